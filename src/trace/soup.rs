//! The triangles of one tree.

use glam::Vec3;
use obvhs::triangle::Triangle;

/// Triangles by their corners, all of the caller's or some.
pub struct Soup<'a> {
    pub corners: Vec<Triangle>,
    /// The caller's index of each, ascending; empty where they are all of the caller's.
    indices: &'a [u32],
}

impl<'a> Soup<'a> {
    /// `indices` say which of the caller's triangles these are; none, that they are all.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], indices: &'a [u32]) -> Self {
        let corners = |t: &[u32; 3]| {
            let [v0, v1, v2] = t.map(|i| positions[i as usize].into());
            Triangle { v0, v1, v2 }
        };
        Self {
            corners: triangles.iter().map(corners).collect(),
            indices,
        }
    }

    /// The caller's index of a triangle.
    pub fn index(&self, i: u32) -> u32 {
        self.indices.get(i as usize).copied().unwrap_or(i)
    }
}
