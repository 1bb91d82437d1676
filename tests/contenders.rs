//! What every contender of every technique must do, read from the registry: a new one is tested the day it is listed.

use glam::{DAffine3, DMat4, DVec3};
use lightbench::entry::Bias;
use lightbench::environment::{Environment, EnvironmentOptions};
use lightbench::image::Image;
use lightbench::registry::TECHNIQUES;
use lightbench::scene::{Material, Scene, SceneDescription, ShapeDescription, ShapeSource, View};
use lightbench::technique::{
    Choice, Contender, Film, Listed as AsListed, Passes, Playing, Rendered, Shot, Technique,
    TechniqueEntry, Terms, reference_pass,
};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::{self, Moment, Motion};

/// A technique, one of its contenders, and parameters that make both cheap.
struct Listed {
    entry: &'static TechniqueEntry,
    technique: Box<dyn Technique>,
    id: String,
    biases: Vec<Bias>,
    parameters: toml::Table,
}

/// Parameters of a technique that make its references and records cheap.
fn cheap(id: &str) -> toml::Table {
    let text = match id {
        "ambient-occlusion" => "side = 8",
        "irradiance-caching" => "side = 8\nreference_passes = 64",
        "importance-caching" => "lights = 64",
        "environment-lighting" => "reference_samples = 256\nreference_passes = 4",
        "path-tracing" | "direct-lighting" | "radiance" => "reference_passes = 64",
        other => panic!("no cheap parameters for {other}: add them"),
    };
    text.parse().expect("toml")
}

/// A contender with parameters that make it cheap, once for each way that it has to work.
fn variants(listed: &AsListed) -> Vec<(&AsListed, toml::Table)> {
    let texts: &[&str] = match listed.id.as_str() {
        id if id.starts_with("SD") => &["min_cluster_size = 1"],
        "per-sample" => &["passes = 2"],
        "rt" => &["", "selection = 'product'"],
        _ => &[""],
    };
    let parsed = |text: &&str| (listed, text.parse().expect("toml"));
    texts.iter().map(parsed).collect()
}

fn all() -> Vec<Listed> {
    let mut all = Vec::new();
    for entry in TECHNIQUES {
        for (listed, parameters) in (entry.contenders)().iter().flat_map(variants) {
            let technique = (entry.build)(&cheap(entry.about.id)).expect("parameters");
            let started = technique.start(&listed.id, &parameters, Terms::default());
            match started.map(|started| started.id) {
                Ok(id) => assert_eq!(id, listed.id, "canonical"),
                Err(error) => {
                    // Gradients are no use to importance caching, and it says so.
                    assert_eq!(error.key, "interpolation", "{error}");
                    continue;
                }
            }
            all.push(Listed {
                entry,
                technique,
                id: listed.id.clone(),
                biases: listed.parts.iter().map(|part| part.bias).collect(),
                parameters,
            });
        }
    }
    all
}

impl Listed {
    fn name(&self) -> String {
        format!("{} {} {}", self.entry.about.id, self.id, self.parameters)
    }

    fn choice(&self, budget: usize, seed: u64) -> Choice<'_> {
        Choice {
            method: &self.id,
            parameters: &self.parameters,
            terms: Terms { budget, seed },
        }
    }

    /// A budget that every technique can afford.
    fn budget(&self) -> usize {
        match self.entry.units[0].key {
            "caches" => 24,
            "lights" => 4,
            "samples" => 2,
            other => panic!("no affordable number of {other}: add it"),
        }
    }

    fn remembers(&self) -> bool {
        self.started(Terms::default()).remembers()
    }

    fn started(&self, terms: Terms) -> Box<dyn Contender + '_> {
        self.playing(terms).contender
    }

    fn playing(&self, terms: Terms) -> Playing<'_> {
        let choice = self.choice(terms.budget, terms.seed);
        choice
            .play_from_start(self.technique.as_ref())
            .expect("starts")
    }

    /// What a viewer sees of a moment, whose exposure is that of a sequence which begins there.
    fn shot<'a>(&self, moment: Moment<'a>, viewer: u16, spp: u32) -> Shot<'a> {
        let view = &moment.scene.views[usize::from(viewer)];
        let film = Film {
            width: 16,
            height: 10,
            spp,
        };
        let technique = self.technique.as_ref();
        let mut shot = Shot::exposed_for(technique, moment, view, film);
        shot.viewer = viewer;
        shot.layer = technique.shared_layer(&shot);
        shot
    }

    /// What both viewers see of a moment.
    fn both<'a>(&self, moment: Moment<'a>, frame: u32) -> Vec<Shot<'a>> {
        let mut shots: Vec<Shot> = (0..2).map(|viewer| self.shot(moment, viewer, 1)).collect();
        shots.iter_mut().for_each(|shot| shot.frame = frame);
        shots
    }
}

