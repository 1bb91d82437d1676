//! Textures in memory and what they are looked up for.

use std::sync::OnceLock;

use glam::Vec2;

use super::texture_file::{Decoded, Texels, decode_gltf_image, load_texels};
use super::{Alpha, SceneError, TextureDescription, TextureSource};
use crate::image::srgb_decode;

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
    uv_shear: f32,
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
            uv_shear: 0.0,
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
            TextureSource::Gltf { file, image } => decode_gltf_image(file, *image, description)?,
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
            uv_shear: description.uv_shear,
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
        let sheared = uv * self.uv_scale + Vec2::new(uv.y * self.uv_shear, 0.0);
        let uv = self.uv_turn.rotate(sheared) + self.uv_offset;
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

    /// How many texels, times the factor, lie outside of [0, 1].
    pub(super) fn out_of_range(&self) -> usize {
        let Texels::Float(texels) = &self.texels else {
            return 0;
        };
        let within = |texel: [f32; 3]| texel.iter().all(|value| (0.0..=1.0).contains(value));
        let colours = texels.iter().map(|&texel| self.coloured(texel));
        colours.filter(|&colour| !within(colour)).count()
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
    fn what_is_added_is_added_after_the_factor() {
        let mut texture = Texture::constant([0.5, 1.0, 0.0]);
        texture.factor = [0.5; 3];
        texture.base = Some([0.2, 0.8, 0.0]);
        assert_eq!(texture.lookup(Vec2::ZERO), [0.45, 1.0, 0.0]);
        assert_eq!(texture.mean(), [0.45, 1.0, 0.0]);
    }

    #[test]
    fn coordinates_are_scaled_sheared_turned_and_shifted() {
        let mut texture = pattern(true, Wrap::Repeat);
        texture.uv_scale = Vec2::new(0.5, 1.0);
        texture.uv_shear = 0.5;
        texture.uv_turn = Vec2::from_angle(std::f32::consts::FRAC_PI_2);
        texture.uv_offset = Vec2::new(1.0, 0.0);
        // (0.2, 0.8) → (0.1, 0.8) → (0.5, 0.8) → (−0.8, 0.5) → (0.2, 0.5), just above and below the middle.
        assert_eq!(texture.lookup(Vec2::new(0.22, 0.8))[0], 1.0);
        assert_eq!(texture.lookup(Vec2::new(0.18, 0.8))[0], 3.0);
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
}
