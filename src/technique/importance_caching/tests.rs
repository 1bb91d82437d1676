//! Contenders against the sum over all lights, on embedded scenes and on hard cases.

use glam::{DMat4, DVec3, Vec3};
use toml::Table;

use super::records::receiver;
use super::{ENTRY, ImportanceCaching, Parameters};
use crate::cache::{Neighbour, Weighted};
use crate::image::{Image, luminance};
use crate::scene::{
    Bsdf, ColourSource, Material, MicrofacetDistribution, Needs, Scene, SceneDescription,
    ShapeDescription, ShapeSource, View, find_scene,
};
use crate::shade::Gathering;
use crate::technique::{
    CachedFunction, Choice, Film, Passes, Seen, Shot, Technique, Terms, reference_pass,
};
use crate::trace::{RayCounter, Tracer};
use crate::world::Moment;

const WIDTH: usize = 16;
const HEIGHT: usize = 12;

/// A view of a scene, small.
fn with_frame<T>(description: &SceneDescription, look: impl FnOnce(&Shot) -> T) -> T {
    let scene = Scene::build(description, Needs::ALL).expect("a scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: WIDTH,
        height: HEIGHT,
        spp: 1,
    };
    look(&Shot::new(
        Moment::still(&scene, &tracer),
        &scene.views[0],
        film,
    ))
}

fn technique(parameters: &str) -> ImportanceCaching {
    let table: Table = parameters.parse().expect("parameters");
    ImportanceCaching::new(Parameters::read(&table).expect("parameters"))
}

/// Checks the estimator at camera samples spread over the view, with records at every
/// `spacing`-th pixel: its exact mean is the sum over all lights, and so is the mean of what is
/// shaded, within four and a half of its exact standard deviations. Returns how many samples had a
/// record whose full distribution is empty.
fn assert_unbiased(description: &SceneDescription, parameters: &str, spacing: usize) -> usize {
    const DRAWS: u32 = 1500;
    let technique = technique(parameters);
    with_frame(description, |shot| {
        let name = format!("{} {parameters}", description.name);
        let counter = RayCounter::default();
        let caster = shot.tracer.caster(&counter);
        let seen: Vec<Seen> = (0..shot.pixels() as u32)
            .filter_map(|pixel| shot.look(&caster, pixel, 0))
            .collect();
        let sites: Vec<Seen> = seen.iter().step_by(spacing).copied().collect();
        let mut records = technique.records(shot, 7);
        records.evaluate(&sites, &counter);
        let mut with_empty = 0;
        for seen in seen.iter().skip(spacing / 2).step_by(13) {
            let to = receiver(shot, seen);
            let mut values = vec![0.0; records.lights.len()];
            let mut add = |light: usize, value: Vec3, visible: bool| {
                values[light] = if visible {
                    luminance(value.into())
                } else {
                    0.0
                };
            };
            let mut gathering = Gathering::default();
            records.lights.each(&caster, &to, &mut gathering, &mut add);
            let exact: f64 = values.iter().map(|&v| f64::from(v)).sum();
            let near = nearest(&records.positions, seen.site.position);
            let chosen: Vec<u32> = near.iter().map(|n| n.record).collect();
            let empty = |r: &u32| records.table.record(*r).is_empty(0);
            with_empty += usize::from(chosen.iter().any(empty));
            let [mean, variance] = records
                .settings
                .rule
                .moments(&records.table, &chosen, &values);
            assert!(
                (mean - exact).abs() <= 1e-4 * exact,
                "{name}: {mean} {exact}"
            );
            let weights = vec![1.0 / near.len() as f32; near.len()];
            let found = Weighted {
                neighbours: &near,
                weights: &weights,
            };
            let emitted = luminance(shot.paths.lights().emitted(&to.at).into());
            let mut sum = 0.0;
            for sample in 0..DRAWS {
                // Another sample number draws other lights.
                let again = Seen { sample, ..*seen };
                let value = luminance(records.shade(&caster, &again, found).expect("served"));
                assert!(value.is_finite() && value >= 0.0, "{name}");
                sum += f64::from(value - emitted);
            }
            let error = sum / f64::from(DRAWS) - exact;
            let sigma = (variance / f64::from(DRAWS)).sqrt();
            assert!(
                error.abs() <= 4.5 * sigma + 1e-4 * exact,
                "{name}: pixel {}: {error} of {exact} ± {sigma}",
                seen.pixel
            );
        }
        with_empty
    })
}

