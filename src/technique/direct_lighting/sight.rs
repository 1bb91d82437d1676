//! What a camera sample sees: a surface whose light is to be sampled, and the light that needs no sampling.

use glam::Vec3;

use super::super::Shot;
use crate::sample::Rng;
use crate::shade::{Interaction, Leg, Met};
use crate::trace::{Caster, Hit};

/// What a camera sample of the direct light sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Radiance that light sampling cannot find: what the camera sees of emitters and the environment, itself, through
    /// opacity masks and by one mirror or pane.
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
        let paths = &shot.paths;
        let vertex = match paths.meet(caster, Leg::from_camera(ray), rng) {
            Met::Sky { passed, sky } => {
                return Self {
                    seen: passed + sky,
                    surface: None,
                };
            }
            Met::Surface(vertex) => vertex,
        };
        let at = &vertex.at;
        let mut seen = vertex.emission;
        if let Some(sample) = at.sample(u).filter(|sample| sample.delta) {
            let leg = Leg::from_camera(paths.lights().spawn(at, sample.direction));
            seen += sample.weight * paths.meet(caster, leg, rng).emission();
        }
        Self {
            seen,
            surface: (!at.bsdf.is_delta()).then_some((vertex.hit, direction)),
        }
    }
}

/// The surface of a sight: opaque, because whether its mask is passed is decided.
pub(super) fn surface<'s>(shot: &'s Shot, hit: Hit, direction: Vec3) -> Interaction<'s> {
    let mut at = shot.paths.surfaces().interact(&hit, direction);
    at.bsdf.opacity = 1.0;
    at
}
