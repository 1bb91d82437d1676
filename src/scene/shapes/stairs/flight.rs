//! Treads, risers, carpet and balustrade.

use glam::{DMat4, DVec2, DVec3};

use super::{BACK_Z, FIRST_Z, GOING, HALF_WIDTH, HALL_X, LANDING_Y, LANDING_Z, RISE, STEPS};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, cuboid, cylinder, lathe, merged, moved, placed, rounded_box, sheet,
    smooth_profile, sphere, sweep,
};

fn step_corner(i: usize) -> (f64, f64) {
    (RISE * (i + 1) as f64, FIRST_Z - GOING * i as f64)
}

/// Treads with a nosing, let into the riser behind them, and the landing's boards.
pub(super) fn treads(_: &Parameters) -> Mesh {
    let tread = |i: usize| {
        let (y, z) = step_corner(i);
        rounded_nosing(
            [-HALF_WIDTH - 0.06, y - 0.036, z - GOING - 0.02],
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
pub(super) fn risers(_: &Parameters) -> Mesh {
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
pub(super) fn carpet(parameters: &Parameters) -> Mesh {
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

pub(super) fn balusters(parameters: &Parameters) -> Mesh {
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
pub(super) fn rails(parameters: &Parameters) -> Mesh {
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
        bevelled_box([-0.06, 0.18, -0.06], [0.06, 1.14, 0.06], 0.008),
        bevelled_box([-0.08, 1.12, -0.08], [0.08, 1.16, 0.08], 0.008),
        moved(
            &cylinder(0.035, 0.05, 0.005, parameters.steps(24)),
            [0.0, 1.15, 0.0],
        ),
        moved(&sphere(0.075, parameters.steps(36)), [0.0, 1.255, 0.0]),
    ])
}
