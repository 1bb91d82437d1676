//! Analytic shapes as triangles, in the object spaces and with the texture coordinates of Mitsuba.
//!
//! Texture coordinates follow the house rule (v = 0 is the bottom row), so `v` is one minus Mitsuba's
//! where an importer asks for it.

use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::Mesh;

/// Segments around spheres, disks and cylinders: the chord error is 0.03 % of the radius.
const SEGMENTS: u32 = 128;

/// `[-1,1]²` in the xy plane, normal +z.
pub(super) fn rectangle() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        positions: corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners
            .map(|(x, y)| Vec2::new(x as f32 * 0.5 + 0.5, y as f32 * 0.5 + 0.5))
            .to_vec(),
        colours: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// `[-1,1]³` with outward normals, each face with the coordinates of the unit square.
pub(super) fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for (normal, right) in [
        (DVec3::X, DVec3::NEG_Z),
        (DVec3::NEG_X, DVec3::Z),
        (DVec3::Y, DVec3::X),
        (DVec3::NEG_Y, DVec3::X),
        (DVec3::Z, DVec3::X),
        (DVec3::NEG_Z, DVec3::NEG_X),
    ] {
        let up = normal.cross(right);
        let mut face = rectangle();
        for p in &mut face.positions {
            *p = right * p.x + up * p.y + normal;
        }
        face.normals = vec![normal.as_vec3(); 4];
        mesh.append(&face);
    }
    mesh
}

/// A sphere with smooth outward normals, poles on ±z, vertices on the sphere.
pub(super) fn sphere(centre: DVec3, radius: f64) -> Mesh {
    let rows = SEGMENTS / 2;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        let (sin_theta, cos_theta) = (TAU * 0.5 * f64::from(row) / f64::from(rows)).sin_cos();
        for column in 0..=SEGMENTS {
            let (sin_phi, cos_phi) = (TAU * f64::from(column) / f64::from(SEGMENTS)).sin_cos();
            let normal = DVec3::new(cos_phi * sin_theta, sin_phi * sin_theta, cos_theta);
            mesh.positions.push(centre + normal * radius);
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(Vec2::new(
                column as f32 / SEGMENTS as f32,
                row as f32 / rows as f32,
            ));
        }
    }
    let stride = SEGMENTS + 1;
    for row in 0..rows {
        for column in 0..SEGMENTS {
            let a = row * stride + column;
            let b = a + stride;
            if row > 0 {
                mesh.triangles.push([a, b, a + 1]);
            }
            if row + 1 < rows {
                mesh.triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    mesh
}

/// Unit disk in the xy plane, normal +z; u is the radius, v the angle.
pub(super) fn disk() -> Mesh {
    let mut mesh = Mesh::default();
    for column in 0..=SEGMENTS {
        let turn = f64::from(column) / f64::from(SEGMENTS);
        let (sin, cos) = (TAU * turn).sin_cos();
        mesh.positions.push(DVec3::ZERO);
        mesh.positions.push(DVec3::new(cos, sin, 0.0));
        mesh.uvs.push(Vec2::new(0.0, turn as f32));
        mesh.uvs.push(Vec2::new(1.0, turn as f32));
    }
    mesh.normals = vec![Vec3::Z; mesh.positions.len()];
    mesh.triangles = (0..SEGMENTS)
        .map(|i| [2 * i, 2 * i + 1, 2 * i + 3])
        .collect();
    mesh
}

/// An open cylinder around the segment `from`–`to` with outward normals; u is the angle.
pub(super) fn cylinder([from, to]: [DVec3; 2], radius: f64) -> Mesh {
    let axis = (to - from).normalize_or(DVec3::Z);
    let (right, up) = axis.any_orthonormal_pair();
    let mut mesh = Mesh::default();
    for column in 0..=SEGMENTS {
        let turn = f64::from(column) / f64::from(SEGMENTS);
        let (sin, cos) = (TAU * turn).sin_cos();
        let normal = right * cos + up * sin;
        for (end, v) in [(from, 0.0), (to, 1.0)] {
            mesh.positions.push(end + normal * radius);
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(Vec2::new(turn as f32, v));
        }
    }
    for i in 0..SEGMENTS {
        let a = 2 * i;
        mesh.triangles.push([a, a + 2, a + 1]);
        mesh.triangles.push([a + 1, a + 2, a + 3]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn area_and_outward(mesh: &Mesh) -> f64 {
        let mut area = 0.0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let n = (b - a).cross(c - a);
            for i in t {
                let facing = n.as_vec3().dot(mesh.normals[*i as usize]);
                assert!(facing > 0.0, "winding disagrees with the normal");
            }
            area += n.length() * 0.5;
        }
        area
    }

    #[test]
    fn areas_and_windings() {
        let near = |mesh: &Mesh, expected: f64| {
            let area = area_and_outward(mesh);
            assert!((area / expected - 1.0).abs() < 1e-3, "{area} {expected}");
        };
        near(&rectangle(), 4.0);
        near(&cube(), 24.0);
        near(&sphere(DVec3::new(1.0, 2.0, 3.0), 2.0), 16.0 * PI);
        near(&disk(), PI);
        near(
            &cylinder([DVec3::ZERO, DVec3::new(0.0, 3.0, 0.0)], 0.5),
            3.0 * PI,
        );
        near(&cylinder([DVec3::Z, DVec3::ZERO], 1.0), 2.0 * PI);
    }

    #[test]
    fn the_cube_is_outward_from_its_centre() {
        let mesh = cube();
        assert_eq!(mesh.triangles.len(), 12);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert_eq!(p.as_vec3().dot(*n), 1.0);
        }
    }
}
