//! Differences of pairs of records, each computed once.

use std::ops::Range;

use rayon::prelude::*;

use super::Refinable;

/// Pixels that share one table of pairs.
const CHUNK: usize = 1 << 14;
/// Shares of the pairs that are compared by themselves.
const SHARES: u64 = 256;
const EMPTY: u64 = u64::MAX;

/// The K nearest records of a pixel in ascending order of record, `u32::MAX` beyond their number.
pub(super) type Nearest<'a> = &'a [u32];

/// Differences between all pairs of each pixel's nearest records.
pub(super) struct Spreads {
    /// The mean of each pixel.
    pub mean: Vec<f32>,
    /// The largest of each pixel.
    pub largest: Vec<f32>,
    /// Pairs of the whole image that were compared.
    pub pairs: usize,
}

/// The spreads of all pixels. `nearest` holds `stride` records for each pixel.
///
/// Neighbouring pixels share most of their pairs: each chunk of pixels collects its own distinct pairs, every pair of
/// the whole image is compared once, and the chunks read the results back. The pairs are compared in shares by their
/// first record, so that no thread has to hold them all.
pub(super) fn spreads(input: &Refinable, nearest: &[u32], stride: usize) -> Spreads {
    let chunks = nearest.par_chunks(CHUNK * stride);
    let mut tables: Vec<Table> = chunks
        .clone()
        .map(|chunk| Table::of(chunk, stride))
        .collect();
    let records = input.sites.len() as u64;
    let share = |share: u64| {
        let begin = |share: u64| (share * records / SHARES) << 32;
        Compared::new(input, &tables, begin(share)..begin(share + 1))
    };
    let shares: Vec<Compared> = (0..SHARES).into_par_iter().map(share).collect();
    let pixels = nearest.len() / stride;
    let (mut mean, mut largest) = (vec![0.0; pixels], vec![0.0; pixels]);
    tables
        .par_iter_mut()
        .zip(chunks)
        .zip(mean.par_chunks_mut(CHUNK))
        .zip(largest.par_chunks_mut(CHUNK))
        .for_each(|(((table, chunk), mean), largest)| {
            table.fill(&shares);
            each_new_set(chunk, stride, |pixels, set| {
                let spread = table.spread(set);
                mean[pixels.clone()].fill(spread.0);
                largest[pixels].fill(spread.1);
            });
        });
    let pairs = shares.iter().map(|share| share.pairs.len()).sum();
    Spreads {
        mean,
        largest,
        pairs,
    }
}

/// The distinct pairs of a share, ascending, and their differences.
struct Compared {
    pairs: Vec<u64>,
    values: Vec<f32>,
}

impl Compared {
    /// Those of all tables that lie in the range.
    fn new(input: &Refinable, tables: &[Table], range: Range<u64>) -> Self {
        let place = |table: &Table, pair: u64| table.pairs.partition_point(|&p| p < pair);
        let mut pairs = Vec::new();
        for table in tables {
            let own = place(table, range.start)..place(table, range.end);
            pairs.extend_from_slice(&table.pairs[own]);
        }
        pairs.sort_unstable();
        pairs.dedup();
        let difference = |&pair: &u64| input.records.difference((pair >> 32) as u32, pair as u32);
        let values = pairs.iter().map(difference).collect();
        Self { pairs, values }
    }
}

/// Calls `found` with each run of pixels that have the same records.
fn each_new_set(chunk: Nearest, stride: usize, mut found: impl FnMut(Range<usize>, &[u32])) {
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
    /// The keys, ascending.
    pairs: Vec<u64>,
}

impl Table {
    /// The distinct pairs of a chunk of pixels.
    fn of(chunk: Nearest, stride: usize) -> Self {
        let mut table = Self {
            keys: vec![EMPTY; 1 << 10],
            values: Vec::new(),
            pairs: Vec::new(),
        };
        each_new_set(chunk, stride, |_, set| {
            each_pair(set, |pair| table.enter(pair));
        });
        table.pairs.sort_unstable();
        table
    }

    fn enter(&mut self, pair: u64) {
        if 2 * self.pairs.len() >= self.keys.len() {
            self.grow();
        }
        let slot = self.find(pair);
        if self.keys[slot] == EMPTY {
            self.keys[slot] = pair;
            self.pairs.push(pair);
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
        self.keys = vec![EMPTY; 2 * self.keys.len()];
        for i in 0..self.pairs.len() {
            let slot = self.find(self.pairs[i]);
            self.keys[slot] = self.pairs[i];
        }
    }

    /// Mean and largest difference between all pairs of a set.
    fn spread(&self, set: &[u32]) -> (f32, f32) {
        let (mut sum, mut largest, mut count) = (0.0f64, 0.0f32, 0u32);
        each_pair(set, |pair| {
            let value = self.values[self.find(pair)];
            sum += f64::from(value);
            largest = largest.max(value);
            count += 1;
        });
        ((sum / f64::from(count.max(1))) as f32, largest)
    }

    /// Looks up the differences of all pairs of the table. Both it and the shares are in ascending order, so that each
    /// is found a little after the one before.
    fn fill(&mut self, shares: &[Compared]) {
        self.values = vec![0.0; self.keys.len()];
        let mut begin = 0;
        for Compared { pairs, values } in shares {
            let Some(&last) = pairs.last() else { continue };
            let mut at = 0;
            while begin < self.pairs.len() && self.pairs[begin] <= last {
                let pair = self.pairs[begin];
                let mut step = 1;
                while at + step < pairs.len() && pairs[at + step] < pair {
                    step *= 2;
                }
                let end = (at + step + 1).min(pairs.len());
                at += pairs[at..end].partition_point(|&other| other < pair);
                let slot = self.find(pair);
                self.values[slot] = values[at];
                begin += 1;
            }
        }
    }
}
