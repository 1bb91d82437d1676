//! The scenes of a config: found, replaced where they are absent, under the environments it asks for.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::config::{Config, ConfigError, OneOrMore, SceneChoice, Source};
use super::sequence::{Sequence, SequenceSpec};
use crate::scene::{SceneDescription, SceneError, View, find_environment, find_scene};
use crate::suggest::hint;

/// Pixels of the largest image.
const LARGEST_IMAGE: usize = 1 << 28;

/// A scene of a config that was found, under one environment.
#[derive(Clone)]
pub(super) struct FoundScene<'a> {
    source: &'a Source,
    /// Position in the config's list.
    pub index: usize,
    pub choice: &'a SceneChoice,
    /// The scene that is loaded: another than the chosen one where it stands in.
    pub found: String,
    /// With the environment, the unit and the depth of the config, and what it adds.
    pub description: SceneDescription,
    pub additions: Option<Additions>,
    /// Name of the map in the description, if the config names one.
    pub environment: Option<String>,
    /// What rows call it.
    pub name: String,
}

/// Paths, lights, shapes and motions that a config adds to each of its scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Additions {
    /// As `[[path]]`, `[[light]]`, `[[shape]]` and `[[motion]]` of a scene file.
    text: String,
    /// What file names in them are relative to the folder of.
    file: PathBuf,
}

impl Additions {
    /// Those of a scene of a config, if it has any.
    ///
    /// # Errors
    /// One that is for a scene which the config does not have.
    fn of(
        config: &Config,
        source: &Source,
        choice: &SceneChoice,
    ) -> Result<Option<Self>, ConfigError> {
        let kinds = [
            ("path", &config.path),
            ("light", &config.light),
            ("shape", &config.shape),
            ("motion", &config.motion),
        ];
        let mut all = toml::Table::new();
        for (kind, tables) in kinds {
            let mut of_scene = Vec::new();
            for (index, table) in tables.iter().enumerate() {
                let mut table = table.clone();
                if let Some(toml::Value::Array(names)) = table.remove("scenes") {
                    let at = |message| source.error(&[kind, &index.to_string(), "scenes"], message);
                    let names = scene_names(config, &names).map_err(at)?;
                    if !names.iter().any(|name| choice.names().contains(name)) {
                        continue;
                    }
                }
                of_scene.push(toml::Value::Table(table));
            }
            if !of_scene.is_empty() {
                all.insert(kind.into(), toml::Value::Array(of_scene));
            }
        }
        Ok((!all.is_empty()).then(|| Self {
            text: all.to_string(),
            file: source.file.clone(),
        }))
    }

    /// They are read with their places in the config's text, which overrides and sweeps do not change.
    pub(super) fn refuse_overrides<'a>(
        keys: impl Iterator<Item = &'a String>,
    ) -> Result<(), ConfigError> {
        for key in keys {
            let first = key.split('.').next().unwrap_or_default();
            if ["path", "light", "shape", "motion"].contains(&first) {
                return Err(ConfigError::Override {
                    text: key.clone(),
                    message: format!("[[{first}]] of a config is changed in its file only"),
                });
            }
        }
        Ok(())
    }

    /// Adds them to a scene.
    ///
    /// # Errors
    /// Those of a scene file, at a place in the additions.
    pub fn add_to(&self, description: &mut SceneDescription) -> Result<(), SceneError> {
        description.add(&self.text, &self.file, &[])
    }
}

