//! A stair hall: balusters, rail and skirting, a seated figure near the camera and one on the landing.

use std::f64::consts::PI;

use glam::{DMat4, DVec2, DVec3};

use super::figures::seated;
use super::kit::{
    Opening, bevelled_box, cuboid, cylinder, lathe, merged, moved, placed, rounded_box, set_at,
    sheet, smooth_profile, sphere, sweep, wall,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("floor", floor),
    ("walls", walls),
    ("ceiling", ceiling),
    ("treads", treads),
    ("risers", risers),
    ("carpet", carpet),
    ("balusters", balusters),
    ("rails", rails),
    ("skirting", skirting),
    ("windows", windows),
    ("near-figure", near_figure),
    ("far-figure", far_figure),
    ("pedestals", pedestals),
    ("lamp", lamp),
    ("lamp-glow", lamp_glow),
    ("pictures", pictures),
    ("picture-frames", picture_frames),
];

/// The flight rises towards -z between x = -1.15 and x = 1.15.
const STEPS: usize = 15;
const RISE: f64 = 0.17;
const GOING: f64 = 0.29;
const FIRST_Z: f64 = -0.9;
const HALF_WIDTH: f64 = 1.15;
/// The hall: x = ±2.6, z from -8.6 to 4.2, 6.2 m high.
const HALL_X: f64 = 2.6;
const BACK_Z: f64 = -8.6;
const FRONT_Z: f64 = 4.2;
const HEIGHT: f64 = 6.2;
const LANDING_Y: f64 = RISE * STEPS as f64;
const LANDING_Z: f64 = FIRST_Z - GOING * (STEPS - 1) as f64;

/// Boards along z with fine joints.
fn floor(_: &Parameters) -> Mesh {
    let width = 0.2;
    let boards = (HALL_X * 2.0 / width).round() as usize;
    let bed = cuboid([-HALL_X, -0.2, BACK_Z], [HALL_X, -0.012, FRONT_Z]);
    let board = |i: usize| {
        let x = -HALL_X + width * i as f64;
        let offset = (i * 7 % 5) as f64 * 0.42;
        let cuts: Vec<f64> = [FRONT_Z]
            .into_iter()
            .chain((0..6).map(|k| FRONT_Z - 0.9 - offset - 2.1 * f64::from(k)))
            .chain([BACK_Z])
            .filter(|z| *z >= BACK_Z)
            .collect();
        merged(cuts.windows(2).filter(|w| w[0] - w[1] > 0.05).map(|w| {
            bevelled_box(
                [x + 0.0015, -0.03, w[1] + 0.0015],
                [x + width - 0.0015, 0.0, w[0] - 0.0015],
                0.003,
            )
        }))
    };
    merged([bed].into_iter().chain((0..boards).map(board)))
}

/// (centre along the wall from its left end, sill, head, half width) of the windows of a side wall.
const WINDOWS: [[f64; 4]; 4] = [
    [2.2, 0.9, 2.6, 0.55],
    [5.2, 2.6, 4.9, 0.55],
    [8.2, 3.5, 5.5, 0.55],
    [11.0, 3.5, 5.5, 0.55],
];