/// Two views of a room with a lamp, open to the sky.
fn room(light: f32) -> SceneDescription {
    let shape = |name: &str, source, to_world| ShapeDescription {
        to_world,
        ..ShapeDescription::new(name, source)
    };
    let floor =
        DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2) * DMat4::from_scale(DVec3::splat(2.0));
    let block = DMat4::from_translation(DVec3::new(0.3, 0.4, -0.2))
        * DMat4::from_rotation_y(0.4)
        * DMat4::from_scale(DVec3::splat(0.4));
    let mut lamp = shape(
        "lamp",
        ShapeSource::Rectangle,
        DMat4::from_translation(DVec3::new(0.0, 2.5, 0.0))
            * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
            * DMat4::from_scale(DVec3::splat(0.5)),
    );
    lamp.emission = Some([light; 3]);
    let eye = |x: f64| [DVec3::new(x, 1.6, 3.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y];
    SceneDescription {
        name: "room".into(),
        max_depth: 6,
        views: vec![
            View::look_at("left", eye(-1.0), 50.0, [16, 10]),
            View::look_at("right", eye(1.2), 50.0, [16, 10]),
        ],
        materials: vec![Material::diffuse("grey", [0.6, 0.5, 0.4])],
        shapes: vec![
            shape("floor", ShapeSource::Rectangle, floor),
            shape("block", ShapeSource::Cube, block),
            lamp,
        ],
        ..SceneDescription::default()
    }
}

/// Nothing but what is seen: no surface in front of the camera.
fn nothing_seen() -> SceneDescription {
    let mut description = room(0.0);
    for view in &mut description.views {
        view.forward = -view.forward;
        view.right = -view.right;
    }
    description
}

struct World {
    scene: Scene,
    tracer: Tracer,
}

/// The scene under a sky that is brighter in one place.
fn under_sky(description: &SceneDescription, technique: &dyn Technique, sky: f32) -> Scene {
    let mut scene = Scene::build(description, technique.needs()).expect("a scene");
    let mut map = Image::new(8, 4);
    map.pixels.fill([sky; 3]);
    map.pixels[10] = [4.0 * sky; 3];
    scene.environment = technique
        .needs()
        .environment
        .then(|| Environment::from_image(&map, &EnvironmentOptions::default()).expect("a map"));
    scene
}

impl World {
    fn new(description: &SceneDescription, technique: &dyn Technique, sky: f32) -> Self {
        let scene = under_sky(description, technique, sky);
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Self { scene, tracer }
    }

    /// The same without its shapes. No file gives such a scene: see the test that it is refused.
    fn emptied(mut self) -> Self {
        let scene = &mut self.scene;
        scene.positions.clear();
        scene.normals.clear();
        scene.uvs.clear();
        scene.triangles.clear();
        scene.triangle_shape.clear();
        scene.shapes.clear();
        self.tracer = Tracer::new(&scene.positions, &scene.triangles);
        self
    }

    fn shot(&self, listed: &Listed, viewer: u16, spp: u32) -> Shot<'_> {
        listed.shot(Moment::still(&self.scene, &self.tracer), viewer, spp)
    }
}

/// Everything of a result that must not depend on threads, viewers or frames.
fn fingerprint(rendered: &Rendered) -> String {
    let bits: Vec<[u32; 3]> = (rendered.image.pixels.iter())
        .map(|pixel| pixel.map(f32::to_bits))
        .collect();
    format!(
        "{bits:?} {:?} {} {:?}",
        rendered.rays, rendered.lookups, rendered.found
    )
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let pool = |threads| {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.build().expect("a pool")
    };
    let (one, four) = (pool(1), pool(4));
    for listed in all() {
        let world = World::new(&room(8.0), listed.technique.as_ref(), 0.5);
        let shot = world.shot(&listed, 0, 2);
        let choice = listed.choice(listed.budget(), 3);
        let render = || choice.still(listed.technique.as_ref(), &shot, None);
        let (a, b) = (one.install(render), four.install(render));
        let (a, b) = (a.expect("an image"), b.expect("an image"));
        assert_eq!(fingerprint(&a), fingerprint(&b), "{}", listed.name());
    }
}

