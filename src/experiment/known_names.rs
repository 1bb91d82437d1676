//! What claims, tables and figures of a config may name: methods, scenes, columns and swept values.

use std::collections::{BTreeMap, BTreeSet};

use super::case::{Case, NamedPlace, Swept, as_in_rows, name_places, place_named, value_text};
use super::claim::EVERY_SCENE;
use super::config::Config;
use super::expression::Expression;
use super::named::Named;
use super::{Job, columns};
use crate::cache::interpolation::INTERPOLATIONS;
use crate::registry::TECHNIQUES;
use crate::suggest::hint;

fn no_scene(scene: &str, known: &[&str]) -> String {
    let hint = match hint(scene, known) {
        none if none.is_empty() => ".".to_owned(),
        hint => hint,
    };
    let known = known.join(", ");
    format!("no scene is called `{scene}`{hint} There are: {known}")
}

/// What claims, tables and figures may name.
pub(super) struct Names<'a> {
    labels: Vec<&'a str>,
    places: Vec<NamedPlace>,
    /// Keys, and what they are set to in turn: as the config has it, and as overrides do.
    swept: BTreeMap<String, BTreeSet<String>>,
}

impl<'a> Names<'a> {
    pub(super) fn of(config: &Config, jobs: &'a [Job]) -> Self {
        let mut labels: Vec<&str> = jobs.iter().map(|job| job.label.as_str()).collect();
        labels.sort_unstable();
        labels.dedup();
        let mut swept: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (key, values) in &config.sweep {
            let values = values.iter().map(|value| value_text(&as_in_rows(value)));
            swept.insert(key.clone(), values.collect());
        }
        for (key, value) in jobs.iter().flat_map(|job| Swept::of_job(job).values) {
            swept.entry(key).or_default().insert(value_text(&value));
        }
        let places = jobs.iter().map(|job| (Case::of_job(job).place, None));
        Self {
            labels,
            places: name_places(places),
            swept,
        }
    }

    pub(super) fn expression(&self, text: &str) -> Result<(), String> {
        let expression = Expression::parse(text)?;
        for (column, label) in expression.names() {
            self.column(column)?;
            let named = Named::parse(label)?;
            self.label(named.label)?;
            named.scene.map_or(Ok(()), |scene| self.scene(scene))?;
            for (key, value) in named.at {
                self.swept_value(key, value)?;
            }
        }
        Ok(())
    }

    fn scene(&self, scene: &str) -> Result<(), String> {
        if scene == EVERY_SCENE || place_named(&self.places, scene).is_some() {
            return Ok(());
        }
        let list = |of: &dyn Fn(&&NamedPlace) -> bool| {
            let names: Vec<&str> = self
                .places
                .iter()
                .filter(of)
                .map(|p| p.name.as_str())
                .collect();
            names.join(", ")
        };
        match list(&|p| p.place.scene == scene) {
            views if views.is_empty() => Err(format!(
                "no scene is called `{scene}`{}; there are: {}",
                hint(scene, &self.scenes()),
                list(&|_| true)
            )),
            views => Err(format!(
                "`{scene}` is seen from several views; say which: {views}"
            )),
        }
    }

    /// Checks a scene that a claim or gate is about.
    pub(super) fn scene_of(&self, config: &Config, scene: &str) -> Result<(), String> {
        let known = self.known_scenes(config);
        match known.contains(&scene) {
            true => Ok(()),
            false => Err(no_scene(scene, &known)),
        }
    }

    /// Checks the pattern of scenes that a figure shows.
    pub(super) fn shown(&self, config: &Config, pattern: &str) -> Result<(), String> {
        let known = self.known_scenes(config);
        if known.contains(&pattern) {
            return Ok(());
        }
        let glob = glob::Pattern::new(pattern)
            .map_err(|error| format!("`{pattern}` is no pattern of names: {error}"))?;
        match known.iter().any(|name| glob.matches(name)) {
            true => Ok(()),
            false => Err(no_scene(pattern, &known)),
        }
    }

    /// Any name that a scene has, each once: the paper's too, and that of a scene which another may stand in for.
    fn known_scenes<'b>(&'b self, config: &'b Config) -> Vec<&'b str> {
        let written = config.scene.iter().flat_map(|choice| {
            let replaced = choice.otherwise.as_ref().map(|_| choice.name.as_str());
            choice.paper.as_deref().into_iter().chain(replaced)
        });
        let mut known = self.scenes();
        known.extend(self.places.iter().map(|p| p.place.scene.as_str()));
        known.extend(written);
        let mut seen = BTreeSet::new();
        known.retain(|name| seen.insert(*name));
        known
    }

    fn scenes(&self) -> Vec<&str> {
        self.places.iter().map(|p| p.name.as_str()).collect()
    }

    pub(super) fn label(&self, label: &str) -> Result<(), String> {
        if self.labels.contains(&label) {
            return Ok(());
        }
        Err(format!(
            "no method is called `{label}`{}; there are: {}",
            hint(label, &self.labels),
            self.labels.join(", ")
        ))
    }

    /// Checks a value that a claim or gate names behind `;`.
    fn swept_value(&self, key: &str, value: &str) -> Result<(), String> {
        let Some(values) = self.swept.get(key) else {
            let known: Vec<&str> = self.swept.keys().map(String::as_str).collect();
            return Err(format!(
                "`{key}` is not swept{}; there are: {}",
                hint(key, &known),
                known.join(", ")
            ));
        };
        if values.contains(value) {
            return Ok(());
        }
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        Err(format!(
            "`{key}` is never {value} in the sweep, but {}",
            values.join(", ")
        ))
    }

    pub(super) fn column(&self, column: &str) -> Result<(), String> {
        if columns::is_declared(column)
            || self.swept.contains_key(column)
            || parameters().any(|key| key == column)
        {
            return Ok(());
        }
        let mut known: Vec<&str> = columns::declared().chain(parameters()).collect();
        known.extend(self.swept.keys().map(String::as_str));
        let hint = match hint(column, &known) {
            none if none.is_empty() => ".".to_owned(),
            hint => hint,
        };
        let listed: Vec<&str> = columns::declared().collect();
        Err(format!(
            "no column is called `{column}`{hint} There are: {}, seconds_<stage>, cpu_seconds_<stage>, \
             serial_share_<stage>, the methods' parameters and swept keys",
            listed.join(", ")
        ))
    }
}

/// Parameters that any contender declares: rows carry those that are set.
fn parameters() -> impl Iterator<Item = &'static str> {
    let listed = TECHNIQUES
        .iter()
        .flat_map(|technique| (technique.contenders)());
    let parts = listed.flat_map(|listed| listed.parts);
    let interpolations = INTERPOLATIONS.iter().map(|e| &e.about);
    parts
        .chain(interpolations)
        .flat_map(|about| about.parameters.iter().map(|p| p.key))
}
