//! Pictures of high-dynamic-range maps that show dark and bright parts alike.

use super::{Image, ToneCurve, encode_srgb, luminance};

/// A map at most `width` pixels wide, sRGB-coded: its logarithmic mean becomes a middle grey and
/// highlights are compressed.
pub fn overview(map: &Image, width: usize) -> Image {
    let shown = map.box_downsample(map.width.div_ceil(width.max(1)));
    let lit: Vec<f64> = shown
        .pixels
        .iter()
        .map(|&p| f64::from(luminance(p)))
        .filter(|&l| l > 0.0)
        .collect();
    let mean = lit.iter().map(|l| l.ln()).sum::<f64>() / lit.len().max(1) as f64;
    let gain = (0.25 / mean.exp()) as f32;
    let toned = shown.map(|p| {
        ToneCurve::Reinhard
            .apply(p.map(|v| v * gain))
            .map(|v| v.clamp(0.0, 1.0))
    });
    encode_srgb(&toned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_brightness_gives_the_same_picture() {
        let mut map = Image::new(64, 32);
        for (i, pixel) in map.pixels.iter_mut().enumerate() {
            *pixel = [1.0 + (i % 7) as f32, 2.0, 0.5];
        }
        let [plain, bright] =
            [1.0, 1e4].map(|gain| overview(&map.map(|p| p.map(|v| v * gain)), 32));
        assert_eq!((plain.width, plain.height), (32, 16));
        for (a, b) in plain
            .pixels
            .iter()
            .flatten()
            .zip(bright.pixels.iter().flatten())
        {
            assert!((a - b).abs() < 1e-4);
        }
        let dark = overview(&Image::new(8, 4), 8);
        assert!(dark.pixels.iter().flatten().all(|v| *v == 0.0));
    }
}
