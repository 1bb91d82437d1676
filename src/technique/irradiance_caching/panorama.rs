//! What records know of the light in single directions, for the gloss of surfaces near them.
//!
//! A record's directions are pooled into square blocks, each with its mean radiance and the nearness `1/t` of what
//! its rays met, weighted by the light that came from there. What the brightest path of a block brings beyond the
//! next one is spread over all blocks: it says little of its own direction, and would be a spot in every
//! reflection. At a distance from the record what lies in a direction is looked up where the record sees it, by
//! one step of a fixed point: `ω' ∝ ω + Δp / t(ω)`. Where the step Δp is no longer small beside `t` the record's mean
//! radiance takes over: `1 / (1 + (Δp/t)⁴)` of the block remains.

use std::ops::Range;

use glam::{Vec3, Vec4};

use crate::image::luminance;
use crate::sample::{Frame as LocalFrame, hemisphere_to_square};

/// Blocks along a side of the grid.
const BLOCKS: usize = 16;
/// Directions that a block needs for its brightest one to be judged.
const ENOUGH: usize = 8;

/// Blocks of all records of a job.
pub struct Panoramas {
    /// Directions of a side of a record's grid.
    side: usize,
    /// Directions along a side of a block.
    block: usize,
    /// Row by row and record by record: radiance, and nearness per scene unit.
    blocks: Vec<Vec4>,
    shots: Vec<LocalFrame>,
    /// Blocks nearer than 10⁻⁴ of the scene's diagonal count as that near.
    nearest: f32,
}

impl Panoramas {
    /// No records yet; they will have `side²` directions.
    pub fn new(side: usize, diagonal: f32) -> Self {
        Self {
            side,
            block: side.div_ceil(BLOCKS).max(1),
            blocks: Vec::new(),
            shots: Vec::new(),
            nearest: 1e4 / diagonal,
        }
    }

    /// Blocks along a side.
    pub fn width(&self) -> usize {
        self.side.div_ceil(self.block)
    }

    /// The blocks of a record whose directions bring this radiance and distance (infinite where nothing
    /// is hit). Their radiance sums to that of the directions.
    pub fn pool(&self, seen: &[(Vec3, f32)]) -> Vec<Vec4> {
        let width = self.width();
        let mut spread = Vec3::ZERO;
        let mut blocks: Vec<Vec4> = (0..width * width)
            .map(|at| {
                let (columns, rows) = (self.span(at % width), self.span(at / width));
                let count = columns.len() * rows.len();
                let (mut sum, mut near) = (Vec3::ZERO, Near::default());
                let mut brightest = [(0.0, Vec3::ZERO); 2];
                for &(radiance, distance) in
                    rows.flat_map(|row| &seen[row * self.side..][columns.clone()])
                {
                    let own = luminance(radiance.into());
                    sum += radiance;
                    near.add(own, (1.0 / distance).min(self.nearest));
                    if own > brightest[0].0 {
                        brightest = [(own, radiance), brightest[0]];
                    } else if own > brightest[1].0 {
                        brightest[1] = (own, radiance);
                    }
                }
                let [(first, radiance), (second, _)] = brightest;
                if count >= ENOUGH && first > second {
                    let beyond = radiance * (1.0 - second / first);
                    sum -= beyond;
                    spread += beyond;
                }
                (sum / count as f32).extend(near.mean(count))
            })
            .collect();
        let spread = (spread / seen.len() as f32).extend(0.0);
        for block in &mut blocks {
            *block += spread;
        }
        blocks
    }

    /// The columns (or rows) of directions in a column of blocks.
    fn span(&self, at: usize) -> Range<usize> {
        at * self.block..((at + 1) * self.block).min(self.side)
    }

    /// Room for so many more records, and not for others.
    pub fn make_room(&mut self, count: usize) {
        self.blocks.reserve_exact(count * self.width().pow(2));
        self.shots.reserve_exact(count);
    }

    /// Appends a record with this unit normal.
    pub fn add(&mut self, normal: Vec3, blocks: &[Vec4]) {
        self.blocks.extend_from_slice(blocks);
        self.shots.push(LocalFrame::from_normal(normal));
    }

    /// Radiance that a record of this mean radiance knows of in a unit direction, `step` away from it.
    /// Directions below its horizon count as on it.
    pub fn radiance(&self, record: u32, step: Vec3, direction: Vec3, mean: Vec3) -> Vec3 {
        let near = self.lookup(record, direction).w;
        let towards = direction + (step * near).clamp_length_max(1.0);
        let there = self.lookup(record, towards.try_normalize().unwrap_or(direction));
        let parallax = (step * near.max(there.w)).length();
        mean.lerp(there.truncate(), 1.0 / (1.0 + parallax.powi(4)))
    }

    /// Bilinear between the blocks' centres.
    fn lookup(&self, record: u32, direction: Vec3) -> Vec4 {
        let width = self.width();
        let blocks = &self.blocks[record as usize * width * width..][..width * width];
        let local = self.shots[record as usize].to_local(direction);
        let [x, y] = hemisphere_to_square(local).map(|u| {
            let at = (u * width as f32 - 0.5).clamp(0.0, (width - 1) as f32);
            let low = (at as usize).min(width.saturating_sub(2));
            (low, (low + 1).min(width - 1), at - low as f32)
        });
        let row = |y: usize| blocks[y * width + x.0].lerp(blocks[y * width + x.1], x.2);
        row(y.0).lerp(row(y.1), y.2)
    }

