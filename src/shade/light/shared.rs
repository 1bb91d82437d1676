//! Tiles of places on lights that serve many surfaces (presampled lights: Wyman and Panteleev, "Rearchitecting Spatiotemporal
//! Resampling for Production", 2021).

use rayon::prelude::*;

use super::tile::LightTile;
use crate::sample::Rng;

/// Tiles that many surfaces share.
pub struct SharedTiles(Vec<LightTile>);

/// Tiles that are shared at most: neighbours seldom have the same one.
const TILES: usize = 1024;
/// Places of all tiles together, where those are large: of more, few are at hand in a processor's cache.
const PLACES: usize = 16384;
/// Keys their random numbers.
const STREAM: u64 = 0x7469_6c65_7320;

impl SharedTiles {
    /// Draws tiles of `count` places each; seed, stream and number key their random numbers.
    pub fn new(
        count: usize,
        [seed, stream, number]: [u64; 3],
        draw: impl Fn(&mut Rng) -> LightTile + Sync,
    ) -> Self {
        let tiles = (PLACES / count.max(1)).clamp(1, TILES);
        let one = |tile| draw(&mut Rng::new(seed, STREAM ^ stream, tile as u64, number));
        Self((0..tiles).into_par_iter().map(one).collect())
    }

    /// One of them, at random.
    pub fn pick(&self, rng: &mut Rng) -> &LightTile {
        &self.0[rng.below(self.0.len())]
    }
}
