//! The colour spaces of FLIP: opponent YCxCz, and Hunt-adjusted L*a*b* (METHODS 9.3, steps 1, 3, 4).
//!
//! Colours that differ by rounding alone have FLIP values of up to 1e-4, so to agree with the official
//! maps the arithmetic here is f32, in the official order.

use crate::image::clamp_unit;

/// The D65 white of FLIP in XYZ.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_3];

/// Its reciprocal as the official implementation rounds it.
const INVERSE_WHITE: [f32; 3] = [1.052_156_9, 1.0, 0.918_357_7];

/// q_c, p_c and p_t of the paper.
const COLOR_EXPONENT: f32 = 0.7;
const SPLIT_SHARE: f32 = 0.4;
const SPLIT_ERROR: f32 = 0.95;

/// Linear RGB to XYZ divided by white.
fn relative_xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    let x = (10_135_552.0 / 24_577_794.0) * r
        + (8_788_810.0 / 24_577_794.0) * g
        + (4_435_075.0 / 24_577_794.0) * b;
    let y = (2_613_072.0 / 12_288_897.0) * r
        + (8_788_810.0 / 12_288_897.0) * g
        + (887_015.0 / 12_288_897.0) * b;
    let z = (1_425_312.0 / 73_733_382.0) * r
        + (8_788_810.0 / 73_733_382.0) * g
        + (70_074_185.0 / 73_733_382.0) * b;
    [x * INVERSE_WHITE[0], y, z * INVERSE_WHITE[2]]
}

/// Linear RGB to the opponent space: no cube root.
pub(super) fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Opponent space to linear RGB, clamped to `[0, 1]`.
fn clamped_rgb([lightness, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (lightness + 16.0) / 116.0;
    let x = (y + cx / 500.0) * WHITE[0];
    let z = (y - cz / 200.0) * WHITE[2];
    [
        3.241_003_3 * x - 1.537_398_9 * y - 0.498_615_86 * z,
        -0.969_224_33 * x + 1.875_930_1 * y + 0.041_554_224 * z,
        0.055_639_423 * x - 0.204_011_2 * y + 1.057_148_9 * z,
    ]
    .map(clamp_unit)
}

/// The nonlinearity of CIE L*a*b*: a cube root with a linear toe.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * (DELTA * DELTA) {
        t.powf(1.0 / 3.0)
    } else {
        (1.0 / (3.0 * (DELTA * DELTA))) * t + 4.0 / 29.0
    }
}

/// Linear RGB to CIE L*a*b* under D65.
pub fn lab(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb).map(lab_curve);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// [`lab`] with chroma scaled by 0.01 L (Hunt effect).
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    let [lightness, a, b] = lab(rgb);
    let hunt = 0.01 * lightness;
    [lightness, hunt * a, hunt * b]
}

/// City-block distance in lightness plus Euclidean distance in chroma.
fn hyab(one: [f32; 3], other: [f32; 3]) -> f32 {
    let (da, db) = (one[1] - other[1], one[2] - other[2]);
    (one[0] - other[0]).abs() + (da * da + db * db).sqrt()
}

/// The perceived difference of two filtered opponent colours, in `[0, 1]`.
#[derive(Clone, Copy)]
pub(super) struct ColorDifference {
    /// c_max: green against blue.
    largest: f32,
}

impl ColorDifference {
    pub(super) fn new() -> Self {
        let (green, blue) = (hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0]));
        Self {
            largest: hyab(green, blue).powf(COLOR_EXPONENT),
        }
    }

    /// Small differences take the range [0, 0.95], the rest is squeezed above it.
    pub(super) fn of(&self, reference: [f32; 3], test: [f32; 3]) -> f32 {
        let distance = hyab(
            hunt_lab(clamped_rgb(reference)),
            hunt_lab(clamped_rgb(test)),
        );
        let error = distance.powf(COLOR_EXPONENT);
        let split = SPLIT_SHARE * self.largest;
        if error < split {
            error * (SPLIT_ERROR / split)
        } else {
            SPLIT_ERROR + (error - split) / (self.largest - split) * (1.0 - SPLIT_ERROR)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn opponent_space_round_trips_inside_the_gamut() {
        for rgb in [[0.0; 3], [1.0; 3], [0.2, 0.7, 0.1], [0.9, 0.0, 0.4]] {
            let back = clamped_rgb(opponent(rgb));
            for c in 0..3 {
                assert_abs_diff_eq!(back[c], rgb[c], epsilon = 2e-6);
            }
        }
    }

    #[test]
    fn largest_difference_is_that_of_the_paper() {
        let difference = ColorDifference::new();
        assert_abs_diff_eq!(difference.largest, 41.2761, epsilon = 1e-3);
        let (green, blue) = (opponent([0.0, 1.0, 0.0]), opponent([0.0, 0.0, 1.0]));
        assert_abs_diff_eq!(difference.of(green, blue), 1.0, epsilon = 1e-5);
        assert_eq!(difference.of(green, green), 0.0);
    }
}
