//! A tree of clusters that is grown only where a threshold asks for it, and cut at any threshold
//! without being built again.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use super::partition::{Coordinates, PART, halve, is_large, is_shared, partition, partition_large};
use super::share::shares;

/// Nodes with more members than this grow their halves in parallel.
const PARALLEL: usize = 1 << 15;

/// How a cluster would be split, and how much it asks for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    /// The size that is compared with the threshold, ≥ 0; a cluster of size 0 is never split.
    pub size: f32,
    pub axis: usize,
    /// `None` splits in two halves of equal count.
    pub plane: Option<f32>,
}

/// How clusters are measured: a pure function of their members.
pub(super) trait Measure: Sync {
    type Member: Coordinates;
    /// What is known of the members seen so far.
    type Summary: Copy + Send + Sync;

    fn nothing(&self) -> Self::Summary;
    fn add(&self, summary: &mut Self::Summary, member: &Self::Member);
    /// Adds what is known of other members.
    fn join(&self, summary: &mut Self::Summary, other: &Self::Summary);
    /// The split of `count` members.
    fn split(&self, summary: &Self::Summary, count: usize) -> Split;
}

/// A cluster: a range of members.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub begin: u32,
    pub end: u32,
    /// The first of two children that lie side by side; 0 for a leaf.
    pub children: u32,
    /// The least size on the path from the root, so that a node is cut open exactly if this is
    /// above the threshold.
    pub size: f32,
    split: Split,
}

impl Node {
    pub fn range(&self) -> Range<usize> {
        self.begin as usize..self.end as usize
    }

    pub fn len(&self) -> usize {
        self.range().len()
    }

    /// The same node where all nodes lie `offset` places later.
    fn moved(self, offset: u32) -> Self {
        let children = match self.children {
            0 => 0,
            first => first + offset,
        };
        Self { children, ..self }
    }
}

/// The tree.
pub(super) struct Hierarchy<F: Measure> {
    pub members: Vec<F::Member>,
    /// Parents come before their children; the root is first.
    pub nodes: Vec<Node>,
    growth: Growth<F>,
}

/// What grew below some nodes.
#[derive(Default)]
struct Grown {
    /// The nodes that were split, and where in `below` the two children of each are.
    parents: Vec<(u32, u32)>,
    /// Indices of children count from its start.
    below: Vec<Node>,
}

/// Lists that nodes which grow at once are gathered in, at least.
const LISTS: usize = 1024;

struct Growth<F> {
    measure: F,
    /// Clusters of this many members or fewer are not split.
    least_members: usize,
}

impl<F: Measure> Hierarchy<F> {
    /// A tree of one node. `members` must not be empty.
    pub fn new(members: Vec<F::Member>, measure: F, least_members: usize) -> Self {
        let growth = Growth {
            measure,
            least_members: least_members.max(1),
        };
        let summary = growth.summary(&members);
        let root = growth.node(&summary, 0..members.len() as u32, f32::INFINITY);
        Self {
            members,
            nodes: vec![root],
            growth,
        }
    }

    /// Grows the tree until it has at least `count` leaves or nothing can be split. Returns the
    /// size down to which all nodes are split.
    pub fn grow_to(&mut self, count: usize) -> f32 {
        // Leaves, their parents, and some more than are asked for.
        self.nodes.reserve(5 * count.min(self.members.len()) / 2);
        let mut threshold = f32::INFINITY;
        loop {
            let leaves = self.nodes.len().div_ceil(2);
            let largest = self.largest_open().min(threshold);
            if leaves >= count || largest <= 0.0 {
                return if threshold.is_finite() {
                    threshold
                } else {
                    largest
                };
            }
            // Counts grow about with the inverse square of the threshold, on surfaces.
            let wanted = (leaves as f32 / count as f32).sqrt() * 0.95;
            threshold = largest * wanted.clamp(0.55, 0.95);
            if threshold >= largest {
                threshold = 0.0; // Sizes so small that the product rounds back.
            }
            self.grow(threshold);
        }
    }

