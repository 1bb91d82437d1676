//! Directional albedo: the share of uniform light that a surface sends to its viewer.

use glam::Vec3;

use super::{LocalBsdf, Model};

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
                    let mut u = lattice(i);
                    u[0] *= self.opacity;
                    self.sample(view, u).map_or(Vec3::ZERO, |s| s.weight)
                };
                (0..POINTS).map(weight).sum::<Vec3>() * (self.opacity / POINTS as f32)
            }
        }
    }
}

/// Point `i` of a three-dimensional additive sequence (powers of the reciprocal of the real root of
/// x⁴ = x + 1).
fn lattice(i: u32) -> [f32; 3] {
    const STEP: [f64; 3] = [
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_3,
        0.549_700_477_901_970_5,
    ];
    // The largest f32 below 1: rounding must not reach 1.
    STEP.map(|s| ((0.5 + f64::from(i) * s).fract() as f32).min(1.0 - f32::EPSILON / 2.0))
}
