//! The per-pixel FLIP error of two images in linear RGB (METHODS 9.3).

use super::color::{ColorDifference, opponent};
use super::kernel::Kernels;
use crate::image::{Plane, Size};
use crate::metric::convolve::{replicate_ends, strips, weighted_sum};
use rayon::prelude::*;

/// Output rows per task: the halo of the filters is recomputed for each.
const STRIP_ROWS: usize = 64;

/// An image in FLIP's opponent space, one plane per channel.
pub(super) struct Opponent {
    width: usize,
    height: usize,
    planes: [Vec<f32>; 3],
}

impl Opponent {
    /// Converts linear RGB in `[0, 1]`, `color(i)` being pixel `i`.
    pub(super) fn new(size: Size, color: impl Fn(usize) -> [f32; 3] + Sync) -> Self {
        let Size { width, height } = size;
        let [mut ys, mut cxs, mut czs] = std::array::from_fn(|_| vec![0.0; width * height]);
        let rows = ys.par_chunks_mut(width).zip(cxs.par_chunks_mut(width));
        let rows = rows.zip(czs.par_chunks_mut(width)).enumerate();
        rows.for_each(|(row, ((ys, cxs), czs))| {
            let pixels = ys.iter_mut().zip(cxs).zip(czs).enumerate();
            for (column, ((y, cx), cz)) in pixels {
                [*y, *cx, *cz] = opponent(color(row * width + column));
            }
        });
        Self {
            width,
            height,
            planes: [ys, cxs, czs],
        }
    }

    fn row(&self, channel: usize, row: usize) -> &[f32] {
        &self.planes[channel][row * self.width..][..self.width]
    }
}

/// The FLIP error of every pixel, in `[0, 1]`. Both images must have one size.
pub(super) fn flip_map(reference: &Opponent, test: &Opponent, kernels: &Kernels) -> Plane {
    let (width, height) = (reference.width, reference.height);
    let mut map = Plane::new(width, height);
    let difference = ColorDifference::new();
    map.values
        .par_chunks_mut(width * STRIP_ROWS)
        .zip(strips(height, STRIP_ROWS))
        .for_each(|(out, rows)| {
            let reference = Strip::new(reference, rows.clone(), kernels);
            let test = Strip::new(test, rows.clone(), kernels);
            let mut rows_work = [FilteredRow::new(width), FilteredRow::new(width)];
            for (row, out) in rows.zip(out.chunks_mut(width)) {
                reference.finish_row(row, kernels, &mut rows_work[0]);
                test.finish_row(row, kernels, &mut rows_work[1]);
                let [a, b] = &rows_work;
                for (x, error) in out.iter_mut().enumerate() {
                    let color = difference.of(a.color(x), b.color(x));
                    *error = combine(color, a.features(x), b.features(x));
                }
            }
        });
    map
}

/// Raises the colour error by the difference of edge and point responses (steps 5 and 6).
fn combine(color: f32, reference: [f32; 2], test: [f32; 2]) -> f32 {
    let edge = (reference[0] - test[0]).abs();
    let point = (reference[1] - test[1]).abs();
    let feature = (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).sqrt();
    color.powf(1.0 - feature).min(1.0)
}

/// The horizontally filtered rows that a strip of output rows needs.
struct Strip {
    width: usize,
    /// First image row that is held.
    first: usize,
    last: usize,
    /// Contrast sensitivity: achromatic, red-green, blue-yellow twice.
    sensitivity: [Vec<f32>; 4],
    /// Gaussian, edge and point responses.
    features: [Vec<f32>; 3],
}

impl Strip {
    fn new(image: &Opponent, rows: std::ops::Range<usize>, kernels: &Kernels) -> Self {
        let halo = kernels.sensitivity_radius().max(kernels.feature_radius());
        let first = rows.start.saturating_sub(halo);
        let last = (rows.end - 1 + halo).min(image.height - 1);
        let size = (last + 1 - first) * image.width;
        let mut strip = Self {
            width: image.width,
            first,
            last,
            sensitivity: std::array::from_fn(|_| vec![0.0; size]),
            features: std::array::from_fn(|_| vec![0.0; size]),
        };
        for row in first..=last {
            strip.filter_row(image, row, kernels);
        }
        strip
    }

