//! The program from outside: exit codes, messages, resume, shards, determinism.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use assert_cmd::Command;

#[path = "cli/damage.rs"]
mod damage;
#[path = "cli/folders.rs"]
mod folders;
#[path = "cli/gates.rs"]
mod gates;
#[cfg(unix)]
#[path = "cli/many.rs"]
mod many;
#[path = "cli/planning.rs"]
mod planning;
#[path = "cli/sequences.rs"]
mod sequences;
#[path = "cli/starting.rs"]
mod starting;

/// A small experiment on a scene of primitives, a second or two in a debug build.
/// What differs from run to run: times, and memory as the allocator sees it.
const MEASURED: &[&str] = &[
    "seconds",
    "seconds_total",
    "cpu_seconds",
    "cpu_seconds_total",
    "serial_share",
    "bytes_scene",
    "bytes_work",
];

const TINY: &str = r#"
name = "tiny"
technique = "ambient-occlusion"
parameters = { side = 8 }
caches = 60
size = [48, 27]
repeats = 2

[[scene]]
name = "hard-cases"
view = "poles"

[[method]]
id = "IM"
[[method]]
id = "VGC+DGS"

[[table]]
name = "errors"

[[claim]]
text = "clustering helps"
where = "nowhere"
expect = "rmse(VGC+DGS) < rmse(IM)"

[[gate]]
text = "bounded"
expect = "rmse(VGC+DGS) < 0.5"
"#;

/// A small experiment under a map, every image of the same time.
const TIMED: &str = r#"
name = "timed"
technique = "environment-lighting"
parameters = { reference_samples = 8, reference_passes = 2 }
seconds = 0.02
size = [24, 18]
environment = "living-room"

[[scene]]
name = "still-puzzle"

[[method]]
id = "mis"
[[method]]
id = "decomposition"
"#;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, text).expect("writable");
        path
    }

    fn lightbench(&self, arguments: &[&str]) -> Output {
        self.lightbench_by(None, arguments)
    }

    /// With a ray kernel of choice.
    fn lightbench_by(&self, kernel: Option<&str>, arguments: &[&str]) -> Output {
        let kernel = kernel.map(|name| ("LIGHTBENCH_KERNEL", name));
        self.lightbench_with(kernel, arguments)
    }

    /// With a variable of the environment.
    fn lightbench_with(&self, variable: Option<(&str, &str)>, arguments: &[&str]) -> Output {
        let output = Command::cargo_bin("lightbench")
            .expect("built")
            .current_dir(self.path())
            .env_remove("LIGHTBENCH_SCENES")
            .env_remove("LIGHTBENCH_KERNEL")
            .env_remove("LIGHTBENCH_HIDE")
            .envs(variable)
            .args(arguments)
            .output()
            .expect("runs");
        Output {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Job folder name → bytes of its image.
    fn images(&self, results: &str) -> BTreeMap<String, Vec<u8>> {
        fs::read_dir(self.path().join(results).join("jobs"))
            .expect("jobs")
            .map(|entry| entry.expect("entry").path())
            .map(|path| {
                let name = path
                    .file_name()
                    .expect("name")
                    .to_string_lossy()
                    .into_owned();
                (name, fs::read(path.join("image.exr")).expect("image"))
            })
            .collect()
    }

    /// The rows without what depends on the machine's speed.
    fn rows(&self, results: &str) -> Vec<serde_json::Value> {
        let text = fs::read_to_string(self.path().join(results).join("rows.jsonl")).expect("rows");
        text.lines()
            .map(|line| {
                let mut row: serde_json::Value = serde_json::from_str(line).expect("json");
                for measured in MEASURED {
                    row[*measured] = serde_json::Value::Null;
                }
                row
            })
            .collect()
    }
}

struct Output {
    code: i32,
    out: String,
    err: String,
}

fn repository(path: &str) -> String {
    format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))
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
fn a_suite_runs_its_experiments_and_collects_their_claims() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    place.write("other.toml", &TINY.replace("\"tiny\"", "\"other\""));
    let suite = "name = 'both'\nset = ['repeats=1']\n[[include]]\nconfig = 'tiny.toml'\n\
                 [[include]]\nconfig = 'other.toml'\nset = ['caches=30']\n";
    let suite = place.write("both.toml", suite).display().to_string();
    let out = place.path().join("out").display().to_string();
    let first = place.lightbench(&["run", &suite, "--out", &out]);
    assert_eq!(first.code, 0, "{}", first.err);
    let page = fs::read_to_string(place.path().join("out/report.html")).expect("page");
    assert!(page.matches("clustering helps").count() == 2, "{page}");
    for (experiment, caches) in [("tiny", 60), ("other", 30)] {
        let rows = place.path().join("out").join(experiment).join("rows.jsonl");
        let rows = fs::read_to_string(rows).expect("rows");
        assert_eq!(rows.lines().count(), 2, "{experiment}");
        assert!(rows.contains(&format!("caches={caches}")), "{rows}");
    }
    let again = place.lightbench(&["run", &suite, "--out", &out]);
    assert!(again.err.contains("2 finished earlier"), "{}", again.err);
    let missing = place.write(
        "broken.toml",
        "name = 'b'\ninclude = [{ config = 'none.toml' }]\n",
    );
    let refused = place.lightbench(&["run", &missing.display().to_string()]);
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(refused.err.contains("none.toml"), "{}", refused.err);
}

