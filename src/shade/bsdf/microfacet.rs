//! Distributions of microfacet normals with separable Smith masking, in the local frame of the
//! surface (z along the shading normal).

use std::f32::consts::{FRAC_2_SQRT_PI, PI};

use glam::Vec3;

use crate::scene::MicrofacetDistribution;

/// Isotropic microfacets of roughness `alpha` (Walter et al. 2007).
#[derive(Clone, Copy, Debug)]
pub struct Microfacets {
    distribution: MicrofacetDistribution,
    alpha: f32,
}

impl Microfacets {
    /// `alpha` is clamped to at least 10⁻⁴.
    pub fn new(distribution: MicrofacetDistribution, alpha: f32) -> Self {
        Self {
            distribution,
            alpha: alpha.max(1e-4),
        }
    }

    /// How their normals spread.
    pub fn distribution(self) -> MicrofacetDistribution {
        self.distribution
    }

    /// Roughness.
    pub fn alpha(self) -> f32 {
        self.alpha
    }

    /// Density of normals per projected area (1/sr) at the unit normal `m`.
    pub fn density(self, m: Vec3) -> f32 {
        if m.z <= 0.0 {
            return 0.0;
        }
        let alpha2 = self.alpha * self.alpha;
        let tilt = (m.x * m.x + m.y * m.y) / alpha2;
        let cos2 = m.z * m.z;
        let density = match self.distribution {
            MicrofacetDistribution::Ggx => {
                let spread = tilt + cos2;
                1.0 / (PI * alpha2 * spread * spread)
            }
            MicrofacetDistribution::Beckmann => (-tilt / cos2).exp() / (PI * alpha2 * cos2 * cos2),
        };
        if density * m.z > 1e-20 { density } else { 0.0 }
    }

    /// Smith's masking of direction `v` for the normal `m`; 0 when they disagree about the side.
    ///
    /// *differs:* Beckmann's is the rational approximation of Walter et al. (within 0.35 %), as in
    /// Mitsuba.
    pub fn masking(self, v: Vec3, m: Vec3) -> f32 {
        if v.dot(m) * v.z <= 0.0 {
            return 0.0;
        }
        let tan2 = (v.x * v.x + v.y * v.y) / (v.z * v.z) * self.alpha * self.alpha;
        match self.distribution {
            MicrofacetDistribution::Ggx => 2.0 / (1.0 + (1.0 + tan2).sqrt()),
            MicrofacetDistribution::Beckmann => {
                let a = 1.0 / tan2.sqrt();
                if a < 1.6 {
                    a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a))
                } else {
                    1.0
                }
            }
        }
    }

    /// A normal visible from `v` (z > 0), distributed as `masking · max(0, v·m) · density / v.z`
    /// (the spherical-cap form of Dupuy & Benyoub 2023 for GGX; for Beckmann the exact distribution,
    /// so that `masking` is off by its approximation).
    pub fn sample_visible(self, v: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha * v.x, self.alpha * v.y, v.z).normalize();
        let half = match self.distribution {
            MicrofacetDistribution::Ggx => visible_cap(stretched, u),
            MicrofacetDistribution::Beckmann => visible_gaussian(stretched, u),
        };
        Vec3::new(self.alpha * half.x, self.alpha * half.y, half.z.max(1e-9)).normalize()
    }

    /// Density (1/sr) of light directions made by reflecting `v` at visible normals; `half` is the
    /// unit half vector.
    pub fn reflection_pdf(self, v: Vec3, half: Vec3) -> f32 {
        self.density(half) * self.masking(v, half) / (4.0 * v.z)
    }
}

/// GGX facets seen by a viewer above the surface, for light from many directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct GgxMirror {
    view: Vec3,
    alpha2: f32,
    inverse_alpha2: f32,
    /// What no direction of light changes.
    scale: f32,
}

impl GgxMirror {
    pub fn new(facets: Microfacets, view: Vec3) -> Self {
        let alpha2 = facets.alpha * facets.alpha;
        Self {
            view,
            alpha2,
            inverse_alpha2: 1.0 / alpha2,
            scale: facets.masking(view, Vec3::Z) / (2.0 * PI * alpha2 * view.z),
        }
    }

