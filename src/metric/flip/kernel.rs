//! The filters of FLIP in separated form (METHODS 9.3, steps 2 and 5).

use std::f64::consts::PI;

/// Width of the edge and point detectors in degrees (w of the paper).
const FEATURE_WIDTH_DEG: f64 = 0.082;

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
        let ppd = f64::from(pixels_per_degree);
        let [achromatic, red_green, blue_yellow_0, blue_yellow_1] = contrast_sensitivity(ppd);
        let [gaussian, edge, point] = feature_detectors(ppd);
        Self {
            achromatic,
            red_green,
            blue_yellow: [blue_yellow_0, blue_yellow_1],
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

fn offsets(radius: usize) -> impl Iterator<Item = f64> {
    (0..=2 * radius).map(move |k| k as f64 - radius as f64)
}

fn to_f32(values: impl Iterator<Item = f64>) -> Vec<f32> {
    values.map(|value| value as f32).collect()
}

/// Gaussians `sqrt(a sqrt(π/b)) exp(-π² r²/b)`, r in degrees: the outer product of one with itself
/// is the two-dimensional filter. Achromatic and red-green sum to 1; the squared sums of the two
/// blue-yellow ones add up to 1.
fn contrast_sensitivity(ppd: f64) -> [Vec<f32>; 4] {
    let widest = 0.04;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * ppd).ceil() as usize;
    let values = |a: f64, b: f64| -> Vec<f64> {
        let peak = (a * (PI / b).sqrt()).sqrt();
        offsets(radius)
            .map(|x| peak * (-(PI * x / ppd).powi(2) / b).exp())
            .collect()
    };
    let sum = |values: &[f64]| values.iter().sum::<f64>();
    let single = |b: f64| {
        let values = values(1.0, b);
        let total = sum(&values);
        to_f32(values.into_iter().map(|value| value / total))
    };
    let (wide, narrow) = (values(34.1, 0.04), values(13.5, 0.025));
    let total = (sum(&wide).powi(2) + sum(&narrow).powi(2)).sqrt();
    let scaled = |values: Vec<f64>| to_f32(values.into_iter().map(|value| value / total));
    [single(0.0047), single(0.0053), scaled(wide), scaled(narrow)]
}

/// A Gaussian that sums to 1, and its derivatives with positive weights that sum to 1 and negative
/// ones that sum to -1.
fn feature_detectors(ppd: f64) -> [Vec<f32>; 3] {
    let sigma = 0.5 * FEATURE_WIDTH_DEG * ppd;
    let radius = (3.0 * sigma).ceil() as usize;
    let gauss = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
    let total: f64 = offsets(radius).map(gauss).sum();
    let balanced = |weight: &dyn Fn(f64) -> f64| {
        let part =
            |sign: f64| -> f64 { offsets(radius).map(|x| (sign * weight(x)).max(0.0)).sum() };
        let (positive, negative) = (part(1.0), part(-1.0));
        to_f32(offsets(radius).map(|x| match weight(x) {
            value if value > 0.0 => value / positive,
            value if value < 0.0 => value / negative,
            _ => 0.0,
        }))
    };
    [
        to_f32(offsets(radius).map(|x| gauss(x) / total)),
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
        for ppd in [1.0, 5.0, 40.0, 67.0206, 300.0] {
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
}
