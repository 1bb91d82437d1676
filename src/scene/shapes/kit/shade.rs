//! Welding and vertex normals with creases.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::face_normal;
use crate::scene::Mesh;

/// Welds equal positions, drops triangles without area and gives every corner the area-weighted mean
/// normal of the faces around its vertex that deviate by at most `crease_deg` from its own face.
/// Vertices on creases are split.
pub fn shade(mesh: Mesh, crease_deg: f64) -> Mesh {
    let (positions, triangles) = weld(&mesh);
    let crosses: Vec<DVec3> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a)
        })
        .collect();
    let incident = Incidence::new(positions.len(), &triangles);
    let limit = crease_deg.to_radians().cos();
    let mut out = Mesh::default();
    let mut variants: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
    for (face, triangle) in triangles.iter().enumerate() {
        let own = crosses[face].normalize_or_zero();
        let corners = triangle.map(|vertex| {
            let sum: DVec3 = incident
                .of(vertex)
                .iter()
                .map(|&f| crosses[f as usize])
                .filter(|c| c.normalize_or_zero().dot(own) >= limit)
                .sum();
            let normal = sum.normalize_or(own).as_vec3();
            let known = &mut variants[vertex as usize];
            let found = known.iter().find(|&&i| out.normals[i as usize] == normal);
            found.copied().unwrap_or_else(|| {
                let index = out.positions.len() as u32;
                out.positions.push(positions[vertex as usize]);
                out.normals.push(normal);
                known.push(index);
                index
            })
        });
        out.triangles.push(corners);
    }
    out
}

/// Makes given vertex normals agree with the winding: where one leans away from a face around it the
/// area-weighted mean of the faces replaces it, and corners that still oppose their face are split
/// off with its normal. Triangles without area go.
pub fn mend_normals(mesh: &mut Mesh) {
    let corners = |positions: &[DVec3], t: &[u32; 3]| t.map(|i| positions[i as usize]);
    let Mesh {
        positions,
        normals,
        triangles,
        ..
    } = mesh;
    triangles.retain(|t| face_normal(corners(positions, t)) != Vec3::ZERO);
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let mut leaning = vec![false; positions.len()];
    for t in triangles.iter() {
        let [a, b, c] = corners(positions, t);
        let face = face_normal([a, b, c]);
        for i in t.map(|i| i as usize) {
            sums[i] += (b - a).cross(c - a);
            leaning[i] |= normals[i].dot(face) < 0.15;
        }
    }
    for (i, sum) in sums.iter().enumerate().filter(|(i, _)| leaning[*i]) {
        normals[i] = sum.as_vec3().try_normalize().unwrap_or(normals[i]);
    }
    for t in triangles.iter_mut() {
        let face = face_normal(corners(positions, t));
        for i in t {
            if normals[*i as usize].dot(face) <= 0.0 {
                positions.push(positions[*i as usize]);
                normals.push(face);
                *i = positions.len() as u32 - 1;
            }
        }
    }
}

/// Positions by first appearance and triangles over them without the degenerate ones.
fn weld(mesh: &Mesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut positions = Vec::with_capacity(mesh.positions.len());
    let remap: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let p = *p + DVec3::ZERO; // -0 becomes +0
            *known
                .entry(p.to_array().map(f64::to_bits))
                .or_insert_with(|| {
                    positions.push(p);
                    positions.len() as u32 - 1
                })
        })
        .collect();
    let triangles = mesh
        .triangles
        .iter()
        .map(|t| t.map(|i| remap[i as usize]))
        .filter(|&[a, b, c]| {
            let [pa, pb, pc] = [a, b, c].map(|i| positions[i as usize]);
            a != b && b != c && c != a && (pb - pa).cross(pc - pa).length_squared() > 1e-24
        })
        .collect();
    (positions, triangles)
}

/// Faces around each vertex, in face order.
struct Incidence {
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl Incidence {
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut start = vec![0u32; vertices + 1];
        for vertex in triangles.iter().flatten() {
            start[*vertex as usize + 1] += 1;
        }
        for i in 0..vertices {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut faces = vec![0; triangles.len() * 3];
        for (face, triangle) in triangles.iter().enumerate() {
            for &vertex in triangle {
                faces[next[vertex as usize] as usize] = face as u32;
                next[vertex as usize] += 1;
            }
        }
        Self { start, faces }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        &self.faces[self.start[v] as usize..self.start[v + 1] as usize]
    }
}
