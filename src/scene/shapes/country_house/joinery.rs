//! Windows, shutters, the open door and the curtains of the second room.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};

use super::{DOOR_TOP, DOOR_X, FRONT_Z, HOUSE_Z, WINDOW_Y, WINDOWS_X};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cylinder, merged, moved, placed, set_at, sheet, torus,
};

fn bar(x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Mesh {
    bevelled_box([x[0], y[0], z[0]], [x[1], y[1], z[1]], 0.004)
}

/// z of the window frames within the wall.
const FRAME_Z: [f64; 2] = [FRONT_Z + 0.1, FRONT_Z + 0.16];

/// Casements with glazing bars, their outer sills, and the frame of the door.
pub(super) fn window_frames(_: &Parameters) -> Mesh {
    let casement = |[l, r]: [f64; 2]| {
        let [low, high] = WINDOW_Y;
        let (middle, z) = ((l + r) * 0.5, FRAME_Z);
        let mut pieces = vec![
            bar([l, l + 0.06], [low, high], z),
            bar([r - 0.06, r], [low, high], z),
            bar([l + 0.06, r - 0.06], [low, low + 0.06], z),
            bar([l + 0.06, r - 0.06], [high - 0.06, high], z),
            bar([middle - 0.04, middle + 0.04], [low + 0.06, high - 0.06], z),
            bar(
                [l - 0.1, r + 0.1],
                [low - 0.06, low - 0.001],
                [z[1], z[1] + 0.2],
            ),
            bar(
                [l - 0.05, r + 0.05],
                [low - 0.04, low - 0.001],
                [FRONT_Z - 0.1, z[0]],
            ),
        ];
        let thin = [z[0] + 0.015, z[1] - 0.015];
        for t in [0.36, 0.68] {
            let y = low + (high - low) * t;
            pieces.push(bar([l + 0.06, middle - 0.04], [y - 0.012, y + 0.012], thin));
            pieces.push(bar([middle + 0.04, r - 0.06], [y - 0.012, y + 0.012], thin));
        }
        merged(pieces)
    };
    let [l, r] = DOOR_X;
    let z = [FRONT_Z + 0.03, HOUSE_Z[1] + 0.025];
    let door = [
        bar([l - 0.09, l + 0.02], [0.012, DOOR_TOP + 0.09], z),
        bar([r - 0.02, r + 0.09], [0.012, DOOR_TOP + 0.09], z),
        bar([l + 0.02, r - 0.02], [DOOR_TOP - 0.02, DOOR_TOP + 0.09], z),
    ];
    merged(WINDOWS_X.map(casement).into_iter().chain(door))
}

/// Glass in the windows of the second room; the kitchen's stand open, for the sun to come in.
pub(super) fn window_panes(_: &Parameters) -> Mesh {
    let z = (FRAME_Z[0] + FRAME_Z[1]) * 0.5;
    let [low, high] = WINDOW_Y;
    merged(WINDOWS_X[1..].iter().map(|&[l, r]| {
        let corners = [[l, low], [r, low], [r, high], [l, high]];
        pane(corners.map(|[x, y]| DVec3::new(x, y, z)))
    }))
}

/// A flat pane of one side.
fn pane(corners: [DVec3; 4]) -> Mesh {
    Mesh {
        positions: corners.to_vec(),
        normals: vec![glam::Vec3::Z; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Louvred shutters that stand open beside the windows.
pub(super) fn shutters(_: &Parameters) -> Mesh {
    let z = HOUSE_Z[1] + 0.012;
    let leaf = |x: [f64; 2]| {
        let [low, high] = [WINDOW_Y[0] - 0.03, WINDOW_Y[1] + 0.03];
        let depth = [z, z + 0.035];
        let mut pieces = vec![
            bar([x[0], x[0] + 0.05], [low, high], depth),
            bar([x[1] - 0.05, x[1]], [low, high], depth),
        ];
        for (y0, y1) in [(low, low + 0.07), (1.5, 1.56), (high - 0.07, high)] {
            pieces.push(bar([x[0] + 0.05, x[1] - 0.05], [y0, y1], depth));
        }
        let slat = placed(
            &bar(
                [x[0] + 0.045, x[1] - 0.045],
                [-0.022, 0.022],
                [-0.004, 0.004],
            ),
            DMat4::from_rotation_x(-0.7),
        );
        for i in 0..28 {
            let y = low + 0.1 + (high - low - 0.2) * f64::from(i) / 27.0;
            pieces.push(moved(&slat, [0.0, y, z + 0.018]));
        }
        merged(pieces)
    };
    merged(WINDOWS_X.into_iter().flat_map(|[l, r]| {
        let width = 0.46;
        [
            leaf([l - width - 0.02, l - 0.02]),
            leaf([r + 0.02, r + width + 0.02]),
        ]
    }))
}

/// Where the door hangs and how far it stands open into the kitchen.
fn hinge() -> DMat4 {
    DMat4::from_translation(DVec3::new(DOOR_X[1] - 0.03, 0.0, FRONT_Z + 0.02))
        * DMat4::from_rotation_y(-(98f64.to_radians()))
}

/// A panelled door; it reaches from its hinge towards -x when closed.
pub(super) fn door(_: &Parameters) -> Mesh {
    let width = DOOR_X[1] - DOOR_X[0] - 0.06;
    let leaf = bevelled_box([-width, 0.016, -0.045], [0.0, DOOR_TOP - 0.025, 0.0], 0.003);
    let panels = [[0.2, 0.85], [1.0, 1.45], [1.55, 2.0]].map(|[low, high]| {
        merged([-1.0, 1.0].map(|side| {
            let middle = -width * 0.5;
            let x = [middle + side * 0.05, middle + side * (width * 0.5 - 0.1)];
            bevelled_box(
                [x[0].min(x[1]), low, -0.053],
                [x[0].max(x[1]), high, 0.008],
                0.012,
            )
        }))
    });
    let panels = panels.into_iter();
    placed(&merged([leaf].into_iter().chain(panels)), hinge())
}

/// A lever on either side, a knocker and the hinges.
pub(super) fn door_handle(parameters: &Parameters) -> Mesh {
    let round = parameters.steps(16);
    let x = -(DOOR_X[1] - DOOR_X[0] - 0.06) + 0.07;
    let lever = |side: f64| {
        let z = if side > 0.0 { 0.0 } else { -0.045 };
        let end = z + side * 0.05;
        merged([
            capsule([x, 1.02, z], [x, 1.02, end], [0.009, 0.009], round),
            capsule([x, 1.02, end], [x + 0.12, 1.02, end], [0.009, 0.008], round),
        ])
    };
    let ring = placed(
        &torus(0.05, 0.008, [parameters.steps(32), 10]),
        DMat4::from_translation(DVec3::new(-0.47, 1.46, 0.017)) * DMat4::from_rotation_x(PI * 0.5),
    );
    let pins = [0.3, 1.8].map(|y| moved(&cylinder(0.012, 0.1, 0.002, 12), [0.006, y, 0.006]));
    let metal = merged([lever(1.0), lever(-1.0), ring].into_iter().chain(pins));
    placed(&metal, hinge())
}

/// White curtains behind the windows of the second room.
pub(super) fn curtains(parameters: &Parameters) -> Mesh {
    let half = sheet(
        [parameters.steps(48), parameters.steps(10)],
        0.002,
        |u, v| {
            let gather = (-((v - 0.35) / 0.2).powi(2)).exp();
            let wave = (TAU * 6.0 * u + 1.3 * (3.0 * v).sin()).sin();
            DVec3::new(0.42 * u * (1.0 - 0.4 * gather), 1.4 * v, 0.03 * wave)
        },
    );
    let other = placed(&half, DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
    merged(WINDOWS_X[1..].iter().flat_map(|[l, r]| {
        let z = FRONT_Z - 0.1;
        [
            set_at(&half, [l - 0.05, 0.85, z], 0.0, 1.0),
            set_at(&other, [r + 0.05, 0.85, z], 0.0, 1.0),
        ]
    }))
}
