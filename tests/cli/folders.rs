//! Results folders over time: resumed, extended, merged, with scenes that change or break.

use std::fs;

use super::planning::{FLOOR, ROOM, experiment, write_room};
use super::{Place, TINY};

#[test]
fn a_selection_keeps_what_else_the_folder_has() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let all = ["run", "tiny.toml", "repeats=1", "--out", "out"];
    assert_eq!(place.lightbench(&all).code, 0);
    let rows = place.rows("out");
    assert_eq!(rows.len(), 2);
    let one = place.lightbench(&[&all[..], &["--method", "IM"]].concat());
    assert_eq!(one.code, 0, "{}", one.err);
    assert_eq!(
        place.rows("out"),
        rows,
        "both methods, in the config's order"
    );
    let page = fs::read_to_string(place.path().join("out/report.html")).expect("page");
    assert!(page.contains("VGC+DGS"));
    let gate = place.lightbench(&["gate", "out"]);
    assert_ne!(gate.code, 12, "the gate has its data: {}", gate.out);
    // Another budget is another experiment: its jobs do not stand beside those of the first.
    let other = [&all[..], &["caches=30", "--method", "IM"]].concat();
    let other = place.lightbench(&other);
    assert!(
        other.err.contains("2 jobs in this folder are no longer"),
        "{}",
        other.err
    );
    assert_eq!(place.rows("out").len(), 1);
    let text = fs::read_to_string(place.path().join("out/provenance.json")).expect("there");
    let provenance: serde_json::Value = serde_json::from_str(&text).expect("json");
    let entries = provenance["entries"].as_array().expect("entries");
    assert_eq!(entries.len(), 1, "one program on one machine: {text}");
    assert!(
        entries[0]["overrides"].to_string().contains("caches=30"),
        "{text}"
    );
}

#[test]
fn a_mesh_that_was_edited_is_rendered_again() {
    let place = Place::new();
    write_room(&place, ROOM, Some(FLOOR));
    place.write("ao.toml", &experiment("ambient-occlusion", "IM"));
    let run = || place.lightbench(&["run", "ao.toml"]);
    assert_eq!(run().code, 0);
    let before = place.rows("results/room")[0].clone();
    assert!(run().err.contains("0 jobs to run"));
    place.write("room/floor.obj", &FLOOR.replace(" 0 ", " 1 "));
    let again = run();
    assert!(again.err.contains("1 jobs to run"), "{}", again.err);
    let after = &place.rows("results/room")[0];
    assert_ne!(before["reference"], after["reference"]);
    assert_ne!(before["rmse"], after["rmse"]);
}

/// Nothing but its contents tells the second mesh from the first.
#[test]
fn a_mesh_of_the_same_size_and_time_is_rendered_again() {
    let place = Place::new();
    write_room(&place, ROOM, Some(FLOOR));
    place.write("ao.toml", &experiment("ambient-occlusion", "IM"));
    let floor = place.path().join("room/floor.obj");
    let run = || place.lightbench(&["run", "ao.toml"]);
    assert_eq!(run().code, 0);
    let before = place.rows("results/room")[0].clone();
    let known = fs::metadata(&floor).expect("there");
    place.write("room/floor.obj", &FLOOR.replace(" 0 ", " 1 "));
    let file = fs::File::options().write(true).open(&floor);
    let times = fs::FileTimes::new().set_modified(known.modified().expect("a time"));
    file.and_then(|file| file.set_times(times))
        .expect("settable");
    let edited = fs::metadata(&floor).expect("there");
    assert_eq!(edited.len(), known.len());
    assert_eq!(
        edited.modified().expect("a time"),
        known.modified().expect("a time")
    );
    let again = run();
    assert!(again.err.contains("1 jobs to run"), "{}", again.err);
    let after = &place.rows("results/room")[0];
    assert_ne!(before["reference"], after["reference"]);
    assert_ne!(before["rmse"], after["rmse"]);
    let references = fs::read_dir(place.path().join("results/references")).expect("a folder");
    let names = references.map(|entry| entry.expect("entry").file_name());
    let kept = names.filter(|name| name.to_string_lossy().ends_with(".exr"));
    assert_eq!(kept.count(), 2, "each mesh has its own");
}

