//! A first stage and an optional refinement, from an id such as `VGC+DGS` and a parameter table.

use toml::Table;

use crate::placement::{FirstStage, Refinement};
use crate::registry::{self, About, ParameterError};

/// A complete cache distribution.
pub struct Distribution {
    /// Canonical id.
    pub id: String,
    pub first: Box<dyn FirstStage>,
    pub refinement: Option<Box<dyn Refinement>>,
}

impl Distribution {
    /// Builds `FIRST` or `FIRST+REFINEMENT`; each parameter goes to the stage that declares it.
    pub fn new(id: &str, parameters: &Table) -> Result<Self, ParameterError> {
        let (first_id, refinement_id) = match id.split_once('+') {
            Some((first, refinement)) => (first, Some(refinement)),
            None => (id, None),
        };
        let unknown = |kind: &str, name: &str, known: Vec<&str>| ParameterError {
            key: Some("id".into()),
            message: format!("no {kind} is called `{name}`; known: {}", known.join(", ")),
        };
        let first = registry::first_stage(first_id).ok_or_else(|| {
            let known = registry::FIRST_STAGES.iter().map(|e| e.about.id).collect();
            unknown("distribution", first_id, known)
        })?;
        let refinement = match refinement_id {
            None => None,
            Some(name) => Some(registry::refinement(name).ok_or_else(|| {
                let known = registry::REFINEMENTS.iter().map(|e| e.about.id).collect();
                unknown("refinement", name, known)
            })?),
        };
        let abouts: Vec<&About> = std::iter::once(&first.about)
            .chain(refinement.map(|r| &r.about))
            .collect();
        registry::check_keys(parameters, &abouts)?;
        let own = |about: &About| -> Table {
            let declared = |key: &str| about.parameters.iter().any(|p| p.key == key);
            parameters
                .iter()
                .filter(|(key, _)| declared(key))
                .map(|(key, value)| (key.clone(), value.clone()))
                .collect()
        };
        Ok(Self {
            id: match refinement {
                Some(r) => format!("{}+{}", first.about.id, r.about.id),
                None => first.about.id.to_owned(),
            },
            first: (first.build)(&own(&first.about))?,
            refinement: refinement.map(|r| (r.build)(&own(&r.about))).transpose()?,
        })
    }
}
