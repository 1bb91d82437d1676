//! Irradiance caching against known answers, and what it does where there is little to cache.

use glam::{DMat4, DVec3};
use lightbench::image::Image;
use lightbench::placement::{FIRST_STAGES, REFINEMENTS};
use lightbench::registry::technique;
use lightbench::scene::{
    Bsdf, ColourSource, Material, MicrofacetDistribution, Needs, Scene, SceneDescription,
    ShapeDescription, ShapeSource, View,
};
use lightbench::shade::{Depths, RenderOptions, render};
use lightbench::technique::{Choice, Film, Rendered, Search, Shot, Terms, reference_pass};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

const SIZE: [usize; 2] = [12, 12];

fn shape(source: ShapeSource, to_world: DMat4) -> ShapeDescription {
    ShapeDescription {
        to_world,
        ..ShapeDescription::new("shape", source)
    }
}

fn description(eye: DVec3, shapes: Vec<ShapeDescription>) -> SceneDescription {
    SceneDescription {
        name: "test".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        max_depth: 6,
        views: vec![View::look_at("v", [eye, DVec3::ZERO, DVec3::Y], 60.0, SIZE)],
        materials: vec![Material::diffuse("grey", [0.8, 0.5, 0.1])],
        shapes,
        ..SceneDescription::default()
    }
}

/// The inside of a cube of side 2.
fn room() -> ShapeDescription {
    ShapeDescription {
        flip_normals: true,
        ..shape(ShapeSource::Cube, DMat4::IDENTITY)
    }
}

/// A square lamp below the ceiling of the room, shining down.
fn lamp(side: f64, emission: f32) -> ShapeDescription {
    let down = DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let place = DMat4::from_translation(DVec3::new(0.0, 0.99, 0.0));
    ShapeDescription {
        emission: Some([emission; 3]),
        ..shape(
            ShapeSource::Rectangle,
            place * down * DMat4::from_scale(DVec3::splat(side / 2.0)),
        )
    }
}

#[derive(Clone, Copy)]
struct Setting<'a> {
    method: &'a str,
    caches: usize,
    parameters: &'a str,
}

/// Renders one contender of a scene.
fn cached(description: &SceneDescription, setting: &Setting) -> Rendered {
    let of_method = match setting.method.starts_with("SD") {
        true => "min_cluster_size = 1",
        false => "",
    };
    rendered(description, setting, of_method, None)
}

/// The same with parameters of its method, and with a reference for those that pick settings by error.
fn rendered(
    description: &SceneDescription,
    setting: &Setting,
    of_method: &str,
    reference: Option<&Image>,
) -> Rendered {
    let parameters: toml::Table = setting.parameters.parse().expect("toml");
    let entry = technique("irradiance-caching").expect("registered");
    let technique = (entry.build)(&parameters).expect("parameters");
    let scene = Scene::build(description, technique.needs()).expect("scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: SIZE[0],
        height: SIZE[1],
        spp: 1,
    };
    let mut shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let of_method: toml::Table = of_method.parse().expect("toml");
    let choice = Choice {
        method: setting.method,
        parameters: &of_method,
        terms: Terms {
            budget: setting.caches,
            seed: 1,
        },
    };
    let technique = technique.as_ref();
    shot.layer = technique.shared_layer(&shot);
    choice.still(technique, &shot, reference).expect("renders")
}

fn mean(image: &Image) -> [f64; 3] {
    let count = image.pixels.len() as f64;
    std::array::from_fn(|c| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / count)
}

/// Every distribution, every refinement after VGC, and the classic cache.
fn methods() -> Vec<String> {
    let first = FIRST_STAGES.iter().map(|e| e.about.id.to_owned());
    let refined = REFINEMENTS.iter().map(|e| format!("VGC+{}", e.about.id));
    let classic = ["on-demand".to_owned()];
    first.chain(refined).chain(classic).collect()
}

#[test]
fn a_closed_glowing_box_sums_the_higher_orders_of_its_series() {
    let mut cube = room();
    cube.emission = Some([1.0, 2.0, 3.0]);
    let glowing = description(DVec3::new(0.2, 0.1, 0.6), vec![cube]);
    for method in methods() {
        let setting = Setting {
            method: &method,
            caches: 20,
            parameters: "side = 32",
        };
        let found = mean(&cached(&glowing, &setting).image);
        for (c, albedo) in [0.8f64, 0.5, 0.1].into_iter().enumerate() {
            let series: f64 = (2..6).map(|k| albedo.powi(k)).sum();
            let expected = series * (c + 1) as f64;
            let error = (found[c] - expected).abs() / expected;
            assert!(
                error < 0.02,
                "{method}, channel {c}: {} {expected}",
                found[c]
            );
        }
    }
}

