//! The layered filter: pixels per second of one layer.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use lightbench::sample::Rng;
use lightbench::technique::radiance::filter::{Filter, FilterParameters};
use lightbench::technique::radiance::layers::{LayerVertex, Layers, Setting, Smoothing};

const SIDE: usize = 1024;

/// A tilted wall with a noisy light and a chequered albedo.
fn layers() -> Layers {
    let mut layers = Layers::new(SIDE, SIDE, 1);
    layers.fill(|mut row, y| {
        for x in 0..SIDE {
            let mut rng = Rng::new(1, 2, (y * SIDE + x) as u64, 0);
            let chequer = if (x / 64 + y / 64).is_multiple_of(2) {
                0.8
            } else {
                0.3
            };
            let vertex = LayerVertex {
                normal: Vec3::new(0.6, 0.0, 0.8),
                path_length: 3.0 + x as f32 * 1e-3,
                albedo: Some(Vec3::new(chequer, 0.5, 0.4)),
                base: Vec3::splat(rng.next_f32()),
                ..LayerVertex::default()
            };
            row.put(0, x, &vertex);
        }
        (1, ())
    });
    layers
}

fn filter(c: &mut Criterion) {
    let mut layers = layers();
    let mut group = c.benchmark_group("a layer of 1024²");
    group.sample_size(10);
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    for (name, smoothing) in [("off", Smoothing::Off), ("layered", Smoothing::Layered)] {
        let setting = Setting {
            smoothing,
            filter: Filter::new(FilterParameters::default()),
            exposure: 1.0,
        };
        group.bench_function(name, |b| b.iter(|| layers.image(&setting)));
    }
    group.finish();
}

criterion_group!(benches, filter);
criterion_main!(benches);
