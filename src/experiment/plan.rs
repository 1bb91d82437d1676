//! From a config and overrides to the frozen list of jobs.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::budget::Budget;
use super::config::{Config, ConfigError, SceneChoice, SceneTransform, Source};
use super::overrides::Override;
use super::scene_key;
use crate::scene::{SceneDescription, find_environment, find_scene};
use crate::technique::{Technique, TechniqueEntry, Terms};

/// Pixels of the largest image.
const LARGEST_IMAGE: usize = 1 << 28;
/// What images of a given time count as in estimates, with those that the time is found by.
const RAYS_PER_SECOND: f64 = 2e7;

/// A resolved experiment: nothing is left to decide before rays are traced.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Plan {
    pub name: String,
    pub title: String,
    /// The config files as given.
    pub configs: Vec<PathBuf>,
    pub overrides: Vec<String>,
    pub jobs: Vec<Job>,
    /// Scenes that were replaced or left out, a sentence each.
    pub notes: Vec<String>,
    /// All jobs of the configs, in order, where `jobs` are a selection of them.
    #[serde(skip)]
    pub all: Vec<Job>,
}

/// One (scene, view, technique, method, parameters, budget, seed).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// Content id.
    pub id: String,
    /// What rows call the scene: the config's label for it, or its name.
    pub scene: String,
    /// The scene that is loaded: differs from `asked` when another one stands in.
    pub found: String,
    pub asked: String,
    /// The paper's name of the scene.
    pub paper: Option<String>,
    pub view: String,
    pub transform: Option<SceneTransform>,
    /// In place of what the scene declares.
    #[serde(default)]
    pub metres_per_unit: Option<f64>,
    /// Whether meshes and textures of the scene may be absent.
    #[serde(default)]
    pub incomplete: bool,
    pub technique: String,
    pub technique_parameters: Table,
    /// Canonical id of the method.
    pub method: String,
    pub label: String,
    pub method_parameters: Table,
    /// Map that replaces the scene's, by name.
    pub environment: Option<String>,
    pub budget: Budget,
    pub seed: u64,
    pub width: usize,
    pub height: usize,
    pub spp: u32,
    /// Swept keys and their values in this job.
    pub sweep: BTreeMap<String, Value>,
    /// Key of the reference image.
    pub reference: String,
    pub allow_non_finite: bool,
}

impl Job {
    /// Rays this job will cast, at most: camera rays, and evaluations of its records or shadow rays
    /// of its lights.
    pub fn estimated_rays(&self) -> u64 {
        let pixels = (self.width * self.height) as u64;
        let samples = pixels * u64::from(self.spp);
        match self.budget {
            Budget::Caches(caches) => pixels + samples + caches * self.rays_per_evaluation(),
            Budget::Lights(lights) => samples * (1 + lights),
            Budget::Samples(paths) => pixels * paths * self.rays_per_evaluation(),
            Budget::Seconds(seconds) => samples + (seconds * RAYS_PER_SECOND) as u64,
        }
    }

    /// What a results folder knows it by: its id, and what its row is called.
    pub fn place(&self) -> [String; 4] {
        let parts = [&self.id, &self.label, &self.scene, &self.view];
        parts.map(String::clone)
    }

    fn rays_per_evaluation(&self) -> u64 {
        self.built_technique()
            .map_or(0, |technique| technique.rays_per_evaluation())
    }

    /// Rays of its reference.
    pub fn reference_rays(&self) -> u64 {
        let pixels = (self.width * self.height) as u64;
        self.built_technique().map_or(0, |technique| {
            let samples = u64::from(technique.reference_samples(self.spp));
            pixels * samples * technique.rays_per_reference_sample()
        })
    }

    /// Bytes its records will take.
    pub fn estimated_bytes(&self) -> u64 {
        match self.budget {
            Budget::Caches(caches) => {
                let technique = self.built_technique();
                caches * technique.map_or(0, |t| t.bytes_per_record())
            }
            Budget::Lights(_) | Budget::Samples(_) | Budget::Seconds(_) => 0,
        }
    }

    pub(super) fn built_technique(&self) -> Option<Box<dyn Technique>> {
        let entry = crate::registry::technique(&self.technique)?;
        (entry.build)(&self.technique_parameters).ok()
    }
}

