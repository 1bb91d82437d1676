use glam::{DMat4, Vec3};
use toml::Table as Parameters;

use super::*;
use crate::image::Image;
use crate::scene::{
    Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View, find_scene,
};
use crate::technique::path_samples;
use crate::technique::{Film, Terms};
use crate::trace::Tracer;
use crate::world::Moment;

const AGES: Ages = Ages {
    history: 64,
    stale: 8,
    blend: false,
};

fn sample(key: Key, light: f32) -> Sample {
    Sample {
        key,
        light: Vec3::splat(light),
    }
}

fn key(x: i32) -> Key {
    Key::new([x, 0, 0], 500, 0)
}

#[test]
fn keys_survive_packing() {
    for position in [
        [0, 0, 0],
        [-1, 5, -7],
        [65535, -65536, 65535],
        [-40000, 12345, 1],
    ] {
        for level in [1, 386, 512, 1023] {
            for octant in 0..8 {
                let key = Key::new(position, level, octant);
                assert_ne!(key, Key::EMPTY);
                let unpacked = (key.position(), key.level(), key.octant());
                assert_eq!(unpacked, (position, level, octant));
            }
        }
    }
    let cell = Key::new([-3, 7, -8], 500, 5);
    assert!(cell.children().all(|child| child.parent() == cell));
    assert_eq!(cell.children().count(), 8);
    assert_eq!(
        Key::new([65535, 0, 0], 500, 0).children().count(),
        0,
        "no key is wrapped"
    );
}

#[test]
fn places_are_cells_of_the_wanted_size_wherever_they_lie() {
    let at = |scale: f32, p: Vec3| {
        let grid = Grid::about((Vec3::new(0.0, 0.0, 4.0) * scale).as_dvec3(), 0.01);
        grid.place(p * scale, Vec3::Y).expect("a place")
    };
    let p = Vec3::new(-0.3, 0.7, 0.2);
    let unit = at(1.0, p);
    let wanted = 0.01 * p.distance(Vec3::Z * 4.0);
    assert!((0.7..1.42).contains(&(unit.side / wanted)), "{unit:?}");
    // Powers of two change the level alone.
    for power in [-100, -20, 20, 100] {
        let scaled = at(2.0f32.powi(power), p);
        assert_eq!(scaled.key.position(), unit.key.position());
        assert_eq!(scaled.key.level() as i32, unit.key.level() as i32 + power);
    }
    // Noise about a wall along the faces of cells.
    let wall = |x: f32| at(1.0, Vec3::new(x, 0.7, 0.2)).key;
    assert_eq!(wall(1e-7), wall(-1e-7));
    assert_ne!(wall(0.1), wall(-0.1));
    let side = |n: Vec3| {
        Grid::about(DVec3::ZERO, 0.01)
            .place(p, n)
            .expect("a place")
            .key
    };
    assert_eq!(
        side(Vec3::new(1e-5, 1.0, -1e-5)),
        side(Vec3::Y),
        "noise about an axis"
    );
    assert_ne!(side(-Vec3::Y), side(Vec3::Y));
    // A camera close to a surface that is far from the origin: coarser cells, each with a key of its own.
    let far = Vec3::new(1000.0, -999.0, 5.0);
    let grid = Grid::about((far + Vec3::X * 0.01).as_dvec3(), 1e-3);
    let place = |p: Vec3| grid.place(p, Vec3::Y).expect("a place");
    assert!(place(far).side > 1e-4);
    let next = place(far + Vec3::new(0.0, place(far).side, 0.0));
    assert_ne!(place(far).key, next.key);
    assert!(grid.place(Vec3::NAN, Vec3::Y).is_none());
    assert!(grid.place(Vec3::splat(f32::INFINITY), Vec3::Y).is_none());
    let on_camera = grid.place(far + Vec3::X * 0.01, Vec3::Y);
    assert!(on_camera.is_some(), "no distance");
}

