//! Merging a frame's samples into the cells of every level.
//!
//! As in section 3.2: samples are sorted by cell, those of a cell and side are summed, and the sums are merged with what the cells held.
//! The level above takes the sums of the level below, so that each level sees every sample. What is summed in which order depends
//! on the samples alone, and not on the number of threads.

use glam::Vec3;
use rayon::prelude::*;

use super::cell::{Cell, Precision, Sum, pack_normal, side_of, unpack_normal};
use super::levels::HashCells;

/// Light that arrived at a surface point.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Scene units.
    pub position: Vec3,
    /// Unit geometric normal on the side at which the light arrives.
    pub normal: Vec3,
    /// Diffuse illumination, not multiplied with the albedo.
    pub value: Vec3,
}

/// What became of a frame's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Update {
    /// Samples merged.
    pub stored: u64,
    /// Samples without a cell.
    pub dropped: u64,
    /// Samples of which the position, the normal or the value was not finite.
    pub non_finite: u64,
    /// Cells written, on all levels.
    pub cells: u64,
}

/// Marks of samples that are not stored; no cell has an index that large.
const NO_CELL: u64 = (u32::MAX as u64) << 32;
const NON_FINITE: u64 = u64::MAX;

/// Cells merged by one thread at a time.
const TOGETHER: usize = 4096;

/// What is new in a cell.
struct Fresh {
    key: u64,
    index: u32,
    /// The cell's packed normal, old or new.
    normal: u32,
    /// Of the front and the back.
    sides: [Sum; 2],
}

impl Update {
    /// Memory that merging takes for each sample, if every one has a cell of its own.
    pub const BYTES_PER_SAMPLE: usize = size_of::<Sample>() + size_of::<u64>() + size_of::<Fresh>();
}

impl HashCells {
    /// Merges samples into every level. Ties are summed in the order of `samples`; the result is the same for any number of threads.
    ///
    /// # Panics
    ///
    /// If there are 2³² samples or more.
    pub fn update(&mut self, samples: Vec<Sample>) -> Update {
        assert!(samples.len() < u32::MAX as usize, "ordinals have 32 bits");
        let mut order: Vec<u64> = samples
            .par_iter()
            .zip(0u32..samples.len() as u32)
            .map(|(sample, ordinal)| self.place(sample, ordinal))
            .collect();
        // Indices ascend with keys: the same order as by keys, in one word.
        order.par_sort_unstable();
        let stored = order.partition_point(|&place| place < NO_CELL);
        let finite = order.partition_point(|&place| place < NON_FINITE);
        let mut update = Update {
            stored: stored as u64,
            dropped: (finite - stored) as u64,
            non_finite: (order.len() - finite) as u64,
            cells: 0,
        };
        order.truncate(stored);
        let finest = self.grid.levels();
        let mut fresh = reduce(
            &order,
            |a, b| a >> 32 == b >> 32,
            |run| self.sum_samples(run, &samples),
        );
        drop(order);
        drop(samples);
        for level in (0..=finest).rev() {
            update.cells += fresh.len() as u64;
            self.merge(level, &fresh);
            if level > 0 {
                fresh = reduce(
                    &fresh,
                    |a, b| a.key >> 3 == b.key >> 3,
                    |run| self.sum_cells(level - 1, run),
                );
            }
        }
        update
    }

    /// Index of a sample's cell, then its ordinal; or a mark.
    fn place(&self, sample: &Sample, ordinal: u32) -> u64 {
        let vectors = [sample.position, sample.normal, sample.value];
        if !vectors.iter().all(|vector| vector.is_finite()) {
            return NON_FINITE;
        }
        match self.find(self.grid.levels(), sample.position) {
            Some(index) => u64::from(index) << 32 | u64::from(ordinal),
            None => NO_CELL,
        }
    }

