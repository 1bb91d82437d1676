//! Carcasses with their doors, drawers and handles.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::{BACK_Z, BASE_Z, GAP, PLINTH, ROOM_X, TOP, UPPER_Z, is_open, unit_x};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{bevelled_box, capsule, cuboid, merged, moved, placed};

pub(super) fn carcasses(_: &Parameters) -> Mesh {
    let mut pieces = vec![cuboid(
        [-ROOM_X, 0.0, BACK_Z],
        [ROOM_X, PLINTH, BASE_Z - 0.06],
    )];
    for i in 0..8 {
        let x = [unit_x(i) + 0.001, unit_x(i + 1) - 0.001];
        pieces.push(cuboid(
            [x[0], PLINTH, BACK_Z],
            [x[1], TOP - 0.04, BASE_Z - 0.022],
        ));
        if !is_open(i) {
            pieces.push(cuboid([x[0], 1.44, BACK_Z], [x[1], 2.3, UPPER_Z - 0.022]));
        }
    }
    let tall = [ROOM_X - 0.62, ROOM_X];
    pieces.push(cuboid([tall[0], 0.1, -1.1], [tall[1] - 0.002, 2.3, 0.1]));
    pieces.push(cuboid(
        [tall[0] + 0.05, 0.0, -1.08],
        [tall[1] - 0.002, 0.1, 0.08],
    ));
    merged(pieces)
}

/// A framed front: a panel set back in four rails.
fn front(min: [f64; 2], max: [f64; 2], z: f64) -> Mesh {
    let [x0, y0] = min.map(|v| v + GAP);
    let [x1, y1] = max.map(|v| v - GAP);
    let rail = 0.055_f64.min((y1 - y0) * 0.3);
    let bar = |x: [f64; 2], y: [f64; 2], depth: f64| {
        bevelled_box([x[0], y[0], z - 0.02], [x[1], y[1], z + depth], 0.0025)
    };
    merged([
        bar([x0, x0 + rail], [y0, y1], 0.0),
        bar([x1 - rail, x1], [y0, y1], 0.0),
        bar([x0 + rail, x1 - rail], [y0, y0 + rail], 0.0),
        bar([x0 + rail, x1 - rail], [y1 - rail, y1], 0.0),
        bar([x0 + rail, x1 - rail], [y0 + rail, y1 - rail], -0.009),
    ])
}

/// Base units 1 and 6 have three drawers, one of them ajar; unit 5 is the stove.
fn has_drawers(i: usize) -> bool {
    i == 1 || i == 6
}

fn drawer_rows() -> [[f64; 2]; 3] {
    [[0.1, 0.4], [0.4, 0.66], [0.66, TOP - 0.045]]
}

/// How far a drawer stands open.
fn drawer_pull(unit: usize, row: usize) -> f64 {
    if (unit, row) == (1, 2) { 0.16 } else { 0.0 }
}

/// The turn of an open door about its left edge.
const DOOR_OPEN_DEG: f64 = -38.0;
const OPEN_DOOR: usize = 2;

fn tall_unit() -> DMat4 {
    DMat4::from_translation(DVec3::new(ROOM_X - 0.62, 0.0, -0.5))
        * DMat4::from_rotation_y(-PI * 0.5)
}

fn hinge(i: usize) -> DMat4 {
    let at = DVec3::new(unit_x(i), 0.0, UPPER_Z - 0.02);
    DMat4::from_translation(at)
        * DMat4::from_rotation_y(DOOR_OPEN_DEG.to_radians())
        * DMat4::from_translation(-at)
}

pub(super) fn fronts(_: &Parameters) -> Mesh {
    let mut pieces = Vec::new();
    for i in 0..8 {
        let (x0, x1) = (unit_x(i), unit_x(i + 1));
        if has_drawers(i) {
            for (row, [y0, y1]) in drawer_rows().into_iter().enumerate() {
                let pull = drawer_pull(i, row);
                pieces.push(front([x0, y0], [x1, y1], BASE_Z + pull));
                if pull > 0.0 {
                    pieces.push(open_drawer(
                        [x0 + 0.02, x1 - 0.02],
                        [y0 + 0.03, y1 - 0.06],
                        pull,
                    ));
                }
            }
        } else if i != 5 {
            pieces.push(front([x0, PLINTH], [x1, TOP - 0.045], BASE_Z));
        }
        if !is_open(i) {
            let door = front([x0, 1.44], [x1, 2.3], UPPER_Z);
            pieces.push(if i == OPEN_DOOR {
                placed(&door, hinge(i))
            } else {
                door
            });
        }
    }
    for (x, y) in [(-0.6, 0.1), (0.0, 0.1), (-0.6, 1.25), (0.0, 1.25)] {
        let door = front([x, y], [x + 0.6, if y < 1.0 { 1.25 } else { 2.3 }], 0.02);
        pieces.push(placed(&door, tall_unit()));
    }
    merged(pieces)
}

/// Sides and bottom of a drawer that stands open.
fn open_drawer(x: [f64; 2], y: [f64; 2], pull: f64) -> Mesh {
    let z = [BASE_Z - 0.021, BASE_Z + pull - 0.02];
    merged([
        cuboid([x[0], y[0], z[0]], [x[0] + 0.014, y[1], z[1]]),
        cuboid([x[1] - 0.014, y[0], z[0]], [x[1], y[1], z[1]]),
        cuboid(
            [x[0] + 0.014, y[0], z[0]],
            [x[1] - 0.014, y[0] + 0.01, z[1]],
        ),
    ])
}

/// A bar handle 8 mm thick on two posts, lying along x and centred on the origin.
pub(super) fn handle(parameters: &Parameters, length: f64) -> Mesh {
    let half = length * 0.5;
    let round = parameters.steps(16);
    let post = |x: f64| capsule([x, 0.0, -0.002], [x, 0.0, 0.032], [0.0035, 0.0035], round);
    merged([
        capsule(
            [-half, 0.0, 0.032],
            [half, 0.0, 0.032],
            [0.004, 0.004],
            round,
        ),
        post(-half * 0.8),
        post(half * 0.8),
    ])
}

pub(super) fn handles(parameters: &Parameters) -> Mesh {
    let level = handle(parameters, 0.3);
    let upright = placed(&handle(parameters, 0.22), DMat4::from_rotation_z(PI * 0.5));
    let mut pieces = Vec::new();
    for i in 0..8 {
        let (x0, x1) = (unit_x(i), unit_x(i + 1));
        let edge = if i % 2 == 0 { x1 - 0.035 } else { x0 + 0.035 };
        if has_drawers(i) {
            for (row, [_, y1]) in drawer_rows().into_iter().enumerate() {
                let at = [(x0 + x1) * 0.5, y1 - 0.032, BASE_Z + drawer_pull(i, row)];
                pieces.push(moved(&level, at));
            }
        } else if i != 5 {
            pieces.push(moved(&upright, [edge, 0.68, BASE_Z]));
        }
        if !is_open(i) {
            let grip = moved(&upright, [edge, 1.6, UPPER_Z]);
            pieces.push(if i == OPEN_DOOR {
                placed(&grip, hinge(i))
            } else {
                grip
            });
        }
    }
    for (x, y) in [(-0.035, 1.05), (0.035, 1.05), (-0.035, 1.45), (0.035, 1.45)] {
        pieces.push(placed(&moved(&upright, [x, y, 0.02]), tall_unit()));
    }
    merged(pieces)
}
