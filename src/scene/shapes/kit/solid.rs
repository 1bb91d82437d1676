//! Solids with flat faces: boxes, bevelled boxes, walls with openings, strips between two curves.

use glam::{DVec2, DVec3};

use super::{CREASE_DEG, lattice, merged, shade};
use crate::scene::Mesh;

/// A box between two corners, with face normals.
pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Mesh {
    let corner = |bits: usize| {
        let pick = |axis: usize| {
            if bits >> axis & 1 == 1 {
                max[axis]
            } else {
                min[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let mut mesh = Mesh::default();
    for face in faces {
        push_polygon(&mut mesh, &face.map(corner));
    }
    shade(mesh, 1.0)
}

/// A box whose edges are cut by `bevel` metres; the bevels are flat.
pub fn bevelled_box(min: [f64; 3], max: [f64; 3], bevel: f64) -> Mesh {
    let (min, max) = (DVec3::from(min), DVec3::from(max));
    let centre = (min + max) * 0.5;
    let half = (max - min) * 0.5;
    let bevel = bevel.min(half.min_element() * 0.95);
    // Three vertices a corner: the one on face `axis` keeps full size along that axis only.
    let vertex = |axis: usize, sign: [f64; 3]| {
        let mut p = (half - DVec3::splat(bevel)).to_array();
        p[axis] = half[axis];
        centre + DVec3::from(p) * DVec3::from(sign)
    };
    let mut mesh = Mesh::default();
    let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let face = signs.map(|s| {
                let mut sign = [0.0; 3];
                (sign[axis], sign[b], sign[c]) = (side, s[0], s[1]);
                vertex(axis, sign)
            });
            push_outward(&mut mesh, &face, centre);
        }
        for s in signs {
            let edge = [(b, 1.0), (b, -1.0), (c, -1.0), (c, 1.0)].map(|(face, along)| {
                let mut sign = [0.0; 3];
                (sign[axis], sign[b], sign[c]) = (along, s[0], s[1]);
                vertex(face, sign)
            });
            push_outward(&mut mesh, &edge, centre);
        }
    }
    for bits in 0..8 {
        let sign = [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 });
        push_outward(&mut mesh, &[0, 1, 2].map(|axis| vertex(axis, sign)), centre);
    }
    shade(mesh, 1.0)
}

/// A rectangular hole of a [`wall`], in its plane.
#[derive(Clone, Copy, Debug)]
pub struct Opening {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

/// A wall standing on the xy plane, `size` wide and high from the origin, from z = 0 to
/// z = `thickness`, with rectangular openings and closed reveals.
pub fn wall(size: [f64; 2], thickness: f64, openings: &[Opening]) -> Mesh {
    let cuts = |axis: usize| {
        let mut cuts = vec![0.0, size[axis]];
        cuts.extend(openings.iter().flat_map(|o| [o.min[axis], o.max[axis]]));
        cuts.retain(|c| (0.0..=size[axis]).contains(c));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    };
    let (xs, ys) = (cuts(0), cuts(1));
    let solid = |i: isize, j: isize| {
        if i < 0 || j < 0 || i + 1 >= xs.len() as isize || j + 1 >= ys.len() as isize {
            return false;
        }
        let x = (xs[i as usize] + xs[i as usize + 1]) * 0.5;
        let y = (ys[j as usize] + ys[j as usize + 1]) * 0.5;
        !openings
            .iter()
            .any(|o| o.min[0] < x && x < o.max[0] && o.min[1] < y && y < o.max[1])
    };
    let mut mesh = Mesh::default();
    for j in 0..ys.len() - 1 {
        for i in 0..xs.len() - 1 {
            let (si, sj) = (i as isize, j as isize);
            if !solid(si, sj) {
                continue;
            }
            let [x0, x1, y0, y1] = [xs[i], xs[i + 1], ys[j], ys[j + 1]];
            let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
            let t = thickness;
            let mut quad = |q: [DVec3; 4]| push_polygon(&mut mesh, &q);
            quad([p(x0, y0, t), p(x1, y0, t), p(x1, y1, t), p(x0, y1, t)]);
            quad([p(x0, y0, 0.), p(x0, y1, 0.), p(x1, y1, 0.), p(x1, y0, 0.)]);
            if !solid(si - 1, sj) {
                quad([p(x0, y0, 0.), p(x0, y0, t), p(x0, y1, t), p(x0, y1, 0.)]);
            }
            if !solid(si + 1, sj) {
                quad([p(x1, y0, 0.), p(x1, y1, 0.), p(x1, y1, t), p(x1, y0, t)]);
            }
            if !solid(si, sj - 1) {
                quad([p(x0, y0, 0.), p(x1, y0, 0.), p(x1, y0, t), p(x0, y0, t)]);
            }
            if !solid(si, sj + 1) {
                quad([p(x0, y1, 0.), p(x0, y1, t), p(x1, y1, t), p(x1, y1, 0.)]);
            }
        }
    }
    shade(mesh, 1.0)
}

/// The solid between two curves of equal length in the xy plane (`lower` under `upper`, both towards
/// +x), from z = 0 to z = `thickness`.
pub fn strip_solid(lower: &[DVec2], upper: &[DVec2], thickness: f64) -> Mesh {
    let n = lower.len().min(upper.len());
    if n < 2 {
        return Mesh::default();
    }
    let front = |curve: usize, i: usize| {
        let p = if curve == 0 { lower[i] } else { upper[i] };
        p.extend(thickness)
    };
    let back = |curve: usize, i: usize| {
        let p = if curve == 0 { upper[i] } else { lower[i] };
        p.extend(0.0)
    };
    let under = |row: usize, i: usize| lower[i].extend(thickness * row as f64);
    let over = |row: usize, i: usize| upper[i].extend(thickness * (1 - row) as f64);
    let mut ends = Mesh::default();
    for (i, order) in [(0, [0, 1, 2, 3]), (n - 1, [3, 2, 1, 0])] {
        let corners = [
            lower[i].extend(0.0),
            lower[i].extend(thickness),
            upper[i].extend(thickness),
            upper[i].extend(0.0),
        ];
        push_polygon(&mut ends, &order.map(|k| corners[k]));
    }
    let by_rows =
        |f: &dyn Fn(usize, usize) -> DVec3| lattice([n, 2], [false; 2], |i, row| f(row, i));
    let mesh = merged([
        by_rows(&front),
        by_rows(&back),
        by_rows(&|row, i| under(row, i)),
        by_rows(&|row, i| over(row, i)),
        ends,
    ]);
    shade(mesh, CREASE_DEG)
}

/// Appends a convex polygon as a fan, without normals.
fn push_polygon(mesh: &mut Mesh, corners: &[DVec3]) {
    let base = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(corners);
    for i in 2..corners.len() as u32 {
        mesh.triangles.push([base, base + i - 1, base + i]);
    }
}

/// Appends a convex polygon, wound so that it faces away from `centre`.
fn push_outward(mesh: &mut Mesh, corners: &[DVec3], centre: DVec3) {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if normal.dot(corners[0] - centre) < 0.0 {
        let reversed: Vec<DVec3> = corners.iter().rev().copied().collect();
        push_polygon(mesh, &reversed);
    } else {
        push_polygon(mesh, corners);
    }
}
