//! A balanced tree over record positions with blocks of up to eight records as leaves.

mod split;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

/// Most records of a leaf.
const BLOCK: usize = 8;
/// Slices longer than this are arranged in parallel.
const PARALLEL: usize = 1 << 14;
/// More than the depth of any tree over u32 indices.
const STACK: usize = 64;

/// A box with its faces along the axes, scene units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3 {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Box3 {
    const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn around(points: impl Iterator<Item = Vec3A>) -> Self {
        points.fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Squared distance to a point, 0 inside.
    #[inline]
    fn squared_to(&self, point: Vec3A) -> f32 {
        let gap = (self.min - point).max(point - self.max).max(Vec3A::ZERO);
        gap.dot(gap)
    }
}

/// Records in the order of the tree's leaves, so that a block is contiguous in every array.
#[derive(Default)]
pub(super) struct RecordTree {
    /// Heap order: the root is 1, the children of i are 2i and 2i + 1; `leaves` leaves come last.
    boxes: Vec<Box3>,
    leaves: usize,
    pub position: Vec<Vec3A>,
    pub normal: Vec<Vec3A>,
    /// Index of the record in the caller's order.
    pub record: Vec<u32>,
}

impl RecordTree {
    /// Leaves out records with a position or normal that is not finite.
    pub fn new(positions: &[Vec3], normals: &[Vec3]) -> Self {
        let all = positions.par_iter().zip(normals).enumerate();
        let is_finite = |(_, (p, n)): &(usize, (&Vec3, &Vec3))| p.is_finite() && n.is_finite();
        let item = |(i, (&p, _)): (usize, (&Vec3, &Vec3))| (p.into(), i as u32);
        // Where the number is known before, all threads write into one list.
        let mut items: Vec<(Vec3A, u32)> = match all.clone().all(|one| is_finite(&one)) {
            true => all.map(item).collect(),
            false => all.filter(is_finite).map(item).collect(),
        };
        if items.is_empty() {
            return Self::default();
        }
        let leaves = items.len().div_ceil(BLOCK).next_power_of_two();
        let all_items = items.len();
        let share = Share {
            first_leaf: 0,
            leaves,
            all_leaves: leaves,
            all_items,
        };
        arrange(&mut items, share);
        let mut tree = Self {
            boxes: Vec::new(),
            leaves,
            position: items.par_iter().map(|item| item.0).collect(),
            normal: items
                .par_iter()
                .map(|item| normals[item.1 as usize].into())
                .collect(),
            record: items.par_iter().map(|item| item.1).collect(),
        };
        tree.boxes = tree.bound();
        tree
    }

    fn bound(&self) -> Vec<Box3> {
        let of_leaf = |node: usize| match node.checked_sub(self.leaves) {
            Some(leaf) => Box3::around(self.position[self.block(leaf)].iter().copied()),
            None => Box3::EMPTY,
        };
        let nodes = (0..2 * self.leaves).into_par_iter();
        let mut boxes: Vec<Box3> = nodes.map(of_leaf).collect();
        let mut width = self.leaves / 2;
        while width > 0 {
            let (above, below) = boxes.split_at_mut(2 * width);
            above[width..]
                .par_iter_mut()
                .zip(below.par_chunks(2))
                .with_min_len(1 << 12)
                .for_each(|(node, children)| *node = children[0].union(children[1]));
            width /= 2;
        }
        boxes
    }

    pub fn len(&self) -> usize {
        self.record.len()
    }

    fn block(&self, leaf: usize) -> std::ops::Range<usize> {
        let n = self.len();
        leaf * n / self.leaves..(leaf + 1) * n / self.leaves
    }

