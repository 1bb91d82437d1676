//! From the binary tree to the wide one, by dynamic programming.
//!
//! `C(n, j)` is the least cost of covering the subtree of `n` with at most `j` children of some wide
//! node, where a ray pays 1 per wide node and [`BLOCK_COST`] per leaf, both weighted by the area of
//! the box (the chance to be entered):
//!
//! - `C(n, 1)` is a leaf of at most as many triangles as there are lanes, or a wide node: the cheapest
//!   way to share its slots, one a lane, between the two binary children, plus the node itself;
//! - `C(n, j)` is `C(n, j − 1)` or the cheapest way to share `j` slots between the children.
//!
//! Children before parents fills the table; the decisions are then followed from the root.
//!
//! Slots are sorted by *occlusion per cost*, the triangle area below divided by `C`, because any-hit
//! rays visit them in this order: what stops many rays for little work comes first.

use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::triangle::Triangle;

use super::binary::BinaryNode;
use super::lanes::{Floats, MOST_LANES};
use super::soup::Soup;
use super::wide::{Block, CHILDREN_ROW, IDS_ROW, LEAF, Line, Node, WideTree};
use crate::memory::in_huge_pages;

/// Cost of a block of triangles in units of a node. Anything between 0.4 and 1.2 does as well.
const BLOCK_COST: f32 = 0.8;
/// The decision "as with one slot fewer", or "a block of triangles" for one slot.
const KEEP: u8 = 0;

/// The caller's index of a triangle, and its vectors.
type Rows = (u32, [Vec3; 3]);

/// Collapses a binary tree over the triangles of `soup`.
pub fn collapse<F: Floats, const TIGHT: bool>(
    present: F::Present,
    tree: &[BinaryNode],
    soup: &Soup,
) -> WideTree<F, TIGHT> {
    let corners = |id: u32| {
        let Triangle { v0, v1, v2 } = soup.corners[id as usize];
        [v0, v1, v2].map(Vec3::from)
    };
    let area = |id: u32| {
        let [a, b, c] = corners(id);
        0.5 * (b - a).cross(c - a).length()
    };
    // What a block holds of a triangle.
    let rows = |id: u32| {
        let [a, b, c] = corners(id);
        let rows = if TIGHT { [a, b, c] } else { [a, a - b, c - a] };
        (!is_degenerate([a, b, c])).then(|| (soup.index(id), rows))
    };
    let (lines, stack_entries) = emit::<F>(&Plan::new(tree, F::LANES, area), rows);
    WideTree {
        present,
        lines: in_huge_pages(lines),
        stack_entries,
    }
}

/// The binary tree with the best decision for every number of slots.
struct Plan<'a> {
    /// Slots of a wide node and triangles of a block.
    lanes: usize,
    nodes: &'a [BinaryNode],
    /// `C(n, 1)`.
    cost: Vec<f32>,
    /// Area of the triangles below.
    area: Vec<f32>,
    /// `[j]`: of `j` slots, those given to the left child, or [`KEEP`]; `[1]` says how a wide node
    /// shares all, [`KEEP`] that the single child is a block.
    left_slots: Vec<[u8; MOST_LANES]>,
}

impl<'a> Plan<'a> {
    fn new(nodes: &'a [BinaryNode], lanes: usize, triangle_area: impl Fn(u32) -> f32) -> Self {
        let n = nodes.len();
        let mut plan = Self {
            lanes,
            nodes,
            cost: vec![0.0; n],
            area: vec![0.0; n],
            left_slots: vec![[KEEP; MOST_LANES]; n],
        };
        plan.decide(triangle_area);
        plan
    }

    fn right(&self, place: usize) -> usize {
        place + 1 + self.nodes[place + 1].length()
    }

