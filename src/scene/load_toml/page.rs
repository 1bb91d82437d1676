//! `docs/scenes.md` against the reader.

use std::collections::BTreeSet;
use std::path::Path;

use super::keys::ASKED;
use super::parse_toml;

const PAGE: &str = include_str!("../../../docs/scenes.md");

/// Something of every kind, so that the reader asks for every key.
const EVERYTHING: &str = r#"
[[view]]
origin = [0, 0, 9]
target = [0, 0, 0]
fov_deg = 45
[texture.t]
path = "t.png"
[material.a]
kind = "diffuse"
reflectance = { texture = "t" }
[material.b]
kind = "plastic"
[material.c]
kind = "conductor"
[material.d]
kind = "dielectric"
[[shape]]
kind = "ply"
path = "m.ply"
[[shape]]
kind = "serialized"
path = "m.serialized"
[[shape]]
kind = "sphere"
name = "ball"
emission = 1
[[shape]]
kind = "cylinder"
[[shape]]
kind = "generated"
generator = "any"
[[light]]
kind = "point"
position = [0, 0, 0]
intensity = 1
[[light]]
kind = "spot"
position = [0, 0, 0]
target = [0, 0, 1]
intensity = 1
cutoff_deg = 30
[[light]]
kind = "directional"
direction = [0, 0, 1]
irradiance = 1
[environment]
kind = "ENVIRONMENT"
path = "m.hdr"
radiance = 1
[[path]]
keys = [{ time = 0, view = "main" }, { time = 1, origin = [0, 0, 1], target = [0, 0, 0] }]
[[motion]]
shape = "ball"
keys = [{ time = 0, translate = [0, 0, 0] }]
"#;

#[test]
fn the_page_has_every_key_of_a_scene() {
    ASKED.with_borrow_mut(BTreeSet::clear);
    for (kind, unused) in [
        ("constant", vec!["path = \"m.hdr\"\n"]),
        ("map", vec!["\nradiance = 1"]),
        ("sky", vec!["path = \"m.hdr\"\n", "\nradiance = 1"]),
    ] {
        let mut text = EVERYTHING.replace("ENVIRONMENT", kind);
        for line in unused {
            text = text.replace(line, "");
        }
        parse_toml(&text, Some(Path::new("s.toml")), "s").expect("parses");
    }
    // These two are only names of tables.
    let is_key = |key: &&&str| !["texture", "motion"].contains(*key);
    let read: BTreeSet<String> = ASKED.with_borrow(|asked| {
        let keys = asked.iter().filter(is_key);
        keys.map(|key| (*key).to_owned()).collect()
    });
    let lines = PAGE
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let documented: BTreeSet<String> = lines.map(str::to_owned).collect();
    let missing: Vec<&String> = read.difference(&documented).collect();
    let stale: Vec<&String> = documented.difference(&read).collect();
    assert!(
        missing.is_empty() && stale.is_empty(),
        "missing {missing:?}, stale {stale:?}"
    );
}
