//! Sections swept along curves.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::{CREASE_DEG, lattice, merged, shade};
use crate::scene::Mesh;

/// A counter-clockwise circle of `sides` points.
pub fn circle(radius: f64, sides: usize) -> Vec<DVec2> {
    (0..sides)
        .map(|i| DVec2::from_angle(TAU * i as f64 / sides as f64) * radius)
        .collect()
}

/// Sweeps a counter-clockwise section along a path with rotation-minimising frames. A closed path is
/// joined (its twist spread evenly); an open one gets flat caps (the section must be star-shaped
/// about its mean). The section's y points along +y where the path starts level.
pub fn sweep(path: &[DVec3], section: &[DVec2], closed: bool) -> Mesh {
    if path.len() < 2 || section.len() < 3 {
        return Mesh::default();
    }
    let frames = frames(path, closed);
    let at = |p: usize, s: usize| path[p] + frames[p] * section[s].extend(0.0);
    let side = lattice([section.len(), path.len()], [true, closed], |s, p| at(p, s));
    if closed {
        return shade(side, CREASE_DEG);
    }
    let mean = section.iter().sum::<DVec2>() / section.len() as f64;
    let cap = |p: usize, facing: bool| {
        let n = section.len();
        let mut mesh = Mesh {
            positions: (0..n).map(|s| at(p, s)).collect(),
            ..Mesh::default()
        };
        mesh.positions.push(path[p] + frames[p] * mean.extend(0.0));
        for s in 0..n as u32 {
            let next = (s + 1) % n as u32;
            let (a, b) = if facing { (s, next) } else { (next, s) };
            mesh.triangles.push([n as u32, a, b]);
        }
        mesh
    };
    let caps = [cap(0, false), cap(path.len() - 1, true)];
    shade(merged([side].into_iter().chain(caps)), CREASE_DEG)
}

/// A round tube along a path.
pub fn tube(path: &[DVec3], radius: f64, sides: usize) -> Mesh {
    sweep(path, &circle(radius, sides), false)
}

/// Points of a Catmull–Rom curve through `points`, `steps` an interval.
pub fn curve(points: &[[f64; 3]], steps: usize) -> Vec<DVec3> {
    let at = |i: isize| DVec3::from(points[i.clamp(0, points.len() as isize - 1) as usize]);
    let mut out = Vec::new();
    for i in 0..points.len().saturating_sub(1) as isize {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        out.extend((0..steps).map(|s| {
            let t = s as f64 / steps as f64;
            (b * 2.0
                + (c - a) * t
                + (a * 2.0 - b * 5.0 + c * 4.0 - d) * t * t
                + (b * 3.0 - a - c * 3.0 + d) * t * t * t)
                * 0.5
        }));
    }
    out.extend(points.last().map(|&p| DVec3::from(p)));
    out
}

/// Rotations that take z to the path's tangent.
fn frames(path: &[DVec3], closed: bool) -> Vec<DQuat> {
    let n = path.len();
    let tangent = |i: usize| {
        let (before, after) = match (closed, i) {
            (true, _) => (path[(i + n - 1) % n], path[(i + 1) % n]),
            (false, 0) => (path[0], path[1]),
            (false, _) => (path[i - 1], path[(i + 1).min(n - 1)]),
        };
        (after - before).normalize_or(DVec3::Z)
    };
    let first = tangent(0);
    let side = DVec3::Y.cross(first).normalize_or(DVec3::X);
    let basis = glam::DMat3::from_cols(side, first.cross(side), first);
    let mut out = vec![DQuat::from_mat3(&basis)];
    for i in 1..n {
        let turn = DQuat::from_rotation_arc(tangent(i - 1), tangent(i));
        out.push((turn * out[i - 1]).normalize());
    }
    if closed {
        let home = DQuat::from_rotation_arc(tangent(n - 1), first) * out[n - 1];
        let drift = out[0] * DVec3::X;
        let x = home * DVec3::X;
        let twist_rad = x.dot(out[0] * DVec3::Y).atan2(x.dot(drift));
        for (i, frame) in out.iter_mut().enumerate() {
            *frame *= DQuat::from_rotation_z(-twist_rad * i as f64 / n as f64);
        }
    }
    out
}