/// Plans one config under overrides. With several values anywhere, every combination is planned.
pub fn plan(source: &Source, overrides: &[Override]) -> Result<(Config, Plan), ConfigError> {
    let written: Config = source.parse()?;
    let single: Vec<(String, Value)> = overrides
        .iter()
        .filter(|o| o.values.len() == 1)
        .map(|o| (o.key.clone(), o.values[0].clone()))
        .collect();
    let base = if single.is_empty() {
        written
    } else {
        source.parse_with(&single)?
    };
    let mut axes: BTreeMap<String, Vec<Value>> = base.sweep.clone();
    for o in overrides.iter().filter(|o| o.values.len() > 1) {
        axes.insert(o.key.clone(), o.values.clone());
    }
    for key in single.iter().map(|(k, _)| k) {
        axes.remove(key);
    }
    let mut plan = Plan {
        name: base.name.clone(),
        title: base.title.clone(),
        configs: vec![source.file.clone()],
        overrides: overrides.iter().map(Override::to_string).collect(),
        jobs: Vec::new(),
        notes: Vec::new(),
        all: Vec::new(),
    };
    let mut cases = HashMap::new();
    for combination in combinations(&axes) {
        let mut settings = single.clone();
        settings.extend(combination.iter().map(|(k, v)| (k.clone(), v.clone())));
        let config = if combination.is_empty() {
            base.clone()
        } else {
            source.parse_with(&settings)?
        };
        Planner {
            source,
            config: &config,
            sweep: combination,
            cases: &mut cases,
        }
        .add_jobs(&mut plan)?;
    }
    super::check::check(source, &base, &plan.jobs)?;
    plan.notes.sort();
    plan.notes.dedup();
    // All jobs of a scene together, so that it is loaded once; otherwise in the order written.
    let order: Vec<String> = plan.jobs.iter().map(|j| j.scene.clone()).collect();
    plan.jobs
        .sort_by_key(|job| order.iter().position(|s| *s == job.scene));
    // A swept key that a method does not have gives the same job again.
    let mut seen = HashSet::new();
    plan.jobs.retain(|job| seen.insert(job.place()));
    plan.all.clone_from(&plan.jobs);
    Ok((base, plan))
}

/// All combinations of the swept values, in the order of keys and values.
fn combinations(axes: &BTreeMap<String, Vec<Value>>) -> Vec<BTreeMap<String, Value>> {
    axes.iter()
        .fold(vec![BTreeMap::new()], |done, (key, values)| {
            done.iter()
                .flat_map(|combination| {
                    values.iter().map(|value| {
                        let mut next = combination.clone();
                        next.insert(key.clone(), value.clone());
                        next
                    })
                })
                .collect()
        })
}

/// A scene of the config that was found, under one environment.
#[derive(Clone, Copy)]
struct PlannedScene<'a> {
    /// Position in the config's list, in decimal.
    index: &'a str,
    found: &'a str,
    /// With the environment and the unit of the config.
    description: &'a SceneDescription,
    /// Name of the map in the description, if the config names one.
    environment: Option<&'a str>,
}

struct Planner<'a> {
    source: &'a Source,
    config: &'a Config,
    sweep: BTreeMap<String, Value>,
    /// Scene, view and swept values of the jobs so far, and the position of their scene.
    cases: &'a mut HashMap<String, String>,
}

