//! Properties every scattering model must have.

use std::f64::consts::PI;

use glam::Vec3;

use super::*;
use crate::sample::Rng;
use crate::scene::MicrofacetDistribution::{self, Beckmann, Ggx};

pub(super) fn models(coatings: &[Coating]) -> Vec<(&'static str, Model<'_>)> {
    let metal = Conductor {
        eta: Vec3::new(0.2, 0.92, 1.1),
        k: Vec3::new(3.9, 2.45, 2.14),
        specular: Vec3::splat(0.9),
    };
    let perfect = Conductor {
        eta: Vec3::ZERO,
        k: Vec3::ZERO,
        specular: Vec3::ONE,
    };
    let plastic = |i: usize, nonlinear| {
        Model::Plastic(Plastic {
            coating: &coatings[i],
            diffuse: Vec3::new(0.9, 0.5, 0.1),
            specular: Vec3::ONE,
            nonlinear,
        })
    };
    vec![
        (
            "diffuse",
            Model::Diffuse(Diffuse {
                reflectance: Vec3::new(1.0, 0.5, 0.0),
            }),
        ),
        ("smooth plastic", plastic(0, false)),
        ("rough plastic", plastic(1, true)),
        ("rough plastic, linear", plastic(1, false)),
        ("very rough plastic", plastic(2, true)),
        ("Beckmann plastic", plastic(3, true)),
        (
            "rough metal",
            Model::RoughConductor(metal, facets(Ggx, 0.3)),
        ),
        ("glossy", Model::RoughConductor(perfect, facets(Ggx, 0.1))),
        (
            "Beckmann metal",
            Model::RoughConductor(metal, facets(Beckmann, 0.3)),
        ),
        (
            "glossy Beckmann",
            Model::RoughConductor(perfect, facets(Beckmann, 0.1)),
        ),
        ("mirror", Model::Mirror(metal)),
    ]
}

pub(super) fn coatings() -> Vec<Coating> {
    vec![
        Coating::new(None, 1.5),
        Coating::new(Some(facets(Ggx, 0.2)), 1.5),
        Coating::new(Some(facets(Ggx, 0.8)), 1.49),
        Coating::new(Some(facets(Beckmann, 0.3)), 1.49),
    ]
}

fn facets(distribution: MicrofacetDistribution, alpha: f32) -> Microfacets {
    Microfacets::new(distribution, alpha)
}

pub(super) fn bsdf(model: Model<'_>) -> LocalBsdf<'_> {
    LocalBsdf {
        model,
        two_sided: false,
        opacity: 1.0,
    }
}

fn direction(cos: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).sqrt();
    Vec3::new(sin * 0.6, sin * 0.8, cos)
}

const COSINES: [f32; 4] = [0.08, 0.4, 0.8, 1.0];

/// Integrates over the upper hemisphere with a fine midpoint grid in (cos θ, φ).
fn integrate(f: impl Fn(Vec3) -> Vec3) -> Vec3 {
    let (rows, columns) = (400, 800);
    let mut sum = glam::DVec3::ZERO;
    for row in 0..rows {
        let z = (row as f32 + 0.5) / rows as f32;
        let s = (1.0 - z * z).sqrt();
        for column in 0..columns {
            let phi = (column as f32 + 0.5) / columns as f32 * std::f32::consts::TAU;
            sum += f(Vec3::new(s * phi.cos(), s * phi.sin(), z)).as_dvec3();
        }
    }
    (sum * 2.0 * PI / f64::from(rows * columns)).as_vec3()
}

fn draw(rng: &mut Rng) -> [f32; 3] {
    [rng.next_f32(), rng.next_f32(), rng.next_f32()]
}

