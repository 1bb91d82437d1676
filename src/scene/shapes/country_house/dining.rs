//! Table, chairs, rug and mirror.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::ROOM_X;
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cylinder, jitter, lathe, merged, moved, placed, set_at, sheet,
    smooth_profile, torus,
};

/// The table's middle and half extents; what the kitchen sets out stands on it, 0.74 m high.
const MIDDLE: [f64; 2] = [-0.15, 0.42];
const HALF: [f64; 2] = [0.95, 0.45];
const TOP: f64 = 0.74;

/// A table of five boards on turned legs.
pub(super) fn table(parameters: &Parameters) -> Mesh {
    let board = |i: usize| {
        let width = HALF[1] * 0.4;
        let z = -HALF[1] + width * i as f64;
        let low = [-HALF[0], TOP - 0.035, z + 0.0008];
        bevelled_box(low, [HALF[0], TOP, z + width - 0.0008], 0.002)
    };
    let leg = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.025, 0.0],
                [0.035, 0.06],
                [0.028, 0.1],
                [0.045, 0.3],
                [0.03, 0.52],
                [0.045, 0.56],
                [0.045, 0.7],
                [0.0, 0.7],
            ],
            parameters.steps(4),
        ),
        parameters.steps(28),
    );
    let legs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, z]| moved(&leg, [x * (HALF[0] - 0.1), 0.001, z * (HALF[1] - 0.09)]));
    let apron = bevelled_box(
        [-HALF[0] + 0.08, TOP - 0.13, -HALF[1] + 0.07],
        [HALF[0] - 0.08, TOP - 0.036, HALF[1] - 0.07],
        0.004,
    );
    let whole = merged((0..5).map(board).chain(legs).chain([apron]));
    moved(&whole, [MIDDLE[0], 0.0, MIDDLE[1]])
}

/// A chair with a back of spindles; it faces +z.
fn chair(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(12);
    let rod = |from: [f64; 3], to: [f64; 3], r: f64| capsule(from, to, [r, r * 0.85], round);
    let seat = bevelled_box([-0.21, 0.44, -0.2], [0.21, 0.47, 0.21], 0.012);
    let mut pieces = vec![seat];
    for x in [-1.0, 1.0] {
        pieces.push(rod([0.19 * x, 0.017, 0.2], [0.16 * x, 0.45, 0.16], 0.016));
        pieces.push(rod([0.2 * x, 0.017, -0.22], [0.16 * x, 0.45, -0.16], 0.016));
        pieces.push(rod([0.19 * x, 0.46, -0.17], [0.2 * x, 0.95, -0.26], 0.015));
        pieces.push(rod([0.18 * x, 0.2, 0.18], [0.18 * x, 0.2, -0.19], 0.009));
    }
    for k in -2..=2 {
        let x = 0.065 * f64::from(k);
        pieces.push(rod([x, 0.46, -0.175], [x * 1.1, 0.9, -0.25], 0.007));
    }
    let crest = sheet([parameters.steps(14), 4], 0.02, |u, v| {
        let x = (u - 0.5) * 0.44;
        DVec3::new(x, 0.88 + 0.1 * v - 0.6 * x * x, -0.275 + 1.2 * x * x)
    });
    pieces.push(crest);
    pieces.push(rod([-0.18, 0.2, 0.0], [0.18, 0.2, 0.0], 0.009));
    merged(pieces)
}

pub(super) fn chairs(parameters: &Parameters) -> Mesh {
    let chair = chair(parameters);
    let [x, z] = MIDDLE;
    let reach = HALF[1] + 0.12;
    merged([
        set_at(&chair, [x - 0.42, 0.0, z - reach - 0.05], 4.0, 1.0),
        set_at(&chair, [x + 0.4, 0.0, z - reach], -8.0, 1.0),
        set_at(&chair, [x - 0.38, 0.0, z + reach], 176.0, 1.0),
        set_at(&chair, [x + 0.5, 0.0, z + reach + 0.18], 215.0, 1.0),
    ])
}

/// A woven rug under the table.
pub(super) fn rug(parameters: &Parameters) -> Mesh {
    let n = parameters.steps(40);
    let rug = sheet([n, n], 0.004, |u, v| {
        let (x, z) = ((u - 0.5) * 2.9, (0.5 - v) * 2.1);
        let weave = 0.0012 * ((x * 90.0).sin() * (z * 90.0).cos());
        let key = (u * 40.0) as u64 * 64 + (v * 40.0) as u64;
        let tread = jitter(parameters.seed, 95_000 + key, [0.0, 0.0006]);
        DVec3::new(x, 0.0068 + weave + tread, z)
    });
    moved(&rug, [MIDDLE[0], 0.0, MIDDLE[1]])
}

/// A round mirror on the right wall.
fn mirror_place() -> DMat4 {
    DMat4::from_translation(DVec3::new(ROOM_X, 1.55, 1.1)) * DMat4::from_rotation_z(PI * 0.5)
}

pub(super) fn mirror(parameters: &Parameters) -> Mesh {
    let glass = cylinder(0.4, 0.012, 0.0, parameters.steps(64));
    placed(&glass, mirror_place())
}

pub(super) fn mirror_frame(parameters: &Parameters) -> Mesh {
    let ring = torus(0.415, 0.024, [parameters.steps(72), parameters.steps(14)]);
    let lifted = moved(&ring, [0.0, 0.012, 0.0]);
    placed(&lifted, mirror_place())
}
