//! Carved figures along a paved avenue, from two metres away to beyond forty.

use super::figures::{elephant, seated, standing};
use super::kit::{
    bevelled_box, cuboid, cylinder, jitter, lathe, merged, moved, set_at, smooth_profile,
    strip_solid,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;
use glam::{DVec2, DVec3};

pub const PARTS: &[(&str, PartFunction)] = &[
    ("ground", ground),
    ("paving", paving),
    ("near-seated", near_seated),
    ("near-elephant", near_elephant),
    ("standing", standing_row),
    ("far-figures", far_figures),
    ("plinths", plinths),
    ("urns", urns),
    ("gate", gate),
    ("rubble", rubble),
];

/// Where the avenue's statues stand: (x, z, turn in degrees). The camera looks towards -z.
const NEAR_SEATED: [f64; 3] = [-1.25, -0.2, 22.0];
const NEAR_ELEPHANT: [f64; 3] = [2.1, -3.2, -38.0];
const STANDING: [[f64; 3]; 5] = [
    [-2.6, -4.6, 35.0],
    [2.6, -9.0, -40.0],
    [-2.6, -9.0, 40.0],
    [2.6, -14.0, -40.0],
    [-2.6, -14.0, 40.0],
];
const FAR_SEATED: [[f64; 3]; 3] = [[-2.6, -20.0, 40.0], [2.6, -20.0, -40.0], [0.0, -39.0, 0.0]];
const FAR_ELEPHANTS: [[f64; 3]; 2] = [[-3.2, -29.0, 30.0], [3.2, -29.0, -30.0]];
const PLINTH_HEIGHT: f64 = 0.55;

/// A quarter square kilometre of flat earth; its far edge rises a little, since below the horizon the
/// sky is black.
fn ground(_: &Parameters) -> Mesh {
    let cuts = [-250.0, -200.0, 200.0, 250.0];
    let mesh = super::kit::lattice([4, 4], [false; 2], |i, j| {
        let inside = (1..3).contains(&i) && (1..3).contains(&j);
        DVec3::new(cuts[i], if inside { 0.0 } else { 4.0 }, -cuts[j])
    });
    super::kit::shade(mesh, 1.0)
}

/// Bevelled slabs, slightly uneven, in a bed of sand that fills the joints up to a few millimetres.
fn paving(parameters: &Parameters) -> Mesh {
    let slab = |i: i32, j: i32| {
        let key = (i * 1000 + j + 500_000) as u64;
        let height = jitter(parameters.seed, key, [0.036, 0.046]);
        let (x, z) = (f64::from(i) * 0.7, 3.4 - f64::from(j) * 0.7);
        let gap = 0.006;
        bevelled_box(
            [x + gap, -0.02, z - 0.7 + gap],
            [x + 0.7 - gap, height, z - gap],
            0.006,
        )
    };
    let bed = cuboid([-2.09, -0.02, 3.39 - 66.0 * 0.7], [2.09, 0.032, 3.39]);
    let slabs = (-3..3).flat_map(|i| (0..66).map(move |j| slab(i, j)));
    merged([bed].into_iter().chain(slabs))
}

fn near_seated(parameters: &Parameters) -> Mesh {
    on_plinth(&seated(parameters.cell(0.0085)), NEAR_SEATED)
}

fn near_elephant(parameters: &Parameters) -> Mesh {
    on_plinth(&elephant(parameters.cell(0.0145)), NEAR_ELEPHANT)
}

fn standing_row(parameters: &Parameters) -> Mesh {
    let figure = standing(parameters.cell(0.0125));
    merged(STANDING.map(|at| on_plinth(&figure, at)))
}

fn far_figures(parameters: &Parameters) -> Mesh {
    let (buddha, animal) = rayon::join(
        || seated(parameters.cell(0.02)),
        || elephant(parameters.cell(0.026)),
    );
    let large = set_at(&buddha, [0.0; 3], 0.0, 2.4);
    let [left, right, last] = FAR_SEATED;
    merged([
        on_plinth(&buddha, left),
        on_plinth(&buddha, right),
        on_plinth(&large, last),
        on_plinth(&animal, FAR_ELEPHANTS[0]),
        on_plinth(&animal, FAR_ELEPHANTS[1]),
    ])
}

fn on_plinth(figure: &Mesh, [x, z, turn_deg]: [f64; 3]) -> Mesh {
    set_at(figure, [x, PLINTH_HEIGHT - 0.004, z], turn_deg, 1.0)
}

/// Square plinths with a moulded foot and cap.
fn plinths(_: &Parameters) -> Mesh {
    let plinth = |[x, z, turn_deg]: [f64; 3], half: [f64; 2]| {
        let [hx, hz] = half;
        let tier = |grow: f64, y0: f64, y1: f64| {
            bevelled_box(
                [-hx - grow, y0, -hz - grow],
                [hx + grow, y1, hz + grow],
                0.015,
            )
        };
        let top = PLINTH_HEIGHT;
        // Each tier is sunk into the one below deeper than its bevel: no wedge opens at its foot.
        let body = merged([
            tier(0.12, -0.02, 0.12),
            tier(0.06, 0.1, 0.18),
            tier(0.0, 0.16, top - 0.08),
            tier(0.05, top - 0.1, top),
        ]);
        set_at(&body, [x, 0.0, z], turn_deg, 1.0)
    };
    let standing = STANDING.map(|at| plinth(at, [0.45, 0.42]));
    let [left, right, last] = FAR_SEATED;
    let seated = [NEAR_SEATED, left, right].map(|at| plinth(at, [0.72, 0.72]));
    let [a, b] = FAR_ELEPHANTS;
    let elephants = [NEAR_ELEPHANT, a, b].map(|at| plinth(at, [0.55, 1.15]));
    let great = plinth(last, [1.8, 1.8]);
    merged(
        standing
            .into_iter()
            .chain(seated)
            .chain(elephants)
            .chain([great]),
    )
}

/// Fluted urns between the statues.
fn urns(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.0, 0.0],
            [0.17, 0.0],
            [0.18, 0.04],
            [0.07, 0.1],
            [0.06, 0.14],
            [0.2, 0.3],
            [0.24, 0.44],
            [0.17, 0.58],
            [0.2, 0.64],
            [0.22, 0.66],
            [0.19, 0.655],
            [0.14, 0.57],
            [0.19, 0.4],
            [0.0, 0.2],
        ],
        parameters.steps(5),
    );
    let urn = lathe(&profile, parameters.steps(48));
    let foot = cylinder(0.24, 0.3, 0.015, parameters.steps(40));
    let whole = merged([foot, moved(&urn, [0.0, 0.3, 0.0])]);
    let spots = [-6.8, -11.5, -17.0, -24.5, -34.0];
    merged(
        spots
            .into_iter()
            .flat_map(|z| [-2.5, 2.5].map(|x| set_at(&whole, [x, 0.0, z], 0.0, 1.0))),
    )
}

