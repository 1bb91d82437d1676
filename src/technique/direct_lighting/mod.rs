//! Direct light over a sequence: emission that the camera sees, and light that what it sees scatters once. The truth is
//! path tracing of two edges, for every measured frame and viewer.

mod light_samples;
mod reservoirs;
pub(super) mod selection;
mod sight;

use super::truth::{Parameters, Truth};
use super::{
    ContenderEntry, RAYS_PER_PIXEL, SAMPLES, SECONDS, TechniqueEntry, light_cones, path_samples,
    running_mean,
};
use crate::entry::{About, Bias};
use crate::shade::DIRECT_LIGHTING;

/// What it compares.
static CONTENDERS: &[ContenderEntry<Truth>] = &[
    path_samples::ENTRY,
    running_mean::ENTRY,
    light_samples::ENTRY,
    reservoirs::RESTIR,
    reservoirs::RESTIR_UNBIASED,
    reservoirs::RTXDI_LIKE,
    light_cones::ENTRY,
];

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "direct-lighting",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["direct"],
        summary: "emission and direct light of area, point, spot and directional lights, environment and sun",
        source: "Veach 1997, power heuristic",
        bias: Bias::Unbiased,
        version: 3,
        failures: &["light through glass and by mirrors is indirect, hence absent"],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        Ok(Box::new(Truth::new(
            table,
            Some(DIRECT_LIGHTING),
            CONTENDERS,
        )?))
    },
    contenders: || CONTENDERS.iter().map(ContenderEntry::listed).collect(),
    units: &[&SAMPLES, &SECONDS, &RAYS_PER_PIXEL],
    default_method: "reference",
    of_contenders: &[],
};
