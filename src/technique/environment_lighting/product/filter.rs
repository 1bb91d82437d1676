//! The ratio of shadowed to unshadowed light, filtered over alike neighbours.

use glam::Vec3;
use rayon::prelude::*;

use super::film::{
    BLOCK, Film, GROUPS, HAS_OWN, NEARNESS, NORMAL, NOTHING, OBJECT, OWN, POSITION, SHADOWED,
    UNSHADOWED,
};
use crate::environment::product_ratio::ProductRatio;
use crate::image::luminance;

/// A number of each pixel of a block.
type Lane = [f32; BLOCK];

/// Weighted sums of a group over the window.
#[derive(Clone, Copy)]
struct Sums {
    shadowed: [Lane; 3],
    unshadowed: [Lane; 3],
    /// Σ w, Σ w ratio, Σ w ratio² over the pixels that have an own ratio.
    moments: [Lane; 3],
}

const EMPTY: Sums = Sums {
    shadowed: [[0.0; BLOCK]; 3],
    unshadowed: [[0.0; BLOCK]; 3],
    moments: [[0.0; BLOCK]; 3],
};

/// Adds the light of every pixel to `sums`; returns the number of values that are not finite, which
/// are left out.
pub(super) fn resolve(
    film: &Film,
    parameters: &ProductRatio,
    rays: usize,
    sums: &mut [Vec3],
) -> u64 {
    let width = film.size[0];
    let filter = Filter::new(film, parameters, rays);
    sums.par_chunks_mut(width)
        .enumerate()
        .map(|(y, row)| {
            let mut non_finite = 0;
            for x in (0..width).step_by(BLOCK) {
                let count = BLOCK.min(width - x);
                let values = filter.block([x, y], count);
                for (sum, value) in row[x..].iter_mut().zip(&values[..count]) {
                    if value.is_finite() {
                        *sum += *value;
                    } else {
                        non_finite += 1;
                    }
                }
            }
            non_finite
        })
        .sum()
}

struct Filter<'a> {
    film: &'a Film,
    parameters: &'a ProductRatio,
    rays: usize,
    /// Gaussian weights by distance from the centre, for both groups; 0 beyond the reach.
    gaussians: [Vec<f32>; 2],
}

impl<'a> Filter<'a> {
    fn new(film: &'a Film, parameters: &'a ProductRatio, rays: usize) -> Self {
        let gaussian = |reach: usize, sigma: f32| -> Vec<f32> {
            (0..=film.margin)
                .map(|d| match d <= reach {
                    true => (-0.5 * (d as f32 / sigma).powi(2)).exp(),
                    false => 0.0,
                })
                .collect()
        };
        Self {
            film,
            parameters,
            rays,
            gaussians: [
                gaussian(parameters.direct_reach, parameters.direct_sigma),
                gaussian(parameters.indirect_reach, parameters.indirect_sigma),
            ],
        }
    }

    /// Light of `count` pixels from (x, y) on.
    fn block(&self, [x, y]: [usize; 2], count: usize) -> [Vec3; BLOCK] {
        let film = self.film;
        let at = y * film.size[0] + x;
        let pixels = &film.pixels[at..at + count];
        let mut values = [Vec3::ZERO; BLOCK];
        let objects = lane(film.plane(y, OBJECT), x + film.margin);
        if objects[..count].iter().all(|&o| o == NOTHING) {
            for (value, pixel) in values.iter_mut().zip(pixels) {
                *value = pixel.plain;
            }
            return values;
        }
        let sums = self.gather([x, y]);
        for (i, (value, pixel)) in values.iter_mut().zip(pixels).enumerate() {
            *value = pixel.plain;
            if objects[i] == NOTHING {
                continue;
            }
            let luminances = pixel.unshadowed.map(|u| luminance(u.into()));
            let all = luminances[0] + luminances[1];
            let mut lit = Vec3::ZERO;
            for group in 0..2 {
                if luminances[group] > 0.0 {
                    let rays = self.rays as f32 * luminances[group] / all;
                    let ratio = self.ratio(&sums[group], group, [x, y], i, rays);
                    lit += pixel.unshadowed[group] * ratio;
                }
            }
            *value += pixel.throughput * lit;
        }
        values
    }

    /// Sums over the windows of a block.
    fn gather(&self, [x, y]: [usize; 2]) -> [Sums; 2] {
        let film = self.film;
        let mut sums = [EMPTY; 2];
        let centre = film.margin + x;
        let own = Features::new(film, y, centre);
        let reach = film.margin as isize;
        let tolerance = 1.0 / self.parameters.normal_tolerance;
        for dy in -reach..=reach {
            let Some(row) = y.checked_add_signed(dy).filter(|r| *r < film.size[1]) else {
                continue;
            };
            let vertical = self.gaussians.each_ref().map(|g| g[dy.unsigned_abs()]);
            for dx in -reach..=reach {
                let from = centre.wrapping_add_signed(dx);
                let alike = own.alike(&Features::new(film, row, from), tolerance);
                for group in 0..2 {
                    let gaussian = vertical[group] * self.gaussians[group][dx.unsigned_abs()];
                    if gaussian > 0.0 {
                        let weights = alike.map(|w| w * gaussian);
                        sums[group].add(&weights, film, row, GROUPS[group], from);
                    }
                }
            }
        }
        sums
    }

