//! Light that rests, moves, goes out and is remembered.

use glam::{DAffine3, DMat4, DVec3};
use lightbench::image::{Image, luminance};
use lightbench::scene::{Needs, Scene, ShapeDescription, ShapeSource, View};
use lightbench::technique::Rendered;
use lightbench::world::{Motion, World};

use super::{
    Built, SIZE, at, cones, direct, found, is_sound, lamp_room, mean, point, rmse, room, shot_of,
    truth_of,
};

#[test]
fn resting_light_comes_nearer_to_the_truth_frame_by_frame() {
    let technique = direct();
    // Lights of unlike strength, so that choosing among them is noise at first.
    let mut description = lamp_room(0.3, 20.0);
    description.lights = [point([1.5, 1.5, 1.0], 1.0), point([-1.5, 1.0, 0.5], 0.3)]
        .into_iter()
        .map(Into::into)
        .collect();
    let built = Built::new(&description);
    let truth = built.truth(technique.as_ref());
    for text in [
        "filter = 'bilinear'",
        "filter = 'nearest'",
        "compressed = true",
    ] {
        // Small texels, so that shadows are not what is off.
        let text = format!("{text}\nbias = -1.0\nselection = 'power'");
        let mut contender = cones(technique.as_ref(), &text);
        let errors = [0..1, 1..8, 8..64].map(|frames| {
            let rendered = built.play(contender.as_mut(), frames);
            rmse(&rendered.image, &truth) / mean(&truth)
        });
        assert!(
            errors[1] < 0.8 * errors[0] && errors[2] < errors[1] && errors[2] < 0.08,
            "{text}: {errors:?}"
        );
    }
}

#[test]
fn a_sequence_goes_on_from_what_was_remembered() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    for text in ["", "compressed = true\nfirst_updates = 2"] {
        let mut straight = cones(technique.as_ref(), text);
        let expected = built.play(straight.as_mut(), 0..5);
        let mut first = cones(technique.as_ref(), text);
        built.play(first.as_mut(), 0..3);
        let memory = first.memory().expect("memory");
        let mut second = cones(technique.as_ref(), text);
        second.recall(&memory).expect("recalls");
        assert_eq!(second.memory().expect("memory"), memory);
        let resumed = built.play(second.as_mut(), 3..5);
        assert_eq!(resumed.image.pixels, expected.image.pixels);
        assert_eq!(resumed.rays, expected.rays);
        // What belongs to another scene is refused.
        let mut third = cones(technique.as_ref(), text);
        third.recall(&memory).expect("recalls");
        let other = Built::new(&room());
        assert!(third.frame(&[other.shot(3)]).is_err());
    }
}

/// Everything moves together, the camera too: nothing changes for anybody.
#[test]
fn what_moves_carries_its_texels_along() {
    let technique = direct();
    let description = lamp_room(0.3, 20.0);
    let place = |time_s: f64| {
        DAffine3::from_rotation_y(0.7 * time_s)
            * DAffine3::from_translation(DVec3::new(time_s, 0.0, 0.0))
    };
    let play = |times_s: [f64; 3]| {
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let moves = (0..3).map(|shape| Motion {
            shape,
            place: Box::new(place),
        });
        let mut world = World::moving(scene, moves.collect(), &[0.0, 1.0, 2.0]).expect("a world");
        let origin = world.origin();
        let mut contender = cones(technique.as_ref(), "motion = 'cones'");
        let mut last = Rendered::default();
        for (frame, time_s) in (0..).zip(times_s) {
            let mut view = description.views[0].clone();
            let carried = place(time_s);
            view.origin = carried.transform_point3(view.origin) - origin;
            for direction in [&mut view.right, &mut view.up, &mut view.forward] {
                *direction = carried.transform_vector3(*direction);
            }
            let shot = shot_of(world.at(time_s), &view, frame, 16);
            let mut images = contender.frame(&[shot]).expect("a frame");
            last = images.pop().expect("one image");
        }
        last
    };
    let (moved, still) = (play([0.0, 1.0, 2.0]), play([0.0; 3]));
    assert!(found(&still, "new_blocks") < 0.1 * found(&still, "blocks"));
    assert!(found(&moved, "new_blocks") < 0.1 * found(&moved, "blocks"));
    let off = rmse(&moved.image, &still.image) / mean(&still.image);
    assert!(off < 0.02, "{off}");
}

/// The floor grows within a frame to its size, from a part of it; what the second frame shows.
fn grown(scale_at_first: f64) -> Rendered {
    let technique = direct();
    let description = lamp_room(0.3, 20.0);
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    let place =
        move |time_s: f64| DAffine3::from_scale(DVec3::splat(scale_at_first.powf(1.0 - time_s)));
    let moves = vec![Motion {
        shape: 0,
        place: Box::new(place),
    }];
    let mut world = World::moving(scene, moves, &[0.0, 1.0]).expect("a world");
    let mut view = description.views[0].clone();
    view.origin -= world.origin();
    let mut contender = cones(technique.as_ref(), "");
    let mut last = Rendered::default();
    for (frame, time_s) in [(0, 0.0), (1, 1.0)] {
        let shot = shot_of(world.at(time_s), &view, frame, 16);
        last = contender.frame(&[shot]).expect("a frame").remove(0);
    }
    last
}