#[test]
fn no_model_creates_energy_and_weights_average_to_the_albedo() {
    let coatings = coatings();
    for (name, model) in models(&coatings) {
        let bsdf = bsdf(model);
        for cos in COSINES {
            let view = direction(cos);
            let mut rng = Rng::new(3, 0, 0, 0);
            let (mut all, mut smooth) = (Vec3::ZERO, Vec3::ZERO);
            let n = 100_000;
            for _ in 0..n {
                if let Some(sample) = bsdf.sample(view, draw(&mut rng)) {
                    all += sample.weight / n as f32;
                    if !sample.delta {
                        smooth += sample.weight / n as f32;
                    }
                }
            }
            assert!(all.max_element() < 1.01, "{name} at {cos}: {all}");
            let albedo = integrate(|light| bsdf.evaluate(view, light));
            let error = (albedo - smooth).abs().max_element();
            assert!(error < 0.012, "{name} at {cos}: {albedo} {smooth}");
        }
    }
}

#[test]
fn base_and_reflections_are_the_directional_albedo() {
    let coatings = coatings();
    for (name, model) in models(&coatings) {
        for cos in [1.0, 0.8, 0.4, -0.6] {
            let (bsdf, view) = (bsdf(model), direction(cos));
            let reflected: Vec3 = bsdf.reflections(view).map(|(_, weight)| weight).sum();
            let parts = bsdf.base_albedo(view) + reflected;
            // Of a smooth coating, scattering is the base alone.
            let (parts, whole) = match model {
                Model::Mirror(_) => (parts, bsdf.directional_albedo(view)),
                _ if name == "smooth plastic" => (
                    bsdf.base_albedo(view),
                    integrate(|light| bsdf.evaluate(view, light)),
                ),
                _ => (parts, integrate(|light| bsdf.evaluate(view, light))),
            };
            let error = (parts - whole).abs().max_element();
            assert!(error < 0.05, "{name} at {cos}: {parts} {whole}");
            for (light, _) in bsdf.reflections(view) {
                assert!((light.length() - 1.0).abs() < 1e-4, "{name}: {light}");
                assert!(light.z * view.z > 0.0, "{name} at {cos}: {light}");
            }
        }
    }
}

#[test]
fn densities_integrate_to_the_share_of_smooth_samples() {
    let coatings = coatings();
    for (name, model) in models(&coatings) {
        let bsdf = bsdf(model);
        for cos in COSINES {
            let view = direction(cos);
            let mut rng = Rng::new(4, 0, 0, 0);
            let n = 50_000;
            let smooth = (0..n)
                .filter(|_| bsdf.sample(view, draw(&mut rng)).is_some_and(|s| !s.delta))
                .count() as f32
                / n as f32;
            let integral = integrate(|light| Vec3::splat(bsdf.pdf(view, light))).x;
            assert!(
                (integral - smooth).abs() < 0.015,
                "{name} at {cos}: {integral} {smooth}"
            );
        }
    }
}

/// Pearson's χ² of sampled directions in cells of equal solid angle against the density's integral
/// over each cell, both hemispheres.
#[test]
fn samples_follow_the_density() {
    const SIDE: usize = 12;
    const FINE: usize = 24;
    let coatings = coatings();
    for (name, model) in models(&coatings) {
        let bsdf = bsdf(model);
        if bsdf.is_delta() {
            continue;
        }
        let view = direction(0.6);
        let n = 200_000;
        let mut counts = vec![0.0f64; SIDE * SIDE];
        let mut rng = Rng::new(5, 0, 0, 0);
        for _ in 0..n {
            if let Some(s) = bsdf.sample(view, draw(&mut rng)).filter(|s| !s.delta) {
                let phi = s
                    .direction
                    .y
                    .atan2(s.direction.x)
                    .rem_euclid(std::f32::consts::TAU);
                let column = (phi / std::f32::consts::TAU * SIDE as f32) as usize;
                let row = (s.direction.z * SIDE as f32) as usize;
                counts[row.min(SIDE - 1) * SIDE + column.min(SIDE - 1)] += 1.0;
            }
        }
        let mut expected = vec![0.0f64; SIDE * SIDE];
        let side = SIDE * FINE;
        for i in 0..side * side {
            let z = (i / side) as f32 / side as f32 + 0.5 / side as f32;
            let phi = ((i % side) as f32 + 0.5) / side as f32 * std::f32::consts::TAU;
            let s = (1.0 - z * z).sqrt();
            let light = Vec3::new(s * phi.cos(), s * phi.sin(), z);
            let cell = (i / side / FINE) * SIDE + (i % side) / FINE;
            expected[cell] +=
                f64::from(bsdf.pdf(view, light)) * 2.0 * PI / (side * side) as f64 * f64::from(n);
        }
        let (mut chi2, mut degrees) = (0.0, 0);
        for (count, mean) in counts
            .iter()
            .zip(&expected)
            .filter(|(_, mean)| **mean >= 10.0)
        {
            chi2 += (count - mean).powi(2) / mean;
            degrees += 1;
        }
        // Six standard deviations of χ² leave room for the midpoint rule's own error.
        let limit = f64::from(degrees) + 6.0 * (2.0 * f64::from(degrees)).sqrt();
        assert!(
            degrees > 3 && chi2 < limit,
            "{name}: χ² {chi2} of {degrees}"
        );
    }
}

