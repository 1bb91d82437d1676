//! From a config and overrides to the frozen list of jobs.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::EXACT;
use super::budget::Budget;
use super::config::{Config, ConfigError, SceneTransform, Source};
use super::darkness;
use super::limits;
use super::overrides::{self, Override};
use super::scene_key;
use super::scenes::{Additions, FoundScene, find_scenes};
use super::sequence::Sequence;
use super::sweep::Sweep;
use crate::technique::{Casts, Choice, Technique, TechniqueEntry, Terms};

/// A resolved experiment: nothing is left to decide before rays are traced.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Plan {
    /// Names the results folder.
    pub name: String,
    /// Heading of the report.
    pub title: String,
    /// The config files as given.
    pub configs: Vec<PathBuf>,
    /// The overrides as given, `key=value`.
    pub overrides: Vec<String>,
    /// Those that are to be run, in order.
    pub jobs: Vec<Job>,
    /// Scenes that were replaced or left out, a sentence each.
    pub notes: Vec<String>,
    /// How many jobs there are in all shards, where these are some of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sharded: Option<usize>,
    /// How many jobs the configs have, of which these may be a selection; of shards see `sharded`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub selected_of: Option<usize>,
    /// All jobs of the configs, in order, where `jobs` are a selection of them.
    #[serde(skip)]
    pub all: Vec<Job>,
}

impl Plan {
    /// How many jobs lie in shards that are not here.
    pub fn in_other_shards(&self) -> usize {
        let all = self.sharded.unwrap_or(0);
        all.saturating_sub(self.jobs.len())
    }

    /// Its notes, and that its jobs are a selection, where they are one.
    pub fn told(&self) -> Vec<String> {
        let some = self.jobs.len();
        let all = self.selected_of.filter(|all| some < *all);
        let selection = all.map(|all| format!("a selection: {some} of {all} jobs of the config"));
        self.notes.iter().cloned().chain(selection).collect()
    }
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
    /// The scene that the config names.
    pub asked: String,
    /// The paper's name of the scene.
    pub paper: Option<String>,
    /// The view, or the paths that viewers follow.
    pub view: String,
    /// What is seen over time; of a still one frame of one view. Older plans have stills only.
    #[serde(default)]
    pub sequence: Sequence,
    /// What the config adds to the scene.
    #[serde(default)]
    pub additions: Option<Additions>,
    /// Key of what the scene shows, and whether that changes with time.
    #[serde(default)]
    pub shown: String,
    /// Whether what is seen changes with time.
    #[serde(default)]
    pub moves: bool,
    /// A similarity applied to the whole scene, camera included.
    pub transform: Option<SceneTransform>,
    /// In place of what the scene declares.
    #[serde(default)]
    pub metres_per_unit: Option<f64>,
    /// In place of what the scene declares.
    #[serde(default)]
    pub max_depth: Option<u32>,
    /// Whether meshes, textures and material libraries of the scene may be absent.
    #[serde(default)]
    pub incomplete: bool,
    /// Canonical id of what is computed.
    pub technique: String,
    /// Those that the config sets or sweeps; the others have their defaults.
    pub technique_parameters: Table,
    /// Canonical id of the method; [`super::EXACT`] for the shading function itself.
    pub method: String,
    /// What tables call the contender.
    pub label: String,
    /// Those that the config sets or sweeps; the others have their defaults.
    pub method_parameters: Table,
    /// Map that replaces the scene's, by name.
    pub environment: Option<String>,
    /// What the contenders share; records are scaled with the image.
    pub budget: Budget,
    /// Tells repeats of a case apart.
    pub seed: u64,
    /// Pixels, scaled.
    pub width: usize,
    /// Pixels, scaled.
    pub height: usize,
    /// Sub-pixel samples of reference and contenders alike.
    pub spp: u32,
    /// Swept keys and their values in this job.
    pub sweep: BTreeMap<String, Value>,
    /// Other values of swept keys that its method does not have: it is the job of these as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also_at: Vec<BTreeMap<String, Value>>,
    /// Key of the reference image; of a sequence one that stands for all of its references.
    pub reference: String,
    /// Keys of all of its references, frame by frame; not written with a plan.
    #[serde(skip)]
    pub references: Arc<[String]>,
    /// Whether the job counts as done with non-finite samples.
    pub allow_non_finite: bool,
}

