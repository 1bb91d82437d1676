//! The search for σ_s: which spatial splits are made so that the angular ones meet the budget.

use std::ops::Range;

use rayon::prelude::*;

use super::cones::Cones;
use super::hierarchy::{Hierarchy, Split};
use super::members::{Bounds, Member, halve, partition};

/// A cut through the spatial hierarchy.
pub(super) struct Cut {
    /// Spatial clusters, by first member.
    pub nodes: Vec<u32>,
    /// Clusters after the angular splits.
    pub clusters: usize,
    /// σ_s: the size of the last node that was split, scene units at the nearest depth. A cut of
    /// one node has its size.
    pub size: f32,
}

impl Cut {
    /// The cut with the most clusters that has at most `count`, or that of the root alone, with
    /// more, if no cut has so few.
    ///
    /// Splitting the j largest nodes is the cut at the size of the j-th. Bisects j; the angular
    /// count of a node does not depend on j, so it is computed once, for all nodes a step needs in
    /// parallel. Counts are monotone in j up to the angular splits' own jumps.
    pub fn find<F: Fn(&[Member]) -> Split + Sync>(
        tree: &Hierarchy<F>,
        cones: Cones,
        count: usize,
    ) -> Self {
        let order = tree.largest_first(count - 1);
        let mut search = Search {
            tree,
            cones,
            angular: vec![0; tree.nodes.len()],
            rank: vec![u32::MAX; tree.nodes.len()],
            limit: u32::try_from(count).unwrap_or(u32::MAX).saturating_add(1),
        };
        for (rank, &node) in order.iter().enumerate() {
            search.rank[node as usize] = rank as u32;
        }
        let splits = search.bisect(order.len(), count);
        let nodes = search.leaves(splits);
        Self {
            clusters: search.total(splits),
            size: tree.nodes[order[..splits].last().map_or(0, |&i| i as usize)].size,
            nodes,
        }
    }

    /// Makes the angular splits and returns the clusters as ranges of the tree's members, which
    /// are reordered: nodes below the cut are no longer valid.
    pub fn clusters_of<F: Sync>(
        &self,
        tree: &mut Hierarchy<F>,
        cones: &Cones,
    ) -> Vec<Range<usize>> {
        let mut tasks = Vec::with_capacity(self.nodes.len());
        let mut rest = &mut tree.members[..];
        let mut start = 0;
        for &node in &self.nodes {
            let (own, tail) = rest.split_at_mut(tree.nodes[node as usize].len());
            let offset = start;
            start += own.len();
            tasks.push((offset, own));
            rest = tail;
        }
        let split = |(offset, own): (usize, &mut [Member])| {
            let mut ranges = Vec::new();
            cones.split(own, offset, &mut |range| {
                ranges.push(range);
                true
            });
            ranges
        };
        tasks.into_par_iter().flat_map_iter(split).collect()
    }
}

struct Search<'a, F> {
    tree: &'a Hierarchy<F>,
    cones: Cones,
    /// Angular clusters of each node, 0 where they are not known yet.
    angular: Vec<u32>,
    /// Position of each node among the splits.
    rank: Vec<u32>,
    /// Counting stops here.
    limit: u32,
}

impl<F: Fn(&[Member]) -> Split + Sync> Search<'_, F> {
    fn leaves(&self, splits: usize) -> Vec<u32> {
        self.tree.cut(|i| (self.rank[i as usize] as usize) < splits)
    }

    /// Clusters when the largest `splits` nodes are split.
    fn total(&mut self, splits: usize) -> usize {
        let leaves = self.leaves(splits);
        let unknown: Vec<u32> = leaves
            .iter()
            .copied()
            .filter(|&i| self.angular[i as usize] == 0)
            .collect();
        let count = |scratch: &mut Vec<Member>, &i: &u32| {
            let members = &self.tree.members[self.tree.nodes[i as usize].range()];
            self.cones.count(members, self.limit, scratch)
        };
        let counts: Vec<u32> = unknown.par_iter().map_init(Vec::new, count).collect();
        for (i, count) in unknown.into_iter().zip(counts) {
            self.angular[i as usize] = count;
        }
        leaves
            .iter()
            .map(|&i| self.angular[i as usize] as usize)
            .sum()
    }

    /// The largest number of splits with at most `count` clusters; 0 if there is none.
    fn bisect(&mut self, most: usize, count: usize) -> usize {
        let (mut low, mut high) = (most, most + 1);
        loop {
            let total = self.total(low);
            if total <= count || low == 0 {
                break;
            }
            // The first guesses fall in proportion to the excess, so that the large clusters,
            // whose normals are costly to count, are hardly ever looked at.
            high = low;
            let share = (count as f64 / total as f64).powf(1.1).clamp(0.3, 0.97);
            low = (low as f64 * share) as usize;
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.total(middle) <= count {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// Splits the clusters with the most members in two until there are `count` clusters or all have
/// one member.
pub(super) fn split_largest(
    members: &mut [Member],
    clusters: &mut Vec<Range<usize>>,
    count: usize,
) {
    while clusters.len() < count {
        let missing = count - clusters.len();
        let mut order: Vec<usize> = (0..clusters.len())
            .filter(|&i| clusters[i].len() > 1)
            .collect();
        if order.is_empty() {
            return;
        }
        order.sort_by_key(|&i| (std::cmp::Reverse(clusters[i].len()), clusters[i].start));
        for &i in order.iter().take(missing) {
            let range = clusters[i].clone();
            let own = &mut members[range.clone()];
            let bounds = Bounds::around(own);
            let axis = bounds.widest(0..3);
            let middle = if bounds.extent(axis) > 0.0 {
                partition(own, axis, bounds.middle(axis))
            } else {
                halve(own, axis)
            };
            clusters[i] = range.start..range.start + middle;
            clusters.push(range.start + middle..range.end);
        }
    }
}
