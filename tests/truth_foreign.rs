//! The truths against small images that Mitsuba 3 rendered from the same files (`scripts/foreign-pairs.py`), and the
//! exact occlusion function against one of them: foreign truth that every checkout has.

mod truth_support;

use std::path::PathBuf;

use lightbench::image::{Image, read};
use lightbench::registry::technique;
use lightbench::scene::{Bsdf, Needs, Scene, find_scene};
use lightbench::technique::{Film, Passes, Shot};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::{Moment, World};
use truth_support::{agreement, small_render};

const SIDE: usize = 64;

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/foreign")
        .join(name)
}

fn scene(name: &str) -> Scene {
    let path = file(&format!("{name}.xml"));
    let description = find_scene(&path.to_string_lossy()).expect("a scene");
    Scene::build(&description, Needs::ALL).expect("builds")
}

/// Their image, and the variance of its pixels.
fn theirs(name: &str) -> (Image, Image) {
    let mean = read(&file(&format!("{name}.exr"))).expect("an image");
    let error = read(&file(&format!("{name}.noise.exr"))).expect("an image");
    // Where both see nothing but a constant sky only rounding differs.
    (mean, error.map(|e| e.map(|e| e * e + 1e-10)))
}

fn check(name: &str, samples: u64) {
    let scene = scene(name);
    compare(name, &scene, samples, scene.max_depth);
}

/// The scene of a glTF file at a time, seen by its camera; theirs is the same scene written for Mitsuba, whose rough
/// plastic loses light where glTF's does not: ours is made to lose it too, and `truth_furnace` tests that else it does not.
fn check_gltf(name: &str, time_s: f64) {
    let path = file(&format!("../gltf/{name}.gltf"));
    let mut description = find_scene(&path.to_string_lossy()).expect("a scene");
    for material in &mut description.materials {
        if let Bsdf::Plastic { lossless, .. } = &mut material.bsdf {
            *lossless = false;
        }
    }
    let scene = Scene::build(&description, Needs::ALL).expect("builds");
    let mut world = World::declared(scene, &description).expect("a world");
    let mut scene = world.at(time_s).scene.clone();
    if let Some(path) = description.paths.first() {
        scene.views[0] = path.view(time_s);
        scene.views[0].origin -= scene.origin;
    }
    compare(&format!("gltf-{name}"), &scene, 256, 4);
}

fn compare(name: &str, scene: &Scene, samples: u64, depth: u32) {
    let (mean, variance) = theirs(name);
    let ours = small_render(scene, [SIDE, SIDE], samples, depth);
    let found = agreement(&ours, &mean, &variance, [4.0, 0.004]);
    println!("{name}: {found:?}");
    assert!((0.7..1.3).contains(&found.z_rms), "{name}: {found:?}");
    assert!(found.bad_blocks <= 0.004, "{name}: {found:?}");
    for (ratio, sigma) in found.ratio.iter().zip(found.ratio_sigma) {
        let bound = 3.5 * sigma + 1e-3;
        assert!((ratio - 1.0).abs() < bound, "{name}: {found:?}");
    }
}

#[test]
fn a_room_with_a_lamp_and_three_bounces() {
    check("room", 256);
}

#[test]
fn metal_under_a_lamp_and_a_sky() {
    check("metals", 256);
}

#[test]
fn point_spot_and_parallel_light_with_three_bounces() {
    check("lights", 256);
}

#[test]
fn point_spot_and_parallel_light_scattered_once() {
    check("lights-direct", 256);
}

#[test]
fn a_gltf_room_of_plastic_metal_and_four_kinds_of_light() {
    check_gltf("room", 0.0);
}

#[test]
fn a_moment_of_a_gltf_animation_seen_by_its_camera() {
    check_gltf("moving", 0.7);
}

#[test]
fn a_white_scene_under_a_white_sky() {
    check("sky", 128);
}

/// Their scene has everything where it is at 0.5 s, ours is moved there; then the same after a detour through time.
#[test]
fn a_moment_of_a_moving_scene_along_a_path() {
    let path = file("moving.toml");
    let mut description = find_scene(&path.to_string_lossy()).expect("a scene");
    for material in &mut description.materials {
        if let Bsdf::Plastic { lossless, .. } = &mut material.bsdf {
            *lossless = false;
        }
    }
    let scene = Scene::build(&description, Needs::ALL).expect("builds");
    let mut world = World::declared(scene, &description).expect("a world");
    let mut seen = Vec::new();
    for time_s in [0.5, 1.7, 0.5] {
        let mut scene = world.at(time_s).scene.clone();
        let mut view = description.paths[0].view(time_s);
        view.origin -= scene.origin;
        scene.views = vec![view];
        seen.push(scene);
    }
    compare("moving", &seen[0], 256, 5);
    let [there, back] = [&seen[0], &seen[2]].map(|s| small_render(s, [8, 8], 2, 5).mean);
    assert_eq!(there, back);
    let lit = |scene: &Scene| {
        let lights = scene.point_lights.iter();
        lights.filter(|light| light.intensity != [0.0; 3]).count()
    };
    assert_eq!(lit(&seen[0]), 2, "one is switched off");
    assert_eq!(lit(&seen[1]), 3);
}

/// White surfaces under a sky of 1 reflect what is open of the sky: cached occlusion's own reference.
#[test]
fn occlusion_is_what_a_white_scene_reflects_of_a_white_sky() {
    let scene = scene("sky");
    let (mean, _) = theirs("sky");
    let parameters = "side = 24\ndistance = 1e6".parse().expect("toml");
    let entry = technique("ambient-occlusion").expect("registered");
    let occlusion = (entry.build)(&parameters).expect("parameters");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: SIDE,
        height: SIDE,
        spp: 16,
    };
    let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let function = occlusion.shading_function(&shot);
    let mut passes = Passes::new(&shot, function.as_ref());
    (0..16).for_each(|_| passes.add(&RayCounter::default()));
    let ours = passes.mean();
    let pairs = ours.pixels.iter().zip(&mean.pixels);
    let differences: Vec<f64> = pairs.map(|(a, b)| f64::from(a[0] - b[0])).collect();
    let n = differences.len() as f64;
    let bias = differences.iter().sum::<f64>() / n;
    let rmse = (differences.iter().map(|d| d * d).sum::<f64>() / n).sqrt();
    assert!(bias.abs() < 1e-3 && rmse < 0.02, "bias {bias}, RMSE {rmse}");
}
