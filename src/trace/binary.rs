//! The binary tree under the wide one: obvhs' tree, with its lower levels built again where that is
//! cheaper.
//!
//! obvhs joins neighbours along a space-filling curve and then moves nodes, which is hard to beat where
//! triangles are of all sizes and leaves a few per cent on even meshes. So every subtree of up to
//! [`SUBTREE`] triangles is built a second time from the top, splitting by the surface area
//! heuristic in bins (Wald 2007), and the tree with less area of inner nodes stays; where that is the old
//! one, its parts are tried. Subtrees know nothing of each other and are built in parallel.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use rayon::prelude::*;

/// Triangles of the largest subtrees that are built again.
const SUBTREE: u32 = 1 << 15;
/// Parts that are tried next are smaller by this factor.
const STEP: u32 = 8;
/// Triangles of the smallest.
const SMALLEST: u32 = 8;
/// Places for a split along an axis.
const BINS: usize = 16;

/// A node of a binary tree in depth-first order: the left child of the node at `i` is at `i + 1`, the
/// right one after the left one's subtree.
#[derive(Clone, Copy)]
pub struct BinaryNode {
    pub bounds: Aabb,
    /// Triangles below; 1 is a leaf.
    pub count: u32,
    /// The caller's index of a leaf's triangle.
    pub triangle: u32,
}

impl BinaryNode {
    pub fn is_leaf(&self) -> bool {
        self.count == 1
    }

    /// Nodes of the subtree.
    pub fn length(&self) -> usize {
        2 * self.count as usize - 1
    }
}

/// obvhs' tree with one triangle a leaf, its subtrees built again where that pays.
pub fn improved(tree: &Bvh2) -> Vec<BinaryNode> {
    let mut nodes = depth_first(tree);
    let mut subtrees = Vec::new();
    let mut rest = nodes.as_mut_slice();
    while let Some(node) = rest.first() {
        if node.count > SUBTREE {
            rest = &mut rest[1..];
            continue;
        }
        let (subtree, after) = rest.split_at_mut(node.length());
        subtrees.push(subtree);
        rest = after;
    }
    subtrees
        .into_par_iter()
        .for_each_init(Scratch::default, improve);
    nodes
}

fn depth_first(tree: &Bvh2) -> Vec<BinaryNode> {
    let mut nodes = Vec::with_capacity(tree.nodes.len());
    let mut open = vec![0u32];
    while let Some(index) = open.pop() {
        let node = &tree.nodes[index as usize];
        let mut copy = BinaryNode {
            bounds: *node.aabb(),
            count: 0,
            triangle: 0,
        };
        if node.is_leaf() {
            copy.count = 1;
            copy.triangle = tree.primitive_indices[node.first_index as usize];
        } else {
            open.extend([node.first_index + 1, node.first_index]);
        }
        nodes.push(copy);
    }
    // Children come after their parents.
    for at in (0..nodes.len()).rev() {
        if nodes[at].count == 0 {
            let left = nodes[at + 1];
            nodes[at].count = left.count + nodes[at + 1 + left.length()].count;
        }
    }
    nodes
}

/// What the inner nodes of a tree or subtree cost: the area of their boxes.
fn cost(nodes: &[BinaryNode]) -> f32 {
    let inner = nodes.iter().filter(|node| !node.is_leaf());
    inner.map(|node| node.bounds.half_area()).sum()
}

/// What building takes, kept from subtree to subtree.
#[derive(Default)]
struct Scratch {
    leaves: Vec<BinaryNode>,
    nodes: Vec<BinaryNode>,
    open: Vec<[usize; 3]>,
}

/// Builds a subtree again if that makes it cheaper, or else its parts.
fn improve(scratch: &mut Scratch, tree: &mut [BinaryNode]) {
    let count = tree[0].count;
    if count < SMALLEST {
        return;
    }
    scratch.build(tree);
    if cost(&scratch.nodes) < cost(tree) {
        tree.copy_from_slice(&scratch.nodes);
        return;
    }
    let mut at = 1;
    while at < tree.len() {
        let length = tree[at].length();
        if tree[at].count <= count / STEP {
            improve(scratch, &mut tree[at..at + length]);
            at += length;
        } else {
            at += 1;
        }
    }
}

impl Scratch {
    /// Builds the tree of a subtree's leaves from the top.
    fn build(&mut self, tree: &[BinaryNode]) {
        self.leaves.clear();
        self.leaves
            .extend(tree.iter().filter(|node| node.is_leaf()));
        self.nodes.clear();
        self.nodes.extend_from_slice(tree);
        self.open.clear();
        self.open.push([0, 0, self.leaves.len()]);
        while let Some([at, start, end]) = self.open.pop() {
            let leaves = &mut self.leaves[start..end];
            if let [leaf] = leaves {
                self.nodes[at] = *leaf;
                continue;
            }
            let (left, bounds) = split(leaves);
            self.nodes[at] = BinaryNode {
                bounds,
                count: leaves.len() as u32,
                triangle: 0,
            };
            self.open.push([at + 2 * left, start + left, end]);
            self.open.push([at + 1, start, start + left]);
        }
    }
}