#[test]
fn sample_weights_are_value_over_density() {
    let coatings = coatings();
    for (name, model) in models(&coatings) {
        for (two_sided, side) in [(false, 1.0), (true, -1.0)] {
            let bsdf = LocalBsdf {
                model,
                two_sided,
                opacity: 0.7,
            };
            let view = direction(0.5) * Vec3::new(1.0, 1.0, side);
            let mut rng = Rng::new(6, 0, 0, 0);
            for _ in 0..1000 {
                let Some(s) = bsdf.sample(view, draw(&mut rng)).filter(|s| !s.delta) else {
                    continue;
                };
                let pdf = bsdf.pdf(view, s.direction);
                assert!(
                    (s.pdf_sr - pdf).abs() <= 2e-3 * pdf,
                    "{name}: {} {pdf}",
                    s.pdf_sr
                );
                let value = bsdf.evaluate(view, s.direction);
                let error = (s.weight * pdf - value).abs().max_element();
                assert!(
                    error <= 3e-3 * value.max_element() + 1e-6,
                    "{name}: {s:?} {value}"
                );
            }
        }
    }
}

#[test]
fn scattering_is_reciprocal_except_across_a_refracting_boundary() {
    let coatings = coatings();
    let mut rng = Rng::new(7, 0, 0, 0);
    for (name, model) in models(&coatings) {
        let bsdf = bsdf(model);
        for _ in 0..200 {
            let a = cosine_sample([rng.next_f32(), rng.next_f32()]);
            let b = cosine_sample([rng.next_f32(), rng.next_f32()]);
            let forth = bsdf.evaluate(a, b) / b.z;
            let back = bsdf.evaluate(b, a) / a.z;
            let error = (forth - back).abs().max_element();
            assert!(
                error <= 1e-4 * forth.max_element() + 1e-6,
                "{name}: {forth} {back}"
            );
        }
    }
}

#[test]
fn backs_are_black_unless_two_sided() {
    let coatings = coatings();
    let (front, back) = (direction(0.7), direction(0.7) * Vec3::new(1.0, 1.0, -1.0));
    for (name, model) in models(&coatings) {
        let one = bsdf(model);
        assert_eq!(one.evaluate(back, back), Vec3::ZERO, "{name}");
        assert_eq!(one.evaluate(front, back), Vec3::ZERO, "{name}");
        assert!(one.sample(back, [0.5, 0.3, 0.2]).is_none(), "{name}");
        let two = LocalBsdf {
            two_sided: true,
            ..one
        };
        assert_eq!(
            two.evaluate(back, back),
            one.evaluate(front, front),
            "{name}"
        );
        assert_eq!(two.evaluate(back, front), Vec3::ZERO, "{name}");
    }
}

