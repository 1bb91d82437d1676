//! Which lights are sampled at a surface, and where.

use crate::entry::{ParameterError, words};
use crate::sample::Rng;
use crate::shade::{
    Arriving, ChosenPlace, EvenLights, Interaction, LightTile, Lights, Sent, SharedTiles, TilePart,
    bsdf::{LANES, Lanes},
};

words! {
    /// How lights are chosen.
    pub(crate) enum Selection {
        /// Each emitting shape and each other light with the same probability.
        Uniform = "uniform",
        /// By power, half of it spread evenly over emitting shapes, points, directional lights and the environment.
        Power = "power",
        /// By power with one random offset for all samples of a surface, evenly spaced.
        Systematic = "systematic",
        /// By what candidates, drawn by power, would add without shadows; those of all samples of a surface are evenly spaced
        /// and serve all of them.
        Product = "product",
    }
}

impl Selection {
    /// Refuses a key that was set and that only [`Selection::Product`] asks for, beside another selection.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn refuse_unused(self, set: Option<&'static str>) -> Result<(), ParameterError> {
        match set {
            Some(key) if self != Self::Product => Err(ParameterError::new(
                key,
                format!(
                    "{key}: counts with selection = \"product\" alone; leave it out, or choose lights so"
                ),
            )),
            _ => Ok(()),
        }
    }
}

/// Chooses light samples.
pub(crate) struct Selecting<'a> {
    pub lights: &'a Lights<'a>,
    pub even: EvenLights<'a, 'a>,
    pub selection: Selection,
    /// Of each sample, for [`Selection::Product`].
    pub candidates: u32,
    /// Candidates that were drawn before, for as many samples as they are told to serve; other numbers of samples draw their
    /// own.
    pub presampled: Vec<Presampled>,
}

/// Candidates that are drawn once for many surfaces.
pub(crate) struct Presampled {
    /// Samples of a surface that a tile serves.
    pub samples: u32,
    pub tiles: SharedTiles,
}

/// A light sample, before it is known whether it reaches its surface.
pub(crate) struct Selected {
    pub arriving: Arriving,
    /// Which [`Lights::group`] it is of.
    pub group: u32,
    /// Of the sample, per unit of the measure of places; NaN where what a candidate adds is not finite.
    pub density: f32,
}

/// The light samples of one surface after another, in the same memory.
#[derive(Default)]
pub(crate) struct Samples {
    /// Those of the last surface, without those that add nothing.
    pub selected: Vec<Selected>,
    /// Of each part of the candidates.
    sent: Vec<Sent>,
    /// What each candidate adds.
    added: Vec<f32>,
    /// Of what candidates add over their density: all up to each one.
    sums: Vec<f64>,
}

/// Candidates that are held at once, unless a single sample has more of its own.
const POOL: u32 = 1024;
/// Candidates of a tile that is worth sharing: larger ones are drawn anew for each surface.
const LARGEST_SHARED: u32 = 256;

