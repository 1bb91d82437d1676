//! Opacity masks: whatever makes an image, they let through the share of light that they do not stop.

use std::process::Command;

/// A floor seen from above and a lamp above it; `VEIL` stands between them, or before the camera.
const SCENE: &str = r#"
max_depth = 2

[[view]]
name = "down"
origin = [0, 1, 0]
target = [0, 0, 0]
up = [0, 0, 1]
fov_deg = 4
size = [24, 24]

[material.floor]
kind = "diffuse"
reflectance = 0.8

[material.veil]
kind = "diffuse"
reflectance = 0
opacity = OPACITY

[[shape]]
name = "floor"
kind = "rectangle"
material = "floor"
rotate = [1, 0, 0, -90]
scale = [20, 20, 20]
"#;

const VEIL: &str = r#"
[[shape]]
kind = "rectangle"
material = "veil"
rotate = [1, 0, 0, -90]
scale = [SIDE, SIDE, SIDE]
translate = [0, HEIGHT, 0]
"#;

/// What makes an image: technique, method and what else is said.
type Maker = (&'static str, &'static str, &'static [&'static str]);

/// Reservoirs are not among them: they ask for each sample again at every surface that reuses it, so that half of a
/// half-transparent mask's light is lost twice, as their failures say.
const OF_LAMPS: [Maker; 6] = [
    ("path-tracing", "reference", &["--spp", "16"]),
    ("direct-lighting", "reference", &["--spp", "16"]),
    ("direct-lighting", "rt", &["--budget", "16"]),
    ("direct-lighting", "light-cones", &["--budget", "8"]),
    ("radiance", "sharc", &["--budget", "8"]),
    ("importance-caching", "reference", &["--set", "lights=4096"]),
];
const OF_SKIES: [Maker; 3] = [
    (
        "environment-lighting",
        "reference",
        &["--set", "mean_luminance=0"],
    ),
    (
        "environment-lighting",
        "mis",
        &["--budget", "16", "--set", "mean_luminance=0"],
    ),
    (
        "environment-lighting",
        "median-cut",
        &["--budget", "64", "--set", "mean_luminance=0"],
    ),
];

const LAMPS: [(&str, &str); 4] = [
    (
        "point",
        "[[light]]\nkind = \"point\"\nposition = [0, 3, 0]\nintensity = [9, 9, 9]\n",
    ),
    (
        "sun",
        "[[light]]\nkind = \"directional\"\ndirection = [0.1, -1, 0]\nirradiance = [3, 3, 3]\n",
    ),
    (
        "panel",
        "[[shape]]\nname = \"panel\"\nkind = \"rectangle\"\nrotate = [1, 0, 0, 90]\nscale = [1, 1, 1]\n\
         translate = [0, 3, 0]\nemission = [4, 4, 4]\n",
    ),
    (
        "sky",
        "[environment]\nkind = \"constant\"\nradiance = [1, 1, 1]\n",
    ),
];

fn scene(opacity: &str, lamp: &str, veils: &[(f64, f64)]) -> String {
    let mut text = SCENE.replace("OPACITY", opacity) + lamp;
    for (height, side) in veils {
        let veil = VEIL.replace("SIDE", &side.to_string());
        text += &veil.replace("HEIGHT", &height.to_string());
    }
    text
}

fn mean(text: &str, technique: &str, method: &str, more: &[&str]) -> f64 {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, out] = ["veiled.toml", "o.exr"].map(|name| folder.path().join(name));
    std::fs::write(&file, text).expect("writable");
    let output = Command::new(env!("CARGO_BIN_EXE_lightbench"))
        .args(["render", "--technique", technique, "--method", method])
        .args(more)
        .arg("--out")
        .arg(&out)
        .arg(&file)
        .output()
        .expect("runs");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{technique} {method}: {told}\n{text}"
    );
    let image = lightbench::image::read(&out).expect("an image");
    let sum: f64 = image.pixels.iter().map(|p| f64::from(p[1])).sum();
    sum / image.pixels.len() as f64
}

/// Of the light that falls on the floor a veil lets 0.6 pass, whatever the lamp.
#[test]
fn veils_before_a_lamp_stop_their_share() {
    for (name, lamp) in LAMPS {
        let makers = OF_LAMPS
            .iter()
            .chain(OF_SKIES.iter().filter(|_| name == "sky"));
        for (technique, method, more) in makers {
            let seen =
                |veils: &[(f64, f64)]| mean(&scene("0.4", lamp, veils), technique, method, more);
            let share = seen(&[(1.5, 20.0)]) / seen(&[]);
            assert!(
                (share / 0.6 - 1.0).abs() < 0.1,
                "{name}, {technique} {method}: {share}"
            );
        }
    }
}

/// Veils between camera and floor stand between the floor and its lamp too. They are no edges of a path, so that two of
/// them need no more than one.
#[test]
fn behind_veils_before_the_camera_surfaces_are_lit() {
    for (name, lamp) in &LAMPS[..2] {
        for (technique, method, more) in OF_LAMPS {
            let seen =
                |veils: &[(f64, f64)]| mean(&scene("0.2", lamp, veils), technique, method, more);
            let bare = seen(&[]);
            for (veils, expected) in [
                (&[(0.5, 0.3)][..], 0.64),
                (&[(0.5, 0.3), (0.45, 0.3)], 0.4096),
            ] {
                let share = seen(veils) / bare;
                let context = format!("{name}, {technique} {method}, {} veils", veils.len());
                assert!((share / expected - 1.0).abs() < 0.1, "{context}: {share}");
            }
        }
    }
}
