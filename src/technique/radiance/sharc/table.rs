//! The open hash table of the cells, and how a frame's samples are merged into it.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::key::Key;

/// Slots in which a key may lie, from that of its hash on.
const WINDOW: usize = 16;

/// What a cell holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Mean light on diffuse bases, without their colour: what they would send back if their albedo were 1.
    pub mean: Vec3,
    /// Samples in the mean, those that the window of frames has faded out left out.
    pub samples: f32,
    /// Frames since the first sample, up to the window; 0 in the frame of the first.
    pub frames: u32,
    /// Frames since the last sample.
    pub stale: u32,
}

/// A sample of the light in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub key: Key,
    pub light: Vec3,
}

/// How cells age.
#[derive(Clone, Copy, Debug)]
pub struct Ages {
    /// Frames that a mean reaches back.
    pub history: u32,
    /// Frames without a sample after which a cell is given up.
    pub stale: u32,
    /// Whether new cells begin with what the next coarser or finer level holds.
    pub blend: bool,
}

/// What merging a frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Merged {
    pub samples: u64,
    /// Cells that got samples.
    pub cells: u64,
    /// Samples left out because all slots of their window were taken.
    pub dropped: u64,
    /// Cells given up for their age.
    pub evicted: u64,
    /// New cells that began with what another level holds.
    pub blended: u64,
}

/// A table of a fixed number of slots.
#[derive(Clone, Debug)]
pub struct Table {
    keys: Vec<Key>,
    cells: Vec<Cell>,
    occupied: usize,
}

impl Table {
    /// An empty table of at least one slot.
    pub fn new(capacity: usize) -> Self {
        let capacity = capacity.max(1);
        Self {
            keys: vec![Key::EMPTY; capacity],
            cells: vec![Cell::default(); capacity],
            occupied: 0,
        }
    }

    /// Cells that it holds.
    pub fn occupied(&self) -> usize {
        self.occupied
    }

    /// Slots.
    pub fn capacity(&self) -> usize {
        self.keys.len()
    }

    /// Bytes of all slots.
    pub fn bytes(&self) -> usize {
        size_of_val(self.keys.as_slice()) + size_of_val(self.cells.as_slice())
    }

    /// The cell of a key, never that of another.
    pub fn get(&self, key: Key) -> Option<&Cell> {
        self.slot(key).map(|slot| &self.cells[slot])
    }

    fn slot(&self, key: Key) -> Option<usize> {
        self.window(key).find(|slot| self.keys[*slot] == key)
    }

    fn window(&self, key: Key) -> impl Iterator<Item = usize> + use<> {
        let capacity = self.keys.len();
        let first = key.hash() as usize % capacity;
        (0..WINDOW.min(capacity)).map(move |i| (first + i) % capacity)
    }

    /// The slot of a key, a new one where it has none; `None` where its window is full.
    fn slot_for(&mut self, key: Key) -> Option<usize> {
        if let Some(slot) = self.slot(key) {
            return Some(slot);
        }
        let slot = self.window(key).find(|s| self.keys[*s] == Key::EMPTY)?;
        self.keys[slot] = key;
        self.cells[slot] = Cell::default();
        self.occupied += 1;
        Some(slot)
    }

    /// Ages the cells by a frame and merges its samples, all finite, into them. Samples of a cell are added in the
    /// order given; new cells take their slots in the order of their keys.
    pub fn merge(&mut self, mut samples: Vec<Sample>, ages: &Ages) -> Merged {
        let mut merged = Merged {
            evicted: self.age(ages),
            ..Merged::default()
        };
        samples.par_sort_by_key(|sample| sample.key);
        let mut fresh = Vec::new();
        for same in samples.chunk_by(|a, b| a.key == b.key) {
            let count = same.len() as u64;
            let Some(slot) = self.slot_for(same[0].key) else {
                merged.dropped += count;
                continue;
            };
            let cell = &mut self.cells[slot];
            if cell.samples == 0.0 {
                fresh.push(slot);
            }
            cell.add(same);
            merged.samples += count;
            merged.cells += 1;
        }
        if ages.blend {
            for slot in fresh {
                merged.blended += u64::from(self.blend(slot));
            }
        }
        merged
    }

