//! What a config says about rows, checked before the first ray: claims, gates, tables, figures.

use std::collections::BTreeMap;

use super::claim::EVERY_SCENE;
use super::columns;
use super::config::{Config, ConfigError, Source};
use super::expression::Expression;
use crate::cache::interpolation::INTERPOLATIONS;
use crate::environment::ENVIRONMENT_SAMPLERS;
use crate::placement::{FIRST_STAGES, REFINEMENTS};
use crate::technique::OTHER_METHODS;

/// Checks every expression, label and column against the methods' labels and the scenes' names as
/// rows will carry them.
pub fn check(
    source: &Source,
    config: &Config,
    labels: &[String],
    scenes: &[String],
) -> Result<(), ConfigError> {
    let names = Names {
        labels,
        scenes,
        swept: &config.sweep,
    };
    let claims = config.claim.iter().map(|c| &c.expect).enumerate();
    let gates = config.gate.iter().map(|g| &g.expect).enumerate();
    for (list, (index, expect)) in claims
        .map(|c| ("claim", c))
        .chain(gates.map(|g| ("gate", g)))
    {
        let path = [list, &index.to_string(), "expect"];
        names
            .expression(expect)
            .map_err(|message| source.error(&path, message))?;
    }
    for (index, table) in config.table.iter().enumerate() {
        for column in table.metrics.iter().chain([&table.cost]) {
            names.column(column).map_err(|message| {
                source.error(&["table", &index.to_string(), "metrics"], message)
            })?;
        }
    }
    for (index, figure) in config.figure.iter().enumerate() {
        let index = index.to_string();
        for column in figure.x.iter().chain(&figure.y) {
            names
                .column(column)
                .map_err(|message| source.error(&["figure", &index], message))?;
        }
        for label in &figure.methods {
            names
                .label(label)
                .map_err(|message| source.error(&["figure", &index, "methods"], message))?;
        }
    }
    Ok(())
}

struct Names<'a> {
    labels: &'a [String],
    scenes: &'a [String],
    /// Swept keys of the config.
    swept: &'a BTreeMap<String, Vec<toml::Value>>,
}

impl Names<'_> {
    fn expression(&self, text: &str) -> Result<(), String> {
        let expression = Expression::parse(text)?;
        for (column, label) in expression.names() {
            self.column(column)?;
            match label.split_once('@') {
                None => self.label(label)?,
                Some((label, scene)) => {
                    self.label(label)?;
                    if scene != EVERY_SCENE && !self.scenes.iter().any(|s| s == scene) {
                        return Err(format!(
                            "no scene is called `{scene}`; there are: {}",
                            self.scenes.join(", ")
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    fn label(&self, label: &str) -> Result<(), String> {
        if self.labels.iter().any(|l| l == label) {
            return Ok(());
        }
        Err(format!(
            "no method is called `{label}`; there are: {}",
            self.labels.join(", ")
        ))
    }

    fn column(&self, column: &str) -> Result<(), String> {
        if columns::is_declared(column)
            || self.swept.contains_key(column)
            || parameters().any(|key| key == column)
        {
            return Ok(());
        }
        let mut known: Vec<&str> = columns::declared().chain(parameters()).collect();
        known.extend(self.swept.keys().map(String::as_str));
        let advice = nearest(column, &known)
            .map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        let listed: Vec<&str> = columns::declared().collect();
        Err(format!(
            "no column is called `{column}`{advice} There are: {}, seconds_<stage>, cpu_seconds_<stage>, \
             serial_share_<stage>, the methods' parameters and swept keys",
            listed.join(", ")
        ))
    }
}

/// Parameters that any contender declares: rows carry those that are set.
fn parameters() -> impl Iterator<Item = &'static str> {
    let first = FIRST_STAGES.iter().map(|e| &e.about);
    let refinements = REFINEMENTS.iter().map(|e| &e.about);
    let interpolations = INTERPOLATIONS.iter().map(|e| &e.about);
    let others = OTHER_METHODS.iter().map(|e| &e.about);
    let samplers = ENVIRONMENT_SAMPLERS.iter().map(|e| &e.about);
    first
        .chain(refinements)
        .chain(interpolations)
        .chain(others)
        .chain(samplers)
        .flat_map(|about| about.parameters.iter().map(|p| p.key))
}

/// The name that is most like another, if it could be a slip of the finger.
fn nearest<'a>(wrong: &str, known: &[&'a str]) -> Option<&'a str> {
    let distance = |name: &str| strsim::damerau_levenshtein(wrong, name);
    let near = known.iter().copied().min_by_key(|name| distance(name))?;
    (distance(near) <= 1 + wrong.len().max(near.len()) / 3).then_some(near)
}