    /// The ratio of a pixel: the filtered one, or part of its own where the window holds an edge.
    fn ratio(&self, sums: &Sums, group: usize, [x, y]: [usize; 2], i: usize, rays: f32) -> Vec3 {
        let plane = |k: usize| self.film.plane(y, GROUPS[group] + k)[self.film.margin + x + i];
        let all = [0, 1, 2].map(|c| sums.unshadowed[c][i]);
        let [weight, first, second] = [0, 1, 2].map(|k| sums.moments[k][i]);
        if weight <= 0.0 {
            // No ray of the window fell into the group.
            return Vec3::ONE;
        }
        let mean = first / weight;
        let ratio = |c: usize| match all[c] > 0.0 {
            true => sums.shadowed[c][i] / all[c],
            false => mean,
        };
        let filtered = Vec3::from([0, 1, 2].map(ratio));
        let expected = [self.parameters.direct_noise, self.parameters.indirect_noise][group];
        let variance = second / weight - mean * mean;
        if variance <= 1e-6 || plane(HAS_OWN) == 0.0 {
            return filtered;
        }
        let noise = expected * mean * (1.0 - mean) / rays;
        let kept = (1.0 - noise / variance).max(0.0);
        let own = Vec3::from([0, 1, 2].map(|c| match plane(UNSHADOWED + c) > 0.0 {
            true => plane(SHADOWED + c) / plane(UNSHADOWED + c),
            false => plane(OWN),
        }));
        filtered + kept * (own - filtered)
    }
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, weights: &Lane, film: &Film, row: usize, first: usize, from: usize) {
        let add = |sum: &mut Lane, values: &Lane| {
            for i in 0..BLOCK {
                sum[i] += weights[i] * values[i];
            }
        };
        for c in 0..3 {
            add(
                &mut self.shadowed[c],
                lane(film.plane(row, first + SHADOWED + c), from),
            );
            add(
                &mut self.unshadowed[c],
                lane(film.plane(row, first + UNSHADOWED + c), from),
            );
        }
        let own = lane(film.plane(row, first + OWN), from);
        let has = lane(film.plane(row, first + HAS_OWN), from);
        let [count, sum, square] = &mut self.moments;
        for i in 0..BLOCK {
            let weight = weights[i] * has[i];
            count[i] += weight;
            sum[i] += weight * own[i];
            square[i] += weight * own[i] * own[i];
        }
    }
}

/// What pixels are compared by.
struct Features<'a> {
    object: &'a Lane,
    normal: [&'a Lane; 3],
    position: [&'a Lane; 3],
    nearness: &'a Lane,
}

impl<'a> Features<'a> {
    #[inline(always)]
    fn new(film: &'a Film, row: usize, from: usize) -> Self {
        let plane = |k: usize| lane(film.plane(row, k), from);
        Self {
            object: plane(OBJECT),
            normal: [0, 1, 2].map(|a| plane(NORMAL + a)),
            position: [0, 1, 2].map(|a| plane(POSITION + a)),
            nearness: plane(NEARNESS),
        }
    }

    /// Weights of other pixels, 0 for other objects.
    #[inline(always)]
    fn alike(&self, other: &Self, tolerance: f32) -> Lane {
        std::array::from_fn(|i| {
            let [mut cos, mut off] = [0.0f32; 2];
            for a in 0..3 {
                cos += self.normal[a][i] * other.normal[a][i];
                off += self.normal[a][i] * (other.position[a][i] - self.position[a][i]);
            }
            let off = off * self.nearness[i];
            let x = (1.0 - cos).max(0.0) * tolerance + off * off;
            let same = if self.object[i] == other.object[i] {
                1.0
            } else {
                0.0
            };
            same * fall_off(x)
        })
    }
}

/// (1 − x/16)¹⁶, close to e⁻ˣ; 0 from 16 on.
#[inline(always)]
fn fall_off(x: f32) -> f32 {
    let base = (1.0 - x * (1.0 / 16.0)).max(0.0);
    let square = base * base;
    let fourth = square * square;
    let eighth = fourth * fourth;
    eighth * eighth
}

/// A block's numbers of a plane.
#[inline(always)]
fn lane(plane: &[f32], from: usize) -> &Lane {
    plane[from..].first_chunk().unwrap_or(&[0.0; BLOCK])
}
