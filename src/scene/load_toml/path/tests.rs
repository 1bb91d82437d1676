use std::path::Path;

use super::super::parse_toml;
use super::*;

const HEAD: &str = r#"[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 45
fov_axis = "y"
size = [64, 32]
[[shape]]
kind = "cube"
[[path]]
"#;

fn load(text: &str) -> Result<CameraPath, String> {
    let text = format!("{HEAD}{text}");
    let scene = parse_toml(&text, Some(Path::new("scene.toml")), "s");
    let scene = scene.map_err(|e| e.to_string())?;
    scene.paths.into_iter().next_back().ok_or("none".into())
}

#[test]
fn keys_from_points() {
    let path = load(
        "name = \"walk\"\nkeys = [{ time = 1, origin = [0, 0, 0], target = [0, 0, -1], fov_deg = 60 },\n\
         { time = 3, origin = [2, 0, 0], target = [2, 0, -1] }]",
    )
    .unwrap();
    let view = path.view(2.0);
    assert_eq!((path.name.as_str(), path.span_s()), ("walk", [1.0, 3.0]));
    assert!(view.origin.distance(DVec3::X) < 1e-12);
    assert_eq!((view.fov_deg, view.fov_axis), (60.0, FovAxis::X));
    assert_eq!([view.width, view.height], [1920, 1080]);
}

#[test]
fn keys_from_views_keep_what_the_view_has() {
    let path = load(
        "eye_distance_m = 0.1\nkeys = [{ time = 0, view = \"main\" },\n\
         { time = 1, view = \"main\", move = [1, 2, 3] },\n\
         { time = 2, view = \"main\", move = [0, 0, 3], target = [9, 0, 6], fov_deg = 30 }]",
    )
    .unwrap();
    assert_eq!((path.name.as_str(), path.viewers()), ("path1", 2));
    let view = path.view(1.0);
    assert!(view.origin.distance(DVec3::new(1.0, 2.0, 6.0)) < 1e-12);
    assert_eq!((view.fov_deg, view.fov_axis), (45.0, FovAxis::Y));
    assert_eq!([view.width, view.height], [64, 32]);
    let end = path.view(9.0);
    assert!(end.forward.distance(DVec3::X) < 1e-9 && end.fov_deg == 30.0);
}

#[test]
fn wrong_paths_have_places() {
    let key = "{ time = 0, origin = [0, 0, 0], target = [0, 0, -1], fov_deg = 60 }";
    for (text, place, expected) in [
        ("".to_owned(), "9:1", "at least one key"),
        (
            format!("keys = [{key}, {{ time = 0, origin = [1, 0, 0], target = [0, 0, 0] }}]"),
            "10:78",
            "key 1 of path `path1`: times of keys must ascend",
        ),
        (
            "keys = [{ time = nan, view = \"main\" }]".into(),
            "10:18",
            "`time` of key 0 of path `path1`: expected a finite number",
        ),
        (
            "keys = [{ time = 0, view = \"mein\" }]".into(),
            "10:28",
            "did you mean `main`",
        ),
        (
            "keys = [{ time = 0, origin = [0, 0, 0], target = [1, 0, 0] }]".into(),
            "10:9",
            "needs `fov_deg`",
        ),
        (
            format!("keys = [{key}, {{ time = 1, view = \"main\" }}]"),
            "10:78",
            "give `fov_deg`",
        ),
        (
            format!("keys = [{key}, {{ time = 1, origin = [1, 0, 0], target = [1, 0, 0] }}]"),
            "10:78",
            "coincide",
        ),
        (
            format!(
                "speed = \"constant\"\nkeys = [{key}, {{ time = 1, origin = [0, 0, 0], target = [1, 0, 0] }}]"
            ),
            "11:78",
            "no constant speed",
        ),
        (
            format!("keys = [{}]", key.replace("60", "180")),
            "10:72",
            "below 180",
        ),
        (
            format!("keys = [{}]", key.replace("time = 0", "time = 0, fov = 3")),
            "10:21",
            "unknown key `fov`",
        ),
        (
            format!("sped = 1\nkeys = [{key}]"),
            "10:1",
            "unknown key `sped`",
        ),
        (
            format!("name = \"a\"\nkeys = [{key}]\n[[path]]\nname = \"a\"\nkeys = [{key}]"),
            "12:1",
            "two paths called `a`",
        ),
    ] {
        let error = load(&text).unwrap_err();
        let at = format!("scene.toml:{place}:");
        assert!(error.starts_with(&at), "{text}: {error}");
        assert!(error.contains(expected), "{error} ({expected})");
    }
}
