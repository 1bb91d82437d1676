//! Arches of both storeys and the groin vaults over the lower aisles.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{AISLE, CORNERS, COURT, PITCH, SLAB, SPRING, TOP, UPPER_SPRING, around, bays};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{lattice, merged, moved, shade, strip_solid, sweep};

/// An arch of a bay: clear width, pier to either side, height of its straight top over the springing
/// line, thickness.
fn arch(parameters: &Parameters, [width, pier, height, thickness]: [f64; 4]) -> Mesh {
    let steps = parameters.steps(22);
    let half = width * 0.5;
    let point = |i: usize, r: f64| {
        let angle_rad = PI * (1.0 - i as f64 / steps as f64);
        DVec2::new(angle_rad.cos() * r, (angle_rad.sin() * r).max(0.0))
    };
    let mut lower = vec![DVec2::new(-half - pier, 0.0)];
    lower.extend((0..=steps).map(|i| point(i, half)));
    lower.push(DVec2::new(half + pier, 0.0));
    let upper: Vec<DVec2> = lower.iter().map(|p| DVec2::new(p.x, height)).collect();
    let body = strip_solid(&lower, &upper, thickness);
    let path: Vec<DVec3> = (0..=steps)
        .map(|i| point(i, half + 0.08).extend(0.0))
        .collect();
    let reach = thickness * 0.5 + 0.035;
    let section = [
        [-reach, 0.045],
        [-reach, -0.045],
        [reach, -0.045],
        [reach, 0.045],
    ];
    let moulding = sweep(&path, &section.map(DVec2::from), false);
    merged([moved(&body, [0.0, 0.0, -thickness * 0.5]), moulding])
}

pub(super) fn arches(parameters: &Parameters) -> Mesh {
    let lower = arch(parameters, [PITCH - 0.58, 0.29, SLAB - SPRING, 0.5]);
    let upper = arch(parameters, [PITCH - 0.32, 0.16, TOP - UPPER_SPRING, 0.32]);
    around(|count| {
        merged(bays(count).flat_map(|x| {
            [
                moved(&lower, [x, SPRING, 0.0]),
                moved(&upper, [x, UPPER_SPRING, 0.0]),
            ]
        }))
    })
}

/// The underside of a groin vault over `size`, about the origin at the springing line: the higher of
/// two barrels that cross.
fn vault(parameters: &Parameters, size: [f64; 2]) -> Mesh {
    let n = 2 * parameters.steps(9);
    // Lines closer together where the barrels are steep.
    let line = |i: usize| -(PI * i as f64 / n as f64).cos();
    let barrel = |t: f64| (1.0 - t * t).max(0.0).sqrt();
    let surface = lattice([n + 1, n + 1], [false; 2], |i, j| {
        let (u, v) = (line(i), line(j));
        let rise = barrel(u).max(barrel(v)) * PITCH * 0.5;
        // Downwards is d/du × d/dv for x and z in this order.
        DVec3::new(u * size[0] * 0.5, rise, v * size[1] * 0.5)
    });
    shade(surface, 35.0)
}

pub(super) fn vaults(parameters: &Parameters) -> Mesh {
    let bay = vault(parameters, [PITCH, AISLE]);
    let corner = vault(parameters, [AISLE, AISLE]);
    let along = around(|count| merged(bays(count).map(|x| moved(&bay, [x, SPRING, -AISLE * 0.5]))));
    let corners = CORNERS.map(|[x, z]| {
        let at = COURT.map(|half| half + AISLE * 0.5);
        moved(&corner, [x * at[0], SPRING, z * at[1]])
    });
    merged([along].into_iter().chain(corners))
}
