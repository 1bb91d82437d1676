//! What a config says about rows, checked before the first ray: claims, gates, tables, figures.

use super::claim::EVERY_SCENE;
use super::config::{Config, ConfigError, Source};
use super::equal_time::FOUND as LIGHTS_IN_TIME;
use super::expression::Expression;
use super::row::NUMBER_COLUMNS;

/// Checks every expression, label and column against the methods' labels and the scenes' names as
/// rows will carry them.
pub fn check(
    source: &Source,
    config: &Config,
    labels: &[String],
    scenes: &[String],
) -> Result<(), ConfigError> {
    let names = Names { labels, scenes };
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
        let parameter = |column: &str| {
            let first = crate::placement::FIRST_STAGES.iter().map(|e| &e.about);
            let refinements = crate::placement::REFINEMENTS.iter().map(|e| &e.about);
            let interpolations = crate::cache::interpolation::INTERPOLATIONS
                .iter()
                .map(|e| &e.about);
            first
                .chain(refinements)
                .chain(interpolations)
                .any(|about| about.parameters.iter().any(|p| p.key == column))
        };
        if NUMBER_COLUMNS.contains(&column)
            || column == "flip"
            || column == LIGHTS_IN_TIME
            || column.starts_with("seconds_")
            || parameter(column)
        {
            return Ok(());
        }
        Err(format!(
            "no column is called `{column}`; there are: {}, seconds_<stage> and the methods' parameters",
            NUMBER_COLUMNS.join(", ")
        ))
    }
}
