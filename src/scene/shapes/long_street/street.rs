//! Road, pavements, poles, wires and lamps.

use glam::DVec3;

use super::{FACE_X, FAR_Z, KERB_X, NEAR_Z, PAVEMENT};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cuboid, curve, cylinder, jitter, lattice, merged, moved, shade, sphere,
    tube,
};

/// Wet asphalt, slightly uneven.
pub(super) fn road(parameters: &Parameters) -> Mesh {
    let (columns, rows) = (parameters.steps(16), parameters.steps(240));
    let surface = lattice([columns + 1, rows + 1], [false; 2], |i, j| {
        let x = (KERB_X + 0.1) * (2.0 * i as f64 / columns as f64 - 1.0);
        let z = NEAR_Z + (FAR_Z - 9.0 - NEAR_Z) * j as f64 / rows as f64;
        let key = 500_000 + (i * 4096 + j) as u64;
        let crown = 0.04 * (1.0 - (x / KERB_X).powi(2));
        DVec3::new(
            x,
            crown - 0.04 + jitter(parameters.seed, key, [0.0, 0.006]),
            z,
        )
    });
    shade(surface, 180.0)
}

/// Slabs and kerb stones.
pub(super) fn pavement(parameters: &Parameters) -> Mesh {
    let rows = ((NEAR_Z - FAR_Z) / 1.0).round() as usize;
    let [inner, outer] = [KERB_X + 0.22, FACE_X];
    merged([-1.0, 1.0].into_iter().flat_map(|side| {
        (0..rows).map(move |i| {
            let z = [NEAR_Z - i as f64 - 1.0, NEAR_Z - i as f64];
            let slab = |x: [f64; 2], gap: f64, lift: f64| {
                let (a, b) = (side * x[0], side * x[1]);
                bevelled_box(
                    [a.min(b) + gap, -0.1, z[0] + gap],
                    [a.max(b) - gap, PAVEMENT + lift, z[1] - gap],
                    0.008,
                )
            };
            let key = 600_000 + i as u64 * 4 + u64::from(side > 0.0);
            let lift = jitter(parameters.seed, key, [-0.004, 0.004]);
            let middle = (inner + outer) * 0.5;
            merged([
                slab([KERB_X, KERB_X + 0.21], 0.003, 0.012),
                slab([inner, middle], 0.004, lift),
                slab([middle, outer], 0.004, -lift),
            ])
        })
    }))
}

/// Worn lines along the kerbs, a crossing near the start, drain covers.
pub(super) fn marks(parameters: &Parameters) -> Mesh {
    let crossing = (0..8).map(|i| {
        let x = -3.15 + 0.84 * f64::from(i);
        cuboid([x, -0.1, -6.4], [x + 0.45, 0.01, -4.0])
    });
    let dashes = (0..42).map(|i| {
        let z = -10.0 - 4.5 * f64::from(i);
        cuboid([-0.06, -0.1, z - 1.8], [0.06, 0.012, z])
    });
    let covers = (0..12).map(|i| {
        let x = if i % 2 == 0 { 1.5 } else { -1.7 };
        let disc = cylinder(0.33, 0.1, 0.005, parameters.steps(28));
        moved(&disc, [x, -0.08, -2.0 - 16.0 * f64::from(i)])
    });
    merged(crossing.chain(dashes).chain(covers))
}

const POLE_PITCH: f64 = 21.0;
const POLES: usize = 10;

/// (x, z) of a pole; they stand on the two sides in turn.
fn pole_at(i: usize) -> [f64; 2] {
    let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    [side * (KERB_X + 0.45), -3.0 - POLE_PITCH * i as f64]
}

/// Poles with cross-arms, transformers and the arms of the street lamps.
pub(super) fn poles(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(14);
    merged((0..POLES).map(|i| {
        let [x, z] = pole_at(i);
        let inwards = -x.signum();
        let arm = curve(
            &[
                [x, 4.6, z],
                [x + inwards * 0.3, 5.1, z],
                [x + inwards * 1.3, 5.25, z],
            ],
            parameters.steps(6),
        );
        let cross = |y: f64, half: f64| {
            bevelled_box([x - half, y, z - 0.05], [x + half, y + 0.1, z + 0.05], 0.01)
        };
        let insulators = [-0.8, -0.4, 0.4, 0.8].map(|dx| {
            let foot = [x + dx, 8.35, z];
            capsule(foot, [x + dx, 8.52, z], [0.035, 0.025], round)
        });
        let can = moved(&cylinder(0.24, 0.7, 0.03, round), [x + 0.36, 6.7, z]);
        let shade = moved(
            &cylinder(0.2, 0.1, 0.03, round),
            [x + inwards * 1.3, 5.17, z],
        );
        let mast = capsule([x, 0.0, z], [x, 8.8, z], [0.14, 0.1], round);
        merged(
            [
                mast,
                tube(&arm, 0.035, round),
                cross(8.3, 0.95),
                cross(7.7, 0.7),
                can,
                shade,
            ]
            .into_iter()
            .chain(insulators),
        )
    }))
}

/// Wires from pole to pole and from the poles to the houses.
pub(super) fn wires(parameters: &Parameters) -> Mesh {
    let hang = |from: [f64; 3], to: [f64; 3], drop: f64| {
        let (a, b) = (DVec3::from(from), DVec3::from(to));
        let line: Vec<DVec3> = (0..=14)
            .map(|i| f64::from(i) / 14.0)
            .map(|t| a.lerp(b, t) - DVec3::Y * (4.0 * drop * t * (1.0 - t)))
            .collect();
        tube(&line, 0.012, 5)
    };
    let mut pieces = Vec::new();
    for i in 0..POLES {
        let [x, z] = pole_at(i);
        if i + 1 < POLES {
            let [to_x, to_z] = pole_at(i + 1);
            for dx in [-0.8, -0.4, 0.4, 0.8] {
                pieces.push(hang([x + dx, 8.52, z], [to_x + dx, 8.52, to_z], 0.7));
            }
            pieces.push(hang([x, 7.72, z], [to_x, 7.72, to_z], 1.1));
        }
        for k in 0..5u64 {
            let random =
                |n: u64, range| jitter(parameters.seed, 700_000 + i as u64 * 32 + k * 4 + n, range);
            let wall = [
                x.signum() * FACE_X * if k < 3 { 1.0 } else { -1.0 },
                random(0, [5.0, 8.0]),
                z + random(1, [-7.0, 7.0]),
            ];
            pieces.push(hang([x, 7.72, z], wall, random(2, [0.1, 0.5])));
        }
    }
    merged(pieces)
}

/// Globes under the arms of the poles.
pub(super) fn street_lamps(parameters: &Parameters) -> Mesh {
    let globe = sphere(0.14, parameters.steps(16));
    merged((0..POLES).map(|i| {
        let [x, z] = pole_at(i);
        moved(&globe, [x - x.signum() * 1.3, 5.05, z])
    }))
}
