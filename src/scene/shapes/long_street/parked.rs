//! Scooters, vans, crates of fruit and plants along the kerbs.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::{KERB_X, PAVEMENT};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Bush, bevelled_box, bush, capsule, cuboid, curve, cylinder, jitter, lathe, merged, moved,
    placed, rounded_box, set_at, smooth_profile, sphere, torus, tube,
};

/// (x, z, turn in degrees) of the scooters, in groups along both kerbs.
fn scooters(parameters: &Parameters) -> Vec<[f64; 3]> {
    let groups = [
        [1.0, -1.0, 3.0],
        [-1.0, -9.5, 4.0],
        [1.0, -17.0, 4.0],
        [-1.0, -38.0, 3.0],
        [1.0, -62.0, 3.0],
        [-1.0, -95.0, 3.0],
    ];
    let mut all = Vec::new();
    for [side, z, count] in groups {
        for i in 0..count as u64 {
            let key = 800_000 + all.len() as u64;
            let turn = jitter(parameters.seed, key, [-9.0, 9.0]);
            let at = z - 0.85 * i as f64;
            all.push([side * (KERB_X - 0.75), at, 90.0 - 25.0 * side + turn]);
        }
    }
    all
}

fn at_scooters(parameters: &Parameters, mesh: &Mesh) -> Mesh {
    let places = scooters(parameters).into_iter();
    merged(places.map(|[x, z, turn_deg]| set_at(mesh, [x, -0.02, z], turn_deg, 1.0)))
}

/// Wheels stand at x = -0.6 and 0.62; the front is towards +x.
const WHEELS: [f64; 2] = [-0.6, 0.62];
const WHEEL: f64 = 0.2;

/// Body panels, mudguards and leg shield.
pub(super) fn scooter_shells(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(2);
    let block = |at: [f64; 3], half: [f64; 3], lean_rad: f64| {
        let turned = placed(
            &rounded_box(half, 0.06, steps),
            DMat4::from_rotation_z(lean_rad),
        );
        moved(&turned, at)
    };
    let whole = merged([
        block([-0.48, 0.52, 0.0], [0.36, 0.16, 0.13], -0.06),
        block([0.42, 0.6, 0.0], [0.065, 0.34, 0.19], 0.25),
        block([-0.02, 0.27, 0.0], [0.36, 0.061, 0.15], 0.0),
        block([0.62, 0.37, 0.0], [0.19, 0.07, 0.08], 0.1),
        block([0.36, 0.96, 0.0], [0.1, 0.08, 0.1], 0.2),
    ]);
    at_scooters(parameters, &whole)
}

/// Fork, handlebar, mirrors, exhaust and lamp.
pub(super) fn scooter_metal(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(10);
    let rod = |a: [f64; 3], b: [f64; 3], r: f64| capsule(a, b, [r, r], round);
    let mut pieces = vec![
        rod([0.36, 1.0, 0.0], [0.6, 0.22, 0.0], 0.03),
        rod([-0.6, 0.2, 0.0], [-0.4, 0.4, 0.0], 0.06),
        rod([-0.85, 0.22, 0.12], [-0.35, 0.2, 0.12], 0.045),
        moved(&sphere(0.075, parameters.steps(16)), [0.43, 0.98, 0.0]),
    ];
    for z in [-1.0, 1.0] {
        let bar = curve(
            &[
                [0.34, 1.02, 0.0],
                [0.3, 1.06, 0.2 * z],
                [0.2, 1.05, 0.36 * z],
            ],
            4,
        );
        pieces.push(tube(&bar, 0.014, round));
        pieces.push(rod([0.28, 1.06, 0.24 * z], [0.3, 1.24, 0.3 * z], 0.006));
        let glass = placed(
            &cylinder(0.055, 0.015, 0.004, round),
            DMat4::from_rotation_z(PI * 0.5),
        );
        pieces.push(moved(&glass, [0.31, 1.28, 0.31 * z]));
    }
    at_scooters(parameters, &merged(pieces))
}

