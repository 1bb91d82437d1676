//! Sequences from outside: interrupted ones go on, and programs share references.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = r#"
metres_per_unit = 1
[[view]]
origin = [0, 1, 4]
target = [0, 0.5, 0]
fov_deg = 50
[[shape]]
kind = "cube"
name = "block"
[[shape]]
kind = "sphere"
name = "lamp"
centre = [2, 2, 2]
radius = 0.5
emission = 4
"#;

const CONFIG: &str = r#"
name = "moving"
technique = "path-tracing"
samples = 1
parameters = { reference_passes = 8 }
size = [48, 32]
[sequence]
path = "walk"
frames = "0..80..2"
fps = 20
warm_up = 2
[[path]]
name = "walk"
keys = [{ time = 0, view = "main" }, { time = 4, view = "main", move = [1, 0.5, 1] }]
[[motion]]
shape = "block"
keys = [{ time = 0, rotate_deg = 0 }, { time = 4, rotate_deg = 90 }]
[[scene]]
name = "room.toml"
[[method]]
id = "running-mean"
[[method]]
id = "paths"
"#;

fn start(place: &Path, out: &str) -> Child {
    start_with(place, out, &["moving.toml"])
}

/// A run that leaves a checkpoint after every frame.
fn start_with(place: &Path, out: &str, selection: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_lightbench"))
        .arg("run")
        .args(selection)
        .args(["--quiet", "--checkpoint", "0", "--out", out])
        .current_dir(place)
        .stdout(Stdio::null())
        .spawn()
        .expect("starts")
}

fn prepare() -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a folder");
    fs::write(place.path().join("room.toml"), SCENE).expect("writable");
    fs::write(place.path().join("moving.toml"), CONFIG).expect("writable");
    place
}

/// Rows and frames without times and memory.
fn results(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let rows = fs::read_to_string(folder.join("rows.jsonl")).expect("rows");
    for line in rows.lines() {
        let mut row: serde_json::Value = serde_json::from_str(line).expect("a row");
        for key in crate::MEASURED {
            row.as_object_mut().expect("a row").remove(*key);
        }
        let id = row["job"].as_str().expect("an id").to_owned();
        found.push(row.to_string());
        let frames = folder.join("jobs").join(&id).join("frames.csv");
        let mut reader = csv::Reader::from_path(frames).expect("frames");
        let names = reader.headers().expect("names").clone();
        for record in reader.records() {
            let record = record.expect("a line");
            let cells = names.iter().zip(&record);
            let kept = cells.filter(|(n, _)| !n.contains("seconds") && *n != "bytes_work");
            found.push(format!("{:?}", kept.collect::<Vec<_>>()));
        }
    }
    found
}

/// The lines of all tables of frames, by column.
fn frames(folder: &Path) -> Vec<HashMap<String, String>> {
    let jobs = fs::read_dir(folder.join("jobs")).expect("jobs");
    let tables = jobs.map(|job| job.expect("a job").path().join("frames.csv"));
    let lines = |table| {
        csv::Reader::from_path(table)
            .expect("frames")
            .into_deserialize()
    };
    let all = tables.flat_map(lines).map(|line| line.expect("a line"));
    all.collect()
}

/// `LIGHTBENCH_KILLS` sets how often, 4 by default.
#[test]
fn a_killed_sequence_goes_on_to_the_same_bits() {
    let place = prepare();
    let start_of_all = Instant::now();
    assert!(
        start(place.path(), "a/whole")
            .wait()
            .expect("ends")
            .success()
    );
    let took = start_of_all.elapsed();
    let expected = results(&place.path().join("a/whole"));
    assert_eq!(expected.len(), 2 + 2 * 40);
    let kills = std::env::var("LIGHTBENCH_KILLS").ok();
    let kills: usize = kills.and_then(|text| text.parse().ok()).unwrap_or(4);
    let mut alive = 0;
    for kill in 0..kills {
        // Spread over the whole run.
        let share = 0.05 + 0.9 * (0.5 + 0.618_034 * kill as f64).fract();
        let out = format!("kill{kill}/killed");
        let mut child = start(place.path(), &out);
        std::thread::sleep(took.mul_f64(share));
        if child.try_wait().expect("runs").is_none() {
            child.kill().expect("killed");
            alive += 1;
        }
        child.wait().expect("ends");
        assert!(start(place.path(), &out).wait().expect("ends").success());
        let folder = place.path().join(&out);
        assert_eq!(results(&folder), expected, "killed after {share} of a run");
        let left = fs::read_dir(folder.join("jobs")).expect("jobs");
        let left = left.map(|entry| entry.expect("an entry").file_name().into_string());
        for name in left {
            let name = name.expect("text");
            assert!(!name.starts_with('.'), "{name} is left");
            let job = folder.join("jobs").join(name);
            assert!(!job.join("checkpoint.bin").exists());
        }
    }
    assert!(alive > 0, "it was never at work");
}

