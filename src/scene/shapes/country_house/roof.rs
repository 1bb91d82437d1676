//! The tiled roof, its gutters and the chimney.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::shell::{EAVES, RIDGE};
use super::{HOUSE_X, HOUSE_Z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, circle, cylinder, lathe, merged, moved, sheet, smooth_profile, sweep, tube,
};

const ROWS: usize = 15;
const OVERHANG: f64 = 0.45;
/// Width of a tile's wave.
const WAVE: f64 = 0.24;

/// A point of the slope on `side` (+1: the front), `t` from the ridge (0) to the eaves (1).
fn slope(side: f64, x: f64, t: f64) -> DVec3 {
    let middle = (HOUSE_Z[0] + HOUSE_Z[1]) * 0.5;
    let half = (HOUSE_Z[1] - HOUSE_Z[0]) * 0.5;
    let fall = (RIDGE - EAVES) / half;
    let across = (half + OVERHANG) * t;
    DVec3::new(x, RIDGE + 0.1 - fall * across, middle + side * across)
}

/// Rows of waved tiles, each row lifted over the next, with ridge tiles and gutters.
pub(super) fn roof(parameters: &Parameters) -> Mesh {
    let x = [HOUSE_X[0] - 0.3, HOUSE_X[1] + 0.3];
    let columns = parameters.steps(((x[1] - x[0]) / WAVE * 3.0) as usize);
    let row = |side: f64, i: usize| {
        sheet([columns, 2], 0.015, |u, v| {
            let v = if side > 0.0 { 1.0 - v } else { v };
            let t = (i as f64 + 1.12 * v) / ROWS as f64;
            let at = slope(side, x[0] + (x[1] - x[0]) * u, t);
            let wave = 0.022 * (TAU * at.x / WAVE).cos();
            at + DVec3::Y * (wave + 0.05 * v)
        })
    };
    let rows = [-1.0, 1.0]
        .into_iter()
        .flat_map(|side| (0..ROWS).map(move |i| row(side, i)));
    let top = slope(1.0, 0.0, 0.0) + DVec3::Y * 0.02;
    let caps = (0..((x[1] - x[0]) / 0.4) as usize).map(|i| {
        let from = x[0] + 0.4 * i as f64;
        let ends = [0.0, 0.43].map(|dx| DVec3::new(from + dx, top.y, top.z));
        tube(&ends, 0.1 + 0.006 * (i % 2) as f64, parameters.steps(14))
    });
    let gutters = [-1.0, 1.0].map(|side| {
        let at = slope(side, 0.0, 1.0) + DVec3::new(0.0, -0.02, 0.07 * side);
        let ends = x.map(|x| DVec3::new(x, at.y, at.z));
        sweep(&ends, &circle(0.055, parameters.steps(12)), false)
    });
    merged(rows.chain(caps).chain(gutters))
}

/// A chimney with two pots.
pub(super) fn chimney(parameters: &Parameters) -> Mesh {
    let at = DVec2::new(5.1, 0.0);
    let block = |half: f64, y: [f64; 2]| {
        bevelled_box(
            [at.x - half * 1.5, y[0], at.y - half],
            [at.x + half * 1.5, y[1], at.y + half],
            0.015,
        )
    };
    let pot = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.11, 0.0],
                [0.12, 0.05],
                [0.095, 0.3],
                [0.12, 0.36],
                [0.115, 0.4],
                [0.08, 0.4],
                [0.075, 0.2],
                [0.0, 0.15],
            ],
            3,
        ),
        parameters.steps(28),
    );
    merged([
        block(0.32, [EAVES + 0.05, 5.75]),
        block(0.36, [5.6, 5.7]),
        block(0.39, [5.73, 5.85]),
        moved(&pot, [at.x - 0.24, 5.84, at.y]),
        moved(&pot, [at.x + 0.24, 5.84, at.y]),
        moved(&cylinder(0.05, 0.2, 0.01, 12), [at.x, 5.84, at.y]),
    ])
}
