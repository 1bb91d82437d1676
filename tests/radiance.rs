//! The hash cache of the technique `radiance` in scenes whose light is known, and in those that break caches.

use glam::{DMat4, DVec3};
use lightbench::environment::EnvironmentDescription;
use lightbench::image::{Image, luminance};
use lightbench::registry::technique;
use lightbench::scene::{
    Bsdf, ColourSource, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource,
    View,
};
use lightbench::technique::{Contender, Film, Rendered, Shot, Technique, Terms, reference_pass};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

const SIZE: [usize; 2] = [16, 12];

/// Parameters over those that suit small images.
fn parameters(text: &str) -> toml::Table {
    let mut table: toml::Table = "levels = 6".parse().expect("toml");
    let more: toml::Table = text.parse().expect("toml");
    table.extend(more);
    table
}

fn radiance() -> Box<dyn Technique> {
    let entry = technique("radiance").expect("listed");
    (entry.build)(&toml::Table::new()).expect("defaults")
}

fn cache<'a>(technique: &'a dyn Technique, text: &str, budget: usize) -> Box<dyn Contender + 'a> {
    let terms = Terms { budget, seed: 1 };
    let started = technique.start("hash-cache", &parameters(text), terms);
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

    fn shot(&self, frame: u32) -> Shot<'_> {
        let film = Film {
            width: SIZE[0],
            height: SIZE[1],
            spp: 1,
        };
        let moment = Moment::still(&self.scene, &self.tracer);
        let mut shot = Shot::new(moment, &self.scene.views[0], film);
        shot.frame = frame;
        shot
    }

    /// The last of frames `0..count` by a contender.
    fn play(&self, contender: &mut dyn Contender, count: u32) -> Rendered {
        let mut last = Rendered::default();
        for frame in 0..count {
            let mut images = contender.frame(&[self.shot(frame)]).expect("a frame");
            last = images.pop().expect("one image");
        }
        last
    }

    /// The mean of paths.
    fn truth(&self, technique: &dyn Technique, passes: u32) -> Image {
        let shot = self.shot(0);
        let function = technique.shading_function(&shot);
        let counter = RayCounter::default();
        let mut mean = Image::new(SIZE[0], SIZE[1]);
        for pass in 0..passes {
            let (image, _) = reference_pass(function.as_ref(), &shot, pass, &counter);
            for (sum, value) in mean.pixels.iter_mut().zip(&image.pixels) {
                (0..3).for_each(|c| sum[c] += value[c] / passes as f32);
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

fn described(
    eye: [DVec3; 3],
    material: Material,
    shapes: Vec<ShapeDescription>,
) -> SceneDescription {
    SceneDescription {
        name: "test".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        max_depth: 8,
        views: vec![View::look_at("v", eye, 60.0, SIZE)],
        materials: vec![material],
        shapes,
        ..SceneDescription::default()
    }
}

/// The inside of a box whose walls all glow and reflect alike.
fn glowing_box(albedo: [f32; 3], emission: Option<[f32; 3]>) -> SceneDescription {
    let mut walls = ShapeDescription::new("box", ShapeSource::Cube);
    walls.flip_normals = true;
    walls.emission = emission;
    let mut material = Material::diffuse("wall", albedo);
    material.two_sided = false;
    let eye = [
        DVec3::new(0.2, 0.1, 0.6),
        DVec3::new(-0.3, 0.0, -1.0),
        DVec3::Y,
    ];
    described(eye, material, vec![walls])
}

/// A floor under a lamp, with a block on it.
fn lamp_room() -> SceneDescription {
    let turned = |angle: f64| DMat4::from_rotation_x(angle);
    let at = |shape: ShapeDescription, to_world| ShapeDescription { to_world, ..shape };
    let flat = ShapeDescription::new("floor", ShapeSource::Rectangle);
    let floor = at(
        flat,
        turned(-std::f64::consts::FRAC_PI_2) * DMat4::from_scale(DVec3::splat(2.0)),
    );
    let block = at(
        ShapeDescription::new("block", ShapeSource::Cube),
        DMat4::from_translation(DVec3::new(0.3, 0.4, -0.2))
            * DMat4::from_rotation_y(0.4)
            * DMat4::from_scale(DVec3::splat(0.4)),
    );
    let mut lamp = at(
        ShapeDescription::new("lamp", ShapeSource::Rectangle),
        DMat4::from_translation(DVec3::new(0.0, 2.5, 0.0))
            * turned(std::f64::consts::FRAC_PI_2)
            * DMat4::from_scale(DVec3::splat(0.5)),
    );
    lamp.emission = Some([8.0, 6.0, 5.0]);
    let eye = [
        DVec3::new(-1.0, 1.6, 3.0),
        DVec3::new(0.0, 0.3, 0.0),
        DVec3::Y,
    ];
    described(
        eye,
        Material::diffuse("grey", [0.6, 0.5, 0.4]),
        vec![floor, block, lamp],
    )
}

#[test]
fn a_glowing_box_gives_the_series_of_its_bounces_at_any_scale() {
    let albedo = [0.8f32, 0.5, 0.0];
    let emission = [1.0f32, 2.0, 3.0];
    let technique = radiance();
    for (scale, offset) in [(1.0, 0.0), (1e-3, 0.0), (1e5, 0.0), (1.0, 1e4)] {
        let box_ = glowing_box(albedo, Some(emission));
        let description = box_.transformed(scale, 0.0, DVec3::splat(offset));
        let built = Built::new(&description);
        for length in [0i32, 1, 3] {
            let text = format!("filter = 'off'\nsub_path_length = {length}");
            let mut contender = cache(technique.as_ref(), &text, 8);
            let image = built.play(contender.as_mut(), 4).image;
            for c in 0..3 {
                let series: f32 = (0..=length).map(|k| albedo[c].powi(k)).sum();
                let expected = emission[c] * (1.0 + albedo[c] * series);
                let sum: f32 = image.pixels.iter().map(|p| p[c]).sum();
                let off = sum / image.pixels.len() as f32 / expected - 1.0;
                assert!(
                    off.abs() < 0.02,
                    "scale {scale}, length {length}, channel {c}: {off}"
                );
            }
        }
    }
}

#[test]
fn a_still_camera_converges_to_path_tracing_on_diffuse_surfaces() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    let truth = built.truth(technique.as_ref(), 4000);
    // Many camera samples, so that edges in pixels are no noise.
    let text = "filter = 'off'\nsub_path_length = 6\nlevels = 9\nreconstruction = 32";
    let errors = [1, 4, 32].map(|frames| {
        let mut contender = cache(technique.as_ref(), text, 1);
        rmse(&built.play(contender.as_mut(), frames).image, &truth)
    });
    assert!(
        errors[1] < 0.8 * errors[0] && errors[2] < 0.6 * errors[1],
        "{errors:?}"
    );
    let mut contender = cache(technique.as_ref(), text, 16);
    let brightness = mean(&built.play(contender.as_mut(), 8).image) / mean(&truth);
    assert!((brightness - 1.0).abs() < 0.02, "{brightness}");
}

#[test]
fn smaller_cells_lower_the_floor() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    let truth = built.truth(technique.as_ref(), 4000);
    let floors = [2, 3, 6].map(|levels| {
        let text = format!(
            "filter = 'off'\njitter = 0.0\nsub_path_length = 6\nreconstruction = 64\nlevels = {levels}"
        );
        let mut contender = cache(technique.as_ref(), &text, 32);
        rmse(&built.play(contender.as_mut(), 8).image, &truth)
    });
    assert!(
        floors[0] > 1.2 * floors[1] && floors[1] > 1.2 * floors[2],
        "{floors:?}"
    );
}

#[test]
fn pixels_tell_which_cell_they_show() {
    let technique = radiance();
    let room = Built::new(&lamp_room());
    let numbers = |text: &str| {
        let mut contender = cache(technique.as_ref(), text, 4);
        assert!(contender.cells(&room.shot(0)).is_none(), "no frame yet");
        room.play(contender.as_mut(), 2);
        let cells = contender.cells(&room.shot(1)).expect("cells");
        assert_eq!(cells.len(), SIZE[0] * SIZE[1]);
        let whole = |number: &f32| (0.0..=1023.0).contains(number) && number.fract() == 0.0;
        assert!(cells.iter().all(whole));
        let mut known: Vec<u32> = cells.iter().map(|number| *number as u32).collect();
        known.sort_unstable();
        known.dedup();
        known.len()
    };
    let (coarse, fine) = (numbers("levels = 2"), numbers("levels = 6"));
    assert!(coarse > 2 && coarse < fine, "{coarse} {fine}");
}

#[test]
fn images_are_the_same_for_any_number_of_threads() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    let render = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let mut contender = cache(technique.as_ref(), "", 2);
            built.play(contender.as_mut(), 3).image
        })
    };
    assert_eq!(render(1).pixels, render(4).pixels);
}

