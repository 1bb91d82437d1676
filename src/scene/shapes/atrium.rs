//! A tiled courtyard between two-storeyed arcades, with hanging chains, curtains and vases.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3};

use super::kit::{
    CREASE_DEG, Opening, bevelled_box, cuboid, curve, cylinder, jitter, lathe, lattice, merged,
    moved, placed, set_at, shade, sheet, smooth_profile, strip_solid, sweep, torus, wall,
};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("light-tiles", light_tiles),
    ("dark-tiles", dark_tiles),
    ("slab", slab),
    ("walls", walls),
    ("columns", columns),
    ("arches", arches),
    ("cornices", cornices),
    ("red-curtains", red_curtains),
    ("blue-curtains", blue_curtains),
    ("rails", rails),
    ("chains", chains),
    ("lanterns", lanterns),
    ("flames", flames),
    ("vases", vases),
];

/// Columns stand at x = ±3 every 2.6 m from z = 2 to z = -21.4; the aisles reach to x = ±5.4.
const ROW_X: f64 = 3.0;
const PITCH: f64 = 2.6;
const BAYS: usize = 9;
const FIRST_Z: f64 = 2.0;
const WALL_X: f64 = 5.4;
const FRONT_Z: f64 = 4.6;
const BACK_Z: f64 = -24.0;
/// Height of the springing line, of the gallery floor and of the wall's top.
const SPRING: f64 = 3.1;
const GALLERY: f64 = 4.9;
const TOP: f64 = 9.4;

fn column_z(i: usize) -> f64 {
    FIRST_Z - PITCH * i as f64
}

fn tiles(parameters: &Parameters, odd: bool) -> Mesh {
    let size = 0.6;
    let columns = (WALL_X * 2.0 / size).round() as i64;
    let rows = ((FRONT_Z - BACK_Z) / size).round() as i64;
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    merged(
        all.filter(|(i, j)| ((i + j) % 2 == 1) == odd)
            .map(|(i, j)| {
                let (x, z) = (-WALL_X + i as f64 * size, FRONT_Z - j as f64 * size);
                let lift = jitter(parameters.seed, (i * 4096 + j) as u64, [-0.0015, 0.0015]);
                let gap = 0.004;
                bevelled_box(
                    [x + gap, -0.03, z - size + gap],
                    [x + size - gap, lift, z - gap],
                    0.004,
                )
            }),
    )
}

fn light_tiles(parameters: &Parameters) -> Mesh {
    tiles(parameters, false)
}

fn dark_tiles(parameters: &Parameters) -> Mesh {
    tiles(parameters, true)
}

/// The grout bed under the tiles and the gallery floors.
fn slab(_: &Parameters) -> Mesh {
    let gallery = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.35), side * WALL_X);
        cuboid(
            [a.min(b), GALLERY - 0.3, BACK_Z],
            [a.max(b), GALLERY, FRONT_Z],
        )
    };
    merged([
        cuboid([-WALL_X, -0.3, BACK_Z], [WALL_X, -0.008, FRONT_Z]),
        gallery(-1.0),
        gallery(1.0),
    ])
}

