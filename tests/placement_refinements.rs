//! Every registered refinement over ordinary and hard records.

mod placement_scenes;

use std::collections::HashSet;
use std::sync::Mutex;

use glam::Vec3;
use lightbench::cache::{DistanceMetric, RecordSearch, SearchRule, ShadingPoints};
use lightbench::placement::{self, Placement, Refinable, Refinement};
use lightbench::placement::{REFINEMENTS, first_stage, refinement};
use placement_scenes::*;

fn build(id: &str, parameters: &str) -> Box<dyn Refinement> {
    let table: toml::Table = parameters.parse().expect("valid toml");
    (refinement(id).expect("registered").build)(&table).expect("valid parameters")
}

fn contenders() -> Vec<(String, Box<dyn Refinement>)> {
    let settings = [
        ("dgs", "terms = 'diff'"),
        ("dgs", "terms = 'geom'"),
        ("dgs", "records = 4\nclamp_percentile = 99.9"),
        ("as", "records = 12\nratio = 0.4"),
    ];
    let defaults = REFINEMENTS.iter().map(|entry| (entry.about.id, ""));
    defaults
        .chain(settings)
        .map(|(id, p)| (format!("{id} {p}"), build(id, p)))
        .collect()
}

/// Records at random pixels, whose value is `shade` of the position.
struct Records<'a> {
    points: &'a ShadingPoints,
    sites: Vec<u32>,
    search: RecordSearch,
    values: Vec<f32>,
    shade: fn(Vec3) -> f32,
}

/// The values alone, as refinements see them.
struct Values<'a> {
    points: &'a ShadingPoints,
    shade: fn(Vec3) -> f32,
    values: Vec<f32>,
}

impl placement::Records for Values<'_> {
    fn difference(&self, a: u32, b: u32) -> f32 {
        (self.values[a as usize] - self.values[b as usize]).abs()
    }

    fn predict(&self, record: u32, _: u32) -> (Vec3, f32) {
        (Vec3::splat(self.values[record as usize]), 1.0)
    }

    fn add(&mut self, points: &[u32]) {
        let value = |&i: &u32| (self.shade)(self.points.position[i as usize]);
        self.values.extend(points.iter().map(value));
    }
}

/// Refinements that compare nothing twice, or nothing at all.
struct Compared<F>(F);

impl<F: Fn(u32, u32) -> f32 + Sync> placement::Records for Compared<F> {
    fn difference(&self, a: u32, b: u32) -> f32 {
        self.0(a, b)
    }

    fn predict(&self, _: u32, _: u32) -> (Vec3, f32) {
        (Vec3::ZERO, 1.0)
    }

    fn add(&mut self, _: &[u32]) {}
}

impl<'a> Records<'a> {
    fn new(points: &'a ShadingPoints, count: usize, shade: fn(Vec3) -> f32) -> Self {
        let stage = (first_stage("im").expect("registered").build)(&toml::Table::new());
        let sites = stage.expect("defaults").place(points, count, 5).sites;
        let (p, n): (Vec<Vec3>, Vec<Vec3>) = sites
            .iter()
            .map(|&i| (points.position[i as usize], points.normal[i as usize]))
            .unzip();
        let metric = DistanceMetric::literal(points.diagonal, points.metres_per_unit);
        Self {
            points,
            search: RecordSearch::new(&p, &n, SearchRule::paper(metric)),
            values: p.into_iter().map(shade).collect(),
            sites,
            shade,
        }
    }

    fn with<T>(&self, act: impl FnOnce(&mut Refinable) -> T) -> T {
        act(&mut Refinable {
            points: self.points,
            sites: &self.sites,
            search: &self.search,
            power: 1,
            records: &mut Values {
                points: self.points,
                shade: self.shade,
                values: self.values.clone(),
            },
        })
    }

    fn refine(&self, method: &dyn Refinement, count: usize, seed: u64) -> Placement {
        self.with(|input| method.refine(input, count, seed))
    }

    fn assert_exact(&self, name: &str, placement: &Placement, count: usize) {
        let new: HashSet<u32> = placement.sites.iter().copied().collect();
        assert_eq!(new.len(), placement.sites.len(), "{name}: distinct");
        let free = self.points.len() - self.sites.len();
        assert_eq!(new.len(), count.min(free), "{name}: {count} asked");
        assert!(
            self.sites.iter().all(|i| !new.contains(i)),
            "{name}: no record twice"
        );
    }
}

/// A shadow edge.
fn edge(p: Vec3) -> f32 {
    if p.x + 0.3 * p.y > 0.4 { 100.0 } else { 0.0 }
}

