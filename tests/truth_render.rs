//! Direct lighting and path tracing against images of independent software (refs/render), whose
//! scenes are defined exactly.

mod truth_support;

use std::path::PathBuf;

use glam::{DMat4, DVec3};
use lightbench::environment::{
    Environment, EnvironmentDescription, EnvironmentOptions, EnvironmentRows,
};
use lightbench::image::Image;
use lightbench::scene::{
    Bsdf, ColourSource, Material, MicrofacetDistribution, Needs, Scene, SceneDescription,
    ShapeDescription, ShapeSource, View,
};
use truth_support::{agreement, reference, reference_file, small_render};

fn shape(name: &str, source: ShapeSource, to_world: DMat4, material: usize) -> ShapeDescription {
    ShapeDescription {
        to_world,
        material,
        ..ShapeDescription::new(name, source)
    }
}

fn one_sided(name: &str, reflectance: [f32; 3]) -> Material {
    Material {
        two_sided: false,
        ..Material::diffuse(name, reflectance)
    }
}

fn description(name: &str, view: View) -> SceneDescription {
    SceneDescription {
        name: name.into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        views: vec![view],
        ..SceneDescription::default()
    }
}

fn cornell(obj: PathBuf) -> Scene {
    let view = View::look_at(
        "front",
        [DVec3::new(0.0, 0.0, 3.9), DVec3::ZERO, DVec3::Y],
        39.3077,
        [256, 256],
    );
    let mut scene = description("cornell", view);
    scene.materials = vec![
        one_sided("white", [0.885809, 0.698859, 0.666422]),
        one_sided("green", [0.105421, 0.37798, 0.076425]),
        one_sided("red", [0.570068, 0.0430135, 0.0443706]),
    ];
    let parts = [
        "back",
        "ceiling",
        "floor",
        "green-wall",
        "red-wall",
        "light",
    ];
    let boxes = ["large-box", "small-box"]
        .iter()
        .flat_map(|b| ["x-", "x+", "y-", "y+", "z-", "z+"].map(|f| format!("{b}-{f}")));
    for part in parts.map(String::from).into_iter().chain(boxes) {
        let material = match part.as_str() {
            "green-wall" => 1,
            "red-wall" => 2,
            _ => 0,
        };
        let source = ShapeSource::Obj {
            path: obj.clone(),
            part: Some(part.clone()),
            material: None,
        };
        let mut shape = shape(&part, source, DMat4::IDENTITY, material);
        shape.face_normals = true;
        if part == "light" {
            shape.emission = Some([18.387, 13.9873, 6.75357]);
        }
        scene.shapes.push(shape);
    }
    Scene::build(&scene, Needs::ALL).expect("cornell box")
}

fn sphere_and_box(name: &str, materials: [Material; 3]) -> SceneDescription {
    let view = View::look_at(
        "front",
        [
            DVec3::new(0.0, 2.2, 6.5),
            DVec3::new(0.0, 0.7, 0.0),
            DVec3::Y,
        ],
        40.0,
        [256, 256],
    );
    let mut scene = description(name, view);
    scene.materials = materials.into();
    let ground = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2)
        * DMat4::from_scale(DVec3::splat(10.0));
    let cube = DMat4::from_translation(DVec3::new(1.4, 0.6, 0.2))
        * DMat4::from_rotation_y(30f64.to_radians())
        * DMat4::from_scale(DVec3::splat(0.6));
    let sphere = ShapeSource::Sphere {
        centre: DVec3::new(-1.0, 1.0, 0.0),
        radius: 1.0,
    };
    scene.shapes = vec![
        shape("ground", ShapeSource::Rectangle, ground, 0),
        shape("sphere", sphere, DMat4::IDENTITY, 1),
        shape("box", ShapeSource::Cube, cube, 2),
    ];
    scene
}

/// The scenes B of the references with their sun map, looked up as Mitsuba does.
fn under_sun(name: &str, materials: [Material; 3], map: &Image) -> Scene {
    let scene = sphere_and_box(name, materials);
    let mut scene = Scene::build(&scene, Needs::ALL).expect("scene");
    let options = EnvironmentOptions {
        rows: EnvironmentRows::PoleCentred,
        ..EnvironmentOptions::default()
    };
    scene.environment = Some(Environment::from_image(map, &options).expect("map"));
    scene
}

/// Renders at a quarter of the size and compares with the reduced reference, whose own noise (its
/// stated RMSE, evenly) is counted in.
fn check(scene: &Scene, name: &str, [spp, depth]: [u32; 2], [rmse, bias]: [f64; 2]) {
    let Some(full) = reference(&format!("render/{name}.exr")) else {
        return;
    };
    let small = full.box_downsample(4);
    let ours = small_render(scene, [small.width, small.height], spp.into(), depth);
    let variance = (rmse * rmse / 16.0) as f32;
    let noise = small.map(|_| [variance; 3]);
    let found = agreement(&ours, &small, &noise, [4.0, bias]);
    println!("{name}: {found:?}");
    assert!((0.5..1.25).contains(&found.z_rms), "{name}: {found:?}");
    assert!(found.bad_blocks <= 0.004, "{name}: {found:?}");
    for (ratio, sigma) in found.ratio.iter().zip(found.ratio_sigma) {
        assert!(
            (ratio - 1.0).abs() < 3.5 * sigma + 1e-3,
            "{name}: {found:?}"
        );
    }
}

