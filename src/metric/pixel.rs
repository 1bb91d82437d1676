//! Errors of pixels: RMSE, relative errors, PSNR.

use super::convolve::strips;
use crate::image::Image;
use rayon::prelude::*;

/// The ε of relMSE (METHODS 9.1).
const RELATIVE_EPSILON: f64 = 0.01;
/// One pixel in this many is rejected as an outlier by the trimmed relMSE.
const PIXELS_PER_OUTLIER: usize = 1000;
/// Pixels per partial sum.
const CHUNK: usize = 1 << 14;

/// Errors that are means over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PixelErrors {
    /// Mean of (a - r)².
    pub mse: f64,
    /// Mean of |a - r|.
    pub mae: f64,
    /// Σ (a - r) over Σ r; `None` of a black reference.
    pub mean_error: Option<f64>,
    /// Mean of (a - r)² / (r² + 0.01), r the reference's channel.
    pub relmse: f64,
    /// relMSE without the worst 0.1 % of the pixels (rounded down).
    pub relmse_trimmed: f64,
}

/// Mean errors of `test` against `reference` on the values as they are.
///
/// Both must be finite, of one size and not empty.
pub fn pixel_errors(reference: &Image, test: &Image) -> PixelErrors {
    let count = reference.pixels.len();
    let partial: Vec<([f64; 4], Vec<f64>)> = strips(count, CHUNK)
        .into_par_iter()
        .map(|range| {
            let mut sums = [0.0; 4];
            let mut relative = Vec::with_capacity(range.len());
            for (r, a) in reference.pixels[range.clone()]
                .iter()
                .zip(&test.pixels[range])
            {
                let mut of_pixel = 0.0;
                for (&r, &a) in r.iter().zip(a) {
                    let (r, difference) = (f64::from(r), f64::from(a) - f64::from(r));
                    let square = difference * difference;
                    sums[0] += square;
                    sums[1] += difference.abs();
                    sums[2] += difference;
                    sums[3] += r;
                    of_pixel += square / (r * r + RELATIVE_EPSILON);
                }
                relative.push(of_pixel);
            }
            (sums, relative)
        })
        .collect();
    let values = (3 * count) as f64;
    let total = |c: usize| partial.iter().map(|(sums, _)| sums[c]).sum::<f64>();
    let (mse, mae) = (total(0) / values, total(1) / values);
    let (more, all) = (total(2), total(3));
    let mut relative: Vec<f64> = partial.into_iter().flat_map(|(_, terms)| terms).collect();
    PixelErrors {
        mse,
        mae,
        mean_error: (all != 0.0).then(|| more / all),
        relmse: relative.iter().sum::<f64>() / values,
        relmse_trimmed: trimmed_mean(&mut relative) / 3.0,
    }
}

fn trimmed_mean(values: &mut [f64]) -> f64 {
    let kept = values.len() - values.len() / PIXELS_PER_OUTLIER;
    if kept < values.len() {
        values.select_nth_unstable_by(kept, f64::total_cmp);
    }
    values[..kept].iter().sum::<f64>() / kept as f64
}

/// Peak signal-to-noise ratio in dB of a mean squared error on values in `[0, 1]`; `None` (infinite)
/// for equal images.
pub fn psnr(mse: f64) -> Option<f64> {
    (mse > 0.0).then(|| 0.0 - 10.0 * mse.log10())
}

/// The per-pixel absolute difference of two images of one size.
pub fn absolute_error(reference: &Image, test: &Image) -> Image {
    let pixels = reference.pixels.par_iter().zip(&test.pixels);
    Image {
        width: reference.width,
        height: reference.height,
        pixels: pixels
            .map(|(r, a)| std::array::from_fn(|c| (a[c] - r[c]).abs()))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn analytic_values_for_constant_images() {
        let mut reference = Image::new(40, 30);
        let mut test = Image::new(40, 30);
        reference.pixels.fill([2.0; 3]);
        test.pixels.fill([2.5; 3]);
        let errors = pixel_errors(&reference, &test);
        assert_relative_eq!(errors.mse, 0.25);
        assert_relative_eq!(errors.mae, 0.5);
        assert_eq!(errors.mean_error, Some(0.25));
        assert_eq!(pixel_errors(&test, &reference).mean_error, Some(-0.2));
        let black = Image::new(40, 30);
        assert_eq!(pixel_errors(&black, &test).mean_error, None);
        assert_relative_eq!(errors.relmse, 0.25 / 4.01, max_relative = 1e-12);
        assert_relative_eq!(errors.relmse_trimmed, errors.relmse, max_relative = 1e-12);
        assert_relative_eq!(psnr(0.01).unwrap(), 20.0, max_relative = 1e-12);
        assert_eq!(psnr(0.0), None);
    }

    #[test]
    fn trimming_rejects_a_firefly() {
        let reference = Image::new(50, 40);
        let mut test = Image::new(50, 40);
        test.pixels.fill([0.1; 3]);
        test.pixels[777] = [1e19; 3];
        let errors = pixel_errors(&reference, &test);
        assert!(errors.relmse > 1e30 && errors.relmse.is_finite());
        assert_relative_eq!(errors.relmse_trimmed, 1.0, max_relative = 1e-6);
    }
}
