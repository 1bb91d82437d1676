//! Radiance over a sequence: contenders are given the shots of one frame after another and keep what they learned of
//! the light in the scene. The truth is path tracing of every measured frame.

mod camera;
mod cells;
mod fill;
pub mod filter;
mod filtered_paths;
mod hash_cache;
pub mod layers;
mod planes;
mod reconstruct;
mod sharc;

pub(super) use camera::viewer_key;

use super::truth::{Parameters, Truth};
use super::{
    ContenderEntry, RAYS_PER_PIXEL, SAMPLES, SECONDS, TechniqueEntry, path_samples, running_mean,
};
use crate::entry::{About, Bias};

/// What it compares.
static CONTENDERS: &[ContenderEntry<Truth>] = &[
    path_samples::ENTRY,
    running_mean::ENTRY,
    filtered_paths::ENTRY,
    hash_cache::ENTRY,
    sharc::ENTRY,
];

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "radiance",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["global-illumination"],
        summary: "all light over the frames of a sequence, by caches that remember and by path tracing",
        source: "Roth et al. 2020; truth: path tracing to the scene's max_depth",
        bias: Bias::Unbiased,
        version: 3,
        failures: &["caustics of small lights through smooth glass converge slowly"],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| Ok(Box::new(Truth::new(table, None, CONTENDERS)?)),
    contenders: || CONTENDERS.iter().map(ContenderEntry::listed).collect(),
    units: &[&SAMPLES, &SECONDS, &RAYS_PER_PIXEL],
    default_method: "hash-cache",
    of_contenders: &[],
};
