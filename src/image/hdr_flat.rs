//! Radiance pictures whose rows are too narrow, or too wide, to be run-length coded.
//!
//! Writers leave rows of fewer than 8 or more than 32767 pixels as they are, and no row of another width begins with
//! bytes like (2, 2, 0, 7); the decoder goes by these bytes alone, and would take such a pixel for a coded row.

/// Whether rows of this width are never coded.
pub(super) fn is_flat(width: usize) -> bool {
    !(8..=32_767).contains(&width)
}

/// Longest run of bytes that a coded row has as they are.
const MOST_LITERALS: usize = 128;

/// How many pixels a byte may stand for, lest a small file asks for much memory.
const MOST_A_BYTE: usize = 16;

/// The pixels behind a header in coded rows, for the decoder; as they are where they are too few.
pub(super) fn coded_rows(pixels: &[u8], width: usize, height: usize) -> Vec<u8> {
    let count = width.saturating_mul(height);
    let is_bounded = count <= pixels.len().saturating_mul(MOST_A_BYTE);
    let texels = is_bounded.then(|| repeated(pixels, count)).flatten();
    let Some(texels) = texels else {
        return pixels.to_vec();
    };
    let mut coded = Vec::with_capacity(pixels.len() * 2);
    for row in texels.chunks(width.max(1)) {
        coded.extend([2, 2, 0, 0]);
        for channel in 0..4 {
            for part in row.chunks(MOST_LITERALS) {
                coded.push(part.len() as u8);
                coded.extend(part.iter().map(|texel| texel[channel]));
            }
        }
    }
    coded
}

/// The first texels of a picture in which (1, 1, 1, n) repeats the one before n times, and more where several stand
/// together, as the oldest files have it; `None` where there are fewer.
fn repeated(pixels: &[u8], count: usize) -> Option<Vec<[u8; 4]>> {
    let mut texels: Vec<[u8; 4]> = Vec::new();
    let mut shift = 0;
    for texel in pixels.chunks_exact(4) {
        match (texel, texels.last().copied()) {
            ([1, 1, 1, n], Some(last)) => {
                let times = (usize::from(*n)).checked_shl(shift).unwrap_or(0);
                let lacking = count.saturating_sub(texels.len());
                texels.extend(std::iter::repeat_n(last, times.min(lacking)));
                shift += 8;
            }
            ([r, g, b, e], _) => {
                texels.push([*r, *g, *b, *e]);
                shift = 0;
            }
            _ => return None,
        }
        if texels.len() >= count {
            return Some(texels);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::image::decode_bytes;

    fn file(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
        let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
        [head.as_bytes(), pixels].concat()
    }

    #[test]
    fn narrow_and_wide_rows_are_read_as_they_are() {
        let first = [2, 2, 0, 7];
        let other = [128, 64, 0, 129];
        for (width, height) in [(4, 2), (1, 3), (7, 1), (40_000, 1)] {
            let mut pixels = vec![first];
            pixels.resize(width * height, other);
            let bytes = file(width, height, &pixels.concat());
            let picture = decode_bytes(Path::new("a.hdr"), None, &bytes).expect("reads");
            assert_eq!([picture.image.width, picture.image.height], [width, height]);
            let read = &picture.image.pixels;
            assert!(read[0].iter().all(|value| *value < 1e-30), "{:?}", read[0]);
            assert!(read[1..].iter().all(|p| *p == [1.0, 0.5, 0.0]), "{width}");
        }
    }

    #[test]
    fn few_bytes_do_not_ask_for_many_pixels() {
        let pixels = [9, 9, 9, 9, 1, 1, 1, 255, 1, 1, 1, 255, 1, 1, 1, 255];
        assert_eq!(coded_rows(&pixels, 1 << 30, 1), pixels);
    }

    #[test]
    fn repeats_of_old_files_are_followed() {
        let (a, b) = ([9, 9, 9, 9], [2, 2, 0, 7]);
        let texels = |pixels: &[[u8; 4]], count| repeated(&pixels.concat(), count);
        let repeat = |n| [1, 1, 1, n];
        assert_eq!(texels(&[b, repeat(2), a], 4), Some(vec![b, b, b, a]));
        let long = texels(&[a, repeat(1), repeat(1)], 258).expect("enough");
        assert_eq!((long.len(), long[257]), (258, a));
        assert_eq!(texels(&[a, repeat(1)], 3), None);
    }
}
