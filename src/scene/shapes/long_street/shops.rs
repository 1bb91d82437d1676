//! The lit shops on the ground floor, their wares and awnings.

use super::facades::{PIER, SHOP_DEPTH, SHOP_FLOOR, SHOP_HEAD};
use super::houses::{House, WALL, houses};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{bevelled_box, cuboid, cylinder, merged, moved, sheet};
use glam::DVec3;

/// Whether a shop is open; closed ones have a rolling shutter.
fn is_open(house: &House) -> bool {
    house.random(20, [0.0, 1.0]) < 0.72
}

/// Floor, sides, back and ceiling of the shops, with counters and shelves; shutters of the closed ones.
pub(super) fn rooms(parameters: &Parameters) -> Mesh {
    merged(houses(parameters).into_iter().map(|house| {
        let [l, r] = [PIER, house.width - PIER];
        if !is_open(&house) {
            let slat = bevelled_box([l, 0.0, -0.15], [r, 0.088, -0.12], 0.01);
            let slats = (0..31).map(|i| moved(&slat, [0.0, 0.09 * f64::from(i), 0.0]));
            return house.place(&merged(slats));
        }
        let back = -SHOP_DEPTH;
        let mut pieces = vec![
            cuboid([l - 0.2, -0.2, back - 0.2], [r + 0.2, SHOP_FLOOR, -0.05]),
            cuboid(
                [l - 0.2, SHOP_FLOOR, back - 0.2],
                [r + 0.2, SHOP_HEAD, back],
            ),
            cuboid([l - 0.2, SHOP_FLOOR, back], [l, SHOP_HEAD, -WALL - 0.002]),
            cuboid([r, SHOP_FLOOR, back], [r + 0.2, SHOP_HEAD, -WALL - 0.002]),
            cuboid(
                [l - 0.2, SHOP_HEAD, back - 0.2],
                [r + 0.2, SHOP_HEAD + 0.098, -WALL - 0.002],
            ),
        ];
        for y in shelf_levels() {
            pieces.push(cuboid([l, y - 0.03, back - 0.01], [r, y, back + 0.35]));
        }
        let low = [l + 0.5, SHOP_FLOOR, -1.0];
        pieces.push(bevelled_box(low, [r - 1.4, SHOP_FLOOR + 0.85, -0.55], 0.02));
        house.place(&merged(pieces))
    }))
}

fn shelf_levels() -> [f64; 3] {
    [0.7, 1.25, 1.8].map(|y| SHOP_FLOOR + y)
}

/// Tubes of light under the ceilings.
pub(super) fn lights(parameters: &Parameters) -> Mesh {
    let open = houses(parameters).into_iter().filter(is_open);
    merged(open.map(|house| {
        let tube = |z: f64| {
            let low = [PIER + 0.6, SHOP_HEAD - 0.06, z];
            cuboid(low, [house.width - PIER - 0.6, SHOP_HEAD - 0.02, z + 0.07])
        };
        house.place(&merged([tube(-0.9), tube(-1.7)]))
    }))
}

/// Boxes, tins and bottles on the shelves and the counter.
pub(super) fn wares(parameters: &Parameters) -> Mesh {
    let tin = cylinder(0.07, 0.16, 0.006, parameters.steps(10));
    let open = houses(parameters).into_iter().filter(is_open);
    merged(open.map(|house| {
        let mut pieces = Vec::new();
        for (row, y) in shelf_levels().into_iter().enumerate() {
            let mut x = PIER + 0.15;
            for item in 0.. {
                let random = |k: u64, range: [f64; 2]| {
                    house.random(1000 + row as u64 * 256 + item * 4 + k, range)
                };
                let wide = random(0, [0.1, 0.34]);
                if x + wide > house.width - PIER - 0.1 || item > 60 {
                    break;
                }
                let z = -SHOP_DEPTH + 0.17;
                pieces.push(if random(1, [0.0, 1.0]) < 0.35 {
                    moved(&tin, [x + 0.08, y, z])
                } else {
                    let high = random(2, [0.12, 0.4]);
                    cuboid([x, y, z - 0.12], [x + wide - 0.02, y + high, z + 0.1])
                });
                x += wide + random(3, [0.02, 0.2]);
            }
        }
        house.place(&merged(pieces))
    }))
}

/// Awnings of cloth over some shops, hung with a scalloped edge.
pub(super) fn awnings(parameters: &Parameters) -> Mesh {
    let shaded = houses(parameters)
        .into_iter()
        .filter(|h| h.random(30, [0.0, 1.0]) < 0.55);
    merged(shaded.map(|house| {
        let [l, r] = [PIER - 0.1, house.width - PIER + 0.1];
        let columns = parameters.steps((house.width * 6.0) as usize);
        let cloth = sheet([columns, parameters.steps(7)], 0.01, |u, v| {
            // v = 0 at the free edge, which hangs down a little.
            let t = (1.0 - v) * 1.12;
            let out = 1.25 * t.min(1.0);
            let hang = (t - 1.0).max(0.0) * 2.0;
            let wave = 0.02 * (u * (r - l) * 12.0).cos() * t;
            let y = SHOP_HEAD + 0.3 - 0.5 * out / 1.25 - hang * (1.0 + 12.0 * wave);
            DVec3::new(l + (r - l) * u, y + 0.3 * wave, 0.01 + out)
        });
        house.place(&cloth)
    }))
}