/// The six nearest records, whatever their normals.
fn nearest(positions: &[Vec3], to: Vec3) -> Vec<Neighbour> {
    let mut found: Vec<Neighbour> = positions
        .iter()
        .enumerate()
        .map(|(record, position)| Neighbour {
            record: record as u32,
            distance: position.distance(to),
        })
        .collect();
    found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    found.truncate(6);
    found
}

const FEW: &str = "lights = 300";

#[test]
fn the_estimate_is_unbiased_for_the_sum_over_all_lights() {
    let alpha = "lights = 300\nheuristic = \"alpha-max\"\nalpha = [1.0, 0.9, 0.7, 0.5]";
    let mut with_empty = 0;
    for scene in ["cornell-curved", "robots", "cabinet-room", "hard-cases"] {
        let description = find_scene(scene).expect("an embedded scene");
        for parameters in [FEW, alpha] {
            with_empty += assert_unbiased(&description, parameters, 9);
        }
    }
    let closed = buried_lamp();
    for parameters in [FEW, alpha] {
        with_empty += assert_unbiased(&closed, parameters, 9);
    }
    assert!(
        with_empty > 20,
        "records with an empty distribution: {with_empty}"
    );
}

/// Reference, and one contender for each seed.
fn images(
    description: &SceneDescription,
    method: &str,
    caches: usize,
    seeds: u64,
) -> (Image, Vec<Image>) {
    let technique = technique(FEW);
    with_frame(description, |shot| {
        let function = technique.shading_function(shot);
        let counter = RayCounter::default();
        let (reference, broken) = reference_pass(function.as_ref(), shot, 0, &counter);
        assert_eq!(broken, 0, "{}", description.name);
        let contender = |seed| {
            let choice = Choice {
                method,
                parameters: &Table::new(),
                terms: Terms {
                    budget: caches,
                    seed,
                },
            };
            let rendered = choice.still(&technique, shot, Some(&reference));
            let rendered = rendered.expect("an image");
            assert_eq!(rendered.non_finite, 0, "{}", description.name);
            let values = rendered.image.pixels.iter().flatten();
            assert!(values.clone().all(|v| v.is_finite() && *v >= 0.0));
            rendered.image
        };
        let contenders = (0..seeds).map(contender).collect();
        (reference, contenders)
    })
}

/// Mean over contenders and pixels of the green channel, its standard error, and the reference's.
fn brightness((reference, contenders): &(Image, Vec<Image>)) -> [f64; 3] {
    let of = |image: &Image| {
        let sum: f64 = image.pixels.iter().map(|p| f64::from(p[1])).sum();
        sum / image.pixels.len() as f64
    };
    let values: Vec<f64> = contenders.iter().map(of).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    [mean, (squares / (n * (n - 1.0))).sqrt(), of(reference)]
}

#[test]
fn every_distribution_of_records_keeps_the_energy() {
    let description = find_scene("cornell-curved").expect("an embedded scene");
    for method in ["IM", "SD", "SD+AS", "VGC", "VGC+DGS", "per-sample"] {
        let [mean, sigma, exact] = brightness(&images(&description, method, 20, 16));
        assert!(sigma < 0.1 * exact, "{method}: ± {sigma} of {exact}");
        assert!(
            (mean - exact).abs() < 4.5 * sigma,
            "{method}: {mean} ± {sigma}, {exact}"
        );
    }
}

