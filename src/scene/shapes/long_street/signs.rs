//! Signs of five colours with writing on them, and strings of paper lanterns.

use glam::DVec3;

use super::houses::{House, houses};
use super::{FACE_X, FAR_Z, SHOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, cuboid, jitter, lathe, merged, moved, smooth_profile, tube,
};

/// An upright sign that juts out over the pavement: left edge, foot, width out from the wall, height.
struct Sign {
    x: f64,
    y: f64,
    out: f64,
    high: f64,
    colour: usize,
    key: u64,
}

const THICK: f64 = 0.16;
/// Clearance between wall and sign.
const GAP: f64 = 0.25;

fn signs(house: &House) -> Vec<Sign> {
    let count = house.random(60, [1.0, 3.4]) as u64;
    let signs = (0..count).map(|i| {
        let random = |k: u64, range: [f64; 2]| house.random(64 + i * 8 + k, range);
        // Between the windows, where no balcony is in the way.
        let pitch = house.width / (house.width / 2.3).floor();
        let column = random(0, [0.0, (house.width / pitch).round()]).floor();
        let high = random(2, [1.2, 3.4]);
        Sign {
            x: (pitch * column + random(1, [-0.05, 0.05])).max(0.15),
            y: SHOP + random(3, [0.25, (house.top() - SHOP - high - 0.8).max(0.3)]),
            out: random(4, [0.55, 1.0]),
            high,
            colour: (random(5, [0.0, 5.0]) as usize).min(4),
            key: house.key * 8 + i,
        }
    });
    let mut kept: Vec<Sign> = Vec::new();
    for sign in signs {
        let clear = |other: &Sign| (other.x - sign.x).abs() > 0.5;
        if kept.iter().all(clear) {
            kept.push(sign);
        }
    }
    kept
}

fn each_sign(parameters: &Parameters, make: impl Fn(&Sign) -> Mesh) -> Mesh {
    let all = houses(parameters).into_iter();
    merged(all.map(|house| house.place(&merged(signs(&house).iter().map(&make)))))
}

/// The glowing boards of one colour; at the far gate hangs one more.
pub(super) fn boards(parameters: &Parameters, colour: usize) -> Mesh {
    let along = each_sign(parameters, |sign| {
        if sign.colour != colour {
            return Mesh::default();
        }
        cuboid(
            [sign.x - THICK * 0.5, sign.y, GAP],
            [sign.x + THICK * 0.5, sign.y + sign.high, GAP + sign.out],
        )
    });
    let x = 2.1 * (colour as f64 - 2.0);
    let gate = cuboid(
        [x - 0.8, 6.5, FAR_Z + 0.15],
        [x + 0.8, 9.5 + 0.4 * (colour % 2) as f64, FAR_Z + 0.4],
    );
    merged([along, gate])
}

/// Rims round the boards and the rods that carry them.
pub(super) fn frames(parameters: &Parameters) -> Mesh {
    each_sign(parameters, |sign| {
        let x = [sign.x - THICK * 0.5 - 0.015, sign.x + THICK * 0.5 + 0.015];
        let (low, high) = (sign.y, sign.y + sign.high);
        let (near, far) = (GAP, GAP + sign.out);
        let bar =
            |y: [f64; 2], z: [f64; 2]| bevelled_box([x[0], y[0], z[0]], [x[1], y[1], z[1]], 0.01);
        let rod = |y: f64| capsule([sign.x, y, -0.05], [sign.x, y, near], [0.02, 0.02], 8);
        merged([
            bar([low - 0.05, low + 0.02], [near - 0.05, far + 0.05]),
            bar([high - 0.02, high + 0.05], [near - 0.05, far + 0.05]),
            bar([low + 0.02, high - 0.02], [near - 0.05, near + 0.02]),
            bar([low + 0.02, high - 0.02], [far - 0.02, far + 0.05]),
            rod(low + 0.2),
            rod(high - 0.2),
        ])
    })
}

