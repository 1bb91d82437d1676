//! What a job runs: a contender of its technique, from an id and a parameter table.

use serde::Deserialize;
use toml::Table;

use super::Distribution;
use crate::registry::{
    self, About, Bias, Contenders, MethodEntry, Parameter, ParameterError, TechniqueEntry,
};

/// A contender, ready to run.
pub enum Method {
    /// Records placed by a cache distribution.
    Distribution(Distribution),
    /// The function itself, estimated at every sample.
    PerSample(PerSample),
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
        match technique.contenders {
            Contenders::None => Err(ParameterError {
                key: Some("id".into()),
                message: format!("{} has one method only: reference", technique.about.id),
            }),
            Contenders::Distributions if PER_SAMPLE.about.answers_to(id) => {
                registry::check_keys(parameters, &[&PER_SAMPLE.about])?;
                Ok(Self::PerSample(registry::parameters(parameters)?))
            }
            Contenders::Distributions => Ok(Self::Distribution(Distribution::new(id, parameters)?)),
        }
    }

    /// Canonical id.
    pub fn id(&self) -> &str {
        match self {
            Self::Distribution(distribution) => &distribution.id,
            Self::PerSample(_) => PER_SAMPLE.about.id,
        }
    }

    /// Whether a setting is picked by error, which takes a reference.
    pub fn needs_reference(&self) -> bool {
        match self {
            Self::Distribution(distribution) => !distribution.first.candidates().is_empty(),
            Self::PerSample(_) => false,
        }
    }
}

/// The outside contender of cached techniques: no records, the function estimated at every camera
/// sample with few random samples.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PerSample {
    /// Estimates of each pixel; `None` takes as many as cost the rays of the budget's records.
    pub passes: Option<std::num::NonZeroU32>,
}

/// The registry's entry.
pub const PER_SAMPLE: MethodEntry = MethodEntry {
    about: About {
        id: "per-sample",
        aliases: &["path-tracing", "monte-carlo"],
        summary: "no records: the function itself, estimated at every camera sample with as many \
                  rays as the records would take",
        source: "the outside contender of cached techniques: path tracing for irradiance, random \
                 occlusion rays for ambient occlusion",
        bias: Bias::Unbiased,
        failures: &["noise falls with the square root of the rays only"],
        parameters: &[Parameter {
            key: "passes",
            default: "equal rays",
            unit: "",
            meaning: "estimates of each pixel; by default passes are added until the rays counted \
                      reach those of evaluating the budget's records, measured on 64 of them",
        }],
    },
};