/// Tyres of scooters and vans, seats and grips.
pub(super) fn tyres(parameters: &Parameters) -> Mesh {
    let ring = |major: f64, minor: f64| {
        let ring = torus(major, minor, [parameters.steps(26), parameters.steps(8)]);
        placed(&ring, DMat4::from_rotation_x(PI * 0.5))
    };
    let hub = |radius: f64, half: f64| {
        let disc = moved(&cylinder(radius, 2.0 * half, 0.01, 16), [0.0, -half, 0.0]);
        placed(&disc, DMat4::from_rotation_x(PI * 0.5))
    };
    let wheel = merged([ring(WHEEL - 0.05, 0.05), hub(0.11, 0.03)]);
    let seat = rounded_box([0.36, 0.05, 0.13], 0.045, parameters.steps(3));
    let scooter = merged(
        WHEELS
            .map(|x| moved(&wheel, [x, WHEEL, 0.0]))
            .into_iter()
            .chain([moved(&seat, [-0.44, 0.71, 0.0])]),
    );
    let van_wheel = merged([ring(0.26, 0.08), hub(0.2, 0.06)]);
    let vans = VANS.into_iter().flat_map(|[x, z]| {
        let corners = [[-0.78, -1.35], [0.78, -1.35], [0.78, 1.3], [-0.78, 1.3]];
        let van_wheel = van_wheel.clone();
        corners.map(move |[dx, dz]| set_at(&van_wheel, [x + dx, 0.33, z + dz], 90.0, 1.0))
    });
    merged([at_scooters(parameters, &scooter)].into_iter().chain(vans))
}

/// (x, z) of delivery vans.
const VANS: [[f64; 2]; 5] = [
    [-2.55, -24.0],
    [2.55, -46.0],
    [-2.55, -70.0],
    [2.55, -104.0],
    [-2.55, -141.0],
];

pub(super) fn vans(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(4);
    let van = merged([
        moved(
            &rounded_box([0.85, 0.78, 1.75], 0.14, steps),
            [0.0, 1.15, -0.3],
        ),
        moved(
            &rounded_box([0.84, 0.42, 0.5], 0.14, steps),
            [0.0, 0.8, 1.6],
        ),
        bevelled_box([-0.8, 0.3, -2.1], [0.8, 0.5, 2.14], 0.03),
    ]);
    merged(VANS.map(|[x, z]| moved(&van, [x, 0.0, z])))
}

/// Windscreens, side windows and lamps.
pub(super) fn van_glass(parameters: &Parameters) -> Mesh {
    let lamp = placed(
        &cylinder(0.11, 0.05, 0.01, parameters.steps(18)),
        DMat4::from_rotation_x(PI * 0.5),
    );
    let glass = merged([
        bevelled_box([-0.68, 1.25, 1.4], [0.68, 1.76, 1.462], 0.02),
        bevelled_box([-0.861, 1.25, 0.5], [0.861, 1.7, 1.2], 0.02),
        bevelled_box([-0.6, 1.25, -2.06], [0.6, 1.7, -2.0], 0.02),
        moved(&lamp, [-0.58, 0.85, 2.07]),
        moved(&lamp, [0.58, 0.85, 2.07]),
    ]);
    merged(VANS.map(|[x, z]| moved(&glass, [x, 0.0, z])))
}

/// (side, z) of the stalls on the pavement.
const STALLS: [[f64; 2]; 9] = [
    [-1.0, -3.2],
    [1.0, -8.5],
    [-1.0, -17.5],
    [1.0, -29.0],
    [-1.0, -44.0],
    [1.0, -71.0],
    [-1.0, -82.0],
    [1.0, -118.0],
    [-1.0, -150.0],
];

/// Corners of the crates of a stall: two steps of three.
fn crate_corners() -> impl Iterator<Item = [f64; 3]> {
    (0..6).map(|i| {
        let (step, place) = (f64::from(i / 3), f64::from(i % 3));
        [
            -0.95 + 0.65 * place,
            PAVEMENT + 0.35 + 0.22 * step,
            0.32 - 0.48 * step,
        ]
    })
}

fn at_stalls(mesh: &Mesh) -> Mesh {
    merged(STALLS.map(|[side, z]| set_at(mesh, [side * (KERB_X + 1.1), 0.0, z], -90.0 * side, 1.0)))
}

