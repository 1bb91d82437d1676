//! What shines of a world that moves: emitting shapes, lights without extent and the environment.

use glam::{DAffine3, DQuat, DVec3, Mat3};

use super::FARTHEST;
use crate::scene::motion::{MotionDescription, Placement};
use crate::scene::track::Track;
use crate::scene::{LightDescription, LightKind, Scene, SceneDescription};

/// What shines, as the scene file has it, and how that changes.
pub(super) struct Lamps {
    motions: Vec<MotionDescription>,
    /// Emission of the shapes that change theirs, with the index of the shape.
    shapes: Vec<(usize, [f32; 3])>,
    /// Lights without extent; empty where the technique needs none or none changes.
    lights: Vec<LightKind>,
    /// Of the environment to the world at rest, if it turns.
    environment: Option<Mat3>,
}

impl Lamps {
    /// What changes of a scene as far as it was loaded.
    pub fn new(
        scene: &Scene,
        lights: &[LightDescription],
        motions: Vec<MotionDescription>,
    ) -> Self {
        let with_strength = motions.iter().filter(|motion| !motion.strength.is_empty());
        let mut changing: Vec<usize> = with_strength.flat_map(|m| m.shapes.clone()).collect();
        changing.sort_unstable();
        changing.dedup();
        let emission = |i: usize| Some((i, scene.shapes.get(i)?.emission?));
        let lit = !scene.point_lights.is_empty() || !scene.directional_lights.is_empty();
        let moves = motions.iter().any(|motion| !motion.lights.is_empty());
        let lights = lights.iter().filter(|_| lit && moves);
        let turns = motions.iter().any(|motion| motion.environment);
        let environment = scene.environment.as_ref().filter(|_| turns);
        Self {
            shapes: changing.into_iter().filter_map(emission).collect(),
            lights: lights.map(|light| light.kind.clone()).collect(),
            environment: environment.map(|environment| environment.to_world()),
            motions,
        }
    }

    /// The first light or shape that gets or shines beyond single precision at a key, in words, and when.
    pub fn beyond(&self, names: &SceneDescription) -> Option<(String, f64)> {
        let keys = self.motions.iter().flat_map(|motion| {
            let strengths = motion.strength.iter().flat_map(Track::times_s);
            motion.times_s().into_iter().chain(strengths.copied())
        });
        let mut keys: Vec<f64> = keys.collect();
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        keys.into_iter().find_map(|time_s| {
            let shape = self.shapes.iter().find(|(shape, emission)| {
                let factor = self.shape_strength(*shape, time_s);
                !emission.iter().all(|e| (e * factor).is_finite())
            });
            let light = (0..self.lights.len()).find(|&i| !is_held(&self.light(i, time_s)));
            let shape =
                shape.map(|(i, _)| format!("emission of shape `{}`", names.shapes[*i].name));
            let light = light.map(|i| format!("light `{}`", names.lights[i].name));
            shape.or(light).map(|what| (what, time_s))
        })
    }

    /// Lets everything shine as it does at a time.
    pub fn put(&self, scene: &mut Scene, time_s: f64) {
        for (shape, emission) in &self.shapes {
            let factor = self.shape_strength(*shape, time_s);
            scene.shapes[*shape].emission = Some(emission.map(|e| e * factor));
        }
        if !self.lights.is_empty() {
            let lights: Vec<LightKind> = (0..self.lights.len())
                .map(|light| self.light(light, time_s))
                .collect();
            scene.set_lights_without_extent(&lights);
        }
        if let (Some(rest), Some(environment)) = (self.environment, &mut scene.environment) {
            let turn = self
                .motions
                .iter()
                .filter(|motion| motion.environment)
                .map(|motion| motion.placement.at(time_s))
                .fold(DAffine3::IDENTITY, |all, next| next * all);
            let turn = DQuat::from_mat3(&turn.matrix3).normalize();
            environment.turn_to(Mat3::from_quat(turn.as_quat()) * rest);
        }
    }

    /// A light at a time.
    fn light(&self, light: usize, time_s: f64) -> LightKind {
        let mut kind = self.lights[light].clone();
        let own = self.motions.iter().filter(|m| m.lights.contains(&light));
        for motion in own {
            kind.carry(&motion.placement.at(time_s));
        }
        kind.scale(self.strength(time_s, |motion| motion.lights.contains(&light)));
        kind
    }

    fn shape_strength(&self, shape: usize, time_s: f64) -> f32 {
        self.strength(time_s, |motion| motion.shapes.contains(&shape))
    }

    fn strength(&self, time_s: f64, moves: impl Fn(&MotionDescription) -> bool) -> f32 {
        let own = self.motions.iter().filter(|motion| moves(motion));
        let factors = own.flat_map(|motion| &motion.strength);
        factors.map(|track| track.at(time_s)).product::<f64>() as f32
    }
}

/// Whether single precision holds where a light is and what it sends.
fn is_held(light: &LightKind) -> bool {
    let place = match light {
        LightKind::Point { position, .. } | LightKind::Spot { position, .. } => *position,
        LightKind::Directional { .. } => DVec3::ZERO,
    };
    let is_near = place.abs().cmple(DVec3::splat(FARTHEST)).all();
    is_near && light.strength().iter().all(|value| value.is_finite())
}

/// The placements of a shape at a time, one after another.
pub(super) fn carried(placements: &[Placement], time_s: f64) -> DAffine3 {
    let maps = placements.iter().map(|placement| placement.at(time_s));
    maps.fold(DAffine3::IDENTITY, |all, next| next * all)
}