impl Selecting<'_> {
    /// Selects the light samples of a surface, `count` with those left out that add nothing. `adds` is what samples add without
    /// shadows, as luminance up to a factor.
    pub fn select(
        &self,
        at: &Interaction,
        count: u32,
        rng: &mut Rng,
        adds: impl Fn(&TilePart, &Sent) -> Lanes,
        samples: &mut Samples,
    ) {
        let lights = self.lights;
        let selected = &mut samples.selected;
        selected.clear();
        match self.selection {
            Selection::Uniform => {
                self.each(at, count, rng, |_, rng| self.even.choose(rng), selected);
            }
            Selection::Power => {
                let by_power = |_, rng: &mut Rng| {
                    let choice = rng.next_f64();
                    lights.choose(choice, rng)
                };
                self.each(at, count, rng, by_power, selected);
            }
            Selection::Systematic => {
                let evenly = |choice, rng: &mut Rng| lights.choose(choice, rng);
                self.each(at, count, rng, evenly, selected);
            }
            Selection::Product => {
                let group = (POOL / self.candidates).max(1);
                for first in (0..count).step_by(group as usize) {
                    let count = group.min(count - first);
                    let of_count = |presampled: &&Presampled| presampled.samples == count;
                    let drawn;
                    let tile = match self.presampled.iter().find(of_count) {
                        Some(Presampled { tiles, .. }) => tiles.pick(rng),
                        None => {
                            drawn = self.tile(count, rng);
                            &drawn
                        }
                    };
                    self.resample(at, count, tile, rng, &adds, samples);
                }
            }
        }
    }

    /// Draws candidates that many surfaces share, for surfaces of so many samples; `seed` and `frame` key them.
    pub fn presample(&mut self, samples: u32, [seed, frame]: [u64; 2]) {
        if samples.saturating_mul(self.candidates) > LARGEST_SHARED {
            return;
        }
        let keys = [seed, u64::from(samples), frame];
        let count = (samples * self.candidates) as usize;
        let tiles = SharedTiles::new(count, keys, |rng| self.tile(samples, rng));
        self.presampled.push(Presampled { samples, tiles });
    }

    /// Draws candidates for a surface of `count` samples.
    fn tile(&self, count: u32, rng: &mut Rng) -> LightTile {
        LightTile::new(self.lights, (count * self.candidates) as usize, rng)
    }

    /// Samples at places that are chosen one after another, each for one of evenly spaced numbers.
    fn each(
        &self,
        at: &Interaction,
        count: u32,
        rng: &mut Rng,
        choose: impl Fn(f64, &mut Rng) -> Option<ChosenPlace>,
        selected: &mut Vec<Selected>,
    ) {
        let offset = rng.next_f64();
        for number in 0..count {
            let Some(chosen) = choose(even(number, offset, count), rng) else {
                continue;
            };
            let ChosenPlace { place, density } = chosen;
            let arriving = self.lights.arriving(&place, at);
            if let Some(arriving) = arriving.filter(|_| density > 0.0) {
                let group = self.lights.group(&place);
                selected.push(Selected {
                    arriving,
                    group,
                    density,
                });
            }
        }
    }

    /// Resampled importance sampling (Talbot et al. 2005): of all candidates `count`, by what they add. Candidates are evenly
    /// spaced over the lights, and those that are taken over what all of them add.
    fn resample(
        &self,
        at: &Interaction,
        count: u32,
        tile: &LightTile,
        rng: &mut Rng,
        adds: &impl Fn(&TilePart, &Sent) -> Lanes,
        samples: &mut Samples,
    ) {
        let Samples {
            selected,
            sent,
            added: all_added,
            sums,
        } = samples;
        all_added.clear();
        sums.clear();
        let mut sum = 0.0;
        sent.resize_with(tile.parts().len(), Sent::default);
        for (part, sent) in tile.parts().iter().zip(&mut *sent) {
            part.send(self.lights, at, sent);
            let added = adds(part, sent);
            let mut weights = [0.0; LANES];
            if !part.over_density(&added, &mut weights) {
                for lane in (0..LANES).filter(|&lane| !weights[lane].is_finite()) {
                    let number = sums.len() + lane;
                    let arriving = tile.arriving(number, self.lights, at, sent);
                    selected.extend(arriving.map(|arriving| Selected {
                        arriving,
                        group: tile.group(number),
                        density: f32::NAN,
                    }));
                }
                weights = weights.map(|weight| if weight.is_finite() { weight } else { 0.0 });
            }
            sums.extend(weights.iter().map(|weight| {
                sum += weight.max(0.0);
                sum
            }));
            all_added.extend_from_slice(&added);
        }
        let offset = rng.next_f64();
        let mut next = 0;
        for number in 0..count {
            let place = sum * even(number, offset, count);
            while sums.get(next).is_some_and(|sum| *sum <= place) {
                next += 1;
            }
            // Rounding may lead past the last one with a weight.
            let taken = match next < sums.len() {
                true => next,
                false => sums.partition_point(|&before| before < sum),
            };
            // Most candidates are not taken: their shadow rays are left out.
            if sum > 0.0
                && let Some(arriving) = tile.arriving(taken, self.lights, at, &sent[taken / LANES])
            {
                let density = (f64::from(all_added[taken]) * tile.count() as f64 / sum) as f32;
                selected.push(Selected {
                    arriving,
                    group: tile.group(taken),
                    density,
                });
            }
        }
    }
}

/// The place of one of `count` evenly spaced numbers in [0, 1).
fn even(number: u32, offset: f64, count: u32) -> f64 {
    (f64::from(number) + offset) / f64::from(count)
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3, Vec3};

    use super::*;
    use crate::scene::{Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View};
    use crate::shade::Surfaces;
    use crate::trace::{RayCounter, Tracer};

    /// Candidates whose light is not finite come back as they are, and none of the samples is at one of them.
    #[test]
    fn candidates_that_are_not_finite_are_told_and_never_taken() {
        let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
        let turned = DMat4::from_rotation_x(std::f64::consts::PI);
        lamp.to_world = DMat4::from_translation(DVec3::Z * 3.0) * turned;
        lamp.emission = Some([2.0; 3]);
        let eye = [DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y];
        let description = SceneDescription {
            views: vec![View::look_at("v", eye, 60.0, [8, 8])],
            shapes: vec![ShapeDescription::new("floor", ShapeSource::Rectangle), lamp],
            ..SceneDescription::default()
        };
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let counter = RayCounter::default();
        let down = crate::trace::Ray::new(Vec3::new(0.1, 0.2, 1.0), -Vec3::Z);
        let hit = tracer.caster(&counter).closest(&down).expect("the floor");
        let (lights, surfaces) = (Lights::new(&scene), Surfaces::new(&scene));
        let at = surfaces.interact(&hit, down.direction);
        let selecting = Selecting {
            lights: &lights,
            even: EvenLights::new(&lights),
            selection: Selection::Product,
            candidates: 8,
            presampled: Vec::new(),
        };
        let samples = |of: fn(usize) -> f32| {
            let mut rng = Rng::new(1, 2, 3, 4);
            let mut samples = Samples::default();
            selecting.select(
                &at,
                4,
                &mut rng,
                |_, _| std::array::from_fn(of),
                &mut samples,
            );
            samples.selected
        };
        let sound = samples(|_| 1.0);
        assert_eq!(sound.len(), 4);
        assert!(sound.iter().all(|sample| sample.density > 0.0));
        // All 32 candidates are in one part; of the first three nothing is taken.
        let spoilt = samples(|lane| [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0][lane.min(3)]);
        let (told, taken): (Vec<_>, Vec<_>) = spoilt.iter().partition(|s| s.density.is_nan());
        assert_eq!((told.len(), taken.len()), (3, 4));
        for sample in taken {
            assert!(sample.density.is_finite() && sample.density > 0.0);
            let is_told = |other: &&Selected| other.arriving.direction == sample.arriving.direction;
            assert!(!told.iter().any(is_told));
        }
    }
}
