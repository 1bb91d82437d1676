//! Hanging chains and the lanterns on them.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::{PITCH, ROW_X, column_z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, circle, curve, lathe, merged, moved, placed, set_at, smooth_profile, sweep,
    torus, tube, y_towards,
};

/// Where lanterns hang, and how deep: (x, y of the hook, z, links).
const HANGING: [[f64; 4]; 5] = [
    [-0.85, 6.6, -0.4, 46.0],
    [1.3, 6.9, -3.2, 50.0],
    [-1.2, 6.9, -8.4, 50.0],
    [1.2, 6.9, -13.6, 50.0],
    [0.0, 6.9, -19.0, 46.0],
];

const LINK: f64 = 0.068;

/// Links that alternate by a quarter turn, straight down from iron beams.
pub(super) fn chains(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(8);
    let path: Vec<DVec3> = (0..2 * steps)
        .map(|i| {
            let angle_rad = PI * (i as f64 + 0.5) / steps as f64;
            let (s, c) = angle_rad.sin_cos();
            DVec3::new(0.026 * c, 0.018 * s.signum() + 0.026 * s, 0.0)
        })
        .collect();
    let link = sweep(&path, &circle(0.0085, parameters.steps(8)), true);
    let mut pieces = Vec::new();
    for [x, y, z, count] in HANGING {
        for i in 0..count as usize {
            let turn_deg = if i % 2 == 0 { 20.0 } else { 110.0 };
            pieces.push(set_at(&link, [x, y - LINK * i as f64, z], turn_deg, 1.0));
        }
        let (reach, high) = (ROW_X + 0.05, y + 0.03);
        pieces.push(bevelled_box(
            [-reach, high, z - 0.04],
            [reach, high + 0.1, z + 0.04],
            0.01,
        ));
    }
    pieces.push(swag(&link, column_z(0) - PITCH, 4.3));
    pieces.push(swag(&link, column_z(0) - 3.0 * PITCH, 4.3));
    merged(pieces)
}

/// A heavy chain that sags across the court at `z` between hooks on the columns at height `y`.
fn swag(link: &Mesh, z: f64, y: f64) -> Mesh {
    let scale = 2.0;
    let pitch = LINK * scale;
    let reach = ROW_X - 0.3;
    // A catenary y = a cosh(x / a), walked by arc length.
    let a = 3.4;
    let total = 2.0 * a * (reach / a).sinh();
    let count = (total / pitch).round() as usize;
    merged((0..=count).map(|i| {
        let along = (i as f64 / count as f64 - 0.5) * total;
        let x = a * (along / a).asinh();
        let drop = a * ((x / a).cosh() - (reach / a).cosh());
        let tangent = DVec3::new(1.0, (x / a).sinh(), 0.0);
        let turn_rad = if i % 2 == 0 { 0.3 } else { 0.3 + PI * 0.5 };
        placed(
            link,
            DMat4::from_translation(DVec3::new(x, y + drop, z))
                * y_towards(tangent)
                * DMat4::from_rotation_y(turn_rad)
                * DMat4::from_scale(DVec3::splat(scale)),
        )
    }))
}

fn lantern_spots() -> impl Iterator<Item = [f64; 3]> {
    HANGING
        .into_iter()
        .map(|[x, y, z, count]| [x, y - LINK * (count - 1.0) - 0.04, z])
}

/// Cages of bent bars between two dishes.
pub(super) fn lanterns(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(30);
    let roof = lathe(
        &smooth_profile(
            &[
                [0.0, -0.14],
                [0.16, -0.14],
                [0.17, -0.125],
                [0.05, -0.05],
                [0.02, -0.02],
                [0.0, -0.01],
            ],
            parameters.steps(4),
        ),
        round,
    );
    let dish = lathe(
        &smooth_profile(
            &[
                [0.0, -0.56],
                [0.06, -0.55],
                [0.13, -0.5],
                [0.13, -0.485],
                [0.0, -0.49],
            ],
            4,
        ),
        round,
    );
    let rib = curve(
        &[
            [0.14, -0.13, 0.0],
            [0.18, -0.25, 0.0],
            [0.165, -0.4, 0.0],
            [0.12, -0.5, 0.0],
        ],
        parameters.steps(5),
    );
    let bars = (0..8).map(|k| {
        let bar = tube(&rib, 0.007, 8);
        placed(&bar, DMat4::from_rotation_y(TAU * f64::from(k) / 8.0))
    });
    let hoop = moved(&torus(0.183, 0.007, [round, 8]), [0.0, -0.28, 0.0]);
    let whole = merged([roof, dish, hoop].into_iter().chain(bars));
    merged(lantern_spots().map(|at| moved(&whole, at)))
}

pub(super) fn flames(parameters: &Parameters) -> Mesh {
    let drop = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.045, 0.03],
                [0.05, 0.08],
                [0.02, 0.16],
                [0.0, 0.2],
            ],
            5,
        ),
        parameters.steps(24),
    );
    merged(lantern_spots().map(|[x, y, z]| moved(&drop, [x, y - 0.48, z])))
}
