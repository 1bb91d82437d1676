//! The charts of all meshes of a scene.

use std::ops::Range;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::copies::originals;
use super::islands::islands;

/// Where a surface point lies: on which island, and where in its chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPlace {
    /// Index of the island.
    pub island: u32,
    /// Scene units from the chart's lower left corner.
    pub place: Vec2,
}

/// Islands of all meshes with their charts, in the lengths that triangles have when the charts are made. Copies of a mesh share
/// its charts, and have islands of their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Charts {
    /// Of each triangle.
    island_of: Vec<u32>,
    islands: Vec<Island>,
    shared: Shared,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Island {
    /// Index into the shared ones.
    chart: u32,
    /// Its triangles come so many places later than those of its chart.
    shift: u32,
}

/// Charts, and what is known of their triangles: those of meshes that are no copies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Shared {
    /// Where the corners of each triangle lie in its chart.
    corners: Vec<[Vec2; 3]>,
    /// Twice the area that each triangle had, scene units².
    areas: Vec<f32>,
    charts: Vec<Chart>,
    /// Triangles, chart by chart.
    members: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Chart {
    /// Place of its first one in `members`.
    first: u32,
    count: u32,
    size: Vec2,
}

impl Shared {
    /// Of one mesh, with the chart of each triangle.
    fn of(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Self, Vec<u32>) {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
            (b - a).cross(c - a).length()
        };
        let mut chart_of = vec![0; triangles.len()];
        let mut shared = Self {
            areas: triangles.iter().map(area).collect(),
            corners: vec![[Vec2::ZERO; 3]; triangles.len()],
            ..Self::default()
        };
        for (chart, island) in (0..).zip(islands(positions, triangles)) {
            shared.charts.push(Chart {
                first: shared.members.len() as u32,
                count: island.triangles.len() as u32,
                size: island.size,
            });
            for (&triangle, corners) in island.triangles.iter().zip(island.corners) {
                shared.members.push(triangle);
                chart_of[triangle as usize] = chart;
                shared.corners[triangle as usize] = corners;
            }
        }
        (shared, chart_of)
    }

    /// Adds those of another mesh, whose triangles get the next numbers.
    fn append(&mut self, mut next: Self) {
        let triangles = self.members.len() as u32;
        next.members
            .iter_mut()
            .for_each(|member| *member += triangles);
        next.charts
            .iter_mut()
            .for_each(|chart| chart.first += triangles);
        self.corners.append(&mut next.corners);
        self.areas.append(&mut next.areas);
        self.charts.append(&mut next.charts);
        self.members.append(&mut next.members);
    }
}

