//! Floor, walls, ceiling, tiles and window.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::{BACK_Z, FRONT_Z, GAP, HEIGHT, ROOM_X, TOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{Opening, bevelled_box, cuboid, jitter, merged, placed, wall};

pub(super) fn floor(_: &Parameters) -> Mesh {
    let size = 0.3;
    let columns = (ROOM_X * 2.0 / size).ceil() as usize;
    let rows = ((FRONT_Z - BACK_Z) / size).ceil() as usize;
    let bed = cuboid([-ROOM_X, -0.2, BACK_Z], [ROOM_X, -0.0015, FRONT_Z]);
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    merged([bed].into_iter().chain(all.map(|(i, j)| {
        let (x, z) = (-ROOM_X + i as f64 * size, BACK_Z + j as f64 * size);
        let (right, front) = ((x + size).min(ROOM_X), (z + size).min(FRONT_Z));
        bevelled_box(
            [x + GAP, -0.02, z + GAP],
            [right - GAP, 0.0, front - GAP],
            0.001,
        )
    })))
}

/// Sill and head of the window in the left wall, and its span along z.
const WINDOW: [f64; 4] = [1.0, 2.15, -0.9, 0.9];

pub(super) fn walls(_: &Parameters) -> Mesh {
    let length = FRONT_Z - BACK_Z;
    let [sill, head, back, front] = WINDOW;
    let hole = Opening {
        min: [FRONT_Z - front, sill],
        max: [FRONT_Z - back, head],
    };
    let left = placed(
        &wall([length, HEIGHT], 0.25, &[hole]),
        DMat4::from_translation(DVec3::new(-ROOM_X - 0.25, 0.0, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    merged([
        left,
        cuboid([ROOM_X, 0.0, BACK_Z], [ROOM_X + 0.2, HEIGHT, FRONT_Z]),
        cuboid(
            [-ROOM_X - 0.25, 0.0, BACK_Z - 0.2],
            [ROOM_X + 0.2, HEIGHT, BACK_Z],
        ),
        cuboid(
            [-ROOM_X - 0.25, 0.0, FRONT_Z],
            [ROOM_X + 0.2, HEIGHT, FRONT_Z + 0.2],
        ),
    ])
}

pub(super) fn ceiling(_: &Parameters) -> Mesh {
    cuboid(
        [-ROOM_X - 0.25, HEIGHT, BACK_Z - 0.2],
        [ROOM_X + 0.2, HEIGHT + 0.2, FRONT_Z + 0.2],
    )
}

/// Bricks of glazed tile in running bond between worktop and wall cabinets.
pub(super) fn wall_tiles(parameters: &Parameters) -> Mesh {
    let (width, height) = (0.15, 0.075);
    // The grout lies a little behind the glazed faces.
    let mut pieces = vec![cuboid(
        [-ROOM_X, TOP, BACK_Z - 0.002],
        [ROOM_X, TOP + 0.005 + height * 7.0, BACK_Z + 0.0068],
    )];
    for row in 0..7 {
        let y = TOP + 0.005 + height * f64::from(row);
        let mut x = -ROOM_X - if row % 2 == 0 { 0.0 } else { width * 0.5 };
        let mut column = 0;
        while x < ROOM_X - 0.01 {
            let (left, right) = (x.max(-ROOM_X), (x + width).min(ROOM_X));
            let key = (row * 100 + column) as u64;
            let depth = 0.008 + jitter(parameters.seed, key, [0.0, 0.0012]);
            if right - left > 0.01 {
                pieces.push(bevelled_box(
                    [left + 0.0012, y + 0.0012, BACK_Z - 0.002],
                    [right - 0.0012, y + height - 0.0012, BACK_Z + depth],
                    0.001,
                ));
            }
            x += width;
            column += 1;
        }
    }
    merged(pieces)
}

/// The window's frame and sill.
pub(super) fn window(_: &Parameters) -> Mesh {
    let [sill, head, back, front] = WINDOW;
    let bar = |y: [f64; 2], z: [f64; 2], x: [f64; 2]| {
        bevelled_box([x[0], y[0], z[0]], [x[1], y[1], z[1]], 0.004)
    };
    let depth = [-ROOM_X - 0.16, -ROOM_X - 0.09];
    let middle = (back + front) * 0.5;
    merged([
        bar([sill, head], [back, back + 0.06], depth),
        bar([sill, head], [front - 0.06, front], depth),
        bar([sill, sill + 0.06], [back + 0.06, front - 0.06], depth),
        bar([head - 0.06, head], [back + 0.06, front - 0.06], depth),
        bar(
            [sill + 0.06, head - 0.06],
            [middle - 0.03, middle + 0.03],
            depth,
        ),
        bar(
            [sill - 0.03, sill],
            [back - 0.06, front + 0.06],
            [-ROOM_X - 0.09, -ROOM_X + 0.16],
        ),
    ])
}