#[test]
fn direct_and_indirect_layers_add_up_to_path_tracing() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let setting = Setting {
        method: "VGC+DGS",
        caches: 100,
        parameters: "side = 32\nlayer = 'global'\nreference_passes = 256",
    };
    let found = mean(&cached(&lit, &setting).image);
    let scene = Scene::build(&lit, Needs::ALL).expect("scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: SIZE[0],
        height: SIZE[1],
        spp: 1,
    };
    let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let options = RenderOptions {
        width: SIZE[0],
        height: SIZE[1],
        samples: 0..512,
        seed: 3,
        depths: Depths::up_to(6),
    };
    let expected = mean(&render(&shot.paths, &scene.views[0], &options).mean);
    for c in 0..3 {
        let error = (found[c] - expected[c]).abs() / expected[c];
        assert!(error < 0.03, "channel {c}: {} {}", found[c], expected[c]);
    }
}

#[test]
fn the_reference_and_the_estimate_per_sample_agree_with_dense_records() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let entry = technique("irradiance-caching").expect("registered");
    let technique = (entry.build)(&"side = 32".parse().expect("toml")).expect("parameters");
    let scene = Scene::build(&lit, technique.needs()).expect("scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: SIZE[0],
        height: SIZE[1],
        spp: 1,
    };
    let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let function = technique.shading_function(&shot);
    let mut exact = [0.0; 3];
    for pass in 0..400 {
        let (image, non_finite) =
            reference_pass(function.as_ref(), &shot, pass, &RayCounter::default());
        assert_eq!(non_finite, 0);
        let own = mean(&image);
        (0..3).for_each(|c| exact[c] += own[c] / 400.0);
    }
    for method in ["IM", "per-sample"] {
        let setting = Setting {
            method,
            caches: SIZE[0] * SIZE[1],
            parameters: "side = 32",
        };
        let rendered = cached(&lit, &setting);
        let found = mean(&rendered.image);
        for c in 0..3 {
            let error = (found[c] - exact[c]).abs() / exact[c];
            assert!(
                error < 0.02,
                "{method}, channel {c}: {} {}",
                found[c],
                exact[c]
            );
        }
    }
}

#[test]
fn equal_rays_are_equal() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let rays = |method| {
        let setting = Setting {
            method,
            caches: 100,
            parameters: "side = 16",
        };
        let rays = cached(&lit, &setting).rays;
        (rays.closest + rays.shadow) as f64
    };
    let ratio = rays("per-sample") / rays("IM");
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}

/// A value that a contender found.
fn found(rendered: &Rendered, key: &str) -> f64 {
    let found = rendered.found.iter().find(|(k, _)| *k == key);
    found.expect(key).1
}

fn stage_names(rendered: &Rendered) -> Vec<&str> {
    rendered.stages.0.iter().map(|stage| stage.name).collect()
}

#[test]
fn the_direct_layer_is_the_same_and_free_for_records_and_for_samples() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let direct = ["IM", "per-sample"].map(|method| {
        let [global, indirect] = ["global", "indirect"].map(|layer| {
            let parameters = format!("side = 8\nreference_passes = 4\nlayer = '{layer}'");
            let setting = Setting {
                method,
                caches: 40,
                parameters: &parameters,
            };
            cached(&lit, &setting)
        });
        assert_eq!(global.rays, indirect.rays, "{method}");
        assert_eq!(stage_names(&global), stage_names(&indirect), "{method}");
        let both = global.image.pixels.into_iter().zip(indirect.image.pixels);
        both.map(|(all, some)| [0, 1, 2].map(|c| all[c] - some[c]))
            .collect::<Vec<[f32; 3]>>()
    });
    assert!(direct[0].iter().flatten().any(|v| *v > 0.1));
    for (a, b) in direct[0].iter().zip(&direct[1]) {
        // Up to the rounding of what was added and taken away.
        (0..3).for_each(|c| assert!((a[c] - b[c]).abs() <= 1e-4 * (1.0 + a[c]), "{a:?} {b:?}"));
    }
}

#[test]
fn trial_clusterings_are_searched_for_and_only_the_chosen_one_is_charged() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let setting = Setting {
        method: "SD",
        caches: 20,
        parameters: "side = 8",
    };
    let reference = cached(
        &lit,
        &Setting {
            caches: 144,
            ..setting
        },
    )
    .image;
    let picked = rendered(
        &lit,
        &setting,
        "min_cluster_size = 'best'",
        Some(&reference),
    );
    let size = found(&picked, "min_cluster_size");
    let set = rendered(&lit, &setting, &format!("min_cluster_size = {size}"), None);
    assert_eq!(picked.image, set.image);
    assert_eq!((picked.rays, picked.lookups), (set.rays, set.lookups));
    assert_eq!(stage_names(&picked), stage_names(&set));
    assert_eq!(set.search, Search::default());
    let search = picked.search;
    assert!(
        search.rays.all() > 5 * set.rays.all(),
        "of six clusterings: {search:?}"
    );
    assert!(search.seconds.wall > 0.0);
}

