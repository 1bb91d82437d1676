//! Numbers as colours.

use super::{Image, Plane};

/// A perceptual colour scale: its lightness rises steadily from one end to the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Palette {
    /// Black over purple and orange to pale yellow.
    #[default]
    Magma,
    /// Violet over teal to yellow.
    Viridis,
}

/// What a value that is not a number is painted with: a colour that no palette contains.
const NOT_A_NUMBER: [f32; 3] = [0.0, 1.0, 0.0];

/// Nine evenly spaced colours in the style of magma, rounded; sRGB-coded.
const MAGMA: [[f32; 3]; 9] = [
    [0.00, 0.00, 0.01],
    [0.11, 0.07, 0.28],
    [0.32, 0.07, 0.49],
    [0.51, 0.15, 0.51],
    [0.72, 0.22, 0.47],
    [0.90, 0.31, 0.39],
    [0.98, 0.53, 0.38],
    [0.99, 0.77, 0.53],
    [0.99, 0.99, 0.75],
];

/// Nine evenly spaced colours in the style of viridis, rounded; sRGB-coded.
const VIRIDIS: [[f32; 3]; 9] = [
    [0.27, 0.00, 0.33],
    [0.28, 0.17, 0.48],
    [0.23, 0.32, 0.55],
    [0.17, 0.45, 0.56],
    [0.13, 0.57, 0.55],
    [0.16, 0.68, 0.50],
    [0.37, 0.79, 0.38],
    [0.68, 0.86, 0.19],
    [0.99, 0.91, 0.15],
];

impl Palette {
    /// The sRGB-coded colour of a value in `[0, 1]`; values outside are clamped, NaN is pure green.
    pub fn color(self, value: f32) -> [f32; 3] {
        if value.is_nan() {
            return NOT_A_NUMBER;
        }
        let table = match self {
            Self::Magma => &MAGMA,
            Self::Viridis => &VIRIDIS,
        };
        let position = value.clamp(0.0, 1.0) * (table.len() - 1) as f32;
        let index = (position as usize).min(table.len() - 2);
        let t = position - index as f32;
        std::array::from_fn(|c| table[index][c] * (1.0 - t) + table[index + 1][c] * t)
    }
}

/// Paints a plane with a palette, `low` at its dark end and `high` at its bright one; the result is
/// sRGB-coded (see [`super::write_png_coded`]).
///
/// When `high` is not above `low` every finite value is painted with the dark end.
pub fn false_color(plane: &Plane, [low, high]: [f32; 2], palette: Palette) -> Image {
    let scale = if high > low { 1.0 / (high - low) } else { 0.0 };
    Image {
        width: plane.width,
        height: plane.height,
        pixels: plane
            .values
            .iter()
            .map(|&value| palette.color((value - low) * scale))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{luminance, srgb_decode};

    #[test]
    fn lightness_rises_along_every_palette() {
        for palette in [Palette::Magma, Palette::Viridis] {
            let mut last = -1.0;
            for i in 0..=256 {
                let y = luminance(palette.color(i as f32 / 256.0).map(srgb_decode));
                assert!(y > last, "{palette:?} at {i}: {y} after {last}");
                last = y;
            }
        }
    }

    #[test]
    fn ends_are_clamped_and_nan_stands_out() {
        assert_eq!(Palette::Magma.color(-3.0), MAGMA[0]);
        assert_eq!(Palette::Magma.color(f32::INFINITY), MAGMA[8]);
        assert_eq!(Palette::Viridis.color(f32::NAN), NOT_A_NUMBER);
        let plane = Plane {
            width: 2,
            height: 1,
            values: vec![5.0, 7.0],
        };
        let flat = false_color(&plane, [7.0, 7.0], Palette::Viridis);
        assert_eq!(flat.pixels, vec![VIRIDIS[0]; 2]);
        assert_eq!(
            false_color(&plane, [5.0, 7.0], Palette::Viridis).pixels[1],
            VIRIDIS[8]
        );
    }
}
