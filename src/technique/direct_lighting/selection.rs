//! Which lights are sampled at a surface, and where.

use crate::entry::words;
use crate::sample::Rng;
use crate::shade::{Arriving, ChosenPlace, EvenLights, Interaction, Lights};

words! {
    /// How lights are chosen.
    pub(crate) enum Selection {
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

/// Chooses light samples.
pub(crate) struct Selecting<'a> {
    pub lights: &'a Lights<'a>,
    pub even: EvenLights<'a, 'a>,
    pub selection: Selection,
    /// Of each sample, for [`Selection::Product`].
    pub candidates: u32,
}

/// One sample of all that a surface takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    pub number: u32,
    pub count: u32,
    /// Random in [0, 1), the same for all samples of the surface.
    pub offset: f64,
}

/// A light sample, before it is known whether it reaches its surface.
pub(crate) struct Selected {
    pub arriving: Arriving,
    /// Of the sample, per unit of the measure of places; NaN where what a candidate adds is not finite.
    pub density: f32,
}

impl Selecting<'_> {
    /// A light sample for a surface; `None` where it adds nothing. `adds` is what a sample adds without shadows, as luminance
    /// up to a factor.
    pub fn sample(
        &self,
        at: &Interaction,
        turn: Turn,
        rng: &mut Rng,
        adds: impl Fn(&Arriving) -> f32,
    ) -> Option<Selected> {
        let even_choice = || (f64::from(turn.number) + turn.offset) / f64::from(turn.count);
        let chosen = match self.selection {
            Selection::Uniform => self.even.choose(rng),
            Selection::Power => self.lights.choose(rng.next_f64(), rng),
            Selection::Systematic => self.lights.choose(even_choice(), rng),
            Selection::Product => return self.best_of_candidates(at, rng, adds),
        };
        let ChosenPlace { place, density } = chosen?;
        let arriving = self.lights.arriving(&place, at)?;
        (density > 0.0).then_some(Selected { arriving, density })
    }

    /// Resampled importance sampling (Talbot et al. 2005): of all candidates one, by what it adds.
    fn best_of_candidates(
        &self,
        at: &Interaction,
        rng: &mut Rng,
        adds: impl Fn(&Arriving) -> f32,
    ) -> Option<Selected> {
        let (mut sum, mut kept) = (0.0, None);
        for _ in 0..self.candidates {
            let chosen = self.lights.choose(rng.next_f64(), rng);
            let u = rng.next_f32();
            let Some(ChosenPlace { place, density }) = chosen else {
                continue;
            };
            let Some(arriving) = self.lights.arriving(&place, at) else {
                continue;
            };
            let added = adds(&arriving);
            let weight = added / density;
            if added != 0.0 && !weight.is_finite() {
                let density = f32::NAN;
                return Some(Selected { arriving, density });
            }
            if weight > 0.0 {
                sum += weight;
                if u * sum < weight {
                    kept = Some((arriving, added));
                }
            }
        }
        let (arriving, added) = kept?;
        let density = added * self.candidates as f32 / sum;
        Some(Selected { arriving, density })
    }
}
