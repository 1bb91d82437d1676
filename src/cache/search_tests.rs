use glam::{Vec3, Vec3A};

use super::super::tree::squared_distance;
use super::*;
use crate::cache::TangentMetric;
use crate::sample::Rng;

/// Records, or queries.
#[derive(Clone, Copy)]
struct Set<'a> {
    positions: &'a [Vec3],
    normals: &'a [Vec3],
}

fn set<'a>(positions: &'a [Vec3], normals: &'a [Vec3]) -> Set<'a> {
    Set { positions, normals }
}

/// The rule to the letter over all records, for the query at `p` with the normal `n`.
fn brute_force(records: Set, p: Vec3, n: Vec3, rule: &SearchRule) -> Vec<Neighbour> {
    let Set { positions, normals } = records;
    if !p.is_finite() || !n.is_finite() {
        return Vec::new();
    }
    let cosine = |i: usize| {
        let m = normals[i];
        m.x * n.x + m.y * n.y + m.z * n.z
    };
    let squared = |i: usize| squared_distance(Vec3A::from(positions[i]), Vec3A::from(p));
    let mut nearest: Vec<usize> = (0..positions.len())
        .filter(|&i| positions[i].is_finite() && normals[i].is_finite())
        .collect();
    nearest.sort_by(|&a, &b| squared(a).total_cmp(&squared(b)).then(a.cmp(&b)));
    nearest.truncate(rule.candidates);
    let least = f64::from(rule.max_angle_deg).to_radians().cos() as f32;
    let unfiltered = rule.max_angle_deg >= 180.0;
    let facing = |i: &usize| unfiltered || cosine(*i) >= least;
    let mut left: Vec<usize> = nearest.iter().copied().filter(facing).collect();
    if left.is_empty() {
        left = nearest;
    }
    let plane = |i: usize| {
        let d = positions[i] - p;
        let along = |n: Vec3| (d.x * n.x + d.y * n.y + d.z * n.z).abs();
        along(n).max(along(normals[i]))
    };
    let mut found: Vec<Neighbour> = left
        .into_iter()
        .map(|i| Neighbour {
            record: i as u32,
            distance: rule.metric.distance(squared(i), plane(i), cosine(i)),
        })
        .collect();
    found.sort_by(|a, b| {
        a.distance
            .total_cmp(&b.distance)
            .then(a.record.cmp(&b.record))
    });
    found.truncate(rule.used);
    found
}

fn agree(records: Set, queries: Set, rule: SearchRule) {
    let search = RecordSearch::new(records.positions, records.normals, rule);
    let Set { positions, normals } = queries;
    let answers = search.map(positions, normals, |_, found| found.to_vec());
    assert_eq!(answers.len(), positions.len());
    for (i, answer) in answers.iter().enumerate() {
        let expected = brute_force(records, positions[i], normals[i], &rule);
        assert_eq!(answer, &expected, "query {i} at {}", positions[i]);
    }
}

fn rule(lambda: f32) -> SearchRule {
    SearchRule::paper(DistanceMetric { lambda })
}

/// A bumpy sheet with a step in depth; normals vary by more than θ_max.
fn surface(count: usize, seed: u64) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut rng = Rng::new(seed, 0, 0, 0);
    (0..count)
        .map(|_| {
            let (x, y) = (rng.next_f32() * 4.0, rng.next_f32() * 3.0);
            let z = (x * 3.0).sin() * 0.3 + if y > 1.5 { 5.0 } else { 0.0 };
            let n = Vec3::new(-(x * 3.0).cos() * 0.9, rng.next_f32() - 0.5, 1.0);
            (Vec3::new(x, y, z), n.normalize())
        })
        .unzip()
}

/// Queries as an image sees them: row by row.
fn image(width: usize, height: usize) -> (Vec<Vec3>, Vec<Vec3>) {
    (0..width * height)
        .map(|i| {
            let x = (i % width) as f32 / width as f32 * 4.0;
            let y = (i / width) as f32 / height as f32 * 3.0;
            let z = (x * 3.0).sin() * 0.3 + if y > 1.5 { 5.0 } else { 0.0 };
            let n = Vec3::new(-(x * 3.0).cos() * 0.9, 0.1, 1.0);
            (Vec3::new(x, y, z), n.normalize())
        })
        .unzip()
}

#[test]
fn equals_brute_force_on_a_surface_for_every_metric() {
    let (p, n) = surface(600, 1);
    let (qp, qn) = image(60, 45);
    for lambda in [0.0, 0.05, 0.5, 20.0] {
        agree(set(&p, &n), set(&qp, &qn), rule(lambda));
    }
    agree(set(&p, &n), set(&qp, &qn), SearchRule::spatial(12));
    for (across, bend) in [(16.0, 0.3), (0.0, 0.0), (1e4, 1e4)] {
        let tangent = SearchRule {
            candidates: 24,
            max_angle_deg: 60.0,
            metric: Ranking::Tangent(TangentMetric { across, bend }),
            ..rule(0.0)
        };
        agree(set(&p, &n), set(&qp, &qn), tangent);
    }
    let odd = SearchRule {
        candidates: 5,
        used: 9,
        max_angle_deg: 10.0,
        ..rule(0.1)
    };
    agree(set(&p, &n), set(&qp, &qn), odd);
}

