//! How irradiance changes around a record, from the paths it was gathered with.

use std::f32::consts::TAU;

use glam::{Mat3, Vec3};

use crate::sample::{Frame as LocalFrame, HemisphereEdges};
use crate::technique::Site;

/// Blocks along a side of the grid that gradients see. Of one path a direction, differences between
/// adjacent directions are mostly noise: the gradient's noise grows with the square of the side.
const POOLED: usize = 8;

/// Radiance and nearness of the directions of one record, means of blocks of adjacent directions.
pub struct Hemisphere {
    /// Directions of a side, and of a block's side.
    side: usize,
    block: usize,
    /// A channel each, sums over the directions of a block.
    radiance: [Vec<f32>; 3],
    /// 1/t, 0 where nothing is hit.
    nearness: Vec<f32>,
    /// Σ L ω of each channel, local frame.
    vector: [Vec3; 3],
}

/// How irradiance changes around a record, world space; columns of matrices belong to the colour
/// channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// `(2π/S) Σ L ω`: its cosine with a normal is the irradiance of a turned surface.
    pub vector: Mat3,
    /// By translation, per scene unit.
    pub gradient: Mat3,
    /// Harmonic mean of the distances that the rays travelled, scene units; infinite in the open.
    pub mean_distance: f32,
}

impl Hemisphere {
    /// Edges of the grid that gradients see, of records with `side²` directions.
    pub fn edges(side: usize) -> HemisphereEdges {
        HemisphereEdges::new(side.div_ceil(Self::block(side)))
    }

    fn block(side: usize) -> usize {
        side.div_ceil(POOLED).max(1)
    }

    /// Nothing seen yet in `side²` directions.
    pub fn new(side: usize) -> Self {
        let block = Self::block(side);
        let cells = side.div_ceil(block).pow(2);
        Self {
            side,
            block,
            radiance: std::array::from_fn(|_| vec![0.0; cells]),
            nearness: vec![0.0; cells],
            vector: [Vec3::ZERO; 3],
        }
    }

    /// Direction `i` and what its ray, which travelled this far, brings.
    pub fn add(&mut self, (i, direction): (usize, Vec3), light: Vec3, distance: f32) {
        let cells = self.side.div_ceil(self.block);
        let (column, row) = (i % self.side / self.block, i / self.side / self.block);
        let cell = row * cells + column;
        for (channel, value) in light.to_array().into_iter().enumerate() {
            self.radiance[channel][cell] += value;
            self.vector[channel] += direction * value;
        }
        self.nearness[cell] += 1.0 / distance;
    }

    /// What the directions of a whole hemisphere say about a site. Blocks nearer than 10⁻⁴ of the
    /// diagonal count as that near.
    pub fn change(&mut self, edges: &HemisphereEdges, (site, diagonal): (&Site, f32)) -> Change {
        let count = (self.side * self.side) as f32;
        let near: f32 = self.nearness.iter().sum();
        let (cells, nearest) = (self.side.div_ceil(self.block), 1e4 / diagonal);
        for cell in 0..self.nearness.len() {
            let across = |at: usize| self.block.min(self.side - at * self.block);
            let directions = (across(cell % cells) * across(cell / cells)) as f32;
            self.nearness[cell] = (self.nearness[cell] / directions).min(nearest);
            for channel in &mut self.radiance {
                channel[cell] /= directions;
            }
        }
        let local = LocalFrame::from_normal(site.normal);
        let vector = self.vector.map(|sum| local.to_world(sum * (TAU / count)));
        let gradient = self.radiance.each_ref().map(|channel| {
            let gradient = edges.gradient(channel, &self.nearness);
            local.to_world(gradient)
        });
        Change {
            vector: Mat3::from_cols(vector[0], vector[1], vector[2]),
            gradient: Mat3::from_cols(gradient[0], gradient[1], gradient[2]),
            mean_distance: count / near,
        }
    }
}

impl Change {
    /// Irradiance a `step` away at a surface with this normal; never negative. By the step it changes
    /// by at most `clamp` times the record's own, in each channel.
    pub fn extrapolate(&self, own: Vec3, (step, normal): (Vec3, Vec3), clamp: f32) -> Vec3 {
        let turned = self.vector.transpose() * normal;
        let moved = self.gradient.transpose() * step;
        let most = own * clamp;
        (turned + moved.clamp(-most, most)).max(Vec3::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::equal_area_hemisphere;

    fn seen(side: usize, light: impl Fn(Vec3) -> (Vec3, f32)) -> (Change, Vec3) {
        let mut hemisphere = Hemisphere::new(side);
        let mut own = Vec3::ZERO;
        for (i, direction) in equal_area_hemisphere(side).into_iter().enumerate() {
            let (radiance, distance) = light(direction);
            hemisphere.add((i, direction), radiance, distance);
            own += radiance * direction.z * TAU / (side * side) as f32;
        }
        let site = Site {
            normal: Vec3::Z,
            ..Site::default()
        };
        let edges = Hemisphere::edges(side);
        (hemisphere.change(&edges, (&site, 10.0)), own)
    }

    #[test]
    fn even_light_changes_with_nothing_whatever_the_side() {
        for side in [1, 3, 8, 13, 16, 64] {
            let (change, own) = seen(side, |_| (Vec3::new(1.0, 2.0, 3.0), 2.0));
            let steepest = change.gradient.to_cols_array();
            assert!(
                steepest.iter().all(|g| g.abs() < 1e-3),
                "{side}: {change:?}"
            );
            let there = change.extrapolate(own, (Vec3::X, Vec3::Z), 0.3);
            assert!(
                (there - own).abs().max_element() < 1e-3,
                "{side}: {there} {own}"
            );
            assert!((change.mean_distance - 2.0).abs() < 1e-4, "{side}");
        }
    }

    #[test]
    fn a_bright_wall_on_one_side_draws_the_irradiance_up_as_far_as_the_clamp_lets_it() {
        let wall = |d: Vec3| match d.x > 0.3 {
            true => (Vec3::ONE, 1.0 / d.x),
            false => (Vec3::ZERO, f32::INFINITY),
        };
        let (change, own) = seen(32, wall);
        let towards = change.extrapolate(own, (Vec3::X * 0.05, Vec3::Z), 10.0);
        assert!(towards.x > 1.01 * own.x, "{towards} {own}");
        let far = change.extrapolate(own, (Vec3::X * 1e6, Vec3::Z), 0.3);
        assert!((far - own * 1.3).abs().max_element() < 1e-3, "{far} {own}");
        let away = change.extrapolate(own, (Vec3::X * -1e6, -Vec3::X), 1.0);
        assert_eq!(away, Vec3::ZERO, "never negative");
        let turned = change.extrapolate(own, (Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8)), 0.3);
        assert!(turned.x > own.x, "turned to the light");
    }

    #[test]
    fn coincident_hits_and_the_open_stay_finite() {
        for distance in [0.0, 1e-30, f32::INFINITY] {
            let (change, own) = seen(16, |d| (Vec3::splat(d.x.max(0.0) * 1e6), distance));
            let value = change.extrapolate(own, (Vec3::splat(1e3), Vec3::Z), 0.3);
            assert!(value.is_finite(), "{distance}: {change:?}");
        }
    }
}
