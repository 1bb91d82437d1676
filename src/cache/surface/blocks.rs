//! The pool of blocks.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::charts::Charts;
use super::grid::{BLOCK_TEXELS, BlockKey, Grid, Texel};
use super::lookup::{SurfacePoint, surface_points};
use super::requests::Requests;

/// How many blocks there can be, and for how long.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Blocks at most.
    pub blocks: usize,
    /// Frames without a request after which a block is given up.
    pub frames: u32,
}

/// Blocks that were asked for, with the contents of their texels.
pub struct Blocks {
    limits: Limits,
    /// Words of a texel.
    words_per_texel: usize,
    slots: Vec<Slot>,
    /// Slots without a block; the last one is taken first.
    free: Vec<u32>,
    slot_of: HashMap<BlockKey, u32, BuildHasherDefault<KeyHasher>>,
    words: Vec<u32>,
    points: Vec<[SurfacePoint; BLOCK_TEXELS]>,
    /// Frames so far.
    frame: u32,
}

/// A place for a block.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    key: Option<BlockKey>,
    /// Texels that this frame asks for.
    asked: u64,
    /// Last frame that asked for it.
    seen: u32,
    /// Texels that have begun: their points stay.
    begun: u64,
    /// Texels whose points were moved.
    moved: u64,
}

/// What became of requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// Blocks that were not there.
    pub new: u64,
    /// Blocks that were given up.
    pub evicted: u64,
    /// Blocks for which there was no room.
    pub refused: u64,
}

/// A block at work: one that somebody asked for in this frame.
pub struct Block<'a> {
    /// Which block it is.
    pub key: BlockKey,
    /// Texels that are asked for.
    pub asked: u64,
    /// Where its texels lie on the surface.
    pub points: &'a [SurfacePoint; BLOCK_TEXELS],
    /// Contents of all texels.
    pub words: &'a mut [u32],
}

/// A block as it is remembered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockMemory {
    key: BlockKey,
    /// Frames since it was asked for.
    age: u32,
    /// Texels that have begun.
    begun: u64,
    /// Texels whose points were moved, and to where.
    moved: Vec<(u32, SurfacePoint)>,
    words: Vec<u32>,
}

impl Blocks {
    /// No block yet; all words of new ones are 0.
    pub fn new(limits: Limits, words_per_texel: usize) -> Self {
        Self {
            limits,
            words_per_texel,
            slots: Vec::new(),
            free: Vec::new(),
            slot_of: HashMap::default(),
            words: Vec::new(),
            points: Vec::new(),
            frame: 0,
        }
    }

    /// Begins a frame: maps what merged requests ask for, in the order of keys, and gives up what is old. Where there is
    /// no room the block that was asked for longest ago goes, if it is not asked for now.
    pub fn begin(&mut self, requests: &Requests, charts: &Charts, grid: &Grid) -> Asked {
        self.frame += 1;
        self.slots.iter_mut().for_each(|slot| slot.asked = 0);
        let mut unknown = Vec::new();
        for (key, mask) in requests.blocks() {
            match self.slot_of.get(key) {
                Some(&slot) => self.ask(slot, *mask),
                None => unknown.push((*key, *mask)),
            }
        }
        let mut asked = Asked {
            evicted: self.give_up_old() + self.make_room(unknown.len()),
            ..Asked::default()
        };
        let mut new = Vec::with_capacity(unknown.len());
        for (key, mask) in unknown {
            let Some(slot) = self.place() else {
                asked.refused += 1;
                continue;
            };
            self.slots[slot as usize] = Slot {
                key: Some(key),
                ..Slot::default()
            };
            self.slot_of.insert(key, slot);
            self.ask(slot, mask);
            new.push((slot, key));
        }
        asked.new = new.len() as u64;
        self.look_up(&new, charts, grid);
        asked
    }

    fn ask(&mut self, slot: u32, mask: u64) {
        let slot = &mut self.slots[slot as usize];
        (slot.asked, slot.seen) = (mask, self.frame);
    }

    /// A slot for a new block, with empty contents.
    fn place(&mut self) -> Option<u32> {
        let size = BLOCK_TEXELS * self.words_per_texel;
        if let Some(slot) = self.free.pop() {
            self.words[slot as usize * size..][..size].fill(0);
            return Some(slot);
        }
        if self.slots.len() >= self.limits.blocks {
            return None;
        }
        let slot = self.slots.len() as u32;
        self.slots.push(Slot::default());
        self.words.resize(self.slots.len() * size, 0);
        Some(slot)
    }