#[test]
fn equals_brute_force_for_queries_in_random_order_and_far_away() {
    let (p, n) = surface(3000, 2);
    let (mut qp, qn) = surface(2000, 3);
    for (i, q) in qp.iter_mut().enumerate() {
        if i % 7 == 0 {
            *q *= 1000.0;
        }
    }
    agree(set(&p, &n), set(&qp, &qn), rule(0.02));
}

#[test]
fn few_records_are_all_candidates() {
    let (qp, qn) = image(9, 7);
    for count in [0, 1, 5, 19, 20, 21] {
        let (p, n) = surface(count, 4);
        agree(set(&p, &n), set(&qp, &qn), rule(0.1));
    }
}

#[test]
fn ties_go_to_the_lower_index() {
    let n = vec![Vec3::Z; 100];
    let coincident = vec![Vec3::ONE; 100];
    let lattice: Vec<Vec3> = (0..100)
        .map(|i| Vec3::new((i % 10) as f32, (i / 10) as f32, 0.0))
        .collect();
    let line: Vec<Vec3> = (0..100).map(|i| Vec3::X * (i / 3) as f32).collect();
    for records in [&coincident, &lattice, &line] {
        let half: Vec<Vec3> = records.iter().map(|p| *p + Vec3::splat(0.5)).collect();
        for queries in [&coincident, &lattice, &line, &half] {
            agree(set(records, &n), set(queries, &n), rule(0.05));
        }
    }
    let search = RecordSearch::new(&coincident, &n, rule(0.0));
    let found = search.map(&coincident[..1], &n[..1], |_, f| {
        f.iter().map(|n| n.record).collect::<Vec<_>>()
    });
    assert_eq!(found, [[0, 1, 2, 3, 4, 5]]);
}

#[test]
fn all_candidates_stay_if_the_filter_drops_all() {
    let (p, _) = surface(200, 5);
    let (qp, _) = image(8, 8);
    let up = vec![Vec3::Z; 200];
    let down = vec![-Vec3::Z; 64];
    agree(set(&p, &up), set(&qp, &down), rule(0.3));
}

#[test]
fn what_is_not_finite_is_never_found_and_finds_nothing() {
    let (mut p, mut n) = surface(60, 6);
    p[3].x = f32::NAN;
    n[4].y = f32::INFINITY;
    let (mut qp, mut qn) = image(6, 6);
    qp[7].z = f32::NAN;
    qn[8].z = f32::NAN;
    agree(set(&p, &n), set(&qp, &qn), rule(0.1));
    let search = RecordSearch::new(&p, &n, rule(0.1));
    let counts = search.map(&qp, &qn, |_, found| found.len());
    assert_eq!((counts[7], counts[8], counts[9]), (0, 0, 6));
}

#[test]
fn extreme_scales_and_offsets_agree_with_brute_force() {
    let (p, n) = surface(300, 7);
    let (qp, qn) = image(24, 16);
    for (scale, offset) in [
        (1e-3, 0.0),
        (1e5, 0.0),
        (1.0, 1e4),
        (1e-20, 0.0),
        (1e19, 0.0),
    ] {
        let move_all = |v: &[Vec3]| -> Vec<Vec3> {
            v.iter().map(|p| *p * scale + Vec3::splat(offset)).collect()
        };
        agree(
            set(&move_all(&p), &n),
            set(&move_all(&qp), &qn),
            rule(0.05 * scale),
        );
    }
}

#[test]
fn threads_do_not_change_the_answers() {
    let (p, n) = surface(500, 8);
    let (qp, qn) = image(300, 200);
    let search = RecordSearch::new(&p, &n, rule(0.05));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| search.map(&qp, &qn, |_, found| found.to_vec()))
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn for_each_visits_every_query_once() {
    use std::sync::atomic::{AtomicU32, Ordering};
    let (p, n) = surface(50, 9);
    let (qp, qn) = image(200, 150);
    let visits: Vec<AtomicU32> = qp.iter().map(|_| AtomicU32::new(0)).collect();
    RecordSearch::new(&p, &n, rule(0.05)).map(&qp, &qn, |i, found| {
        assert!(!found.is_empty());
        visits[i].fetch_add(1, Ordering::Relaxed);
    });
    assert!(visits.iter().all(|v| v.load(Ordering::Relaxed) == 1));
}
