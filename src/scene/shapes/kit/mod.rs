//! The small kit every generator composes from: parametric surfaces, solids, sweeps, cloth, foliage
//! and implicit bodies. Lengths are metres, y is up, winding is outward.

pub mod cloth;
pub mod field;
pub mod foliage;
pub mod implicit;
pub mod round;
pub mod shade;
pub mod solid;
pub mod sweep;

use glam::{DMat4, DVec3, Mat3, Vec3};

use crate::scene::Mesh;

pub use cloth::sheet;
pub use foliage::{Bush, bush, tuft};
pub use implicit::polygonise;
pub use round::{capsule, cylinder, lathe, rounded_box, smooth_profile, sphere, torus};
pub use shade::shade;
pub use solid::{Opening, bevelled_box, cuboid, strip_solid, wall};
pub use sweep::{circle, curve, sweep, tube};

/// A crease angle that keeps right angles sharp and rounds the facets of curved bodies.
pub const CREASE_DEG: f64 = 42.0;

/// A vertex lattice of `count` vertices per direction; a wrapped direction joins its ends. The front
/// side is `d/du × d/dv`. The mesh has no normals yet.
pub fn lattice(
    count: [usize; 2],
    wrap: [bool; 2],
    position: impl Fn(usize, usize) -> DVec3,
) -> Mesh {
    lattice_of(count, wrap, &position)
}

/// Compiled once for all lattices; so are the kit's other shapes that take functions.
fn lattice_of(
    count: [usize; 2],
    wrap: [bool; 2],
    position: &dyn Fn(usize, usize) -> DVec3,
) -> Mesh {
    let [columns, rows] = count;
    let mut mesh = Mesh::default();
    for v in 0..rows {
        mesh.positions.extend((0..columns).map(|u| position(u, v)));
    }
    let index = |u: usize, v: usize| ((v % rows) * columns + u % columns) as u32;
    let cells = |n: usize, wrapped: bool| if wrapped { n } else { n.saturating_sub(1) };
    for v in 0..cells(rows, wrap[1]) {
        for u in 0..cells(columns, wrap[0]) {
            let [a, b, c, d] = [
                index(u, v),
                index(u + 1, v),
                index(u + 1, v + 1),
                index(u, v + 1),
            ];
            mesh.triangles.push([a, b, c]);
            mesh.triangles.push([a, c, d]);
        }
    }
    mesh
}

/// The mesh moved by `to_world`; mirrored ones keep outward winding.
pub fn placed(mesh: &Mesh, to_world: DMat4) -> Mesh {
    let mut out = mesh.clone();
    for p in &mut out.positions {
        *p = to_world.transform_point3(*p);
    }
    let normal_matrix = Mat3::from_mat4(to_world.as_mat4()).inverse().transpose();
    for n in &mut out.normals {
        *n = (normal_matrix * *n).normalize_or_zero();
    }
    if to_world.determinant() < 0.0 {
        for t in &mut out.triangles {
            t.swap(1, 2);
        }
    }
    out
}

/// The mesh moved by a vector.
pub fn moved(mesh: &Mesh, by: [f64; 3]) -> Mesh {
    placed(mesh, DMat4::from_translation(DVec3::from(by)))
}

/// The mesh turned about +y by `turn_deg`, scaled, then moved.
pub fn set_at(mesh: &Mesh, at: [f64; 3], turn_deg: f64, scale: f64) -> Mesh {
    let turn = DMat4::from_rotation_y(turn_deg.to_radians());
    let to_world = DMat4::from_translation(DVec3::from(at)) * turn;
    placed(mesh, to_world * DMat4::from_scale(DVec3::splat(scale)))
}

/// The rotation that takes +y to `direction`, about the shortest arc.
pub fn y_towards(direction: DVec3) -> DMat4 {
    let direction = direction.normalize_or(DVec3::Y);
    DMat4::from_quat(glam::DQuat::from_rotation_arc(DVec3::Y, direction))
}

/// All meshes as one.
pub fn merged(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    merged_of(&mut meshes.into_iter())
}

fn merged_of(meshes: &mut dyn Iterator<Item = Mesh>) -> Mesh {
    let mut out = Mesh::default();
    for mesh in meshes {
        out.append(&mesh);
    }
    out
}

/// Unit normal of a triangle, zero when it has no area.
pub fn face_normal(corners: [DVec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// A random value in `[low, high)` from its keys.
pub fn jitter(seed: u64, item: u64, range: [f64; 2]) -> f64 {
    let mut rng = crate::sample::Rng::new(seed, 0x5ca1e, item, 0);
    range[0] + (range[1] - range[0]) * rng.next_f64()
}