    /// Squared distance from `point` to its `count`-th nearest record, at most
    /// `bound`; `nearest` is scratch space. Infinite if there are fewer records.
    pub fn nth_squared(
        &self,
        point: Vec3A,
        count: usize,
        bound: f32,
        nearest: &mut Vec<f32>,
    ) -> f32 {
        nearest.clear();
        if self.len() < count || count == 0 {
            return f32::INFINITY;
        }
        let mut worst = bound;
        let mut stack = [(0usize, 0.0f32); STACK];
        stack[0] = (1, self.boxes[1].squared_to(point));
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (node, away) = stack[depth];
            if away > worst {
                continue;
            }
            if node >= self.leaves {
                for slot in self.block(node - self.leaves) {
                    let squared = squared_distance(self.position[slot], point);
                    if squared < worst {
                        insert(nearest, squared, count);
                        if nearest.len() == count {
                            worst = nearest[count - 1];
                        }
                    }
                }
                continue;
            }
            let left = (2 * node, self.boxes[2 * node].squared_to(point));
            let right = (2 * node + 1, self.boxes[2 * node + 1].squared_to(point));
            let (near, far) = if left.1 <= right.1 {
                (left, right)
            } else {
                (right, left)
            };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
        worst
    }

    /// Calls `found` with the slots of all blocks that may hold records within the root of
    /// `farthest` of `point`.
    pub fn for_each_block(
        &self,
        point: Vec3A,
        farthest: f32,
        mut found: impl FnMut(std::ops::Range<usize>),
    ) {
        if self.len() == 0 {
            return;
        }
        let mut stack = [1usize; STACK];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = stack[depth];
            if self.boxes[node].squared_to(point) > farthest {
                continue;
            }
            if node >= self.leaves {
                found(self.block(node - self.leaves));
            } else {
                stack[depth] = 2 * node + 1;
                stack[depth + 1] = 2 * node;
                depth += 2;
            }
        }
    }
}

/// The one expression for squared distances: every path of the search rounds alike.
#[inline]
pub(super) fn squared_distance(a: Vec3A, b: Vec3A) -> f32 {
    let d = a - b;
    d.x * d.x + d.y * d.y + d.z * d.z
}

/// Keeps `sorted` ascending with at most `count` values.
fn insert(sorted: &mut Vec<f32>, value: f32, count: usize) {
    if sorted.len() < count {
        sorted.push(value);
    }
    let mut i = sorted.len() - 1;
    while i > 0 && sorted[i - 1] > value {
        sorted[i] = sorted[i - 1];
        i -= 1;
    }
    sorted[i] = value;
}

/// Which leaves a slice of items is for, and how items map to leaves in the whole tree.
#[derive(Clone, Copy)]
struct Share {
    first_leaf: usize,
    leaves: usize,
    all_leaves: usize,
    all_items: usize,
}

/// The axis along which the box around items is longest.
fn widest_axis(items: &[(Vec3A, u32)]) -> usize {
    let around = |items: &[(Vec3A, u32)]| Box3::around(items.iter().map(|item| item.0));
    let bounds = match items.len() > PARALLEL {
        true => items
            .par_chunks(PARALLEL)
            .map(around)
            .reduce(|| Box3::EMPTY, Box3::union),
        false => around(items),
    };
    (bounds.max - bounds.min).max_position()
}

/// Orders items so that each half of the leaves gets one side of a median split on the widest axis.
fn arrange(items: &mut [(Vec3A, u32)], share: Share) {
    if share.leaves < 2 {
        // However they came here.
        items.sort_unstable_by_key(|item| item.1);
        return;
    }
    let axis = widest_axis(items);
    let half = share.leaves / 2;
    let start = |leaf: usize| leaf * share.all_items / share.all_leaves;
    let middle = start(share.first_leaf + half) - start(share.first_leaf);
    if middle < items.len() {
        split::at_rank(items, middle, |item| split::key(item.0[axis], item.1));
    }
    let parallel = items.len() > PARALLEL;
    let (low, high) = items.split_at_mut(middle);
    let low_share = Share {
        leaves: half,
        ..share
    };
    let high_share = Share {
        first_leaf: share.first_leaf + half,
        ..low_share
    };
    if parallel {
        rayon::join(|| arrange(low, low_share), || arrange(high, high_share));
    } else {
        arrange(low, low_share);
        arrange(high, high_share);
    }
}
