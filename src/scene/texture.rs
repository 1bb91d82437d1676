//! Bitmap textures.

use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;
use std::sync::OnceLock;

use glam::Vec2;

use super::text::file_error;
use super::{Alpha, SceneError, TextureDescription, TextureSource};
use crate::image::{
    decoded, holds, is_cut_jpeg, pixels_a_byte, srgb_decode, translucent_pixels, unheeded,
};

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// Its nearest edge.
    Clamp,
    /// The texture again, every other copy mirrored.
    Mirror,
}

/// A texture in memory; [`Texture::lookup`] gives linear values.
///
/// Texels lie row-major, the top row (v = 1) first; texel centres are at half-integers. An alpha
/// channel of the file is not kept.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Texels of a row.
    pub width: usize,
    /// Texels of a column.
    pub height: usize,
    texels: Texels,
    nearest: bool,
    wrap: Wrap,
    uv_scale: Vec2,
    uv_turn: Vec2,
    uv_offset: Vec2,
    factor: [f32; 3],
    base: Option<[f32; 3]>,
    alpha: Option<Alpha>,
    /// What of its file was replaced or is not followed.
    notes: Vec<String>,
    /// Texels of its file that are not opaque, where their alpha is left out.
    translucent: usize,
}

/// Texels of a file, the top row first.
#[derive(Default)]
struct Decoded {
    width: usize,
    height: usize,
    texels: Texels,
    notes: Vec<String>,
    translucent: usize,
}

/// Texels as compactly as the file allows.
#[derive(Clone, Debug)]
enum Texels {
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

impl Default for Texture {
    /// A grey of 0.5: what stands for a texture that is absent or not needed.
    fn default() -> Self {
        Self::constant([0.5; 3])
    }
}

impl Texture {
    /// A texture of one linear colour.
    pub fn constant(colour: [f32; 3]) -> Self {
        Self {
            width: 1,
            height: 1,
            texels: Texels::Float(vec![colour]),
            nearest: true,
            wrap: Wrap::Repeat,
            uv_scale: Vec2::ONE,
            uv_turn: Vec2::X,
            uv_offset: Vec2::ZERO,
            factor: [1.0; 3],
            base: None,
            alpha: None,
            notes: Vec::new(),
            translucent: 0,
        }
    }

    /// What of its file was left out or replaced.
    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// How many texels of its file are not opaque, where their alpha is left out.
    pub(super) fn translucent(&self) -> usize {
        self.translucent
    }

    /// Reads what is described: PNG, JPEG, BMP, TGA, Radiance HDR, or the RGB channels of an EXR.
    /// Fails on files that are absent or damaged.
    pub fn load(description: &TextureDescription) -> Result<Self, SceneError> {
        let decoded = match &description.source {
            TextureSource::File(path) => load_texels(path, description)?,
            TextureSource::Gltf { file, image } => {
                let bytes = Cursor::new(file.image_bytes(*image)?);
                decode_texels(bytes, file.path(), description)?
            }
            TextureSource::Checkerboard([a, b]) => Decoded {
                width: 2,
                height: 2,
                texels: Texels::Float(vec![*a, *b, *b, *a]),
                ..Decoded::default()
            },
        };
        Ok(Self {
            width: decoded.width,
            height: decoded.height,
            texels: decoded.texels,
            notes: decoded.notes,
            translucent: decoded.translucent,
            nearest: description.nearest,
            wrap: description.wrap,
            uv_scale: Vec2::from(description.uv_scale),
            uv_turn: Vec2::from_angle(description.uv_turn_rad),
            uv_offset: Vec2::from(description.uv_offset),
            factor: description.factor,
            base: description.base,
            alpha: description.alpha,
        })
    }

    /// Linear RGB at texture coordinates, times the factor and with what is added, or the alpha three times; (0, 0) is the bottom
    /// left corner of the image. Non-finite coordinates give some texel.
    pub fn lookup(&self, uv: Vec2) -> [f32; 3] {
        let texel = self.filtered(uv);
        match &self.alpha {
            Some(alpha) => texel.map(|value| alpha.of(value)),
            None => self.coloured(texel),
        }
    }

    /// A texel times the factor, and what is added to it.
    fn coloured(&self, texel: [f32; 3]) -> [f32; 3] {
        let scaled = std::array::from_fn(|c| texel[c] * self.factor[c]);
        match self.base {
            Some(base) => std::array::from_fn(|c| (scaled[c] + base[c]).clamp(0.0, 1.0)),
            None => scaled,
        }
    }

