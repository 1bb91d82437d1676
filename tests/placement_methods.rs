//! Every registered first stage on ordinary and on hard sets of points.

mod placement_scenes;

use std::collections::HashSet;

use glam::Vec3;
use lightbench::cache::ShadingPoints;
use lightbench::placement::{FIRST_STAGES, first_stage};
use lightbench::placement::{FirstStage, Placement};
use lightbench::sample::Rng;
use placement_scenes::*;

fn build(id: &str, parameters: &str) -> Box<dyn FirstStage> {
    let table: toml::Table = parameters.parse().expect("valid toml");
    (first_stage(id).expect("registered").build)(&table).expect("valid parameters")
}

/// Every method in several settings, with a name for messages.
fn contenders() -> Vec<(String, Box<dyn FirstStage>)> {
    let settings = [
        ("im", "pattern = 'jittered'"),
        ("sd", "min_cluster_size = 1"),
        (
            "sd",
            "min_cluster_size = 50\nrepresentative = 'nearest-average'",
        ),
        ("sd", "normal_scale = 'diagonal'"),
        ("vgc", "angle_deg = 5"),
        (
            "vgc",
            "angle_deg = 20.0\nsplit = 'median'\nlambda_kappa = 0.05",
        ),
        ("vgc", "literal_sign = true"),
    ];
    let defaults = FIRST_STAGES.iter().map(|entry| (entry.about.id, ""));
    defaults
        .chain(settings)
        .map(|(id, p)| (format!("{id} {p}"), build(id, p)))
        .collect()
}

fn assert_exact(name: &str, points: &ShadingPoints, placement: &Placement, count: usize) {
    let sites: HashSet<u32> = placement.sites.iter().copied().collect();
    assert_eq!(sites.len(), placement.sites.len(), "{name}: distinct");
    assert_eq!(
        sites.len(),
        count.min(points.len()),
        "{name}: {count} asked"
    );
    assert!(sites.iter().all(|&i| (i as usize) < points.len()), "{name}");
}

#[test]
fn counts_are_exact_and_sites_distinct_on_every_set() {
    let sets = [
        ("room", room(64, 48)),
        ("identical", identical(20, 10)),
        ("plane", plane(30, 20)),
        ("antipodal", antipodal(20, 10)),
        ("dome", dome(24, 24)),
        ("one point", plane(1, 1)),
        ("sky", film((8, 8), |_, _| None)),
        ("a row", room(400, 1)),
        ("a column", room(1, 400)),
    ];
    for (name, stage) in contenders() {
        for (set, points) in &sets {
            for count in [
                0,
                1,
                2,
                5,
                19,
                150,
                points.len().saturating_sub(1),
                points.len(),
                4000,
            ] {
                let placement = stage.place(points, count, 1);
                assert_exact(&format!("{name} on {set}"), points, &placement, count);
                let too_few = count > points.len();
                assert!(
                    !too_few || !placement.notes.is_empty(),
                    "{name} on {set}: a note"
                );
            }
        }
    }
}

#[test]
fn seeds_decide_and_threads_do_not() {
    let points = room(320, 200);
    let run = |stage: &dyn FirstStage, threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool")
            .install(|| stage.place(&points, 900, seed))
    };
    for (name, stage) in contenders() {
        let first = run(&*stage, 1, 7);
        assert_eq!(first.sites, run(&*stage, 2, 7).sites, "{name}");
        assert_eq!(first.sites, run(&*stage, 2, 7).sites, "{name} repeated");
        assert_ne!(first.sites, run(&*stage, 2, 8).sites, "{name}");
    }
}

#[test]
fn points_that_are_not_finite_are_never_chosen() {
    let mut points = room(40, 30);
    for i in (0..points.len()).step_by(3) {
        match i % 9 {
            0 => points.position[i].x = f32::NAN,
            3 => points.normal[i].y = f32::NAN,
            _ => points.depth[i] = f32::INFINITY,
        }
    }
    for (name, stage) in contenders() {
        let sites = stage.place(&points, 200, 1).sites;
        assert_eq!(sites.len(), 200, "{name}");
        assert!(sites.iter().all(|i| i % 3 != 0), "{name}");
    }
}

fn found(placement: &Placement, key: &str) -> f64 {
    let entry = placement.found.iter().find(|(k, _)| *k == key);
    entry
        .unwrap_or_else(|| panic!("no {key} in {:?}", placement.found))
        .1
}

#[test]
fn clusters_reach_the_budget_before_anything_is_trimmed_or_added() {
    let points = room(320, 200);
    for (id, parameters) in [
        ("sd", "min_cluster_size = 1"),
        ("sd", "min_cluster_size = 10"),
        ("vgc", "angle_deg = 20"),
        ("vgc", "split = 'median'"),
    ] {
        let placement = build(id, parameters).place(&points, 1500, 1);
        let clusters = found(&placement, "clusters");
        assert!(
            (1492.5..=1500.0).contains(&clusters),
            "{id} {parameters}: {clusters}"
        );
    }
}

/// The same points after a change of units and place, with the matching declaration.
fn moved(points: &ShadingPoints, scale: f32, offset: Vec3) -> ShadingPoints {
    let mut out = points.clone();
    out.position
        .iter_mut()
        .for_each(|p| *p = *p * scale + offset);
    out.depth.iter_mut().for_each(|d| *d *= scale);
    out.diagonal *= scale;
    out.metres_per_unit /= scale;
    out
}

