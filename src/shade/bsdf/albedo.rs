//! Directional albedo: the share of uniform light that a surface sends to its viewer.

use glam::Vec3;

use super::{LocalBsdf, Model};
use crate::sample::additive;

/// Points of the fixed set; few suffice because sampling follows the scattering closely.
const POINTS: u32 = 32;

impl LocalBsdf<'_> {
    /// `∫ f(view, ω) |cos ω| dω` over the directions that the surface scatters to: the
    /// directional-hemispherical reflectance, linear RGB, delta reflections included and what passes
    /// an opacity mask left out. Exact for the diffuse model; otherwise the mean weight of a fixed set
    /// of [`LocalBsdf::sample`]s, the same for all points.
    pub fn directional_albedo(&self, view: Vec3) -> Vec3 {
        match &self.model {
            Model::Diffuse(diffuse) => {
                let lit = self.two_sided || view.z > 0.0;
                diffuse.reflectance * (f32::from(u8::from(lit)) * self.opacity)
            }
            _ => {
                let weight = |i: u32| {
                    let mut u = additive([0.5; 3], i);
                    u[0] *= self.opacity;
                    self.sample(view, u).map_or(Vec3::ZERO, |s| s.weight)
                };
                (0..POINTS).map(weight).sum::<Vec3>() * (self.opacity / POINTS as f32)
            }
        }
    }
}
