//! Many rays of one origin, 64 at a time: a tile of neighbouring directions descends the tree
//! together, so that nodes and triangles are fetched and prepared once for all of them.
//!
//! - A stack entry is a child with a mask of the rays that enter it; rays that are settled meanwhile
//!   drop out when it is popped.
//! - A node's eight boxes, taken relative to the origin, are first culled at once against the cone
//!   around the tile (its slopes along the main axis) and against `t_max`; each box left is tested
//!   against groups of eight rays.
//! - A leaf prepares its triangles once ([`Seen`]); a ray then costs three dot products.
//! - When few rays are left, they go on alone with the single-ray kernel.
//!
//! Which path a ray takes never changes its answer: box tests lose no hit, and the triangle tests are
//! the same operations in the same order.

use std::arch::x86_64::*;

use glam::Vec3;

use super::Hit;
use super::query::{Bundle, Scratch, Waiting};
use super::single::{self, Beam, nearest_lane, reciprocal};
use super::vector::{Seen, Vec3x8, load, store};
use super::wide::{LEAF, Node, WideTree};

/// Rays of a tile.
const TILE: usize = 64;
/// With this many rays or fewer, rays go on alone.
const FEW: u32 = 8;
/// Bounds the rounding of a box's distance.
const SLACK: f32 = 4.0 * f32::EPSILON;
/// Bounds the rounding of slopes, with plenty to spare.
const SLOPE_SLACK: f32 = 1e-5;

/// See [`super::Caster::occluded_bundle`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn occluded(tree: &WideTree, bundle: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
    let order = Order::new(bundle.directions.len());
    for start in (0..bundle.directions.len()).step_by(TILE) {
        let tile = Tile::new(bundle, order, start);
        let blocked = occluded_tile(tree, &tile, scratch);
        for k in bits(blocked) {
            let i = order.index(start + k);
            occluded[i / 64] |= 1 << (i % 64);
        }
    }
}

/// See [`super::Caster::closest_bundle`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn closest(tree: &WideTree, bundle: &Bundle, scratch: &mut Scratch, hits: &mut [Option<Hit>]) {
    let order = Order::new(bundle.directions.len());
    for start in (0..bundle.directions.len()).step_by(TILE) {
        let mut tile = Tile::new(bundle, order, start);
        let found = closest_tile(tree, &mut tile, scratch);
        for k in bits(tile.rays) {
            hits[order.index(start + k)] = found[k];
        }
    }
}

/// The positions of the set bits.
fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let k = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (k < 64).then_some(k)
    })
}

/// How directions are dealt to tiles: a row-major square grid in tiles of 8×8, each in groups of
/// 4×2; anything else as it comes.
#[derive(Clone, Copy)]
struct Order {
    /// Side of the grid in directions, 0 if there is none.
    side: usize,
}

impl Order {
    fn new(directions: usize) -> Self {
        let side = directions.isqrt();
        let is_grid = side * side == directions && side.is_multiple_of(8);
        Self {
            side: if is_grid { side } else { 0 },
        }
    }

    fn index(self, k: usize) -> usize {
        if self.side == 0 {
            return k;
        }
        let (tile, group, lane) = (k / 64, k / 8 % 8, k % 8);
        let (tile_x, tile_y) = (tile % (self.side / 8), tile / (self.side / 8));
        let x = 8 * tile_x + 4 * (group % 2) + lane % 4;
        let y = 8 * tile_y + 2 * (group / 2) + lane / 4;
        y * self.side + x
    }
}

/// Up to 64 rays of one origin.
struct Tile<'a> {
    bundle: &'a Bundle<'a>,
    origin: [f32; 3],
    directions: [Vec3; TILE],
    /// `1/d` by axis, eight rays a group.
    scale: [[[f32; 8]; 8]; 3],
    /// Bits of the rays present.
    rays: u64,
    /// Limit of each ray, eight a group; 0 for absent rays.
    t_max: [[f32; 8]; 8],
    cone: Option<Cone>,
}

