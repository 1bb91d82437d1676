//! The cones of the technique `direct-lighting`: convergence where the light rests, what changes, what is shared, and scenes
//! that break caches on surfaces.

#[path = "light_cones/change.rs"]
mod change;
#[path = "light_cones/hard.rs"]
mod hard;

use std::f64::consts::FRAC_PI_2;

use glam::{DMat4, DVec3};
use lightbench::image::{Image, luminance};
use lightbench::registry::technique;
use lightbench::scene::{
    LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
};
use lightbench::technique::{Contender, Film, Rendered, Shot, Technique, Terms, reference_pass};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

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
        truth_of(technique, &self.shot(0), 4000)
    }
}

/// The mean of paths.
fn truth_of(technique: &dyn Technique, shot: &Shot, passes: u32) -> Image {
    let function = technique.shading_function(shot);
    let counter = RayCounter::default();
    let mut mean = Image::new(SIZE[0], SIZE[1]);
    for pass in 0..passes {
        let (image, _) = reference_pass(function.as_ref(), shot, pass, &counter);
        for (sum, value) in mean.pixels.iter_mut().zip(&image.pixels) {
            (0..3).for_each(|c| sum[c] += value[c] / passes as f32);
        }
    }
    mean
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

/// At first, and after long at rest: nothing but noise is left, and what texels lose of edges.
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
        ("a large lamp", lamp_room(0.3, 20.0)),
    ] {
        let built = Built::new(&description);
        let truth = f64::from(mean(&built.truth(technique.as_ref())));
        for (frames, seeds) in [(3, 16), (64, 8)] {
            // Texels of half a pixel, so that what they lose of edges is little.
            let means: Vec<f64> = (0..seeds)
                .map(|seed| {
                    let mut contender = seeded(technique.as_ref(), "bias = -1.0", seed);
                    f64::from(mean(&built.play(contender.as_mut(), 0..frames).image))
                })
                .collect();
            let count = means.len() as f64;
            let mean = means.iter().sum::<f64>() / count;
            let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let error = (variance / count).sqrt();
            assert!(
                (mean - truth).abs() < 4.0 * error + 0.004 * truth,
                "{what}, {frames} frames: {mean} ± {error} for {truth}"
            );
        }
    }
}

/// Frames in which a lamp moves, seen by three viewers.
fn moving_room() -> Vec<Built> {
    let frame = |frame: u32| {
        let mut description = lamp_room(0.2, 20.0);
        let lamp = &mut description.shapes[2].to_world;
        *lamp = DMat4::from_translation(DVec3::new(0.2 * f64::from(frame), 0.0, 0.0)) * *lamp;
        let eye = [DVec3::new(0.0, 3.0, 0.1), DVec3::ZERO, DVec3::Y];
        let above = View::look_at("above", eye, 60.0, SIZE);
        description.views.push(above);
        Built::new(&description)
    };
    (0..4).map(frame).collect()
}

#[test]
fn images_are_the_same_for_any_number_of_threads() {
    let technique = direct();
    let frames = moving_room();
    for text in ["", "compressed = true", "most_blocks = 12"] {
        let render = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool").install(|| {
                let mut contender = cones(technique.as_ref(), text);
                let play = (0..).zip(&frames).map(|(frame, built)| {
                    let shots = [0, 1, 2].map(|viewer| built.seen(viewer, frame));
                    let images = contender.frame(&shots).expect("a frame");
                    let told = images.into_iter();
                    told.map(|image| (image.image.pixels, image.found, image.rays))
                        .collect()
                });
                play.collect::<Vec<Vec<_>>>()
            })
        };
        assert_eq!(render(1), render(4), "{text}");
    }
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
    let in_order = play([0, 1]);
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
fn viewers_may_come_in_any_order_where_lamps_move_and_room_is_scarce() {
    let technique = direct();
    let frames = moving_room();
    for text in ["", "most_blocks = 12"] {
        let play = |order: [usize; 3]| {
            let mut contender = cones(technique.as_ref(), text);
            let mut images = Vec::new();
            for (frame, built) in (0..).zip(&frames) {
                let shots = order.map(|viewer| built.seen(viewer, frame));
                images = contender.frame(&shots).expect("a frame");
            }
            let mut told: Vec<_> = order
                .into_iter()
                .zip(images)
                .map(|(viewer, image)| (viewer, image.image.pixels, image.found))
                .collect();
            told.sort_by_key(|(viewer, ..)| *viewer);
            told
        };
        let expected = play([0, 1, 2]);
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            assert_eq!(play(order), expected, "{text} {order:?}");
        }
    }
}