/// The cube of side 2 seen from inside, with a lamp of a given side and radiance in its ceiling.
fn room(wall: Material, [lamp_side, radiance]: [f64; 2]) -> SceneDescription {
    let mut cube = ShapeDescription::new("room", ShapeSource::Cube);
    cube.flip_normals = true;
    let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
    // In the plane of the ceiling but for a thousandth.
    lamp.to_world = DMat4::from_translation(DVec3::Y * 0.999)
        * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
        * DMat4::from_scale(DVec3::splat(0.5 * lamp_side));
    lamp.emission = (radiance > 0.0).then_some([radiance as f32; 3]);
    let source = ShapeSource::Sphere {
        centre: DVec3::new(0.3, -0.6, -0.2),
        radius: 0.4,
    };
    SceneDescription {
        name: "room".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        max_depth: 4,
        views: vec![View::look_at(
            "v",
            [
                DVec3::new(0.0, 0.1, 0.95),
                DVec3::new(0.0, -0.2, -1.0),
                DVec3::Y,
            ],
            75.0,
            [WIDTH, HEIGHT],
        )],
        materials: vec![wall],
        shapes: vec![cube, lamp, ShapeDescription::new("ball", source)],
        ..SceneDescription::default()
    }
}

fn grey() -> Material {
    Material::diffuse("grey", [0.6; 3])
}

fn glossy(alpha: f32) -> Material {
    Material {
        bsdf: Bsdf::Plastic {
            diffuse: ColourSource::Constant([0.4; 3]),
            specular: [1.0; 3],
            ior: 1.5,
            alpha,
            distribution: MicrofacetDistribution::Ggx,
            nonlinear: false,
            lossless: false,
        },
        ..grey()
    }
}

/// A lamp inside a closed box below the ceiling: full distributions are empty, unoccluded ones not.
fn buried_lamp() -> SceneDescription {
    let mut scene = room(grey(), [0.1, 10.0]);
    let mut case = ShapeDescription::new("case", ShapeSource::Cube);
    case.to_world = DMat4::from_translation(DVec3::Y * 0.95) * DMat4::from_scale(DVec3::splat(0.1));
    scene.shapes.push(case);
    scene
}

fn across(to_world: DMat4) -> ShapeDescription {
    let mut sheet = ShapeDescription::new("sheet", ShapeSource::Rectangle);
    sheet.to_world = to_world * DMat4::from_scale(DVec3::splat(1.1));
    sheet
}

#[test]
fn a_tiny_lamp_a_million_times_brighter_keeps_the_mean() {
    let mut scene = room(grey(), [0.8, 1.0]);
    let mut spark = scene.shapes[1].clone();
    spark.to_world = DMat4::from_translation(DVec3::new(-0.9, -0.5, -0.9))
        * DMat4::from_scale(DVec3::splat(5e-4));
    spark.emission = Some([1e6; 3]);
    scene.shapes.push(spark);
    assert_unbiased(&scene, FEW, 9);
}

#[test]
fn roughness_from_a_hundredth_to_one_stays_finite_and_unbiased() {
    for alpha in [0.01, 0.1, 1.0] {
        assert_unbiased(&room(glossy(alpha), [0.6, 10.0]), FEW, 9);
    }
}

#[test]
fn no_record_one_record_and_more_records_than_pixels_are_fine() {
    let scene = room(grey(), [0.6, 10.0]);
    assert_unbiased(&scene, FEW, WIDTH * HEIGHT);
    for caches in [0, 1, 1000] {
        let images = images(&scene, "IM", caches, 16);
        let [mean, sigma, exact] = brightness(&images);
        assert!(
            (mean - exact).abs() < 5.0 * sigma,
            "{caches}: {mean} ± {sigma}, {exact}"
        );
        // No pixel that is lit stays black.
        let (reference, contenders) = images;
        for (i, exact) in reference.pixels.iter().enumerate() {
            let lit = contenders.iter().any(|image| image.pixels[i][1] > 0.0);
            assert!(exact[1] == 0.0 || lit, "{caches}: pixel {i} is black");
        }
    }
}

#[test]
fn dark_rooms_and_black_materials_show_emission_only() {
    let black = Material::diffuse("black", [0.0; 3]);
    for scene in [
        room(grey(), [0.6, 0.0]),
        room(black, [0.6, 10.0]),
        buried_lamp(),
    ] {
        let (reference, contenders) = images(&scene, "VGC+DGS", 20, 2);
        let emission = |p: &[f32; 3]| *p == [0.0; 3] || *p == [10.0; 3];
        assert!(reference.pixels.iter().all(emission));
        assert!(contenders.iter().all(|image| *image == reference));
    }
}