/// All slots of a small table are one window.
#[test]
fn keys_that_share_a_window_are_told_apart() {
    let mut table = Table::new(16);
    let samples = (0..10).map(|x| sample(key(x), x as f32)).collect();
    let merged = table.merge(samples, &AGES);
    assert_eq!(
        (merged.cells, merged.dropped, table.occupied()),
        (10, 0, 10)
    );
    for x in 0..10 {
        assert_eq!(
            table.get(key(x)).expect("a cell").mean,
            Vec3::splat(x as f32)
        );
    }
    assert!((10..1000).all(|x| table.get(key(x)).is_none()));
    assert!(
        table.get(Key::new([3, 0, 0], 500, 1)).is_none(),
        "other octant"
    );
    assert!(
        table.get(Key::new([3, 0, 0], 501, 0)).is_none(),
        "other level"
    );
}

#[test]
fn a_full_table_drops_and_counts() {
    let mut table = Table::new(4);
    let samples = || {
        (0..6)
            .flat_map(|x| [sample(key(x), 1.0), sample(key(x), 3.0)])
            .collect()
    };
    for _ in 0..3 {
        let merged = table.merge(samples(), &AGES);
        assert_eq!((merged.samples, merged.dropped), (8, 4));
        assert_eq!(table.occupied(), 4);
    }
    let known = (0..6).filter_map(|x| table.get(key(x)));
    assert!(
        known
            .clone()
            .all(|c| c.mean == Vec3::splat(2.0) && c.samples == 6.0)
    );
    assert_eq!(known.count(), 4);
}

#[test]
fn old_cells_are_given_up_and_begin_anew() {
    let mut table = Table::new(4);
    table.merge((0..4).map(|x| sample(key(x), 1.0)).collect(), &AGES);
    for frame in 0..8 {
        let merged = table.merge(vec![sample(key(0), 1.0)], &AGES);
        assert_eq!(merged.evicted, 0, "frame {frame}");
    }
    let merged = table.merge(vec![sample(key(2), 5.0), sample(key(7), 6.0)], &AGES);
    assert_eq!(
        (merged.evicted, merged.dropped, table.occupied()),
        (3, 0, 3)
    );
    let cell = table.get(key(2)).expect("a new cell");
    assert_eq!((cell.mean, cell.samples), (Vec3::splat(5.0), 1.0));
    assert_eq!(table.get(key(0)).expect("sampled").samples, 9.0);
    assert_eq!(
        table.get(key(7)).expect("in a freed slot").mean,
        Vec3::splat(6.0)
    );
    assert!(table.get(key(1)).is_none());
}

#[test]
fn means_forget_what_lies_before_their_window() {
    let mut table = Table::new(4);
    let ages = Ages { history: 4, ..AGES };
    for _ in 0..50 {
        table.merge(vec![sample(key(0), 1.0)], &ages);
    }
    let held = table.get(key(0)).expect("a cell").samples;
    assert!((4.0..6.0).contains(&held), "{held}");
    for _ in 0..30 {
        table.merge(vec![sample(key(0), 9.0)], &ages);
    }
    assert!(table.get(key(0)).expect("a cell").mean.x > 8.9);
}

#[test]
fn new_cells_begin_with_an_adjacent_level_where_a_viewer_moved() {
    let ages = Ages {
        blend: true,
        ..AGES
    };
    let coarse = Key::new([-2, 3, 0], 501, 2);
    for (known, new) in [
        (coarse, coarse.children().next().expect("a child")),
        (coarse.children().last().expect("a child"), coarse),
    ] {
        let mut table = Table::new(64);
        table.merge(vec![sample(known, 1.0); 9], &ages);
        let merged = table.merge(vec![sample(new, 11.0)], &ages);
        assert_eq!(merged.blended, 1);
        let cell = table.get(new).expect("a cell");
        assert!((cell.samples - 8.2).abs() < 1e-3, "{cell:?}");
        assert!((1.0..1.5).contains(&cell.mean.x), "{cell:?}");
        let merged = table.merge(vec![sample(new, 1.0)], &ages);
        assert_eq!(merged.blended, 0, "once");
    }
}

struct World {
    scene: Scene,
    tracer: Tracer,
}

