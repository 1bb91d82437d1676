//! Scattering at a shading point as numbers for eight lights at once.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use super::lights::{Chunk, LANES, Lane, larger, smaller};
use crate::scene::MicrofacetDistribution;
use crate::shade::Interaction;
use crate::shade::bsdf::{Boundary, Gloss, Lobes, Microfacets};

/// What every light's power is multiplied by.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    /// Of each term.
    pub terms: [Lane; 3],
    /// The first term when a light counts as far as it reaches.
    pub wide: Lane,
    /// Mean cosines, of the diffuse term without a coating.
    pub cosines: Lane,
}

impl Numbers {
    /// What lights are chosen by, in place of term k.
    #[inline(always)]
    pub fn choosing(&self, k: usize) -> &Lane {
        if k == 0 { &self.wide } else { &self.terms[k] }
    }
}

/// Scattering at one point, ready for many lights.
#[derive(Clone, Copy)]
pub(super) struct Terms {
    pub normal: Vec3,
    view: Vec3,
    transmission: Option<[f32; 9]>,
    gloss: Option<GlossTerms>,
    /// Colours of the terms, and how many there are.
    pub colours: [Vec3; 3],
    pub count: usize,
}

#[derive(Clone, Copy)]
struct GlossTerms {
    facets: Microfacets,
    alpha2: f32,
    cos_view: f32,
    /// Masking towards the viewer over 4 cos.
    factor: f32,
    /// Squared index − 1 of a dielectric; `None` for a conductor.
    dielectric: Option<f32>,
}

/// Least share of a metal's lobe that a light above the surface is given when it is chosen.
const FLOOR: f32 = 0.02;

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
        let sin = (1.0 - cos_view * cos_view).max(0.0).sqrt();
        let masking = gloss.facets.masking(Vec3::new(sin, 0.0, cos_view), Vec3::Z);
        let dielectric = match gloss.boundary {
            Boundary::Dielectric { ior } => {
                self.colours[1] = gloss.specular;
                self.count = 2;
                Some(ior * ior - 1.0)
            }
            Boundary::Conductor { facing, tilted } => {
                let schlick = |f: f32, p: f32| f + (1.0 - f) * p;
                let (p, q) = ((6.0f32 / 7.0).powi(5), (6.0f32 / 7.0).powi(6) / 7.0);
                let dip = [0, 1, 2].map(|c| (schlick(facing[c], p) - tilted[c]) / q);
                self.colours = [facing, Vec3::ONE - facing, -Vec3::from(dip)]
                    .map(|colour| gloss.specular * colour);
                self.count = 3;
                None
            }
        };
        self.gloss = Some(GlossTerms {
            facets: gloss.facets,
            alpha2: gloss.facets.alpha() * gloss.facets.alpha(),
            cos_view,
            factor: masking / (4.0 * cos_view),
            dielectric,
        });
    }

    /// Whether the first term is a diffuse one.
    pub fn diffuse_term(&self) -> bool {
        self.count < 3
    }

    /// Whether the diffuse term lies under a coating.
    pub fn coated(&self) -> bool {
        self.transmission.is_some()
    }

    /// The first term of a highlight, and the squared roughness of its facets.
    pub fn gloss_term(&self) -> Option<(usize, f32)> {
        let gloss = self.gloss?;
        Some((usize::from(gloss.dielectric.is_some()), gloss.alpha2))
    }

    /// Numbers of eight lights.
    #[inline(always)]
    pub fn numbers(&self, chunk: &Chunk) -> Numbers {
        let cos = dot(self.normal, &chunk.direction);
        let reaching = chunk.reach.positive(&cos);
        match &self.gloss {
            Some(gloss) if gloss.dielectric.is_none() => {
                gloss.metal(chunk, &cos, &reaching, self.view)
            }
            gloss => {
                let mut numbers = self.diffuse(chunk, &cos, &reaching);
                if let Some(gloss) = gloss {
                    numbers.terms[1] = gloss.coat(chunk, &cos, &reaching, self.view);
                }
                numbers
            }
        }
    }

    #[inline(always)]
    fn diffuse(&self, chunk: &Chunk, cos: &Lane, reaching: &Lane) -> Numbers {
        let mut cosines = chunk.spread.positive(cos);
        let mut wide = *reaching;
        for i in 0..LANES {
            cosines[i] *= chunk.moment[i];
            wide[i] *= larger(chunk.moment[i], 0.1);
        }
        let mut first = cosines;
        if let Some(coefficients) = &self.transmission {
            let mut through = [coefficients[0]; LANES];
            for k in &coefficients[1..] {
                for i in 0..LANES {
                    through[i] = through[i] * larger(cos[i], 0.0) + k;
                }
            }
            for i in 0..LANES {
                let share = larger(through[i], 0.005);
                first[i] *= share;
                wide[i] *= share;
            }
        }
        Numbers {
            terms: [first, [0.0; LANES], [0.0; LANES]],
            wide,
            cosines,
        }
    }
}

