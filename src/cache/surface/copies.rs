//! Which meshes are copies of one another: the same triangles, turned and moved.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

use crate::sample::hash;

/// Largest distance of a corner from where it would be in an exact copy, as a part of the mesh's extent.
const ALIKE: f64 = 1e-5;
/// Meshes that one is compared with at most: of many boxes of all sizes some copies may go unnoticed.
const MOST_COMPARED: usize = 64;

/// Of each mesh the first one that it is a copy of; itself where there is none. What is mirrored or of another size is
/// no copy.
pub(super) fn originals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    meshes: &[Range<usize>],
) -> Vec<usize> {
    let mesh = |range: &Range<usize>| Mesh {
        positions,
        triangles: &triangles[range.clone()],
    };
    let connections: Vec<[u64; 2]> = meshes.par_iter().map(|m| mesh(m).connections()).collect();
    let mut connected_alike: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for (index, connections) in connections.into_iter().enumerate() {
        connected_alike.entry(connections).or_default().push(index);
    }
    let of_group = |group: &Vec<usize>| {
        let mut known: Vec<(usize, Original)> = Vec::new();
        let pair = |&index: &usize| {
            let mesh = mesh(&meshes[index]);
            if let Some((original, _)) = known.iter().find(|(_, known)| known.is_copied_by(&mesh)) {
                return (index, *original);
            }
            if group.len() > 1 && known.len() < MOST_COMPARED {
                known.extend(Original::of(mesh).map(|original| (index, original)));
            }
            (index, index)
        };
        group.iter().map(pair).collect::<Vec<_>>()
    };
    let groups: Vec<&Vec<usize>> = connected_alike.values().collect();
    let mut pairs: Vec<(usize, usize)> = groups.into_par_iter().flat_map_iter(of_group).collect();
    pairs.sort_unstable();
    pairs.into_iter().map(|(_, original)| original).collect()
}

#[derive(Clone, Copy)]
struct Mesh<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
}

impl Mesh<'_> {
    /// Numbers that are the same where the same corners of as many triangles share a vertex.
    fn connections(&self) -> [u64; 2] {
        let vertices = || self.triangles.iter().flatten();
        let least = vertices().copied().min().unwrap_or(0);
        let which = vertices().fold(0, |all, vertex| hash(all ^ u64::from(vertex - least)));
        [self.triangles.len() as u64, which]
    }

    /// Corners of all triangles, one after another.
    fn corner(&self, place: usize) -> DVec3 {
        let vertex = self.triangles[place / 3][place % 3];
        self.positions[vertex as usize].as_dvec3()
    }

    fn places(&self) -> Range<usize> {
        0..3 * self.triangles.len()
    }

    /// Where the corner is that has most of something.
    fn most(&self, of: impl Fn(DVec3) -> f64) -> Option<usize> {
        let amount = |&place: &usize| of(self.corner(place));
        self.places().max_by(|a, b| amount(a).total_cmp(&amount(b)))
    }

    /// Axes through three corners.
    fn pose(&self, anchors: [usize; 3]) -> Option<Pose> {
        let [origin, along, aside] = anchors.map(|place| self.corner(place));
        let x = (along - origin).try_normalize()?;
        let z = x.cross(aside - origin).try_normalize()?;
        Some(Pose {
            origin,
            axes: DMat3::from_cols(x, z.cross(x), z),
        })
    }
}

/// Where a mesh lies.
struct Pose {
    origin: DVec3,
    axes: DMat3,
}

impl Pose {
    fn local(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.origin)
    }
}

/// A mesh that others may be copies of.
struct Original<'a> {
    mesh: Mesh<'a>,
    /// Places of three corners far apart.
    anchors: [usize; 3],
    pose: Pose,
    /// Distance of the first two.
    extent: f64,
}

impl<'a> Original<'a> {
    /// `None` where all corners lie on a line.
    fn of(mesh: Mesh<'a>) -> Option<Self> {
        let first = mesh.corner(mesh.places().next()?);
        let far = mesh.most(|corner| corner.distance_squared(first))?;
        let along = mesh.corner(far) - first;
        let aside = mesh.most(|corner| along.cross(corner - first).length_squared())?;
        let anchors = [0, far, aside];
        Some(Self {
            mesh,
            anchors,
            pose: mesh.pose(anchors)?,
            extent: along.length(),
        })
    }

    /// Whether a mesh of the same connections has all corners where this one has them.
    fn is_copied_by(&self, other: &Mesh) -> bool {
        let Some(pose) = other.pose(self.anchors) else {
            return false;
        };
        self.mesh.places().all(|place| {
            let here = self.pose.local(self.mesh.corner(place));
            let there = pose.local(other.corner(place));
            here.distance(there) <= ALIKE * self.extent
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Quat};

    use super::*;

    /// Meshes of a prism with corners that differ, each with vertices of its own.
    fn originals_of(copies: &[&dyn Fn(Vec3) -> Vec3]) -> Vec<usize> {
        let corners = [
            Vec3::ZERO,
            Vec3::new(2.0, 0.1, 0.0),
            Vec3::new(0.3, 1.0, 0.0),
            Vec3::new(0.1, 0.2, 1.5),
        ];
        let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
        let positions: Vec<Vec3> = copies.iter().flat_map(|copy| corners.map(copy)).collect();
        let triangles: Vec<[u32; 3]> = (0..copies.len() as u32)
            .flat_map(|copy| faces.map(|face| face.map(|corner| 4 * copy + corner)))
            .collect();
        let meshes: Vec<_> = (0..copies.len())
            .map(|copy| 4 * copy..4 * copy + 4)
            .collect();
        originals(&positions, &triangles, &meshes)
    }

    #[test]
    fn what_is_turned_and_moved_is_a_copy_and_what_is_mirrored_scaled_or_bent_is_none() {
        let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0);
        let found = originals_of(&[
            &|p| p,
            &|p| 1.001 * p,
            &|p| turn * p + Vec3::new(30.0, -4.0, 7.0),
            &|p| Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0)) * p,
            &|p| p + Vec3::Z * (0.01 * p.x * p.y),
            &|p| turn * (1.001 * p) - Vec3::Y,
        ]);
        assert_eq!(found, [0, 1, 0, 3, 4, 1]);
    }

    #[test]
    fn corners_far_apart_are_the_same_ones_in_symmetric_copies() {
        // Of a square two corners are equally far from the first: rounding must not choose.
        let square = |place: Vec3, turn: Quat| {
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            corners.map(|[x, y]| place + turn * Vec3::new(x, y, 0.0))
        };
        let turns = (0..40).map(|i| Quat::from_rotation_x(0.1 * i as f32));
        let positions: Vec<Vec3> = turns.flat_map(|turn| square(Vec3::X, turn)).collect();
        let faces = |i: u32| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]];
        let triangles: Vec<[u32; 3]> = (0..40).flat_map(faces).collect();
        let meshes: Vec<_> = (0..40).map(|i| 2 * i..2 * i + 2).collect();
        assert_eq!(originals(&positions, &triangles, &meshes), [0; 40]);
    }

    #[test]
    fn other_connections_lines_and_nothing_are_no_copies() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::X];
        let triangles = [[0, 1, 2], [0, 2, 1], [0, 1, 3], [0, 1, 3]];
        let all = [0..2, 0..2, 2..3, 3..4, 4..4, 4..4];
        // The two lines have connections of their own, and no plane.
        assert_eq!(originals(&positions, &triangles, &all), [0, 0, 2, 3, 4, 5]);
        assert_eq!(originals(&[], &[], &[]), [0; 0]);
    }
}
