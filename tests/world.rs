//! The world in time: what moves is moved, what stands still costs nothing, and lengths are those of the
//! whole sequence.

use glam::{DAffine3, DMat4, DVec3, Vec3};
use lightbench::scene::{
    Needs, PointLight, Scene, SceneDescription, ShapeDescription, ShapeSource, View, find_scene,
};
use lightbench::trace::{Hit, Kernel, Ray, RayCounter, Tracer};
use lightbench::world::{Moment, Motion, World};

/// A floor of 10 × 10 with a ball of radius 1 on it, seen from above.
fn scene() -> Scene {
    let flat = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let floor = ShapeDescription {
        to_world: flat * DMat4::from_scale(DVec3::splat(5.0)),
        ..ShapeDescription::new("floor", ShapeSource::Rectangle)
    };
    let ball = ShapeSource::Sphere {
        centre: DVec3::Y,
        radius: 1.0,
    };
    let eye = [DVec3::new(0.0, 9.0, 0.1), DVec3::ZERO, DVec3::Y];
    let description = SceneDescription {
        name: "ball".into(),
        views: vec![View::look_at("main", eye, 60.0, [8, 8])],
        shapes: vec![floor, ShapeDescription::new("ball", ball)],
        materials: vec![lightbench::scene::Material::diffuse("grey", [0.5; 3])],
        ..SceneDescription::default()
    };
    Scene::build(&description, Needs::GEOMETRY).unwrap_or_else(|e| panic!("{e}"))
}

/// The ball rises by a unit a second and moves along x by two.
fn rising() -> Motion {
    Motion {
        shape: 1,
        place: Box::new(|time_s| DAffine3::from_translation(DVec3::new(2.0, 1.0, 0.0) * time_s)),
    }
}

fn hit(tracer: &Tracer, origin: Vec3) -> Option<Hit> {
    let counter = RayCounter::default();
    tracer.caster(&counter).closest(&Ray::new(origin, -Vec3::Y))
}

/// From above a place of the floor, in the coordinates of the file.
fn above(moment: &Moment, x: f64) -> Vec3 {
    (DVec3::new(x, 20.0, 0.0) - moment.scene.origin).as_vec3()
}

#[test]
fn a_still_world_is_the_scene_at_any_time() {
    let built = scene();
    let expected = Tracer::new(&built.positions, &built.triangles);
    let mut world = World::still(scene());
    for time_s in [0.0, 1.0, -3.0] {
        let moment = world.at(time_s);
        assert_eq!(moment.scene.positions, built.positions);
        assert_eq!(moment.scene.diagonal, built.diagonal);
        let hit_now = hit(moment.tracer, above(&moment, 0.3));
        assert_eq!(hit_now, hit(&expected, above(&moment, 0.3)));
        let hit_now = hit_now.expect("the ball");
        let point = above(&moment, 0.3) - hit_now.t * Vec3::Y;
        assert!((moment.before(&hit_now) - point).length() < 1e-5);
    }
}

#[test]
fn lamps_stay_where_they_are_when_the_box_grows() {
    let lamp = DVec3::new(1.0, 4.0, 0.0);
    let mut built = scene();
    built.point_lights.push(PointLight {
        position: (lamp - built.origin).as_vec3(),
        intensity: [1.0; 3],
        cone: None,
    });
    let mut world = World::moving(built, vec![rising()], &[0.0, 9.0]).expect("a world");
    let scene = world.at(9.0).scene;
    let position = scene.point_lights[0].position.as_dvec3() + scene.origin;
    assert!(
        scene.origin.y > 4.0 && position.distance(lamp) < 1e-5,
        "{position}"
    );
}

#[test]
fn shapes_move_and_hits_know_where_they_were() {
    let mut world = World::moving(scene(), vec![rising()], &[0.0, 0.5, 1.0]).expect("a world");
    let (mut last, mut lengths) = (None, Vec::new());
    for time_s in [0.0, 0.5, 1.0] {
        let moment = world.at(time_s);
        let origin = above(&moment, 2.0 * time_s);
        let top = hit(moment.tracer, origin).expect("the ball");
        let height = f64::from(origin.y - top.t) + moment.scene.origin.y;
        assert!((height - (2.0 + time_s)).abs() < 1e-2, "{time_s}: {height}");
        let point = origin - top.t * Vec3::Y;
        let moved = point - moment.before(&top);
        let expected = last.map_or(Vec3::ZERO, |last: f64| {
            (DVec3::new(2.0, 1.0, 0.0) * (time_s - last)).as_vec3()
        });
        assert!((moved - expected).length() < 1e-4, "{time_s}: {moved}");
        let floor = hit(moment.tracer, above(&moment, -3.0)).expect("the floor");
        let point = above(&moment, -3.0) - floor.t * Vec3::Y;
        assert!((moment.before(&floor) - point).length() < 1e-5);
        lengths.push((moment.scene.origin, moment.scene.diagonal));
        last = Some(time_s);
    }
    lengths.dedup();
    let whole = DVec3::new(10.0, 3.0, 10.0);
    assert_eq!(lengths.len(), 1, "one centre and diagonal: {lengths:?}");
    assert!((lengths[0].0 - DVec3::new(0.0, 1.5, 0.0)).length() < 1e-5);
    assert!((f64::from(lengths[0].1) - whole.length()).abs() < 1e-4);
}