#[test]
fn after_a_wipe_the_cache_is_as_new() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    let mut wiped = cache(technique.as_ref(), "wipe = 3", 1);
    let mut kept = cache(technique.as_ref(), "", 1);
    let wiped = built.play(wiped.as_mut(), 4).image;
    let kept = built.play(kept.as_mut(), 4).image;
    let mut new = cache(technique.as_ref(), "", 1);
    let new = new.frame(&[built.shot(3)]).expect("a frame");
    assert_eq!(wiped.pixels, new[0].image.pixels);
    assert_ne!(wiped.pixels, kept.pixels);
}

#[test]
fn a_sequence_goes_on_from_what_was_remembered() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    for precision in ["half", "single"] {
        let text = format!("precision = '{precision}'");
        let mut straight = cache(technique.as_ref(), &text, 1);
        let expected = built.play(straight.as_mut(), 4);
        let mut first = cache(technique.as_ref(), &text, 1);
        built.play(first.as_mut(), 3);
        let mut second = cache(technique.as_ref(), &text, 1);
        let memory = first.memory().expect("memory");
        assert!(second.recall(&memory).is_err(), "without cells");
        second.rebuild(&[built.shot(0)]).expect("cells");
        second.recall(&memory).expect("recalls");
        // Asked again before a frame is played, it still knows.
        assert_eq!(second.memory().expect("memory"), memory);
        let resumed = second.frame(&[built.shot(3)]).expect("a frame");
        assert_eq!(resumed[0].image.pixels, expected.image.pixels);
    }
}

