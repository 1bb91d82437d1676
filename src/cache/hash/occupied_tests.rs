//! Occupied cells against clipping, and hit points against occupied cells.

use glam::{DVec3, Vec3};

use crate::cache::hash::grid::{Grid, coordinates, morton};
use crate::cache::hash::occupied::{coarser, occupied_cells};
use crate::sample::Rng;

fn random_point(rng: &mut Rng) -> Vec3 {
    Vec3::from([0; 3].map(|_: u32| rng.next_f32()))
}

/// Triangles of many sizes in the unit cube; every fifth lies in a plane of an axis.
fn random_triangles(rng: &mut Rng, count: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for i in 0..count {
        let size = 0.5f32.powi((i % 8) as i32);
        let anchor = random_point(rng);
        for _ in 0..3 {
            let mut corner =
                (anchor + (random_point(rng) - 0.5) * size).clamp(Vec3::ZERO, Vec3::ONE);
            if i % 5 == 0 {
                corner[i % 3] = anchor[i % 3];
            }
            positions.push(corner);
        }
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    (positions, triangles.collect())
}

/// Whether something of a triangle is left that was clipped by the six planes of a box.
fn is_clipped_to_something(corners: [DVec3; 3], low: DVec3, high: DVec3) -> bool {
    let mut polygon = corners.to_vec();
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let bound = if sign > 0.0 { high[axis] } else { -low[axis] };
        let inside = |p: DVec3| bound - sign * p[axis];
        let mut clipped = Vec::new();
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (at_a, at_b) = (inside(a), inside(b));
            if at_a >= 0.0 {
                clipped.push(a);
            }
            if at_a * at_b < 0.0 {
                clipped.push(a + (b - a) * (at_a / (at_a - at_b)));
            }
        }
        polygon = clipped;
    }
    !polygon.is_empty()
}

fn is_touched(grid: &Grid, corners: [Vec3; 3], cell: [u32; 3], slack: f64) -> bool {
    let low = DVec3::from_array(cell.map(f64::from));
    let corners = corners.map(|corner| grid.in_cells(corner));
    is_clipped_to_something(corners, low - slack, low + 1.0 + slack)
}

#[test]
fn occupied_cells_are_those_of_clipping() {
    for seed in 0..30 {
        let mut rng = Rng::new(seed, 1, 0, 0);
        let (positions, triangles) = random_triangles(&mut rng, 1 + seed as usize % 9);
        let levels = seed as u32 % 6;
        let grid = Grid::around(&positions, &triangles, levels);
        let keys = occupied_cells(&grid, &positions, &triangles);
        assert!(keys.is_sorted_by(|a, b| a < b));
        for key in 0..1u64 << (3 * levels) {
            let touched = |slack: f64| {
                triangles.iter().any(|triangle| {
                    let corners = triangle.map(|v| positions[v as usize]);
                    is_touched(&grid, corners, coordinates(key), slack)
                })
            };
            let found = keys.binary_search(&key).is_ok();
            if found {
                assert!(touched(1.001 * grid.slack()), "{seed}: {key} is too much");
            } else {
                assert!(!touched(0.999 * grid.slack()), "{seed}: {key} is missing");
            }
        }
    }
}

/// A uniform point of a triangle, in `f32` as a renderer computes it.
fn hit_point(rng: &mut Rng, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (mut u, mut v) = (rng.next_f32(), rng.next_f32());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + (b - a) * u + (c - a) * v
}

#[test]
fn hit_points_have_a_cell_wherever_the_scene_is() {
    let moved = |scale: f32, offset: f32| move |p: Vec3| (p - 0.3) * scale + offset;
    for place in [
        moved(1.0, 0.0),
        moved(10.0, 1e4),
        moved(10.0, -1e4),
        moved(1e-3, 0.0),
        moved(1e5, 0.0),
        moved(1e5, -1e6),
    ] {
        let mut rng = Rng::new(4, 0, 0, 0);
        let (mut positions, triangles) = random_triangles(&mut rng, 40);
        for position in &mut positions {
            *position = place(*position);
        }
        let grid = Grid::around(&positions, &triangles, 12);
        // Few triangles at a time: all together have millions of cells.
        for triangle in &triangles {
            let corners = triangle.map(|v| positions[v as usize]);
            let small = (corners[0] - corners[1])
                .length()
                .max((corners[0] - corners[2]).length());
            if small > 200.0 * grid.cell_size(12) {
                continue;
            }
            let keys = occupied_cells(&grid, &positions, &[*triangle]);
            for _ in 0..2000 {
                let point = hit_point(&mut rng, corners);
                let key = grid.key(point).expect("in the cube");
                assert!(keys.binary_search(&key).is_ok(), "{point} of {corners:?}");
            }
        }
    }
}

