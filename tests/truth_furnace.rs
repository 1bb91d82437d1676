//! Scenes whose light is known without rendering.

mod truth_support;

use glam::{DMat4, DVec3};
use lightbench::environment::EnvironmentDescription;
use lightbench::scene::MicrofacetDistribution::{Beckmann, Ggx};
use lightbench::scene::{
    Bsdf, ColourSource, LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription,
    ShapeSource, View,
};
use lightbench::shade::{Depths, PathTracer, RenderOptions, Rendering, render};
use lightbench::trace::Tracer;
use truth_support::small_render;

fn scene(
    name: &str,
    eye: DVec3,
    material: Material,
    shapes: Vec<ShapeDescription>,
) -> SceneDescription {
    SceneDescription {
        name: name.into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        views: vec![View::look_at(
            "v",
            [eye, DVec3::ZERO, DVec3::Y],
            40.0,
            [16, 16],
        )],
        materials: vec![material],
        shapes,
        ..SceneDescription::default()
    }
}

fn sphere() -> ShapeDescription {
    let source = ShapeSource::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    };
    ShapeDescription::new("sphere", source)
}

/// A sphere in a constant environment of radiance 1, filling the view.
fn in_furnace(material: Material, spp: u64, depth: u32) -> Rendering {
    let mut description = scene(
        "furnace",
        DVec3::new(0.3, 0.2, 2.2),
        material,
        vec![sphere()],
    );
    description.environment = Some(EnvironmentDescription::Constant { radiance: [1.0; 3] });
    let scene = Scene::build(&description, Needs::ALL).expect("furnace");
    small_render(&scene, [16, 16], spp, depth)
}

fn mean_and_sigma(rendering: &Rendering, channel: usize) -> [f64; 2] {
    let count = rendering.mean.pixels.len() as f64;
    let sum = |pixels: &[[f32; 3]]| pixels.iter().map(|p| f64::from(p[channel])).sum::<f64>();
    let variance = sum(&rendering.variance.pixels);
    [sum(&rendering.mean.pixels) / count, variance.sqrt() / count]
}

fn mean(rendering: &Rendering) -> f64 {
    let pixels = &rendering.mean.pixels;
    pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
}

#[test]
fn a_closed_glowing_box_sums_a_geometric_series() {
    let albedo = [0.8f32, 0.5, 0.1];
    let mut cube = ShapeDescription::new("box", ShapeSource::Cube);
    cube.flip_normals = true;
    cube.emission = Some([1.0, 2.0, 3.0]);
    let mut material = Material::diffuse("wall", albedo);
    material.two_sided = false;
    let description = scene("box", DVec3::new(0.2, 0.1, 0.6), material, vec![cube]);
    for scale in [1e-3, 1.0, 1e5] {
        let mut scaled = description.clone();
        scaled.shapes[0].to_world = DMat4::from_scale(DVec3::splat(scale));
        scaled.views[0].origin *= scale;
        let scene = Scene::build(&scaled, Needs::ALL).expect("box");
        for depth in [1, 2, 3, 8] {
            let rendering = small_render(&scene, [8, 8], 800, depth);
            for (c, albedo) in albedo.iter().enumerate() {
                let series: f64 = (0..depth as i32).map(|k| f64::from(*albedo).powi(k)).sum();
                let expected = series * (c + 1) as f64;
                let [found, sigma] = mean_and_sigma(&rendering, c);
                assert!(
                    (found - expected).abs() < 4.0 * sigma + 1e-5 * expected,
                    "scale {scale}, depth {depth}, channel {c}: {found} ± {sigma}, {expected}"
                );
                assert!(sigma < 0.01 * expected);
            }
        }
    }
}

#[test]
fn a_white_convex_body_disappears_in_a_white_furnace() {
    let found = mean(&in_furnace(Material::diffuse("white", [1.0; 3]), 64, 2));
    assert!((found - 1.0).abs() < 0.003, "{found}");
}

#[test]
fn lossless_glass_disappears_at_any_depth() {
    for thin in [false, true] {
        let glass = Material {
            bsdf: Bsdf::Dielectric {
                ior: 1.5,
                thin,
                reflectance: [1.0; 3],
                transmittance: [1.0; 3],
                roughness: None,
            },
            two_sided: false,
            ..Material::diffuse("glass", [0.0; 3])
        };
        let found = mean(&in_furnace(glass, 64, 60));
        assert!((found - 1.0).abs() < 0.003, "thin {thin}: {found}");
    }
}

#[test]
fn a_half_transparent_white_body_disappears() {
    let mut veil = Material::diffuse("veil", [1.0; 3]);
    veil.opacity = Some(ColourSource::Constant([0.4; 3]));
    let found = mean(&in_furnace(veil, 256, 80));
    assert!((found - 1.0).abs() < 0.01, "{found}");
}

