//! The sum over all lights against the path tracer and against light that is known exactly.

use crate::environment::EnvironmentDescription;
use glam::{DMat4, DVec3, Vec3};

use super::{Gathering, Neighbourhood, Receiver, VirtualLights, VplOptions};
use crate::sample::Rng;
use crate::scene::{
    Bsdf, ColourSource, LightKind, Material, MicrofacetDistribution, Needs, Scene,
    SceneDescription, ShapeDescription, ShapeSource, View,
};
use crate::shade::{Depths, PathTracer};
use crate::trace::{Ray, RayCounter, Tracer};

const DEPTH: u32 = 4;

fn description(materials: Vec<Material>, shapes: Vec<ShapeDescription>) -> SceneDescription {
    let eye = [DVec3::new(0.0, 0.0, 0.8), DVec3::ZERO, DVec3::Y];
    SceneDescription {
        name: "vpl".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        max_depth: DEPTH,
        views: vec![View::look_at("v", eye, 60.0, [8, 8])],
        materials,
        shapes,
        ..SceneDescription::default()
    }
}

fn plain(name: &str, reflectance: [f32; 3]) -> Material {
    Material::diffuse(name, reflectance)
}

fn coated(alpha: f32) -> Material {
    Material {
        bsdf: Bsdf::Plastic {
            diffuse: ColourSource::Constant([0.3, 0.5, 0.2]),
            specular: [1.0; 3],
            ior: 1.5,
            alpha,
            distribution: MicrofacetDistribution::Ggx,
            nonlinear: false,
            lossless: false,
        },
        ..plain("coated", [0.0; 3])
    }
}

/// The cube of side 2 seen from inside, with a square lamp below its ceiling and a smooth sphere.
fn room(wall: Material, ball: Material) -> SceneDescription {
    let mut cube = ShapeDescription::new("room", ShapeSource::Cube);
    cube.flip_normals = true;
    let source = ShapeSource::Sphere {
        centre: DVec3::new(0.3, -0.5, -0.2),
        radius: 0.4,
    };
    let mut sphere = ShapeDescription::new("ball", source);
    sphere.material = 1;
    let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
    lamp.to_world = DMat4::from_translation(DVec3::Y * 0.9)
        * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
        * DMat4::from_scale(DVec3::splat(0.3));
    lamp.emission = Some([20.0, 15.0, 10.0]);
    lamp.material = 2;
    description(
        vec![wall, ball, plain("lamp", [0.0; 3])],
        vec![cube, sphere, lamp],
    )
}

fn options(count: usize, seed: u64, clamp: f32) -> VplOptions {
    VplOptions {
        count,
        seed,
        max_depth: DEPTH,
        clamp,
    }
}

#[derive(Debug)]
struct Moments {
    mean: f64,
    /// Of the mean.
    variance: f64,
}

/// Sets of virtual lights that are averaged over.
#[derive(Clone, Copy)]
struct Sets {
    /// Lights of each.
    count: usize,
    seeds: u64,
}

const SETS: Sets = Sets {
    count: 1500,
    seeds: 40,
};

fn moments(values: &[f64]) -> Moments {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    Moments {
        mean,
        variance: squares / (n * (n - 1.0)),
    }
}

/// Light of all virtual lights along camera rays, by seeds of the set.
fn summed(scene: &Scene, rays: &[Ray], sets: Sets) -> Vec<Moments> {
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(scene, &tracer);
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let mut found = vec![Vec::new(); rays.len()];
    for seed in 0..sets.seeds {
        let lights = VirtualLights::new(&paths, &options(sets.count, seed, 0.0), &counter);
        for (ray, found) in rays.iter().zip(&mut found) {
            let hit = caster.closest(ray).expect("a surface");
            let at = paths.surfaces().interact(&hit, ray.direction);
            let to = Receiver::new(at, scene.diagonal);
            let (sum, non_finite) = lights.sum(&caster, &to, &mut Gathering::default());
            assert_eq!(non_finite, 0);
            found.push(f64::from(sum.dot(Vec3::new(0.5, 0.3, 0.2))));
        }
    }
    found.iter().map(|values| moments(values)).collect()
}

