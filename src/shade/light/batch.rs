//! Many places on lights at once, and what they send to a surface: loops that processors work through many at a time.

use glam::Vec3;
use multiversion::multiversion;

use super::{ChosenPlace, EmittingTriangle, LightPlace, Lights, Unshadowed};
use crate::sample::Rng;
use crate::shade::surface::Interaction;

/// Places that are worked on together.
const LANES: usize = 32;
/// A number of each of them.
type Lanes = [f32; LANES];

/// Places that were selected at random, and what they send to one surface.
struct LightBatch {
    len: usize,
    chosen: [ChosenPlace; LANES],
    /// Points of emitting triangles, later unit vectors towards the lights; one array a coordinate.
    towards: [Lanes; 3],
    normal: [Lanes; 3],
    /// Radiance of emitting triangles, later irradiance as in [`super::Arriving`]; zero where a place cannot reach the
    /// surface.
    light: [Lanes; 3],
    /// Lights that are not triangles, by their number in the batch.
    others: Vec<(usize, Unshadowed)>,
}

impl Default for LightBatch {
    fn default() -> Self {
        let nowhere = ChosenPlace {
            place: LightPlace::Point(u32::MAX),
            density: 0.0,
        };
        Self {
            len: 0,
            chosen: [nowhere; LANES],
            towards: [[0.0; LANES]; 3],
            normal: [[0.0; LANES]; 3],
            light: [[0.0; LANES]; 3],
            others: Vec::new(),
        }
    }
}

impl Lights<'_> {
    /// Selects a place for each number in [0, 1) of `choices`, as [`Lights::choose`] does, and gives those that send light
    /// to a surface to `each`, with what [`Lights::unshadowed`] says of them.
    pub fn each_unshadowed(
        &self,
        choices: impl Iterator<Item = f64>,
        rng: &mut Rng,
        from: &Interaction,
        mut each: impl FnMut(ChosenPlace, Unshadowed),
    ) {
        if self.is_dark() {
            return;
        }
        let mut batch = LightBatch::default();
        for choice in choices {
            if batch.len == LANES {
                batch.hand_over(from, &mut each);
            }
            let at = [rng.next_f32(), rng.next_f32()];
            if let Some(light) = self.triangle_for(choice) {
                batch.add_triangle(light, at);
            } else if let Some(chosen) = self.choose_at(choice, at) {
                let light = self.unshadowed(&chosen.place, from);
                batch.add_other(chosen, light);
            }
        }
        batch.hand_over(from, &mut each);
    }
}

impl LightBatch {
    fn add_triangle(&mut self, light: &EmittingTriangle, at: [f32; 2]) {
        let lane = self.len;
        self.chosen[lane] = light.chosen(at);
        let point = light.point(at);
        for axis in 0..3 {
            self.towards[axis][lane] = point[axis];
            self.normal[axis][lane] = light.normal[axis];
            self.light[axis][lane] = light.emission[axis];
        }
        self.len += 1;
    }

    fn add_other(&mut self, chosen: ChosenPlace, light: Option<Unshadowed>) {
        self.chosen[self.len] = chosen;
        let dark = Unshadowed {
            direction: Vec3::Z,
            irradiance: Vec3::ZERO,
        };
        self.others.push((self.len, light.unwrap_or(dark)));
        self.len += 1;
    }

    /// Gives all places to `each`, and begins anew.
    fn hand_over(&mut self, from: &Interaction, each: &mut impl FnMut(ChosenPlace, Unshadowed)) {
        send(self, from.position);
        for (lane, light) in self.others.drain(..) {
            for axis in 0..3 {
                self.towards[axis][lane] = light.direction[axis];
                self.light[axis][lane] = light.irradiance[axis];
            }
        }
        for lane in 0..self.len {
            let of = |[x, y, z]: &[Lanes; 3]| Vec3::new(x[lane], y[lane], z[lane]);
            let light = Unshadowed {
                direction: of(&self.towards),
                irradiance: of(&self.light),
            };
            if light.irradiance != Vec3::ZERO {
                each(self.chosen[lane], light);
            }
        }
        self.len = 0;
    }
}

