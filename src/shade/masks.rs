//! Opacity masks: rays pass them by chance, as if the surface were not there, and no edge of a path is counted for it.

use glam::Vec3;

use super::PathTracer;
use crate::sample::Rng;
use crate::trace::{Caster, Hit, Ray};

/// Most opacity masks that a ray passes; what lies behind more of them is not met.
pub const MOST_MASKS: u32 = 64;

/// Stream of the chances of shadow rays.
const STREAM: u64 = 0x6d61_736b;

impl PathTracer<'_> {
    /// Whether anything stops a shadow ray. A mask stops it with the chance of its opacity there, which the ray's own
    /// numbers decide: the same ray is always answered alike, and of many rays a mask stops as large a part as it is opaque.
    pub fn occluded(&self, caster: &Caster, ray: &Ray) -> bool {
        let met = caster.occluded(ray);
        met && (!self.surfaces().has_masks() || self.stopped_at(caster, ray).is_some())
    }

    /// [`PathTracer::occluded`] of many rays of one origin: see [`Caster::occluded_bundle`].
    pub fn occluded_bundle(
        &self,
        caster: &Caster,
        origin: Vec3,
        directions: &[Vec3],
        t_max: f32,
        occluded: &mut [u64],
    ) {
        caster.occluded_bundle(origin, directions, t_max, occluded);
        if !self.surfaces().has_masks() {
            return;
        }
        for (i, &direction) in directions.iter().enumerate() {
            let bit = 1 << (i % 64);
            let ray = Ray {
                t_max,
                ..Ray::new(origin, direction)
            };
            if occluded[i / 64] & bit != 0 && self.stopped_at(caster, &ray).is_none() {
                occluded[i / 64] &= !bit;
            }
        }
    }

    /// The first hit of a ray that stops it: see [`PathTracer::occluded`].
    pub fn stopped_at(&self, caster: &Caster, ray: &Ray) -> Option<Hit> {
        let mut hit = caster.closest(ray)?;
        if !self.surfaces().has_masks() {
            return Some(hit);
        }
        let mut chances = chances_of(ray);
        let mut passed = 0.0;
        for _ in 0..MOST_MASKS {
            let at = self.surfaces().interact(&hit, ray.direction);
            let opacity = at.bsdf.opacity;
            if opacity >= 1.0 || chances.next_f32() < opacity {
                break;
            }
            passed += hit.t;
            hit = caster.closest(&Ray {
                t_max: ray.t_max - passed,
                ..self.lights().spawn(&at, ray.direction)
            })?;
        }
        Some(Hit {
            t: passed + hit.t,
            ..hit
        })
    }
}

/// Random numbers that follow from a ray alone.
fn chances_of(ray: &Ray) -> Rng {
    let bits = |v: f32| u64::from(v.to_bits());
    let [origin, direction] = [ray.origin, ray.direction].map(|v| v.to_array());
    let [from, way] = [origin, direction].map(|[x, y, _]| bits(x) << 32 | bits(y));
    Rng::new(
        from,
        STREAM,
        way,
        bits(origin[2]) << 32 | bits(direction[2]),
    )
}
