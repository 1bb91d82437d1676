//! One light and one surface point: what arrives, and a bound of what could arrive nearby.

use glam::Vec3;

use super::{Emission, Facing, LANES, VirtualLight, VirtualLights};
use crate::shade::surface::Interaction;
use crate::trace::{Caster, Ray, offset_origin};

/// Rays to a light stop this share of their length before it.
pub(super) const REACH: f32 = 1.0 - 1e-6;

/// A surface point that receives light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    /// The point, seen from where its light goes.
    pub at: Interaction<'a>,
    /// Where its shadow rays start: off the surface on the viewer's side.
    pub origin: Vec3,
    /// Normal of the scattering on the viewer's side.
    normal: Vec3,
    lambertian: Option<Vec3>,
}

impl<'a> Receiver<'a> {
    /// `diagonal` is that of the scene.
    pub fn new(at: Interaction<'a>, diagonal: f32) -> Self {
        Self {
            origin: offset_origin(at.position, at.facing_normal(), diagonal),
            normal: at.facing_shading_normal(),
            lambertian: at.lambertian(),
            at,
        }
    }

    /// Scattering × cosine towards a unit direction.
    fn scattering(&self, direction: Vec3) -> Vec3 {
        match self.lambertian {
            Some(scattering) => scattering * self.normal.dot(direction).max(0.0),
            None => self.at.evaluate(direction),
        }
    }

    /// Scattering without its cosine, also for directions below the horizon, which are lifted.
    fn lifted_scattering(&self, direction: Vec3) -> Vec3 {
        match self.lambertian {
            Some(scattering) => scattering,
            None => lifted(&self.at, self.normal, direction),
        }
    }
}

/// A neighbourhood of a receiver that a bound must hold for.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood {
    /// Distance of its points from the receiver, scene units.
    pub radius: f32,
    /// Cosine and sine of the angle of their normals to the receiver's.
    pub turn: [f32; 2],
}

impl VirtualLights<'_> {
    /// Radiance that light `index` adds at the receiver towards its viewer if nothing is between.
    /// 0 for a light at the receiver itself. Not finite only where a material is.
    pub fn unoccluded(&self, to: &Receiver, index: usize) -> Vec3 {
        let light = &self.lights[index];
        if let Emission::Infinity { irradiance } = light.emission {
            return to.scattering(light.normal) * irradiance;
        }
        let way = light.position - to.at.position;
        let squared = way.length_squared();
        let Some(direction) = way.try_normalize() else {
            return Vec3::ZERO;
        };
        if let Emission::Point(light) = light.emission {
            return to.scattering(direction) * light.irradiance(-way);
        }
        let sent = light.sent(-direction);
        if sent == Vec3::ZERO {
            return Vec3::ZERO;
        }
        to.scattering(direction) * sent / squared.max(self.least_squared())
    }

    /// A bound of [`VirtualLights::unoccluded`] over a neighbourhood: cosines and the distance at their
    /// best, scattering as at the receiver (Georgiev et al. 2012). A point light closer than the least
    /// distance of the geometry term can exceed it.
    ///
    /// *differs:* the receiver's cosine is bounded over the radius and the turn of the normals, not
    /// by 1, so that lights behind everything nearby count for nothing.
    pub fn bounded(&self, to: &Receiver, index: usize, near: &Neighbourhood) -> Vec3 {
        let light = &self.lights[index];
        if let Emission::Infinity { irradiance } = light.emission {
            let cosine = best_cosine(to.normal.dot(light.normal), near.turn);
            return to.lifted_scattering(light.normal) * irradiance * cosine;
        }
        let way = light.position - to.at.position;
        let distance = way.length();
        let direction = way.try_normalize().unwrap_or(to.normal);
        let least = (distance - near.radius).max(0.0);
        let squared = (least * least).max(self.least_squared());
        if least == 0.0 {
            // The light may lie in any direction.
            let sent = light.lifted_sent(-direction);
            return to.lifted_scattering(direction) * sent / squared;
        }
        let sin = near.radius / distance;
        let cos = (1.0 - sin * sin).max(0.0).sqrt();
        let sending = light.best_sending(-direction, [cos, sin]);
        let receiving = best_cosine(to.normal.dot(direction), sum([cos, sin], near.turn));
        let cosines = sending * receiving;
        if cosines == 0.0 {
            return Vec3::ZERO;
        }
        let sent = light.lifted_sent(-direction);
        to.lifted_scattering(direction) * sent * (cosines / squared)
    }

    /// Whether something stops a light on its way to the receiver.
    pub fn occluded(&self, caster: &Caster, to: &Receiver, index: usize) -> bool {
        let ray = self.shadow_ray(to, index);
        self.paths_of_scene.occluded(caster, &ray)
    }

    /// The ray that decides whether a light reaches the receiver.
    pub fn shadow_ray(&self, to: &Receiver, index: usize) -> Ray {
        let light = &self.lights[index];
        if let Emission::Infinity { .. } = light.emission {
            return Ray::new(to.origin, light.normal);
        }
        let way = light.end - to.origin;
        Ray {
            t_max: way.length() * REACH,
            ..Ray::new(to.origin, way.normalize_or(light.normal))
        }
    }

    /// A bit for each of eight lights on surfaces that lies before the receiver and shines towards
    /// it; the others add nothing.
    pub(super) fn faced(&self, to: &Receiver, block: usize) -> u32 {
        let Facing { position, normal } = &self.facing[block];
        let (at, up) = (to.at.position.to_array(), to.normal.to_array());
        let mut seen = [0.0f32; LANES];
        let mut shining = [0.0f32; LANES];
        for axis in 0..3 {
            for lane in 0..LANES {
                let way = position[axis][lane] - at[axis];
                seen[lane] += way * up[axis];
                shining[lane] -= way * normal[axis][lane];
            }
        }
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= u32::from(seen[lane] > 0.0 && shining[lane] > 0.0) << lane;
        }
        bits
    }

    fn least_squared(&self) -> f32 {
        (self.clamp_distance * self.clamp_distance).max(f32::MIN_POSITIVE)
    }
}