#[test]
fn two_viewers_see_what_each_sees_alone_and_frames_repeat_without_memory() {
    for listed in all().iter().filter(|listed| !listed.remembers()) {
        let technique = listed.technique.as_ref();
        let world = World::new(&room(8.0), technique, 0.5);
        let shots: Vec<Shot> = (0..2).map(|v| world.shot(listed, v, 1)).collect();
        let choice = listed.choice(listed.budget(), 5);
        // A single run has one viewer, the first.
        let alone: Vec<String> = (0..2)
            .map(|view| {
                let mut shot = world.shot(listed, view, 1);
                shot.viewer = 0;
                fingerprint(&choice.still(technique, &shot, None).expect("an image"))
            })
            .collect();
        let mut contender = listed.started(choice.terms);
        for frame in 0..2 {
            let mut images = contender.frame(&shots).expect("images");
            for (viewer, rendered) in images.iter_mut().enumerate() {
                shots[viewer].add_layer(&mut rendered.image);
                let name = format!("{} frame {frame} viewer {viewer}", listed.name());
                assert_eq!(fingerprint(rendered), alone[viewer], "{name}");
            }
        }
    }
}

#[test]
fn scenes_without_light_and_views_of_nothing_are_exact() {
    for listed in all() {
        let technique = listed.technique.as_ref();
        for (description, sky, what) in [
            (room(0.0), 0.0, "black"),
            (nothing_seen(), 0.5, "nothing seen"),
            (room(0.0), 0.5, "no shapes"),
        ] {
            let mut world = World::new(&description, technique, sky);
            if what == "no shapes" {
                world = world.emptied();
            }
            let shot = world.shot(&listed, 0, 2);
            let choice = listed.choice(listed.budget(), 1);
            let rendered = choice.still(technique, &shot, None).expect("an image");
            let name = format!("{}, {what}", listed.name());
            assert_eq!(rendered.non_finite, 0, "{name}");
            let expected = match (listed.entry.about.id, what) {
                // Occlusion needs no light: surfaces have it, and open sky is 1.
                ("ambient-occlusion", "black") => continue,
                ("ambient-occlusion", _) => 1.0,
                (_, "black") => 0.0,
                _ => {
                    let function = technique.shading_function(&shot);
                    let counter = RayCounter::default();
                    let (image, _) = reference_pass(function.as_ref(), &shot, 0, &counter);
                    for (a, b) in rendered.image.pixels.iter().zip(&image.pixels) {
                        (0..3).for_each(|c| assert!((a[c] - b[c]).abs() <= 1e-4 * b[c], "{name}"));
                    }
                    continue;
                }
            };
            let exact = rendered.image.pixels.iter().flatten();
            assert!(exact.clone().all(|v| *v == expected), "{name}");
        }
    }
}

#[test]
fn scenes_without_shapes_are_refused() {
    for entry in TECHNIQUES {
        let technique = (entry.build)(&cheap(entry.about.id)).expect("parameters");
        let description = SceneDescription {
            shapes: vec![],
            ..room(8.0)
        };
        let error = Scene::build(&description, technique.needs()).expect_err("nothing is there");
        let told = error.to_string();
        assert!(told.contains("nothing to render"), "{told}");
    }
}

