//! A Cornell box with a torus knot on a pedestal and a sphere: curved bodies between flat walls.

use std::f64::consts::TAU;

use glam::DVec3;

use super::kit::{bevelled_box, circle, cuboid, merged, moved, rounded_box, set_at, sphere, sweep};
use super::{Parameters, PartFunction};
use crate::scene::Mesh;

pub const PARTS: &[(&str, PartFunction)] = &[
    ("shell", shell),
    ("left-wall", left_wall),
    ("right-wall", right_wall),
    ("knot", knot),
    ("ball", ball),
    ("plinths", plinths),
    ("lamp", lamp),
    ("lamp-frame", lamp_frame),
];

/// Inner size of the box: 2 m each way, its floor at y = 0, open towards +z.
const HALF: f64 = 1.0;
const THICK: f64 = 0.05;

fn shell(_: &Parameters) -> Mesh {
    let outer = HALF + THICK;
    merged([
        cuboid([-outer, -THICK, -outer], [outer, 0.0, HALF]),
        cuboid([-outer, 2.0, -outer], [outer, 2.0 + THICK, HALF]),
        cuboid([-HALF, 0.0, -outer], [HALF, 2.0, -HALF]),
    ])
}

fn left_wall(_: &Parameters) -> Mesh {
    cuboid([-HALF - THICK, 0.0, -HALF - THICK], [-HALF, 2.0, HALF])
}

fn right_wall(_: &Parameters) -> Mesh {
    cuboid([HALF, 0.0, -HALF - THICK], [HALF + THICK, 2.0, HALF])
}

/// A (2, 3) torus knot lying on the tall plinth.
fn knot(parameters: &Parameters) -> Mesh {
    let steps = parameters.steps(130);
    let path: Vec<DVec3> = (0..steps)
        .map(|i| {
            let t = TAU * i as f64 / steps as f64;
            let radius = 0.25 * (2.0 + (3.0 * t).cos()) / 2.0;
            DVec3::new(
                radius * (2.0 * t).cos(),
                0.13 * (3.0 * t).sin(),
                radius * (2.0 * t).sin(),
            )
        })
        .collect();
    let knot = sweep(&path, &circle(0.068, parameters.steps(16)), true);
    let standing = glam::DMat4::from_rotation_x(68f64.to_radians());
    let upright = super::kit::placed(&knot, standing);
    set_at(&upright, [-0.34, 0.98, -0.36], 24.0, 1.0)
}

fn ball(parameters: &Parameters) -> Mesh {
    moved(&sphere(0.3, parameters.steps(40)), [0.42, 0.56, 0.14])
}

fn plinths(parameters: &Parameters) -> Mesh {
    let tall = rounded_box([0.29, 0.29, 0.29], 0.03, parameters.steps(3));
    let low = bevelled_box([-0.27, 0.0, -0.27], [0.27, 0.26, 0.27], 0.012);
    merged([
        set_at(&tall, [-0.34, 0.29, -0.36], 18.0, 1.0),
        set_at(&low, [0.42, 0.0, 0.14], -17.0, 1.0),
    ])
}

/// The lamp's glowing underside, a thin plate.
fn lamp(_: &Parameters) -> Mesh {
    cuboid([-0.3, 1.975, -0.3], [0.3, 1.985, 0.2])
}

fn lamp_frame(_: &Parameters) -> Mesh {
    let bar = |x: [f64; 2], z: [f64; 2]| bevelled_box([x[0], 1.96, z[0]], [x[1], 2.0, z[1]], 0.006);
    merged([
        bar([-0.34, -0.3], [-0.34, 0.24]),
        bar([0.3, 0.34], [-0.34, 0.24]),
        bar([-0.3, 0.3], [-0.34, -0.3]),
        bar([-0.3, 0.3], [0.2, 0.24]),
    ])
}
