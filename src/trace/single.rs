//! One ray against the wide tree: one stream of instructions a node tests all its boxes.
//!
//! A box is entered where the ray is past all near planes and before all far planes. With
//! `t = plane·r − o·r`, `r = 1/d`, a plane costs one fused operation. `o·r` is prepared twice, so that
//! near planes never come out too far nor far planes too near by any rounding that grows with the
//! origin; what grows with the planes is in the boxes (see [`super::collapse`]). A box test therefore
//! loses no hit, however flat the box or however parallel the ray.
//!
//! Near and far are compared as integers: for non-negative floats the order of the bits is the order
//! of the values, and a negative far plane (box behind the origin) is below every `t_min ≥ 0`.
//!
//! *Any hit* visits children in slot order (see [`super::collapse`]), *closest hit* by distance, and
//! skips what lies beyond the closest hit so far. Of triangles hit at the same distance the
//! one with the smallest index wins, in whatever order they are met.

use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

use super::lanes::Floats;
use super::triangle::{Crossing, Seen, Vectors};
use super::wide::{Block, LEAF, Line, Node, WideTree};
use super::{Hit, Ray};

/// A direction component this small is as good as parallel to the planes of its axis.
const PARALLEL: f32 = 1e-18;
/// Bounds the rounding of a plane's distance, relative to `o/d`.
const SLACK: f32 = 4.0 * f32::EPSILON;

/// `1/d`, finite for a ray parallel to the planes.
pub fn reciprocal(d: f32) -> f32 {
    1.0 / d.abs().max(PARALLEL).copysign(d)
}

/// A ray prepared for box and triangle tests.
pub struct Beam<F: Floats> {
    present: F::Present,
    /// `1/d`.
    scale: Vectors<F>,
    /// `o/d`, moved by more than all rounding that grows with `o`.
    near_shift: Vectors<F>,
    far_shift: Vectors<F>,
    /// Rows of the near planes; the far plane of an axis is the other row of the pair.
    near_row: [usize; 3],
    origin: Vectors<F>,
    direction: Vectors<F>,
    t_min: f32,
    t_max: f32,
}

impl<F: Floats> Beam<F> {
    /// `ray` must be finite apart from an infinite `t_max`.
    #[inline(always)]
    pub fn new(present: F::Present, ray: &Ray) -> Self {
        Self::with_scale(present, ray, ray.direction.to_array().map(reciprocal))
    }

    /// As [`Beam::new`] with the reciprocals of the direction at hand.
    #[inline(always)]
    pub fn with_scale(present: F::Present, ray: &Ray, scale: [f32; 3]) -> Self {
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let shift = |slack: f32| {
            let each = |a: usize| o[a] * scale[a] + (o[a] * scale[a]).abs() * slack;
            Vectors::splat(present, [each(0), each(1), each(2)])
        };
        Self {
            present,
            scale: Vectors::splat(present, scale),
            near_shift: shift(SLACK),
            far_shift: shift(-SLACK),
            near_row: [0, 1, 2].map(|a| 2 * a + usize::from(scale[a] < 0.0)),
            origin: Vectors::splat(present, o),
            direction: Vectors::splat(present, d),
            t_min: ray.t_min.max(0.0) + 0.0,
            t_max: ray.t_max,
        }
    }

    /// The entry distances of a node's boxes and a bit for each box entered before `t_max`.
    #[inline(always)]
    fn boxes(&self, node: &Node<F>, t_max: f32) -> (F, u32) {
        let [x, y, z] = self.near_row;
        let (scale, near, far) = (&self.scale, &self.near_shift, &self.far_shift);
        let near_x = self.plane(node, x).mul_sub(scale.x, near.x);
        let near_y = self.plane(node, y).mul_sub(scale.y, near.y);
        let near_z = self.plane(node, z).mul_sub(scale.z, near.z);
        let far_x = self.plane(node, x ^ 1).mul_sub(scale.x, far.x);
        let far_y = self.plane(node, y ^ 1).mul_sub(scale.y, far.y);
        let far_z = self.plane(node, z ^ 1).mul_sub(scale.z, far.z);
        let t_min = F::splat(self.present, self.t_min);
        let t_max = F::splat(self.present, t_max);
        let near = near_x.max_bits(near_y).max_bits(near_z.max_bits(t_min));
        let far = far_x.min_bits(far_y).min_bits(far_z.min_bits(t_max));
        (near, near.le_bits(far))
    }

