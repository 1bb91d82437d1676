//! A kitchen: cabinets with thin handles and door gaps, shelves of bottles and plates, a worktop with
//! sink and tap, a tiled back wall, a window and a lamp.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::kit::{
    Opening, bevelled_box, capsule, cuboid, curve, cylinder, jitter, lathe, merged, moved, placed,
    set_at, sheet, smooth_profile, torus, tube, wall,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("floor", floor),
    ("walls", walls),
    ("ceiling", ceiling),
    ("wall-tiles", wall_tiles),
    ("carcasses", carcasses),
    ("fronts", fronts),
    ("handles", handles),
    ("worktop", worktop),
    ("sink-and-tap", sink_and_tap),
    ("stove", stove),
    ("shelves", shelves),
    ("bottles", bottles),
    ("plates", plates),
    ("cups", cups),
    ("towel", towel),
    ("window", window),
    ("lamp", lamp),
    ("lamp-glow", lamp_glow),
    ("stools", stools),
    ("table", table),
];

/// The room: x = ±2.3, z from -2.2 (the kitchen wall) to 3.2, 2.6 m high.
const ROOM_X: f64 = 2.3;
const BACK_Z: f64 = -2.2;
const FRONT_Z: f64 = 3.2;
const HEIGHT: f64 = 2.6;
/// Fronts of base and wall cabinets, and the worktop's upper side.
const BASE_Z: f64 = BACK_Z + 0.58;
const UPPER_Z: f64 = BACK_Z + 0.34;
const TOP: f64 = 0.9;
const PLINTH: f64 = 0.1;
/// Width of a cabinet; eight stand side by side from x = -2.3 to 2.26.
const UNIT: f64 = 0.57;
const GAP: f64 = 0.002;

fn floor(_: &Parameters) -> Mesh {
    let size = 0.3;
    let columns = (ROOM_X * 2.0 / size).ceil() as usize;
    let rows = ((FRONT_Z - BACK_Z) / size).ceil() as usize;
    let bed = cuboid([-ROOM_X, -0.2, BACK_Z], [ROOM_X, -0.004, FRONT_Z]);
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    merged([bed].into_iter().chain(all.map(|(i, j)| {
        let (x, z) = (-ROOM_X + i as f64 * size, BACK_Z + j as f64 * size);
        let (right, front) = ((x + size).min(ROOM_X), (z + size).min(FRONT_Z));
        bevelled_box(
            [x + GAP, -0.02, z + GAP],
            [right - GAP, 0.0, front - GAP],
            0.002,
        )
    })))
}

/// Sill and head of the window in the left wall, and its span along z.
const WINDOW: [f64; 4] = [1.0, 2.15, -0.9, 0.9];

fn walls(_: &Parameters) -> Mesh {
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

fn ceiling(_: &Parameters) -> Mesh {
    cuboid(
        [-ROOM_X - 0.25, HEIGHT, BACK_Z - 0.2],
        [ROOM_X + 0.2, HEIGHT + 0.2, FRONT_Z + 0.2],
    )
}

/// Bricks of glazed tile in running bond between worktop and wall cabinets.
fn wall_tiles(parameters: &Parameters) -> Mesh {
    let (width, height) = (0.15, 0.075);
    let mut pieces = Vec::new();
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
                    0.002,
                ));
            }
            x += width;
            column += 1;
        }
    }
    merged(pieces)
}

fn unit_x(i: usize) -> f64 {
    -ROOM_X + UNIT * i as f64
}

/// Which wall cabinets are open shelves instead: the two in the middle.
fn is_open(i: usize) -> bool {
    (3..5).contains(&i)
}

fn carcasses(_: &Parameters) -> Mesh {
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

fn fronts(_: &Parameters) -> Mesh {
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
fn handle(parameters: &Parameters, length: f64) -> Mesh {
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

fn handles(parameters: &Parameters) -> Mesh {
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

/// Where the sink is cut out of the worktop: x and z ranges.
const SINK: [[f64; 2]; 2] = [[-0.95, -0.42], [BACK_Z + 0.14, BACK_Z + 0.5]];

fn worktop(_: &Parameters) -> Mesh {
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

fn sink_and_tap(parameters: &Parameters) -> Mesh {
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
fn stove(parameters: &Parameters) -> Mesh {
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

/// Heights of the open boards between the wall cabinets.
const BOARDS: [f64; 3] = [1.44, 1.74, 2.04];
const SHELF_X: [f64; 2] = [-ROOM_X + UNIT * 3.0, -ROOM_X + UNIT * 5.0];

fn shelves(_: &Parameters) -> Mesh {
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

fn bottles(parameters: &Parameters) -> Mesh {
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

fn plates(parameters: &Parameters) -> Mesh {
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

fn cups(parameters: &Parameters) -> Mesh {
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

/// A towel over the oven's handle.
fn towel(parameters: &Parameters) -> Mesh {
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

/// The window's frame and sill.
fn window(_: &Parameters) -> Mesh {
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

const LAMP_AT: [f64; 3] = [0.15, 1.95, 0.35];

/// A pendant shade on its cord.
fn lamp(parameters: &Parameters) -> Mesh {
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

fn lamp_glow(parameters: &Parameters) -> Mesh {
    let [x, y, z] = LAMP_AT;
    moved(
        &super::kit::sphere(0.055, parameters.steps(28)),
        [x, y + 0.07, z],
    )
}

/// Two round stools with thin legs and a rung.
fn stools(parameters: &Parameters) -> Mesh {
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

const TABLE_TOP: f64 = 0.74;

/// A small table under the lamp.
fn table(parameters: &Parameters) -> Mesh {
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