/// Charts have the lengths of the first frame.
#[test]
fn texels_of_a_shape_that_grows_or_shrinks_keep_to_the_size_of_pixels() {
    let expected = found(&grown(1.0), "texels");
    for scale in [0.02, 50.0] {
        let texels = found(&grown(scale), "texels");
        assert!(
            (texels / expected - 1.0).abs() < 0.5,
            "{scale}: {texels} and {expected}"
        );
    }
}

/// A shape that begins as a point has charts without area.
#[test]
fn a_shape_that_grows_from_nothing_is_lit() {
    let (from_nothing, expected) = (grown(0.0), grown(1.0));
    assert!(is_sound(&from_nothing));
    assert!(found(&from_nothing, "uncached") > 0.3);
    let off = mean(&from_nothing.image) / mean(&expected.image) - 1.0;
    assert!(off.abs() < 0.1, "{off}");
}

#[test]
fn light_that_goes_out_is_soon_gone_and_comes_back() {
    let technique = direct();
    let on = Built::new(&lamp_room(0.3, 20.0));
    let mut off = Built::new(&lamp_room(0.3, 20.0));
    off.scene.shapes[2].emission = Some([0.0; 3]);
    let mut contender = cones(technique.as_ref(), "");
    let bright = mean(&on.play(contender.as_mut(), 0..40).image);
    let dark = mean(&off.play(contender.as_mut(), 40..68).image);
    assert!(dark < 0.08 * bright, "{dark} of {bright}");
    let again = mean(&on.play(contender.as_mut(), 68..84).image);
    assert!((again / bright - 1.0).abs() < 0.1, "{again} of {bright}");
}

#[test]
fn light_that_changes_unseen_is_not_stale_when_it_is_seen_again() {
    let technique = direct();
    let with_lamp = |x: f64, emission: f32| {
        let mut description = lamp_room(0.3, emission);
        let lamp = &mut description.shapes[2];
        lamp.to_world = DMat4::from_translation(DVec3::new(x, 0.0, 0.0)) * lamp.to_world;
        // Another lamp is what is left, and a second viewer looks away.
        description.lights = vec![point([1.2, 1.0, 0.8], 0.3).into()];
        let mut away = description.views[0].clone();
        (away.forward, away.right) = (-away.forward, -away.right);
        description.views[1] = away;
        Built::new(&description)
    };
    let before = with_lamp(0.0, 20.0);
    for (what, after) in [
        ("dimmed", with_lamp(0.0, 0.2)),
        ("moved", with_lamp(-1.2, 20.0)),
    ] {
        let mut fresh = cones(technique.as_ref(), "");
        let expected = after.play(fresh.as_mut(), 54..86).image;
        let off = |text: &str| {
            let mut contender = cones(technique.as_ref(), text);
            before.play(contender.as_mut(), 0..40);
            for frame in 40..54 {
                contender.frame(&[after.seen(1, frame)]).expect("a frame");
            }
            let image = after.play(contender.as_mut(), 54..68).image;
            rmse(&image, &expected) / mean(&expected)
        };
        let (seen_again, of_cones) = (off(""), off("motion = 'cones'"));
        assert!(seen_again < 0.2, "{what}: {seen_again}");
        assert!(
            seen_again < 0.5 * of_cones,
            "{what}: {seen_again}, {of_cones} by cones alone"
        );
    }
}

/// No cone turns where a shadow falls or a lamp is dimmed.
#[test]
fn sudden_changes_show_within_some_frames() {
    let technique = direct();
    let with_board = |place: DVec3, emission: f32| {
        let mut description = lamp_room(0.3, emission);
        description.shapes.push(at(
            ShapeDescription::new("board", ShapeSource::Cube),
            DMat4::from_translation(place) * DMat4::from_scale(DVec3::new(0.5, 0.02, 0.5)),
        ));
        Built::new(&description)
    };
    // Above the lamp, which shines downwards, it is in nobody's way.
    let (aside, below) = (DVec3::new(0.3, 3.2, 0.2), DVec3::new(0.3, 1.5, 0.2));
    let beside = DVec3::new(-0.8, 1.2, 0.0);
    for (what, before, after) in [
        ("dimmed", (aside, 20.0), (aside, 0.4)),
        ("bright again", (aside, 0.4), (aside, 20.0)),
        ("behind a board", (aside, 20.0), (below, 20.0)),
        ("out of its shadow", (below, 20.0), (aside, 20.0)),
        ("a board jumps", (below, 20.0), (beside, 20.0)),
    ] {
        let [before, after] = [before, after].map(|(place, light)| with_board(place, light));
        let mut fresh = cones(technique.as_ref(), "");
        let expected = after.play(fresh.as_mut(), 40..72).image;
        let off = |text: &str| {
            let mut contender = cones(technique.as_ref(), text);
            before.play(contender.as_mut(), 0..40);
            let image = after.play(contender.as_mut(), 40..56).image;
            rmse(&image, &expected) / mean(&expected)
        };
        let noticed = off("");
        let by_turns = off("rules = { surprise = 1000 }");
        assert!(noticed < 0.2, "{what}: {noticed}");
        // Where a lamp shines as it did, dark edges of cones tell of its shadow too.
        let shines = |built: &Built| built.scene.shapes[2].emission;
        if shines(&before) != shines(&after) {
            assert!(
                noticed < 0.5 * by_turns,
                "{what}: {noticed}, by turns {by_turns}"
            );
        }
    }
}

