//! Joint bilateral upsampling (Kopf et al. 2007; Wu 2024, section 3.4): light of every r-th pixel is
//! carried to the pixels between, from neighbours alike in normal, depth and albedo.
//!
//! The published formula is 0/0 where no neighbour is alike. There the most similar ones are taken as long
//! as they differ by less than the pixel's own light would be noisy, which falls with the shadow rays of a
//! pixel, and the rest are shaded themselves.

use glam::Vec3;
use rayon::prelude::*;

use super::super::Shot;
use crate::shade::Interaction;
use crate::shade::bsdf::Model;

/// σ of normal, depth (share of the visible range) and albedo.
const FEATURE_SIGMA: f32 = 0.005;
/// σ of the distance in grid pixels, and half the side of the 5×5 window.
const SPATIAL_SIGMA: f32 = 1.0;
const REACH: isize = 2;

/// Every r-th row and column of an image, from an offset.
pub(super) struct Grid {
    step: usize,
    offset: [usize; 2],
    /// Grid pixels across and down.
    size: [usize; 2],
    image_width: usize,
}

impl Grid {
    /// Sub-pixel samples start at different offsets.
    pub fn new(shot: &Shot, step: usize, sample: u32) -> Self {
        let [width, height] = [shot.width, shot.height];
        let sample = sample as usize;
        let offset = [
            (sample % step).min(width - 1),
            (sample / step % step).min(height - 1),
        ];
        Self {
            step,
            offset,
            size: [
                (width - offset[0]).div_ceil(step),
                (height - offset[1]).div_ceil(step),
            ],
            image_width: width,
        }
    }

    /// Column and row in the grid of an image pixel that lies on it.
    pub fn position(&self, x: usize, y: usize) -> Option<[usize; 2]> {
        let along = |value: usize, axis: usize| {
            let distance = value.checked_sub(self.offset[axis])?;
            distance
                .is_multiple_of(self.step)
                .then_some(distance / self.step)
        };
        Some([along(x, 0)?, along(y, 1)?])
    }

    /// Image pixels of the grid, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = u32> {
        let [columns, rows] = self.size;
        (0..columns * rows).map(move |i| self.pixel(i % columns, i / columns))
    }

    fn pixel(&self, column: usize, row: usize) -> u32 {
        let x = self.offset[0] + column * self.step;
        let y = self.offset[1] + row * self.step;
        (y * self.image_width + x) as u32
    }

    /// Fractional grid coordinates of an image pixel.
    fn coordinates(&self, x: usize, y: usize) -> [f32; 2] {
        let along = |value: usize, axis: usize| {
            (value as f32 - self.offset[axis] as f32) / self.step as f32
        };
        [along(x, 0), along(y, 1)]
    }
}

/// What neighbours are compared by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feature {
    normal: Vec3,
    /// Distance from the camera, scene units.
    depth: f32,
    albedo: Vec3,
}

impl Feature {
    pub fn new(at: &Interaction, depth: f32) -> Self {
        let normal = if at.shading_normal.dot(at.view) < 0.0 {
            -at.shading_normal
        } else {
            at.shading_normal
        };
        let albedo = match &at.bsdf.model {
            Model::Diffuse(diffuse) => diffuse.reflectance,
            Model::Plastic(plastic) => plastic.diffuse,
            Model::Mirror(metal) | Model::RoughConductor(metal, _) => metal.specular,
            Model::Dielectric(glass) => glass.transmittance,
        };
        Self {
            normal,
            depth,
            albedo,
        }
    }

    /// Squared distance in units of σ; depths are divided by `range`.
    fn distance2(&self, other: &Self, range: f32) -> f32 {
        let depth = (self.depth - other.depth) / range;
        let sum = (self.normal - other.normal).length_squared()
            + depth * depth
            + (self.albedo - other.albedo).length_squared();
        sum / (FEATURE_SIGMA * FEATURE_SIGMA)
    }
}

/// A sum of weights below e to this power is 0 in single precision.
const UNDERFLOW: f32 = -103.0;
/// How far a neighbour may be that light is carried from beyond that: the squared distance of features, in
/// σ, times shadow rays of a pixel to the power of 3/2, by which the squared errors of light sets fall.
const FARTHEST: f32 = 96_000.0;

/// Carries `low` (of the grid's pixels) to all pixels; `None` at pixels without a surface, and at
/// those without a neighbour that is alike enough for this number of shadow rays a pixel. Weights are
/// relative to the largest one of the window, so that their sum is never 0.
pub(super) fn upsample(
    grid: &Grid,
    features: &[Option<Feature>],
    low: &[Vec3],
    rays: usize,
) -> Vec<Option<Vec3>> {
    let rays = rays.max(1) as f32;
    let least = (-0.5 * FARTHEST / (rays * rays.sqrt())).min(UNDERFLOW);
    let range = depth_range(features);
    let width = grid.image_width;
    features
        .par_iter()
        .enumerate()
        .map(|(pixel, own)| {
            let own = own.as_ref()?;
            let [column, row] = grid.coordinates(pixel % width, pixel / width);
            let window = window(grid, [column, row]);
            let weights = window.filter_map(|[c, r]| {
                let other = features[grid.pixel(c, r) as usize].as_ref()?;
                let (dx, dy) = (c as f32 - column, r as f32 - row);
                let spatial = (dx * dx + dy * dy) / (SPATIAL_SIGMA * SPATIAL_SIGMA);
                let log_weight = -0.5 * (spatial + own.distance2(other, range));
                Some((log_weight, low[r * grid.size[0] + c]))
            });
            let (mean, largest) = weighted_mean(weights)?;
            (largest > least).then_some(mean)
        })
        .collect()
}

