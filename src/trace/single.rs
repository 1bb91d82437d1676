//! One ray against the eight-wide tree: one instruction stream per node tests all eight boxes.
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

use std::arch::x86_64::*;

use super::tile::bits as set_bits;
use super::vector::{Crossing, Seen, Vec3x8, load, load_bits, store, store_bits};
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
pub struct Beam {
    /// `1/d`.
    scale: Vec3x8,
    /// `o/d`, moved by more than all rounding that grows with `o`.
    near_shift: Vec3x8,
    far_shift: Vec3x8,
    /// Rows of the near planes; the far plane of an axis is the other row of the pair.
    near_row: [usize; 3],
    origin: Vec3x8,
    direction: Vec3x8,
    t_min: f32,
    t_max: f32,
}

impl Beam {
    /// `ray` must be finite apart from an infinite `t_max`.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn new(ray: &Ray) -> Self {
        Self::with_scale(ray, ray.direction.to_array().map(reciprocal))
    }

    /// As [`Beam::new`] with the reciprocals of the direction at hand.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn with_scale(ray: &Ray, scale: [f32; 3]) -> Self {
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let shift = |slack: f32| {
            let each = |a: usize| o[a] * scale[a] + (o[a] * scale[a]).abs() * slack;
            Vec3x8::splat([each(0), each(1), each(2)])
        };
        Self {
            scale: Vec3x8::splat(scale),
            near_shift: shift(SLACK),
            far_shift: shift(-SLACK),
            near_row: [0, 1, 2].map(|a| 2 * a + usize::from(scale[a] < 0.0)),
            origin: Vec3x8::splat(o),
            direction: Vec3x8::splat(d),
            t_min: ray.t_min.max(0.0) + 0.0,
            t_max: ray.t_max,
        }
    }

    /// The entry distances of a node's boxes and a bit for each box entered before `t_max`.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn boxes(&self, node: &Node, t_max: f32) -> (__m256i, u32) {
        // SAFETY: rows are 2a or 2a + 1 for an axis a < 3, and so are they after `^ 1`.
        let plane = |row: usize| load(unsafe { node.planes.get_unchecked(row) });
        let [x, y, z] = self.near_row;
        let near_x = _mm256_fmsub_ps(plane(x), self.scale.x, self.near_shift.x);
        let near_y = _mm256_fmsub_ps(plane(y), self.scale.y, self.near_shift.y);
        let near_z = _mm256_fmsub_ps(plane(z), self.scale.z, self.near_shift.z);
        let far_x = _mm256_fmsub_ps(plane(x ^ 1), self.scale.x, self.far_shift.x);
        let far_y = _mm256_fmsub_ps(plane(y ^ 1), self.scale.y, self.far_shift.y);
        let far_z = _mm256_fmsub_ps(plane(z ^ 1), self.scale.z, self.far_shift.z);
        let t_min = _mm256_castps_si256(_mm256_set1_ps(self.t_min));
        let t_max = _mm256_castps_si256(_mm256_set1_ps(t_max));
        let near = max_bits(
            max_bits(bits(near_x), bits(near_y)),
            max_bits(bits(near_z), t_min),
        );
        let far = min_bits(
            min_bits(bits(far_x), bits(far_y)),
            min_bits(bits(far_z), t_max),
        );
        let missed = _mm256_castsi256_ps(_mm256_cmpgt_epi32(near, far));
        (near, !_mm256_movemask_ps(missed) as u32 & 0xff)
    }

    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn crossing<const TIGHT: bool>(&self, block: &Block) -> Crossing {
        Seen::<TIGHT>::new(block, self.origin).cross(self.direction)
    }
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn bits(v: __m256) -> __m256i {
    _mm256_castps_si256(v)
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn max_bits(a: __m256i, b: __m256i) -> __m256i {
    _mm256_max_epi32(a, b)
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn min_bits(a: __m256i, b: __m256i) -> __m256i {
    _mm256_min_epi32(a, b)
}

impl WideTree {
    #[inline]
    pub(super) fn node(&self, child: u32) -> &Node {
        debug_assert!(child & LEAF == 0 && child as usize + Node::LINES <= self.lines.len());
        // SAFETY: `collapse` sets `LEAF` or the first line of a node.
        unsafe { &*self.address(child).cast() }
    }

    #[inline]
    pub(super) fn block(&self, child: u32) -> &Block {
        debug_assert!(
            child & LEAF != 0 && (child & !LEAF) as usize + Block::LINES <= self.lines.len()
        );
        // SAFETY: `collapse` sets the first line of a block. Empty slots, which no ray enters, name
        // line 0, where any tree has five lines.
        unsafe { &*self.address(child).cast() }
    }

    #[inline]
    fn address(&self, child: u32) -> *const Line {
        self.lines.as_ptr().wrapping_add((child & !LEAF) as usize)
    }

    /// Asks for a child ahead of its visit.
    #[inline]
    pub(super) fn prefetch(&self, child: u32) {
        for line in 0..Block::LINES {
            let address = self.address(child).wrapping_add(line);
            // SAFETY: a prefetch reads nothing and cannot fault; SSE is part of x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast()) };
        }
    }
}

/// Whether anything is hit in `(t_min, t_max]`.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn occluded_ray<const TIGHT: bool>(tree: &WideTree, ray: &Ray, stack: &mut [u32]) -> bool {
    occluded::<TIGHT>(tree, &Beam::new(ray), 0, stack)
}

/// The closest hit in `(t_min, t_max]`.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn closest_ray<const TIGHT: bool>(
    tree: &WideTree,
    ray: &Ray,
    stack: &mut [u64],
) -> Option<Hit> {
    let mut best = None;
    closest::<TIGHT>(tree, &Beam::new(ray), 0, stack, &mut best);
    best
}

