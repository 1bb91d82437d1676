//! The cones of the technique `direct-lighting`: convergence where the light rests, what changes, what is shared, and scenes
//! that break caches on surfaces.

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DMat4, DVec3, Vec3};
use lightbench::environment::Environment;
use lightbench::image::{Image, luminance};
use lightbench::registry::technique;
use lightbench::scene::{
    LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
};
use lightbench::technique::{Contender, Film, Rendered, Shot, Technique, Terms, reference_pass};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::{Moment, Motion, World};

const SIZE: [usize; 2] = [16, 12];
/// Light samples of a texel.
const SAMPLES: usize = 8;

fn direct() -> Box<dyn Technique> {
    let entry = technique("direct-lighting").expect("listed");
    (entry.build)(&toml::Table::new()).expect("defaults")
}

fn seeded<'a>(technique: &'a dyn Technique, text: &str, seed: u64) -> Box<dyn Contender + 'a> {
    let terms = Terms {
        budget: SAMPLES,
        seed,
    };
    let parameters = text.parse().expect("toml");
    let started = technique.start("light-cones", &parameters, terms);
    started.expect("starts").contender
}

fn cones<'a>(technique: &'a dyn Technique, text: &str) -> Box<dyn Contender + 'a> {
    seeded(technique, text, 1)
}

fn shot_of<'a>(moment: Moment<'a>, view: &'a View, frame: u32, spp: u32) -> Shot<'a> {
    let film = Film {
        width: SIZE[0],
        height: SIZE[1],
        spp,
    };
    let mut shot = Shot::new(moment, view, film);
    shot.frame = frame;
    shot
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

    /// A viewer's shot with many camera samples, so that edges in pixels are no error.
    fn seen(&self, view: usize, frame: u32) -> Shot<'_> {
        let moment = Moment::still(&self.scene, &self.tracer);
        let mut shot = shot_of(moment, &self.scene.views[view], frame, 16);
        shot.viewer = view as u16;
        shot
    }

    fn shot(&self, frame: u32) -> Shot<'_> {
        self.seen(0, frame)
    }

    /// The last of some frames by a contender.
    fn play(&self, contender: &mut dyn Contender, frames: std::ops::Range<u32>) -> Rendered {
        let mut last = Rendered::default();
        for frame in frames {
            let mut images = contender.frame(&[self.shot(frame)]).expect("a frame");
            last = images.pop().expect("one image");
        }
        last
    }

    /// The mean of paths.
    fn truth(&self, technique: &dyn Technique) -> Image {
        const PASSES: u32 = 4000;
        let shot = self.shot(0);
        let function = technique.shading_function(&shot);
        let counter = RayCounter::default();
        let mut mean = Image::new(SIZE[0], SIZE[1]);
        for pass in 0..PASSES {
            let (image, _) = reference_pass(function.as_ref(), &shot, pass, &counter);
            for (sum, value) in mean.pixels.iter_mut().zip(&image.pixels) {
                (0..3).for_each(|c| sum[c] += value[c] / PASSES as f32);
            }
        }
        mean
    }
}

fn mean(image: &Image) -> f32 {
    image.pixels.iter().map(|p| luminance(*p)).sum::<f32>() / image.pixels.len() as f32
}

fn rmse(a: &Image, b: &Image) -> f32 {
    let squares = a.pixels.iter().zip(&b.pixels).map(|(a, b)| {
        let difference = luminance(*a) - luminance(*b);
        difference * difference
    });
    (squares.sum::<f32>() / a.pixels.len() as f32).sqrt()
}

fn found(rendered: &Rendered, key: &str) -> f64 {
    let found = rendered.found.iter().find(|(k, _)| *k == key);
    found.unwrap_or_else(|| panic!("no {key}")).1
}

fn is_sound(rendered: &Rendered) -> bool {
    let mut values = rendered.image.pixels.iter().flatten();
    values.all(|value| value.is_finite() && *value >= 0.0)
}

fn at(shape: ShapeDescription, to_world: DMat4) -> ShapeDescription {
    ShapeDescription { to_world, ..shape }
}