/// Outer walls with windows, and roofs over the aisles; the court is open to the sky.
fn walls(_: &Parameters) -> Mesh {
    let length = FRONT_Z - BACK_Z;
    let window = |centre: f64, low: f64, high: f64, half: f64| Opening {
        min: [centre - half, low],
        max: [centre + half, high],
    };
    let openings: Vec<Opening> = (0..BAYS)
        .map(|i| FRONT_Z - (column_z(i) - PITCH * 0.5))
        .map(|along| window(along, 6.0, 8.0, 0.5))
        .collect();
    // A wall runs along +x with its front towards +z; the side walls are turned to face the court.
    let long = wall([length, TOP], 0.4, &openings);
    let right = placed(
        &long,
        DMat4::from_translation(DVec3::new(WALL_X + 0.4, 0.0, FRONT_Z - length))
            * DMat4::from_rotation_y(-PI * 0.5),
    );
    let left = placed(
        &long,
        DMat4::from_translation(DVec3::new(-WALL_X - 0.4, 0.0, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    let door = [window(WALL_X, 0.0, 3.0, 1.1), window(WALL_X, 5.6, 8.2, 0.9)];
    let end = wall([WALL_X * 2.0, TOP], 0.4, &door);
    let back = moved(&end, [-WALL_X, 0.0, BACK_Z - 0.4]);
    let front = moved(&end, [-WALL_X, 0.0, FRONT_Z]);
    let outside = cuboid([-2.5, -0.3, BACK_Z - 6.0], [2.5, -0.008, BACK_Z]);
    let roof = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.4), side * (WALL_X + 0.6));
        let z = [BACK_Z - 0.4, FRONT_Z + 0.4];
        bevelled_box([a.min(b), TOP, z[0]], [a.max(b), TOP + 0.25, z[1]], 0.04)
    };
    merged([right, left, back, front, outside, roof(-1.0), roof(1.0)])
}

/// A fluted shaft of unit height with entasis.
fn fluted(radius: f64, flutes: usize, rows: usize, per_flute: usize) -> Mesh {
    let around = flutes * per_flute;
    let mesh = lattice([rows + 1, around], [false, true], |i, j| {
        let t = i as f64 / rows as f64;
        let angle_rad = TAU * j as f64 / around as f64;
        let groove = (j % per_flute) as f64 / per_flute as f64;
        let depth = (PI * groove).sin().powf(0.7) * 0.075 * radius;
        let r = radius * (1.0 - 0.16 * t * t) - depth;
        DVec3::new(r * angle_rad.cos(), t, r * angle_rad.sin())
    });
    shade(mesh, CREASE_DEG)
}

/// Base, fluted shaft, capital with leaves and abacus.
fn column(parameters: &Parameters, radius: f64, height: f64) -> Mesh {
    let round = parameters.steps(30);
    let base = lathe(
        &smooth_profile(
            &[
                [0.0, 0.12],
                [1.42, 0.12],
                [1.5, 0.2],
                [1.42, 0.3],
                [1.2, 0.34],
                [1.16, 0.42],
                [1.28, 0.48],
                [1.26, 0.54],
                [1.05, 0.6],
                [0.0, 0.6],
            ]
            .map(|[r, y]| [r * radius, y * 0.5]),
            parameters.steps(4),
        ),
        round,
    );
    let plinth = bevelled_box(
        [-1.5 * radius, 0.0, -1.5 * radius],
        [1.5 * radius, 0.07, 1.5 * radius],
        0.01,
    );
    let (foot, cap) = (0.28, 0.5);
    let shaft = fluted(radius, 20, parameters.steps(6), parameters.steps(5));
    let shaft = placed(
        &shaft,
        DMat4::from_translation(DVec3::new(0.0, foot, 0.0))
            * DMat4::from_scale(DVec3::new(1.0, height - foot - cap + 0.02, 1.0)),
    );
    let bell = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [1.0, 0.0],
                [1.06, 0.03],
                [0.98, 0.06],
                [0.9, 0.12],
                [1.0, 0.3],
                [1.36, 0.43],
                [0.0, 0.43],
            ]
            .map(|[r, y]| [r * radius * 0.9, y]),
            parameters.steps(4),
        ),
        round,
    );
    let abacus = bevelled_box(
        [-1.42 * radius, 0.42, -1.42 * radius],
        [1.42 * radius, 0.5, 1.42 * radius],
        0.015,
    );
    let leaves = merged(
        (0..2)
            .flat_map(|row| (0..8).map(move |k| (row, k)))
            .map(|(row, k)| leaf(parameters, radius, row, k)),
    );
    let capital = moved(&merged([bell, abacus, leaves]), [0.0, height - cap, 0.0]);
    merged([plinth, base, shaft, capital])
}

