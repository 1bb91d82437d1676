//! Curtains, figures, planters and benches.

use std::f64::consts::TAU;

use glam::{DMat4, DVec3};

use super::{PITCH, SPRING, around, bays};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::figures::seated;
use crate::scene::shapes::kit::{
    Bush, bevelled_box, bush, capsule, jitter, lathe, merged, moved, placed, set_at, sheet,
    smooth_profile, sphere,
};

/// Half of a pair of curtains, tied at a third of its height; x from 0 (the column) outwards.
fn curtain(parameters: &Parameters, key: u64) -> Mesh {
    let (width, drop) = (0.92, SPRING - 0.3);
    let phase = jitter(parameters.seed, key, [0.0, TAU]);
    sheet(
        [parameters.steps(42), parameters.steps(11)],
        0.002,
        |u, v| {
            // v = 0 at the hem.
            let gather = (-((v - 0.38) / 0.17).powi(2)).exp();
            let bend = 0.3 * (TAU * u + phase).sin() * (1.0 - v);
            let depth = (0.04 + 0.03 * (1.0 - v)) * (1.0 - 0.35 * gather);
            let x = width * u * (1.0 - 0.5 * gather);
            DVec3::new(x, drop * v, depth * (TAU * 6.0 * u + phase + bend).sin())
        },
    )
}

/// Curtains hang behind every third arch of the long sides and the middle ones of the short sides.
fn is_hung(count: usize, bay: usize, red: bool) -> bool {
    match (count, bay) {
        (6, 1) => red,
        (6, 4) => !red,
        (3, 0 | 2) => red,
        _ => false,
    }
}

fn curtains(parameters: &Parameters, red: bool) -> Mesh {
    around(|count| {
        let hung = bays(count)
            .enumerate()
            .filter(|(i, _)| is_hung(count, *i, red));
        merged(hung.flat_map(|(i, x)| {
            let half = curtain(parameters, (count * 8 + i) as u64);
            let left = moved(&half, [-PITCH * 0.5 + 0.3, 0.08, -0.4]);
            let right = placed(&left, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
            [left, right].map(|side| moved(&side, [x, 0.0, 0.0]))
        }))
    })
}

pub(super) fn red_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, true)
}

pub(super) fn green_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, false)
}

/// Rods that carry the curtains.
pub(super) fn rods(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(12);
    let knob = sphere(0.04, round * 2);
    around(|count| {
        let hung = bays(count)
            .enumerate()
            .filter(|(i, _)| is_hung(count, *i, true) || is_hung(count, *i, false));
        merged(hung.flat_map(|(_, x)| {
            let (half, y, z) = (PITCH * 0.5 - 0.27, SPRING - 0.2, -0.4);
            [
                capsule([x - half, y, z], [x + half, y, z], [0.016, 0.016], round),
                moved(&knob, [x - half, y, z]),
                moved(&knob, [x + half, y, z]),
            ]
        }))
    })
}

/// Two seated figures face each other across the fountain.
const FIGURES: [[f64; 3]; 2] = [[0.0, -5.2, 0.0], [0.0, 5.2, 180.0]];

pub(super) fn figures(parameters: &Parameters) -> Mesh {
    let figure = seated(parameters.cell(0.036));
    merged(FIGURES.map(|[x, z, turn_deg]| set_at(&figure, [x, 0.896, z], turn_deg, 0.8)))
}

pub(super) fn pedestals(_: &Parameters) -> Mesh {
    merged(FIGURES.map(|[x, z, _]| {
        let tier = |half: f64, y: [f64; 2]| {
            bevelled_box([x - half, y[0], z - half], [x + half, y[1], z + half], 0.02)
        };
        merged([
            tier(0.78, [-0.02, 0.12]),
            tier(0.7, [0.1, 0.2]),
            tier(0.6, [0.18, 0.82]),
            tier(0.68, [0.8, 0.9]),
        ])
    }))
}

/// Where planters stand: in the corners of the court and beside the figures.
const PLANTERS: [[f64; 2]; 8] = [
    [-3.1, -7.1],
    [3.1, -7.1],
    [3.1, 7.1],
    [-3.1, 7.1],
    [-3.1, -2.67],
    [3.1, -2.67],
    [3.1, 2.67],
    [-3.1, 2.67],
];

pub(super) fn planters(parameters: &Parameters) -> Mesh {
    let jar = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.2, 0.0],
                [0.22, 0.05],
                [0.34, 0.3],
                [0.33, 0.5],
                [0.36, 0.56],
                [0.35, 0.6],
                [0.3, 0.58],
                [0.28, 0.5],
                [0.0, 0.48],
            ],
            parameters.steps(3),
        ),
        parameters.steps(32),
    );
    merged(PLANTERS.map(|[x, z]| moved(&jar, [x, -0.001, z])))
}

/// What grows in the planters.
pub(super) fn leaves(parameters: &Parameters) -> Mesh {
    let count = (620.0 * parameters.detail * parameters.detail).max(8.0) as usize;
    merged(PLANTERS.into_iter().enumerate().map(|(i, [x, z])| {
        let tall = if i < 4 { 0.62 } else { 0.36 };
        bush(
            parameters.seed,
            Bush {
                centre: [x, 0.5 + tall, z],
                radii: [0.42, tall, 0.42],
                leaves: count,
                leaf: 0.13,
                key: 5000 + i as u64,
            },
        )
    }))
}

/// Stone benches along the outer walls.
pub(super) fn benches(_: &Parameters) -> Mesh {
    around(|count| {
        let placed = bays(count).enumerate().filter(|(i, _)| i % 3 == 2);
        merged(placed.map(|(_, x)| {
            let block = |low: [f64; 3], high: [f64; 3]| bevelled_box(low, high, 0.02);
            let z = -super::AISLE;
            merged([
                block([x - 0.85, 0.4, z + 0.06], [x + 0.85, 0.5, z + 0.52]),
                block([x - 0.7, -0.02, z + 0.12], [x - 0.5, 0.41, z + 0.46]),
                block([x + 0.5, -0.02, z + 0.12], [x + 0.7, 0.41, z + 0.46]),
            ])
        }))
    })
}
