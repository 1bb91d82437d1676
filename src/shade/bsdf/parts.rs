//! Scattering in two parts: the diffuse base, whose light caches keep without its colour, and the gloss above it
//! (coatings, metals, glass), which depends on the viewer.
//!
//! Opacity is left out: whether a mask is passed is decided before a surface is taken apart.

use glam::Vec3;

use super::diffuse::{cosine_pdf, cosine_sample};
use super::{BsdfSample, LocalBsdf, Model};

/// Bounds of the chance to follow the gloss of a coated surface, so that neither part starves.
const CHANCES: [f32; 2] = [0.1, 0.9];

impl LocalBsdf<'_> {
    /// Whether a part scatters light to all sides, whatever the viewer.
    pub fn has_base(&self) -> bool {
        matches!(self.model, Model::Diffuse(_) | Model::Plastic(_))
    }

    /// Scattering of the base × cosine of `light`, over [`LocalBsdf::base_albedo`] (1/sr): it
    /// integrates to 1 and does not depend on colours. 0 without a base and on an unlit side.
    pub fn base_share(&self, view: Vec3, light: Vec3) -> f32 {
        let [view, light] = self.turned(view, light);
        if view.z <= 0.0 {
            return 0.0;
        }
        match &self.model {
            Model::Diffuse(_) => cosine_pdf(light),
            Model::Plastic(m) => cosine_pdf(light) * m.entering_share(light.z),
            _ => 0.0,
        }
    }

    /// A direction of the base with the density [`LocalBsdf::base_pdf`].
    pub fn sample_base(&self, view: Vec3, u: [f32; 2]) -> Option<Vec3> {
        let turn = self.two_sided_turn(view);
        (self.has_base() && (view * turn).z > 0.0).then(|| cosine_sample(u) * turn)
    }

    /// Density (1/sr) of [`LocalBsdf::sample_base`].
    pub fn base_pdf(&self, view: Vec3, light: Vec3) -> f32 {
        let [view, light] = self.turned(view, light);
        if self.has_base() && view.z > 0.0 {
            cosine_pdf(light)
        } else {
            0.0
        }
    }

    /// Chance to follow the gloss when one part is chosen: 0 without gloss, 1 without a base.
    pub fn gloss_chance(&self, view: Vec3) -> f32 {
        match &self.model {
            Model::Diffuse(_) => 0.0,
            Model::Plastic(m) => {
                let cos = self.turned(view, view)[0].z;
                m.specular_chance(cos).clamp(CHANCES[0], CHANCES[1])
            }
            _ => 1.0,
        }
    }

    /// Scattering of the gloss × cosine of `light`, without delta parts.
    pub fn evaluate_gloss(&self, view: Vec3, light: Vec3) -> Vec3 {
        let [view, light] = self.turned(view, light);
        match &self.model {
            Model::Plastic(m) => m.evaluate_coating(view, light),
            Model::RoughConductor(m, facets) => m.evaluate(*facets, view, light),
            _ => Vec3::ZERO,
        }
    }

    /// Density (1/sr) of [`LocalBsdf::sample_gloss`] for `light`, without delta parts.
    pub fn gloss_pdf(&self, view: Vec3, light: Vec3) -> f32 {
        let [view, light] = self.turned(view, light);
        match &self.model {
            Model::Plastic(m) => m.coating_pdf(view, light),
            Model::RoughConductor(m, facets) => m.pdf(*facets, view, light),
            _ => 0.0,
        }
    }

    /// A direction of the gloss by importance; `None` without gloss and where the path is absorbed.
    pub fn sample_gloss(&self, view: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let turn = self.two_sided_turn(view);
        let view = view * turn;
        let mut sample = match &self.model {
            Model::Diffuse(_) => None,
            Model::Plastic(m) => m.sample_coating(view, [u[1], u[2]]),
            Model::Mirror(m) => m.sample_mirror(view),
            Model::RoughConductor(m, facets) => m.sample(*facets, view, [u[1], u[2]]),
            Model::Dielectric(m) => m.sample(view, u),
        }?;
        sample.direction *= turn;
        Some(sample)
    }

    /// Whether the gloss is a mirror or clear glass, so that lights cannot be sampled for it.
    pub fn gloss_is_delta(&self) -> bool {
        match &self.model {
            Model::Plastic(m) => m.is_smooth(),
            Model::Mirror(_) | Model::Dielectric(_) => true,
            Model::Diffuse(_) | Model::RoughConductor(..) => false,
        }
    }

    /// Roughness of the gloss: 0 for mirrors and clear glass, 1 where there is none.
    pub fn gloss_alpha(&self) -> f32 {
        match &self.model {
            Model::Diffuse(_) => 1.0,
            Model::Plastic(m) => m.alpha(),
            Model::RoughConductor(_, facets) => facets.alpha(),
            Model::Mirror(_) | Model::Dielectric(_) => 0.0,
        }
    }
}

