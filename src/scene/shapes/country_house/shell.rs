//! Walls, floors and ceilings.

use std::f64::consts::PI;

use glam::{DMat4, DVec2, DVec3};

use super::{
    BACK_Z, DOOR_TOP, DOOR_X, FRONT_Z, HEIGHT, HOUSE_X, HOUSE_Z, LAWN, ROOM_X, WINDOW_Y, WINDOWS_X,
};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Opening, bevelled_box, cuboid, merged, moved, placed, strip_solid, wall,
};

/// How far the walls reach into the ground.
const FOOT: f64 = -0.3;

/// The front with its door and windows, the left wall with the kitchen's side window, and the gables.
pub(super) fn walls(_: &Parameters) -> Mesh {
    let opening = |x: [f64; 2], y: [f64; 2]| Opening {
        min: [x[0] - HOUSE_X[0], y[0] - FOOT],
        max: [x[1] - HOUSE_X[0], y[1] - FOOT],
    };
    let openings: Vec<Opening> = WINDOWS_X
        .map(|x| opening(x, WINDOW_Y))
        .into_iter()
        .chain([opening(DOOR_X, [0.0, DOOR_TOP])])
        .collect();
    let size = [HOUSE_X[1] - HOUSE_X[0], HEIGHT - FOOT];
    let front = moved(
        &wall(size, HOUSE_Z[1] - FRONT_Z, &openings),
        [HOUSE_X[0], FOOT, FRONT_Z],
    );
    let side = Opening {
        min: [FRONT_Z - 0.9, 1.0 - FOOT],
        max: [FRONT_Z + 0.9, 2.15 - FOOT],
    };
    let left = placed(
        &wall([FRONT_Z - BACK_Z, HEIGHT - FOOT], 0.25, &[side]),
        DMat4::from_translation(DVec3::new(HOUSE_X[0], FOOT, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    merged([
        front,
        left,
        cuboid([HOUSE_X[0], FOOT, HOUSE_Z[0]], [HOUSE_X[1], HEIGHT, BACK_Z]),
        cuboid(
            [HOUSE_X[1] - 0.25, FOOT, BACK_Z],
            [HOUSE_X[1], HEIGHT, FRONT_Z],
        ),
        gable(HOUSE_X[0]),
        gable(HOUSE_X[1] - 0.25),
    ])
}

/// Height of the ceiling's upper side, on which the gables and the roof stand.
pub(super) const EAVES: f64 = HEIGHT + 0.2;
pub(super) const RIDGE: f64 = 5.0;

/// The triangle under the roof at the end wall whose left face lies at `x`.
fn gable(x: f64) -> Mesh {
    let half = (HOUSE_Z[1] - HOUSE_Z[0]) * 0.5;
    let lower = [-half, 0.0, half].map(|z| DVec2::new(z, EAVES));
    let upper = [(-half, EAVES + 0.01), (0.0, RIDGE), (half, EAVES + 0.01)].map(DVec2::from);
    let middle = (HOUSE_Z[0] + HOUSE_Z[1]) * 0.5;
    placed(
        &strip_solid(&lower, &upper, 0.25),
        DMat4::from_translation(DVec3::new(x, 0.0, middle)) * DMat4::from_rotation_y(PI * 0.5),
    )
}

/// The wall between the rooms.
pub(super) fn inner_walls(_: &Parameters) -> Mesh {
    cuboid([ROOM_X, FOOT, BACK_Z], [ROOM_X + 0.2, HEIGHT, FRONT_Z])
}

/// A course of stone round the foot of the house, and the step before the door.
pub(super) fn plinth(_: &Parameters) -> Mesh {
    let course =
        |x: [f64; 2], z: [f64; 2]| bevelled_box([x[0], FOOT, z[0]], [x[1], 0.22, z[1]], 0.02);
    let (front, back) = (HOUSE_Z[1], HOUSE_Z[0]);
    let stones = |from: f64, to: f64| {
        let count = ((to - from) / 0.62).round().max(1.0);
        let length = (to - from) / count;
        merged((0..count as usize).map(|i| {
            let x = from + length * i as f64;
            course(
                [x + 0.004, x + length - 0.004],
                [front - 0.05, front + 0.06],
            )
        }))
    };
    let step = bevelled_box(
        [DOOR_X[0] - 0.25, LAWN - 0.1, front + 0.002],
        [DOOR_X[1] + 0.25, -0.02, front + 0.55],
        0.015,
    );
    let sill = bevelled_box(
        [DOOR_X[0] + 0.001, -0.1, FRONT_Z - 0.02],
        [DOOR_X[1] - 0.001, 0.012, front + 0.03],
        0.006,
    );
    merged([
        stones(HOUSE_X[0] - 0.06, DOOR_X[0] - 0.02),
        stones(DOOR_X[1] + 0.02, HOUSE_X[1] + 0.06),
        course([HOUSE_X[0] - 0.06, HOUSE_X[0] + 0.05], [back, front - 0.06]),
        course([HOUSE_X[1] - 0.05, HOUSE_X[1] + 0.06], [back, front - 0.06]),
        step,
        sill,
    ])
}

/// The ceiling of both rooms, with beams over the kitchen.
pub(super) fn ceiling(_: &Parameters) -> Mesh {
    let plate = cuboid(
        [HOUSE_X[0], HEIGHT, HOUSE_Z[0]],
        [HOUSE_X[1], EAVES, HOUSE_Z[1]],
    );
    let beams = (0..4).map(|i| {
        let z = -0.6 + 1.1 * f64::from(i);
        bevelled_box(
            [-ROOM_X - 0.05, HEIGHT - 0.13, z - 0.07],
            [ROOM_X + 0.05, HEIGHT + 0.02, z + 0.07],
            0.01,
        )
    });
    merged([plate].into_iter().chain(beams))
}

/// The floor of the second room.
pub(super) fn room_floor(_: &Parameters) -> Mesh {
    cuboid(
        [ROOM_X + 0.2, -0.2, BACK_Z],
        [HOUSE_X[1] - 0.25, 0.0, FRONT_Z],
    )
}
