//! Animations against the formulas of the glTF 2.0 specification.

use glam::{DAffine3, DQuat, DVec3, DVec4};
use lightbench::scene::{Needs, Scene, SceneDescription};
use lightbench::world::World;
use serde_json::json;

use crate::builder::{FLOAT, File, floats, load_file};

fn moving() -> SceneDescription {
    load_file(&crate::committed("moving")).expect("loads")
}

/// Appendix C: the cubic between two keys of (in-tangent, value, out-tangent).
fn spline(before: [DVec4; 3], after: [DVec4; 3], span_s: f64, share: f64) -> DVec4 {
    let (t, t2, t3) = (share, share.powi(2), share.powi(3));
    before[1] * (2.0 * t3 - 3.0 * t2 + 1.0)
        + before[2] * (span_s * (t3 - 2.0 * t2 + t))
        + after[1] * (-2.0 * t3 + 3.0 * t2)
        + after[0] * (span_s * (t3 - t2))
}

/// Appendix C: spherical interpolation by the shorter way.
fn slerp(from: DVec4, to: DVec4, share: f64) -> DVec4 {
    let dot = from.dot(to);
    let angle = dot.abs().acos();
    (from * ((1.0 - share) * angle).sin() + to * ((share * angle).sin() * dot.signum()))
        / angle.sin()
}

fn about(axis: DVec3, degrees: f64) -> DVec4 {
    DVec4::from(DQuat::from_axis_angle(axis, degrees.to_radians()))
}

/// Where the arm of the moving file is.
fn arm(time_s: f64) -> DAffine3 {
    let keys = [
        DVec3::new(0.0, 0.5, 0.0),
        DVec3::new(1.0, 0.8, 0.5),
        DVec3::new(0.0, 0.5, -0.5),
    ];
    let place = match time_s {
        t if t < 1.0 => keys[0] + (keys[1] - keys[0]) * t.max(0.0),
        t => keys[1] + (keys[2] - keys[1]) * (t - 1.0).min(1.0),
    };
    let before = [
        DVec4::ZERO,
        about(DVec3::Y, -20.0),
        DVec4::new(0.0, 0.6, 0.0, -0.1),
    ];
    let after = [
        DVec4::new(0.0, 0.2, 0.1, -0.2),
        about(DVec3::Y, 70.0),
        DVec4::ZERO,
    ];
    let turn = spline(before, after, 1.0, time_s.clamp(0.0, 1.0)).normalize();
    DAffine3::from_rotation_translation(DQuat::from_vec4(turn), place)
}

/// Where the hand is, a child of the arm.
fn hand(time_s: f64) -> DAffine3 {
    let keys = [DVec4::W, -about(DVec3::Z, 80.0), about(DVec3::X, 60.0)];
    let turn = match time_s {
        t if t < 0.25 => keys[0],
        t if t < 0.75 => slerp(keys[0], keys[1], (t - 0.25) / 0.5),
        t if t < 1.5 => slerp(keys[1], keys[2], (t - 0.75) / 0.75),
        _ => keys[2],
    };
    let scale = match time_s {
        t if t < 0.5 => DVec3::splat(0.3),
        t if t < 1.0 => DVec3::new(0.3, 0.6, 0.3),
        _ => DVec3::splat(0.9),
    };
    let own = DAffine3::from_scale_rotation_translation(
        scale,
        DQuat::from_vec4(turn),
        DVec3::new(0.0, 1.2, 0.4),
    );
    arm(time_s) * own
}

fn shape(scene: &SceneDescription, name: &str) -> usize {
    scene
        .shapes
        .iter()
        .position(|s| s.name == name)
        .expect(name)
}

const TIMES_S: [f64; 10] = [-1.0, 0.0, 0.2, 0.4, 0.5, 0.7, 0.99, 1.2, 1.9, 50.0];

#[test]
fn nodes_are_where_the_formulas_put_them() {
    let description = moving();
    let scene = Scene::build(&description, Needs::ALL).expect("builds");
    let mut world = World::declared(scene, &description).expect("a world");
    let body = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.3, 0.7, 0.3),
        DQuat::IDENTITY,
        DVec3::new(0.0, 0.2, 0.0),
    );
    for time_s in TIMES_S {
        let moment = world.at(time_s);
        for (name, place) in [("hand", hand(time_s)), ("body", arm(time_s) * body)] {
            let triangles = moment.scene.shapes[shape(&description, name)].triangles();
            let used = moment.scene.triangles[triangles].iter().flatten();
            let mut corners: Vec<DVec3> = (0..8)
                .map(|i| {
                    DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0
                        - 1.0
                })
                .map(|corner| place.transform_point3(corner))
                .collect();
            for &i in used {
                let found = moment.scene.positions[i as usize].as_dvec3() + moment.scene.origin;
                let nearest = corners
                    .iter()
                    .map(|c| c.distance(found))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < 2e-5, "{name} at {time_s} s: {nearest}");
            }
            corners.dedup();
        }
        let torch = arm(time_s).transform_point3(DVec3::new(0.6, 1.6, 0.8));
        let found = moment.scene.point_lights[0].position.as_dvec3() + moment.scene.origin;
        assert!(found.distance(torch) < 2e-5, "{time_s} s: {found} {torch}");
    }
}

