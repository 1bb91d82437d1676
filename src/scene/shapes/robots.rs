//! Glossy robots near and far on a plain floor.

use std::f64::consts::TAU;

use glam::{DMat4, DVec3};

use super::kit::{
    bevelled_box, capsule, curve, cylinder, jitter, lathe, lattice, merged, moved, placed,
    rounded_box, set_at, smooth_profile, sphere, torus, tube,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("floor", floor),
    ("walker-shells", walker_shells),
    ("walker-joints", walker_joints),
    ("walker-eyes", walker_eyes),
    ("roller-shells", roller_shells),
    ("roller-metal", roller_metal),
    ("roller-eyes", roller_eyes),
    ("cables", cables),
    ("crates", crates),
    ("lamps", lamps),
];

/// Two-legged robots: (x, z, turn in degrees, scale).
const WALKERS: [[f64; 4]; 5] = [
    [-0.95, -0.3, 24.0, 1.0],
    [1.9, -3.6, -28.0, 1.0],
    [-3.2, -6.5, 30.0, 1.1],
    [0.4, -11.0, 5.0, 1.0],
    [4.6, -15.0, -30.0, 1.2],
];
/// Ball-shaped robots on one wheel.
const ROLLERS: [[f64; 4]; 4] = [
    [0.75, 0.1, -25.0, 1.0],
    [-0.9, -4.4, 20.0, 1.0],
    [3.6, -7.6, -20.0, 1.3],
    [-5.4, -12.5, 35.0, 1.3],
];

/// A floor that curves up into a back wall 26 m away.
fn floor(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(24);
    let profile: Vec<[f64; 2]> = [[12.0, 0.0]]
        .into_iter()
        .chain((0..=steps).map(|i| {
            let angle_rad = TAU * 0.25 * i as f64 / steps as f64;
            [-20.0 - 6.0 * angle_rad.sin(), 6.0 - 6.0 * angle_rad.cos()]
        }))
        .chain([[-26.0, 14.0]])
        .collect();
    let mesh = lattice([2, profile.len()], [false; 2], |i, j| {
        let [z, y] = profile[j];
        DVec3::new(-40.0 + 80.0 * i as f64, y, z)
    });
    super::kit::shade(mesh, 30.0)
}

fn at_all(body: &Mesh, spots: &[[f64; 4]]) -> Mesh {
    let copy = |&[x, z, turn_deg, scale]: &[f64; 4]| set_at(body, [x, 0.0, z], turn_deg, scale);
    merged(spots.iter().map(copy))
}

fn box_at(half: [f64; 3], radius: f64, at: [f64; 3], steps: usize) -> Mesh {
    moved(&rounded_box(half, radius, steps), at)
}

/// Both of a pair, the second mirrored in x.
fn pair(mesh: Mesh) -> Mesh {
    let mirror = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let other = placed(&mesh, mirror);
    merged([mesh, other])
}

fn walker_shells(parameters: &Parameters) -> Mesh {
    let (steps, round) = (parameters.steps(5), parameters.steps(28));
    let chest = box_at([0.24, 0.22, 0.17], 0.1, [0.0, 1.08, 0.0], steps);
    let hips = box_at([0.17, 0.08, 0.12], 0.06, [0.0, 0.74, 0.0], steps);
    let head = box_at([0.17, 0.13, 0.14], 0.075, [0.0, 1.52, 0.02], steps);
    let pack = box_at([0.16, 0.17, 0.07], 0.04, [0.0, 1.1, -0.22], steps);
    let thigh = capsule([0.13, 0.64, 0.0], [0.15, 0.46, 0.03], [0.075, 0.065], round);
    let shin = capsule(
        [0.15, 0.33, 0.03],
        [0.15, 0.14, -0.01],
        [0.068, 0.085],
        round,
    );
    let foot = box_at([0.09, 0.045, 0.16], 0.04, [0.15, 0.045, 0.05], steps);
    let shoulder = moved(&sphere(0.105, round), [0.33, 1.2, 0.0]);
    let upper = capsule([0.38, 1.1, 0.0], [0.41, 0.97, 0.02], [0.058, 0.05], round);
    let fore = capsule([0.41, 0.83, 0.06], [0.38, 0.72, 0.2], [0.052, 0.068], round);
    let limbs = pair(merged([thigh, shin, foot, shoulder, upper, fore]));
    at_all(&merged([chest, hips, head, pack, limbs]), &WALKERS)
}