#[test]
fn counts_are_exact_and_sites_new_on_every_set() {
    let sets = [
        ("room", room(64, 48)),
        ("identical", identical(20, 10)),
        ("plane", plane(30, 20)),
        ("antipodal", antipodal(20, 10)),
        ("dome", dome(24, 24)),
        ("one point", plane(1, 1)),
        ("sky", film((8, 8), |_, _| None)),
        ("a row", room(400, 1)),
    ];
    for (name, method) in contenders() {
        for (set, points) in &sets {
            for records in [0, 1, 2, 5, 19, 60, points.len()] {
                let records = Records::new(points, records, edge);
                for count in [0, 1, 2, 10, 5000] {
                    let placement = records.refine(&*method, count, 1);
                    records.assert_exact(&format!("{name} on {set}"), &placement, count);
                }
            }
        }
    }
}

#[test]
fn seeds_decide_and_threads_do_not() {
    let points = room(200, 150);
    let records = Records::new(&points, 400, edge);
    let run = |method: &dyn Refinement, threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("a pool");
        pool.install(|| {
            (
                records.refine(method, 60, seed).sites,
                records.with(|i| method.refine(i, 1, 1).map),
            )
        })
    };
    for (name, method) in contenders() {
        assert_eq!(run(&*method, 1, 7), run(&*method, 2, 7), "{name}");
        if name.starts_with("dgs") {
            assert_ne!(run(&*method, 1, 7).0, run(&*method, 1, 8).0, "{name}");
        }
    }
}

#[test]
fn new_records_gather_at_the_edge() {
    let points = plane(160, 120);
    let records = Records::new(&points, 600, edge);
    let near = |i: &u32| {
        let p = points.position[*i as usize];
        (p.x + 0.3 * p.y - 0.4).abs() < 0.3
    };
    let chance = (0..points.len() as u32).filter(near).count() as f64 / points.len() as f64;
    for (name, method) in contenders() {
        let sites = records.refine(&*method, 50, 1).sites;
        let share = sites.iter().filter(|i| near(i)).count() as f64 / 50.0;
        if name.contains("geom") {
            assert!(
                (share - chance).abs() < 0.2,
                "{name}: {share}, by chance {chance}"
            );
        } else {
            assert!(share > 0.9, "{name}: {share}, by chance {chance}");
        }
    }
}

#[test]
fn a_flat_map_falls_back_to_uniform_and_says_so() {
    let points = plane(40, 30);
    let records = Records::new(&points, 50, |_| 1.0);
    for (name, method) in contenders() {
        let placement = records.refine(&*method, 40, 1);
        records.assert_exact(&name, &placement, 40);
        assert!(
            placement.notes[0].contains("uniformly random"),
            "{name}: {:?}",
            placement.notes
        );
        if let Some(map) = records.with(|input| method.refine(input, 1, 1).map) {
            assert!(map.iter().all(|&v| v == 0.0), "{name}");
        }
    }
}

#[test]
fn one_pixel_that_differs_is_taken_and_the_rest_is_uniform() {
    let mut points = plane(5, 5);
    points.normal[12] = Vec3::X;
    // All 24 other points see the odd one; only records stand there, but for (0, 0) to (0, 4).
    let records = Records::new(&points, 0, edge);
    let method = build("dgs", "terms = 'geom'");
    let placement = records.refine(&*method, 10, 1);
    records.assert_exact("dgs", &placement, 10);

    let mut lonely = film((40, 1), |x, _| Some((Vec3::new(x, 1.0, 0.0), Vec3::Y)));
    lonely.normal[0] = Vec3::X;
    let mut sites: Vec<u32> = vec![0, 2];
    sites.extend(20..30);
    let search = RecordSearch::new(&[], &[], SearchRule::spatial(6));
    let mut input = Refinable {
        points: &lonely,
        sites: &sites,
        search: &search,
        power: 1,
        records: &mut Compared(|_, _| 0.0),
    };
    // Points 0, 1 and 2 see the turned normal; 0 and 2 are records, so only 1 has a value.
    let placement = method.refine(&mut input, 10, 1);
    assert_eq!(placement.sites.len(), 10);
    assert_eq!(placement.sites[0], 1);
    assert!(
        placement.notes[0].contains("only 1 pixels"),
        "{:?}",
        placement.notes
    );
}

