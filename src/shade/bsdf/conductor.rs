//! Metals: the perfect mirror and the rough conductor (single scattering).

use glam::Vec3;

use super::fresnel;
use super::microfacet::{Microfacets, reflect};
use super::{Boundary, BsdfSample, Gloss};

/// Fresnel data of a metal at a surface point.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    /// Real part of the index of refraction, per channel.
    pub eta: Vec3,
    /// Imaginary part of the index of refraction, per channel.
    pub k: Vec3,
    /// Factor on the reflection.
    pub specular: Vec3,
}

impl Conductor {
    fn reflectance(&self, cos: f32) -> Vec3 {
        self.specular * fresnel::conductor(cos, self.eta, self.k)
    }

    /// Fresnel reflectance of a channel for a cosine in [0, 1], without the factor.
    #[inline(always)]
    pub(super) fn channel(&self, channel: usize, cos: f32) -> f32 {
        fresnel::conductor_channel(cos, self.eta[channel], self.k[channel])
    }

    /// The perfect mirror.
    pub(super) fn sample_mirror(&self, view: Vec3) -> Option<BsdfSample> {
        (view.z > 0.0).then(|| BsdfSample {
            direction: Vec3::new(-view.x, -view.y, view.z),
            weight: self.reflectance(view.z),
            pdf_sr: 1.0,
            delta: true,
        })
    }

    pub(super) fn evaluate(&self, facets: Microfacets, view: Vec3, light: Vec3) -> Vec3 {
        if view.z <= 0.0 || light.z <= 0.0 {
            return Vec3::ZERO;
        }
        let half = (view + light).normalize();
        let masking = facets.masking(view, half) * facets.masking(light, half);
        self.reflectance(view.dot(half)) * (facets.density(half) * masking / (4.0 * view.z))
    }

    /// See [`super::LocalBsdf::lobes`].
    pub(super) fn gloss(&self, facets: Microfacets) -> Gloss {
        Gloss {
            facets,
            boundary: Boundary::Conductor {
                facing: fresnel::conductor(1.0, self.eta, self.k),
                tilted: fresnel::conductor(1.0 / 7.0, self.eta, self.k),
            },
            specular: self.specular,
        }
    }

    pub(super) fn pdf(&self, facets: Microfacets, view: Vec3, light: Vec3) -> f32 {
        if view.z <= 0.0 || light.z <= 0.0 {
            return 0.0;
        }
        facets.reflection_pdf(view, (view + light).normalize())
    }

    pub(super) fn sample(
        &self,
        facets: Microfacets,
        view: Vec3,
        u: [f32; 2],
    ) -> Option<BsdfSample> {
        if view.z <= 0.0 {
            return None;
        }
        let half = facets.sample_visible(view, u);
        let light = reflect(view, half);
        let pdf_sr = facets.reflection_pdf(view, half);
        if light.z <= 0.0 || pdf_sr <= 0.0 {
            return None;
        }
        Some(BsdfSample {
            direction: light,
            weight: self.reflectance(view.dot(half)) * facets.masking(light, half),
            pdf_sr,
            delta: false,
        })
    }
}
