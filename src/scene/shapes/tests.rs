//! Every generator's parts are sound meshes.

use std::collections::BTreeMap;

use glam::DVec3;

use super::kit::{self, face_normal};
use super::{generate, generators, parts};
use crate::scene::{Mesh, SceneDescription, ShapeSource, find_scene, shipped_scenes};

fn set(detail: f64) -> BTreeMap<String, f64> {
    BTreeMap::from([("detail".to_owned(), detail)])
}

/// Shares of triangles without area and of corners whose normal opposes the winding.
fn defects(mesh: &Mesh) -> (f64, f64) {
    let (mut flat, mut opposed) = (0usize, 0usize);
    for t in &mesh.triangles {
        let normal = face_normal(t.map(|i| mesh.positions[i as usize]));
        flat += usize::from(normal == glam::Vec3::ZERO);
        opposed += t
            .iter()
            .filter(|&&i| normal.dot(mesh.normals[i as usize]) <= 0.0)
            .count();
    }
    let count = mesh.triangles.len() as f64;
    (flat as f64 / count, opposed as f64 / (3.0 * count))
}

fn content_hash(mesh: &Mesh) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for p in &mesh.positions {
        hasher.update(
            &p.to_array()
                .map(f64::to_bits)
                .map(u64::to_le_bytes)
                .concat(),
        );
    }
    for n in &mesh.normals {
        hasher.update(
            &n.to_array()
                .map(f32::to_bits)
                .map(u32::to_le_bytes)
                .concat(),
        );
    }
    for t in &mesh.triangles {
        hasher.update(&t.map(u32::to_le_bytes).concat());
    }
    hasher.finalize()
}

fn volume(mesh: &Mesh) -> f64 {
    let at = |i: u32| mesh.positions[i as usize];
    let tetrahedra = mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0);
    tetrahedra.sum()
}

/// Directed edges without an opposite partner between the same two places.
fn open_edges(mesh: &Mesh) -> usize {
    let key = |i: u32| {
        (mesh.positions[i as usize] + DVec3::ZERO)
            .to_array()
            .map(f64::to_bits)
    };
    let mut balance: BTreeMap<_, i32> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (key(from), key(to));
            if from < to {
                *balance.entry((from, to)).or_default() += 1;
            } else {
                *balance.entry((to, from)).or_default() -= 1;
            }
        }
    }
    balance.values().filter(|&&b| b != 0).count()
}

#[test]
fn every_part_is_finite_wound_outwards_and_repeatable() {
    let mut poor = Vec::new();
    for generator in generators() {
        for part in parts(generator).expect("known generator") {
            let make = || generate(generator, Some(part), &set(0.5)).expect("known part");
            let mesh = make();
            let place = format!("{generator}/{part}");
            assert!(!mesh.triangles.is_empty(), "{place} is empty");
            assert_eq!(mesh.normals.len(), mesh.positions.len(), "{place}");
            let sane = |p: &DVec3| p.is_finite() && p.length() < 500.0;
            assert!(mesh.positions.iter().all(sane), "{place}: positions");
            let unit = |n: &glam::Vec3| (n.length() - 1.0).abs() < 1e-3;
            assert!(mesh.normals.iter().all(unit), "{place}: normals");
            let (flat, opposed) = defects(&mesh);
            if flat > 1e-3 || opposed > 1e-3 {
                poor.push(format!("{place}: flat {flat}, opposed {opposed}"));
            }
            assert_eq!(content_hash(&mesh), content_hash(&make()), "{place}");
        }
    }
    assert!(poor.is_empty(), "{poor:#?}");
}

/// Shipped scenes that show a generator's parts: the one of its name, or for the still life several.
fn scenes_of(generator: &str) -> Vec<SceneDescription> {
    let names = shipped_scenes().into_iter().filter(|name| match generator {
        "still-life" => name.starts_with("still-"),
        _ => *name == generator,
    });
    names
        .map(|name| find_scene(name).expect("a shipped scene that parses"))
        .collect()
}

#[test]
fn scene_files_declare_every_part_of_their_generator() {
    for generator in generators() {
        let mut declared: Vec<String> = Vec::new();
        for scene in scenes_of(generator) {
            assert!(
                !scene.views.is_empty() && scene.ao_distance.is_some(),
                "{generator}"
            );
            for shape in &scene.shapes {
                if let ShapeSource::Generated {
                    generator: name,
                    part,
                    ..
                } = &shape.source
                {
                    assert_eq!(name, generator);
                    declared.extend(part.clone());
                }
            }
            let emits = scene.shapes.iter().any(|s| s.emission.is_some());
            assert!(scene.environment.is_some() || emits, "{generator} is dark");
        }
        let mut known = parts(generator).expect("known generator");
        known.sort_unstable();
        declared.sort_unstable();
        if generator == "still-life" {
            declared.dedup();
        }
        assert_eq!(declared, known, "{generator}");
    }
}

