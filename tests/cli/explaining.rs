//! What the program says of itself.

use std::fs;
use std::process::Stdio;

use super::{Place, repository};

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
