//! What a camera sample sees: a surface whose light is to be sampled, and the light that needs no sampling.

use glam::Vec3;

use super::super::Shot;
use crate::sample::Rng;
use crate::shade::Interaction;
use crate::trace::{Caster, Hit, Ray};

/// What a camera sample of the direct light sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Radiance that light sampling cannot find: what the camera sees of emitters and the environment, itself, through an
    /// opacity mask and by one mirror or pane.
    pub seen: Vec3,
    /// What remains to be lit, opaque: the hit, and the unit direction of the ray.
    pub surface: Option<(Hit, Vec3)>,
}

impl Sight {
    /// What a random place of a pixel sees.
    pub fn of(shot: &Shot, caster: &Caster, pixel: u32, rng: &mut Rng) -> Self {
        let x = (pixel as usize % shot.width) as f64 + rng.next_f64();
        let y = (pixel as usize / shot.width) as f64 + rng.next_f64();
        let ray = shot.ray_through(x, y);
        let direction = ray.direction;
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let lights = shot.paths.lights();
        let Some(hit) = caster.closest(&ray) else {
            return Self {
                seen: lights.environment(direction),
                surface: None,
            };
        };
        let mut at = shot.paths.surfaces().interact(&hit, direction);
        let mut seen = lights.emitted(&at);
        let passes_mask = at.bsdf.opacity < 1.0 && rng.next_f32() >= at.bsdf.opacity;
        if passes_mask {
            let ray = lights.spawn(&at, direction);
            return Self {
                seen: seen + emitted_along(shot, caster, &ray),
                surface: None,
            };
        }
        at.bsdf.opacity = 1.0;
        if let Some(sample) = at.sample(u).filter(|sample| sample.delta) {
            let ray = lights.spawn(&at, sample.direction);
            seen += sample.weight * emitted_along(shot, caster, &ray);
        }
        Self {
            seen,
            surface: (!at.bsdf.is_delta()).then_some((hit, direction)),
        }
    }
}

/// The radiance that emitters and the environment send against a ray.
fn emitted_along(shot: &Shot, caster: &Caster, ray: &Ray) -> Vec3 {
    let lights = shot.paths.lights();
    match caster.closest(ray) {
        None => lights.environment(ray.direction),
        Some(hit) => {
            let surfaces = shot.paths.surfaces();
            lights.emitted(&surfaces.interact(&hit, ray.direction))
        }
    }
}

/// The surface of a sight: opaque, because whether its mask is passed is decided.
pub(super) fn surface<'s>(shot: &'s Shot, hit: Hit, direction: Vec3) -> Interaction<'s> {
    let mut at = shot.paths.surfaces().interact(&hit, direction);
    at.bsdf.opacity = 1.0;
    at
}