impl VirtualLight<'_> {
    /// Intensity that a light with a position sends in a direction.
    fn sent(&self, direction: Vec3) -> Vec3 {
        match &self.emission {
            Emission::Cosine {
                intensity,
                shading_normal,
            } => {
                let cosine = direction.dot(self.normal);
                if cosine <= 0.0 || direction.dot(*shading_normal) <= 0.0 {
                    Vec3::ZERO
                } else {
                    *intensity * cosine
                }
            }
            Emission::Glossy { at, power } => {
                if direction.dot(self.normal) <= 0.0 {
                    return Vec3::ZERO;
                }
                at.evaluate(direction) * *power * at.adjoint(direction)
            }
            Emission::Point(light) => light.sent(direction),
            Emission::Infinity { irradiance } => *irradiance,
        }
    }

    /// The largest cosine of a light on a surface, or share of a spot light's intensity, around a direction
    /// that may turn (cosine, sine).
    fn best_sending(&self, direction: Vec3, turn: [f32; 2]) -> f32 {
        match &self.emission {
            Emission::Point(light) => light.cone.map_or(1.0, |cone| {
                cone.share(cone.angle(direction) - turn[1].atan2(turn[0]))
            }),
            _ => best_cosine(direction.dot(self.normal), turn),
        }
    }

    /// The most of [`VirtualLight::sent`] without its cosine or falloff, lifted above the horizon.
    fn lifted_sent(&self, direction: Vec3) -> Vec3 {
        match &self.emission {
            Emission::Cosine { intensity, .. } => *intensity,
            Emission::Glossy { at, power } => {
                lifted(at, at.facing_shading_normal(), direction) * *power
            }
            Emission::Point(light) => light.intensity.into(),
            Emission::Infinity { irradiance } => *irradiance,
        }
    }
}

/// Scattering without its cosine; directions below a small height are raised to it.
fn lifted(at: &Interaction, normal: Vec3, direction: Vec3) -> Vec3 {
    const LEAST: f32 = 0.1;
    let cosine = normal.dot(direction);
    if cosine >= LEAST {
        return at.evaluate(direction) / cosine;
    }
    let raised = (direction + normal * (LEAST - cosine)).normalize_or(normal);
    at.evaluate(raised) / normal.dot(raised)
}

/// The largest cosine of an angle of this cosine that may shrink by a turn (cosine, sine), at least 0.
fn best_cosine(cosine: f32, [cos, sin]: [f32; 2]) -> f32 {
    if cosine >= cos {
        return 1.0;
    }
    let own_sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    (cosine * cos + own_sine * sin).max(0.0)
}

/// Two turns together, at most half a circle.
fn sum([c1, s1]: [f32; 2], [c2, s2]: [f32; 2]) -> [f32; 2] {
    let (cos, sin) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    if sin < 0.0 { [-1.0, 0.0] } else { [cos, sin] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_cosines_hold_and_are_met() {
        let turn = |degrees: f32| [degrees.to_radians().cos(), degrees.to_radians().sin()];
        let cos = |degrees: f32| degrees.to_radians().cos();
        assert_eq!(best_cosine(cos(20.0), turn(30.0)), 1.0);
        assert!((best_cosine(cos(70.0), turn(30.0)) - cos(40.0)).abs() < 1e-6);
        assert_eq!(best_cosine(cos(130.0), turn(30.0)), 0.0);
        let both = sum(turn(30.0), turn(60.0));
        assert!(both[0].abs() < 1e-6 && (both[1] - 1.0).abs() < 1e-6);
        assert_eq!(sum(turn(100.0), turn(120.0)), [-1.0, 0.0]);
        assert_eq!(best_cosine(-1.0, [-1.0, 0.0]), 1.0);
    }
}
