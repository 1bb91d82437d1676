//! Values that cannot be radiance.

use crate::image::Image;

/// Values of the input that could not be radiance, and were replaced: NaN and negative by 0,
/// infinite by the largest finite value of the channel. Counted per channel value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Sanitised {
    /// Replaced by 0.
    pub nan: usize,
    /// Replaced by the channel's largest finite value.
    pub infinite: usize,
    /// Replaced by 0.
    pub negative: usize,
}

impl Sanitised {
    /// A sentence about what was replaced; `None` when nothing was.
    pub fn note(&self) -> Option<String> {
        (*self != Self::default()).then(|| {
            format!(
                "environment map repaired: {} NaN and {} negative values became 0, {} infinite ones \
                 the largest finite one",
                self.nan, self.negative, self.infinite
            )
        })
    }
}

/// The pixels of an image times a factor, without such values.
pub(super) fn sanitise(image: &Image, scale: f32) -> (Vec<[f32; 3]>, Sanitised) {
    let mut largest = [0.0f32; 3];
    for pixel in &image.pixels {
        for (max, value) in largest.iter_mut().zip(pixel) {
            let value = value * scale;
            if value.is_finite() && value > *max {
                *max = value;
            }
        }
    }
    let mut counts = Sanitised::default();
    let mut clean = |value: f32, channel: usize| {
        let value = value * scale;
        if value.is_nan() {
            counts.nan += 1;
            0.0
        } else if value < 0.0 {
            counts.negative += 1;
            0.0
        } else if value.is_infinite() {
            counts.infinite += 1;
            largest[channel]
        } else {
            value
        }
    };
    let pixels = image
        .pixels
        .iter()
        .map(|p| [clean(p[0], 0), clean(p[1], 1), clean(p[2], 2)])
        .collect();
    (pixels, counts)
}