    fn filtered(&self, uv: Vec2) -> [f32; 3] {
        let uv = self.uv_turn.rotate(uv * self.uv_scale) + self.uv_offset;
        let x = uv.x * self.width as f32;
        let y = (1.0 - uv.y) * self.height as f32;
        if self.nearest {
            return self.texel(x.floor() as i64, y.floor() as i64);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (column, row) = (x0 as i64, y0 as i64);
        let texel = |dx, dy| self.texel(column.saturating_add(dx), row.saturating_add(dy));
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let texels = corners.map(|(dx, dy)| texel(dx, dy));
        std::array::from_fn(|c| {
            let top = texels[0][c] + (texels[1][c] - texels[0][c]) * fx;
            let bottom = texels[2][c] + (texels[3][c] - texels[2][c]) * fx;
            top + (bottom - top) * fy
        })
    }

    /// Mean of all texels, times the factor, with what is added.
    pub fn mean(&self) -> [f32; 3] {
        let mut sum = [0.0_f64; 3];
        for row in 0..self.height as i64 {
            for column in 0..self.width as i64 {
                let texel = self.texel(column, row);
                (0..3).for_each(|c| sum[c] += f64::from(texel[c]));
            }
        }
        let count = (self.width * self.height) as f64;
        self.coloured(sum.map(|channel| (channel / count) as f32))
    }

    /// Bytes of the texels.
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Srgb8(t) | Texels::Linear8(t) => t.len() * 3,
            Texels::Float(t) => t.len() * 12,
        }
    }

    fn texel(&self, column: i64, row: i64) -> [f32; 3] {
        let column = wrapped(column, self.width, self.wrap);
        let row = wrapped(row, self.height, self.wrap);
        let index = row * self.width + column;
        match &self.texels {
            Texels::Srgb8(t) => t[index].map(|v| srgb_table()[v as usize]),
            Texels::Linear8(t) => t[index].map(|v| f32::from(v) / 255.0),
            Texels::Float(t) => t[index],
        }
    }
}

fn wrapped(index: i64, size: usize, wrap: Wrap) -> usize {
    let size = size as i64;
    let index = match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Clamp => index.clamp(0, size - 1),
        Wrap::Mirror => {
            let index = index.rem_euclid(2 * size);
            if index < size {
                index
            } else {
                2 * size - 1 - index
            }
        }
    };
    index as usize
}

fn srgb_table() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|i| srgb_decode(i as f32 / 255.0)))
}

/// Decodes the bytes of an 8- or 16-bit image as textures are; messages name `path`.
pub(super) fn try_texture(bytes: &[u8], path: &Path) -> Result<(), SceneError> {
    let description = TextureDescription::file(path.to_owned());
    decode_texels(Cursor::new(bytes), path, &description).map(|_| ())
}

fn load_texels(path: &Path, description: &TextureDescription) -> Result<Decoded, SceneError> {
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("exr") || e.eq_ignore_ascii_case("hdr"))
    {
        return load_linear(path);
    }
    let file = std::fs::File::open(path).map_err(|e| file_error(path, e.to_string()))?;
    decode_texels(BufReader::new(file), path, description)
}

/// Decodes an image file; messages name `path`.
fn decode_texels(
    mut bytes: impl BufRead + Seek,
    path: &Path,
    description: &TextureDescription,
) -> Result<Decoded, SceneError> {
    let srgb = description.srgb;
    let fail = |e: &dyn std::fmt::Display| file_error(path, e.to_string());
    let mut whole = Vec::new();
    bytes.read_to_end(&mut whole).map_err(|e| fail(&e))?;
    // Nothing in a TGA file says what it is.
    let tga = || image::ImageFormat::from_path(path).ok();
    let tga = || tga().filter(|format| *format == image::ImageFormat::Tga);
    let format = image::guess_format(&whole).ok().or_else(tga);
    let format = format.ok_or_else(|| {
        fail(&"neither PNG, JPEG, BMP nor TGA (told by the first bytes, TGA by the name)")
    })?;
    if format == image::ImageFormat::Jpeg && is_cut_jpeg(&whole) {
        return Err(fail(&"the file is cut short"));
    }
    let reader = || image::ImageReader::with_format(Cursor::new(&whole), format);
    let size = reader().into_dimensions().map_err(|e| fail(&e))?;
    let size = (size.0 as usize, size.1 as usize);
    holds(size, whole.len(), pixels_a_byte(format)).map_err(|why| fail(&why))?;
    let image = decoded(|| reader().decode().map_err(|e| e.to_string()));
    let image = image.map_err(|why| fail(&why))?;
    let place = |note: String| format!("{}: {note}", path.display());
    let notes = unheeded(&whole).into_iter().map(place).collect();
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
    let picture = picture.map_err(|e| file_error(path, e.to_string()))?;
    let notes = picture.window.iter().chain(&picture.unheeded);
    let notes = notes.map(|note| format!("{}: {note}", path.display()));
    let notes = notes.collect();
    let translucent = picture.translucent;
    let image = picture.into_linear();
    if image.pixels.is_empty() {
        return Err(file_error(path, "the image is empty"));
    }
    Ok(Decoded {
        width: image.width,
        height: image.height,
        texels: Texels::Float(image.pixels),
        notes,
        translucent,
    })
}