#[test]
fn points_on_faces_of_cells_have_a_cell_with_rounding_either_way() {
    // Walls on faces of cells: of a cube from 0 to 8 with margins they are near them, so that both neighbours count.
    let levels = 12;
    let frame = [Vec3::ZERO, Vec3::splat(8.0)];
    let mut rng = Rng::new(6, 0, 0, 0);
    let grid = Grid::around(&frame, &[[0, 1, 1]], levels);
    let face = |cells: u32| {
        // The coordinate of the face of a cell, to rounding.
        let middle = f64::from(grid.cell_size(levels)) * f64::from(cells);
        (middle - 8e-5) as f32
    };
    for cells in [1, 7, 1000, 2048, 4001] {
        for axis in 0..3 {
            let mut corners = [Vec3::splat(2.0), Vec3::splat(2.0), Vec3::splat(2.0)];
            for corner in &mut corners {
                *corner += 0.1 * random_point(&mut rng);
                corner[axis] = face(cells);
            }
            let positions = corners.to_vec();
            let keys = occupied_cells(&grid, &positions, &[[0, 1, 2]]);
            let layers: Vec<u32> = keys.iter().map(|&key| coordinates(key)[axis]).collect();
            let on_face =
                (grid.in_cells(corners[0])[axis] - f64::from(cells)).abs() < 0.9 * grid.slack();
            for _ in 0..500 {
                let mut point = hit_point(&mut rng, corners);
                point[axis] = point[axis].next_up();
                assert!(
                    keys.binary_search(&grid.key(point).expect("inside"))
                        .is_ok()
                );
                point[axis] = point[axis].next_down().next_down();
                assert!(
                    keys.binary_search(&grid.key(point).expect("inside"))
                        .is_ok()
                );
            }
            if on_face {
                assert!(layers.contains(&cells) && layers.contains(&(cells - 1)));
            }
        }
    }
}

#[test]
fn coarser_levels_are_the_parents() {
    let mut rng = Rng::new(8, 0, 0, 0);
    let (positions, triangles) = random_triangles(&mut rng, 20);
    let grid = Grid::around(&positions, &triangles, 6);
    let mut keys = occupied_cells(&grid, &positions, &triangles);
    for _ in 0..6 {
        let parents: std::collections::BTreeSet<u64> = keys.iter().map(|key| key >> 3).collect();
        keys = coarser(&keys);
        assert!(keys.iter().eq(&parents));
    }
    assert_eq!(keys, [0]);
    assert!(coarser(&[]).is_empty());
}

#[test]
fn a_flat_scene_has_four_cells_of_level_one() {
    let corner = |x, y| Vec3::new(x, y, 3.0);
    let positions = [
        corner(0.0, 0.0),
        corner(5.0, 0.0),
        corner(5.0, 5.0),
        corner(0.0, 5.0),
    ];
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let grid = Grid::around(&positions, &triangles, 7);
    let mut keys = occupied_cells(&grid, &positions, &triangles);
    assert_eq!(keys.len(), 128 * 128);
    for _ in 0..6 {
        keys = coarser(&keys);
    }
    assert_eq!(keys, [0, 1, 2, 3]);
}

#[test]
fn what_has_no_area_or_is_not_finite() {
    let positions = [
        Vec3::ZERO,
        Vec3::ONE,
        Vec3::new(0.4, 0.4, 0.4),
        Vec3::new(f32::NAN, 0.0, 0.0),
        Vec3::new(f32::INFINITY, 0.0, 0.0),
    ];
    let frame = [0, 1, 1];
    let grid = Grid::around(&positions, &[frame], 4);
    let cells = |triangle| occupied_cells(&grid, &positions, &[triangle]);
    let diagonal = cells(frame);
    for i in 0..16 {
        assert!(diagonal.binary_search(&morton([i; 3])).is_ok());
    }
    assert_eq!(cells([2, 2, 2]), [grid.key(positions[2]).expect("inside")]);
    assert!(cells([0, 1, 3]).is_empty());
    assert!(cells([0, 1, 4]).is_empty());
    assert!(occupied_cells(&grid, &positions, &[]).is_empty());
}

#[test]
fn one_cell_and_grids_smaller_than_a_block() {
    let mut rng = Rng::new(9, 0, 0, 0);
    let (positions, triangles) = random_triangles(&mut rng, 5);
    let mut finer: Option<Vec<u64>> = None;
    for levels in (0..7).rev() {
        let grid = Grid::around(&positions, &triangles, levels);
        let keys = occupied_cells(&grid, &positions, &triangles);
        if let Some(finer) = finer {
            let parents = coarser(&finer);
            // The slack is wider there.
            assert!(parents.iter().all(|key| keys.binary_search(key).is_ok()));
        }
        finer = Some(keys);
    }
    assert_eq!(finer, Some(vec![0]));
}
