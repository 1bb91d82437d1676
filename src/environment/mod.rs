//! Light from infinity: maps, skies and their samplers.
//!
//! A [`LightSampler`] turns a map into a [`LightSet`] once, for all shading points; [`mis::Mis`]
//! draws directions anew at every point. Samplers work in the map's own space and turn the finished
//! set, so that rotating a map rotates its lights.

mod blocks;
mod declared;
pub mod decomposition;
mod description;
mod directs;
mod emissive;
#[cfg(test)]
mod example;
pub mod fhis;
mod gallery;
mod halving;
mod indirects;
pub mod kollig_keller;
mod leaves;
mod light;
mod map;
mod mean_shift;
pub mod median_cut;
pub mod mis;
mod penrose;
pub mod product_ratio;
pub mod product_ratio_unbiased;
mod regions;
mod relaxation;
mod repair;
mod rings;
#[cfg(test)]
mod sampler_tests;
mod sky;
mod strata;
mod table;
mod texel_lights;
mod texel_lists;
mod texels;
pub mod tmms;
pub mod variance_minimization;

pub use description::EnvironmentDescription;
pub use gallery::{embedded_map, embedded_maps};
pub use light::{Light, LightKind, LightSampler, LightSet};
pub use map::{Environment, EnvironmentOptions, EnvironmentRows, EnvironmentSample};
pub use repair::Sanitised;
pub use sky::{SunSky, sun_sky_image};
pub use texel_lights::{BLOCK, DRAWS, TexelLights, TexelSample};

use crate::entry::{About, ParameterError};

/// A sampler of environment maps.
pub struct SamplerEntry {
    /// What the registry says of it.
    pub about: About,
    /// Makes the sampler with the parameters of a table, which it checks.
    pub build: fn(&toml::Table) -> Result<EnvironmentSampler, ParameterError>,
}

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

/// A contender of environment lighting.
pub enum EnvironmentSampler {
    /// One set of lights for all shading points.
    Lights(Box<dyn LightSampler>),
    /// Directions drawn at every shading point.
    PerPoint(mis::Mis),
    /// Lights chosen anew at every shading point, and their visibility filtered.
    Product {
        /// Those of candidates, ratio and filter; those of the filter go unused where `unbiased`.
        parameters: product_ratio::ProductRatio,
        /// Whether texels are lit as they are, without ratio and filter.
        unbiased: bool,
    },
}

use std::path::PathBuf;

/// Why there is no environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// The map's file cannot be read.
    #[error("{}: {message}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What reading it said.
        message: String,
    },
    /// The map's image has no rows or no columns.
    #[error("an environment map needs at least one pixel, this one has {width}×{height}")]
    Empty {
        /// Pixels.
        width: usize,
        /// Pixels.
        height: usize,
    },
    /// The matrix that places the map shears it, stretches it unevenly or is singular.
    #[error(
        "the environment's to_world must be a rotation (mirrored or uniformly scaled at most): {matrix}"
    )]
    NotARotation {
        /// Its numbers, for the message.
        matrix: String,
    },
    /// No embedded map has the name.
    #[error("no environment map is called `{name}`")]
    Unknown {
        /// As the scene gives it.
        name: String,
    },
    /// The daylight model has no such sky: the sun is too low, or turbidity or albedo out of range.
    #[error("{message}")]
    Sky {
        /// What is wrong with it.
        message: String,
    },
}