/// A scene of a config, once for each environment that it is to be seen under. Notes tell of a scene
/// that stands in for it.
///
/// # Errors
/// Absent scenes and environments, and a unit that is no length.
pub(super) fn find_scenes<'a>(
    source: &'a Source,
    config: &'a Config,
    index: usize,
    notes: &mut Vec<String>,
) -> Result<Vec<FoundScene<'a>>, ConfigError> {
    let choice = &config.scene[index];
    let at =
        |key: &str, message: String| source.error(&["scene", &index.to_string(), key], message);
    let (found, mut description) =
        find_or_replace(source, choice, notes).map_err(|m| at("name", m))?;
    if let Some(metres) = choice.metres_per_unit {
        if !(metres.is_finite() && metres > 0.0) {
            let message = "metres_per_unit: expected a number above 0".into();
            return Err(at("metres_per_unit", message));
        }
        description.metres_per_unit = Some(metres);
    }
    if let Some(edges) = choice.max_depth {
        if edges == 0 {
            return Err(at("max_depth", "max_depth: expected at least 1".into()));
        }
        description.max_depth = edges;
    }
    let additions = Additions::of(config, source, choice)?;
    let own_name = choice.label.clone();
    let scene = FoundScene {
        source,
        index,
        choice,
        found,
        additions,
        environment: None,
        name: own_name.unwrap_or_else(|| description.name.clone()),
        description,
    };
    let own = choice.environment.as_ref();
    let mut scenes = match own.or(config.environment.as_ref()) {
        None => vec![scene],
        Some(environments) => {
            let lit = environments.names().iter().map(|map| {
                scene.under(map, environments).map_err(|message| match own {
                    Some(_) => at("environment", message),
                    None => source.error(&["environment"], message),
                })
            });
            lit.collect::<Result<_, _>>()?
        }
    };
    for scene in scenes.iter_mut().filter(|scene| scene.additions.is_some()) {
        // From the text of the config, so that errors tell the place there. Under the map, which a motion may turn.
        let names = choice.names();
        let added = scene.description.add(&source.text, &source.file, &names);
        added.map_err(|error| ConfigError::Other(error.to_string()))?;
    }
    Ok(scenes)
}

/// The names of a list, each of which a scene of the config has.
fn scene_names<'a>(config: &Config, names: &'a [toml::Value]) -> Result<Vec<&'a str>, String> {
    let known: Vec<&str> = config.scene.iter().flat_map(SceneChoice::names).collect();
    if names.is_empty() {
        return Err("scenes: expected the name of a [[scene]] at least".into());
    }
    let name = |value: &'a toml::Value| match value.as_str() {
        None => Err(format!("scenes: expected names, found {value}")),
        Some(name) if known.contains(&name) => Ok(name),
        Some(name) => Err(format!(
            "scenes: no [[scene]] is called `{name}`{}",
            hint(name, &known)
        )),
    };
    names.iter().map(name).collect()
}

/// A scene by its name, or the one that stands in for it.
fn find_or_replace(
    source: &Source,
    choice: &SceneChoice,
    notes: &mut Vec<String>,
) -> Result<(String, SceneDescription), String> {
    let found = beside(source, &choice.name);
    let error = match find_scene(&found) {
        Ok(description) => return Ok((found, description)),
        Err(error) => error.to_string(),
    };
    let other = choice.otherwise.as_ref().ok_or_else(|| error.clone())?;
    let other = beside(source, other);
    let description = find_scene(&other).map_err(|_| error)?;
    notes.push(format!(
        "scene `{}` was not found; `{other}` stands in for it",
        choice.name
    ));
    Ok((other, description))
}

/// A path in a config is relative to the config, if it leads to something from there. A name without a separator is a path
/// if it is that of a file with an ending; others are names of scenes and maps.
fn beside(source: &Source, name: &str) -> String {
    let folder = source.file.parent().unwrap_or(Path::new(""));
    let path = folder.join(name);
    let is_file = || path.extension().is_some() && path.is_file();
    match name.contains(['/', '\\']) && path.exists() || is_file() {
        true => path.display().to_string(),
        false => name.to_owned(),
    }
}

