//! Single objects on a board, a hand or two high: the bodies of the table-top test scenes.

use std::f64::consts::TAU;

use glam::DVec3;

use super::figures;
use super::kit::{
    circle, curve, jitter, lathe, merged, moved, placed, rounded_box, set_at, smooth_profile,
    sphere, sweep, tube,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

/// Every part but the board stands on y = 0 about the origin.
pub const PARTS: &[(&str, PartFunction)] = &[
    ("board", board),
    ("puzzle-core", puzzle_core),
    ("puzzle-front", |p| puzzle_faces(p, 0)),
    ("puzzle-side", |p| puzzle_faces(p, 1)),
    ("puzzle-top", |p| puzzle_faces(p, 2)),
    ("vase", vase),
    ("twigs", twigs),
    ("bottle", bottle),
    ("bowl", bowl),
    ("ball", ball),
    ("knot", knot),
    ("blocks", blocks),
    ("seated", |p| small(&figures::seated(p.cell(0.024)), 0.16)),
    ("standing", |p| {
        small(&figures::standing(p.cell(0.024)), 0.2)
    }),
    ("elephant", |p| {
        small(&figures::elephant(p.cell(0.024)), 0.16)
    }),
];

fn small(figure: &Mesh, scale: f64) -> Mesh {
    set_at(figure, [0.0, -0.0006, 0.0], 0.0, scale)
}

/// A round board whose upper side is y = 0.
fn board(parameters: &Parameters) -> Mesh {
    let edge = smooth_profile(
        &[
            [1.06, -0.04],
            [1.09, -0.034],
            [1.1, -0.02],
            [1.09, -0.006],
            [1.06, 0.0],
        ],
        4,
    );
    let profile: Vec<[f64; 2]> = [[0.0, -0.04]]
        .into_iter()
        .chain(edge)
        .chain([[0.0, 0.0]])
        .collect();
    lathe(&profile, parameters.steps(160))
}

/// Side of the puzzle's 27 cubes.
const CUBE: f64 = 0.044;

fn puzzle_core(parameters: &Parameters) -> Mesh {
    let cube = rounded_box([CUBE * 0.49; 3], 0.004, parameters.steps(3));
    let places = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|k| (f64::from(k) - 1.0) * CUBE));
    let whole = merged(places.map(|[x, y, z]| moved(&cube, [x, y, z])));
    moved(&whole, [0.0, 1.5 * CUBE, 0.0])
}

/// Plates on two opposite sides: 0 the front and back, 1 the sides, 2 top and bottom.
fn puzzle_faces(parameters: &Parameters, axis: usize) -> Mesh {
    let thin = 0.0012;
    let mut half = [CUBE * 0.4; 3];
    let normal = [2, 0, 1][axis];
    half[normal] = thin;
    let plate = rounded_box(half, thin * 0.9, parameters.steps(2));
    let plates = (0..18).map(|i| {
        let (a, b, side) = (i % 3, i / 3 % 3, i / 9);
        let mut at = [0.0; 3];
        at[(normal + 1) % 3] = (f64::from(a) - 1.0) * CUBE;
        at[(normal + 2) % 3] = (f64::from(b) - 1.0) * CUBE;
        at[normal] = (f64::from(side) * 2.0 - 1.0) * CUBE * 1.49;
        at[1] += 1.5 * CUBE;
        moved(&plate, at)
    });
    // The plates under the puzzle would lie in the board.
    let above = plates.filter(|plate| plate.positions.iter().all(|p| p.y > 0.0));
    merged(above)
}

fn vase(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.04, 0.0],
            [0.045, 0.006],
            [0.075, 0.07],
            [0.078, 0.12],
            [0.05, 0.19],
            [0.026, 0.235],
            [0.03, 0.265],
            [0.036, 0.272],
            [0.031, 0.272],
            [0.022, 0.25],
            [0.022, 0.23],
            [0.044, 0.19],
            [0.07, 0.12],
            [0.0, 0.02],
        ],
        parameters.steps(6),
    );
    lathe(&profile, parameters.steps(72))
}

