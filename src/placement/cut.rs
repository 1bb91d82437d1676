//! The search for σ_s: which spatial splits are made so that the angular ones meet the budget.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::cones::Cones;
use super::hierarchy::{Hierarchy, Measure};
use super::members::{Bounds, Member, POSITION, Spot, complete};
use super::partition::{halve, partition};
use super::representative::{Average, nearest_to_average};
use super::share::shares;
use crate::cache::{NO_POINT, ShadingPoints};
use crate::memory::concatenated;

/// Fewest nodes whose angular clusters are counted together, and nodes that one thread splits.
const BATCH: usize = 256;
/// Nodes whose normals are fetched together: many fetches wait at once.
const GROUP: usize = 32;

/// How spatial clusters become records.
#[derive(Clone, Copy)]
pub(super) struct Angular<'a> {
    pub points: &'a ShadingPoints,
    pub cones: Cones,
    pub average: Average,
    pub seed: u64,
}

impl Angular<'_> {
    /// The record of a cluster.
    pub fn record(&self, members: &[Member]) -> u32 {
        nearest_to_average(members, self.average, self.seed)
    }
}

/// A cluster after the angular splits.
#[derive(Clone)]
pub(super) struct Cluster {
    /// Its members in the tree.
    pub range: Range<usize>,
    /// Its record, if that was chosen already.
    pub record: Option<u32>,
}

/// A cut through the spatial hierarchy.
pub(super) struct Cut {
    /// Spatial clusters, by first member.
    pub nodes: Vec<u32>,
    /// Their records, of those whose normals are within one cone.
    records: Vec<Option<u32>>,
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
    pub fn find<F: Measure<Member = Spot>>(
        tree: &Hierarchy<F>,
        angular: Angular,
        count: usize,
    ) -> Self {
        let order = tree.largest_first(count - 1);
        let counts = AngularCounts {
            tree,
            angular,
            known: Known::nothing(tree.nodes.len()),
            limit: u32::try_from(count).unwrap_or(u32::MAX).saturating_add(1),
        };
        let leaves = tree.cut(&order);
        counts.learn(&leaves);
        let mut clusters: usize = leaves.par_iter().map(|&i| counts.of(i)).sum();
        let mut splits = order.len();
        while clusters > count && splits > 0 {
            let first = splits.saturating_sub((clusters - count).max(BATCH));
            counts.learn(&order[first..splits]);
            // How many clusters undoing each of the splits leaves instead of how many.
            let changes: Vec<[usize; 2]> = order[first..splits]
                .par_iter()
                .map(|&node| {
                    let children = tree.nodes[node as usize].children;
                    let split = counts.of(children) + counts.of(children + 1);
                    [counts.of(node), split]
                })
                .collect();
            for [whole, split] in changes.into_iter().rev() {
                clusters = clusters + whole - split;
                splits -= 1;
                if clusters <= count {
                    break;
                }
            }
        }
        let nodes = tree.cut(&order[..splits]);
        Self {
            records: nodes.par_iter().map(|&i| counts.record(i)).collect(),
            nodes,
            clusters,
            size: tree.nodes[order[..splits].last().map_or(0, |&i| i as usize)].size,
        }
    }

    /// Makes the angular splits and returns the clusters; the tree's members are reordered: nodes
    /// below the cut are no longer valid.
    pub fn clusters_of<F: Measure<Member = Spot>>(
        &self,
        tree: &mut Hierarchy<F>,
        angular: Angular,
    ) -> Vec<Cluster> {
        let nodes = &tree.nodes;
        let range = |node: u32| nodes[node as usize].range();
        let split = |node: u32, own: &mut [Spot], clusters: &mut Vec<Cluster>| {
            let mut members = Vec::with_capacity(own.len());
            complete(angular.points, own, &mut members);
            let (first, offset) = (clusters.len(), range(node).start);
            angular.cones.split(&mut members, 0, &mut |range| {
                let record = None;
                clusters.push(Cluster { range, record });
                true
            });
            for cluster in &mut clusters[first..] {
                let Range { start, end } = cluster.range.clone();
                cluster.record = Some(angular.record(&members[start..end]));
                cluster.range = offset + start..offset + end;
            }
            for (spot, member) in own.iter_mut().zip(&members) {
                *spot = member.spot();
            }
        };
        let shares = shares(&mut tree.members, &self.nodes, BATCH, |&node| range(node));
        let clusters = shares
            .into_par_iter()
            .zip(self.records.par_chunks(BATCH))
            .map(|(mut share, records)| {
                let mut clusters = Vec::with_capacity(records.len());
                for (&node, &record) in share.parts.iter().zip(records) {
                    let range = range(node);
                    match record {
                        Some(_) => clusters.push(Cluster { range, record }),
                        None => split(node, share.items(range), &mut clusters),
                    }
                }
                clusters
            });
        concatenated(clusters.collect())
    }
}

