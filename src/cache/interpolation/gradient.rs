//! Gradient interpolation: each record is extrapolated by what its own rays know.
//!
//! A record keeps, besides its value, how the value turns with the normal (the bent or irradiance vector **B**)
//! and how it changes with the position (**g**, from differences between adjacent directions over the
//! distances their rays travelled; for irradiance, whose paths are noisy, between the means of 8 × 8 blocks). At a shading point with position p and normal n, record c says
//!
//! ```text
//! value_c = B_c·n + clamp(g_c·Δp, ±clamp)          kept within the function's range
//! ```
//!
//! Of the 24 records nearest in space those within 60° of the normal stay, of them the 4 least in
//!
//! ```text
//! D² = |Δp|² + (across · pl)² + (bend · ℓ)² (1 − n_c·n)
//! ```
//!
//! with pl the larger of the distances of either point from the other's tangent plane and ℓ the length within
//! which the function changes (the occlusion distance; the median of the records' harmonic mean distances for
//! irradiance). Weights are `1 / Dᵖ`, p = `power`; for ambient occlusion times `1 / (1 + d Σ 1/t / S)`, with t the
//! distances of what lies at the edges of openings and d the longest: a record that feels something near changes
//! soon. Finding those distances takes closest hits, about one for fifteen occlusion rays, which rows count apart.
//! Beyond 60° a record keeps its plain value. The change by the position is kept within ±0.1 (ambient
//! occlusion) or ±0.3 of the value (irradiance).
//!
//! Records of irradiance also keep the radiance and nearness of 16 × 16 blocks of their directions. Gloss
//! sees these: 16 directions of the microfacet lobe are looked up where each record sees what lies there, in place
//! of the directional albedo times the mean. The brightest path of a block counts as much as the next one and spreads
//! the rest over all blocks, for gradients too.

use super::Interpolation;
use crate::cache::interpolation::InterpolationEntry;
use crate::cache::{Ranking, SearchRule, TangentMetric};
use crate::entry::{About, Bias, parameters};

parameters! {
    /// Parameters of gradient interpolation.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Gradient {
        /// Weight of the distance from the tangent plane.
        pub across: f32 = 16.0, Within(0.0, 1000.0);
        /// Distance that a bend of 90° counts as.
        pub bend: f32 = 0.2, Within(0.0, 100.0), "ℓ";
        /// p of the weights 1/Dᵖ.
        pub power: i32 = 3, Within(1.0, 8.0);
        /// Largest change by the position: absolute for ambient occlusion, relative to the record's value for
        /// irradiance; 0 leaves the rotation only. Without it 0.1 for ambient occlusion and 0.3 for irradiance.
        pub clamp: Option<f32> = None, Within(0.0, 10.0);
    }
}

/// Records nearest in space that are candidates.
const CANDIDATES: usize = 24;
/// Records that are used.
const USED: usize = 4;
/// Largest angle between normals, degrees.
pub(super) const MAX_ANGLE_DEG: f32 = 60.0;

impl Gradient {
    /// The lookup; `length` (ℓ) in scene units.
    pub fn rule(&self, length: f32) -> SearchRule {
        SearchRule {
            candidates: CANDIDATES,
            used: USED,
            max_angle_deg: MAX_ANGLE_DEG,
            metric: Ranking::Tangent(TangentMetric {
                across: self.across,
                bend: self.bend * length,
            }),
        }
    }
}

/// The registry's entry.
pub const ENTRY: InterpolationEntry = InterpolationEntry {
    about: About {
        id: "gradient",
        module: crate::entry::head_comment!("gradient.rs"),
        aliases: &[],
        summary: "ours: records are extrapolated by their own gradients and weighted off the tangent plane",
        source: "ours; gradients from adjacent directions after Ward & Heckbert 1992",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "an occluder nearer than the record's rays are apart has no gradient that points to it",
            "irradiance from few and noisy paths has noisy gradients",
            "gloss of irradiance: near things at the horizon of a record are reflected where the record is, and \
             fade to its mean within the distance they have",
            "needs hit distances: some closest-hit beside the any-hit rays for ambient occlusion",
        ],
        parameters: Gradient::PARAMETERS,
    },
    build: |table| Ok(Interpolation::Gradient(Gradient::read(table)?)),
};