/// One curling leaf of a capital.
fn leaf(parameters: &Parameters, radius: f64, row: usize, k: usize) -> Mesh {
    let low = 0.08 + 0.1 * row as f64;
    let tall = 0.17 + 0.04 * row as f64;
    let turn_rad = TAU * (k as f64 + 0.5 * row as f64) / 8.0;
    let blade = sheet([parameters.steps(5), parameters.steps(8)], 0.008, |u, v| {
        let width = radius * 0.34 * (1.0 - 0.75 * v.powi(3)) * (1.0 + 0.12 * (v * 22.0).sin());
        let across = (u - 0.5) * 2.0;
        let curl = (v - 0.72).max(0.0);
        let out = radius * (0.86 + 0.2 * v + 0.09 * row as f64) + 1.6 * curl * radius
            - 0.012 * across.abs();
        DVec3::new(
            across * width,
            low + tall * v - 2.2 * tall * curl * curl * 2.0,
            out,
        )
    });
    placed(&blade, DMat4::from_rotation_y(turn_rad))
}

fn columns(parameters: &Parameters) -> Mesh {
    let lower = column(parameters, 0.25, SPRING);
    let coarse = Parameters {
        detail: parameters.detail * 0.55,
        ..*parameters
    };
    let upper = column(&coarse, 0.13, 2.6);
    let mut pieces = Vec::new();
    for i in 0..=BAYS {
        for side in [-1.0, 1.0] {
            let z = column_z(i);
            pieces.push(moved(&lower, [side * ROW_X, 0.0, z]));
            pieces.push(moved(&upper, [side * ROW_X, GALLERY + 0.24, z]));
        }
    }
    merged(pieces)
}

/// The arch of one bay, `width` between the springing points, under a straight top.
fn arch(parameters: &Parameters, size: [f64; 4]) -> Mesh {
    let [width, pier, height, thickness] = size;
    let steps = parameters.steps(26);
    let half = width * 0.5;
    let mut lower = vec![DVec2::new(-half - pier, 0.0)];
    lower.extend((0..=steps).map(|i| {
        let angle_rad = PI * (1.0 - i as f64 / steps as f64);
        DVec2::new(angle_rad.cos() * half, (angle_rad.sin() * half).max(0.0))
    }));
    lower.push(DVec2::new(half + pier, 0.0));
    let upper: Vec<DVec2> = lower.iter().map(|p| DVec2::new(p.x, height)).collect();
    let body = moved(
        &strip_solid(&lower, &upper, thickness),
        [0.0, 0.0, -thickness * 0.5],
    );
    let path: Vec<DVec3> = (0..=steps)
        .map(|i| {
            let angle_rad = PI * (1.0 - i as f64 / steps as f64);
            let r = half + 0.09;
            DVec3::new(angle_rad.cos() * r, (angle_rad.sin() * r).max(0.0), 0.0)
        })
        .collect();
    let section = [[-0.05, -0.5], [0.05, -0.5], [0.05, 0.5], [-0.05, 0.5]]
        .map(|[a, b]| DVec2::new(b * (thickness + 0.08), -a));
    merged([body, sweep(&path, &section, false)])
}

fn arches(parameters: &Parameters) -> Mesh {
    let turn = PI * 0.5;
    let lower = arch(
        parameters,
        [PITCH - 0.56, 0.28, GALLERY - 0.3 - SPRING, 0.5],
    );
    let upper_spring = GALLERY + 0.24 + 2.6;
    let upper = arch(parameters, [PITCH - 0.3, 0.15, TOP - upper_spring, 0.3]);
    let mut pieces = Vec::new();
    for i in 0..BAYS {
        let z = column_z(i) - PITCH * 0.5;
        for side in [-1.0, 1.0] {
            let place = |y: f64| {
                DMat4::from_translation(DVec3::new(side * ROW_X, y, z))
                    * DMat4::from_rotation_y(turn)
            };
            pieces.push(placed(&lower, place(SPRING)));
            pieces.push(placed(&upper, place(upper_spring)));
        }
    }
    merged(pieces)
}

