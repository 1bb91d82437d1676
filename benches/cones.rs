//! Cones of light in texels on surfaces: charts, blocks, updates without rays, entries in memory, and the passes of a frame.
//!
//! `cargo bench --bench cones`. Charts are those of a wavy ball of a million triangles.

use std::f32::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use lightbench::cache::cones::{Entry, Rules, Storage, Update};
use lightbench::cache::surface::{
    Blocks, Charts, Grid, Layout, Limits, Requests, Surface, surface_points,
};
use lightbench::registry::technique;
use lightbench::sample::{Frame, Rng};
use lightbench::scene::{Needs, Scene, find_scene};
use lightbench::technique::{Film, Shot, Terms};
use lightbench::trace::Tracer;
use lightbench::world::Moment;

/// Rings of the ball, of twice as many segments.
const RINGS: u32 = 500;
/// Triangles of the ball.
const TRIANGLES: u64 = 4 * (RINGS as u64) * (RINGS as u64);
/// Light samples of an update.
const SAMPLES: u32 = 8;
/// Updates that are timed together.
const UPDATES: usize = 4096;

/// A ball of radius about 1 with waves on it.
fn ball() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let segments = 2 * RINGS;
    let mut positions = Vec::new();
    for ring in 0..=RINGS {
        let (sine, cosine) = (PI * ring as f32 / RINGS as f32).sin_cos();
        for segment in 0..segments {
            let phi = TAU * segment as f32 / segments as f32;
            let direction = Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
            let wave = (40.0 * direction.x).sin() * (35.0 * direction.y).sin();
            positions.push(direction * (1.0 + 0.02 * wave));
        }
    }
    let at = |ring, segment| ring * segments + segment % segments;
    let mut triangles = Vec::new();
    for ring in 0..RINGS {
        for segment in 0..segments {
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    (positions, triangles)
}

fn charts(c: &mut Criterion) {
    let (positions, triangles) = ball();
    let mesh = 0..triangles.len();
    let mut group = c.benchmark_group("charts");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(TRIANGLES));
    group.bench_function("a ball of a million triangles", |b| {
        b.iter(|| Charts::new(&positions, &triangles, std::slice::from_ref(&mesh)));
    });
    group.finish();
}

/// Each island once, at a level where it has a few blocks.
fn requests(charts: &Charts, grid: &Grid) -> Requests {
    let mut requests = Requests::default();
    for island in 0..charts.len() as u32 {
        let surface = Surface {
            island,
            back: false,
        };
        let size = charts.size(island);
        for i in 0..64 {
            let place = size * glam::Vec2::new((i % 8) as f32, (i / 8) as f32) / 8.0;
            requests.ask(grid.nearest(surface, place, 0));
        }
    }
    requests.merge();
    requests
}

fn blocks(c: &mut Criterion) {
    let (positions, triangles) = ball();
    let charts = Charts::new(
        &positions,
        &triangles,
        std::slice::from_ref(&(0..triangles.len())),
    );
    let grid = Grid { finest: 2e-3 };
    let requests = requests(&charts, &grid);
    let keys = requests.blocks();
    let mut group = c.benchmark_group("blocks");
    group.sample_size(10);
    group.throughput(Throughput::Elements(keys.len() as u64));
    group.bench_function("surface points", |b| {
        b.iter(|| {
            for (key, _) in keys {
                black_box(surface_points(&charts, &grid, *key));
            }
        });
    });
    let limits = Limits {
        blocks: 1 << 20,
        frames: 60,
    };
    let mut pool = Blocks::new(
        limits,
        Layout {
            texel: Storage::Full { cones: 3 }.words(),
            block: 0,
        },
    );
    pool.begin(&requests, &charts, &grid);
    group.bench_function("asked for again", |b| {
        b.iter(|| pool.begin(&requests, &charts, &grid));
    });
    group.finish();
}

/// Updates of entries by samples of three lights, one of them large.
fn updates(c: &mut Criterion) {
    let rules = Rules::default();
    let lights = [
        (Vec3::new(0.0, 0.6, 0.8), 0.3),
        (Vec3::new(0.8, 0.0, 0.6), 0.05),
        (Vec3::new(-0.6, -0.48, 0.64), 0.02),
    ];
    let updated = |entry: Entry, number: u64| {
        let mut rng = Rng::new(1, 2, number, 0);
        let mut update = Update::of(entry, &rules, SAMPLES);
        for _ in 0..SAMPLES {
            let (towards, spread) = lights[rng.below(3)];
            let frame = Frame::from_normal(towards);
            let [x, y] = [0; 2].map(|_| spread * (2.0 * rng.next_f32() - 1.0));
            let direction = towards + frame.tangent * x + frame.bitangent * y;
            update.add(direction.normalize(), Vec3::splat(0.1));
        }
        update.watch();
        update.take_news();
        update.average();
        update.finish()
    };
    let entries: Vec<Entry> = (0..UPDATES as u64)
        .map(|i| (0..8).fold(Entry::default(), |entry, k| updated(entry, 8 * i + k)))
        .collect();
    let mut group = c.benchmark_group("entries");
    group.throughput(Throughput::Elements(UPDATES as u64));
    group.bench_function("updates of 8 samples", |b| {
        b.iter(|| {
            for (entry, number) in entries.iter().zip(0..) {
                black_box(updated(*entry, number));
            }
        });
    });
    for (name, storage) in [
        ("full", Storage::Full { cones: 3 }),
        ("compressed", Storage::Compressed { cones: 3 }),
    ] {
        let mut words = vec![0; storage.words()];
        group.bench_function(format!("{name}: written and read"), |b| {
            b.iter(|| {
                for entry in &entries {
                    storage.write(entry, &mut words);
                    black_box(storage.read(&words));
                }
            });
        });
    }
    group.finish();
}

/// Frames before a scene at rest is timed.
const WARM_UP: u32 = 12;

/// Processor seconds of the passes over a scene at rest: what finds the texels that a viewer sees, camera rays among it, and
/// what puts up to three cones of four texels into the material of each of four camera samples a pixel.
fn passes(c: &mut Criterion) {
    let description = find_scene("cornell-curved").expect("shipped");
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: 480,
        height: 270,
        spp: 4,
    };
    let entry = technique("direct-lighting").expect("listed");
    let technique = (entry.build)(&toml::Table::new()).expect("defaults");
    let terms = Terms { budget: 8, seed: 1 };
    let started = technique.start("light-cones", &toml::Table::new(), terms);
    let mut contender = started.expect("starts").contender;
    let mut frame = 0;
    let mut play = |stage: &str| {
        let mut shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
        shot.frame = frame;
        frame += 1;
        let images = contender.frame(&[shot]).expect("a frame");
        let stages = images[0].stages.0.iter();
        let seconds = stages.filter(|s| s.name == stage).map(|s| s.seconds.cpu);
        Duration::from_secs_f64(seconds.sum())
    };
    (0..WARM_UP).for_each(|_| {
        play("");
    });
    let mut group = c.benchmark_group("passes, processor time");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements((film.width * film.height) as u64));
    for stage in ["visibility", "shading"] {
        group.bench_function(stage, |b| {
            b.iter_custom(|frames| (0..frames).map(|_| play(stage)).sum());
        });
    }
    group.finish();
}

criterion_group!(benches, charts, blocks, updates, passes);
criterion_main!(benches);
