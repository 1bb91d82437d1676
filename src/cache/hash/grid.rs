//! The cube around a scene and the keys of its cells.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The most levels of a grid: three times as many bits fit a key.
pub const MOST_LEVELS: u32 = 20;

/// Share of the longest extent that the cube leaves free on either side.
const MARGIN: f64 = 1e-5;

/// Least distance, in cells of the finest level, at which a triangle still touches a cell.
const LEAST_SLACK: f64 = 1e-3;

/// Units in the last place of the largest coordinate that a hit point may be off its triangle.
const SLACK_ULPS: f64 = 4.0;

/// A cube around a scene, halved `levels` times: level l has 2^l cells a side.
///
/// The cube begins at the smallest corner of the bounding box, less a small margin: a flat scene occupies 4 of the
/// 8 cells of level 1, as in the paper's Table 1. Keys are Morton codes, with x in the lowest bit; the key of the cell above is
/// the key shifted by three bits.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Smallest corner, scene units.
    origin: DVec3,
    /// Side of a cell of the finest level, scene units.
    cell: f64,
    levels: u32,
    /// Distance at which a triangle touches a cell, in cells of the finest level.
    slack: f64,
}

impl Grid {
    /// Around the vertices of the triangles that are finite; a unit cube at the origin where there are none.
    ///
    /// # Panics
    ///
    /// If `levels` exceeds [`MOST_LEVELS`], or a triangle has a vertex that is not there.
    pub fn around(positions: &[Vec3], triangles: &[[u32; 3]], levels: u32) -> Self {
        assert!(levels <= MOST_LEVELS, "at most {MOST_LEVELS} levels");
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = triangles
            .par_iter()
            .filter_map(|triangle| finite_corners(positions, triangle))
            .map(|[a, b, c]| (a.min(b).min(c), a.max(b).max(c)))
            .reduce(|| nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        if low.x > high.x {
            return Self {
                origin: DVec3::ZERO,
                cell: (-f64::from(levels)).exp2(),
                levels,
                slack: LEAST_SLACK,
            };
        }
        let ulp = f64::from(low.abs().max(high.abs()).max_element()) * f64::from(f32::EPSILON);
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let extent = (high - low).max_element();
        let margin = (MARGIN * extent).max(2.0 * SLACK_ULPS * ulp);
        let side = extent + 2.0 * margin;
        let side = if side > 0.0 { side } else { 1.0 };
        let cell = side / f64::from(1 << levels);
        Self {
            origin: low - margin,
            cell,
            levels,
            // Cells that coordinates cannot tell apart gain nothing from more.
            slack: (SLACK_ULPS * ulp / cell).clamp(LEAST_SLACK, 1.0),
        }
    }

    /// Number of the finest level; the coarsest, one cell, is 0.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Side of a cell of a level, scene units.
    pub fn cell_size(&self, level: u32) -> f32 {
        (self.cell * f64::from(self.levels as i32 - level as i32).exp2()) as f32
    }

    /// Key of the cell of the finest level that holds a point; none outside of the cube or where it is not finite.
    pub fn key(&self, position: Vec3) -> Option<u64> {
        if !position.is_finite() {
            return None;
        }
        let cells = self.in_cells(position);
        let inside = cells.min_element() >= 0.0 && cells.max_element() < f64::from(self.side());
        inside.then(|| morton(cells.to_array().map(|c| c as u32)))
    }

    /// Key of the cell of a level that holds a point; none as in [`Grid::key`], or where there is no such level.
    pub fn key_at(&self, level: u32, position: Vec3) -> Option<u64> {
        let above = self.levels.checked_sub(level)?;
        Some(self.key(position)? >> (3 * above))
    }

    /// Cells a side of the finest level.
    pub(super) fn side(&self) -> u32 {
        1 << self.levels
    }

    /// A point in cells of the finest level, from the smallest corner.
    pub(super) fn in_cells(&self, position: Vec3) -> DVec3 {
        (position.as_dvec3() - self.origin) / self.cell
    }

    /// Distance at which a triangle touches a cell, in cells of the finest level.
    pub(super) fn slack(&self) -> f64 {
        self.slack
    }
}

/// The corners of a triangle, if they are finite.
pub(super) fn finite_corners(positions: &[Vec3], triangle: &[u32; 3]) -> Option<[Vec3; 3]> {
    let corners = triangle.map(|vertex| positions[vertex as usize]);
    corners.iter().all(|c| c.is_finite()).then_some(corners)
}

/// Interleaves the bits of cell coordinates below 2²¹, x lowest.
pub(super) fn morton([x, y, z]: [u32; 3]) -> u64 {
    spread(x) | spread(y) << 1 | spread(z) << 2
}

/// The coordinates of which a key is the Morton code.
pub(super) fn coordinates(key: u64) -> [u32; 3] {
    [gather(key), gather(key >> 1), gather(key >> 2)]
}

/// Moves bit i to bit 3i.
fn spread(coordinate: u32) -> u64 {
    let mut x = u64::from(coordinate) & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Moves bit 3i to bit i.
fn gather(key: u64) -> u32 {
    let mut x = key & 0x1249_2492_4924_9249;
    x = (x | x >> 2) & 0x10c3_0c30_c30c_30c3;
    x = (x | x >> 4) & 0x100f_00f0_0f00_f00f;
    x = (x | x >> 8) & 0x001f_0000_ff00_00ff;
    x = (x | x >> 16) & 0x001f_0000_0000_ffff;
    (x | x >> 32) as u32 & 0x1f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn keys_and_coordinates_are_each_others_inverse() {
        let mut rng = Rng::new(1, 0, 0, 0);
        for _ in 0..10_000 {
            let cell = [0; 3].map(|_: u32| rng.below(1 << 20) as u32);
            assert_eq!(coordinates(morton(cell)), cell);
            assert_eq!(coordinates(morton(cell) >> 3), cell.map(|c| c / 2));
        }
        assert_eq!(morton([1, 0, 0]), 1);
        assert_eq!(morton([0, 1, 0]), 2);
        assert_eq!(morton([0, 0, 3]), 0b100_100);
    }

    #[test]
    fn the_cube_holds_the_scene_and_little_else() {
        let positions = [
            Vec3::new(-3.0, 1.0, 2.0),
            Vec3::new(5.0, 2.0, 2.5),
            Vec3::new(0.0, f32::NAN, 0.0),
            Vec3::new(-1.0, 1.5, 1.0),
        ];
        let grid = Grid::around(&positions, &[[0, 1, 3], [0, 1, 2]], 8);
        assert_eq!(grid.levels(), 8);
        assert!((grid.cell_size(0) - 8.0).abs() < 1e-3);
        assert!((grid.cell_size(8) - 8.0 / 256.0).abs() < 1e-5);
        assert_eq!(grid.key(Vec3::new(-3.0, 1.0, 1.0)), Some(0));
        for outside in [
            Vec3::new(-3.1, 1.0, 1.0),
            Vec3::new(5.1, 1.0, 1.0),
            Vec3::new(0.0, f32::NAN, 1.0),
            Vec3::INFINITY,
        ] {
            assert_eq!(grid.key(outside), None, "{outside}");
        }
        let point = Vec3::new(4.9, 1.9, 1.1);
        let key = grid.key(point).expect("inside");
        assert_eq!(coordinates(key)[0], 252);
        for level in 0..=8 {
            assert_eq!(grid.key_at(level, point), Some(key >> (3 * (8 - level))));
        }
        assert_eq!(grid.key_at(9, point), None);
    }

    #[test]
    fn nothing_and_a_point_have_a_cube() {
        let empty = Grid::around(&[], &[], 5);
        assert_eq!(empty.cell_size(0), 1.0);
        for point in [Vec3::ZERO, Vec3::splat(1e4), Vec3::splat(-1e-30)] {
            let grid = Grid::around(&[point], &[[0; 3]], 12);
            assert!(grid.key(point).is_some(), "{point}");
        }
    }
}
