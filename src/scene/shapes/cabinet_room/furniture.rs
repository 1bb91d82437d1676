//! Shelves, lamp, stools and table.

use std::f64::consts::TAU;

use super::{BACK_Z, BOARDS, HEIGHT, SHELF_X, TABLE_TOP, UPPER_Z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cuboid, cylinder, lathe, merged, moved, set_at, smooth_profile, sphere,
    torus,
};

pub(super) fn shelves(_: &Parameters) -> Mesh {
    let boards = BOARDS.map(|y| {
        bevelled_box(
            [SHELF_X[0], y, BACK_Z],
            [SHELF_X[1], y + 0.024, UPPER_Z - 0.04],
            0.003,
        )
    });
    let brackets = BOARDS.into_iter().flat_map(|y| {
        [0.12, 0.57, 1.02].map(|x| {
            cuboid(
                [SHELF_X[0] + x, y - 0.012, BACK_Z],
                [SHELF_X[0] + x + 0.012, y, UPPER_Z - 0.08],
            )
        })
    });
    let rack = bevelled_box([-1.95, 1.3, BACK_Z], [-1.2, 1.32, BACK_Z + 0.1], 0.003);
    merged(boards.into_iter().chain(brackets).chain([rack]))
}

const LAMP_AT: [f64; 3] = [0.15, 1.95, 0.35];

/// A pendant shade on its cord.
pub(super) fn lamp(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.15],
            [0.03, 0.15],
            [0.1, 0.133],
            [0.193, 0.057],
            [0.218, 0.0],
            [0.222, 0.004],
            [0.2, 0.06],
            [0.11, 0.14],
            [0.03, 0.17],
            [0.025, 0.22],
            [0.0, 0.225],
        ],
        parameters.steps(4),
    );
    let shade = lathe(&profile, parameters.steps(56));
    let cord = capsule(
        [0.0, 0.22, 0.0],
        [0.0, HEIGHT - LAMP_AT[1], 0.0],
        [0.004, 0.004],
        10,
    );
    let rose = moved(
        &cylinder(0.05, 0.03, 0.005, 28),
        [0.0, HEIGHT - LAMP_AT[1] - 0.03, 0.0],
    );
    moved(&merged([shade, cord, rose]), LAMP_AT)
}

pub(super) fn lamp_glow(parameters: &Parameters) -> Mesh {
    let [x, y, z] = LAMP_AT;
    moved(&sphere(0.055, parameters.steps(28)), [x, y + 0.07, z])
}

/// Two round stools with thin legs and a rung.
pub(super) fn stools(parameters: &Parameters) -> Mesh {
    let seat = lathe(
        &smooth_profile(
            &[
                [0.0, 0.6],
                [0.15, 0.6],
                [0.17, 0.615],
                [0.165, 0.64],
                [0.1, 0.645],
                [0.0, 0.64],
            ],
            4,
        ),
        parameters.steps(44),
    );
    let legs = (0..4).map(|k| {
        let (s, c) = (TAU * (f64::from(k) + 0.5) / 4.0).sin_cos();
        capsule(
            [0.2 * c, 0.012, 0.2 * s],
            [0.11 * c, 0.6, 0.11 * s],
            [0.012, 0.015],
            parameters.steps(14),
        )
    });
    let rung = moved(
        &torus(0.172, 0.007, [parameters.steps(40), 8]),
        [0.0, 0.2, 0.0],
    );
    let stool = merged([seat, rung].into_iter().chain(legs));
    merged([
        set_at(&stool, [1.05, 0.0, 0.3], 10.0, 1.0),
        set_at(&stool, [-0.8, 0.0, 0.25], 35.0, 1.0),
    ])
}

/// A small table under the lamp.
pub(super) fn table(parameters: &Parameters) -> Mesh {
    let (centre, half) = ([0.15, 0.35], [0.6, 0.36]);
    let top = bevelled_box(
        [centre[0] - half[0], TABLE_TOP - 0.03, centre[1] - half[1]],
        [centre[0] + half[0], TABLE_TOP, centre[1] + half[1]],
        0.006,
    );
    let legs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[sx, sz]| {
        let (x, z) = (
            centre[0] + sx * (half[0] - 0.06),
            centre[1] + sz * (half[1] - 0.06),
        );
        let foot = [x + 0.03 * sx, 0.014, z + 0.03 * sz];
        capsule(
            foot,
            [x, TABLE_TOP - 0.03, z],
            [0.014, 0.022],
            parameters.steps(18),
        )
    });
    let apron = bevelled_box(
        [
            centre[0] - half[0] + 0.06,
            TABLE_TOP - 0.1,
            centre[1] - half[1] + 0.06,
        ],
        [
            centre[0] + half[0] - 0.06,
            TABLE_TOP - 0.03,
            centre[1] + half[1] - 0.06,
        ],
        0.004,
    );
    merged([top, apron].into_iter().chain(legs))
}
