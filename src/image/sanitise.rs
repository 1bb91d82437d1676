//! Values that no image may hold, made harmless and counted.

use super::Image;

/// Stands in for +Inf in a channel without any positive finite value: the largest half-float.
const INFINITY_CAP: f32 = 65504.0;

/// What [`sanitise`] replaced, counted in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Sanitised {
    /// Pixels with a NaN or an infinity in any channel.
    pub non_finite: usize,
    /// Pixels with a finite negative value in any channel.
    pub negative: usize,
}

/// Replaces what no metric or sampler can use: NaN by 0, +Inf by the largest finite value of its
/// channel, negative values and -Inf by 0.
///
/// A channel whose finite values are all zero or absent takes 65504 for +Inf.
pub fn sanitise(image: &mut Image) -> Sanitised {
    let mut counts = Sanitised::default();
    let mut largest = [0.0_f32; 3];
    for pixel in &image.pixels {
        counts.non_finite += usize::from(pixel.iter().any(|value| !value.is_finite()));
        counts.negative += usize::from(pixel.iter().any(|v| v.is_finite() && *v < 0.0));
        for (top, &value) in largest.iter_mut().zip(pixel) {
            if value.is_finite() {
                *top = top.max(value);
            }
        }
    }
    if counts == Sanitised::default() {
        return counts;
    }
    let cap = largest.map(|top| if top > 0.0 { top } else { INFINITY_CAP });
    for pixel in &mut image.pixels {
        for (value, cap) in pixel.iter_mut().zip(cap) {
            if *value == f32::INFINITY {
                *value = cap;
            } else if value.is_nan() || *value < 0.0 {
                *value = 0.0;
            }
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_is_applied_and_counted() {
        let mut image = Image {
            width: 4,
            height: 1,
            pixels: vec![
                [f32::NAN, 2.0, 0.0],
                [f32::INFINITY, f32::INFINITY, f32::INFINITY],
                [-1.0, f32::NEG_INFINITY, -0.0],
                [3.0, 1.0, 0.0],
            ],
        };
        let counts = sanitise(&mut image);
        assert_eq!((counts.non_finite, counts.negative), (3, 1));
        assert_eq!(image.pixels[0], [0.0, 2.0, 0.0]);
        assert_eq!(image.pixels[1], [3.0, 2.0, INFINITY_CAP]);
        assert_eq!(image.pixels[2], [0.0, 0.0, 0.0]);
        assert_eq!(image.pixels[3], [3.0, 1.0, 0.0]);
        assert_eq!(sanitise(&mut image), Sanitised::default());
    }
}
