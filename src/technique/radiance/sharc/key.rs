//! Cells of a grid that is coarser the further it is from the camera, and their 64-bit keys (SHaRC, hash grid).

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::technique::Shot;

/// Bits of a coordinate, a signed whole number of cells.
const POSITION_BITS: u32 = 17;
/// Bits of the level.
const LEVEL_BITS: u32 = 10;
const POSITION_MASK: u64 = (1 << POSITION_BITS) - 1;
const LEVEL_MASK: u64 = (1 << LEVEL_BITS) - 1;
/// Level whose cells have a side of one scene unit. Sides of all `f32` lie well within the levels.
const LEVEL_OF_UNIT: i32 = 512;
/// Added to positions, over the distance to the camera, so that walls along the faces of cells lie in one cell.
const POSITION_BIAS: f32 = 1e-4;
/// Added to normals, so that those along an axis lie in one octant.
const NORMAL_BIAS: f32 = 1e-3;

/// A cell: position in its level's grid, level, octant of the normal. No key is 0, which stands for an empty slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key(u64);

impl Key {
    /// The key of no cell.
    pub const EMPTY: Self = Self(0);

    /// `position` within ±2¹⁶ cells, `level` in 1..1024, `octant` below 8.
    pub fn new(position: [i32; 3], level: u32, octant: u32) -> Self {
        let [x, y, z] = position.map(|p| p as u64 & POSITION_MASK);
        let level = u64::from(level) & LEVEL_MASK;
        let position = x | y << POSITION_BITS | z << (2 * POSITION_BITS);
        let above = level | u64::from(octant) << LEVEL_BITS;
        Self(position | above << (3 * POSITION_BITS))
    }

    /// Position in the grid of the level.
    pub fn position(self) -> [i32; 3] {
        [0, 1, 2].map(|axis| {
            let bits = (self.0 >> (axis * POSITION_BITS) & POSITION_MASK) as i32;
            // Carries the sign upwards.
            bits << (32 - POSITION_BITS) >> (32 - POSITION_BITS)
        })
    }

    /// Sides double from one level to the next.
    pub fn level(self) -> u32 {
        (self.0 >> (3 * POSITION_BITS) & LEVEL_MASK) as u32
    }

    /// Signs of the normal: bit `axis` is set where it points backwards.
    pub fn octant(self) -> u32 {
        (self.0 >> (3 * POSITION_BITS + LEVEL_BITS)) as u32
    }

    /// Spread over 32 bits: Jenkins' hash of either half.
    pub fn hash(self) -> u32 {
        jenkins(self.0 as u32) ^ jenkins((self.0 >> 32) as u32)
    }

    /// The cell of the next coarser level that this one is part of.
    pub fn parent(self) -> Self {
        Self::new(
            self.position().map(|p| p >> 1),
            self.level() + 1,
            self.octant(),
        )
    }

    /// The cells of the next finer level that are part of this one and can be told apart by their keys.
    pub fn children(self) -> impl Iterator<Item = Self> {
        const LIMIT: i32 = 1 << (POSITION_BITS - 1);
        let first = self.position().map(|p| 2 * p);
        (0..8).filter_map(move |child| {
            let position = [0, 1, 2].map(|axis| first[axis] + (child >> axis & 1));
            let fits = position.iter().all(|p| (-LIMIT..LIMIT).contains(p));
            fits.then(|| Self::new(position, self.level() - 1, self.octant()))
        })
    }
}

/// Bob Jenkins' hash of 32 bits by additions, shifts and exclusive ors.
fn jenkins(mut a: u32) -> u32 {
    a = a.wrapping_add(0x7ed5_5d16).wrapping_add(a << 12);
    a = (a ^ 0xc761_c23c) ^ (a >> 19);
    a = a.wrapping_add(0x1656_67b1).wrapping_add(a << 5);
    a = a.wrapping_add(0xd3a2_646c) ^ (a << 9);
    a = a.wrapping_add(0xfd70_46c5).wrapping_add(a << 3);
    (a ^ 0xb55a_4f09) ^ (a >> 16)
}

/// A cell that a point lies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub key: Key,
    /// Side of the cell, scene units.
    pub side: f32,
}

/// The grid about one camera.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    camera: DVec3,
    /// Side of a cell over its distance to the camera.
    slope: f32,
}

impl Grid {
    /// Cells whose sides are about `cell_pixels` projected pixels, within a factor √2.
    pub fn new(shot: &Shot, cell_pixels: f32) -> Self {
        let [_, half] = shot.view.half_tangents(shot.width, shot.height);
        let pixel_angle = 2.0 * half / shot.height as f64;
        Self::about(shot.view.origin, cell_pixels * pixel_angle as f32)
    }

    /// Cells about a camera whose sides are about `slope` times their distance to it.
    pub fn about(camera: DVec3, slope: f32) -> Self {
        Self { camera, slope }
    }

    /// The cell of a surface point with its unit normal; `None` for what is not finite.
    ///
    /// The side is the power of two scene units nearest to what is wanted, so that cameras with other lenses and films
    /// share cells. *Differs:* a position beyond 2¹⁶ cells from the origin takes the finest level that can number it,
    /// where SHaRC wraps around to the key of another cell.
    pub fn place(&self, position: Vec3, normal: Vec3) -> Option<Place> {
        let distance = position.as_dvec3().distance(self.camera) as f32;
        let biased = position + POSITION_BIAS * distance;
        let wanted = distance * self.slope * std::f32::consts::SQRT_2;
        if !(biased.is_finite() && normal.is_finite() && wanted.is_finite()) {
            return None;
        }
        let numbered = exponent(biased.abs().max_element()) + 2 - POSITION_BITS as i32;
        let power = exponent(wanted).max(numbered).max(-126);
        let side = f32::from_bits(((power + 127) as u32) << 23);
        let cell = (biased.as_dvec3() / f64::from(side)).floor().as_ivec3();
        let level = (power + LEVEL_OF_UNIT) as u32;
        Some(Place {
            key: Key::new(cell.to_array(), level, octant(normal)),
            side,
        })
    }
}

/// The power of two at or below a number that is not negative; −126 for what is smaller.
fn exponent(x: f32) -> i32 {
    ((x.to_bits() >> 23) as i32 - 127).max(-126)
}

fn octant(normal: Vec3) -> u32 {
    (0..3)
        .filter(|axis| normal[*axis] + NORMAL_BIAS < 0.0)
        .map(|axis| 1 << axis)
        .sum()
}
