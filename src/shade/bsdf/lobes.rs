//! Scattering as plain numbers, for loops over many lights at one point.

use glam::Vec3;

use super::{LocalBsdf, Microfacets, Model};

/// What of a surface point scatters light, as a function of the cosines among normal, view and light.
#[derive(Clone, Copy, Debug)]
pub struct Lobes {
    /// Lambertian coefficient (1/sr): times the cosine, and times `transmission`.
    pub diffuse: Vec3,
    /// Share of light that enters a coating, coefficients of a polynomial in the cosine from the
    /// highest down; `None`: all does.
    pub transmission: Option<[f32; 9]>,
    /// The rough reflection; `None` where there is none, as of perfect mirrors.
    pub gloss: Option<Gloss>,
}

/// A microfacet lobe.
#[derive(Clone, Copy, Debug)]
pub struct Gloss {
    /// How its normals spread.
    pub facets: Microfacets,
    /// How much each of them reflects.
    pub boundary: Boundary,
    /// Factor on the reflection.
    pub specular: Vec3,
}

/// How much facets reflect.
#[derive(Clone, Copy, Debug)]
pub enum Boundary {
    /// Fresnel reflectance without absorption.
    Dielectric {
        /// Interior over exterior index of refraction.
        ior: f32,
    },
    /// Reflectance at cosines 1 and 1/7, from which that between follows (Lazányi & Szirmay-Kalos
    /// 2005, as in Hoffman 2019).
    Conductor {
        /// At cosine 1, linear RGB.
        facing: Vec3,
        /// At cosine 1/7, linear RGB.
        tilted: Vec3,
    },
}

impl LocalBsdf<'_> {
    /// The lobes towards a viewer at this cosine (on the lit side); delta parts are left out.
    pub fn lobes(&self, cos_view: f32) -> Lobes {
        let dark = Lobes {
            diffuse: Vec3::ZERO,
            transmission: None,
            gloss: None,
        };
        if cos_view <= 0.0 {
            return dark;
        }
        let mut lobes = match &self.model {
            Model::Diffuse(m) => Lobes {
                diffuse: m.reflectance * std::f32::consts::FRAC_1_PI,
                ..dark
            },
            Model::Plastic(m) => m.lobes(cos_view),
            Model::RoughConductor(m, facets) => Lobes {
                gloss: Some(m.gloss(*facets)),
                ..dark
            },
            Model::Mirror(_) | Model::Dielectric(_) => dark,
        };
        lobes.diffuse *= self.opacity;
        if let Some(gloss) = &mut lobes.gloss {
            gloss.specular *= self.opacity;
        }
        lobes
    }
}
