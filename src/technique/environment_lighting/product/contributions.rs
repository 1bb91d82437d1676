//! Unshadowed contributions of all lights at a shading point.
//!
//! A surface scatters by up to three terms, each a colour times a number a light: the loops work on
//! the numbers of eight lights at once.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::lights::{Chunk, Lane, LightArrays};
use crate::environment::LANES;
use crate::scene::MicrofacetDistribution;
use crate::shade::Interaction;
use crate::shade::bsdf::{Boundary, Gloss, Lobes};

/// Scattering at one point, ready for many lights.
#[derive(Clone, Copy)]
pub(super) struct Terms {
    normal: Vec3,
    view: Vec3,
    transmission: Option<[f32; 9]>,
    gloss: Option<GlossTerms>,
    /// Colours of the terms, and how many there are.
    pub colours: [Vec3; 3],
    pub count: usize,
}

#[derive(Clone, Copy)]
struct GlossTerms {
    distribution: MicrofacetDistribution,
    alpha2: f32,
    cos_view: f32,
    /// Masking towards the viewer over 4 cos.
    factor: f32,
    /// Squared index − 1 of a dielectric; `None` for a conductor.
    dielectric: Option<f32>,
}

impl Terms {
    pub fn new(at: &Interaction) -> Self {
        let Lobes {
            diffuse,
            transmission,
            gloss,
        } = at.lobes();
        let mut terms = Self {
            normal: at.facing_shading_normal(),
            view: at.view,
            transmission,
            gloss: None,
            colours: [diffuse, Vec3::ZERO, Vec3::ZERO],
            count: 1,
        };
        if let Some(gloss) = gloss {
            terms.add_gloss(&gloss);
        }
        terms
    }

    fn add_gloss(&mut self, gloss: &Gloss) {
        let cos_view = self.normal.dot(self.view).clamp(1e-4, 1.0);
        let alpha2 = gloss.facets.alpha() * gloss.facets.alpha();
        let masking = gloss.facets.masking(
            Vec3::new((1.0 - cos_view * cos_view).max(0.0).sqrt(), 0.0, cos_view),
            Vec3::Z,
        );
        let dielectric = match gloss.boundary {
            Boundary::Dielectric { ior } => {
                self.colours[1] = gloss.specular;
                self.count = 2;
                Some(ior * ior - 1.0)
            }
            Boundary::Conductor { facing, tilted } => {
                let schlick = |f: f32, p: f32| f + (1.0 - f) * p;
                let (p, q) = ((6.0f32 / 7.0).powi(5), (6.0f32 / 7.0).powi(6) / 7.0);
                let dip = Vec3::from([0, 1, 2].map(|c| (schlick(facing[c], p) - tilted[c]) / q));
                self.colours = [
                    gloss.specular * facing,
                    gloss.specular * (Vec3::ONE - facing),
                    gloss.specular * -dip,
                ];
                self.count = 3;
                None
            }
        };
        self.gloss = Some(GlossTerms {
            distribution: gloss.facets.distribution(),
            alpha2,
            cos_view,
            factor: masking / (4.0 * cos_view),
            dielectric,
        });
    }