#[test]
fn a_scene_that_does_not_load_fails_its_jobs_alone() {
    let place = Place::new();
    write_room(&place, ROOM, Some("v 0 0 0\nv 1 0 0\nf 1 2 9\n"));
    let text = TINY.replace(
        "[[method]]\nid = \"IM\"",
        "[[scene]]\nname = \"room\"\n[[method]]\nid = \"IM\"",
    );
    let text = text.replace("repeats = 2", "repeats = 1");
    let first = text
        .replace("\"room\"", "\"x\"")
        .replace("\"hard-cases\"\nview = \"poles\"", "\"room\"");
    place.write("mid.toml", &first.replace("\"x\"", "\"hard-cases\""));
    let run = place.lightbench(&["run", "mid.toml", "--out", "out"]);
    assert_eq!(run.code, 4, "{}", run.err);
    let rows = place.rows("out");
    assert_eq!(rows.len(), 4);
    for row in rows {
        let status = row["status"].as_str().expect("text");
        match row["scene"].as_str() {
            Some("room") => assert!(
                status.starts_with("failed: ") && status.contains("floor.obj"),
                "{status}"
            ),
            _ => assert_eq!(status, "ok"),
        }
    }
    let gate = place.lightbench(&["gate", "out", "--junit", "gate.xml"]);
    let junit = fs::read_to_string(place.path().join("gate.xml")).expect("written");
    for text in [&gate.out, &junit] {
        assert!(text.contains("room IM seed 1: failed: "), "{text}");
        assert!(text.contains("floor.obj"), "{text}");
    }
    // Once it is mended, only its jobs are run.
    place.write("room/floor.obj", FLOOR);
    let mended = place.lightbench(&["run", "mid.toml", "--out", "out"]);
    assert_eq!(mended.code, 0, "{}", mended.err);
    assert!(
        mended.err.contains("2 jobs to run, 2 finished"),
        "{}",
        mended.err
    );
}

