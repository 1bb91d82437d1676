//! Runs: the same results for any threads, kernels, shards and interruptions; suites, sweeps and single images.

use std::fs;

use super::{Place, TIMED, TINY};

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
fn a_budget_in_seconds_records_the_count_that_repeats_its_image() {
    let place = Place::new();
    place.write("timed.toml", TIMED);
    let run = place.lightbench(&["run", "timed.toml", "--out", "timed"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rows = place.rows("timed");
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert_eq!(row["budget"], "seconds=0.02");
        let count = row["params"]["affordable"].as_f64().expect("recorded");
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
fn a_budget_in_rays_is_spent_and_never_exceeded() {
    const SPENT: &str = r#"
name = "spent"
technique = "direct-lighting"
size = [24, 16]
rays_per_pixel = 11
parameters = { reference_passes = 4 }
sequence = { frames = 4, warm_up = 2 }
[[scene]]
name = "cornell-curved"
[[method]]
id = "rt"
rays = 2
[[method]]
id = "light-cones"
"#;
    let place = Place::new();
    place.write("spent.toml", SPENT);
    let run = place.lightbench(&["run", "spent.toml", "--out", "spent"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rays_per_pixel = |row: &serde_json::Value| {
        let rays =
            row["rays"].as_f64().expect("counted") + row["shadow_rays"].as_f64().unwrap_or(0.0);
        rays / f64::from(24 * 16 * 4)
    };
    for row in place.rows("spent") {
        let count = row["params"]["affordable"].as_f64().expect("recorded");
        assert!(row["search_rays"].as_u64().expect("counted") > 0);
        assert!(rays_per_pixel(&row) <= 11.0, "{row}");
        let method = row["method"].as_str().expect("text");
        let with = |samples: f64| {
            let counted = SPENT.replace("rays_per_pixel = 11", &format!("samples = {samples}"));
            place.write("counted.toml", &counted);
            let out = format!("{method}-{samples}");
            let run = place.lightbench(&["run", "counted.toml", "--method", method, "--out", &out]);
            assert_eq!(run.code, 0, "{}", run.err);
            place.rows(&out).remove(0)
        };
        let (same, more) = (with(count), with(count + 1.0));
        assert!(rays_per_pixel(&more) > 11.0, "{more}");
        for column in ["rmse", "flip_ldr", "rays", "shadow_rays"] {
            assert_eq!(same[column], row[column], "{method} {column}");
        }
    }
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

/// Parameters that references do not depend on differ between jobs that share a reference.
#[test]
fn swept_parameters_of_contenders_alone_are_those_of_each_job() {
    let place = Place::new();
    let config = "name = 'swept'\ntechnique = 'importance-caching'\nsize = [24, 14]\ncaches = 40\n\
                  parameters = { reference_passes = 4 }\n[sweep]\n'parameters.heuristic' = ['balance', 'alpha-max']\n\
                  [[scene]]\nname = 'cabinet-room'\n[[method]]\nid = 'IM'\n";
    place.write("swept.toml", config);
    let run = place.lightbench(&["run", "swept.toml", "--out", "swept"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let rows = place.rows("swept");
    assert_eq!(rows.len(), 2);
    assert_ne!(rows[0]["rmse"], rows[1]["rmse"]);
    let alone = "parameters.heuristic=alpha-max";
    let alone = place.lightbench(&["run", "swept.toml", alone, "--out", "alone"]);
    assert_eq!(alone.code, 0, "{}", alone.err);
    let alone = &place.rows("alone")[0];
    assert_eq!(alone["job"], rows[1]["job"]);
    for metric in ["rmse", "flip_ldr", "rays"] {
        assert_eq!(alone[metric], rows[1][metric], "{metric}");
    }
}

/// One moment has no frames before it.
#[test]
fn render_says_where_a_method_that_learns_from_frames_has_none() {
    let place = Place::new();
    let note = "running-mean learns from earlier frames";
    for (time, json, is_said) in [("0", "", false), ("1.5", "", true), ("1.5", "--json", true)] {
        let scene = ["render", "hard-cases", "--view", "poles", "--size", "16x9"];
        let method = ["--technique", "path-tracing", "--method", "running-mean"];
        let rest = ["--budget", "1", "--time", time, "--out", "o.png", json];
        let mut arguments = [&scene[..], &method, &rest].concat();
        arguments.retain(|argument| !argument.is_empty());
        let render = place.lightbench(&arguments);
        assert_eq!(render.code, 0, "{}", render.err);
        assert_eq!(render.err.contains(note), is_said, "{}", render.err);
        assert_eq!(
            render.out.contains(note),
            !json.is_empty(),
            "{}",
            render.out
        );
    }
    // `caches` renders too: 144 pixels have no 5,000 shading points.
    let scene = ["caches", "hard-cases", "--view", "poles", "--size", "16x9"];
    let rest = ["--method", "IM", "--budget", "5000", "--out", "o.csv"];
    let caches = place.lightbench(&[&scene[..], &rest].concat());
    assert_eq!(caches.code, 0, "{}", caches.err);
    assert!(
        caches.err.contains("records instead of 5000"),
        "{}",
        caches.err
    );
}
