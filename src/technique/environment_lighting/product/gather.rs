//! Shadow rays of every pixel: its lights, where they are sampled, and what is visible.

use glam::Vec3;
use rayon::prelude::*;

use super::contributions::{Contributions, Detail};
use super::film::{Band, Film, Gathered, Site};
use super::irradiance::Irradiance;
use super::lights::LightArrays;
use super::numbers::Numbers;
use super::selection::{Chosen, systematic};
use super::terms::Terms;
use crate::environment::{DRAWS, TexelLights};
use crate::shade::Interaction;
use crate::technique::Seen;
use crate::technique::environment_lighting::illumination::Illumination;
use crate::trace::{Caster, RayCounter};

/// Rows of a band that a thread works on.
const ROWS: usize = 8;

/// One sample of all pixels.
pub(super) struct Gather<'a> {
    pub illumination: &'a Illumination<'a>,
    pub lights: &'a TexelLights,
    pub arrays: &'a LightArrays,
    pub irradiance: &'a Irradiance,
    pub detail: Detail,
    pub numbers: Numbers,
    /// K: shadow rays a point.
    pub rays: usize,
    /// Index of the sub-pixel sample.
    pub sample: u32,
    pub unbiased: bool,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    contributions: Contributions,
    chosen: Vec<Chosen>,
}

impl Gather<'_> {
    pub fn fill(&self, film: &mut Film, counter: &RayCounter) {
        let tracer = self.illumination.frame.tracer;
        film.bands(ROWS).into_par_iter().for_each(|mut band| {
            let caster = tracer.caster(counter);
            self.fill_band(&caster, &mut band);
        });
    }

    fn fill_band(&self, caster: &Caster, band: &mut Band) {
        band.clear();
        let mut scratch = Scratch::default();
        for row in 0..band.rows() {
            for x in 0..band.width {
                let at = [x, band.first + row];
                let pixel = (at[1] * band.width + x) as u32;
                match self.illumination.point(caster, pixel, self.sample) {
                    Err(radiance) => {
                        let gathered = Gathered {
                            plain: radiance,
                            ..Gathered::default()
                        };
                        band.set([x, row], gathered, None);
                    }
                    Ok((surface, seen)) => {
                        let (gathered, site) =
                            self.shade(caster, (&surface, &seen), at, &mut scratch);
                        band.set([x, row], gathered, site.as_ref());
                    }
                }
            }
        }
    }

    fn shade(
        &self,
        caster: &Caster,
        (surface, seen): (&Interaction, &Seen),
        pixel: [usize; 2],
        Scratch {
            contributions,
            chosen,
        }: &mut Scratch,
    ) -> (Gathered, Option<Site>) {
        let terms = Terms::new(surface);
        contributions.evaluate((self.arrays, self.irradiance), &terms, self.detail);
        let u = self.numbers.choice(pixel);
        systematic((contributions, self.arrays), self.rays, u, chosen);
        if self.unbiased {
            let gathered = Gathered {
                plain: seen.throughput
                    * self.estimate(caster, surface, pixel, (contributions, chosen)),
                ..Gathered::default()
            };
            return (gathered, None);
        }
        let (mut shadowed, mut sampled) = ([Vec3::ZERO; 2], [Vec3::ZERO; 2]);
        let normal = surface.facing_shading_normal();
        let share = contributions.total() / self.rays as f32;
        for choice in chosen.iter() {
            let contribution = contributions.contribution(self.arrays, choice.light);
            if contribution == Vec3::ZERO {
                continue;
            }
            let draw = (choice.within * DRAWS as f32) as usize;
            let direction = self.lights.draws[choice.light * DRAWS + draw];
            if direction.dot(normal) <= 0.0 {
                continue;
            }
            let group = usize::from(choice.light >= self.lights.groups[1].start);
            let weighed = contribution * (share / choice.weight);
            sampled[group] += weighed;
            if self.illumination.sees(caster, surface, direction) {
                shadowed[group] += weighed;
            }
        }
        let gathered = Gathered {
            plain: Vec3::ZERO,
            throughput: seen.throughput,
            unshadowed: contributions.unshadowed,
        };
        let site = Site {
            object: surface.shape,
            normal,
            position: surface.position,
            depth: seen.depth,
            shadowed,
            sampled,
        };
        (gathered, Some(site))
    }

    /// Σ scattering · radiance · visibility over the density of the directions.
    fn estimate(
        &self,
        caster: &Caster,
        surface: &Interaction,
        pixel: [usize; 2],
        (contributions, chosen): (&Contributions, &[Chosen]),
    ) -> Vec3 {
        let (illumination, map) = (self.illumination, self.illumination.environment);
        let share = contributions.total() / self.rays as f32;
        let mut sum = Vec3::ZERO;
        for (ray, choice) in chosen.iter().enumerate() {
            let point = self.numbers.point(pixel, ray);
            let at = (choice.within, point);
            let Some(sample) = self.lights.sample(map, choice.light, at) else {
                continue;
            };
            let density = sample.pdf_sr * choice.weight;
            if density <= 0.0 {
                continue;
            }
            let reflected =
                surface.evaluate(sample.direction) * illumination.radiance(sample.direction);
            if reflected != Vec3::ZERO && illumination.sees(caster, surface, sample.direction) {
                sum += reflected * (share / density);
            }
        }
        sum
    }
}