impl Charts {
    /// The charts of meshes, which are ranges of the triangles that follow one another and leave none out.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], meshes: &[Range<usize>]) -> Self {
        let original_of = originals(positions, triangles, meshes);
        let of_mesh = |(index, mesh): (usize, &Range<usize>)| {
            let is_copy = original_of[index] != index;
            (!is_copy).then(|| Shared::of(positions, &triangles[mesh.clone()]))
        };
        let found: Vec<_> = meshes.par_iter().enumerate().map(of_mesh).collect();
        let mut charts = Self {
            island_of: Vec::with_capacity(triangles.len()),
            ..Self::default()
        };
        let mut islands_of: Vec<Range<usize>> = Vec::with_capacity(meshes.len());
        for ((mesh, found), original) in meshes.iter().zip(found).zip(original_of) {
            let first = charts.islands.len();
            match found {
                Some((next, chart_of)) => charts.append(mesh.start, next, &chart_of),
                None => charts.copy(mesh.start, &meshes[original], islands_of[original].clone()),
            }
            islands_of.push(first..charts.islands.len());
        }
        charts
    }

    /// Adds the charts of a mesh that begins with some triangle, with the chart of each of its triangles.
    fn append(&mut self, begin: usize, next: Shared, chart_of: &[u32]) {
        let island = self.islands.len() as u32;
        let chart = self.shared.charts.len() as u32;
        let shift = (begin - self.shared.members.len()) as u32;
        let charts = chart..chart + next.charts.len() as u32;
        self.islands
            .extend(charts.map(|chart| Island { chart, shift }));
        self.island_of
            .extend(chart_of.iter().map(|chart| island + chart));
        self.shared.append(next);
    }

    /// Adds a copy that begins with some triangle, of a mesh of these triangles and islands.
    fn copy(&mut self, begin: usize, triangles: &Range<usize>, islands: Range<usize>) {
        let further = (begin - triangles.start) as u32;
        let later = (self.islands.len() - islands.start) as u32;
        for island in islands {
            let Island { chart, shift } = self.islands[island];
            let shift = shift + further;
            self.islands.push(Island { chart, shift });
        }
        for triangle in triangles.clone() {
            self.island_of.push(self.island_of[triangle] + later);
        }
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
        let island = self.island_of[triangle as usize];
        let shared = triangle - self.islands[island as usize].shift;
        let [a, b, c] = self.shared.corners[shared as usize];
        ChartPlace {
            island,
            place: a + (b - a) * u + (c - a) * v,
        }
    }

    /// Whether a triangle had an area when the charts were made, so that its chart tells its points apart.
    pub fn has_extent(&self, triangle: u32) -> bool {
        self.area(triangle) > 0.0
    }

    /// How many times as long a triangle is now as it was when the charts were made, by the square root of its area; `twice`
    /// is twice its area now. 1 where it had none, or has none now.
    pub fn grown(&self, triangle: u32, twice: f32) -> f32 {
        let grown = (twice / self.area(triangle)).sqrt();
        if grown.is_normal() { grown } else { 1.0 }
    }

    /// Twice the area that a triangle had.
    fn area(&self, triangle: u32) -> f32 {
        let island = self.island_of[triangle as usize];
        let shared = triangle - self.islands[island as usize].shift;
        self.shared.areas[shared as usize]
    }

    /// Extent of an island's chart, scene units.
    pub fn size(&self, island: u32) -> Vec2 {
        let Island { chart, .. } = self.islands[island as usize];
        self.shared.charts[chart as usize].size
    }

    /// Triangles of an island, each with where its corners lie.
    pub fn members(&self, island: u32) -> impl Iterator<Item = (u32, &[Vec2; 3])> {
        let Island { chart, shift } = self.islands[island as usize];
        let Chart { first, count, .. } = self.shared.charts[chart as usize];
        let members = &self.shared.members[first as usize..][..count as usize];
        members
            .iter()
            .map(move |&member| (member + shift, &self.shared.corners[member as usize]))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let Shared {
            corners,
            areas,
            charts,
            members,
        } = &self.shared;
        size_of_val(self.island_of.as_slice())
            + size_of_val(self.islands.as_slice())
            + size_of_val(corners.as_slice())
            + size_of_val(areas.as_slice())
            + size_of_val(charts.as_slice())
            + size_of_val(members.as_slice())
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
        // A line and a point are triangles too.
        let flat = Charts::new(
            &positions,
            &[[0, 1, 2], [0, 0, 1], [2, 2, 2]],
            std::slice::from_ref(&(0..3)),
        );
        let have = [0, 1, 2].map(|triangle| flat.has_extent(triangle));
        assert_eq!(have, [true, false, false]);
        assert!((0..3).all(|triangle| flat.place(triangle, [0.2, 0.3]).place.is_finite()));
    }

    #[test]
    fn copies_share_charts_and_have_islands_and_triangles_of_their_own() {
        let square =
            |place: Vec3, up: Vec3| [place, place + Vec3::X, place + Vec3::X + up, place + up];
        let places = [
            (Vec3::ZERO, Vec3::Y),
            (Vec3::ZERO, 2.0 * Vec3::Y),
            (Vec3::new(5.0, 1.0, 2.0), Vec3::Z),
        ];
        let positions: Vec<Vec3> = places
            .iter()
            .flat_map(|&(place, up)| square(place, up))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..3)
            .flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|corner| 4 * i + corner)))
            .collect();
        let charts = Charts::new(&positions, &triangles, &[0..2, 2..4, 4..4, 4..6]);
        assert_eq!((charts.len(), charts.triangles()), (3, 6));
        assert_eq!(
            charts.shared.members.len(),
            4,
            "the third has the charts of the first"
        );
        let sizes = [0, 1, 2].map(|island| charts.size(island).y);
        assert_eq!(sizes, [1.0, 2.0, 1.0]);
        for (triangle, island) in (0..6).zip([0, 0, 1, 1, 2, 2]) {
            assert_eq!(charts.place(triangle, [0.3, 0.3]).island, island);
            let members: Vec<u32> = charts
                .members(island)
                .map(|(triangle, _)| triangle)
                .collect();
            assert_eq!(members, [2 * island, 2 * island + 1]);
            assert_eq!(
                charts.grown(triangle, [1.0, 2.0, 1.0][island as usize]),
                1.0
            );
        }
        let alike = [0, 4].map(|triangle| charts.place(triangle, [0.2, 0.5]).place);
        assert_eq!(alike[0], alike[1]);
        let apart = Charts::new(&positions, &triangles, &[0..2, 2..4]);
        assert!(charts.bytes() < apart.bytes() * 3 / 2);
    }
}