#[test]
fn the_map_is_zero_at_records_and_background_and_at_most_three() {
    let points = room(64, 48);
    let records = Records::new(&points, 100, edge);
    for (name, method) in contenders() {
        let Some(map) = records.with(|input| method.refine(input, 1, 1).map) else {
            continue;
        };
        assert_eq!(map.len(), 64 * 48, "{name}");
        assert!(map.iter().any(|&v| v > 0.0), "{name}");
        if name.starts_with("EGR") {
            // A standard deviation of values from 0 to 100, also at records.
            assert!(map.iter().all(|v| (0.0..=50.0).contains(v)), "{name}");
            continue;
        }
        assert!(map.iter().all(|v| (0.0..=3.0).contains(v)), "{name}");
        for &site in &records.sites {
            assert_eq!(map[points.pixel[site as usize] as usize], 0.0, "{name}");
        }
        let empty = (0..map.len()).filter(|&i| points.point_of_pixel[i] == u32::MAX);
        assert!(empty.into_iter().all(|i| map[i] == 0.0), "{name}");
    }
}

#[test]
fn the_difference_terms_equal_a_direct_evaluation() {
    let points = room(40, 30);
    let records = Records::new(&points, 120, |p| p.x.sin() * 10.0 + p.y);
    let map = records.with(|input| build("dgs", "terms = 'diff'").refine(input, 1, 1).map);
    let map = map.expect("dgs has a map");
    let spreads = records
        .search
        .map(&points.position, &points.normal, |_, found| {
            let of = |i: usize| records.values[found[i].record as usize];
            let pairs = (0..found.len()).flat_map(|i| (i + 1..found.len()).map(move |k| (i, k)));
            let all: Vec<f32> = pairs.map(|(i, k)| (of(i) - of(k)).abs()).collect();
            let mean = all.iter().sum::<f32>() / all.len().max(1) as f32;
            (mean, all.iter().copied().fold(0.0, f32::max))
        });
    let most_mean = spreads.iter().map(|s| s.0).fold(0.0, f32::max);
    let most = spreads.iter().map(|s| s.1).fold(0.0, f32::max);
    for (i, spread) in spreads.iter().enumerate() {
        let value = map[points.pixel[i] as usize];
        let expected = if records.sites.contains(&(i as u32)) {
            0.0
        } else {
            spread.0 / most_mean + spread.1 / most
        };
        assert!((value - expected).abs() < 1e-5, "{i}: {value} {expected}");
    }
}

#[test]
fn every_pair_is_compared_once() {
    let points = room(200, 150);
    let records = Records::new(&points, 300, edge);
    let seen = Mutex::new(HashSet::new());
    let difference = |a: u32, b: u32| {
        let new = seen.lock().expect("no panic").insert((a.min(b), a.max(b)));
        assert!(new, "{a} and {b} again");
        1.0
    };
    let mut input = Refinable {
        points: &points,
        sites: &records.sites,
        search: &records.search,
        power: 1,
        records: &mut Compared(difference),
    };
    for method in ["dgs", "as"] {
        build(method, "").refine(&mut input, 50, 1);
        let mut seen = seen.lock().expect("no panic");
        assert!(seen.len() > 300, "{method}: {}", seen.len());
        seen.clear();
    }
}

#[test]
fn extreme_differences_neither_panic_nor_hide_everything() {
    let points = room(64, 48);
    let mut records = Records::new(&points, 100, edge);
    records.values[3] = f32::NAN;
    records.values[4] = f32::INFINITY;
    records.values[5] = 1e30;
    for (name, method) in contenders() {
        let placement = records.refine(&*method, 40, 1);
        records.assert_exact(&name, &placement, 40);
    }
}

#[test]
fn a_threshold_leaves_the_budget_unspent_rather_than_lower_itself() {
    let points = plane(80, 60);
    let records = Records::new(&points, 200, edge);
    let strict = records.refine(&*build("as", "threshold = 601"), 50, 1);
    assert_eq!(
        strict.sites.len(),
        0,
        "no record can differ by more than 6 × 100"
    );
    assert!(strict.notes[0].contains("unspent"));
    let mild = records.refine(&*build("as", "threshold = 250"), 50, 1);
    assert!(!mild.sites.is_empty() && mild.sites.len() <= 50);
}

#[test]
fn wrong_parameters_name_the_key_and_what_is_expected() {
    for (id, parameters, expected) in [
        ("dgs", "ratio = 1.5", "0 to 0.9"),
        ("dgs", "records = 1", "2 to 32"),
        ("dgs", "terms = 'all'", "both"),
        ("dgs", "clamp_percentile = 10", "50 to 100"),
        ("as", "threshold = -1", "0 or more"),
        ("as", "budget = 3", "budget"),
    ] {
        let table: toml::Table = parameters.parse().expect("valid toml");
        let error = match (refinement(id).expect("registered").build)(&table) {
            Ok(_) => panic!("{id} accepts {parameters}"),
            Err(error) => error,
        };
        assert!(error.message.contains(expected), "{parameters}: {error}");
    }
    assert_eq!(build("dgs", "ratio = 0").ratio(), 0.0);
    assert_eq!(build("as", "").ratio(), 0.15);
}