impl World {
    fn new(description: &SceneDescription) -> Self {
        let scene = Scene::build(description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Self { scene, tracer }
    }

    fn shot<'a>(&'a self, view: &'a View, frame: u32) -> Shot<'a> {
        let film = Film {
            width: 32,
            height: 18,
            spp: 1,
        };
        let mut shot = Shot::new(Moment::still(&self.scene, &self.tracer), view, film);
        shot.frame = frame;
        shot
    }
}

const TERMS: Terms = Terms { budget: 1, seed: 7 };

fn started<'a>(truth: &'a Truth, parameters: &str) -> Box<dyn Contender + 'a> {
    let table: Parameters = parameters.parse().expect("toml");
    (ENTRY.start)(truth, &table, TERMS).expect("starts")
}

fn truth() -> Truth {
    Truth::new(&Parameters::new(), None, &[]).expect("the defaults")
}

/// A closed box that glows and reflects everywhere, with a camera inside.
fn furnace(albedo: f32, emission: f32) -> SceneDescription {
    let mut cube = ShapeDescription::new("box", ShapeSource::Cube);
    cube.flip_normals = true;
    cube.emission = (emission > 0.0).then_some([emission; 3]);
    let eye = [DVec3::new(0.2, 0.1, 0.6), DVec3::ZERO, DVec3::Y];
    SceneDescription {
        name: "furnace".into(),
        max_depth: 64,
        views: vec![View::look_at("v", eye, 60.0, [32, 18])],
        materials: vec![Material {
            two_sided: false,
            ..Material::diffuse("wall", [albedo; 3])
        }],
        shapes: vec![cube],
        ..SceneDescription::default()
    }
}

fn mean(image: &Image) -> f64 {
    let values = image.pixels.iter().flatten().map(|v| f64::from(*v));
    values.sum::<f64>() / (3 * image.pixels.len()) as f64
}

fn found(rendered: &Rendered, key: &str) -> f64 {
    let value = rendered.found.iter().find(|(k, _)| *k == key);
    value.expect("found").1
}

/// Plays frames of a still camera and gives back their images.
fn frames(world: &World, parameters: &str, count: u32) -> Vec<Rendered> {
    let truth = truth();
    let mut contender = started(&truth, parameters);
    let view = &world.scene.views[0];
    let frame = |frame| {
        contender
            .frame(&[world.shot(view, frame)])
            .expect("images")
            .remove(0)
    };
    (0..count).map(frame).collect()
}

#[test]
fn a_closed_glowing_box_sums_the_geometric_series() {
    for scale in [1e-3, 1.0, 1e4] {
        for query in ["secondary", "primary"] {
            let mut description = furnace(0.6, 2.0);
            description.shapes[0].to_world = DMat4::from_scale(DVec3::splat(scale));
            description.views[0].origin *= scale;
            let world = World::new(&description);
            let parameters = format!("query = \"{query}\"\ncell_pixels = 4\nleast_samples = 4");
            let images = frames(&world, &parameters, 24);
            let shown: Vec<f64> = images[8..].iter().map(|r| mean(&r.image)).collect();
            let brightness = shown.iter().sum::<f64>() / shown.len() as f64;
            let expected = 2.0 / (1.0 - 0.6);
            let off = brightness / expected - 1.0;
            assert!(off.abs() < 0.01, "{query} at scale {scale}: {brightness}");
            let last = images.last().expect("a frame");
            assert!(last.lookups > 0 && found(last, "misses") < 0.9 * last.lookups as f64);
            assert_eq!(last.non_finite, 0);
        }
    }
}

#[test]
fn black_and_empty_scenes_are_black() {
    let mut nothing_there = furnace(0.5, 0.0);
    nothing_there.shapes.clear();
    for description in [furnace(0.5, 0.0), furnace(0.0, 0.0), nothing_there] {
        let Ok(scene) = Scene::build(&description, Needs::ALL) else {
            continue;
        };
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        for rendered in frames(&World { scene, tracer }, "smoothed = true", 3) {
            assert!(rendered.image.pixels.iter().all(|pixel| *pixel == [0.0; 3]));
            assert_eq!(rendered.non_finite, 0);
        }
    }
}