    fn give_up_old(&mut self) -> u64 {
        let old = |slot: &Slot| self.frame - slot.seen > self.limits.frames;
        let slots = (0..).zip(&self.slots);
        let old: Vec<u32> = slots
            .filter(|(_, slot)| slot.key.is_some() && old(slot))
            .map(|(index, _)| index)
            .collect();
        old.iter().for_each(|&slot| self.give_up(slot));
        old.len() as u64
    }

    /// Gives up blocks until so many find room, as far as that is possible.
    fn make_room(&mut self, wanted: usize) -> u64 {
        let room = self.free.len() + self.limits.blocks.saturating_sub(self.slots.len());
        let missing = wanted.saturating_sub(room);
        if missing == 0 {
            return 0;
        }
        let slots = (0..).zip(&self.slots);
        let mut candidates: Vec<(u32, BlockKey, u32)> = slots
            .filter(|(_, slot)| slot.seen < self.frame)
            .filter_map(|(index, slot)| Some((slot.seen, slot.key?, index)))
            .collect();
        candidates.sort_unstable();
        candidates.truncate(missing);
        candidates.iter().for_each(|&(.., slot)| self.give_up(slot));
        candidates.len() as u64
    }

    fn give_up(&mut self, slot: u32) {
        if let Some(key) = self.slots[slot as usize].key.take() {
            self.slot_of.remove(&key);
            self.free.push(slot);
        }
    }

    /// Finds the surface points of new blocks.
    fn look_up(&mut self, new: &[(u32, BlockKey)], charts: &Charts, grid: &Grid) {
        let found: Vec<_> = new
            .par_iter()
            .map(|(_, key)| surface_points(charts, grid, *key))
            .collect();
        self.points
            .resize(self.slots.len(), [SurfacePoint::NONE; BLOCK_TEXELS]);
        for ((slot, _), points) in new.iter().zip(found) {
            self.points[*slot as usize] = points;
        }
    }

    /// Works on every block that this frame asks for; results are in the order of slots.
    pub fn work<T: Send, S>(
        &mut self,
        start: impl Fn() -> S + Sync + Send,
        work: impl Fn(&mut S, Block) -> T + Sync + Send,
    ) -> Vec<T> {
        let size = (BLOCK_TEXELS * self.words_per_texel).max(1);
        self.words
            .par_chunks_mut(size)
            .zip(&self.slots)
            .zip(&self.points)
            .filter(|((_, slot), _)| slot.asked != 0)
            .map_init(start, |state, ((words, slot), points)| {
                let key = slot.key.expect("what is asked for has a block");
                let block = Block {
                    key,
                    asked: slot.asked,
                    points,
                    words,
                };
                work(state, block)
            })
            .collect()
    }

    /// The blocks that this frame asks for, with the texels that it asks for, in the order of slots.
    pub fn asked(&self) -> impl Iterator<Item = (BlockKey, u64)> {
        let asked = self.slots.iter().filter(|slot| slot.asked != 0);
        asked.filter_map(|slot| Some((slot.key?, slot.asked)))
    }

    /// Surface point and contents of a texel, if its block is there.
    pub fn texel(&self, texel: Texel) -> Option<(SurfacePoint, &[u32])> {
        let slot = *self.slot_of.get(&texel.block)? as usize;
        let index = texel.index as usize;
        let start = (slot * BLOCK_TEXELS + index) * self.words_per_texel;
        let words = &self.words[start..start + self.words_per_texel];
        Some((self.points[slot][index], words))
    }

    /// Whether this frame asks for a texel that was never used before.
    pub fn any_begins(&self) -> bool {
        self.slots.iter().any(|slot| slot.asked & !slot.begun != 0)
    }

    /// Whether a texel was never used before.
    pub fn begins(&self, texel: Texel) -> bool {
        let slot = self.slot_of.get(&texel.block);
        slot.is_some_and(|&slot| self.slots[slot as usize].begun >> texel.index & 1 == 0)
    }

    /// A texel is used from now on, at this surface point in place of that at its centre.
    pub fn begin_texel(&mut self, texel: Texel, point: Option<SurfacePoint>) {
        let Some(&slot) = self.slot_of.get(&texel.block) else {
            return;
        };
        let bit = 1 << texel.index;
        self.slots[slot as usize].begun |= bit;
        if let Some(point) = point {
            self.slots[slot as usize].moved |= bit;
            self.points[slot as usize][texel.index as usize] = point;
        }
    }

