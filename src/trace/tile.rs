//! A tile of up to 64 rays of one origin, and how it meets the boxes of a node.

use glam::Vec3;

use super::lanes::Floats;
use super::query::Bundle;
use super::single::{Beam, reciprocal};
use super::triangle::Vectors;
use super::wide::Node;
use super::{Hit, Ray};

/// Rays of a tile.
pub const TILE: usize = 64;
/// Rays that are tested at a time make a group; of the fewest lanes there are so many.
const MOST_GROUPS: usize = 8;
/// The sign of a float.
const SIGN: u32 = 1 << 31;
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
/// 4×4, each in halves of 4×2; anything else as it comes.
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
        let (tile, group, lane) = (k / TILE, k / 16 % 4, k % 16);
        let (tile_x, tile_y) = (tile % (self.side / 8), tile / (self.side / 8));
        let x = 8 * tile_x + 4 * (group % 2) + lane % 4;
        let y = 8 * tile_y + 4 * (group / 2) + lane / 4;
        y * self.side + x
    }
}

/// Up to 64 rays of one origin.
pub struct Tile<'a, F: Floats> {
    present: F::Present,
    pub bundle: &'a Bundle<'a>,
    pub origin: [f32; 3],
    pub directions: [Vec3; TILE],
    /// `1/d` by axis and group.
    scale: [[F::Row; MOST_GROUPS]; 3],
    /// Bits of the rays present.
    pub rays: u64,
    /// Limit of each ray by group; 0 for absent rays.
    pub t_max: [F::Row; MOST_GROUPS],
    pub cone: Option<Cone>,
    /// Rows of the near planes if all rays have the same signs.
    near_row: Option<[usize; 3]>,
}

