//! First stages and refinements at 1920 × 1080 with 120,000 records.
//!
//! `cargo bench --bench placement`; add a name to run one. Compare within one run only.

mod gbuffer;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use lightbench::cache::{DistanceMetric, RecordSearch, SearchRule};
use lightbench::placement::{Records, Refinable};
use lightbench::placement::{first_stage, refinement};

const RECORDS: usize = 120_000;
const REFINED: usize = 18_000;

fn placement(criterion: &mut Criterion) {
    let points = gbuffer::points(1920, 1080);
    println!("{} shading points", points.len());
    let mut group = criterion.benchmark_group("first stage");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for (id, parameters) in [
        ("im", ""),
        ("im", "pattern = 'jittered'"),
        ("sd", "min_cluster_size = 1"),
        ("sd", "min_cluster_size = 10"),
        ("vgc", ""),
        ("vgc", "angle_deg = 25"),
    ] {
        let table: toml::Table = parameters.parse().expect("valid toml");
        let entry = first_stage(id).expect("registered");
        let stage = (entry.build)(&table).expect("valid parameters");
        println!(
            "{id} {parameters}: {:?}",
            stage.place(&points, RECORDS, 1).found
        );
        group.bench_function(format!("{id} {parameters}"), |b| {
            b.iter(|| stage.place(&points, RECORDS, 1));
        });
    }
    group.finish();
}

fn refinements(criterion: &mut Criterion) {
    let points = gbuffer::points(1920, 1080);
    let entry = first_stage("vgc").expect("registered");
    let stage = (entry.build)(&toml::Table::new()).expect("defaults");
    let sites = stage.place(&points, RECORDS - REFINED, 1).sites;
    let (p, n): (Vec<_>, Vec<_>) = sites
        .iter()
        .map(|&i| (points.position[i as usize], points.normal[i as usize]))
        .unzip();
    let metric = DistanceMetric::literal(points.diagonal, 1.0);
    let search = RecordSearch::new(&p, &n, SearchRule::paper(metric));
    // 1024 bits for each record, as ambient occlusion has; their content does not matter here.
    let bits = |i: u32| -> Vec<u64> {
        let mut rng = lightbench::sample::Rng::new(1, 0, u64::from(i / 64), 0);
        (0..16).map(|_| rng.next_u64() & rng.next_u64()).collect()
    };
    let bits: Vec<Vec<u64>> = (0..sites.len() as u32).map(bits).collect();
    let difference = |a: u32, b: u32| {
        let (a, b) = (&bits[a as usize], &bits[b as usize]);
        a.iter()
            .zip(b)
            .map(|(x, y)| (x ^ y).count_ones())
            .sum::<u32>() as f32
    };
    let mut input = Refinable {
        points: &points,
        sites: &sites,
        search: &search,
        power: 1,
        records: &mut Compared(difference),
    };
    let mut group = criterion.benchmark_group("refinement");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for (id, parameters) in [("as", ""), ("dgs", ""), ("dgs", "terms = 'geom'")] {
        let table: toml::Table = parameters.parse().expect("valid toml");
        let entry = refinement(id).expect("registered");
        let method = (entry.build)(&table).expect("valid parameters");
        println!(
            "{id} {parameters}: {:?}",
            method.refine(&mut input, REFINED, 1).found
        );
        group.bench_function(format!("{id} {parameters}"), |b| {
            b.iter(|| method.refine(&mut input, REFINED, 1));
        });
    }
    group.finish();
}

/// Records that are compared only.
struct Compared<F>(F);

impl<F: Fn(u32, u32) -> f32 + Sync> Records for Compared<F> {
    fn difference(&self, a: u32, b: u32) -> f32 {
        self.0(a, b)
    }

    fn predict(&self, _: u32, _: u32) -> (glam::Vec3, f32) {
        (glam::Vec3::ZERO, 1.0)
    }

    fn add(&mut self, _: &[u32]) {}
}

criterion_group!(benches, placement, refinements);
criterion_main!(benches);
