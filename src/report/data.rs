//! The rows of a results folder, grouped the way tables and figures ask for them.

use std::collections::{BTreeMap, HashSet};
use std::io;
use std::path::Path;

use serde_json::Value;

use super::estimate::Estimate;
use crate::experiment::{Config, EVERY_SCENE, Job, Plan, Row, Store};

/// Everything a report is made of, but the images.
pub struct Data {
    pub store: Store,
    pub plan: Plan,
    pub config: Config,
    pub rows: Vec<Row>,
    /// `provenance.json`, or null.
    pub provenance: Value,
    /// In the order of the plan.
    pub scenes: Vec<SceneOf>,
    /// Labels of the methods, in the order of the plan.
    pub labels: Vec<String>,
    /// Combinations of swept values, in the order of the plan; one empty one without a sweep.
    pub points: Vec<SweepPoint>,
}

/// A scene as rows call it.
#[derive(Clone, Debug)]
pub struct SceneOf {
    pub name: String,
    /// The paper's name.
    pub paper: Option<String>,
}

/// One combination of swept values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepPoint {
    pub values: Vec<(String, Value)>,
}

impl SceneOf {
    /// Stands for the mean over all scenes.
    pub fn all() -> Self {
        Self {
            name: EVERY_SCENE.into(),
            paper: None,
        }
    }
}

impl SweepPoint {
    fn of_job(job: &Job) -> Self {
        let value = |v: &toml::Value| serde_json::to_value(v).unwrap_or(Value::Null);
        Self {
            values: job
                .sweep
                .iter()
                .map(|(k, v)| (k.clone(), value(v)))
                .collect(),
        }
    }

    fn of_row(row: &Row) -> Self {
        let mut values: Vec<_> = row
            .sweep
            .iter()
            .map(|(k, v)| (k.clone(), v.clone()))
            .collect();
        values.sort_by(|a, b| a.0.cmp(&b.0));
        Self { values }
    }

    /// `caches=100 ratio=0.5`, as claims name it; empty without a sweep.
    pub fn text(&self) -> String {
        let parts: Vec<String> = self
            .values
            .iter()
            .map(|(k, v)| format!("{k}={}", value_text(v)))
            .collect();
        parts.join(" ")
    }

    /// The values alone.
    pub fn short(&self) -> String {
        let parts: Vec<String> = self.values.iter().map(|(_, v)| value_text(v)).collect();
        parts.join(", ")
    }

    /// The swept keys.
    pub fn keys(&self) -> String {
        let keys: Vec<&str> = self.values.iter().map(|(k, _)| k.as_str()).collect();
        keys.join(", ")
    }
}

fn value_text(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// A contender in a scene at a swept value: what its repeats share.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    pub scene: &'a str,
    pub label: &'a str,
    pub point: &'a SweepPoint,
}

impl Data {
    /// Reads a results folder.
    pub fn read(folder: &Path) -> io::Result<Self> {
        let store = Store::open(folder)?;
        let named = |name: &str, error: io::Error| {
            io::Error::new(
                error.kind(),
                format!("{}: {error}", folder.join(name).display()),
            )
        };
        let plan = store.plan().map_err(|e| named("plan.json", e))?;
        let config = store.config().map_err(|e| named("config.json", e))?;
        let rows = store.rows(&plan);
        let provenance = std::fs::read_to_string(folder.join("provenance.json"))
            .ok()
            .and_then(|text| serde_json::from_str(&text).ok())
            .unwrap_or(Value::Null);
        let mut data = Self {
            store,
            config,
            rows,
            provenance,
            scenes: Vec::new(),
            labels: Vec::new(),
            points: Vec::new(),
            plan,
        };
        data.group();
        Ok(data)
    }

