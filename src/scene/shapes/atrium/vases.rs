//! Large jars.

use std::f64::consts::PI;

use glam::DMat4;

use super::{BAYS, ROW_X, column_z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    curve, cylinder, lathe, merged, moved, placed, set_at, smooth_profile, torus, tube,
};

/// Large jars along both rows and two tall ones near the camera.
pub(super) fn vases(parameters: &Parameters) -> Mesh {
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
    let ear = tube(
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
