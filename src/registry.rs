//! The table of techniques.

use crate::technique::{
    TechniqueEntry, ambient_occlusion, environment_lighting, importance_caching,
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

/// The technique with this id or alias, in any case.
pub fn technique(id: &str) -> Option<&'static TechniqueEntry> {
    TECHNIQUES.iter().find(|entry| entry.about.answers_to(id))
}
