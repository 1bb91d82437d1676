//! Light samples and ReSTIR: what is unbiased is, what is biased is too dark, and memory, threads and viewers change nothing.

use glam::{DMat4, DVec3};
use lightbench::image::{Image, luminance};
use lightbench::registry::technique;
use lightbench::scene::{
    Bsdf, ColourSource, LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription,
    ShapeSource, View,
};
use lightbench::technique::{Contender, Film, Passes, Rendered, Shot, Technique, Terms};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

const SIZE: [usize; 2] = [16, 12];

fn direct() -> Box<dyn Technique> {
    let entry = technique("direct-lighting").expect("listed");
    (entry.build)(&toml::Table::new()).expect("defaults")
}

fn start<'a>(
    technique: &'a dyn Technique,
    (method, parameters): (&str, &str),
    seed: u64,
) -> Box<dyn Contender + 'a> {
    let table: toml::Table = parameters.parse().expect("toml");
    let terms = Terms { budget: 1, seed };
    let started = technique.start(method, &table, terms);
    started.expect("starts").contender
}

/// A scene with its tree.
struct Built {
    scene: Scene,
    tracer: Tracer,
}

impl Built {
    fn new(description: &SceneDescription) -> Self {
        let scene = Scene::build(description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Self { scene, tracer }
    }

    fn shot(&self, viewer: u16, frame: u32) -> Shot<'_> {
        let film = Film {
            width: SIZE[0],
            height: SIZE[1],
            spp: 1,
        };
        let moment = Moment::still(&self.scene, &self.tracer);
        let view = &self.scene.views[usize::from(viewer)];
        let mut shot = Shot::new(moment, view, film);
        shot.viewer = viewer;
        shot.frame = frame;
        shot
    }

    /// The last of frames `0..count` of the first viewer.
    fn play(&self, contender: &mut dyn Contender, count: u32) -> Rendered {
        let mut last = Rendered::default();
        for frame in 0..count {
            let mut images = contender.frame(&[self.shot(0, frame)]).expect("a frame");
            last = images.pop().expect("one image");
        }
        last
    }

    /// Mean luminance of paths, and its standard error.
    fn truth(&self, technique: &dyn Technique) -> (f64, f64) {
        let shot = self.shot(0, 0);
        let function = technique.shading_function(&shot);
        let parts: Vec<f64> = (0..16)
            .map(|part| {
                let mut passes = Passes::starting_at(part * 128, &shot, function.as_ref());
                (0..128).for_each(|_| passes.add(&RayCounter::default()));
                mean(&passes.mean())
            })
            .collect();
        mean_and_error(&parts)
    }

    /// Mean luminance of the fourth frame over many seeds, and its standard error.
    fn fourth_frame(&self, technique: &dyn Technique, how: (&str, &str)) -> (f64, f64) {
        let of_seed = |seed| mean(&self.play(start(technique, how, seed).as_mut(), 4).image);
        mean_and_error(&(0..SEEDS).map(of_seed).collect::<Vec<f64>>())
    }
}

const SEEDS: u64 = 200;

