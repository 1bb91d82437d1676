//! The filters of FLIP in separated form (METHODS 9.3, steps 2 and 5), computed in f32 as the
//! official implementation does.

use std::f32::consts::PI;

/// Width of the edge and point detectors in degrees (w of the paper).
const FEATURE_WIDTH_DEG: f32 = 0.082;

/// One-dimensional kernels for an observer with a given number of pixels per degree.
pub(super) struct Kernels {
    /// Contrast sensitivity: achromatic, red-green, and the two Gaussians of blue-yellow.
    pub achromatic: Vec<f32>,
    pub red_green: Vec<f32>,
    pub blue_yellow: [Vec<f32>; 2],
    /// Feature detection: Gaussian, its first and its second derivative.
    pub gaussian: Vec<f32>,
    pub edge: Vec<f32>,
    pub point: Vec<f32>,
}

impl Kernels {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let [achromatic, red_green, wide, narrow] = contrast_sensitivity(pixels_per_degree);
        let [gaussian, edge, point] = feature_detectors(pixels_per_degree);
        Self {
            achromatic,
            red_green,
            blue_yellow: [wide, narrow],
            gaussian,
            edge,
            point,
        }
    }

    pub(super) fn sensitivity_radius(&self) -> usize {
        self.achromatic.len() / 2
    }

    pub(super) fn feature_radius(&self) -> usize {
        self.gaussian.len() / 2
    }
}

fn offsets(radius: usize) -> impl Iterator<Item = f32> {
    (0..=2 * radius).map(move |k| k as f32 - radius as f32)
}

/// Gaussians `sqrt(a sqrt(π/b)) exp(-π² r²/b)`, r in degrees: the outer product of one with itself
/// is the two-dimensional filter. Achromatic and red-green sum to 1; the squared sums of the two
/// blue-yellow ones add up to 1.
fn contrast_sensitivity(ppd: f32) -> [Vec<f32>; 4] {
    let widest = 0.04_f32;
    let radius = (3.0 * (widest / (2.0 * (PI * PI))).sqrt() * ppd).ceil() as usize;
    let degrees_per_pixel = 1.0 / ppd;
    let values = |peak: f32, b: f32| -> Vec<f32> {
        offsets(radius)
            .map(|pixel| pixel * degrees_per_pixel)
            .map(|x| peak * (-(PI * PI) * (x * x) / b).exp())
            .collect()
    };
    let sum = |values: &[f32]| values.iter().sum::<f32>();
    let scaled = |values: &[f32], factor: f32| values.iter().map(|value| value * factor).collect();
    let single = |b: f32| {
        let values = values((PI / b).sqrt(), b);
        scaled(&values, 1.0 / sum(&values))
    };
    let wide = values((34.1 * (PI / 0.04).sqrt()).sqrt(), 0.04);
    let narrow = values((13.5 * (PI / 0.025).sqrt()).sqrt(), 0.025);
    let (wide_sum, narrow_sum) = (sum(&wide), sum(&narrow));
    let factor = 1.0 / (wide_sum * wide_sum + narrow_sum * narrow_sum).sqrt();
    let blue_yellow = [wide, narrow].map(|values| scaled(&values, factor));
    let [wide, narrow] = blue_yellow;
    [single(0.0047), single(0.0053), wide, narrow]
}

/// A Gaussian that sums to 1, and its derivatives with positive weights that sum to 1 and negative
/// ones that sum to -1.
fn feature_detectors(ppd: f32) -> [Vec<f32>; 3] {
    let sigma = 0.5 * FEATURE_WIDTH_DEG * ppd;
    let radius = (3.0 * sigma).ceil() as usize;
    let gauss = |x: f32| (-(x * x) / (2.0 * sigma * sigma)).exp();
    let total: f32 = offsets(radius).map(gauss).sum();
    let balanced = |weight: &dyn Fn(f32) -> f32| -> Vec<f32> {
        let part =
            |sign: f32| -> f32 { offsets(radius).map(|x| (sign * weight(x)).max(0.0)).sum() };
        let (positive, negative) = (part(1.0), part(-1.0));
        let share = |value: f32| match value {
            value if value > 0.0 => value / positive,
            value if value < 0.0 => value / negative,
            _ => 0.0,
        };
        offsets(radius).map(|x| share(weight(x))).collect()
    };
    [
        offsets(radius).map(|x| gauss(x) / total).collect(),
        balanced(&|x| -x * gauss(x)),
        balanced(&|x| (x * x / (sigma * sigma) - 1.0) * gauss(x)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn default_observer_has_the_radii_of_the_paper() {
        let kernels = Kernels::new(67.0206);
        assert_eq!(kernels.sensitivity_radius(), 10);
        assert_eq!(kernels.feature_radius(), 9);
    }

    #[test]
    fn kernels_are_normalised_for_any_observer() {
        for ppd in [5.0, 13.3, 40.0, 67.0206, 300.0] {
            let kernels = Kernels::new(ppd);
            let sum = |kernel: &[f32]| kernel.iter().map(|&v| f64::from(v)).sum::<f64>();
            for kernel in [&kernels.achromatic, &kernels.red_green, &kernels.gaussian] {
                assert_abs_diff_eq!(sum(kernel), 1.0, epsilon = 1e-5);
            }
            let [wide, narrow] = &kernels.blue_yellow;
            assert_abs_diff_eq!(sum(wide).powi(2) + sum(narrow).powi(2), 1.0, epsilon = 1e-5);
            for kernel in [&kernels.edge, &kernels.point] {
                let absolute: f64 = kernel.iter().map(|&v| f64::from(v.abs())).sum();
                assert_abs_diff_eq!(sum(kernel), 0.0, epsilon = 1e-5);
                assert_abs_diff_eq!(absolute, 2.0, epsilon = 1e-5);
            }
        }
    }

    #[test]
    fn features_smaller_than_a_pixel_vanish_without_nan() {
        let kernels = Kernels::new(1.0);
        for kernel in [&kernels.gaussian, &kernels.edge, &kernels.point] {
            assert!(kernel.iter().all(|weight| weight.is_finite()));
        }
        assert_eq!(kernels.edge, [0.0; 3]);
    }
}