#[test]
fn nothing_passes_a_thin_wall() {
    let mut scene = room(grey(), [0.6, 10.0]);
    // Below the lamp: all that the camera sees lies under it.
    let below = DMat4::from_translation(DVec3::Y * 0.9);
    let level = DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
    scene.shapes.push(across(below * level));
    let (reference, contenders) = images(&scene, "IM", 20, 3);
    assert!(reference.pixels.iter().all(|p| *p == [0.0; 3]));
    assert!(contenders.iter().all(|image| *image == reference));
    // Between a lit and a dark half that the camera looks into.
    let upright = DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2);
    scene.shapes[3] = across(upright);
    scene.shapes[1].to_world = DMat4::from_translation(DVec3::X * 0.6) * scene.shapes[1].to_world;
    scene.shapes.remove(2);
    for (x, dark) in [(0.5, false), (-0.5, true)] {
        scene.views[0].origin.x = x;
        assert_unbiased(&scene, FEW, 9);
        let (reference, contenders) = images(&scene, "IM", 20, 3);
        let black = |image: &Image| image.pixels.iter().filter(|p| **p == [0.0; 3]).count();
        assert_eq!(black(&reference) == WIDTH * HEIGHT, dark);
        assert!(!dark || contenders.iter().all(|image| *image == reference));
    }
}

#[test]
fn a_reference_of_paths_is_the_mean_of_path_tracing_and_close_to_the_lights() {
    let scene = room(grey(), [0.6, 10.0]);
    let technique = technique("lights = 4000\nreference = \"paths\"\nreference_passes = 1000");
    assert!(technique.reference_is_random());
    with_frame(&scene, |shot| {
        let function = technique.shading_function(shot);
        let counter = RayCounter::default();
        let mut passes = Passes::new(shot, function.as_ref());
        for _ in 0..technique.reference_samples(1) {
            passes.add(&counter);
        }
        assert_eq!((passes.count(), passes.non_finite), (1000, 0));
        let reference = passes.mean();
        let contenders = |method: &str, table: &str, seeds: u64| {
            let table: Table = table.parse().expect("toml");
            let contender = |seed| Choice {
                method,
                parameters: &table,
                terms: Terms { budget: 20, seed },
            };
            (1..=seeds)
                .map(|seed| {
                    contender(seed)
                        .still(&technique, shot, None)
                        .expect("an image")
                })
                .map(|rendered| rendered.image)
                .collect()
        };
        let traced = brightness(&(
            reference.clone(),
            contenders("per-sample", "passes = 40", 12),
        ));
        let [mean, sigma, truth] = traced;
        assert!(
            (mean - truth).abs() < 5.0 * sigma,
            "{mean} ± {sigma}, {truth}"
        );
        assert!(sigma < 0.01 * truth, "{mean} ± {sigma}");
        let [mean, sigma, truth] = brightness(&(reference, contenders("IM", "", 24)));
        let bound = 5.0 * sigma + 0.05 * truth;
        assert!((mean - truth).abs() < bound, "{mean} ± {sigma}, {truth}");
        assert!(sigma < 0.05 * truth, "{mean} ± {sigma}");
    });
}

#[test]
fn images_do_not_depend_on_threads() {
    let description = room(glossy(0.2), [0.6, 10.0]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let render = || images(&description, "VGC+DGS", 20, 2);
        pool.expect("threads").install(render)
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn parameters_out_of_range_name_their_key() {
    let key = |text: &str| {
        let table: Table = text.parse().expect("toml");
        (ENTRY.build)(&table).err().map(|e| e.key)
    };
    assert_eq!(key("lights = 0").as_deref(), Some("lights"));
    assert_eq!(key("clamp = -1.0").as_deref(), Some("clamp"));
    assert_eq!(
        key("alpha = [1.0, 1.0, 1.0, 0.0]").as_deref(),
        Some("alpha")
    );
    assert_eq!(key("bound_radius = 2.0").as_deref(), Some("bound_radius"));
    assert_eq!(key("lookup = { used = 0 }").as_deref(), Some("lookup"));
    let paper = ImportanceCaching::new(Parameters::default());
    // 25,000 records of the paper's size, and what else a job holds, in 3 GiB.
    assert!(25_000 * paper.bytes_per_record() < 2 << 30);
}
