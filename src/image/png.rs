//! Images as PNG files, after exposure or as they are coded.

use super::{Image, ImageError, Size, clamp_unit, to_display, write_atomically};
use ::image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::path::Path;

/// Writes a linear image as 8-bit sRGB PNG after scaling by 2^`exposure` and clamping; NaN becomes
/// black.
pub fn write_png(path: &Path, linear: &Image, exposure: f32) -> Result<(), ImageError> {
    write_png_coded(path, &to_display(linear, exposure))
}

/// What [`write_png`] writes of an image: three bytes a pixel, row-major.
pub fn display_bytes(linear: &Image, exposure: f32) -> Vec<u8> {
    bytes_of(&to_display(linear, exposure))
}

fn bytes_of(coded: &Image) -> Vec<u8> {
    let quantise = |value: f32| (clamp_unit(value) * 255.0 + 0.5) as u8;
    let pixels = coded.pixels.iter();
    pixels.flat_map(|pixel| pixel.map(quantise)).collect()
}

/// Values in `[0, 1]` that are sRGB-coded already as the bytes of an 8-bit PNG; NaN becomes 0.
///
/// # Errors
/// A sentence, where the image is empty or too large.
pub fn png_bytes(coded: &Image) -> Result<Vec<u8>, String> {
    let side = |n: usize| u32::try_from(n).map_err(|error| error.to_string());
    let (width, height) = (side(coded.width)?, side(coded.height)?);
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&bytes_of(coded), width, height, ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Writes values in `[0, 1]` that are sRGB-coded already as 8-bit PNG; NaN becomes 0.
pub fn write_png_coded(path: &Path, coded: &Image) -> Result<(), ImageError> {
    write_png_bytes(path, coded.size(), &bytes_of(coded))
}

/// Writes three bytes a pixel, row-major, as 8-bit PNG.
pub fn write_png_bytes(path: &Path, size: Size, bytes: &[u8]) -> Result<(), ImageError> {
    let Size { width, height } = size;
    if bytes.len() != width * height * 3 || bytes.is_empty() {
        let reason = format!("{width}x{height} with {} bytes", bytes.len());
        return Err(ImageError::encode(path, reason));
    }
    let dimension = |n: usize| u32::try_from(n).map_err(|error| ImageError::encode(path, error));
    let (width, height) = (dimension(width)?, dimension(height)?);
    write_atomically(path, |writer| {
        PngEncoder::new(writer)
            .write_image(bytes, width, height, ExtendedColorType::Rgb8)
            .map_err(|error| ImageError::encode(path, error))
    })
}
