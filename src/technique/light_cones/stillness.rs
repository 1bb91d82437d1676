//! Whether anything of a scene changes from frame to frame.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::sample::hash;
use crate::scene::Scene;

/// What the last frame was like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Stillness {
    /// Of lights and shapes; `None` before the first frame.
    fingerprint: Option<u64>,
    /// Of which lights shine.
    shining: u64,
    /// Frames since something changed.
    pub frames: u32,
    /// Whether a light was switched on or off since the last frame.
    pub switched: bool,
}

/// Numbers that are hashed one after another.
const RUN: usize = 4096;

impl Stillness {
    /// Takes in the scene of the next frame; before the first one nothing has changed.
    pub fn next(&mut self, scene: &Scene) {
        let now = fingerprint(scene);
        let before = std::mem::replace(&mut self.shining, shining(scene));
        self.switched = self.fingerprint.is_some() && before != self.shining;
        self.frames = match self.fingerprint.replace(now) {
            None => u32::MAX,
            Some(before) if before == now => self.frames.saturating_add(1),
            Some(_) => 0,
        };
    }
}

/// A number that changes with which lights shine.
fn shining(scene: &Scene) -> u64 {
    let shapes = scene.shapes.iter().map(|shape| shape.emission);
    let points = scene.point_lights.iter().map(|light| Some(light.intensity));
    let parallel = scene
        .directional_lights
        .iter()
        .map(|(_, light)| Some(*light));
    let shines = |light: Option<[f32; 3]>| light.is_some_and(|light| light != [0.0; 3]);
    let all = shapes.chain(points).chain(parallel).map(shines);
    all.fold(0, |all, shines| hash(all << 1 ^ u64::from(shines)))
}

/// A number that changes with where shapes and lights are and what they send.
fn fingerprint(scene: &Scene) -> u64 {
    let runs: Vec<u64> = scene
        .positions
        .par_chunks(RUN)
        .map(|run| hashed(run.iter().flat_map(|p| p.to_array())))
        .collect();
    let emission = scene
        .shapes
        .iter()
        .flat_map(|shape| shape.emission.unwrap_or_default());
    let points = scene.point_lights.iter().flat_map(|light| {
        // Where a spot light turns, what it sends to the axes changes.
        let axes = [glam::Vec3::X, glam::Vec3::Y, glam::Vec3::Z];
        let sent = axes.map(|axis| light.cone.map_or(0.0, |cone| cone.angle(axis)));
        let numbers = light.position.to_array().into_iter().chain(light.intensity);
        numbers.chain(sent)
    });
    let parallel = scene
        .directional_lights
        .iter()
        .flat_map(|(direction, irradiance)| direction.to_array().into_iter().chain(*irradiance));
    // Maps turn, and nothing else of them changes.
    let sky = scene.environment.iter().flat_map(|map| {
        let texels = [[0, 0], [map.width() / 4, map.height() / 2]];
        texels
            .map(|[x, y]| map.texel_direction(x, y).to_array())
            .concat()
    });
    let rest = hashed(emission.chain(points).chain(parallel).chain(sky));
    runs.into_iter().fold(rest, |all, run| hash(all ^ run))
}

fn hashed(numbers: impl Iterator<Item = f32>) -> u64 {
    numbers.fold(0, |all, number| hash(all ^ u64::from(number.to_bits())))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{PointLight, Shape};

    fn scene() -> Scene {
        let light = PointLight {
            position: Vec3::Y,
            intensity: [1.0; 3],
            cone: None,
        };
        let lamp = Shape {
            emission: Some([1.0, 2.0, 3.0]),
            ..Shape::default()
        };
        let mut scene = Scene::default();
        scene.positions = vec![Vec3::X; 10_000];
        scene.shapes = vec![Shape::default(), lamp];
        scene.point_lights = vec![light];
        scene.directional_lights = vec![(Vec3::NEG_Y, [1.0; 3])];
        scene
    }

    #[test]
    fn frames_are_counted_since_anything_changed() {
        let changes: [fn(&mut Scene); 5] = [
            |scene| scene.positions[9_999].z = 1e-6,
            |scene| scene.shapes[1].emission = Some([1.0, 2.0, 3.5]),
            |scene| scene.point_lights[0].position.x = 0.1,
            |scene| scene.point_lights.clear(),
            |scene| scene.directional_lights[0].0 = Vec3::NEG_X,
        ];
        for change in changes {
            let mut stillness = Stillness::default();
            stillness.next(&scene());
            assert_eq!(stillness.frames, u32::MAX, "nothing was before");
            let mut other = scene();
            change(&mut other);
            let frames = [&other, &other, &other, &scene()].map(|scene| {
                stillness.next(scene);
                stillness.frames
            });
            assert_eq!(frames, [0, 1, 2, 0]);
        }
    }
}
