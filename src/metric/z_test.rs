//! Whether an unbiased image differs from its expectation by more than its variance explains.

use super::MetricError;
use super::error::check_sizes;
use crate::image::Image;

/// How the difference of two images compares with the noise that it should have.
///
/// For equal expectations and the right variance `mean_squared` is near 1 and `share_beyond_3` near
/// 0.0027 (more where the noise has heavy tails).
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ZTest {
    /// Values (pixels times channels) with a positive variance.
    pub count: usize,
    /// Mean of z: its sign tells the direction of a bias.
    pub mean: f64,
    /// Mean of z².
    pub mean_squared: f64,
    /// Share of the values with |z| > 3.
    pub share_beyond_3: f64,
    /// Values without variance that are equal: they say nothing.
    pub without_noise: usize,
    /// Values without variance, or not finite, that differ: certain errors.
    pub certain_errors: usize,
}

/// Tests whether `test` equals `expected` within `variance`, the per-value variance of their
/// difference (the sum of both variances when both are noisy).
pub fn z_test(test: &Image, expected: &Image, variance: &Image) -> Result<ZTest, MetricError> {
    check_sizes(expected, test)?;
    check_sizes(expected, variance)?;
    let mut result = ZTest::default();
    let mut beyond = 0usize;
    let values = test
        .pixels
        .iter()
        .zip(&expected.pixels)
        .zip(&variance.pixels);
    for ((test, expected), variance) in values {
        for c in 0..3 {
            let difference = f64::from(test[c]) - f64::from(expected[c]);
            let z = difference / f64::from(variance[c]).sqrt();
            if variance[c] > 0.0 && z.is_finite() {
                result.count += 1;
                result.mean += z;
                result.mean_squared += z * z;
                beyond += usize::from(z.abs() > 3.0);
            } else if difference == 0.0 {
                result.without_noise += 1;
            } else {
                result.certain_errors += 1;
            }
        }
    }
    let count = result.count.max(1) as f64;
    result.mean /= count;
    result.mean_squared /= count;
    result.share_beyond_3 = beyond as f64 / count;
    Ok(result)
}

/// The z-score of every block's mean difference, one pixel per `block x block` pixels: sensitive to
/// small biases over an area, and nearly normal even where single pixels have heavy tails.
///
/// A block without variance has 0 if it is equal, else an infinite score of the difference's sign.
pub fn block_z_scores(
    test: &Image,
    expected: &Image,
    variance: &Image,
    block: usize,
) -> Result<Image, MetricError> {
    check_sizes(expected, test)?;
    check_sizes(expected, variance)?;
    let block = block.max(1);
    let size = (test.width.div_ceil(block), test.height.div_ceil(block));
    let mut scores = Image::new(size.0, size.1);
    let mut sums = vec![[[0.0_f64; 2]; 3]; size.0 * size.1];
    for y in 0..test.height {
        for x in 0..test.width {
            let sum = &mut sums[y / block * size.0 + x / block];
            let (a, e, v) = (test.at(x, y), expected.at(x, y), variance.at(x, y));
            for c in 0..3 {
                sum[c][0] += f64::from(a[c]) - f64::from(e[c]);
                sum[c][1] += f64::from(v[c]);
            }
        }
    }
    for (score, sum) in scores.pixels.iter_mut().zip(sums) {
        *score = sum.map(|[difference, variance]| match difference {
            0.0 => 0.0,
            _ => (difference / variance.sqrt()) as f32,
        });
    }
    Ok(scores)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    /// Standard normal noise by the sum of twelve uniforms.
    fn noise(width: usize, height: usize) -> Image {
        let mut image = Image::new(width, height);
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            let mut rng = Rng::new(3, 0, i as u64, 0);
            *pixel = std::array::from_fn(|_| (0..12).map(|_| rng.next_f32()).sum::<f32>() - 6.0);
        }
        image
    }

    #[test]
    fn right_variance_gives_one_and_wrong_variance_shows() {
        let test = noise(64, 64);
        let expected = Image::new(64, 64);
        let unit = expected.map(|_| [1.0; 3]);
        let right = z_test(&test, &expected, &unit).unwrap();
        assert!((right.mean_squared - 1.0).abs() < 0.05, "{right:?}");
        assert!(
            right.share_beyond_3 < 0.006 && right.mean.abs() < 0.03,
            "{right:?}"
        );
        let wrong = z_test(&test, &expected, &unit.map(|_| [0.25; 3])).unwrap();
        assert!(
            wrong.mean_squared > 3.5 && wrong.share_beyond_3 > 0.1,
            "{wrong:?}"
        );
    }

    #[test]
    fn blocks_reveal_a_bias_that_pixels_hide() {
        let biased = noise(64, 64).map(|pixel| pixel.map(|value| value + 0.3));
        let expected = Image::new(64, 64);
        let unit = expected.map(|_| [1.0; 3]);
        let scores = block_z_scores(&biased, &expected, &unit, 32).unwrap();
        assert_eq!((scores.width, scores.height), (2, 2));
        assert!(
            scores.pixels.iter().flatten().all(|&z| z > 5.0),
            "{scores:?}"
        );
    }

    #[test]
    fn zero_variance_is_counted_apart() {
        let expected = Image::new(2, 1);
        let mut test = expected.clone();
        test.pixels[0][0] = 1.0;
        test.pixels[1][2] = f32::NAN;
        let result = z_test(&test, &expected, &Image::new(2, 1)).unwrap();
        assert_eq!(
            (result.count, result.without_noise, result.certain_errors),
            (0, 4, 2)
        );
        assert_eq!(result.mean_squared, 0.0);
        assert!(z_test(&test, &Image::new(1, 2), &Image::new(2, 1)).is_err());
    }
}
