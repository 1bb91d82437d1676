//! One kind of processor speaks for the other: what `LIGHTBENCH_HIDE` hides is not used, and changes no
//! picture where the answers are the same to the last bit.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use lightbench::registry::TECHNIQUES;

const HIDE: &str = "LIGHTBENCH_HIDE";

fn lightbench(folder: &Path, hidden: Option<&str>) -> Command {
    let mut command = Command::cargo_bin("lightbench").expect("built");
    command
        .current_dir(folder)
        .env_remove("LIGHTBENCH_SCENES")
        .env_remove("LIGHTBENCH_KERNEL")
        .env_remove(HIDE)
        .envs(hidden.map(|names| (HIDE, names)));
    command
}

/// One tiny image of a contender, as the bytes of its file.
fn render(technique: &str, method: &str, hidden: Option<&str>) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("temporary folder");
    let arguments = [
        "render",
        "still-zoo",
        "--technique",
        technique,
        "--method",
        method,
        "--size",
        "32x18",
        "--spp",
        "1",
        "--budget",
        "8",
        "--seed",
        "3",
        "--out",
        "image.exr",
    ];
    let output = lightbench(folder.path(), hidden)
        .args(arguments)
        .output()
        .expect("runs");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success(),
        "{technique}, {method}, hidden {hidden:?}: {message}"
    );
    std::fs::read(folder.path().join("image.exr")).expect("image")
}

/// AVX-512 and AVX2 answer alike; without both, rays near an edge may be decided otherwise.
#[test]
fn every_technique_renders_with_and_without_wide_registers() {
    for entry in TECHNIQUES {
        let id = entry.about.id;
        // Combinations take the same steps as their parts.
        let contenders = (entry.contenders)();
        let alone = contenders.iter().filter(|listed| listed.parts.len() == 1);
        for (number, listed) in alone.enumerate() {
            let method = listed.id.as_str();
            let all = render(id, method, None);
            assert!(
                all == render(id, method, Some("avx512")),
                "{id}, {method}: AVX-512 changes the picture"
            );
            if number == 0 {
                render(id, method, Some("avx2"));
            }
        }
    }
}

#[test]
fn hidden_instructions_cannot_be_requested_and_unknown_names_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let plan = |kernel: &str, hidden: &str| -> Output {
        let mut command = lightbench(folder.path(), Some(hidden));
        command.env("LIGHTBENCH_KERNEL", kernel).args(["list"]);
        command.output().expect("runs")
    };
    for (kernel, hidden) in [
        ("wide-avx512", "avx512"),
        ("wide-avx2-fma", "avx2"),
        ("wide", "avx2,avx512"),
    ] {
        let refused = plan(kernel, hidden);
        assert_eq!(refused.status.code(), Some(2), "{kernel} without {hidden}");
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(message.contains("or they are hidden"), "{message}");
    }
    assert!(plan("portable", "avx2").status.success());
    let unknown = plan("portable", "sse9");
    assert_eq!(unknown.status.code(), Some(2));
    let message = String::from_utf8_lossy(&unknown.stderr).into_owned();
    assert!(
        message.contains("LIGHTBENCH_HIDE") && message.contains("sse9"),
        "{message}"
    );
}
