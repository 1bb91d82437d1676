//! The worktop with its sink, the stove and the towel before it.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::cabinets::handle;
use super::{BACK_Z, BASE_Z, GAP, ROOM_X, TOP, unit_x};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Opening, bevelled_box, capsule, cuboid, curve, cylinder, lathe, merged, moved, placed, set_at,
    sheet, smooth_profile, torus, tube, wall,
};

/// Where the sink is cut out of the worktop: x and z ranges.
const SINK: [[f64; 2]; 2] = [[-0.95, -0.42], [BACK_Z + 0.14, BACK_Z + 0.5]];

pub(super) fn worktop(_: &Parameters) -> Mesh {
    let [x, z] = SINK;
    let hole = Opening {
        min: [x[0] + ROOM_X, -z[1] + BASE_Z + 0.03],
        max: [x[1] + ROOM_X, -z[0] + BASE_Z + 0.03],
    };
    // A wall laid on its back: its height runs towards the kitchen wall.
    let slab = wall([ROOM_X * 2.0, BASE_Z + 0.03 - BACK_Z], 0.04, &[hole]);
    let lying = DMat4::from_translation(DVec3::new(-ROOM_X, TOP - 0.04, BASE_Z + 0.03))
        * DMat4::from_rotation_x(-PI * 0.5);
    let strip = bevelled_box(
        [-ROOM_X, TOP - 0.001, BACK_Z],
        [ROOM_X, TOP + 0.012, BACK_Z + 0.016],
        0.004,
    );
    let board = bevelled_box(
        [-1.75, TOP, BASE_Z - 0.42],
        [-1.33, TOP + 0.022, BASE_Z - 0.12],
        0.006,
    );
    merged([placed(&slab, lying), strip, board])
}

pub(super) fn sink_and_tap(parameters: &Parameters) -> Mesh {
    let [x, z] = SINK;
    let depth = 0.028;
    let floor_y = TOP - 0.032;
    let rim = 0.012;
    let bar = |x: [f64; 2], z: [f64; 2]| {
        bevelled_box(
            [x[0], floor_y - 0.006, z[0]],
            [x[1], TOP + 0.004, z[1]],
            0.0025,
        )
    };
    let basin = merged([
        bar([x[0] - rim, x[0] + rim], [z[0] - rim, z[1] + rim]),
        bar([x[1] - rim, x[1] + rim], [z[0] - rim, z[1] + rim]),
        bar([x[0] + rim, x[1] - rim], [z[0] - rim, z[0] + rim]),
        bar([x[0] + rim, x[1] - rim], [z[1] - rim, z[1] + rim]),
        cuboid([x[0], floor_y - 0.006, z[0]], [x[1], TOP - depth, z[1]]),
    ]);
    let round = parameters.steps(24);
    let centre = (x[0] + x[1]) * 0.5;
    let drain = moved(
        &torus(0.03, 0.004, [round, 8]),
        [centre, TOP - depth, (z[0] + z[1]) * 0.5],
    );
    let spout = tube(
        &curve(
            &[
                [0.0, 0.03, 0.0],
                [0.0, 0.22, 0.0],
                [0.0, 0.31, 0.05],
                [0.0, 0.3, 0.14],
                [0.0, 0.22, 0.17],
            ],
            parameters.steps(9),
        ),
        0.011,
        parameters.steps(18),
    );
    let foot = cylinder(0.026, 0.05, 0.004, round);
    let lever = capsule([0.0, 0.05, 0.0], [0.02, 0.1, 0.02], [0.006, 0.004], 12);
    let valves =
        [-0.09, 0.09].map(|dx| moved(&merged([foot.clone(), lever.clone()]), [dx, 0.0, 0.0]));
    let bridge = capsule([-0.09, 0.03, 0.0], [0.09, 0.03, 0.0], [0.009, 0.009], 14);
    let tap = merged([foot, spout, bridge].into_iter().chain(valves));
    merged([basin, drain, moved(&tap, [centre, TOP, z[0] - 0.05])])
}

