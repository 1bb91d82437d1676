//! Lambertian reflection and the cosine warp that the other models share.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};

use glam::Vec3;

use super::BsdfSample;

/// Lambertian reflection of one side.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// Albedo, linear RGB.
    pub reflectance: Vec3,
}

impl Diffuse {
    pub(super) fn evaluate(&self, view: Vec3, light: Vec3) -> Vec3 {
        if view.z <= 0.0 {
            return Vec3::ZERO;
        }
        self.reflectance * cosine_pdf(light)
    }

    pub(super) fn pdf(&self, view: Vec3, light: Vec3) -> f32 {
        if view.z <= 0.0 {
            0.0
        } else {
            cosine_pdf(light)
        }
    }

    pub(super) fn sample(&self, view: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
        let light = cosine_sample(u);
        let pdf_sr = self.pdf(view, light);
        (pdf_sr > 0.0).then_some(BsdfSample {
            direction: light,
            weight: self.reflectance,
            pdf_sr,
            delta: false,
        })
    }
}

/// Density (1/sr) of [`cosine_sample`]; 0 below the surface.
pub fn cosine_pdf(direction: Vec3) -> f32 {
    direction.z.max(0.0) * FRAC_1_PI
}

/// A direction of the upper hemisphere with density cos θ / π (concentric disk, Shirley & Chiu).
pub fn cosine_sample(u: [f32; 2]) -> Vec3 {
    let [x, y] = [2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0];
    if x == 0.0 && y == 0.0 {
        return Vec3::Z;
    }
    let (radius, phi) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    };
    let (sin, cos) = phi.sin_cos();
    let z = (1.0 - radius * radius).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}