    /// Contents of a texel, to be written; `None` where its block is not there.
    pub fn texel_mut(&mut self, texel: Texel) -> Option<&mut [u32]> {
        let slot = *self.slot_of.get(&texel.block)? as usize;
        let start = (slot * BLOCK_TEXELS + texel.index as usize) * self.words_per_texel;
        Some(&mut self.words[start..start + self.words_per_texel])
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.slot_of.len()
    }

    /// Whether there is no block.
    pub fn is_empty(&self) -> bool {
        self.slot_of.is_empty()
    }

    /// Bytes of a block: contents, surface points and its place.
    fn block_bytes(&self) -> usize {
        BLOCK_TEXELS * (4 * self.words_per_texel + size_of::<SurfacePoint>()) + size_of::<Slot>()
    }

    /// Bytes of the blocks that are there.
    pub fn active_bytes(&self) -> usize {
        self.len() * self.block_bytes()
    }

    /// Bytes of all slots and of the map.
    pub fn allocated_bytes(&self) -> usize {
        let entry = size_of::<(BlockKey, u32)>() + 1;
        4 * self.words.capacity()
            + self.points.capacity() * size_of::<[SurfacePoint; BLOCK_TEXELS]>()
            + self.slots.capacity() * size_of::<Slot>()
            + 4 * self.free.capacity()
            + self.slot_of.capacity() * 8 / 7 * entry
    }

    /// The blocks, in the order of keys.
    pub fn memory(&self) -> Vec<BlockMemory> {
        let size = BLOCK_TEXELS * self.words_per_texel;
        let slots = self.slots.iter().enumerate();
        let mut memory: Vec<BlockMemory> = slots
            .filter_map(|(index, slot)| {
                let moved = (0..BLOCK_TEXELS).filter(|i| slot.moved >> i & 1 == 1);
                Some(BlockMemory {
                    key: slot.key?,
                    age: self.frame - slot.seen,
                    begun: slot.begun,
                    moved: moved.map(|i| (i as u32, self.points[index][i])).collect(),
                    words: self.words[index * size..][..size].to_vec(),
                })
            })
            .collect();
        memory.sort_unstable_by_key(|block| block.key);
        memory
    }

    /// Holds what [`Blocks::memory`] gave, over the same charts.
    ///
    /// # Errors
    /// A sentence, where that does not fit.
    pub fn recall(
        &mut self,
        memory: Vec<BlockMemory>,
        charts: &Charts,
        grid: &Grid,
    ) -> Result<(), String> {
        let size = BLOCK_TEXELS * self.words_per_texel;
        let fits = |block: &BlockMemory| {
            let texels = BLOCK_TEXELS as u32;
            let moved = block.moved.iter().all(|(index, _)| *index < texels);
            moved
                && block.words.len() == size
                && (block.key.surface().island as usize) < charts.len()
        };
        if memory.len() > self.limits.blocks || !memory.iter().all(fits) {
            return Err(
                "what was remembered is of other blocks: of another scene or of other parameters"
                    .into(),
            );
        }
        *self = Self::new(self.limits, self.words_per_texel);
        self.frame = memory.iter().map(|block| block.age).max().unwrap_or(0);
        let mut new = Vec::with_capacity(memory.len());
        let mut moved = Vec::new();
        for (slot, block) in (0..).zip(memory) {
            self.slots.push(Slot {
                key: Some(block.key),
                asked: 0,
                seen: self.frame - block.age,
                begun: block.begun,
                moved: block.moved.iter().fold(0, |bits, (i, _)| bits | 1 << i),
            });
            moved.extend(
                block
                    .moved
                    .into_iter()
                    .map(|(i, point)| (slot as usize, i, point)),
            );
            self.words.extend(block.words);
            self.slot_of.insert(block.key, slot);
            new.push((slot, block.key));
        }
        self.look_up(&new, charts, grid);
        for (slot, index, point) in moved {
            self.points[slot][index as usize] = point;
        }
        Ok(())
    }
}

/// Hashes the bits of a key.
#[derive(Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = crate::sample::hash(self.0 ^ u64::from(*byte));
        }
    }

    fn write_u64(&mut self, key: u64) {
        self.0 = crate::sample::hash(key);
    }
}

#[cfg(test)]
mod tests;