    fn filter_row(&mut self, image: &Opponent, row: usize, kernels: &Kernels) {
        let mut padded = Vec::with_capacity(2 * self.width);
        let halo = kernels.sensitivity_radius().max(kernels.feature_radius());
        let starts: Vec<usize> = (0..=2 * halo).collect();
        let place = (row - self.first) * self.width..(row + 1 - self.first) * self.width;
        let [blue_yellow_0, blue_yellow_1] = &kernels.blue_yellow;
        let jobs = [
            (0, &kernels.achromatic),
            (1, &kernels.red_green),
            (2, blue_yellow_0),
            (2, blue_yellow_1),
        ];
        for ((channel, kernel), out) in jobs.into_iter().zip(&mut self.sensitivity) {
            replicate_ends(image.row(channel, row), kernel.len() / 2, &mut padded);
            weighted_sum(&padded, &starts, kernel, &mut out[place.clone()]);
        }
        replicate_ends(image.row(0, row), kernels.feature_radius(), &mut padded);
        for value in &mut padded {
            *value = *value * (1.0 / 116.0) + 16.0 / 116.0;
        }
        let detectors = [&kernels.gaussian, &kernels.edge, &kernels.point];
        for (kernel, out) in detectors.into_iter().zip(&mut self.features) {
            weighted_sum(&padded, &starts, kernel, &mut out[place.clone()]);
        }
    }

    /// Filters vertically around one output row.
    fn finish_row(&self, row: usize, kernels: &Kernels, out: &mut FilteredRow) {
        let starts = |radius: usize| -> Vec<usize> {
            let rows = (0..=2 * radius).map(|k| (row + k).saturating_sub(radius));
            let held = rows.map(|wanted| wanted.clamp(self.first, self.last) - self.first);
            held.map(|row| row * self.width).collect()
        };
        let around = starts(kernels.sensitivity_radius());
        let [achromatic, red_green, wide, narrow] = &self.sensitivity;
        let [wide_kernel, narrow_kernel] = &kernels.blue_yellow;
        let [ys, cxs, czs] = &mut out.channels;
        weighted_sum(achromatic, &around, &kernels.achromatic, ys);
        weighted_sum(red_green, &around, &kernels.red_green, cxs);
        weighted_sum(wide, &around, wide_kernel, czs);
        weighted_sum(narrow, &around, narrow_kernel, &mut out.narrow);
        for (sum, narrow) in out.channels[2].iter_mut().zip(&out.narrow) {
            *sum += narrow;
        }
        let around = starts(kernels.feature_radius());
        let [smooth, edge, point] = &self.features;
        let Kernels {
            gaussian,
            edge: edge_kernel,
            point: point_kernel,
            ..
        } = kernels;
        weighted_sum(edge, &around, gaussian, &mut out.edge[0]);
        weighted_sum(smooth, &around, edge_kernel, &mut out.edge[1]);
        weighted_sum(point, &around, gaussian, &mut out.point[0]);
        weighted_sum(smooth, &around, point_kernel, &mut out.point[1]);
    }
}

/// One row of the fully filtered image.
struct FilteredRow {
    channels: [Vec<f32>; 3],
    narrow: Vec<f32>,
    /// Responses along x and y.
    edge: [Vec<f32>; 2],
    point: [Vec<f32>; 2],
}

impl FilteredRow {
    fn new(width: usize) -> Self {
        let row = || vec![0.0; width];
        Self {
            channels: [row(), row(), row()],
            narrow: row(),
            edge: [row(), row()],
            point: [row(), row()],
        }
    }

    fn color(&self, x: usize) -> [f32; 3] {
        std::array::from_fn(|c| self.channels[c][x])
    }

    /// Magnitudes of the edge and point responses.
    fn features(&self, x: usize) -> [f32; 2] {
        let norm = |[dx, dy]: &[Vec<f32>; 2]| (dx[x] * dx[x] + dy[x] * dy[x]).sqrt();
        [norm(&self.edge), norm(&self.point)]
    }
}
