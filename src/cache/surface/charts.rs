//! The charts of all meshes of a scene.

use std::ops::Range;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::islands::islands;

/// Where a surface point lies: on which island, and where in its chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPlace {
    /// Index of the island.
    pub island: u32,
    /// Scene units from the chart's lower left corner.
    pub place: Vec2,
}

/// Islands of all meshes with their charts, in the lengths that triangles have when the charts are made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Charts {
    /// Of each triangle.
    island_of: Vec<u32>,
    /// Where the corners of each triangle lie in its chart.
    corners: Vec<[Vec2; 3]>,
    /// Twice the area that each triangle had, scene units².
    areas: Vec<f32>,
    islands: Vec<Chart>,
    /// Triangles, island by island.
    members: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Chart {
    /// Place of its first one in `members`.
    first: u32,
    count: u32,
    size: Vec2,
}

impl Charts {
    /// The charts of meshes, which are ranges of the triangles that follow one another and leave none out.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], meshes: &[Range<usize>]) -> Self {
        let found: Vec<_> = meshes
            .par_iter()
            .map(|mesh| islands(positions, &triangles[mesh.clone()]))
            .collect();
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
            (b - a).cross(c - a).length()
        };
        let mut charts = Self {
            areas: triangles.par_iter().map(area).collect(),
            island_of: vec![0; triangles.len()],
            corners: vec![[Vec2::ZERO; 3]; triangles.len()],
            ..Self::default()
        };
        for (mesh, islands) in meshes.iter().zip(found) {
            for island in islands {
                charts.islands.push(Chart {
                    first: charts.members.len() as u32,
                    count: island.triangles.len() as u32,
                    size: island.size,
                });
                for (triangle, corners) in island.triangles.iter().zip(island.corners) {
                    let triangle = mesh.start + *triangle as usize;
                    charts.members.push(triangle as u32);
                    charts.island_of[triangle] = charts.islands.len() as u32 - 1;
                    charts.corners[triangle] = corners;
                }
            }
        }
        charts
    }

    /// Number of islands.
    pub fn len(&self) -> usize {
        self.islands.len()
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.islands.is_empty()
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.island_of.len()
    }

    /// Where a point of a triangle lies; `u` and `v` are the barycentric weights of its second and third corner.
    pub fn place(&self, triangle: u32, [u, v]: [f32; 2]) -> ChartPlace {
        let [a, b, c] = self.corners[triangle as usize];
        ChartPlace {
            island: self.island_of[triangle as usize],
            place: a + (b - a) * u + (c - a) * v,
        }
    }

    /// How many times as long a triangle is now as it was when the charts were made, by the square root of its area; `twice`
    /// is twice its area now. 1 where it had none, or has none now.
    pub fn grown(&self, triangle: u32, twice: f32) -> f32 {
        let grown = (twice / self.areas[triangle as usize]).sqrt();
        if grown.is_normal() { grown } else { 1.0 }
    }

    /// Extent of an island's chart, scene units.
    pub fn size(&self, island: u32) -> Vec2 {
        self.islands[island as usize].size
    }

    /// Triangles of an island, each with where its corners lie.
    pub fn members(&self, island: u32) -> impl Iterator<Item = (u32, &[Vec2; 3])> {
        let Chart { first, count, .. } = self.islands[island as usize];
        let members = &self.members[first as usize..][..count as usize];
        members
            .iter()
            .map(|&triangle| (triangle, &self.corners[triangle as usize]))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(self.island_of.as_slice())
            + size_of_val(self.corners.as_slice())
            + size_of_val(self.areas.as_slice())
            + size_of_val(self.islands.as_slice())
            + size_of_val(self.members.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_that_touch_have_islands_of_their_own() {
        let positions = [Vec3::ZERO, Vec3::X * 2.0, Vec3::new(2.0, 1.0, 0.0), Vec3::Y];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let one = Charts::new(&positions, &triangles, std::slice::from_ref(&(0..2)));
        let two = Charts::new(&positions, &triangles, &[0..1, 1..1, 1..2]);
        assert_eq!([one.len(), two.len()], [1, 2]);
        assert_eq!(one.size(0), Vec2::new(2.0, 1.0));
        let middle = one.place(1, [0.5, 0.5]);
        assert_eq!((middle.island, middle.place), (0, Vec2::ONE));
        assert_eq!(two.place(1, [0.5, 0.5]).island, 1);
        let members: Vec<u32> = one.members(0).map(|(triangle, _)| triangle).collect();
        assert_eq!(members, [0, 1]);
        assert!(Charts::new(&[], &[], &[]).is_empty());
        assert_eq!([one.grown(0, 2.0), one.grown(1, 18.0)], [1.0, 3.0]);
        assert_eq!([one.grown(0, 0.0), one.grown(0, f32::NAN)], [1.0, 1.0]);
    }
}