/// Thin branches that stand in the vase.
fn twigs(parameters: &Parameters) -> Mesh {
    let twig = |index: u64| {
        let at = |key: u64, range| jitter(parameters.seed, 16 * index + key, range);
        let turn = TAU * (index as f64 + at(0, [0.0, 0.6])) / 7.0;
        let lean = at(1, [0.06, 0.17]);
        let (x, z) = (turn.cos(), turn.sin());
        let height = at(2, [0.42, 0.56]);
        let bend = at(3, [-0.03, 0.03]);
        let path = curve(
            &[
                [0.004 * x, 0.2, 0.004 * z],
                [0.012 * x, 0.28, 0.012 * z],
                [lean * 0.5 * x + bend, 0.37, lean * 0.5 * z - bend],
                [lean * x, height, lean * z],
            ],
            parameters.steps(8),
        );
        let side = [
            path[path.len() * 2 / 3].to_array(),
            (path[path.len() * 2 / 3] + DVec3::new(0.05 * z, 0.06, -0.05 * x)).to_array(),
        ];
        let middle = [0, 1, 2].map(|k| 0.5 * (side[0][k] + side[1][k]) + 0.006);
        merged([
            tube(&path, 0.0026, parameters.steps(9)),
            tube(
                &curve(&[side[0], middle, side[1]], parameters.steps(6)),
                0.0018,
                parameters.steps(8),
            ),
        ])
    };
    merged((0..7).map(twig))
}

fn bottle(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.05, 0.0],
            [0.056, 0.01],
            [0.056, 0.17],
            [0.05, 0.2],
            [0.022, 0.235],
            [0.018, 0.29],
            [0.022, 0.297],
            [0.021, 0.312],
            [0.0, 0.314],
        ],
        parameters.steps(5),
    );
    lathe(&profile, parameters.steps(72))
}

fn bowl(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.05, 0.0],
            [0.052, 0.008],
            [0.1, 0.04],
            [0.13, 0.088],
            [0.131, 0.093],
            [0.127, 0.094],
            [0.095, 0.048],
            [0.0, 0.016],
        ],
        parameters.steps(6),
    );
    lathe(&profile, parameters.steps(84))
}

fn ball(parameters: &Parameters) -> Mesh {
    moved(&sphere(0.075, parameters.steps(64)), [0.0, 0.075, 0.0])
}

/// A trefoil standing on its edge.
fn knot(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(160);
    let path: Vec<DVec3> = (0..steps)
        .map(|i| {
            let t = TAU * i as f64 / steps as f64;
            let radius = 0.052 * (2.0 + (3.0 * t).cos());
            DVec3::new(
                radius * (2.0 * t).cos(),
                0.05 * (3.0 * t).sin(),
                radius * (2.0 * t).sin(),
            )
        })
        .collect();
    let flat = sweep(&path, &circle(0.026, parameters.steps(22)), true);
    let upright = placed(&flat, glam::DMat4::from_rotation_x(72f64.to_radians()));
    let lowest = upright.positions.iter().map(|p| p.y).fold(0.0, f64::min);
    moved(&upright, [0.0, -lowest, 0.0])
}

/// Building blocks: an arch of three and a leaning plate.
fn blocks(parameters: &Parameters) -> Mesh {
    let block = |half: [f64; 3], at: [f64; 3], turn_deg: f64| {
        set_at(
            &rounded_box(half, 0.004, parameters.steps(3)),
            at,
            turn_deg,
            1.0,
        )
    };
    let plate = rounded_box([0.05, 0.006, 0.07], 0.003, parameters.steps(3));
    let lean = glam::DMat4::from_translation(DVec3::new(0.118, 0.055, 0.0))
        * glam::DMat4::from_rotation_z(-1.05);
    merged([
        block([0.022, 0.06, 0.022], [-0.06, 0.06, 0.0], 4.0),
        block([0.022, 0.06, 0.022], [0.06, 0.06, 0.0], -6.0),
        block([0.09, 0.016, 0.024], [0.0, 0.136, 0.0], 2.0),
        placed(&plate, lean),
    ])
}