    /// What facets reflect from a unit direction to the viewer (density × masking / (4 cos)) × cosine of the light, 0 from
    /// below, and the cosine between the facet and either of them, in [0, 1].
    #[inline(always)]
    pub fn reflected(&self, x: f32, y: f32, z: f32) -> (f32, f32) {
        let view = self.view;
        let (hx, hy, hz) = (view.x + x, view.y + y, view.z + z);
        let across2 = hx * hx + hy * hy;
        let inverse2 = 1.0 / (across2 + hz * hz);
        let towards = (view.x * hx + view.y * hy + view.z * hz) * inverse2.sqrt();
        let spread = (across2 * self.inverse_alpha2 + hz * hz) * inverse2;
        // 2 z / `masked` is the masking of the light.
        let masked = z + (z * z + self.alpha2 * (x * x + y * y)).sqrt();
        let is_seen = (towards > 0.0) & (z > 0.0);
        let reflected = self.scale * z / (spread * spread * masked);
        let reflected = if is_seen { reflected } else { 0.0 };
        (reflected, towards.clamp(0.0, 1.0))
    }
}

/// A normal of the unit hemisphere visible from `v`; its length is arbitrary.
fn visible_cap(v: Vec3, u: [f32; 2]) -> Vec3 {
    let (sin_phi, cos_phi) = (2.0 * PI * u[0]).sin_cos();
    let z = (1.0 - u[1]) * (1.0 + v.z) - v.z;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(sin * cos_phi, sin * sin_phi, z) + v
}

/// A normal of a Gaussian surface of roughness 1 visible from the unit vector `v`; z = 1.
///
/// The slope across `v` is Gaussian; that along it, rising towards `v`, has the density
/// `(cos + s sin) exp(−s²)`, positive part, whose integral is inverted by safeguarded Newton steps in
/// `erf s` (the parametrisation of Jakob 2014).
fn visible_gaussian(v: Vec3, u: [f32; 2]) -> Vec3 {
    let sin = (v.x * v.x + v.y * v.y).sqrt();
    let [cos_phi, sin_phi] = if sin > 0.0 {
        [v.x / sin, v.y / sin]
    } else {
        [1.0, 0.0]
    };
    let along = visible_slope(sin, v.z, u[0]);
    let across = erf_inverse(2.0 * u[1] - 1.0);
    Vec3::new(
        along * cos_phi - across * sin_phi,
        along * sin_phi + across * cos_phi,
        1.0,
    )
}

/// Tilt of the normal towards a direction of this sine and cosine for `u` in [0, 1).
fn visible_slope(sin: f32, cos: f32, u: f32) -> f32 {
    let gaussian = |slope: f32| sin * 0.5 * FRAC_2_SQRT_PI * (-slope * slope).exp();
    // x = −tilt; the facet is seen from x = −∞ up to the cotangent.
    let integral = |x: f32, erf_x: f32| cos * (1.0 + erf_x) + gaussian(x);
    let cotangent = cos / sin;
    let (mut low, mut high) = (-1.0f32, erf(cotangent));
    let target = u * integral(cotangent, high);
    let mut erf_x = low + (high - low) * u;
    let mut x = erf_inverse(erf_x);
    for _ in 0..24 {
        let excess = integral(x, erf_x) - target;
        if excess > 0.0 {
            high = erf_x;
        } else {
            low = erf_x;
        }
        let newton = erf_x - excess / (cos - x * sin);
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let change = (next - erf_x).abs();
        erf_x = next;
        x = erf_inverse(erf_x);
        if change < 1e-6 * (1.0 - erf_x.abs()).max(1e-3) {
            break;
        }
    }
    -x
}

