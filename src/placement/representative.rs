//! Which member of a cluster becomes the record.

use glam::{DVec3, Vec3};

use super::members::{Bounds, Member, POSITION};
use super::pick::STREAM_MEMBER;
use crate::cache::{DistanceMetric, NO_POINT};
use crate::sample::{Rng, hash};

/// A uniformly random member, whatever the order of the members: the one with the least hash.
pub(super) fn random_member(members: &[Member], seed: u64) -> u32 {
    let key = hash(seed ^ STREAM_MEMBER);
    let indices = members.iter().map(Member::index);
    let chosen = indices.min_by_key(|&i| (hash(key ^ u64::from(i)), i));
    chosen.unwrap_or(NO_POINT)
}

/// How the member nearest to the average is found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Average {
    pub metric: DistanceMetric,
    /// Largest move of the average position, as a share of the box's sides.
    pub jitter: f32,
    /// What the members' normals are multiplied with.
    pub normal_scale: f32,
}

/// The member nearest to the jittered average position and the average normal (Wu & Shen, eq. 2);
/// the lower index of equals.
pub(super) fn nearest_to_average(members: &[Member], rule: Average, seed: u64) -> u32 {
    if let [only] = members {
        return only.index();
    }
    let unscaled = if rule.normal_scale > 0.0 {
        1.0 / rule.normal_scale
    } else {
        0.0
    };
    let mut bounds = Bounds::EMPTY;
    let mut first = NO_POINT;
    let (mut position, mut normal) = (DVec3::ZERO, DVec3::ZERO);
    for member in members {
        bounds.add(member.lanes());
        first = first.min(member.index());
        position += member.position().as_dvec3();
        normal += member.normal().as_dvec3();
    }
    // Depends on which points are in the cluster, not on the order of clusters.
    let mut rng = Rng::new(seed, STREAM_MEMBER, u64::from(first), 0);
    let shift = Vec3::from_array(POSITION.map(|axis| {
        let unit = 2.0 * rng.next_f32() - 1.0;
        rule.jitter * unit * bounds.extent(axis)
    }));
    let position = (position / members.len() as f64).as_vec3() + shift;
    let normal = normal.normalize_or_zero().as_vec3() * unscaled;
    let distance = |m: &Member| {
        let squared = m.position().distance_squared(position);
        rule.metric.distance(squared, m.normal().dot(normal))
    };
    let mut best = (f32::INFINITY, NO_POINT);
    for member in members {
        let candidate = (distance(member), member.index());
        if best.1 == NO_POINT || candidate < best {
            best = candidate;
        }
    }
    best.1
}
