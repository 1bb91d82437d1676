//! Round lamps: three small ones in the aisles, the first of which runs on a rail, and a large one.

use super::{AISLE, COURT, GALLERY, SPRING, TOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{capsule, cylinder, lathe, merged, moved, sphere};

/// Middles of the aisles.
const AISLE_X: f64 = COURT[0] + AISLE * 0.5;
const AISLE_Z: f64 = COURT[1] + AISLE * 0.5;

/// Where the small lamps hang (the first one at the start of its way) and their radius.
const SMALL: [[f64; 3]; 3] = [
    [-AISLE_X, 2.25, 6.0],
    [AISLE_X, 2.25, -16.0 / 3.0],
    [8.0 / 3.0, 2.25, -AISLE_Z],
];
const SMALL_RADIUS: f64 = 0.15;

/// Where the large lamp hangs.
const GREAT: [f64; 3] = [0.0, 6.9, 0.0];
const GREAT_RADIUS: f64 = 0.9;

/// Apex of the vaults.
const APEX: f64 = SPRING + 4.0 / 3.0;

pub(super) fn small(parameters: &Parameters, lamp: usize) -> Mesh {
    moved(&sphere(SMALL_RADIUS, parameters.steps(28)), SMALL[lamp])
}

pub(super) fn great(parameters: &Parameters) -> Mesh {
    moved(&sphere(GREAT_RADIUS, parameters.steps(40)), GREAT)
}

/// The cap and rod of a small lamp, up to `top`.
fn holder(parameters: &Parameters, [x, y, z]: [f64; 3], top: f64) -> Mesh {
    let cap = lathe(
        &[
            [0.0, 0.0],
            [0.075, 0.0],
            [0.07, 0.03],
            [0.03, 0.06],
            [0.0, 0.065],
        ],
        parameters.steps(20),
    );
    let foot = y + SMALL_RADIUS - 0.01;
    merged([
        moved(&cap, [x, foot, z]),
        capsule(
            [x, foot + 0.05, z],
            [x, top, z],
            [0.009, 0.009],
            parameters.steps(10),
        ),
    ])
}

/// The holder that moves with the first lamp.
pub(super) fn moving_holder(parameters: &Parameters) -> Mesh {
    let [x, _, z] = SMALL[0];
    let slide = moved(&cylinder(0.03, 0.06, 0.006, 16), [x, APEX - 0.14, z]);
    merged([holder(parameters, SMALL[0], APEX - 0.12), slide])
}

/// The holders of the other two, and the wires of the large lamp.
pub(super) fn holders(parameters: &Parameters) -> Mesh {
    let small = [SMALL[1], SMALL[2]].map(|at| holder(parameters, at, APEX + 0.05));
    let [x, y, z] = GREAT;
    let wires = super::CORNERS.map(|[sx, sz]| {
        let from = [x + 0.42 * sx, y + 0.8, z + 0.42 * sz];
        let to = [sx * (COURT[0] - 0.1), TOP + 0.05, sz * super::PITCH * 0.5];
        capsule(from, to, [0.012, 0.012], parameters.steps(8))
    });
    let cap = cylinder(0.5, 0.06, 0.02, parameters.steps(36));
    let cap = moved(&cap, [x, y + GREAT_RADIUS * 0.86, z]);
    merged(small.into_iter().chain(wires).chain([cap]))
}

/// The rail of the first lamp along the vaults of the left aisle.
pub(super) fn rail(parameters: &Parameters) -> Mesh {
    let (x, y) = (-AISLE_X, APEX - 0.07);
    let z = COURT[1] + 0.5;
    let bar = capsule([x, y, -z], [x, y, z], [0.016, 0.016], parameters.steps(10));
    let hangers = (0..7).map(|i| {
        let at = super::PITCH * (f64::from(i) - 3.0);
        capsule([x, y, at], [x, GALLERY - 0.2, at], [0.012, 0.012], 8)
    });
    merged([bar].into_iter().chain(hangers))
}
