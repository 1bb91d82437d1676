//! The experiment file: what it may say, and where it is wrong.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::arrays;
use super::locate::locate;
use super::reported::{ClaimSpec, FigureSpec, GateSpec, Published, TableSpec};
use super::scale::Scale;
use super::sequence::{SequenceSpec, ViewersSpec};
use super::shipped;
use crate::other_kind::read_text;
use crate::suggest::with_hint;

/// An experiment as written. Every key has a default but `name`, `technique`, `scene` and `method`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Names the results folder.
    pub name: String,
    /// Heading of the report; empty: the name.
    #[serde(default)]
    pub title: String,
    /// Id or alias of what is computed: `lightbench list`.
    pub technique: String,
    /// Parameters of the technique, shared by reference and contenders.
    #[serde(default)]
    pub parameters: toml::Table,
    /// What is rendered, scene by scene.
    pub scene: Vec<SceneChoice>,
    /// Frames and viewers; without it each scene is one still picture.
    #[serde(default)]
    pub sequence: Option<SequenceSpec>,
    /// Camera paths, lights, shapes and motions that each scene has besides its own, as in scene files; with a list `scenes`
    /// only the scenes of these names or labels.
    #[serde(default)]
    pub path: Vec<toml::Table>,
    /// Lights without extent, each as `[[light]]` of a scene file.
    #[serde(default)]
    pub light: Vec<toml::Table>,
    /// Shapes, each as `[[shape]]` of a scene file.
    #[serde(default)]
    pub shape: Vec<toml::Table>,
    /// Motions of the scene's things or of those added here, each as `[[motion]]` of a scene file.
    #[serde(default)]
    pub motion: Vec<toml::Table>,
    /// The contenders: `id`, optional `label`, and the method's parameters.
    pub method: Vec<toml::Table>,
    /// Records of every contender at full size.
    #[serde(default)]
    pub caches: Option<u64>,
    /// Shadow rays per shading point of every contender of environment lighting.
    #[serde(default)]
    pub lights: Option<u64>,
    /// Paths through each pixel of a frame of every contender of path tracing.
    #[serde(default)]
    pub samples: Option<u64>,
    /// In place of `lights` or `samples`: processor seconds that an image of every contender takes.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// In place of `lights` or `samples`: rays that an image of every contender takes a pixel, camera rays included.
    #[serde(default)]
    pub rays_per_pixel: Option<f64>,
    /// Environment maps by name or file, crossed with the scenes that name none themselves.
    #[serde(default)]
    pub environment: Option<OneOrMore>,
    /// Scales both sides of the image, and the records by its square: "1/4" keeps records per pixel.
    #[serde(default = "unit_scale")]
    pub scale: Scale,
    /// Image size in pixels before scaling; default: the view's.
    #[serde(default, deserialize_with = "arrays::optional")]
    pub size: Option<[usize; 2]>,
    /// Sub-pixel samples of reference and contenders alike.
    #[serde(default = "one")]
    pub spp: u32,
    /// Seed of the first repeat.
    #[serde(default = "one_u64")]
    pub seed: u64,
    /// Each contender is run with seeds `seed, seed + 1, …`.
    #[serde(default = "one")]
    pub repeats: u32,
    /// Keys (as in overrides) that take several values, crossed with one another.
    #[serde(default)]
    pub sweep: BTreeMap<String, Vec<toml::Value>>,
    /// Jobs whose non-finite samples are tolerated (they are counted and reported all the same).
    #[serde(default)]
    pub allow_non_finite: bool,
    /// Tables that the report has of the rows.
    #[serde(default)]
    pub table: Vec<TableSpec>,
    /// Figures that the report has of rows and images.
    #[serde(default)]
    pub figure: Vec<FigureSpec>,
    /// Statements of the paper, judged in the report and, where there is no gate, by `lightbench gate`.
    #[serde(default)]
    pub claim: Vec<ClaimSpec>,
    /// Bounds that `lightbench gate` judges.
    #[serde(default)]
    pub gate: Vec<GateSpec>,
    /// Numbers of the paper, shown beside those measured.
    #[serde(default)]
    pub published: Vec<Published>,
}

fn one() -> u32 {
    1
}

fn one_u64() -> u64 {
    1
}

fn unit_scale() -> Scale {
    Scale(1.0)
}

