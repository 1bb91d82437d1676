//! What every entry of the registry says of itself.

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
    /// Raised whenever the same job would give another result; results of older versions are not reused.
    pub version: u32,
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