    #[inline(always)]
    fn plane(&self, node: &Node<F>, row: usize) -> F {
        // SAFETY: rows are 2a or 2a + 1 for an axis a < 3, and so are they after `^ 1`.
        F::load(self.present, unsafe { node.planes.get_unchecked(row) })
    }

    #[inline(always)]
    fn crossing<const TIGHT: bool>(&self, block: &Block<F>) -> Crossing<F> {
        Seen::<F, TIGHT>::new(self.present, block, self.origin).cross(self.direction)
    }
}

impl<F: Floats, const TIGHT: bool> WideTree<F, TIGHT> {
    #[inline]
    pub(super) fn node(&self, child: u32) -> &Node<F> {
        debug_assert!(child & LEAF == 0 && child as usize + Node::<F>::LINES <= self.lines.len());
        // SAFETY: `collapse` sets `LEAF` or the first line of a node.
        unsafe { &*self.address(child).cast() }
    }

    #[inline]
    pub(super) fn block(&self, child: u32) -> &Block<F> {
        debug_assert!(
            child & LEAF != 0 && (child & !LEAF) as usize + Block::<F>::LINES <= self.lines.len()
        );
        // SAFETY: `collapse` sets the first line of a block. Empty slots, which no ray enters, name
        // line 0, after which any tree has the lines of a node and a block.
        unsafe { &*self.address(child).cast() }
    }

    #[inline]
    fn address(&self, child: u32) -> *const Line {
        self.lines.as_ptr().wrapping_add((child & !LEAF) as usize)
    }

    /// Asks for a child ahead of its visit.
    #[inline]
    pub(super) fn prefetch(&self, child: u32) {
        for line in 0..Block::<F>::LINES {
            let address = self.address(child).wrapping_add(line);
            // SAFETY: a prefetch reads nothing and cannot fault; SSE is part of x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) };
        }
    }
}

/// Whether anything below `child` is hit in `(t_min, t_max]`. `stack` holds
/// `tree.stack_entries` entries.
#[inline(always)]
pub fn occluded<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    beam: &Beam<F>,
    child: u32,
    stack: &mut [u32],
) -> bool {
    let t_min = F::splat(tree.present, beam.t_min);
    let t_max = F::splat(tree.present, beam.t_max);
    let mut waiting = 0;
    let mut child = child;
    loop {
        if child & LEAF == 0 {
            let node = tree.node(child);
            let (_, entered) = beam.boxes(node, beam.t_max);
            if entered != 0 {
                let lowest = |lanes: u32| node.children[lanes.trailing_zeros() as usize % F::LANES];
                let rest = entered & (entered - 1);
                F::write_falling(tree.present, &node.children, rest, &mut stack[waiting..]);
                waiting += rest.count_ones() as usize;
                tree.prefetch(lowest(rest));
                child = lowest(entered);
                continue;
            }
        } else if beam
            .crossing::<TIGHT>(tree.block(child))
            .hits(tree.present, t_min, t_max)
            != 0
        {
            return true;
        }
        if waiting == 0 {
            return false;
        }
        waiting -= 1;
        child = stack[waiting];
        tree.prefetch(stack[waiting.saturating_sub(1)]);
    }
}