impl Job {
    /// Rays this job will cast, at most: camera rays, and evaluations of its records or shadow rays
    /// of its lights.
    pub fn estimated_rays(&self) -> u64 {
        let pixels = (self.width * self.height) as u64;
        let casts = Casts {
            pixels: pixels as f64,
            samples: (pixels * u64::from(self.spp)) as f64,
            rays_per_evaluation: self.rays_per_evaluation() as f64,
        };
        let image = (self.budget.unit.rays)(self.budget.amount, &casts) as u64;
        image * self.sequence.images() as u64
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

    /// Rays of all its references.
    pub fn reference_rays(&self) -> u64 {
        let images = self.sequence.measured().count() * self.sequence.viewers.len();
        self.rays_of_reference() * images as u64
    }

    /// Rays of one of its references.
    pub fn rays_of_reference(&self) -> u64 {
        let pixels = (self.width * self.height) as u64;
        self.built_technique().map_or(0, |technique| {
            let samples = u64::from(technique.reference_samples(self.spp));
            pixels * samples * technique.rays_per_reference_sample()
        })
    }

    /// Bytes its records will take.
    pub fn estimated_bytes(&self) -> u64 {
        let technique = self.built_technique();
        let records = self.budget.count().unwrap_or(0);
        records * technique.map_or(0, |t| t.bytes_per_record())
    }

    /// Its contender, with a number of records, lights or samples.
    pub(super) fn choice(&self, count: u64) -> Choice<'_> {
        Choice {
            method: &self.method,
            parameters: &self.method_parameters,
            terms: Terms {
                budget: count as usize,
                seed: self.seed,
            },
        }
    }

    pub(super) fn built_technique(&self) -> Option<Box<dyn Technique>> {
        let entry = crate::registry::technique(&self.technique)?;
        (entry.build)(&self.technique_parameters).ok()
    }
}

/// Plans one config under overrides. With several values anywhere, every combination is planned.
pub fn plan(source: &Source, overrides: &[Override]) -> Result<(Config, Plan), ConfigError> {
    limits::check_numbers(source)?;
    let written: Config = source.parse()?;
    let changed = overrides.iter().map(|o| &o.key);
    Additions::refuse_overrides(changed.chain(written.sweep.keys()))?;
    let single = overrides::single(overrides);
    let base = if single.is_empty() {
        written
    } else {
        source.parse_with(&single)?
    };
    let sweep = Sweep::new(source, &base.sweep, overrides);
    limits::check_names(source, &base)?;
    limits::check_axes(&sweep)?;
    limits::check_count(source, &base, &sweep.axes)?;
    let mut plan = Plan {
        name: base.name.clone(),
        title: base.title.clone(),
        configs: vec![source.file.clone()],
        overrides: overrides.iter().map(Override::to_string).collect(),
        jobs: Vec::new(),
        notes: Vec::new(),
        sharded: None,
        selected_of: None,
        all: Vec::new(),
    };
    overrides::tell_reach(overrides, &base.scene, &mut plan.notes)?;
    let mut cases = HashMap::new();
    for combination in sweep.combinations() {
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
            is_image: false,
        }
        .add_jobs(&mut plan)?;
    }
    limits::check_jobs(source, &base, &plan)?;
    super::check::check(source, &base, &plan.jobs)?;
    plan.notes.sort();
    plan.notes.dedup();
    // All jobs of a scene together, so that it is loaded once; otherwise in the order written.
    let mut order: HashMap<String, usize> = HashMap::new();
    for job in &plan.jobs {
        let next = order.len();
        order.entry(job.scene.clone()).or_insert(next);
    }
    plan.jobs.sort_by_key(|job| order[&job.scene]);
    sweep.leave_each_once(&mut plan.jobs)?;
    plan.all.clone_from(&plan.jobs);
    Ok((base, plan))
}

pub(super) struct Planner<'a> {
    pub source: &'a Source,
    pub config: &'a Config,
    pub sweep: BTreeMap<String, Value>,
    /// Scene, view and swept values of the jobs so far, and the position of their scene.
    pub cases: &'a mut HashMap<String, usize>,
    /// Whether single images are planned: then the exact function is a method too, and the budget has a
    /// default.
    pub is_image: bool,
}

