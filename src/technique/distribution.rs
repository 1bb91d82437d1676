//! A first stage, an optional refinement and a rule of interpolation, from an id such as `VGC+DGS`
//! and a parameter table.

use toml::Table;

use super::Listed;
use crate::cache::Interpolation;
use crate::cache::interpolation::{INTERPOLATIONS, interpolation, inverse_distance};
use crate::entry::{About, ParameterError, check_keys};
use crate::placement::{
    FIRST_STAGES, FirstStage, REFINEMENTS, Refinement, first_stage, refinement,
};
use crate::suggest::advice;

/// The parameter that names the rule of interpolation.
const KEY: &str = "interpolation";

/// A complete cache distribution.
pub struct Distribution {
    /// Canonical id.
    pub id: String,
    /// First stage, refinement and rule of interpolation.
    pub parts: Vec<&'static About>,
    /// Places the first records.
    pub first: Box<dyn FirstStage>,
    /// Adds records to them; `None` for a first stage alone.
    pub refinement: Option<Box<dyn Refinement>>,
    /// How records are interpolated.
    pub interpolation: Interpolation,
}

impl Distribution {
    /// Builds `FIRST` or `FIRST+REFINEMENT`; each parameter goes to the stage, or the rule of
    /// interpolation, that declares it. `interpolation` names that rule; by default it is the one
    /// that the refinement is meant for, or the papers'.
    pub fn new(id: &str, parameters: &Table) -> Result<Self, ParameterError> {
        let (first_id, refinement_id) = match id.split_once('+') {
            Some((first, refinement)) => (first, Some(refinement)),
            None => (id, None),
        };
        let unknown = |(key, kind): (&str, &str), name: &str, known: Vec<&str>| {
            let advice = advice(name, &known);
            ParameterError::new(key, format!("no {kind} is called `{name}`; {advice}"))
        };
        let first = first_stage(first_id).ok_or_else(|| {
            let known = FIRST_STAGES.iter().map(|e| e.about.id).collect();
            unknown(("id", "distribution"), first_id, known)
        })?;
        let refinement = match refinement_id {
            None => None,
            Some(name) => Some(refinement(name).ok_or_else(|| {
                let known = REFINEMENTS.iter().map(|e| e.about.id).collect();
                unknown(("id", "refinement"), name, known)
            })?),
        };
        let interpolation = match parameters.get(KEY) {
            None => refinement.map_or(&inverse_distance::ENTRY, |r| r.interpolation),
            Some(value) => {
                let name = value.as_str().unwrap_or_default();
                interpolation(name).ok_or_else(|| {
                    let known = INTERPOLATIONS.iter().map(|e| e.about.id).collect();
                    unknown((KEY, KEY), name, known)
                })?
            }
        };
        let abouts: Vec<&'static About> = std::iter::once(&first.about)
            .chain(refinement.map(|r| &r.about))
            .chain(std::iter::once(&interpolation.about))
            .collect();
        let mut parameters = parameters.clone();
        parameters.remove(KEY);
        check_keys(
            &parameters,
            abouts.iter().flat_map(|about| about.parameters),
        )?;
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
            interpolation: (interpolation.build)(&own(&interpolation.about))?,
            parts: abouts,
        })
    }
}

/// Every first stage, alone and with every refinement.
pub fn distributions() -> Vec<Listed> {
    let mut listed = Vec::new();
    for first in FIRST_STAGES {
        listed.push(Listed {
            id: first.about.id.to_owned(),
            parts: vec![&first.about],
        });
        listed.extend(REFINEMENTS.iter().map(|refinement| Listed {
            id: format!("{}+{}", first.about.id, refinement.about.id),
            parts: vec![&first.about, &refinement.about],
        }));
    }
    listed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(id: &str, parameters: &str) -> Result<Distribution, ParameterError> {
        Distribution::new(id, &parameters.parse().expect("valid toml"))
    }

    #[test]
    fn the_interpolation_is_the_papers_unless_asked_for_or_made_for_another() {
        let of = |id, parameters| build(id, parameters).expect("valid").interpolation;
        assert_eq!(of("VGC+DGS", ""), Interpolation::InverseDistance);
        assert!(of("VGC+EGR", "").gradient().is_some());
        assert!(of("IM", "interpolation = 'gradient'").gradient().is_some());
        let plain = of("VGC+EGR", "interpolation = 'inverse-distance'");
        assert_eq!(plain, Interpolation::InverseDistance);
        let steep = of("VGC+EGR", "across = 4.0\npower = 2").gradient();
        let steep = steep.expect("the gradient's parameters");
        assert_eq!((steep.across, steep.power), (4.0, 2));
    }

    #[test]
    fn wrong_interpolations_name_their_key() {
        for (parameters, key) in [
            ("interpolation = 'linear'", "interpolation"),
            ("interpolation = 3", "interpolation"),
            ("power = 2", "power"),
            ("interpolation = 'gradient'\npower = 0", "power"),
            ("interpolation = 'gradient'\nacross = -1.0", "across"),
            ("interpolation = 'gradient'\nbend = nan", "bend"),
            ("interpolation = 'gradient'\nclamp = 11.0", "clamp"),
        ] {
            let error = build("VGC", parameters).err().expect(parameters);
            assert_eq!(error.key, key, "{parameters}: {error}");
        }
        for parameters in ["rounds = 0", "spacing = 5.0", "ratio = 1.0"] {
            assert!(build("VGC+EGR", parameters).is_err(), "{parameters}");
        }
    }
}
