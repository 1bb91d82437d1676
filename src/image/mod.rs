//! Pixel buffers, image files, colour conversions and tone curves.
//!
//! An [`Image`] holds linear RGB. Files are read with [`read`] (always linear) or [`read_coded`]
//! (the values as stored, with the [`Encoding`] they have), and written with [`write_exr`] (named
//! layers and provenance) and [`write_png`]. Every write goes to a temporary name beside its place
//! and is renamed when complete.

mod area;
mod atomic;
mod color;
mod error;
mod exr_picture;
mod exr_read;
mod exr_write;
mod false_color;
#[cfg(test)]
mod file_tests;
mod guard;
mod hdr_flat;
mod hdr_header;
mod layer;
mod mean;
mod overview;
mod png;
mod primaries;
mod read;
mod resample;
mod sanitise;
mod tone;
mod unheeded;

pub use area::{Rect, Size};
pub use atomic::write_atomically;
pub use color::{clamp_unit, decode_srgb, encode_srgb, srgb_decode, srgb_encode, to_display};
pub use error::ImageError;
pub use exr_read::{LayeredImage, read_layers};
pub use exr_write::write_exr;
pub use false_color::{Palette, false_color};
pub use guard::{decoded, is_cut_jpeg};
pub(crate) use guard::{holds, is_worth, pixels_a_byte};
pub use layer::{Attributes, Layer, Plane, Samples};
pub use mean::ImageMean;
pub use overview::overview;
pub use png::{display_bytes, png_bytes, write_png, write_png_bytes, write_png_coded};
pub use read::{Encoding, Picture, file_of, read, read_coded, read_picture};
pub(crate) use read::{decode_bytes, promised_size, translucent_pixels};
pub use sanitise::{Sanitised, sanitise};
pub use tone::{ToneCurve, UnknownToneCurve};
pub(crate) use unheeded::unheeded;

use rayon::prelude::*;

/// A linear RGB image (Rec.709 primaries, scene-referred), row-major, the top left pixel first.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Image {
    /// Pixels of a row.
    pub width: usize,
    /// Pixels of a column.
    pub height: usize,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Image {
    /// A black image.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            pixels: vec![[0.0; 3]; width * height],
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        Size::new(self.width, self.height)
    }

    /// The pixel in column `x` and row `y`, counted from the top left.
    pub fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// An image of the same size with `change` applied to every pixel.
    pub fn map(&self, change: impl Fn([f32; 3]) -> [f32; 3] + Sync) -> Self {
        Self {
            width: self.width,
            height: self.height,
            pixels: self.pixels.par_iter().map(|&pixel| change(pixel)).collect(),
        }
    }
}

/// Weights of linear Rec.709 channels in luminance.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance of a linear Rec.709 colour.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2]
}
