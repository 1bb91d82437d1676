//! Bitmap textures.

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    #[default]
    Repeat,
    Clamp,
    Mirror,
}

/// A texture in memory; `lookup` gives linear values.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    pub width: usize,
    pub height: usize,
    /// Linear RGB, row-major, the top row (v = 1) first.
    pub pixels: Vec<[f32; 3]>,
}