impl<'a> Tile<'a> {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn new(bundle: &'a Bundle, order: Order, start: usize) -> Self {
        let count = TILE.min(bundle.directions.len() - start);
        let mut tile = Self {
            bundle,
            origin: bundle.origin.to_array(),
            directions: [Vec3::ZERO; TILE],
            scale: [[[1.0; 8]; 8]; 3],
            rays: u64::MAX >> (TILE - count),
            t_max: [[0.0; 8]; 8],
            cone: None,
        };
        for k in 0..count {
            let direction = bundle.directions[order.index(start + k)];
            tile.directions[k] = direction;
            tile.t_max[k / 8][k % 8] = bundle.t_max;
            for axis in 0..3 {
                tile.scale[axis][k / 8][k % 8] = reciprocal(direction[axis]);
            }
        }
        tile.cone = Cone::around(&tile.directions[..count]);
        tile
    }

    /// The rays of `rays` that enter a box before their limits. A bit a ray; `planes` is relative to
    /// the origin.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn entering(&self, planes: &Relative, lane: usize, rays: u64) -> u64 {
        let low = [0, 1, 2].map(|axis| _mm256_set1_ps(planes.rows[2 * axis][lane]));
        let high = [0, 1, 2].map(|axis| _mm256_set1_ps(planes.rows[2 * axis + 1][lane]));
        let mut entering = 0;
        for group in 0..8 {
            if rays >> (8 * group) & 0xff == 0 {
                continue;
            }
            let mut near = _mm256_setzero_ps();
            let mut far = load(&self.t_max[group]);
            for axis in 0..3 {
                let scale = load(&self.scale[axis][group]);
                let (a, b) = (
                    _mm256_mul_ps(low[axis], scale),
                    _mm256_mul_ps(high[axis], scale),
                );
                near = _mm256_max_ps(near, _mm256_min_ps(a, b));
                far = _mm256_min_ps(far, _mm256_max_ps(a, b));
            }
            let entered = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
            entering |= (entered as u64) << (8 * group);
        }
        entering & rays
    }

    fn beam_ray(&self, k: usize) -> super::Ray {
        super::Ray {
            t_max: self.bundle.t_max,
            ..super::Ray::new(self.bundle.origin, self.directions[k])
        }
    }
}

/// The slopes of a tile's directions along their common main axis.
struct Cone {
    axis: usize,
    /// The directions point along `+axis` or `−axis`.
    negative: bool,
    /// For the two other axes: the axis, the smallest and the largest slope.
    slopes: [(usize, f32, f32); 2],
}

impl Cone {
    /// `None` when the directions have no main axis in common.
    fn around(directions: &[Vec3]) -> Option<Self> {
        let sum: Vec3 = directions.iter().sum();
        let axis = sum.abs().max_position();
        let negative = sum[axis] < 0.0;
        let along = |d: &Vec3| if negative { -d[axis] } else { d[axis] };
        if !directions.iter().all(|d| along(d) > 0.01) {
            return None;
        }
        let slopes = [(axis + 1) % 3, (axis + 2) % 3].map(|other| {
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for d in directions {
                let slope = d[other] / along(d);
                (low, high) = (low.min(slope), high.max(slope));
            }
            let slack = SLOPE_SLACK * (1.0 + low.abs().max(high.abs()));
            (other, low - slack, high + slack)
        });
        Some(Self {
            axis,
            negative,
            slopes,
        })
    }

