//! Bottles, plates and cups.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::{BACK_Z, BASE_Z, BOARDS, SHELF_X, TABLE_TOP, TOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    curve, jitter, lathe, merged, moved, placed, set_at, smooth_profile, tube,
};

fn bottle(parameters: &Parameters, size: [f64; 3]) -> Mesh {
    let [radius, height, neck] = size;
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [radius, 0.0],
            [radius, 0.02],
            [radius, height * 0.55],
            [radius * 0.85, height * 0.66],
            [neck, height * 0.78],
            [neck, height * 0.93],
            [neck * 1.3, height * 0.94],
            [neck * 1.3, height],
            [0.0, height],
        ],
        parameters.steps(3),
    );
    lathe(&profile, parameters.steps(28))
}

pub(super) fn bottles(parameters: &Parameters) -> Mesh {
    let z = BACK_Z + 0.13;
    let mut pieces = Vec::new();
    let mut x = SHELF_X[0] + 0.06;
    for k in 0..9u64 {
        let random = |n: u64, range: [f64; 2]| jitter(parameters.seed, 900 + k * 8 + n, range);
        let size = [
            random(0, [0.024, 0.038]),
            random(1, [0.15, 0.25]),
            random(2, [0.009, 0.014]),
        ];
        let at = [x, BOARDS[2] + 0.024, z + random(3, [-0.04, 0.06])];
        pieces.push(moved(&bottle(parameters, size), at));
        x += 2.0 * size[0] + random(4, [0.03, 0.06]);
    }
    // Spice jars on the rack, oil beside the stove, three large bottles on the worktop.
    for k in 0..11 {
        let at = [-1.91 + 0.067 * f64::from(k), 1.32, BACK_Z + 0.05];
        pieces.push(moved(&bottle(parameters, [0.024, 0.085, 0.02]), at));
    }
    for (at, size) in [
        ([0.36, TOP, BACK_Z + 0.12], [0.034, 0.3, 0.012]),
        ([0.27, TOP, BACK_Z + 0.16], [0.03, 0.24, 0.011]),
        ([1.3, TOP, BACK_Z + 0.2], [0.042, 0.32, 0.014]),
        ([0.14, TABLE_TOP, 0.14], [0.04, 0.31, 0.014]),
    ] {
        pieces.push(moved(&bottle(parameters, size), at));
    }
    merged(pieces)
}

pub(super) fn plates(parameters: &Parameters) -> Mesh {
    let plate = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.06, 0.0],
                [0.065, 0.004],
                [0.09, 0.008],
                [0.118, 0.018],
                [0.12, 0.021],
                [0.115, 0.021],
                [0.085, 0.012],
                [0.0, 0.006],
            ],
            parameters.steps(3),
        ),
        parameters.steps(48),
    );
    let z = BACK_Z + 0.15;
    let stack = (0..7).map(|k| {
        moved(
            &plate,
            [
                SHELF_X[0] + 0.17,
                BOARDS[0] + 0.024 + 0.0085 * f64::from(k),
                z,
            ],
        )
    });
    let small = (0..6).map(|k| {
        set_at(
            &plate,
            [
                SHELF_X[0] + 0.44,
                BOARDS[0] + 0.024 + 0.0065 * f64::from(k),
                z,
            ],
            0.0,
            0.75,
        )
    });
    // Upright in a row, leaning against the wall.
    let row = (0..5).map(|k| {
        let at = DVec3::new(
            SHELF_X[0] + 0.16 + 0.19 * f64::from(k),
            BOARDS[1] + 0.024 + 0.115,
            BACK_Z + 0.055,
        );
        placed(
            &plate,
            DMat4::from_translation(at) * DMat4::from_rotation_x(PI * 0.5 - 0.22),
        )
    });
    let drying = (0..3).map(|k| moved(&plate, [-1.1, TOP + 0.0085 * f64::from(k), BACK_Z + 0.3]));
    let set_out = [[-0.08, 0.3], [0.36, 0.5]].map(|[x, z]| moved(&plate, [x, TABLE_TOP, z]));
    merged(stack.chain(small).chain(row).chain(drying).chain(set_out))
}

pub(super) fn cups(parameters: &Parameters) -> Mesh {
    let body = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.028, 0.0],
                [0.034, 0.006],
                [0.04, 0.05],
                [0.041, 0.08],
                [0.0375, 0.08],
                [0.036, 0.05],
                [0.03, 0.01],
                [0.0, 0.008],
            ],
            parameters.steps(3),
        ),
        parameters.steps(36),
    );
    let ear = tube(
        &curve(
            &[
                [0.036, 0.065, 0.0],
                [0.06, 0.067, 0.0],
                [0.067, 0.045, 0.0],
                [0.055, 0.022, 0.0],
                [0.034, 0.02, 0.0],
            ],
            parameters.steps(6),
        ),
        0.005,
        parameters.steps(12),
    );
    let cup = merged([body, ear]);
    let mut spots: Vec<[f64; 4]> = (0..5)
        .map(|k| {
            [
                SHELF_X[0] + 0.64 + 0.105 * f64::from(k),
                BOARDS[0] + 0.024,
                BACK_Z + 0.15,
                30.0 + 17.0 * f64::from(k),
            ]
        })
        .collect();
    spots.push([-1.5, TOP + 0.022, BASE_Z - 0.22, 200.0]);
    spots.push([-0.22, TABLE_TOP, 0.5, 130.0]);
    spots.push([0.42, TABLE_TOP, 0.18, 250.0]);
    spots.push([1.45, TOP, BASE_Z - 0.2, 320.0]);
    merged(
        spots
            .into_iter()
            .map(|[x, y, z, turn_deg]| set_at(&cup, [x, y, z], turn_deg, 1.0)),
    )
}
