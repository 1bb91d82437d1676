//! Strata of a map that are split and merged until their importance is balanced and their number is
//! the one asked for.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::blocks::Blocks;
use super::mean_shift::neighbours;
use super::relaxation::{Cells, Item};
use super::texels::{Cluster, Texels};

/// A connected part of the map.
#[derive(Clone, Debug, Default)]
struct Stratum {
    blocks: Vec<u32>,
    energy: f64,
    solid_angle_sr: f64,
    /// Cannot be split: all its light comes from one direction.
    whole: bool,
}

impl Stratum {
    /// Energy · solid angle^¼, the metric of structured importance sampling.
    fn importance(&self) -> f64 {
        self.energy * self.solid_angle_sr.max(0.0).powf(0.25)
    }
}

/// All strata of a map.
pub(super) struct Strata<'a> {
    blocks: &'a Blocks,
    /// Of the blocks; `None` of black ones.
    items: Vec<Option<Item>>,
    strata: Vec<Stratum>,
}

/// A stratum may have this many times its share of the importance.
const EXCESS: f64 = 1.5;
/// Strata of fewer blocks join their most similar neighbour.
const FEWEST_BLOCKS: usize = 8;

impl<'a> Strata<'a> {
    /// From a label for every block.
    pub fn new(texels: &Texels, blocks: &'a Blocks, labels: &[u32]) -> Self {
        let count = labels.iter().max().map_or(0, |&l| l as usize + 1);
        let item = |sums: &Cluster| {
            Some(Item {
                direction: sums.direction(texels)?,
                moment: sums.moment,
            })
        };
        let mut strata = Self {
            blocks,
            items: blocks.sums.par_iter().map(item).collect(),
            strata: vec![Stratum::default(); count],
        };
        for (block, &label) in labels.iter().enumerate() {
            strata.strata[label as usize].blocks.push(block as u32);
        }
        (0..count).for_each(|i| strata.sum(i));
        strata
    }

    fn sum(&mut self, index: usize) {
        let stratum = &mut self.strata[index];
        stratum.energy = 0.0;
        stratum.solid_angle_sr = 0.0;
        for &block in &stratum.blocks {
            stratum.energy += self.blocks.sums[block as usize].energy;
            stratum.solid_angle_sr += self.blocks.solid_angles_sr[block as usize];
        }
    }

    /// Balances to `count` strata, and returns the stratum of every block. Fewer remain when there
    /// is nothing more to split.
    pub fn balanced(mut self, count: usize) -> Vec<u32> {
        self.absorb_small(count);
        let total: f64 = self.strata.iter().map(Stratum::importance).sum();
        let target = total / count.max(1) as f64;
        while let Some(index) = self.largest().filter(|&i| {
            self.strata[i].importance() > EXCESS * target && self.strata.len() < 8 * count + 64
        }) {
            self.split(index);
        }
        self.merge_down(count, target);
        while self.strata.len() < count {
            let Some(index) = self.largest() else { break };
            self.split(index);
        }
        let mut labels = vec![0; self.blocks.sums.len()];
        for (label, stratum) in self.strata.iter().enumerate() {
            for &block in &stratum.blocks {
                labels[block as usize] = label as u32;
            }
        }
        labels
    }

