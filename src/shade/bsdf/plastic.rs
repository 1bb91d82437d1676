//! A diffuse base under a dielectric coating, smooth or rough, with all orders of internal
//! reflection (the models of Mitsuba's `plastic` and `roughplastic`).

use std::collections::BTreeMap;
use std::f32::consts::FRAC_1_PI;
use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use rayon::prelude::*;

use super::diffuse::{cosine_pdf, cosine_sample};
use super::microfacet::{Microfacets, reflect};
use super::{Boundary, BsdfSample, Gloss, Lobes, fresnel};
use crate::scene::MicrofacetDistribution;

/// What is integrated once for a coating of given roughness and index.
#[derive(Clone, Debug)]
pub struct Coating {
    pub(super) ior: f32,
    /// `None` for the smooth coating.
    pub(super) facets: Option<Microfacets>,
    /// Transmittance from outside over the cosine, 0 to 1 in equal steps (rough coating only).
    transmittance: [f32; NODES],
    /// Mean reflectance from inside under diffuse light.
    internal_reflectance: f32,
    /// Mean transmittance from outside under diffuse light.
    pub(super) entering: f32,
    /// Polynomial of the transmittance, see [`polynomial`].
    fit: [f32; 9],
}

const NODES: usize = 64;
const QUADRATURE: usize = 96;

/// Coatings that were integrated already. Every frame of every viewer asks for those of all materials, and a rough one takes
/// a tenth of a second.
static KNOWN: Mutex<BTreeMap<[u32; 4], Arc<Coating>>> = Mutex::new(BTreeMap::new());

impl Coating {
    /// The coating of this roughness (0: smooth) and index, integrated when it is first asked for.
    pub fn of(distribution: MicrofacetDistribution, alpha: f32, ior: f32) -> Arc<Self> {
        let key = [distribution as u32, alpha.to_bits(), ior.to_bits(), 0];
        Self::remembered(key, || Self::new(facets_of(distribution, alpha), ior))
    }

    /// As [`Coating::of`], of a coating that loses nothing: see [`Coating::lossless`].
    pub fn lossless_of(distribution: MicrofacetDistribution, alpha: f32, ior: f32) -> Arc<Self> {
        let key = [distribution as u32, alpha.to_bits(), ior.to_bits(), 1];
        Self::remembered(key, || Self::lossless(facets_of(distribution, alpha), ior))
    }

    fn remembered(key: [u32; 4], make: impl FnOnce() -> Self) -> Arc<Self> {
        let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(coating) = known().get(&key) {
            return coating.clone();
        }
        // Unlocked: other threads help, and one of them may ask for a coating meanwhile.
        let coating = Arc::new(make());
        known().entry(key).or_insert(coating).clone()
    }

    /// Integrates the coating; no facets are a smooth one. *differs:* for a rough coating the internal
    /// reflectance is the plain mean over the table's nodes, as in Mitsuba, which lies 1.5 % below
    /// the integral.
    pub fn new(facets: Option<Microfacets>, ior: f32) -> Self {
        let Some(facets) = facets else {
            let smooth = |cos: f64| 1.0 - fresnel::dielectric(cos as f32, ior).reflectance;
            return Self {
                ior,
                facets: None,
                transmittance: [0.0; NODES],
                internal_reflectance: fresnel::diffuse_reflectance(1.0 / ior),
                entering: 1.0 - fresnel::diffuse_reflectance(ior),
                fit: polynomial(smooth),
            };
        };
        let rows: Vec<(f32, f32)> = (0..NODES)
            .into_par_iter()
            .map(|i| {
                let mu = node_cosine(i);
                let [_, transmitted] = boundary_shares(facets, mu, ior);
                let [reflected, _] = boundary_shares(facets, mu, 1.0 / ior);
                (transmitted, reflected * mu)
            })
            .collect();
        let mut coating = Self::tabulated(ior, facets, std::array::from_fn(|i| rows[i].0));
        coating.internal_reflectance = 2.0 * rows.iter().map(|r| r.1).sum::<f32>() / NODES as f32;
        coating
    }