    /// The number of every term for eight lights, and what the first is when light counts as far as
    /// the lights reach.
    #[inline(always)]
    fn of_chunk(&self, chunk: &Chunk) -> ([Lane; 3], Lane) {
        let [x, y, z] = &chunk.direction;
        let cos: Lane = std::array::from_fn(|i| {
            self.normal.x * x[i] + self.normal.y * y[i] + self.normal.z * z[i]
        });
        let reaching: Lane = std::array::from_fn(|i| chunk.reach.positive(i, cos[i]));
        if let Some(gloss) = self.gloss
            && gloss.dielectric.is_none()
        {
            let (lobe, tilt) = gloss.lobe(chunk, (&cos, &reaching), self.view);
            let one_by_one =
                |f: fn(f32) -> f32| -> Lane { std::array::from_fn(|i| lobe[i] * f(tilt[i])) };
            let first = one_by_one(|_| 1.0);
            let grazing = one_by_one(|c| (1.0 - c).max(0.0).powi(5));
            let dip = one_by_one(|c| c * (1.0 - c).max(0.0).powi(6));
            let wide = std::array::from_fn(|i| first[i] + FLOOR * reaching[i]);
            return ([first, grazing, dip], wide);
        }
        let mut through = [1.0; LANES];
        if let Some(coefficients) = &self.transmission {
            for i in 0..LANES {
                let c = cos[i].clamp(0.0, 1.0);
                let value = coefficients.iter().fold(0.0, |sum, k| sum * c + k);
                through[i] = value.max(0.005);
            }
        }
        let diffuse: Lane = std::array::from_fn(|i| {
            chunk.spread.positive(i, cos[i]) * chunk.moment[i] * through[i]
        });
        let wide: Lane =
            std::array::from_fn(|i| reaching[i] * chunk.moment[i].max(0.1) * through[i]);
        let mut terms = [diffuse, [0.0; LANES], [0.0; LANES]];
        if let Some(gloss) = &self.gloss {
            let (lobe, tilt) = gloss.lobe(chunk, (&cos, &reaching), self.view);
            let index = gloss.dielectric.unwrap_or(0.0);
            for i in 0..LANES {
                let c = tilt[i];
                let g = (index + c * c).max(0.0).sqrt();
                let a = (g - c) / (g + c);
                let b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
                terms[1][i] = lobe[i] * 0.5 * a * a * (1.0 + b * b);
            }
        }
        (terms, wide)
    }
}

/// Least share of a metal's lobe that a light above the surface is given when it is chosen.
const FLOOR: f32 = 0.02;

impl GlossTerms {
    /// Density of facets × masking / (4 cos cos) × cos, and the cosine of view and half vector.
    #[inline(always)]
    fn lobe(&self, chunk: &Chunk, (cos, above): (&Lane, &Lane), view: Vec3) -> (Lane, Lane) {
        let [x, y, z] = &chunk.direction;
        let (mut lobe, mut tilt) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let toward = view.x * x[i] + view.y * y[i] + view.z * z[i];
            let length2 = (2.0 + 2.0 * toward).max(1e-6);
            let inverse = 1.0 / length2.sqrt();
            let height = (self.cos_view + cos[i]).max(0.0) * inverse;
            let c2 = (height * height).min(1.0);
            tilt[i] = (0.5 * length2 * inverse).min(1.0);
            let a2 = (self.alpha2 + chunk.widening[i]).min(1.0);
            let l = above[i];
            let q = (1.0 - c2) + a2 * c2;
            // tan² α² over cos²: Smith's masking without a division by the cosine.
            let masking =
                2.0 * l / (l + (l * l + self.alpha2 * (1.0 - l * l).max(0.0)).sqrt() + 1e-20);
            lobe[i] = self.factor * masking * a2 * FRAC_1_PI / (q * q);
        }
        if self.distribution == MicrofacetDistribution::Beckmann {
            for i in 0..LANES {
                lobe[i] = self.beckmann(chunk, i, (cos[i], above[i]), view);
            }
        }
        (lobe, tilt)
    }

    fn beckmann(&self, chunk: &Chunk, i: usize, (cos, above): (f32, f32), view: Vec3) -> f32 {
        let direction = Vec3::from([0, 1, 2].map(|a| chunk.direction[a][i]));
        let length2 = (2.0 + 2.0 * view.dot(direction)).max(1e-6);
        let height = (self.cos_view + cos).max(0.0);
        let c2 = (height * height / length2).clamp(1e-6, 1.0);
        let a2 = (self.alpha2 + chunk.widening[i]).min(1.0);
        let density = (-(1.0 - c2) / (a2 * c2)).exp() / (PI * a2 * c2 * c2);
        let masking = if above > 0.0 {
            let facets =
                crate::shade::bsdf::Microfacets::new(self.distribution, self.alpha2.sqrt());
            let l = above.min(1.0);
            facets.masking(Vec3::new((1.0 - l * l).sqrt(), 0.0, l), Vec3::Z)
        } else {
            0.0
        };
        self.factor * masking * density
    }
}