/// A row of arches that closes the avenue at 44 m: spandrels set back between the piers, which run up
/// into the frieze.
fn gate(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(24);
    let span = 3.2;
    let arch = |centre: f64| {
        let (lower, upper): (Vec<DVec2>, Vec<DVec2>) = (0..=steps)
            .map(|i| {
                let angle_rad = std::f64::consts::PI * (1.0 - i as f64 / steps as f64);
                let (x, y) = (
                    angle_rad.cos() * (span * 0.5 + 0.03),
                    angle_rad.sin() * span * 0.5,
                );
                (DVec2::new(centre + x, 4.2 + y), DVec2::new(centre + x, 6.9))
            })
            .unzip();
        moved(&strip_solid(&lower, &upper, 0.84), [0.0, 0.0, -44.42])
    };
    let pitch = span + 1.0;
    let mut pieces = Vec::new();
    for i in -3..=3 {
        pieces.push(arch(f64::from(i) * pitch));
    }
    for i in -4..=3 {
        let x = (f64::from(i) + 0.5) * pitch;
        let block = |hx: f64, y: [f64; 2], grow: f64| {
            let z = [-44.5 - grow, -43.5 + grow];
            bevelled_box([x - hx, y[0], z[0]], [x + hx, y[1], z[1]], 0.02)
        };
        pieces.push(block(0.5, [0.0, 6.9], 0.0));
        pieces.push(block(0.6, [0.0, 0.5], 0.1));
        pieces.push(block(0.58, [4.0, 4.25], 0.08));
    }
    let reach = 4.0 * pitch;
    for (y, grow) in [(6.8, 0.12), (7.0, 0.24), (7.22, 0.1)] {
        let (low, high) = ([-reach, y, -44.5 - grow], [reach, y + 0.26, -43.5 + grow]);
        pieces.push(bevelled_box(low, high, 0.03));
    }
    merged(pieces)
}

/// Stones scattered beside the paving.
fn rubble(parameters: &Parameters) -> Mesh {
    let stone = super::kit::sphere(1.0, parameters.steps(14));
    let stones = (0..160u64).map(|i| {
        let random = |k: u64, range: [f64; 2]| jitter(parameters.seed, i * 16 + k, range);
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        let size = 0.02 + 0.13 * random(0, [0.0, 1.0]).powi(3);
        let x = side * random(1, [3.3, 8.0]);
        let z = 1.0 - 32.0 * random(2, [0.0, 1.0]).powi(2);
        let lump = |p: DVec3| {
            let wave = (p.x * 2.6 + random(3, [0.0, 6.0])).sin() * (p.y * 2.2).cos()
                + 0.5 * (p.z * 4.1 + random(4, [0.0, 6.0])).sin();
            p * (1.0 + 0.16 * wave) * DVec3::new(1.0, 0.62, 0.8)
        };
        let mut rock = Mesh {
            positions: stone.positions.iter().map(|&p| lump(p)).collect(),
            triangles: stone.triangles.clone(),
            ..Mesh::default()
        };
        rock = super::kit::shade(rock, 180.0);
        set_at(&rock, [x, size * 0.3, z], random(5, [0.0, 360.0]), size)
    });
    merged(stones)
}