/// Mouldings along the court, the gallery's kerb and the heads of the side walls.
fn cornices(_: &Parameters) -> Mesh {
    let section = [
        [0.0, -0.2],
        [0.1, -0.2],
        [0.14, -0.12],
        [0.2, -0.08],
        [0.24, 0.0],
        [0.24, 0.06],
        [0.0, 0.06],
    ];
    let run = |x: f64, y: f64, side: f64| {
        // Towards the court: left of the path for the right-hand side.
        let points = section.map(|[a, b]| DVec2::new(a, b));
        let (from, to) = if side > 0.0 {
            (FRONT_Z, BACK_Z)
        } else {
            (BACK_Z, FRONT_Z)
        };
        sweep(
            &[DVec3::new(x, y, from), DVec3::new(x, y, to)],
            &points,
            false,
        )
    };
    let kerb = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.2), side * (ROW_X + 0.2));
        bevelled_box(
            [a.min(b), GALLERY, BACK_Z],
            [a.max(b), GALLERY + 0.25, FRONT_Z],
            0.02,
        )
    };
    merged([-1.0, 1.0].into_iter().flat_map(|side| {
        [
            run(side * (ROW_X - 0.35), GALLERY - 0.06, side),
            run(side * (ROW_X - 0.4), TOP + 0.2, side),
            run(side * WALL_X, SPRING + 0.4, side),
            kerb(side),
        ]
    }))
}

/// A curtain drawn to one side of a bay: pleated at the rail, gathered by a tie, loose at the hem.
fn curtain(parameters: &Parameters, key: u64) -> Mesh {
    let width = 0.95;
    let drop = 2.15;
    let phase = jitter(parameters.seed, key, [0.0, TAU]);
    let pleats = 7.0;
    sheet(
        [parameters.steps(72), parameters.steps(18)],
        0.002,
        |u, v| {
            // v = 0 at the hem.
            let gather = (-((v - 0.42) / 0.16).powi(2)).exp();
            let spread = 1.0 - 0.45 * gather;
            let bend = 0.25 * (TAU * u + phase).sin() * (1.0 - v);
            let depth = (0.035 + 0.03 * (1.0 - v)) * (1.0 - 0.4 * gather);
            let wave = (TAU * pleats * u + phase + bend).sin()
                + 0.15 * (TAU * pleats * 2.0 * u + 2.0 * phase).sin() * (1.0 - v);
            let sag = 0.02 * (TAU * pleats * u).cos().powi(2) * v.powi(24);
            DVec3::new(
                width * (u * spread) - 0.08 * gather * (1.0 - u),
                drop * v - sag,
                depth * wave,
            )
        },
    )
}

fn curtains(parameters: &Parameters, red: bool) -> Mesh {
    let bays = (0..BAYS).filter(|i| (i % 2 == 0) == red);
    merged(bays.flat_map(|i| {
        let z = column_z(i) - PITCH * 0.5;
        [-1.0, 1.0].map(|side| {
            let base = curtain(parameters, i as u64 * 2 + u64::from(side > 0.0));
            let left = moved(&base, [-1.04, 0.0, 0.0]);
            let right = placed(&left, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
            let both = merged([left, right]);
            placed(
                &both,
                DMat4::from_translation(DVec3::new(side * (ROW_X + 0.36), 0.9, z))
                    * DMat4::from_rotation_y(PI * 0.5),
            )
        })
    }))
}

fn red_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, true)
}

fn blue_curtains(parameters: &Parameters) -> Mesh {
    curtains(parameters, false)
}