fn side_wall(mesh: &Mesh, right: bool) -> Mesh {
    // Both walls run their own x from the front of the hall to its back.
    let left = placed(
        mesh,
        DMat4::from_translation(DVec3::new(-HALL_X - 0.3, 0.0, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    if right {
        placed(&left, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)))
    } else {
        left
    }
}

fn walls(_: &Parameters) -> Mesh {
    let length = FRONT_Z - BACK_Z;
    let openings = WINDOWS.map(|[c, low, high, half]| Opening {
        min: [c - half, low],
        max: [c + half, high],
    });
    let lit = wall([length, HEIGHT], 0.3, &openings);
    let plain = wall([length, HEIGHT], 0.3, &[]);
    let niche = Opening {
        min: [HALL_X - 0.8, LANDING_Y + 0.1],
        max: [HALL_X + 0.8, LANDING_Y + 2.3],
    };
    let back = moved(
        &wall([HALL_X * 2.0, HEIGHT], 0.5, &[niche]),
        [-HALL_X, 0.0, BACK_Z - 0.5],
    );
    let niche_back = cuboid(
        [-1.2, LANDING_Y - 0.2, BACK_Z - 0.6],
        [1.2, HEIGHT, BACK_Z - 0.5],
    );
    let front = cuboid([-HALL_X, 0.0, FRONT_Z], [HALL_X, HEIGHT, FRONT_Z + 0.3]);
    merged([
        side_wall(&lit, false),
        side_wall(&plain, true),
        back,
        niche_back,
        front,
    ])
}

/// Plaster with beams.
fn ceiling(_: &Parameters) -> Mesh {
    let plate = cuboid(
        [-HALL_X - 0.3, HEIGHT, BACK_Z - 0.6],
        [HALL_X + 0.3, HEIGHT + 0.2, FRONT_Z + 0.3],
    );
    let beams = (0..9).map(|i| {
        let z = FRONT_Z - 0.9 - 1.4 * f64::from(i);
        bevelled_box(
            [-HALL_X, HEIGHT - 0.18, z - 0.08],
            [HALL_X, HEIGHT + 0.05, z + 0.08],
            0.012,
        )
    });
    merged([plate].into_iter().chain(beams))
}

fn step_corner(i: usize) -> (f64, f64) {
    (RISE * (i + 1) as f64, FIRST_Z - GOING * i as f64)
}

/// Treads with a nosing, and the landing's boards.
fn treads(_: &Parameters) -> Mesh {
    let tread = |i: usize| {
        let (y, z) = step_corner(i);
        rounded_nosing(
            [-HALF_WIDTH - 0.06, y - 0.036, z - GOING],
            [HALF_WIDTH + 0.06, y, z + 0.03],
        )
    };
    let landing = bevelled_box(
        [-HALL_X, LANDING_Y - 0.036, BACK_Z],
        [HALL_X, LANDING_Y, LANDING_Z + 0.03],
        0.008,
    );
    merged((0..STEPS - 1).map(tread).chain([landing]))
}

fn rounded_nosing(min: [f64; 3], max: [f64; 3]) -> Mesh {
    let (low, high) = (DVec3::from(min), DVec3::from(max));
    let half = (high - low) * 0.5;
    moved(
        &rounded_box(half.to_array(), 0.012, 3),
        ((low + high) * 0.5).to_array(),
    )
}

/// Risers, the closed sides under the flight and the landing's front.
fn risers(_: &Parameters) -> Mesh {
    let body = (0..STEPS - 1).map(|i| {
        let (y, z) = step_corner(i);
        cuboid([-HALF_WIDTH, 0.0, z - GOING], [HALF_WIDTH, y - 0.036, z])
    });
    let landing = cuboid(
        [-HALL_X, 0.0, BACK_Z],
        [HALL_X, LANDING_Y - 0.036, LANDING_Z],
    );
    let panels = [-1.0f64, 1.0].into_iter().flat_map(|side| {
        [0.45, 1.2].map(|y| {
            let (a, b) = (side * 1.35, side * 2.4);
            let z = LANDING_Z;
            bevelled_box(
                [a.min(b), y - 0.3, z - 0.02],
                [a.max(b), y + 0.3, z + 0.025],
                0.02,
            )
        })
    });
    merged(body.chain([landing]).chain(panels))
}

/// A runner that follows the steps.
fn carpet(parameters: &Parameters) -> Mesh {
    let mut line = vec![[0.012, FIRST_Z + 0.9], [0.012, FIRST_Z + 0.012]];
    for i in 0..STEPS - 1 {
        let (y, z) = step_corner(i);
        let lift = 0.01;
        line.extend([
            [y - 0.045, z + lift],
            [y - 0.03, z + 0.03 + lift],
            [y - 0.006, z + 0.03 + lift],
            [y + lift, z + 0.02],
            [y + lift, z - GOING + lift + 0.004],
        ]);
    }
    let (y, z) = step_corner(STEPS - 1);
    line.extend([
        [y - 0.045, z + 0.01],
        [y - 0.03, z + 0.04],
        [y - 0.006, z + 0.04],
    ]);
    line.extend([[y + 0.01, z + 0.02], [y + 0.01, z - 1.6]]);
    let rows = line.len();
    let columns = parameters.steps(9);
    sheet([columns, rows], 0.008, |u, v| {
        let [y, z] = line[(v * (rows - 1) as f64).round() as usize];
        DVec3::new((u - 0.5) * 1.3, y, z)
    })
}

/// A turned post of unit height.
fn baluster(parameters: &Parameters) -> Mesh {
    let profile = smooth_profile(
        &[
            [0.019, 0.13],
            [0.026, 0.145],
            [0.018, 0.165],
            [0.027, 0.25],
            [0.03, 0.31],
            [0.017, 0.46],
            [0.013, 0.58],
            [0.022, 0.6],
            [0.013, 0.62],
            [0.017, 0.74],
            [0.024, 0.83],
            [0.019, 0.86],
        ],
        parameters.steps(4),
    );
    let closed: Vec<[f64; 2]> = [[0.0, 0.12]]
        .into_iter()
        .chain(profile)
        .chain([[0.0, 0.87]])
        .collect();
    merged([
        lathe(&closed, parameters.steps(22)),
        bevelled_box([-0.024, 0.0, -0.024], [0.024, 0.135, 0.024], 0.003),
        bevelled_box([-0.024, 0.85, -0.024], [0.024, 1.0, 0.024], 0.003),
    ])
}

const RAIL_ABOVE: f64 = 0.92;

fn balusters(parameters: &Parameters) -> Mesh {
    let post = baluster(parameters);
    let mut pieces = Vec::new();
    for side in [-1.0, 1.0] {
        for i in 0..STEPS - 1 {
            let (y, z) = step_corner(i);
            for back in [0.25, 0.75] {
                // The rail climbs within a tread; the second post is taller.
                let height = RAIL_ABOVE + RISE * (back - 0.5) - 0.01;
                let at = DVec3::new(side * (HALF_WIDTH - 0.05), y, z - GOING * back);
                let grow = DMat4::from_scale(DVec3::new(1.0, height, 1.0));
                pieces.push(placed(&post, DMat4::from_translation(at) * grow));
            }
        }
        for k in 0..9 {
            let x = side * (HALF_WIDTH + 0.1 + 0.15 * f64::from(k));
            let at = DVec3::new(x, LANDING_Y, LANDING_Z - 0.06);
            let grow = DMat4::from_scale(DVec3::new(1.0, RAIL_ABOVE, 1.0));
            pieces.push(placed(&post, DMat4::from_translation(at) * grow));
        }
    }
    merged(pieces)
}

/// Handrails with a moulded section, and newel posts with balls.
fn rails(parameters: &Parameters) -> Mesh {
    let section: Vec<DVec2> = smooth_profile(
        &[
            [0.0, -0.028],
            [0.024, -0.028],
            [0.026, -0.01],
            [0.036, 0.008],
            [0.03, 0.028],
            [0.0, 0.034],
        ],
        parameters.steps(4),
    )
    .iter()
    .map(|&[x, y]| DVec2::new(x, y))
    .collect();
    let mirrored = section.iter().rev().skip(1).map(|p| DVec2::new(-p.x, p.y));
    let full: Vec<DVec2> = section.iter().copied().chain(mirrored).collect();
    let full = &full[..full.len() - 1];
    let mut pieces = Vec::new();
    for side in [-1.0, 1.0] {
        let x = side * (HALF_WIDTH - 0.05);
        let low = DVec3::new(x, RISE * 0.5 + RAIL_ABOVE + 0.03, FIRST_Z + 0.02);
        let high = DVec3::new(
            x,
            LANDING_Y - RISE * 0.5 + RAIL_ABOVE + 0.03,
            LANDING_Z + 0.02,
        );
        pieces.push(sweep(&[low, high], full, false));
        let level = LANDING_Y + RAIL_ABOVE + 0.03;
        let ends = [side * (HALF_WIDTH - 0.05), side * HALL_X];
        let across = ends.map(|x| DVec3::new(x, level, LANDING_Z - 0.06));
        pieces.push(sweep(&across, full, false));
        for (y, z) in [(0.0, FIRST_Z + 0.1), (LANDING_Y, LANDING_Z - 0.06)] {
            pieces.push(moved(&newel(parameters), [x, y, z]));
        }
    }
    merged(pieces)
}

fn newel(parameters: &Parameters) -> Mesh {
    merged([
        bevelled_box([-0.075, 0.0, -0.075], [0.075, 0.2, 0.075], 0.01),
        bevelled_box([-0.06, 0.2, -0.06], [0.06, 1.12, 0.06], 0.008),
        bevelled_box([-0.08, 1.12, -0.08], [0.08, 1.16, 0.08], 0.008),
        moved(
            &cylinder(0.035, 0.05, 0.005, parameters.steps(24)),
            [0.0, 1.15, 0.0],
        ),
        moved(&sphere(0.075, parameters.steps(36)), [0.0, 1.255, 0.0]),
    ])
}

/// Skirting boards along the hall and up the flight.
fn skirting(_: &Parameters) -> Mesh {
    let board = |side: f64, z: [f64; 2], y: f64| {
        let (a, b) = (side * (HALL_X - 0.022), side * HALL_X);
        merged([
            bevelled_box([a.min(b), y, z[0]], [a.max(b), y + 0.14, z[1]], 0.006),
            bevelled_box(
                [(a - side * 0.012).min(b), y, z[0]],
                [(a - side * 0.012).max(b), y + 0.03, z[1]],
                0.005,
            ),
        ])
    };
    let dado = |side: f64, z: [f64; 2], y: f64| {
        let (a, b) = (side * (HALL_X - 0.03), side * HALL_X);
        bevelled_box([a.min(b), y, z[0]], [a.max(b), y + 0.05, z[1]], 0.01)
    };
    let stringer = |side: f64| {
        let line = [[FIRST_Z + 0.05, 0.0], [LANDING_Z, LANDING_Y - RISE]]
            .map(|[z, y]| DVec3::new(side * (HALF_WIDTH + 0.015), y + 0.02, z));
        let section =
            [[-0.015, -0.1], [0.015, -0.1], [0.015, 0.13], [-0.015, 0.13]].map(DVec2::from);
        sweep(&line, &section, false)
    };
    merged([-1.0, 1.0].into_iter().flat_map(|side| {
        [
            board(side, [LANDING_Z, FRONT_Z], 0.0),
            board(side, [BACK_Z, LANDING_Z], LANDING_Y),
            dado(side, [BACK_Z, LANDING_Z], LANDING_Y + 0.9),
            stringer(side),
        ]
    }))
}

/// Frames, sills and glazing bars.
fn windows(_: &Parameters) -> Mesh {
    let frame = |[c, low, high, half]: [f64; 4]| {
        let bar = |x: [f64; 2], y: [f64; 2], z: [f64; 2]| {
            bevelled_box([x[0], y[0], z[0]], [x[1], y[1], z[1]], 0.004)
        };
        let (l, r) = (c - half, c + half);
        let mut pieces = vec![
            bar([l, l + 0.06], [low, high], [0.1, 0.17]),
            bar([r - 0.06, r], [low, high], [0.1, 0.17]),
            bar([l + 0.06, r - 0.06], [low, low + 0.07], [0.1, 0.17]),
            bar([l + 0.06, r - 0.06], [high - 0.06, high], [0.1, 0.17]),
            bar(
                [c - 0.025, c + 0.025],
                [low + 0.07, high - 0.06],
                [0.11, 0.16],
            ),
            bar([l - 0.08, r + 0.08], [low - 0.05, low], [0.17, 0.38]),
        ];
        for k in 1..5 {
            let y = low + (high - low) * f64::from(k) / 5.0;
            pieces.push(bar(
                [l + 0.06, r - 0.06],
                [y - 0.013, y + 0.013],
                [0.12, 0.15],
            ));
        }
        for x in [c - half * 0.5, c + half * 0.5] {
            pieces.push(bar(
                [x - 0.013, x + 0.013],
                [low + 0.07, high - 0.06],
                [0.122, 0.148],
            ));
        }
        merged(pieces)
    };
    side_wall(&merged(WINDOWS.map(frame)), false)
}

fn near_figure(parameters: &Parameters) -> Mesh {
    let body = seated(parameters.cell(0.0115));
    set_at(&body, [0.66, 0.798, 0.3], -10.0, 0.52)
}

fn far_figure(parameters: &Parameters) -> Mesh {
    let body = seated(parameters.cell(0.016));
    set_at(&body, [0.0, LANDING_Y + 0.548, BACK_Z + 0.15], 0.0, 0.95)
}

fn pedestals(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(56);
    let near = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.36, 0.0],
                [0.36, 0.05],
                [0.27, 0.09],
                [0.24, 0.14],
                [0.2, 0.4],
                [0.24, 0.68],
                [0.33, 0.735],
                [0.385, 0.75],
                [0.39, 0.78],
                [0.38, 0.8],
                [0.0, 0.8],
            ],
            parameters.steps(5),
        ),
        round,
    );
    let tier = |half: f64, y: [f64; 2]| {
        let z = BACK_Z + 0.15;
        bevelled_box(
            [-half, LANDING_Y + y[0], z - half.min(0.6)],
            [half, LANDING_Y + y[1], z + half],
            0.012,
        )
    };
    merged([
        moved(&near, [0.66, 0.0, 0.3]),
        tier(0.78, [0.0, 0.1]),
        tier(0.7, [0.1, 0.47]),
        tier(0.75, [0.47, 0.55]),
    ])
}