/// Bellows, pins, fingers, aerial: the bare metal.
fn walker_joints(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(24);
    let bellows = |from: [f64; 3], to: [f64; 3], radius: f64, rings: usize| {
        let (a, b) = (DVec3::from(from), DVec3::from(to));
        let along = (b - a).normalize();
        merged((0..rings).map(|i| {
            let t = (i as f64 + 0.5) / rings as f64;
            let ring = torus(radius * 0.72, radius * 0.3, [round, parameters.steps(10)]);
            let core = cylinder(radius * 0.8, a.distance(b) / rings as f64, 0.0, round);
            let turn = super::kit::y_towards(along);
            let low = a.lerp(b, i as f64 / rings as f64);
            merged([
                placed(&ring, DMat4::from_translation(a.lerp(b, t)) * turn),
                placed(&core, DMat4::from_translation(low) * turn),
            ])
        }))
    };
    let waist = bellows([0.0, 0.8, 0.0], [0.0, 0.88, 0.0], 0.12, 4);
    let neck = bellows([0.0, 1.29, 0.0], [0.0, 1.4, 0.01], 0.075, 4);
    let knee = bellows([0.15, 0.44, 0.03], [0.15, 0.34, 0.03], 0.05, 3);
    let elbow = bellows([0.41, 0.95, 0.02], [0.41, 0.84, 0.06], 0.042, 3);
    let fingers = (0..3).map(|i| {
        let angle_rad = TAU * f64::from(i) / 3.0 + 0.5;
        let (s, c) = (angle_rad.sin() * 0.045, angle_rad.cos() * 0.045);
        let knuckle = [0.375 + s, 0.68 + c * 0.8, 0.26 + c * 0.3];
        let tip = [0.37 + s * 0.8, 0.63 + c * 0.8, 0.345];
        let root = [0.38 + s * 0.6, 0.7 + c * 0.6, 0.2];
        merged([
            capsule(root, knuckle, [0.018, 0.015], 12),
            capsule(knuckle, tip, [0.015, 0.009], 12),
        ])
    });
    let ear = cylinder(0.055, 0.04, 0.01, round);
    let sideways = DMat4::from_translation(DVec3::new(0.16, 1.52, 0.02))
        * DMat4::from_rotation_z(-90f64.to_radians());
    let sides = pair(merged(
        [knee, elbow, placed(&ear, sideways)]
            .into_iter()
            .chain(fingers),
    ));
    let aerial = merged([
        capsule([0.1, 1.63, -0.02], [0.12, 1.88, -0.05], [0.008, 0.004], 10),
        moved(&sphere(0.018, 14), [0.12, 1.89, -0.05]),
    ]);
    let dial = placed(
        &merged([
            torus(0.075, 0.012, [round, 10]),
            cylinder(0.07, 0.012, 0.004, round),
        ]),
        DMat4::from_translation(DVec3::new(0.0, 1.13, 0.168))
            * DMat4::from_rotation_x(90f64.to_radians()),
    );
    at_all(&merged([waist, neck, sides, aerial, dial]), &WALKERS)
}

fn walker_eyes(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(24);
    let eye = moved(&sphere(0.042, round), [0.07, 1.545, 0.145]);
    let mouth = (-2..=2).map(|i| {
        let x = f64::from(i) * 0.025;
        capsule([x, 1.45, 0.155], [x, 1.475, 0.158], [0.008, 0.008], 10)
    });
    at_all(&merged([pair(eye)].into_iter().chain(mouth)), &WALKERS)
}

fn roller_shells(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(56);
    // Two shells with a seam between them.
    let half = |sign: f64| {
        let n = parameters.steps(16);
        let mut profile: Vec<[f64; 2]> = (0..=n)
            .map(|i| {
                let angle_rad = TAU * 0.25 * i as f64 / n as f64;
                let across = if i == n { 0.0 } else { angle_rad.cos() };
                [0.36 * across, 0.018 + 0.36 * angle_rad.sin()]
            })
            .collect();
        profile.insert(0, [0.32, 0.018]);
        profile.insert(0, [0.0, 0.018]);
        placed(
            &lathe(&profile, round),
            DMat4::from_translation(DVec3::new(0.0, 0.72, 0.0))
                * DMat4::from_rotation_z((90.0 - 90.0 * sign + 12.0f64).to_radians()),
        )
    };
    let cap = lathe(
        &smooth_profile(
            &[
                [0.0, 1.04],
                [0.11, 1.05],
                [0.12, 1.13],
                [0.07, 1.2],
                [0.0, 1.22],
            ],
            6,
        ),
        round,
    );
    let fender = placed(
        &torus(0.25, 0.05, [round, parameters.steps(16)]),
        DMat4::from_translation(DVec3::new(0.0, 0.27, 0.0))
            * DMat4::from_scale(DVec3::new(0.6, 1.0, 1.0)),
    );
    at_all(&merged([half(1.0), half(-1.0), cap, fender]), &ROLLERS)
}

