use super::*;

fn key(time_s: f64, origin: [f64; 3], target: [f64; 3]) -> PathKey {
    let points = [DVec3::from(origin), DVec3::from(target), DVec3::Y];
    PathKey {
        time_s,
        view: View::look_at("main", points, 50.0, [16, 9]),
    }
}

fn path(keys: Vec<PathKey>, pace: Pace) -> CameraPath {
    CameraPath {
        name: "walk".into(),
        eye_distance_m: None,
        source: PathSource::Keys(KeyedPath::new(keys, pace).expect("a path")),
    }
}

/// Round a corner, with keys at uneven times and distances.
fn corner() -> Vec<PathKey> {
    vec![
        key(1.0, [0.0, 1.0, 0.0], [9.0, 1.0, 0.0]),
        key(2.0, [4.0, 1.0, 0.0], [9.0, 1.0, 0.0]),
        key(4.0, [5.0, 1.5, 1.0], [5.0, 1.0, 9.0]),
        key(4.5, [5.0, 2.0, 6.0], [5.0, 2.0, 9.0]),
    ]
}

fn assert_orthonormal(view: &View) {
    let [r, u, f] = [view.right, view.up, view.forward];
    for (a, b) in [(r, u), (u, f), (f, r)] {
        assert!(a.dot(b).abs() < 1e-12 && (a.length() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn keys_are_passed_at_their_times_and_held_outside() {
    let walk = path(corner(), Pace::Keyed);
    for key in corner() {
        let view = walk.view(key.time_s);
        assert!(view.origin.distance(key.view.origin) < 1e-12);
        assert!(view.forward.distance(key.view.forward) < 1e-9);
        assert_orthonormal(&view);
    }
    assert_eq!(walk.view(-5.0), walk.view(1.0));
    assert_eq!(walk.view(f64::MAX), walk.view(4.5));
    assert_eq!(walk.span_s(), [1.0, 4.5]);
    assert_eq!(walk.view(1.0).name, "walk");
}

#[test]
fn velocity_has_no_jumps() {
    let walk = path(corner(), Pace::Keyed);
    let speed = |time: f64| (walk.view(time + 1e-6).origin - walk.view(time).origin) / 1e-6;
    for time in [2.0, 4.0] {
        let jump = speed(time).distance(speed(time - 2e-6));
        assert!(jump < 1e-3, "{time}: {jump}");
    }
}

#[test]
fn constant_speed_is_constant() {
    let walk = path(corner(), Pace::Constant);
    let place = |i: i32| walk.view(1.0 + 3.5 * f64::from(i) / 200.0).origin;
    let steps: Vec<f64> = (0..200).map(|i| place(i).distance(place(i + 1))).collect();
    let mean = steps.iter().sum::<f64>() / 200.0;
    for (i, step) in steps.iter().enumerate() {
        assert!((step / mean - 1.0).abs() < 3e-3, "{i}: {step} {mean}");
    }
    assert_eq!(place(0), corner()[0].view.origin);
    assert!(place(200).distance(corner()[3].view.origin) < 1e-12);
}

#[test]
fn a_straight_path_is_straight_and_turns_evenly() {
    let keys = vec![
        key(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        key(2.0, [8.0, 0.0, 0.0], [9.0, 0.0, 0.0]),
    ];
    let walk = path(keys, Pace::Keyed);
    let view = walk.view(0.5);
    assert!(view.origin.distance(DVec3::new(2.0, 0.0, 0.0)) < 1e-12);
    let angle = std::f64::consts::FRAC_PI_8;
    let expected = DVec3::new(angle.sin(), 0.0, -angle.cos());
    assert!(view.forward.distance(expected) < 1e-12, "{}", view.forward);
}

#[test]
fn a_camera_may_wait_and_look_around() {
    let keys = vec![
        key(0.0, [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
        key(1.0, [1.0, 0.0, 0.0], [1.0, 0.0, -1.0]),
        key(2.0, [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
        key(3.0, [1.0, 0.0, 5.0], [2.0, 0.0, 5.0]),
    ];
    let walk = path(keys.clone(), Pace::Keyed);
    for i in 0..=10 {
        let view = walk.view(1.0 + 0.1 * f64::from(i));
        assert!(view.origin.distance(DVec3::X) < 1e-12);
        let angle = std::f64::consts::FRAC_PI_2 * 0.1 * f64::from(i);
        assert!(
            view.forward
                .distance(DVec3::new(angle.sin(), 0.0, -angle.cos()))
                < 1e-9
        );
    }
    let (key, message) = KeyedPath::new(keys, Pace::Constant).expect_err("waits");
    assert_eq!(key, 2, "{message}");
}

#[test]
fn one_key_is_a_camera_that_stands() {
    let stands = path(vec![key(3.0, [1.0, 2.0, 3.0], [0.0; 3])], Pace::Keyed);
    assert_eq!(stands.view(0.0), stands.view(99.0));
}

#[test]
fn wrong_keys_are_named() {
    let mut keys = corner();
    keys[2].time_s = 2.0;
    assert_eq!(KeyedPath::new(keys, Pace::Keyed).expect_err("order").0, 2);
    let mut keys = corner();
    keys[1].view.fov_axis = crate::scene::FovAxis::Y;
    assert_eq!(KeyedPath::new(keys, Pace::Keyed).expect_err("axis").0, 1);
    let mut keys = corner();
    keys[3].view.right = -keys[3].view.right;
    assert_eq!(KeyedPath::new(keys, Pace::Keyed).expect_err("mirror").0, 3);
}

#[test]
fn mirrored_cameras_stay_so() {
    let mut keys = corner();
    for key in &mut keys {
        key.view.right = -key.view.right;
    }
    let walk = path(keys, Pace::Keyed);
    let view = walk.view(3.0);
    assert!(is_mirrored(&view));
    assert_orthonormal(&view);
}

#[test]
fn eyes_are_apart_in_metres() {
    let pair = CameraPath {
        eye_distance_m: Some(0.06),
        ..path(corner(), Pace::Keyed)
    };
    // A unit of 2 m.
    let views = pair.views(1.0, 2.0);
    assert_eq!(views.len(), pair.viewers());
    assert!((views[1].origin - views[0].origin).distance(views[0].right * 0.03) < 1e-12);
    assert_eq!(
        [&views[0].name, &views[1].name],
        ["walk left", "walk right"]
    );
}

#[test]
fn a_path_moves_with_its_scene() {
    let turn = DQuat::from_rotation_y(0.4);
    let all = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::X);
    let walk = path(corner(), Pace::Keyed);
    let mut moved = walk.clone();
    moved.transformed(all);
    for time in [1.0, 2.7, 4.4] {
        let expected = carried(&walk.view(time), &all);
        let found = moved.view(time);
        assert!(found.origin.distance(expected.origin) < 1e-9);
        assert!(found.forward.distance(expected.forward) < 1e-9);
    }
}