const LAMP_AT: [f64; 3] = [0.0, 4.1, -1.2];

/// A hanging lamp: rod, ring, six arms with cups.
fn lamp(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(40);
    let [x, y, z] = LAMP_AT;
    let rod = super::kit::capsule([0.0, 0.0, 0.0], [0.0, HEIGHT - y, 0.0], [0.012, 0.012], 14);
    let ring = super::kit::torus(0.38, 0.014, [round, 12]);
    let arms = (0..6).map(|k| {
        let path = super::kit::curve(
            &[
                [0.0, 0.0, 0.0],
                [0.15, -0.09, 0.0],
                [0.3, -0.06, 0.0],
                [0.38, 0.0, 0.0],
            ],
            parameters.steps(6),
        );
        let cup = lathe(
            &smooth_profile(
                &[
                    [0.0, 0.0],
                    [0.03, 0.0],
                    [0.06, 0.05],
                    [0.055, 0.05],
                    [0.0, 0.015],
                ],
                5,
            ),
            parameters.steps(24),
        );
        let arm = merged([
            super::kit::tube(&path, 0.009, 10),
            moved(&cup, [0.38, 0.0, 0.0]),
        ]);
        placed(&arm, DMat4::from_rotation_y(PI * f64::from(k) / 3.0))
    });
    let boss = sphere(0.05, parameters.steps(28));
    moved(
        &merged([rod, ring, boss].into_iter().chain(arms)),
        [x, y, z],
    )
}

