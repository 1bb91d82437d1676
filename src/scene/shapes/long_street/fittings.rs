//! Balconies, cornices, cooling boxes and what stands on roofs.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::houses::{House, WINDOW, houses};
use super::{FLOOR, SHOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cuboid, cylinder, merged, moved, placed, torus,
};

const DEPTH: f64 = 0.85;

/// x range and level of the balconies of a house: one before every window of a floor that has them.
fn balconies_of(house: &House) -> Vec<[f64; 3]> {
    let floors = (0..house.floors).filter(|&floor| house.has_balconies(floor));
    floors
        .flat_map(|floor| {
            let level = SHOP + FLOOR * floor as f64 + 0.12;
            let windows = house.windows(floor);
            windows.map(move |[x, _]| [x - 0.35, x + WINDOW[0] + 0.35, level])
        })
        .collect()
}

/// Slabs with two brackets.
pub(super) fn balconies(parameters: &Parameters) -> Mesh {
    merged(houses(parameters).into_iter().map(|house| {
        let slabs = balconies_of(&house).into_iter().map(|[l, r, y]| {
            let bracket = |x: f64| cuboid([x, y - 0.22, -0.05], [x + 0.1, y - 0.002, 0.45]);
            merged([
                bevelled_box([l, y, -0.05], [r, y + 0.1, DEPTH], 0.015),
                bracket(l + 0.15),
                bracket(r - 0.25),
            ])
        });
        house.place(&merged(slabs))
    }))
}

/// Railings of thin bars round the balconies.
pub(super) fn railings(parameters: &Parameters) -> Mesh {
    let bar = |x: f64, y: f64, z: f64| {
        let r = 0.009;
        cuboid([x - r, y + 0.1, z - r], [x + r, y + 0.95, z + r])
    };
    merged(houses(parameters).into_iter().map(|house| {
        let rails = balconies_of(&house).into_iter().map(|[l, r, y]| {
            let (l, r, front) = (l + 0.04, r - 0.04, DEPTH - 0.04);
            let steps = ((r - l) / 0.13).round();
            let mut pieces: Vec<Mesh> = (0..=steps as usize)
                .map(|i| bar(l + (r - l) * i as f64 / steps, y, front))
                .collect();
            for i in 0..6 {
                let z = front * f64::from(i) / 6.0;
                pieces.push(bar(l, y, z));
                pieces.push(bar(r, y, z));
            }
            let high = [y + 0.93, y + 0.97];
            let rail =
                |x: [f64; 2], z: [f64; 2]| cuboid([x[0], high[0], z[0]], [x[1], high[1], z[1]]);
            pieces.push(rail([l - 0.022, r + 0.022], [front - 0.022, front + 0.022]));
            pieces.push(rail([l - 0.022, l + 0.022], [-0.02, front - 0.023]));
            pieces.push(rail([r - 0.022, r + 0.022], [-0.02, front - 0.023]));
            merged(pieces)
        });
        house.place(&merged(rails))
    }))
}

/// String courses over the shop and cornices at the roof.
pub(super) fn cornices(parameters: &Parameters) -> Mesh {
    merged(houses(parameters).into_iter().map(|house| {
        let run = |y: f64, high: f64, out: f64| {
            let low = [0.01, y, -0.1];
            bevelled_box(low, [house.width - 0.01, y + high, out], 0.02)
        };
        let top = house.top();
        let middle = (1..house.floors).map(|i| run(SHOP + FLOOR * i as f64 - 0.05, 0.1, 0.05));
        let whole = merged(
            [
                run(SHOP - 0.12, 0.22, 0.14),
                run(top - 0.3, 0.14, 0.16),
                run(top - 0.14, 0.2, 0.34),
            ]
            .into_iter()
            .chain(middle),
        );
        house.place(&whole)
    }))
}

/// Cooling boxes with their fans beside windows.
pub(super) fn boxes(parameters: &Parameters) -> Mesh {
    let upright = DMat4::from_rotation_x(PI * 0.5);
    let ring = placed(&torus(0.17, 0.012, [parameters.steps(20), 6]), upright);
    let hub = placed(&cylinder(0.05, 0.03, 0.005, 12), upright);
    let blades = (0..4).map(|i| {
        let blade = bevelled_box([0.03, -0.03, -0.004], [0.16, 0.03, 0.004], 0.002);
        placed(
            &blade,
            DMat4::from_rotation_z(0.7 + PI * 0.5 * f64::from(i)),
        )
    });
    let front = merged([ring, hub].into_iter().chain(blades));
    let case = bevelled_box([-0.36, -0.27, 0.08], [0.36, 0.27, 0.36], 0.02);
    let arms = [-0.25, 0.25].map(|x| cuboid([x, -0.32, -0.02], [x + 0.03, -0.272, 0.36]));
    let unit = merged(
        [case, moved(&front, [-0.08, 0.0, 0.368])]
            .into_iter()
            .chain(arms),
    );
    merged(houses(parameters).into_iter().map(|house| {
        let found = (0..house.floors)
            .filter(|&f| !house.has_balconies(f))
            .flat_map(|floor| {
                let windows = house.windows(floor).enumerate();
                let chosen = windows.filter(move |(i, _)| {
                    house.random(500 + (floor * 16 + i) as u64, [0.0, 1.0]) < 0.4
                });
                chosen.map(|(_, [x, y])| moved(&unit, [x + WINDOW[0] + 0.55, y + 0.1, 0.0]))
            });
        let fitting = found.filter(|m| m.positions.iter().all(|p| p.x < house.width - 0.1));
        house.place(&merged(fitting))
    }))
}

/// Water tanks, stair heads and aerials.
pub(super) fn rooftops(parameters: &Parameters) -> Mesh {
    let tank = cylinder(0.9, 1.6, 0.08, parameters.steps(24));
    merged(houses(parameters).into_iter().map(|house| {
        let y = house.top() - 0.42;
        let x = house.width * house.random(7, [0.25, 0.7]);
        let mut pieces = vec![bevelled_box(
            [x - 1.2, y, -5.0],
            [x + 0.6, y + 2.3, -2.8],
            0.03,
        )];
        if house.random(8, [0.0, 1.0]) < 0.5 {
            pieces.push(moved(&tank, [x + 1.1, y + 0.6, -2.0]));
            for [dx, dz] in [[-0.6, -0.6], [0.6, -0.6], [0.6, 0.6], [-0.6, 0.6]] {
                let foot = [x + 1.1 + dx, y - 0.05, -2.0 + dz];
                pieces.push(capsule(foot, [foot[0], y + 0.65, foot[2]], [0.05, 0.05], 8));
            }
        }
        let mast = [house.width * 0.2, y, -1.2];
        pieces.push(capsule(mast, [mast[0], y + 2.6, mast[2]], [0.02, 0.015], 6));
        for k in 0..5 {
            let (half, high) = (0.42 - 0.05 * f64::from(k), y + 2.5);
            let z = mast[2] - 0.3 + 0.15 * f64::from(k);
            let from = DVec3::new(mast[0] - half, high, z).to_array();
            pieces.push(capsule(from, [mast[0] + half, high, z], [0.008, 0.008], 6));
        }
        pieces.push(capsule(
            [mast[0], y + 2.5, mast[2] - 0.32],
            [mast[0], y + 2.5, mast[2] + 0.32],
            [0.01, 0.01],
            6,
        ));
        house.place(&merged(pieces))
    }))
}