    /// Fills the table from the last place to the first: children come after their parents.
    fn decide(&mut self, triangle_area: impl Fn(u32) -> f32) {
        let lanes = self.lanes;
        // A floor on areas makes points and lines cost what they cost: nodes.
        let floor = (self.nodes[0].bounds.half_area() * 1e-9).max(1e-30);
        // The costs of the places whose parent is still to come, most recent last.
        let mut waiting: Vec<[f32; MOST_LANES]> = Vec::new();
        for place in (0..self.nodes.len()).rev() {
            let half_area = self.nodes[place].bounds.half_area().max(floor);
            if self.nodes[place].is_leaf() {
                self.cost[place] = half_area * BLOCK_COST;
                self.area[place] = triangle_area(self.nodes[place].triangle);
                waiting.push([self.cost[place]; MOST_LANES]);
                continue;
            }
            let right_place = self.right(place);
            self.area[place] = self.area[place + 1] + self.area[right_place];
            let (Some(left), Some(right)) = (waiting.pop(), waiting.pop()) else {
                unreachable!("an inner node has two children after it");
            };
            let cheapest = |slots: usize| {
                (1..slots)
                    .filter(|&k| k < lanes && slots - k < lanes)
                    .map(|k| (left[k - 1] + right[slots - k - 1], k as u8))
                    .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
            };
            let mut best = [0.0; MOST_LANES];
            let (split, k) = cheapest(lanes);
            (best[0], self.left_slots[place][1]) = (split + half_area, k);
            let leaf = half_area * BLOCK_COST;
            if self.nodes[place].count as usize <= lanes && leaf <= best[0] {
                (best[0], self.left_slots[place][1]) = (leaf, KEEP);
            }
            for j in 2..lanes {
                let (split, k) = cheapest(j);
                let better = split < best[j - 2];
                best[j - 1] = if better { split } else { best[j - 2] };
                self.left_slots[place][j] = if better { k } else { KEEP };
            }
            self.cost[place] = best[0];
            waiting.push(best);
        }
    }

    /// Whether the cheapest single child is a block of triangles.
    fn is_block(&self, place: usize) -> bool {
        self.left_slots[place][1] == KEEP
    }

    /// Follows the decisions from `place` with `slots` free slots down to single children.
    fn gather(&self, place: usize, slots: usize, found: &mut Vec<u32>) {
        if slots == 1 {
            found.push(place as u32);
            return;
        }
        let decision = self.left_slots[place][if slots == self.lanes { 1 } else { slots }];
        if decision == KEEP {
            return self.gather(place, slots - 1, found);
        }
        let left = usize::from(decision);
        self.gather(place + 1, left, found);
        self.gather(self.right(place), slots - left, found);
    }

    /// The children of the wide node at a place, in the order of visits.
    fn children(&self, place: usize, found: &mut Vec<u32>) {
        found.clear();
        self.gather(
            place,
            if self.is_block(place) { 1 } else { self.lanes },
            found,
        );
        let worth = |&place: &u32| self.area[place as usize] / self.cost[place as usize];
        found.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    }
}

/// A wide node to be written.
struct Open {
    place: usize,
    /// The parent's first line and the slot that is to name it.
    named_at: (usize, usize),
    /// Entries that may wait on a traversal stack when this node is reached.
    pending: usize,
}

