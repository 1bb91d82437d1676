//! Lights drawn on the tone-mapped environment map they were made from.

use super::canvas::{disc, fitted_size, scaled};
use crate::environment::LightKind;
use crate::image::{Image, Plane, ToneCurve, encode_srgb, luminance};

pub const DIRECT: [f32; 3] = [0.95, 0.1, 0.08];
pub const INDIRECT: [f32; 3] = [0.12, 0.35, 1.0];
const RIM: [f32; 3] = [1.0; 3];

/// A latitude–longitude map for display: its logarithmic mean becomes a dark grey, and highlights are
/// compressed.
pub fn tone_mapped(map: &Image, most: (usize, usize)) -> Image {
    let shown = scaled(map, fitted_size((map.width, map.height), most));
    let lit: Vec<f64> = shown
        .pixels
        .iter()
        .map(|&p| f64::from(luminance(p)))
        .filter(|&l| l > 0.0)
        .collect();
    let mean = lit.iter().map(|l| l.ln()).sum::<f64>() / lit.len().max(1) as f64;
    let gain = (0.25 / mean.exp()) as f32;
    let curve = ToneCurve::Reinhard;
    let toned = shown.map(|p| curve.apply(p.map(|v| v * gain)).map(|v| v.clamp(0.0, 1.0)));
    encode_srgb(&toned)
}

/// Marks lights at their map coordinates (u, v in [0, 1]): direct and global ones red, indirect ones
/// blue.
pub fn draw_lights(shown: &mut Image, lights: impl Iterator<Item = ([f32; 2], LightKind)>) {
    let size = [shown.width as f32, shown.height as f32];
    let radius = (size[0] / 150.0).max(2.5);
    for ([u, v], kind) in lights {
        let color = match kind {
            LightKind::Indirect => INDIRECT,
            LightKind::Direct | LightKind::Global => DIRECT,
        };
        let center = (u * size[0], v * size[1]);
        disc(shown, center, radius * 1.35, RIM);
        disc(shown, center, radius, color);
    }
}

/// Tints texels where `emissive` is set red and the others blue.
pub fn tint_classes(shown: &mut Image, emissive: &Plane) {
    let (width, height) = (shown.width, shown.height);
    for y in 0..height {
        for x in 0..width {
            let (sx, sy) = (x * emissive.width / width, y * emissive.height / height);
            let bright = emissive.values[sy * emissive.width + sx] > 0.5;
            let color = if bright { DIRECT } else { INDIRECT };
            let pixel = &mut shown.pixels[y * width + x];
            let share = if bright { 0.75 } else { 0.45 };
            (0..3).for_each(|c| pixel[c] += (color[c] - pixel[c]) * share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_appear_at_their_place_over_any_map() {
        let mut map = Image::new(64, 32);
        map.pixels[7] = [1e6, 1e5, 1e4];
        for map in [map, Image::new(64, 32)] {
            let mut shown = tone_mapped(&map, (640, 320));
            assert_eq!((shown.width, shown.height), (640, 320));
            assert!(shown.pixels.iter().flatten().all(|v| v.is_finite()));
            let lights = [
                ([0.25, 0.5], LightKind::Direct),
                ([0.75, 0.5], LightKind::Indirect),
            ];
            draw_lights(&mut shown, lights.into_iter());
            assert_eq!(shown.at(160, 160), DIRECT);
            assert_eq!(shown.at(480, 160), INDIRECT);
        }
    }
}
