use std::path::Path;

use super::super::parse_toml;
use super::*;

const HEAD: &str = r#"[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 45
[[shape]]
kind = "cube"
name = "box"
[[shape]]
kind = "sphere"
name = "lamp"
emission = 2
[[light]]
kind = "point"
name = "bulb"
position = [0, 3, 0]
intensity = 1
[[motion]]
"#;

fn load(text: &str) -> Result<MotionDescription, String> {
    let text = format!("{HEAD}{text}");
    let scene = parse_toml(&text, Some(Path::new("scene.toml")), "s");
    let scene = scene.map_err(|e| e.to_string())?;
    scene.motions.into_iter().next_back().ok_or("none".into())
}

#[test]
fn keys_that_say_nothing_of_a_value_do_not_key_it() {
    let motion = load(
        "shapes = [\"lamp\", \"box\", \"lamp\"]\nlight = \"bulb\"\npivot = [1, 0, 0]\nkeys = [\n\
         { time = 0, translate = [0, 0, 0] }, { time = 1, rotate_deg = 90 },\n\
         { time = 2, translate = [4, 0, 0], scale = 2 } ]",
    )
    .unwrap();
    assert_eq!((motion.shapes, motion.lights), (vec![0, 1], vec![0]));
    let at = |time, point| motion.placement.at(time).transform_point3(point);
    // Scale and turn have one key each, which holds at all times.
    let there = at(1.0, DVec3::new(2.0, 0.0, 0.0));
    assert!(
        there.distance(DVec3::new(3.0, 0.0, -2.0)) < 1e-12,
        "{there}"
    );
    assert!(motion.strength.is_empty());
}

#[test]
fn lamps_fade_and_are_switched() {
    let motion = load(
        "shape = \"lamp\"\nkeys = [{ time = 0, emission = 1, on = true }, { time = 2, emission = 3 },\n\
         { time = 3, on = false }]",
    )
    .unwrap();
    let strength = |time| motion.strength.iter().map(|s| s.at(time)).product::<f64>();
    assert_eq!([0.0, 1.0, 2.5, 3.0].map(strength), [1.0, 2.0, 3.0, 0.0]);
    assert!(motion.placement.is_rest());
}

#[test]
fn wrong_motions_have_places() {
    for (text, place, expected) in [
        (
            "keys = [{ time = 0, on = true }]",
            "17:1",
            "needs what it moves",
        ),
        ("shape = \"bax\"\nkeys = []", "18:9", "did you mean `box`"),
        (
            "shapes = [\"box\", \"nobody\"]\nkeys = []",
            "18:18",
            "`nobody` is unknown",
        ),
        ("light = \"lamp\"\nkeys = []", "18:9", "`lamp` is unknown"),
        ("shape = \"box\"", "17:1", "needs `keys`"),
        (
            "shape = \"box\"\nkeys = [{ time = 1, scale = 1 }, { time = 1, scale = 2 }]",
            "19:34",
            "must ascend",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = nan, scale = 1 }]",
            "19:18",
            "a finite number",
        ),
        (
            "shape = \"box\"\nkeys = [{ scale = 1 }]",
            "19:9",
            "needs `time`",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0, scale = 0 }]",
            "19:29",
            "above 0",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0, translate = [1e39, 0, 0] }]",
            "19:33",
            "3 finite numbers of at most 3.4e38",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0, scale = 1e300 }]",
            "19:29",
            "a finite number of at most 3.4e38",
        ),
        (
            "shape = \"lamp\"\nkeys = [{ time = 0, emission = 1e308 }]",
            "19:32",
            "a finite number of at most 3.4e38",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0, scal = 2 }]",
            "19:21",
            "unknown key `scal`",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0 }]",
            "17:1",
            "need `translate`",
        ),
        (
            "shape = \"box\"\nkeys = [{ time = 0, on = false }]",
            "17:1",
            "emits no light",
        ),
        (
            "environment = true\nkeys = [{ time = 0, rotate_deg = 3 }]",
            "17:1",
            "no environment",
        ),
        (
            "environment = true\nkeys = [{ time = 0, scale = 3 }]",
            "17:1",
            "can only turn",
        ),
        (
            "shape = \"box\"\naxis = [0, 0, 0]\nkeys = [{ time = 0, rotate_deg = 3 }]",
            "17:1",
            "must not be zero",
        ),
        (
            "shape = \"box\"\ninterpolation = \"cubic\"\nkeys = [{ time = 0, rotate_deg = 3 }]",
            "19:17",
            "`cubic` is unknown",
        ),
    ] {
        let error = load(text).unwrap_err();
        let at = format!("scene.toml:{place}:");
        assert!(error.starts_with(&at), "{text}: {error}");
        assert!(error.contains(expected), "{error} ({expected})");
    }
}
