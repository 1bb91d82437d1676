//! Shipped configs by name, files to start from, and what was perhaps meant.

use super::Place;

#[test]
fn shipped_configs_run_by_name_from_any_folder() {
    let place = Place::new();
    for name in ["quickstart", "configs/quickstart.toml", "quickstart.toml"] {
        let output = place.lightbench(&["plan", name]);
        assert_eq!(output.code, 0, "{}", output.err);
        assert!(output.out.contains("quickstart: 54 jobs"), "{}", output.out);
    }
    let suite = place.lightbench(&["plan", "sequences/quick"]);
    assert_eq!(suite.code, 0, "{}", suite.err);
    let listed = place.lightbench(&["list", "configs"]);
    assert!(listed.out.contains("  quickstart  "), "{}", listed.out);
    assert!(listed.out.contains("papers/hash-cache/claims"));
    let several = place.lightbench(&["plan", "claims"]);
    assert_eq!(several.code, 2);
    assert!(several.err.contains("say which"), "{}", several.err);
    let wrong = place.lightbench(&["plan", "quikstart"]);
    assert_eq!(wrong.code, 2);
    let meant = "did you mean `quickstart`?";
    assert!(wrong.err.contains(meant), "{}", wrong.err);
}

#[test]
fn a_file_wins_over_a_shipped_config() {
    let place = Place::new();
    place.write("quickstart", &super::TINY.replace("\"tiny\"", "\"mine\""));
    let output = place.lightbench(&["plan", "quickstart"]);
    assert!(output.out.contains("mine: "), "{}", output.out);
}

#[test]
fn new_files_work_as_they_are_and_replace_nothing() {
    let place = Place::new();
    for arguments in [
        ["new", "scene", "my-room"],
        ["new", "experiment", "my-test"],
    ] {
        let output = place.lightbench(&arguments);
        assert_eq!(output.code, 0, "{}", output.err);
        let again = place.lightbench(&arguments);
        assert_eq!(again.code, 2, "{}", again.err);
        assert!(again.err.contains("left as it is"), "{}", again.err);
    }
    let scene = place.lightbench(&["scene", "check", "my-room"]);
    assert_eq!(scene.code, 0, "{}", scene.err);
    assert!(scene.out.contains("dropped_degenerate: 0"), "{}", scene.out);
    let render = [
        "render",
        "my-room",
        "--size",
        "16x9",
        "-o",
        "my-room.png",
        "-j",
        "1",
    ];
    let image = place.lightbench(&[&render, ["--method", "reference"].as_slice()].concat());
    assert_eq!(image.code, 0, "{}", image.err);
    let plan = place.lightbench(&["plan", "my-test.toml"]);
    assert!(
        plan.out.contains("my-test: 6 jobs"),
        "{}{}",
        plan.out,
        plan.err
    );
    let own = [
        "plan",
        "my-test.toml",
        "scene.cabinet-room.name=my-room/scene.toml",
    ];
    let own = place.lightbench(&own);
    assert_eq!(own.code, 0, "{}", own.err);
    for name in ["", "a/b", "..", "-x"] {
        let refused = place.lightbench(&["new", "scene", "--", name]);
        assert_eq!(refused.code, 2, "{name}: {}", refused.err);
    }
}