/// Slatted crates on trestles.
pub(super) fn crates(_: &Parameters) -> Mesh {
    let slatted = crate_corners().map(|[x, y, z]| {
        let board = |low: [f64; 3], high: [f64; 3]| {
            cuboid(
                [x + low[0], y + low[1], z + low[2]],
                [x + high[0], y + high[1], z + high[2]],
            )
        };
        let sides = [0.03, 0.12].into_iter().flat_map(|h| {
            [
                board([0.0, h, 0.43], [0.6, h + 0.07, 0.445]),
                board([0.0, h, 0.0], [0.6, h + 0.07, 0.015]),
                board([0.0, h, 0.016], [0.015, h + 0.07, 0.429]),
                board([0.585, h, 0.016], [0.6, h + 0.07, 0.429]),
            ]
        });
        let floor = board([0.001, 0.0, 0.001], [0.599, 0.02, 0.444]);
        let posts = [0.02, 0.55]
            .map(|dx| board([dx, -0.02 - y + PAVEMENT, 0.2], [dx + 0.03, -0.001, 0.24]));
        merged(sides.chain([floor]).chain(posts))
    });
    at_stalls(&merged(slatted))
}

/// A pole with an arm over every stall, and the cap of its lamp.
pub(super) fn stall_poles(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(10);
    let rod = |a: [f64; 3], b: [f64; 3], r: f64| capsule(a, b, [r, r], round);
    let [x, y, z] = STALL_LAMP;
    at_stalls(&merged([
        rod([-1.05, 0.0, -0.25], [-1.05, y + 0.3, -0.25], 0.022),
        rod([-1.05, y + 0.3, -0.25], [x, y + 0.3, z], 0.014),
        rod([x, y + 0.3, z], [x, y + 0.06, z], 0.006),
        moved(&cylinder(0.05, 0.06, 0.01, round), [x, y + 0.05, z]),
    ]))
}

/// Bulbs over the stalls.
pub(super) fn stall_lamps(parameters: &Parameters) -> Mesh {
    at_stalls(&moved(&sphere(0.065, parameters.steps(14)), STALL_LAMP))
}

/// Where the bulb hangs in the frame of a stall.
const STALL_LAMP: [f64; 3] = [0.0, 2.1, 0.5];

/// Fruit heaped in the crates.
pub(super) fn fruit(parameters: &Parameters) -> Mesh {
    let ball = sphere(0.045, parameters.steps(7));
    let heaps = crate_corners().enumerate().flat_map(|(c, [x, y, z])| {
        let ball = ball.clone();
        (0..24u64).map(move |i| {
            let random = |k: u64, range| {
                jitter(parameters.seed, 900_000 + c as u64 * 256 + i * 4 + k, range)
            };
            let (column, row) = ((i % 6) as f64, (i / 6) as f64);
            moved(
                &ball,
                [
                    x + 0.075 + 0.09 * column + random(0, [-0.012, 0.012]),
                    y + 0.12 + random(1, [0.0, 0.05]),
                    z + 0.075 + 0.095 * row + random(2, [-0.012, 0.012]),
                ],
            )
        })
    });
    at_stalls(&merged(heaps))
}

/// Bushes and pots beside the doors.
pub(super) fn plants(parameters: &Parameters) -> Mesh {
    let pot = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.14, 0.0],
                [0.2, 0.3],
                [0.17, 0.3],
                [0.0, 0.26],
            ],
            2,
        ),
        parameters.steps(18),
    );
    let leaves = (420.0 * parameters.detail * parameters.detail) as usize;
    merged((0..26u64).map(|i| {
        let random = |k: u64, range: [f64; 2]| jitter(parameters.seed, 950_000 + i * 4 + k, range);
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        let at = DVec3::new(
            side * (KERB_X + 2.1),
            PAVEMENT,
            1.0 - 5.7 * i as f64 + random(0, [-1.0, 1.0]),
        );
        let tall = random(1, [0.35, 0.6]);
        let green = bush(
            parameters.seed,
            Bush {
                centre: [at.x, at.y + 0.25 + tall, at.z],
                radii: [0.26, tall, 0.26],
                leaves: leaves.max(8),
                leaf: 0.09,
                key: 3000 + i,
            },
        );
        merged([moved(&pot, at.to_array()), green])
    }))
}