    /// A coating of which all that its facets do not reflect enters, and of what comes back from the base as much
    /// leaves as entered: a white base under it reflects all light, at every roughness (the coupling of Kelemen &
    /// Szirmay-Kalos 2001). A smooth one is that of [`Coating::new`].
    pub fn lossless(facets: Option<Microfacets>, ior: f32) -> Self {
        let Some(facets) = facets else {
            return Self::new(None, ior);
        };
        let entering: Vec<f32> = (0..NODES)
            .into_par_iter()
            .map(|i| 1.0 - boundary_shares(facets, node_cosine(i), ior)[0])
            .collect();
        let mut coating = Self::tabulated(ior, facets, std::array::from_fn(|i| entering[i]));
        coating.internal_reflectance = 1.0 - coating.entering / (ior * ior);
        coating
    }

    /// A rough coating of this transmittance at the cosines of the table, without what happens under it.
    fn tabulated(ior: f32, facets: Microfacets, transmittance: [f32; NODES]) -> Self {
        let mut coating = Self {
            ior,
            facets: Some(facets),
            transmittance,
            internal_reflectance: 0.0,
            entering: 0.0,
            fit: [0.0; 9],
        };
        let cosine = |i: u32| (i as f32 + 0.5) / QUADRATURE as f32;
        let entering = |i: u32| cosine(i) * coating.transmittance(cosine(i));
        coating.entering =
            2.0 * (0..QUADRATURE as u32).map(entering).sum::<f32>() / QUADRATURE as f32;
        coating.fit = polynomial(|cos| coating.transmittance(cos as f32));
        coating
    }

    /// Share of light at this cosine that enters the coating.
    pub(super) fn transmittance(&self, cos: f32) -> f32 {
        if self.facets.is_none() {
            return 1.0 - fresnel::dielectric(cos, self.ior).reflectance;
        }
        self.entering_rough(cos)
    }

    /// [`Coating::transmittance`] of a rough coating.
    #[inline(always)]
    pub(super) fn entering_rough(&self, cos: f32) -> f32 {
        let x = cos.clamp(0.0, 1.0) * (NODES - 1) as f32;
        let i = (x as i32).clamp(0, NODES as i32 - 2) as usize;
        let [a, b] = [self.transmittance[i], self.transmittance[i + 1]];
        a + (x - i as f32) * (b - a)
    }
}

/// The cosine of a place in the table.
fn node_cosine(i: usize) -> f32 {
    (i as f32 / (NODES - 1) as f32).max(1e-6)
}

/// Those of a rough coating.
fn facets_of(distribution: MicrofacetDistribution, alpha: f32) -> Option<Microfacets> {
    (alpha > 0.0).then(|| Microfacets::new(distribution, alpha))
}

/// Coefficients, from the highest power down, of the polynomial in the cosine that passes through a
/// function of it at nine Chebyshev points of [0, 1].
fn polynomial(value: impl Fn(f64) -> f32) -> [f32; 9] {
    let node = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * (i as f64 + 0.5) / 9.0).cos();
    let mut differences: [f64; 9] = std::array::from_fn(|i| f64::from(value(node(i))));
    for order in 1..9 {
        for i in (order..9).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (node(i) - node(i - order));
        }
    }
    // Newton's form, multiplied out from the highest difference; lowest power first.
    let mut powers = [0.0f64; 9];
    for i in (0..9).rev() {
        for k in (1..9).rev() {
            powers[k] = powers[k - 1] - node(i) * powers[k];
        }
        powers[0] = differences[i] - node(i) * powers[0];
    }
    std::array::from_fn(|k| powers[8 - k] as f32)
}

/// Shares of light at cosine `mu` that a rough dielectric boundary reflects and lets through (single
/// scattering: what other facets catch belongs to neither), by the midpoint rule over visible
/// normals.
fn boundary_shares(facets: Microfacets, mu: f32, ior: f32) -> [f32; 2] {
    let view = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let centre = |i: usize| (i as f32 + 0.5) / QUADRATURE as f32;
    let mut sums = [0.0f64; 2];
    for i in 0..QUADRATURE * QUADRATURE {
        let u = [centre(i % QUADRATURE), centre(i / QUADRATURE)];
        let half = facets.sample_visible(view, u);
        let cos = view.dot(half).max(0.0);
        let fresnel = fresnel::dielectric(cos, ior);
        let reflected = reflect(view, half);
        if reflected.z > 0.0 {
            sums[0] += f64::from(fresnel.reflectance * facets.masking(reflected, half));
        }
        let scale = 1.0 / fresnel.eta_ratio;
        let refracted = half * (cos * scale - fresnel.cos_refracted) - view * scale;
        if refracted.z < 0.0 && fresnel.reflectance < 1.0 {
            sums[1] += f64::from((1.0 - fresnel.reflectance) * facets.masking(refracted, half));
        }
    }
    sums.map(|sum| (sum / (QUADRATURE * QUADRATURE) as f64) as f32)
}

