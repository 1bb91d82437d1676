//! Four objects from diffuse to semi-glossy on a round table under the sky.

use std::f64::consts::TAU;

use glam::{DMat4, DVec3};

use super::figures::seated;
use super::kit::{
    bevelled_box, capsule, curve, lathe, merged, moved, placed, rounded_box, set_at, sheet,
    smooth_profile, sphere, torus, tube,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("ground", ground),
    ("table-top", table_top),
    ("table-leg", table_leg),
    ("cloth", cloth),
    ("figure", figure),
    ("teapot", teapot),
    ("bowl", bowl),
    ("fruit", fruit),
    ("dice", dice),
    ("rings", rings),
];

/// Height of the table's surface.
const TOP: f64 = 0.75;

/// Flat earth that rises a little far away, since below the horizon the sky is black.
fn ground(_: &Parameters) -> Mesh {
    let profile = [
        [0.0, -0.2],
        [60.0, -0.2],
        [60.0, 2.2],
        [40.0, 0.0],
        [0.0, 0.0],
    ];
    lathe(&profile, 96)
}

fn table_top(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.66, 0.0],
            [0.69, 0.005],
            [0.7, 0.02],
            [0.69, 0.035],
            [0.66, 0.04],
        ],
        4,
    );
    let closed: Vec<[f64; 2]> = [[0.0, 0.0]]
        .into_iter()
        .chain(profile)
        .chain([[0.0, 0.04]])
        .collect();
    moved(
        &lathe(&closed, parameters.steps(128)),
        [0.0, TOP - 0.04, 0.0],
    )
}

fn table_leg(parameters: &Parameters) -> Mesh {
    lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.3, 0.0],
                [0.3, 0.03],
                [0.1, 0.06],
                [0.05, 0.12],
                [0.07, 0.3],
                [0.05, 0.5],
                [0.09, 0.66],
                [0.2, 0.708],
                [0.0, 0.708],
            ],
            parameters.steps(5),
        ),
        parameters.steps(64),
    )
}

/// A napkin with soft folds under the bowl.
fn cloth(parameters: &Parameters) -> Mesh {
    let n = parameters.steps(70);
    let napkin = sheet([n, n], 0.002, |u, v| {
        let (x, z) = ((u - 0.5) * 0.42, (0.5 - v) * 0.34);
        let wave = (x * 34.0 + 4.0 * (z * 8.0).sin()).sin() * (z * 21.0 + x * 9.0).cos();
        let edge = ((x / 0.21).abs().max((z / 0.17).abs())).powi(4);
        DVec3::new(x, 0.0022 + 0.011 * edge * (0.6 + 0.6 * wave).max(0.05), z)
    });
    set_at(&napkin, [0.36, TOP, 0.11], 24.0, 1.0)
}

fn figure(parameters: &Parameters) -> Mesh {
    let body = seated(parameters.cell(0.02));
    set_at(&body, [-0.17, TOP - 0.0008, -0.2], 18.0, 0.235)
}

fn teapot(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(72);
    let smooth = parameters.steps(6);
    let body = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.055, 0.0],
                [0.06, 0.008],
                [0.095, 0.045],
                [0.1, 0.085],
                [0.075, 0.13],
                [0.05, 0.145],
                [0.0, 0.147],
            ],
            smooth,
        ),
        round,
    );
    let lid = lathe(
        &smooth_profile(
            &[
                [0.0, 0.143],
                [0.054, 0.143],
                [0.056, 0.149],
                [0.04, 0.16],
                [0.012, 0.168],
                [0.008, 0.174],
                [0.014, 0.182],
                [0.011, 0.191],
                [0.0, 0.193],
            ],
            smooth,
        ),
        round,
    );
    let handle = tube(
        &curve(
            &[
                [-0.07, 0.125, 0.0],
                [-0.115, 0.137, 0.0],
                [-0.152, 0.105, 0.0],
                [-0.14, 0.06, 0.0],
                [-0.085, 0.035, 0.0],
            ],
            parameters.steps(10),
        ),
        0.0085,
        parameters.steps(16),
    );
    let spout_path = curve(
        &[
            [0.08, 0.05, 0.0],
            [0.115, 0.062, 0.0],
            [0.137, 0.1, 0.0],
            [0.158, 0.133, 0.0],
        ],
        parameters.steps(8),
    );
    let count = spout_path.len();
    let spout = merged((0..count - 1).map(|i| {
        let radius = |k: usize| 0.024 - 0.0125 * k as f64 / (count - 1) as f64;
        let ends = [spout_path[i].to_array(), spout_path[i + 1].to_array()];
        capsule(
            ends[0],
            ends[1],
            [radius(i), radius(i + 1)],
            parameters.steps(24),
        )
    }));
    let whole = merged([body, lid, handle, spout]);
    set_at(&whole, [0.03, TOP, 0.2], 205.0, 1.0)
}