/// Each is killed as soon as it has a checkpoint: what it goes on with has moved since the first frame.
#[test]
fn caches_of_a_moving_scene_go_on_to_the_same_bits() {
    let place = prepare();
    let rest = CONFIG.split("[[method]]").next().expect("the rest");
    for (technique, method) in [
        ("radiance", "hash-cache"),
        ("radiance", "sharc"),
        ("direct-lighting", "light-cones"),
    ] {
        let config = rest.replace("path-tracing", technique);
        let config = format!("{config}[[method]]\nid = \"{method}\"\n");
        fs::write(place.path().join("caches.toml"), config).expect("writable");
        let start = |out: &str| start_with(place.path(), out, &["caches.toml", "--method", method]);
        let whole = format!("{method}/whole");
        assert!(start(&whole).wait().expect("ends").success());
        let killed = format!("{method}/killed");
        let mut child = start(&killed);
        let jobs = place.path().join(&killed).join("jobs");
        let has_checkpoint = || {
            let mut all = fs::read_dir(&jobs).into_iter().flatten().flatten();
            all.any(|entry| entry.path().join("checkpoint.bin").exists())
        };
        while !has_checkpoint() {
            let ended = child.try_wait().expect("runs");
            assert!(ended.is_none(), "{method} left no checkpoint");
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().expect("killed");
        child.wait().expect("ends");
        assert!(has_checkpoint(), "{method} was done before it was killed");
        assert!(start(&killed).wait().expect("ends").success(), "{method}");
        let [whole, killed] = [whole, killed].map(|out| results(&place.path().join(out)));
        assert_eq!(killed, whole, "{method}");
        for frame in frames(&place.path().join(format!("{method}/whole"))) {
            // What was kept before is neither work nor taken from it.
            assert_ne!(frame["bytes_work"], "0", "{method}: {frame:?}");
        }
    }
}

/// Both want each of the 38 references; a lock lets one render it while the other waits.
#[test]
fn two_programs_render_a_reference_once() {
    let place = prepare();
    let started = Instant::now();
    let mut both = [start(place.path(), "c/one"), start(place.path(), "c/two")];
    let mut written: std::collections::BTreeMap<String, std::collections::BTreeSet<_>> =
        Default::default();
    let references = place.path().join("c/references");
    while both
        .iter_mut()
        .any(|child| child.try_wait().expect("runs").is_none())
    {
        for entry in fs::read_dir(&references).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if let (true, Ok(metadata)) = (name.ends_with(".exr"), entry.metadata()) {
                let modified = metadata.modified().expect("a time");
                written.entry(name).or_default().insert(modified);
            }
        }
        assert!(started.elapsed() < Duration::from_secs(600), "stuck");
        std::thread::sleep(Duration::from_millis(2));
    }
    for child in &mut both {
        assert!(child.wait().expect("ends").success());
    }
    assert_eq!(written.len(), 38);
    for (name, times) in written {
        // Eight passes take less than the half minute after which an unfinished one is stored.
        assert_eq!(times.len(), 1, "{name} was written again");
    }
    let [one, two] = ["c/one", "c/two"].map(|out| results(&place.path().join(out)));
    assert_eq!(one, two);
    let locks = fs::read_dir(references).expect("there").flatten();
    let locks = locks.filter(|entry| entry.path().extension().is_some_and(|e| e == "lock"));
    assert_eq!(locks.count(), 0);
}

#[test]
fn wrong_sequences_are_refused_with_their_place_before_anything_is_written() {
    let place = prepare();
    let with = |from: &str, to: &str| {
        assert!(CONFIG.contains(from), "{from}");
        CONFIG.replace(from, to)
    };
    for (config, at, expected) in [
        (
            with("path = \"walk\"", "path = \"wolk\""),
            "moving.toml:8:1:",
            "no path `wolk`; did you mean `walk`? it has: walk",
        ),
        (
            with(
                "{ time = 4, view = \"main\", move",
                "{ time = 0, view = \"main\", move",
            ),
            "moving.toml:14:",
            "must ascend",
        ),
        (
            with(
                "{ time = 0, view = \"main\" }",
                "{ time = nan, view = \"main\" }",
            ),
            "moving.toml:14:11:",
            "finite numbers",
        ),
        (
            with("view = \"main\" }, ", "view = \"mein\" }, "),
            "moving.toml:14:28:",
            "did you mean `main`",
        ),
        (
            with("shape = \"block\"", "shape = \"black\""),
            "moving.toml:16:9:",
            "did you mean `block`",
        ),
        (
            with(
                "{ time = 0, rotate_deg = 0 }",
                "{ time = 4, rotate_deg = 0 }",
            ),
            "moving.toml:17:",
            "must ascend",
        ),
        (
            with("\"0..80..2\"", "\"0-80\""),
            "moving.toml:9:1:",
            "from..to",
        ),
        (
            with("fps = 20", "fps = 0"),
            "moving.toml:10:1:",
            "a number above 0",
        ),
        (
            with("warm_up = 2", "warm_up = 40"),
            "moving.toml:11:1:",
            "leave none",
        ),
        (
            with("warm_up = 2", "warmup = 2"),
            "moving.toml:11:1:",
            "unknown field `warmup`",
        ),
    ] {
        is_refused(place.path(), &config, [at, expected]);
    }
}