impl<'a, F: Floats> Tile<'a, F> {
    #[inline(always)]
    pub fn new(present: F::Present, bundle: &'a Bundle, order: Order, start: usize) -> Self {
        let count = TILE.min(bundle.directions.len() - start);
        let mut tile = Self {
            present,
            bundle,
            origin: bundle.origin.to_array(),
            directions: [Vec3::ZERO; TILE],
            scale: [[F::splat(present, 1.0).store(); MOST_GROUPS]; 3],
            rays: u64::MAX >> (TILE - count),
            t_max: [F::splat(present, 0.0).store(); MOST_GROUPS],
            cone: None,
            near_row: None,
        };
        for k in 0..count {
            let direction = bundle.directions[order.index(start + k)];
            tile.directions[k] = direction;
            tile.t_max[k / F::LANES][k % F::LANES] = bundle.t_max;
            for axis in 0..3 {
                tile.scale[axis][k / F::LANES][k % F::LANES] = reciprocal(direction[axis]);
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
    #[inline(always)]
    pub fn entering(&self, planes: &Relative<F>, lane: usize, rays: u64) -> u64 {
        match self.near_row {
            Some(near) => self.entering_as::<true>(planes, near, lane, rays),
            None => self.entering_as::<false>(planes, [0, 2, 4], lane, rays),
        }
    }

    /// As [`Tile::entering`]; `ALIKE` says that all rays have their near planes in rows `near`.
    #[inline(always)]
    fn entering_as<const ALIKE: bool>(
        &self,
        planes: &Relative<F>,
        near: [usize; 3],
        lane: usize,
        rays: u64,
    ) -> u64 {
        let splat = |row: usize| F::splat(self.present, planes.rows[row][lane]);
        let first = [splat(near[0]), splat(near[1]), splat(near[2])];
        let second = [splat(near[0] ^ 1), splat(near[1] ^ 1), splat(near[2] ^ 1)];
        let mut entering = 0;
        for group in 0..TILE / F::LANES {
            if rays >> (F::LANES * group) & (u64::MAX >> (TILE - F::LANES)) == 0 {
                continue;
            }
            let mut near = F::splat(self.present, 0.0);
            let mut far = F::load(self.present, &self.t_max[group]);
            for axis in 0..3 {
                let scale = F::load(self.present, &self.scale[axis][group]);
                let (a, b) = (first[axis] * scale, second[axis] * scale);
                let (a, b) = if ALIKE { (a, b) } else { (a.min(b), a.max(b)) };
                near = near.max(a);
                far = far.min(b);
            }
            entering |= u64::from(near.le(far)) << (F::LANES * group);
        }
        entering & rays
    }

    /// A ray that goes on alone.
    #[inline(always)]
    pub fn beam(&self, k: usize) -> Beam<F> {
        let ray = Ray {
            t_max: self.bundle.t_max,
            ..Ray::new(self.bundle.origin, self.directions[k])
        };
        Beam::with_scale(self.present, &ray, self.reciprocal(k))
    }

    /// The direction of a ray.
    #[inline(always)]
    pub fn direction(&self, k: usize) -> Vectors<F> {
        Vectors::splat(self.present, self.directions[k].to_array())
    }

    /// `1/d` of a ray.
    #[inline]
    fn reciprocal(&self, k: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis: usize| self.scale[axis][k / F::LANES][k % F::LANES])
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
    #[inline(always)]
    pub fn reaches<F: Floats>(&self, present: F::Present, planes: &Relative<F>) -> u32 {
        let zero = F::splat(present, 0.0);
        let row = |row: usize| F::load(present, &planes.rows[row]);
        let (low, high) = (row(2 * self.axis), row(2 * self.axis + 1));
        let (near, far) = if self.negative {
            (zero - high, zero - low)
        } else {
            (low, high)
        };
        let near = near.max(zero);
        let mut reaches = zero.le(far);
        for &(axis, low, high) in &self.slopes {
            let top = F::splat(present, high) * if high > 0.0 { far } else { near };
            let bottom = F::splat(present, low) * if low > 0.0 { near } else { far };
            reaches &= row(2 * axis).le(top) & bottom.le(row(2 * axis + 1));
        }
        reaches
    }
}

/// The planes of a node's boxes relative to the origin, moved outwards by the rounding of the tests.
pub struct Relative<F: Floats> {
    rows: [F::Row; 6],
    /// Squared distance from the origin; infinite for empty slots.
    pub distance_squared: F::Row,
}

impl<F: Floats> Relative<F> {
    #[inline(always)]
    pub fn new(present: F::Present, node: &Node<F>, origin: &[f32; 3]) -> Self {
        let magnitude = F::splat(present, f32::from_bits(!SIGN));
        let slack = F::splat(present, SLACK);
        let zero = F::splat(present, 0.0);
        let mut rows = [zero.store(); 6];
        let mut distance_squared = zero;
        for axis in 0..3 {
            let o = F::splat(present, origin[axis]);
            let low = F::load(present, &node.planes[2 * axis]) - o;
            let high = F::load(present, &node.planes[2 * axis + 1]) - o;
            let low = low.and(magnitude).neg_mul_add(slack, low);
            let high = high.and(magnitude).mul_add(slack, high);
            let gap = low.max(zero - high).max(zero);
            distance_squared = gap.mul_add(gap, distance_squared);
            rows[2 * axis] = low.store();
            rows[2 * axis + 1] = high.store();
        }
        Self {
            rows,
            distance_squared: distance_squared.store(),
        }
    }

    /// A bit for each box within a squared distance.
    #[inline(always)]
    pub fn within(&self, present: F::Present, distance_squared: f32) -> u32 {
        F::load(present, &self.distance_squared).le(F::splat(present, distance_squared))
    }
}

/// The square of a distance, rounded up and finite, so that an empty slot is always beyond.
pub fn reach_squared(t_max: f32) -> f32 {
    (t_max * t_max * (1.0 + SLOPE_SLACK)).min(f32::MAX)
}

impl<F: Floats> Tile<'_, F> {
    /// The rays of `rays` whose limits are not nearer than the square of a distance.
    #[inline(always)]
    pub fn reaching(&self, distance_squared: f32, rays: u64) -> u64 {
        let distance = F::splat(self.present, distance_squared.sqrt() * (1.0 - SLOPE_SLACK));
        let mut reaching = 0;
        for (group, limits) in self.t_max[..TILE / F::LANES].iter().enumerate() {
            let beyond = distance.le(F::load(self.present, limits));
            reaching |= u64::from(beyond) << (F::LANES * group);
        }
        reaching & rays
    }

    /// Makes the hits of `rays` their limits and returns the square of the largest limit.
    #[inline(always)]
    pub fn shorten(&mut self, best: &[Option<Hit>; TILE], rays: u64) -> f32 {
        for k in bits(rays) {
            if let Some(hit) = best[k] {
                self.t_max[k / F::LANES][k % F::LANES] = hit.t;
            }
        }
        let mut largest = F::load(self.present, &self.t_max[0]);
        for limits in &self.t_max[1..TILE / F::LANES] {
            largest = largest.max(F::load(self.present, limits));
        }
        let row = largest.store();
        reach_squared((0..F::LANES).map(|lane| row[lane]).fold(0.0, f32::max))
    }
}
