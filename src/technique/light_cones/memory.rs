//! What is kept of an interrupted sequence.

use serde::{Deserialize, Serialize};

use super::stillness::Stillness;
use super::texels::Surfaces;
use crate::cache::surface::{BlockMemory, Blocks, Charts, Grid};
use crate::scene::Scene;

/// Charts have the lengths of the first frame, from which shapes may have moved since: they are kept too.
#[derive(Serialize, Deserialize)]
pub(super) struct Memory {
    charts: Charts,
    grid: Grid,
    blocks: Vec<BlockMemory>,
    stillness: Stillness,
}

impl Memory {
    pub fn of(surfaces: &Surfaces) -> Self {
        Self {
            charts: Charts::clone(&surfaces.charts),
            grid: surfaces.grid,
            blocks: surfaces.blocks.memory(),
            stillness: surfaces.stillness,
        }
    }

    /// # Errors
    /// A sentence.
    pub fn bytes(&self) -> Result<Vec<u8>, String> {
        postcard::to_allocvec(self).map_err(|error| error.to_string())
    }

    /// # Errors
    /// A sentence, where these are not the bytes of one.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        postcard::from_bytes(bytes).map_err(|error| error.to_string())
    }

    /// The texels of a scene as they were, in place of no block.
    ///
    /// # Errors
    /// A sentence, where they were of another scene or had other parameters.
    pub fn restored(self, mut blocks: Blocks, scene: &Scene) -> Result<Surfaces, String> {
        if self.charts.triangles() != scene.triangles.len() {
            return Err("what was remembered is of another scene".into());
        }
        blocks.recall(self.blocks, &self.charts, &self.grid)?;
        Ok(Surfaces {
            charts: self.charts.into(),
            grid: self.grid,
            blocks,
            stillness: self.stillness,
        })
    }
}