impl FoundScene<'_> {
    /// The scene under one of the environments that the config asks for.
    fn under(&self, map: &str, environments: &OneOrMore) -> Result<Self, String> {
        let mut lit = self.clone();
        let found = beside(self.source, map);
        let environment = find_environment(&found).map_err(|error| error.to_string())?;
        lit.description.environment = Some(environment);
        lit.environment = Some(found);
        // A label of its own says all about a scene under one map.
        if self.choice.label.is_none() || environments.names().len() > 1 {
            lit.name = format!("{}/{map}", self.name);
        }
        Ok(lit)
    }

    /// An error at a key of the scene in the config.
    pub fn error(&self, key: &str, message: String) -> ConfigError {
        let path = ["scene", &self.index.to_string(), key];
        self.source.error(&path, message)
    }

    /// The view that the config chooses; the first where it chooses none.
    pub fn view(&self) -> Result<&View, ConfigError> {
        let views = &self.description.views;
        if views.is_empty() {
            return Err(self.error("view", "the scene declares no view".into()));
        }
        let chosen = match &self.choice.view {
            None => views.first(),
            Some(name) => views.iter().find(|v| v.name == *name),
        };
        chosen.ok_or_else(|| {
            let known: Vec<&str> = views.iter().map(|v| v.name.as_str()).collect();
            let hint = self.choice.view.as_deref().map(|name| hint(name, &known));
            let (hint, known) = (hint.unwrap_or_default(), known.join(", "));
            let message = format!("the scene has no such view{hint}; it has: {known}");
            self.error("view", message)
        })
    }

    /// What is seen of it over time, and the first of its cameras, whose size is that of images by default.
    pub fn sequence(&self, config: &Config) -> Result<(Sequence, View), ConfigError> {
        let view = self.view()?;
        let Some(spec) = &config.sequence else {
            let own = [
                ("path", self.choice.path.is_some()),
                ("viewers", self.choice.viewers.is_some()),
            ];
            if let Some((key, _)) = own.into_iter().find(|(_, is_there)| *is_there) {
                let message = format!("{key}: needs a [sequence], whose frames are seen");
                return Err(self.error(key, message));
            }
            return Ok((Sequence::still(&view.name), view.clone()));
        };
        let own = self.choice.viewers.as_ref();
        let spec = SequenceSpec {
            viewers: own.or(spec.viewers.as_ref()).cloned(),
            ..spec.clone()
        };
        let path = self.choice.path.as_deref();
        // A size that is refused is refused for the view as well.
        let size = |view: &View| {
            let size = self.size(config, view);
            size.unwrap_or([view.width, view.height])
        };
        let resolved = spec.resolve(&self.description, path, &view.name, &size);
        let sequence = resolved.map_err(|(key, message)| match key {
            "path" if path.is_some() => self.error("path", message),
            "viewers" if own.is_some() => self.error("viewers", message),
            _ => self.source.error(&["sequence", key], message),
        })?;
        let first = sequence.time_s(sequence.frames[0]);
        let views = sequence.views(&self.description, first);
        let view = views.and_then(|views| views.into_iter().next());
        let view = view.unwrap_or_else(|| self.description.views[0].clone());
        Ok((sequence, view))
    }

    /// Width and height of its images in pixels.
    pub fn size(&self, config: &Config, view: &View) -> Result<[usize; 2], ConfigError> {
        let full = self.choice.size.or(config.size);
        let full = full.unwrap_or([view.width, view.height]);
        let size = full.map(|side| ((side as f64 * config.scale.0).round() as usize).max(1));
        if full.iter().all(|side| *side > 0) && size[0].saturating_mul(size[1]) <= LARGEST_IMAGE {
            return Ok(size);
        }
        let message = format!(
            "size: expected [width, height] of at least 1 and {LARGEST_IMAGE} pixels at most"
        );
        Err(match self.choice.size {
            Some(_) => self.error("size", message),
            None => self.source.error(&["size"], message),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beside_the_config_are_found_with_and_without_a_separator() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("own.toml"), "").expect("writable");
        std::fs::create_dir(folder.path().join("stairs")).expect("writable");
        let source = Source {
            file: folder.path().join("c.toml"),
            text: String::new(),
        };
        let own = folder.path().join("own.toml").display().to_string();
        assert_eq!(beside(&source, "own.toml"), own);
        assert!(beside(&source, "./own.toml").ends_with("own.toml"));
        // A shipped scene, whatever folder lies there; and a file that is looked for elsewhere.
        assert_eq!(beside(&source, "stairs"), "stairs");
        assert_eq!(beside(&source, "other.toml"), "other.toml");
    }
}