/// A name or a list of names.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(
    untagged,
    expecting = "environment: expected the name of a map or a list of such"
)]
pub enum OneOrMore {
    /// A string.
    One(String),
    /// An array of strings.
    More(Vec<String>),
}

impl OneOrMore {
    /// The names in the order of the file; one of a single name.
    pub fn names(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::More(names) => names,
        }
    }
}

/// A scene of the experiment, with what differs from the experiment's defaults.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SceneChoice {
    /// A shipped scene, one on `LIGHTBENCH_SCENES`, or a scene file.
    pub name: String,
    /// Used when `name` is not found: the shipped scene of the same kind.
    #[serde(default)]
    pub otherwise: Option<String>,
    /// What rows and tables call it; needed when a scene is used twice.
    #[serde(default)]
    pub label: Option<String>,
    /// The name the paper's tables use.
    #[serde(default)]
    pub paper: Option<String>,
    /// A view of the scene by name; default: its first one.
    #[serde(default)]
    pub view: Option<String>,
    /// In place of the `path` of `[sequence]`.
    #[serde(default)]
    pub path: Option<String>,
    /// In place of the `viewers` of `[sequence]`.
    #[serde(default)]
    pub viewers: Option<ViewersSpec>,
    /// Records at full size, in place of the experiment's.
    #[serde(default)]
    pub caches: Option<u64>,
    /// Shadow rays per shading point, in place of the experiment's.
    #[serde(default)]
    pub lights: Option<u64>,
    /// Paths through each pixel of a frame, in place of the experiment's.
    #[serde(default)]
    pub samples: Option<u64>,
    /// Seconds of each image, in place of the experiment's.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// Rays of each image a pixel, in place of the experiment's.
    #[serde(default)]
    pub rays_per_pixel: Option<f64>,
    /// Replaces the scene's environment; several maps make several scenes.
    #[serde(default)]
    pub environment: Option<OneOrMore>,
    /// Width and height in pixels before scaling, in place of the experiment's.
    #[serde(default, deserialize_with = "arrays::optional")]
    pub size: Option<[usize; 2]>,
    /// Replaces the scene's AO distance, scene units.
    #[serde(default)]
    pub ao_distance: Option<f64>,
    /// Replaces the length of a scene unit in metres.
    #[serde(default)]
    pub metres_per_unit: Option<f64>,
    /// Replaces the scene's longest paths, edges.
    #[serde(default)]
    pub max_depth: Option<u32>,
    /// Says that meshes, textures and material libraries of the scene are known to be absent, so that it is
    /// used without them; otherwise absent files are an error.
    #[serde(default)]
    pub incomplete: bool,
    /// Hard cases: the whole scene, camera included, is scaled, then moved (scene units after
    /// scaling), with metres per unit declared to match.
    #[serde(default)]
    pub transform: Option<SceneTransform>,
}

impl SceneChoice {
    /// What `scenes` of a `[[shape]]` and the like may call it.
    pub fn names(&self) -> Vec<&str> {
        let label = self.label.as_deref();
        [Some(self.name.as_str()), label]
            .into_iter()
            .flatten()
            .collect()
    }

    /// Whether it has a value of its own for a key that experiments have too.
    pub(super) fn sets(&self, key: &str) -> bool {
        match key {
            "caches" => self.caches.is_some(),
            "lights" => self.lights.is_some(),
            "samples" => self.samples.is_some(),
            "seconds" => self.seconds.is_some(),
            "rays_per_pixel" => self.rays_per_pixel.is_some(),
            "environment" => self.environment.is_some(),
            "size" => self.size.is_some(),
            _ => false,
        }
    }
}

/// A similarity applied to a whole scene.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SceneTransform {
    /// Factor on all lengths; applied first.
    #[serde(default = "unit")]
    pub scale: f64,
    /// Degrees about +y.
    #[serde(default)]
    pub rotate_y_deg: f64,
    /// What is added to all positions, scene units after scaling; applied last.
    #[serde(default, deserialize_with = "arrays::fixed")]
    pub translate: [f64; 3],
}