    fn open(&self, node: &Node) -> bool {
        node.children == 0 && node.len() > self.growth.least_members
    }

    fn largest_open(&self) -> f32 {
        let open = self.nodes.par_iter().with_min_len(PARALLEL);
        let sizes = open.filter(|n| self.open(n)).map(|n| n.size);
        sizes.reduce(|| 0.0, f32::max)
    }

    /// Splits every node that is larger than `threshold`.
    fn grow(&mut self, threshold: f32) {
        let nodes = &self.nodes;
        let open = (0..nodes.len() as u32)
            .into_par_iter()
            .with_min_len(PARALLEL)
            .filter(|&i| self.open(&nodes[i as usize]) && nodes[i as usize].size > threshold);
        let open = self.by_first_member(open);
        let growth = &self.growth;
        let together = (open.len() / LISTS).max(1);
        let range = |&i: &u32| nodes[i as usize].range();
        let shares = shares(&mut self.members, &open, together, range);
        let grown: Vec<Grown> = shares
            .into_par_iter()
            .map(|mut share| {
                let mut grown = Grown::default();
                for &parent in share.parts {
                    let node = nodes[parent as usize];
                    let first = grown.below.len() as u32;
                    grown.parents.push((parent, first));
                    let own = share.items(node.range());
                    growth.extend(node, own, threshold, &mut grown.below);
                }
                grown
            })
            .collect();
        self.append_all(grown);
    }

    /// Appends what grew.
    fn append_all(&mut self, grown: Vec<Grown>) {
        let before = self.nodes.len();
        let mut after = before;
        for Grown { parents, below } in &grown {
            for &(parent, first) in parents {
                self.nodes[parent as usize].children = after as u32 + first;
            }
            after += below.len();
        }
        // Written by all threads: one alone would wait for each page of them.
        let unused = rayon::iter::repeat_n(self.nodes[0], after - before);
        self.nodes.par_extend(unused);
        let mut places = Vec::with_capacity(grown.len());
        let (mut rest, mut start) = (&mut self.nodes[before..], before);
        for Grown { below, .. } in grown {
            let (own, tail) = rest.split_at_mut(below.len());
            let first = start as u32;
            (rest, start) = (tail, start + below.len());
            places.push((first, own, below));
        }
        places.into_par_iter().for_each(|(first, own, below)| {
            let moved = below.iter().map(|node| node.moved(first));
            own.iter_mut().zip(moved).for_each(|(to, from)| *to = from);
        });
    }

    /// The nodes that a threshold cuts open in descending size, parents before children; at most
    /// `most` of them.
    pub fn largest_first(&self, most: usize) -> Vec<u32> {
        // Sizes are not negative, so their bits are in their order.
        let key = |i: u32| {
            let size = self.nodes[i as usize].size;
            u64::from(!size.to_bits()) << 32 | u64::from(i)
        };
        let all = (0..self.nodes.len() as u32).into_par_iter();
        let mut order: Vec<u64> = all
            .filter(|&i| self.nodes[i as usize].children != 0)
            .map(key)
            .collect();
        order.par_sort_unstable();
        order.truncate(most);
        order.into_par_iter().map(|key| key as u32).collect()
    }

    /// The leaves left when exactly the nodes `opened` are split, by first member. A node must be among them if a
    /// child is.
    pub fn cut(&self, opened: &[u32]) -> Vec<u32> {
        if opened.is_empty() {
            return vec![0];
        }
        let none = (0..self.nodes.len()).into_par_iter().with_min_len(PARALLEL);
        let is_open: Vec<AtomicBool> = none.map(|_| AtomicBool::new(false)).collect();
        let is_open = |i: u32| &is_open[i as usize];
        let opens = opened.par_iter().with_min_len(PARALLEL);
        opens.for_each(|&i| is_open(i).store(true, Relaxed));
        let children = |&i: &u32| {
            let first = self.nodes[i as usize].children;
            [first, first + 1]
        };
        let leaves = opened.par_iter().flat_map_iter(children);
        self.by_first_member(leaves.filter(|&i| !is_open(i).load(Relaxed)))
    }

