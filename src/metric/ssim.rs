//! Structural similarity (Wang et al. 2004) with Gaussian weights.

use super::convolve::strips;
use crate::image::Size;
use rayon::prelude::*;

/// Half the width of the window.
const RADIUS: usize = 5;
/// Width of the window: an axis shorter than this has no complete window.
pub(super) const WINDOW: usize = 2 * RADIUS + 1;
const SIGMA: f64 = 1.5;
/// (K1 L)² and (K2 L)² for the data range L = 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;
/// Output rows per task.
const STRIP_ROWS: usize = 16;

/// Two channels of one size, values in `[0, 1]`, row-major.
#[derive(Clone, Copy)]
pub(super) struct ChannelPair<'a> {
    pub reference: &'a [f32],
    pub test: &'a [f32],
    pub width: usize,
    pub height: usize,
}

/// Means over all windows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WindowMeans {
    /// Mean of luminance times contrast-structure: SSIM.
    pub ssim: f64,
    /// Mean of the contrast-structure term alone.
    pub contrast: f64,
}

/// Mean SSIM of two channels: 11 x 11 Gaussian window with sigma 1.5, population covariance, data
/// range 1, over the windows that lie inside the image.
///
/// An axis shorter than 11 pixels has no such window: there the image is
/// mirrored at its border and every pixel counts.
pub fn ssim(reference: &[f32], test: &[f32], size: Size) -> f64 {
    window_means(ChannelPair {
        reference,
        test,
        width: size.width,
        height: size.height,
    })
    .ssim
}

pub(super) fn window_means(pair: ChannelPair) -> WindowMeans {
    let rows = inside(pair.height);
    let columns = inside(pair.width).len();
    let kernel = gaussian();
    let partial: Vec<[f64; 2]> = strips(rows.len(), STRIP_ROWS)
        .into_par_iter()
        .map(|strip| {
            let mut sums = [0.0; 2];
            let mut work = Moments::new(pair.width, columns);
            for row in strip {
                work.gather(&pair, rows.start + row, &kernel);
                let [ssim, contrast] = work.sum_row(&kernel);
                sums[0] += ssim;
                sums[1] += contrast;
            }
            sums
        })
        .collect();
    let windows = (rows.len() * columns) as f64;
    let mean = |c: usize| partial.iter().map(|sums| sums[c]).sum::<f64>() / windows;
    WindowMeans {
        ssim: mean(0),
        contrast: mean(1),
    }
}

/// The positions along an axis whose window counts.
fn inside(length: usize) -> std::ops::Range<usize> {
    if length >= WINDOW {
        RADIUS..length - RADIUS
    } else {
        0..length
    }
}

fn gaussian() -> [f64; WINDOW] {
    let weight = |k: usize| {
        let x = k as f64 - RADIUS as f64;
        (-x * x / (2.0 * SIGMA * SIGMA)).exp()
    };
    let raw: [f64; WINDOW] = std::array::from_fn(weight);
    let sum: f64 = raw.iter().sum();
    raw.map(|value| value / sum)
}

/// An index mirrored into `0..length`, the border value repeated (d c b a | a b c d | d c b a).
fn mirror(index: isize, length: usize) -> usize {
    let folded = index.rem_euclid(2 * length as isize) as usize;
    folded.min(2 * length - 1 - folded)
}

/// Weighted moments of one row of windows: x, y, x², y², xy.
///
/// f64: variances are differences of nearly equal numbers.
struct Moments {
    vertical: [Vec<f64>; 5],
    padded: Vec<f64>,
    full: [Vec<f64>; 5],
    width: usize,
}

impl Moments {
    fn new(width: usize, columns: usize) -> Self {
        Self {
            vertical: std::array::from_fn(|_| vec![0.0; width]),
            padded: Vec::with_capacity(width + 2 * RADIUS),
            full: std::array::from_fn(|_| vec![0.0; columns]),
            width,
        }
    }

    /// Sums the rows around `row` with the kernel's weights.
    fn gather(&mut self, pair: &ChannelPair, row: usize, kernel: &[f64; WINDOW]) {
        for moment in &mut self.vertical {
            moment.fill(0.0);
        }
        let [mx, my, mxx, myy, mxy] = &mut self.vertical;
        for (k, &weight) in kernel.iter().enumerate() {
            let source = mirror((row + k) as isize - RADIUS as isize, pair.height) * self.width;
            let xs = &pair.reference[source..source + self.width];
            let ys = &pair.test[source..source + self.width];
            let first = mx.iter_mut().zip(my.iter_mut());
            let second = mxx.iter_mut().zip(myy.iter_mut()).zip(mxy.iter_mut());
            for ((&x, &y), ((mx, my), ((mxx, myy), mxy))) in
                xs.iter().zip(ys).zip(first.zip(second))
            {
                let (x, y) = (f64::from(x), f64::from(y));
                let (wx, wy) = (weight * x, weight * y);
                *mx += wx;
                *my += wy;
                *mxx += wx * x;
                *myy += wy * y;
                *mxy += wx * y;
            }
        }
    }

