//! Fluted columns with leafy capitals, and the arches on them.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3};

use super::{BAYS, GALLERY, PITCH, ROW_X, SPRING, TOP, column_z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    CREASE_DEG, bevelled_box, lathe, lattice, merged, moved, placed, shade, sheet, smooth_profile,
    strip_solid, sweep,
};

/// A fluted shaft of unit height with entasis.
fn fluted(radius: f64, flutes: usize, rows: usize, per_flute: usize) -> Mesh {
    let around = flutes * per_flute;
    let mesh = lattice([rows + 1, around], [false, true], |i, j| {
        let t = i as f64 / rows as f64;
        let angle_rad = TAU * j as f64 / around as f64;
        let groove = (j % per_flute) as f64 / per_flute as f64;
        let depth = (PI * groove).sin().powf(0.7) * 0.075 * radius;
        let r = radius * (1.0 - 0.16 * t * t) - depth;
        DVec3::new(r * angle_rad.cos(), t, r * angle_rad.sin())
    });
    shade(mesh, CREASE_DEG)
}

/// Base, fluted shaft, capital with leaves and abacus.
fn column(parameters: &Parameters, radius: f64, height: f64) -> Mesh {
    let round = parameters.steps(30);
    let base = lathe(
        &smooth_profile(
            &[
                [0.0, 0.12],
                [1.42, 0.12],
                [1.5, 0.2],
                [1.42, 0.3],
                [1.2, 0.34],
                [1.16, 0.42],
                [1.28, 0.48],
                [1.26, 0.54],
                [1.05, 0.6],
                [0.0, 0.6],
            ]
            .map(|[r, y]| [r * radius, y * 0.5]),
            parameters.steps(4),
        ),
        round,
    );
    let plinth = bevelled_box(
        [-1.5 * radius, 0.0, -1.5 * radius],
        [1.5 * radius, 0.07, 1.5 * radius],
        0.01,
    );
    let (foot, cap) = (0.28, 0.5);
    let shaft = fluted(radius, 20, parameters.steps(6), parameters.steps(5));
    let shaft = placed(
        &shaft,
        DMat4::from_translation(DVec3::new(0.0, foot, 0.0))
            * DMat4::from_scale(DVec3::new(1.0, height - foot - cap + 0.02, 1.0)),
    );
    let bell = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [1.0, 0.0],
                [1.06, 0.03],
                [0.98, 0.06],
                [0.9, 0.12],
                [1.0, 0.3],
                [1.36, 0.43],
                [0.0, 0.43],
            ]
            .map(|[r, y]| [r * radius * 0.9, y]),
            parameters.steps(4),
        ),
        round,
    );
    let abacus = bevelled_box(
        [-1.42 * radius, 0.42, -1.42 * radius],
        [1.42 * radius, 0.5, 1.42 * radius],
        0.015,
    );
    let leaves = merged(
        (0..2)
            .flat_map(|row| (0..8).map(move |k| (row, k)))
            .map(|(row, k)| leaf(parameters, radius, row, k)),
    );
    let capital = moved(&merged([bell, abacus, leaves]), [0.0, height - cap, 0.0]);
    merged([plinth, base, shaft, capital])
}

/// One curling leaf of a capital.
fn leaf(parameters: &Parameters, radius: f64, row: usize, k: usize) -> Mesh {
    let low = 0.08 + 0.1 * row as f64;
    let tall = 0.17 + 0.04 * row as f64;
    let turn_rad = TAU * (k as f64 + 0.5 * row as f64) / 8.0;
    let blade = sheet([parameters.steps(5), parameters.steps(8)], 0.008, |u, v| {
        let width = radius * 0.34 * (1.0 - 0.75 * v.powi(3)) * (1.0 + 0.12 * (v * 22.0).sin());
        let across = (u - 0.5) * 2.0;
        let curl = (v - 0.72).max(0.0);
        let out = radius * (0.8 + 0.26 * v + 0.09 * row as f64) + 1.6 * curl * radius
            - 0.012 * across.abs();
        // Bent around the bell, so that no gap opens behind its edges.
        let (sin, cos) = (across * width / out).sin_cos();
        let y = low + tall * v - 2.2 * tall * curl * curl * 2.0;
        DVec3::new(out * sin, y, out * cos)
    });
    placed(&blade, DMat4::from_rotation_y(turn_rad))
}

pub(super) fn columns(parameters: &Parameters) -> Mesh {
    let lower = column(parameters, 0.25, SPRING);
    let coarse = Parameters {
        detail: parameters.detail * 0.55,
        ..*parameters
    };
    let upper = column(&coarse, 0.13, 2.6);
    let mut pieces = Vec::new();
    for i in 0..=BAYS {
        for side in [-1.0, 1.0] {
            let z = column_z(i);
            pieces.push(moved(&lower, [side * ROW_X, 0.0, z]));
            pieces.push(moved(&upper, [side * ROW_X, GALLERY + 0.24, z]));
        }
    }
    merged(pieces)
}

/// The arch of one bay, `width` between the springing points, under a straight top.
fn arch(parameters: &Parameters, size: [f64; 4]) -> Mesh {
    let [width, pier, height, thickness] = size;
    let steps = parameters.steps(26);
    let half = width * 0.5;
    let mut lower = vec![DVec2::new(-half - pier, 0.0)];
    lower.extend((0..=steps).map(|i| {
        let angle_rad = PI * (1.0 - i as f64 / steps as f64);
        DVec2::new(angle_rad.cos() * half, (angle_rad.sin() * half).max(0.0))
    }));
    lower.push(DVec2::new(half + pier, 0.0));
    let upper: Vec<DVec2> = lower.iter().map(|p| DVec2::new(p.x, height)).collect();
    let body = moved(
        &strip_solid(&lower, &upper, thickness),
        [0.0, 0.0, -thickness * 0.5],
    );
    let path: Vec<DVec3> = (0..=steps)
        .map(|i| {
            let angle_rad = PI * (1.0 - i as f64 / steps as f64);
            let r = half + 0.09;
            DVec3::new(angle_rad.cos() * r, (angle_rad.sin() * r).max(0.0), 0.0)
        })
        .collect();
    let section = [[-0.05, -0.5], [0.05, -0.5], [0.05, 0.5], [-0.05, 0.5]]
        .map(|[a, b]| DVec2::new(b * (thickness + 0.08), -a));
    merged([body, sweep(&path, &section, false)])
}

pub(super) fn arches(parameters: &Parameters) -> Mesh {
    let turn = PI * 0.5;
    let lower = arch(
        parameters,
        [PITCH - 0.56, 0.28, GALLERY - 0.3 - SPRING, 0.5],
    );
    let upper_spring = GALLERY + 0.24 + 2.6;
    let upper = arch(parameters, [PITCH - 0.3, 0.15, TOP - upper_spring, 0.3]);
    let mut pieces = Vec::new();
    for i in 0..BAYS {
        let z = column_z(i) - PITCH * 0.5;
        for side in [-1.0, 1.0] {
            let place = |y: f64| {
                DMat4::from_translation(DVec3::new(side * ROW_X, y, z))
                    * DMat4::from_rotation_y(turn)
            };
            pieces.push(placed(&lower, place(SPRING)));
            pieces.push(placed(&upper, place(upper_spring)));
        }
    }
    merged(pieces)
}