/// The closest hit below `child` in `(t_min, t_max]` that beats `best`. `stack` holds
/// `tree.stack_entries` entries: the bits of the entry distance above the child.
#[inline(always)]
pub fn closest<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    beam: &Beam<F>,
    child: u32,
    stack: &mut [u64],
    best: &mut Option<Hit>,
) {
    let mut waiting = 0;
    let mut child = child;
    let mut t_max = best.map_or(beam.t_max, |hit| hit.t);
    loop {
        if child & LEAF == 0 {
            let node = tree.node(child);
            let (near, entered) = beam.boxes(node, t_max);
            if entered != 0 {
                let first = entered.trailing_zeros() as usize % F::LANES;
                let others = entered & (entered - 1);
                child = node.children[first];
                tree.prefetch(child);
                if others == 0 {
                    continue;
                }
                let near = near.store();
                let second = others.trailing_zeros() as usize % F::LANES;
                tree.prefetch(node.children[second]);
                if others & (others - 1) != 0 {
                    child = push_sorted(tree, node, &near, entered, &mut stack[waiting..]);
                    waiting += others.count_ones() as usize;
                    continue;
                }
                // A branch, not a choice: when it is guessed right, the next visit begins early.
                if near[first].to_bits() <= near[second].to_bits() {
                    stack[waiting] = entry(node, &near, second);
                } else {
                    stack[waiting] = entry(node, &near, first);
                    child = node.children[second];
                }
                waiting += 1;
                continue;
            }
        } else {
            let block = tree.block(child);
            let crossing = beam.crossing::<TIGHT>(block);
            nearest_lane(tree.present, &crossing, block, [beam.t_min, t_max], best);
            t_max = best.map_or(beam.t_max, |hit| hit.t);
        }
        loop {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            if (stack[waiting] >> 32) as u32 <= t_max.to_bits() {
                break;
            }
        }
        child = stack[waiting] as u32;
    }
}

/// A child that waits: the bits of its entry distance above it.
#[inline]
fn entry<F: Floats>(node: &Node<F>, near: &F::Row, lane: usize) -> u64 {
    u64::from(near[lane % F::LANES].to_bits()) << 32 | u64::from(node.children[lane % F::LANES])
}

/// The nearest of three or more entered children; writes the others to `top`, from the farthest to
/// the nearest. Three are sorted without a branch, more by insertion.
#[inline(always)]
fn push_sorted<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    node: &Node<F>,
    near: &F::Row,
    entered: u32,
    top: &mut [u64],
) -> u32 {
    let mut lanes = entered;
    let mut next = || {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes.wrapping_sub(1);
        let next = entry(node, near, lane);
        tree.prefetch(next as u32);
        next
    };
    let (a, b, c) = (next(), next(), next());
    let (a, b) = (a.min(b), a.max(b));
    let (b, c) = (b.min(c), b.max(c));
    let (a, b) = (a.min(b), a.max(b));
    top[..3].copy_from_slice(&[c, b, a]);
    let count = entered.count_ones() as usize;
    for end in 3..count {
        let next = next();
        let mut at = end;
        while at > 0 && top[at - 1] < next {
            top[at] = top[at - 1];
            at -= 1;
        }
        top[at] = next;
    }
    top[count - 1] as u32
}

/// Replaces `best` by the nearest of a block's hits in `(limits[0], limits[1]]` if that is nearer,
/// or as near with a smaller index; whether it did.
#[inline(always)]
pub fn nearest_lane<F: Floats>(
    present: F::Present,
    crossing: &Crossing<F>,
    block: &Block<F>,
    limits: [f32; 2],
    best: &mut Option<Hit>,
) -> bool {
    let [t_min, t_max] = limits;
    // The undivided test may round the other way than the division that decides below.
    let generous = F::splat(present, t_max * (1.0 + SLACK));
    let mut hits = crossing.hits(present, F::splat(present, t_min), generous);
    if hits == 0 {
        return false;
    }
    let t = (crossing.t / crossing.denominator).store();
    let mut found = None;
    let mut limit = (t_max, best.map_or(u32::MAX, |hit| hit.triangle));
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize % F::LANES;
        hits &= hits - 1;
        let candidate = (t[lane], block.id[lane]);
        if candidate.0 < limit.0 || candidate.0 == limit.0 && candidate.1 < limit.1 {
            limit = candidate;
            found = Some(lane);
        }
    }
    if let Some(lane) = found {
        *best = Some(Hit {
            t: t[lane],
            u: (crossing.u / crossing.denominator).store()[lane],
            v: (crossing.v / crossing.denominator).store()[lane],
            triangle: block.id[lane],
        });
    }
    found.is_some()
}