#[inline(always)]
fn dot(vector: Vec3, [x, y, z]: &[Lane; 3]) -> Lane {
    let mut cos = [0.0; LANES];
    for i in 0..LANES {
        cos[i] = vector.x * x[i] + vector.y * y[i] + vector.z * z[i];
    }
    cos
}

impl GlossTerms {
    /// Density of facets × masking / (4 cos cos) × cos, and the cosine of view and half vector.
    #[inline(always)]
    fn lobe(&self, chunk: &Chunk, cos: &Lane, above: &Lane, view: Vec3) -> (Lane, Lane) {
        let toward = dot(view, &chunk.direction);
        let (mut lobe, mut tilt) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let length = larger(2.0 + 2.0 * toward[i], 1e-6).sqrt();
            let height = larger(self.cos_view + cos[i], 0.0) / length;
            let c2 = smaller(height * height, 1.0);
            tilt[i] = smaller(0.5 * length, 1.0);
            let a2 = smaller(self.alpha2 + chunk.widening[i], 1.0);
            let l = above[i];
            let q = (1.0 - c2) + a2 * c2;
            // Smith's masking without a division by the cosine.
            let root = (l * l + self.alpha2 * larger(1.0 - l * l, 0.0)).sqrt();
            lobe[i] = self.factor * 2.0 * l * a2 * FRAC_1_PI / ((l + root + 1e-20) * q * q);
        }
        if self.facets.distribution() == MicrofacetDistribution::Beckmann {
            for i in 0..LANES {
                let height = (self.cos_view + cos[i]).max(0.0);
                lobe[i] = self.beckmann(chunk.widening[i], tilt[i], height, above[i]);
            }
        }
        (lobe, tilt)
    }

    fn beckmann(&self, widening: f32, tilt: f32, height: f32, above: f32) -> f32 {
        let height = height / (2.0 * tilt);
        let c2 = (height * height).clamp(1e-6, 1.0);
        let a2 = (self.alpha2 + widening).min(1.0);
        let density = (-(1.0 - c2) / (a2 * c2)).exp() / (PI * a2 * c2 * c2);
        if above <= 0.0 {
            return 0.0;
        }
        let l = above.min(1.0);
        let light = Vec3::new((1.0 - l * l).sqrt(), 0.0, l);
        self.factor * self.facets.masking(light, Vec3::Z) * density
    }

    /// The highlight of a coating.
    #[inline(always)]
    fn coat(&self, chunk: &Chunk, cos: &Lane, above: &Lane, view: Vec3) -> Lane {
        let (mut lobe, tilt) = self.lobe(chunk, cos, above, view);
        let index = self.dielectric.unwrap_or(0.0);
        for i in 0..LANES {
            let c = tilt[i];
            let g = larger(index + c * c, 0.0).sqrt();
            let (sum, difference) = (g + c, g - c);
            let over = c * sum - 1.0;
            let under = c * difference + 1.0;
            let squares = under * under + over * over;
            let ratio = difference / (sum * under);
            lobe[i] *= 0.5 * ratio * ratio * squares;
        }
        lobe
    }

    #[inline(always)]
    fn metal(&self, chunk: &Chunk, cos: &Lane, above: &Lane, view: Vec3) -> Numbers {
        let (first, tilt) = self.lobe(chunk, cos, above, view);
        let (mut grazing, mut dip, mut wide) = (first, first, first);
        for i in 0..LANES {
            let c = larger(1.0 - tilt[i], 0.0);
            let fifth = c * c * c * c * c;
            grazing[i] *= fifth;
            dip[i] *= tilt[i] * c * fifth;
            wide[i] += FLOOR * above[i];
        }
        Numbers {
            terms: [first, grazing, dip],
            wide,
            cosines: [0.0; LANES],
        }
    }
}
