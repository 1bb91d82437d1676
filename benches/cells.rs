//! Cells of a scene in world space: finding those that are occupied, building their maps, looking up, reading, and merging samples.
//!
//! `cargo bench --bench cells`. The scene is six walls around a ball of 260,000 triangles. Lookups are compared with a
//! `std::collections::HashMap` of the same keys and a fast hasher; before timing each map is checked to hold them all.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::hash::{BuildHasherDefault, Hasher};
use std::hint::black_box;

use criterion::{
    BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use glam::Vec3;
use lightbench::cache::hash::{
    CellMap, Grid, HashCells, MapKind, Options, Precision, Sample, occupied_cells,
};
use lightbench::sample::{Rng, hash};

const KINDS: [MapKind; 4] = [
    MapKind::Blocks,
    MapKind::Cuckoo,
    MapKind::CuckooThree,
    MapKind::OpenAddressing,
];

/// Rings of the ball, of twice as many segments.
const RINGS: u32 = 256;
/// Queries of a lookup, and samples of an update.
const QUERIES: usize = 1 << 20;

/// Hashes a key with the function that the maps have.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, _: &[u8]) {
        unreachable!("keys are u64");
    }

    fn write_u64(&mut self, key: u64) {
        self.0 = hash(key);
    }
}

type Reference = HashMap<u64, u32, BuildHasherDefault<Mixer>>;

struct Scene {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// Two walls across each axis, ten apart, and a ball between them.
fn scene() -> Scene {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for wall in 0..6 {
        let (axis, at) = (wall / 2, (wall % 2) as f32 * 10.0);
        let first = positions.len() as u32;
        for [u, v] in [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]] {
            let mut corner = Vec3::splat(at);
            corner[(axis + 1) % 3] = u;
            corner[(axis + 2) % 3] = v;
            positions.push(corner);
        }
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v: u32| first + v)));
    }
    let first = positions.len() as u32;
    let segments = 2 * RINGS;
    for ring in 0..=RINGS {
        let theta = PI * ring as f32 / RINGS as f32;
        for segment in 0..segments {
            let phi = TAU * segment as f32 / segments as f32;
            let normal = Vec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            positions.push(Vec3::splat(5.0) + 3.0 * normal);
        }
    }
    let at = |ring, segment| first + ring * segments + segment % segments;
    for ring in 0..RINGS {
        for segment in 0..segments {
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    Scene {
        positions,
        triangles,
    }
}

/// Samples on random triangles, half on the walls.
fn samples(scene: &Scene, count: usize) -> Vec<Sample> {
    let mut rng = Rng::new(2, 0, 0, 0);
    (0..count)
        .map(|i| {
            let among = if i % 2 == 0 {
                12
            } else {
                scene.triangles.len()
            };
            let triangle = scene.triangles[rng.below(among)];
            let [a, b, c] = triangle.map(|vertex| scene.positions[vertex as usize]);
            let (mut u, mut v) = (rng.next_f32(), rng.next_f32());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            Sample {
                position: a + (b - a) * u + (c - a) * v,
                normal: (b - a).cross(c - a).normalize_or_zero(),
                value: Vec3::splat(rng.next_f32()),
            }
        })
        .collect()
}

fn rasterise(criterion: &mut Criterion) {
    let scene = scene();
    let mut group = criterion.benchmark_group("occupied cells");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for levels in [10, 11] {
        let grid = Grid::around(&scene.positions, &scene.triangles, levels);
        let run = || occupied_cells(&grid, &scene.positions, &scene.triangles);
        let cells = run().len();
        println!("{cells} cells at {}³", 1 << levels);
        group.throughput(Throughput::Elements(cells as u64));
        group.bench_function(BenchmarkId::from_parameter(1 << levels), |b| b.iter(run));
    }
    group.finish();
}

fn maps(criterion: &mut Criterion) {
    let scene = scene();
    let grid = Grid::around(&scene.positions, &scene.triangles, 10);
    let keys = occupied_cells(&grid, &scene.positions, &scene.triangles);
    let reference = || -> Reference { keys.iter().copied().zip(0..).collect() };

    let mut group = criterion.benchmark_group("build a map");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.throughput(Throughput::Elements(keys.len() as u64));
    for kind in KINDS {
        let name = format!("{kind:?}");
        group.bench_function(name, |b| b.iter(|| CellMap::build(&keys, kind)));
    }
    group.bench_function("HashMap", |b| b.iter(reference));
    group.finish();

    let mut rng = Rng::new(1, 0, 0, 0);
    let hits: Vec<u64> = (0..QUERIES).map(|_| keys[rng.below(keys.len())]).collect();
    let misses: Vec<u64> = (0..QUERIES)
        .map(|_| rng.next_u64() >> 34)
        .filter(|key| keys.binary_search(key).is_err())
        .collect();
    let mut group = criterion.benchmark_group("look up, 1 thread");
    group.sample_size(20);
    for (name, queries) in [("hits", &hits), ("misses", &misses)] {
        group.throughput(Throughput::Elements(queries.len() as u64));
        for kind in KINDS {
            let map = CellMap::build(&keys, kind);
            assert!(
                keys.iter()
                    .zip(0..)
                    .all(|(&key, rank)| map.find(key) == Some(rank))
            );
            println!(
                "{kind:?}: {} bytes, {} rebuilds",
                map.bytes(),
                map.rebuilds()
            );
            group.bench_function(format!("{name}, {kind:?}"), |b| {
                b.iter(|| {
                    queries
                        .iter()
                        .filter_map(|&key| map.find(key))
                        .map(u64::from)
                        .sum::<u64>()
                })
            });
        }
        let map = reference();
        group.bench_function(format!("{name}, HashMap"), |b| {
            b.iter(|| {
                let found = queries.iter().filter_map(|key| map.get(key));
                found.map(|&rank| u64::from(rank)).sum::<u64>()
            });
        });
    }
    group.finish();
}

fn update(criterion: &mut Criterion) {
    let scene = scene();
    let samples = samples(&scene, QUERIES);
    let mut group = criterion.benchmark_group("update, all levels");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    group.throughput(Throughput::Elements(samples.len() as u64));
    for precision in [Precision::Half, Precision::Single] {
        let options = Options {
            levels: 10,
            map: MapKind::Cuckoo,
            precision,
        };
        let mut cells = HashCells::new(&scene.positions, &scene.triangles, options)
            .expect("fewer cells than indices");
        let update = cells.update(samples.clone());
        println!("{precision:?}: {} bytes, {update:?}", cells.bytes());
        group.bench_function(format!("{precision:?}"), |b| {
            b.iter(|| black_box(cells.update(samples.clone())));
        });
    }
    group.finish();
}

/// What reconstruction does at a surface point, but for the ray that finds it.
fn look(criterion: &mut Criterion) {
    let scene = scene();
    let places = samples(&scene, QUERIES);
    let mut group = criterion.benchmark_group("light at a surface point, 1 thread");
    group.sample_size(20);
    group.throughput(Throughput::Elements(QUERIES as u64));
    for map in KINDS {
        let options = Options {
            levels: 10,
            map,
            precision: Precision::Single,
        };
        let mut cells = HashCells::new(&scene.positions, &scene.triangles, options)
            .expect("fewer cells than indices");
        cells.update(places.clone());
        group.bench_function(format!("{map:?}"), |b| {
            b.iter(|| {
                for place in &places {
                    black_box(cells.look(10, place.position, place.normal));
                }
            });
        });
    }
    group.finish();
}

criterion_group!(benches, rasterise, maps, update, look);
criterion_main!(benches);
