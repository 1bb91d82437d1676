//! Grass, bushes, flowers, trees and what grows in pots.

use super::garden::distance_to_path;
use super::{DOOR_X, FENCE_Z, LAWN};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Bush, bush, capsule, jitter, lathe, merged, moved, smooth_profile, sphere, tuft,
};

/// Leaves scale with the square of the detail, as facets do.
fn count(parameters: &Parameters, leaves: f64) -> usize {
    (leaves * parameters.detail * parameters.detail)
        .round()
        .max(8.0) as usize
}

/// Tufts on the lawn between house and fence, denser beside the path.
pub(super) fn grass(parameters: &Parameters) -> Mesh {
    let tufts = count(parameters, 2300.0) as u64;
    merged((0..tufts).filter_map(|i| {
        let random =
            |k: u64, range: [f64; 2]| jitter(parameters.seed, 1_000_000 + i * 4 + k, range);
        let x = 2.0 + 11.0 * random(0, [-1.0, 1.0]) * random(1, [0.0, 1.0]);
        let z = random(2, [4.3, 17.0]);
        let clear = distance_to_path(x, z) > 0.68;
        let tall = random(3, [0.05, 0.11]);
        clear.then(|| tuft(parameters.seed, i, [x, LAWN - 0.004, z], [7.0, tall]))
    }))
}

/// (x, z, radius, height) of the bushes along the wall, the fence and the sides of the garden.
const BUSHES: [[f64; 4]; 17] = [
    [-2.2, 4.0, 0.4, 0.75],
    [2.6, 4.05, 0.42, 0.6],
    [3.45, 3.95, 0.38, 0.45],
    [4.4, 4.0, 0.48, 0.8],
    [5.4, 3.95, 0.42, 0.5],
    [6.4, 4.05, 0.5, 0.95],
    [-4.4, 11.4, 0.9, 1.1],
    [-2.4, 11.7, 0.7, 0.8],
    [6.2, 11.6, 0.8, 0.9],
    [8.2, 11.2, 1.0, 1.3],
    [-6.3, 9.4, 1.1, 1.5],
    [-6.6, 6.4, 1.2, 1.7],
    [-6.4, 3.4, 1.1, 1.5],
    [10.2, 8.8, 1.2, 1.6],
    [10.4, 5.6, 1.2, 1.8],
    [10.0, 2.4, 1.1, 1.5],
    [-5.2, -0.2, 1.1, 1.6],
];

pub(super) fn bushes(parameters: &Parameters) -> Mesh {
    let lumps = BUSHES
        .into_iter()
        .enumerate()
        .map(|(i, [x, z, r, height])| {
            let near = z < 4.2 && x > -3.0 && x < 7.0;
            let area = r * (r + height);
            let (leaf, density) = if near { (0.06, 1900.0) } else { (0.15, 480.0) };
            Bush {
                centre: [x, LAWN + height * 0.5, z],
                radii: [r, height * 0.5, r * 0.9],
                leaves: count(parameters, area * density),
                leaf,
                key: 100 + i as u64,
            }
        });
    let potted = POTS.into_iter().enumerate().map(|(i, [x, y, z])| Bush {
        centre: [x, y + 0.5, z],
        radii: [0.24, 0.25, 0.24],
        leaves: count(parameters, 500.0),
        leaf: 0.055,
        key: 200 + i as u64,
    });
    let all = lumps.chain(potted);
    merged(all.map(|lump| bush(parameters.seed, lump)))
}

/// Heads of flowers over the bed along the wall and beside the gate.
pub(super) fn flowers(parameters: &Parameters) -> Mesh {
    let head = sphere(1.0, parameters.steps(8));
    let flat = crate::scene::shapes::kit::placed(
        &head,
        glam::DMat4::from_scale(glam::DVec3::new(1.0, 0.55, 1.0)),
    );
    merged((0..150u64).map(|i| {
        let random = |k: u64, range: [f64; 2]| jitter(parameters.seed, 90_000 + i * 8 + k, range);
        let [x, z, r, height] = BUSHES[1 + (i % 4) as usize];
        let (dx, dz) = (
            random(0, [-0.9, 0.9]) * r,
            random(1, [-0.3, 0.95]) * r * 0.9,
        );
        let bulge = (1.0 - (dx / r).powi(2) - (dz / r).powi(2)).max(0.05).sqrt();
        let y = LAWN + height * (0.52 + 0.5 * bulge);
        let size = random(2, [0.022, 0.036]);
        crate::scene::shapes::kit::set_at(&flat, [x + dx, y, z + dz], 0.0, size)
    }))
}