/// From points and radiance of triangles to directions and irradiance: `EmittingTriangle::facing` of all of them.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn send(batch: &mut LightBatch, position: Vec3) {
    let [px, py, pz] = &mut batch.towards;
    let [nx, ny, nz] = &batch.normal;
    let [red, green, blue] = &mut batch.light;
    let mut pdf_area = [0.0; LANES];
    for (pdf_area, chosen) in pdf_area.iter_mut().zip(&batch.chosen) {
        *pdf_area = chosen.density;
    }
    for lane in 0..LANES {
        let x = px[lane] - position.x;
        let y = py[lane] - position.y;
        let z = pz[lane] - position.z;
        let distance2 = x * x + y * y + z * z;
        let inverse = 1.0 / distance2.sqrt();
        let (x, y, z) = (x * inverse, y * inverse, z * inverse);
        let cos = -(x * nx[lane] + y * ny[lane] + z * nz[lane]);
        let pdf_sr = pdf_area[lane] * distance2 / cos;
        let reaches = (cos > 0.0)
            & (pdf_sr > 0.0)
            & (pdf_sr < f32::INFINITY)
            & (inverse > 0.0)
            & (inverse < f32::INFINITY);
        let factor = pdf_area[lane] / pdf_sr;
        (px[lane], py[lane], pz[lane]) = (x, y, z);
        red[lane] = if reaches { red[lane] * factor } else { 0.0 };
        green[lane] = if reaches { green[lane] * factor } else { 0.0 };
        blue[lane] = if reaches { blue[lane] * factor } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::environment::EnvironmentDescription;
    use crate::scene::{
        LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
    };
    use crate::shade::PathTracer;
    use crate::trace::{Hit, Tracer};

    /// A floor under a round lamp, a point light, parallel light and a sky.
    fn scene() -> Scene {
        let mut floor = ShapeDescription::new("floor", ShapeSource::Rectangle);
        floor.to_world = DMat4::from_scale(DVec3::splat(4.0));
        let ball = ShapeSource::Sphere {
            centre: DVec3::new(0.5, 0.2, 1.0),
            radius: 0.3,
        };
        let mut lamp = ShapeDescription::new("lamp", ball);
        lamp.emission = Some([20.0, 15.0, 10.0]);
        let eye = [DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y];
        let lights = [
            LightKind::Point {
                position: DVec3::new(-1.0, 0.0, 1.0),
                intensity: [2.0; 3],
            },
            LightKind::Directional {
                direction: DVec3::NEG_Z,
                irradiance: [1.0; 3],
            },
        ];
        let description = SceneDescription {
            views: vec![View::look_at("v", eye, 60.0, [8, 8])],
            materials: vec![Material::diffuse("grey", [0.5; 3])],
            shapes: vec![floor, lamp],
            lights: lights.into_iter().map(Into::into).collect(),
            environment: Some(EnvironmentDescription::Constant {
                radiance: [0.3, 0.4, 0.5],
            }),
            ..SceneDescription::default()
        };
        Scene::build(&description, Needs::ALL).expect("a scene")
    }

    #[test]
    fn a_batch_is_one_place_after_another_bit_for_bit() {
        let scene = scene();
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let paths = PathTracer::new(&scene, &tracer);
        let lights = paths.lights();
        for (place, count) in [(0.1, 100), (0.4, LANES), (0.7, 1), (0.2, 0)] {
            let hit = Hit {
                t: 1.0,
                u: place,
                v: 0.2,
                triangle: 0,
            };
            let at = paths.surfaces().interact(&hit, Vec3::NEG_Z);
            let choices = || (0..count).map(|i| (i as f64 + 0.5) / count as f64);
            let mut expected = Vec::new();
            let mut rng = Rng::new(7, 0, 0, 0);
            for choice in choices() {
                let chosen = lights.choose(choice, &mut rng).expect("something shines");
                if let Some(light) = lights.unshadowed(&chosen.place, &at) {
                    expected.push((chosen, light));
                }
            }
            let mut rng = Rng::new(7, 0, 0, 0);
            let mut found = Vec::new();
            lights.each_unshadowed(choices(), &mut rng, &at, |chosen, light| {
                found.push((chosen, light));
            });
            assert_eq!(format!("{found:?}"), format!("{expected:?}"));
            let triangle = |(chosen, _): &&(ChosenPlace, Unshadowed)| {
                matches!(chosen.place, LightPlace::Triangle(..))
            };
            let lit = found.iter().filter(triangle).count();
            assert!(count < 100 || (5..60).contains(&lit), "{lit}");
        }
    }
}