fn traced(scene: &Scene, rays: &[Ray], samples: u64) -> Vec<Moments> {
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(scene, &tracer);
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let mut means = Vec::new();
    for (i, ray) in rays.iter().enumerate() {
        let values: Vec<f64> = (0..samples)
            .map(|sample| {
                let mut rng = Rng::new(3, 99, i as u64, sample);
                let rgb = paths.radiance(&caster, *ray, &mut rng, Depths::up_to(DEPTH));
                f64::from(Vec3::from(rgb).dot(Vec3::new(0.5, 0.3, 0.2)))
            })
            .collect();
        means.push(moments(&values));
    }
    means
}

/// Rays from the middle of the room: to the floor, a wall, the ball and the lit back.
fn rays() -> Vec<Ray> {
    let eye = Vec3::new(0.0, 0.1, 0.7);
    [
        [-0.4, -1.0, 0.2],
        [-1.0, -0.2, 0.1],
        [0.25, -0.35, 0.1],
        [0.1, 0.2, -1.0],
    ]
    .map(|target| Ray::new(eye, (Vec3::from(target) - eye).normalize()))
    .to_vec()
}

fn assert_agreement(name: &str, scene: &SceneDescription, sets: Sets) {
    let scene = Scene::build(scene, Needs::ALL).expect(name);
    let ours = summed(&scene, &rays(), sets);
    let truth = traced(&scene, &rays(), 20_000);
    for (i, (ours, truth)) in ours.iter().zip(&truth).enumerate() {
        let sigma = (ours.variance + truth.variance).sqrt();
        let difference = ours.mean - truth.mean;
        // Within noise that is small against the value.
        assert!(sigma < 0.03 * truth.mean, "{name} {i}: {ours:?} {truth:?}");
        assert!(
            difference.abs() < 4.0 * sigma,
            "{name} {i}: {ours:?} {truth:?}"
        );
    }
}

#[test]
fn the_sum_converges_to_the_path_tracer_in_a_diffuse_room() {
    let scene = room(plain("wall", [0.7, 0.5, 0.3]), plain("ball", [0.6; 3]));
    assert_agreement("diffuse", &scene, SETS);
}

#[test]
fn the_sum_converges_to_the_path_tracer_with_glossy_surfaces() {
    let metal = Material {
        bsdf: Bsdf::Conductor {
            eta: [0.0; 3],
            k: [0.0; 3],
            specular: ColourSource::Constant([0.9, 0.8, 0.7]),
            alpha: 0.5,
            distribution: MicrofacetDistribution::Beckmann,
        },
        ..plain("metal", [0.0; 3])
    };
    assert_agreement("glossy", &room(coated(0.4), metal), SETS);
}

#[test]
fn the_sum_converges_to_the_path_tracer_under_a_sky_and_a_sun() {
    let mut scene = room(plain("wall", [0.7, 0.5, 0.3]), coated(0.6));
    // A floor and the ball under the open sky.
    scene.shapes[0] = ShapeDescription::new("floor", ShapeSource::Rectangle);
    scene.shapes[0].to_world = DMat4::from_translation(-DVec3::Y)
        * DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2)
        * DMat4::from_scale(DVec3::splat(3.0));
    let sun = LightKind::Directional {
        direction: DVec3::new(0.3, -1.0, -0.4),
        irradiance: [2.0, 1.8, 1.5],
    };
    scene.lights.push(sun.into());
    scene.environment = Some(EnvironmentDescription::Constant {
        radiance: [0.5, 0.7, 1.0],
    });
    let down: Vec<Ray> = [[-0.4, -1.0, 0.2], [0.25, -0.35, 0.1], [0.8, -1.0, -0.2]]
        .map(|target| {
            let eye = Vec3::new(0.0, 0.1, 0.7);
            Ray::new(eye, (Vec3::from(target) - eye).normalize())
        })
        .to_vec();
    let scene = Scene::build(&scene, Needs::ALL).expect("open");
    // Building moves the scene to the centre of its box.
    let moved: Vec<Ray> = down
        .iter()
        .map(|ray| Ray::new(ray.origin - scene.origin.as_vec3(), ray.direction))
        .collect();
    let (ours, truth) = (summed(&scene, &moved, SETS), traced(&scene, &moved, 20_000));
    for (ours, truth) in ours.iter().zip(&truth) {
        let sigma = (ours.variance + truth.variance).sqrt();
        assert!(sigma < 0.03 * truth.mean, "{ours:?} {truth:?}");
        assert!(
            (ours.mean - truth.mean).abs() < 4.0 * sigma,
            "{ours:?} {truth:?}"
        );
    }
}