#[test]
fn merging_prefers_finished_rows_and_damages_no_part() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let arguments = ["run", "tiny.toml", "repeats=1", "--out"];
    for out in ["a", "b"] {
        assert_eq!(place.lightbench(&[&arguments[..], &[out]].concat()).code, 0);
    }
    let whole = place.rows("b");
    for row in &whole {
        let job = row["job"].as_str().expect("text");
        let file = place.path().join("a/jobs").join(job).join("row.json");
        let text = fs::read_to_string(&file).expect("row");
        fs::write(&file, text.replace("\"ok\"", "\"failed: no memory\"")).expect("writable");
    }
    let merged = place.lightbench(&["merge", "a", "b", "--out", "both"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert_eq!(place.rows("both"), whole);
    let into = place.lightbench(&["merge", "a", "b", "--out", "a"]);
    assert_eq!(into.code, 0, "{}", into.err);
    assert_eq!(place.rows("a"), whole);
    assert_eq!(place.lightbench(&["report", "a"]).code, 0);
    let text = fs::read_to_string(place.path().join("both/provenance.json")).expect("there");
    assert_eq!(text.matches("ray_kernel").count(), 1, "{text}");
}

#[test]
fn provenance_tells_what_the_environment_hid() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let arguments = ["run", "tiny.toml", "repeats=1", "--method", "IM", "--out"];
    let entries = |hidden: Option<&str>, out: &str| {
        let variable = hidden.map(|names| ("LIGHTBENCH_HIDE", names));
        let run = place.lightbench_with(variable, &[&arguments[..], &[out]].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        let file = place.path().join(out).join("provenance.json");
        let text = fs::read_to_string(file).expect("there");
        serde_json::from_str::<serde_json::Value>(&text).expect("json")["entries"].clone()
    };
    let plain = &entries(None, "plain")[0];
    assert!(plain["hidden_instruction_sets"].is_null(), "{plain}");
    let without = &entries(Some("avx512,avx2"), "without")[0];
    assert_eq!(without["ray_kernel"], "portable");
    let hidden = serde_json::json!(["avx512", "avx2"]);
    assert_eq!(without["hidden_instruction_sets"], hidden);
}

/// What Mitsuba knows and we leave out is no error, but nothing that may go unsaid.
#[test]
fn notes_of_a_loader_reach_the_terminal_rows_report_provenance_and_junit() {
    let place = Place::new();
    let scene = r#"<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="42"/>
<transform name="to_world"><lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film></sensor>
<shape type="sphere"><bsdf type="roughdiffuse"><boolean name="use_fast_approx" value="true"/></bsdf></shape>
</scene>"#;
    place.write("ball.xml", scene);
    let text = experiment("ambient-occlusion", "IM")
        .replace("name = \"room\"\n[[m", "name = \"ball.xml\"\n[[m");
    let text = text.replace("[[method]]", "[[method]]\nid = \"VGC\"\n[[method]]");
    let gate = "\n[[gate]]\ntext = \"bounded\"\nexpect = \"rmse(IM) < 9\"\n";
    place.write("ball.toml", &(text + gate));
    let run = place.lightbench(&["run", "ball.toml", "--out", "out"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(
        run.err.matches("`use_fast_approx`").count(),
        1,
        "once a scene: {}",
        run.err
    );
    for row in place.rows("out") {
        assert!(
            row["notes"].to_string().contains("`use_fast_approx`"),
            "{row}"
        );
    }
    let gated = place.lightbench(&["gate", "out", "--junit", "out/gate.xml"]);
    assert_eq!(gated.code, 0, "{}{}", gated.out, gated.err);
    for file in ["provenance.json", "report.html", "gate.xml"] {
        let text = fs::read_to_string(place.path().join("out").join(file)).expect("there");
        assert!(text.contains("use_fast_approx"), "{file}");
    }
    let output = place.lightbench(&["render", "ball.xml", "--json", "--out", "o.exr"]);
    assert!(output.err.contains("`use_fast_approx`") && output.out.contains("`use_fast_approx`"));
}

#[test]
fn a_folder_stays_that_of_its_experiment() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.write(
        "other.toml",
        &TINY.replace("name = \"tiny\"", "name = \"other\""),
    );
    for (config, out) in [("tiny.toml", "a"), ("other.toml", "b")] {
        let run = place.lightbench(&["run", config, "repeats=1", "--out", out]);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let before = place.rows("b");
    for into in [
        place.lightbench(&["merge", "a", "--out", "b"]),
        place.lightbench(&["run", "tiny.toml", "repeats=1", "--out", "b"]),
    ] {
        assert_eq!(into.code, 2, "{}", into.err);
        assert!(into.err.contains("`other`"), "{}", into.err);
    }
    assert_eq!(place.rows("b"), before);
    assert_eq!(place.lightbench(&["report", "b"]).code, 0);
}

#[test]
fn merging_into_a_folder_keeps_what_it_has_and_tells_of_other_results() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let arguments = ["run", "tiny.toml", "repeats=1", "--out"];
    let one = [&arguments[..], &["a", "--method", "IM"]].concat();
    assert_eq!(place.lightbench(&one).code, 0);
    assert_eq!(place.lightbench(&[&arguments[..], &["b"]].concat()).code, 0);
    let merged = place.lightbench(&["merge", "a", "--out", "b"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert!(!merged.err.contains("warning"), "{}", merged.err);
    assert_eq!(place.rows("b").len(), 2);
    let job = place.rows("a")[0]["job"].as_str().expect("text").to_owned();
    let file = place.path().join("a/jobs").join(job).join("row.json");
    let mut row: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&file).expect("row")).expect("json");
    row["rmse"] = 0.5.into();
    fs::write(&file, row.to_string()).expect("writable");
    let merged = place.lightbench(&["merge", "a", "b", "--out", "c"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert!(merged.err.contains("RMSE of 0.5 in a"), "{}", merged.err);
}

#[test]
fn merging_two_results_of_one_case_is_refused() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    for (caches, out) in [("caches=60", "a"), ("caches=30", "b")] {
        let arguments = ["run", "tiny.toml", "repeats=1", caches, "--out", out];
        assert_eq!(place.lightbench(&arguments).code, 0);
    }
    let merged = place.lightbench(&["merge", "a", "b", "--out", "both"]);
    assert_eq!(merged.code, 2, "{}", merged.err);
    for text in [
        "hard-cases (poles), ambient-occlusion, IM, seed 1 has two results",
        "(caches=60) in a and job",
        "(caches=30) in b",
    ] {
        assert!(merged.err.contains(text), "`{text}` in {}", merged.err);
    }
    assert!(!place.path().join("both").exists());
    let into = place.lightbench(&["merge", "a", "--out", "b"]);
    assert_eq!(into.code, 2, "{}", into.err);
}

#[test]
fn merging_leaves_out_what_failed_before_a_scene_was_mended() {
    let place = Place::new();
    write_room(&place, ROOM, Some("v 0 0 0\nv 1 0 0\nf 1 2 9\n"));
    let text = experiment("ambient-occlusion", "IM");
    place.write("ao.toml", &text);
    let broken = place.lightbench(&["run", "ao.toml", "--out", "broken"]);
    assert_eq!(broken.code, 4, "{}", broken.err);
    place.write("room/floor.obj", FLOOR);
    let gate = "[[gate]]\ntext = \"bounded\"\nexpect = \"rmse(IM) < 1\"\n";
    place.write("ao.toml", &format!("{text}{gate}"));
    let mended = place.lightbench(&["run", "ao.toml", "--out", "mended"]);
    assert_eq!(mended.code, 0, "{}", mended.err);
    let merged = place.lightbench(&["merge", "broken", "mended", "--out", "both"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    for text in [
        "the failed row of job",
        "in broken is left out",
        "gates of mended differ from those of broken, which are taken",
    ] {
        assert!(merged.err.contains(text), "`{text}` in {}", merged.err);
    }
    assert_eq!(place.rows("both"), place.rows("mended"));
}

#[test]
fn a_gate_does_not_pass_on_some_of_the_shards() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    for (shard, out) in [("1/2", "a"), ("2/2", "b")] {
        let run = place.lightbench(&["run", "tiny.toml", "--shard", shard, "--out", out]);
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let missing = |folder: &str| place.lightbench(&["gate", folder]);
    for folder in ["a", "b"] {
        let gate = missing(folder);
        assert!(matches!(gate.code, 10 | 12), "{}", gate.out);
        assert!(
            gate.out.contains("2 of 4 jobs without a result"),
            "{}",
            gate.out
        );
    }
    let half = place.lightbench(&["merge", "a", "--out", "half"]);
    assert!(half.err.contains("2 jobs are in shards"), "{}", half.err);
    assert!(missing("half").out.contains("2 of 4"));
    let whole = place.lightbench(&["merge", "b", "--out", "half"]);
    assert!(!whole.err.contains("shards"), "{}", whole.err);
    assert!(missing("half").out.contains("0 of 4"));
}

#[test]
fn files_of_others_are_not_replaced() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    fs::create_dir_all(place.path().join("mine")).expect("a folder");
    place.write("mine/config.json", "{\"mine\": 1}");
    let run = place.lightbench(&["run", "tiny.toml", "repeats=1", "--out", "mine"]);
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(
        run.err.contains("holds a `config.json` and no results"),
        "{}",
        run.err
    );
    let kept = fs::read_to_string(place.path().join("mine/config.json")).expect("there");
    assert_eq!(kept, "{\"mine\": 1}");
    assert!(!place.path().join("mine/jobs").exists());
    // Its own folder it takes again, whatever was removed from it.
    let own = ["run", "tiny.toml", "repeats=1", "--out", "own"];
    assert_eq!(place.lightbench(&own).code, 0);
    fs::remove_dir_all(place.path().join("own/jobs")).expect("there");
    assert_eq!(place.lightbench(&own).code, 0);
}

#[test]
fn experiments_of_different_techniques_are_not_merged() {
    let place = Place::new();
    let other = TINY
        .replace("\"ambient-occlusion\"", "\"direct-lighting\"")
        .replace("{ side = 8 }", "{ reference_passes = 4 }")
        .replace("caches = 60", "samples = 1")
        .replace("\"IM\"", "\"rt\"")
        .replace("\"VGC+DGS\"", "\"rt\"\nlabel = \"VGC+DGS\"")
        .replace("rmse(IM)", "rmse(rt)")
        .replace("repeats = 2", "repeats = 1");
    for (name, config) in [("a", TINY), ("b", &other)] {
        place.write("tiny.toml", config);
        let run = place.lightbench(&["run", "tiny.toml", "--out", name]);
        assert!([0, 10].contains(&run.code), "{}", run.err);
    }
    let merged = place.lightbench(&["merge", "a", "b", "--out", "both"]);
    assert_eq!(merged.code, 2, "{}", merged.err);
    assert!(
        merged.err.contains("ambient-occlusion and direct-lighting"),
        "{}",
        merged.err
    );
    assert!(!place.path().join("both").exists());
}
