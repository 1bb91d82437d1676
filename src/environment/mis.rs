//! Multiple importance sampling of the map and the surface at every shading point (Veach & Guibas
//! 1995, as in PBRT-v3). The estimator is in the technique; here is which samples it takes.

use serde::{Deserialize, Serialize};

use super::EnvironmentSampler;
use crate::entry::{About, Bias, Parameter};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "mis",
        module: include_str!("mis.rs"),
        aliases: &[],
        summary: "light and surface sampling at every shading point, power heuristic",
        source: "Veach & Guibas 1995; PBRT-v3; compensation: Karlík et al. 2019",
        bias: Bias::Unbiased,
        version: 1,
        failures: &["noise at few samples"],
        parameters: &[
            Parameter {
                key: "compensated",
                default: "false",
                unit: "",
                meaning: "draws lights from the part of the luminance above its average",
            },
            Parameter {
                key: "stratified",
                default: "true",
                unit: "",
                meaning: "the samples of a point form a scrambled (0,2)-sequence",
            },
        ],
    },
    build: |table| {
        Ok(EnvironmentSampler::PerPoint(crate::entry::parameters(
            table,
        )?))
    },
};

/// Parameters of the estimator.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mis {
    /// Whether the light density is that of MIS compensation.
    pub compensated: bool,
    /// Whether samples of a point are stratified; independent otherwise.
    pub stratified: bool,
}

impl Default for Mis {
    fn default() -> Self {
        Self {
            compensated: false,
            stratified: true,
        }
    }
}
