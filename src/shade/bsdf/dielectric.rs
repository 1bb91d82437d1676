//! Smooth glass: a refracting boundary, or a thin pane that lets light through undeviated.

use glam::Vec3;

use super::BsdfSample;
use super::fresnel;

/// A smooth dielectric; all scattering is in delta directions. Transmitted radiance is scaled by
/// the square of the index ratio.
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
}

impl Dielectric {
    /// `u` chooses between reflection and transmission with the Fresnel reflectance.
    pub(super) fn sample(&self, view: Vec3, u: f32) -> Option<BsdfSample> {
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
}