/// Each frame drops another number of samples; a job has one note for all of them.
#[test]
fn samples_outside_of_the_first_frames_cells_are_counted() {
    let technique = radiance();
    let mut contender = cache(technique.as_ref(), "", 1);
    let mut counts = Vec::new();
    let mut notes = Vec::new();
    for frame in 0..3 {
        let mut description = lamp_room();
        let block = &mut description.shapes[1];
        block.to_world =
            DMat4::from_translation(DVec3::Y * 0.4 * f64::from(frame)) * block.to_world;
        let built = Built::new(&description);
        let mut images = contender.frame(&[built.shot(frame)]).expect("a frame");
        counts.push(found(&images[0], "dropped_samples"));
        notes.append(&mut images[0].notes);
    }
    assert_eq!(counts[0], 0.0);
    assert!(
        counts[1] > 0.0 && counts[2] > 0.0 && counts[1] != counts[2],
        "{counts:?}"
    );
    assert_eq!(notes.len(), 2);
    assert_eq!(notes[0], notes[1]);
}

#[test]
fn viewers_share_what_they_learn() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    let truth = built.truth(technique.as_ref(), 4000);
    let text = "filter = 'off'";
    let mut alone = cache(technique.as_ref(), text, 1);
    let alone = rmse(&built.play(alone.as_mut(), 1).image, &truth);
    let mut second = built.shot(0);
    second.viewer = 1;
    let mut both = cache(technique.as_ref(), text, 1);
    let both = both.frame(&[built.shot(0), second]).expect("a frame");
    assert_eq!(both.len(), 2);
    for image in &both {
        assert!(rmse(&image.image, &truth) < alone);
    }
    assert_ne!(both[0].image.pixels, both[1].image.pixels);
}

/// A sheet between a lamp above and darkness below is lit on one side.
#[test]
fn the_sides_of_a_thin_sheet_are_kept_apart() {
    let technique = radiance();
    let mut description = lamp_room();
    // Without the block, beside whose walls the floor's cells cannot tell above from below.
    description.shapes.retain(|shape| shape.name != "block");
    description.views = vec![
        description.views[0].clone(),
        View::look_at(
            "below",
            [DVec3::new(0.1, -2.0, 0.2), DVec3::ZERO, DVec3::X],
            40.0,
            SIZE,
        ),
    ];
    let built = Built::new(&description);
    let mut below = built.shot(0);
    below.view = &built.scene.views[1];
    below.viewer = 1;
    let mut contender = cache(technique.as_ref(), "filter = 'off'", 8);
    let images = contender.frame(&[built.shot(0), below]).expect("a frame");
    assert!(mean(&images[0].image) > 0.05);
    assert!(mean(&images[1].image) < 1e-6, "{}", mean(&images[1].image));
}

#[test]
fn black_walls_show_nothing_and_white_ones_stay_finite() {
    let technique = radiance();
    for (albedo, emission) in [
        ([0.0; 3], None),
        ([1.0; 3], None),
        ([0.0; 3], Some([1.0; 3])),
    ] {
        let built = Built::new(&glowing_box(albedo, emission));
        let mut contender = cache(technique.as_ref(), "", 2);
        let image = built.play(contender.as_mut(), 2).image;
        let expected = emission.map_or(0.0, |e| e[0]);
        for pixel in &image.pixels {
            assert!(
                pixel.iter().all(|v| (v - expected).abs() < 1e-5),
                "{pixel:?}"
            );
        }
    }
    let built = Built::new(&glowing_box([1.0; 3], Some([1.0; 3])));
    let mut contender = cache(technique.as_ref(), "filter = 'off'", 8);
    let brightness = mean(&built.play(contender.as_mut(), 4).image);
    assert!((brightness / 5.0 - 1.0).abs() < 0.02, "{brightness}");
}