/// A coated diffuse surface at a point.
#[derive(Clone, Copy, Debug)]
pub struct Plastic<'a> {
    /// What was integrated for its roughness and index.
    pub coating: &'a Coating,
    /// Albedo of the base, linear RGB.
    pub diffuse: Vec3,
    /// Factor on the reflection of the coating.
    pub specular: Vec3,
    /// Whether internal scattering shifts the colour.
    pub nonlinear: bool,
}

impl Plastic<'_> {
    /// The diffuse part with internal reflections, without the two passages of the boundary.
    pub(super) fn base(&self) -> Vec3 {
        let inside = self.coating.internal_reflectance;
        let trapped = if self.nonlinear {
            self.diffuse * inside
        } else {
            Vec3::splat(inside)
        };
        self.diffuse / (Vec3::ONE - trapped) / (self.coating.ior * self.coating.ior)
    }

    /// What is multiplied with what base and gloss scatter to a viewer at this cosine.
    pub(super) fn weights(&self, cosine: f32) -> [Vec3; 2] {
        let through = self.coating.transmittance(cosine) * FRAC_1_PI;
        [self.base() * through, self.specular]
    }

    /// See [`super::LocalBsdf::lobes`].
    pub(super) fn lobes(&self, cos_view: f32) -> Lobes {
        let boundary = Boundary::Dielectric {
            ior: self.coating.ior,
        };
        Lobes {
            diffuse: self.base() * (FRAC_1_PI * self.coating.transmittance(cos_view)),
            transmission: Some(self.coating.fit),
            gloss: self.coating.facets.map(|facets| Gloss {
                facets,
                boundary,
                specular: self.specular,
            }),
        }
    }

    /// Whether the coating is a mirror.
    pub(super) fn is_smooth(&self) -> bool {
        self.coating.facets.is_none()
    }

    /// Directional albedo of what is under the coating.
    pub(super) fn base_albedo(&self, cos_view: f32) -> Vec3 {
        self.base() * (self.coating.transmittance(cos_view) * self.coating.entering)
    }

    /// A direction that the coating reflects to the viewer, and its weight: the mean over `u` is the
    /// coating's directional albedo.
    pub(super) fn reflection(&self, view: Vec3, u: [f32; 2]) -> (Vec3, Vec3) {
        let Some(facets) = self.coating.facets else {
            let share = 1.0 - self.coating.transmittance(view.z);
            return (Vec3::new(-view.x, -view.y, view.z), self.specular * share);
        };
        let half = facets.sample_visible(view, u);
        let light = reflect(view, half);
        let boundary = fresnel::dielectric(view.dot(half), self.coating.ior).reflectance;
        let weight = boundary * facets.masking(light, half);
        (light, self.specular * weight)
    }

    /// Probability of sampling the coating's reflection from a direction.
    pub(super) fn specular_probability(&self, transmittance: f32) -> f32 {
        let [d, s] = [self.diffuse.element_sum(), self.specular.element_sum()];
        let coat = (1.0 - transmittance) * s;
        let base = transmittance * d;
        if coat + base > 0.0 {
            coat / (coat + base)
        } else {
            0.0
        }
    }

    pub(super) fn evaluate(&self, view: Vec3, light: Vec3) -> Vec3 {
        if view.z <= 0.0 || light.z <= 0.0 {
            return Vec3::ZERO;
        }
        let through = self.coating.transmittance(view.z) * self.coating.transmittance(light.z);
        let base = self.base() * (FRAC_1_PI * light.z * through);
        let Some(facets) = self.coating.facets else {
            return base;
        };
        let half = (view + light).normalize();
        base + self.specular * self.coating_reflection(facets, view, [light, half])
    }

    /// What the coating's facets reflect from `light` to `view` × cosine of `light`, but for its colour.
    pub(super) fn coating_reflection(
        &self,
        facets: Microfacets,
        view: Vec3,
        [light, half]: [Vec3; 2],
    ) -> f32 {
        let boundary = fresnel::dielectric(view.dot(half), self.coating.ior).reflectance;
        let masking = facets.masking(view, half) * facets.masking(light, half);
        boundary * facets.density(half) * masking / (4.0 * view.z)
    }

    pub(super) fn pdf(&self, view: Vec3, light: Vec3) -> f32 {
        if view.z <= 0.0 || light.z <= 0.0 {
            return 0.0;
        }
        let specular = self.specular_probability(self.coating.transmittance(view.z));
        let base = (1.0 - specular) * cosine_pdf(light);
        match self.coating.facets {
            None => base,
            Some(facets) => {
                base + specular * facets.reflection_pdf(view, (view + light).normalize())
            }
        }
    }

    pub(super) fn sample(&self, view: Vec3, choice: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if view.z <= 0.0 {
            return None;
        }
        let transmittance = self.coating.transmittance(view.z);
        let specular = self.specular_probability(transmittance);
        let light = match self.coating.facets {
            _ if choice >= specular => cosine_sample(u),
            Some(facets) => reflect(view, facets.sample_visible(view, u)),
            None => {
                return Some(BsdfSample {
                    direction: Vec3::new(-view.x, -view.y, view.z),
                    weight: self.specular * ((1.0 - transmittance) / specular),
                    pdf_sr: specular,
                    delta: true,
                });
            }
        };
        let pdf_sr = self.pdf(view, light);
        (pdf_sr > 0.0).then(|| BsdfSample {
            direction: light,
            weight: self.evaluate(view, light) / pdf_sr,
            pdf_sr,
            delta: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coating_is_integrated_once_and_is_the_same_as_anew() {
        let of = |alpha| Coating::of(MicrofacetDistribution::Ggx, alpha, 1.45);
        assert!(Arc::ptr_eq(&of(0.2), &of(0.2)) && !Arc::ptr_eq(&of(0.2), &of(0.3)));
        let facets = Microfacets::new(MicrofacetDistribution::Ggx, 0.2);
        let anew = Coating::new(Some(facets), 1.45);
        assert_eq!(
            (anew.transmittance, anew.fit),
            (of(0.2).transmittance, of(0.2).fit)
        );
    }

    #[test]
    fn the_polynomial_follows_the_transmittance() {
        for alpha in [0.0, 0.15, 0.4] {
            let facets =
                (alpha > 0.0).then(|| Microfacets::new(MicrofacetDistribution::Ggx, alpha));
            let coating = Coating::new(facets, 1.5);
            for i in 0..=100 {
                let cos = i as f32 / 100.0;
                let fit = coating.fit.iter().fold(0.0, |sum, c| sum * cos + c);
                let off = (fit - coating.transmittance(cos)).abs();
                assert!(off < 0.01, "alpha {alpha}, cosine {cos}: {off}");
            }
        }
    }

    /// Under a white sky a surface of base 0.8 shows about 0.8 (glTF's formula: 0.04 + 0.96 · 0.8 head on), however rough.
    #[test]
    fn a_lossless_coating_keeps_what_it_does_not_reflect() {
        for alpha in [0.0, 0.05, 0.25, 0.64, 1.0] {
            for ior in [1.1, 1.5, 2.0] {
                let facets = facets_of(MicrofacetDistribution::Ggx, alpha);
                let coating = Coating::lossless(facets, ior);
                let of = |base: f32, cos: f32| {
                    let plastic = Plastic {
                        coating: &coating,
                        diffuse: Vec3::splat(base),
                        specular: Vec3::ONE,
                        nonlinear: false,
                    };
                    let view = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                    let points = (0..1 << 12).map(|i| crate::sample::additive([0.5; 3], i));
                    let gloss = points.map(|u| plastic.reflection(view, [u[1], u[2]]));
                    let seen = gloss
                        .filter(|(light, _)| light.z > 0.0)
                        .map(|(_, weight)| weight.x);
                    plastic.base_albedo(cos).x + seen.sum::<f32>() / 4096.0
                };
                for cos in [0.2, 0.5, 1.0] {
                    let white = of(1.0, cos);
                    assert!(
                        (white - 1.0).abs() < 0.01,
                        "alpha {alpha}, index {ior}, cosine {cos}: {white}"
                    );
                    let grey = of(0.8, cos);
                    assert!((0.79..1.0).contains(&grey), "{grey}");
                }
            }
        }
    }
}
