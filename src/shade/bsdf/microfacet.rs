//! The GGX distribution of microfacet normals with separable Smith masking, in the local frame of
//! the surface (z along the shading normal).

use std::f32::consts::PI;

use glam::Vec3;

/// Isotropic GGX of roughness `alpha` (Walter et al. 2007).
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// `alpha` is clamped to at least 10⁻⁴.
    pub fn new(alpha: f32) -> Self {
        Self {
            alpha: alpha.max(1e-4),
        }
    }

    /// Density of normals per projected area (1/sr) at the unit normal `m`.
    pub fn density(self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let stretched = (m.x * m.x + m.y * m.y) / (self.alpha * self.alpha) + m.z * m.z;
        let density = 1.0 / (PI * self.alpha * self.alpha * stretched * stretched);
        if density * m.z > 1e-20 { density } else { 0.0 }
    }

    /// Smith's masking of direction `v` for the normal `m`; 0 when they disagree about the side.
    pub fn masking(self, v: Vec3, m: Vec3) -> f32 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        let tan2 = (v.x * v.x + v.y * v.y) / (v.z * v.z);
        2.0 / (1.0 + (1.0 + self.alpha * self.alpha * tan2).sqrt())
    }

    /// A normal visible from `v` (z > 0), distributed as `masking · max(0, v·m) · density / v.z`
    /// (the spherical-cap form of Dupuy & Benyoub 2023).
    pub fn sample_visible(self, v: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha * v.x, self.alpha * v.y, v.z).normalize();
        let (sin_phi, cos_phi) = (2.0 * PI * u[0]).sin_cos();
        let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
        let sin = (1.0 - z * z).max(0.0).sqrt();
        let half = Vec3::new(sin * cos_phi, sin * sin_phi, z) + stretched;
        Vec3::new(self.alpha * half.x, self.alpha * half.y, half.z.max(1e-9)).normalize()
    }

    /// Density (1/sr) of light directions made by reflecting `v` at visible normals; `half` is the
    /// unit half vector.
    pub fn reflection_pdf(self, v: Vec3, half: Vec3) -> f32 {
        self.density(half) * self.masking(v, half) / (4.0 * v.z)
    }
}

/// Mirror image of `v` about the unit normal `m`; both point away from the surface.
pub fn reflect(v: Vec3, m: Vec3) -> Vec3 {
    2.0 * v.dot(m) * m - v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn visible_area_projects_to_the_cosine() {
        // ∫ masking · max(0, v·m) · density dm = v.z, by uniform sampling of the hemisphere.
        for alpha in [0.2, 0.5, 1.0] {
            let ggx = Ggx::new(alpha);
            for cos in [0.2f32, 0.7, 1.0] {
                let v = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let mut rng = Rng::new(1, 0, 0, 0);
                let n = 400_000;
                let mut sum = 0.0f64;
                for _ in 0..n {
                    let z = rng.next_f32();
                    let phi = 2.0 * PI * rng.next_f32();
                    let s = (1.0 - z * z).sqrt();
                    let m = Vec3::new(s * phi.cos(), s * phi.sin(), z);
                    sum += f64::from(ggx.masking(v, m) * v.dot(m).max(0.0) * ggx.density(m));
                }
                let area = sum * 2.0 * std::f64::consts::PI / f64::from(n);
                assert!(
                    (area - f64::from(cos)).abs() < 0.02,
                    "{alpha} {cos}: {area}"
                );
            }
        }
    }

    #[test]
    fn sampled_normals_are_unit_upper_and_visible() {
        let mut rng = Rng::new(2, 0, 0, 0);
        for alpha in [0.0, 0.01, 0.3, 1.0] {
            for cos in [1e-4f32, 0.1, 0.9, 1.0] {
                let v = Vec3::new(0.0, (1.0 - cos * cos).sqrt(), cos);
                for _ in 0..1000 {
                    let m = Ggx::new(alpha).sample_visible(v, [rng.next_f32(), rng.next_f32()]);
                    assert!((m.length() - 1.0).abs() < 1e-4 && m.z > 0.0 && v.dot(m) > -1e-4);
                }
            }
        }
    }
}
