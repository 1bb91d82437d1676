//! Small scenes that went wrong once, with what is right for them (mean RGB of Mitsuba 3.9, 4096 samples).

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/cases")
        .join(name)
}

fn path_traced(scene: &Path, out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lightbench"))
        .args([
            "render",
            "--technique",
            "path-tracing",
            "--method",
            "reference",
        ])
        .args(["--spp", "64", "--out"])
        .arg(out)
        .arg(scene)
        .output()
        .expect("runs")
}

fn mean(name: &str) -> [f64; 3] {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("o.exr");
    let output = path_traced(&case(name), &out);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: {told}");
    let image = lightbench::image::read(&out).expect("an image");
    let count = image.pixels.len() as f64;
    let channel = |c: usize| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
    [0, 1, 2].map(|c| channel(c) / count)
}

#[test]
fn what_shines_hides_is_coloured_or_bent_is_as_in_mitsuba() {
    for (name, expected) in [
        ("hidden-emitters.xml", [0.2066, 0.2496, 0.2927]),
        ("vertex-colours.xml", [0.6297, 0.5188, 0.6484]),
        ("normal-map.xml", [0.0841; 3]),
        ("textured-lamp.xml", [0.0490, 0.0587, 0.0821]),
        ("bare-lamps.xml", [0.5928, 0.4756, 0.4795]),
        ("steep-bumps.xml", [0.4188, 0.3660, 0.3131]),
        ("blends.xml", [0.3054, 0.3051, 0.3281]),
        ("frosted.xml", [0.8545, 0.5146, 0.4166]),
        // By hand: masks in Mitsuba lose some of what they reflect where rays go on behind them.
        ("hidden-sky.xml", [0.0655, 0.0327, 0.0164]),
    ] {
        let found = mean(name);
        let near = |c: usize| (found[c] / expected[c] - 1.0).abs() < 0.04;
        assert!((0..3).all(near), "{name}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn a_misspelt_parameter_is_an_error_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("o.exr");
    let output = path_traced(&case("misspelt.xml"), &out);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("misspelt.xml:10:"), "{told}");
    assert!(told.contains("did you mean `radius`"), "{told}");
    assert!(!out.exists());
}
