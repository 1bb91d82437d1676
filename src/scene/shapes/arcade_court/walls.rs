//! Outer walls, doors, the gallery's floor and the roofs over it.

use std::f64::consts::PI;

use super::{AISLE, COURT, GALLERY, PITCH, SLAB, TOP, around, bays};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{bevelled_box, cuboid, cylinder, merged, moved, placed, sheet};
use glam::{DMat4, DVec3};

/// Half extents of the inside.
const INSIDE: [f64; 2] = [COURT[0] + AISLE, COURT[1] + AISLE];

pub(super) fn walls(_: &Parameters) -> Mesh {
    let [x, z] = INSIDE;
    let y = [-0.4, TOP + 0.3];
    let side = |s: f64| {
        let (a, b) = (s * x, s * (x + 0.4));
        cuboid([a.min(b), y[0], -z - 0.4], [a.max(b), y[1], z + 0.4])
    };
    let end = |s: f64| {
        let (a, b) = (s * z, s * (z + 0.4));
        cuboid([-x, y[0], a.min(b)], [x, y[1], a.max(b)])
    };
    // A dado along the lower walls and a frame for blind windows above.
    let trim = around(|count| {
        merged(bays(count).map(|x| {
            let half = PITCH * 0.5 - 0.19;
            let bar = |low: [f64; 2], high: [f64; 2], out: f64| {
                let z = [-AISLE - 0.05, -AISLE + out];
                bevelled_box([low[0], low[1], z[0]], [high[0], high[1], z[1]], 0.01)
            };
            let (l, r) = (x - 0.55, x + 0.55);
            let (low, high) = (GALLERY + 0.8, GALLERY + 2.5);
            merged([
                bar([x - half, 0.95], [x + half, 1.03], 0.04),
                bar([l - 0.1, low], [l, high], 0.06),
                bar([r, low], [r + 0.1, high], 0.06),
                bar([l - 0.16, low - 0.1], [r + 0.16, low], 0.1),
                bar([l - 0.16, high], [r + 0.16, high + 0.12], 0.1),
            ])
        }))
    });
    merged([side(-1.0), side(1.0), end(-1.0), end(1.0), trim])
}

/// Panelled doors in the middle of the short sides, and shutters in the frames above.
pub(super) fn doors(parameters: &Parameters) -> Mesh {
    let knob = placed(
        &cylinder(0.035, 0.05, 0.01, parameters.steps(18)),
        DMat4::from_rotation_x(PI * 0.5),
    );
    let panel = |low: [f64; 2], high: [f64; 2], out: f64| {
        let z = [-AISLE - 0.05, -AISLE + out];
        bevelled_box([low[0], low[1], z[0]], [high[0], high[1], z[1]], 0.012)
    };
    let leaf = |s: f64| {
        let x = |a: f64, b: f64| [(s * a).min(s * b), (s * a).max(s * b)];
        let [outer, inner] = [x(0.008, 0.72), x(0.12, 0.62)];
        let panels = [[0.2, 0.9], [1.1, 1.6], [1.75, 2.15]];
        let raised = panels.map(|[a, b]| panel([inner[0], a], [inner[1], b], 0.075));
        let grip = moved(&knob, [s * 0.07, 1.0, -AISLE + 0.055]);
        let flat = panel([outer[0], 0.01], [outer[1], 2.3], 0.06);
        merged([flat, grip].into_iter().chain(raised))
    };
    around(|count| {
        let shutters = bays(count).map(|x| {
            let (low, high) = (GALLERY + 0.8, GALLERY + 2.5);
            panel([x - 0.545, low + 0.005], [x + 0.545, high - 0.005], 0.025)
        });
        let entrance = if count == 3 {
            merged([leaf(-1.0), leaf(1.0)])
        } else {
            Mesh::default()
        };
        merged(shutters.chain([entrance]))
    })
}

/// A ring of four slabs over the aisles from `inner` metres before the columns to the walls.
fn ring(y: [f64; 2], inner: f64) -> Mesh {
    let [x, z] = INSIDE;
    let [cx, cz] = [COURT[0] - inner, COURT[1] - inner];
    let slab =
        |low: [f64; 2], high: [f64; 2]| cuboid([low[0], y[0], low[1]], [high[0], y[1], high[1]]);
    merged([
        slab([-x, -z], [-cx, z]),
        slab([cx, -z], [x, z]),
        slab([-cx, -z], [cx, -cz]),
        slab([-cx, cz], [cx, z]),
    ])
}

/// The gallery's floor with a moulding along the court.
pub(super) fn gallery(_: &Parameters) -> Mesh {
    let moulding = around(|count| {
        let half = PITCH * 0.5 * count as f64 - 0.36;
        merged(
            [(SLAB - 0.14, 0.3), (SLAB + 0.12, 0.41)]
                .map(|(y, out)| bevelled_box([-half, y, 0.2], [half, y + 0.12, out], 0.02)),
        )
    });
    merged([ring([SLAB, GALLERY], 0.36), moulding])
}

/// Ceiling and beams over the gallery, eaves, and tiles that fall towards the court.
pub(super) fn roof(parameters: &Parameters) -> Mesh {
    let beams = around(|count| {
        let half = PITCH * 0.5 * count as f64;
        let steps = count * 2;
        merged((0..=steps).map(|i| {
            let x = -half + PITCH * 0.5 * i as f64;
            let low = [x - 0.07, TOP - 0.2, -AISLE - 0.02];
            bevelled_box(low, [x + 0.07, TOP + 0.02, 0.0], 0.01)
        }))
    });
    let tiles = around(|count| {
        let half = PITCH * 0.5 * count as f64;
        let columns = parameters.steps(count * 24);
        sheet([columns, 4], 0.02, |u, v| {
            // Mitred where two roofs meet over a corner.
            let out = 0.55 - (AISLE + 0.55) * v;
            let x = (u - 0.5) * 2.0 * (half - out);
            let wave = 0.03 * (x * 24.0).cos();
            DVec3::new(x, TOP + 0.32 + 0.9 * v + wave, out)
        })
    });
    merged([ring([TOP, TOP + 0.2], 0.45), beams, tiles])
}