#[test]
fn between_mirrors_paths_are_cut_and_counted() {
    let technique = radiance();
    let mut description = glowing_box([0.5; 3], None);
    description.materials[0].bsdf = Bsdf::Conductor {
        eta: [0.0; 3],
        k: [0.0; 3],
        specular: ColourSource::Constant([1.0; 3]),
        alpha: 0.0,
        distribution: Default::default(),
    };
    let built = Built::new(&description);
    let mut contender = cache(technique.as_ref(), "", 1);
    let rendered = built.play(contender.as_mut(), 2);
    assert!(rendered.image.pixels.iter().all(|p| *p == [0.0; 3]));
    assert_eq!(found(&rendered, "cut_paths"), 1.0);
    assert_eq!(found(&rendered, "stored_samples"), 0.0);
}

#[test]
fn a_colour_that_is_not_a_number_is_left_out_and_counted() {
    let technique = radiance();
    let mut built = Built::new(&lamp_room());
    built.scene.materials[0].bsdf = Bsdf::Diffuse {
        reflectance: ColourSource::Constant([f32::NAN; 3]),
    };
    let mut contender = cache(technique.as_ref(), "", 1);
    let rendered = built.play(contender.as_mut(), 1);
    assert!(rendered.non_finite > 0);
    assert!(
        rendered
            .image
            .pixels
            .iter()
            .flatten()
            .all(|v| v.is_finite())
    );
}

#[test]
fn holes_are_shown_by_what_is_known_nearby() {
    let technique = radiance();
    // All light is 1 + 0.5 (1 + 0.5 + 0.25 + 0.125), whatever is shown in its place.
    let built = Built::new(&glowing_box([0.5; 3], Some([1.0; 3])));
    // A tenth of the pixels fill the cache, in cells smaller than pixels.
    let text = "caching_resolution = 0.3\nlevels = 10\ncell_pixels = 0.25\njitter = 0.0";
    for holes in ["neighbours", "coarser"] {
        let text = format!("{text}\nholes = '{holes}'");
        let mut contender = cache(technique.as_ref(), &text, 1);
        let rendered = built.play(contender.as_mut(), 1);
        let share = found(&rendered, "holes");
        assert_eq!(share > 0.1, holes == "neighbours", "{holes}: {share}");
        for pixel in &rendered.image.pixels {
            assert!(pixel[0] > 1.2 && pixel[0] < 4.0, "{holes}: {pixel:?}");
        }
    }
}

#[test]
fn a_scene_is_seen_from_outside_of_its_cells() {
    let technique = radiance();
    let eye = [DVec3::new(9.0, 7.0, 11.0), DVec3::ZERO, DVec3::Y];
    let cube = ShapeDescription::new("cube", ShapeSource::Cube);
    let mut description = described(eye, Material::diffuse("grey", [0.5; 3]), vec![cube]);
    description.views = vec![View::look_at("v", eye, 14.0, SIZE)];
    description.environment = Some(EnvironmentDescription::Constant { radiance: [1.0; 3] });
    let built = Built::new(&description);
    let mut contender = cache(technique.as_ref(), "jitter = 0.0", 16);
    let rendered = built.play(contender.as_mut(), 2);
    assert!(found(&rendered, "holes") < 0.01, "but for edges");
    // Nothing but the sky lights a cube: half of it is sent on, whatever the side.
    let middle = rendered.image.pixels[SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2];
    assert!((middle[0] - 0.5).abs() < 0.01, "{middle:?}");
    assert_eq!(rendered.image.pixels[0], [1.0; 3], "the sky beside it");
}

#[test]
fn memory_is_foreseen_from_the_geometry() {
    let technique = radiance();
    let built = Built::new(&lamp_room());
    for map in ["blocks", "cuckoo", "open-addressing"] {
        let text = format!("levels = 9\nmap = '{map}'");
        let mut contender = cache(technique.as_ref(), &text, 1);
        let film = Film {
            width: SIZE[0],
            height: SIZE[1],
            spp: 1,
        };
        let geometry = Scene::build(&lamp_room(), Needs::POSITIONS).expect("a scene");
        let foreseen = contender.foreseen(&geometry, film).expect("it can tell");
        let held = built.play(contender.as_mut(), 1).bytes_cache as f64;
        assert!(
            (foreseen.cache / held - 1.0).abs() < 0.1,
            "{map}: {foreseen:?} {held}"
        );
        assert!(foreseen.work > 0.0);
    }
}