/// Curtain rods with knobs, and the gallery's railing.
fn rails(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(14);
    let knob = super::kit::sphere(0.035, round);
    let bar = |from: [f64; 3], to: [f64; 3], r: f64| super::kit::capsule(from, to, [r, r], round);
    let mut pieces = Vec::new();
    for side in [-1.0, 1.0] {
        for i in 0..BAYS {
            let (x, z) = (side * (ROW_X + 0.36), column_z(i) - PITCH * 0.5);
            pieces.push(bar([x, 3.07, z - 1.12], [x, 3.07, z + 1.12], 0.016));
            pieces.push(moved(&knob, [x, 3.07, z - 1.14]));
            pieces.push(moved(&knob, [x, 3.07, z + 1.14]));
            let bars = 11;
            for k in 1..bars {
                let at = z + (f64::from(k) / f64::from(bars) - 0.5) * PITCH;
                let (x, y) = (side * ROW_X, GALLERY + 0.24);
                pieces.push(bar([x, y, at], [x, y + 0.75, at], 0.012));
            }
        }
        let (x, y) = (side * ROW_X, GALLERY + 1.0);
        pieces.push(bar([x, y, column_z(BAYS)], [x, y, column_z(0)], 0.028));
    }
    merged(pieces)
}

/// Where lanterns hang, and how deep: (x, y of the hook, z, links).
const HANGING: [[f64; 4]; 5] = [
    [-0.85, 6.6, -0.4, 46.0],
    [1.3, 6.9, -3.2, 50.0],
    [-1.2, 6.9, -8.4, 50.0],
    [1.2, 6.9, -13.6, 50.0],
    [0.0, 6.9, -19.0, 46.0],
];
const LINK: f64 = 0.068;

/// Links that alternate by a quarter turn, straight down from iron beams.
fn chains(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(8);
    let path: Vec<DVec3> = (0..2 * steps)
        .map(|i| {
            let angle_rad = PI * (i as f64 + 0.5) / steps as f64;
            let (s, c) = angle_rad.sin_cos();
            DVec3::new(0.026 * c, 0.018 * s.signum() + 0.026 * s, 0.0)
        })
        .collect();
    let link = sweep(
        &path,
        &super::kit::circle(0.0085, parameters.steps(8)),
        true,
    );
    let mut pieces = Vec::new();
    for [x, y, z, count] in HANGING {
        for i in 0..count as usize {
            let turn_deg = if i % 2 == 0 { 20.0 } else { 110.0 };
            pieces.push(set_at(&link, [x, y - LINK * i as f64, z], turn_deg, 1.0));
        }
        let (reach, high) = (ROW_X + 0.05, y + 0.03);
        pieces.push(bevelled_box(
            [-reach, high, z - 0.04],
            [reach, high + 0.1, z + 0.04],
            0.01,
        ));
    }
    pieces.push(swag(&link, column_z(0) - PITCH, 4.3));
    pieces.push(swag(&link, column_z(0) - 3.0 * PITCH, 4.3));
    merged(pieces)
}

/// A heavy chain that sags across the court at `z` between hooks on the columns at height `y`.
fn swag(link: &Mesh, z: f64, y: f64) -> Mesh {
    let scale = 2.0;
    let pitch = LINK * scale;
    let reach = ROW_X - 0.3;
    // A catenary y = a cosh(x / a), walked by arc length.
    let a = 3.4;
    let total = 2.0 * a * (reach / a).sinh();
    let count = (total / pitch).round() as usize;
    merged((0..=count).map(|i| {
        let along = (i as f64 / count as f64 - 0.5) * total;
        let x = a * (along / a).asinh();
        let drop = a * ((x / a).cosh() - (reach / a).cosh());
        let tangent = DVec3::new(1.0, (x / a).sinh(), 0.0);
        let turn_rad = if i % 2 == 0 { 0.3 } else { 0.3 + PI * 0.5 };
        placed(
            link,
            DMat4::from_translation(DVec3::new(x, y + drop, z))
                * super::kit::y_towards(tangent)
                * DMat4::from_rotation_y(turn_rad)
                * DMat4::from_scale(DVec3::splat(scale)),
        )
    }))
}

