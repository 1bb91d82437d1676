//! The table of techniques, and of every entry there is.

use crate::cache::interpolation::INTERPOLATIONS;
use crate::entry::About;
use crate::environment::ENVIRONMENT_SAMPLERS;
use crate::placement::{FIRST_STAGES, REFINEMENTS};
use crate::suggest::advice;
use crate::technique::{
    TechniqueEntry, ambient_occlusion, direct_lighting, environment_lighting, importance_caching,
    irradiance_caching, radiance, truth,
};

/// All techniques.
pub const TECHNIQUES: &[TechniqueEntry] = &[
    ambient_occlusion::ENTRY,
    environment_lighting::ENTRY,
    irradiance_caching::ENTRY,
    importance_caching::ENTRY,
    direct_lighting::ENTRY,
    truth::PATH_TRACING,
    radiance::ENTRY,
];

/// The technique with this id or alias, in any case.
pub fn technique(id: &str) -> Option<&'static TechniqueEntry> {
    TECHNIQUES.iter().find(|entry| entry.about.answers_to(id))
}

/// As [`technique`].
///
/// # Errors
/// A sentence that lists what there is.
pub fn technique_named(id: &str) -> Result<&'static TechniqueEntry, String> {
    technique(id).ok_or_else(|| {
        let known: Vec<&str> = TECHNIQUES.iter().map(|e| e.about.id).collect();
        format!("no technique is called `{id}`; {}", advice(id, &known))
    })
}

/// Kind, and every entry of it.
pub fn entries() -> Vec<(&'static str, &'static About)> {
    let techniques = TECHNIQUES.iter().map(|e| ("techniques", &e.about));
    let first = FIRST_STAGES.iter().map(|e| ("distributions", &e.about));
    let refinements = REFINEMENTS.iter().map(|e| ("refinements", &e.about));
    let interpolations = INTERPOLATIONS.iter().map(|e| ("interpolations", &e.about));
    let others = contenders();
    let samplers = ENVIRONMENT_SAMPLERS.iter().map(|e| ("samplers", &e.about));
    techniques
        .chain(first)
        .chain(refinements)
        .chain(interpolations)
        .chain(others.into_iter().map(|about| ("methods", about)))
        .chain(samplers)
        .collect()
}

/// Contenders that techniques list and that are neither distributions nor samplers.
fn contenders() -> Vec<&'static About> {
    let mut found: Vec<&'static About> = Vec::new();
    let elsewhere = |id: &str| {
        FIRST_STAGES.iter().any(|e| e.about.id == id)
            || ENVIRONMENT_SAMPLERS.iter().any(|e| e.about.id == id)
    };
    for listed in TECHNIQUES
        .iter()
        .flat_map(|technique| (technique.contenders)())
    {
        if let [about] = listed.parts.as_slice()
            && !elsewhere(about.id)
            && found.iter().all(|known| known.id != about.id)
        {
            found.push(about);
        }
    }
    found
}

#[cfg(test)]
mod tests;