    /// A bit for each box that reaches into the cone.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn reaches(&self, planes: &Relative) -> u32 {
        let zero = _mm256_setzero_ps();
        let (low, high) = (
            load(&planes.rows[2 * self.axis]),
            load(&planes.rows[2 * self.axis + 1]),
        );
        let (near, far) = if self.negative {
            (_mm256_sub_ps(zero, high), _mm256_sub_ps(zero, low))
        } else {
            (low, high)
        };
        let near = _mm256_max_ps(near, zero);
        let mut reaches = _mm256_cmp_ps::<_CMP_GE_OQ>(far, zero);
        for &(axis, low, high) in &self.slopes {
            let widest = |slope: f32, at: __m256| _mm256_mul_ps(_mm256_set1_ps(slope), at);
            let top = widest(high, if high > 0.0 { far } else { near });
            let bottom = widest(low, if low > 0.0 { near } else { far });
            let below = _mm256_cmp_ps::<_CMP_LE_OQ>(load(&planes.rows[2 * axis]), top);
            let above = _mm256_cmp_ps::<_CMP_GE_OQ>(load(&planes.rows[2 * axis + 1]), bottom);
            reaches = _mm256_and_ps(reaches, _mm256_and_ps(below, above));
        }
        _mm256_movemask_ps(reaches) as u32
    }
}

/// The planes of a node's boxes relative to the origin, moved outwards by the rounding of the tests.
struct Relative {
    rows: [[f32; 8]; 6],
    /// Squared distance from the origin; infinite for empty slots.
    distance_squared: [f32; 8],
}

impl Relative {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn new(node: &Node, origin: &[f32; 3]) -> Self {
        let sign = _mm256_set1_ps(-0.0);
        let slack = _mm256_set1_ps(SLACK);
        let zero = _mm256_setzero_ps();
        let mut rows = [[0.0; 8]; 6];
        let mut distance_squared = zero;
        for axis in 0..3 {
            let o = _mm256_set1_ps(origin[axis]);
            let low = _mm256_sub_ps(load(&node.planes[2 * axis]), o);
            let high = _mm256_sub_ps(load(&node.planes[2 * axis + 1]), o);
            let low = _mm256_fnmadd_ps(_mm256_andnot_ps(sign, low), slack, low);
            let high = _mm256_fmadd_ps(_mm256_andnot_ps(sign, high), slack, high);
            let gap = _mm256_max_ps(_mm256_max_ps(low, _mm256_sub_ps(zero, high)), zero);
            distance_squared = _mm256_fmadd_ps(gap, gap, distance_squared);
            rows[2 * axis] = store(low);
            rows[2 * axis + 1] = store(high);
        }
        Self {
            rows,
            distance_squared: store(distance_squared),
        }
    }

    /// A bit for each box within a squared distance.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn within(&self, distance_squared: f32) -> u32 {
        let limit = _mm256_set1_ps(distance_squared);
        let within = _mm256_cmp_ps::<_CMP_LE_OQ>(load(&self.distance_squared), limit);
        _mm256_movemask_ps(within) as u32
    }
}

/// The square of a distance, rounded up and finite, so that an empty slot is always beyond.
fn reach_squared(t_max: f32) -> f32 {
    (t_max * t_max * (1.0 + SLOPE_SLACK)).min(f32::MAX)
}

/// The rays of a tile that are blocked.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_tile(tree: &WideTree, tile: &Tile, scratch: &mut Scratch) -> u64 {
    let origin = Vec3x8::splat(tile.origin);
    let reach = reach_squared(tile.bundle.t_max);
    let t_max = _mm256_set1_ps(tile.bundle.t_max);
    let mut alive = tile.rays;
    let stack = &mut scratch.tiles;
    stack[0] = Waiting {
        rays: alive,
        ..Waiting::default()
    };
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let Waiting { rays, child, .. } = stack[waiting];
        let rays = rays & alive;
        if child & LEAF != 0 {
            let seen = Seen::new(tree.block(child), origin);
            for k in bits(rays) {
                let crossing = seen.cross(Vec3x8::splat(tile.directions[k].to_array()));
                if crossing.hits(_mm256_setzero_ps(), t_max) != 0 {
                    alive ^= 1 << k;
                }
            }
        } else if rays.count_ones() <= FEW {
            for k in bits(rays) {
                let beam = Beam::new(&tile.beam_ray(k));
                if single::occluded(tree, &beam, child, &mut scratch.children) {
                    alive ^= 1 << k;
                }
            }
        } else {
            let node = tree.node(child);
            let planes = Relative::new(node, &tile.origin);
            let mut boxes = planes.within(reach);
            if let Some(cone) = &tile.cone {
                boxes &= cone.reaches(&planes);
            }
            while boxes != 0 {
                let lane = 31 - boxes.leading_zeros() as usize;
                boxes ^= 1 << lane;
                let entering = tile.entering(&planes, lane, rays);
                if entering != 0 {
                    tree.prefetch(node.children[lane]);
                    stack[waiting] = Waiting {
                        rays: entering,
                        child: node.children[lane],
                        distance_squared: 0.0,
                    };
                    waiting += 1;
                }
            }
        }
    }
    tile.rays & !alive
}