fn bowl(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.045, 0.0],
            [0.045, 0.01],
            [0.09, 0.03],
            [0.125, 0.073],
            [0.127, 0.079],
            [0.1245, 0.081],
            [0.121, 0.076],
            [0.085, 0.038],
            [0.0, 0.02],
        ],
        parameters.steps(6),
    );
    let bowl = lathe(&profile, parameters.steps(80));
    moved(&bowl, [0.36, TOP + 0.0023, 0.11])
}

fn fruit(parameters: &Parameters) -> Mesh {
    let apple = lathe(
        &smooth_profile(
            &[
                [0.0, 0.006],
                [0.012, 0.0],
                [0.03, 0.012],
                [0.037, 0.035],
                [0.03, 0.058],
                [0.012, 0.064],
                [0.0, 0.056],
            ],
            parameters.steps(6),
        ),
        parameters.steps(40),
    );
    let stalk = capsule(
        [0.0, 0.054, 0.0],
        [0.004, 0.076, 0.002],
        [0.0016, 0.0022],
        10,
    );
    let apple = merged([apple, stalk]);
    let spots = [
        [0.325, 0.0368, 0.100, 0.0],
        [0.395, 0.0388, 0.085, 70.0],
        [0.375, 0.0378, 0.150, 150.0],
        [0.362, 0.0878, 0.108, 30.0],
    ];
    let piled = spots.map(|[x, y, z, turn_deg]| {
        let lean = placed(
            &apple,
            DMat4::from_rotation_z((turn_deg * 0.2f64).to_radians()),
        );
        set_at(&lean, [x, TOP + y, z], turn_deg, 1.0)
    });
    let loose = set_at(&apple, [-0.12, TOP + 0.001, 0.27], 40.0, 1.0);
    merged(piled.into_iter().chain([loose]))
}

/// Rounded dice with inset-looking raised pips.
fn dice(parameters: &Parameters) -> Mesh {
    let cube = rounded_box([0.022, 0.022, 0.022], 0.005, parameters.steps(4));
    let pip = sphere(0.0042, parameters.steps(12));
    let face = |spots: &[[f64; 2]], turn: DMat4| {
        merged(spots.iter().map(|&[a, b]| {
            placed(
                &pip,
                turn * DMat4::from_translation(DVec3::new(a, 0.0203, b)),
            )
        }))
    };
    let d = 0.011;
    let die = merged([
        cube,
        face(
            &[[d, d], [-d, -d], [0.0, 0.0], [d, -d], [-d, d]],
            DMat4::IDENTITY,
        ),
        face(&[[d, d], [-d, -d]], DMat4::from_rotation_x(TAU * 0.25)),
        face(
            &[[d, d], [-d, -d], [0.0, 0.0]],
            DMat4::from_rotation_z(TAU * 0.25),
        ),
        face(&[[0.0, 0.0]], DMat4::from_rotation_z(-TAU * 0.25)),
    ]);
    merged([
        set_at(&die, [-0.27, TOP + 0.022, 0.16], 33.0, 1.0),
        set_at(&die, [-0.22, TOP + 0.022, 0.23], -12.0, 1.0),
        moved(
            &bevelled_box([-0.055, 0.0, -0.04], [0.055, 0.024, 0.04], 0.003),
            [-0.33, TOP, 0.03],
        ),
    ])
}

/// Interlocked metal rings leaning on the book.
fn rings(parameters: &Parameters) -> Mesh {
    let ring = torus(0.052, 0.006, [parameters.steps(72), parameters.steps(18)]);
    let flat = moved(&ring, [-0.34, TOP + 0.03, 0.03]);
    let lying = moved(&ring, [0.16, TOP + 0.006, 0.33]);
    let leaning = placed(
        &ring,
        DMat4::from_translation(DVec3::new(0.22, TOP + 0.029, 0.345))
            * DMat4::from_rotation_y(0.6)
            * DMat4::from_rotation_z(0.44),
    );
    merged([flat, lying, leaning])
}
