//! Published sample files, where `LIGHTBENCH_SCENES` points to them.

use std::path::PathBuf;

use lightbench::scene::{SceneDescription, check_scene};

use crate::builder::load_file;

/// A file below `gltf` in a folder of the search path; `None` (said aloud) where it is not there.
fn sample(name: &str) -> Option<PathBuf> {
    let list = std::env::var_os("LIGHTBENCH_SCENES").unwrap_or_default();
    let found = std::env::split_paths(&list)
        .map(|folder| folder.join("gltf").join(name))
        .find(|path| path.exists());
    if found.is_none() {
        eprintln!("skipped: gltf/{name} is not below LIGHTBENCH_SCENES");
    }
    found
}

fn load(name: &str) -> Option<Result<SceneDescription, String>> {
    sample(name).map(|path| load_file(&path))
}

#[test]
fn samples_have_the_triangles_that_they_have() {
    for (name, triangles) in [
        ("2CylinderEngine-glTF-Binary/2CylinderEngine.glb", 121_496),
        ("BoxTexcoords-glTF/boxTexcoords.gltf", 12),
        ("BoxTextured-glTF/BoxTextured.gltf", 12),
        ("BoxTextured-glTF-Binary/BoxTextured.glb", 12),
        ("BoxTextured-glTF-Embedded/BoxTextured.gltf", 12),
        (
            "BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf",
            12,
        ),
        ("cameras/Cameras.gltf", 2),
    ] {
        let Some(scene) = load(name) else { continue };
        let check = check_scene(&scene.unwrap_or_else(|e| panic!("{name}: {e}"))).expect("builds");
        let report = check.report;
        assert_eq!(
            report.triangles + report.dropped_degenerate,
            triangles,
            "{name}"
        );
        assert_eq!(report.absent, [""; 0], "{name}");
    }
}

#[test]
fn all_modes_of_primitives_are_read_or_named() {
    for number in 0..16 {
        let name =
            format!("glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_{number:02}.gltf");
        let Some(loaded) = load(&name) else { continue };
        let of_lines = number < 4 || (7..11).contains(&number);
        match loaded {
            Ok(scene) => assert_eq!((scene.shapes.len(), of_lines), (1, false), "{name}"),
            Err(error) => assert!(
                of_lines && error.contains("points or lines"),
                "{name}: {error}"
            ),
        }
    }
}

/// Samples that are damaged on purpose, or use what cannot be read, with a part of the message.
const REFUSED: [(&str, &str); 19] = [
    (
        "BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf",
        "KHR_technique_webgl",
    ),
    (
        "BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb",
        "is not finite",
    ),
    ("IndexOutOfRange/IndexOutOfRange.gltf", "is vertex"),
    ("IndexOutOfRange/AllIndicesOutOfRange.gltf", "is vertex"),
    ("MissingBin/BoxTextured.gltf", "BoxTextured0.bin"),
    ("RecursiveNodes/RecursiveNodes.gltf", "is reached twice"),
    ("SchemaFailures/sceneWrongType.gltf", "sceneWrongType.gltf:"),
    ("TestNoRootNode/NoScene.gltf", "scene"),
    (
        "TestNoRootNode/SceneWithoutNodes.gltf",
        "nothing in it has triangles",
    ),
    ("draco/2CylinderEngine.gltf", "KHR_draco_mesh_compression"),
    ("simple_skin/simple_skin.gltf", "skinning"),
    ("simple_skin/quad_skin.glb", "skinning"),
    ("SimpleMorph/glTF/SimpleMorph.gltf", "morph"),
    ("wrongTypes/badArray.gltf", "badArray.gltf:"),
    ("wrongTypes/badExtension.gltf", "badExtension.gltf:"),
    ("wrongTypes/badNumber.gltf", "badNumber.gltf:"),
    ("wrongTypes/badObject.gltf", "badObject.gltf:"),
    ("wrongTypes/badString.gltf", "badString.gltf:"),
    ("wrongTypes/badUint.gltf", "badUint.gltf:"),
];

#[test]
fn bad_samples_are_refused_with_a_place() {
    for (name, expected) in REFUSED {
        let Some(loaded) = load(name) else { continue };
        let error = loaded.expect_err(name);
        println!("{error}");
        assert!(error.contains(expected), "{name}: {error}");
    }
}

#[test]
fn no_other_sample_is_refused() {
    let Some(folder) = sample("") else { return };
    let mut folders = vec![folder.clone()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder").flatten() {
            let path = entry.path();
            let name = path.strip_prefix(&folder).expect("below it");
            let name = name.to_string_lossy();
            let ending = path.extension().unwrap_or_default();
            if path.is_dir() {
                folders.push(path);
            } else if (ending == "gltf" || ending == "glb")
                && !name.contains("Mesh_PrimitiveMode")
                && !REFUSED.iter().any(|(refused, _)| name == *refused)
            {
                let scene = load_file(&path).unwrap_or_else(|e| panic!("{e}"));
                check_scene(&scene).unwrap_or_else(|e| panic!("{name}: {e}"));
            }
        }
    }
}
