//! What stands and hangs about the worktop: a polished kettle, glasses, bowls, lemons, copper pans.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::BACK_Z;
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    capsule, cuboid, curve, jitter, lathe, merged, moved, placed, set_at, smooth_profile, sphere,
    torus, tube,
};

/// Heights of the worktop and of the table.
const TOP: f64 = 0.9;
const TABLE: f64 = 0.74;

fn turned(parameters: &Parameters, profile: &[[f64; 2]], segments: usize) -> Mesh {
    lathe(
        &smooth_profile(profile, parameters.steps(3)),
        parameters.steps(segments),
    )
}

/// A kettle of polished steel.
pub(super) fn kettle(parameters: &Parameters) -> Mesh {
    let body = turned(
        parameters,
        &[
            [0.0, 0.0],
            [0.085, 0.0],
            [0.1, 0.012],
            [0.1, 0.06],
            [0.075, 0.125],
            [0.045, 0.15],
            [0.042, 0.156],
            [0.012, 0.165],
            [0.014, 0.185],
            [0.0, 0.19],
        ],
        64,
    );
    let spout = [
        [0.08, 0.05, 0.0],
        [0.13, 0.075, 0.0],
        [0.145, 0.12, 0.0],
        [0.17, 0.14, 0.0],
    ];
    let grip = [
        [-0.07, 0.12, 0.0],
        [-0.07, 0.21, 0.0],
        [0.0, 0.25, 0.0],
        [0.07, 0.21, 0.0],
        [0.07, 0.12, 0.0],
    ];
    let round = parameters.steps(18);
    let steps = parameters.steps(9);
    let whole = merged([
        body,
        tube(&curve(&spout, steps), 0.015, round),
        tube(&curve(&grip, steps), 0.007, round),
    ]);
    set_at(&whole, [-0.3, TOP, BACK_Z + 0.36], 205.0, 1.0)
}

/// Tumblers and a jug of glass, on the worktop and the table.
pub(super) fn glasses(parameters: &Parameters) -> Mesh {
    let tumbler = turned(
        parameters,
        &[
            [0.0, 0.0],
            [0.03, 0.0],
            [0.032, 0.004],
            [0.038, 0.1],
            [0.037, 0.102],
            [0.0355, 0.1],
            [0.029, 0.014],
            [0.0, 0.012],
        ],
        44,
    );
    let jug = turned(
        parameters,
        &[
            [0.0, 0.0],
            [0.05, 0.0],
            [0.055, 0.006],
            [0.072, 0.07],
            [0.06, 0.15],
            [0.045, 0.19],
            [0.052, 0.225],
            [0.05, 0.227],
            [0.0425, 0.19],
            [0.057, 0.15],
            [0.069, 0.07],
            [0.05, 0.012],
            [0.0, 0.01],
        ],
        52,
    );
    let spots = [
        [0.17, TOP, BACK_Z + 0.44],
        [0.26, TOP, BACK_Z + 0.36],
        [1.52, TOP, BACK_Z + 0.3],
        [-0.45, TABLE, 0.25],
        [0.12, TABLE, 0.68],
    ];
    let tumblers = spots.map(|at| moved(&tumbler, at));
    let jugs = [moved(&jug, [-0.72, TABLE, 0.5])];
    merged(tumblers.into_iter().chain(jugs))
}

const FRUIT_BOWL: [f64; 3] = [0.0, TOP, BACK_Z + 0.26];
const TABLE_BOWL: [f64; 3] = [-0.5, TABLE, 0.62];

pub(super) fn bowls(parameters: &Parameters) -> Mesh {
    let bowl = turned(
        parameters,
        &[
            [0.0, 0.0],
            [0.05, 0.0],
            [0.052, 0.012],
            [0.1, 0.04],
            [0.13, 0.085],
            [0.132, 0.09],
            [0.127, 0.09],
            [0.095, 0.046],
            [0.0, 0.02],
        ],
        60,
    );
    let nested = (0..3).map(|k| {
        let scale = 0.85 - 0.12 * f64::from(k);
        let at = [1.72, TOP + 0.021 * f64::from(k), BACK_Z + 0.3];
        set_at(&bowl, at, 0.0, scale)
    });
    merged(
        [
            moved(&bowl, FRUIT_BOWL),
            set_at(&bowl, TABLE_BOWL, 0.0, 0.9),
        ]
        .into_iter()
        .chain(nested),
    )
}