#[test]
fn the_sum_converges_to_the_path_tracer_under_points_and_spots() {
    let mut scene = room(plain("wall", [0.7, 0.5, 0.3]), coated(0.5));
    scene.shapes[2].emission = None;
    scene.lights = vec![
        LightKind::Point {
            position: DVec3::new(-0.5, 0.3, 0.2),
            intensity: [0.4, 0.5, 0.3],
        }
        .into(),
        LightKind::Spot {
            position: DVec3::new(0.2, 0.8, 0.3),
            direction: DVec3::new(0.0, -0.9, -0.4),
            intensity: [3.0, 2.0, 2.5],
            beam_width_deg: 15.0,
            cutoff_deg: 50.0,
        }
        .into(),
    ];
    assert_agreement("points", &scene, SETS);
    with_set(&scene, 1, |lights, to, _| {
        assert_eq!(lights.finite - lights.on_surfaces, 2);
        assert_eq!(lights.finite, lights.len());
        let mut rng = Rng::new(1, 0, 0, 0);
        let near = Neighbourhood {
            radius: 0.1,
            turn: [1.0, 0.0],
        };
        for _ in 0..200 {
            let mut other = *to;
            other.at.position.x += (rng.next_f32() - 0.5) * 0.14;
            other.at.position.z += (rng.next_f32() - 0.5) * 0.14;
            for i in lights.on_surfaces..lights.finite {
                let (value, bound) = (lights.unoccluded(&other, i), lights.bounded(to, i, &near));
                assert!(value.cmple(bound * 1.0001).all(), "{value} > {bound}");
            }
        }
    });
}

#[test]
fn a_closed_glowing_box_sums_a_geometric_series() {
    let albedo = [0.8f32, 0.5, 0.1];
    let mut cube = ShapeDescription::new("box", ShapeSource::Cube);
    cube.flip_normals = true;
    cube.emission = Some([1.0; 3]);
    let scene = description(vec![plain("wall", albedo)], vec![cube]);
    let scene = Scene::build(&scene, Needs::ALL).expect("box");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(&scene, &tracer);
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let ray = Ray::new(Vec3::ZERO, Vec3::new(0.1, -1.0, 0.05).normalize());
    let at = paths
        .surfaces()
        .interact(&caster.closest(&ray).expect("floor"), ray.direction);
    let to = Receiver::new(at, scene.diagonal);
    let mut channels = [const { Vec::new() }; 3];
    for seed in 0..30 {
        let lights = VirtualLights::new(&paths, &options(4000, seed, 0.0), &counter);
        assert!((3400..4600).contains(&lights.len()), "{}", lights.len());
        let (sum, _) = lights.sum(&caster, &to, &mut Gathering::default());
        (0..3).for_each(|c| channels[c].push(f64::from(sum[c])));
    }
    for (values, albedo) in channels.iter().zip(albedo) {
        let expected: f64 = (1..DEPTH as i32).map(|k| f64::from(albedo).powi(k)).sum();
        let Moments { mean, variance } = moments(values);
        let sigma = variance.sqrt();
        assert!(sigma < 0.02 * expected, "{mean} ± {sigma}");
        assert!(
            (mean - expected).abs() < 4.0 * sigma,
            "{mean} ± {sigma}, {expected}"
        );
    }
}