#[test]
fn wrong_configs_are_refused_with_their_place_and_nothing_is_written() {
    let cases = [
        ("name = \"x\"\ntechnique = ", "bad.toml:2:"),
        (
            &TINY.replace("caches = 60", "cashes = 60"),
            "bad.toml:5:1: unknown field `cashes`",
        ),
        (&TINY.replace("ambient-occlusion", "ambient"), "bad.toml:3:"),
        (
            &TINY.replace("hard-cases", "no-such-scene"),
            "no-such-scene",
        ),
        (
            &TINY.replace("id = \"IM\"", "id = \"XY\""),
            "no distribution is called `XY`",
        ),
        (
            &TINY.replace("id = \"IM\"", "id = \"IM\"\nsigma = 3"),
            "bad.toml:15:1: unknown parameter `sigma`",
        ),
        (
            &TINY.replace("view = \"poles\"", "view = \"attic\""),
            "it has: poles",
        ),
        (
            &TINY.replace("side = 8", "side = 0"),
            "side = 0: expected a whole number from 1 to 256",
        ),
        (
            &TINY.replace("side = 8", "side = 8, distance = inf"),
            "distance: expected finite numbers, found inf",
        ),
        (&TINY.replace("rmse(IM)", "rmse(IM"), "expected `)`"),
        (
            &TINY.replace("< rmse(IM)", "< rmse(XX)"),
            "no method is called `XX`",
        ),
        (
            &TINY.replace("rmse(VGC+DGS) < 0.5", "rmsx(VGC+DGS) < 0.5"),
            "rmsx",
        ),
        (
            &TINY.replace("\"tiny\"", "\"../../tiny\""),
            "bad.toml:2:1: name: expected the name of one folder",
        ),
        (
            &TINY.replace("[48, 27]", "[48, 27, 3]"),
            "bad.toml:6:8: expected 2 values, found 3",
        ),
        (
            &format!("{TINY}[sweep]\ncaches = []\n"),
            "`caches` is swept over no value",
        ),
        (&TINY.replace("\"tiny\"", "\"..\""), "bad.toml:2:1: name"),
        (&TINY.replace("\"tiny\"", "\"\""), "bad.toml:2:1: name"),
        (
            &TINY.replace("\"errors\"", "\"a/errors\""),
            "name: expected the name of one folder",
        ),
        (
            &TINY.replace("repeats = 2", "repeats = 4000000000"),
            "make 8000000000 jobs; 1000000 at most",
        ),
    ];
    for (text, expected) in cases {
        let place = Place::new();
        place.write("bad.toml", text);
        let output = place.lightbench(&["run", "bad.toml"]);
        assert_eq!(output.code, 2, "{expected}: {}", output.err);
        assert!(
            output.err.contains(expected),
            "expected `{expected}` in: {}",
            output.err
        );
        assert!(!place.path().join("results").exists(), "{expected}");
    }
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
fn wrong_budgets_are_refused_with_their_key_and_what_is_expected() {
    let place = Place::new();
    let scene = "name = \"still-puzzle\"";
    let number = "seconds: expected a number above 0 and up to 86400";
    for (text, expected) in [
        (TIMED.replace("0.02", "0"), number),
        (TIMED.replace("0.02", "-1.5"), number),
        (
            TIMED.replace("0.02", "inf"),
            "seconds: expected finite numbers, found inf",
        ),
        (TIMED.replace("0.02", "\"long\""), "bad.toml:5:"),
        (
            TIMED.replace("0.02", "0.02\nlights = 4"),
            "two budgets, `lights` and `seconds`: expected one of them",
        ),
        (
            TIMED.replace(scene, &format!("{scene}\nlights = 4")),
            "two budgets",
        ),
        (
            TIMED.replace("seconds = 0.02", "caches = 4"),
            "takes `lights` or `seconds`, not `caches`",
        ),
        (
            TINY.replace("caches = 60", "seconds = 1.0"),
            "takes `caches`, not `seconds`",
        ),
        (TIMED.replace("seconds = 0.02", ""), "set `lights`"),
    ] {
        place.write("bad.toml", &text);
        let output = place.lightbench(&["plan", "bad.toml"]);
        assert_eq!(output.code, 2, "{expected}: {}", output.err);
        assert!(output.err.contains(expected), "{expected}: {}", output.err);
    }
}

#[test]
fn a_budget_in_seconds_records_the_count_that_repeats_its_image() {
    let place = Place::new();
    place.write("timed.toml", TIMED);
    let run = place.lightbench(&["run", "timed.toml", "--out", "timed"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rows = place.rows("timed");
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_eq!(row["budget"], "seconds=0.02");
        let count = row["params"]["lights_in_time"].as_f64().expect("recorded");
        assert!(count >= 1.0 && count.fract() == 0.0);
        let method = row["method"].as_str().expect("text");
        let counted = TIMED.replace("seconds = 0.02", &format!("lights = {count}"));
        place.write("counted.toml", &counted);
        let arguments = ["run", "counted.toml", "--method", method, "--out", method];
        let again = place.lightbench(&arguments);
        assert_eq!(again.code, 0, "{}", again.err);
        let repeated = &place.rows(method)[0];
        assert_eq!(repeated["lights"], row["lights"]);
        for metric in ["rmse", "flip_ldr"] {
            assert_eq!(repeated[metric], row[metric], "{method} {metric}");
        }
        let job = format!("timed/jobs/{}", row["job"].as_str().expect("text"));
        let pixel = place.lightbench(&["replay", &job, "--pixel", "12,14"]);
        assert_eq!(pixel.code, 0, "{}", pixel.err);
    }
}

#[test]
fn wrong_overrides_and_selections_are_refused() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    for (arguments, code, expected) in [
        (vec!["run", "tiny.toml", "caches=many"], 2, "caches"),
        (
            vec!["run", "tiny.toml", "method.XX.a=1"],
            2,
            "no method is called `XX`",
        ),
        (vec!["run", "tiny.toml", "--shard", "3/2"], 2, "K/N"),
        (vec!["run", "absent.toml"], 2, "absent.toml"),
        (
            vec!["run", "tiny.toml", "--scene", "moon*"],
            3,
            "scenes are ",
        ),
        (
            vec!["render", "hard-cases", "--out", "x.gif"],
            2,
            ".exr or .png",
        ),
        (vec!["render", "nowhere", "--out", "x.exr"], 2, "nowhere"),
        (
            vec![
                "render",
                "hard-cases",
                "--method",
                "reference",
                "--set",
                "sid=8",
                "--out",
                "x.exr",
            ],
            2,
            "no such parameter",
        ),
        (vec!["report", "."], 2, "plan.json"),
        (vec!["explain", "distributions/XX"], 2, "no entry"),
        (vec!["explain", "VGC+XX"], 2, "no entry"),
    ] {
        let output = place.lightbench(&arguments);
        assert_eq!(output.code, code, "{arguments:?}: {}", output.err);
        assert!(
            output.err.contains(expected),
            "{arguments:?}: {}",
            output.err
        );
    }
    assert!(!place.path().join("results").exists());
}

#[test]
fn results_do_not_depend_on_threads_or_on_interruption() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let one = place.lightbench(&["run", "tiny.toml", "--threads", "1", "--out", "a/tiny"]);
    assert_eq!(one.code, 0, "{}", one.err);
    let two = place.lightbench(&["run", "tiny.toml", "--threads", "2", "--out", "b/tiny"]);
    assert_eq!(two.code, 0, "{}", two.err);
    assert_eq!(place.rows("a/tiny"), place.rows("b/tiny"));
    assert_eq!(place.images("a/tiny"), place.images("b/tiny"));

    // As after a kill: one job gone, one unfinished, the rest in place.
    let jobs = place.path().join("b/tiny/jobs");
    let first = fs::read_dir(&jobs)
        .expect("jobs")
        .next()
        .expect("one")
        .expect("entry")
        .path();
    fs::remove_dir_all(&first).expect("removable");
    fs::create_dir(jobs.join(".unfinished-xyz")).expect("writable");
    let again = place.lightbench(&["run", "tiny.toml", "--out", "b/tiny"]);
    assert_eq!(again.code, 0);
    assert!(
        again
            .err
            .contains("1 jobs to run, 3 finished earlier and kept"),
        "{}",
        again.err
    );
    assert_eq!(place.rows("a/tiny"), place.rows("b/tiny"));
    assert_eq!(place.images("a/tiny"), place.images("b/tiny"));
    let nothing_left = place.lightbench(&["run", "tiny.toml", "--out", "b/tiny"]);
    assert!(
        nothing_left.err.contains("0 jobs to run, 4 finished"),
        "{}",
        nothing_left.err
    );
}