    /// Bytes of a record with `side²` directions.
    pub fn bytes_per_record(side: usize) -> u64 {
        let width = Self::new(side, 1.0).width();
        (size_of::<Vec4>() * width * width + size_of::<LocalFrame>()) as u64
    }
}

/// Nearness of the directions of a block.
#[derive(Default)]
struct Near {
    /// Σ luminance · nearness, Σ luminance, Σ nearness.
    lit: f32,
    light: f32,
    all: f32,
}

impl Near {
    fn add(&mut self, luminance: f32, nearness: f32) {
        self.lit += luminance * nearness;
        self.light += luminance;
        self.all += nearness;
    }

    /// Weighted by the luminance; without light the plain mean of `count` directions.
    fn mean(&self, count: usize) -> f32 {
        match self.light > 0.0 {
            true => self.lit / self.light,
            false => self.all / count as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::equal_area_hemisphere;

    /// A record at the origin that looks up into a scene given by direction.
    fn record(side: usize, scene: impl Fn(Vec3) -> (Vec3, f32)) -> Panoramas {
        let mut panoramas = Panoramas::new(side, 10.0);
        let seen: Vec<_> = equal_area_hemisphere(side).into_iter().map(scene).collect();
        let blocks = panoramas.pool(&seen);
        panoramas.add(Vec3::Z, &blocks);
        panoramas
    }

    /// A ceiling at this height, whose radiance is its own x and y.
    fn ceiling(height: f32) -> impl Fn(Vec3) -> (Vec3, f32) {
        move |d| {
            let t = height / d.z.max(1e-3);
            ((d * t).truncate().extend(0.0) + 5.0, t)
        }
    }

    #[test]
    fn even_light_is_the_same_in_every_direction_and_place_whatever_the_side() {
        for side in [1, 2, 5, 16, 33, 64] {
            let known = record(side, |_| (Vec3::new(1.0, 2.0, 3.0), 2.0));
            for direction in [Vec3::Z, Vec3::X, -Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
                for step in [Vec3::ZERO, Vec3::X, Vec3::splat(1e9)] {
                    let radiance = known.radiance(0, step, direction, Vec3::new(1.0, 2.0, 3.0));
                    let error = (radiance - Vec3::new(1.0, 2.0, 3.0)).abs().max_element();
                    assert!(error < 1e-5, "{side} {direction} {step}: {radiance}");
                }
            }
        }
    }

    #[test]
    fn what_a_ray_meets_is_looked_up_where_the_record_sees_it() {
        let (height, direction) = (2.0, Vec3::new(0.28, 0.0, 0.96));
        let known = record(64, ceiling(height));
        let step = Vec3::new(0.5, -0.25, 0.0);
        let met = step + direction * (height / direction.z);
        let expected = Vec3::new(met.x + 5.0, met.y + 5.0, 5.0);
        let found = known.radiance(0, step, direction, Vec3::ZERO);
        assert!(
            (found - expected).abs().max_element() < 0.06,
            "{found} {expected}"
        );
        let unmoved = known.radiance(0, Vec3::ZERO, direction, Vec3::ZERO);
        assert!(
            (unmoved - expected).abs().max_element() > 0.2,
            "{unmoved} {expected}"
        );
    }

    #[test]
    fn far_from_a_record_its_mean_takes_over() {
        let known = record(32, |_| (Vec3::splat(4.0), 0.5));
        let at = |step: f32| known.radiance(0, Vec3::X * step, Vec3::Z, Vec3::ONE).x;
        assert!(at(0.1) > 3.99, "{}", at(0.1));
        assert!((at(0.5) - 2.5).abs() < 1e-3, "{}", at(0.5));
        assert!(at(5.0) < 1.01, "{}", at(5.0));
    }

    #[test]
    fn one_bright_path_is_spread_and_a_bright_patch_is_not() {
        let bright =
            |i: usize, lit: bool| (Vec3::splat(if lit { 100.0 } else { 1.0 }), 1.0 + i as f32);
        let panoramas = Panoramas::new(64, 10.0);
        let mean = |seen: &[(Vec3, f32)]| {
            let blocks = panoramas.pool(seen);
            let sum: Vec4 = blocks.iter().sum();
            let directions: Vec3 = seen.iter().map(|s| s.0).sum();
            let error = sum.truncate() / 256.0 - directions / 4096.0;
            assert!(error.abs().max_element() < 1e-5, "{error}");
            blocks.iter().map(|b| b.x).fold(0.0, f32::max)
        };
        let one: Vec<_> = (0..4096).map(|i| bright(i, i == 1234)).collect();
        assert!(mean(&one) < 1.1);
        // Four directions of one block.
        let patch: Vec<_> = (0..4096)
            .map(|i| bright(i, i / 64 == 9 && i % 64 / 4 == 5))
            .collect();
        assert!(mean(&patch) > 20.0);
    }

    #[test]
    fn coincident_hits_and_the_open_stay_finite() {
        for distance in [0.0, 1e-30, f32::INFINITY] {
            let known = record(16, |d| (Vec3::splat(d.x.max(0.0) * 1e6), distance));
            for step in [Vec3::ZERO, Vec3::splat(1e3), Vec3::new(0.0, 0.0, -1e20)] {
                let radiance = known.radiance(0, step, Vec3::Z, Vec3::ONE);
                assert!(radiance.is_finite(), "{distance} {step}: {radiance}");
            }
        }
    }
}