    /// Counts a frame for each cell, and gives up those that got no sample for too long.
    fn age(&mut self, ages: &Ages) -> u64 {
        let mut evicted = 0;
        for (key, cell) in self.keys.iter_mut().zip(&mut self.cells) {
            if *key == Key::EMPTY {
                continue;
            }
            if cell.stale >= ages.stale {
                *key = Key::EMPTY;
                evicted += 1;
                continue;
            }
            cell.stale += 1;
            cell.frames += 1;
            if cell.frames > ages.history {
                cell.samples *= ages.history as f32 / cell.frames as f32;
                cell.frames = ages.history;
            }
        }
        self.occupied -= evicted as usize;
        evicted
    }

    /// Mixes a new cell with what an adjacent level held before this frame: the coarser, or else the finer. Each weighs
    /// by its samples (SHaRC, resolve).
    fn blend(&mut self, slot: usize) -> bool {
        let key = self.keys[slot];
        let held = |key| self.get(key).filter(|cell| cell.frames > 0);
        let adjacent = held(key.parent()).copied().or_else(|| {
            let (mut sum, mut samples) = (Vec3::ZERO, 0.0);
            for child in key.children().filter_map(held) {
                sum += child.mean * child.samples;
                samples += child.samples;
            }
            (samples > 0.0).then(|| Cell::new(sum / samples, samples))
        });
        let Some(adjacent) = adjacent else {
            return false;
        };
        let cell = &mut self.cells[slot];
        let share = adjacent.samples / (adjacent.samples + cell.samples);
        let mix = |own: f32, other: f32| own + (other - own) * share;
        let sum = (cell.mean * cell.samples).lerp(adjacent.mean * adjacent.samples, share);
        cell.samples = mix(cell.samples, adjacent.samples);
        cell.mean = sum / cell.samples;
        true
    }

    /// The cells with their slots, to be stored.
    pub fn stored(&self) -> Vec<(u32, Key, Cell)> {
        let cells = self.keys.iter().zip(&self.cells).enumerate();
        cells
            .filter(|(_, (key, _))| **key != Key::EMPTY)
            .map(|(slot, (key, cell))| (slot as u32, *key, *cell))
            .collect()
    }

    /// An empty table of so many slots filled with what [`Table::stored`] gave.
    ///
    /// # Errors
    /// A sentence, where a cell lies outside of the window of its key or upon another.
    pub fn restored(capacity: usize, stored: &[(u32, Key, Cell)]) -> Result<Self, String> {
        let mut table = Self::new(capacity);
        for (slot, key, cell) in stored {
            let slot = *slot as usize;
            let fits = *key != Key::EMPTY
                && table.window(*key).any(|s| s == slot)
                && table.keys[slot] == Key::EMPTY
                && table.slot(*key).is_none();
            if !fits {
                return Err("what is remembered is not of a table with as many slots".into());
            }
            table.keys[slot] = *key;
            table.cells[slot] = *cell;
        }
        table.occupied = stored.len();
        Ok(table)
    }
}

impl Cell {
    /// A cell of this frame.
    pub fn new(mean: Vec3, samples: f32) -> Self {
        Self {
            mean,
            samples,
            ..Self::default()
        }
    }

    fn add(&mut self, samples: &[Sample]) {
        let before = self.mean.as_dvec3() * f64::from(self.samples);
        let sum = samples
            .iter()
            .fold(before, |sum, s| sum + s.light.as_dvec3());
        self.samples += samples.len() as f32;
        self.mean = (sum / f64::from(self.samples)).as_vec3();
        self.stale = 0;
    }
}