fn mean(image: &Image) -> f64 {
    let values = image.pixels.iter().map(|p| f64::from(luminance(*p)));
    values.sum::<f64>() / image.pixels.len() as f64
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn found(rendered: &Rendered, key: &str) -> f64 {
    let found = rendered.found.iter().find(|(k, _)| *k == key);
    found.unwrap_or_else(|| panic!("no {key}")).1
}

/// A floor with a block on it, under a lamp, a bulb and parallel light, seen twice.
fn room(material: Material, lamp: f32) -> SceneDescription {
    let shape = |name: &str, source, to_world| ShapeDescription {
        to_world,
        ..ShapeDescription::new(name, source)
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let floor = DMat4::from_rotation_x(-quarter) * DMat4::from_scale(DVec3::splat(2.0));
    let block = DMat4::from_translation(DVec3::new(0.3, 0.4, -0.2))
        * DMat4::from_rotation_y(0.4)
        * DMat4::from_scale(DVec3::splat(0.4));
    let above = DMat4::from_translation(DVec3::new(0.0, 2.5, 0.0))
        * DMat4::from_rotation_x(quarter)
        * DMat4::from_scale(DVec3::splat(0.5));
    let mut light = shape("lamp", ShapeSource::Rectangle, above);
    light.emission = Some([lamp; 3]);
    let bulb = LightKind::Point {
        position: DVec3::new(-1.2, 0.9, 0.4),
        intensity: [0.3 * lamp; 3],
    };
    let sun = LightKind::Directional {
        direction: DVec3::new(0.6, -0.8, 0.1),
        irradiance: [0.1 * lamp; 3],
    };
    let eye = |x: f64| [DVec3::new(x, 1.6, 3.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y];
    SceneDescription {
        name: "room".into(),
        views: vec![
            View::look_at("left", eye(-1.0), 50.0, SIZE),
            View::look_at("right", eye(1.2), 50.0, SIZE),
        ],
        materials: vec![material],
        shapes: vec![
            shape("floor", ShapeSource::Rectangle, floor),
            shape("block", ShapeSource::Cube, block),
            light,
        ],
        lights: vec![bulb.into(), sun.into()],
        ..SceneDescription::default()
    }
}

fn diffuse() -> Material {
    Material::diffuse("grey", [0.6, 0.5, 0.4])
}

fn metal() -> Material {
    Material {
        bsdf: Bsdf::Conductor {
            eta: [0.2; 3],
            k: [3.0; 3],
            specular: ColourSource::Constant([1.0; 3]),
            alpha: 0.3,
            distribution: Default::default(),
        },
        ..diffuse()
    }
}

const SELECTIONS: [&str; 4] = ["uniform", "power", "systematic", "product"];

#[test]
fn unbiased_contenders_have_the_mean_of_paths_after_frames() {
    let technique = direct();
    for (what, material) in [("diffuse", diffuse()), ("glossy", metal())] {
        let built = Built::new(&room(material, 8.0));
        let (truth, truth_error) = built.truth(technique.as_ref());
        let mut variants = vec![
            ("restir-unbiased", String::new()),
            ("restir-unbiased", "weights = 'support'".into()),
            ("restir-unbiased", "reservoirs = 2\nrounds = 2".into()),
            ("restir-unbiased", "presampled = true".into()),
            ("restir-unbiased", "least_history = 2".into()),
            (
                "restir-unbiased",
                "candidates = 2\nsurface_candidates = 2".into(),
            ),
            (
                "restir-unbiased",
                "surface_candidates = 1\npresampled = true".into(),
            ),
        ];
        let selections = SELECTIONS.map(|s| ("rt", format!("selection = '{s}'\nrays = 4")));
        variants.extend(selections);
        for (method, parameters) in &variants {
            let how = (*method, parameters.as_str());
            let (mean, error) = built.fourth_frame(technique.as_ref(), how);
            let z = (mean - truth) / error.hypot(truth_error);
            let told = format!("{what}, {method} {parameters}: {mean} {truth}, z = {z}");
            println!("{told}");
            assert!(z.abs() < 4.0, "{told}");
        }
    }
}

#[test]
fn the_biased_form_is_too_dark_and_its_neighbours_are_why() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    let (truth, truth_error) = built.truth(technique.as_ref());
    let of = |parameters| built.fourth_frame(technique.as_ref(), ("restir", parameters));
    // Neighbours from far away and over edges: more bias than with the method's own radius.
    let far = "radius = 8\nangle_deg = 180\ndepth = 1000.0";
    let (mean, error) = of(far);
    let z = (mean - truth) / error.hypot(truth_error);
    println!("far: {mean} {truth}, z = {z}");
    assert!(z < -6.0, "{mean} {truth}, z = {z}");
    let (mean, error) = of("neighbours = 0\nhistory = 0");
    let z = (mean - truth) / error.hypot(truth_error);
    println!("alone: {mean} {truth}, z = {z}");
    assert!(z.abs() < 4.0, "{mean} {truth}, z = {z}");
}

/// Few places of a large lamp are in the highlight that a surface shows of it: its own directions find them.
#[test]
fn candidates_of_the_surface_lower_the_noise_of_highlights() {
    let technique = direct();
    let mut glossy = metal();
    let Bsdf::Conductor { alpha, .. } = &mut glossy.bsdf else {
        unreachable!("a metal")
    };
    *alpha = 0.05;
    let mut description = room(glossy, 8.0);
    description.lights.clear();
    description.shapes[2].to_world *= DMat4::from_scale(DVec3::splat(8.0));
    let built = Built::new(&description);
    let alone = "neighbours = 0\nhistory = 0\ncandidates = 4";
    let spread = |surface_candidates: u32| {
        let parameters = format!("{alone}\nsurface_candidates = {surface_candidates}");
        built.fourth_frame(technique.as_ref(), ("restir-unbiased", &parameters))
    };
    let [without, with] = [0, 1].map(spread);
    println!("without {without:?}, with {with:?}");
    assert!(with.1 < 0.7 * without.1, "{with:?} {without:?}");
    let z = (with.0 - without.0) / with.1.hypot(without.1);
    assert!(z.abs() < 4.0, "{with:?} {without:?}");
}

/// Nothing of it is in the light of a first frame, of which all samples are naive.
#[test]
fn neighbours_without_history_are_not_asked() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    let first_frames = |parameters: &str, count| {
        let mut contender = start(technique.as_ref(), ("rtxdi", parameters), 6);
        built.play(contender.as_mut(), count).image.pixels
    };
    let alone = |count| first_frames("neighbours = 0\nneighbours_without_history = 0", count);
    assert_eq!(first_frames("", 2), alone(2));
    assert_ne!(first_frames("", 3), alone(3));
    assert_ne!(first_frames("least_history = 0", 1), alone(1));
}

#[test]
fn the_filter_makes_what_boils_darker_and_counts_it() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    let mean_and_emptied = |boiling: f32| {
        let parameters = format!("boiling = {boiling}");
        let mut contender = start(technique.as_ref(), ("rtxdi", &parameters), 7);
        let last = built.play(contender.as_mut(), 4);
        let emptied = last.found.iter().find(|(k, _)| *k == "boiling_reservoirs");
        (mean(&last.image), emptied.map(|(_, count)| *count))
    };
    let (off, strong) = (mean_and_emptied(0.0), mean_and_emptied(1.0));
    assert_eq!(off.1, None);
    assert!(strong.1.is_some_and(|count| count > 1.0), "{strong:?}");
    assert!(strong.0 < off.0, "{strong:?} {off:?}");
}

