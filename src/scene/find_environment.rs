//! Environment maps by name: embedded, on the search path, or a file.

use std::path::{Path, PathBuf};

use glam::DMat4;

use super::SceneError;
use super::find::search_folders;
use super::text::nearest;
use crate::environment::{EnvironmentDescription, EnvironmentRows, embedded_maps};
use crate::image::file_of;

const EXTENSIONS: [&str; 2] = ["hdr", "exr"];

/// The environment of a name, unscaled and not turned.
///
/// `name` is, in this order: an embedded map; the stem of a `.hdr` or `.exr` file, with or without a
/// resolution such as `_1k`, in a folder of `LIGHTBENCH_SCENES` or its `hdri` folder; a path to such
/// a file.
pub fn find_environment(name: &str) -> Result<EnvironmentDescription, SceneError> {
    find_environment_in(name, &search_folders())
}

/// As [`find_environment`], with the folders of the search path given.
pub fn find_environment_in(
    name: &str,
    folders: &[PathBuf],
) -> Result<EnvironmentDescription, SceneError> {
    if embedded_maps().any(|(known, _)| known == name) {
        return Ok(EnvironmentDescription::Embedded {
            name: name.to_owned(),
            scale: 1.0,
            to_world: DMat4::IDENTITY,
        });
    }
    let places = map_folders(folders);
    let found = places
        .iter()
        .find_map(|folder| map_in(folder, name))
        .or_else(|| {
            let file = file_of(Path::new(name));
            file.is_file().then(|| PathBuf::from(name))
        });
    if let Some(path) = found {
        return Ok(EnvironmentDescription::Map {
            path,
            scale: 1.0,
            to_world: DMat4::IDENTITY,
            rows: EnvironmentRows::CellCentred,
        });
    }
    let mut known: Vec<String> = embedded_maps().map(|(name, _)| name.to_owned()).collect();
    known.extend(places.iter().flat_map(|folder| stems(folder)));
    let words: Vec<&str> = known.iter().map(String::as_str).collect();
    let mut list = words.join(", ");
    if let Some(similar) = nearest(name, &words) {
        list = format!("{list} (did you mean `{similar}`?)");
    }
    let mut looked = vec!["the embedded maps".to_owned()];
    looked.extend(places.iter().map(|p| p.display().to_string()));
    looked.push(name.to_owned());
    Err(SceneError::EnvironmentNotFound {
        name: name.to_owned(),
        looked: looked.join("; "),
        known: list,
    })
}

fn map_folders(folders: &[PathBuf]) -> Vec<PathBuf> {
    let both = folders.iter().flat_map(|f| [f.join("hdri"), f.clone()]);
    both.filter(|f| f.is_dir()).collect()
}

/// The map of this stem in a folder; of several resolutions the first by name.
fn map_in(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut exact = EXTENSIONS
        .iter()
        .map(|e| folder.join(format!("{name}.{e}")));
    if let Some(file) = exact.find(|file| file.is_file()) {
        return Some(file);
    }
    files(folder)
        .into_iter()
        .find(|file| stem(file).is_some_and(|s| without_resolution(&s) == name))
}

fn stems(folder: &Path) -> Vec<String> {
    files(folder).iter().filter_map(|f| stem(f)).collect()
}

fn stem(file: &Path) -> Option<String> {
    file.file_stem().map(|s| s.to_string_lossy().into_owned())
}

/// Map files of a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| {
            let extension = path.extension().map(|e| e.to_ascii_lowercase());
            extension.is_some_and(|e| EXTENSIONS.iter().any(|known| e == *known))
        })
        .collect();
    files.sort();
    files
}

/// `chapel_2k` is called `chapel` too.
fn without_resolution(stem: &str) -> &str {
    let Some((name, end)) = stem.rsplit_once('_') else {
        return stem;
    };
    let digits = end.strip_suffix('k').unwrap_or("");
    if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) {
        name
    } else {
        stem
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_found_by_stem_and_without_their_resolution() {
        let folder = tempfile::tempdir().expect("a folder");
        let maps = folder.path().join("hdri");
        std::fs::create_dir(&maps).expect("hdri");
        for name in ["chapel_1k.hdr", "chapel_2k.hdr", "mill_kd.exr"] {
            std::fs::write(maps.join(name), b"").expect("a file");
        }
        let folders = [folder.path().to_owned()];
        let file = |name: &str| match find_environment_in(name, &folders) {
            Ok(EnvironmentDescription::Map { path, .. }) => {
                path.file_name().map(|f| f.to_string_lossy().into_owned())
            }
            _ => None,
        };
        assert_eq!(file("chapel").as_deref(), Some("chapel_1k.hdr"));
        assert_eq!(file("chapel_2k").as_deref(), Some("chapel_2k.hdr"));
        assert_eq!(file("mill_kd").as_deref(), Some("mill_kd.exr"));
        assert_eq!(file("mill"), None);
        let message = find_environment_in("chappel_1k", &folders)
            .expect_err("no such map")
            .to_string();
        assert!(message.contains("did you mean `chapel_1k`"), "{message}");
        assert!(matches!(
            find_environment_in("noon", &folders),
            Ok(EnvironmentDescription::Embedded { .. })
        ));
    }

    #[test]
    fn a_layer_of_a_file_may_be_an_environment() {
        use crate::environment::Environment;
        use crate::image::{Attributes, Image, Layer, Plane, write_exr};
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        // The first layer that is written is the picture: here one of distances.
        let depth = Layer::gray("", Plane::new(4, 2));
        let colours = [("left", 1.0), ("right", 2.0)].map(|(name, value)| {
            let mut image = Image::new(4, 2);
            image.pixels.fill([value; 3]);
            Layer::color(name, image)
        });
        let layers = [vec![depth], colours.to_vec()].concat();
        write_exr(&path, &layers, &Attributes::default()).expect("writes");
        let environment = |name: String| {
            let found = find_environment(&name).expect("is found");
            Environment::from_description(&found).map_err(|error| error.to_string())
        };
        let right = environment(format!("{}#right", path.display())).expect("reads");
        assert_eq!(right.radiance(glam::Vec3::X), [2.0; 3]);
        let several = environment(path.display().to_string()).expect_err("two layers");
        assert_eq!(several.matches("a.exr: ").count(), 1, "{several}");
    }

    #[test]
    fn a_cube_is_no_map() {
        use crate::environment::Environment;
        use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, WritableImage};
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let channels =
            ["R", "G", "B"].map(|name| AnyChannel::new(name, FlatSamples::F32(vec![1.0; 6])));
        let mut attributes = exr::prelude::LayerAttributes::named("map");
        attributes.environment_map = Some(exr::meta::attribute::EnvironmentMap::Cube);
        let channels = AnyChannels::sort(channels.into_iter().collect());
        let encoding = exr::prelude::Encoding::UNCOMPRESSED;
        let layer = exr::prelude::Layer::new((1, 6), attributes, encoding, channels);
        let image = exr::prelude::Image::from_layer(layer);
        image.write().to_file(&path).expect("writes");
        let found = find_environment(&path.display().to_string()).expect("is found");
        let error = Environment::from_description(&found).expect_err("a cube");
        assert!(error.to_string().contains("cube"), "{error}");
    }
}
