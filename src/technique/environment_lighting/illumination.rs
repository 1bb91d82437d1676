//! What a camera sample sees, and its light by parallel lights.

use glam::Vec3;

use super::super::Frame;
use crate::environment::{Environment, Light};
use crate::shade::{Interaction, Surfaces};
use crate::trace::{Caster, Hit, Ray, offset_origin};

/// A frame, its materials and its map.
pub(super) struct Illumination<'a> {
    pub frame: &'a Frame<'a>,
    pub environment: &'a Environment,
    surfaces: Surfaces<'a>,
    /// Factor on all radiance: the exposure.
    pub scale: f32,
}

/// What a camera sample sees.
pub(super) enum Point<'a> {
    Surface(Interaction<'a>, Hit),
    /// The exposed radiance of the map.
    Background(Vec3),
}

/// A light ready for shading: direction and exposed power.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parallel {
    pub direction: Vec3,
    pub power: Vec3,
}

impl<'a> Illumination<'a> {
    /// Unexposed; `None` without an environment.
    pub fn new(frame: &'a Frame<'a>) -> Option<Self> {
        Some(Self {
            frame,
            environment: frame.scene.environment.as_ref()?,
            surfaces: Surfaces::new(frame.scene),
            scale: 1.0,
        })
    }

    pub fn point(&self, caster: &Caster, pixel: u32, sample: u32) -> Point<'_> {
        let ray = self.frame.camera_ray(pixel, sample);
        match caster.closest(&ray) {
            Some(hit) => Point::Surface(self.surfaces.interact(&hit, ray.direction), hit),
            None => Point::Background(self.radiance(ray.direction)),
        }
    }

    /// The surface at a hit that was found before.
    pub fn surface(&self, hit: &Hit, pixel: u32, sample: u32) -> Interaction<'_> {
        let ray = self.frame.camera_ray(pixel, sample);
        self.surfaces.interact(hit, ray.direction)
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
        let side = if direction.dot(at.geometric_normal) < 0.0 {
            -at.geometric_normal
        } else {
            at.geometric_normal
        };
        let origin = offset_origin(at.position, side, self.frame.scene.diagonal);
        !caster.occluded(&Ray::new(origin, direction))
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
