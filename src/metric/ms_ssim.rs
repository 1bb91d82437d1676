//! Structural similarity over several scales (Wang et al. 2003).

use super::ssim::{ChannelPair, WINDOW, window_means};
use crate::image::Size;

/// The exponents of the five scales, finest first (Wang et al. 2003), used as published although
/// they add up to 1.0001.
const WEIGHTS: [f64; 5] = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333];

/// Multi-scale SSIM and how many scales the image size allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MsSsim {
    /// 1 where the images are equal.
    pub value: f64,
    /// 5, or fewer when a side would shrink below the window of 11 pixels.
    pub scales: usize,
}

/// Multi-scale SSIM of two channels with values in `[0, 1]`.
///
/// Contrast of the finer scales, full SSIM of the coarsest, each raised to its weight; negative
/// means count as 0. Between scales 2 x 2 blocks are averaged. Images with a side below 161 pixels
/// use fewer scales, with the remaining weights renormalised to 1.
///
/// As pytorch-msssim does, an axis of odd length is preceded by a row or column of zeros before it
/// is halved.
pub fn ms_ssim(reference: &[f32], test: &[f32], size: Size) -> MsSsim {
    let scales = scale_count(size);
    let renormalise = match scales {
        5 => 1.0,
        _ => 1.0 / WEIGHTS[..scales].iter().sum::<f64>(),
    };
    let (mut x, mut y, mut size) = (reference.to_vec(), test.to_vec(), size);
    let mut value = 1.0;
    for (scale, weight) in WEIGHTS[..scales].iter().enumerate() {
        if scale > 0 {
            (x, y) = (halve(&x, size), halve(&y, size));
            size = half(size);
        }
        let means = window_means(ChannelPair {
            reference: &x,
            test: &y,
            width: size.width,
            height: size.height,
        });
        let last = scale + 1 == scales;
        let mean = if last { means.ssim } else { means.contrast };
        value *= mean.max(0.0).powf(weight * renormalise);
    }
    MsSsim { value, scales }
}

fn scale_count(mut size: Size) -> usize {
    let mut scales = 1;
    while scales < WEIGHTS.len() {
        size = half(size);
        if size.width.min(size.height) < WINDOW {
            break;
        }
        scales += 1;
    }
    scales
}

fn half(size: Size) -> Size {
    Size::new(size.width.div_ceil(2), size.height.div_ceil(2))
}

fn halve(values: &[f32], size: Size) -> Vec<f32> {
    let Size { width, height } = size;
    let half = half(size);
    let mut reduced = Vec::with_capacity(half.width * half.height);
    for y in 0..half.height {
        for x in 0..half.width {
            let mut sum = 0.0;
            for (j, i) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let row = (2 * y + j).checked_sub(height % 2);
                let column = (2 * x + i).checked_sub(width % 2);
                if let (Some(row), Some(column)) = (row, column) {
                    sum += values[row * width + column];
                }
            }
            reduced.push(0.25 * sum);
        }
    }
    reduced
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::ssim;
    use approx::assert_abs_diff_eq;

    #[test]
    fn scales_follow_the_shorter_side() {
        let sides = [
            (1, 1),
            (20, 1),
            (21, 2),
            (40, 2),
            (41, 3),
            (81, 4),
            (160, 4),
            (161, 5),
        ];
        for (side, scales) in sides {
            assert_eq!(scale_count(Size::new(side, 4000)), scales, "side {side}");
        }
    }

    #[test]
    fn one_scale_is_ssim_and_equal_images_are_one() {
        let x: Vec<f32> = (0..18 * 15).map(|i| (i % 11) as f32 / 11.0).collect();
        let y: Vec<f32> = x.iter().map(|v| v * 0.9 + 0.05).collect();
        let single = ms_ssim(&x, &y, Size::new(18, 15));
        assert_eq!(single.scales, 1);
        assert_abs_diff_eq!(
            single.value,
            ssim(&x, &y, Size::new(18, 15)),
            epsilon = 1e-12
        );
        let large: Vec<f32> = (0..200 * 170).map(|i| (i % 13) as f32 / 13.0).collect();
        let same = ms_ssim(&large, &large, Size::new(200, 170));
        assert_eq!(same.scales, 5);
        assert_abs_diff_eq!(same.value, 1.0, epsilon = 1e-12);
    }

    #[test]
    fn halving_averages_blocks_and_pads_odd_axes_in_front() {
        assert_eq!(halve(&[1.0, 2.0, 3.0, 6.0], Size::new(2, 2)), [3.0]);
        assert_eq!(halve(&[4.0, 8.0, 12.0], Size::new(3, 1)), [1.0, 5.0]);
    }

    #[test]
    fn inverted_contrast_is_zero_and_not_nan() {
        let x: Vec<f32> = (0..200 * 200).map(|i| (i % 2) as f32).collect();
        let y: Vec<f32> = x.iter().map(|v| 1.0 - v).collect();
        assert_eq!(ms_ssim(&x, &y, Size::new(200, 200)).value, 0.0);
    }
}
