//! Normal cones and the angular splits of view-guided clustering.

use std::ops::Range;

use glam::DVec3;

use super::growth::Growth;
use super::members::{Bounds, Member, NORMAL};
use super::partition::partition;

/// A mean normal shorter than this means that the normals cancel: the spread counts as a full turn.
const CANCELLED: f64 = 1e-4;

/// The angular threshold and how it grows with depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thresholds {
    pub growth: Growth,
    pub angle_rad: f32,
}

/// Splits clusters by their normals. Member normals must be unscaled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cones {
    thresholds: Thresholds,
}

impl Cones {
    pub fn new(thresholds: Thresholds) -> Self {
        Self { thresholds }
    }

    /// Whether the normals' spread, twice the largest angle to their mean, is above σ′_a.
    ///
    /// *differs:* the paper bounds the normals by a box in (θ, φ), which has a seam and poles.
    fn too_wide(&self, members: &[Member]) -> bool {
        let (mut sum, mut depth) = (DVec3::ZERO, 0.0f64);
        for member in members {
            sum += member.normal().as_dvec3();
            depth += f64::from(member.depth());
        }
        let count = members.len() as f64;
        let factor = self.thresholds.growth.factor((depth / count) as f32);
        let limit = (self.thresholds.angle_rad * factor).min(std::f32::consts::PI);
        if sum.length() <= CANCELLED * count {
            return true;
        }
        // spread = 4 asin(chord / 2) > limit, without an arc sine for each member.
        let chord = 2.0 * (0.25 * limit).sin();
        let axis = sum.normalize().as_vec3();
        let away = |m: &Member| (m.normal() - axis).length_squared();
        members.iter().any(|m| away(m) > chord * chord)
    }

    /// The number of clusters that `members` fall into, or `limit` as soon as it is reached.
    /// Members are reordered.
    pub fn count(&self, members: &mut [Member], limit: u32) -> u32 {
        let mut count = 0;
        self.split(members, 0, &mut |_| {
            count += 1;
            count < limit
        });
        count
    }

    /// Reorders `members` so that each cluster is a range, and calls `found` with it, `offset`
    /// added, until `found` says that this is enough.
    pub fn split(
        &self,
        members: &mut [Member],
        offset: usize,
        found: &mut impl FnMut(Range<usize>) -> bool,
    ) -> bool {
        let whole = offset..offset + members.len();
        if members.len() < 2 || !self.too_wide(members) {
            return found(whole);
        }
        let bounds = Bounds::around(members);
        let axis = bounds.widest(&NORMAL);
        if bounds.extent(axis) <= 0.0 {
            return found(whole);
        }
        let middle = partition(members, axis, bounds.middle(axis));
        let (low, high) = members.split_at_mut(middle);
        self.split(low, offset, found) && self.split(high, offset + middle, found)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec3Swizzles};

    use super::*;
    use crate::cache::ShadingPoints;

    fn clusters(normals: &[Vec3], degrees: f32) -> u32 {
        let points = ShadingPoints {
            position: vec![Vec3::ZERO; normals.len()],
            normal: normals.to_vec(),
            depth: vec![1.0; normals.len()],
            ..ShadingPoints::default()
        };
        let mut members: Vec<Member> = (0..normals.len() as u32)
            .map(|i| Member::new(&points, i, 1.0))
            .collect();
        let cones = Cones::new(Thresholds {
            growth: Growth::new(1.0, 1.0, 0.2, 1.0),
            angle_rad: degrees.to_radians(),
        });
        cones.count(&mut members, u32::MAX)
    }

    fn tilted(degrees: f32) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, 0.0, cos)
    }

    #[test]
    fn splits_where_normals_spread_more_than_the_threshold() {
        assert_eq!(clusters(&[Vec3::Z; 40], 0.001), 1);
        let fan = [tilted(-10.0), tilted(10.0)];
        assert_eq!(clusters(&fan, 20.1), 1);
        assert_eq!(clusters(&fan, 19.9), 2);
        assert_eq!(clusters(&[Vec3::Z, -Vec3::Z], 180.0), 2, "antipodal");
        assert_eq!(clusters(&[Vec3::Z, Vec3::X, -Vec3::X], 15.0), 3);
    }

    #[test]
    fn noise_around_a_pole_is_one_cluster() {
        let normals: Vec<Vec3> = (0..360)
            .map(|i| {
                let (sin, cos) = (i as f32).to_radians().sin_cos();
                Vec3::new(0.01 * cos, 0.01 * sin, 1.0).normalize()
            })
            .collect();
        for rotated in [|n: Vec3| n, |n: Vec3| -n, |n: Vec3| n.zxy()] {
            let turned: Vec<Vec3> = normals.iter().map(|&n| rotated(n)).collect();
            assert_eq!(clusters(&turned, 5.0), 1);
        }
    }
}
