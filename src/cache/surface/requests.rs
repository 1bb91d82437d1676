//! What viewers ask for: texels, block by block.

use rayon::prelude::*;

use super::grid::{BlockKey, Texel};
use crate::memory::concatenated;

/// Blocks with a mask of 64 bits of the texels that are asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Requests {
    blocks: Vec<(BlockKey, u64)>,
}

impl Requests {
    /// Asks for a texel.
    pub fn ask(&mut self, texel: Texel) {
        let bit = 1 << texel.index;
        match self.blocks.last_mut() {
            Some((block, mask)) if *block == texel.block => *mask |= bit,
            _ => self.blocks.push((texel.block, bit)),
        }
    }

    /// Each block once, in the order of keys: the same whatever was asked for first.
    pub fn merge(&mut self) {
        // Merged requests one after another are sorted runs, which a stable sort merges, with all threads where they are many.
        self.blocks.par_sort();
        self.blocks.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 |= next.1;
            }
            same
        });
    }

    /// All that some merged requests ask for, merged.
    pub fn merged(all: Vec<Self>) -> Self {
        let is_one = all.len() < 2;
        let mut both = Self {
            blocks: concatenated(all.into_iter().map(|one| one.blocks).collect()),
        };
        if !is_one {
            both.merge();
        }
        both
    }

    /// Blocks and masks.
    pub fn blocks(&self) -> &[(BlockKey, u64)] {
        &self.blocks
    }

    /// Number of texels, of merged requests.
    pub fn texels(&self) -> u64 {
        let counts = self.blocks.iter().map(|(_, mask)| mask.count_ones());
        counts.map(u64::from).sum()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::cache::surface::{Grid, Surface};

    #[test]
    fn what_two_ask_for_is_asked_for_once_in_any_order() {
        let grid = Grid { finest: 1.0 };
        let surface = Surface {
            island: 3,
            back: false,
        };
        let places = |from: u32| {
            let mut requests = Requests::default();
            for i in from..from + 60 {
                let place = Vec2::new((i % 11) as f32, (i / 7) as f32);
                requests.ask(grid.nearest(surface, place, i % 2));
            }
            requests
        };
        let (mut a, b) = (places(0), places(30));
        let both = Requests::merged(vec![a.clone(), b.clone()]);
        assert_eq!(both, Requests::merged(vec![b.clone(), a.clone()]));
        a.merge();
        assert!(both.texels() > a.texels());
        assert!(both.texels() < a.texels() + Requests::merged(vec![b]).texels());
        assert!(both.blocks().is_sorted());
    }
}
