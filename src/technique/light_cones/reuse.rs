//! New texels begin with what the next coarser or finer one at their place holds.

use rayon::prelude::*;

use super::gather::Gathering;
use super::texels::{Surfaces, frame_of, normal_of};
use crate::cache::cones::Entry;
use crate::cache::surface::{BLOCK_TEXELS, LEVELS, Texel};

impl Gathering<'_> {
    /// Gives texels that are asked for and hold nothing the cones of another level, with a part of their count: the next
    /// coarser level, or else the next finer one. Returns how many.
    pub fn reuse(&self, surfaces: &mut Surfaces) -> u64 {
        let asked: Vec<_> = surfaces.blocks.asked().collect();
        let known = &*surfaces;
        let found: Vec<(Texel, Entry)> = asked
            .par_iter()
            .flat_map_iter(|(block, mask)| {
                let texels = (0..BLOCK_TEXELS as u32).filter(move |i| mask >> i & 1 == 1);
                texels.filter_map(|index| {
                    let texel = Texel {
                        block: *block,
                        index,
                    };
                    Some((texel, self.known_of(known, texel)?))
                })
            })
            .collect();
        for (texel, entry) in &found {
            if let Some(words) = surfaces.blocks.texel_mut(*texel) {
                self.storage.write(entry, words);
            }
        }
        found.len() as u64
    }

    /// What another level knows of an empty texel, as seen from it.
    fn known_of(&self, surfaces: &Surfaces, texel: Texel) -> Option<Entry> {
        let (point, words) = surfaces.blocks.texel(texel)?;
        if !point.is_somewhere() || self.storage.read(words).count > 0.0 {
            return None;
        }
        let surface = texel.block.surface();
        let level = texel.block.level();
        let place = surfaces.grid.centre(texel);
        let levels = [level + 1, level.wrapping_sub(1)];
        let (source, entry) = levels.into_iter().find_map(|level| {
            if level >= LEVELS {
                return None;
            }
            let other = surfaces.grid.nearest(surface, place, level);
            let (source, words) = surfaces.blocks.texel(other)?;
            let entry = self.storage.read(words);
            let is_outdated = !self.restless && surfaces.blocks.has_missed(other);
            (entry.count > 0.0 && !is_outdated).then_some((source, entry))
        })?;
        let (scene, orientation) = (self.shot.scene, self.parameters.orientation);
        let frame = |triangle| {
            let normal = normal_of(scene, triangle, surface.back);
            frame_of(scene, triangle, normal, orientation)
        };
        let (from, to) = (frame(source.triangle), frame(point.triangle));
        let mut entry = entry.carried(|axis| to.to_local(from.to_world(axis)).normalize());
        entry.count = (self.parameters.reused_count * entry.count).max(1.0);
        Some(entry)
    }
}
