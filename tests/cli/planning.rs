//! What is found wrong before the first ray, and what a plan is known by.

use std::fs;
use std::path::PathBuf;

use super::{Place, TINY, repository};

/// A floor from a file under a map from a file; neither is there unless a test writes it.
pub const ROOM: &str = r#"
[[view]]
origin = [0, 2, 4]
target = [0, 0, 0]
fov_deg = 40
size = [24, 16]
[[shape]]
kind = "cube"
scale = 0.5
[[shape]]
kind = "obj"
path = "floor.obj"
"#;
pub const FLOOR: &str = "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\nf 1 2 3 4\n";
const MAP: &str = "[environment]\nkind = \"map\"\npath = \"gone.hdr\"\n";

/// An experiment on the room.
pub fn experiment(technique: &str, method: &str) -> String {
    format!(
        "name = \"room\"\ntechnique = \"{technique}\"\ncaches = 20\n[[scene]]\nname = \"room\"\n\
         [[method]]\nid = \"{method}\"\n"
    )
}

pub fn write_room(place: &Place, scene: &str, floor: Option<&str>) {
    fs::create_dir_all(place.path().join("room")).expect("a folder");
    place.write("room/scene.toml", scene);
    if let Some(floor) = floor {
        place.write("room/floor.obj", floor);
    }
}

fn refused(place: &Place, arguments: &[&str], expected: &[&str]) {
    let output = place.lightbench(arguments);
    assert_eq!(output.code, 2, "{expected:?}: {}", output.err);
    for text in expected {
        assert!(output.err.contains(text), "`{text}` in: {}", output.err);
    }
    assert!(!place.path().join("results").exists(), "{expected:?}");
}

#[test]
fn what_does_not_go_together_is_refused_with_its_place() {
    let place = Place::new();
    let distant = TINY.replace("view =", "ao_distance = 0.5\nview =");
    let lights = |text: &str| {
        let text = text.replace("ambient-occlusion", "environment-lighting");
        let text = text.replace("parameters = { side = 8 }\n", "");
        let text = text.replace("caches = 60", "lights = 4");
        text.replace("\"VGC+DGS\"", "\"mis\"")
            .replace("\"IM\"", "\"tmms\"")
    };
    let importance = experiment("importance-caching", "VGC+EGR");
    let twice = "[[scene]]\nname = \"hard-cases\"\n[[method]]\nid = \"IM\"";
    let cases: [(String, &[&str]); 8] = [
        (
            importance.replace("\"room\"\n[[method]]", "\"cornell-curved\"\n[[method]]"),
            &["bad.toml:6:1", "interpolation = \"inverse-distance\""],
        ),
        (lights(TINY), &["bad.toml:9:1", "name a map"]),
        (
            lights(&distant),
            &["bad.toml:10:1", "takes no `ao_distance`"],
        ),
        (
            distant.replace("0.5", "-0.5"),
            &["bad.toml:11:1", "distance"],
        ),
        (
            TINY.replace("[[method]]\nid = \"IM\"", twice),
            &["bad.toml:1", "scenes 1 and 2", "`poles`", "another `label`"],
        ),
        (
            TINY.replace("[48, 27]", "[48, 0]"),
            &["bad.toml:6:1", "of at least 1"],
        ),
        (
            TINY.replace("view =", "metres_per_unit = -1.0\nview ="),
            &["bad.toml:11:1", "above 0"],
        ),
        (
            TINY.replace("view =", "transform = { scale = 0.0 }\nview ="),
            &["bad.toml:11:1", "scale above 0"],
        ),
    ];
    for (text, expected) in cases {
        place.write("bad.toml", &text);
        refused(&place, &["run", "bad.toml"], expected);
        refused(&place, &["plan", "bad.toml"], expected);
    }
    let distance = ["--set", "ao_distance=1", "--out", "a.exr"];
    let paths = ["render", "hard-cases", "--technique", "path-tracing"];
    refused(
        &place,
        &[paths, distance].concat(),
        &["takes no `ao_distance`"],
    );
    // Two views of one scene are two cases.
    let views = format!(
        "{ROOM}{}",
        ROOM[..ROOM.find("[[shape]]").expect("shapes")]
            .replace("fov_deg = 40", "fov_deg = 30\nname = \"near\"",)
    );
    write_room(&place, &views, Some(FLOOR));
    let two = experiment("ambient-occlusion", "IM");
    let two = two.replace(
        "[[method]]",
        "[[scene]]\nname = \"room\"\nview = \"near\"\n[[method]]",
    );
    place.write("two.toml", &two);
    let output = place.lightbench(&["plan", "two.toml"]);
    assert!(
        output.code == 0 && output.out.contains("2 jobs"),
        "{}",
        output.err
    );
}