impl SceneTransform {
    /// Refuses what is no similarity.
    pub(super) fn check(&self) -> Result<(), String> {
        let [x, y, z] = self.translate;
        // Intensities of lights follow the square of the scale.
        let finite = [self.scale * self.scale, self.rotate_y_deg, x, y, z];
        match finite.iter().all(|n| (*n as f32).is_finite()) && self.scale > 0.0 {
            true => Ok(()),
            false => Err(
                "transform: expected finite numbers of at most 3.4e38 and a scale above 0, of at most 1.8e19"
                    .into(),
            ),
        }
    }
}

fn unit() -> f64 {
    1.0
}

/// An experiment file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read, or no shipped config or several have its name.
    #[error("{}: {reason}", file.display())]
    Read {
        /// The file or name as it was given.
        file: PathBuf,
        /// What the system, or the search among shipped configs, says.
        reason: String,
    },
    /// A key or value of a file is wrong.
    #[error("{}:{line}:{column}: {message}", file.display())]
    At {
        /// The config that holds it.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// Counted from 1, in characters.
        column: usize,
        /// What is wrong, and what is expected.
        message: String,
    },
    /// An override from the command line or a suite is wrong: its form, its key or its value.
    #[error("override `{text}`: {message}")]
    Override {
        /// The override as written.
        text: String,
        /// What is wrong, and what is expected.
        message: String,
    },
    /// An error that has no place in a file; its message.
    #[error("{0}")]
    Other(String),
}

/// The text of a config and where it came from: what errors point into. A config that no file holds has
/// none, and its errors are their messages.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Empty where no file holds the text.
    pub file: PathBuf,
    /// The whole file.
    pub text: String,
}

impl Source {
    /// The config of a file, or where there is none a shipped one, by its name or its path below `configs/`, with or
    /// without `configs/` and `.toml`.
    ///
    /// # Errors
    /// A file that cannot be read; a name that no config has, or several.
    pub fn find(name: &str) -> Result<Self, ConfigError> {
        if Path::new(name).is_file() {
            return Self::read(name.as_ref());
        }
        match shipped::find(name) {
            Ok((path, text)) => Ok(Self {
                file: Path::new(shipped::FOLDER).join(path).with_extension("toml"),
                text: text.to_owned(),
            }),
            Err(reason) => Err(ConfigError::Read {
                file: name.into(),
                reason,
            }),
        }
    }

    /// Reads a config file.
    ///
    /// # Errors
    /// A file that cannot be read, or is not UTF-8.
    pub fn read(file: &Path) -> Result<Self, ConfigError> {
        let text = read_text(file).map_err(|reason| ConfigError::Read {
            file: file.to_owned(),
            reason,
        })?;
        Ok(Self {
            file: file.to_owned(),
            text,
        })
    }

    /// An error at the value of a key path such as `["method", "2", "sigma_a_deg"]`; the closest
    /// enclosing place when the path itself is not in the file (it came from an override).
    pub fn error(&self, path: &[&str], message: String) -> ConfigError {
        let offset = locate(&self.text, path).unwrap_or(0);
        self.error_at(offset, message)
    }

    fn error_at(&self, offset: usize, message: String) -> ConfigError {
        if self.file.as_os_str().is_empty() {
            return ConfigError::Other(message);
        }
        let (line, column) = line_column(&self.text, offset);
        ConfigError::At {
            file: self.file.clone(),
            line,
            column,
            message,
        }
    }

    /// Parses the text as written.
    pub fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, ConfigError> {
        toml::from_str(&self.text).map_err(|error| {
            let offset = error.span().map_or(0, |s| s.start);
            self.error_at(offset, with_hint(error.message()))
        })
    }

    /// Parses the text with `key=value` pairs (already single-valued) put in.
    pub fn parse_with(&self, settings: &[(String, toml::Value)]) -> Result<Config, ConfigError> {
        let mut table: toml::Table = toml::from_str(&self.text).map_err(|error| {
            let offset = error.span().map_or(0, |s| s.start);
            self.error_at(offset, with_hint(error.message()))
        })?;
        for (key, value) in settings {
            super::overrides::apply(&mut table, key, value)?;
        }
        // As text again: one reader of configs is enough of program.
        toml::from_str(&table.to_string()).map_err(|error| ConfigError::Override {
            text: settings
                .iter()
                .map(|(k, v)| format!("{k}={v}"))
                .collect::<Vec<_>>()
                .join(" "),
            message: with_hint(error.message()),
        })
    }
}

/// One-based line and column (in characters) of a byte offset.
pub fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(offset.min(text.len()))];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    (line, column)
}
