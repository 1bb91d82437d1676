//! The papers' interpolation.
//!
//! Of the N = 20 records nearest in space those within θ_max = 30° of the normal stay, of them the M = 6 least
//! in the combined distance `|Δp| + λ √(1 − n·n′)`, weighted by its inverse. Values are taken as they are. The
//! technique's `lookup` sets N, M, θ_max and λ.

use super::Interpolation;
use crate::cache::interpolation::InterpolationEntry;
use crate::entry::{About, Bias, check_keys};

/// The registry's entry.
pub const ENTRY: InterpolationEntry = InterpolationEntry {
    about: About {
        id: "inverse-distance",
        module: crate::entry::head_comment!("inverse_distance.rs"),
        aliases: &[],
        summary: "the papers' rule: six records by position and normal, weighted by the inverse distance",
        source: "Wu & Shen 2023, section 3.3, eq. 5",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "every gradient between records becomes a step or a ramp: halos around contacts",
            "records in front of and behind an edge in depth mix where their normals agree",
        ],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(Interpolation::InverseDistance)
    },
};
