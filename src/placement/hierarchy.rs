//! A tree of clusters that is grown only where a threshold asks for it, and cut at any threshold
//! without being built again.

use rayon::prelude::*;

use super::members::{Member, halve, partition};

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
    pub fn range(&self) -> std::ops::Range<usize> {
        self.begin as usize..self.end as usize
    }

    pub fn len(&self) -> usize {
        self.range().len()
    }
}

/// The tree. `measure` is a pure function of a cluster's members.
pub(super) struct Hierarchy<F> {
    pub members: Vec<Member>,
    /// Parents come before their children; the root is first.
    pub nodes: Vec<Node>,
    growth: Growth<F>,
}

struct Growth<F> {
    measure: F,
    /// Clusters of this many members or fewer are not split.
    least_members: usize,
}

impl<F: Fn(&[Member]) -> Split + Sync> Hierarchy<F> {
    /// A tree of one node. `members` must not be empty.
    pub fn new(members: Vec<Member>, measure: F, least_members: usize) -> Self {
        let growth = Growth {
            measure,
            least_members: least_members.max(1),
        };
        let root = growth.node(&members, 0, f32::INFINITY);
        Self {
            members,
            nodes: vec![root],
            growth,
        }
    }

    /// Grows the tree until it has at least `count` leaves or nothing can be split. Returns the
    /// size down to which all nodes are split.
    pub fn grow_to(&mut self, count: usize) -> f32 {
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
        let open = self.nodes.iter().filter(|n| self.open(n));
        open.map(|n| n.size).fold(0.0, f32::max)
    }

    /// Splits every node that is larger than `threshold`.
    fn grow(&mut self, threshold: f32) {
        let mut open: Vec<usize> = (0..self.nodes.len())
            .filter(|&i| self.open(&self.nodes[i]) && self.nodes[i].size > threshold)
            .collect();
        open.sort_unstable_by_key(|&i| self.nodes[i].begin);
        let mut tasks = Vec::with_capacity(open.len());
        let (mut rest, mut start) = (&mut self.members[..], 0);
        for i in open {
            let node = self.nodes[i];
            let (_, tail) = rest.split_at_mut(node.begin as usize - start);
            let (own, tail) = tail.split_at_mut(node.len());
            tasks.push((i, node, own));
            (rest, start) = (tail, node.end as usize);
        }
        let growth = &self.growth;
        let grown: Vec<(usize, Vec<Node>)> = tasks
            .into_par_iter()
            .map(|(i, node, own)| (i, growth.below(node, own, threshold)))
            .collect();
        for (i, below) in grown {
            self.nodes[i].children = self.nodes.len() as u32;
            append(&mut self.nodes, &below);
        }
    }

    /// The nodes that a threshold cuts open in descending size, parents before children; at most
    /// `most` of them.
    pub fn largest_first(&self, most: usize) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.nodes.len() as u32)
            .filter(|&i| self.nodes[i as usize].children != 0)
            .collect();
        let size = |i: u32| self.nodes[i as usize].size;
        order.par_sort_unstable_by(|&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
        order.truncate(most);
        order
    }

    /// The leaves left when exactly the nodes for which `opened` holds are split, by first member.
    pub fn cut(&self, opened: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut leaves = Vec::new();
        let mut stack = vec![0];
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i as usize];
            if node.children != 0 && opened(i) {
                stack.extend([node.children + 1, node.children]);
            } else {
                leaves.push(i);
            }
        }
        leaves
    }
}

impl<F: Fn(&[Member]) -> Split + Sync> Growth<F> {
    fn node(&self, members: &[Member], begin: u32, parent_size: f32) -> Node {
        let split = (self.measure)(members);
        Node {
            begin,
            end: begin + members.len() as u32,
            children: 0,
            size: split.size.min(parent_size),
            split,
        }
    }

    /// All nodes below `node`, its two children first.
    fn below(&self, node: Node, members: &mut [Member], threshold: f32) -> Vec<Node> {
        let mut nodes = Vec::new();
        self.extend(node, members, (threshold, &mut nodes));
        nodes
    }

    fn extend(
        &self,
        node: Node,
        members: &mut [Member],
        (threshold, nodes): (f32, &mut Vec<Node>),
    ) {
        let axis = node.split.axis;
        let middle = match node.split.plane {
            Some(plane) => partition(members, axis, plane),
            None => halve(members, axis),
        };
        let parallel = members.len() > PARALLEL;
        let (low, high) = members.split_at_mut(middle);
        let measure_low = || self.node(low, node.begin, node.size);
        let measure_high = || self.node(high, node.begin + middle as u32, node.size);
        let (left, right) = if parallel {
            rayon::join(measure_low, measure_high)
        } else {
            (measure_low(), measure_high())
        };
        let wanted = |n: &Node| n.len() > self.least_members && n.size > threshold;
        let first = nodes.len();
        nodes.extend([left, right]);
        if parallel {
            let grow = |child: Node, own: &mut [Member]| {
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
                self.extend(node, own, (threshold, nodes));
            }
        }
    }
}

/// Appends nodes whose child indices count from their own start. Never used for a root, so that
/// child index 0 always means a leaf.
fn append(nodes: &mut Vec<Node>, below: &[Node]) {
    let offset = nodes.len() as u32;
    nodes.extend(below.iter().map(|node| Node {
        children: if node.children == 0 {
            0
        } else {
            node.children + offset
        },
        ..*node
    }));
}
