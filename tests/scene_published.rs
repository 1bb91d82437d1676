//! Readers become stricter, and published files must not fall to that: every scene, mesh and environment map below
//! `LIGHTBENCH_SCENES` is read whole. Samples of glTF, some of them damaged on purpose, are in `tests/gltf`.

use std::path::{Path, PathBuf};

use lightbench::environment::{Environment, EnvironmentDescription};
use lightbench::scene::{SceneDescription, check_scene, find_environment, find_scene_in};

/// Files with one of these endings below the folders of the search path; none (said aloud) where there is no such path.
fn published(endings: &[&str]) -> Vec<PathBuf> {
    let list = std::env::var_os("LIGHTBENCH_SCENES").unwrap_or_default();
    let folders = std::env::split_paths(&list);
    let found: Vec<PathBuf> = folders.flat_map(|f| files(&f, endings)).collect();
    if found.is_empty() {
        eprintln!("skipped: no file of {endings:?} is below LIGHTBENCH_SCENES");
    }
    found
}

/// Sorted, of all depths.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default();
        let ending = path.extension().unwrap_or_default();
        if path.is_dir() && name != "gltf" {
            found.extend(files(&path, endings));
        } else if endings.iter().any(|known| ending == *known) {
            found.push(path);
        }
    }
    found
}

/// Reads all files and says of every one that is refused why.
fn none_is_refused(files: &[PathBuf], read: impl Fn(&Path) -> Result<(), String>) {
    let why = |path: &PathBuf| {
        let error = read(path).err()?;
        Some(format!("{}: {error}", path.display()))
    };
    let refused: Vec<String> = files.iter().filter_map(why).collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

fn checked(scene: &SceneDescription) -> Result<(), String> {
    check_scene(scene).map(drop).map_err(|e| e.to_string())
}

#[test]
fn published_scenes_are_read() {
    none_is_refused(&published(&["toml", "xml"]), |path| {
        let scene = find_scene_in(&path.to_string_lossy(), &[]).map_err(|e| e.to_string())?;
        checked(&scene)
    });
}

#[test]
fn published_maps_are_read() {
    none_is_refused(&published(&["hdr"]), |path| {
        let map = find_environment(&path.to_string_lossy()).map_err(|e| e.to_string())?;
        assert!(matches!(map, EnvironmentDescription::Map { .. }));
        let map = Environment::from_description(&map).map_err(|e| e.to_string())?;
        match map.total_power().iter().all(|power| *power > 0.0) {
            true => Ok(()),
            false => Err("is black".into()),
        }
    });
}

#[test]
fn published_pictures_are_read() {
    none_is_refused(&published(&["exr"]), |path| {
        let picture = lightbench::image::read(path);
        picture.map(drop).map_err(|e| e.to_string())
    });
}

#[test]
fn published_meshes_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene_file = folder.path().join("scene.toml");
    let mut meshes = published(&["obj", "ply"]);
    // Those of scenes are read with them; some have no area.
    meshes.retain(|path| {
        path.parent()
            .is_some_and(|folder| folder.ends_with("meshes"))
    });
    none_is_refused(&meshes, |path| {
        let kind = path.extension().unwrap_or_default().to_string_lossy();
        let text = format!(
            "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 40\n\
             [[shape]]\nkind = '{kind}'\npath = '{}'\nmaterial = 'grey'\n\
             [material.grey]\nkind = 'diffuse'\n",
            path.display()
        );
        std::fs::write(&scene_file, text).expect("a file");
        let name = scene_file.to_string_lossy();
        checked(&find_scene_in(&name, &[]).map_err(|e| e.to_string())?)
    });
}