/// An oven under four rings with a pot and a pan.
pub(super) fn stove(parameters: &Parameters) -> Mesh {
    let (x0, x1) = (unit_x(5), unit_x(6));
    let centre = (x0 + x1) * 0.5;
    let round = parameters.steps(40);
    let door = bevelled_box(
        [x0 + GAP, 0.14, BASE_Z - 0.021],
        [x1 - GAP, 0.7, BASE_Z + 0.004],
        0.004,
    );
    let panel = bevelled_box(
        [x0 + GAP, 0.705, BASE_Z - 0.021],
        [x1 - GAP, 0.855, BASE_Z + 0.004],
        0.004,
    );
    let grip = placed(
        &handle(parameters, 0.44),
        DMat4::from_translation(DVec3::new(centre, 0.65, BASE_Z + 0.004))
            * DMat4::from_scale(DVec3::splat(1.2)),
    );
    let knob = placed(
        &cylinder(0.019, 0.026, 0.004, parameters.steps(24)),
        DMat4::from_rotation_x(PI * 0.5),
    );
    let knobs = (0..5).map(|k| {
        moved(
            &knob,
            [x0 + 0.085 + 0.1 * f64::from(k), 0.78, BASE_Z + 0.003],
        )
    });
    let hob = bevelled_box(
        [x0 + 0.03, TOP - 0.002, BACK_Z + 0.08],
        [x1 - 0.03, TOP + 0.006, BASE_Z - 0.05],
        0.003,
    );
    let spots = [[-0.12, 0.19], [0.12, 0.19], [-0.12, 0.41], [0.12, 0.41]];
    let rings = spots.map(|[dx, dz]| {
        moved(
            &torus(0.075, 0.005, [round, 8]),
            [centre + dx, TOP + 0.009, BACK_Z + dz],
        )
    });
    let pot = lathe(
        &[
            [0.0, 0.0],
            [0.09, 0.0],
            [0.096, 0.006],
            [0.096, 0.13],
            [0.099, 0.133],
            [0.092, 0.133],
            [0.092, 0.01],
            [0.0, 0.01],
        ],
        round,
    );
    let lid = lathe(
        &smooth_profile(
            &[
                [0.0, 0.134],
                [0.1, 0.134],
                [0.1, 0.138],
                [0.05, 0.152],
                [0.008, 0.157],
                [0.01, 0.175],
                [0.0, 0.18],
            ],
            4,
        ),
        round,
    );
    let pan = lathe(
        &[
            [0.0, 0.0],
            [0.085, 0.0],
            [0.108, 0.04],
            [0.104, 0.04],
            [0.082, 0.005],
            [0.0, 0.005],
        ],
        round,
    );
    let pan_grip = capsule([0.1, 0.035, 0.0], [0.27, 0.055, 0.0], [0.008, 0.01], 14);
    merged(
        [
            door,
            panel,
            grip,
            hob,
            moved(
                &merged([pot, lid]),
                [centre - 0.12, TOP + 0.014, BACK_Z + 0.19],
            ),
            set_at(
                &merged([pan, pan_grip]),
                [centre + 0.12, TOP + 0.014, BACK_Z + 0.41],
                -35.0,
                1.0,
            ),
        ]
        .into_iter()
        .chain(knobs)
        .chain(rings),
    )
}

/// A towel over the oven's handle.
pub(super) fn towel(parameters: &Parameters) -> Mesh {
    let centre = (unit_x(5) + unit_x(6)) * 0.5 + 0.05;
    sheet(
        [parameters.steps(34), parameters.steps(60)],
        0.003,
        |u, v| {
            let (bar_y, bar_z, r) = (0.65, BASE_Z + 0.0424, 0.0095);
            let wave = 0.008 * (u * 17.0 + 0.8).sin() + 0.004 * (u * 31.0).sin();
            let x = centre + (u - 0.5) * 0.24;
            // From the front hem up, over the bar and down behind.
            let (y, z) = if v < 0.55 {
                let drop = (0.55 - v) / 0.55;
                (
                    bar_y - 0.36 * drop,
                    bar_z + r + (wave + 0.012) * drop.sqrt(),
                )
            } else if v < 0.62 {
                let angle_rad = PI * (v - 0.55) / 0.07;
                (bar_y + r * angle_rad.sin(), bar_z + r * angle_rad.cos())
            } else {
                (bar_y - 0.22 * (v - 0.62) / 0.38, bar_z - r)
            };
            DVec3::new(x, y, z)
        },
    )
}