/// Whether anything below `child` is hit in `(t_min, t_max]`. `stack` holds
/// `tree.stack_entries` entries.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn occluded<const TIGHT: bool>(
    tree: &WideTree,
    beam: &Beam,
    child: u32,
    stack: &mut [u32],
) -> bool {
    let t_min = _mm256_set1_ps(beam.t_min);
    let t_max = _mm256_set1_ps(beam.t_max);
    let mut waiting = 0;
    let mut child = child;
    loop {
        if child & LEAF == 0 {
            let node = tree.node(child);
            let (_, entered) = beam.boxes(node, beam.t_max);
            if entered != 0 {
                let lowest = |lanes: u32| node.children[lanes.trailing_zeros() as usize & 7];
                let rest = entered & (entered - 1);
                push(node, rest, &mut stack[waiting..]);
                waiting += rest.count_ones() as usize;
                tree.prefetch(lowest(rest));
                tree.prefetch(lowest(rest & rest.wrapping_sub(1)));
                child = lowest(entered);
                continue;
            }
        } else if beam.crossing::<TIGHT>(tree.block(child)).hits(t_min, t_max) != 0 {
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

/// Writes the children of the set lanes, highest lane first, to the front of `top`, and anything to
/// the rest of its first eight entries: one permutation and one store without a branch.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn push(node: &Node, lanes: u32, top: &mut [u32]) {
    let order = load_bits(&FALLING[lanes as usize & 0xff]);
    let children = _mm256_permutevar8x32_epi32(load_bits(&node.children), order);
    store_bits(&mut top[..8], children);
}

/// `[m]`: the positions of the set bits of `m` from the highest to the lowest, then zeros.
static FALLING: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut left = mask as u32;
        let mut count = 0;
        while left != 0 {
            let highest = 31 - left.leading_zeros();
            table[mask][count] = highest;
            left ^= 1 << highest;
            count += 1;
        }
        mask += 1;
    }
    table
};

/// The closest hit below `child` in `(t_min, t_max]` that beats `best`. `stack` holds
/// `tree.stack_entries` entries: the bits of the entry distance above the child.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn closest<const TIGHT: bool>(
    tree: &WideTree,
    beam: &Beam,
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
                let first = entered.trailing_zeros() as usize & 7;
                let others = entered & (entered - 1);
                child = node.children[first];
                tree.prefetch(child);
                if others == 0 {
                    continue;
                }
                let near = store(_mm256_castsi256_ps(near));
                let second = others.trailing_zeros() as usize & 7;
                tree.prefetch(node.children[second]);
                if others & (others - 1) != 0 {
                    child = push_sorted(tree, node, (&near, entered), &mut stack[waiting..]);
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
            nearest_lane(&crossing, block, [beam.t_min, t_max], best);
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
fn entry(node: &Node, near: &[f32; 8], lane: usize) -> u64 {
    u64::from(near[lane & 7].to_bits()) << 32 | u64::from(node.children[lane & 7])
}

/// The nearest of three or more entered children; writes the others to `top`, from the farthest to
/// the nearest.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn push_sorted(
    tree: &WideTree,
    node: &Node,
    (near, entered): (&[f32; 8], u32),
    top: &mut [u64],
) -> u32 {
    let mut count = 0;
    for lane in set_bits(u64::from(entered)) {
        let next = entry(node, near, lane);
        tree.prefetch(next as u32);
        let mut at = count;
        while at > 0 && top[at - 1] < next {
            top[at] = top[at - 1];
            at -= 1;
        }
        top[at] = next;
        count += 1;
    }
    top[count - 1] as u32
}

/// Replaces `best` by the nearest of a block's hits in `(limits[0], limits[1]]` if that is nearer,
/// or as near with a smaller index; whether it did.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn nearest_lane(
    crossing: &Crossing,
    block: &Block,
    limits: [f32; 2],
    best: &mut Option<Hit>,
) -> bool {
    let [t_min, t_max] = limits;
    // The undivided test may round the other way than the division that decides below.
    let generous = _mm256_set1_ps(t_max * (1.0 + SLACK));
    let mut hits = crossing.hits(_mm256_set1_ps(t_min), generous);
    if hits == 0 {
        return false;
    }
    let divided = |v: __m256| store(_mm256_div_ps(v, crossing.denominator));
    let t = divided(crossing.t);
    let mut found = None;
    let mut limit = (t_max, best.map_or(u32::MAX, |hit| hit.triangle));
    while hits != 0 {
        let lane = hits.trailing_zeros() as usize & 7;
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
            u: divided(crossing.u)[lane],
            v: divided(crossing.v)[lane],
            triangle: block.id[lane],
        });
    }
    found.is_some()
}
