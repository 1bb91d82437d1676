//! The rows of a results folder, grouped the way tables and figures ask for them.

use std::io;
use std::path::Path;

use serde_json::Value;

use super::estimate::Estimate;
use super::references::References;
use crate::experiment::{
    Case, Cases, Config, EVERY_SCENE, Job, NamedPlace, Place, Plan, Row, Sequence, Store, Swept,
};

/// Everything a report is made of, but the images.
pub struct Data {
    pub store: Store,
    pub references: References,
    pub plan: Plan,
    pub config: Config,
    pub cases: Cases,
    /// `provenance.json`, or null.
    pub provenance: Value,
    /// In the order of the plan.
    pub scenes: Vec<SceneOf>,
}

/// A scene, from one of its views, as tables and figures show it.
#[derive(Clone, Debug)]
pub struct SceneOf {
    /// The scene's name, with the view where several of them occur.
    pub name: String,
    /// The paper's name.
    pub paper: Option<String>,
    pub place: Place,
}

impl SceneOf {
    /// Stands for the mean over all scenes.
    pub fn all() -> Self {
        Self {
            name: EVERY_SCENE.into(),
            paper: None,
            place: Place::default(),
        }
    }

    fn of(named: &NamedPlace) -> Self {
        Self {
            name: named.name.clone(),
            paper: named.paper.clone(),
            place: named.place.clone(),
        }
    }

    /// Whether it stands for the mean over all scenes.
    pub fn is_all(&self) -> bool {
        self.name == EVERY_SCENE
    }
}

/// A contender in a scene, or over all of them, at a swept value.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    pub scene: &'a SceneOf,
    pub label: &'a str,
    pub point: &'a Swept,
}

impl Data {
    /// Reads a results folder.
    pub fn read(folder: &Path) -> io::Result<Self> {
        let store = Store::open(folder)?;
        let plan = store.plan()?;
        let rows = store.rows(&plan);
        Self::of(folder, plan, rows)
    }

    /// A results folder of which the plan and its rows are known.
    pub fn of(folder: &Path, plan: Plan, rows: Vec<Row>) -> io::Result<Self> {
        let store = Store::open(folder)?;
        let config = store.config()?;
        let cases = Cases::new(&plan.jobs, rows);
        let provenance = std::fs::read_to_string(folder.join("provenance.json"))
            .ok()
            .and_then(|text| serde_json::from_str(&text).ok())
            .unwrap_or(Value::Null);
        Ok(Self {
            store,
            references: References::of(folder),
            config,
            scenes: cases.places.iter().map(SceneOf::of).collect(),
            cases,
            provenance,
            plan,
        })
    }

    /// Labels of the methods, in the order of the plan.
    pub fn labels(&self) -> &[String] {
        &self.cases.labels
    }

    /// Combinations of swept values, in the order of the plan; one empty one without a sweep.
    pub fn points(&self) -> &[Swept] {
        &self.cases.points
    }

    /// Whether more than one combination of values was swept.
    pub fn swept(&self) -> bool {
        self.points().len() > 1
    }

    /// The case that is asked for; that of no row for the mean over all scenes.
    pub fn case(&self, asked: Asked) -> Case {
        self.cases
            .case(&asked.scene.place, asked.label, asked.point)
    }

    /// The frames and viewers of the jobs at a scene and a swept value.
    pub fn sequence(&self, scene: &SceneOf, point: &Swept) -> Option<&Sequence> {
        let is_asked = |case: Case| case.place == scene.place && case.swept == *point;
        let here = |job: &&Job| Case::all_of_job(job).any(is_asked);
        Some(&self.plan.jobs.iter().find(here)?.sequence)
    }

    /// The scenes in which anything was to run at a swept value.
    pub fn expected<'a>(&'a self, point: &'a Swept) -> impl Iterator<Item = &'a SceneOf> {
        let scenes = self.scenes.iter();
        scenes.filter(|scene| self.cases.expects(&scene.place, point))
    }

    /// Mean and interval of a column over the repeats of a case; values that are missing or not
    /// finite are left out, which the estimate tells. `None` when nothing is left.
    pub fn estimate(&self, asked: Asked, column: &str) -> Option<Estimate> {
        if asked.scene.is_all() {
            return self.mean_of_scenes(asked, column);
        }
        let case = self.case(asked);
        let seeds = self.cases.seeds_of(&case);
        let value = |seed| Some((seed, self.cases.value(&case, seed, column)?));
        let estimate = Estimate::new(seeds.filter_map(value).collect())?;
        Some(estimate.of_expected(self.cases.seeds_of(&case).count()))
    }

    /// The same where every seed has a value: what means, ranks and other comparisons of scenes are made of.
    pub fn whole(&self, asked: Asked, column: &str) -> Option<Estimate> {
        let estimate = self.estimate(asked, column);
        estimate.filter(Estimate::is_whole)
    }

    /// For each seed the mean over the scenes, as long as all of them have a value with every seed.
    fn mean_of_scenes(&self, asked: Asked, column: &str) -> Option<Estimate> {
        let scenes = self.expected(asked.point);
        let estimates: Vec<Estimate> = scenes
            .map(|scene| self.whole(Asked { scene, ..asked }, column))
            .collect::<Option<_>>()?;
        Estimate::mean_of(&estimates)
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
        self.cases.missing(&self.plan.jobs)
    }

    /// Rows of jobs that failed.
    pub fn failed(&self) -> Vec<&Row> {
        self.cases.failed().collect()
    }
}

impl SceneOf {
    /// The name, with the paper's where it differs.
    pub fn title(&self) -> String {
        if self.is_all() {
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
