//! Leaves, bushes and grass: many small kites, two triangles each, seen from both sides.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::sample::Rng;
use crate::scene::Mesh;

/// Separates the random numbers of leaves from those of [`super::jitter`].
const STREAM: u64 = 0x1eaf;

/// Appends a kite from its stalk at `at` along `along` (its length), `half_width` to either side, its
/// front towards `facing`.
fn push_leaf(mesh: &mut Mesh, at: DVec3, along: DVec3, facing: DVec3, half_width: f64) {
    let side = along.cross(facing).normalize_or(DVec3::X) * half_width;
    let normal = side.cross(along).normalize_or(DVec3::Y);
    let wide = at + along * 0.4;
    let base = mesh.positions.len() as u32;
    mesh.positions
        .extend([at, wide + side, at + along, wide - side]);
    mesh.normals.extend([normal.as_vec3(); 4]);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| base + i);
    mesh.triangles.extend([[a, b, c], [a, c, d]]);
}

/// A lump of leaves.
#[derive(Clone, Copy, Debug)]
pub struct Bush {
    pub centre: [f64; 3],
    pub radii: [f64; 3],
    pub leaves: usize,
    /// Length of a leaf.
    pub leaf: f64,
    /// Distinguishes one bush from another.
    pub key: u64,
}

/// Leaves in the outer part of a lumpy ellipsoid, most of them facing outwards and up.
pub fn bush(seed: u64, bush: Bush) -> Mesh {
    let mut mesh = Mesh::default();
    let centre = DVec3::from(bush.centre);
    let radii = DVec3::from(bush.radii);
    let phase = Rng::new(seed, STREAM, bush.key, u64::MAX).next_f64() * TAU;
    for i in 0..bush.leaves {
        let mut rng = Rng::new(seed, STREAM, bush.key, i as u64);
        let out = direction(&mut rng);
        let lump = 1.0
            + 0.13 * (out.x * 5.0 + phase).sin() * (out.y * 6.0 + phase).cos()
            + 0.08 * (out.z * 9.0 - phase).sin();
        let depth = 1.0 - 0.45 * rng.next_f64().powi(2);
        let at = centre + radii * out * lump * depth;
        let facing = (out + DVec3::Y * 0.5 + direction(&mut rng) * 0.8).normalize_or(DVec3::Y);
        let along = facing
            .cross(direction(&mut rng))
            .normalize_or(facing.any_orthonormal_vector());
        let length = bush.leaf * (0.7 + 0.6 * rng.next_f64());
        push_leaf(&mut mesh, at, along * length, facing, length * 0.32);
    }
    mesh
}

/// A tuft of narrow blades that bend outwards, `height` metres high.
pub fn tuft(seed: u64, key: u64, at: [f64; 3], [blades, height]: [f64; 2]) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..blades as u64 {
        let mut rng = Rng::new(seed, STREAM + 1, key, i);
        let turn = DVec3::new(1.0, 0.0, 0.0).rotate_y(TAU * rng.next_f64());
        let lean = 0.2 + 0.5 * rng.next_f64();
        let tall = height * (0.6 + 0.6 * rng.next_f64());
        let foot = DVec3::from(at) + turn * (height * 0.25 * rng.next_f64());
        let along = (DVec3::Y + turn * lean) * tall;
        push_leaf(
            &mut mesh,
            foot,
            along,
            DVec3::Y - turn * 0.3,
            height * 0.045,
        );
    }
    mesh
}

/// A uniform direction.
fn direction(rng: &mut Rng) -> DVec3 {
    let y = 2.0 * rng.next_f64() - 1.0;
    let (sin, cos) = (TAU * rng.next_f64()).sin_cos();
    let across = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(across * cos, y, across * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_keep_to_their_bush_and_face_as_wound() {
        let radii = [0.5, 1.0, 2.0];
        let leafy = bush(
            1,
            Bush {
                centre: [3.0, 1.0, 0.0],
                radii,
                leaves: 500,
                leaf: 0.05,
                key: 7,
            },
        );
        assert_eq!(leafy.triangles.len(), 1000);
        for p in &leafy.positions {
            let q = (*p - DVec3::new(3.0, 1.0, 0.0)) / DVec3::from(radii);
            assert!(q.length() < 1.5, "{p}");
        }
        for t in &leafy.triangles {
            let normal = super::super::face_normal(t.map(|i| leafy.positions[i as usize]));
            assert!(normal.dot(leafy.normals[t[0] as usize]) > 0.99);
        }
    }
}
