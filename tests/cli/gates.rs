//! Gates on results that are not whole.

use std::fs;

use super::{Place, TINY};

#[test]
fn a_plan_half_of_whose_jobs_have_no_row_is_no_pass() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    assert_eq!(
        place.lightbench(&["run", "tiny.toml", "--out", "out"]).code,
        0
    );
    let whole = place.lightbench(&["gate", "out"]);
    assert_eq!(whole.code, 0, "{}{}", whole.out, whole.err);
    assert!(
        whole.out.contains("0 of 4 jobs without a result"),
        "{}",
        whole.out
    );
    // Every method keeps a row, but one seed is no data for a gate over two.
    for row in place.rows("out").iter().filter(|row| row["seed"] == 2) {
        let job = row["job"].as_str().expect("text");
        fs::remove_dir_all(place.path().join("out/jobs").join(job)).expect("removable");
    }
    let half = place.lightbench(&["gate", "out", "--junit", "gate.xml"]);
    assert_eq!(half.code, 12, "{}{}", half.out, half.err);
    assert!(
        half.out.contains("2 of 4 jobs without a result"),
        "{}",
        half.out
    );
    let junit = fs::read_to_string(place.path().join("gate.xml")).expect("written");
    assert!(junit.contains("2 of 4 jobs without a result"), "{junit}");
}

#[test]
fn a_method_that_lacks_a_swept_key_has_data_at_all_of_its_values() {
    let place = Place::new();
    let swept = format!("{TINY}[sweep]\n\"method.VGC+DGS.angle_deg\" = [15, 25]\n");
    place.write("tiny.toml", &swept);
    let ran = place.lightbench(&["run", "tiny.toml", "--out", "out"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert_eq!(place.rows("out").len(), 6);
    let table = fs::read_to_string(place.path().join("out/tables/errors.csv")).expect("written");
    for at in ["15", "25"] {
        let at = format!("method.VGC+DGS.angle_deg={at}");
        let of_im = table.lines().filter(|line| line.contains(&at));
        let of_im: Vec<&str> = of_im.filter(|line| line.contains(",IM,rmse,")).collect();
        assert_eq!(of_im.len(), 1, "{at}: {table}");
    }
    let gate = swept.replace("rmse(VGC+DGS) < 0.5", "rmse(VGC+DGS) - rmse(IM) < 0.5");
    place.write("tiny.toml", &gate);
    let run = place.lightbench(&["run", "tiny.toml", "--out", "out"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let gate = place.lightbench(&["gate", "out"]);
    assert_eq!(gate.code, 0, "{}{}", gate.out, gate.err);
    // What is divided by zero is told as that.
    let nothing = swept.replace(
        "rmse(VGC+DGS) < 0.5",
        "rmse(IM) / (rmse(IM) - rmse(IM)) < 5",
    );
    place.write("tiny.toml", &nothing);
    assert_eq!(
        place.lightbench(&["run", "tiny.toml", "--out", "out"]).code,
        0
    );
    let gate = place.lightbench(&["gate", "out"]);
    assert_eq!(gate.code, 12, "{}{}", gate.out, gate.err);
    assert!(gate.out.contains("no finite number"), "{}", gate.out);
}

#[test]
fn a_gate_on_a_selection_says_so() {
    let place = Place::new();
    let two = TINY.replace(
        "[[method]]\nid = \"IM\"",
        "[[scene]]\nname = \"table\"\n[[method]]\nid = \"IM\"",
    );
    place.write("tiny.toml", &two);
    let run = |more: &[&str]| {
        let run = ["run", "tiny.toml", "--out", "out"];
        assert_eq!(place.lightbench(&[&run, more].concat()).code, 0);
        place.lightbench(&["gate", "out"])
    };
    let some = run(&["--scene", "table"]);
    let told = format!("{}{}", some.out, some.err);
    assert!(
        told.contains("a selection: 4 of 8 jobs of the config"),
        "{told}"
    );
    // Selections that are merged to the whole are none.
    let other = [
        "run",
        "tiny.toml",
        "--scene",
        "hard-cases",
        "--out",
        "other",
    ];
    assert_eq!(place.lightbench(&other).code, 0);
    let merge = ["merge", "out", "other", "--out", "both"];
    assert_eq!(place.lightbench(&merge).code, 0);
    for whole in [place.lightbench(&["gate", "both"]), run(&[])] {
        assert_eq!(whole.code, 0, "{}", whole.err);
        assert!(!whole.err.contains("a selection"), "{}", whole.err);
    }
}

#[test]
fn a_run_is_found_by_its_name_below_results() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    assert_eq!(place.lightbench(&["run", "tiny.toml"]).code, 0);
    for verb in [
        &["gate", "tiny"][..],
        &["report", "tiny"],
        &["diff", "tiny", "results/tiny"],
    ] {
        let named = place.lightbench(verb);
        assert_eq!(named.code, 0, "{verb:?}: {}{}", named.out, named.err);
    }
    let other = place.lightbench(&["gate", "tine"]);
    assert_eq!(other.code, 2);
    assert!(other.err.contains("below results/"), "{}", other.err);
}

#[test]
fn diff_tells_what_failed_and_what_one_folder_alone_has() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let run = |arguments: &[&str]| {
        let run = place.lightbench(&[&["run", "tiny.toml"], arguments].concat());
        assert_eq!(run.code, 0, "{}", run.err);
    };
    run(&["--out", "both"]);
    run(&["--method", "IM", "--out", "one"]);
    let job = place.rows("one")[0]["job"]
        .as_str()
        .expect("text")
        .to_owned();
    let file = place.path().join("one/jobs").join(job).join("row.json");
    let text = fs::read_to_string(&file).expect("row");
    let mut row: serde_json::Value = serde_json::from_str(&text).expect("json");
    (row["status"], row["rays"], row["rmse"]) = ("failed: no memory".into(), 0.into(), ().into());
    fs::write(&file, row.to_string()).expect("writable");
    let diff = place.lightbench(&["diff", "both", "one"]);
    assert_eq!(diff.code, 0, "{}", diff.err);
    for said in [
        "IM\n  no data: 1 of 2 seeds failed after: no memory\n",
        "VGC+DGS\n  only in both\n",
        "1 contenders in common, 1 changed beyond noise or without data, 1 only in both\n",
    ] {
        assert!(diff.out.contains(said), "`{said}` in {}", diff.out);
    }
    assert!(!diff.out.contains("100.00 %"), "{}", diff.out);
}
