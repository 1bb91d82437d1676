//! Halving sets of directions, for orders and groups of neighbours.

use glam::DVec3;

/// The box around directions; turned inside out without any.
pub(super) fn bounds(directions: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    directions.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], d| {
        [low.min(d), high.max(d)]
    })
}

/// Orders indices so that the lower half along the longest side of their directions' box comes first, and
/// returns where the upper one begins. Equal coordinates are ordered by index.
pub(super) fn halve(indices: &mut [u32], direction: impl Fn(u32) -> DVec3) -> usize {
    let [low, high] = bounds(indices.iter().map(|&index| direction(index)));
    let axis = (high - low).max_position();
    let middle = indices.len() / 2;
    indices.select_nth_unstable_by(middle, |&a, &b| {
        let along = |index: u32| direction(index)[axis];
        along(a).total_cmp(&along(b)).then(a.cmp(&b))
    });
    middle
}