#[test]
fn absent_files_are_refused_where_they_are_needed() {
    let place = Place::new();
    write_room(&place, &format!("{ROOM}{MAP}"), Some(FLOOR));
    place.write("lit.toml", &experiment("irradiance-caching", "VGC"));
    refused(
        &place,
        &["run", "lit.toml"],
        &["lit.toml:5:1", "gone.hdr", "light comes from it"],
    );
    let incomplete = ["run", "lit.toml", "scene.room.incomplete=true"];
    refused(&place, &incomplete, &["gone.hdr"]);
    let render = [
        "render",
        "room",
        "--technique",
        "path-tracing",
        "--out",
        "o.exr",
    ];
    refused(&place, &render, &["gone.hdr is absent"]);
    // Ambient occlusion has no use for a map, but for the floor.
    place.write("ao.toml", &experiment("ambient-occlusion", "IM"));
    assert_eq!(place.lightbench(&["plan", "ao.toml"]).code, 0);
    fs::remove_file(place.path().join("room/floor.obj")).expect("removable");
    refused(
        &place,
        &["plan", "ao.toml"],
        &["ao.toml:5:1", "floor.obj", "incomplete = true"],
    );
    let run = place.lightbench(&["run", "ao.toml", "scene.room.incomplete=true"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(
        run.err.matches("floor.obj is absent").count(),
        1,
        "{}",
        run.err
    );
    let row = &place.rows("results/room")[0];
    assert!(
        row["notes"].to_string().contains("floor.obj is absent"),
        "{row}"
    );
    let lamp = ROOM.replace("\"floor.obj\"", "\"floor.obj\"\nemission = [1, 1, 1]");
    place.write("room/scene.toml", &lamp);
    let render = [
        "render",
        "room",
        "--technique",
        "direct-lighting",
        "--out",
        "o.exr",
    ];
    let black = place.lightbench(&render);
    assert_eq!(black.code, 2, "{}", black.err);
    assert!(black.err.contains("light comes from it"), "{}", black.err);
}

#[test]
fn absent_material_libraries_are_refused_where_a_face_uses_them() {
    let place = Place::new();
    let floor = |material: &str| FLOOR.replace("f 1", &format!("mtllib gone.mtl\n{material}f 1"));
    write_room(&place, ROOM, Some(&floor("usemtl wood\n")));
    let sky = "[environment]\nkind = \"constant\"\nradiance = 1\n";
    place.write("room/scene.toml", &format!("{ROOM}{sky}"));
    let lit = experiment("path-tracing", "paths").replace("caches = 20", "samples = 1");
    place.write("lit.toml", &lit);
    refused(
        &place,
        &["run", "lit.toml"],
        &[
            "lit.toml:5:1",
            "material library",
            "gone.mtl is absent",
            "incomplete = true",
        ],
    );
    let incomplete = ["run", "lit.toml", "scene.room.incomplete=true"];
    let run = place.lightbench(&incomplete);
    assert_eq!(run.code, 0, "{}", run.err);
    let row = &place.rows("results/room")[0];
    assert!(row["notes"].to_string().contains("gone.mtl"), "{row}");
    // Ambient occlusion has no use for materials, and here no face has.
    place.write("ao.toml", &experiment("ambient-occlusion", "IM"));
    assert_eq!(place.lightbench(&["plan", "ao.toml"]).code, 0);
    place.write("room/floor.obj", &floor(""));
    assert_eq!(place.lightbench(&["plan", "lit.toml"]).code, 0);
}

#[test]
fn the_unit_of_a_scene_can_be_set_and_is_part_of_the_keys() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let ids = |setting: &[&str]| {
        let arguments = [&["plan", "tiny.toml", "--json"], setting].concat();
        let output = place.lightbench(&arguments);
        let plan: serde_json::Value = serde_json::from_str(&output.out).expect("json");
        let job = |key: &str| plan["jobs"][0][key].as_str().map(str::to_owned);
        [job("id"), job("reference")]
    };
    let (plain, set) = (ids(&[]), ids(&["scene.hard-cases.metres_per_unit=0.1"]));
    assert_ne!(plain[0], set[0]);
    assert_ne!(plain[1], set[1]);
    let image = |setting: &[&str]| {
        let render = [
            "render",
            "hard-cases",
            "--size",
            "24x16",
            "--budget",
            "20",
            "--set",
            "side=8",
            "--method",
            "VGC",
            "--out",
            "o.exr",
        ];
        let output = place.lightbench(&[&render, setting].concat());
        assert_eq!(output.code, 0, "{}", output.err);
        fs::read(place.path().join("o.exr")).expect("an image")
    };
    let metres = image(&["--set", "metres_per_unit=1"]);
    assert_ne!(metres, image(&["--set", "metres_per_unit=0.01"]));
}

#[test]
fn an_override_that_is_given_twice_is_refused() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let twice: [&[&str]; 2] = [
        &["caches=10", "caches=20,30"],
        &["repeats=2", "--repeats", "3"],
    ];
    for arguments in twice {
        let plan = place.lightbench(&[&["plan", "tiny.toml"], arguments].concat());
        assert_eq!(plan.code, 2, "{}", plan.err);
        assert!(plan.err.contains("is given twice"), "{}", plan.err);
    }
}