    /// The stratum of most importance among those that can be split.
    fn largest(&self) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for (index, stratum) in self.strata.iter().enumerate().filter(|(_, s)| !s.whole) {
            let importance = stratum.importance();
            if importance > best.map_or(0.0, |b| b.1) {
                best = Some((index, importance));
            }
        }
        best.map(|(index, _)| index)
    }

    /// Halves a stratum by 2-means over directions weighted by energy, or marks it as whole.
    fn split(&mut self, index: usize) {
        let stratum = &self.strata[index];
        let lit: Vec<(u32, Item)> = stratum
            .blocks
            .iter()
            .filter_map(|&block| Some((block, self.items[block as usize]?)))
            .collect();
        let items: Vec<Item> = lit.iter().map(|(_, item)| *item).collect();
        let centres = far_pair(&items);
        let Some(centres) = centres else {
            self.strata[index].whole = true;
            return;
        };
        let mut cells = Cells::new(&items, centres.to_vec());
        cells.relax(20, 0.0);
        let mut parts = [Stratum::default(), Stratum::default()];
        let mut next = 0;
        for &block in &stratum.blocks {
            let is_lit = lit.get(next).is_some_and(|(b, _)| *b == block);
            // Black blocks go with the part of the lit one before them.
            let label = cells.labels[next.min(lit.len() - 1)];
            next += usize::from(is_lit);
            parts[label as usize].blocks.push(block);
        }
        if parts.iter().any(|p| p.blocks.is_empty()) {
            self.strata[index].whole = true;
            return;
        }
        let [first, second] = parts;
        self.strata[index] = first;
        self.strata.push(second);
        self.sum(index);
        self.sum(self.strata.len() - 1);
    }

    /// Merges strata of few blocks into the neighbour of the most similar luminance, unless they are
    /// important.
    fn absorb_small(&mut self, count: usize) {
        let total: f64 = self.strata.iter().map(Stratum::importance).sum();
        let target = total / count.max(1) as f64;
        let mut merging = Merging::new(self);
        for index in 0..self.strata.len() {
            let stratum = &self.strata[index];
            let small = (1..FEWEST_BLOCKS).contains(&stratum.blocks.len());
            if !small || stratum.importance() > target {
                continue;
            }
            let luminance = |s: &Stratum| s.energy / s.solid_angle_sr;
            let own = luminance(stratum);
            let difference = |other: &usize| (luminance(&self.strata[*other]) - own).abs();
            let similar = merging.adjacent[index]
                .iter()
                .copied()
                .min_by(|a, b| difference(a).total_cmp(&difference(b)));
            if let Some(other) = similar {
                merging.merge(self, other, index);
            }
        }
        self.strata.retain(|s| !s.blocks.is_empty());
    }

    /// Merges adjacent strata until `count` are left: pairs that stay within their share first, and
    /// of those the pair of least importance.
    fn merge_down(&mut self, count: usize, target: f64) {
        let mut merging = Merging::new(self);
        let mut left = self.strata.len();
        while left > count {
            let mut best: Option<((bool, f64), (usize, usize))> = None;
            for (a, adjacent) in merging.adjacent.iter().enumerate() {
                for &b in adjacent.range(a + 1..) {
                    let [x, y] = [&self.strata[a], &self.strata[b]];
                    let merged =
                        (x.energy + y.energy) * (x.solid_angle_sr + y.solid_angle_sr).powf(0.25);
                    let rank = (merged > EXCESS * target, x.importance() + y.importance());
                    if best.is_none_or(|(known, _)| rank < known) {
                        best = Some((rank, (a, b)));
                    }
                }
            }
            let Some((_, (a, b))) = best else { break };
            merging.merge(self, a, b);
            left -= 1;
        }
        self.strata.retain(|s| !s.blocks.is_empty());
    }
}

/// Which strata are adjacent, kept while they merge.
struct Merging {
    adjacent: Vec<BTreeSet<usize>>,
}

impl Merging {
    fn new(strata: &Strata) -> Self {
        let blocks = strata.blocks;
        let mut labels = vec![0; blocks.sums.len()];
        for (label, stratum) in strata.strata.iter().enumerate() {
            for &block in &stratum.blocks {
                labels[block as usize] = label;
            }
        }
        let mut adjacent = vec![BTreeSet::new(); strata.strata.len()];
        for (a, b) in neighbours(blocks.width, blocks.height) {
            let (a, b) = (labels[a], labels[b]);
            if a != b {
                adjacent[a].insert(b);
                adjacent[b].insert(a);
            }
        }
        Self { adjacent }
    }

    /// `gone` becomes part of `kept`.
    fn merge(&mut self, strata: &mut Strata, kept: usize, gone: usize) {
        let removed = std::mem::take(&mut strata.strata[gone]);
        let stratum = &mut strata.strata[kept];
        stratum.blocks.extend(removed.blocks);
        stratum.blocks.sort_unstable();
        stratum.energy += removed.energy;
        stratum.solid_angle_sr += removed.solid_angle_sr;
        stratum.whole = false;
        for other in std::mem::take(&mut self.adjacent[gone]) {
            self.adjacent[other].remove(&gone);
            if other != kept {
                self.adjacent[other].insert(kept);
                self.adjacent[kept].insert(other);
            }
        }
    }
}

/// Two items far apart; `None` when all have the same direction.
fn far_pair(items: &[Item]) -> Option<[glam::DVec3; 2]> {
    let farthest = |from: glam::DVec3| {
        // Of equally far ones the last, whatever threads there are.
        let places = items.par_iter().with_min_len(1024).enumerate();
        let all = places.map(|(place, item)| ((item.direction - from).length_squared(), place));
        let farther = |a: (f64, usize), b: (f64, usize)| {
            let order = a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            if order.is_gt() { a } else { b }
        };
        let (_, place) = all.reduce_with(farther)?;
        Some(items[place].direction)
    };
    let first = farthest(items.first()?.direction)?;
    let second = farthest(first)?;
    ((second - first).length() > 1e-9).then_some([first, second])
}
