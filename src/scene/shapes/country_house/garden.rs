//! The lawn, the path to the door, the fence and a bench.

use std::f64::consts::PI;

use glam::DVec3;

use super::{FENCE_Z, GATE_X, LAWN};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{
    bevelled_box, capsule, curve, jitter, lathe, merged, moved, set_at,
};

/// A lawn that rises to hills far away, since below the horizon the sky is black.
pub(super) fn ground(_: &Parameters) -> Mesh {
    let profile = [
        [0.0, -1.0],
        [150.0, -1.0],
        [150.0, 11.0],
        [95.0, 6.0],
        [55.0, 1.2],
        [34.0, 0.0],
        [0.0, 0.0],
    ];
    moved(&lathe(&profile, 72), [2.0, LAWN, 4.0])
}

/// The line of the path, from the step before the door to the gate and on to the lane.
fn path_line() -> Vec<DVec3> {
    curve(
        &[
            [1.25, 0.0, 4.1],
            [1.3, 0.0, 5.6],
            [1.9, 0.0, 8.6],
            [2.75, 0.0, 12.0],
            [2.9, 0.0, 15.5],
        ],
        9,
    )
}

/// Distance from the middle of the path.
pub(super) fn distance_to_path(x: f64, z: f64) -> f64 {
    let at = DVec3::new(x, 0.0, z);
    let distances = path_line().into_iter().map(|p| p.distance(at));
    distances.fold(f64::INFINITY, f64::min)
}

/// Uneven flagstones two and three abreast, and the gravel of the lane beyond the gate.
pub(super) fn path(parameters: &Parameters) -> Mesh {
    let line = path_line();
    let mut pieces = Vec::new();
    for (row, pair) in line.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let along = (to - from).normalize();
        let turn_deg = along.x.atan2(along.z).to_degrees();
        let random =
            |k: u64, range: [f64; 2]| jitter(parameters.seed, row as u64 * 8 + k + 60_000, range);
        let half = from.distance(to) * 0.5 - 0.012;
        let split = random(0, [-0.22, 0.22]);
        let edges = [random(1, [-0.66, -0.5]), split, random(2, [0.5, 0.66])];
        for (k, edge) in edges.windows(2).enumerate() {
            let high = random(3 + k as u64, [0.012, 0.03]);
            let low = [edge[0] + 0.012, -0.08, -half];
            let stone = bevelled_box(low, [edge[1] - 0.012, high, half], 0.012);
            let middle = (from + to) * 0.5;
            let turn = turn_deg + random(5 + k as u64, [-2.0, 2.0]);
            pieces.push(set_at(&stone, [middle.x, LAWN, middle.z], turn, 1.0));
        }
    }
    merged(pieces)
}

/// A picket with a pointed head.
fn picket(height: f64) -> Mesh {
    let foot = bevelled_box([-0.035, -0.1, -0.01], [0.035, height, 0.01], 0.004);
    let head = bevelled_box([-0.022, -0.022, -0.0095], [0.022, 0.022, 0.0095], 0.004);
    let turned = crate::scene::shapes::kit::placed(
        &head,
        glam::DMat4::from_translation(DVec3::new(0.0, height - 0.003, 0.0))
            * glam::DMat4::from_rotation_z(PI * 0.25),
    );
    merged([foot, turned])
}

/// A picket fence with posts, and its gate, which stands open.
pub(super) fn fence(parameters: &Parameters) -> Mesh {
    let picket = picket(0.86);
    let run = |from: f64, to: f64| {
        let count = ((to - from) / 0.125).floor();
        let pickets = (0..count as usize).map(|i| {
            let lift = jitter(parameters.seed, 70_000 + i as u64, [-0.012, 0.012]);
            moved(
                &picket,
                [from + 0.125 * (i as f64 + 0.5), LAWN + lift, 0.02],
            )
        });
        let rails = [0.22, 0.66].map(|y| {
            let low = [from, LAWN + y, -0.03];
            bevelled_box(low, [to, LAWN + y + 0.06, 0.005], 0.004)
        });
        merged(pickets.chain(rails))
    };
    let posts = (-8..=8).map(|i| 2.8 + 2.0 * f64::from(i));
    let posts = posts.filter(|x| !(GATE_X[0] - 0.1..GATE_X[1] + 0.1).contains(x));
    let posts = posts.chain([GATE_X[0] - 0.06, GATE_X[1] + 0.06]).map(|x| {
        let low = [x - 0.05, LAWN - 0.1, -0.13];
        bevelled_box(low, [x + 0.05, LAWN + 1.0, -0.035], 0.01)
    });
    let sides = [run(-13.0, GATE_X[0] - 0.12), run(GATE_X[1] + 0.12, 18.0)];
    let line = merged(posts.chain(sides));
    let gate = set_at(&run(0.0, 1.45), [GATE_X[0] + 0.02, 0.0, 0.0], 100.0, 1.0);
    moved(&merged([line, gate]), [0.0, 0.0, FENCE_Z])
}

/// A slatted bench under the kitchen window.
pub(super) fn bench(parameters: &Parameters) -> Mesh {
    let slats = (0..4).map(|i| {
        let z = -0.2 + 0.105 * f64::from(i);
        bevelled_box([-0.75, 0.42, z], [0.75, 0.445, z + 0.09], 0.006)
    });
    let back = (0..3).map(|i| {
        let y = 0.56 + 0.12 * f64::from(i);
        let z = -0.235 - 0.02 * f64::from(i);
        bevelled_box([-0.75, y, z - 0.022], [0.75, y + 0.09, z], 0.006)
    });
    let round = parameters.steps(12);
    let frames = [-0.62, 0.62].into_iter().flat_map(|x| {
        let rod = |from: [f64; 2], to: [f64; 2]| {
            let [a, b] = [from, to].map(|[y, z]| [x, y, z]);
            capsule(a, b, [0.02, 0.02], round)
        };
        [
            rod([0.0, 0.2], [0.42, 0.17]),
            rod([0.0, -0.24], [0.43, -0.2]),
            rod([0.43, -0.22], [0.92, -0.31]),
            rod([0.4, -0.2], [0.4, 0.2]),
            rod([0.64, 0.22], [0.64, -0.24]),
            rod([0.42, 0.2], [0.64, 0.2]),
        ]
    });
    let whole = merged(slats.chain(back).chain(frames));
    moved(&whole, [-1.05, LAWN, 3.95])
}