#[test]
fn what_is_not_finite_is_left_out_and_counted() {
    let world = World::new(&furnace(0.9, f32::MAX));
    for rendered in frames(&world, "", 3) {
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
}

/// The mean of many frames is nearly that of path tracing.
#[test]
fn the_bias_on_a_diffuse_scene_is_small() {
    let world = World::new(&find_scene("still-puzzle").expect("an embedded scene"));
    let truth = truth();
    let view = &world.scene.views[0];
    let terms = Terms {
        budget: 512,
        seed: 3,
    };
    let mut paths = (path_samples::ENTRY.start)(&truth, &Parameters::new(), terms).expect("starts");
    let reference = paths.frame(&[world.shot(view, 0)]).expect("images");
    let expected = mean(&reference[0].image);
    for parameters in ["", "smoothed = true", "query = \"primary\""] {
        let images = frames(&world, parameters, 64);
        let shown: f64 = images[16..].iter().map(|r| mean(&r.image)).sum();
        let off = shown / 48.0 / expected - 1.0;
        assert!(off.abs() < 0.03, "{parameters}: {off}");
    }
}

fn bits(rendered: &Rendered) -> String {
    let pixels: Vec<[u32; 3]> = (rendered.image.pixels.iter())
        .map(|pixel| pixel.map(f32::to_bits))
        .collect();
    let counts = (rendered.rays, rendered.lookups, &rendered.found);
    format!("{pixels:?} {counts:?}")
}

/// Two viewers who move, for some frames.
fn flight(world: &World, contender: &mut dyn Contender, numbers: std::ops::Range<u32>) -> String {
    let mut all = String::new();
    for number in numbers {
        let views: Vec<View> = [0.01, -0.02]
            .iter()
            .map(|step| {
                let mut view = world.scene.views[0].clone();
                view.origin += DVec3::new(f64::from(number) * step, 0.0, 0.0);
                view
            })
            .collect();
        let mut shots: Vec<Shot> = views.iter().map(|view| world.shot(view, number)).collect();
        shots[1].viewer = 1;
        let images = contender.frame(&shots).expect("images");
        assert_eq!(images.len(), 2);
        assert_ne!(images[0].image.pixels, images[1].image.pixels);
        images.iter().for_each(|rendered| all += &bits(rendered));
    }
    all
}

#[test]
fn frames_do_not_depend_on_threads_nor_on_interruptions() {
    let world = World::new(&find_scene("still-puzzle").expect("an embedded scene"));
    let truth = truth();
    let start = || started(&truth, "capacity = 4096\nsmoothed = true\nstale_frames = 8");
    let play = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let mut contender = start();
        pool.expect("a pool").install(|| {
            let first = flight(&world, contender.as_mut(), 0..4);
            (first, flight(&world, contender.as_mut(), 4..6))
        })
    };
    let (first, last) = play(1);
    assert_eq!((first.clone(), last.clone()), play(4));
    let mut contender = start();
    assert!(contender.remembers());
    assert_eq!(flight(&world, contender.as_mut(), 0..4), first);
    let memory = contender.memory().expect("memory");
    let mut resumed = start();
    resumed.recall(&[]).expect("nothing");
    resumed.recall(&memory).expect("recalled");
    assert_eq!(resumed.memory().expect("memory"), memory);
    assert_eq!(flight(&world, resumed.as_mut(), 4..6), last);
    let mut other = started(&truth, "capacity = 64");
    assert!(other.recall(&memory).is_err(), "a smaller table");
    assert!(other.recall(&[1, 2, 3]).is_err(), "something else");
}

#[test]
fn a_small_table_says_what_it_dropped() {
    let world = World::new(&furnace(0.6, 1.0));
    let images = frames(&world, "capacity = 16", 2);
    let last = images.last().expect("a frame");
    assert_eq!(found(last, "occupancy"), 1.0);
    assert!(found(last, "dropped_samples") > 0.0);
    assert!(last.notes.iter().any(|note| note.contains("dropped")));
    assert_ne!(
        found(&images[0], "dropped_samples"),
        found(last, "dropped_samples")
    );
    assert_eq!(images[0].notes, last.notes, "one note of the job");
}
