//! Texels of image files.

use std::io::Cursor;
use std::path::Path;

use super::text::file_error;
use super::{GltfFile, SceneError, TextureDescription, TextureSource};
use crate::image::{
    Image, Size, decoded, file_of, holds, is_cut_jpeg, is_worth, pixels_a_byte, promised_size,
    srgb_decode, translucent_pixels, unheeded,
};
use crate::other_kind::{other_kind, with_other_kind};

/// Texels of a file, the top row first.
#[derive(Default)]
pub(super) struct Decoded {
    pub width: usize,
    pub height: usize,
    pub texels: Texels,
    /// What of the file was replaced or is not followed.
    pub notes: Vec<String>,
    /// Texels that are not opaque, where their alpha is left out.
    pub translucent: usize,
}

/// Texels as compactly as the file allows.
#[derive(Clone, Debug)]
pub(super) enum Texels {
    /// 8-bit sRGB, decoded through a table.
    Srgb8(Vec<[u8; 3]>),
    /// 8-bit linear.
    Linear8(Vec<[u8; 3]>),
    Float(Vec<[f32; 3]>),
}

impl Default for Texels {
    fn default() -> Self {
        Self::Float(Vec::new())
    }
}

/// Decodes the bytes of an 8- or 16-bit image as textures are; messages name `path`.
pub(super) fn try_texture(bytes: &[u8], path: &Path) -> Result<(), SceneError> {
    let description = TextureDescription::file(path.to_owned());
    decode_texels(bytes, path, &description).map(|_| ())
}

/// Reads an image file.
pub(super) fn load_texels(
    path: &Path,
    description: &TextureDescription,
) -> Result<Decoded, SceneError> {
    if is_linear(path) {
        return load_linear(path);
    }
    let bytes = crate::files::read(path).map_err(|e| file_error(path, e.to_string()))?;
    decode_texels(&bytes, path, description)
}

/// Decodes an image file; messages name `path`.
fn decode_texels(
    bytes: &[u8],
    path: &Path,
    description: &TextureDescription,
) -> Result<Decoded, SceneError> {
    let srgb = description.srgb;
    let fail = |e: &dyn std::fmt::Display| file_error(path, e.to_string());
    // Nothing in a TGA file says what it is.
    let tga = || image::ImageFormat::from_path(path).ok();
    let tga = || tga().filter(|format| *format == image::ImageFormat::Tga);
    let format = image::guess_format(bytes).ok().or_else(tga);
    let format = format.filter(|_| other_kind(bytes).is_none());
    let format = format.ok_or_else(|| {
        let message = "neither PNG, JPEG, BMP nor TGA (told by the first bytes, TGA by the name)";
        file_error(path, with_other_kind(message.into(), bytes))
    })?;
    if format == image::ImageFormat::Jpeg && is_cut_jpeg(bytes) {
        return Err(fail(&"the file is cut short"));
    }
    let reader = || image::ImageReader::with_format(Cursor::new(bytes), format);
    let size = reader().into_dimensions().map_err(|e| fail(&e))?;
    let size = Size::new(size.0 as usize, size.1 as usize);
    // Three bytes as they are decoded, and four of texels.
    let memory_a_pixel = 7;
    holds(size, bytes.len(), pixels_a_byte(format))
        .and_then(|()| is_worth(size, bytes.len(), memory_a_pixel))
        .map_err(|why| fail(&why))?;
    let image = decoded(|| reader().decode().map_err(|e| e.to_string()));
    let image = image.map_err(|why| fail(&why))?;
    let place = |note: String| format!("{}: {note}", path.display());
    let notes = unheeded(bytes).into_iter().map(place).collect();
    let (width, height) = (image.width() as usize, image.height() as usize);
    if width == 0 || height == 0 {
        return Err(fail(&"the image is empty"));
    }
    if description.alpha.is_some() {
        let alphas = image.to_rgba8().pixels().map(|p| [p.0[3]; 3]).collect();
        return Ok(Decoded {
            width,
            height,
            texels: Texels::Linear8(alphas),
            notes,
            translucent: 0,
        });
    }
    let translucent = translucent_pixels(&image);
    use image::ColorType::{L8, La8, Rgb8, Rgba8};
    let texels = if matches!(image.color(), L8 | La8 | Rgb8 | Rgba8) {
        let pixels = image.to_rgb8().pixels().map(|p| p.0).collect();
        if srgb {
            Texels::Srgb8(pixels)
        } else {
            Texels::Linear8(pixels)
        }
    } else {
        let decode = |v: f32| if srgb { srgb_decode(v) } else { v };
        Texels::Float(
            image
                .to_rgb32f()
                .pixels()
                .map(|p| p.0.map(decode))
                .collect(),
        )
    };
    Ok(Decoded {
        width,
        height,
        texels,
        notes,
        translucent,
    })
}

/// EXR and Radiance HDR through the image module, which keeps them linear.
fn load_linear(path: &Path) -> Result<Decoded, SceneError> {
    let picture = crate::image::read_picture(path);
    let picture = picture.map_err(|e| file_error(path, e.without_path()))?;
    let notes = picture.window.iter().chain(&picture.unheeded);
    let notes = notes.map(|note| format!("{}: {note}", path.display()));
    let mut notes: Vec<String> = notes.collect();
    let translucent = picture.translucent;
    let mut image = picture.into_linear();
    if image.pixels.is_empty() {
        return Err(file_error(path, "the image is empty"));
    }
    notes.extend(without_infinities(&mut image, path));
    Ok(Decoded {
        width: image.width,
        height: image.height,
        texels: Texels::Float(image.pixels),
        notes,
        translucent,
    })
}

