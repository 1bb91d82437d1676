//! The contract of global light sets: parallel lights that stand for a whole map.

use glam::{DVec3, Mat3, Vec3};
use serde::{Deserialize, Serialize};

use super::Environment;
use crate::sample::Rng;

/// Which part of a map a light stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightKind {
    /// Emissive texels: sharp shadows.
    Direct,
    /// The remaining texels: smooth light.
    Indirect,
    /// Any texels.
    Global,
}

/// Parallel light from a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Light {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Σ radiance · solid angle of what it stands for, linear RGB: the irradiance of a facing surface.
    pub power: [f64; 3],
    /// Which part of the map it stands for.
    pub kind: LightKind,
    /// Half the opening angle of the cone about `direction` that holds all it stands for, in [0, π].
    pub extent_rad: f32,
}

/// The lights of a map under one sampler; none of them is black.
#[derive(Clone, Debug, Default)]
pub struct LightSet {
    /// Each stands for a part of the map.
    pub lights: Vec<Light>,
    /// Texels (row-major) that the direct lights stand for.
    pub emissive: Vec<u32>,
    /// Quantities found on the way (threshold, split, …), for the row's `params`.
    pub found: Vec<(&'static str, f64)>,
    /// Shortfalls and fallbacks, a sentence each.
    pub notes: Vec<String>,
}

impl LightSet {
    /// Σ power, per channel.
    pub fn total_power(&self) -> [f64; 3] {
        let sum: DVec3 = self.lights.iter().map(|l| DVec3::from(l.power)).sum();
        sum.to_array()
    }

    /// Number of lights of a kind.
    pub fn count(&self, kind: LightKind) -> usize {
        self.lights.iter().filter(|l| l.kind == kind).count()
    }

    /// The set with its directions carried over by a rotation (possibly mirrored).
    pub(super) fn turned(mut self, rotation: Mat3) -> Self {
        for light in &mut self.lights {
            light.direction = (rotation * light.direction).normalize();
        }
        self
    }

    /// `sets` versions for interleaved sampling (Kollig & Keller 2003; Wu 2024, section 3.5): the
    /// first is the set itself, in the others every direction is moved within a cap of `range` times
    /// the light's extent, uniformly; powers stay.
    pub fn interleaved(&self, sets: usize, range: f64, seed: u64) -> Vec<Vec<Light>> {
        /// Keys the random numbers of the moves.
        const STREAM: u64 = 0x696e_7465_726c;
        (0..sets.max(1))
            .map(|set| {
                self.lights
                    .iter()
                    .enumerate()
                    .map(|(index, light)| {
                        let mut rng = Rng::new(seed, STREAM, index as u64, set as u64);
                        let cap_rad = match set {
                            0 => 0.0,
                            _ => range * f64::from(light.extent_rad),
                        };
                        Light {
                            direction: moved(light.direction, cap_rad, &mut rng),
                            ..*light
                        }
                    })
                    .collect()
            })
            .collect()
    }
}

/// A direction uniform in the cap of this half-angle about `axis`.
fn moved(axis: Vec3, cap_rad: f64, rng: &mut Rng) -> Vec3 {
    if cap_rad <= 0.0 {
        return axis;
    }
    let half = (0.5 * cap_rad.min(std::f64::consts::PI)).sin();
    // 1 − cos of the polar angle, uniform: exact for narrow caps.
    let height = 2.0 * half * half * rng.next_f64();
    let sin = (height * (2.0 - height)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * rng.next_f64()).sin_cos();
    let axis = axis.as_dvec3().normalize();
    let (tangent, bitangent) = axis.any_orthonormal_pair();
    let direction = axis * (1.0 - height) + tangent * (sin * cos_phi) + bitangent * (sin * sin_phi);
    direction.normalize().as_vec3()
}

/// A sampler that turns a map into lights once, for all shading points.
pub trait LightSampler: Send + Sync {
    /// At most `count` lights in world space; fewer where the map has less to give, none for a black
    /// one. Depends on the map, the count and the seed alone.
    fn lights(&self, map: &Environment, count: usize, seed: u64) -> LightSet;

    /// Image rows and columns per shading point of the [`LightKind::Indirect`] lights: 2 shades them
    /// at half the resolution.
    fn reduction(&self) -> usize {
        1
    }

    /// Whether lights of a kind are shaded; an image without some shows what they add.
    fn shades(&self, _kind: LightKind) -> bool {
        true
    }

    /// The lights whose shading costs at most `rays` shadow rays a pixel, when an indirect one costs
    /// `indirect_cost`, in (0, 1].
    fn lights_within(
        &self,
        map: &Environment,
        rays: usize,
        _indirect_cost: f64,
        seed: u64,
    ) -> LightSet {
        self.lights(map, rays, seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interleaved_sets_stay_within_their_caps_and_fill_them() {
        let light = Light {
            direction: Vec3::new(0.6, 0.0, -0.8),
            power: [1.0, 2.0, 3.0],
            kind: LightKind::Global,
            extent_rad: 1.0,
        };
        let set = LightSet {
            lights: vec![light; 50],
            ..LightSet::default()
        };
        let sets = set.interleaved(8, 0.1, 7);
        assert_eq!(sets[0], set.lights);
        let angle = |l: &Light| {
            let chord = (l.direction.as_dvec3() - light.direction.as_dvec3()).length();
            2.0 * (0.5 * chord).asin()
        };
        let angles: Vec<f64> = sets[1..].iter().flatten().map(angle).collect();
        assert!(angles.iter().all(|a| *a <= 0.1 + 1e-6));
        // Uniform in the cap: the mean of the squared radius is half its largest value.
        let mean = angles.iter().map(|a| a * a).sum::<f64>() / angles.len() as f64;
        assert!((mean / 0.005 - 1.0).abs() < 0.15, "{mean}");
        assert!(sets.iter().flatten().all(|l| l.power == light.power));
    }
}
