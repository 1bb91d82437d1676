use std::fs::{self, File, FileTimes};
use std::path::Path;
use std::time::{Duration, SystemTime};

use super::*;
use crate::scene::find_scene_in;

const SCENE: &str = r#"
[[view]]
origin = [0, 0, 3]
target = [0, 0, 0]
fov_deg = 40
[texture.wood]
path = "wood.png"
[material.table]
kind = "diffuse"
reflectance = { texture = "wood" }
[[shape]]
kind = "obj"
path = "m.obj"
material = "table"
[environment]
kind = "map"
path = "sky.hdr"
"#;

fn write_scene(folder: &Path) {
    fs::create_dir_all(folder).expect("a folder");
    let files = [
        ("scene.toml", SCENE),
        ("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("wood.png", "not looked into"),
        ("sky.hdr", "not looked into either"),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).expect("writable");
    }
}

fn key_of(folder: &Path) -> String {
    let name = folder.display().to_string();
    scene_key(&find_scene_in(&name, &[]).expect("a scene"))
}

#[test]
fn lights_without_extent_are_part_of_a_scene() {
    let place = tempfile::tempdir().expect("a folder");
    let spot = "kind = \"spot\"\nposition = [0, 2, 0]\ndirection = [0, -1, 0]\nintensity = 1\n";
    let lights = [
        String::new(),
        "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nintensity = 1\n".into(),
        "[[light]]\nkind = \"point\"\nposition = [0, 2, 0]\nintensity = 2\n".into(),
        format!("[[light]]\n{spot}cutoff_deg = 20\n"),
        format!("[[light]]\n{spot}cutoff_deg = 20\nbeam_width_deg = 3\n"),
    ];
    let mut keys: Vec<String> = lights
        .iter()
        .map(|light| {
            write_scene(place.path());
            let text = format!("{SCENE}{light}");
            fs::write(place.path().join("scene.toml"), text).expect("writable");
            key_of(place.path())
        })
        .collect();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), lights.len());
}

#[test]
fn an_edit_of_equal_size_makes_another_key_wherever_the_folder_lies() {
    let place = tempfile::tempdir().expect("a folder");
    let (here, there) = (place.path().join("here"), place.path().join("else/where"));
    write_scene(&here);
    write_scene(&there);
    let key = key_of(&here);
    assert_eq!(key, key_of(&there), "the same scene in another folder");
    for (count, file) in ["m.obj", "wood.png", "sky.hdr"].iter().enumerate() {
        let path = here.join(file);
        let edited = fs::read_to_string(&path).expect("text").replace('1', "2");
        let edited = edited.replace("not", "now");
        fs::write(&path, &edited).expect("writable");
        // Clocks of file systems may be coarse; what counts here is the size.
        let later = SystemTime::now() + Duration::from_secs(10 + count as u64);
        let opened = File::options().write(true).open(&path).expect("a file");
        let times = FileTimes::new().set_modified(later);
        opened.set_times(times).expect("settable");
        assert_ne!(key, key_of(&here), "{file} was edited");
        fs::copy(&path, there.join(file)).expect("copied");
        let opened = File::options().write(true).open(there.join(file));
        opened.expect("a file").set_times(times).expect("settable");
        assert_eq!(key_of(&here), key_of(&there), "{file} is the same again");
    }
    fs::remove_file(here.join("wood.png")).expect("removable");
    assert_ne!(
        key_of(&here),
        key_of(&there),
        "an absent file is another scene"
    );
}

#[test]
fn names_titles_and_views_are_no_part_of_what_a_scene_shows() {
    let scene = find_scene_in("cornell-curved", &[]).expect("a shipped scene");
    let mut other = scene.clone();
    other.name = "other".into();
    other.title = "another".into();
    other.views.clear();
    assert_eq!(scene_key(&scene), scene_key(&other));
    other.metres_per_unit = Some(7.0);
    assert_ne!(scene_key(&scene), scene_key(&other));
}

#[test]
fn a_method_is_known_by_the_versions_of_its_own_parts() {
    let ao = crate::registry::technique("ambient-occlusion").expect("listed");
    let of = |technique: &TechniqueEntry, method: &str, parameters: &str| -> Vec<&str> {
        let parameters = parameters.parse().expect("toml");
        let built = (technique.build)(&toml::Table::new()).expect("defaults");
        let parts = versions(built.as_ref(), method, &parameters);
        parts.into_iter().map(|(id, _)| id).collect()
    };
    assert_eq!(of(ao, "IM", ""), ["IM", "inverse-distance"]);
    assert_eq!(of(ao, "VGC+EGR", ""), ["VGC", "EGR", "gradient"]);
    let plain = "interpolation = 'inverse-distance'";
    assert_eq!(of(ao, "VGC+EGR", plain), ["VGC", "EGR", "inverse-distance"]);
    assert_eq!(of(ao, "per-sample", ""), ["per-sample"]);
    let lighting = crate::registry::technique("environment-lighting").expect("listed");
    assert_eq!(of(lighting, "mis", ""), ["mis"]);
}

#[test]
fn the_order_of_parameters_does_not_matter_and_their_values_do() {
    let key = |text: &str| canonical_table(&text.parse().expect("toml")).to_string();
    assert_eq!(key("a = 1\nb = [2.5]"), key("b = [2.5]\na = 1"));
    assert_ne!(key("a = inf"), key("a = nan"));
    assert_ne!(key("a = 1"), key("a = 1.5"));
}

/// Keys of 2026-11-29. Where they change on purpose (another `FORMAT`, technique or scene), these change; else stores of
/// references that users have would be rendered again for nothing.
#[test]
fn references_of_earlier_programs_are_found() {
    let text = "name = 'n'\ntechnique = 'ambient-occlusion'\ncaches = 60\nsize = [48, 27]\n\
                [[scene]]\nname = 'statues'\n[[scene]]\nname = 'atrium'\n[[method]]\nid = 'IM'\n";
    let source = crate::experiment::Source {
        text: text.into(),
        ..Default::default()
    };
    let (_, plan) = crate::experiment::plan(&source, &[]).expect("a plan");
    let keys: Vec<&str> = plan.jobs.iter().map(|job| job.reference.as_str()).collect();
    assert_eq!(keys, ["effc041d378e6b4a", "72d146cca574e5cd"]);
}
