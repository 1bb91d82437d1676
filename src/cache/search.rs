//! The run-time rule (Wu & Shen, section 3.3): N nearest records, normal filter, M by distance.

use glam::Vec3;

/// The combined distance of Wu & Shen, eq. 2 and 5: `|Δp| + lambda · sqrt(1 − n·n′)`, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceMetric {
    /// Weight of the angular term in scene units.
    pub lambda: f32,
}

/// Parameters of the rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchRule {
    /// Spatially nearest records that are candidates (N).
    pub candidates: usize,
    /// Records that are used (M).
    pub used: usize,
    /// Largest angle between normals, degrees (θ_max).
    pub max_angle_deg: f32,
    pub metric: DistanceMetric,
}

/// A record chosen for a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    pub record: u32,
    /// Combined distance, scene units.
    pub distance: f32,
}

/// Answers the rule for many queries.
pub struct RecordSearch {}

impl RecordSearch {
    /// Builds the search over records at `positions` with unit `normals`.
    pub fn new(positions: &[Vec3], normals: &[Vec3], rule: SearchRule) -> Self {
        let _ = (positions, normals, rule);
        Self {}
    }

    /// Calls `answer(query, neighbours)` once for each query, with at most M neighbours in
    /// ascending distance (ties by record index); none only if there are no records. Queries that
    /// are neighbours in the input should be neighbours in space: they are answered tile by tile.
    /// `answer` is called from several threads, in no fixed order.
    pub fn for_each(
        &self,
        positions: &[Vec3],
        normals: &[Vec3],
        answer: impl Fn(usize, &[Neighbour]) + Sync,
    ) {
        let _ = (positions, normals, answer);
    }
}
