//! Walls, window frames and panes.

use super::houses::{House, WALL, WINDOW, houses};
use super::{FACE_X, FAR_Z, NEAR_Z, PAVEMENT, SHOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{Opening, bevelled_box, cuboid, merged, moved, wall};

/// How deep a shop is behind its facade, and the piers at its ends.
pub(super) const SHOP_DEPTH: f64 = 2.4;
pub(super) const PIER: f64 = 0.55;
pub(super) const SHOP_HEAD: f64 = SHOP - 0.55;

/// The facades of one colour, and the bodies of the houses over their shops.
pub(super) fn walls(parameters: &Parameters, colour: usize) -> Mesh {
    let all = houses(parameters).into_iter();
    merged(all.filter(|h| h.colour() == colour).map(|house| {
        let mut openings = vec![Opening {
            min: [PIER, 0.0],
            max: [house.width - PIER, SHOP_HEAD],
        }];
        for floor in 0..house.floors {
            openings.extend(house.windows(floor).map(|[x, y]| Opening {
                min: [x, y],
                max: [x + WINDOW[0], y + WINDOW[1]],
            }));
        }
        let front = wall([house.width, house.top()], WALL, &openings);
        let body = cuboid(
            [0.0, SHOP_HEAD + 0.1, -6.0],
            [house.width, house.top() - 0.4, -WALL - 0.002],
        );
        house.place(&merged([moved(&front, [0.0, 0.0, -WALL]), body]))
    }))
}

/// A gatehouse with a passage at the far end, and a wall behind the start.
pub(super) fn ends(_: &Parameters) -> Mesh {
    let passage = Opening {
        min: [FACE_X + 1.5, 0.0],
        max: [FACE_X + 4.5, 4.2],
    };
    let gate = wall([FACE_X * 2.0 + 6.0, 13.0], 1.5, &[passage]);
    let tiers = (0..3).map(|i| {
        let y = 13.0 + 2.2 * f64::from(i);
        let (half, z) = (5.6 - 1.3 * f64::from(i), FAR_Z - 0.8);
        merged([
            bevelled_box(
                [-half + 0.9, y - 0.1, z - 2.0],
                [half - 0.9, y + 2.0, z + 0.4],
                0.05,
            ),
            bevelled_box([-half, y + 1.75, z - 2.8], [half, y + 2.15, z + 1.3], 0.15),
        ])
    });
    let back = cuboid(
        [-FACE_X - 6.0, -0.2, NEAR_Z],
        [FACE_X + 6.0, 9.0, NEAR_Z + 0.4],
    );
    let beyond = cuboid([-8.0, -0.2, FAR_Z - 9.0], [8.0, 6.0, FAR_Z - 8.6]);
    let gate = moved(&gate, [-FACE_X - 3.0, 0.0, FAR_Z - 1.5]);
    merged([gate, back, beyond].into_iter().chain(tiers))
}

fn each_window(
    parameters: &Parameters,
    make: impl Fn(&House, usize, u64, [f64; 2]) -> Mesh,
) -> Mesh {
    merged(houses(parameters).into_iter().map(|house| {
        let of_house = (0..house.floors).flat_map(|floor| {
            let windows = house.windows(floor).enumerate();
            let make = &make;
            let house = &house;
            windows.map(move |(i, at)| make(house, floor, (floor * 16 + i) as u64, at))
        });
        house.place(&merged(of_house))
    }))
}

/// Frames with a mullion and a transom, and sills.
pub(super) fn window_frames(parameters: &Parameters) -> Mesh {
    each_window(parameters, |_, _, _, [x, y]| {
        let [w, h] = WINDOW;
        let bar =
            |x: [f64; 2], y: [f64; 2], z: [f64; 2]| cuboid([x[0], y[0], z[0]], [x[1], y[1], z[1]]);
        let (z, middle) = ([-0.19, -0.12], x + w * 0.5);
        let transom = y + h * 0.68;
        merged([
            bar([x, x + 0.05], [y, y + h], z),
            bar([x + w - 0.05, x + w], [y, y + h], z),
            bar([x + 0.05, x + w - 0.05], [y, y + 0.05], z),
            bar([x + 0.05, x + w - 0.05], [y + h - 0.05, y + h], z),
            bar(
                [middle - 0.025, middle + 0.025],
                [y + 0.05, y + h - 0.05],
                z,
            ),
            bar(
                [x + 0.05, middle - 0.025],
                [transom - 0.02, transom + 0.02],
                [z[0] + 0.01, z[1] - 0.01],
            ),
            bar(
                [middle + 0.025, x + w - 0.05],
                [transom - 0.02, transom + 0.02],
                [z[0] + 0.01, z[1] - 0.01],
            ),
            bevelled_box([x - 0.08, y - 0.08, -0.1], [x + w + 0.08, y, 0.09], 0.012),
        ])
    })
}

/// Whether somebody is at home behind a window.
fn is_lit(house: &House, item: u64) -> bool {
    house.random(200 + item, [0.0, 1.0]) < 0.24
}

fn panes(parameters: &Parameters, lit: bool) -> Mesh {
    each_window(parameters, |house, _, item, [x, y]| {
        if is_lit(house, item) != lit {
            return Mesh::default();
        }
        let [w, h] = WINDOW;
        cuboid(
            [x - 0.02, y - 0.02, -0.21],
            [x + w + 0.02, y + h + 0.02, -0.18],
        )
    })
}

/// Panes of dark rooms.
pub(super) fn dark_panes(parameters: &Parameters) -> Mesh {
    panes(parameters, false)
}

/// Panes of lit rooms.
pub(super) fn lit_panes(parameters: &Parameters) -> Mesh {
    panes(parameters, true)
}

/// The height at which shops stand.
pub(super) const SHOP_FLOOR: f64 = PAVEMENT + 0.02;