#[test]
fn cornell_box_direct_and_one_bounce() {
    let Some(obj) = reference_file("render/cornell.obj") else {
        return;
    };
    let scene = cornell(obj);
    check(&scene, "cornell_depth2", [128, 2], [0.00247, 0.004]);
    check(&scene, "cornell_depth3", [128, 3], [0.00363, 0.004]);
}

#[test]
fn diffuse_and_metal_under_a_sun() {
    let Some(map) = reference("render/env_sun_512x256.exr") else {
        return;
    };
    let ground = one_sided("ground", [0.5; 3]);
    let diffuse = [
        ground.clone(),
        one_sided("sphere", [0.7, 0.3, 0.2]),
        one_sided("box", [0.2, 0.5, 0.7]),
    ];
    let scene = under_sun("env_diffuse", diffuse, &map);
    check(&scene, "env_diffuse", [128, 2], [0.00676, 0.004]);
    let metal = |name: &str, specular| Material {
        bsdf: Bsdf::Conductor {
            eta: [0.0; 3],
            k: [0.0; 3],
            specular: ColourSource::Constant(specular),
            alpha: 0.2,
            distribution: MicrofacetDistribution::Ggx,
        },
        ..one_sided(name, [0.0; 3])
    };
    let metals = [
        ground,
        metal("sphere", [1.0; 3]),
        metal("box", [0.9, 0.6, 0.3]),
    ];
    let scene = under_sun("env_conductor", metals, &map);
    check(&scene, "env_conductor", [128, 2], [0.00959, 0.004]);
}

/// Plastics have no reference image. They must turn into the diffuse scene as the index goes to 1
/// and change by little for a little change of index or roughness.
#[test]
fn plastic_under_a_sun_is_continuous_and_bounded() {
    let Some(map) = reference("render/env_sun_512x256.exr") else {
        return;
    };
    let plastic = |name: &str, diffuse, [ior, alpha]: [f32; 2]| Material {
        bsdf: Bsdf::Plastic {
            diffuse: ColourSource::Constant(diffuse),
            specular: [1.0; 3],
            ior,
            alpha,
            distribution: MicrofacetDistribution::Ggx,
            nonlinear: false,
            lossless: false,
        },
        ..one_sided(name, [0.0; 3])
    };
    let mean = |materials: [Material; 3]| {
        let scene = under_sun("env_plastic", materials, &map);
        let rendering = small_render(&scene, [64, 64], 256, 2);
        // The sphere and the box: the middle of the image, without ground and sky.
        let pixels = (20..44).flat_map(|y| (14..50).map(move |x| (x, y)));
        let sum = pixels.fold([0.0f64; 3], |sum, (x, y)| {
            std::array::from_fn(|c| sum[c] + f64::from(rendering.mean.at(x, y)[c]))
        });
        sum.map(|s| s / (24.0 * 36.0))
    };
    let coated = |parameters| {
        mean([
            one_sided("ground", [0.5; 3]),
            plastic("sphere", [0.7, 0.3, 0.2], parameters),
            plastic("box", [0.2, 0.5, 0.7], parameters),
        ])
    };
    let diffuse = mean([
        one_sided("ground", [0.5; 3]),
        one_sided("sphere", [0.7, 0.3, 0.2]),
        one_sided("box", [0.2, 0.5, 0.7]),
    ]);
    let near = |a: [f64; 3], b: [f64; 3], tolerance: f64| {
        let close = a
            .iter()
            .zip(b)
            .all(|(a, b)| (a / b - 1.0).abs() < tolerance);
        assert!(close, "{a:?} {b:?}");
    };
    near(coated([1.001, 0.001]), diffuse, 0.01);
    let [plastic, rougher, denser] = [[1.5, 0.2], [1.5, 0.205], [1.51, 0.2]].map(coated);
    println!("env_plastic: {plastic:?}, diffuse {diffuse:?}");
    near(plastic, rougher, 0.02);
    near(plastic, denser, 0.02);
    // The coating adds its own reflection and takes less than that from the base.
    near(plastic, diffuse, 0.35);
}

#[test]
fn a_constant_sky_shows_ambient_occlusion() {
    let white = one_sided("white", [1.0; 3]);
    let mut scene = sphere_and_box("ao", [white.clone(), white.clone(), white]);
    scene.environment = Some(EnvironmentDescription::Constant { radiance: [1.0; 3] });
    let scene = Scene::build(&scene, Needs::ALL).expect("scene");
    check(&scene, "ao_constant_sky", [64, 2], [0.00485, 0.004]);
}