/// The error function (Abramowitz & Stegun 7.1.26, within 1.5·10⁻⁷).
fn erf(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let polynomial = t
        * (0.254_829_6
            + t * (-0.284_496_74 + t * (1.421_413_7 + t * (-1.453_152 + t * 1.061_405_4))));
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

/// The inverse of the error function (Giles 2010, single precision); arguments beyond ±(1 − 10⁻⁷)
/// are clamped.
fn erf_inverse(y: f32) -> f32 {
    let y = y.clamp(-0.999_999_9, 0.999_999_9);
    let w = -((1.0 - y) * (1.0 + y)).ln();
    let (w, coefficients): (f32, [f32; 9]) = if w < 5.0 {
        (
            w - 2.5,
            [
                2.810_226_4e-8,
                3.432_739_4e-7,
                -3.523_387_7e-6,
                -4.391_506_5e-6,
                2.185_808_7e-4,
                -1.253_725e-3,
                -4.177_681_6e-3,
                0.246_640_73,
                1.501_409_4,
            ],
        )
    } else {
        (
            w.sqrt() - 3.0,
            [
                -2.002_142_6e-4,
                1.009_505_6e-4,
                1.349_343_2e-3,
                -3.673_428_4e-3,
                5.739_507_7e-3,
                -7.622_461_3e-3,
                9.438_870_5e-3,
                1.001_674,
                2.832_976_8,
            ],
        )
    };
    coefficients.iter().fold(0.0, |sum, c| sum * w + c) * y
}

/// Mirror image of `v` about the unit normal `m`; both point away from the surface.
pub fn reflect(v: Vec3, m: Vec3) -> Vec3 {
    2.0 * v.dot(m) * m - v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    const DISTRIBUTIONS: [MicrofacetDistribution; 2] = [
        MicrofacetDistribution::Ggx,
        MicrofacetDistribution::Beckmann,
    ];

    #[test]
    fn visible_area_projects_to_the_cosine() {
        // ∫ masking · max(0, v·m) · density dm = v.z, by uniform sampling of the hemisphere.
        let alphas = [0.2, 0.5, 1.0].map(|alpha| DISTRIBUTIONS.map(|d| (d, alpha)));
        for (distribution, alpha) in alphas.into_iter().flatten() {
            let facets = Microfacets::new(distribution, alpha);
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
                    sum += f64::from(facets.masking(v, m) * v.dot(m).max(0.0) * facets.density(m));
                }
                let area = sum * 2.0 * std::f64::consts::PI / f64::from(n);
                assert!(
                    (area - f64::from(cos)).abs() < 0.02,
                    "{distribution:?} {alpha} {cos}: {area}"
                );
            }
        }
    }

    #[test]
    fn sampled_normals_are_unit_upper_and_visible() {
        let mut rng = Rng::new(2, 0, 0, 0);
        let alphas = [0.0, 0.01, 0.3, 1.0].map(|alpha| DISTRIBUTIONS.map(|d| (d, alpha)));
        for (distribution, alpha) in alphas.into_iter().flatten() {
            let facets = Microfacets::new(distribution, alpha);
            for cos in [1e-4f32, 0.1, 0.9, 1.0] {
                let v = Vec3::new(0.0, (1.0 - cos * cos).sqrt(), cos);
                for _ in 0..1000 {
                    let m = facets.sample_visible(v, [rng.next_f32(), rng.next_f32()]);
                    assert!((m.length() - 1.0).abs() < 1e-4 && m.z > 0.0 && v.dot(m) > -1e-4);
                }
            }
        }
    }
    #[test]
    fn the_error_function_and_its_inverse_are_those_of_the_tables() {
        for (x, value) in [
            (0.0, 0.0),
            (0.1, 0.112_462_92),
            (0.5, 0.520_499_9),
            (1.0, 0.842_700_8),
            (2.0, 0.995_322_3),
        ] {
            assert!((erf(x) - value).abs() < 5e-7 && (erf(-x) + value).abs() < 5e-7);
            assert!((erf_inverse(value) - x).abs() < 2e-5, "{x}");
        }
        assert!(erf(f32::INFINITY) == 1.0 && erf_inverse(1.0).is_finite());
    }

    #[test]
    fn gaussian_slopes_are_seen_by_their_projected_area() {
        // Share of the visible area with a tilt below t, by a fine midpoint rule.
        for cos in [0.02f64, 0.3, 0.8, 0.999] {
            let sin = (1.0 - cos * cos).sqrt();
            let area = |from: f64, to: f64| -> f64 {
                let n = 20_000;
                let step = (to - from) / f64::from(n);
                (0..n)
                    .map(|i| from + (f64::from(i) + 0.5) * step)
                    .map(|t| (cos + t * sin).max(0.0) * (-t * t).exp() * step)
                    .sum()
            };
            let lowest = (-cos / sin).max(-6.0);
            for u in [0.01f32, 0.2, 0.5, 0.9, 0.999] {
                let tilt = visible_slope(sin as f32, cos as f32, u);
                // The share runs from the steepest tilt towards the eye down.
                let share = area(f64::from(tilt), 6.0) / area(lowest, 6.0);
                assert!((share - f64::from(u)).abs() < 1e-4, "{cos} {u}: {share}");
            }
        }
    }
}
