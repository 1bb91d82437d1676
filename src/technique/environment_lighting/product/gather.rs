//! Shadow rays of every pixel: its lights, where they are sampled, and what is visible.

use glam::Vec3;
use rayon::prelude::*;

use super::contributions::{Contributions, Detail};
use super::film::{Band, Film, Gathered, Site};
use super::irradiance::Irradiance;
use super::lights::LightArrays;
use super::numbers::PixelNumbers;
use super::selection::{Chosen, systematic};
use super::terms::Terms;
use crate::environment::{DRAWS, Environment, TexelLights};
use crate::sample::is_set;
use crate::shade::Interaction;
use crate::technique::Seen;
use crate::technique::environment_lighting::illumination::Illumination;
use crate::trace::{Caster, RayCounter};

/// Rows of a band that a thread works on.
const ROWS: usize = 8;

/// One sample of all pixels.
pub(super) struct Gather<'a> {
    pub illumination: &'a Illumination<'a>,
    /// What the lights are parts of.
    pub map: &'a Environment,
    pub lights: &'a TexelLights,
    pub arrays: &'a LightArrays,
    pub irradiance: &'a Irradiance,
    pub detail: Detail,
    pub numbers: PixelNumbers,
    /// K: shadow rays a point.
    pub rays: usize,
    /// Index of the sub-pixel sample.
    pub sample: u32,
    pub unbiased: bool,
    /// Least rays of a point that are cast together.
    pub bundle: usize,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    contributions: Contributions,
    chosen: Vec<Chosen>,
    /// Directions of rays, with what each brings: its group, and light.
    directions: Vec<Vec3>,
    brought: Vec<(usize, Vec3)>,
    occluded: Vec<u64>,
}

impl Gather<'_> {
    pub fn fill(&self, film: &mut Film, counter: &RayCounter) {
        let tracer = self.illumination.shot.tracer;
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
                            self.shade(caster, &surface, &seen, at, &mut scratch);
                        band.set([x, row], gathered, site.as_ref());
                    }
                }
            }
        }
    }

    fn shade(
        &self,
        caster: &Caster,
        surface: &Interaction,
        seen: &Seen,
        pixel: [usize; 2],
        scratch: &mut Scratch,
    ) -> (Gathered, Option<Site>) {
        let terms = Terms::new(surface);
        let contributions = &mut scratch.contributions;
        contributions.evaluate(self.arrays, self.irradiance, &terms, self.detail);
        let u = self.numbers.choice(pixel);
        systematic(
            contributions,
            self.arrays,
            self.rays,
            u,
            &mut scratch.chosen,
        );
        if self.unbiased {
            let light = self.estimate(caster, surface, pixel, scratch);
            let gathered = Gathered {
                plain: seen.throughput * light,
                ..Gathered::default()
            };
            return (gathered, None);
        }
        self.aim(&terms, scratch);
        let (shadowed, sampled) = self.cast(caster, surface, scratch);
        let gathered = Gathered {
            plain: Vec3::ZERO,
            throughput: seen.throughput,
            unshadowed: scratch.contributions.unshadowed,
        };
        let site = Site {
            object: surface.shape,
            normal: terms.normal,
            position: surface.position,
            depth: seen.depth,
            shadowed,
            sampled,
        };
        (gathered, Some(site))
    }

    /// Directions and light of the chosen lights' rays above the surface.
    fn aim(&self, terms: &Terms, scratch: &mut Scratch) {
        let contributions = &scratch.contributions;
        let share = contributions.total() / self.rays as f32;
        scratch.directions.clear();
        scratch.brought.clear();
        for choice in &scratch.chosen {
            let contribution = contributions.contribution(self.arrays, terms, choice.light);
            let draw = (choice.within * DRAWS as f32) as usize;
            let direction = self.lights.draws[choice.light * DRAWS + draw];
            if contribution == Vec3::ZERO || direction.dot(terms.normal) <= 0.0 {
                continue;
            }
            let group = usize::from(choice.light >= self.lights.groups[1].start);
            scratch.directions.push(direction);
            scratch
                .brought
                .push((group, contribution * (share / choice.weight)));
        }
    }

    /// Casts the rays: what arrives of each group, and what would without shadows.
    fn cast(
        &self,
        caster: &Caster,
        surface: &Interaction,
        scratch: &mut Scratch,
    ) -> ([Vec3; 2], [Vec3; 2]) {
        let Scratch {
            directions,
            brought,
            occluded,
            ..
        } = scratch;
        let side = surface.facing_normal();
        // Rays of one side of the surface have one origin.
        let together =
            directions.len() >= self.bundle && directions.iter().all(|d| d.dot(side) > 0.0);
        if together {
            let paths = &self.illumination.shot.paths;
            let start = paths.lights().spawn(surface, directions[0]);
            occluded.clear();
            occluded.resize(directions.len().div_ceil(64), 0);
            paths.occluded_bundle(caster, start.origin, directions, start.t_max, occluded);
        }
        let (mut shadowed, mut sampled) = ([Vec3::ZERO; 2], [Vec3::ZERO; 2]);
        for (i, (direction, (group, light))) in directions.iter().zip(brought).enumerate() {
            sampled[*group] += *light;
            let open = match together {
                true => !is_set(occluded, i),
                false => self.illumination.sees(caster, surface, *direction),
            };
            if open {
                shadowed[*group] += *light;
            }
        }
        (shadowed, sampled)
    }

    /// Σ scattering · radiance · visibility over the density of the directions.
    fn estimate(
        &self,
        caster: &Caster,
        surface: &Interaction,
        pixel: [usize; 2],
        scratch: &Scratch,
    ) -> Vec3 {
        let illumination = self.illumination;
        let share = scratch.contributions.total() / self.rays as f32;
        let mut sum = Vec3::ZERO;
        for (ray, choice) in scratch.chosen.iter().enumerate() {
            let point = self.numbers.point(pixel, ray);
            let sample = self
                .lights
                .sample(self.map, choice.light, choice.within, point);
            let Some(sample) = sample else {
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
