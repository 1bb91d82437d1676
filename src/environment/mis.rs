//! Multiple importance sampling of the map and the surface at every shading point (Veach & Guibas
//! 1995, as in PBRT-v3). The estimator is in the technique; here is which samples it takes.

use super::EnvironmentSampler;
use crate::entry::{About, Bias, parameters};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "mis",
        module: crate::entry::head_comment!("mis.rs"),
        aliases: &[],
        summary: "light and surface sampling at every shading point, power heuristic",
        source: "Veach & Guibas 1995; PBRT-v3; compensation: Karlík et al. 2019",
        bias: Bias::Unbiased,
        version: 1,
        failures: &["noise at few samples"],
        parameters: Mis::PARAMETERS,
    },
    build: |table| Ok(EnvironmentSampler::PerPoint(Mis::read(table)?)),
};

parameters! {
    /// Parameters of the estimator.
    #[derive(Clone, Copy, Debug)]
    pub struct Mis {
        /// Draws lights from the part of the luminance above its average (MIS compensation).
        pub compensated: bool = false;
        /// The samples of a point form a scrambled (0,2)-sequence; they are independent otherwise.
        pub stratified: bool = true;
    }
}
