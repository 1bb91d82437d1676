//! What a frame costs in which 1 % of the triangles move, against building the whole tree again.

use glam::Vec3;
use lightbench::trace::{RayCounter, Tracer};

use super::sets::ray_sets;
use super::{ROUNDS, Scene, all_cpu_seconds, timed};

/// One triangle in so many moves: the last ones, which are neighbours.
const SHARE: usize = 100;

/// Prints the CPU seconds of a frame as a share of those of the whole tree, and what rays cost that ask
/// both trees.
pub fn report(scene: &Scene) {
    let count = scene.triangles.len();
    let first = count - count / SHARE;
    let moving: Vec<bool> = (0..count).map(|i| i >= first).collect();
    let mut positions = scene.positions.clone();
    let mut vertices: Vec<u32> = scene.triangles[first..].iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let one = Tracer::new(&positions, &scene.triangles);
    let mut two = Tracer::with_moving(&positions, &scene.triangles, &moving);
    let (mut whole, mut frame) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        for &i in &vertices {
            positions[i as usize] += Vec3::new(0.01, 0.02, -0.01);
        }
        whole = whole.min(cpu(|| drop(Tracer::new(&positions, &scene.triangles))));
        frame = frame.min(cpu(|| two.moved(&positions)));
    }
    println!(
        "{}: {} of {count} triangles move: {:.1} ms of CPU time a frame, {:.2} % of the {:.0} ms of the \
         whole tree",
        scene.name,
        count - first,
        1e3 * frame,
        100.0 * frame / whole,
        1e3 * whole
    );
    two.moved(&scene.positions);
    println!("\n| rays that ask two trees, CPU time | single | bundle |\n|---|--:|--:|");
    for set in ray_sets(scene, &one) {
        let ratio = |bundled: bool| {
            let cast = |tracer: &Tracer| {
                let counter = RayCounter::default();
                timed(|| set.work.cast(&tracer.caster(&counter), bundled)).0
            };
            let best = |best: [f64; 2]| [best[0].min(cast(&one)), best[1].min(cast(&two))];
            let [alone, both] = (0..ROUNDS).fold([f64::INFINITY; 2], |b, _| best(b));
            format!("{:.2} ×", both / alone)
        };
        let bundle = if set.work.has_bundles() {
            ratio(true)
        } else {
            "–".into()
        };
        println!("| {} | {} | {bundle} |", set.name, ratio(false));
    }
    println!();
}

fn cpu(work: impl FnOnce()) -> f64 {
    let start = all_cpu_seconds();
    work();
    all_cpu_seconds() - start
}