/// A floor with a block on it, seen by two viewers.
fn room() -> SceneDescription {
    let floor = DMat4::from_rotation_x(-FRAC_PI_2) * DMat4::from_scale(DVec3::splat(2.0));
    let block = DMat4::from_translation(DVec3::new(0.3, 0.4, -0.2))
        * DMat4::from_rotation_y(0.4)
        * DMat4::from_scale(DVec3::splat(0.4));
    let eye = |x: f64| [DVec3::new(x, 1.6, 3.0), DVec3::new(0.0, 0.2, 0.0), DVec3::Y];
    SceneDescription {
        name: "room".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        views: vec![
            View::look_at("left", eye(-1.0), 50.0, SIZE),
            View::look_at("right", eye(0.6), 50.0, SIZE),
        ],
        materials: vec![Material::diffuse("grey", [0.6, 0.5, 0.4])],
        shapes: vec![
            at(
                ShapeDescription::new("floor", ShapeSource::Rectangle),
                floor,
            ),
            at(ShapeDescription::new("block", ShapeSource::Cube), block),
        ],
        ..SceneDescription::default()
    }
}

/// The room under a square lamp.
fn lamp_room(half_side: f64, emission: f32) -> SceneDescription {
    let mut room = room();
    let mut lamp = at(
        ShapeDescription::new("lamp", ShapeSource::Rectangle),
        DMat4::from_translation(DVec3::new(0.0, 2.5, 0.0))
            * DMat4::from_rotation_x(FRAC_PI_2)
            * DMat4::from_scale(DVec3::splat(half_side)),
    );
    lamp.emission = Some([emission, 0.8 * emission, 0.6 * emission]);
    room.shapes.push(lamp);
    room
}

fn lit_by(lights: impl IntoIterator<Item = LightKind>) -> SceneDescription {
    let mut room = room();
    room.lights = lights.into_iter().map(Into::into).collect();
    room
}

fn point(position: [f64; 3], intensity: f32) -> LightKind {
    LightKind::Point {
        position: position.into(),
        intensity: [intensity; 3],
    }
}

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

/// Of lights that are small cones the cosine is that of the samples: nothing but noise is left.
#[test]
fn the_light_of_diffuse_surfaces_has_the_right_mean() {
    let technique = direct();
    let lights = [
        point([0.5, 2.0, 0.5], 6.0),
        point([-1.0, 1.5, 1.0], 2.0),
        LightKind::Spot {
            position: DVec3::new(0.0, 3.0, 0.0),
            direction: DVec3::NEG_Y,
            intensity: [8.0, 2.0, 0.0],
            beam_width_deg: 10.0,
            cutoff_deg: 25.0,
        },
        LightKind::Directional {
            direction: DVec3::new(0.6, -0.8, 0.0),
            irradiance: [0.5; 3],
        },
    ];
    for (what, description) in [
        ("lights without extent", lit_by(lights)),
        ("a small lamp", lamp_room(0.05, 400.0)),
    ] {
        let built = Built::new(&description);
        let truth = f64::from(mean(&built.truth(technique.as_ref())));
        // Texels of half a pixel, so that what they lose of edges is little.
        let means: Vec<f64> = (0..16)
            .map(|seed| {
                let mut contender = seeded(technique.as_ref(), "bias = -1.0", seed);
                f64::from(mean(&built.play(contender.as_mut(), 0..3).image))
            })
            .collect();
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let error = (variance / count).sqrt();
        assert!(
            (mean - truth).abs() < 4.0 * error + 0.004 * truth,
            "{what}: {mean} ± {error} for {truth}"
        );
    }
}

#[test]
fn images_are_the_same_for_any_number_of_threads() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let render = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let mut contender = cones(technique.as_ref(), "");
            let rendered = built.play(contender.as_mut(), 0..4);
            (rendered.image.pixels, rendered.found, rendered.rays)
        })
    };
    assert_eq!(render(1), render(4));
}

