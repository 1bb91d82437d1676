//! What every contender of every technique must do, read from the registry: a new one is tested the day it is listed.

#[path = "contenders/listed.rs"]
mod listed;

use lightbench::entry::Bias;
use lightbench::image::Image;
use lightbench::memory::released;
use lightbench::registry::TECHNIQUES;
use lightbench::scene::{Scene, SceneDescription};
use lightbench::technique::{Passes, Playing, Rendered, Shot, reference_pass};
use lightbench::trace::RayCounter;
use lightbench::world;

use listed::{World, all, cheap, fingerprint, moving_room, nothing_seen, room};

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
            images.iter().map(fingerprint).collect::<Vec<String>>()
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

/// What contenders say that they keep is what the allocator gets back when they end; without a memory they keep it for an
/// image, and nothing after it. Charts of light cones are not among it: the next job may take them over.
#[test]
fn the_heap_holds_what_contenders_say_that_they_keep() {
    const SPARE: usize = 4 << 10;
    for listed in all() {
        let name = listed.name();
        let mut world = moving_room(listed.technique.as_ref());
        let mut playing = listed.playing(listed.choice(listed.budget(), 5).terms);
        let mut said = 0;
        for frame in 0..3 {
            let shots = listed.both(world.at(0.25 * f64::from(frame)), frame);
            let images = playing.frame(&shots).expect("images");
            said = images.iter().map(|image| image.bytes_cache).sum();
            let makes_some = |image: &Rendered| !image.records.is_empty() || image.lights.is_some();
            let lights_of_records = listed.entry.about.id == "importance-caching";
            for image in images.iter().filter(|i| makes_some(i) || lights_of_records) {
                assert!(image.bytes_cache > 64, "{name} keeps something");
            }
        }
        if !listed.remembers() {
            said = 0;
        }
        let held = released(playing);
        assert!(
            held.abs_diff(said) <= said / 10 + SPARE,
            "{name} says {said} bytes and holds {held}"
        );
    }
}
