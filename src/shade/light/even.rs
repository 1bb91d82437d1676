//! Choosing among lights evenly, whatever their power.

use super::point::power;
use super::{ChosenPlace, EmittingShape, LightPlace, Lights, pick, radiant_exitance, usable};
use crate::sample::Rng;

/// The lights of a scene that shine, to be chosen with the same probability each: every emitting shape, point and spot
/// light and directional light is one, and the environment. Places on a shape are even in area.
pub struct EvenLights<'l, 's> {
    lights: &'l Lights<'s>,
    choices: Vec<Choice>,
}

enum Choice {
    Shape(EmittingShape),
    Point(u32),
    Parallel(u32),
    Environment,
}

impl<'l, 's> EvenLights<'l, 's> {
    /// Collects what shines.
    pub fn new(lights: &'l Lights<'s>) -> Self {
        let scene = lights.scene;
        let shapes = lights.emitting_shapes().map(Choice::Shape);
        let mut choices: Vec<Choice> = shapes.collect();
        for (index, light) in (0..).zip(&scene.point_lights) {
            if power(light) > 0.0 {
                choices.push(Choice::Point(index));
            }
        }
        for (index, (_, irradiance)) in (0..).zip(&scene.directional_lights) {
            if usable(*irradiance) > 0.0 {
                choices.push(Choice::Parallel(index));
            }
        }
        if lights.groups[3] > 0.0 {
            choices.push(Choice::Environment);
        }
        Self { lights, choices }
    }

    /// A place on one of them; `None` where nothing shines.
    pub fn choose(&self, rng: &mut Rng) -> Option<ChosenPlace> {
        let chance = 1.0 / self.choices.len() as f64;
        let choice = self.choices.get(rng.below(self.choices.len()))?;
        let which = rng.next_f64();
        let at = [rng.next_f32(), rng.next_f32()];
        let (place, density) = match choice {
            Choice::Shape(shape) => {
                let sums = &self.lights.triangle_power[..shape.triangles.end];
                let [before, with] = shape.sums;
                let target = (before + which * (with - before)) / with;
                let index = pick(sums, target).max(shape.triangles.start);
                let triangle = &self.lights.triangles[index];
                let place = LightPlace::Triangle(triangle.number, at);
                let exitance = radiant_exitance(triangle.emission.into());
                (place, chance * exitance / shape.power())
            }
            Choice::Point(index) => (LightPlace::Point(*index), chance),
            Choice::Parallel(index) => (LightPlace::Parallel(*index), chance),
            Choice::Environment => {
                let chosen = self.lights.choose_environment(at)?;
                (chosen.place, f64::from(chosen.density) * chance)
            }
        };
        Some(ChosenPlace {
            place,
            density: density as f32,
        })
    }
}