/// Kernels round triangles differently, so that a ray near an edge may differ; errors do not.
#[test]
fn ray_kernels_give_the_same_table_and_are_named() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let refused = place.lightbench_by(Some("fast"), &["plan", "tiny.toml"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused
            .err
            .contains("expected wide, watertight or one of wide-avx512"),
        "{}",
        refused.err
    );
    let mut errors: Vec<(&str, Vec<f64>)> = Vec::new();
    for kernel in lightbench::trace::Kernel::ALL {
        if !kernel.is_available() {
            continue;
        }
        let name = kernel.name();
        let out = format!("by-{name}");
        let run = place.lightbench_by(Some(name), &["run", "tiny.toml", "--quiet", "--out", &out]);
        assert_eq!(run.code, 0, "{}", run.err);
        let file = place.path().join(&out).join("provenance.json");
        let provenance = fs::read_to_string(file).expect("provenance");
        assert!(provenance.contains(name), "{provenance}");
        let rmse = |row: &serde_json::Value| row["rmse"].as_f64().expect("rmse");
        errors.push((name, place.rows(&out).iter().map(rmse).collect()));
    }
    let (first, expected) = &errors[0];
    for (other, found) in &errors[1..] {
        // Registers of any width answer alike; another test may round otherwise.
        let alike = first.split('-').next() == other.split('-').next();
        let tolerance = if alike { 0.0 } else { 1e-4 };
        for (a, b) in expected.iter().zip(found) {
            assert!((a - b).abs() <= tolerance * a, "{errors:?}");
        }
    }
}