/// Another viewer of the same moment, and a step back.
#[test]
fn the_same_time_is_the_same_moment_and_time_may_go_back() {
    let mut world = World::moving(scene(), vec![rising()], &[0.0, 1.0]).expect("a world");
    world.at(0.0);
    let seen = |moment: Moment| {
        let hit = hit(moment.tracer, above(&moment, 2.0)).expect("the ball");
        (hit, moment.before(&hit))
    };
    let first = seen(world.at(1.0));
    assert_eq!(first, seen(world.at(1.0)));
    world.at(0.0);
    assert_eq!(first, seen(world.at(1.0)));
}

/// The moved tracer answers as one built for that moment.
#[test]
fn a_moment_is_traced_as_if_built_for_it() {
    let mut world = World::moving(scene(), vec![rising()], &[0.0, 1.0]).expect("a world");
    for time_s in [1.0, 0.25] {
        let moment = world.at(time_s);
        let anew = Tracer::new(&moment.scene.positions, &moment.scene.triangles);
        for i in -40..40 {
            let origin = above(&moment, f64::from(i) * 0.11 + 0.013);
            let (found, expected) = (hit(moment.tracer, origin), hit(&anew, origin));
            let known = moment.tracer.kernel() != Kernel::Portable;
            let alike = found == expected
                || !known && found.map(|h| h.triangle) == expected.map(|h| h.triangle);
            assert!(alike, "{found:?}, expected {expected:?}");
        }
    }
}

/// A sky that turns, a lamp that fades and is switched off, and what no motion names.
#[test]
fn light_changes_over_time_as_declared() {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("room.toml");
    let text = r#"
[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 45
[[shape]]
kind = "cube"
emission = 2
name = "lamp"
[[shape]]
kind = "sphere"
emission = 3
centre = [4, 0, 0]
[environment]
kind = "sky"
[[motion]]
environment = true
keys = [{ time = 0, rotate_deg = 0 }, { time = 1, rotate_deg = 90 }]
[[motion]]
shape = "lamp"
keys = [{ time = 0, emission = 1, on = true }, { time = 1, emission = 3 }, { time = 2, on = false }]
"#;
    std::fs::write(&file, text).expect("writable");
    let description = find_scene(&file.to_string_lossy()).expect("a scene");
    let scene = Scene::build(&description, Needs::ALL).expect("builds");
    let rest = scene.environment.clone().expect("a sky");
    let mut world = World::declared(scene, &description).expect("a world");
    for (time_s, emission) in [(0.5, 4.0), (1.5, 6.0), (2.0, 0.0), (0.0, 2.0)] {
        let scene = world.at(time_s).scene;
        assert_eq!(scene.shapes[0].emission, Some([emission; 3]), "{time_s}");
        assert_eq!(scene.shapes[1].emission, Some([3.0; 3]));
        let angle = 90.0_f32.to_radians() * time_s.min(1.0) as f32;
        let turn = glam::Quat::from_rotation_y(angle);
        let now = scene.environment.as_ref().expect("a sky");
        for direction in [Vec3::X, Vec3::new(0.6, 0.64, 0.48), -Vec3::Z] {
            let found = Vec3::from(now.radiance(turn * direction));
            let expected = Vec3::from(rest.radiance(direction));
            let error = (found - expected).length();
            assert!(
                error < 1e-3 * expected.length(),
                "{time_s}: {found} {expected}"
            );
        }
    }
}

/// Each key is fine by itself; the product of two is not.
#[test]
fn what_motions_take_beyond_single_precision_is_named_with_its_time() {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("room.toml");
    let scene = r#"
[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 45
[[shape]]
kind = "cube"
emission = 2
name = "lamp"
[[light]]
kind = "point"
name = "bulb"
position = [0, 3, 0]
intensity = 1
"#;
    for (moved, keyed, expected) in [
        ("shape = \"lamp\"", "scale", "the shape `lamp` beyond"),
        (
            "shape = \"lamp\"",
            "emission",
            "the emission of shape `lamp` beyond",
        ),
        (
            "light = \"bulb\"\npivot = [0, 0, 0]",
            "scale",
            "the light `bulb` beyond",
        ),
        ("light = \"bulb\"", "emission", "the light `bulb` beyond"),
    ] {
        // One motion is within, all of them together are beyond.
        let (value, count) = match keyed {
            "scale" => ("1e8", 3),
            _ => ("1e30", 2),
        };
        let motion = format!(
            "[[motion]]\n{moved}\nkeys = [{{ time = 0, {keyed} = 1 }}, {{ time = 2, {keyed} = {value} }}]\n"
        );
        let declared = |motions: &str| {
            std::fs::write(&file, format!("{scene}{motions}")).expect("writable");
            let description = find_scene(&file.to_string_lossy()).expect("a scene");
            let scene = Scene::build(&description, Needs::ALL).expect("builds");
            World::declared(scene, &description).map_err(|error| error.to_string())
        };
        declared(&motion).map(drop).expect(keyed);
        let error = declared(&motion.repeat(count)).map(drop).expect_err(keyed);
        assert!(error.contains(expected), "{error} ({expected})");
        assert!(error.contains(" s: key smaller values"), "{error}");
    }
}