/// Writes nodes in depth-first order, each followed by its blocks. Also tells how many entries a
/// traversal stack needs.
fn emit<F: Floats>(plan: &Plan, rows: impl Fn(u32) -> Option<Rows>) -> (Vec<Line>, usize) {
    let mut lines = Vec::with_capacity(plan.nodes.len());
    let mut stack_entries = 1;
    let mut children = Vec::with_capacity(F::LANES);
    let mut open = vec![Open {
        place: 0,
        named_at: (0, 0),
        pending: 0,
    }];
    while let Some(Open {
        place,
        named_at: (parent, slot),
        pending,
    }) = open.pop()
    {
        plan.children(place, &mut children);
        let pending = pending + children.len();
        stack_entries = stack_entries.max(pending);
        let first_open = open.len();
        let at = lines.len();
        if place != 0 {
            Part::at(&mut lines, parent, F::LANES).set(CHILDREN_ROW, slot, at as u32);
        }
        lines.resize(at + Node::<F>::LINES, Line::ZERO);
        Part::at(&mut lines, at, F::LANES).clear_boxes();
        for (lane, &child) in children.iter().enumerate() {
            let child = child as usize;
            Part::at(&mut lines, at, F::LANES).set_box(lane, &plan.nodes[child].bounds);
            if plan.is_block(child) {
                let block = lines.len();
                lines.resize(block + Block::<F>::LINES, Line::ZERO);
                Part::at(&mut lines, block, F::LANES).set_triangles(plan, child, &rows);
                Part::at(&mut lines, at, F::LANES).set(CHILDREN_ROW, lane, LEAF | block as u32);
            } else {
                open.push(Open {
                    place: child,
                    named_at: (at, lane),
                    pending,
                });
            }
        }
        open[first_open..].reverse();
    }
    (lines, stack_entries)
}

/// The lines of a node or block while they are written: rows of a number a lane.
struct Part<'a> {
    lines: &'a mut [Line],
    lanes: usize,
}

impl<'a> Part<'a> {
    fn at(lines: &'a mut [Line], first: usize, lanes: usize) -> Self {
        let lines = &mut lines[first..];
        Self { lines, lanes }
    }

    fn set(&mut self, row: usize, lane: usize, value: u32) {
        let at = row * self.lanes + lane;
        self.lines[at / Line::NUMBERS].0[at % Line::NUMBERS] = value;
    }

    /// Makes all slots of a node empty.
    fn clear_boxes(&mut self) {
        for lane in 0..self.lanes {
            for axis in 0..3 {
                self.set(2 * axis, lane, f32::INFINITY.to_bits());
                self.set(2 * axis + 1, lane, f32::NEG_INFINITY.to_bits());
            }
            self.set(CHILDREN_ROW, lane, LEAF);
        }
    }

    /// Writes the box of one slot, which grows by 2⁻²¹ of its coordinates and 2⁻²² of its extent, more than
    /// the rounding of box tests and of triangles relative to a vertex, so that a box never decides
    /// what a triangle test should.
    fn set_box(&mut self, lane: usize, bounds: &Aabb) {
        let (low, high) = (bounds.min, bounds.max);
        let extent = (high - low).max_element() * f32::EPSILON;
        for axis in 0..3 {
            let pad = |plane: f32| 2.0 * extent + 4.0 * plane.abs() * f32::EPSILON;
            let (low, high) = (low[axis] - pad(low[axis]), high[axis] + pad(high[axis]));
            self.set(2 * axis, lane, low.to_bits());
            self.set(2 * axis + 1, lane, high.to_bits());
        }
    }

    /// Writes the triangles below a place that can be hit, which are its next leaves in depth-first
    /// order.
    fn set_triangles(&mut self, plan: &Plan, place: usize, rows: impl Fn(u32) -> Option<Rows>) {
        let end = place + plan.nodes[place].length();
        let leaves = plan.nodes[place..end].iter().filter(|node| node.is_leaf());
        for (lane, leaf) in leaves.enumerate() {
            let Some((id, rows)) = rows(leaf.triangle) else {
                continue;
            };
            for (k, axis) in (0..9).map(|i| (i / 3, i % 3)) {
                self.set(3 * k + axis, lane, rows[k][axis].to_bits());
            }
            self.set(IDS_ROW, lane, id);
        }
    }
}

/// Whether a triangle has no area. In f64, because rounding gives its f32 normal a direction.
fn is_degenerate([a, b, c]: [Vec3; 3]) -> bool {
    (b - a).as_dvec3().cross((c - a).as_dvec3()) == glam::DVec3::ZERO
}
