//! Point and spot lights, which have no extent: a surface point receives them from one direction.

use super::emit::Emitted;
use super::{LightSample, Lights, pick, usable};
use crate::scene::PointLight;
use crate::shade::surface::Interaction;
use crate::trace::{Ray, offset_origin};

impl<'a> Lights<'a> {
    /// The light that `choice` in [0, 1) selects, and the probability of the selection.
    fn choose_point(&self, choice: f64) -> (&'a PointLight, f64) {
        let index = pick(&self.point_sums, choice);
        (&self.scene.point_lights[index], self.point_chance(index))
    }

    /// Probability with which [`Lights::sample`] selects a point or spot light.
    pub(super) fn point_chance(&self, index: usize) -> f64 {
        self.all.chance(power(&self.scene.point_lights[index]))
    }

    /// `None` where the light is at the surface point itself.
    pub(super) fn sample_point(&self, from: &Interaction, choice: f64) -> Option<LightSample> {
        let (light, probability) = self.choose_point(choice);
        self.point_sample(light, probability, from)
    }

    /// A light, selected with a probability, as seen from a surface.
    pub(super) fn point_sample(
        &self,
        light: &PointLight,
        probability: f64,
        from: &Interaction,
    ) -> Option<LightSample> {
        let towards = light.position - from.position;
        let direction = towards.try_normalize()?;
        let start = self.spawn(from, direction).origin;
        // A light in a surface shines to both of its sides.
        let way = offset_origin(light.position, -direction, self.scene.diagonal) - start;
        Some(LightSample {
            direction,
            radiance: light.irradiance(-towards),
            pdf_sr: probability as f32,
            delta: true,
            shadow_ray: Ray {
                t_max: way.length(),
                ..Ray::new(start, way.try_normalize()?)
            },
        })
    }

    /// The start of a light path; `point` in [0, 1)² selects its direction.
    pub(super) fn emit_from_point(&self, choice: f64, point: [f64; 2]) -> Emitted {
        let (light, probability) = self.choose_point(choice);
        let (direction, solid_angle) = light.direction(point);
        let start = offset_origin(light.position, direction, self.scene.diagonal);
        Emitted {
            source: None,
            ray: Ray::new(start, direction),
            power: light.sent(direction) * (solid_angle / probability as f32),
        }
    }

    /// All point and spot lights that shine.
    pub fn points(&self) -> impl Iterator<Item = &'a PointLight> + use<'a> {
        let lights = self.scene.point_lights.iter();
        lights.filter(|light| power(light) > 0.0)
    }
}

