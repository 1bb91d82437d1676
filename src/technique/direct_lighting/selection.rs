//! Which lights are sampled at a surface, and where.

use crate::entry::words;
use crate::sample::Rng;
use crate::shade::{
    Arriving, ChosenPlace, EvenLights, Interaction, LightPlace, Lights, Unshadowed,
};

words! {
    /// How lights are chosen.
    pub(crate) enum Selection {
        /// Each emitting shape and each other light with the same probability.
        Uniform = "uniform",
        /// By power, half of it spread evenly over area, point, directional lights and environment.
        Power = "power",
        /// By power with one random offset for all samples of a surface, evenly spaced.
        Systematic = "systematic",
        /// By what candidates, drawn by power, would add without shadows; those of all samples of a surface are evenly spaced
        /// and serve all of them.
        Product = "product",
    }
}

/// Chooses light samples.
pub(crate) struct Selecting<'a> {
    pub lights: &'a Lights<'a>,
    pub even: EvenLights<'a, 'a>,
    pub selection: Selection,
    /// Of each sample, for [`Selection::Product`].
    pub candidates: u32,
}

/// A light sample, before it is known whether it reaches its surface.
pub(crate) struct Selected {
    pub arriving: Arriving,
    /// Of the sample, per unit of the measure of places; NaN where what a candidate adds is not finite.
    pub density: f32,
}

/// Candidates that are held at once, unless a single sample has more of its own.
const POOL: u32 = 1024;

impl Selecting<'_> {
    /// The light samples of a surface, `count` with those left out that add nothing. `adds` is what a sample adds without
    /// shadows, as luminance up to a factor.
    pub fn samples(
        &self,
        at: &Interaction,
        count: u32,
        rng: &mut Rng,
        adds: impl Fn(&Unshadowed) -> f32,
    ) -> Vec<Selected> {
        let lights = self.lights;
        match self.selection {
            Selection::Uniform => self.each(at, count, rng, |_, rng| self.even.choose(rng)),
            Selection::Power => self.each(at, count, rng, |_, rng| {
                let choice = rng.next_f64();
                lights.choose(choice, rng)
            }),
            Selection::Systematic => {
                self.each(at, count, rng, |choice, rng| lights.choose(choice, rng))
            }
            Selection::Product => {
                let mut selected = Vec::with_capacity(count as usize);
                let group = (POOL / self.candidates).max(1);
                for first in (0..count).step_by(group as usize) {
                    let count = group.min(count - first);
                    self.resample(at, count, rng, &adds, &mut selected);
                }
                selected
            }
        }
    }

    /// Samples at places that are chosen one after another, each for one of evenly spaced numbers.
    fn each(
        &self,
        at: &Interaction,
        count: u32,
        rng: &mut Rng,
        choose: impl Fn(f64, &mut Rng) -> Option<ChosenPlace>,
    ) -> Vec<Selected> {
        let offset = rng.next_f64();
        let mut selected = Vec::with_capacity(count as usize);
        for number in 0..count {
            let Some(chosen) = choose(even(number, offset, count), rng) else {
                continue;
            };
            let ChosenPlace { place, density } = chosen;
            let arriving = self.lights.arriving(&place, at);
            if let Some(arriving) = arriving.filter(|_| density > 0.0) {
                selected.push(Selected { arriving, density });
            }
        }
        selected
    }

    /// Resampled importance sampling (Talbot et al. 2005): of all candidates `count`, by what they add. Candidates are evenly
    /// spaced over the lights, and those that are taken over what all of them add.
    fn resample(
        &self,
        at: &Interaction,
        count: u32,
        rng: &mut Rng,
        adds: &impl Fn(&Unshadowed) -> f32,
        selected: &mut Vec<Selected>,
    ) {
        let all = count * self.candidates;
        let offset = rng.next_f64();
        let mut pool = Vec::with_capacity(all as usize);
        let mut sum = 0.0;
        let choices = (0..all).map(|number| even(number, offset, all));
        // Most candidates are not taken: their shadow rays are left out.
        self.lights
            .each_unshadowed(choices, rng, at, |chosen, light| {
                let ChosenPlace { place, density } = chosen;
                let added = adds(&light);
                let weight = f64::from(added / density);
                if added != 0.0 && !weight.is_finite() {
                    let density = f32::NAN;
                    let arriving = self.lights.arriving(&place, at);
                    selected.extend(arriving.map(|arriving| Selected { arriving, density }));
                } else if weight > 0.0 {
                    sum += weight;
                    pool.push(Candidate { place, added, sum });
                }
            });
        let offset = rng.next_f64();
        for number in 0..count {
            let place = sum * even(number, offset, count);
            let index = pool.partition_point(|candidate| candidate.sum <= place);
            let taken = pool.get(index).or(pool.last());
            if let Some(taken) = taken
                && let Some(arriving) = self.lights.arriving(&taken.place, at)
            {
                let density = (f64::from(taken.added) * f64::from(all) / sum) as f32;
                selected.push(Selected { arriving, density });
            }
        }
    }
}

/// A light sample that may be taken.
struct Candidate {
    place: LightPlace,
    /// What it adds without shadows.
    added: f32,
    /// Of this over density, of all up to this one.
    sum: f64,
}

/// The place of one of `count` evenly spaced numbers in [0, 1).
fn even(number: u32, offset: f64, count: u32) -> f64 {
    (f64::from(number) + offset) / f64::from(count)
}