#[test]
fn what_a_config_adds_is_not_overridden() {
    let place = prepare();
    let output = Command::new(env!("CARGO_BIN_EXE_lightbench"))
        .args([
            "run",
            "moving.toml",
            "motion.0.shape=lamp",
            "--out",
            "x/moving",
        ])
        .current_dir(place.path())
        .output()
        .expect("runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("changed in its file only"), "{said}");
}

/// The map is that of the config, for all scenes or for one; the scene has none itself.
#[test]
fn a_motion_turns_the_environment_that_a_config_chooses() {
    let place = prepare();
    let turn = "[[motion]]\nenvironment = true\nkeys = [{ time = 0, rotate_deg = 0 }, { time = 4, rotate_deg = 180 }]\n";
    let still = format!("{turn}[[scene]]").replace("180", "0");
    let turn = format!("{turn}[[scene]]");
    let chosen = "environment = \"afternoon\"\n";
    let run = |name: &str, config: String| {
        let config = config
            .replace("\"0..80..2\"", "[0, 80]")
            .replace("warm_up = 2\n", "");
        fs::write(place.path().join("moving.toml"), config).expect("writable");
        let out = format!("{name}/moving");
        let ended = start(place.path(), &out).wait().expect("ends");
        (ended.code(), place.path().join(out))
    };
    let (code, _) = run("none", CONFIG.replace("[[scene]]", &turn));
    assert_eq!(code, Some(2), "nothing turns");
    let for_all = CONFIG.replacen("[sequence]", &format!("{chosen}[sequence]"), 1);
    let for_one = CONFIG.replace("\"room.toml\"\n", &format!("\"room.toml\"\n{chosen}"));
    let errors = [
        ("still", for_all.replace("[[scene]]", &still)),
        ("all", for_all.replace("[[scene]]", &turn)),
        ("one", for_one.replace("[[scene]]", &turn)),
    ]
    .map(|(name, config)| {
        let (code, folder) = run(name, config);
        assert_eq!(code, Some(0), "{name}");
        let rows = fs::read_to_string(folder.join("rows.jsonl")).expect("rows");
        let row = |line: &str| serde_json::from_str::<serde_json::Value>(line).expect("a row");
        let errors = rows.lines().map(|line| row(line)["rmse"].to_string());
        errors.collect::<Vec<String>>()
    });
    assert_eq!(errors[1], errors[2]);
    assert!(errors[0] != errors[1] && errors[0].len() == 2, "{errors:?}");
}

/// Runs a config in a folder: exit code 2, what is expected is told, and nothing is written.
fn is_refused(folder: &Path, config: &str, expected: [&str; 2]) {
    fs::write(folder.join("moving.toml"), config).expect("writable");
    let output = Command::new(env!("CARGO_BIN_EXE_lightbench"))
        .args(["run", "moving.toml", "--out", "x/moving"])
        .current_dir(folder)
        .output()
        .expect("runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let told = expected.iter().all(|part| said.contains(part));
    assert!(told, "{said} ({expected:?})");
    assert!(!folder.join("x").exists(), "nothing is written");
}

/// A path of a scene that no viewer would follow: the scene would give the same numbers as the one before it.
#[test]
fn a_path_beside_viewers_is_refused_at_its_place() {
    let place = prepare();
    let other = "name = \"room.toml\"\n[[scene]]\nname = \"room.toml\"\nlabel = \"other\"\npath = \"walk\"\n";
    let config = CONFIG
        .replace("path = \"walk\"\nframes", "viewers = { count = 1 }\nframes")
        .replace("name = \"room.toml\"\n", other);
    for (text, at) in [
        (config, "moving.toml:23:1:"),
        (
            CONFIG.replace("fps = 20", "fps = 20\nviewers = [\"walk\"]"),
            "moving.toml:8:1:",
        ),
    ] {
        is_refused(place.path(), &text, [at, "`walk` would not be followed"]);
    }
}