    /// Nodes in the order of their first members.
    fn by_first_member(&self, nodes: impl ParallelIterator<Item = u32>) -> Vec<u32> {
        let key = |i: u32| u64::from(self.nodes[i as usize].begin) << 32 | u64::from(i);
        let mut keys: Vec<u64> = nodes.map(key).collect();
        keys.par_sort_unstable();
        keys.into_par_iter().map(|key| key as u32).collect()
    }
}

impl<F: Measure> Growth<F> {
    fn summary(&self, members: &[F::Member]) -> F::Summary {
        let of = |members: &[F::Member]| {
            let mut summary = self.measure.nothing();
            members
                .iter()
                .for_each(|member| self.measure.add(&mut summary, member));
            summary
        };
        if !is_shared(members) {
            return of(members);
        }
        let parts: Vec<F::Summary> = members.par_chunks(PART).map(of).collect();
        let mut summary = self.measure.nothing();
        parts
            .iter()
            .for_each(|part| self.measure.join(&mut summary, part));
        summary
    }

    fn node(&self, summary: &F::Summary, range: Range<u32>, parent_size: f32) -> Node {
        let split = self.measure.split(summary, range.len());
        Node {
            begin: range.start,
            end: range.end,
            children: 0,
            size: split.size.min(parent_size),
            split,
        }
    }

    /// Reorders the members of a node and returns how many are in its first half, and summaries
    /// of both.
    fn halves(&self, split: Split, members: &mut [F::Member]) -> (usize, [F::Summary; 2]) {
        let middle = match split.plane {
            Some(plane) if is_large(members) && !is_shared(members) => {
                let add = |summary: &mut F::Summary, member: &F::Member| {
                    self.measure.add(summary, member);
                };
                let nothing = [self.measure.nothing(); 2];
                return partition_large(members, split.axis, plane, nothing, add);
            }
            Some(plane) => partition(members, split.axis, plane),
            None => halve(members, split.axis),
        };
        let (low, high) = members.split_at(middle);
        (middle, [self.summary(low), self.summary(high)])
    }

    /// All nodes below `node`, its two children first.
    fn below(&self, node: Node, members: &mut [F::Member], threshold: f32) -> Vec<Node> {
        let mut nodes = Vec::new();
        self.extend(node, members, threshold, &mut nodes);
        nodes
    }

    fn extend(&self, node: Node, members: &mut [F::Member], threshold: f32, nodes: &mut Vec<Node>) {
        let parallel = members.len() > PARALLEL;
        let (middle, summaries) = self.halves(node.split, members);
        let (low, high) = members.split_at_mut(middle);
        let middle = node.begin + middle as u32;
        let left = self.node(&summaries[0], node.begin..middle, node.size);
        let right = self.node(&summaries[1], middle..node.end, node.size);
        let wanted = |n: &Node| n.len() > self.least_members && n.size > threshold;
        let first = nodes.len();
        nodes.extend([left, right]);
        if parallel {
            let grow = |child: Node, own: &mut [F::Member]| {
                let wanted = wanted(&child);
                wanted.then(|| self.below(child, own, threshold))
            };
            let (below_left, below_right) = rayon::join(|| grow(left, low), || grow(right, high));
            for (child, below) in [(first, below_left), (first + 1, below_right)] {
                if let Some(below) = below {
                    nodes[child].children = nodes.len() as u32;
                    append(nodes, &below);
                }
            }
            return;
        }
        for (child, node, own) in [(first, left, low), (first + 1, right, high)] {
            if wanted(&node) {
                nodes[child].children = nodes.len() as u32;
                self.extend(node, own, threshold, nodes);
            }
        }
    }
}

/// Appends nodes whose child indices count from their own start. Never used for a root, so that
/// child index 0 always means a leaf.
fn append(nodes: &mut Vec<Node>, below: &[Node]) {
    let offset = nodes.len() as u32;
    nodes.extend(below.iter().map(|node| node.moved(offset)));
}