fn lantern_spots() -> impl Iterator<Item = [f64; 3]> {
    HANGING
        .into_iter()
        .map(|[x, y, z, count]| [x, y - LINK * (count - 1.0) - 0.04, z])
}

/// Cages of bent bars between two dishes.
fn lanterns(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(30);
    let roof = lathe(
        &smooth_profile(
            &[
                [0.0, -0.14],
                [0.16, -0.14],
                [0.17, -0.125],
                [0.05, -0.05],
                [0.02, -0.02],
                [0.0, -0.01],
            ],
            parameters.steps(4),
        ),
        round,
    );
    let dish = lathe(
        &smooth_profile(
            &[
                [0.0, -0.56],
                [0.06, -0.55],
                [0.13, -0.5],
                [0.13, -0.485],
                [0.0, -0.49],
            ],
            4,
        ),
        round,
    );
    let rib = curve(
        &[
            [0.14, -0.13, 0.0],
            [0.18, -0.25, 0.0],
            [0.165, -0.4, 0.0],
            [0.12, -0.5, 0.0],
        ],
        parameters.steps(5),
    );
    let bars = (0..8).map(|k| {
        let bar = super::kit::tube(&rib, 0.007, 8);
        placed(&bar, DMat4::from_rotation_y(TAU * f64::from(k) / 8.0))
    });
    let hoop = moved(&torus(0.183, 0.007, [round, 8]), [0.0, -0.28, 0.0]);
    let whole = merged([roof, dish, hoop].into_iter().chain(bars));
    merged(lantern_spots().map(|at| moved(&whole, at)))
}

fn flames(parameters: &Parameters) -> Mesh {
    let drop = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.045, 0.03],
                [0.05, 0.08],
                [0.02, 0.16],
                [0.0, 0.2],
            ],
            5,
        ),
        parameters.steps(24),
    );
    merged(lantern_spots().map(|[x, y, z]| moved(&drop, [x, y - 0.48, z])))
}

/// Large jars along both rows and two tall ones near the camera.
fn vases(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(40);
    let smooth = parameters.steps(4);
    let jar = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.16, 0.0],
                [0.17, 0.02],
                [0.28, 0.25],
                [0.3, 0.42],
                [0.2, 0.62],
                [0.13, 0.7],
                [0.17, 0.78],
                [0.16, 0.785],
                [0.11, 0.7],
                [0.17, 0.6],
                [0.0, 0.3],
            ],
            smooth,
        ),
        round,
    );
    let ear = super::kit::tube(
        &curve(
            &[
                [0.13, 0.72, 0.0],
                [0.26, 0.76, 0.0],
                [0.33, 0.66, 0.0],
                [0.27, 0.52, 0.0],
                [0.22, 0.5, 0.0],
            ],
            parameters.steps(7),
        ),
        0.02,
        parameters.steps(12),
    );
    let other = placed(&ear, DMat4::from_rotation_y(PI));
    let band = moved(&torus(0.297, 0.012, [round, 10]), [0.0, 0.42, 0.0]);
    let jar = merged([jar, ear, other, band]);
    let stand = cylinder(0.3, 0.14, 0.02, round);
    let whole = merged([stand, moved(&jar, [0.0, 0.14, 0.0])]);
    let mut pieces = vec![
        set_at(&whole, [1.65, 0.0, 0.35], 35.0, 1.25),
        set_at(&whole, [-1.75, 0.0, -2.3], -20.0, 1.0),
    ];
    for i in 1..=BAYS {
        for side in [-1.0, 1.0] {
            if (i + usize::from(side > 0.0)) % 2 == 0 {
                let at = [side * (ROW_X - 0.75), 0.0, column_z(i)];
                pieces.push(set_at(&whole, at, 30.0 * i as f64, 0.8));
            }
        }
    }
    merged(pieces)
}