/// Contributions of all lights at one point; reused from point to point.
#[derive(Default)]
pub(super) struct Contributions {
    /// Numbers of the terms, eight lights a chunk.
    terms: Vec<[Lane; 3]>,
    /// c_j: luminance of the contribution, positive wherever a texel of the light may contribute.
    pub weights: Vec<Lane>,
    /// Running sums of the weights over chunks.
    pub running: Vec<f32>,
    /// U of both groups.
    pub unshadowed: [Vec3; 2],
    colours: [Vec3; 3],
    count: usize,
}

impl Contributions {
    /// Evaluates all lights.
    pub fn evaluate(&mut self, lights: &LightArrays, terms: &Terms) {
        self.terms.clear();
        self.weights.clear();
        self.running.clear();
        (self.colours, self.count) = (terms.colours, terms.count);
        match terms.count {
            1 => self.run::<1>(lights, terms),
            2 => self.run::<2>(lights, terms),
            _ => self.run::<3>(lights, terms),
        }
    }

    fn run<const N: usize>(&mut self, lights: &LightArrays, terms: &Terms) {
        const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
        // Weight of a channel's power in the luminance of a term.
        let luminances: [[f32; 3]; N] =
            std::array::from_fn(|k| [0, 1, 2].map(|c| LUMINANCE[c] * terms.colours[k][c]));
        let mut running = 0.0f32;
        for (group, range) in [0..lights.indirect, lights.indirect..lights.chunks.len()]
            .into_iter()
            .enumerate()
        {
            let mut sums = [[[0.0f32; LANES]; 3]; N];
            for chunk in &lights.chunks[range] {
                let (numbers, wide) = terms.of_chunk(chunk);
                let mut weight = [0.0f32; LANES];
                for k in 0..N {
                    let own = if k == 0 { &wide } else { &numbers[k] };
                    for i in 0..LANES {
                        let [r, g, b] = [0, 1, 2].map(|c| chunk.power[c][i]);
                        let [y_r, y_g, y_b] = luminances[k];
                        weight[i] += own[i] * (y_r * r + y_g * g + y_b * b);
                    }
                    for c in 0..3 {
                        for i in 0..LANES {
                            sums[k][c][i] += numbers[k][i] * chunk.power[c][i];
                        }
                    }
                }
                let weight = weight.map(|w| w.max(0.0));
                running += sum(&weight);
                self.terms.push(numbers);
                self.weights.push(weight);
                self.running.push(running);
            }
            self.unshadowed[group] = (0..N)
                .map(|k| terms.colours[k] * Vec3::from([0, 1, 2].map(|c| sum(&sums[k][c]))))
                .sum::<Vec3>()
                .max(Vec3::ZERO);
        }
    }

    /// Σ c_j.
    pub fn total(&self) -> f32 {
        self.running.last().copied().unwrap_or(0.0)
    }

    /// The unshadowed contribution of a light.
    pub fn contribution(&self, lights: &LightArrays, light: usize) -> Vec3 {
        let (chunk, i) = (light / LANES, light % LANES);
        let power = Vec3::from([0, 1, 2].map(|c| lights.chunks[chunk].power[c][i]));
        let scattered: Vec3 = (0..self.count)
            .map(|k| self.colours[k] * self.terms[chunk][k][i])
            .sum();
        (scattered * power).max(Vec3::ZERO)
    }
}

#[inline(always)]
fn sum(lane: &Lane) -> f32 {
    let half: [f32; 4] = std::array::from_fn(|i| lane[i] + lane[i + 4]);
    (half[0] + half[2]) + (half[1] + half[3])
}