    fn group(&mut self) {
        for job in &self.plan.jobs {
            if !self.scenes.iter().any(|s| s.name == job.scene) {
                self.scenes.push(SceneOf {
                    name: job.scene.clone(),
                    paper: job.paper.clone(),
                });
            }
            if !self.labels.contains(&job.label) {
                self.labels.push(job.label.clone());
            }
            let point = SweepPoint::of_job(job);
            if !self.points.contains(&point) {
                self.points.push(point);
            }
        }
        if self.points.is_empty() {
            self.points.push(SweepPoint::default());
        }
    }

    /// Whether more than one combination of values was swept.
    pub fn swept(&self) -> bool {
        self.points.len() > 1
    }

    /// Finished rows of a case, one a seed.
    pub fn rows_of<'a>(&'a self, case: Case<'a>) -> impl Iterator<Item = &'a Row> {
        self.rows.iter().filter(move |row| {
            row.ok()
                && row.scene == case.scene
                && row.label == case.label
                && SweepPoint::of_row(row) == *case.point
        })
    }

    /// Mean and interval of a column over the repeats of a case; values that are missing or not
    /// finite are left out. `None` when nothing is left.
    pub fn estimate(&self, case: Case, column: &str) -> Option<Estimate> {
        if case.scene == EVERY_SCENE {
            return self.mean_of_scenes(case, column);
        }
        let by_seed: BTreeMap<u64, f64> = self
            .rows_of(case)
            .filter_map(|row| Some((row.seed, row.number(column)?)))
            .filter(|(_, value)| value.is_finite())
            .collect();
        Estimate::new(by_seed)
    }

    /// For each seed the mean over the scenes, as long as all of them have a value.
    fn mean_of_scenes(&self, case: Case, column: &str) -> Option<Estimate> {
        let estimates: Vec<Estimate> = self
            .scenes
            .iter()
            .map(|scene| {
                let scene = &scene.name;
                self.estimate(Case { scene, ..case }, column)
            })
            .collect::<Option<_>>()?;
        let seeds = estimates.first()?.by_seed.keys();
        let mean = |seed: &u64| {
            let values = estimates.iter().map(|e| e.by_seed.get(seed).copied());
            let values: Vec<f64> = values.collect::<Option<_>>()?;
            Some((*seed, values.iter().sum::<f64>() / values.len() as f64))
        };
        Estimate::new(seeds.filter_map(mean).collect())
    }

    /// The experiment's title, or its name.
    pub fn title(&self) -> &str {
        if self.plan.title.is_empty() {
            &self.plan.name
        } else {
            &self.plan.title
        }
    }

    /// Jobs of the plan without a row.
    pub fn missing(&self) -> Vec<&Job> {
        let there: HashSet<&str> = self.rows.iter().map(|r| r.job.as_str()).collect();
        self.plan
            .jobs
            .iter()
            .filter(|job| !there.contains(job.id.as_str()))
            .collect()
    }

    /// Rows of jobs that failed.
    pub fn failed(&self) -> Vec<&Row> {
        self.rows.iter().filter(|row| !row.ok()).collect()
    }

    /// Shortfalls and fallbacks of the rows: each text once, with the runs it belongs to.
    pub fn row_notes(&self) -> Vec<(String, Vec<String>)> {
        let mut notes: Vec<(String, Vec<String>)> = Vec::new();
        for row in &self.rows {
            let place = format!("{} {}", row.scene, row.label);
            for note in &row.notes {
                let known = notes.iter().position(|(text, _)| text == note);
                let index = known.unwrap_or(notes.len());
                if known.is_none() {
                    notes.push((note.clone(), Vec::new()));
                }
                if !notes[index].1.contains(&place) {
                    notes[index].1.push(place.clone());
                }
            }
        }
        notes
    }
}

impl SceneOf {
    /// The name, with the paper's where it differs.
    pub fn title(&self) -> String {
        if self.name == EVERY_SCENE {
            return "Mean of all scenes".into();
        }
        match &self.paper {
            Some(paper) if !paper.eq_ignore_ascii_case(&self.name) => {
                format!("{} ({paper})", self.name)
            }
            _ => self.name.clone(),
        }
    }
}
