//! From a config and overrides to the frozen list of jobs.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::budget::Budget;
use super::config::{Config, ConfigError, SceneTransform, Source};
use super::overrides::Override;
use super::scene_key;
use crate::scene::{SceneDescription, find_environment, find_scene};
use crate::technique::{Contenders, TechniqueEntry};
use crate::technique::{Method, Technique};

/// Changes whenever the same job would give another reference, so that older ones are not reused.
const REFERENCES: u32 = 2;
/// Changes whenever the same job would give another result beside the same reference.
const RESULTS: u32 = 5;
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
            Budget::Seconds(seconds) => samples + (seconds * RAYS_PER_SECOND) as u64,
        }
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
            Budget::Lights(_) | Budget::Seconds(_) => 0,
        }
    }

    fn built_technique(&self) -> Option<Box<dyn Technique>> {
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
    };
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
    let mut seen = std::collections::HashSet::new();
    plan.jobs
        .retain(|job| seen.insert((job.id.clone(), job.label.clone())));
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
    description: &'a SceneDescription,
    /// Name of the map in the description, if the config names one.
    environment: Option<&'a str>,
}

struct Planner<'a> {
    source: &'a Source,
    config: &'a Config,
    sweep: BTreeMap<String, Value>,
}

impl Planner<'_> {
    fn add_jobs(&self, plan: &mut Plan) -> Result<(), ConfigError> {
        let config = self.config;
        let technique = crate::registry::technique(&config.technique).ok_or_else(|| {
            let known: Vec<&str> = crate::registry::TECHNIQUES
                .iter()
                .map(|e| e.about.id)
                .collect();
            let message = format!(
                "no technique is called `{}`; known: {}",
                config.technique,
                known.join(", ")
            );
            self.source.error(&["technique"], message)
        })?;
        if technique.contenders == Contenders::None {
            let message = format!(
                "{} has no contenders to compare; use `lightbench render`",
                technique.about.id
            );
            return Err(self.source.error(&["technique"], message));
        }
        (technique.build)(&config.parameters).map_err(|error| {
            let path = ["parameters", error.key.as_deref().unwrap_or("")];
            self.source.error(&path, error.message)
        })?;
        if config.spp == 0 || config.repeats == 0 {
            return Err(self
                .source
                .error(&["spp"], "spp and repeats must be at least 1".into()));
        }
        let methods = self.methods(technique)?;
        for (index, choice) in config.scene.iter().enumerate() {
            let index = index.to_string();
            let (found, description) = match find_scene(&choice.name) {
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

    /// Method id, label and parameters, all checked.
    fn methods(
        &self,
        technique: &TechniqueEntry,
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
            let method = Method::new(technique, &id, &parameters).map_err(|error| {
                let key = error.key.as_deref().unwrap_or("id");
                self.source.error(&["method", &index, key], error.message)
            })?;
            let label = label.unwrap_or_else(|| method.id().to_owned());
            if methods.iter().any(|(_, known, _)| *known == label) {
                return Err(self.source.error(
                    &["method", &index],
                    format!("two methods are called `{label}`; give one of them another label"),
                ));
            }
            methods.push((method.id().to_owned(), label, parameters));
        }
        Ok(methods)
    }

    fn add_scene(
        &self,
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
        let budget = Budget::of(config, choice).map_err(|(key, message)| at(key, message))?;
        let mut technique_parameters = config.parameters.clone();
        if let Some(distance) = choice.ao_distance {
            technique_parameters.insert("distance".into(), Value::Float(distance));
        }
        let technique = crate::registry::technique(&config.technique).map_or("", |e| e.about.id);
        let name = choice.label.as_ref().unwrap_or(&description.name);
        let several = choice.environment.as_ref().or(config.environment.as_ref());
        let name = match environment {
            // A label of its own says all about a scene under one map.
            Some(map) if choice.label.is_none() || several.is_some_and(|e| e.names().len() > 1) => {
                format!("{name}/{map}")
            }
            _ => name.clone(),
        };
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
                    technique: technique.to_owned(),
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
                job.identify(&scene_key(description));
                plan.jobs.push(job);
            }
        }
        Ok(())
    }
}

impl Job {
    /// Fills in the content ids: of the reference from what it shows, of the job from what it does.
    fn identify(&mut self, scene: &str) {
        let own = crate::registry::technique(&self.technique).map_or(&[][..], |e| e.of_contenders);
        let (own, shared): (Vec<_>, Vec<_>) = self
            .technique_parameters
            .iter()
            .partition(|(key, _)| own.contains(&key.as_str()));
        let table = |entries: Vec<(&String, &Value)>| -> Table {
            let owned = entries.into_iter().map(|(k, v)| (k.clone(), v.clone()));
            owned.collect()
        };
        let own = (!own.is_empty()).then(|| table(own));
        let shown = serde_json::json!([
            REFERENCES,
            scene,
            self.view,
            self.transform,
            self.technique,
            table(shared),
            self.width,
            self.height,
            self.spp
        ]);
        self.reference = hash(&shown.to_string());
        let mut done = vec![
            serde_json::json!(RESULTS),
            serde_json::json!(self.reference),
            serde_json::json!(self.method),
            serde_json::json!(self.method_parameters),
            self.budget.key(),
            serde_json::json!(self.seed),
        ];
        done.extend(own.map(|own| serde_json::json!(own)));
        self.id = hash(&serde_json::Value::from(done).to_string());
    }
}

/// Sixteen hexadecimal digits of a text's hash.
pub fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}
