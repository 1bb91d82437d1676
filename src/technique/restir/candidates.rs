//! Candidates of a pixel: places on lights that are drawn by power, and such as directions that the surface draws lead to. One
//! is kept, in proportion to what it would add without shadows.
//!
//! Both kinds could have drawn any place of a light that has an extent. Each candidate therefore weighs by the density of
//! all candidates together (the balance heuristic), as in the RTXDI library.

use super::pass::{Sources, Tools};
use super::receiver::Receiver;
use super::reservoir::{Reservoir, Selecting};
use super::settings::Settings;
use crate::sample::Rng;
use crate::shade::{ChosenPlace, LightTile, Lights, SharedTiles};
use crate::technique::Shot;

/// What draws them in a pass.
pub struct Candidates<'a> {
    shot: &'a Shot<'a>,
    settings: &'a Settings,
    sources: Sources,
    /// Those that pixels share.
    tiles: Option<SharedTiles>,
}

impl<'a> Candidates<'a> {
    /// Seed, stream and number of the pass key the random numbers of what pixels share.
    pub fn new(
        shot: &'a Shot<'a>,
        settings: &'a Settings,
        sources: Sources,
        keys: [u64; 3],
    ) -> Self {
        let lights = shot.paths.lights();
        let count = settings.candidates as usize;
        let draw = |rng: &mut Rng| match sources {
            Sources::All => LightTile::new(lights, count, rng),
            Sources::Environment => LightTile::of_environment(lights, count, rng),
        };
        let tiles = settings.presampled;
        Self {
            shot,
            settings,
            sources,
            tiles: tiles.then(|| SharedTiles::new(count, keys, draw)),
        }
    }

    /// Resampled importance sampling: of all candidates one. Where the settings say so, it is given up in shadow.
    pub fn reservoir(&self, receiver: &Receiver, mut tools: Tools) -> Reservoir {
        let selecting = self.selecting(receiver, &mut tools);
        tools.tally.non_finite += selecting.non_finite;
        let count = self.settings.all_candidates();
        let reservoir = selecting.reservoir(count, 1.0 / f64::from(count));
        let dropped = self.settings.visibility_reuse
            && reservoir
                .place
                .is_some_and(|place| receiver.shadowed_target(tools.caster, &place) == 0.0);
        match dropped {
            true => reservoir.emptied(),
            false => reservoir,
        }
    }

    fn selecting(&self, receiver: &Receiver, tools: &mut Tools) -> Selecting {
        let mut selecting = Selecting::default();
        let mut offer = |chosen: ChosenPlace, target: f32, u: f64| {
            let density = match target > 0.0 {
                true => self.density(receiver, &chosen),
                false => chosen.density,
            };
            selecting.offer_place(chosen.place, target, density, u);
        };
        match &self.tiles {
            Some(tiles) => {
                let tile = tiles.pick(&mut tools.rng);
                receiver.each_lit(tile, |chosen, target| {
                    offer(chosen, target, tools.rng.next_f64());
                });
            }
            None => {
                for _ in 0..self.settings.candidates {
                    let chosen = self.by_power(&mut tools.rng);
                    let u = tools.rng.next_f64();
                    if let Some(chosen) = chosen {
                        offer(chosen, receiver.target(&chosen.place), u);
                    }
                }
            }
        }
        for _ in 0..self.settings.surface_candidates {
            if let Some(chosen) = self.by_surface(receiver, tools) {
                let u = tools.rng.next_f64();
                offer(chosen, receiver.target(&chosen.place), u);
            }
        }
        selecting
    }

    /// Density over places of all candidates together, of a place and its density among those by power.
    fn density(&self, receiver: &Receiver, chosen: &ChosenPlace) -> f32 {
        let by_surface = self.settings.surface_candidates as f32;
        if by_surface == 0.0 {
            return chosen.density;
        }
        let by_power = self.settings.candidates as f32 * chosen.density;
        (by_power + by_surface * receiver.density(&chosen.place))
            / self.settings.all_candidates() as f32
    }

    fn by_power(&self, rng: &mut Rng) -> Option<ChosenPlace> {
        match self.sources {
            Sources::All => self.lights().choose(rng.next_f64(), rng),
            Sources::Environment => self
                .lights()
                .choose_environment([rng.next_f32(), rng.next_f32()]),
        }
    }

    fn by_surface(&self, receiver: &Receiver, tools: &mut Tools) -> Option<ChosenPlace> {
        let ray = receiver.sampled_ray(&mut tools.rng)?;
        let hit = self.shot.paths.stopped_at(tools.caster, &ray);
        match (self.sources, hit) {
            (Sources::All, hit) => receiver.place_met(hit.as_ref(), ray.direction),
            (Sources::Environment, None) => self.lights().environment_place(ray.direction),
            (Sources::Environment, Some(_)) => None,
        }
    }

    fn lights(&self) -> &Lights<'a> {
        self.shot.paths.lights()
    }
}
