//! Floor, walls, ceiling, skirting and windows of the hall.

use std::f64::consts::PI;

use glam::{DMat4, DVec2, DVec3};

use super::{BACK_Z, FIRST_Z, FRONT_Z, HALF_WIDTH, HALL_X, HEIGHT, LANDING_Y, LANDING_Z, RISE};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Opening, bevelled_box, cuboid, merged, moved, placed, sweep, wall,
};

/// Boards along z with fine joints.
pub(super) fn floor(_: &Parameters) -> Mesh {
    let width = 0.2;
    let boards = (HALL_X * 2.0 / width).round() as usize;
    let bed = cuboid([-HALL_X, -0.2, BACK_Z], [HALL_X, -0.0015, FRONT_Z]);
    let board = |i: usize| {
        let x = -HALL_X + width * i as f64;
        let offset = (i * 7 % 5) as f64 * 0.42;
        let cuts: Vec<f64> = [FRONT_Z]
            .into_iter()
            .chain((0..6).map(|k| FRONT_Z - 0.9 - offset - 2.1 * f64::from(k)))
            .chain([BACK_Z])
            .filter(|z| *z >= BACK_Z)
            .collect();
        merged(cuts.windows(2).filter(|w| w[0] - w[1] > 0.05).map(|w| {
            bevelled_box(
                [x + 0.0008, -0.03, w[1] + 0.0008],
                [x + width - 0.0008, 0.0, w[0] - 0.0008],
                0.0015,
            )
        }))
    };
    merged([bed].into_iter().chain((0..boards).map(board)))
}

/// (centre along the wall from its left end, sill, head, half width) of the windows of a side wall.
const WINDOWS: [[f64; 4]; 4] = [
    [2.2, 0.9, 2.6, 0.55],
    [5.2, 2.6, 4.9, 0.55],
    [8.2, 3.5, 5.5, 0.55],
    [11.0, 3.5, 5.5, 0.55],
];

fn side_wall(mesh: &Mesh, right: bool) -> Mesh {
    // Both walls run their own x from the front of the hall to its back.
    let left = placed(
        mesh,
        DMat4::from_translation(DVec3::new(-HALL_X - 0.3, 0.0, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    if right {
        placed(&left, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)))
    } else {
        left
    }
}

pub(super) fn walls(_: &Parameters) -> Mesh {
    let length = FRONT_Z - BACK_Z;
    let openings = WINDOWS.map(|[c, low, high, half]| Opening {
        min: [c - half, low],
        max: [c + half, high],
    });
    let lit = wall([length, HEIGHT], 0.3, &openings);
    let plain = wall([length, HEIGHT], 0.3, &[]);
    let niche = Opening {
        min: [HALL_X - 0.8, LANDING_Y + 0.1],
        max: [HALL_X + 0.8, LANDING_Y + 2.3],
    };
    let back = moved(
        &wall([HALL_X * 2.0, HEIGHT], 0.5, &[niche]),
        [-HALL_X, 0.0, BACK_Z - 0.5],
    );
    let niche_back = cuboid(
        [-1.2, LANDING_Y - 0.2, BACK_Z - 0.6],
        [1.2, HEIGHT, BACK_Z - 0.5],
    );
    let front = cuboid([-HALL_X, 0.0, FRONT_Z], [HALL_X, HEIGHT, FRONT_Z + 0.3]);
    merged([
        side_wall(&lit, false),
        side_wall(&plain, true),
        back,
        niche_back,
        front,
    ])
}

/// Plaster with beams.
pub(super) fn ceiling(_: &Parameters) -> Mesh {
    let plate = cuboid(
        [-HALL_X - 0.3, HEIGHT, BACK_Z - 0.6],
        [HALL_X + 0.3, HEIGHT + 0.2, FRONT_Z + 0.3],
    );
    let beams = (0..9).map(|i| {
        let z = FRONT_Z - 0.9 - 1.4 * f64::from(i);
        bevelled_box(
            [-HALL_X, HEIGHT - 0.18, z - 0.08],
            [HALL_X, HEIGHT + 0.05, z + 0.08],
            0.012,
        )
    });
    merged([plate].into_iter().chain(beams))
}

/// Skirting boards along the hall and up the flight.
pub(super) fn skirting(_: &Parameters) -> Mesh {
    let board = |side: f64, z: [f64; 2], y: f64| {
        let (a, b) = (side * (HALL_X - 0.022), side * HALL_X);
        merged([
            bevelled_box([a.min(b), y, z[0]], [a.max(b), y + 0.14, z[1]], 0.006),
            bevelled_box(
                [(a - side * 0.012).min(b), y, z[0]],
                [(a - side * 0.012).max(b), y + 0.03, z[1]],
                0.005,
            ),
        ])
    };
    let dado = |side: f64, z: [f64; 2], y: f64| {
        let (a, b) = (side * (HALL_X - 0.03), side * HALL_X);
        bevelled_box([a.min(b), y, z[0]], [a.max(b), y + 0.05, z[1]], 0.01)
    };
    let stringer = |side: f64| {
        let line = [[FIRST_Z + 0.05, 0.0], [LANDING_Z, LANDING_Y - RISE]]
            .map(|[z, y]| DVec3::new(side * (HALF_WIDTH + 0.015), y + 0.02, z));
        let section =
            [[-0.015, -0.1], [0.015, -0.1], [0.015, 0.13], [-0.015, 0.13]].map(DVec2::from);
        sweep(&line, &section, false)
    };
    merged([-1.0, 1.0].into_iter().flat_map(|side| {
        [
            board(side, [LANDING_Z, FRONT_Z], 0.0),
            board(side, [BACK_Z, LANDING_Z], LANDING_Y),
            dado(side, [BACK_Z, LANDING_Z], LANDING_Y + 0.9),
            stringer(side),
        ]
    }))
}

/// Frames, sills and glazing bars.
pub(super) fn windows(_: &Parameters) -> Mesh {
    let frame = |[c, low, high, half]: [f64; 4]| {
        let bar = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
            bevelled_box([x[0], y[0], z[0]], [x[1], y[1], z[1]], 0.004)
        };
        let (l, r) = (c - half, c + half);
        let mut pieces = vec![
            bar([l, l + 0.06], [low, high], [0.1, 0.17]),
            bar([r - 0.06, r], [low, high], [0.1, 0.17]),
            bar([l + 0.06, r - 0.06], [low, low + 0.07], [0.1, 0.17]),
            bar([l + 0.06, r - 0.06], [high - 0.06, high], [0.1, 0.17]),
            bar(
                [c - 0.025, c + 0.025],
                [low + 0.07, high - 0.06],
                [0.11, 0.16],
            ),
            bar([l - 0.08, r + 0.08], [low - 0.05, low], [0.17, 0.38]),
        ];
        for k in 1..5 {
            let y = low + (high - low) * f64::from(k) / 5.0;
            pieces.push(bar(
                [l + 0.06, r - 0.06],
                [y - 0.013, y + 0.013],
                [0.12, 0.15],
            ));
        }
        for x in [c - half * 0.5, c + half * 0.5] {
            pieces.push(bar(
                [x - 0.013, x + 0.013],
                [low + 0.07, high - 0.06],
                [0.122, 0.148],
            ));
        }
        merged(pieces)
    };
    side_wall(&merged(WINDOWS.map(frame)), false)
}
