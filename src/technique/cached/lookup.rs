//! The run-time rule as users set it.

use serde::{Deserialize, Serialize};

use crate::cache::{DistanceMetric, Ranking, SearchRule};
use crate::technique::Shot;

/// The largest M: weights of a sample live on the stack.
pub(super) const MOST_USED: usize = 32;

/// The run-time rule's parameters (Wu & Shen, table 1), shared by all cached techniques.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lookup {
    /// N: spatially nearest records that are candidates.
    pub candidates: usize,
    /// M: records that are used.
    pub used: usize,
    /// θ_max: largest angle between normals, degrees.
    pub max_angle_deg: f32,
    /// Weight of the normals in the combined distance: `None` is the paper's 0.5 / L, in metres;
    /// `Some(κ)` is the scale-free 0.5 · L · κ.
    pub lambda_scaled: Option<f32>,
}

impl Default for Lookup {
    fn default() -> Self {
        Self {
            candidates: 20,
            used: 6,
            max_angle_deg: 30.0,
            lambda_scaled: None,
        }
    }
}

impl Lookup {
    /// Checks ranges; the message names the key.
    pub fn validate(&self) -> Result<(), String> {
        if !(1..=MOST_USED).contains(&self.used)
            || self.candidates < self.used
            || self.candidates > 256
        {
            return Err(format!(
                "lookup: expected 1 ≤ used ≤ {MOST_USED} and used ≤ candidates ≤ 256, got used = {}, candidates = {}",
                self.used, self.candidates
            ));
        }
        if !(0.0..=180.0).contains(&self.max_angle_deg) {
            return Err("lookup: max_angle_deg must lie in 0 to 180".into());
        }
        Ok(())
    }

    pub(super) fn rule(&self, shot: &Shot) -> SearchRule {
        let (diagonal, metres) = (shot.scene.diagonal, shot.scene.metres_per_unit as f32);
        SearchRule {
            candidates: self.candidates,
            used: self.used,
            max_angle_deg: self.max_angle_deg,
            metric: Ranking::Combined(match self.lambda_scaled {
                None => DistanceMetric::literal(diagonal, metres),
                Some(kappa) => DistanceMetric::scaled(kappa, diagonal),
            }),
        }
    }
}
