//! Differences of pairs of records, each computed once.

use rayon::prelude::*;

use super::Refinable;

/// Pixels that share one table of pairs.
const CHUNK: usize = 1 << 14;
const EMPTY: u64 = u64::MAX;

/// The K nearest records of a pixel in ascending order of record, `u32::MAX` beyond their number.
pub(super) type Nearest<'a> = &'a [u32];

/// Mean and largest difference between all pairs of a pixel's nearest records.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spread {
    pub mean: f32,
    pub largest: f32,
}

/// The spread of each pixel. `nearest` holds `stride` records for each pixel.
///
/// Neighbouring pixels share most of their pairs: each chunk collects its own distinct pairs, the
/// chunks' lists are merged, every pair of the whole image is compared once, and the chunks read
/// the results back.
pub(super) fn spreads(input: &Refinable, nearest: &[u32], stride: usize) -> (Vec<Spread>, usize) {
    let chunks: Vec<Nearest> = nearest.chunks(CHUNK * stride).collect();
    let mut tables: Vec<Table> = chunks
        .par_iter()
        .map(|chunk| {
            let mut table = Table::new();
            each_new_set(chunk, stride, |_, set| {
                each_pair(set, |pair| table.enter(pair));
            });
            table
        })
        .collect();
    let mut pairs: Vec<u64> = tables.iter().flat_map(Table::pairs).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    let values: Vec<f32> = pairs
        .par_iter()
        .map(|&pair| input.records.difference((pair >> 32) as u32, pair as u32))
        .collect();
    let spreads = tables
        .par_iter_mut()
        .zip(&chunks)
        .flat_map_iter(|(table, chunk)| {
            table.fill(&pairs, &values);
            read_back(table, chunk, stride)
        })
        .collect();
    (spreads, pairs.len())
}

fn read_back(table: &Table, chunk: Nearest, stride: usize) -> Vec<Spread> {
    let mut spreads = vec![Spread::default(); chunk.len() / stride];
    each_new_set(chunk, stride, |pixels, set| {
        let (mut sum, mut largest, mut count) = (0.0f64, 0.0f32, 0u32);
        each_pair(set, |pair| {
            let value = table.values[table.find(pair)];
            sum += f64::from(value);
            largest = largest.max(value);
            count += 1;
        });
        let mean = (sum / f64::from(count.max(1))) as f32;
        spreads[pixels].fill(Spread { mean, largest });
    });
    spreads
}

/// Calls `found` with each run of pixels that have the same records.
fn each_new_set(
    chunk: Nearest,
    stride: usize,
    mut found: impl FnMut(std::ops::Range<usize>, &[u32]),
) {
    let pixels = chunk.len() / stride;
    let set = |i: usize| &chunk[i * stride..(i + 1) * stride];
    let mut start = 0;
    while start < pixels {
        let end = (start + 1..pixels)
            .find(|&i| set(i) != set(start))
            .unwrap_or(pixels);
        found(start..end, set(start));
        start = end;
    }
}

fn each_pair(set: &[u32], mut found: impl FnMut(u64)) {
    let set = &set[..set.iter().position(|&r| r == u32::MAX).unwrap_or(set.len())];
    for (i, &a) in set.iter().enumerate() {
        for &b in &set[i + 1..] {
            found(u64::from(a) << 32 | u64::from(b));
        }
    }
}

/// An open-addressing table from pairs to differences.
struct Table {
    keys: Vec<u64>,
    values: Vec<f32>,
    used: usize,
}

impl Table {
    fn new() -> Self {
        Self {
            keys: vec![EMPTY; 1 << 10],
            values: Vec::new(),
            used: 0,
        }
    }

    fn enter(&mut self, pair: u64) {
        if 2 * self.used >= self.keys.len() {
            self.grow();
        }
        let slot = self.find(pair);
        if self.keys[slot] == EMPTY {
            self.keys[slot] = pair;
            self.used += 1;
        }
    }

    /// Where `pair` is, or the empty place for it.
    fn find(&self, pair: u64) -> usize {
        let mask = self.keys.len() - 1;
        let mixed = pair.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut slot = (mixed >> 32) as usize & mask;
        while self.keys[slot] != EMPTY && self.keys[slot] != pair {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self) {
        let old = std::mem::take(&mut self.keys);
        self.keys = vec![EMPTY; 2 * old.len()];
        for pair in old.into_iter().filter(|&pair| pair != EMPTY) {
            let slot = self.find(pair);
            self.keys[slot] = pair;
        }
    }

    fn pairs(&self) -> impl Iterator<Item = u64> + '_ {
        self.keys.iter().copied().filter(|&pair| pair != EMPTY)
    }

    /// Looks up the differences of all pairs of the table in the sorted list. The table's own pairs are
    /// looked up in order, so that each is found a little after the one before.
    fn fill(&mut self, pairs: &[u64], values: &[f32]) {
        self.values = vec![0.0; self.keys.len()];
        let slots = 0..self.keys.len() as u32;
        let mut slots: Vec<u32> = slots
            .filter(|&slot| self.keys[slot as usize] != EMPTY)
            .collect();
        slots.sort_unstable_by_key(|&slot| self.keys[slot as usize]);
        let mut at = 0;
        for slot in slots.into_iter().map(|slot| slot as usize) {
            let mut step = 1;
            while at + step < pairs.len() && pairs[at + step] < self.keys[slot] {
                step *= 2;
            }
            let end = (at + step + 1).min(pairs.len());
            at += pairs[at..end].partition_point(|&pair| pair < self.keys[slot]);
            self.values[slot] = values[at];
        }
    }
}