#[test]
fn viewers_see_the_same_in_any_order_and_share_what_they_both_see() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let play = |order: [usize; 2]| {
        let mut contender = cones(technique.as_ref(), "");
        let mut images = Vec::new();
        for frame in 0..4 {
            let shots = order.map(|viewer| built.seen(viewer, frame));
            images = contender.frame(&shots).expect("a frame");
        }
        images
    };
    let (in_order, reversed) = (play([0, 1]), play([1, 0]));
    for (a, b) in in_order.iter().zip(reversed.iter().rev()) {
        assert_eq!(a.image.pixels, b.image.pixels);
        assert_eq!(a.found, b.found);
    }
    // What one sees twice is updated once; what two see in part, in part.
    let twice = play([0, 0]);
    let once = built.play(cones(technique.as_ref(), "").as_mut(), 0..4);
    let of = |rendered: &Rendered| found(rendered, "light_samples");
    assert_eq!(of(&twice[0]), of(&once));
    assert_eq!(twice[0].image.pixels, twice[1].image.pixels);
    assert_eq!(twice[0].image.pixels, once.image.pixels);
    let both = of(&in_order[0]);
    assert!(both > of(&once) && both < 1.9 * of(&once), "{both}");
    // The cache is held once.
    assert_eq!(
        (twice[0].bytes_cache, twice[1].bytes_cache),
        (once.bytes_cache, 0)
    );
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

/// Centres of large texels around the foot of the block lie beneath it, where it is dark.
#[test]
fn texels_beneath_a_block_do_not_darken_the_floor_around_it() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let truth = mean(&built.truth(technique.as_ref()));
    let [moved, kept] = ["moved", "kept"].map(|cut_off| {
        let text = format!("cut_off = '{cut_off}'\nbias = 2.0");
        let mut contender = cones(technique.as_ref(), &text);
        let first = built.play(contender.as_mut(), 0..1);
        let last = built.play(contender.as_mut(), 1..32);
        (found(&first, "moved_texels"), mean(&last.image) / truth)
    });
    assert!(moved.0 > 0.0 && kept.0 == 0.0);
    assert!(moved.1 > kept.1 && moved.1 < 1.0, "{moved:?} {kept:?}");
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
    assert!(found(&still, "new_blocks") < 0.05 * found(&still, "blocks"));
    assert!(found(&moved, "new_blocks") < 0.05 * found(&moved, "blocks"));
    let off = rmse(&moved.image, &still.image) / mean(&still.image);
    assert!(off < 0.02, "{off}");
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

/// A sheet between a lamp above and darkness below is lit on one side.
#[test]
fn the_sides_of_a_thin_sheet_are_kept_apart() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    let eye = [DVec3::new(0.1, -2.0, 0.2), DVec3::ZERO, DVec3::X];
    description.views[1] = View::look_at("below", eye, 40.0, SIZE);
    let built = Built::new(&description);
    let mut contender = cones(technique.as_ref(), "");
    let images = contender
        .frame(&[built.seen(0, 0), built.seen(1, 0)])
        .expect("a frame");
    assert!(mean(&images[0].image) > 0.05);
    assert_eq!(mean(&images[1].image), 0.0);
}

#[test]
fn a_pool_without_room_shows_light_samples_instead_and_says_so() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let truth = built.truth(technique.as_ref());
    for blocks in [0, 3] {
        let text = format!("most_blocks = {blocks}");
        let rendered = built.play(cones(technique.as_ref(), &text).as_mut(), 0..2);
        assert!(found(&rendered, "refused_blocks") > 0.0);
        assert!(found(&rendered, "blocks") <= f64::from(blocks));
        let uncached = found(&rendered, "uncached");
        assert!(
            uncached > 0.1 && (blocks > 0 || uncached > 0.5),
            "{uncached}"
        );
        assert!(rendered.notes[0].contains("most_blocks"));
        let off = mean(&rendered.image) / mean(&truth) - 1.0;
        assert!(off.abs() < 0.05, "{blocks} blocks: {off}");
    }
}

