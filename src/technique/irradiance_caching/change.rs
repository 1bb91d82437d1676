//! How irradiance changes around a record, from the paths it was gathered with.

use std::f32::consts::TAU;

use glam::{Mat3, Vec3, Vec4};

use crate::sample::{Frame as LocalFrame, HemisphereEdges};

/// Blocks along a side of the grid that gradients see. Of one path a direction, differences between
/// adjacent directions are mostly noise: the gradient's noise grows with the square of the side.
const POOLED: usize = 8;

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

/// Edges of the grid that gradients see, of records with `width²` blocks.
pub fn edges(width: usize) -> HemisphereEdges {
    HemisphereEdges::new(width.div_ceil(width.div_ceil(POOLED)))
}

impl Change {
    /// What a whole hemisphere says about a site with this unit normal: the directions of the local frame with
    /// the radiance and distance of each, and their blocks (radiance and nearness, `width²` of them).
    pub fn new(
        directions: &[Vec3],
        seen: &[(Vec3, f32)],
        blocks: &[Vec4],
        width: usize,
        edges: &HemisphereEdges,
        normal: Vec3,
    ) -> Self {
        let (mut vector, mut near) = ([Vec3::ZERO; 3], 0.0);
        for (direction, (light, distance)) in directions.iter().zip(seen) {
            for (sum, value) in vector.iter_mut().zip(light.to_array()) {
                *sum += *direction * value;
            }
            near += 1.0 / distance;
        }
        let local = LocalFrame::from_normal(normal);
        let count = seen.len() as f32;
        let vector = vector.map(|sum| local.to_world(sum * (TAU / count)));
        let pooled = pool(blocks, width);
        let nearness: Vec<f32> = pooled.iter().map(|block| block.w).collect();
        let gradient = [0, 1, 2].map(|channel| {
            let radiance: Vec<f32> = pooled.iter().map(|block| block[channel]).collect();
            local.to_world(edges.gradient(&radiance, &nearness))
        });
        Self {
            vector: Mat3::from_cols(vector[0], vector[1], vector[2]),
            gradient: Mat3::from_cols(gradient[0], gradient[1], gradient[2]),
            mean_distance: count / near,
        }
    }

    /// Irradiance a `step` away at a surface with this normal; never negative. By the step it changes
    /// by at most `clamp` times the record's own, in each channel.
    pub fn extrapolate(&self, own: Vec3, step: Vec3, normal: Vec3, clamp: f32) -> Vec3 {
        let turned = self.vector.transpose() * normal;
        let moved = self.gradient.transpose() * step;
        let most = own * clamp;
        (turned + moved.clamp(-most, most)).max(Vec3::ZERO)
    }
}

/// Means of square groups of blocks, as few as there are [`edges`] for.
fn pool(blocks: &[Vec4], width: usize) -> Vec<Vec4> {
    let group = width.div_ceil(POOLED);
    let cells = width.div_ceil(group);
    let mut sums = vec![Vec4::ZERO; cells * cells];
    let mut counts = vec![0u32; cells * cells];
    for (at, block) in blocks.iter().enumerate() {
        let cell = at / width / group * cells + at % width / group;
        sums[cell] += *block;
        counts[cell] += 1;
    }
    let mean = |(sum, count): (Vec4, u32)| sum / count as f32;
    sums.into_iter().zip(counts).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::super::panorama::Panoramas;
    use super::*;
    use crate::sample::equal_area_hemisphere;

    fn seen(side: usize, light: impl Fn(Vec3) -> (Vec3, f32)) -> (Change, Vec3) {
        let directions = equal_area_hemisphere(side);
        let seen: Vec<_> = directions.iter().map(|&d| light(d)).collect();
        let radiances = directions.iter().zip(&seen);
        let own: Vec3 = radiances.map(|(d, (radiance, _))| radiance * d.z).sum();
        let panoramas = Panoramas::new(side, 10.0);
        let (blocks, width) = (panoramas.pool(&seen), panoramas.width());
        let edges = edges(width);
        let change = Change::new(&directions, &seen, &blocks, width, &edges, Vec3::Z);
        (change, own * (TAU / seen.len() as f32))
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
            let there = change.extrapolate(own, Vec3::X, Vec3::Z, 0.3);
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
        let towards = change.extrapolate(own, Vec3::X * 0.05, Vec3::Z, 10.0);
        assert!(towards.x > 1.01 * own.x, "{towards} {own}");
        let far = change.extrapolate(own, Vec3::X * 1e6, Vec3::Z, 0.3);
        assert!((far - own * 1.3).abs().max_element() < 1e-3, "{far} {own}");
        let away = change.extrapolate(own, Vec3::X * -1e6, -Vec3::X, 1.0);
        assert_eq!(away, Vec3::ZERO, "never negative");
        let turned = change.extrapolate(own, Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8), 0.3);
        assert!(turned.x > own.x, "turned to the light");
    }

    #[test]
    fn coincident_hits_and_the_open_stay_finite() {
        for distance in [0.0, 1e-30, f32::INFINITY] {
            let (change, own) = seen(16, |d| (Vec3::splat(d.x.max(0.0) * 1e6), distance));
            let value = change.extrapolate(own, Vec3::splat(1e3), Vec3::Z, 0.3);
            assert!(value.is_finite(), "{distance}: {change:?}");
        }
    }
}