/// Fig. 6: a pillar stands between the floor and the way of a lamp.
#[test]
fn a_lamp_that_passes_behind_a_pillar_leaves_no_light_in_its_shadow() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    let [pillar, lamp] = [1, 2].map(|shape| {
        let place = |at: DVec3, half: DVec3| DMat4::from_translation(at) * DMat4::from_scale(half);
        match shape {
            1 => place(DVec3::new(0.0, 1.0, -0.7), DVec3::new(0.12, 1.0, 0.12)),
            _ => place(DVec3::new(-1.2, 0.9, -1.3), DVec3::new(0.25, 0.15, 0.15)),
        }
    });
    description.shapes[1].to_world = pillar;
    description.shapes[2].to_world = lamp;
    description.shapes[2].source = ShapeSource::Cube;
    let above = [
        DVec3::new(0.0, 2.6, 1.6),
        DVec3::new(0.0, 0.0, 0.7),
        DVec3::Y,
    ];
    let mut view = View::look_at("above", above, 40.0, SIZE);
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    // At 3.6 metres a second, seen 30 times a second.
    let place = |time_s: f64| DAffine3::from_translation(DVec3::new(3.6 * time_s, 0.0, 0.0));
    let moves = vec![Motion {
        shape: 2,
        place: Box::new(place),
    }];
    let times_s: Vec<f64> = (0..20).map(|frame| f64::from(frame) / 30.0).collect();
    let mut world = World::moving(scene, moves, &times_s).expect("a world");
    view.origin -= world.origin();
    let mut contender = cones(technique.as_ref(), "");
    let mut earlier: Vec<Image> = Vec::new();
    let (mut lit, mut left) = (0.0, 0.0);
    for (frame, time_s) in (0..).zip(times_s) {
        let shot = shot_of(world.at(time_s), &view, frame, 16);
        let truth = truth_of(technique.as_ref(), &shot, 800);
        let image = contender.frame(&[shot]).expect("a frame").remove(0).image;
        let off = rmse(&image, &truth) / mean(&truth);
        assert!(off < 0.3, "frame {frame}: {off}");
        if let Some(before) = earlier.len().checked_sub(3).map(|i| &earlier[i]) {
            for pixel in 0..truth.pixels.len() {
                let [was, is, seen] =
                    [before, &truth, &image].map(|of| luminance(of.pixels[pixel]));
                if is < 0.1 * was {
                    (lit, left) = (lit + was, left + seen);
                }
            }
        }
        earlier.push(truth);
    }
    // What was lit three frames ago and is in the shadow now.
    assert!(lit > 1.0 && left < 0.5 * lit, "{left} of {lit}");
}

/// A viewer who comes nearer asks for finer texels.
#[test]
fn finer_texels_begin_with_what_coarser_ones_know_while_nothing_changes() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    // Many lamps, so that eight samples are noise.
    let lamp = |i: u32| {
        let angle = 0.7 * f64::from(i);
        let height = 0.6 + 0.1 * f64::from(i);
        point([1.5 * angle.cos(), height, 1.5 * angle.sin()], 1.0)
    };
    description.lights = (0..12).map(|i| lamp(i).into()).collect();
    let eye = [
        DVec3::new(-1.0, 1.6, 3.0),
        DVec3::new(0.0, 0.2, 0.0),
        DVec3::Y,
    ];
    description.views[1] = View::look_at("near", eye, 25.0, SIZE);
    let before = Built::new(&description);
    description.shapes[2].emission = Some([19.0, 17.0, 13.0]);
    let after = Built::new(&description);
    let truth = truth_of(technique.as_ref(), &before.seen(1, 0), 4000);
    let first_look = |text: &str, now: &Built| {
        let text = format!("selection = 'uniform'\n{text}");
        let mut contender = cones(technique.as_ref(), &text);
        before.play(contender.as_mut(), 0..24);
        let shots = [now.seen(1, 24)];
        let rendered = contender.frame(&shots).expect("a frame").remove(0);
        let off = rmse(&rendered.image, &truth) / mean(&truth);
        (found(&rendered, "reused_texels"), off)
    };
    let (with, without) = (
        first_look("", &before),
        first_look("reuse = 'never'", &before),
    );
    assert!(with.0 > 0.0 && without.0 == 0.0);
    assert!(with.1 < 0.8 * without.1, "{with:?} {without:?}");
    let changed = ["", "reuse = 'always'"].map(|text| first_look(text, &after).0);
    assert!(changed[0] == 0.0 && changed[1] > 0.0, "{changed:?}");
}