    /// The packed normal of a cell, if it has samples.
    fn normal(&self, level: u32, index: u32) -> Option<u32> {
        let cell = self.cell(level, index);
        cell.has_samples().then_some(cell.normal)
    }

    /// The samples of one cell of the finest level.
    fn sum_samples(&self, places: &[u64], samples: &[Sample]) -> Fresh {
        let sample = |place: &u64| &samples[*place as u32 as usize];
        let first = sample(&places[0]);
        let index = (places[0] >> 32) as u32;
        let level = self.grid.levels();
        let normal = self
            .normal(level, index)
            .unwrap_or_else(|| pack_normal(first.normal));
        let front = unpack_normal(normal);
        let mut sides = [Sum::default(); 2];
        for sample in places.iter().map(sample) {
            sides[side_of(front, sample.normal)].add(Sum {
                total: sample.value.as_dvec3(),
                samples: 1,
            });
        }
        Fresh {
            key: self.grid.key(first.position).expect("it has a cell"),
            index,
            normal,
            sides,
        }
    }

    /// What is new in a cell of a level: the sums of the cells within it.
    fn sum_cells(&self, level: u32, children: &[Fresh]) -> Fresh {
        let key = children[0].key >> 3;
        let index = self.levels[level as usize].map.find(key);
        let index = index.expect("every level has the cells around those below");
        let normal = self.normal(level, index).unwrap_or(children[0].normal);
        let front = unpack_normal(normal);
        let mut sides = [Sum::default(); 2];
        for child in children {
            let turned = side_of(front, unpack_normal(child.normal));
            for (side, sum) in child.sides.iter().enumerate() {
                sides[side ^ turned].add(*sum);
            }
        }
        Fresh {
            key,
            index,
            normal,
            sides,
        }
    }

    fn merge(&mut self, level: u32, fresh: &[Fresh]) {
        let (precision, stamp) = (self.precision, self.stamp);
        let mut rest = self.levels[level as usize].words.as_mut_slice();
        let mut before = 0;
        let mut parts = Vec::with_capacity(fresh.len().div_ceil(TOGETHER));
        for group in fresh.chunks(TOGETHER) {
            let first = group[0].index as usize;
            let end = group[group.len() - 1].index as usize + 1;
            let _untouched = rest.split_off_mut(..(first - before) * precision.words());
            let part = rest.split_off_mut(..(end - first) * precision.words());
            parts.push((group, part.expect("indices ascend")));
            before = end;
        }
        parts.into_par_iter().for_each(|(group, words)| {
            merge_into(words, group, precision, stamp);
        });
    }
}

/// What `sum` makes of each run of items that belong together.
fn reduce<T: Sync>(
    items: &[T],
    together: impl Fn(&T, &T) -> bool + Sync,
    sum: impl Fn(&[T]) -> Fresh + Sync,
) -> Vec<Fresh> {
    let starts: Vec<usize> = (0..items.len())
        .into_par_iter()
        .filter(|&i| i == 0 || !together(&items[i - 1], &items[i]))
        .collect();
    let mut sums = Vec::new();
    (0..starts.len())
        .into_par_iter()
        .map(|i| sum(&items[starts[i]..starts.get(i + 1).copied().unwrap_or(items.len())]))
        .collect_into_vec(&mut sums);
    sums
}

/// Merges what is new into the cells from the first of the group to its last.
fn merge_into(words: &mut [u32], group: &[Fresh], precision: Precision, stamp: u32) {
    let first = group[0].index;
    for fresh in group {
        let start = (fresh.index - first) as usize * precision.words();
        let words = &mut words[start..start + precision.words()];
        let mut cell = precision.unpack(words);
        if cell.stamp != stamp {
            cell = Cell {
                stamp,
                ..Cell::default()
            };
        }
        cell.normal = fresh.normal;
        for (side, sum) in cell.sides.iter_mut().zip(&fresh.sides) {
            precision.merge(side, sum);
        }
        precision.pack(&cell, words);
    }
}