impl Planner<'_> {
    fn add_jobs(&mut self, plan: &mut Plan) -> Result<(), ConfigError> {
        let config = self.config;
        let technique = self.technique()?;
        if !technique.has_contenders() {
            let message = format!(
                "{} has no contenders to compare; use `lightbench render`",
                technique.about.id
            );
            return Err(self.source.error(&["technique"], message));
        }
        let built = (technique.build)(&config.parameters).map_err(|error| {
            let path = ["parameters", &error.key];
            self.source.error(&path, error.message)
        })?;
        if config.spp == 0 || config.repeats == 0 {
            return Err(self
                .source
                .error(&["spp"], "spp and repeats must be at least 1".into()));
        }
        let methods = self.methods(built.as_ref())?;
        for (index, choice) in config.scene.iter().enumerate() {
            let index = index.to_string();
            let (found, mut description) = match find_scene(&choice.name) {
                Ok(description) => (choice.name.clone(), description),
                Err(error) => {
                    let replaced = choice
                        .otherwise
                        .clone()
                        .and_then(|o| find_scene(&o).ok().map(|d| (o, d)));
                    let Some(other) = replaced else {
                        return Err(self
                            .source
                            .error(&["scene", &index, "name"], error.to_string()));
                    };
                    plan.notes.push(format!(
                        "scene `{}` was not found; `{}` stands in for it",
                        choice.name, other.0
                    ));
                    other
                }
            };
            if let Some(metres) = choice.metres_per_unit {
                if !(metres.is_finite() && metres > 0.0) {
                    let message = "metres_per_unit: expected a number above 0".into();
                    let path = ["scene", &index, "metres_per_unit"];
                    return Err(self.source.error(&path, message));
                }
                description.metres_per_unit = Some(metres);
            }
            let scene = PlannedScene {
                index: &index,
                found: &found,
                description: &description,
                environment: None,
            };
            let environments = choice.environment.as_ref().or(config.environment.as_ref());
            let Some(environments) = environments else {
                self.add_scene(plan, &scene, &methods)?;
                continue;
            };
            for name in environments.names() {
                let mut lit = description.clone();
                lit.environment = Some(find_environment(name).map_err(|error| {
                    let path: &[&str] = match choice.environment {
                        Some(_) => &["scene", &index, "environment"],
                        None => &["environment"],
                    };
                    self.source.error(path, error.to_string())
                })?);
                let scene = PlannedScene {
                    description: &lit,
                    environment: Some(name),
                    ..scene
                };
                self.add_scene(plan, &scene, &methods)?;
            }
        }
        Ok(())
    }

    fn technique(&self) -> Result<&'static TechniqueEntry, ConfigError> {
        let id = &self.config.technique;
        crate::registry::technique(id).ok_or_else(|| {
            let known = crate::registry::TECHNIQUES.iter().map(|e| e.about.id);
            let known = known.collect::<Vec<_>>().join(", ");
            let message = format!("no technique is called `{id}`; known: {known}");
            self.source.error(&["technique"], message)
        })
    }

    /// The technique's parameters in one scene.
    fn technique_parameters(
        &self,
        technique: &TechniqueEntry,
        index: &str,
        choice: &SceneChoice,
    ) -> Result<Table, ConfigError> {
        let mut parameters = self.config.parameters.clone();
        let Some(distance) = choice.ao_distance else {
            return Ok(parameters);
        };
        if !technique
            .about
            .parameters
            .iter()
            .any(|p| p.key == "distance")
        {
            let id = technique.about.id;
            let message = format!("{id} takes no `ao_distance`: remove it from the scene");
            let path = ["scene", index, "ao_distance"];
            return Err(self.source.error(&path, message));
        }
        if !(distance.is_finite() && distance > 0.0) {
            let message = "ao_distance: expected a distance above 0, scene units".into();
            return Err(self.source.error(&["scene", index, "ao_distance"], message));
        }
        parameters.insert("distance".into(), Value::Float(distance));
        Ok(parameters)
    }

    /// Method id, label and parameters, all checked.
    fn methods(
        &self,
        technique: &dyn Technique,
    ) -> Result<Vec<(String, String, Table)>, ConfigError> {
        if self.config.method.is_empty() {
            return Err(self
                .source
                .error(&["method"], "expected at least one [[method]]".into()));
        }
        let mut methods: Vec<(String, String, Table)> = Vec::new();
        for (index, written) in self.config.method.iter().enumerate() {
            let index = index.to_string();
            let mut parameters = written.clone();
            let mut text = |key: &str| match parameters.remove(key) {
                Some(Value::String(text)) => Ok(Some(text)),
                Some(_) => Err(self
                    .source
                    .error(&["method", &index, key], format!("{key} must be text"))),
                None => Ok(None),
            };
            let (id, label) = (text("id")?, text("label")?);
            let id = id.ok_or_else(|| {
                self.source.error(
                    &["method", &index],
                    "a method needs an id, for example id = \"VGC+DGS\"".into(),
                )
            })?;
            let started = technique.start(&id, &parameters, Terms::default());
            let method = started.map_err(|error| {
                let key = &error.key;
                self.source.error(&["method", &index, key], error.message)
            })?;
            let label = label.unwrap_or_else(|| method.id.clone());
            if methods.iter().any(|(_, known, _)| *known == label) {
                return Err(self.source.error(
                    &["method", &index],
                    format!("two methods are called `{label}`; give one of them another label"),
                ));
            }
            methods.push((method.id, label, parameters));
        }
        Ok(methods)
    }

    fn add_scene(
        &mut self,
        plan: &mut Plan,
        scene: &PlannedScene,
        methods: &[(String, String, Table)],
    ) -> Result<(), ConfigError> {
        let config = self.config;
        let PlannedScene {
            index,
            found,
            description,
            environment,
        } = *scene;
        let position: usize = index.parse().unwrap_or(0);
        let choice = &config.scene[position];
        let at = |key: &str, message: String| self.source.error(&["scene", index, key], message);
        let view = match &choice.view {
            None => description.views.first(),
            Some(name) => description.views.iter().find(|v| v.name == *name),
        }
        .ok_or_else(|| {
            let known: Vec<&str> = description.views.iter().map(|v| v.name.as_str()).collect();
            at(
                "view",
                format!("the scene has no such view; it has: {}", known.join(", ")),
            )
        })?;
        let [full_width, full_height] = choice
            .size
            .or(config.size)
            .unwrap_or([view.width, view.height]);
        let scaled = |side: usize| ((side as f64 * config.scale.0).round() as usize).max(1);
        let pixels = scaled(full_width).saturating_mul(scaled(full_height));
        if full_width == 0 || full_height == 0 || pixels > LARGEST_IMAGE {
            let message = format!(
                "size: expected [width, height] of at least 1 and {LARGEST_IMAGE} pixels at most"
            );
            return Err(match choice.size {
                Some(_) => at("size", message),
                None => self.source.error(&["size"], message),
            });
        }
        let budget = Budget::of(config, choice).map_err(|(key, message)| at(key, message))?;
        let entry = self.technique()?;
        let technique_parameters = self.technique_parameters(entry, index, choice)?;
        let technique = (entry.build)(&technique_parameters)
            .map_err(|error| at("ao_distance", error.message))?;
        technique
            .fits(description)
            .map_err(|message| at("name", message))?;
        description
            .require_files(technique.needs(), choice.incomplete)
            .map_err(|error| at("name", error.to_string()))?;
        if let Some(transform) = &choice.transform {
            transform
                .check()
                .map_err(|message| at("transform", message))?;
        }
        let name = choice.label.as_ref().unwrap_or(&description.name);
        let several = choice.environment.as_ref().or(config.environment.as_ref());
        let name = match environment {
            // A label of its own says all about a scene under one map.
            Some(map) if choice.label.is_none() || several.is_some_and(|e| e.names().len() > 1) => {
                format!("{name}/{map}")
            }
            _ => name.clone(),
        };
        let case = serde_json::json!([name, view.name, self.sweep]).to_string();
        if let Some(earlier) = self.cases.insert(case, index.to_owned()) {
            if found != choice.name {
                plan.notes.push(format!(
                    "`{}` is left out: `{found}`, which stands in for it, is there already",
                    choice.name
                ));
                return Ok(());
            }
            let number = |index: &str| index.parse::<usize>().map_or(0, |i| i + 1);
            let message = format!(
                "scenes {} and {} of this config give the same jobs twice, such as scene `{name}`, \
                 view `{}`, {}, seed {}: give one of them another `label`",
                number(&earlier),
                number(index),
                view.name,
                methods[0].1,
                config.seed,
            );
            return Err(self.source.error(&["scene", index], message));
        }
        let key = scene_key(description);
        for (method, label, parameters) in methods {
            for repeat in 0..config.repeats {
                let mut job = Job {
                    id: String::new(),
                    scene: name.clone(),
                    found: found.to_owned(),
                    asked: choice.name.clone(),
                    paper: choice.paper.clone(),
                    view: view.name.clone(),
                    transform: choice.transform,
                    metres_per_unit: choice.metres_per_unit,
                    incomplete: choice.incomplete,
                    technique: entry.about.id.to_owned(),
                    technique_parameters: technique_parameters.clone(),
                    method: method.clone(),
                    label: label.clone(),
                    method_parameters: parameters.clone(),
                    environment: environment.map(str::to_owned),
                    budget,
                    seed: config.seed + u64::from(repeat),
                    width: scaled(full_width),
                    height: scaled(full_height),
                    spp: config.spp,
                    sweep: self.sweep.clone(),
                    reference: String::new(),
                    allow_non_finite: config.allow_non_finite,
                };
                job.identify(entry, &key, view);
                plan.jobs.push(job);
            }
        }
        Ok(())
    }
}