/// Mean over the image, and its standard error over repeats.
fn mean_and_error(images: &[Image]) -> (f64, f64) {
    let of = |image: &Image| {
        let values = image.pixels.iter().flatten().map(|v| f64::from(*v));
        values.sum::<f64>() / (3 * image.pixels.len()) as f64
    };
    let means: Vec<f64> = images.iter().map(of).collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn contenders_that_call_themselves_unbiased_are() {
    let mut tested = 0;
    for listed in all() {
        // Importance caching is unbiased whatever places its records; others are if all their parts are.
        let of_technique = listed.entry.about.id == "importance-caching";
        let unbiased = |bias: &Bias| matches!(bias, Bias::Unbiased | Bias::Exact);
        if !of_technique && !listed.biases.iter().all(unbiased) {
            continue;
        }
        tested += 1;
        let technique = listed.technique.as_ref();
        let world = World::new(&room(8.0), technique, 0.5);
        let shot = world.shot(&listed, 0, 1);
        let function = technique.shading_function(&shot);
        let passes = technique.reference_samples(shot.spp);
        let references: Vec<Image> = (0..8)
            .map(|part| {
                let random = technique.reference_is_random();
                let first = if random { part * passes } else { 0 };
                let mut mean = Passes::starting_at(first, &shot, function.as_ref());
                (0..passes).for_each(|_| mean.add(&RayCounter::default()));
                mean.mean()
            })
            .collect();
        let images: Vec<Image> = (0..24)
            .map(|seed| {
                let choice = listed.choice(listed.budget(), 100 + seed);
                choice
                    .still(technique, &shot, None)
                    .expect("an image")
                    .image
            })
            .collect();
        let (truth, truth_error) = mean_and_error(&references);
        let (mean, error) = mean_and_error(&images);
        let z = (mean - truth) / (error.hypot(truth_error) + 1e-6 * truth);
        assert!(truth > 0.0, "{}: nothing to test", listed.name());
        assert!(z.abs() < 4.5, "{}: {mean} {truth}, z = {z}", listed.name());
    }
    assert!(tested >= 8, "{tested} contenders");
}

/// A still camera over a still scene: the running mean of frames is the mean of all their paths.
#[test]
fn memory_over_a_still_scene_is_worth_more_paths() {
    let listed = all();
    let of = |id: &str| {
        let found = listed
            .iter()
            .find(|l| l.id == id && l.entry.about.id == "path-tracing");
        found.expect("listed")
    };
    let (paths, mean) = (of("paths"), of("running-mean"));
    assert!(mean.remembers() && !paths.remembers());
    let technique = mean.technique.as_ref();
    let world = World::new(&room(8.0), technique, 0.5);
    let start = technique.start("running-mean", &toml::Table::new(), mean.choice(2, 9).terms);
    let mut contender = start.expect("starts").contender;
    let mut last = Image::default();
    for frame in 0..4 {
        let mut shot = world.shot(mean, 0, 1);
        shot.frame = frame;
        let images = contender.frame(&[shot]).expect("images");
        if frame == 0 {
            let still = paths
                .choice(2, 9)
                .still(technique, &world.shot(paths, 0, 1), None);
            assert_eq!(
                images[0].image.pixels,
                still.expect("an image").image.pixels
            );
        }
        last.clone_from(&images[0].image);
    }
    let all = paths
        .choice(8, 9)
        .still(technique, &world.shot(paths, 0, 1), None);
    for (a, b) in last.pixels.iter().zip(&all.expect("an image").image.pixels) {
        (0..3).for_each(|c| assert!((a[c] - b[c]).abs() <= 1e-5 * (1.0 + b[c]), "{a:?} {b:?}"));
    }
}

/// The room, whose block and lamp move and turn.
fn moving_room(technique: &dyn Technique) -> world::World {
    let moves = |shape: usize, way: DVec3| Motion {
        shape,
        place: Box::new(move |time_s| {
            DAffine3::from_translation(way * time_s) * DAffine3::from_rotation_y(0.7 * time_s)
        }),
    };
    let motions = vec![
        moves(1, DVec3::new(-0.9, 0.5, 0.3)),
        moves(2, DVec3::new(0.4, -0.3, 0.0)),
    ];
    let scene = under_sky(&room(8.0), technique, 0.5);
    world::World::moving(scene, motions, &[0.0, 1.0]).expect("a world")
}

/// Broken off and gone on with before every frame, as a killed run does.
#[test]
fn over_a_moving_scene_a_sequence_goes_on_to_the_same_bits() {
    const FRAMES: u32 = 4;
    let time_s = |frame: u32| f64::from(frame) / f64::from(FRAMES);
    let mut tested = 0;
    for listed in all().iter().filter(|listed| listed.remembers()) {
        tested += 1;
        let terms = listed.choice(listed.budget(), 5).terms;
        let play = |playing: &mut Playing, world: &mut world::World, frame: u32| {
            let shots = listed.both(world.at(time_s(frame)), frame);
            let images = playing.frame(&shots).expect("images");
            let bits = |image: &Rendered| format!("{} {}", fingerprint(image), image.bytes_cache);
            images.iter().map(bits).collect::<Vec<String>>()
        };
        let mut world = moving_room(listed.technique.as_ref());
        let mut playing = listed.playing(terms);
        let whole: Vec<Vec<String>> = (0..FRAMES)
            .map(|frame| play(&mut playing, &mut world, frame))
            .collect();
        assert_ne!(whole[1], whole[2], "{}: nothing moves", listed.name());
        world.rewind();
        playing = listed.playing(terms);
        for frame in 0..FRAMES {
            if let Some(before) = frame.checked_sub(1) {
                let memory = playing.contender.memory().expect("memory");
                playing = listed.playing(terms);
                world.rewind();
                let first = listed.both(world.at(time_s(0)), 0);
                playing.contender.rebuild(&first).expect("the first frame");
                playing.recall(&memory).expect("its own");
                world.at(time_s(before));
            }
            let images = play(&mut playing, &mut world, frame);
            let name = format!("{} frame {frame}", listed.name());
            assert_eq!(images, whole[frame as usize], "{name}");
        }
    }
    assert!(tested >= 8, "{tested} contenders");
}