#[test]
fn reuse_lowers_the_error_of_a_still_scene() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    let spread = |parameters: &str| {
        let how = ("restir-unbiased", parameters);
        built.fourth_frame(technique.as_ref(), how).1
    };
    let alone = spread("candidates = 4\nneighbours = 0\nhistory = 0");
    let reused = spread("candidates = 4");
    // The image's mean gains less than its pixels do, because errors of neighbours are alike.
    println!("spread alone {alone}, reused {reused}");
    let noise = |parameters: &str| {
        let images: Vec<Image> = (0..24)
            .map(|seed| {
                let how = ("restir-unbiased", parameters);
                let mut contender = start(technique.as_ref(), how, seed);
                built.play(contender.as_mut(), 4).image
            })
            .collect();
        let pixels = SIZE[0] * SIZE[1];
        let variance = |i: usize| {
            let values: Vec<f64> = images
                .iter()
                .map(|m| luminance(m.pixels[i]).into())
                .collect();
            mean_and_error(&values).1.powi(2)
        };
        (0..pixels).map(variance).sum::<f64>()
    };
    let of = [
        noise("candidates = 4\nneighbours = 0\nhistory = 0"),
        noise("candidates = 4"),
    ];
    assert!(of[1] < of[0], "{of:?}");
}

#[test]
fn a_sequence_goes_on_from_what_was_remembered_and_threads_change_nothing() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    let methods = [
        ("restir", ""),
        ("restir", "boiling = 1.0\nsurface_candidates = 2"),
        ("restir-unbiased", ""),
        ("rtxdi", ""),
    ];
    for how in methods {
        let method = how.0;
        let new = || start(technique.as_ref(), how, 3);
        let render = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool")
                .install(|| built.play(new().as_mut(), 3))
        };
        let (one, four) = (render(1), render(4));
        assert_eq!(one.image.pixels, four.image.pixels, "{method}");
        assert_eq!(
            (one.rays, one.lookups),
            (four.rays, four.lookups),
            "{method}"
        );
        let mut first = new();
        built.play(first.as_mut(), 2);
        let memory = first.memory().expect("memory");
        let mut second = new();
        second.recall(&memory).expect("recalls");
        let resumed = second.frame(&[built.shot(0, 2)]).expect("a frame");
        assert_eq!(resumed[0].image.pixels, one.image.pixels, "{method}");
        assert!(found(&one, "reprojected") > 0.5, "{method}");
        // A memory of another number of reservoirs is refused.
        let mut other = start(technique.as_ref(), (method, "reservoirs = 7"), 3);
        assert!(other.recall(&memory).is_err(), "{method}");
    }
}

#[test]
fn viewers_know_nothing_of_each_other_in_any_order() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 8.0));
    for method in ["rt", "restir", "rtxdi"] {
        let play = |viewers: &[u16]| {
            let mut contender = start(technique.as_ref(), (method, ""), 4);
            let mut last = Vec::new();
            for frame in 0..3 {
                let shots: Vec<Shot> = viewers.iter().map(|v| built.shot(*v, frame)).collect();
                last = contender.frame(&shots).expect("images");
            }
            last.into_iter().map(|r| r.image.pixels).collect::<Vec<_>>()
        };
        let (both, turned) = (play(&[0, 1]), play(&[1, 0]));
        assert_eq!(both[0], turned[1], "{method}");
        assert_eq!(both[1], turned[0], "{method}");
        assert_eq!(both[0], play(&[0])[0], "{method}");
    }
}

