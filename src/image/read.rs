//! Images of any format that is read, linear or as coded.

use super::error::MAX_PIXELS;
use super::guard::{decoded, holds, is_cut_jpeg, is_worth, pixels_a_byte};
use super::hdr_header::HdrHeader;
use super::primaries::hdr_to_rec709;
use super::{Image, ImageError, Size, exr_read, srgb_decode, unheeded};
use crate::other_kind::other_kind;
use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};
use glam::DVec3;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

/// What the stored values of a file mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Scene-referred, proportional to light (EXR, Radiance HDR).
    Linear,
    /// Display-referred, sRGB-coded in `[0, 1]` (PNG, JPEG).
    Srgb,
}

/// What a file shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The values as they are stored, 8 and 16 bits scaled to `[0, 1]`.
    pub image: Image,
    /// What its values mean.
    pub encoding: Encoding,
    /// Pixels that are not opaque; their alpha is left out.
    pub translucent: usize,
    /// What was made of a data window that is not the display window (EXR), in words.
    pub window: Option<String>,
    /// What the file says of its colours or pixels that is not followed, in words.
    pub unheeded: Vec<String>,
    /// Whether the file says that it holds the six sides of a cube around a place.
    pub cube: bool,
}

impl Picture {
    /// Its image as linear RGB.
    pub fn into_linear(self) -> Image {
        let mut image = self.image;
        if self.encoding == Encoding::Srgb {
            for pixel in &mut image.pixels {
                *pixel = pixel.map(srgb_decode);
            }
        }
        image
    }
}

/// Reads an EXR, Radiance HDR, PNG or JPEG file as linear RGB.
///
/// The format is told by the first bytes. 8- and 16-bit files are decoded from sRGB; gray is spread
/// over the channels; alpha, colour profiles and metadata are not followed ([`Picture::unheeded`] tells of them), but for the chromaticities of EXR files and the exposure and
/// primaries of Radiance files. `FILE#layer` names a layer of an EXR file. Non-finite values are kept: see [`super::sanitise`].
pub fn read(path: &Path) -> Result<Image, ImageError> {
    Ok(read_picture(path)?.into_linear())
}

/// Reads like [`read`], but leaves the values as they are stored (8 and 16 bits scaled to `[0, 1]`) and
/// says what they mean.
pub fn read_coded(path: &Path) -> Result<(Image, Encoding), ImageError> {
    let picture = read_picture(path)?;
    Ok((picture.image, picture.encoding))
}

/// Reads like [`read_coded`] and counts what alpha would have changed.
pub fn read_picture(path: &Path) -> Result<Picture, ImageError> {
    let (path, layer) = file_and_layer(path);
    let bytes = crate::files::read(&path).map_err(|source| ImageError::io(&path, source))?;
    decode_bytes(&path, layer.as_deref(), &bytes)
}

/// [`read_picture`] of the bytes of a file; messages name `path`.
pub(crate) fn decode_bytes(
    path: &Path,
    layer: Option<&str>,
    bytes: &[u8],
) -> Result<Picture, ImageError> {
    let picture = match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            let picture = exr_read::decode_picture(path, layer, bytes)?;
            return Ok(Picture {
                image: picture.image,
                encoding: Encoding::Linear,
                translucent: picture.translucent,
                window: picture.window,
                unheeded: picture.unheeded,
                cube: picture.cube,
            });
        }
        [b'#', b'?', ..] => {
            let (image, unheeded) = decode_hdr(path, bytes)?;
            return Ok(Picture {
                image,
                encoding: Encoding::Linear,
                translucent: 0,
                window: None,
                unheeded,
                cube: false,
            });
        }
        [0x89, b'P', b'N', b'G', ..] => decode(path, bytes, ImageFormat::Png)?,
        [0xff, 0xd8, ..] => decode(path, bytes, ImageFormat::Jpeg)?,
        _ => {
            let path = path.to_owned();
            let kind = other_kind(bytes);
            return Err(ImageError::UnknownFormat { path, kind });
        }
    };
    Ok(Picture {
        image: coded_pixels(&picture),
        encoding: Encoding::Srgb,
        translucent: translucent_pixels(&picture),
        window: None,
        unheeded: unheeded(bytes),
        cube: false,
    })
}

