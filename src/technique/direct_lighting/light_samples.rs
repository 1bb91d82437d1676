//! The contender `rt`: random samples of the lights at what each camera sample sees, a shadow ray each, without memory.
//!
//! Lights that the surface cannot scatter to the camera cost no ray. What light sampling cannot find, emitters and the
//! environment seen directly, in smooth mirrors and through masks, takes a ray of its own.
//!
//! *Differs* from `paths`: directions are not sampled by the surface, so that there is no noise of choosing between both,
//! and highlights of large lights on smooth surfaces are noisier.

use glam::Vec3;

use super::super::truth::Truth;
use super::super::{
    Contender, ContenderEntry, Passes, Rendered, ShadingFunction, Shot, Terms, each_pixel,
};
use super::sight::{Sight, surface};
use crate::entry::{About, Bias, parameters, words};
use crate::image::luminance;
use crate::sample::Rng;
use crate::shade::{Arriving, ChosenPlace, EvenLights, Interaction};
use crate::technique::radiance::viewer_key;
use crate::trace::{Caster, RayCounter};

/// Keys its random numbers.
const STREAM: u64 = 0x7274_6c69_6768;

/// Entry in the technique's list.
pub(super) const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "rt",
        module: include_str!("light_samples.rs"),
        aliases: &["light-samples"],
        summary: "random samples of the lights, a shadow ray each, at what each camera sample sees",
        source: "Stadlbauer et al. 2023, section 4: ray-traced light sampling",
        bias: Bias::Unbiased,
        version: 1,
        failures: &[
            "noise falls with the square root of the rays only",
            "large lights in smooth surfaces are noisy: directions are not sampled by the surface",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        Ok(Box::new(LightSamples {
            parameters: Parameters::read(table)?,
            terms,
        }))
    },
};

words! {
    /// How lights are chosen.
    enum Selection {
        /// Each emitting shape and each other light with the same probability.
        Uniform = "uniform",
        /// By power, half of it spread evenly over area, point, directional lights and environment.
        Power = "power",
        /// By power with one random offset for all samples of a surface, evenly spaced.
        Systematic = "systematic",
        /// By what candidates, drawn by power, would add without shadows.
        Product = "product",
    }
}

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Light samples of each camera sample.
        rays: u32 = 16, Within(1.0, 65536.0);
        /// How their lights are chosen.
        selection: Selection = Selection::Uniform;
        /// Candidates of each sample, for selection = "product".
        candidates: u32 = 8, Within(1.0, 65536.0);
    }
}

struct LightSamples {
    parameters: Parameters,
    terms: Terms,
}

impl Contender for LightSamples {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.shot(shot)).collect())
    }
}

impl LightSamples {
    fn shot(&self, shot: &Shot) -> Rendered {
        let samples = self.terms.budget as u32;
        let mut rendered = Rendered::default();
        let counter = RayCounter::default();
        let lit = Lit {
            shot,
            even: EvenLights::new(shot.paths.lights()),
            parameters: self.parameters,
            seed: self.terms.seed,
        };
        // Each frame takes other samples, or its noise would stick to the screen.
        let first = shot.frame.wrapping_mul(samples);
        let mut passes = Passes::starting_at(first, shot, &lit);
        rendered.stages.time("rendering", || {
            (0..samples).for_each(|_| passes.add(&counter));
        });
        rendered.image = passes.mean();
        rendered.non_finite = passes.non_finite;
        rendered.notes.extend(passes.note());
        rendered.rays = counter.read();
        rendered
    }
}

/// Camera samples lit by random samples of the lights.
struct Lit<'a> {
    shot: &'a Shot<'a>,
    even: EvenLights<'a, 'a>,
    parameters: Parameters,
    seed: u64,
}

impl ShadingFunction for Lit<'_> {
    fn pixels(
        &self,
        caster: &Caster,
        (first_pixel, sample): (u32, u32),
        out: &mut [[f32; 3]],
    ) -> u64 {
        let shot = self.shot;
        let stream = STREAM ^ viewer_key(shot);
        each_pixel(first_pixel, out, |pixel| {
            let mut rng = Rng::new(self.seed, stream, u64::from(pixel), u64::from(sample));
            let sight = Sight::of(shot, caster, pixel, &mut rng);
            match sight.surface {
                Some(seen) => sight.seen + self.scattered(caster, &surface(shot, seen), &mut rng),
                None => sight.seen,
            }
        })
    }
}

/// A light sample at a surface.
struct Sample {
    /// What the surface sends to the camera for each unit of the measure of places, without shadows.
    scattered: Vec3,
    arriving: Arriving,
    density: f32,
}

impl Lit<'_> {
    /// Light that a surface scatters to the camera: the mean of all samples.
    fn scattered(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let count = self.parameters.rays;
        let offset = rng.next_f64();
        let mut sum = Vec3::ZERO;
        for number in 0..count {
            let even_choice = (f64::from(number) + offset) / f64::from(count);
            sum += match self.parameters.selection {
                Selection::Uniform => self.one(caster, (at, self.even.choose(rng))),
                Selection::Power => self.one(caster, (at, self.by_power(rng.next_f64(), rng))),
                Selection::Systematic => self.one(caster, (at, self.by_power(even_choice, rng))),
                Selection::Product => self.best_of_candidates(caster, at, rng),
            };
        }
        sum / count as f32
    }

    fn by_power(&self, choice: f64, rng: &mut Rng) -> Option<ChosenPlace> {
        self.shot.paths.lights().choose(choice, rng)
    }

    /// `None` where the surface sends nothing of it to the camera.
    fn sample(&self, at: &Interaction, chosen: Option<ChosenPlace>) -> Option<Sample> {
        let chosen = chosen?;
        let arriving = self.shot.paths.lights().arriving(&chosen.place, at)?;
        let scattered = at.evaluate(arriving.direction) * arriving.irradiance;
        (scattered != Vec3::ZERO && chosen.density > 0.0).then_some(Sample {
            scattered,
            arriving,
            density: chosen.density,
        })
    }

    fn one(&self, caster: &Caster, (at, chosen): (&Interaction, Option<ChosenPlace>)) -> Vec3 {
        match self.sample(at, chosen) {
            Some(sample) if !caster.occluded(&sample.arriving.shadow_ray) => {
                sample.scattered / sample.density
            }
            _ => Vec3::ZERO,
        }
    }

    /// Resampled importance sampling (Talbot et al. 2005): of all candidates one, by what it adds without shadows.
    fn best_of_candidates(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let mut sum = 0.0;
        let mut kept: Option<Sample> = None;
        let mut broken = Vec3::ZERO;
        for _ in 0..self.parameters.candidates {
            let chosen = self.by_power(rng.next_f64(), rng);
            let u = rng.next_f32();
            let Some(sample) = self.sample(at, chosen) else {
                continue;
            };
            let weight = luminance(sample.scattered.into()) / sample.density;
            if !weight.is_finite() {
                // Told to the caller, who counts it.
                broken = sample.scattered / sample.density;
                continue;
            }
            sum += weight;
            if u * sum < weight {
                kept = Some(sample);
            }
        }
        let Some(sample) = kept.filter(|s| !caster.occluded(&s.arriving.shadow_ray)) else {
            return broken;
        };
        let target = luminance(sample.scattered.into());
        broken + sample.scattered * (sum / (target * self.parameters.candidates as f32))
    }
}
