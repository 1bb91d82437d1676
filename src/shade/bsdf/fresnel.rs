//! Fresnel reflectances for unpolarised light.

use glam::Vec3;

/// Reflectance and refraction at a smooth dielectric boundary.
#[derive(Clone, Copy, Debug)]
pub struct DielectricFresnel {
    /// Share of the light that is reflected, in [0, 1].
    pub reflectance: f32,
    /// Cosine of the refracted direction, positive; 0 under total internal reflection.
    pub cos_refracted: f32,
    /// Index of the side the light goes to over that of the side it comes from.
    pub eta_ratio: f32,
}

/// Fresnel terms for the cosine `cos_incident` (negative: from inside) and the index of refraction
/// `ior` = interior over exterior, positive.
pub fn dielectric(cos_incident: f32, ior: f32) -> DielectricFresnel {
    let eta_ratio = if cos_incident >= 0.0 { ior } else { 1.0 / ior };
    let cos_i = cos_incident.abs().min(1.0);
    let sin2_refracted = (1.0 - cos_i * cos_i) / (eta_ratio * eta_ratio);
    if sin2_refracted >= 1.0 {
        return DielectricFresnel {
            reflectance: 1.0,
            cos_refracted: 0.0,
            eta_ratio,
        };
    }
    let cos_t = (1.0 - sin2_refracted).sqrt();
    let senkrecht = (cos_i - eta_ratio * cos_t) / (cos_i + eta_ratio * cos_t);
    let parallel = (eta_ratio * cos_i - cos_t) / (eta_ratio * cos_i + cos_t);
    DielectricFresnel {
        reflectance: 0.5 * (senkrecht * senkrecht + parallel * parallel),
        cos_refracted: cos_t,
        eta_ratio,
    }
}

/// The reflectance of [`dielectric`] for light from outside, its cosine in [0, 1], without a branch.
#[inline(always)]
pub fn outside(cos: f32, ior: f32) -> f32 {
    let cos = cos.min(1.0);
    let sin2_refracted = (1.0 - cos * cos) * (1.0 / (ior * ior));
    let refracted = (1.0 - sin2_refracted).max(0.0).sqrt();
    // Both fractions over one denominator.
    let (senkrecht, parallel) = (cos - ior * refracted, ior * cos - refracted);
    let (under_senkrecht, under_parallel) = (cos + ior * refracted, ior * cos + refracted);
    let (senkrecht, parallel) = (senkrecht * under_parallel, parallel * under_senkrecht);
    let under = under_senkrecht * under_parallel;
    let reflectance = 0.5 * (senkrecht * senkrecht + parallel * parallel) / (under * under);
    if sin2_refracted >= 1.0 {
        1.0
    } else {
        reflectance
    }
}

/// Reflectance of a conductor with complex index `eta + i k` per channel at `cos_incident` in
/// [0, 1]; a channel with `eta = 0` and `k = 0` reflects everything.
pub fn conductor(cos_incident: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let cos = cos_incident.clamp(0.0, 1.0);
    let channel = |c: usize| conductor_channel(cos, eta[c], k[c]);
    Vec3::new(channel(0), channel(1), channel(2))
}

/// One channel of [`conductor`].
#[inline(always)]
pub(super) fn conductor_channel(cos: f32, eta: f32, k: f32) -> f32 {
    if eta == 0.0 && k == 0.0 {
        return 1.0;
    }
    let cos2 = cos * cos;
    let sin2 = 1.0 - cos2;
    let difference = eta * eta - k * k - sin2;
    let a2_plus_b2 = (difference * difference + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (a2_plus_b2 + difference)).max(0.0).sqrt();
    let first = a2_plus_b2 + cos2;
    let second = 2.0 * a * cos;
    let senkrecht = (first - second) / (first + second);
    let third = a2_plus_b2 * cos2 + sin2 * sin2;
    let fourth = second * sin2;
    let parallel = senkrecht * (third - fourth) / (third + fourth);
    (0.5 * (senkrecht + parallel)).clamp(0.0, 1.0)
}

/// Mean reflectance of a smooth dielectric under diffuse light, `2 ∫ F(µ) µ dµ`, by the midpoint
/// rule; `ior` below 1 gives the reflectance from inside.
pub fn diffuse_reflectance(ior: f32) -> f32 {
    const STEPS: usize = 1 << 14;
    let sum: f64 = (0..STEPS)
        .map(|i| {
            let mu = (i as f64 + 0.5) / STEPS as f64;
            f64::from(dielectric(mu as f32, ior).reflectance) * mu
        })
        .sum();
    (2.0 * sum / STEPS as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_brewster_and_total_reflection() {
        assert!((dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-6);
        assert!((dielectric(-1.0, 1.5).reflectance - 0.04).abs() < 1e-6);
        assert_eq!(dielectric(0.0, 1.5).reflectance, 1.0);
        assert_eq!(dielectric(-0.3, 1.5).reflectance, 1.0);
        // At Brewster's angle only the perpendicular part remains.
        let cos = (1.0f32 / (1.0 + 1.5 * 1.5)).sqrt();
        let senkrecht = (1.0 - 1.5f32 * 1.5) / (1.0 + 1.5 * 1.5);
        assert!((dielectric(cos, 1.5).reflectance - 0.5 * senkrecht * senkrecht).abs() < 1e-6);
    }

    #[test]
    fn conductors_without_absorption_equal_dielectrics() {
        for cos in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let metal = conductor(cos, Vec3::splat(1.5), Vec3::ZERO).x;
            assert!((metal - dielectric(cos, 1.5).reflectance).abs() < 1e-5);
            assert_eq!(conductor(cos, Vec3::ZERO, Vec3::ZERO), Vec3::ONE);
            assert!((conductor(cos, Vec3::ZERO, Vec3::ONE).x - 1.0).abs() < 1e-6);
        }
        // Gold-like numbers at normal incidence: ((n-1)² + k²) / ((n+1)² + k²).
        let expected = (0.57f32 * 0.57 + 9.0) / (1.43f32.mul_add(1.43, 9.0));
        assert!((conductor(1.0, Vec3::splat(0.43), Vec3::splat(3.0)).x - expected).abs() < 1e-5);
    }

    #[test]
    fn diffuse_reflectance_matches_the_literature() {
        // Egan & Hilgeman: 0.5963 inside, 0.0918 outside glass of index 1.5.
        assert!((diffuse_reflectance(1.0 / 1.5) - 0.5963).abs() < 1e-3);
        assert!((diffuse_reflectance(1.5) - 0.0918).abs() < 1e-3);
    }
}