#[test]
fn every_shipped_config_plans() {
    let place = Place::new();
    let mut folders = vec![PathBuf::from(repository("configs"))];
    let mut configs = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("configs") {
            let path = entry.expect("entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                configs.push(path.display().to_string());
            }
        }
    }
    assert!(configs.len() >= 50);
    for config in configs {
        let output = place.lightbench(&["plan", &config]);
        assert_eq!(output.code, 0, "{config}: {}", output.err);
        assert!(output.out.contains("jobs"), "{}", output.out);
    }
}

#[test]
fn plans_tell_memory_where_methods_can() {
    let place = Place::new();
    let config = repository("configs/papers/hash-cache/memory.toml");
    let plan = |scene: &str, more: &[&str]| {
        let asked = [
            "plan",
            &config,
            "method.hash-cache.levels=8",
            "--memory",
            "--scene",
            scene,
        ];
        place.lightbench(&[&asked, more].concat())
    };
    let output = plan("long-street", &[]);
    assert_eq!(output.code, 0, "{}", output.err);
    assert!(output.out.contains("MiB in the cache"), "{}", output.out);
    let json: serde_json::Value =
        serde_json::from_str(&plan("long-street", &["--json"]).out).expect("JSON");
    let memory = json["estimates"]["memory"].as_array().expect("a list");
    assert_eq!(memory.len(), 2, "two kinds of maps");
    let bytes = |i: usize| memory[i]["bytes_cache"].as_f64().expect("a number");
    assert!(bytes(0) > bytes(1) && bytes(1) > 1e6, "{memory:?}");
}

#[test]
fn references_are_shared_by_settings_of_contenders_alone() {
    let place = Place::new();
    let config = repository("configs/papers/cache-placement/importance-fig3.toml");
    let first = |setting: &str| {
        let output = place.lightbench(&["plan", "--json", &config, setting]);
        let plan: serde_json::Value = serde_json::from_str(&output.out).expect("json");
        let bytes = plan["estimates"]["record_bytes_peak"].as_u64();
        // 25,000 records of 8192 lights: three half floats a light, and their sums.
        assert_eq!(bytes, Some(25_000 * (8192 * 6 + 128 * 24 + 4)));
        let job = |key: &str| plan["jobs"][0][key].as_str().map(str::to_owned);
        [job("id"), job("reference")]
    };
    let plain = first("parameters.seed=1");
    let ablation = first("parameters.heuristic=alpha-max");
    let other_lights = first("parameters.seed=2");
    assert_ne!(plain[1], other_lights[1]);
    assert_eq!(first("parameters.seed=1"), plain);
    assert_ne!(plain[0], ablation[0]);
    let swept = place.lightbench(&[
        "plan",
        "--json",
        &config,
        "parameters.heuristic=balance,alpha-max",
    ]);
    let plan: serde_json::Value = serde_json::from_str(&swept.out).expect("json");
    let jobs = plan["jobs"].as_array().expect("jobs");
    // Two methods, three seeds and two heuristics.
    assert_eq!(jobs.len(), 12);
    assert!(
        jobs.iter()
            .all(|job| job["reference"] == jobs[0]["reference"])
    );
    let ids: std::collections::BTreeSet<_> = jobs.iter().map(|j| j["id"].as_str()).collect();
    assert_eq!(ids.len(), 12);
}

