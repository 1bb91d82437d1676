//! Scattering at a surface point, in the local frame: z along the shading normal, `view` towards
//! where the path comes from, `light` towards where it goes, both pointing away from the surface.

mod albedo;
mod conductor;
mod dielectric;
mod diffuse;
pub mod fresnel;
mod incident;
mod lanes;
mod lobes;
mod microfacet;
mod parts;
mod plastic;
#[cfg(test)]
mod tests;

use glam::Vec3;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::{Diffuse, cosine_pdf, cosine_sample};
pub use incident::{Incident, LightCone};
pub use lanes::{LANES, Lanes, VectorLanes, to_local};
pub use lobes::{Boundary, Gloss, Lobes};
pub use microfacet::Microfacets;
pub use plastic::{Coating, Plastic};

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit vector away from the surface, local frame.
    pub direction: Vec3,
    /// Scattering × |cosine| / density, linear RGB.
    pub weight: Vec3,
    /// Density per solid angle; the probability of the choice when `delta`.
    pub pdf_sr: f32,
    /// Whether no other technique can find this direction.
    pub delta: bool,
}

/// A scattering model with its parameters at one point.
#[derive(Clone, Copy, Debug)]
pub enum Model<'a> {
    /// Lambertian reflection.
    Diffuse(Diffuse),
    /// A diffuse base under a smooth or rough coating.
    Plastic(Plastic<'a>),
    /// A metal without roughness.
    Mirror(Conductor),
    /// A metal with its microfacets.
    RoughConductor(Conductor, Microfacets),
    /// Clear or frosted glass, or a thin pane.
    Dielectric(Dielectric),
}

/// A model with its sides and its opacity.
#[derive(Clone, Copy, Debug)]
pub struct LocalBsdf<'a> {
    /// How light scatters, seen from the front.
    pub model: Model<'a>,
    /// Reflects alike on both sides; otherwise the back of a reflecting model is black.
    pub two_sided: bool,
    /// Probability in [0, 1] that light meets the surface at all.
    pub opacity: f32,
}

impl LocalBsdf<'_> {
    /// Whether every direction is a delta, so that sampling lights is in vain.
    pub fn is_delta(&self) -> bool {
        matches!(self.model, Model::Mirror(_) | Model::Dielectric(_))
    }

    /// Whether some directions are deltas: of mirrors, of glass, and straight on where light meets no surface.
    pub fn has_delta(&self) -> bool {
        let model = match &self.model {
            Model::Mirror(_) | Model::Dielectric(_) => true,
            Model::Plastic(plastic) => plastic.is_smooth(),
            Model::Diffuse(_) | Model::RoughConductor(..) => false,
        };
        model || self.opacity < 1.0
    }

    /// Whether light can go straight on, through an opacity mask or a pane.
    pub fn may_be_passed(&self) -> bool {
        self.opacity < 1.0 || matches!(&self.model, Model::Dielectric(glass) if glass.thin)
    }

    /// Scattering × |cosine of `light`|, without delta parts.
    pub fn evaluate(&self, view: Vec3, light: Vec3) -> Vec3 {
        let [view, light] = self.turned(view, light);
        let value = match &self.model {
            Model::Diffuse(m) => m.evaluate(view, light),
            Model::Plastic(m) => m.evaluate(view, light),
            Model::RoughConductor(m, facets) => m.evaluate(*facets, view, light),
            Model::Mirror(_) | Model::Dielectric(_) => Vec3::ZERO,
        };
        value * self.opacity
    }

    /// Density (1/sr) with which [`LocalBsdf::sample`] finds `light`, without delta parts.
    pub fn pdf(&self, view: Vec3, light: Vec3) -> f32 {
        let [view, light] = self.turned(view, light);
        let pdf = match &self.model {
            Model::Diffuse(m) => m.pdf(view, light),
            Model::Plastic(m) => m.pdf(view, light),
            Model::RoughConductor(m, facets) => m.pdf(*facets, view, light),
            Model::Mirror(_) | Model::Dielectric(_) => 0.0,
        };
        pdf * self.opacity
    }

    /// A direction by importance; `None` absorbs the path. A ray that meets no surface (opacity)
    /// goes straight on as a delta.
    pub fn sample(&self, view: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        if u[0] >= self.opacity {
            return Some(BsdfSample {
                direction: -view,
                weight: Vec3::ONE,
                pdf_sr: 1.0 - self.opacity,
                delta: true,
            });
        }
        let choice = u[0] / self.opacity;
        let turn = self.two_sided_turn(view);
        let view = view * turn;
        let mut sample = match &self.model {
            Model::Diffuse(m) => m.sample(view, [u[1], u[2]]),
            Model::Plastic(m) => m.sample(view, choice, [u[1], u[2]]),
            Model::Mirror(m) => m.sample_mirror(view),
            Model::RoughConductor(m, facets) => m.sample(*facets, view, [u[1], u[2]]),
            Model::Dielectric(m) => m.sample(view, [choice, u[1], u[2]]),
        }?;
        sample.direction *= turn;
        sample.pdf_sr *= self.opacity;
        Some(sample)
    }

    fn two_sided_turn(&self, view: Vec3) -> Vec3 {
        let behind = self.two_sided && view.z < 0.0 && !matches!(self.model, Model::Dielectric(_));
        Vec3::new(1.0, 1.0, if behind { -1.0 } else { 1.0 })
    }

    fn turned(&self, view: Vec3, light: Vec3) -> [Vec3; 2] {
        let turn = self.two_sided_turn(view);
        [view * turn, light * turn]
    }
}