impl Planner<'_> {
    pub fn add_jobs(&mut self, plan: &mut Plan) -> Result<(), ConfigError> {
        let config = self.config;
        let technique = self.technique()?;
        let built = (technique.build)(&config.parameters).map_err(|error| {
            let path = ["parameters", &error.key];
            self.source.error(&path, error.message)
        })?;
        limits::check_samples(self.source, config)?;
        let methods = self.methods(built.as_ref())?;
        for index in 0..config.scene.len() {
            for scene in find_scenes(self.source, config, index, &mut plan.notes)? {
                self.add_scene(plan, &scene, &methods)?;
            }
        }
        Ok(())
    }

    fn technique(&self) -> Result<&'static TechniqueEntry, ConfigError> {
        let technique = crate::registry::technique_named(&self.config.technique);
        technique.map_err(|message| self.source.error(&["technique"], message))
    }

    /// The technique's parameters in one scene.
    fn technique_parameters(
        &self,
        technique: &TechniqueEntry,
        scene: &FoundScene,
    ) -> Result<Table, ConfigError> {
        let mut parameters = self.config.parameters.clone();
        let Some(distance) = scene.choice.ao_distance else {
            return Ok(parameters);
        };
        let about = &technique.about;
        if !about.parameters.iter().any(|p| p.key == "distance") {
            let message = format!(
                "{} takes no `ao_distance`: remove it from the scene",
                about.id
            );
            return Err(scene.error("ao_distance", message));
        }
        if !((distance as f32).is_finite() && distance as f32 > 0.0) {
            let message = format!(
                "ao_distance: expected a distance above 0, scene units, that single precision holds, found {distance:e}"
            );
            return Err(scene.error("ao_distance", message));
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
            let id = if self.is_image && id.eq_ignore_ascii_case(EXACT) {
                EXACT.to_owned()
            } else {
                let started = technique.start(&id, &parameters, Terms::default());
                let started = started.map_err(|error| {
                    let path = ["method", &index, &error.key];
                    self.source.error(&path, error.message)
                })?;
                started.id
            };
            let label = label.unwrap_or_else(|| id.clone());
            limits::check_label(&label)
                .map_err(|message| self.source.error(&["method", &index, "label"], message))?;
            if methods.iter().any(|(_, known, _)| *known == label) {
                return Err(self.source.error(
                    &["method", &index],
                    format!("two methods are called `{label}`; give one of them another label"),
                ));
            }
            methods.push((id, label, parameters));
        }
        Ok(methods)
    }

    fn add_scene(
        &mut self,
        plan: &mut Plan,
        scene: &FoundScene,
        methods: &[(String, String, Table)],
    ) -> Result<(), ConfigError> {
        let (config, choice, description) = (self.config, scene.choice, &scene.description);
        let (sequence, view) = scene.sequence(config)?;
        let [width, height] = scene.size(config, &view)?;
        let place = sequence.place();
        let entry = self.technique()?;
        let usual = self
            .is_image
            .then(|| (entry.units[0].usual)((width * height) as f64));
        let budget = Budget::of(entry, config, choice, usual)
            .map_err(|(key, message)| scene.error(key, message))?;
        let technique_parameters = self.technique_parameters(entry, scene)?;
        let technique = (entry.build)(&technique_parameters)
            .map_err(|error| scene.error("ao_distance", error.message))?;
        technique
            .fits(description)
            .map_err(|message| scene.error("name", message))?;
        if scene.environment.is_some() && !technique.needs().environment {
            let message = format!("{} takes no `environment`: leave it out", entry.about.id);
            return Err(match choice.environment {
                Some(_) => scene.error("environment", message),
                None => self.source.error(&["environment"], message),
            });
        }
        description
            .require_files(technique.needs(), choice.incomplete)
            .map_err(|error| scene.error("name", error.to_string()))?;
        let shown = darkness::Shown::of(entry.about.id, technique.needs(), description);
        darkness::refuse_declared(shown, description, &sequence)
            .map_err(|message| scene.error("name", message))?;
        if let Some(transform) = &choice.transform {
            transform
                .check()
                .map_err(|message| scene.error("transform", message))?;
        }
        if self.is_left_out(plan, scene, &place, &methods[0].1)? {
            return Ok(());
        }
        let key = scene_key(description);
        let mut references: Option<(String, Arc<[String]>)> = None;
        for (method, label, parameters) in methods {
            for repeat in 0..config.repeats {
                let mut job = Job {
                    id: String::new(),
                    scene: scene.name.clone(),
                    found: scene.found.clone(),
                    asked: choice.name.clone(),
                    paper: choice.paper.clone(),
                    view: place.clone(),
                    sequence: sequence.clone(),
                    additions: scene.additions.clone(),
                    shown: key.clone(),
                    moves: !description.motions.is_empty(),
                    transform: choice.transform,
                    metres_per_unit: choice.metres_per_unit,
                    max_depth: choice.max_depth,
                    incomplete: choice.incomplete,
                    technique: entry.about.id.to_owned(),
                    technique_parameters: technique_parameters.clone(),
                    method: method.clone(),
                    label: label.clone(),
                    method_parameters: parameters.clone(),
                    environment: scene.environment.clone(),
                    budget,
                    seed: config.seed + u64::from(repeat),
                    width,
                    height,
                    spp: config.spp,
                    sweep: self.sweep.clone(),
                    also_at: Vec::new(),
                    reference: String::new(),
                    references: Arc::default(),
                    allow_non_finite: config.allow_non_finite,
                };
                let shared = references.get_or_insert_with(|| job.references(description));
                (job.reference, job.references) = shared.clone();
                job.identify(entry, technique.as_ref());
                plan.jobs.push(job);
            }
        }
        Ok(())
    }

    /// Whether the jobs of a scene are planned already, under a scene that this one's stand-in is. Two
    /// scenes that were both found are an error, which names a method of theirs.
    fn is_left_out(
        &mut self,
        plan: &mut Plan,
        scene: &FoundScene,
        view: &str,
        method: &str,
    ) -> Result<bool, ConfigError> {
        let case = serde_json::json!([scene.name, view, self.sweep]).to_string();
        let Some(earlier) = self.cases.insert(case, scene.index) else {
            return Ok(false);
        };
        let asked = &scene.choice.name;
        let found = &scene.found;
        if found != asked {
            plan.notes.push(format!(
                "`{asked}` is left out: `{found}`, which stands in for it, is there already"
            ));
            return Ok(true);
        }
        let message = format!(
            "scenes {} and {} of this config give the same jobs twice, such as scene `{}`, view \
             `{view}`, {method}, seed {}: give one of them another `label`",
            earlier + 1,
            scene.index + 1,
            scene.name,
            self.config.seed,
        );
        let path = ["scene", &scene.index.to_string()];
        Err(self.source.error(&path, message))
    }
}