/// The set of a scene, and the room's floor as a receiver, for what needs no truth.
fn with_set(
    scene: &SceneDescription,
    seed: u64,
    check: impl FnOnce(&VirtualLights, &Receiver, &Ray),
) {
    let scene = Scene::build(scene, Needs::ALL).expect("scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(&scene, &tracer);
    let counter = RayCounter::default();
    let lights = VirtualLights::new(&paths, &options(800, seed, 0.01), &counter);
    let caster = tracer.caster(&counter);
    let ray = rays()[0];
    let at = paths
        .surfaces()
        .interact(&caster.closest(&ray).expect("floor"), ray.direction);
    let to = Receiver::new(at, scene.diagonal);
    let mut visible = vec![None; lights.len()];
    let mut note = |i: usize, _, seen| visible[i] = Some(seen);
    lights.each(&caster, &to, &mut Gathering::default(), &mut note);
    for (i, seen) in visible.iter().enumerate() {
        let single = !caster.occluded(&lights.shadow_ray(&to, i));
        assert!(
            seen.is_none_or(|seen| seen == single),
            "light {i}: bundle and ray differ"
        );
        assert_eq!(seen.is_none(), lights.unoccluded(&to, i) == Vec3::ZERO);
    }
    check(&lights, &to, &ray);
}

#[test]
fn dark_and_black_scenes_have_few_lights_or_none() {
    let mut scene = room(plain("wall", [0.0; 3]), plain("ball", [0.0; 3]));
    with_set(&scene, 1, |lights, _, _| {
        let direct = |l: &super::VirtualLight| l.position.y > 0.85;
        assert!(!lights.is_empty());
        assert!(lights.lights.iter().all(direct));
    });
    scene.shapes[2].emission = None;
    with_set(&scene, 1, |lights, _, _| assert!(lights.is_empty()));
    scene.shapes[2].emission = Some([f32::NAN, 1.0, 1.0]);
    with_set(&scene, 1, |lights, _, _| assert!(lights.is_empty()));
}

#[test]
fn sets_depend_on_the_seed_alone() {
    let scene = room(plain("wall", [0.5; 3]), coated(0.2));
    let positions = |seed| {
        let mut found = Vec::new();
        with_set(&scene, seed, |lights, _, _| {
            found = lights.lights.iter().map(|l| l.position).collect();
        });
        found
    };
    assert_eq!(positions(4), positions(4));
    assert_ne!(positions(4), positions(5));
}

#[test]
fn bounds_hold_for_diffuse_points_of_the_neighbourhood() {
    let scene = room(plain("wall", [0.7, 0.5, 0.3]), plain("ball", [0.6; 3]));
    let turn = 30f32.to_radians();
    let near = Neighbourhood {
        radius: 0.1,
        turn: [turn.cos(), turn.sin()],
    };
    with_set(&scene, 2, |lights, to, _| {
        let mut rng = Rng::new(1, 0, 0, 0);
        let mut tight = 0;
        for _ in 0..50 {
            // Points of the floor around the receiver.
            let mut other = *to;
            other.at.position.x += (rng.next_f32() - 0.5) * 0.14;
            other.at.position.z += (rng.next_f32() - 0.5) * 0.14;
            for i in 0..lights.len() {
                let bound = lights.bounded(to, i, &near);
                let value = lights.unoccluded(&other, i);
                assert!(
                    value.cmple(bound * 1.0001).all(),
                    "light {i}: {value} > {bound}"
                );
                tight += usize::from(bound.x < 4.0 * value.x);
            }
        }
        assert!(tight > 5 * lights.len(), "bounds say nothing: {tight}");
    });
}

#[test]
fn a_light_at_the_point_itself_stays_finite() {
    let scene = room(plain("wall", [0.7, 0.5, 0.3]), plain("ball", [0.6; 3]));
    with_set(&scene, 2, |lights, to, _| {
        for (i, light) in lights.lights.iter().enumerate().step_by(7) {
            let mut here = *to;
            here.at.position = light.position;
            assert_eq!(lights.unoccluded(&here, i), Vec3::ZERO);
            here.at.position += light.normal * 1e-7;
            let near = Neighbourhood {
                radius: 0.0,
                turn: [1.0, 0.0],
            };
            let most = lights.clamp_distance.powi(-2) * 100.0;
            for value in [lights.unoccluded(&here, i), lights.bounded(&here, i, &near)] {
                assert!(value.is_finite() && value.max_element() < most, "{value}");
            }
        }
    });
}
