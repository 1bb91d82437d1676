//! Glass: a refracting boundary, clear or frosted, or a thin pane that lets light through undeviated.

use glam::Vec3;

use super::microfacet::reflect;
use super::{BsdfSample, Microfacets, fresnel};

/// A dielectric. Transmitted radiance is scaled by the square of the index ratio.
///
/// Directions of frosted glass (Walter et al. 2007) are found by sampling its facets alone, as those of clear glass by
/// sampling the boundary: all of them count as deltas, so that lights without extent do not show in it, and small ones
/// converge slowly.
#[derive(Clone, Copy, Debug)]
pub struct Dielectric {
    /// Interior over exterior index of refraction.
    pub ior: f32,
    /// Whether it is a pane: light passes undeviated, with the reflections inside it.
    pub thin: bool,
    /// Factor on what is reflected, linear RGB.
    pub reflectance: Vec3,
    /// Factor on what is transmitted, linear RGB.
    pub transmittance: Vec3,
    /// `None` is clear; panes are.
    pub facets: Option<Microfacets>,
}

impl Dielectric {
    /// The first number chooses between reflection and transmission with the Fresnel reflectance, the others the facet.
    pub(super) fn sample(&self, view: Vec3, [u, facet @ ..]: [f32; 3]) -> Option<BsdfSample> {
        if let Some(facets) = self.facets {
            return self.sample_rough(facets, view, [u, facet[0], facet[1]]);
        }
        let cos = if self.thin { view.z.abs() } else { view.z };
        let boundary = fresnel::dielectric(cos, self.ior);
        let mut reflected = boundary.reflectance;
        if self.thin && reflected < 1.0 {
            // All orders of reflection between the two sides of the pane.
            reflected *= 2.0 / (1.0 + reflected);
        }
        let delta = |direction, weight, pdf_sr| {
            Some(BsdfSample {
                direction,
                weight,
                pdf_sr,
                delta: true,
            })
        };
        if u < reflected {
            let mirrored = Vec3::new(-view.x, -view.y, view.z);
            return delta(mirrored, self.reflectance, reflected);
        }
        if self.thin {
            return delta(-view, self.transmittance, 1.0 - reflected);
        }
        let scale = 1.0 / boundary.eta_ratio;
        let refracted = Vec3::new(
            -scale * view.x,
            -scale * view.y,
            -boundary.cos_refracted.copysign(view.z),
        );
        delta(
            refracted,
            self.transmittance * (scale * scale),
            1.0 - reflected,
        )
    }

    /// A facet seen from `view` reflects or refracts.
    fn sample_rough(&self, facets: Microfacets, view: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let side = Vec3::new(1.0, 1.0, 1f32.copysign(view.z));
        let view = view * side;
        if view.z <= 0.0 {
            return None;
        }
        let facet = facets.sample_visible(view, [u[1], u[2]]);
        let cos = view.dot(facet);
        let boundary = fresnel::dielectric(cos * side.z, self.ior);
        let reflects = u[0] < boundary.reflectance;
        let (light, factor, chance) = if reflects {
            let reflected = reflect(view, facet);
            (reflected, self.reflectance, boundary.reflectance)
        } else {
            let scale = 1.0 / boundary.eta_ratio;
            let refracted = facet * (scale * cos - boundary.cos_refracted) - view * scale;
            let factor = self.transmittance * (scale * scale);
            (refracted, factor, 1.0 - boundary.reflectance)
        };
        // What goes to the wrong side would meet another facet, which is not followed.
        ((light.z > 0.0) == reflects).then(|| BsdfSample {
            direction: light * side,
            weight: factor * facets.masking(light, facet),
            pdf_sr: chance,
            delta: true,
        })
    }
}
