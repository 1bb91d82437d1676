//! Scenes by name: shipped, on the search path, or a file.

use std::path::{Path, PathBuf};

use super::gltf::load_gltf;
use super::load_toml::{load_toml, parse_toml};
use super::mitsuba::load_mitsuba;
use super::text::nearest;
use super::{SceneDescription, SceneError};

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../scenes/", $name, "/scene.toml")))),*]
    };
}

/// Name and text of every shipped scene.
const SHIPPED: &[(&str, &str)] = shipped![
    "arcade-court",
    "atrium",
    "cabinet-room",
    "cornell-curved",
    "country-house",
    "hard-cases",
    "long-street",
    "robots",
    "stairs",
    "statues",
    "still-glossy",
    "still-puzzle",
    "still-twigs",
    "still-zoo",
    "table",
];

/// The environment variable with the search path.
const PATH_VARIABLE: &str = "LIGHTBENCH_SCENES";

/// Files that make a folder a scene, in order of preference.
const SCENE_FILES: [&str; 4] = ["scene.toml", "scene.xml", "scene.gltf", "scene.glb"];

/// Endings of scene files.
const ENDINGS: [&str; 4] = ["toml", "xml", "gltf", "glb"];

/// Loads the description of a scene.
///
/// `name` is, in this order: a shipped scene; a folder with a `scene.toml`, `scene.xml`,
/// `scene.gltf` or `scene.glb` in one of the folders of `LIGHTBENCH_SCENES` (or a file with one of those
/// endings below one of them); a path to such a
/// file or folder. A name that starts with `./` or `/` is always a path.
pub fn find_scene(name: &str) -> Result<SceneDescription, SceneError> {
    find_scene_in(name, &search_folders())
}

/// The folders of `LIGHTBENCH_SCENES`.
pub(super) fn search_folders() -> Vec<PathBuf> {
    std::env::var_os(PATH_VARIABLE)
        .map(|list| {
            std::env::split_paths(&list)
                .filter(|p| !p.as_os_str().is_empty())
                .collect()
        })
        .unwrap_or_default()
}

/// As [`find_scene`], with the folders of the search path given.
pub fn find_scene_in(name: &str, folders: &[PathBuf]) -> Result<SceneDescription, SceneError> {
    if let Some((name, text)) = SHIPPED.iter().find(|(n, _)| *n == name) {
        return parse_toml(text, None, name);
    }
    let mut looked = vec!["the shipped scenes".to_owned()];
    for base in folders.iter().map(PathBuf::as_path).chain([Path::new("")]) {
        let path = base.join(name);
        if let Some(file) = scene_file(&path) {
            return load_file(&file, &scene_name(&file));
        }
        let shown = path.display();
        if !base.as_os_str().is_empty() && !base.is_dir() {
            looked.push(format!("{}, which is no folder", base.display()));
            continue;
        }
        looked.push(if is_scene_file(&path) {
            shown.to_string()
        } else {
            format!("{shown}/{{{}}}", SCENE_FILES.join(","))
        });
    }
    let mut known: Vec<String> = shipped_scenes().into_iter().map(str::to_owned).collect();
    known.extend(folders.iter().flat_map(|f| scenes_in(f)));
    Err(not_found(name, looked, &known))
}

fn not_found(name: &str, looked: Vec<String>, known: &[String]) -> SceneError {
    let words: Vec<&str> = known.iter().map(String::as_str).collect();
    let mut known = if words.is_empty() {
        "none".to_owned()
    } else {
        words.join(", ")
    };
    if let Some(similar) = nearest(name, &words) {
        known = format!("{known} (did you mean `{similar}`?)");
    }
    SceneError::NotFound {
        name: name.to_owned(),
        looked: looked.join("; "),
        known,
    }
}

/// The file itself, or the scene file of a folder.
fn scene_file(path: &Path) -> Option<PathBuf> {
    if path.is_dir() {
        return SCENE_FILES
            .iter()
            .map(|f| path.join(f))
            .find(|f| f.is_file());
    }
    (is_scene_file(path) && path.is_file()).then(|| path.to_owned())
}

fn is_scene_file(path: &Path) -> bool {
    path.extension()
        .is_some_and(|ending| ENDINGS.iter().any(|known| ending == *known))
}

fn load_file(file: &Path, name: &str) -> Result<SceneDescription, SceneError> {
    match file.extension().and_then(|ending| ending.to_str()) {
        Some("xml") => load_mitsuba(file, name),
        Some("gltf" | "glb") => load_gltf(file, name),
        _ => load_toml(file, name),
    }
}

/// The folder's name for `scene.*`, else folder and file: a name for rows and result folders.
fn scene_name(file: &Path) -> String {
    let text = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = text(file.file_stem()).unwrap_or_default();
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let folder = text(absolute.parent().and_then(Path::file_name));
    match folder {
        Some(folder) if stem == "scene" => folder,
        Some(folder) => format!("{folder}-{stem}"),
        None => stem,
    }
}

/// Names of the folders with scenes directly below a folder, sorted.
fn scenes_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter(|e| scene_file(&e.path()).is_some() && e.path().is_dir())
        .map(|e| e.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort_unstable();
    names
}

/// Names of the embedded scenes.
pub fn shipped_scenes() -> Vec<&'static str> {
    SHIPPED.iter().map(|(name, _)| *name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_scenes_that_is_none_is_named() {
        let folders = [PathBuf::from("/gone/scenes"), PathBuf::from("Cargo.toml")];
        let error = find_scene_in("nowhere", &folders).unwrap_err().to_string();
        assert!(
            error.contains("/gone/scenes, which is no folder; Cargo.toml, which is no folder"),
            "{error}"
        );
    }
}