fn lamp_glow(parameters: &Parameters) -> Mesh {
    let bulb = sphere(0.045, parameters.steps(24));
    let [x, y, z] = LAMP_AT;
    merged((0..6).map(|k| {
        let angle_rad = PI * f64::from(k) / 3.0;
        moved(
            &bulb,
            [
                x + 0.38 * angle_rad.cos(),
                y + 0.075,
                z - 0.38 * angle_rad.sin(),
            ],
        )
    }))
}

/// (z of the centre, y of the centre, half width, half height) on the right wall.
const PICTURES: [[f64; 4]; 4] = [
    [1.4, 1.75, 0.45, 0.6],
    [-0.4, 2.1, 0.35, 0.45],
    [-2.2, 2.9, 0.4, 0.55],
    [-6.6, 4.4, 0.6, 0.45],
];

fn pictures(_: &Parameters) -> Mesh {
    merged(PICTURES.map(|[z, y, half, tall]| {
        cuboid(
            [HALL_X - 0.015, y - tall, z - half],
            [HALL_X, y + tall, z + half],
        )
    }))
}

fn picture_frames(_: &Parameters) -> Mesh {
    merged(PICTURES.into_iter().flat_map(|[z, y, half, tall]| {
        let bar = |y: [f64; 2], z: [f64; 2]| {
            bevelled_box([HALL_X - 0.045, y[0], z[0]], [HALL_X, y[1], z[1]], 0.012)
        };
        let (w, h) = (half + 0.06, tall + 0.06);
        [
            bar([y - h, y - tall], [z - w, z + w]),
            bar([y + tall, y + h], [z - w, z + w]),
            bar([y - tall, y + tall], [z - w, z - half]),
            bar([y - tall, y + tall], [z + half, z + w]),
        ]
    }))
}