/// The file that a path names, where a layer may follow behind a `#`.
pub fn file_of(path: &Path) -> PathBuf {
    file_and_layer(path).0
}

/// The file that is named, and the layer behind a `#` if there is no file whose name has it.
fn file_and_layer(path: &Path) -> (PathBuf, Option<String>) {
    let parts = path.to_str().and_then(|text| text.rsplit_once('#'));
    match parts {
        Some((file, layer)) if !path.exists() => (file.into(), Some(layer.to_owned())),
        _ => (path.to_owned(), None),
    }
}

/// Width and height of the picture that the head of a file promises, in pixels; `None` where it cannot be read.
pub(crate) fn promised_size(path: &Path) -> Option<[usize; 2]> {
    let path = file_of(path);
    let mut head = Vec::new();
    crate::files::check_ends(&path).ok()?;
    let file = std::fs::File::open(&path).ok()?;
    file.take(1 << 20).read_to_end(&mut head).ok()?;
    match head[..] {
        [0x76, 0x2f, 0x31, 0x01, ..] => exr_read::promised_size(&path),
        [b'#', b'?', ..] => HdrHeader::read(&head).ok().map(|header| header.size()),
        _ => {
            let (width, height) = ::image::image_dimensions(&path).ok()?;
            Some([width as usize, height as usize])
        }
    }
}

/// How many pixels are not opaque.
pub(crate) fn translucent_pixels(picture: &DynamicImage) -> usize {
    match picture.color().has_alpha() {
        true => picture
            .to_rgba16()
            .pixels()
            .filter(|p| p.0[3] < u16::MAX)
            .count(),
        false => 0,
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
    // Three floats, and what is decoded.
    let memory_a_pixel = 16;
    let size = Size { width, height };
    holds(size, bytes.len(), pixels_a_byte(format))
        .and_then(|()| is_worth(size, bytes.len(), memory_a_pixel))
        .map_err(|why| ImageError::decode(path, name, why))?;
    if format == ImageFormat::Jpeg && is_cut_jpeg(bytes) {
        return Err(ImageError::decode(path, name, "the file is cut short"));
    }
    let mut reader = reader();
    reader.limits(Limits::no_limits());
    decoded(|| reader.decode().map_err(|error| error.to_string()))
        .map_err(|why| ImageError::decode(path, name, why))
}

/// Radiance files keep linear values in a shared exponent; the decoder yields f32. With what is not followed.
fn decode_hdr(path: &Path, bytes: &[u8]) -> Result<(Image, Vec<String>), ImageError> {
    let header =
        HdrHeader::read(bytes).map_err(|why| ImageError::decode(path, "Radiance HDR", why))?;
    let picture = decode(path, &header.plain(bytes), ImageFormat::Hdr)?.into_rgb32f();
    let pixels = picture.pixels();
    let radiance = |value: &[f32; 3]| std::array::from_fn(|c| value[c] / header.exposure[c]);
    let mut image = Image {
        width: picture.width() as usize,
        height: picture.height() as usize,
        pixels: pixels.map(|pixel| radiance(&pixel.0)).collect(),
    };
    let matrix = match &header.primaries {
        Some(primaries) => {
            hdr_to_rec709(primaries).map_err(|why| ImageError::decode(path, "Radiance HDR", why))?
        }
        None => None,
    };
    if let Some(matrix) = matrix {
        image = image.map(|rgb| {
            let rgb = DVec3::from(rgb.map(f64::from));
            (matrix * rgb).as_vec3().to_array()
        });
    }
    if header.bottom_up {
        let rows = image.pixels.chunks(image.width.max(1)).rev();
        image.pixels = rows.flatten().copied().collect();
    }
    Ok((image, header.unheeded))
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