/// What the angular splits make of a spatial cluster.
#[derive(Clone, Copy)]
struct Known {
    /// Number of clusters; 0 where it is not known yet.
    count: u32,
    /// The record if it is one cluster: it costs little while the members are at hand.
    record: u32,
}

impl Known {
    /// Nothing of so many clusters.
    fn nothing(clusters: usize) -> Vec<AtomicU64> {
        let all = (0..clusters).into_par_iter().with_min_len(1 << 15);
        all.map(|_| AtomicU64::new(0)).collect()
    }

    fn read(from: &AtomicU64) -> Self {
        let bits = from.load(Relaxed);
        Self {
            count: (bits >> 32) as u32,
            record: bits as u32,
        }
    }

    fn write(self, to: &AtomicU64) {
        to.store(
            u64::from(self.count) << 32 | u64::from(self.record),
            Relaxed,
        );
    }
}

/// What the angular splits make of each spatial cluster.
struct AngularCounts<'a, F: Measure> {
    tree: &'a Hierarchy<F>,
    angular: Angular<'a>,
    /// See [`Known::read`]: all threads write them.
    known: Vec<AtomicU64>,
    /// Counting stops here.
    limit: u32,
}

impl<F: Measure<Member = Spot>> AngularCounts<'_, F> {
    fn of(&self, node: u32) -> usize {
        Known::read(&self.known[node as usize]).count as usize
    }

    fn record(&self, node: u32) -> Option<u32> {
        let known = Known::read(&self.known[node as usize]);
        (known.count == 1).then_some(known.record)
    }

    fn learn(&self, nodes: &[u32]) {
        let angular = self.angular;
        let look = |members: &mut [Member]| {
            let count = angular.cones.count(members, self.limit);
            let record = match count {
                1 => angular.record(members),
                _ => NO_POINT,
            };
            Known { count, record }
        };
        let spots = |i: u32| &self.tree.members[self.tree.nodes[i as usize].range()];
        let look_at_group = |members: &mut Vec<Member>, group: &[u32]| {
            members.clear();
            let all = group.iter().map(|&i| spots(i));
            all.for_each(|own| complete(angular.points, own, members));
            let mut rest = &mut members[..];
            for &i in group {
                let (own, tail) = std::mem::take(&mut rest).split_at_mut(spots(i).len());
                rest = tail;
                look(own).write(&self.known[i as usize]);
            }
        };
        let groups = nodes.par_chunks(GROUP);
        groups.for_each_init(Vec::new, look_at_group);
    }
}

/// Splits the clusters with the most members in two until there are `count` clusters or all have
/// one member.
pub(super) fn split_largest(members: &mut [Spot], clusters: &mut Vec<Cluster>, count: usize) {
    while clusters.len() < count {
        let missing = count - clusters.len();
        let all = (0..clusters.len()).into_par_iter();
        let mut order: Vec<usize> = all.filter(|&i| clusters[i].range.len() > 1).collect();
        if order.is_empty() {
            return;
        }
        order.par_sort_unstable_by_key(|&i| {
            let range = &clusters[i].range;
            (std::cmp::Reverse(range.len()), range.start)
        });
        for &i in order.iter().take(missing) {
            let range = clusters[i].range.clone();
            let own = &mut members[range.clone()];
            let mut bounds = Bounds::EMPTY;
            own.iter().for_each(|spot| bounds.add(&spot.lanes));
            let axis = bounds.widest(&POSITION);
            let middle = if bounds.extent(axis) > 0.0 {
                partition(own, axis, bounds.middle(axis))
            } else {
                halve(own, axis)
            };
            let half = |range| Cluster {
                range,
                record: None,
            };
            clusters[i] = half(range.start..range.start + middle);
            clusters.push(half(range.start + middle..range.end));
        }
    }
}