/// Grid positions within reach of the one nearest to fractional coordinates.
fn window(grid: &Grid, [column, row]: [f32; 2]) -> impl Iterator<Item = [usize; 2]> {
    let [columns, rows] = grid.size;
    let around = |centre: f32, count: usize| {
        let centre = centre.round() as isize;
        let first = (centre - REACH).max(0) as usize;
        let end = (centre + REACH + 1).clamp(0, count as isize) as usize;
        first..end
    };
    let (columns, rows) = (around(column, columns), around(row, rows));
    rows.flat_map(move |r| columns.clone().map(move |c| [c, r]))
}

/// Mean under weights given by their logarithms, and the largest of these; `None` without values.
fn weighted_mean(values: impl Iterator<Item = (f32, Vec3)>) -> Option<(Vec3, f32)> {
    let (mut largest, mut sum, mut total) = (f32::NEG_INFINITY, Vec3::ZERO, 0.0f32);
    for (log, value) in values {
        if log > largest {
            let shrink = (largest - log).exp();
            sum *= shrink;
            total *= shrink;
            largest = log;
        }
        let weight = (log - largest).exp();
        sum += value * weight;
        total += weight;
    }
    (total > 0.0).then(|| (sum / total, largest))
}

/// From the nearest to the farthest surface; never 0.
fn depth_range(features: &[Option<Feature>]) -> f32 {
    let (low, high) = features
        .iter()
        .flatten()
        .fold((f32::INFINITY, 0.0f32), |(low, high), f| {
            (low.min(f.depth), high.max(f.depth))
        });
    (high - low).max(1e-6 * high).max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_do_not_underflow() {
        let values = [(-1e6, Vec3::X), (-1e6 - 0.5, Vec3::Y)];
        let (mean, largest) = weighted_mean(values.into_iter()).expect("values");
        assert_eq!(largest, -1e6);
        assert!((mean.x + mean.y - 1.0).abs() < 1e-6 && mean.x > mean.y);
        let reversed = weighted_mean(values.into_iter().rev()).expect("values");
        assert!((reversed.0 - mean).length() < 1e-6);
        assert!(weighted_mean(std::iter::empty()).is_none());
    }

    fn feature(normal: Vec3, depth: f32) -> Option<Feature> {
        Some(Feature {
            normal,
            depth,
            albedo: Vec3::splat(0.5),
        })
    }

    fn grid(size: [usize; 2], step: usize, offset: [usize; 2]) -> Grid {
        Grid {
            step,
            offset,
            size: [
                (size[0] - offset[0]).div_ceil(step),
                (size[1] - offset[1]).div_ceil(step),
            ],
            image_width: size[0],
        }
    }

    #[test]
    fn grids_visit_every_second_pixel_of_any_size() {
        for size in [[1, 1], [5, 4], [8, 3]] {
            for offset in [[0, 0], [1, 1]] {
                let offset = [offset[0].min(size[0] - 1), offset[1].min(size[1] - 1)];
                let grid = grid(size, 2, offset);
                for (index, pixel) in grid.pixels().enumerate() {
                    let (x, y) = (pixel as usize % size[0], pixel as usize / size[0]);
                    let [c, r] = grid.position(x, y).expect("on the grid");
                    assert_eq!(r * grid.size[0] + c, index);
                    assert_eq!(grid.coordinates(x, y), [c as f32, r as f32]);
                }
            }
        }
    }

    #[test]
    fn a_window_covers_five_by_five_inside_and_less_at_the_border() {
        let grid = grid([40, 40], 2, [0, 0]);
        assert_eq!(window(&grid, [9.5, 7.0]).count(), 25);
        assert_eq!(window(&grid, [0.0, 0.0]).count(), 9);
        assert_eq!(window(&grid, [19.5, 19.5]).count(), 4);
    }

    #[test]
    fn neighbours_are_taken_while_they_differ_less_than_few_rays_are_noisy() {
        let grid = grid([3, 1], 2, [0, 0]);
        let tilted = Vec3::new(0.15, 0.0, 1.0).normalize();
        let low = [Vec3::ONE, Vec3::splat(3.0)];
        let carried = |middle: Vec3, rays| {
            let features = [
                feature(Vec3::Z, 1.0),
                feature(middle, 1.0),
                feature(Vec3::Z, 1.0),
            ];
            upsample(&grid, &features, &low, rays)[1]
        };
        // Thirty σ away: too far for many rays.
        assert_eq!(carried(tilted, 8), Some(Vec3::splat(2.0)));
        assert_eq!(carried(tilted, 64), None);
        assert_eq!(carried(Vec3::Z, 1 << 20), Some(Vec3::splat(2.0)));
        // The background has nothing to carry.
        let features = [None, feature(Vec3::Z, 1.0), None];
        assert_eq!(upsample(&grid, &features, &low, 8), [None, None, None]);
    }

    #[test]
    fn depths_have_a_range_even_when_equal() {
        assert!(depth_range(&[feature(Vec3::Z, 2.0), None]) > 0.0);
        assert!(depth_range(&[None]) > 0.0);
    }
}
