//! The texels of a scene, and what directions of their cones mean.

use std::sync::Arc;

use glam::Vec3;

use super::options::Orientation;
use super::stillness::Stillness;
use crate::cache::surface::{Blocks, Charts, Grid, SurfacePoint};
use crate::sample::Frame;
use crate::scene::Scene;
use crate::trace::Hit;

/// The charts of a scene and the texels that somebody asked for.
pub(super) struct Surfaces {
    pub charts: Arc<Charts>,
    pub grid: Grid,
    pub blocks: Blocks,
    pub stillness: Stillness,
}

/// A texel's point as a hit.
pub(super) fn hit_of(point: SurfacePoint) -> Hit {
    Hit {
        t: 0.0,
        u: point.u,
        v: point.v,
        triangle: point.triangle,
    }
}

/// Unit normal of a triangle on one of its sides.
pub(super) fn normal_of(scene: &Scene, triangle: u32, back: bool) -> Vec3 {
    let [a, b, c] = corners(scene, triangle);
    let (e1, e2) = (b - a, c - a);
    let scale = e1.abs().max_element().max(e2.abs().max_element());
    let normal = (e1 / scale).cross(e2 / scale).normalize_or(Vec3::Z);
    if back { -normal } else { normal }
}

/// Twice the area of a triangle as it lies now, scene units².
pub(super) fn twice_area(scene: &Scene, triangle: u32) -> f32 {
    let [a, b, c] = corners(scene, triangle);
    (b - a).cross(c - a).length()
}

/// The frame that the cones of a texel are told in, as its triangle lies now, with this [`normal_of`] the texel's side.
pub(super) fn frame_of(
    scene: &Scene,
    triangle: u32,
    normal: Vec3,
    orientation: Orientation,
) -> Frame {
    if orientation == Orientation::World {
        return Frame {
            tangent: Vec3::X,
            bitangent: Vec3::Y,
            normal: Vec3::Z,
        };
    }
    let [a, b, _] = corners(scene, triangle);
    let along = b - a;
    let across = along - normal * along.dot(normal);
    let tangent = (across / across.abs().max_element()).try_normalize();
    let Some(tangent) = tangent else {
        return Frame::from_normal(normal);
    };
    Frame {
        tangent,
        bitangent: normal.cross(tangent),
        normal,
    }
}

fn corners(scene: &Scene, triangle: u32) -> [Vec3; 3] {
    scene.triangles[triangle as usize].map(|i| scene.positions[i as usize])
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn triangle(turn: Quat, size: f32) -> Scene {
        let corners = [
            Vec3::ZERO,
            Vec3::new(2.0, 0.5, 0.0),
            Vec3::new(0.3, 1.0, 0.1),
        ];
        let mut scene = Scene::default();
        scene.positions = corners.map(|p| turn * p * size).to_vec();
        scene.triangles = vec![[0, 1, 2]];
        scene
    }

    #[test]
    fn frames_turn_with_their_triangle_and_have_its_normal_on_either_side() {
        let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0);
        for (back, scale) in [(false, 1.0), (true, 1e-4), (true, 1e5)] {
            let still = triangle(Quat::IDENTITY, scale);
            let of = |scene: &Scene| {
                let normal = normal_of(scene, 0, back);
                frame_of(scene, 0, normal, Orientation::Surface)
            };
            let (before, after) = (of(&still), of(&triangle(turn, scale)));
            let direction = Vec3::new(0.1, 0.7, -0.4);
            let carried = turn * before.to_world(direction);
            assert!((after.to_world(direction) - carried).length() < 1e-5);
            assert!((before.to_local(before.to_world(direction)) - direction).length() < 1e-5);
            assert_eq!(before.normal, normal_of(&still, 0, back));
            assert_eq!(before.normal.z < 0.0, back);
            let world = frame_of(&still, 0, Vec3::X, Orientation::World);
            assert_eq!(world.to_world(direction), direction);
        }
    }
}
