//! The floor and the fountain.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{AISLE, COURT};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, cuboid, jitter, lathe, lattice, merged, moved, set_at, shade, smooth_profile,
    sphere,
};

fn tiles(parameters: &Parameters, odd: bool) -> Mesh {
    let reach = [COURT[0] + AISLE, COURT[1] + AISLE];
    let (columns, rows) = (20, 32);
    let size = [
        2.0 * reach[0] / columns as f64,
        2.0 * reach[1] / rows as f64,
    ];
    let all = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    merged(
        all.filter(|(i, j)| ((i + j) % 2 == 1) == odd)
            .map(|(i, j)| {
                let (x, z) = (
                    -reach[0] + size[0] * i as f64,
                    -reach[1] + size[1] * j as f64,
                );
                let lift = jitter(parameters.seed, i * 64 + j, [-0.001, 0.001]);
                let gap = 0.003;
                bevelled_box(
                    [x + gap, -0.03, z + gap],
                    [x + size[0] - gap, lift, z + size[1] - gap],
                    0.003,
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

/// The grout under the tiles.
pub(super) fn bed(_: &Parameters) -> Mesh {
    let [x, z] = COURT.map(|half| half + AISLE);
    cuboid([-x, -0.4, -z], [x, -0.004, z])
}

/// An eight-sided basin with two bowls on a stem.
pub(super) fn fountain(parameters: &Parameters) -> Mesh {
    let basin = lathe(
        &[
            [0.0, 0.0],
            [1.62, 0.0],
            [1.62, 0.12],
            [1.5, 0.16],
            [1.5, 0.46],
            [1.6, 0.5],
            [1.6, 0.58],
            [1.32, 0.58],
            [1.32, 0.14],
            [0.0, 0.14],
        ],
        8,
    );
    let bowl = |radius: f64| {
        lathe(
            &smooth_profile(
                &[
                    [0.0, 0.0],
                    [0.12, 0.0],
                    [0.2, 0.04],
                    [0.6, 0.12],
                    [1.0, 0.27],
                    [1.02, 0.3],
                    [0.97, 0.3],
                    [0.55, 0.18],
                    [0.0, 0.12],
                ]
                .map(|[r, y]| [r * radius, y]),
                parameters.steps(4),
            ),
            parameters.steps(48),
        )
    };
    let stem = lathe(
        &smooth_profile(
            &[
                [0.0, 0.1],
                [0.34, 0.1],
                [0.34, 0.2],
                [0.2, 0.28],
                [0.13, 0.5],
                [0.17, 0.8],
                [0.1, 1.0],
                [0.1, 1.15],
                [0.14, 1.4],
                [0.07, 1.6],
                [0.06, 1.75],
                [0.0, 1.75],
            ],
            parameters.steps(4),
        ),
        parameters.steps(32),
    );
    let ball = moved(&sphere(0.12, parameters.steps(28)), [0.0, 1.95, 0.0]);
    let whole = merged([
        basin,
        moved(&bowl(0.82), [0.0, 0.9, 0.0]),
        moved(&bowl(0.45), [0.0, 1.5, 0.0]),
        stem,
        ball,
    ]);
    set_at(&whole, [0.0, -0.001, 0.0], 22.5, 1.0)
}

/// Water with rings of ripples in the basin.
pub(super) fn water(parameters: &Parameters) -> Mesh {
    let (rings, around) = (parameters.steps(40), parameters.steps(64));
    let surface = lattice([rings + 1, around], [false, true], |i, j| {
        let angle_rad = TAU * j as f64 / around as f64;
        let r = 0.1 + 1.24 * i as f64 / rings as f64;
        let wave = 0.006 * (r * 30.0).sin() * (1.0 - 0.5 * r);
        DVec3::new(r * angle_rad.cos(), 0.47 + wave, r * angle_rad.sin())
    });
    let mut surface = surface;
    for t in &mut surface.triangles {
        t.swap(1, 2);
    }
    shade(surface, 180.0)
}
