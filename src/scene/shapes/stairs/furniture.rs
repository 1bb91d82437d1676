//! Figures on pedestals, the hanging lamp and the pictures.

use std::f64::consts::PI;

use glam::DMat4;

use super::{BACK_Z, HALL_X, HEIGHT, LANDING_Y};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::figures::seated;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cuboid, curve, lathe, merged, moved, placed, set_at, smooth_profile,
    sphere, torus, tube,
};

pub(super) fn near_figure(parameters: &Parameters) -> Mesh {
    let body = seated(parameters.cell(0.0115));
    set_at(&body, [0.66, 0.798, 0.3], -10.0, 0.52)
}

pub(super) fn far_figure(parameters: &Parameters) -> Mesh {
    let body = seated(parameters.cell(0.016));
    set_at(&body, [0.0, LANDING_Y + 0.548, BACK_Z + 0.15], 0.0, 0.95)
}

pub(super) fn pedestals(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(56);
    let near = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.36, 0.0],
                [0.36, 0.05],
                [0.27, 0.09],
                [0.24, 0.14],
                [0.2, 0.4],
                [0.24, 0.68],
                [0.33, 0.735],
                [0.385, 0.75],
                [0.39, 0.78],
                [0.38, 0.8],
                [0.0, 0.8],
            ],
            parameters.steps(5),
        ),
        round,
    );
    let tier = |half: f64, y: [f64; 2]| {
        let z = BACK_Z + 0.15;
        bevelled_box(
            [-half, LANDING_Y + y[0], z - half.min(0.6)],
            [half, LANDING_Y + y[1], z + half],
            0.012,
        )
    };
    merged([
        moved(&near, [0.66, 0.0, 0.3]),
        tier(0.78, [0.0, 0.1]),
        tier(0.7, [0.08, 0.49]),
        tier(0.75, [0.47, 0.55]),
    ])
}

const LAMP_AT: [f64; 3] = [0.0, 4.1, -1.2];

/// A hanging lamp: rod, ring, six arms with cups.
pub(super) fn lamp(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(40);
    let [x, y, z] = LAMP_AT;
    let rod = capsule([0.0, 0.0, 0.0], [0.0, HEIGHT - y, 0.0], [0.012, 0.012], 14);
    let ring = torus(0.38, 0.014, [round, 12]);
    let arms = (0..6).map(|k| {
        let path = curve(
            &[
                [0.0, 0.0, 0.0],
                [0.15, -0.09, 0.0],
                [0.3, -0.06, 0.0],
                [0.38, 0.0, 0.0],
            ],
            parameters.steps(6),
        );
        let cup = lathe(
            &smooth_profile(
                &[
                    [0.0, 0.0],
                    [0.03, 0.0],
                    [0.06, 0.05],
                    [0.055, 0.05],
                    [0.0, 0.015],
                ],
                5,
            ),
            parameters.steps(24),
        );
        let arm = merged([tube(&path, 0.009, 10), moved(&cup, [0.38, 0.0, 0.0])]);
        placed(&arm, DMat4::from_rotation_y(PI * f64::from(k) / 3.0))
    });
    let boss = sphere(0.05, parameters.steps(28));
    moved(
        &merged([rod, ring, boss].into_iter().chain(arms)),
        [x, y, z],
    )
}

pub(super) fn lamp_glow(parameters: &Parameters) -> Mesh {
    let bulb = sphere(0.045, parameters.steps(24));
    let [x, y, z] = LAMP_AT;
    merged((0..6).map(|k| {
        let angle_rad = PI * f64::from(k) / 3.0;
        moved(
            &bulb,
            [
                x + 0.38 * angle_rad.cos(),
                y + 0.075,
                z - 0.38 * angle_rad.sin(),
            ],
        )
    }))
}

/// (z of the centre, y of the centre, half width, half height) on the right wall.
const PICTURES: [[f64; 4]; 4] = [
    [1.4, 1.75, 0.45, 0.6],
    [-0.4, 2.1, 0.35, 0.45],
    [-2.2, 2.9, 0.4, 0.55],
    [-6.6, 4.4, 0.6, 0.45],
];

pub(super) fn pictures(_: &Parameters) -> Mesh {
    merged(PICTURES.map(|[z, y, half, tall]| {
        cuboid(
            [HALL_X - 0.015, y - tall, z - half],
            [HALL_X, y + tall, z + half],
        )
    }))
}

pub(super) fn picture_frames(_: &Parameters) -> Mesh {
    merged(PICTURES.into_iter().flat_map(|[z, y, half, tall]| {
        let bar = |y: [f64; 2], z: [f64; 2]| {
            bevelled_box([HALL_X - 0.045, y[0], z[0]], [HALL_X, y[1], z[1]], 0.012)
        };
        let (w, h) = (half + 0.06, tall + 0.06);
        [
            bar([y - h, y - tall], [z - w, z + w]),
            bar([y + tall, y + h], [z - w, z + w]),
            bar([y - tall, y + tall], [z - w, z - half]),
            bar([y - tall, y + tall], [z + half, z + w]),
        ]
    }))
}
