//! The normals of surface points: of triangles, interpolated, and bent by textures.

use glam::{Vec2, Vec3};

use crate::image::luminance;
use crate::sample::Frame;
use crate::scene::{Scene, Texture};

/// Of a triangle with these edges, whatever their lengths.
pub(super) fn unit_normal(e1: Vec3, e2: Vec3) -> Vec3 {
    let scale = e1.abs().max_element().max(e2.abs().max_element());
    (e1 / scale).cross(e2 / scale).normalize_or(Vec3::Z)
}

/// Interpolated from the corners; `None` where one of them has none.
pub(super) fn shading_normal(
    scene: &Scene,
    corners: [usize; 3],
    weights: [f32; 3],
) -> Option<Vec3> {
    if scene.normals.is_empty() {
        return None;
    }
    let normals = corners.map(|i| scene.normals[i]);
    if normals.contains(&Vec3::ZERO) {
        return None;
    }
    (0..3)
        .fold(Vec3::ZERO, |sum, i| sum + weights[i] * normals[i])
        .try_normalize()
}

/// Derivatives of the position by u and v; an orthonormal pair where the map is degenerate.
pub(super) fn uv_tangents([e1, e2]: [Vec3; 2], uvs: [Vec2; 3], normal: Vec3) -> [Vec3; 2] {
    let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let determinant = d1.perp_dot(d2);
    if determinant == 0.0 || !(1.0 / determinant).is_finite() {
        let frame = Frame::from_normal(normal);
        return [frame.tangent, frame.bitangent];
    }
    let inverse = 1.0 / determinant;
    [
        (e1 * d2.y - e2 * d1.y) * inverse,
        (e2 * d1.x - e1 * d2.x) * inverse,
    ]
}

/// A normal bent by a texture, turned half around the shading normal where only one of both faces the viewer, who would
/// see black there (as Mitsuba's `normalmap` and `bumpmap` do from version 3.6 on).
pub(super) fn turned_to_viewer(mapped: Vec3, shading_normal: Vec3, view: Vec3) -> Vec3 {
    if mapped.dot(view) * shading_normal.dot(view) > 0.0 {
        return mapped;
    }
    2.0 * mapped.dot(shading_normal) * shading_normal - mapped
}

/// How much a bent normal weakens grazing light: the squared roughness of Estevez et al. 2019, 0 where it is not bent.
pub(super) fn bend(bent: Vec3, shading_normal: Vec3) -> f32 {
    (0.125 * tangent_squared(bent.dot(shading_normal))).clamp(0.0, 1.0)
}

/// The share of light at a cosine to the shading normal that a bend leaves.
pub(super) fn left_by(bend: f32, cos_light: f32) -> f32 {
    2.0 / (1.0 + (1.0 + bend * tangent_squared(cos_light)).sqrt())
}

fn tangent_squared(cos: f32) -> f32 {
    let squared = (cos * cos).clamp(1e-12, 1.0);
    (1.0 - squared) / squared
}

/// The normal of the surface displaced along `normal` by a height of this gradient by (u, v).
pub(super) fn bumped(normal: Vec3, [by_u, by_v]: [Vec3; 2], gradient: Vec2) -> Vec3 {
    let lifted_u = by_u + normal * (gradient.x - normal.dot(by_u));
    let lifted_v = by_v + normal * (gradient.y - normal.dot(by_v));
    lifted_u.cross(lifted_v).try_normalize().unwrap_or(normal)
}

/// The normal that a texture holds, about a shading normal with u along a tangent.
pub(super) fn mapped(texture: &Texture, uv: Vec2, [along, normal]: [Vec3; 2]) -> Vec3 {
    let [x, y, z] = texture.lookup(uv).map(|value| 2.0 * value - 1.0);
    let tangent = along.reject_from_normalized(normal).try_normalize();
    let Some(tangent) = tangent else {
        return normal;
    };
    let mapped = tangent * x + normal.cross(tangent) * y + normal * z;
    mapped.try_normalize().unwrap_or(normal)
}

/// Derivatives of a texture's luminance by u and v, by differences of a tenth of a texel.
pub(super) fn height_gradient(texture: &Texture, uv: Vec2) -> Vec2 {
    let step = |size: usize| 0.05 / size.max(1) as f32;
    let slope = |offset: Vec2| {
        let [ahead, behind] = [uv + offset, uv - offset];
        let rise = luminance(texture.lookup(ahead)) - luminance(texture.lookup(behind));
        rise / (ahead - behind).length().max(f32::MIN_POSITIVE)
    };
    Vec2::new(
        slope(Vec2::new(step(texture.width), 0.0)),
        slope(Vec2::new(0.0, step(texture.height))),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_maps_that_face_away_are_turned_half_around() {
        // What Mitsuba 3.9.1 answers for such views.
        let mapped = Vec3::new(0.8, 0.0, 0.6);
        let of = |view: Vec3| turned_to_viewer(mapped, Vec3::Z, view);
        assert_eq!(of(Vec3::new(0.9, 0.0, 0.436)), mapped);
        let turned = of(Vec3::new(-0.9, 0.0, 0.436));
        assert!((turned - Vec3::new(-0.8, 0.0, 0.6)).length() < 1e-6);
        assert_eq!(of(Vec3::new(-0.9, 0.0, -0.436)), mapped);
    }

    #[test]
    fn bent_normals_weaken_grazing_light() {
        // What Mitsuba 3.9.1 answers for a bump of slope 2.
        let bent = bend(Vec3::new(-2.0, 0.0, 1.0).normalize(), Vec3::Z);
        for (slope, expected) in [(0.0_f32, 1.0), (1.0, 0.8990), (3.0, 0.5979)] {
            let cos = 1.0 / (1.0 + slope * slope).sqrt();
            assert!((left_by(bent, cos) - expected).abs() < 1e-4, "{slope}");
        }
        assert_eq!(left_by(bend(Vec3::Z, Vec3::Z), 0.0), 1.0);
    }

    #[test]
    fn bumps_tilt_against_the_slope() {
        let tangents = [Vec3::X * 2.0, Vec3::Y * 2.0];
        assert_eq!(bumped(Vec3::Z, tangents, Vec2::ZERO), Vec3::Z);
        // A rise of 2 per unit u, one u being 2 long: 45°.
        let tilted = bumped(Vec3::Z, tangents, Vec2::new(2.0, 0.0));
        assert!((tilted - Vec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn tangents_invert_the_texture_map() {
        let uvs = [
            Vec2::new(0.1, 0.2),
            Vec2::new(0.5, 0.3),
            Vec2::new(0.2, 0.9),
        ];
        let (by_u, by_v) = (Vec3::new(1.0, 2.0, 0.5), Vec3::new(-0.3, 1.0, 4.0));
        let edge = |i: usize| {
            let d = uvs[i] - uvs[0];
            by_u * d.x + by_v * d.y
        };
        let found = uv_tangents([edge(1), edge(2)], uvs, Vec3::Z);
        assert!((found[0] - by_u).length() < 1e-5 && (found[1] - by_v).length() < 1e-5);
        let flat = uv_tangents([Vec3::X, Vec3::Y], [Vec2::ZERO; 3], Vec3::Z);
        assert!(flat[0].cross(flat[1]).dot(Vec3::Z) > 0.99);
    }

    #[test]
    fn normals_survive_any_scale() {
        for scale in [1e-15f32, 1.0, 1e15] {
            let n = unit_normal(Vec3::X * scale, Vec3::Y * scale);
            assert!((n - Vec3::Z).length() < 1e-6);
        }
    }
}
