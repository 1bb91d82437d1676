//! Light generation of every sampler: a 2048×1024 map, 32 lights, one thread.

use criterion::{Criterion, criterion_group, criterion_main};
use lightbench::environment::ENVIRONMENT_SAMPLERS;
use lightbench::environment::{Environment, EnvironmentOptions, EnvironmentSampler, embedded_map};
use lightbench::image::Image;

/// The map of this name at twice its size, each texel four times.
fn doubled(name: &str) -> Environment {
    let small = embedded_map(name).expect("an embedded map");
    let large: Image = small.resize_nearest(2 * small.width, 2 * small.height);
    Environment::from_image(&large, &EnvironmentOptions::default()).expect("a map")
}

fn light_generation(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    let mut group = criterion.benchmark_group("32 lights of 2048x1024 texels");
    group.sample_size(10);
    for name in ["afternoon", "living-room", "canopy"] {
        let map = doubled(name);
        for entry in ENVIRONMENT_SAMPLERS {
            let sampler = (entry.build)(&toml::Table::new()).expect("defaults");
            let EnvironmentSampler::Lights(sampler) = sampler else {
                continue;
            };
            group.bench_function(format!("{} {name}", entry.about.id), |bencher| {
                bencher.iter(|| pool.install(|| sampler.lights(&map, 32, 1)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, light_generation);
criterion_main!(benches);
