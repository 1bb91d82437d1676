//! Columns, corner piers, pilasters and the balustrade of the gallery.

use super::{
    AISLE, CORNERS, COURT, GALLERY, PITCH, SPRING, UPPER_SPRING, around, bays, inner_columns,
};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{bevelled_box, lathe, merged, moved, smooth_profile};

/// A round column on a square plinth under a square abacus.
fn column(parameters: &Parameters, radius: f64, height: f64) -> Mesh {
    let slab =
        |half: f64, y: [f64; 2]| bevelled_box([-half, y[0], -half], [half, y[1], half], 0.012);
    let foot = smooth_profile(
        &[
            [1.0, 0.07],
            [1.38, 0.08],
            [1.44, 0.13],
            [1.3, 0.18],
            [1.16, 0.2],
            [1.22, 0.25],
            [1.14, 0.29],
            [1.0, 0.31],
        ],
        parameters.steps(2),
    );
    let head = smooth_profile(
        &[
            [0.86, -0.42],
            [0.94, -0.4],
            [0.94, -0.37],
            [0.87, -0.35],
            [0.88, -0.28],
            [1.05, -0.16],
            [1.36, -0.08],
        ],
        parameters.steps(2),
    );
    let profile: Vec<[f64; 2]> = [[0.0, 0.07]]
        .into_iter()
        .chain(foot.into_iter().map(|[r, y]| [r * radius, y]))
        .chain(head.into_iter().map(|[r, y]| [r * radius, height + y]))
        .chain([[0.0, height - 0.08]])
        .collect();
    merged([
        slab(1.5 * radius, [-0.02, 0.08]),
        lathe(&profile, parameters.steps(26)),
        slab(1.45 * radius, [height - 0.09, height + 0.01]),
    ])
}

pub(super) fn columns(parameters: &Parameters) -> Mesh {
    let lower = column(parameters, 0.22, SPRING);
    let upper = column(parameters, 0.12, UPPER_SPRING - GALLERY);
    let rows = around(|count| {
        merged(inner_columns(count).flat_map(|x| {
            [
                moved(&lower, [x, 0.0, 0.0]),
                moved(&upper, [x, GALLERY, 0.0]),
            ]
        }))
    });
    let piers = CORNERS.map(|[x, z]| {
        let block = |half: f64, y: [f64; 2]| {
            let (x, z) = (x * COURT[0], z * COURT[1]);
            bevelled_box([x - half, y[0], z - half], [x + half, y[1], z + half], 0.02)
        };
        merged([
            block(0.38, [-0.02, 0.25]),
            block(0.31, [0.2, 4.19]),
            block(0.36, [SPRING - 0.12, SPRING + 0.02]),
            block(0.22, [GALLERY - 0.02, 7.99]),
            block(0.27, [UPPER_SPRING - 0.1, UPPER_SPRING + 0.02]),
        ])
    });
    merged([rows].into_iter().chain(piers))
}

/// Flat half-columns at the outer walls, under the feet of the vaults.
pub(super) fn pilasters(_: &Parameters) -> Mesh {
    around(|count| {
        let ends = [-0.5, 0.5].map(|side| side * PITCH * count as f64);
        merged(inner_columns(count).chain(ends).map(|x| {
            let block = |half: f64, y: [f64; 2], out: f64| {
                let z = [-AISLE - 0.05, -AISLE + out];
                bevelled_box([x - half, y[0], z[0]], [x + half, y[1], z[1]], 0.012)
            };
            merged([
                block(0.24, [-0.02, 0.22], 0.16),
                block(0.18, [0.2, SPRING - 0.1], 0.11),
                block(0.25, [SPRING - 0.12, SPRING + 0.03], 0.2),
            ])
        }))
    })
}

/// Turned balusters between kerb and rail.
pub(super) fn balustrade(parameters: &Parameters) -> Mesh {
    let baluster = lathe(
        &smooth_profile(
            &[
                [0.0, 0.0],
                [0.06, 0.0],
                [0.045, 0.06],
                [0.03, 0.1],
                [0.068, 0.24],
                [0.04, 0.4],
                [0.028, 0.54],
                [0.05, 0.62],
                [0.0, 0.64],
            ],
            parameters.steps(2),
        ),
        parameters.steps(10),
    );
    around(|count| {
        let bays = bays(count).flat_map(|x| {
            let bar = |y: [f64; 2], half: f64| {
                let w = PITCH * 0.5 - 0.1;
                bevelled_box([x - w, y[0], -half], [x + w, y[1], half], 0.012)
            };
            let posts = (0..6).map(|i| {
                let across = (f64::from(i) / 5.0 - 0.5) * (PITCH - 0.66);
                moved(&baluster, [x + across, GALLERY + 0.17, 0.0])
            });
            let rails = [
                bar([GALLERY - 0.02, GALLERY + 0.18], 0.1),
                bar([GALLERY + 0.8, GALLERY + 0.92], 0.12),
            ];
            posts.chain(rails).collect::<Vec<_>>()
        });
        merged(bays)
    })
}