/// Sorts leaves into two sides and tells how many are left, and the bounds of all.
fn split(leaves: &mut [BinaryNode]) -> (usize, Aabb) {
    let mut bounds = Aabb::empty();
    let mut centres = Aabb::empty();
    for leaf in leaves.iter() {
        bounds = bounds.union(&leaf.bounds);
        centres.extend(centre(leaf));
    }
    let half = leaves.len() / 2;
    if leaves.len() == 2 {
        return (half, bounds);
    }
    let scale = BINS as f32 / (centres.max - centres.min).max(Vec3A::splat(f32::MIN_POSITIVE));
    let bins = |leaf: &BinaryNode| {
        let place = (centre(leaf) - centres.min) * scale;
        place.min(Vec3A::splat(BINS as f32 - 1.0)).as_uvec3()
    };
    let mut counts = [[0u32; BINS]; 3];
    let mut boxes = [[Aabb::empty(); BINS]; 3];
    for leaf in leaves.iter() {
        for (axis, bin) in bins(leaf).to_array().into_iter().enumerate() {
            counts[axis][bin as usize] += 1;
            boxes[axis][bin as usize] = boxes[axis][bin as usize].union(&leaf.bounds);
        }
    }
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        let mut right = [0.0; BINS];
        let mut sweep = (Aabb::empty(), 0);
        for bin in (1..BINS).rev() {
            sweep.0 = sweep.0.union(&boxes[axis][bin]);
            sweep.1 += counts[axis][bin];
            right[bin] = if sweep.1 == 0 {
                f32::INFINITY
            } else {
                sweep.0.half_area() * sweep.1 as f32
            };
        }
        let mut sweep = (Aabb::empty(), 0);
        for bin in 1..BINS {
            sweep.0 = sweep.0.union(&boxes[axis][bin - 1]);
            sweep.1 += counts[axis][bin - 1];
            if sweep.1 > 0 {
                let cost = sweep.0.half_area() * sweep.1 as f32 + right[bin];
                if cost < best.0 {
                    best = (cost, axis, bin as u32);
                }
            }
        }
    }
    let (cost, axis, bin) = best;
    if cost.is_infinite() {
        // All centres in one place.
        return (half, bounds);
    }
    let mut left = 0;
    for i in 0..leaves.len() {
        if bins(&leaves[i])[axis] < bin {
            leaves.swap(i, left);
            left += 1;
        }
    }
    (left, bounds)
}

/// Twice the centre of a leaf's box.
fn centre(leaf: &BinaryNode) -> Vec3A {
    leaf.bounds.min + leaf.bounds.max
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use obvhs::triangle::Triangle;

    use super::*;
    use crate::sample::Rng;
    use crate::trace::tracer::{MEDIUM, binary_tree};

    /// Two triangles a cell of an even grid, as many random ones of all sizes, or copies of one.
    fn meshes() -> [Vec<Triangle>; 3] {
        let triangle = |[a, b, c]: [Vec3; 3]| Triangle {
            v0: a.into(),
            v1: b.into(),
            v2: c.into(),
        };
        let cell = |i: usize| {
            let corner = |x: usize, y: usize| {
                let (x, y) = ((i % 64 + x) as f32, (i / 64 + y) as f32);
                Vec3::new(x, y, (0.1 * x).sin() * (0.17 * y).cos())
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            [triangle([a, b, c]), triangle([b, d, c])]
        };
        let mut rng = Rng::new(1, 0, 0, 0);
        let mut point = || Vec3::from([(); 3].map(|()| rng.next_f32()));
        let random = (0..3000).map(|_| {
            let (from, size) = (point(), point().x.powi(8));
            triangle([from, from + size * point(), from + size * point()])
        });
        let random = random.collect();
        let one = triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        [(0..4096).flat_map(cell).collect(), random, vec![one; 100]]
    }

    #[test]
    fn trees_stay_whole_and_do_not_get_dearer() {
        for triangles in meshes() {
            let binary = binary_tree(&triangles, MEDIUM);
            let (before, after) = (depth_first(&binary), improved(&binary));
            assert!(cost(&after) <= cost(&before) * (1.0 + 1e-5));
            let mut found: Vec<u32> = after
                .iter()
                .filter(|node| node.is_leaf())
                .map(|node| node.triangle)
                .collect();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..triangles.len() as u32));
            for (at, node) in after.iter().enumerate().filter(|(_, n)| !n.is_leaf()) {
                let left = after[at + 1];
                let right = after[at + 1 + left.length()];
                assert_eq!(node.count, left.count + right.count);
                assert_eq!(node.bounds, left.bounds.union(&right.bounds));
            }
        }
    }

    #[test]
    fn an_even_mesh_gets_a_cheaper_tree() {
        let [grid, ..] = meshes();
        let binary = binary_tree(&grid, MEDIUM);
        assert!(cost(&improved(&binary)) < 0.98 * cost(&depth_first(&binary)));
    }

    #[test]
    fn any_number_of_threads_builds_the_same_tree() {
        for (mesh, triangles) in meshes().iter().enumerate() {
            let tree = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let build = || improved(&binary_tree(triangles, MEDIUM));
                let nodes = pool.expect("threads").install(build);
                let node = |n: BinaryNode| (n.count, n.triangle, n.bounds.min, n.bounds.max);
                nodes.into_iter().map(node).collect::<Vec<_>>()
            };
            let alone = tree(1);
            for threads in [2, 3, 16] {
                assert!(tree(threads) == alone, "mesh {mesh}, {threads} threads");
            }
        }
    }
}