/// (x, z, height of the trunk, radius of the crown).
const TREES: [[f64; 4]; 7] = [
    [-4.4, 7.6, 2.6, 1.9],
    [8.6, 7.0, 2.4, 1.7],
    [-4.0, -6.5, 3.4, 2.6],
    [1.5, -8.5, 4.4, 3.0],
    [7.0, -7.0, 3.8, 2.7],
    [13.0, -3.0, 3.6, 2.8],
    [-11.0, 2.0, 3.6, 2.9],
];

pub(super) fn trunks(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(14);
    merged(
        TREES
            .into_iter()
            .enumerate()
            .map(|(i, [x, z, height, crown])| {
                let thick = 0.07 * crown;
                let lean = jitter(parameters.seed, 80_000 + i as u64, [-0.25, 0.25]);
                let fork = [x + lean, LAWN + height, z + lean * 0.5];
                let limbs = (0..6u64).map(|k| {
                    let turn = k as f64 * 1.05 + lean * 5.0;
                    let reach = crown * 0.62;
                    let tip = [
                        fork[0] + reach * turn.cos(),
                        fork[1] + crown * (0.45 + 0.25 * (k % 2) as f64),
                        fork[2] + reach * turn.sin(),
                    ];
                    let from = [fork[0], fork[1] - 0.12 * k as f64, fork[2]];
                    capsule(from, tip, [thick * 0.5, thick * 0.14], round)
                });
                let trunk = capsule([x, LAWN - 0.2, z], fork, [thick, thick * 0.7], round);
                merged([trunk].into_iter().chain(limbs))
            }),
    )
}

pub(super) fn crowns(parameters: &Parameters) -> Mesh {
    let mut pieces = Vec::new();
    for (i, [x, z, height, crown]) in TREES.into_iter().enumerate() {
        let near = z > 0.0 && x > -8.0;
        for k in 0..7u64 {
            let turn = k as f64 * 1.05;
            let out = if k == 6 { 0.0 } else { crown * 0.55 };
            let up = if k == 6 {
                crown * 0.85
            } else {
                crown * (0.35 + 0.2 * (k % 2) as f64)
            };
            let r = crown * 0.56;
            pieces.push(bush(
                parameters.seed,
                Bush {
                    centre: [
                        x + out * turn.cos(),
                        LAWN + height + up,
                        z + out * turn.sin(),
                    ],
                    radii: [r, r * 0.8, r],
                    leaves: count(parameters, if near { 900.0 } else { 380.0 }),
                    leaf: if near { 0.17 } else { 0.34 },
                    key: 1000 + 16 * i as u64 + k,
                },
            ));
        }
    }
    merged(pieces)
}

/// Where pots stand: beside the door and the gate.
const POTS: [[f64; 3]; 3] = [
    [DOOR_X[0] - 0.2, LAWN, 4.35],
    [DOOR_X[1] + 0.25, LAWN, 4.3],
    [1.55, LAWN, FENCE_Z - 0.6],
];

/// Clay pots; their plants are among the [`bushes`].
pub(super) fn pots(parameters: &Parameters) -> Mesh {
    let pot = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.13, 0.0],
                [0.14, 0.02],
                [0.19, 0.26],
                [0.21, 0.27],
                [0.21, 0.33],
                [0.18, 0.33],
                [0.17, 0.28],
                [0.0, 0.27],
            ],
            parameters.steps(3),
        ),
        parameters.steps(36),
    );
    merged(POTS.map(|at| moved(&pot, at)))
}