fn roller_metal(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(40);
    let core = moved(&sphere(0.34, round), [0.0, 0.72, 0.0]);
    let wheel = placed(
        &torus(0.17, 0.075, [round, parameters.steps(18)]),
        DMat4::from_translation(DVec3::new(0.0, 0.245, 0.0))
            * DMat4::from_rotation_z(90f64.to_radians()),
    );
    let spokes = (0..6).map(|i| {
        let angle_rad = TAU * f64::from(i) / 6.0;
        let (s, c) = angle_rad.sin_cos();
        capsule(
            [0.0, 0.245, 0.0],
            [0.0, 0.245 + 0.14 * s, 0.14 * c],
            [0.016, 0.012],
            10,
        )
    });
    let fork = pair(capsule(
        [0.12, 0.245, 0.0],
        [0.19, 0.42, 0.0],
        [0.022, 0.028],
        14,
    ));
    let axle = capsule([-0.12, 0.245, 0.0], [0.12, 0.245, 0.0], [0.022, 0.022], 14);
    let bezel = placed(
        &torus(0.13, 0.02, [round, parameters.steps(12)]),
        DMat4::from_translation(DVec3::new(0.0, 0.79, 0.335))
            * DMat4::from_rotation_x(78f64.to_radians()),
    );
    let arm = pair(merged([
        capsule([0.36, 0.72, 0.02], [0.47, 0.62, 0.1], [0.035, 0.026], 16),
        capsule([0.47, 0.62, 0.1], [0.42, 0.52, 0.28], [0.026, 0.022], 16),
        moved(&sphere(0.04, 18), [0.42, 0.52, 0.28]),
    ]));
    let whole = merged(
        [core, wheel, fork, axle, bezel, arm]
            .into_iter()
            .chain(spokes),
    );
    at_all(&whole, &ROLLERS)
}

fn roller_eyes(parameters: &Parameters) -> Mesh {
    let lens = moved(&sphere(0.115, parameters.steps(32)), [0.0, 0.785, 0.305]);
    at_all(&lens, &ROLLERS)
}

/// Cables between the robots' packs, slack on the floor, and one to the camera's side.
fn cables(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(12);
    let lines: [&[[f64; 3]]; 4] = [
        &[
            [-1.05, 1.0, -0.56],
            [-1.3, 0.35, -0.9],
            [-1.0, 0.02, -1.5],
            [0.2, 0.02, -1.9],
            [0.9, 0.02, -2.9],
            [1.75, 0.3, -4.05],
            [2.02, 1.0, -3.87],
        ],
        &[
            [-1.0, 1.1, -0.6],
            [-1.7, 0.5, -0.8],
            [-2.1, 0.025, -0.3],
            [-1.6, 0.025, 0.7],
            [-0.3, 0.025, 0.9],
            [0.5, 0.025, 1.3],
            [1.8, 0.025, 1.0],
            [3.4, 0.025, 1.9],
        ],
        &[
            [-3.35, 1.1, -6.8],
            [-3.6, 0.3, -7.3],
            [-2.4, 0.02, -7.8],
            [-0.6, 0.02, -8.4],
            [0.5, 0.02, -10.2],
            [0.45, 0.4, -11.5],
            [0.4, 1.05, -11.28],
        ],
        &[
            [1.5, 0.015, -0.9],
            [2.3, 0.015, -1.3],
            [2.6, 0.015, -0.6],
            [1.9, 0.015, -0.3],
            [1.7, 0.015, -1.0],
            [2.5, 0.035, -1.5],
            [3.6, 0.015, -1.1],
        ],
    ];
    let radii = [0.02, 0.025, 0.02, 0.015];
    merged(
        lines
            .iter()
            .zip(radii)
            .map(|(points, radius)| tube(&curve(points, steps), radius, parameters.steps(12))),
    )
}

fn crates(parameters: &Parameters) -> Mesh {
    let spots = [
        [2.9, -1.9],
        [-2.5, -2.4],
        [1.3, -7.4],
        [-1.9, -9.6],
        [6.0, -10.0],
        [-6.6, -6.0],
    ];
    merged(spots.iter().enumerate().map(|(i, &[x, z])| {
        let key = i as u64 * 8;
        let half = jitter(parameters.seed, key, [0.22, 0.36]);
        let turn_deg = jitter(parameters.seed, key + 1, [0.0, 90.0]);
        let body = bevelled_box([-half, 0.04, -half], [half, half * 2.0, half], 0.02);
        let lid = bevelled_box(
            [-half - 0.015, half * 1.7, -half - 0.015],
            [half + 0.015, half * 1.78, half + 0.015],
            0.006,
        );
        let feet = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[sx, sz]| {
            let at = [sx * (half - 0.06), 0.0, sz * (half - 0.06)];
            moved(&cylinder(0.04, 0.05, 0.005, 16), at)
        });
        let handle = tube(
            &curve(
                &[
                    [-0.09, half * 1.3, half - 0.01],
                    [-0.08, half * 1.3, half + 0.04],
                    [0.08, half * 1.3, half + 0.04],
                    [0.09, half * 1.3, half - 0.01],
                ],
                parameters.steps(5),
            ),
            0.009,
            10,
        );
        let whole = merged([body, lid, handle].into_iter().chain(feet));
        set_at(&whole, [x, 0.0, z], turn_deg, 1.0)
    }))
}

/// Three long glowing panels overhead that face down; single quads, so that no light sample is lost on
/// a side nobody sees.
fn lamps(_: &Parameters) -> Mesh {
    let panels = [-1.0, -8.0, -16.0].map(|middle| {
        lattice([2, 2], [false; 2], |i, j| {
            DVec3::new(-3.0 + 6.0 * i as f64, 5.6, middle - 0.5 + j as f64)
        })
    });
    super::kit::shade(merged(panels), 1.0)
}