/// Lemons in both bowls and one beside.
pub(super) fn lemons(parameters: &Parameters) -> Mesh {
    let lemon = turned(
        parameters,
        &[
            [0.0, -0.046],
            [0.008, -0.041],
            [0.02, -0.032],
            [0.031, 0.0],
            [0.02, 0.032],
            [0.008, 0.04],
            [0.0, 0.043],
        ],
        36,
    );
    let pile = [
        [0.05, 0.058, 0.0],
        [-0.03, 0.056, 0.045],
        [-0.035, 0.056, -0.045],
        [0.0, 0.1, 0.005],
    ];
    let lying = |at: DVec3, key: u64| {
        let turn = jitter(parameters.seed, 97_000 + key, [0.0, 2.0 * PI]);
        let tilt = DMat4::from_rotation_y(turn) * DMat4::from_rotation_z(PI * 0.5 - 0.15);
        placed(&lemon, DMat4::from_translation(at) * tilt)
    };
    let bowls = [FRUIT_BOWL, TABLE_BOWL].map(DVec3::from).into_iter();
    let heaps = bowls.enumerate().flat_map(|(b, middle)| {
        pile.into_iter()
            .enumerate()
            .map(move |(k, at)| (middle + DVec3::from(at), (b * 8 + k) as u64))
    });
    let loose = (DVec3::new(0.2, TOP + 0.0318, BACK_Z + 0.24), 20);
    merged(heaps.chain([loose]).map(|(at, key)| lying(at, key)))
}

/// Strips of light under the wall cabinets and the lowest shelf.
pub(super) fn strip_lights(_: &Parameters) -> Mesh {
    let z = [BACK_Z + 0.272, BACK_Z + 0.298];
    let strip = |x: [f64; 2]| cuboid([x[0], 1.421, z[0]], [x[1], 1.4365, z[1]]);
    merged([[-2.2, -0.66], [-0.53, 0.49], [0.62, 2.2]].map(strip))
}

/// Pans of copper on a rail under the wall cabinets, right of the shelves.
pub(super) fn copper(parameters: &Parameters) -> Mesh {
    let pan = turned(
        parameters,
        &[
            [0.0, 0.0],
            [0.07, 0.0],
            [0.08, 0.006],
            [0.085, 0.05],
            [0.088, 0.053],
            [0.081, 0.051],
            [0.076, 0.008],
            [0.0, 0.006],
        ],
        52,
    );
    let round = parameters.steps(14);
    let grip = capsule([0.08, 0.045, 0.0], [0.22, 0.05, 0.0], [0.007, 0.009], round);
    let eye = moved(&torus(0.014, 0.003, [round * 2, 8]), [0.235, 0.05, 0.0]);
    let pan = merged([pan, grip, eye]);
    let z = BACK_Z + 0.05;
    let hung = (0..3).map(|k| {
        let scale = 0.95 - 0.14 * f64::from(k);
        let x = 1.32 + 0.26 * f64::from(k);
        let hang = DMat4::from_translation(DVec3::new(x, 1.375 - 0.235 * scale, z))
            * DMat4::from_rotation_x(PI * 0.5)
            * DMat4::from_rotation_y(PI * 0.5)
            * DMat4::from_scale(DVec3::splat(scale));
        placed(&pan, hang)
    });
    let rail = capsule([1.2, 1.38, z], [1.95, 1.38, z], [0.006, 0.006], round);
    let knobs = [1.2, 1.95].map(|x| moved(&sphere(0.012, round), [x, 1.38, z]));
    merged(hung.chain([rail]).chain(knobs))
}