impl super::Plastic<'_> {
    fn alpha(&self) -> f32 {
        self.coating.facets.map_or(0.0, |facets| facets.alpha())
    }

    /// Share of light at this cosine that enters the coating, over its mean under diffuse light.
    fn entering_share(&self, cos_light: f32) -> f32 {
        self.coating.transmittance(cos_light) / self.coating.entering
    }

    /// Probability of the coating by what each part reflects.
    fn specular_chance(&self, cos_view: f32) -> f32 {
        if cos_view <= 0.0 {
            return 0.0;
        }
        self.specular_probability(self.coating.transmittance(cos_view))
    }

    fn evaluate_coating(&self, view: Vec3, light: Vec3) -> Vec3 {
        if view.z <= 0.0 || light.z <= 0.0 {
            return Vec3::ZERO;
        }
        let Some(facets) = self.coating.facets else {
            return Vec3::ZERO;
        };
        let half = (view + light).normalize();
        self.specular * self.coating_reflection(facets, view, [light, half])
    }

    fn coating_pdf(&self, view: Vec3, light: Vec3) -> f32 {
        match self.coating.facets {
            Some(facets) if view.z > 0.0 && light.z > 0.0 => {
                facets.reflection_pdf(view, (view + light).normalize())
            }
            _ => 0.0,
        }
    }

    fn sample_coating(&self, view: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
        if view.z <= 0.0 {
            return None;
        }
        let (direction, weight) = self.reflection(view, u);
        let delta = self.is_smooth();
        let pdf_sr = if delta {
            1.0
        } else {
            self.coating_pdf(view, direction)
        };
        (direction.z > 0.0 && pdf_sr > 0.0).then_some(BsdfSample {
            direction,
            weight,
            pdf_sr,
            delta,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use super::*;
    use crate::sample::additive;
    use crate::scene::MicrofacetDistribution;
    use crate::shade::bsdf::{Coating, Diffuse, Microfacets, Plastic};

    fn coated(coating: &Coating) -> LocalBsdf<'_> {
        LocalBsdf {
            model: Model::Plastic(Plastic {
                coating,
                diffuse: Vec3::new(0.7, 0.3, 0.0),
                specular: Vec3::splat(0.8),
                nonlinear: true,
            }),
            two_sided: true,
            opacity: 1.0,
        }
    }

    /// The parts of coated and plain surfaces add up to all of the scattering, from both sides.
    #[test]
    fn parts_add_up() {
        for alpha in [0.0, 0.2] {
            let facets =
                (alpha > 0.0).then(|| Microfacets::new(MicrofacetDistribution::Ggx, alpha));
            let coating = Coating::new(facets, 1.5);
            let diffuse = LocalBsdf {
                model: Model::Diffuse(Diffuse {
                    reflectance: Vec3::new(0.5, 0.2, 0.9),
                }),
                two_sided: true,
                opacity: 1.0,
            };
            for bsdf in [coated(&coating), diffuse] {
                for side in [1.0, -1.0] {
                    let view = Vec3::new(0.6, 0.0, 0.8 * side);
                    for i in 0..64 {
                        let [u, v, _] = additive([0.3; 3], i);
                        let light = cosine_sample([u, v]) * Vec3::new(1.0, 1.0, side);
                        let parts = bsdf.base_albedo(view) * bsdf.base_share(view, light)
                            + bsdf.evaluate_gloss(view, light);
                        let all = bsdf.evaluate(view, light);
                        let off = (parts - all).abs().max_element();
                        assert!(off <= 1e-4 * all.max_element(), "{off} of {all}");
                    }
                }
            }
        }
    }

    /// The base's share integrates to 1, and samples of the gloss average to its albedo.
    #[test]
    fn parts_are_normalised() {
        const POINTS: u32 = 1 << 14;
        let facets = Microfacets::new(MicrofacetDistribution::Ggx, 0.3);
        let coating = Coating::new(Some(facets), 1.5);
        let bsdf = coated(&coating);
        let view = Vec3::new(0.8, 0.0, 0.6);
        let (mut share, mut by_samples, mut by_cosine) = (0.0, 0.0, 0.0);
        for i in 0..POINTS {
            let u = additive([0.1; 3], i);
            let light = cosine_sample([u[1], u[2]]);
            share += bsdf.base_share(view, light) / cosine_pdf(light);
            by_cosine += bsdf.evaluate_gloss(view, light).x / cosine_pdf(light);
            if let Some(sample) = bsdf.sample_gloss(view, u) {
                by_samples += sample.weight.x;
                let direct = bsdf.evaluate_gloss(view, sample.direction)
                    / bsdf.gloss_pdf(view, sample.direction);
                assert!((direct.x - sample.weight.x).abs() < 1e-3 * sample.weight.x.max(1e-3));
            }
        }
        let mean = |sum: f32| sum / POINTS as f32;
        assert!((mean(share) - 1.0).abs() < 0.01, "{}", mean(share));
        let ratio = by_samples / by_cosine;
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn a_surface_seen_from_its_dark_side_has_no_share() {
        let bsdf = LocalBsdf {
            model: Model::Diffuse(Diffuse {
                reflectance: Vec3::ONE,
            }),
            two_sided: false,
            opacity: 1.0,
        };
        assert_eq!(bsdf.base_share(-Vec3::Z, -Vec3::Z), 0.0);
        assert!(bsdf.sample_base(-Vec3::Z, [0.5; 2]).is_none());
        assert!((bsdf.base_share(Vec3::Z, Vec3::Z) - 1.0 / PI).abs() < 1e-6);
    }
}
