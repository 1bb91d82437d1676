//! Thin sheets with two sides and a rim: curtains, cloths, paper.

use glam::DVec3;

use super::shade::mend_normals;
use super::{lattice, merged, shade};
use crate::scene::Mesh;

/// A sheet of `count` vertices per direction over `position(u, v)` with u, v in `[0, 1]`, thickened
/// by `thickness` against its front side `d/du × d/dv`.
pub fn sheet(count: [usize; 2], thickness: f64, position: impl Fn(f64, f64) -> DVec3) -> Mesh {
    sheet_of(count, thickness, &position)
}

fn sheet_of(count: [usize; 2], thickness: f64, position: &dyn Fn(f64, f64) -> DVec3) -> Mesh {
    let [columns, rows] = count.map(|n| n.max(2));
    let at = |i: usize, j: usize| {
        position(
            i as f64 / (columns - 1) as f64,
            j as f64 / (rows - 1) as f64,
        )
    };
    let front = shade(lattice([columns, rows], [false; 2], at), 180.0);
    let normals = lattice_normals(columns, rows, &at);
    let behind = |i: usize, j: usize| at(i, j) - normals[j * columns + i] * thickness;
    let back = lattice([columns, rows], [false; 2], |i, j| {
        behind(columns - 1 - i, j)
    });
    let rim_path: Vec<(usize, usize)> = (0..columns - 1)
        .map(|i| (i, 0))
        .chain((0..rows - 1).map(|j| (columns - 1, j)))
        .chain((1..columns).rev().map(|i| (i, rows - 1)))
        .chain((1..rows).rev().map(|j| (0, j)))
        .collect();
    let rim = lattice([rim_path.len(), 2], [true, false], |s, side| {
        let (i, j) = rim_path[s];
        if side == 0 { behind(i, j) } else { at(i, j) }
    });
    let mut whole = merged([front, shade(back, 180.0), shade(rim, 60.0)]);
    mend_normals(&mut whole);
    whole
}

/// Normals by central differences over the lattice.
fn lattice_normals(columns: usize, rows: usize, at: &impl Fn(usize, usize) -> DVec3) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let along_u = at((i + 1).min(columns - 1), j) - at(i.saturating_sub(1), j);
            let along_v = at(i, (j + 1).min(rows - 1)) - at(i, j.saturating_sub(1));
            out.push(along_u.cross(along_v).normalize_or_zero());
        }
    }
    out
}
