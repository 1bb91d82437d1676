//! The pool of blocks.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

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

/// Words of the contents of a block.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Of each texel.
    pub texel: usize,
    /// Behind those of all texels, of the block as a whole.
    pub block: usize,
}

/// Blocks that were asked for, with the contents of their texels.
pub struct Blocks {
    limits: Limits,
    layout: Layout,
    slots: Vec<Slot>,
    /// Slots without a block; the last one is taken first.
    free: Vec<u32>,
    slot_of: HashMap<BlockKey, u32, BuildHasherDefault<KeyHasher>>,
    /// Of each slot; those of free slots serve the next block.
    contents: Vec<Contents>,
    /// Frames so far.
    frame: u32,
}

/// What a slot holds.
#[derive(Default)]
struct Contents {
    /// See [`Layout`].
    words: Vec<u32>,
    /// Of all texels.
    points: Vec<SurfacePoint>,
}

/// A place for a block.
#[derive(Debug, Default)]
struct Slot {
    key: Option<BlockKey>,
    /// Texels that this frame asks for: written by all threads, each block by one of them.
    asked: AtomicU64,
    /// Last frame that asked for it.
    seen: u32,
    /// Texels that have begun: their points stay.
    begun: u64,
    /// Texels whose points were moved.
    moved: u64,
    /// Texels that nobody asked for when something changed, nor since.
    missed: u64,
}

impl Slot {
    fn asked(&self) -> u64 {
        self.asked.load(Relaxed)
    }
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
    pub points: &'a [SurfacePoint],
    /// Contents of all texels, and behind them those of the block as a whole.
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
    missed: u64,
    words: Vec<u32>,
}

impl Blocks {
    /// No block yet; all words of new ones are 0.
    pub fn new(limits: Limits, layout: Layout) -> Self {
        Self {
            limits,
            layout,
            slots: Vec::new(),
            free: Vec::new(),
            slot_of: HashMap::default(),
            contents: Vec::new(),
            frame: 0,
        }
    }

    /// Begins a frame: maps what merged requests ask for, in the order of keys, and gives up what is old. Where there is
    /// no room the block that was asked for longest ago goes, if it is not asked for now.
    pub fn begin(&mut self, requests: &Requests, charts: &Charts, grid: &Grid) -> Asked {
        self.frame += 1;
        let slots = self.slots.par_iter_mut().with_min_len(1024);
        slots.for_each(|slot| *slot.asked.get_mut() = 0);
        let requests = requests.blocks().par_iter().with_min_len(1024);
        let unknown: Vec<(BlockKey, u64)> = requests
            .filter(|(key, mask)| match self.slot_of.get(key) {
                Some(&slot) => {
                    self.slots[slot as usize].asked.store(*mask, Relaxed);
                    false
                }
                None => true,
            })
            .copied()
            .collect();
        let slots = self.slots.par_iter_mut().with_min_len(1024);
        slots.for_each(|slot| {
            if slot.asked() != 0 {
                slot.seen = self.frame;
            }
        });
        let mut asked = Asked {
            evicted: self.give_up_old() + self.make_room(unknown.len()),
            ..Asked::default()
        };
        let mut new = Vec::with_capacity(unknown.len());
        self.slot_of.reserve(unknown.len().min(self.limits.blocks));
        let room = self.limits.blocks.saturating_sub(self.slots.len());
        let slots = unknown.len().saturating_sub(self.free.len()).min(room);
        self.slots.reserve(slots);
        self.contents.reserve(slots);
        for (key, mask) in unknown {
            let Some(slot) = self.place() else {
                asked.refused += 1;
                continue;
            };
            self.slots[slot as usize] = Slot {
                key: Some(key),
                asked: mask.into(),
                seen: self.frame,
                ..Slot::default()
            };
            self.slot_of.insert(key, slot);
            new.push((slot, key));
        }
        asked.new = new.len() as u64;
        self.fill(&new, charts, grid);
        asked
    }

    /// A slot for a new block.
    fn place(&mut self) -> Option<u32> {
        if let Some(slot) = self.free.pop() {
            return Some(slot);
        }
        if self.slots.len() >= self.limits.blocks {
            return None;
        }
        let slot = self.slots.len() as u32;
        self.slots.push(Slot::default());
        self.contents.push(Contents::default());
        Some(slot)
    }

