//! What every entry of the registry says of itself.

mod head_comment;
mod parameters;
mod range;
mod setting;

pub(crate) use head_comment::{head_comment, head_length, head_of};
pub(crate) use parameters::parameters;
pub use parameters::{Parameter, check_keys, written};
pub use range::Range;
pub(crate) use setting::words;
pub use setting::{Kind, Setting};

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
    /// Key in the parameter table; `id` for the name of the method itself.
    pub key: String,
    /// What is expected, a sentence.
    pub message: String,
}

impl ParameterError {
    /// An error of one key.
    pub fn new(key: &str, message: impl Into<String>) -> Self {
        Self {
            key: key.to_owned(),
            message: message.into(),
        }
    }
}

/// What every entry of the registry says of itself.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Canonical name, as plans and rows have it.
    pub id: &'static str,
    /// Head comment of the module: the body of the page.
    pub module: &'static str,
    /// Other names that are understood.
    pub aliases: &'static [&'static str],
    /// One line.
    pub summary: &'static str,
    /// Paper, section and equations; "reconstruction" where it is one.
    pub source: &'static str,
    /// How its results relate to the truth.
    pub bias: Bias,
    /// Raised whenever the same job would give another result; results of older versions are not reused.
    pub version: u32,
    /// Known failures, a sentence each.
    pub failures: &'static [&'static str],
    /// What it can be told, as its struct of parameters declares it.
    pub parameters: &'static [Parameter],
}

impl About {
    /// Whether `name` is the id or an alias, in any case.
    pub fn answers_to(&self, name: &str) -> bool {
        let same = |id: &&str| id.eq_ignore_ascii_case(name);
        same(&self.id) || self.aliases.iter().any(same)
    }
}