#[test]
fn scale_changes_nothing_if_it_is_declared() {
    let points = room(200, 150);
    for (name, stage) in contenders() {
        let sites: HashSet<u32> = stage.place(&points, 600, 3).sites.into_iter().collect();
        for exponent in [-3, -1, 1, 3, 5] {
            let scaled = moved(&points, 10f32.powi(exponent), Vec3::ZERO);
            let again = stage.place(&scaled, 600, 3).sites;
            let kept = again.iter().filter(|i| sites.contains(i)).count();
            assert!(kept >= 585, "{name} scaled by 1e{exponent}: {kept} of 600");
        }
        let exact = moved(&points, 1024.0, Vec3::ZERO);
        let again: HashSet<u32> = stage.place(&exact, 600, 3).sites.into_iter().collect();
        assert!(
            sites.intersection(&again).count() >= 598,
            "{name} scaled by 1024"
        );
    }
}

#[test]
fn a_distant_origin_keeps_counts_and_most_clusters() {
    let points = room(200, 150);
    let away = moved(&points, 1.0, Vec3::new(1e4, -1e4, 1e4));
    for (name, stage) in contenders() {
        let placement = stage.place(&away, 600, 3);
        assert_exact(&name, &away, &placement, 600);
    }
}

/// Random points on the visible half of a ball, at equal depth, turned so that a pole is in view.
fn ball(turn: impl Fn(Vec3) -> Vec3) -> ShadingPoints {
    let mut points = film((90, 90), |x, y| {
        let mut rng = Rng::new(1, x.to_bits().into(), y.to_bits().into(), 0);
        let (a, b) = (2.0 * rng.next_f32() - 1.0, 2.0 * rng.next_f32() - 1.0);
        let left = 1.0 - a * a - b * b;
        let p = Vec3::new(a, b, left.max(0.0).sqrt());
        (left > 0.0).then_some((p, p))
    });
    points.depth.fill(4.0);
    points.position.iter_mut().for_each(|p| *p = turn(*p));
    points.normal.iter_mut().for_each(|n| *n = turn(*n));
    points
}

#[test]
fn a_ball_is_clustered_alike_whichever_pole_is_in_view() {
    let towards_z = ball(|p| p);
    let towards_y = ball(|p| Vec3::new(p.x, p.z, -p.y));
    let towards_x = ball(|p| Vec3::new(p.z, p.x, p.y));
    for angle in [8, 15, 30] {
        let stage = build("vgc", &format!("angle_deg = {angle}"));
        let count = |points| {
            let placement = stage.place(points, 800, 1);
            [
                found(&placement, "clusters"),
                found(&placement, "spatial_clusters"),
            ]
        };
        let z = count(&towards_z);
        assert_eq!(z, count(&towards_y), "{angle}°: +y");
        assert_eq!(z, count(&towards_x), "{angle}°: +x");
    }
}

#[test]
fn an_angle_that_is_too_small_is_raised_and_said_so() {
    let points = ball(|p| p);
    let placement = build("vgc", "angle_deg = 1").place(&points, 20, 1);
    assert_exact("vgc", &points, &placement, 20);
    assert!(found(&placement, "sigma_a_deg") > 10.0);
    assert!(
        placement.notes[0].contains("raised"),
        "{:?}",
        placement.notes
    );
}

#[test]
fn clusters_of_a_plane_are_equal_squares() {
    let points = plane(128, 128);
    let placement = build("vgc", "angle_deg = 15\ngamma = 0").place(&points, 256, 1);
    assert_eq!(found(&placement, "clusters"), 256.0);
    assert!(
        (found(&placement, "sigma_s") - 15.0 / 128.0 * 3.0).abs() < 1e-6,
        "{:?}",
        placement.found
    );
}

#[test]
fn sd_best_offers_the_papers_sizes() {
    assert_eq!(build("sd", "").candidates().len(), 6);
    assert_eq!(build("sd", "min_cluster_size = 10").candidates().len(), 0);
    assert_eq!(build("vgc", "").candidates().len(), 0);
}

#[test]
fn wrong_parameters_name_the_key_and_what_is_expected() {
    let wrong = [
        ("im", "pattern = 'blue'", "jittered"),
        ("im", "colour = 1", "colour"),
        ("sd", "min_cluster_size = 0", "1 to 100000"),
        ("sd", "min_cluster_size = 'worst'", "best"),
        ("vgc", "angle_deg = -3", "above 0"),
        ("vgc", "angle_deg = 'autumn'", "auto"),
        ("vgc", "gamma = -1", "gamma = -1"),
        ("vgc", "jitter = 2", "0 to 1"),
        ("vgc", "lambda_kappa = nan", "lambda_kappa"),
    ];
    for (id, parameters, expected) in wrong {
        let table: toml::Table = parameters.parse().expect("valid toml");
        let error = match (first_stage(id).expect("registered").build)(&table) {
            Ok(_) => panic!("{id} accepts {parameters}"),
            Err(error) => error,
        };
        assert!(error.message.contains(expected), "{parameters}: {error}");
    }
}

#[test]
fn ids_and_aliases_are_unique_and_every_default_builds() {
    let mut names = HashSet::new();
    for entry in FIRST_STAGES {
        for name in entry.about.aliases.iter().chain([&entry.about.id]) {
            assert!(names.insert(name.to_lowercase()), "{name} twice");
            assert_eq!(
                first_stage(&name.to_uppercase()).map(|e| e.about.id),
                Some(entry.about.id)
            );
        }
        assert!((entry.build)(&toml::Table::new()).is_ok());
    }
    assert!(first_stage("nothing").is_none());
}
