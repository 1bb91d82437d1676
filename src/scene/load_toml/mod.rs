//! `scene.toml`: the house format.
//!
//! Unknown keys, unknown kinds, references to nothing and values out of range are errors with
//! file, line, column and the nearest word that would have been right.

mod keys;
mod light;
mod material;
mod motion;
mod path;
mod shape;
mod view;

use std::path::{Path, PathBuf};

use keys::{Keys, Source};
use toml::de::DeTable;

use super::text::{error_at, file_error};
use super::{Material, SceneDescription, SceneError};
use crate::other_kind::read_text;

/// Reads a scene file; no mesh, texture or map is opened.
pub(super) fn load_toml(file: &Path, name: &str) -> Result<SceneDescription, SceneError> {
    let text = read_text(file).map_err(|why| file_error(file, why))?;
    parse_toml(&text, Some(file), name)
}

/// Parses the text of a scene file; `file` is `None` for embedded scenes.
pub(super) fn parse_toml(
    text: &str,
    file: Option<&Path>,
    name: &str,
) -> Result<SceneDescription, SceneError> {
    let embedded = PathBuf::from(format!("<{name}>/scene.toml"));
    let shown = file.unwrap_or(&embedded);
    let root = parse(text, shown)?;
    let source = Source { file: shown, text };
    let keys = Keys::new(&source, root.get_ref(), 0..0, "the scene");
    let mut loader = Loader {
        folder: file
            .and_then(Path::parent)
            .unwrap_or(Path::new(""))
            .to_owned(),
        texture_names: Vec::new(),
        scene: SceneDescription {
            name: name.to_owned(),
            file: file.map(Path::to_owned),
            materials: vec![Material::diffuse("default", [0.5; 3])],
            ..SceneDescription::default()
        },
    };
    loader.read(&keys)?;
    Ok(loader.scene)
}

impl SceneDescription {
    /// Adds the `[[shape]]`, `[[light]]`, `[[path]]` and `[[motion]]` of a text, such as a config has, to the scene.
    /// Names of files are relative to the folder of `file`. What has a list `scenes` is added if one of `names` is in it.
    /// Other keys are not looked at.
    ///
    /// # Errors
    /// As for scene files, at a place in `text`.
    pub fn add(&mut self, text: &str, file: &Path, names: &[&str]) -> Result<(), SceneError> {
        let root = parse(text, file)?;
        let source = Source { file, text };
        let keys = Keys::new(&source, root.get_ref(), 0..0, "the config");
        let mut loader = Loader {
            folder: file.parent().unwrap_or(Path::new("")).to_owned(),
            texture_names: Vec::new(),
            scene: std::mem::take(self),
        };
        let added = loader.additions(&keys, Some(names));
        *self = loader.scene;
        added
    }
}

fn parse<'a>(text: &'a str, file: &Path) -> Result<toml::Spanned<DeTable<'a>>, SceneError> {
    DeTable::parse(text).map_err(|e| {
        let offset = e.span().map_or(0, |s| s.start);
        error_at(file, text, offset, e.message().trim().to_owned())
    })
}

/// The state of one load.
struct Loader {
    /// What paths are relative to.
    folder: PathBuf,
    /// Parallel to the textures of the scene.
    texture_names: Vec<String>,
    scene: SceneDescription,
}

impl Loader {
    fn read(&mut self, keys: &Keys) -> Result<(), SceneError> {
        let scene = &mut self.scene;
        scene.title = keys.string("title")?.unwrap_or("").to_owned();
        scene.metres_per_unit = keys.positive("metres_per_unit")?;
        scene.ao_distance = keys.positive("ao_distance")?;
        scene.exposure = keys.positive("exposure")?.unwrap_or(1.0) as f32;
        scene.max_depth = keys.whole("max_depth", 0..10_001)?.unwrap_or(6);
        for mut table in keys.tables("view")? {
            let view = self.view(&mut table)?;
            if self.scene.views.iter().any(|v| v.name == view.name) {
                return Err(table.error(format!("there are two views called `{}`", view.name)));
            }
            self.scene.views.push(view);
        }
        if self.scene.views.is_empty() {
            return Err(keys.error("the scene needs at least one [[view]]"));
        }
        self.textures(keys)?;
        self.materials(keys)?;
        self.environment(keys)?;
        self.additions(keys, None)?;
        if self.scene.shapes.is_empty() {
            return Err(keys.error("the scene needs at least one [[shape]]"));
        }
        keys.finish()
    }

    /// What a config may add to a scene as well: to all, or to those of some names.
    fn additions(&mut self, keys: &Keys, scene: Option<&[&str]>) -> Result<(), SceneError> {
        for mut table in of_scene(keys, "shape", scene)? {
            let shape = self.shape(&mut table)?;
            self.add_shape(shape, &table)?;
        }
        for mut table in of_scene(keys, "light", scene)? {
            self.light(&mut table)?;
        }
        for mut table in of_scene(keys, "path", scene)? {
            self.camera_path(&mut table)?;
        }
        for mut table in of_scene(keys, "motion", scene)? {
            self.motion(&mut table)?;
        }
        Ok(())
    }

    /// A path relative to the scene file.
    fn file(&self, keys: &Keys) -> Result<PathBuf, SceneError> {
        let path = keys.required("path", keys.string("path")?)?;
        Ok(self.folder.join(path))
    }
}

/// The tables under a key that a scene of these names has: those that name it, or no scene.
fn of_scene<'a>(
    keys: &Keys<'a>,
    key: &'static str,
    scene: Option<&[&str]>,
) -> Result<Vec<Keys<'a>>, SceneError> {
    let mut found = Vec::new();
    for table in keys.tables(key)? {
        let scenes = match scene {
            Some(called) => table.names("scenes")?.zip(Some(called)),
            None => None,
        };
        if scenes.is_none_or(|(scenes, called)| scenes.iter().any(|s| called.contains(&s.name))) {
            found.push(table);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod page;
#[cfg(test)]
mod tests;
