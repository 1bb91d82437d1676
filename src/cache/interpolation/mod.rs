//! How records become the value of a camera sample: which records, with what weights, and whether
//! each is extrapolated by its own gradients.

mod extrapolation;
pub mod gradient;
pub mod inverse_distance;

pub use extrapolation::Extrapolation;
pub use gradient::Gradient;

use super::SearchRule;
use crate::entry::{About, ParameterError};

/// A rule of interpolation between records.
pub struct InterpolationEntry {
    /// What the registry says of it.
    pub about: About,
    /// Makes the rule with the parameters of a table, which it checks.
    pub build: fn(&toml::Table) -> Result<Interpolation, ParameterError>,
}

/// All rules of interpolation between records.
pub const INTERPOLATIONS: &[InterpolationEntry] = &[inverse_distance::ENTRY, gradient::ENTRY];

/// The rule of interpolation with this id or alias, in any case.
pub fn interpolation(id: &str) -> Option<&'static InterpolationEntry> {
    INTERPOLATIONS
        .iter()
        .find(|entry| entry.about.answers_to(id))
}

/// A rule of interpolation with its parameters set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Interpolation {
    /// The papers': the technique's lookup, values as they are, weights 1/D.
    #[default]
    InverseDistance,
    /// Ours: see [`gradient`].
    Gradient(Gradient),
}

impl Interpolation {
    /// The lookup: `paper` is the technique's own rule, `length` the distance within which its
    /// function changes (scene units).
    pub fn rule(&self, paper: SearchRule, length: f32) -> SearchRule {
        match self {
            Self::InverseDistance => paper,
            Self::Gradient(gradient) => gradient.rule(length),
        }
    }

    /// p of the weights 1/Dᵖ.
    pub fn power(&self) -> i32 {
        match self {
            Self::InverseDistance => 1,
            Self::Gradient(gradient) => gradient.power,
        }
    }

    /// The gradient's parameters, if records have gradients.
    pub fn gradient(&self) -> Option<Gradient> {
        match self {
            Self::InverseDistance => None,
            Self::Gradient(gradient) => Some(*gradient),
        }
    }
}