/// Writing: characters of dark strokes, one under the other, on both faces.
pub(super) fn marks(parameters: &Parameters) -> Mesh {
    each_sign(parameters, |sign| {
        let size = sign.out * 0.72;
        let count = ((sign.high - 0.1) / (size * 1.25)).floor() as u64;
        let strokes = (0..count).flat_map(|c| (0..7u64).map(move |s| (c, s)));
        merged(strokes.map(|(c, s)| {
            let random = |k: u64, range: [f64; 2]| {
                jitter(
                    parameters.seed,
                    300_000 + sign.key * 1024 + c * 64 + s * 4 + k,
                    range,
                )
            };
            let middle = [
                sign.y + sign.high - size * (0.7 + 1.25 * c as f64),
                GAP + sign.out * 0.5,
            ];
            let level = s % 2 == 0;
            let half = size * random(0, [0.16, 0.46]);
            let off = size * random(1, [-0.42, 0.42]);
            let shift = random(2, [-1.0, 1.0]) * (size * 0.5 - half);
            let thin = size * 0.045;
            let (y, z) = if level { (off, shift) } else { (shift, off) };
            let (hy, hz) = if level { (thin, half) } else { (half, thin) };
            // Through the board: a stroke on either face.
            let deep = THICK * 0.5 + 0.006 + 0.0004 * s as f64;
            cuboid(
                [sign.x - deep, middle[0] + y - hy, middle[1] + z - hz],
                [sign.x + deep, middle[0] + y + hy, middle[1] + z + hz],
            )
        }))
    })
}

/// Strings across the street: (z, height at the walls, lanterns).
fn strings(parameters: &Parameters) -> Vec<[f64; 3]> {
    (0..15)
        .map(|i| {
            let random = |k: u64, range| jitter(parameters.seed, 400_000 + i * 4 + k, range);
            let z = -9.0 - 12.7 * i as f64 + random(0, [-2.0, 2.0]);
            [z, random(1, [5.6, 7.4]), 7.0]
        })
        .collect()
}

/// Height of a string at x.
fn sag(high: f64, x: f64) -> f64 {
    high - 1.1 * (1.0 - (x / FACE_X).powi(2))
}

pub(super) fn lantern_strings(parameters: &Parameters) -> Mesh {
    merged(strings(parameters).into_iter().map(|[z, high, count]| {
        let line: Vec<DVec3> = (0..=16)
            .map(|i| FACE_X * (f64::from(i) / 8.0 - 1.0))
            .map(|x| DVec3::new(x, sag(high, x), z))
            .collect();
        let caps = hung(count).map(|x| {
            let y = sag(high, x) - 0.12;
            cuboid(
                [x - 0.07, y - 0.03, z - 0.07],
                [x + 0.07, y + 0.13, z + 0.07],
            )
        });
        merged([tube(&line, 0.009, 5)].into_iter().chain(caps))
    }))
}

fn hung(count: f64) -> impl Iterator<Item = f64> {
    (1..=count as usize).map(move |i| FACE_X * 0.86 * (2.0 * i as f64 / (count + 1.0) - 1.0))
}

/// Ribbed lanterns of paper.
pub(super) fn lanterns(parameters: &Parameters) -> Mesh {
    let lantern = lathe(
        &smooth_profile(
            &[
                [0.0, -0.24],
                [0.09, -0.24],
                [0.19, -0.14],
                [0.22, 0.0],
                [0.19, 0.14],
                [0.09, 0.24],
                [0.0, 0.24],
            ],
            1,
        ),
        parameters.steps(14),
    );
    merged(
        strings(parameters)
            .into_iter()
            .flat_map(|[z, high, count]| {
                let lantern = lantern.clone();
                hung(count).map(move |x| moved(&lantern, [x, sag(high, x) - 0.38, z]))
            }),
    )
}