/// Luminance of the power.
pub(super) fn power(light: &PointLight) -> f64 {
    usable(light.intensity) * light.solid_angle()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

    use glam::{DMat4, DVec3, Vec3};

    use super::*;
    use crate::sample::Rng;
    use crate::scene::{
        LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
    };
    use crate::shade::PathTracer;
    use crate::trace::{RayCounter, Tracer};

    const REFLECTANCE: f64 = 0.5;

    fn point(position: [f64; 3], intensity: f32) -> LightKind {
        LightKind::Point {
            position: position.into(),
            intensity: [intensity; 3],
        }
    }

    fn spot(position: [f64; 3], direction: [f64; 3], beam_width_deg: f64) -> LightKind {
        LightKind::Spot {
            position: position.into(),
            direction: direction.into(),
            intensity: [8.0; 3],
            beam_width_deg,
            cutoff_deg: 40.0,
        }
    }

    /// Floor y = 0 of side 20 with a screen of side 2 at y = 1 over x = −5.
    fn scene(lights: &[LightKind]) -> Scene {
        let lying = DMat4::from_rotation_x(-FRAC_PI_2);
        let square = |name, place| ShapeDescription {
            to_world: place,
            ..ShapeDescription::new(name, ShapeSource::Rectangle)
        };
        let screen = DMat4::from_translation(DVec3::new(-5.0, 1.0, 0.0)) * lying;
        let eye = [DVec3::new(0.0, 5.0, 9.0), DVec3::ZERO, DVec3::Y];
        let description = SceneDescription {
            views: vec![View::look_at("v", eye, 60.0, [8, 8])],
            materials: vec![Material::diffuse("grey", [REFLECTANCE as f32; 3])],
            shapes: vec![
                square("floor", lying * DMat4::from_scale(DVec3::splat(10.0))),
                square("screen", screen),
            ],
            lights: lights.iter().cloned().map(Into::into).collect(),
            ..SceneDescription::default()
        };
        Scene::build(&description, Needs::ALL).expect("a scene")
    }

    /// Mean radiance that the floor at x sends up.
    fn radiance(scene: &Scene, x: f64) -> f64 {
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let paths = PathTracer::new(scene, &tracer);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let eye = DVec3::new(x, 0.9, 0.1) - scene.origin;
        let down = Vec3::new(0.0, -0.9, -0.1).normalize();
        let hit = caster
            .closest(&Ray::new(eye.as_vec3(), down))
            .expect("the floor");
        let at = paths.surfaces().interact(&hit, down);
        let samples = 40_000;
        let sum: f64 = (0..samples)
            .map(|sample| {
                let found = paths.direct(&caster, &at, &mut Rng::new(1, 2, 3, sample));
                assert!(found.is_finite());
                f64::from(found.x)
            })
            .sum();
        sum / samples as f64
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        let error = (found - expected).abs();
        assert!(error <= tolerance * expected, "{found} {expected}");
    }

    #[test]
    fn a_floor_receives_intensity_times_cosine_over_squared_distance() {
        let scene = scene(&[point([1.0, 2.0, 0.0], 6.0)]);
        for x in [1.0, 0.0, 3.0] {
            let squared: f64 = 4.0 + (x - 1.0) * (x - 1.0);
            let irradiance = 6.0 * 2.0 / squared.sqrt() / squared;
            assert_near(
                radiance(&scene, x),
                REFLECTANCE * FRAC_1_PI * irradiance,
                1e-5,
            );
        }
        assert_eq!(radiance(&scene, -9.5), 0.0, "behind the screen");
    }

    #[test]
    fn a_spot_ends_softly() {
        let scene = scene(&[spot([1.0, 2.0, 0.0], [0.0, -1.0, 0.0], 20.0)]);
        for (degrees, share) in [
            (0.0, 1.0),
            (19.0, 1.0),
            (30.0, 0.5),
            (39.0, 0.05),
            (41.0, 0.0),
        ] {
            let (sine, cosine) = f64::to_radians(degrees).sin_cos();
            let irradiance = 8.0 * share * cosine.powi(3) / 4.0;
            let found = radiance(&scene, 1.0 + 2.0 * sine / cosine);
            assert_near(found, REFLECTANCE * FRAC_1_PI * irradiance, 1e-4);
        }
    }

    #[test]
    fn parallel_light_falls_everywhere_alike() {
        let scene = scene(&[LightKind::Directional {
            direction: DVec3::new(0.6, -0.8, 0.0),
            irradiance: [3.0; 3],
        }]);
        for x in [0.0, 7.0] {
            assert_near(
                radiance(&scene, x),
                REFLECTANCE * FRAC_1_PI * 3.0 * 0.8,
                1e-5,
            );
        }
    }

    #[test]
    fn several_lights_add_up() {
        let lights = [
            point([1.0, 2.0, 0.0], 6.0),
            spot([0.0, 3.0, 0.0], [0.0, -1.0, 0.0], 40.0),
            LightKind::Directional {
                direction: DVec3::NEG_Y,
                irradiance: [0.3; 3],
            },
        ];
        let irradiance = 12.0 / 5f64.powf(1.5) + 8.0 / 9.0 + 0.3;
        let found = radiance(&scene(&lights), 0.0);
        assert_near(found, REFLECTANCE * FRAC_1_PI * irradiance, 0.03);
    }

    #[test]
    fn lights_on_and_behind_surfaces_give_nothing() {
        for position in [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, -1.0, 0.0]] {
            assert_eq!(
                radiance(&scene(&[point(position, 6.0)]), 0.0),
                0.0,
                "{position:?}"
            );
        }
        // In the plane of the screen, which is seen from both sides of it.
        let scene = scene(&[point([-5.0, 1.0, 0.0], 6.0)]);
        assert_near(radiance(&scene, -5.0), REFLECTANCE * FRAC_1_PI * 6.0, 1e-5);
    }

    #[test]
    fn dark_and_broken_lights_do_not_count() {
        let broken = [
            point([0.0, 1.0, 0.0], f32::NAN),
            point([0.0, 1.0, 0.0], -1.0),
        ];
        let scene = scene(&[&broken[..], &[point([0.0, 1.0, 0.0], 0.0)]].concat());
        assert!(Lights::new(&scene).is_dark());
        assert_eq!(radiance(&scene, 0.0), 0.0);
        let note = &scene.report.notes[scene.report.notes.len() - 1];
        assert_eq!(note, "lights of no strength are left out: 1");
    }

    #[test]
    fn light_paths_start_with_all_the_power() {
        let lights = [
            point([0.0, 2.0, 0.0], 3.0),
            spot([1.0, 2.0, 0.0], [0.0, -1.0, 0.0], 10.0),
        ];
        let scene = scene(&lights);
        let lights = Lights::new(&scene);
        let mut rng = Rng::new(4, 0, 0, 0);
        let count = 100_000;
        let mut sum = 0.0;
        for _ in 0..count {
            let [choice, u, v] = [rng.next_f64(), rng.next_f64(), rng.next_f64()];
            let start = lights.emit(choice, [u, v], &mut rng).expect("light");
            assert!(start.source.is_none() && start.ray.direction.is_normalized());
            sum += f64::from(start.power.x);
        }
        let cone = scene.point_lights[1].solid_angle();
        assert_near(sum / f64::from(count), 4.0 * PI * 3.0 + 8.0 * cone, 0.01);
    }
}