#[test]
fn triangle_counts_span_a_thousand_to_a_million() {
    let ranges = [
        ("cornell-curved", 1_000..10_000),
        ("table", 40_000..200_000),
        ("cabinet-room", 100_000..250_000),
        ("robots", 50_000..300_000),
        ("stairs", 300_000..500_000),
        ("atrium", 300_000..800_000),
        ("statues", 800_000..1_300_000),
        ("arcade-court", 200_000..300_000),
        ("country-house", 300_000..450_000),
        ("long-street", 600_000..800_000),
    ];
    for (generator, range) in ranges {
        let count = generate(generator, None, &BTreeMap::new())
            .expect("known generator")
            .triangles
            .len();
        assert!(range.contains(&count), "{generator} has {count} triangles");
    }
}

#[test]
fn solids_of_the_kit_are_closed_and_enclose_their_volume() {
    let circle_volume = std::f64::consts::PI;
    let cases = [
        ("cuboid", kit::cuboid([0.0; 3], [1.0, 2.0, 3.0]), 6.0),
        (
            "bevelled",
            kit::bevelled_box([0.0; 3], [1.0, 2.0, 3.0], 0.01),
            6.0,
        ),
        ("rounded", kit::rounded_box([0.5, 1.0, 1.5], 0.05, 4), 6.0),
        ("sphere", kit::sphere(1.0, 96), circle_volume * 4.0 / 3.0),
        (
            "cylinder",
            kit::cylinder(1.0, 2.0, 0.01, 96),
            circle_volume * 2.0,
        ),
        (
            "torus",
            kit::torus(2.0, 0.5, [96, 48]),
            circle_volume.powi(2),
        ),
        (
            "capsule",
            kit::capsule([1.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.5, 0.5], 96),
            circle_volume * (0.5 + 1.0 / 6.0),
        ),
        (
            "tube",
            kit::tube(
                &kit::curve(&[[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]], 4),
                0.5,
                64,
            ),
            circle_volume * 0.5,
        ),
        (
            "sheet",
            kit::sheet([9, 7], 0.1, |u, v| DVec3::new(2.0 * u, v, 0.0)),
            0.2,
        ),
        (
            "wall",
            kit::wall(
                [4.0, 3.0],
                0.5,
                &[kit::Opening {
                    min: [1.0, 1.0],
                    max: [2.0, 2.0],
                }],
            ),
            5.5,
        ),
        (
            "implicit ball",
            kit::polygonise([[-1.2; 3], [1.2; 3]], 0.05, |p| p.length() - 1.0),
            circle_volume * 4.0 / 3.0,
        ),
    ];
    for (name, mesh, expected) in cases {
        let found = volume(&mesh);
        assert!(
            (found / expected - 1.0).abs() < 0.02,
            "{name}: {found} instead of {expected}"
        );
        assert_eq!(open_edges(&mesh), 0, "{name} is not closed");
    }
}

#[test]
fn an_implicit_ball_lies_on_its_sphere_with_its_normals() {
    let ball = kit::polygonise([[-1.2; 3], [1.2; 3]], 0.07, |p| p.length() - 1.0);
    for (p, n) in ball.positions.iter().zip(&ball.normals) {
        assert!((p.length() - 1.0).abs() < 1e-3, "{p}");
        assert!(n.dot(p.normalize().as_vec3()) > 0.999, "{p} {n}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("pool");
        pool.install(|| generate("statues", Some("near-seated"), &set(0.3)))
    };
    let [one, two] = [run(1), run(2)].map(|m| content_hash(&m.expect("known part")));
    assert_eq!(one, two);
}

#[test]
fn unknown_names_list_what_exists() {
    let none = BTreeMap::new();
    let error = generate("statue", None, &none).expect_err("unknown generator");
    assert!(error.contains("`statues`"), "{error}");
    let error = generate("table", Some("vase"), &none).expect_err("unknown part");
    assert!(error.contains("`teapot`"), "{error}");
    let wrong = BTreeMap::from([("details".to_owned(), 1.0)]);
    let error = generate("table", None, &wrong).expect_err("unknown parameter");
    assert!(error.contains("`detail`"), "{error}");
    for bad in [f64::NAN, 0.0, -1.0, 1e9] {
        assert!(generate("table", Some("dice"), &set(bad)).is_err(), "{bad}");
    }
}