#[test]
fn scale_and_place_change_nothing_but_noise() {
    let technique = direct();
    let plain = room(diffuse(), 8.0);
    let mut area_light_alone = plain.clone();
    area_light_alone.lights.clear();
    let (expected, error) =
        Built::new(&area_light_alone).fourth_frame(technique.as_ref(), ("restir-unbiased", ""));
    for (scale, offset) in [(1e-3, 0.0), (1e5, 0.0), (1.0, 1e4)] {
        let description = area_light_alone
            .clone()
            .transformed(scale, 0.0, DVec3::splat(offset));
        let built = Built::new(&description);
        let (mean, other) = built.fourth_frame(technique.as_ref(), ("restir-unbiased", ""));
        let z = (mean - expected) / error.hypot(other);
        assert!(
            z.abs() < 4.5,
            "scale {scale}, offset {offset}: {mean} {expected}"
        );
    }
}

#[test]
fn dark_and_broken_scenes_stay_finite() {
    let technique = direct();
    let mut broken = room(diffuse(), 8.0);
    broken.materials[0].bsdf = Bsdf::Diffuse {
        reflectance: ColourSource::Constant([f32::NAN; 3]),
    };
    let dark = room(diffuse(), 0.0);
    for method in ["rt", "restir", "restir-unbiased", "rtxdi"] {
        let mut contender = start(technique.as_ref(), (method, ""), 5);
        let image = Built::new(&dark).play(contender.as_mut(), 2).image;
        assert!(image.pixels.iter().all(|p| *p == [0.0; 3]), "{method}");
        let mut built = Built::new(&room(diffuse(), 8.0));
        built.scene.materials[0].bsdf = broken.materials[0].bsdf.clone();
        let mut contender = start(technique.as_ref(), (method, ""), 5);
        let image = built.play(contender.as_mut(), 2).image;
        assert!(
            image.pixels.iter().flatten().all(|v| v.is_finite()),
            "{method}"
        );
    }
}

#[test]
fn settings_that_would_bias_the_unbiased_form_are_refused() {
    let technique = direct();
    for text in [
        "weights = 'count'",
        "shadowed = false",
        "visibility_reuse = false",
        "boiling = 0.2",
    ] {
        let table: toml::Table = text.parse().expect("toml");
        let started = technique.start("restir-unbiased", &table, Terms::default());
        let error = started.err().expect(text);
        assert!(error.message.contains("biased"), "{error}");
        let biased = technique.start("restir", &table, Terms::default());
        assert!(biased.is_ok(), "{text}");
    }
}

#[test]
fn what_a_selection_does_not_ask_for_is_refused() {
    let technique = direct();
    for (method, text, key) in [
        ("rt", "candidates = 4", "candidates"),
        ("rt", "candidates = 4\nselection = 'power'", "candidates"),
        (
            "light-cones",
            "hidden = 'as-seen'\nselection = 'power'",
            "hidden",
        ),
    ] {
        let table: toml::Table = text.parse().expect("toml");
        let started = technique.start(method, &table, Terms::default());
        let error = started.err().expect(text);
        assert!(error.message.starts_with(key), "{error}");
        let product = format!("{key} = {}\nselection = 'product'", table[key]);
        let table = product.parse().expect("toml");
        assert!(technique.start(method, &table, Terms::default()).is_ok());
    }
}

#[test]
fn passes_take_the_place_of_the_budget_in_direct_lighting_only() {
    let technique = direct();
    let built = Built::new(&room(diffuse(), 20.0));
    let image = |budget: usize, text: &str| {
        let terms = Terms { budget, seed: 1 };
        let table = text.parse().expect("toml");
        let started = technique.start("rtxdi", &table, terms).expect("starts");
        let mut contender = started.contender;
        built.play(contender.as_mut(), 3).image
    };
    let (one, eight) = (image(1, ""), image(8, ""));
    assert_eq!(image(8, "passes = 1").pixels, one.pixels);
    assert_ne!(eight.pixels, one.pixels);
    let entry = lightbench::registry::technique("environment-lighting").expect("listed");
    let environment = (entry.build)(&toml::Table::new()).expect("defaults");
    let terms = Terms { budget: 8, seed: 1 };
    let table = "passes = 1".parse().expect("toml");
    let refused = environment.start("restir", &table, terms).err();
    let message = refused.expect("refused").to_string();
    assert!(message.contains("`spp`"), "{message}");
}
