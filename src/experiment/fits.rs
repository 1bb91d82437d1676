//! What goes together: technique, method and scene, told before the first ray.

use crate::entry::ParameterError;
use crate::scene::SceneDescription;
use crate::technique::{Contenders, Method, TechniqueEntry};

/// Whether a technique can use a method as it is set.
///
/// # Errors
/// The key at fault, and what is expected of it.
pub fn method_fits(technique: &TechniqueEntry, method: &Method) -> Result<(), ParameterError> {
    if let Method::Distribution(distribution) = method
        && technique.about.id == crate::technique::importance_caching::ENTRY.about.id
        && distribution.interpolation.gradient().is_some()
    {
        return Err(ParameterError {
            key: Some("interpolation".into()),
            message: format!(
                "{} samples by its records and interpolates no values: set interpolation = \
                 \"inverse-distance\" for {}",
                technique.about.id, distribution.id
            ),
        });
    }
    Ok(())
}

/// Whether a scene has what a technique is about.
///
/// # Errors
/// A sentence with advice.
pub fn scene_fits(technique: &TechniqueEntry, scene: &SceneDescription) -> Result<(), String> {
    if technique.contenders == Contenders::EnvironmentSamplers && scene.environment.is_none() {
        return Err(format!(
            "{} needs an environment and scene `{}` has none: name a map, for example environment \
             = \"afternoon\"; `lightbench list maps` shows them",
            technique.about.id, scene.name
        ));
    }
    Ok(())
}
