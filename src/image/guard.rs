//! Decoders of damaged files: what they may allocate, and what becomes of their defects.

use std::panic::{AssertUnwindSafe, catch_unwind};

use ::image::ImageFormat;
use exr::compression::Compression;

use super::Size;

/// The result of a decoder; where it panics, that the file is damaged.
///
/// # Errors
/// Those of `decode`.
pub fn decoded<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err("the file is damaged: its decoder gave up".into()))
}

/// Whether a JPEG ends before its picture does: nothing marks the end behind its last scan.
pub fn is_cut_jpeg(bytes: &[u8]) -> bool {
    const SCAN: [u8; 2] = [0xff, 0xda];
    const END: [u8; 2] = [0xff, 0xd9];
    let at = |marker: [u8; 2]| bytes.windows(2).rposition(|pair| pair == marker);
    match (at(SCAN), at(END)) {
        (_, None) => true,
        (scan, Some(end)) => scan.is_some_and(|scan| scan > end),
    }
}

/// Pixels that a byte of the best compressed picture of a format may stand for: 1032 bytes of Deflate, eight pixels
/// each; one bit of a progressive JPEG for 64; runs as long as a row of an old Radiance file.
pub fn pixels_a_byte(format: ImageFormat) -> usize {
    match format {
        ImageFormat::Png => 8 * DEFLATED,
        ImageFormat::Jpeg => 1024,
        ImageFormat::Hdr => 4096,
        // A run of 128 in two bytes at least.
        ImageFormat::Tga => 64,
        // Without limit, as a file may end its rows early.
        _ => 20_000,
    }
}

/// Bytes that a byte of Deflate may stand for.
const DEFLATED: usize = 1032;

/// Bytes of samples that a byte of an EXR file may stand for.
pub fn exr_bytes_a_byte(compression: Compression) -> usize {
    match compression {
        Compression::Uncompressed => 1,
        Compression::RLE => 64,
        Compression::B44 | Compression::B44A => 12,
        // Deflated, of blocks of 64 half-floats that are one number each.
        Compression::DWAA(_) | Compression::DWAB(_) => 64 * DEFLATED,
        // Of each four bytes three are deflated (PXR24); runs of 255 in a byte or so (PIZ).
        _ => DEFLATED * 4 / 3,
    }
}

/// Refuses a picture whose header promises more than so few bytes can hold, with so many pixels a byte.
///
/// # Errors
/// A sentence.
pub fn holds(size: Size, bytes: usize, most_a_byte: usize) -> Result<(), String> {
    let Size { width, height } = size;
    let most = bytes.saturating_mul(most_a_byte);
    match width.saturating_mul(height) <= most {
        true => Ok(()),
        false => Err(format!(
            "{bytes} bytes are too few for the {width}x{height} pixels that the header promises: the file is cut short"
        )),
    }
}

/// Memory that the picture of a small file may take, bytes, and what it may take for each byte of a larger one.
const MOST_MEMORY: usize = 1 << 30;
const MEMORY_A_BYTE: usize = 1 << 10;

/// Refuses a picture, `bytes` long, that takes much memory for what little there is in its file.
///
/// # Errors
/// A sentence.
pub fn is_worth(size: Size, bytes: usize, memory_a_pixel: usize) -> Result<(), String> {
    let Size { width, height } = size;
    let most = MOST_MEMORY.max(bytes.saturating_mul(MEMORY_A_BYTE));
    let wanted = width.saturating_mul(height).saturating_mul(memory_a_pixel);
    match wanted <= most {
        true => Ok(()),
        false => Err(format!(
            "its {width}x{height} pixels would take {} MiB of memory, which {bytes} bytes are not worth: make it smaller",
            wanted >> 20
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_files_take_no_gigabyte() {
        assert!(is_worth(Size::new(8192, 8192), 100, 16).is_ok());
        let error = is_worth(Size::new(16384, 16384), 32_647, 16).unwrap_err();
        assert!(error.contains("4096 MiB"), "{error}");
        assert!(is_worth(Size::new(16384, 16384), 4 << 20, 16).is_ok());
    }

    #[test]
    fn panics_of_decoders_are_errors() {
        assert_eq!(decoded(|| Ok(3)), Ok(3));
        let empty: [u8; 0] = [];
        let error = decoded::<u8>(|| Ok(empty[std::hint::black_box(1)])).unwrap_err();
        assert!(error.contains("damaged"), "{error}");
    }

    #[test]
    fn a_jpeg_ends_behind_its_last_scan() {
        let thumbnail = [0xff, 0xd8, 0xff, 0xda, 1, 0xff, 0xd9];
        let whole = [&thumbnail[..], &[0xff, 0xda, 5, 6, 0xff, 0xd9, 0]].concat();
        assert!(!is_cut_jpeg(&whole));
        assert!(is_cut_jpeg(&whole[..whole.len() - 2]));
        assert!(is_cut_jpeg(&[0xff, 0xd8]));
    }

    #[test]
    fn headers_cannot_promise_what_is_not_there() {
        assert!(holds(Size::new(1024, 1024), 55, 20_000).is_ok());
        assert!(holds(Size::new(16384, 16384), 55, 20_000).is_err());
        assert!(holds(Size::new(usize::MAX, 2), usize::MAX, 3).is_ok());
    }
}