#[test]
fn what_was_perhaps_meant_is_said() {
    let place = Place::new();
    let with = |from: &str, to: &str| super::TINY.replace(from, to);
    for (text, meant) in [
        (with("caches = 60", "cachez = 60"), "caches"),
        (
            with("ambient-occlusion", "ambient-oclusion"),
            "ambient-occlusion",
        ),
        (with("\"hard-cases\"", "\"hard-case\""), "hard-cases"),
        (with("\"poles\"", "\"polse\""), "poles"),
        (with("id = \"VGC+DGS\"", "id = \"VGC+DSG\""), "DGS"),
        (
            with("id = \"IM\"", "id = \"IM\"\npatern = \"random\""),
            "pattern",
        ),
        (with("rmse(IM)", "rmze(IM)"), "rmse"),
        (with("< rmse(IM)", "< rmse(MI)"), "IM"),
        (
            with("\"errors\"", "\"errors\"\nkind = \"method\""),
            "methods",
        ),
    ] {
        place.write("bad.toml", &text);
        let output = place.lightbench(&["plan", "bad.toml"]);
        assert_eq!(output.code, 2, "{meant}");
        let said = format!("did you mean `{meant}`?");
        assert!(output.err.contains(&said), "{said}: {}", output.err);
    }
    place.write("good.toml", super::TINY);
    for (arguments, meant) in [
        (
            vec!["plan", "good.toml", "method.VGC+DSG.gamma=1"],
            "VGC+DGS",
        ),
        (
            vec!["plan", "good.toml", "scene.hard-case.caches=1"],
            "hard-cases",
        ),
        (vec!["plan", "good.toml", "repeat=2"], "repeats"),
        (vec!["explain", "VCG"], "VGC"),
        (vec!["list", "techniqus"], "techniques"),
        (
            vec!["lights", "gym", "--method", "decompositon"],
            "decomposition",
        ),
        (vec!["lights", "gymm"], "gym"),
    ] {
        let output = place.lightbench(&arguments);
        assert_eq!(output.code, 2, "{meant}");
        let said = format!("did you mean `{meant}`?");
        assert!(output.err.contains(&said), "{said}: {}", output.err);
    }
}

#[test]
fn lights_names_only_samplers_that_have_lights() {
    let place = Place::new();
    let refused = place.lightbench(&["lights", "gym", "--method", "product-ratio"]);
    assert_eq!(refused.code, 2);
    let (_, known) = refused.err.split_once("have one:").expect("a list");
    assert!(known.contains("median-cut"), "{known}");
    for without in ["product-ratio", "mis"] {
        assert!(
            !known.split([',', ' ']).any(|id| id.trim() == without),
            "{known}"
        );
    }
}

#[test]
fn records_of_the_on_demand_cache_are_written() {
    let place = Place::new();
    let arguments = [
        "caches",
        "cornell-curved",
        "--technique",
        "irradiance-caching",
        "--method",
        "on-demand",
        "--budget",
        "20",
        "--size",
        "24x16",
        "--set",
        "side=8",
        "-o",
        "records.csv",
    ];
    let output = place.lightbench(&arguments);
    assert_eq!(output.code, 0, "{}", output.err);
    let text = std::fs::read_to_string(place.path().join("records.csv")).expect("written");
    assert!(text.lines().count() > 2, "{text}");
}

/// A light, a ball and as many unnamed cubes as the text has no room for.
#[test]
fn a_check_lists_what_motions_can_move() {
    let place = Place::new();
    let cubes = "[[shape]]\nkind = \"cube\"\n".repeat(30);
    place.write(
        "many.toml",
        &format!(
            "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n[[shape]]\nkind = \"sphere\"\n\
             name = \"ball\"\n[[light]]\nkind = \"point\"\nname = \"bulb\"\nposition = [0, 3, 0]\nintensity = 1\n{cubes}"
        ),
    );
    let text = place.lightbench(&["scene", "check", "many.toml"]);
    assert_eq!(text.code, 0, "{}", text.err);
    let line = |key: &str| text.out.lines().find(|line| line.starts_with(key));
    let shapes = line("movable_shapes: ball, cube 1, ").expect("shapes");
    assert!(shapes.ends_with("cube 23, … and 7 more"), "{shapes}");
    assert_eq!(line("movable_lights"), Some("movable_lights: bulb"));
    let json = place.lightbench(&["scene", "check", "many.toml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).expect("JSON");
    let shapes = json["movable_shapes"].as_array().expect("a list");
    assert_eq!((shapes.len(), &shapes[30]), (31, &"cube 30".into()));
    assert_eq!(json["movable_lights"], serde_json::json!(["bulb"]));
}