    fn give_up_old(&mut self) -> u64 {
        let old = |slot: &Slot| self.frame - slot.seen > self.limits.frames;
        let slots = self.slots.par_iter().with_min_len(1024).enumerate();
        let old: Vec<u32> = slots
            .filter(|(_, slot)| slot.key.is_some() && old(slot))
            .map(|(index, _)| index as u32)
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

    /// Gives new blocks empty contents and their surface points.
    fn fill(&mut self, new: &[(u32, BlockKey)], charts: &Charts, grid: &Grid) {
        let size = self.size();
        let contents = new
            .iter()
            .map(|(slot, _)| std::mem::take(&mut self.contents[*slot as usize]));
        let mut contents: Vec<Contents> = contents.collect();
        contents
            .par_iter_mut()
            .zip(new)
            .for_each(|(contents, (_, key))| {
                contents.words.clear();
                contents.words.resize(size, 0);
                contents.points.clear();
                contents.points.extend(surface_points(charts, grid, *key));
            });
        for ((slot, _), contents) in new.iter().zip(contents) {
            self.contents[*slot as usize] = contents;
        }
    }

    /// Words of a block.
    fn size(&self) -> usize {
        BLOCK_TEXELS * self.layout.texel + self.layout.block
    }

    /// Works on every block that this frame asks for; results are in the order of slots.
    pub fn work<T: Send, S>(
        &mut self,
        start: impl Fn() -> S + Sync + Send,
        work: impl Fn(&mut S, Block) -> T + Sync + Send,
    ) -> Vec<T> {
        self.contents
            .par_iter_mut()
            .zip(&self.slots)
            .filter(|(_, slot)| slot.asked() != 0)
            .map_init(start, |state, (Contents { words, points }, slot)| {
                let key = slot.key.expect("what is asked for has a block");
                let block = Block {
                    key,
                    asked: slot.asked(),
                    points,
                    words,
                };
                work(state, block)
            })
            .collect()
    }

    /// The blocks that this frame asks for, with the texels that it asks for, in the order of slots.
    pub fn asked(&self) -> impl Iterator<Item = (BlockKey, u64)> {
        let asked = self.slots.iter().filter(|slot| slot.asked() != 0);
        asked.filter_map(|slot| Some((slot.key?, slot.asked())))
    }

    /// Something has changed since the last frame: what texels hold that this frame does not ask for is no longer so.
    pub fn miss(&mut self) {
        let slots = self.slots.par_iter_mut().with_min_len(1024);
        slots.for_each(|slot| slot.missed |= !slot.asked());
    }

    /// Texels that this frame asks for catch up with what they missed, by holding nothing any more where `forgetting`.
    pub fn catch_up(&mut self, forgetting: bool) {
        let size = self.layout.texel;
        let slots = self.slots.par_iter_mut().with_min_len(1024);
        slots.zip(&mut self.contents).for_each(|(slot, contents)| {
            let late = slot.missed & slot.asked();
            slot.missed &= !slot.asked();
            if forgetting {
                let late = (0..BLOCK_TEXELS).filter(|index| late >> index & 1 == 1);
                late.for_each(|index| contents.words[index * size..][..size].fill(0));
            }
        });
    }

    /// Whether a texel has missed a change.
    pub fn has_missed(&self, texel: Texel) -> bool {
        let slot = self.slot_of.get(&texel.block);
        slot.is_some_and(|&slot| self.slots[slot as usize].missed >> texel.index & 1 == 1)
    }

    /// Surface point and contents of a texel, if its block is there.
    pub fn texel(&self, texel: Texel) -> Option<(SurfacePoint, &[u32])> {
        let slot = *self.slot_of.get(&texel.block)? as usize;
        let Contents { words, points } = &self.contents[slot];
        let index = texel.index as usize;
        let start = index * self.layout.texel;
        Some((points[index], &words[start..start + self.layout.texel]))
    }

    /// Whether this frame asks for a texel that was never used before.
    pub fn any_begins(&self) -> bool {
        self.slots
            .iter()
            .any(|slot| slot.asked() & !slot.begun != 0)
    }

    /// Whether a texel was never used before.
    pub fn begins(&self, texel: Texel) -> bool {
        let slot = self.slot_of.get(&texel.block);
        slot.is_some_and(|&slot| self.slots[slot as usize].begun >> texel.index & 1 == 0)
    }

    /// Texels are used from now on, at these surface points in place of those at their centres. `begun` says which; those
    /// of a block follow one another.
    pub fn begin_texels<T: Sync>(
        &mut self,
        begun: &[T],
        texel: impl Fn(&T) -> (Texel, Option<SurfacePoint>) + Sync,
    ) {
        let block = |of: &T| texel(of).0.block;
        let of_blocks = begun.par_chunk_by(|a, b| block(a) == block(b));
        let found: Vec<_> = of_blocks
            .filter_map(|begun| {
                let slot = *self.slot_of.get(&block(&begun[0]))? as usize;
                let bits = begun.iter().map(|of| 1 << texel(of).0.index);
                let moved = begun.iter().filter_map(|of| match texel(of) {
                    (texel, Some(point)) => Some((texel.index, point)),
                    _ => None,
                });
                let moved: Vec<_> = moved.collect();
                Some((slot, bits.fold(0, |all, bit| all | bit), moved))
            })
            .collect();
        for (slot, begun, moved) in found {
            let of_slot = &mut self.slots[slot];
            of_slot.begun |= begun;
            for (index, point) in moved {
                of_slot.moved |= 1 << index;
                self.contents[slot].points[index as usize] = point;
            }
        }
    }

    /// Contents of a texel, to be written; `None` where its block is not there.
    pub fn texel_mut(&mut self, texel: Texel) -> Option<&mut [u32]> {
        let slot = *self.slot_of.get(&texel.block)? as usize;
        let start = texel.index as usize * self.layout.texel;
        Some(&mut self.contents[slot].words[start..start + self.layout.texel])
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
        4 * self.size()
            + BLOCK_TEXELS * size_of::<SurfacePoint>()
            + size_of::<Contents>()
            + size_of::<Slot>()
    }

    /// Bytes of the blocks that are there.
    pub fn active_bytes(&self) -> usize {
        self.len() * self.block_bytes()
    }

    /// Bytes of all slots, those without a block too, and of the map.
    pub fn allocated_bytes(&self) -> usize {
        let entry = size_of::<(BlockKey, u32)>() + 1;
        self.slots.len() * self.block_bytes()
            + size_of_val(self.free.as_slice())
            + self.slot_of.len() * 8 / 7 * entry
    }

    /// The blocks, in the order of keys.
    pub fn memory(&self) -> Vec<BlockMemory> {
        let slots = self.slots.iter().zip(&self.contents);
        let mut memory: Vec<BlockMemory> = slots
            .filter_map(|(slot, Contents { words, points })| {
                let moved = (0..BLOCK_TEXELS).filter(|i| slot.moved >> i & 1 == 1);
                Some(BlockMemory {
                    key: slot.key?,
                    age: self.frame - slot.seen,
                    begun: slot.begun,
                    moved: moved.map(|i| (i as u32, points[i])).collect(),
                    missed: slot.missed,
                    words: words.clone(),
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
        let size = self.size();
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
        *self = Self::new(self.limits, self.layout);
        self.frame = memory.iter().map(|block| block.age).max().unwrap_or(0);
        let mut new = Vec::with_capacity(memory.len());
        for (slot, block) in (0..).zip(&memory) {
            self.slots.push(Slot {
                key: Some(block.key),
                asked: 0.into(),
                seen: self.frame - block.age,
                begun: block.begun,
                moved: block.moved.iter().fold(0, |bits, (i, _)| bits | 1 << i),
                missed: block.missed,
            });
            self.contents.push(Contents::default());
            self.slot_of.insert(block.key, slot);
            new.push((slot, block.key));
        }
        self.fill(&new, charts, grid);
        for (contents, block) in self.contents.iter_mut().zip(memory) {
            contents.words = block.words;
            for (index, point) in block.moved {
                contents.points[index as usize] = point;
            }
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
