//! Splitting a mesh into islands that lie flat.
//!
//! An island grows from a triangle over shared edges while normals stay within [`STEEPEST_DEG`] of the first one's, so
//! that its projection along that normal stretches nothing by more than twice, and while no projected triangle covers
//! another, so that each place of the chart is one place of the surface. Edges of more than two triangles are
//! cut. Corners are the same where their positions are, whatever else tells them apart.

use std::collections::{HashMap, VecDeque};

use glam::{Vec2, Vec3};

/// Triangles of an island at most.
pub const MOST_TRIANGLES: usize = 256;
/// Largest angle between a normal and that of the island's first triangle, degrees.
pub const STEEPEST_DEG: f32 = 60.0;

/// No neighbour.
const NONE: u32 = u32::MAX;
/// Part of a triangle's extent by which triangles may cover each other through rounding.
const ROUNDING: f32 = 1e-5;

/// An island of a mesh.
pub(super) struct Island {
    /// Indices among the mesh's triangles, in the order in which they were found.
    pub triangles: Vec<u32>,
    /// Where the corners of each lie in the chart, scene units; the least coordinates are 0.
    pub corners: Vec<[Vec2; 3]>,
    /// Extent of the chart.
    pub size: Vec2,
}

/// The islands of a mesh; each triangle is in one of them.
pub(super) fn islands(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Island> {
    let mesh = Mesh::new(positions, triangles);
    let mut taken = vec![false; triangles.len()];
    let mut islands = Vec::new();
    for seed in 0..triangles.len() as u32 {
        if !taken[seed as usize] {
            islands.push(mesh.grown_from(seed, &mut taken));
        }
    }
    islands
}

/// Triangles with their normals and neighbours.
struct Mesh<'a> {
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
    normals: Vec<Vec3>,
    /// Over the edges from each corner to the next.
    neighbours: Vec<[u32; 3]>,
}

impl<'a> Mesh<'a> {
    fn new(positions: &'a [Vec3], triangles: &'a [[u32; 3]]) -> Self {
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        };
        Self {
            positions,
            triangles,
            normals: triangles.iter().map(normal).collect(),
            neighbours: neighbours(positions, triangles),
        }
    }

    /// The island of a triangle that is in none.
    fn grown_from(&self, seed: u32, taken: &mut [bool]) -> Island {
        let projection = Projection::of(self, seed);
        let mut island = Island {
            triangles: Vec::new(),
            corners: Vec::new(),
            size: Vec2::ZERO,
        };
        let least_cosine = STEEPEST_DEG.to_radians().cos();
        let mut front = VecDeque::from([seed]);
        while let Some(next) = front.pop_front() {
            if island.triangles.len() == MOST_TRIANGLES {
                break;
            }
            if taken[next as usize] {
                continue;
            }
            let corners =
                self.triangles[next as usize].map(|i| projection.flat(self.positions[i as usize]));
            let first = next == seed;
            let steep = self.normals[next as usize].dot(projection.normal) < least_cosine;
            if !first && (steep || island.corners.iter().any(|other| covers(other, &corners))) {
                continue;
            }
            taken[next as usize] = true;
            island.triangles.push(next);
            island.corners.push(corners);
            let free = |n: &&u32| **n != NONE && !taken[**n as usize];
            front.extend(self.neighbours[next as usize].iter().filter(free));
        }
        let all = || island.corners.iter().flatten();
        let low = all().fold(Vec2::INFINITY, |low, p| low.min(*p));
        let high = all().fold(Vec2::NEG_INFINITY, |high, p| high.max(*p));
        island.size = high - low;
        island.corners.iter_mut().flatten().for_each(|p| *p -= low);
        island
    }
}

/// The plane that an island is laid out in.
struct Projection {
    origin: Vec3,
    normal: Vec3,
    across: Vec3,
    up: Vec3,
}

impl Projection {
    /// The plane of a triangle, with its first edge across.
    fn of(mesh: &Mesh, triangle: u32) -> Self {
        let [a, b, _] = mesh.triangles[triangle as usize].map(|i| mesh.positions[i as usize]);
        let normal = mesh.normals[triangle as usize];
        let across = (b - a).try_normalize().unwrap_or(Vec3::X);
        Self {
            origin: a,
            normal,
            across,
            up: normal.cross(across),
        }
    }

    fn flat(&self, point: Vec3) -> Vec2 {
        let way = point - self.origin;
        Vec2::new(way.dot(self.across), way.dot(self.up))
    }
}

/// The triangle beyond each edge; none over edges of one triangle and of more than two.
fn neighbours(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut corner_of: HashMap<[u32; 3], u32> = HashMap::new();
    let mut corner = |i: &u32| {
        // Both zeros are one place.
        let place = (positions[*i as usize] + 0.0).to_array().map(f32::to_bits);
        let next = corner_of.len() as u32;
        *corner_of.entry(place).or_insert(next)
    };
    let mut edges: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in (0..).zip(triangles) {
        let corners = [0, 1, 2].map(|k| corner(&corners[k]));
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], triangle, k));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a, side_a), (_, b, side_b)] = shared {
            neighbours[*a as usize][*side_a] = *b;
            neighbours[*b as usize][*side_b] = *a;
        }
    }
    neighbours
}

/// Whether the insides of two triangles of a chart have points in common: whether no edge separates them.
fn covers(a: &[Vec2; 3], b: &[Vec2; 3]) -> bool {
    let (low_a, high_a) = bounds(a);
    let (low_b, high_b) = bounds(b);
    let extent = (high_a - low_a).max(high_b - low_b).max_element();
    let allowed = ROUNDING * extent;
    if (low_a + allowed).cmpge(high_b).any() || (low_b + allowed).cmpge(high_a).any() {
        return false;
    }
    !(0..3).any(|k| separates(a, b, k, allowed) || separates(b, a, k, allowed))
}

/// Whether the other triangle lies beyond an edge of a counter-clockwise one.
fn separates(triangle: &[Vec2; 3], other: &[Vec2; 3], edge: usize, allowed: f32) -> bool {
    let from = triangle[edge];
    let along = (triangle[(edge + 1) % 3] - from).normalize_or_zero();
    other.iter().all(|p| along.perp_dot(*p - from) <= allowed)
}

pub(super) fn bounds(corners: &[Vec2; 3]) -> (Vec2, Vec2) {
    let [a, b, c] = *corners;
    (a.min(b).min(c), a.max(b).max(c))
}

#[cfg(test)]
mod tests;
