//! What a job runs: a contender of its technique, from an id and a parameter table.

use toml::Table;

use super::Distribution;
use super::irradiance_caching::on_demand::{self, OnDemand};
use super::per_sample::{PER_SAMPLE, PerSample};
use crate::entry::{About, ParameterError};
use crate::environment::EnvironmentSampler;
use crate::technique::{Contenders, TechniqueEntry};

/// A method that is no distribution.
pub struct MethodEntry {
    pub about: About,
    /// Ids of the techniques it is a contender of.
    pub techniques: &'static [&'static str],
    pub build: fn(&toml::Table) -> Result<Method, ParameterError>,
}

/// Methods that are no distributions.
pub const OTHER_METHODS: &[MethodEntry] = &[PER_SAMPLE, on_demand::ENTRY];

/// The method of a technique that is no distribution, by its id or alias, in any case.
pub fn other_method(technique: &str, id: &str) -> Option<&'static MethodEntry> {
    OTHER_METHODS
        .iter()
        .find(|e| e.about.answers_to(id) && e.techniques.contains(&technique))
}

/// A contender, ready to run.
pub enum Method {
    /// Records placed by a cache distribution.
    Distribution(Distribution),
    /// The function itself, estimated at every sample.
    PerSample(PerSample),
    /// A sampler of environment maps, and its canonical id.
    EnvironmentSampler(&'static str, EnvironmentSampler),
    /// The classic irradiance cache.
    OnDemand(OnDemand),
}

impl Method {
    /// Builds the method `id` of a technique.
    ///
    /// # Errors
    /// Ids that the technique does not take, unknown and unfit parameters; the key is named.
    pub fn new(
        technique: &TechniqueEntry,
        id: &str,
        parameters: &Table,
    ) -> Result<Self, ParameterError> {
        if let Some(other) = crate::technique::other_method(technique.about.id, id) {
            crate::entry::check_keys(parameters, &[&other.about])?;
            return (other.build)(parameters);
        }
        match technique.contenders {
            Contenders::None => Err(ParameterError {
                key: Some("id".into()),
                message: format!("{} has one method only: reference", technique.about.id),
            }),
            Contenders::EnvironmentSamplers => {
                let entry = crate::environment::environment_sampler(id).ok_or_else(|| {
                    let known = crate::environment::ENVIRONMENT_SAMPLERS
                        .iter()
                        .map(|e| e.about.id);
                    let known: Vec<&str> = known.collect();
                    ParameterError {
                        key: Some("id".into()),
                        message: format!(
                            "no sampler of environment maps is called `{id}`; known: {}",
                            known.join(", ")
                        ),
                    }
                })?;
                crate::entry::check_keys(parameters, &[&entry.about])?;
                let sampler = (entry.build)(parameters)?;
                Ok(Self::EnvironmentSampler(entry.about.id, sampler))
            }
            Contenders::Distributions => Ok(Self::Distribution(Distribution::new(id, parameters)?)),
        }
    }

    /// Canonical id.
    pub fn id(&self) -> &str {
        match self {
            Self::Distribution(distribution) => &distribution.id,
            Self::PerSample(_) => PER_SAMPLE.about.id,
            Self::EnvironmentSampler(id, _) => id,
            Self::OnDemand(_) => on_demand::ENTRY.about.id,
        }
    }

    /// Whether a setting is picked by error, which takes a reference.
    pub fn needs_reference(&self) -> bool {
        match self {
            Self::Distribution(distribution) => !distribution.first.candidates().is_empty(),
            Self::PerSample(_) | Self::OnDemand(_) | Self::EnvironmentSampler(..) => false,
        }
    }
}
