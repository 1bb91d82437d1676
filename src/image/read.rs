use super::error::MAX_PIXELS;
use super::{Image, ImageError, exr_read, srgb_decode};
use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// What the stored values of a file mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Scene-referred, proportional to light (EXR, Radiance HDR).
    Linear,
    /// Display-referred, sRGB-coded in `[0, 1]` (PNG, JPEG).
    Srgb,
}

/// Reads an EXR, Radiance HDR, PNG or JPEG file as linear RGB.
///
/// The format is told by the first bytes. 8- and 16-bit files are decoded from sRGB; gray is spread
/// over the channels; alpha, colour profiles and metadata are ignored. Non-finite values are kept:
/// see [`super::sanitise`].
pub fn read(path: &Path) -> Result<Image, ImageError> {
    let (mut image, encoding) = read_coded(path)?;
    if encoding == Encoding::Srgb {
        for pixel in &mut image.pixels {
            *pixel = pixel.map(srgb_decode);
        }
    }
    Ok(image)
}

/// Reads like [`read`], but leaves the values as they are stored (8 and 16 bits scaled to `[0, 1]`) and
/// says what they mean.
pub fn read_coded(path: &Path) -> Result<(Image, Encoding), ImageError> {
    let bytes = std::fs::read(path).map_err(|source| ImageError::io(path, source))?;
    match bytes.as_slice() {
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            Ok((exr_read::decode_picture(path, &bytes)?, Encoding::Linear))
        }
        [b'#', b'?', ..] => Ok((decode_hdr(path, &bytes)?, Encoding::Linear)),
        [0x89, b'P', b'N', b'G', ..] => {
            let picture = decode(path, &bytes, ImageFormat::Png)?;
            Ok((coded_pixels(&picture), Encoding::Srgb))
        }
        [0xff, 0xd8, ..] => {
            let picture = decode(path, &bytes, ImageFormat::Jpeg)?;
            Ok((coded_pixels(&picture), Encoding::Srgb))
        }
        _ => Err(ImageError::UnknownFormat {
            path: path.to_owned(),
        }),
    }
}

fn decode(path: &Path, bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, ImageError> {
    let name = match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        _ => "Radiance HDR",
    };
    let damaged = |error| ImageError::decode(path, name, error);
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(damaged)?;
    let (width, height) = (width as usize, height as usize);
    if width
        .checked_mul(height)
        .is_none_or(|area| area > MAX_PIXELS)
    {
        return Err(ImageError::TooLarge {
            path: path.to_owned(),
            width,
            height,
        });
    }
    let mut reader = reader();
    reader.limits(Limits::no_limits());
    reader.decode().map_err(damaged)
}

/// Radiance files keep linear values in a shared exponent; the decoder yields f32.
fn decode_hdr(path: &Path, bytes: &[u8]) -> Result<Image, ImageError> {
    let picture = decode(path, bytes, ImageFormat::Hdr)?.into_rgb32f();
    Ok(Image {
        width: picture.width() as usize,
        height: picture.height() as usize,
        pixels: picture.pixels().map(|pixel| pixel.0).collect(),
    })
}

fn coded_pixels(picture: &DynamicImage) -> Image {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let pixels = match picture.color().bytes_per_pixel() / picture.color().channel_count() {
        1 => picture
            .to_rgb8()
            .pixels()
            .map(|pixel| pixel.0.map(|value| f32::from(value) / 255.0))
            .collect(),
        _ => picture
            .to_rgb16()
            .pixels()
            .map(|pixel| pixel.0.map(|value| f32::from(value) / 65535.0))
            .collect(),
    };
    Image {
        width,
        height,
        pixels,
    }
}
