//! Nearest-record search against kiddo: 2 million image-ordered queries over 120,000 records.
//!
//! `cargo bench --bench lookup`. Before timing it checks that both give the same neighbours.

mod gbuffer;

use std::num::NonZero;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use lightbench::cache::{DistanceMetric, Neighbour, RecordSearch, SearchRule, ShadingPoints};
use lightbench::sample::Rng;

const RECORDS: usize = 120_000;

fn records(points: &ShadingPoints) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut rng = Rng::new(5, 0, 0, 0);
    (0..RECORDS)
        .map(|_| rng.below(points.len()))
        .map(|i| (points.position[i], points.normal[i]))
        .unzip()
}

/// The same rule over kiddo's neighbours; returns a sum that depends on all of them.
struct Kiddo<'a> {
    tree: ImmutableKdTree<f32, 3>,
    records: &'a (Vec<Vec3>, Vec<Vec3>),
    rule: SearchRule,
}

impl Kiddo<'_> {
    fn query(&self, p: Vec3, n: Vec3, found: &mut Vec<Neighbour>) {
        let count = NonZero::new(self.rule.candidates).expect("N is positive");
        let nearest = self
            .tree
            .query(&p.to_array())
            .nearest_n::<SquaredEuclidean<f32>>(count)
            .execute();
        let least = self.rule.max_angle_deg.to_radians().cos();
        let take = |least: f32, found: &mut Vec<Neighbour>| {
            found.clear();
            for item in &nearest {
                let cosine = self.records.1[item.item as usize].dot(n);
                if cosine >= least {
                    found.push(Neighbour {
                        record: item.item,
                        distance: self.rule.metric.distance(item.distance, 0.0, cosine),
                    });
                }
            }
        };
        take(least, found);
        if found.is_empty() {
            take(-2.0, found);
        }
        found.sort_by(|a, b| {
            (a.distance, a.record)
                .partial_cmp(&(b.distance, b.record))
                .expect("finite")
        });
        found.truncate(self.rule.used);
    }
}

fn lookup(criterion: &mut Criterion) {
    let points = gbuffer::points(1920, 1080);
    let records = records(&points);
    let rule = SearchRule::paper(DistanceMetric::literal(points.diagonal, 1.0));
    let search = RecordSearch::new(&records.0, &records.1, rule);
    let entries: Vec<[f32; 3]> = records.0.iter().map(Vec3::to_array).collect();
    let kiddo = Kiddo {
        tree: ImmutableKdTree::new_from_slice(&entries).expect("finite points"),
        records: &records,
        rule,
    };
    compare(&points, &search, &kiddo);

    let mut group = criterion.benchmark_group("lookup");
    group
        .sampling_mode(SamplingMode::Flat)
        .sample_size(10)
        .throughput(Throughput::Elements(points.len() as u64));
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    group.bench_function("tiles, 1 thread", |b| {
        b.iter(|| {
            one.install(|| search.map(&points.position, &points.normal, |_, f| f[0].distance))
        });
    });
    group.bench_function("kiddo, 1 thread", |b| {
        b.iter(|| {
            let mut found = Vec::new();
            (0..points.len())
                .map(|i| {
                    kiddo.query(points.position[i], points.normal[i], &mut found);
                    found[0].distance
                })
                .collect::<Vec<f32>>()
        });
    });
    group.finish();
    criterion.bench_function("build over 120,000 records", |b| {
        b.iter(|| RecordSearch::new(&records.0, &records.1, rule));
    });
}

/// Prints how many of a sample of queries differ in a record.
fn compare(points: &ShadingPoints, search: &RecordSearch, kiddo: &Kiddo) {
    let ours = search.map(&points.position, &points.normal, |_, f| {
        f.iter().map(|n| n.record).collect::<Vec<_>>()
    });
    let mut found = Vec::new();
    let step = 7;
    let differing = (0..points.len())
        .step_by(step)
        .filter(|&i| {
            kiddo.query(points.position[i], points.normal[i], &mut found);
            !found.iter().map(|n| n.record).eq(ours[i].iter().copied())
        })
        .count();
    let compared = points.len().div_ceil(step);
    println!("{differing} of {compared} queries differ from kiddo's (rounding and ties)");
}

criterion_group!(benches, lookup);
criterion_main!(benches);