#[test]
fn an_animated_camera_is_a_path() {
    let scene = moving();
    let [path] = scene.paths.as_slice() else {
        panic!("one path")
    };
    assert_eq!(path.name, "crane");
    assert_eq!(path.span_s(), [0.0, 2.0]);
    let keys = [
        [
            DVec3::ZERO,
            DVec3::new(0.0, 2.5, 7.0),
            DVec3::new(2.0, 0.0, -1.0),
        ],
        [DVec3::X, DVec3::new(2.0, 2.0, 5.0), DVec3::ZERO],
    ];
    let keys = keys.map(|key| key.map(|v| v.extend(0.0)));
    let looks = [
        DQuat::from_rotation_x((-15_f64).to_radians()),
        DQuat::from_rotation_y(12_f64.to_radians())
            * DQuat::from_rotation_x((-15_f64).to_radians()),
    ];
    for time_s in TIMES_S {
        let place = spline(keys[0], keys[1], 2.0, time_s.clamp(0.0, 2.0) / 2.0).truncate();
        let turn = slerp(looks[0].into(), looks[1].into(), time_s.clamp(0.0, 1.0));
        let turn = DQuat::from_vec4(turn);
        let view = path.view(time_s);
        assert!(
            view.origin.distance(place) < 1e-6,
            "{time_s}: {} {place}",
            view.origin
        );
        for (found, expected) in [
            (view.forward, DVec3::NEG_Z),
            (view.up, DVec3::Y),
            (view.right, DVec3::X),
        ] {
            assert!(found.distance(turn * expected) < 1e-6, "{time_s}");
        }
    }
}

/// The triangle with its node animated.
fn animated(path: &str, values: &[f32], interpolation: &str) -> File {
    let mut file = File::triangle();
    let input = file.accessor(&floats(&[0.0, 1.0]), FLOAT, "SCALAR", 2);
    let (kind, size) = match path {
        "rotation" => ("VEC4", 4),
        "weights" => ("SCALAR", 1),
        _ => ("VEC3", 3),
    };
    let output = file.accessor(&floats(values), FLOAT, kind, values.len() / size);
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    file.set(
        "/animations",
        json!([{ "samplers": [sampler], "channels": [channel] }]),
    );
    file
}

#[test]
fn what_is_hidden_at_rest_appears() {
    let growing = animated("scale", &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0], "LINEAR")
        .with("/nodes/0/scale", json!([0, 0, 0]));
    let description = growing.load().expect("loads");
    let scene = Scene::build(&description, Needs::ALL).expect("builds");
    let mut world = World::declared(scene, &description).expect("a world");
    let moment = world.at(0.5);
    let [a, b] = [0, 1].map(|i| moment.scene.positions[i]);
    assert!((a.distance(b) - 1.0).abs() < 1e-6);
}

#[test]
fn wrong_animations_have_a_place() {
    let straight = || animated("translation", &[0.0; 6], "LINEAR");
    assert_eq!(straight().load().expect("loads").motions.len(), 1);
    for (file, expected) in [
        (
            animated("translation", &[0.0; 6], "CUBICSPLINE"),
            "animation 0, channel 0: has 2 values (accessor 2), 6 are expected",
        ),
        (
            animated("translation", &[f32::NAN; 6], "STEP"),
            "value 0 (accessor 2) is not finite",
        ),
        (
            animated("rotation", &[0.0; 8], "LINEAR"),
            "a rotation (accessor 2) is zero",
        ),
        (
            animated("translation", &[0.0; 6], "SMOOTH"),
            "animations[0].samplers[0].interpolation",
        ),
        (
            animated("translation", &[0.0; 6], "STEP").with("/accessors/1/count", json!(3)),
            "reaches beyond",
        ),
        (
            straight().with("/animations/0/channels/0/sampler", json!(4)),
            "sampler",
        ),
        (
            straight().with("/animations/0/channels/0/target/node", json!(4)),
            "channel 0: animates node 4, which is not there",
        ),
        (
            straight().with("/animations/0/channels/0/target/path", json!("tint")),
            "path",
        ),
        (
            straight().with(
                "/nodes/0/matrix",
                json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            ),
            "has a matrix",
        ),
    ] {
        let found = file.load().expect_err(expected);
        assert!(found.contains(expected), "{found} ({expected})");
    }
    let mut backwards = straight();
    let input = backwards.accessor(&floats(&[1.0, 1.0]), FLOAT, "SCALAR", 2);
    backwards.set("/animations/0/samplers/0/input", json!(input));
    assert!(
        backwards
            .load()
            .expect_err("equal times")
            .contains("do not ascend")
    );
}

#[test]
fn animations_play_together_unless_they_move_the_same() {
    let mut file = animated("translation", &[0.0; 6], "LINEAR");
    let first = file.json["animations"][0].clone();
    let mut second = first.clone();
    second["channels"][0]["target"]["path"] = json!("scale");
    let mut third = first.clone();
    third["name"] = json!("again");
    file.set("/animations", json!([first, second, third]));
    let scene = file.load().expect("loads");
    assert_eq!(scene.motions.len(), 1);
    let told = "animation 2 `again` is left out: it moves what animation 0 moves";
    assert!(
        scene.notes.iter().any(|note| note == told),
        "{:?}",
        scene.notes
    );
    let weights = animated("weights", &[0.0, 0.0], "LINEAR")
        .load()
        .expect("loads");
    assert!(weights.notes.iter().any(|note| note.contains("weights")));
    assert!(weights.motions.is_empty(), "nothing of it moves");
}