#[test]
fn shiny_bodies_lose_only_what_single_scattering_loses() {
    let metal = |alpha, distribution| Material {
        bsdf: Bsdf::Conductor {
            eta: [0.0; 3],
            k: [0.0; 3],
            specular: ColourSource::Constant([1.0; 3]),
            alpha,
            distribution,
        },
        ..Material::diffuse("metal", [0.0; 3])
    };
    let mirror = mean(&in_furnace(metal(0.0, Ggx), 16, 2));
    assert!((mirror - 1.0).abs() < 1e-4, "{mirror}");
    let [smooth, rough] = [0.05, 0.3].map(|alpha| mean(&in_furnace(metal(alpha, Ggx), 256, 2)));
    assert!((0.99..1.0).contains(&smooth), "{smooth}");
    // A separate integration of the model gives 0.877 at normal incidence, 0.838 at cosine 0.65.
    assert!((0.838..0.877).contains(&rough), "{rough}");
    // Gaussian facets have no long tail of steep ones, so less is lost.
    let gaussian = mean(&in_furnace(metal(0.3, Beckmann), 256, 2));
    assert!(rough < gaussian && gaussian < 1.0, "{gaussian}");
    let coated = Material {
        bsdf: Bsdf::Plastic {
            diffuse: ColourSource::Constant([1.0; 3]),
            specular: [1.0; 3],
            ior: 1.5,
            alpha: 0.0,
            distribution: Ggx,
            nonlinear: true,
            lossless: false,
        },
        ..Material::diffuse("coated", [0.0; 3])
    };
    // A smooth lossless coating over white returns everything.
    let found = mean(&in_furnace(coated, 256, 2));
    assert!((found - 1.0).abs() < 0.01, "{found}");
}

/// What glTF calls a white dielectric: its formula gives about 1, at every roughness.
#[test]
fn lossless_coatings_over_white_disappear_however_rough() {
    for alpha in [0.0, 0.25, 0.64, 1.0] {
        let coated = Material {
            bsdf: Bsdf::Plastic {
                diffuse: ColourSource::Constant([1.0; 3]),
                specular: [1.0; 3],
                ior: 1.5,
                alpha,
                distribution: Ggx,
                nonlinear: false,
                lossless: true,
            },
            ..Material::diffuse("coated", [0.0; 3])
        };
        let found = mean(&in_furnace(coated, 256, 2));
        assert!((found - 1.0).abs() < 0.01, "{alpha}: {found}");
    }
}

#[test]
fn parallel_light_shades_by_the_cosine() {
    let ground = ShapeDescription::new("ground", ShapeSource::Rectangle);
    let eye = DVec3::new(0.0, 0.0, 1.0);
    let material = Material::diffuse("ground", [0.6; 3]);
    let mut description = scene("parallel", eye, material, vec![ground]);
    let direction = DVec3::new(0.6, 0.0, -0.8);
    let sun = LightKind::Directional {
        direction,
        irradiance: [5.0, 1.0, 0.0],
    };
    description.lights = vec![sun.into()];
    let scene = Scene::build(&description, Needs::ALL).expect("ground");
    let expected = 0.6 / std::f32::consts::PI * 0.8;
    for pixel in small_render(&scene, [4, 4], 4, 2).mean.pixels {
        assert!((pixel[0] - 5.0 * expected).abs() < 1e-5, "{pixel:?}");
        assert!((pixel[1] - expected).abs() < 1e-6 && pixel[2] == 0.0);
    }
}

#[test]
fn a_scene_without_light_is_black_and_finite() {
    let material = Material::diffuse("grey", [0.5; 3]);
    let mut description = scene("dark", DVec3::new(0.0, 0.0, 2.0), material, vec![sphere()]);
    let black = Some(EnvironmentDescription::Constant { radiance: [0.0; 3] });
    for environment in [None, black] {
        description.environment = environment;
        let scene = Scene::build(&description, Needs::ALL).expect("dark");
        let image = small_render(&scene, [8, 8], 4, 8).mean;
        assert!(image.pixels.iter().all(|p| *p == [0.0; 3]));
    }
}

#[test]
fn images_depend_on_samples_alone() {
    let material = Material::diffuse("grey", [0.5; 3]);
    let mut description = scene("same", DVec3::new(0.0, 1.0, 2.0), material, vec![sphere()]);
    description.environment = Some(EnvironmentDescription::Constant { radiance: [1.0; 3] });
    let scene = Scene::build(&description, Needs::ALL).expect("scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let path_tracer = PathTracer::new(&scene, &tracer);
    let options = |samples| RenderOptions {
        width: 13,
        height: 9,
        samples,
        seed: 7,
        depths: Depths::up_to(4),
    };
    let with_threads = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads")
            .install(|| render(&path_tracer, &scene.views[0], &options(0..32)))
    };
    let (one, three) = (with_threads(1), with_threads(3));
    assert_eq!(one.mean, three.mean);
    assert_eq!(one.variance, three.variance);
    assert_eq!(one.rays, three.rays);
    let part = |samples| render(&path_tracer, &scene.views[0], &options(samples));
    let merged = part(0..12).merge(&part(12..32)).expect("same size");
    let close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * a.abs().max(1e-3);
    for (a, b) in merged.mean.pixels.iter().zip(&one.mean.pixels) {
        assert!(close(a[0], b[0]), "{a:?} {b:?}");
    }
    for (a, b) in merged.variance.pixels.iter().zip(&one.variance.pixels) {
        assert!(close(a[0], b[0]), "{a:?} {b:?}");
    }
}

#[test]
fn roulette_keeps_the_mean() {
    let mut cube = ShapeDescription::new("box", ShapeSource::Cube);
    cube.flip_normals = true;
    cube.emission = Some([1.0; 3]);
    let material = Material::diffuse("wall", [0.7; 3]);
    let description = scene("roulette", DVec3::new(0.2, 0.1, 0.6), material, vec![cube]);
    let scene = Scene::build(&description, Needs::ALL).expect("box");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let path_tracer = PathTracer::new(&scene, &tracer);
    let options = RenderOptions {
        width: 8,
        height: 8,
        samples: 0..1000,
        seed: 1,
        depths: Depths {
            roulette_from: Some(2),
            ..Depths::up_to(40)
        },
    };
    let found = mean(&render(&path_tracer, &scene.views[0], &options));
    assert!((found * 0.3 - 1.0).abs() < 0.01, "{found}");
}
