//! The search for σ_s: which spatial splits are made so that the angular ones meet the budget.

use std::ops::Range;

use rayon::prelude::*;

use super::cones::Cones;
use super::hierarchy::{Hierarchy, Split};
use super::members::{Bounds, Member, POSITION, halve, partition};

/// Fewest nodes whose angular clusters are counted together.
const BATCH: usize = 256;

/// A cut through the spatial hierarchy.
pub(super) struct Cut {
    /// Spatial clusters, by first member.
    pub nodes: Vec<u32>,
    /// Whether the normals of each spatial cluster are within one cone.
    whole: Vec<bool>,
    /// Clusters after the angular splits.
    pub clusters: usize,
    /// σ_s: the size of the last node that was split, scene units at the nearest depth. A cut of
    /// one node has its size.
    pub size: f32,
}

impl Cut {
    /// The cut with the most splits that has at most `count` clusters, or that of the root alone,
    /// with more, if no cut has so few.
    ///
    /// Splitting the j largest nodes is the cut at the size of the j-th, so σ_s is found among the
    /// sizes themselves: starting from as many spatial clusters as wanted, the smallest splits are
    /// undone until the angular ones fit. The angular count of a node does not depend on σ_s and is
    /// computed once, in parallel, and only for nodes that a cut comes to.
    ///
    /// *differs:* from the paper's binary search only in being exact.
    pub fn find<F: Fn(&[Member]) -> Split + Sync>(
        tree: &Hierarchy<F>,
        cones: Cones,
        count: usize,
    ) -> Self {
        let order = tree.largest_first(count - 1);
        let mut opened = vec![false; tree.nodes.len()];
        order.iter().for_each(|&i| opened[i as usize] = true);
        let mut counts = AngularCounts {
            tree,
            cones,
            known: vec![0; tree.nodes.len()],
            limit: u32::try_from(count).unwrap_or(u32::MAX).saturating_add(1),
        };
        let leaves = tree.cut(|i| opened[i as usize]);
        counts.learn(&leaves);
        let mut clusters: usize = leaves.iter().map(|&i| counts.of(i)).sum();
        let mut splits = order.len();
        let mut learned = splits;
        while clusters > count && splits > 0 {
            if splits == learned {
                learned = splits.saturating_sub((clusters - count).max(BATCH));
                counts.learn(&order[learned..splits]);
            }
            splits -= 1;
            let node = order[splits];
            let children = tree.nodes[node as usize].children;
            clusters = clusters + counts.of(node) - counts.of(children) - counts.of(children + 1);
            opened[node as usize] = false;
        }
        let nodes = tree.cut(|i| opened[i as usize]);
        Self {
            whole: nodes.iter().map(|&i| counts.of(i) == 1).collect(),
            nodes,
            clusters,
            size: tree.nodes[order[..splits].last().map_or(0, |&i| i as usize)].size,
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
        for (&node, &whole) in self.nodes.iter().zip(&self.whole) {
            let (own, tail) = rest.split_at_mut(tree.nodes[node as usize].len());
            let offset = start;
            start += own.len();
            tasks.push((offset, own, whole));
            rest = tail;
        }
        let split = |(offset, own, whole): (usize, &mut [Member], bool)| {
            let mut ranges = Vec::with_capacity(1);
            if whole {
                ranges.push(offset..offset + own.len());
                return ranges;
            }
            cones.split(own, offset, &mut |range| {
                ranges.push(range);
                true
            });
            ranges
        };
        tasks.into_par_iter().flat_map_iter(split).collect()
    }
}

/// How many clusters the angular splits make of each spatial cluster.
struct AngularCounts<'a, F> {
    tree: &'a Hierarchy<F>,
    cones: Cones,
    /// 0 where it is not known yet.
    known: Vec<u32>,
    /// Counting stops here.
    limit: u32,
}

impl<F: Fn(&[Member]) -> Split + Sync> AngularCounts<'_, F> {
    fn of(&self, node: u32) -> usize {
        self.known[node as usize] as usize
    }

    fn learn(&mut self, nodes: &[u32]) {
        let count = |scratch: &mut Vec<Member>, &i: &u32| {
            let members = &self.tree.members[self.tree.nodes[i as usize].range()];
            self.cones.count(members, self.limit, scratch)
        };
        let counts: Vec<u32> = nodes.par_iter().map_init(Vec::new, count).collect();
        for (&i, count) in nodes.iter().zip(counts) {
            self.known[i as usize] = count;
        }
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
            let axis = bounds.widest(&POSITION);
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