/// Bytes that a texture would take, from the header of its file; `None` when it cannot be read.
pub(super) fn estimated_bytes(description: &TextureDescription) -> Option<usize> {
    if let TextureSource::Gltf { file, image } = &description.source {
        let bytes = Cursor::new(file.image_bytes(*image).ok()?);
        let reader = image::ImageReader::new(bytes).with_guessed_format().ok()?;
        let (width, height) = reader.into_dimensions().ok()?;
        return Some(width as usize * height as usize * 3);
    }
    let path = description.path()?;
    let (width, height) = image::image_dimensions(path).ok()?;
    let hdr = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("hdr"));
    Some(width as usize * height as usize * if hdr { 12 } else { 3 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(nearest: bool, wrap: Wrap) -> Texture {
        Texture {
            width: 2,
            height: 2,
            texels: Texels::Float(vec![[1.0; 3], [2.0; 3], [3.0; 3], [4.0; 3]]),
            nearest,
            wrap,
            ..Texture::default()
        }
    }

    #[test]
    fn v_points_up() {
        let t = pattern(true, Wrap::Repeat);
        assert_eq!(t.lookup(Vec2::new(0.1, 0.1))[0], 3.0);
        assert_eq!(t.lookup(Vec2::new(0.9, 0.1))[0], 4.0);
        assert_eq!(t.lookup(Vec2::new(0.1, 0.9))[0], 1.0);
    }

    #[test]
    fn bilinear_is_exact_at_centres_and_between() {
        let t = pattern(false, Wrap::Clamp);
        assert_eq!(t.lookup(Vec2::new(0.25, 0.75))[0], 1.0);
        assert_eq!(t.lookup(Vec2::new(0.5, 0.5))[0], 2.5);
        assert_eq!(
            t.lookup(Vec2::new(0.0, 1.0))[0],
            1.0,
            "clamped at the corner"
        );
        let r = pattern(false, Wrap::Repeat);
        assert_eq!(
            r.lookup(Vec2::new(0.0, 0.75))[0],
            1.5,
            "wraps to the other side"
        );
    }

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
    fn what_is_added_is_added_after_the_factor() {
        let mut texture = Texture::constant([0.5, 1.0, 0.0]);
        texture.factor = [0.5; 3];
        texture.base = Some([0.2, 0.8, 0.0]);
        assert_eq!(texture.lookup(Vec2::ZERO), [0.45, 1.0, 0.0]);
        assert_eq!(texture.mean(), [0.45, 1.0, 0.0]);
    }

    #[test]
    fn wrapping() {
        assert_eq!(
            [-1, 0, 3, 4].map(|i| wrapped(i, 4, Wrap::Repeat)),
            [3, 0, 3, 0]
        );
        assert_eq!(
            [-9, 0, 3, 4].map(|i| wrapped(i, 4, Wrap::Clamp)),
            [0, 0, 3, 3]
        );
        assert_eq!(
            [-1, 3, 4, 7, 8].map(|i| wrapped(i, 4, Wrap::Mirror)),
            [0, 3, 3, 0, 0]
        );
    }

    #[test]
    fn wild_coordinates_do_not_panic() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
                pattern(true, wrap).lookup(Vec2::splat(x));
                pattern(false, wrap).lookup(Vec2::splat(x));
            }
        }
    }

    #[test]
    fn srgb_follows_the_standard() {
        assert_eq!(srgb_table()[0], 0.0);
        assert_eq!(srgb_table()[255], 1.0);
        assert!((srgb_table()[188] - 0.502_886_5).abs() < 1e-6);
    }

    #[test]
    fn a_checkerboard_has_its_first_colour_at_the_top_left() {
        let mut description = TextureDescription::file("x.png".into());
        description.source = TextureSource::Checkerboard([[1.0; 3], [0.0; 3]]);
        description.nearest = true;
        description.uv_scale = [2.0, 2.0];
        let t = Texture::load(&description).unwrap();
        assert_eq!(t.lookup(Vec2::new(0.1, 0.9))[0], 1.0);
        assert_eq!(t.lookup(Vec2::new(0.3, 0.9))[0], 0.0);
        assert_eq!(t.lookup(Vec2::new(0.6, 0.9))[0], 1.0, "scaled twice");
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
}
