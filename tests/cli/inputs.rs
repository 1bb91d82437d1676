//! Files and scenes that cannot be what was meant: what is told of them, and how the program ends.

use super::{Place, TINY};

const ROOM: &str = "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n";

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_by_name() {
    let place = Place::new();
    let lamp = "[[shape]]\nkind = \"cube\"\nemission = 1\n";
    let shape = |path: &str| format!("{ROOM}[[shape]]\nkind = \"{path}\n{lamp}");
    place.write("obj.toml", &shape("obj\"\npath = \"/dev/zero\""));
    place.write("ply.toml", &shape("ply\"\npath = \"/dev/zero\""));
    let map = "environment = { kind = \"map\", path = \"/dev/zero\" }\n";
    place.write("map.toml", &format!("{map}{ROOM}{lamp}"));
    for scene in ["obj.toml", "ply.toml", "map.toml", "/dev/zero"] {
        let arguments = ["render", scene, "--technique", "path-tracing", "--size"];
        let output = place.lightbench(&[&arguments[..], &["8x8", "-o", "o.exr"]].concat());
        assert_eq!(output.code, 2, "{scene}: {}", output.err);
        let named = output.err.contains("/dev/zero");
        assert!(named, "{scene}: {}", output.err);
    }
    let made = std::process::Command::new("mkfifo")
        .arg(place.path().join("pipe.exr"))
        .status();
    assert!(made.expect("runs").success());
    let output = place.lightbench(&["compare", "pipe.exr", "pipe.exr"]);
    assert_eq!(output.code, 2, "{}", output.err);
    assert!(
        output.err.contains("pipe.exr: this is a pipe or a device"),
        "{}",
        output.err
    );
}

#[test]
fn scenes_beyond_single_precision_fail_with_a_reason() {
    let place = Place::new();
    for (transform, told) in [
        ("scale = 1e-15", "single precision holds scenes of"),
        ("translate = [1e30, 0, 0]", "units from the origin"),
    ] {
        let moved = format!("view = \"poles\"\ntransform = {{ {transform} }}");
        place.write("far.toml", &TINY.replace("view = \"poles\"", &moved));
        let output = place.lightbench(&["run", "far.toml", "--out", "out"]);
        assert_eq!(output.code, 4, "{}", output.err);
        assert!(output.err.contains(told), "{}", output.err);
        std::fs::remove_dir_all(place.path().join("out")).expect("removable");
    }
}

#[test]
fn compared_files_with_alpha_are_named() {
    let place = Place::new();
    for (name, alpha) in [("solid.png", 255), ("clear.png", 7)] {
        let picture = image::RgbaImage::from_pixel(16, 16, image::Rgba([9, 9, 9, alpha]));
        picture.save(place.path().join(name)).expect("writable");
    }
    let output = place.lightbench(&["compare", "solid.png", "clear.png"]);
    assert_eq!(output.code, 0, "{}", output.err);
    let note = "note: clear.png: 256 pixels are not opaque; their alpha is left out";
    assert!(output.err.contains(note), "{}", output.err);
    assert!(!output.err.contains("solid.png"), "{}", output.err);
}