/// What leaves frosted glass without its scale of radiance never grows, is little less where facets are flat, and lies on the
/// side that it was sent to.
#[test]
fn frosted_glass_loses_only_what_meets_another_facet() {
    for (distribution, alpha, least) in [(Ggx, 0.02, 0.98), (Beckmann, 0.3, 0.85), (Ggx, 0.6, 0.5)]
    {
        let glass = Dielectric {
            ior: 1.5,
            thin: false,
            reflectance: Vec3::ONE,
            transmittance: Vec3::ONE,
            facets: Some(facets(distribution, alpha)),
        };
        let bsdf = bsdf(Model::Dielectric(glass));
        for (cos, ratio) in [(0.9, 1.5), (0.4, 1.5), (-0.9, 1.0 / 1.5), (-0.4, 1.0 / 1.5)] {
            let upright: f32 = f32::signum(cos);
            let view = direction(f32::abs(cos)) * Vec3::new(1.0, 1.0, upright);
            let mut rng = Rng::new(5, 0, 0, 0);
            let (mut kept, n) = (0.0, 20_000);
            for sample in (0..n).filter_map(|_| bsdf.sample(view, draw(&mut rng))) {
                assert!(sample.direction.is_normalized() && sample.weight.is_finite());
                let passes = sample.direction.z * upright < 0.0;
                let scale = if passes { ratio * ratio } else { 1.0 };
                kept += sample.weight.x * scale / n as f32;
            }
            assert!((least..1.001).contains(&kept), "{alpha} {cos}: {kept}");
        }
    }
}

#[test]
fn glass_refracts_by_snell_and_conserves_energy() {
    let glass = |thin| Dielectric {
        ior: 1.5,
        thin,
        reflectance: Vec3::ONE,
        transmittance: Vec3::ONE,
        facets: None,
    };
    for cos in [-0.95f32, -0.3, 0.2, 0.9] {
        let view = direction(cos.abs()) * Vec3::new(1.0, 1.0, cos.signum());
        for thin in [false, true] {
            let bsdf = bsdf(Model::Dielectric(glass(thin)));
            let ratio = if thin {
                1.0
            } else if cos > 0.0 {
                1.5
            } else {
                1.0 / 1.5
            };
            let mut total = 0.0;
            for u in [0.0, 0.999_999] {
                let s = bsdf
                    .sample(view, [u, 0.5, 0.5])
                    .expect("glass never absorbs");
                assert!((s.direction.length() - 1.0).abs() < 1e-5);
                let transmitted = s.direction.z * view.z < 0.0;
                let sin = |v: Vec3| v.truncate().length();
                let expected = if transmitted {
                    sin(view) / ratio
                } else {
                    sin(view)
                };
                assert!((sin(s.direction) - expected).abs() < 1e-5);
                let scale = if transmitted { ratio * ratio } else { 1.0 };
                assert!((s.weight.x * scale - 1.0).abs() < 1e-5);
                total += s.pdf_sr;
            }
            // Both choices together are certain, or reflection alone is (twice the same choice).
            assert!(
                (total - 1.0).abs() < 1e-4 || (total - 2.0).abs() < 1e-4,
                "{total}"
            );
        }
    }
}

#[test]
fn opacity_lets_the_rest_pass() {
    let half = LocalBsdf {
        opacity: 0.25,
        ..bsdf(Model::Diffuse(Diffuse {
            reflectance: Vec3::splat(0.5),
        }))
    };
    let view = direction(0.4);
    let mut rng = Rng::new(8, 0, 0, 0);
    let passed = (0..40_000)
        .filter(|_| {
            half.sample(view, draw(&mut rng))
                .is_some_and(|s| s.delta && s.direction == -view)
        })
        .count();
    assert!((passed as f32 / 40_000.0 - 0.75).abs() < 0.01);
    let none = LocalBsdf {
        opacity: 0.0,
        ..half
    };
    assert!(none.sample(view, [0.0, 0.5, 0.5]).is_some_and(|s| s.delta));
}