#[test]
fn scale_and_place_change_next_to_nothing() {
    let technique = direct();
    let image = |scale: f64, offset: f64| {
        let description = lamp_room(0.3, 20.0).transformed(scale, 0.0, DVec3::splat(offset));
        let built = Built::new(&description);
        let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..12);
        assert!(is_sound(&rendered));
        rendered.image
    };
    let plain = image(1.0, 0.0);
    for (scale, offset) in [(1e-3, 0.0), (1e5, 0.0), (1.0, 1e4)] {
        let off = rmse(&image(scale, offset), &plain) / mean(&plain);
        assert!(off < 0.05, "{scale} {offset}: {off}");
    }
}

#[test]
fn hard_lights_leave_sound_images() {
    let technique = direct();
    let thousand = (0..1000).map(|i| {
        let angle = f64::from(i) * 0.7;
        point(
            [
                2.0 * angle.cos(),
                1.0 + 1e-3 * f64::from(i),
                2.0 * angle.sin(),
            ],
            0.01,
        )
    });
    let mut touching = lamp_room(0.3, 20.0);
    let mut glow = at(
        ShapeDescription::new("glow", ShapeSource::Cube),
        DMat4::from_translation(DVec3::new(-0.7, 0.2, 0.5)) * DMat4::from_scale(DVec3::splat(0.2)),
    );
    glow.emission = Some([3.0; 3]);
    touching.shapes.push(glow);
    let cases = [
        ("no light", room(), 0.0),
        (
            "behind the surface",
            lit_by([point([0.0, -1.0, 0.0], 5.0)]),
            0.0,
        ),
        ("in the surface", lit_by([point([0.0, 0.0, 0.5], 5.0)]), 0.0),
        ("a thousand", lit_by(thousand), 1.0),
        ("an emitter that touches", touching, 1.0),
    ];
    for (what, description, light) in cases {
        let built = Built::new(&description);
        let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..10);
        assert!(is_sound(&rendered), "{what}");
        assert_eq!(rendered.non_finite, 0, "{what}");
        if light == 0.0 {
            // A light in the floor shines on the block's sides.
            let dark = what == "in the surface" || mean(&rendered.image) == 0.0;
            assert!(dark, "{what}: {}", mean(&rendered.image));
        } else {
            let truth = mean(&built.truth(technique.as_ref()));
            let off = mean(&rendered.image) / truth - 1.0;
            assert!(off.abs() < 0.12, "{what}: {off}");
        }
    }
}

#[test]
fn a_sky_all_around_has_the_right_brightness_and_less_where_light_below_the_horizon_is_lost() {
    let technique = direct();
    let mut built = Built::new(&room());
    built.scene.environment = Some(Environment::constant([0.5, 0.6, 0.7]));
    let truth = mean(&built.truth(technique.as_ref()));
    let offs = ["lost", "renormalised"].map(|horizon| {
        let text = format!("horizon = '{horizon}'");
        let rendered = built.play(cones(technique.as_ref(), &text).as_mut(), 0..12);
        assert!(is_sound(&rendered));
        mean(&rendered.image) / truth - 1.0
    });
    // Cones as wide as the hemisphere lean over its rim, and the light of samples, most of which are high up, is spread all
    // over them.
    assert!(offs[0] < offs[1], "{offs:?}");
    assert!(offs.iter().all(|off| off.abs() < 0.08), "{offs:?}");
}

#[test]
fn light_that_is_not_a_number_is_left_out() {
    let technique = direct();
    let mut built = Built::new(&lamp_room(0.3, 20.0));
    built.scene.positions[3] = Vec3::splat(f32::NAN);
    let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..2);
    assert!(is_sound(&rendered));
}

#[test]
fn viewers_of_nothing_ask_for_nothing() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    for view in &mut description.views {
        (view.forward, view.right) = (-view.forward, -view.right);
    }
    let built = Built::new(&description);
    let mut contender = cones(technique.as_ref(), "");
    let shots: Vec<Shot> = (0..16).map(|i| built.seen(i % 2, 0)).collect();
    let images = contender.frame(&shots).expect("a frame");
    assert_eq!(images.len(), 16);
    for rendered in &images {
        assert!(rendered.image.pixels.iter().all(|p| *p == [0.0; 3]));
        assert_eq!(found(rendered, "texels"), 0.0);
    }
    assert!(contender.frame(&[]).expect("no shot").is_empty());
}
