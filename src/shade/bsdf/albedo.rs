//! Directional albedo: the share of uniform light that a surface sends to its viewer.

use glam::Vec3;

use super::{LocalBsdf, Model};
use crate::sample::additive;

/// Points of the fixed set; few suffice because sampling follows the scattering closely.
const POINTS: u32 = 32;
/// Points of the fixed set of reflections.
const REFLECTIONS: u32 = 16;

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

    /// The part of [`LocalBsdf::directional_albedo`] that comes from a diffuse surface, coated or not,
    /// and from glass.
    pub fn base_albedo(&self, view: Vec3) -> Vec3 {
        let [view, _] = self.turned(view, view);
        match &self.model {
            Model::Diffuse(_) | Model::Dielectric(_) => self.directional_albedo(view),
            Model::Plastic(plastic) if view.z > 0.0 => plastic.base_albedo(view.z) * self.opacity,
            _ => Vec3::ZERO,
        }
    }

    /// Directions from which coatings and metals reflect light to the viewer, each with its weight: the
    /// weights sum to the rest of [`LocalBsdf::directional_albedo`], within 5 % on rough metals. A fixed set,
    /// the same for all points.
    pub fn reflections(&self, view: Vec3) -> impl Iterator<Item = (Vec3, Vec3)> {
        let turn = self.two_sided_turn(view);
        let view = view * turn;
        let smooth = match &self.model {
            Model::Plastic(plastic) => plastic.is_smooth(),
            Model::Mirror(_) => true,
            _ => false,
        };
        let points = match &self.model {
            Model::Diffuse(_) | Model::Dielectric(_) => 0,
            _ if view.z <= 0.0 => 0,
            _ if smooth => 1,
            _ => REFLECTIONS,
        };
        let scale = self.opacity / points.max(1) as f32;
        (0..points).filter_map(move |i| {
            // Evenly along the second number, which for views along the normal is the tilt of facets.
            let [u, ..] = additive([0.5; 3], i);
            let v = (i as f32 + 0.5) / points as f32;
            let (direction, weight) = match &self.model {
                Model::Plastic(plastic) => plastic.reflection(view, [u, v]),
                Model::Mirror(metal) => {
                    let sample = metal.sample_mirror(view)?;
                    (sample.direction, sample.weight)
                }
                Model::RoughConductor(metal, facets) => {
                    let sample = metal.sample(*facets, view, [u, v])?;
                    (sample.direction, sample.weight)
                }
                Model::Diffuse(_) | Model::Dielectric(_) => return None,
            };
            (direction.z > 0.0).then(|| (direction * turn, weight * scale))
        })
    }
}