/// A reader that goes early, as `head` does, ends neither the command nor its exit code in a panic.
#[test]
fn a_closed_pipe_is_no_error() {
    let program = assert_cmd::cargo::cargo_bin("lightbench");
    for arguments in [
        &["explain", "all"][..],
        &["list"],
        &["man"],
        &["completions", "bash"],
    ] {
        let mut child = std::process::Command::new(&program)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            (output.status.code(), errors.as_ref()),
            (Some(0), ""),
            "{arguments:?}"
        );
    }
}

#[test]
fn shards_unite_to_the_whole_and_gates_decide() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    assert_eq!(
        place
            .lightbench(&["run", "tiny.toml", "--out", "whole/tiny"])
            .code,
        0
    );
    for k in ["1/2", "2/2"] {
        let out = format!("part{}/tiny", &k[..1]);
        let output = place.lightbench(&["run", "tiny.toml", "--shard", k, "--out", &out]);
        assert_eq!(output.code, 0, "{}", output.err);
    }
    let merged = place.lightbench(&["merge", "part1/tiny", "part2/tiny", "--out", "union/tiny"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    let sorted = |results| {
        let mut rows: Vec<String> = place.rows(results).iter().map(|r| r.to_string()).collect();
        rows.sort();
        rows
    };
    assert_eq!(sorted("whole/tiny"), sorted("union/tiny"));
    let diff = place.lightbench(&["diff", "whole/tiny", "union/tiny"]);
    assert!(diff.out.contains("2 contenders in common"), "{}", diff.out);

    let gate = place.lightbench(&["gate", "whole/tiny", "--junit", "gate.xml"]);
    assert_eq!(gate.code, 0, "{}{}", gate.out, gate.err);
    let junit = fs::read_to_string(place.path().join("gate.xml")).expect("written");
    assert!(junit.contains("tests=\"1\" failures=\"0\""), "{junit}");
    let strict = TINY
        .replace("< 0.5", "< 0.0001")
        .replace("repeats = 2", "repeats = 4");
    place.write("strict.toml", &strict);
    assert_eq!(
        place
            .lightbench(&["run", "strict.toml", "--out", "strict/tiny"])
            .code,
        0
    );
    assert_eq!(place.lightbench(&["gate", "strict/tiny"]).code, 10);
    let part = place.lightbench(&["run", "tiny.toml", "--method", "IM", "--out", "im/tiny"]);
    assert_eq!(part.code, 0);
    assert_eq!(place.lightbench(&["gate", "im/tiny"]).code, 12);
}

#[test]
fn sweeps_cross_and_single_images_can_be_made() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let plan = place.lightbench(&[
        "plan",
        "tiny.toml",
        "caches=20..60..20",
        "spp=1,4",
        "--json",
    ]);
    assert_eq!(plan.code, 0, "{}", plan.err);
    let plan: serde_json::Value = serde_json::from_str(&plan.out).expect("json");
    assert_eq!(plan["jobs"].as_array().expect("jobs").len(), 2 * 2 * 3 * 2);

    let common = [
        "hard-cases",
        "--size",
        "48x27",
        "--budget",
        "50",
        "--set",
        "side=8",
        "--method",
        "VGC+DGS",
    ];
    let mut caches = vec!["caches"];
    caches.extend(common);
    caches.extend(["--out", "records.csv"]);
    let output = place.lightbench(&caches);
    assert_eq!(output.code, 0, "{}", output.err);
    let csv = fs::read_to_string(place.path().join("records.csv")).expect("written");
    assert_eq!(csv.lines().next(), Some("x,y,z,nx,ny,nz,px,py,stage"));
    assert_eq!(csv.lines().count(), 51);

    let mut render = vec!["render"];
    render.extend(common);
    render.extend(["--out", "image.exr", "--json"]);
    let output = place.lightbench(&render);
    assert_eq!(output.code, 0, "{}", output.err);
    let record: serde_json::Value = serde_json::from_str(&output.out).expect("json");
    assert_eq!(record["caches"], 50);
    let exact = [
        "render",
        "hard-cases",
        "--size",
        "48x27",
        "--set",
        "side=8",
        "--method",
        "reference",
        "--out",
        "exact.exr",
    ];
    assert_eq!(place.lightbench(&exact).code, 0);
    let compared = place.lightbench(&["compare", "exact.exr", "image.exr", "--json"]);
    assert_eq!(compared.code, 0, "{}", compared.err);
    let metrics: serde_json::Value = serde_json::from_str(&compared.out).expect("json");
    for key in [
        "rmse",
        "relmse",
        "psnr",
        "ssim",
        "ms_ssim",
        "flip_ldr",
        "flip_hdr",
        "flip_start_exposure",
        "flip_stop_exposure",
        "non_finite",
    ] {
        assert!(metrics.get(key).is_some(), "{key}");
    }
    assert!(metrics["rmse"].as_f64().is_some_and(|e| e > 0.0 && e < 0.5));
    place.write("broken.exr", "not an image");
    let broken = place.lightbench(&["compare", "exact.exr", "broken.exr"]);
    assert_eq!(broken.code, 2);
    assert!(broken.err.contains("broken.exr"), "{}", broken.err);
}

