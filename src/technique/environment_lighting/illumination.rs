//! What a camera sample sees, and its light by parallel lights.

use glam::Vec3;

use super::super::{Seen, Shot};
use crate::environment::{Environment, Light};
use crate::shade::Interaction;
use crate::trace::Caster;

/// A shot, its materials and its map.
pub(super) struct Illumination<'a> {
    pub shot: &'a Shot<'a>,
    pub environment: &'a Environment,
    /// Factor on all radiance: the exposure.
    pub scale: f32,
}

/// What a camera sample sees: a surface, whose light is to be multiplied by the throughput of mirrors
/// and glass before it, or else the exposed radiance of the map.
pub(super) type Point<'a> = Result<(Interaction<'a>, Seen), Vec3>;

/// A light ready for shading: direction and exposed power.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parallel {
    pub direction: Vec3,
    pub power: Vec3,
}

impl<'a> Illumination<'a> {
    /// With the shot's exposure; `None` without an environment.
    pub fn new(shot: &'a Shot<'a>) -> Option<Self> {
        Some(Self {
            shot,
            environment: shot.scene.environment.as_ref()?,
            scale: shot.exposure,
        })
    }

    pub fn point(&self, caster: &Caster, pixel: u32, sample: u32) -> Point<'_> {
        match self.shot.look_out(caster, pixel, sample) {
            Ok(seen) => Ok((self.shot.surface(&seen), seen)),
            Err(missed) => Err(missed.throughput * self.radiance(missed.direction)),
        }
    }

    /// Exposed radiance of the map from a direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        Vec3::from(self.environment.radiance(direction)) * self.scale
    }

    /// Lights of a set, ready for shading.
    pub fn parallel<'l>(&self, lights: impl Iterator<Item = &'l Light>) -> Vec<Parallel> {
        let scale = f64::from(self.scale);
        lights
            .map(|light| Parallel {
                direction: light.direction,
                power: Vec3::from(light.power.map(|p| (p * scale) as f32)),
            })
            .collect()
    }

    /// Whether nothing lies between a surface and the map in a direction.
    pub fn sees(&self, caster: &Caster, at: &Interaction, direction: Vec3) -> bool {
        let paths = &self.shot.paths;
        !paths.occluded(caster, &paths.lights().spawn(at, direction))
    }

    /// Σ scattering · cosine · power · visibility; lights that the surface does not reflect cost no
    /// ray.
    pub fn lit(&self, caster: &Caster, at: &Interaction, lights: &[Parallel]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for light in lights {
            let reflected = at.evaluate(light.direction) * light.power;
            if reflected != Vec3::ZERO && self.sees(caster, at, light.direction) {
                sum += reflected;
            }
        }
        sum
    }
}
