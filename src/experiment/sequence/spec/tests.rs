use super::*;
use crate::scene::motion::Placement;
use crate::scene::path::PathSource;
use crate::scene::{FovAxis, find_scene_in};

fn scene() -> SceneDescription {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("s.toml");
    let text = r#"
metres_per_unit = 0.5
[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 90
[[shape]]
kind = "cube"
[[path]]
name = "walk"
keys = [{ time = 0, view = "main" }, { time = 1, view = "main", move = [1, 0, 0] }]
[[path]]
name = "pair"
eye_distance_m = 0.06
keys = [{ time = 0, view = "main" }]
"#;
    std::fs::write(&file, text).expect("writable");
    find_scene_in(&file.display().to_string(), &[]).expect("a scene")
}

fn spec(text: &str) -> SequenceSpec {
    toml::from_str(text).expect("a sequence")
}

fn resolve(text: &str) -> Result<Sequence, String> {
    let resolved = spec(text).resolve(&scene(), None, "main", &|view| [view.width, view.height]);
    resolved.map_err(|(key, why)| format!("{key}: {why}"))
}

#[test]
fn frames_may_be_counted_ranged_and_listed() {
    for (text, expected) in [
        ("frames = 3", vec![0, 1, 2]),
        ("frames = \"2..5\"", vec![2, 3, 4]),
        ("frames = \"0..10..4\"", vec![0, 4, 8]),
        ("frames = [1, 7]", vec![1, 7]),
    ] {
        assert_eq!(resolve(text).expect(text).frames, expected);
    }
    let sequence = resolve("frames = 9\nwarm_up = 2\nmeasure_every = 3\nfps = 10").expect("ok");
    assert_eq!(sequence.measured().collect::<Vec<_>>(), [2, 5, 8]);
    let pairs =
        resolve("frames = 10\nwarm_up = 1\nmeasure_every = 4\nmeasure_run = 2").expect("ok");
    assert_eq!(pairs.measured().collect::<Vec<_>>(), [1, 2, 5, 6, 9]);
    assert_eq!((sequence.time_s(5), sequence.representative()), (0.5, 5));
    assert_eq!(sequence.place(), "main");
}

#[test]
fn more_frames_than_a_sequence_has_are_refused_before_they_are_made() {
    for text in [
        "frames = 100001",
        "frames = 4000000000",
        "frames = \"0..4000000000\"",
        "frames = \"0..4000000000..2\"",
    ] {
        let error = resolve(text).expect_err(text);
        assert!(error.contains("expected 1 to 100000 of them"), "{error}");
    }
}

#[test]
fn viewers_follow_paths_and_rules() {
    let places = |text: &str| {
        let sequence = resolve(&format!("frames = 1\n{text}")).expect(text);
        let views = sequence.views(&scene(), 0.0).expect("views");
        (sequence.place(), views)
    };
    let (name, views) = places("path = \"walk\"");
    assert_eq!((name.as_str(), views.len()), ("walk", 1));
    let (name, views) = places("path = \"pair\"");
    assert_eq!((name.as_str(), views.len()), ("pair", 2));
    assert!((views[0].origin.distance(views[1].origin) - 0.12).abs() < 1e-12);
    assert_eq!(places("viewers = [\"walk\", \"pair\"]").1.len(), 3);
    assert_eq!(places("viewers = { count = 2 }").0, "walk + pair");
    // A square film of 90°: half an overlap is 45°… of the width of 16 : 9.
    let (_, views) = places("path = \"walk\"\nviewers = { count = 3, overlap = 0.5 }");
    for (copy, view) in views.iter().enumerate() {
        let angle = (45.0 * copy as f64).to_radians();
        assert!(
            (view.forward.x - angle.sin()).abs() < 1e-9,
            "{copy}: {}",
            view.forward
        );
        assert!(view.right.dot(view.forward).abs() < 1e-12);
    }
}

#[test]
fn images_are_kept_as_asked() {
    let kept = |keep: &str| {
        let text = format!("frames = 100\nwarm_up = 1\nmeasure_every = 2\n{keep}");
        resolve(&text).expect(keep).kept
    };
    assert_eq!(kept(""), [1, 15, 29, 43, 57, 71, 85, 99]);
    assert_eq!(kept("keep = \"measured\"").len(), 50);
    assert_eq!(kept("keep = \"all\"").len(), 100);
    assert_eq!(kept("keep = \"none\"").len(), 0);
    assert_eq!(kept("keep = [0, 99]"), [0, 99]);
    assert_eq!(kept("keep = [6, 0, 0]"), [0, 6]);
}

#[test]
fn what_is_wrong_is_named() {
    for (text, expected) in [
        ("frames = 0", "frames: frames: expected 1 to"),
        ("frames = \"5..2\"", "expected 1 to"),
        ("frames = \"0..5..0\"", "expected \"from..to\""),
        ("frames = \"0-5\"", "expected \"from..to\""),
        ("frames = [3, 3]", "ascending"),
        (
            "frames = 3\nfps = nan",
            "fps: fps: expected a number above 0",
        ),
        (
            "frames = 3\nfps = 5e-324",
            "fps: fps: expected more, so that the time of frame 2",
        ),
        ("frames = 3\nwarm_up = 3", "leave none of 3"),
        ("frames = 3\nmeasure_every = 0", "at least 1"),
        ("frames = 3\nmeasure_run = 0", "expected 1 to 1"),
        (
            "frames = 9\nmeasure_every = 3\nmeasure_run = 4",
            "expected 1 to 3",
        ),
        ("frames = 3\nkeep = [7]", "frame 7 is not rendered"),
        (
            "frames = 3\npath = \"wolk\"",
            "no path `wolk`; did you mean `walk`? it has: walk, pair",
        ),
        ("frames = 3\nviewers = []", "at least one path"),
        (
            "frames = 3\nviewers = { count = 9 }",
            "9 are wanted and the paths have 3",
        ),
        ("frames = 3\nviewers = { count = 0 }", "a count from 1"),
        (
            "frames = 3\nviewers = { count = 2, overlap = 0.5 }",
            "name it as `path`",
        ),
        (
            "frames = 3\npath = \"walk\"\nviewers = { count = 2, overlap = 0.5, paths = [\"pair\"] }",
            "viewers: viewers with an `overlap` are copies of `path`: leave `paths` out",
        ),
        (
            "frames = 3\npath = \"walk\"\nviewers = [\"pair\"]",
            "path: path: `viewers` say who looks, and `walk` would not be followed",
        ),
        (
            "frames = 3\npath = \"walk\"\nviewers = { count = 2 }",
            "path: path: `viewers` say who looks",
        ),
        (
            "frames = 3\npath = \"walk\"\nviewers = { count = 2, overlap = 2 }",
            "from 0 to 1",
        ),
    ] {
        let error = resolve(text).expect_err(text);
        assert!(error.contains(expected), "{error} ({expected})");
    }
}

/// The path's picture is 16 : 9; that of the job counts.
#[test]
fn viewers_overlap_in_the_pictures_of_the_job() {
    let mut scene = scene();
    let view = scene.views[0].clone();
    let tall = View {
        fov_axis: FovAxis::Y,
        ..view
    };
    let placement = Placement::default();
    scene.paths[0].source = PathSource::Carried {
        view: tall,
        placement,
    };
    let spec = spec("frames = 1\npath = \"walk\"\nviewers = { count = 2, overlap = 0 }");
    for (size, tangent) in [([240, 60], 4.0_f64), ([60, 60], 1.0), ([30, 60], 0.5)] {
        let sequence = spec.resolve(&scene, None, "main", &|_| size);
        let views = sequence.expect("ok").views(&scene, 0.0).expect("views");
        let angle = views[0].forward.angle_between(views[1].forward);
        assert!(
            (angle - 2.0 * tangent.atan()).abs() < 1e-9,
            "{size:?}: {angle}"
        );
    }
}

#[test]
fn values_of_another_kind_are_told_what_is_expected() {
    for (text, expected) in [
        ("frames = -1", "frames: expected how many"),
        ("frames = 1.5", "frames: expected how many"),
        ("frames = 3\nkeep = \"sum\"", "keep: expected \"some\""),
        ("frames = 3\nviewers = 3", "viewers: expected a list"),
        (
            "frames = 3\nviewers = { paths = [\"walk\"] }",
            "or { count = 2 }",
        ),
    ] {
        let error = toml::from_str::<SequenceSpec>(text).expect_err(text);
        let error = error.message();
        assert!(error.contains(expected), "{error} ({expected})");
    }
}