#[test]
fn every_entry_explains_itself() {
    let place = Place::new();
    let list = place.lightbench(&["list"]);
    assert_eq!(list.code, 0);
    for name in [
        "ambient-occlusion",
        "IM",
        "SD",
        "VGC",
        "AS",
        "DGS",
        "statues",
        "atrium",
    ] {
        assert!(list.out.contains(name), "{name} in {}", list.out);
    }
    let pages = place.lightbench(&["explain", "all"]);
    assert_eq!(pages.code, 0);
    assert!(pages.out.matches("Source:").count() >= 6);
    let composed = place.lightbench(&["explain", "VGC+DGS"]);
    assert_eq!(
        composed.out.matches("Source:").count(),
        2,
        "{}",
        composed.err
    );
    assert_eq!(place.lightbench(&["completions", "bash"]).code, 0);
    assert_eq!(place.lightbench(&["man"]).code, 0);
}

/// `lightbench explain all > docs/methods.md` makes the page again.
#[test]
fn the_page_of_methods_is_up_to_date() {
    let pages = Place::new().lightbench(&["explain", "all"]);
    let written = fs::read_to_string(repository("docs/methods.md")).expect("docs/methods.md");
    assert!(
        pages.out == written,
        "run: lightbench explain all > docs/methods.md"
    );
}
