//! A tile of up to 64 rays of one origin, and how it meets the boxes of a node.

use std::arch::x86_64::*;

use glam::Vec3;

use super::query::Bundle;
use super::single::{Beam, reciprocal};
use super::vector::{Vec3x8, load, store};
use super::wide::Node;
use super::{Hit, Ray};

/// Rays of a tile.
pub const TILE: usize = 64;
/// Bounds the rounding of a box's distance.
const SLACK: f32 = 4.0 * f32::EPSILON;
/// Bounds the rounding of slopes, with plenty to spare.
const SLOPE_SLACK: f32 = 1e-5;

/// The positions of the set bits.
pub fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let k = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (k < 64).then_some(k)
    })
}

/// How directions are dealt to tiles: a row-major square grid in tiles of 8×8, each in groups of
/// 4×2; anything else as it comes.
#[derive(Clone, Copy)]
pub struct Order {
    /// Side of the grid in directions, 0 if there is none.
    side: usize,
}

impl Order {
    pub fn new(directions: usize) -> Self {
        let side = directions.isqrt();
        let is_grid = side * side == directions && side.is_multiple_of(8);
        Self {
            side: if is_grid { side } else { 0 },
        }
    }

    pub fn index(self, k: usize) -> usize {
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
pub struct Tile<'a> {
    pub bundle: &'a Bundle<'a>,
    pub origin: [f32; 3],
    pub directions: [Vec3; TILE],
    /// `1/d` by axis, eight rays a group.
    scale: [[[f32; 8]; 8]; 3],
    /// Bits of the rays present.
    pub rays: u64,
    /// Limit of each ray, eight a group; 0 for absent rays.
    pub t_max: [[f32; 8]; 8],
    pub cone: Option<Cone>,
    /// Rows of the near planes if all rays have the same signs.
    near_row: Option<[usize; 3]>,
}

impl<'a> Tile<'a> {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn new(bundle: &'a Bundle, order: Order, start: usize) -> Self {
        let count = TILE.min(bundle.directions.len() - start);
        let mut tile = Self {
            bundle,
            origin: bundle.origin.to_array(),
            directions: [Vec3::ZERO; TILE],
            scale: [[[1.0; 8]; 8]; 3],
            rays: u64::MAX >> (TILE - count),
            t_max: [[0.0; 8]; 8],
            cone: None,
            near_row: None,
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
        let sign = |d: &Vec3| d.is_negative_bitmask();
        let first = sign(&tile.directions[0]);
        if tile.directions[..count].iter().all(|d| sign(d) == first) {
            tile.near_row = Some([0, 1, 2].map(|a| 2 * a + (first as usize >> a & 1)));
        }
        tile
    }

    /// The rays of `rays` that enter the box of a slot before their limits, a bit a ray.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn entering(&self, planes: &Relative, lane: usize, rays: u64) -> u64 {
        match self.near_row {
            Some(near) => self.entering_as::<true>(planes, near, lane, rays),
            None => self.entering_as::<false>(planes, [0, 2, 4], lane, rays),
        }
    }

    /// As [`Tile::entering`]; `ALIKE` says that all rays have their near planes in rows `near`.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn entering_as<const ALIKE: bool>(
        &self,
        planes: &Relative,
        near: [usize; 3],
        lane: usize,
        rays: u64,
    ) -> u64 {
        let first = near.map(|row| _mm256_set1_ps(planes.rows[row][lane]));
        let second = near.map(|row| _mm256_set1_ps(planes.rows[row ^ 1][lane]));
        let mut entering = 0;
        for group in 0..8 {
            if rays >> (8 * group) & 0xff == 0 {
                continue;
            }
            let mut near = _mm256_setzero_ps();
            let mut far = load(&self.t_max[group]);
            for axis in 0..3 {
                let scale = load(&self.scale[axis][group]);
                let a = _mm256_mul_ps(first[axis], scale);
                let b = _mm256_mul_ps(second[axis], scale);
                let (a, b) = if ALIKE {
                    (a, b)
                } else {
                    (_mm256_min_ps(a, b), _mm256_max_ps(a, b))
                };
                near = _mm256_max_ps(near, a);
                far = _mm256_min_ps(far, b);
            }
            let entered = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far));
            entering |= (entered as u64) << (8 * group);
        }
        entering & rays
    }

    /// A ray that goes on alone.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn beam(&self, k: usize) -> Beam {
        let ray = Ray {
            t_max: self.bundle.t_max,
            ..Ray::new(self.bundle.origin, self.directions[k])
        };
        Beam::with_scale(&ray, self.reciprocal(k))
    }

    /// The direction of a ray.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn direction(&self, k: usize) -> Vec3x8 {
        Vec3x8::splat(self.directions[k].to_array())
    }

    /// `1/d` of a ray.
    #[inline]
    fn reciprocal(&self, k: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis: usize| self.scale[axis][k / 8][k % 8])
    }
}

/// The slopes of a tile's directions along their common main axis.
pub struct Cone {
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
    pub fn reaches(&self, planes: &Relative) -> u32 {
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
pub struct Relative {
    rows: [[f32; 8]; 6],
    /// Squared distance from the origin; infinite for empty slots.
    pub distance_squared: [f32; 8],
}

impl Relative {
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn new(node: &Node, origin: &[f32; 3]) -> Self {
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
    pub fn within(&self, distance_squared: f32) -> u32 {
        let limit = _mm256_set1_ps(distance_squared);
        let within = _mm256_cmp_ps::<_CMP_LE_OQ>(load(&self.distance_squared), limit);
        _mm256_movemask_ps(within) as u32
    }
}

/// The square of a distance, rounded up and finite, so that an empty slot is always beyond.
pub fn reach_squared(t_max: f32) -> f32 {
    (t_max * t_max * (1.0 + SLOPE_SLACK)).min(f32::MAX)
}

impl Tile<'_> {
    /// The rays of `rays` whose limits are not nearer than the square of a distance.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn reaching(&self, distance_squared: f32, rays: u64) -> u64 {
        let distance = _mm256_set1_ps(distance_squared.sqrt() * (1.0 - SLOPE_SLACK));
        let mut reaching = 0;
        for (group, limits) in self.t_max.iter().enumerate() {
            let beyond = _mm256_cmp_ps::<_CMP_GE_OQ>(load(limits), distance);
            reaching |= (_mm256_movemask_ps(beyond) as u64) << (8 * group);
        }
        reaching & rays
    }

    /// Makes the hits of `rays` their limits and returns the square of the largest limit.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn shorten(&mut self, best: &[Option<Hit>; TILE], rays: u64) -> f32 {
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
