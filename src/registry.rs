//! The one table of methods.

use crate::cache::Interpolation;
use crate::cache::interpolation::{gradient, inverse_distance};
use crate::environment::{
    EnvironmentSampler, decomposition, fhis, kollig_keller, median_cut, mis, product_ratio,
    product_ratio_unbiased, tmms, variance_minimization,
};
use crate::placement::{FirstStage, Refinement, adaptive, dgs, egr, im, sd, vgc};
use crate::technique::irradiance_caching::on_demand;
use crate::technique::{
    Method, PER_SAMPLE, Technique, ambient_occlusion, environment_lighting, importance_caching,
    irradiance_caching, truth,
};

/// All techniques.
pub const TECHNIQUES: &[TechniqueEntry] = &[
    ambient_occlusion::ENTRY,
    environment_lighting::ENTRY,
    irradiance_caching::ENTRY,
    importance_caching::ENTRY,
    truth::DIRECT,
    truth::PATH_TRACING,
];

/// All first stages of placement.
pub const FIRST_STAGES: &[FirstStageEntry] = &[im::ENTRY, sd::ENTRY, vgc::ENTRY];

/// All refinements of placement.
pub const REFINEMENTS: &[RefinementEntry] = &[adaptive::ENTRY, dgs::ENTRY, egr::ENTRY];

/// All rules of interpolation between records.
pub const INTERPOLATIONS: &[InterpolationEntry] = &[inverse_distance::ENTRY, gradient::ENTRY];

/// All samplers of environment maps.
pub const ENVIRONMENT_SAMPLERS: &[SamplerEntry] = &[
    mis::ENTRY,
    fhis::ENTRY,
    median_cut::ENTRY,
    variance_minimization::ENTRY,
    tmms::ENTRY,
    kollig_keller::ENTRY,
    decomposition::FULL_RESOLUTION,
    decomposition::ENTRY,
    product_ratio::ENTRY,
    product_ratio_unbiased::ENTRY,
];

/// The sampler of environment maps with this id or alias, in any case.
pub fn environment_sampler(id: &str) -> Option<&'static SamplerEntry> {
    ENVIRONMENT_SAMPLERS
        .iter()
        .find(|entry| entry.about.answers_to(id))
}

/// Methods that are no distributions.
pub const OTHER_METHODS: &[MethodEntry] = &[PER_SAMPLE, on_demand::ENTRY];

/// The method of a technique that is no distribution, by its id or alias, in any case.
pub fn other_method(technique: &str, id: &str) -> Option<&'static MethodEntry> {
    OTHER_METHODS
        .iter()
        .find(|e| e.about.answers_to(id) && e.techniques.contains(&technique))
}

/// The technique with this id or alias, in any case.
pub fn technique(id: &str) -> Option<&'static TechniqueEntry> {
    TECHNIQUES.iter().find(|entry| entry.about.answers_to(id))
}

/// The first stage with this id or alias, in any case.
pub fn first_stage(id: &str) -> Option<&'static FirstStageEntry> {
    FIRST_STAGES.iter().find(|entry| entry.about.answers_to(id))
}

/// The refinement with this id or alias, in any case.
pub fn refinement(id: &str) -> Option<&'static RefinementEntry> {
    REFINEMENTS.iter().find(|entry| entry.about.answers_to(id))
}

/// The rule of interpolation with this id or alias, in any case.
pub fn interpolation(id: &str) -> Option<&'static InterpolationEntry> {
    INTERPOLATIONS
        .iter()
        .find(|entry| entry.about.answers_to(id))
}

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
    /// Source of the module; its head comment is the body of the page.
    pub module: &'static str,
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

impl About {
    /// Whether `name` is the id or an alias, in any case.
    pub fn answers_to(&self, name: &str) -> bool {
        let same = |id: &&str| id.eq_ignore_ascii_case(name);
        same(&self.id) || self.aliases.iter().any(same)
    }
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
    /// How its records are interpolated unless the method says otherwise.
    pub interpolation: &'static InterpolationEntry,
    pub build: fn(&toml::Table) -> Result<Box<dyn Refinement>, ParameterError>,
}

/// A rule of interpolation between records.
pub struct InterpolationEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Interpolation, ParameterError>,
}

/// A sampler of environment maps.
pub struct SamplerEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<EnvironmentSampler, ParameterError>,
}

/// A method that is no distribution.
pub struct MethodEntry {
    pub about: About,
    /// Ids of the techniques it is a contender of.
    pub techniques: &'static [&'static str],
    pub build: fn(&toml::Table) -> Result<Method, ParameterError>,
}

/// Refuses parameters that none of the entries declares.
pub fn check_keys(table: &toml::Table, abouts: &[&About]) -> Result<(), ParameterError> {
    let known: Vec<&str> = abouts
        .iter()
        .flat_map(|about| about.parameters.iter().map(|p| p.key))
        .collect();
    match table.keys().find(|key| !known.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => Err(ParameterError {
            key: Some(key.clone()),
            message: format!("unknown parameter `{key}`; known: {}", known.join(", ")),
        }),
    }
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

/// Which methods a technique compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contenders {
    /// None: `reference` is the only method.
    None,
    /// Cache distributions, and the function itself at every sample.
    Distributions,
    /// Samplers of environment maps.
    EnvironmentSamplers,
}

/// A technique.
pub struct TechniqueEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Box<dyn Technique>, ParameterError>,
    pub contenders: Contenders,
    /// Parameters that the reference does not depend on.
    pub of_contenders: &'static [&'static str],
}
