//! Light paths: where light starts, and the first ray that carries it into the scene.

use glam::Vec3;

use super::choice::radiant_exitance;
use super::{Lights, pick, usable};
use crate::sample::{Frame, Rng};
use crate::shade::bsdf::cosine_sample;
use crate::trace::{Ray, offset_origin};

/// A sampled start of a light path, all values divided by the density of the choice.
#[derive(Clone, Copy, Debug)]
pub struct Emitted {
    /// `None` where the light is one of [`Lights::points`] and [`Lights::parallel`], which need no
    /// sampling.
    pub source: Option<Source>,
    /// The first ray.
    pub ray: Ray,
    /// Power that the ray carries.
    pub power: Vec3,
}

/// The point that a light path starts from, as a light of its own.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// A point of an emitting triangle: intensity along the normal; it falls off with the cosine.
    Surface {
        /// World space.
        position: Vec3,
        /// Unit, on the side that shines.
        normal: Vec3,
        /// Power per solid angle (linear RGB) along the normal.
        intensity: Vec3,
    },
    /// Light from infinity: irradiance of a facing surface, and the direction towards it.
    Infinity {
        /// Unit vector towards the light.
        direction: Vec3,
        /// Of a surface that faces it, linear RGB.
        irradiance: Vec3,
    },
}

impl Lights<'_> {
    /// A light path's start; `choice` in [0, 1) selects the light, `point` in [0, 1)² a point of it
    /// (of points and the environment: a direction). `None` where nothing shines.
    pub fn emit(&self, choice: f64, point: [f64; 2], rng: &mut Rng) -> Option<Emitted> {
        if self.is_dark() {
            return None;
        }
        let [area, points, parallel, sky] = self.groups;
        if choice < area {
            return self.emit_from_triangle(choice / area, point, rng);
        }
        let finite = area + points;
        if choice < finite || parallel + sky == 0.0 {
            let choice = ((choice - area) / points).clamp(0.0, 1.0);
            return Some(self.emit_from_point(choice, point));
        }
        let is_parallel = choice < finite + parallel || sky == 0.0;
        let (towards, irradiance) = if is_parallel {
            let index = pick(
                &self.parallel_sums,
                ((choice - finite) / parallel).clamp(0.0, 1.0),
            );
            let (travel, irradiance) = self.scene.directional_lights[index];
            (
                -travel.try_normalize()?,
                Vec3::from(irradiance) / self.parallel_chance(index) as f32,
            )
        } else {
            let sample = self.scene.environment.as_ref()?.sample(point)?;
            let density = sample.pdf_sr * sky as f32;
            (sample.direction, Vec3::from(sample.radiance) / density)
        };
        let radius = self.scene.diagonal * 0.5;
        let frame = Frame::from_normal(towards);
        let [x, y] = disk([rng.next_f32(), rng.next_f32()]);
        let origin = towards * (radius * 1.01) + (frame.tangent * x + frame.bitangent * y) * radius;
        Some(Emitted {
            source: (!is_parallel).then_some(Source::Infinity {
                direction: towards,
                irradiance,
            }),
            ray: Ray::new(origin, -towards),
            power: irradiance * self.disk() as f32,
        })
    }

    fn emit_from_triangle(&self, choice: f64, [u, v]: [f64; 2], rng: &mut Rng) -> Option<Emitted> {
        let light = &self.triangles[pick(&self.triangle_power, choice)];
        let (root, v) = (u.sqrt() as f32, v as f32);
        let position =
            light.corner + light.edges[0] * (root * (1.0 - v)) + light.edges[1] * (root * v);
        let exitance = radiant_exitance(light.emission.into());
        let total = self.triangle_power[self.triangle_power.len() - 1];
        let intensity = light.emission / (exitance * (self.groups[0] / total)) as f32;
        let local = cosine_sample([rng.next_f32(), rng.next_f32()]);
        let direction = Frame::from_normal(light.normal)
            .to_world(local)
            .try_normalize()?;
        Some(Emitted {
            source: Some(Source::Surface {
                position,
                normal: light.normal,
                intensity,
            }),
            ray: Ray::new(
                offset_origin(position, light.normal, self.scene.diagonal),
                direction,
            ),
            power: intensity * std::f32::consts::PI,
        })
    }

    /// Diagonal of the scene's bounding box, scene units.
    pub fn diagonal(&self) -> f32 {
        self.scene.diagonal
    }

    /// All parallel lights: unit direction towards the light, irradiance of a facing surface.
    pub fn parallel(&self) -> impl Iterator<Item = (Vec3, Vec3)> {
        self.scene
            .directional_lights
            .iter()
            .filter(|(_, irradiance)| usable(*irradiance) > 0.0)
            .filter_map(|(travel, irradiance)| {
                Some((-travel.try_normalize()?, Vec3::from(*irradiance)))
            })
    }
}

/// A point of the unit disk, uniformly.
fn disk(u: [f32; 2]) -> [f32; 2] {
    let on_hemisphere = cosine_sample(u);
    [on_hemisphere.x, on_hemisphere.y]
}