/// The closest hits of a tile, which also become the limits of its rays.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn closest_tile(tree: &WideTree, tile: &mut Tile, scratch: &mut Scratch) -> [Option<Hit>; TILE] {
    let origin = Vec3x8::splat(tile.origin);
    let mut best = [None; TILE];
    let mut reach = reach_squared(tile.bundle.t_max);
    let stack = &mut scratch.tiles;
    stack[0] = Waiting {
        rays: tile.rays,
        ..Waiting::default()
    };
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let Waiting {
            rays,
            child,
            distance_squared,
        } = stack[waiting];
        if distance_squared > reach {
            continue;
        }
        if child & LEAF != 0 {
            let block = tree.block(child);
            let seen = Seen::new(block, origin);
            for k in bits(rays) {
                let crossing = seen.cross(Vec3x8::splat(tile.directions[k].to_array()));
                let limits = [0.0, tile.t_max[k / 8][k % 8]];
                nearest_lane(&crossing, block, limits, &mut best[k]);
            }
            reach = tile.shorten(&best, rays);
        } else if rays.count_ones() <= FEW {
            for k in bits(rays) {
                let beam = Beam::new(&tile.beam_ray(k));
                single::closest(tree, &beam, child, &mut scratch.sorted, &mut best[k]);
            }
            reach = tile.shorten(&best, rays);
        } else {
            let node = tree.node(child);
            let planes = Relative::new(node, &tile.origin);
            let mut boxes = planes.within(reach);
            if let Some(cone) = &tile.cone {
                boxes &= cone.reaches(&planes);
            }
            let first = waiting;
            while boxes != 0 {
                let lane = boxes.trailing_zeros() as usize & 7;
                boxes &= boxes - 1;
                let entering = tile.entering(&planes, lane, rays);
                if entering == 0 {
                    continue;
                }
                tree.prefetch(node.children[lane]);
                let entry = Waiting {
                    rays: entering,
                    child: node.children[lane],
                    distance_squared: planes.distance_squared[lane],
                };
                insert(&mut stack[first..=waiting], entry);
                waiting += 1;
            }
        }
    }
    best
}

/// Puts an entry into its place in a run sorted from far to near, whose last place is free.
fn insert(run: &mut [Waiting], entry: Waiting) {
    let mut at = run.len() - 1;
    while at > 0 && run[at - 1].distance_squared < entry.distance_squared {
        run[at] = run[at - 1];
        at -= 1;
    }
    run[at] = entry;
}

impl Tile<'_> {
    /// Makes the hits of `rays` their limits and returns the square of the largest limit.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn shorten(&mut self, best: &[Option<Hit>; TILE], rays: u64) -> f32 {
        for k in bits(rays) {
            if let Some(hit) = best[k] {
                self.t_max[k / 8][k % 8] = hit.t;
            }
        }
        let mut largest = load(&self.t_max[0]);
        for group in 1..8 {
            largest = _mm256_max_ps(largest, load(&self.t_max[group]));
        }
        reach_squared(store(largest).into_iter().fold(0.0, f32::max))
    }
}
