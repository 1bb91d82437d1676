//! The one table of methods.

use crate::placement::{FirstStage, Refinement};
use crate::technique::{Technique, ambient_occlusion};

/// How a method's error behaves as its budget grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bias {
    /// Equal to the reference within rounding.
    Exact,
    /// Right on average at any budget.
    Unbiased,
    /// Converges to the reference as the budget grows.
    Consistent,
    /// Keeps an error at any budget.
    Biased,
}

/// A wrong parameter of a method: the key and what is expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ParameterError {
    /// Key in the parameter table, if the error belongs to one.
    pub key: Option<String>,
    pub message: String,
}

/// What every entry of the registry says of itself.
#[derive(Clone, Copy, Debug)]
pub struct About {
    pub id: &'static str,
    pub aliases: &'static [&'static str],
    /// One line.
    pub summary: &'static str,
    /// Paper, section and equations; "reconstruction" where it is one.
    pub source: &'static str,
    pub bias: Bias,
    /// Known failures, a sentence each.
    pub failures: &'static [&'static str],
    /// `(key, default, unit, meaning)` of each parameter.
    pub parameters: &'static [Parameter],
}

/// One documented parameter.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    pub key: &'static str,
    pub default: &'static str,
    /// Empty when dimensionless.
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// A first stage of placement.
pub struct FirstStageEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Box<dyn FirstStage>, ParameterError>,
}

/// A refinement of placement.
pub struct RefinementEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Box<dyn Refinement>, ParameterError>,
}

/// Deserializes a parameter struct, naming the key at fault.
pub fn parameters<T: serde::de::DeserializeOwned>(
    table: &toml::Table,
) -> Result<T, ParameterError> {
    T::deserialize(table.clone()).map_err(|error| ParameterError {
        key: None,
        message: error.message().to_owned(),
    })
}

/// A technique.
pub struct TechniqueEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Box<dyn Technique>, ParameterError>,
    /// Whether contenders are cache distributions; otherwise `reference` is the only method.
    pub distributions: bool,
}

/// All techniques.
pub const TECHNIQUES: &[&TechniqueEntry] = &[&ambient_occlusion::ENTRY];

/// The technique of an id or alias, whatever the case.
pub fn technique(id: &str) -> Option<&'static TechniqueEntry> {
    TECHNIQUES.iter().copied().find(|e| e.about.is(id))
}

impl About {
    /// Whether `name` is the id or an alias, whatever the case.
    pub fn is(&self, name: &str) -> bool {
        std::iter::once(&self.id)
            .chain(self.aliases)
            .any(|known| known.eq_ignore_ascii_case(name))
    }
}
