//! How many cells and bytes a scene will take, before any cell is found.

use glam::Vec3;
use rayon::prelude::*;

use super::grid::{Grid, finite_corners};
use super::levels::Options;
use super::map::MapKind;

/// About how many cells of the finest level the triangles touch.
///
/// A large piece of a plane touches as many cells as its shadows along the three axes have faces of cells. Edges of the surface
/// add to that; surfaces closer together than a cell, and details smaller than one, share cells.
pub(super) fn cells(grid: &Grid, positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let shadows = |triangle: &[u32; 3]| {
        finite_corners(positions, triangle).map_or(0.0, |corners| {
            let [a, b, c] = corners.map(|corner| grid.in_cells(corner));
            0.5 * (b - a).cross(c - a).abs().element_sum()
        })
    };
    triangles.par_iter().map(shadows).sum()
}

/// About how many bytes the cells and maps of all levels will take.
///
/// # Panics
///
/// As [`Grid::around`].
pub fn bytes(positions: &[Vec3], triangles: &[[u32; 3]], options: Options) -> f64 {
    let grid = Grid::around(positions, triangles, options.levels);
    let finest = cells(&grid, positions, triangles);
    let of_level = |level: u32| {
        let above = 4f64.powi(options.levels as i32 - level as i32);
        (finest / above).clamp(1.0, 8f64.powi(level as i32))
    };
    let held = |level: u32| {
        let count = of_level(level);
        let slots = match options.map {
            MapKind::Blocks => {
                let blocks = of_level(level.saturating_sub(2));
                blocks * (8.0 * 1.1 + 12.0)
            }
            MapKind::Cuckoo | MapKind::CuckooThree => count * 8.0 * 1.1,
            MapKind::OpenAddressing => count * 8.0 / 0.7,
        };
        slots + count * 4.0 * options.precision.words() as f64
    };
    (0..=options.levels).map(held).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::hash::{HashCells, Precision, occupied_cells};

    /// A cube of side 2 around a ball of radius 0.7 in small triangles.
    fn scene() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut positions: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0)
            .collect();
        let faces = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        let mut triangles: Vec<[u32; 3]> = faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        let rings = 60u32;
        for ring in 0..=rings {
            for segment in 0..rings {
                let theta = std::f32::consts::PI * ring as f32 / rings as f32;
                let phi = std::f32::consts::TAU * segment as f32 / rings as f32;
                let [sin, cos] = [theta.sin(), theta.cos()];
                positions.push(0.7 * Vec3::new(sin * phi.cos(), sin * phi.sin(), cos));
            }
        }
        let at = |ring: u32, segment: u32| 8 + ring * rings + segment % rings;
        for ring in 0..rings {
            for segment in 0..rings {
                let [a, b] = [at(ring, segment), at(ring, segment + 1)];
                let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        (positions, triangles)
    }

    #[test]
    fn cells_and_bytes_are_foreseen_to_a_tenth() {
        let (positions, triangles) = scene();
        for levels in [7, 9] {
            let grid = Grid::around(&positions, &triangles, levels);
            let foreseen = cells(&grid, &positions, &triangles);
            let found = occupied_cells(&grid, &positions, &triangles).len() as f64;
            assert!((foreseen / found - 1.0).abs() < 0.1, "{foreseen} {found}");
        }
        for map in [MapKind::Blocks, MapKind::Cuckoo, MapKind::OpenAddressing] {
            for precision in [Precision::Half, Precision::Single] {
                let options = Options {
                    levels: 8,
                    map,
                    precision,
                };
                let foreseen = bytes(&positions, &triangles, options);
                let cells = HashCells::new(&positions, &triangles, options).expect("few cells");
                let held = cells.bytes() as f64;
                assert!((foreseen / held - 1.0).abs() < 0.1, "{foreseen} {held}");
            }
        }
    }

    #[test]
    fn nothing_and_damaged_triangles_take_next_to_nothing() {
        let options = Options {
            levels: 6,
            map: MapKind::Blocks,
            precision: Precision::Half,
        };
        let damaged = [Vec3::NAN, Vec3::X, Vec3::Y];
        for triangles in [&[][..], &[[0, 1, 2]][..]] {
            assert!(bytes(&damaged, triangles, options) < 1000.0);
        }
    }
}
