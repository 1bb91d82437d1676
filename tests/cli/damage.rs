//! Folders and files that are damaged, and names that would damage others.

use std::fs;
use std::path::{Path, PathBuf};

use super::{Output, Place, TINY};

/// A finished run, and the file of its only reference.
fn finished() -> (Place, PathBuf) {
    let place = Place::new();
    place.write("tiny.toml", &TINY.replace("repeats = 2", "repeats = 1"));
    let run = place.lightbench(&["run", "tiny.toml"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let store = fs::read_dir(place.path().join("results/references"));
    let mut files = store.expect("a store").map(|e| e.expect("entry").path());
    let reference = files.find(|f| f.extension().is_some_and(|e| e == "exr"));
    (place, reference.expect("a reference"))
}

fn flip_a_bit(file: &Path) {
    let mut bytes = fs::read(file).expect("readable");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    fs::write(file, bytes).expect("writable");
}

fn names(file: &Path, output: &Output) {
    let name = file.file_name().expect("a name").to_string_lossy();
    let all = format!("{}{}", output.out, output.err);
    assert!(all.contains(&*name), "{name} in: {all}");
}

#[test]
fn a_damaged_reference_is_told_set_aside_and_rendered_again() {
    let (place, reference) = finished();
    let rows = place.rows("results/tiny");
    assert_eq!(place.lightbench(&["ref", "status"]).code, 0);
    flip_a_bit(&reference);
    let status = place.lightbench(&["ref", "status"]);
    assert_eq!(status.code, 2, "{}", status.out);
    assert!(status.out.contains("damaged"), "{}", status.out);
    names(&reference, &status);
    let report = place.lightbench(&["report", "tiny"]);
    assert_eq!(report.code, 0, "{}", report.err);
    assert!(
        report.out.contains("a reference is damaged"),
        "{}",
        report.out
    );
    names(&reference, &report);
    fs::remove_dir_all(place.path().join("results/tiny/jobs")).expect("removable");
    let again = place.lightbench(&["run", "tiny.toml"]);
    assert_eq!(again.code, 0, "{}", again.err);
    assert!(again.err.contains("is rendered again"), "{}", again.err);
    names(&reference, &again);
    assert_eq!(place.rows("results/tiny"), rows);
    let aside = format!("{}.damaged", reference.display());
    assert!(fs::exists(&aside).expect("readable"), "{aside}");
    let status = place.lightbench(&["ref", "status"]);
    assert_eq!(status.code, 0, "{}", status.err);
    assert!(status.out.contains("set aside"), "{}", status.out);
}

#[test]
fn absent_and_damaged_references_of_finished_jobs_are_rendered_when_asked() {
    let (place, reference) = finished();
    fs::remove_file(&reference).expect("removable");
    let report = place.lightbench(&["report", "tiny"]);
    assert!(report.out.contains("ref extend"), "{}", report.out);
    names(&reference, &report);
    for damage in [false, true] {
        if damage {
            flip_a_bit(&reference);
        }
        let extend = place.lightbench(&["ref", "extend", "tiny"]);
        assert_eq!(extend.code, 0, "{}", extend.err);
        assert_eq!(extend.err.contains("is rendered again"), damage);
        let report = place.lightbench(&["report", "tiny"]);
        assert!(!report.out.contains("a reference"), "{}", report.out);
    }
}

#[test]
fn merging_a_damaged_config_or_plan_is_refused_and_writes_nothing() {
    let (place, _) = finished();
    for file in ["config.json", "plan.json"] {
        let path = place.path().join("results/tiny").join(file);
        let sound = fs::read(&path).expect("readable");
        fs::write(&path, &sound[..sound.len() / 2]).expect("writable");
        let merged = place.lightbench(&["merge", "tiny", "--out", "out/tiny"]);
        assert_eq!(merged.code, 2, "{}", merged.err);
        assert_eq!(merged.err.matches(file).count(), 1, "{}", merged.err);
        assert!(
            merged.err.contains("run the config again"),
            "{}",
            merged.err
        );
        assert!(!place.path().join("out").exists());
        let report = place.lightbench(&["report", "tiny"]);
        assert_eq!(report.err.matches(file).count(), 1, "{}", report.err);
        fs::write(&path, sound).expect("writable");
    }
    let file = place.path().join("results/tiny/provenance.json");
    fs::write(file, "{").expect("writable");
    let merged = place.lightbench(&["merge", "tiny", "--out", "out/tiny"]);
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert!(
        merged.err.contains("provenance.json is damaged"),
        "{}",
        merged.err
    );
}

#[test]
fn the_folder_of_references_is_not_written_over() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let named = TINY.replace("\"tiny\"", "\"references\"");
    place.write("named.toml", &named);
    let suite = "name = 'references'\ninclude = [{ config = 'tiny.toml' }]\n";
    place.write("suite.toml", suite);
    for arguments in [
        &["run", "named.toml"][..],
        &["run", "suite.toml"],
        &["run", "tiny.toml", "--out", "results/references"],
        &["new", "experiment", "references"],
    ] {
        let output = place.lightbench(arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.err);
        assert!(output.err.contains("references of all"), "{}", output.err);
        assert!(!place.path().join("results").exists(), "{arguments:?}");
    }
}

#[test]
fn numbers_out_of_range_are_refused_in_the_words_of_the_command() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let render = ["render", "stairs", "--out", "o.png"];
    let paths = [&render[..], &["--technique", "path-tracing", "--budget"]].concat();
    for (arguments, expected) in [
        (
            vec!["run", "tiny.toml", "--threads", "1000000"],
            "--threads 1000000: expected 1 to",
        ),
        (
            [&render[..], &["--threads", "0"]].concat(),
            "--threads 0: expected 1 to",
        ),
        (
            [&paths[..], &["0"]].concat(),
            "--budget 0: expected 1 to 16777216 paths a pixel",
        ),
        (
            [&paths[..], &["8"]].concat(),
            "--budget 8: `reference`, the method of this image, has no budget but the samples of --spp",
        ),
        (
            [&render[..], &["--spp", "16777216"]].concat(),
            "spp: expected 1 to 65536",
        ),
        (
            vec!["run", "tiny.toml", "spp=1,16777216"],
            "spp: expected 1 to 65536",
        ),
        (
            [&render[..], &["--budget", "99999999999"]].concat(),
            "--budget 99999999999: expected 1 to 4294967295 records",
        ),
        (
            vec!["run", "tiny.toml", "caches=5,5"],
            "override `caches=5,5`: `caches` is swept over 5 twice",
        ),
    ] {
        let output = place.lightbench(&arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.err);
        assert!(output.err.contains(expected), "{}", output.err);
        assert!(!place.path().join("results").exists(), "{arguments:?}");
    }
}
