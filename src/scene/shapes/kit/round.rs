//! Bodies of revolution and rounded boxes.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::sweep::curve;
use super::{CREASE_DEG, circle, lattice, placed, shade, sweep, y_towards};
use crate::scene::Mesh;

/// Revolves a profile of (radius, height) points about +y. The profile runs upwards along the
/// outside; where it turns back down it bounds a cavity.
pub fn lathe(profile: &[[f64; 2]], segments: usize) -> Mesh {
    let segments = segments.max(3);
    let mesh = lattice([profile.len(), segments], [false, true], |i, j| {
        let angle_rad = TAU * j as f64 / segments as f64;
        let [radius, height] = profile[i];
        DVec3::new(radius * angle_rad.cos(), height, radius * angle_rad.sin())
    });
    shade(mesh, CREASE_DEG)
}

/// A sphere about the origin with `segments` meridians.
pub fn sphere(radius: f64, segments: usize) -> Mesh {
    let rows = (segments / 2).max(3);
    let profile: Vec<[f64; 2]> = (0..=rows)
        .map(|i| {
            let polar_rad = PI * i as f64 / rows as f64;
            let across = if i == 0 || i == rows {
                0.0
            } else {
                polar_rad.sin()
            };
            [radius * across, -radius * polar_rad.cos()]
        })
        .collect();
    let mesh = lathe(&profile, segments);
    Mesh {
        normals: mesh
            .positions
            .iter()
            .map(|p| p.normalize_or_zero().as_vec3())
            .collect(),
        ..mesh
    }
}

/// A closed cylinder along +y from the origin, its rims cut by `bevel` metres.
pub fn cylinder(radius: f64, height: f64, bevel: f64, segments: usize) -> Mesh {
    let mut profile = vec![[0.0, 0.0], [radius - bevel, 0.0]];
    if bevel > 0.0 {
        profile.extend([[radius, bevel], [radius, height - bevel]]);
        profile.push([radius - bevel, height]);
    } else {
        profile.push([radius, height]);
    }
    profile.push([0.0, height]);
    lathe(&profile, segments)
}

/// A capsule between two points, with a radius for each end.
pub fn capsule(from: [f64; 3], to: [f64; 3], radii: [f64; 2], segments: usize) -> Mesh {
    let (from, to) = (DVec3::from(from), DVec3::from(to));
    let length = from.distance(to).max(1e-9);
    let rows = (segments / 4).max(2);
    // Where the cone touches the two spheres.
    let tilt_rad = ((radii[0] - radii[1]) / length).clamp(-0.99, 0.99).asin();
    let arc = |radius: f64, height: f64, range: [f64; 2]| {
        (0..=rows).map(move |i| {
            let t = i as f64 / rows as f64;
            let latitude_rad = range[0] + (range[1] - range[0]) * t;
            let pole = latitude_rad.abs() > PI * 0.5 - 1e-9;
            let across = if pole { 0.0 } else { latitude_rad.cos() };
            [radius * across, height + radius * latitude_rad.sin()]
        })
    };
    let lower = arc(radii[0], 0.0, [-PI * 0.5, tilt_rad]);
    let upper = arc(radii[1], length, [tilt_rad, PI * 0.5]);
    let profile: Vec<[f64; 2]> = lower.chain(upper).collect();
    let to_world = DMat4::from_translation(from) * y_towards(to - from);
    placed(&lathe(&profile, segments), to_world)
}

/// A torus about +y: `major` metres to the tube's centre, `minor` its radius.
pub fn torus(major: f64, minor: f64, segments: [usize; 2]) -> Mesh {
    let path: Vec<DVec3> = (0..segments[0])
        .map(|i| {
            let angle_rad = TAU * i as f64 / segments[0] as f64;
            DVec3::new(major * angle_rad.cos(), 0.0, major * angle_rad.sin())
        })
        .collect();
    sweep(&path, &circle(minor, segments[1]), true)
}

/// A box about the origin with `half` extents, rounded by `radius`, `steps` facets a quarter circle.
pub fn rounded_box(half: [f64; 3], radius: f64, steps: usize) -> Mesh {
    let half = DVec3::from(half);
    let radius = radius.min(half.min_element() * 0.999);
    let inner = half - DVec3::splat(radius);
    let steps = steps.max(1);
    let rows = 2 * steps + 2;
    // Lines of a cube sphere; the middle one is doubled and opens to the flat faces.
    let line = |i: usize| {
        let (k, sign) = if i <= steps {
            (steps - i, -1.0)
        } else {
            (i - steps - 1, 1.0)
        };
        (sign, sign * (PI * 0.25 * k as f64 / steps as f64).tan())
    };
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let patch = lattice([rows, rows], [false; 2], |u, v| {
                let ((su, tu), (sv, tv)) = (line(u), line(v));
                // Swapping the sign of one direction keeps the front side outside.
                let on_cube = turned(axis, [side, tu * side, tv]);
                let signs = turned(axis, [side, su * side, sv]);
                signs * inner + on_cube.normalize() * radius
            });
            mesh.append(&patch);
        }
    }
    for p in &mut mesh.positions {
        // Patches compute shared edges in different orders: make them meet exactly.
        *p = (*p * 1e9).round() / 1e9;
    }
    shade(mesh, CREASE_DEG)
}

/// (along the axis, next axis, next but one) as x, y, z.
fn turned(axis: usize, [along, b, c]: [f64; 3]) -> DVec3 {
    let mut p = [0.0; 3];
    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (along, b, c);
    DVec3::from(p)
}

/// Points of a profile rounded by a Catmull–Rom curve, `steps` an interval.
pub fn smooth_profile(points: &[[f64; 2]], steps: usize) -> Vec<[f64; 2]> {
    let points: Vec<[f64; 3]> = points.iter().map(|&[r, y]| [r, y, 0.0]).collect();
    curve(&points, steps)
        .iter()
        .map(|p| [p.x.max(0.0), p.y])
        .collect()
}