/// Where light is reflected once, all records cost the same.
#[test]
fn overtures_are_searched_for_and_only_the_records_of_the_last_are_charged() {
    let mut lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    lit.max_depth = 2;
    let setting = Setting {
        method: "on-demand",
        caches: 20,
        parameters: "side = 8",
    };
    let rendered = cached(&lit, &setting);
    assert_eq!(
        stage_names(&rendered),
        ["shading_points", "records", "rendering"]
    );
    let camera_rays = 2 * (SIZE[0] * SIZE[1]) as u64;
    let records = rendered.records.len() as u64;
    let charged = rendered.rays.closest - camera_rays;
    let evaluated = found(&rendered, "evaluated") as u64;
    assert_eq!(charged % records, 0);
    assert_eq!(rendered.search.rays.closest, evaluated * charged / records);
    assert!(
        evaluated > records,
        "{evaluated} in all overtures, {records} in the last"
    );
}

/// A floor with a wall of no thickness across it; the lamp is on the left, the camera on the right
/// sees the wall's dark side at grazing distance to its lit one.
#[test]
fn the_two_sides_of_a_thin_wall_do_not_mix() {
    let wall = shape(
        ShapeSource::Rectangle,
        DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2) * DMat4::from_scale(DVec3::splat(5.0)),
    );
    let lit_floor = shape(
        ShapeSource::Rectangle,
        DMat4::from_translation(DVec3::new(-2.0, -1.0, 0.0))
            * DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2)
            * DMat4::from_scale(DVec3::splat(1.5)),
    );
    let light = ShapeDescription {
        emission: Some([50.0; 3]),
        ..shape(
            ShapeSource::Rectangle,
            DMat4::from_translation(DVec3::new(-2.0, 2.0, 0.0))
                * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2),
        )
    };
    let shapes = vec![wall, lit_floor, light];
    let bright = description(DVec3::new(-4.0, 0.0, 0.3), shapes.clone());
    let dark = description(DVec3::new(4.0, 0.0, 0.3), shapes);
    for method in methods() {
        let setting = Setting {
            method: &method,
            caches: 30,
            parameters: "side = 16",
        };
        assert!(mean(&cached(&bright, &setting).image)[0] > 0.1, "{method}");
        assert_eq!(mean(&cached(&dark, &setting).image), [0.0; 3], "{method}");
    }
}

#[test]
fn hard_cases_stay_finite_and_sane() {
    let eye = DVec3::new(0.3, 0.2, 0.9);
    let plain = description(eye, vec![room(), lamp(0.5, 20.0)]);
    let mut black = plain.clone();
    black.materials = vec![Material::diffuse("black", [0.0; 3])];
    let mut glossy = plain.clone();
    glossy.materials = vec![Material {
        bsdf: Bsdf::Conductor {
            eta: [0.2; 3],
            k: [3.0; 3],
            specular: ColourSource::Constant([1.0; 3]),
            alpha: 0.01,
            distribution: MicrofacetDistribution::Ggx,
        },
        ..Material::diffuse("metal", [0.5; 3])
    }];
    let cases = [
        ("no light", description(eye, vec![room()]), true),
        ("black", black, true),
        (
            "tiny bright lamp",
            description(eye, vec![room(), lamp(0.002, 1e6)]),
            false,
        ),
        ("glossy", glossy, false),
        ("lit", plain, false),
    ];
    let methods = ["VGC+DGS", "on-demand"];
    for (name, scene, dark) in &cases {
        for (caches, method) in [1, 2, 19, 5000]
            .into_iter()
            .flat_map(|n| methods.map(|m| (n, m)))
        {
            let setting = Setting {
                method,
                caches,
                parameters: "side = 8",
            };
            let rendered = cached(scene, &setting);
            let values = rendered.image.pixels.iter().flatten();
            assert!(
                values.clone().all(|v| v.is_finite() && *v >= 0.0),
                "{name} {method}"
            );
            assert_eq!(rendered.non_finite, 0, "{name}");
            assert_eq!(
                values.sum::<f32>() == 0.0,
                *dark,
                "{name} {caches} {method}"
            );
        }
    }
}

#[test]
fn a_view_of_nothing_is_black() {
    let mut away = description(DVec3::new(0.0, 0.0, 5.0), vec![room()]);
    away.views = vec![View::look_at(
        "v",
        [DVec3::Z * 5.0, DVec3::Z * 9.0, DVec3::Y],
        60.0,
        SIZE,
    )];
    for method in ["VGC+DGS", "on-demand", "per-sample"] {
        let setting = Setting {
            method,
            caches: 10,
            parameters: "side = 8",
        };
        assert_eq!(mean(&cached(&away, &setting).image), [0.0; 3], "{method}");
    }
}

#[test]
fn images_do_not_depend_on_the_number_of_threads() {
    let lit = description(DVec3::new(0.3, 0.2, 0.9), vec![room(), lamp(0.5, 20.0)]);
    let with_threads = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads")
            .install(|| {
                ["VGC+DGS", "on-demand", "per-sample"].map(|method| {
                    let setting = Setting {
                        method,
                        caches: 40,
                        parameters: "side = 8\nlayer = 'global'\nreference_passes = 4",
                    };
                    let rendered = cached(&lit, &setting);
                    (rendered.image, rendered.rays.closest, rendered.rays.shadow)
                })
            })
    };
    assert_eq!(with_threads(1), with_threads(3));
}
