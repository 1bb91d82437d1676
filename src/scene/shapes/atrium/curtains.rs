//! Curtains, their rods and the railing of the gallery.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::{BAYS, GALLERY, PITCH, ROW_X, column_z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{capsule, jitter, merged, moved, placed, sheet, sphere};

/// A curtain drawn to one side of a bay: pleated at the rail, gathered by a tie, loose at the hem.
fn curtain(parameters: &Parameters, key: u64) -> Mesh {
    let width = 0.95;
    let drop = 2.15;
    let phase = jitter(parameters.seed, key, [0.0, TAU]);
    let pleats = 7.0;
    sheet(
        [parameters.steps(72), parameters.steps(18)],
        0.002,
        |u, v| {
            // v = 0 at the hem.
            let gather = (-((v - 0.42) / 0.16).powi(2)).exp();
            let spread = 1.0 - 0.45 * gather;
            let bend = 0.25 * (TAU * u + phase).sin() * (1.0 - v);
            let depth = (0.035 + 0.03 * (1.0 - v)) * (1.0 - 0.4 * gather);
            let wave = (TAU * pleats * u + phase + bend).sin()
                + 0.15 * (TAU * pleats * 2.0 * u + 2.0 * phase).sin() * (1.0 - v);
            let sag = 0.02 * (TAU * pleats * u).cos().powi(2) * v.powi(24);
            DVec3::new(
                width * (u * spread) - 0.08 * gather * (1.0 - u),
                drop * v - sag,
                depth * wave,
            )
        },
    )
}

fn curtains(parameters: &Parameters, red: bool) -> Mesh {
    let bays = (0..BAYS).filter(|i| (i % 2 == 0) == red);
    merged(bays.flat_map(|i| {
        let z = column_z(i) - PITCH * 0.5;
        [-1.0, 1.0].map(|side| {
            let base = curtain(parameters, i as u64 * 2 + u64::from(side > 0.0));
            let left = moved(&base, [-1.04, 0.0, 0.0]);
            let right = placed(&left, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
            let both = merged([left, right]);
            placed(
                &both,
                DMat4::from_translation(DVec3::new(side * (ROW_X + 0.36), 0.9, z))
                    * DMat4::from_rotation_y(PI * 0.5),
            )
        })
    }))
}

pub(super) fn red_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, true)
}

pub(super) fn blue_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, false)
}

/// Curtain rods with knobs, and the gallery's railing.
pub(super) fn rails(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(14);
    let knob = sphere(0.035, round);
    let bar = |from: [f64; 3], to: [f64; 3], r: f64| capsule(from, to, [r, r], round);
    let mut pieces = Vec::new();
    for side in [-1.0, 1.0] {
        for i in 0..BAYS {
            let (x, z) = (side * (ROW_X + 0.36), column_z(i) - PITCH * 0.5);
            pieces.push(bar([x, 3.07, z - 1.12], [x, 3.07, z + 1.12], 0.016));
            pieces.push(moved(&knob, [x, 3.07, z - 1.14]));
            pieces.push(moved(&knob, [x, 3.07, z + 1.14]));
            let bars = 11;
            for k in 1..bars {
                let at = z + (f64::from(k) / f64::from(bars) - 0.5) * PITCH;
                let (x, y) = (side * ROW_X, GALLERY + 0.24);
                pieces.push(bar([x, y, at], [x, y + 0.75, at], 0.012));
            }
        }
        let (x, y) = (side * ROW_X, GALLERY + 1.0);
        pieces.push(bar([x, y, column_z(BAYS)], [x, y, column_z(0)], 0.028));
    }
    merged(pieces)
}
