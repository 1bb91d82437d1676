//! Floor tiles, galleries, walls and mouldings.

use std::f64::consts::PI;

use glam::{DMat4, DVec2, DVec3};

use super::{BACK_Z, BAYS, FRONT_Z, GALLERY, PITCH, ROW_X, SPRING, TOP, WALL_X, column_z};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    Opening, bevelled_box, cuboid, jitter, merged, moved, placed, sweep, wall,
};

fn tiles(parameters: &Parameters, odd: bool) -> Mesh {
    let size = 0.6;
    let columns = (WALL_X * 2.0 / size).round() as i64;
    let rows = ((FRONT_Z - BACK_Z) / size).round() as i64;
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    merged(
        all.filter(|(i, j)| ((i + j) % 2 == 1) == odd)
            .map(|(i, j)| {
                let (x, z) = (-WALL_X + i as f64 * size, FRONT_Z - j as f64 * size);
                let lift = jitter(parameters.seed, (i * 4096 + j) as u64, [-0.001, 0.001]);
                let gap = 0.003;
                bevelled_box(
                    [x + gap, -0.03, z - size + gap],
                    [x + size - gap, lift, z - gap],
                    0.002,
                )
            }),
    )
}

pub(super) fn light_tiles(parameters: &Parameters) -> Mesh {
    tiles(parameters, false)
}

pub(super) fn dark_tiles(parameters: &Parameters) -> Mesh {
    tiles(parameters, true)
}

/// The grout bed under the tiles and the gallery floors.
pub(super) fn slab(_: &Parameters) -> Mesh {
    let gallery = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.35), side * WALL_X);
        cuboid(
            [a.min(b), GALLERY - 0.3, BACK_Z],
            [a.max(b), GALLERY, FRONT_Z],
        )
    };
    merged([
        cuboid([-WALL_X, -0.3, BACK_Z], [WALL_X, -0.003, FRONT_Z]),
        gallery(-1.0),
        gallery(1.0),
    ])
}

/// Outer walls with windows, and roofs over the aisles; the court is open to the sky.
pub(super) fn walls(_: &Parameters) -> Mesh {
    let length = FRONT_Z - BACK_Z;
    let window = |centre: f64, low: f64, high: f64, half: f64| Opening {
        min: [centre - half, low],
        max: [centre + half, high],
    };
    let openings: Vec<Opening> = (0..BAYS)
        .map(|i| FRONT_Z - (column_z(i) - PITCH * 0.5))
        .map(|along| window(along, 6.0, 8.0, 0.5))
        .collect();
    // A wall runs along +x with its front towards +z; the side walls are turned to face the court.
    let long = wall([length, TOP], 0.4, &openings);
    let right = placed(
        &long,
        DMat4::from_translation(DVec3::new(WALL_X + 0.4, 0.0, FRONT_Z - length))
            * DMat4::from_rotation_y(-PI * 0.5),
    );
    let left = placed(
        &long,
        DMat4::from_translation(DVec3::new(-WALL_X - 0.4, 0.0, FRONT_Z))
            * DMat4::from_rotation_y(PI * 0.5),
    );
    let door = [window(WALL_X, 0.0, 3.0, 1.1), window(WALL_X, 5.6, 8.2, 0.9)];
    let end = wall([WALL_X * 2.0, TOP], 0.4, &door);
    let back = moved(&end, [-WALL_X, 0.0, BACK_Z - 0.4]);
    let front = moved(&end, [-WALL_X, 0.0, FRONT_Z]);
    // A yard behind the door; its wall hides the black below the sky's horizon.
    let far_z = BACK_Z - 6.0;
    let outside = merged([
        cuboid([-8.0, -0.3, far_z], [8.0, -0.003, BACK_Z]),
        cuboid([-8.0, -0.3, far_z - 0.3], [8.0, 2.3, far_z]),
    ]);
    let roof = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.4), side * (WALL_X + 0.6));
        let z = [BACK_Z - 0.4, FRONT_Z + 0.4];
        bevelled_box([a.min(b), TOP, z[0]], [a.max(b), TOP + 0.25, z[1]], 0.04)
    };
    merged([right, left, back, front, outside, roof(-1.0), roof(1.0)])
}

/// Mouldings along the court, the gallery's kerb and the heads of the side walls.
pub(super) fn cornices(_: &Parameters) -> Mesh {
    let section = [
        [0.0, -0.2],
        [0.1, -0.2],
        [0.14, -0.12],
        [0.2, -0.08],
        [0.24, 0.0],
        [0.24, 0.06],
        [0.0, 0.06],
    ];
    let run = |x: f64, y: f64, side: f64| {
        // Towards the court: left of the path for the right-hand side.
        let points = section.map(|[a, b]| DVec2::new(a, b));
        let (from, to) = if side > 0.0 {
            (FRONT_Z, BACK_Z)
        } else {
            (BACK_Z, FRONT_Z)
        };
        sweep(
            &[DVec3::new(x, y, from), DVec3::new(x, y, to)],
            &points,
            false,
        )
    };
    let kerb = |side: f64| {
        let (a, b) = (side * (ROW_X - 0.2), side * (ROW_X + 0.2));
        bevelled_box(
            [a.min(b), GALLERY, BACK_Z],
            [a.max(b), GALLERY + 0.25, FRONT_Z],
            0.02,
        )
    };
    merged([-1.0, 1.0].into_iter().flat_map(|side| {
        [
            run(side * (ROW_X - 0.35), GALLERY - 0.06, side),
            run(side * (ROW_X - 0.4), TOP + 0.2, side),
            run(side * WALL_X, SPRING + 0.4, side),
            kerb(side),
        ]
    }))
}