/// Blackens texels that are not finite; says how many.
fn without_infinities(image: &mut Image, path: &Path) -> Option<String> {
    let odd = |texel: &&mut [f32; 3]| texel.iter().any(|value| !value.is_finite());
    let odd: Vec<_> = image.pixels.iter_mut().filter(odd).collect();
    let count = odd.len();
    odd.into_iter().for_each(|texel| *texel = [0.0; 3]);
    let path = path.display();
    (count > 0).then(|| format!("{path}: {count} texels that are not finite become black"))
}

/// An image inside a glTF file.
pub(super) fn decode_gltf_image(
    file: &GltfFile,
    image: usize,
    description: &TextureDescription,
) -> Result<Decoded, SceneError> {
    decode_texels(&file.image_bytes(image)?, file.path(), description)
}

/// Bytes that a texture would take, from the header of its file; `None` when it cannot be read.
pub(super) fn estimated_bytes(description: &TextureDescription) -> Option<usize> {
    if let TextureSource::Gltf { file, image } = &description.source {
        let bytes = file.image_bytes(*image).ok()?;
        let reader = image::ImageReader::new(Cursor::new(bytes.as_slice()));
        let reader = reader.with_guessed_format().ok()?;
        let (width, height) = reader.into_dimensions().ok()?;
        return Some(width as usize * height as usize * 3);
    }
    let path = description.path()?;
    let [width, height] = promised_size(path)?;
    let bytes = if is_linear(path) { 12 } else { 3 };
    Some(width * height * bytes)
}

/// Whether a file, told by its ending, keeps linear values.
fn is_linear(path: &Path) -> bool {
    let file = file_of(path);
    let ending = file.extension();
    ending.is_some_and(|e| e.eq_ignore_ascii_case("exr") || e.eq_ignore_ascii_case("hdr"))
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::super::Texture;
    use super::*;

    #[test]
    fn tga_files_are_known_by_their_name() {
        let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]));
        let mut bytes = Cursor::new(Vec::new());
        let tga = image::ImageFormat::Tga;
        picture.write_to(&mut bytes, tga).expect("memory");
        let bytes = bytes.into_inner();
        try_texture(&bytes, Path::new("a.TGA")).unwrap();
        let error = try_texture(&bytes, Path::new("a.png"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("TGA by the name"), "{error}");
        let mut large = bytes.clone();
        large[12..16].fill(0x7f);
        let error = try_texture(&large, Path::new("a.tga"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("too few"), "{error}");
    }

    #[test]
    fn files_are_read_and_damage_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255 * x as u8, 0, 188]))
            .save(&path)
            .unwrap();
        let mut description = TextureDescription::file(path.clone());
        description.nearest = true;
        let t = Texture::load(&description).unwrap();
        assert_eq!((t.width, t.height, t.bytes()), (2, 1, 6));
        assert!((t.lookup(Vec2::new(0.9, 0.5))[2] - 0.502_886_5).abs() < 1e-6);
        description.srgb = false;
        let raw = Texture::load(&description).unwrap();
        assert!((raw.lookup(Vec2::new(0.9, 0.5))[2] - 188.0 / 255.0).abs() < 1e-6);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let error = Texture::load(&description).unwrap_err().to_string();
        assert!(error.contains("a.png"), "{error}");
    }

    #[test]
    fn memory_is_foreseen_by_the_head_of_a_file_and_of_a_layer() {
        let folder = tempfile::tempdir().unwrap();
        let foreseen = |path: std::path::PathBuf| estimated_bytes(&TextureDescription::file(path));
        let exr = folder.path().join("a.exr");
        let layer = crate::image::Layer::color("left", Image::new(4, 2));
        crate::image::write_exr(&exr, &[layer], &Default::default()).unwrap();
        let named = format!("{}#left", exr.display());
        assert_eq!(foreseen(named.into()), Some(4 * 2 * 12));
        assert_eq!(foreseen(exr), Some(4 * 2 * 12));
        let hdr = folder.path().join("a.hdr");
        std::fs::write(&hdr, "#?RGBE\r\n\r\n-Y 3 +X 5\r\nxyxyxyxyxyxy").unwrap();
        assert_eq!(foreseen(hdr), Some(5 * 3 * 12));
        let png = folder.path().join("a.png");
        image::RgbImage::new(7, 1).save(&png).unwrap();
        assert_eq!(foreseen(png), Some(7 * 3));
        assert_eq!(foreseen(folder.path().join("none.png")), None);
    }

    #[test]
    fn texels_that_are_not_finite_become_black() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut image = Image::new(2, 1);
        image.pixels = vec![[f32::INFINITY, 1.0, 1.0], [0.5, 2.0, 0.5]];
        let layers = [crate::image::Layer::color("", image)];
        crate::image::write_exr(&path, &layers, &Default::default()).unwrap();
        let texture = Texture::load(&TextureDescription::file(path)).unwrap();
        assert_eq!(texture.lookup(Vec2::new(0.25, 0.5)), [0.0; 3]);
        assert!(texture.notes()[0].contains("1 texels that are not finite"));
        assert_eq!(texture.out_of_range(), 1);
    }
}