#[test]
fn paths_in_a_config_are_relative_to_it() {
    let place = Place::new();
    let scene = "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n[[shape]]\nkind = \"cube\"\n";
    std::fs::create_dir_all(place.path().join("there/scenes")).expect("folders");
    std::fs::create_dir_all(place.path().join("there/configs")).expect("folders");
    place.write("there/scenes/box.toml", scene);
    let config = TINY.replace("\"hard-cases\"", "\"../scenes/box.toml\"");
    let config = config.replace("view = \"poles\"", "");
    place.write("there/configs/c.toml", &config);
    let output = place.lightbench(&["plan", "there/configs/c.toml"]);
    assert_eq!(output.code, 0, "{}", output.err);
    assert!(output.out.contains("box"), "{}", output.out);
    // Without a separator too, from any folder.
    place.write("there/configs/box.toml", scene);
    let config = config.replace("../scenes/box.toml", "box.toml");
    place.write("there/configs/beside.toml", &config);
    let output = place.lightbench(&["plan", "there/configs/beside.toml"]);
    assert_eq!(output.code, 0, "{}", output.err);
}

#[test]
fn what_a_config_adds_can_be_for_some_of_its_scenes() {
    let place = Place::new();
    write_room(&place, ROOM, Some(FLOOR));
    let scenes = "[[scene]]\nname = \"room\"\nlabel = \"plain\"\n[[scene]]\nname = \"room\"\nlabel = \"ball\"\n";
    let plain =
        experiment("ambient-occlusion", "IM").replace("[[scene]]\nname = \"room\"\n", scenes);
    let ball = |scenes: &str| {
        format!(
            "{plain}[[shape]]\n{scenes}name = \"ball\"\nkind = \"sphere\"\nradius = 0.5\n\
             [[motion]]\n{scenes}shape = \"ball\"\nkeys = [{{ time = 0, translate = [0, 1, 0] }}]\n"
        )
    };
    // Keys of the jobs of both scenes.
    let planned = |text: &str| {
        place.write("room.toml", text);
        let output = place.lightbench(&["plan", "room.toml"]);
        assert_eq!(output.code, 0, "{}", output.err);
        let keys = output.out.lines().take(2);
        let keys = keys.map(|line| line.split(' ').next().unwrap_or_default().to_owned());
        keys.collect::<Vec<String>>()
    };
    let without = planned(&plain);
    let all = planned(&ball(""));
    let one = planned(&ball("scenes = [\"ball\"]\n"));
    assert_eq!(one, [without[0].clone(), all[1].clone()]);
    assert!(without[0] != all[0] && without[1] != all[1]);
    // One scene is not loaded for the other.
    let output = place.lightbench(&["run", "room.toml", "--out", "out"]);
    assert_eq!(output.code, 0, "{}", output.err);
    let images = one.iter().map(|id| {
        let image = place.path().join("out/jobs").join(id).join("image.exr");
        fs::read(image).expect("an image")
    });
    let images: Vec<Vec<u8>> = images.collect();
    assert!(images[0] != images[1], "both scenes look the same");
    assert_eq!(planned(&ball("scenes = [\"room\"]\n")), all);
    for (scenes, expected) in [
        ("scenes = [\"bal\"]\n", "room.toml:1"),
        ("scenes = [\"bal\"]\n", "did you mean `ball`?"),
        ("scenes = \"ball\"\n", "a list of names"),
        ("scenes = [1]\n", "expected names, found 1"),
        ("scenes = []\n", "the name of a [[scene]]"),
    ] {
        place.write("room.toml", &ball(scenes));
        refused(&place, &["plan", "room.toml"], &[expected]);
    }
}