    /// Finishes the moments along the row and sums SSIM and contrast over its windows.
    fn sum_row(&mut self, kernel: &[f64; WINDOW]) -> [f64; 2] {
        for (vertical, full) in self.vertical.iter().zip(&mut self.full) {
            let source = if self.width >= WINDOW {
                vertical
            } else {
                let reach = -(RADIUS as isize)..(self.width + RADIUS) as isize;
                self.padded.clear();
                self.padded
                    .extend(reach.map(|i| vertical[mirror(i, self.width)]));
                &self.padded
            };
            full.fill(0.0);
            for (k, &weight) in kernel.iter().enumerate() {
                for (sum, &value) in full.iter_mut().zip(&source[k..]) {
                    *sum += weight * value;
                }
            }
        }
        let mut sums = [0.0; 2];
        let [mx, my, mxx, myy, mxy] = &self.full;
        for i in 0..mx.len() {
            let (x, y) = (mx[i], my[i]);
            let variances = (mxx[i] - x * x) + (myy[i] - y * y);
            let contrast = (2.0 * (mxy[i] - x * y) + C2) / (variances + C2);
            sums[0] += contrast * (2.0 * x * y + C1) / (x * x + y * y + C1);
            sums[1] += contrast;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn equal_channels_are_one_at_any_size() {
        for (width, height) in [(1, 1), (1, 40), (3, 2), (10, 11), (11, 10), (37, 23)] {
            let size = Size { width, height };
            let values: Vec<f32> = (0..width * height).map(|i| (i % 7) as f32 / 7.0).collect();
            assert_abs_diff_eq!(ssim(&values, &values, size), 1.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn constant_channels_follow_the_luminance_term() {
        for (width, height) in [(1, 1), (5, 30), (30, 20)] {
            let size = Size { width, height };
            let reference = vec![0.25; width * height];
            let test = vec![0.75; width * height];
            let expected = (2.0 * 0.25 * 0.75 + C1) / (0.0625 + 0.5625 + C1);
            assert_abs_diff_eq!(ssim(&reference, &test, size), expected, epsilon = 1e-9);
        }
    }

    #[test]
    fn agrees_with_the_definition_window_by_window() {
        let (w, h) = (14, 13);
        let x: Vec<f32> = (0..w * h)
            .map(|i| ((i * 37) % 101) as f32 / 101.0)
            .collect();
        let y: Vec<f32> = (0..w * h)
            .map(|i| ((i * 53 + 7) % 89) as f32 / 89.0)
            .collect();
        let g = gaussian();
        let mut sum = 0.0;
        for cy in 5..h - 5 {
            for cx in 5..w - 5 {
                let weighted = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
                    let mut total = 0.0;
                    for (j, gj) in g.iter().enumerate() {
                        for (i, gi) in g.iter().enumerate() {
                            let at = (cy + j - 5) * w + cx + i - 5;
                            total += gi * gj * f(f64::from(x[at]), f64::from(y[at]));
                        }
                    }
                    total
                };
                let (mx, my) = (weighted(&|a, _| a), weighted(&|_, b| b));
                let vx = weighted(&|a, _| (a - mx).powi(2));
                let vy = weighted(&|_, b| (b - my).powi(2));
                let cov = weighted(&|a, b| (a - mx) * (b - my));
                sum += (2.0 * mx * my + C1) * (2.0 * cov + C2)
                    / ((mx * mx + my * my + C1) * (vx + vy + C2));
            }
        }
        let expected = sum / ((w - 10) * (h - 10)) as f64;
        assert_abs_diff_eq!(ssim(&x, &y, Size::new(w, h)), expected, epsilon = 1e-12);
    }

    #[test]
    fn mirror_repeats_the_border() {
        let seen: Vec<_> = (-4..7).map(|i| mirror(i, 3)).collect();
        assert_eq!(seen, [2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 0][..].to_vec());
        assert_eq!(mirror(-5, 1), 0);
    }
}
