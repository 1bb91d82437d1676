//! The run-time rule as users set it.

use serde::Serialize;

use crate::cache::{DistanceMetric, Ranking, SearchRule};
use crate::entry::{Kind, ParameterError, Setting, parameters};
use crate::technique::Shot;

/// The largest M: weights of a sample live on the stack.
pub(super) const MOST_USED: usize = 32;

parameters! {
    /// The run-time rule's parameters (Wu & Shen, table 1), shared by all cached techniques.
    #[derive(Clone, Copy, Debug, Serialize)]
    pub struct Lookup {
        /// N: spatially nearest records that are candidates, at least as many as are used.
        pub candidates: usize = 20, Within(1.0, 256.0);
        /// M: records that are used.
        pub used: usize = 6, Within(1.0, MOST_USED as f64);
        /// θ_max: largest angle between normals.
        pub max_angle_deg: f32 = 30.0, Within(0.0, 180.0), "°";
        /// Weight κ of the normals in the combined distance, λ = 0.5·L·κ; without it the paper's 0.5 / L, in metres.
        pub lambda_scaled: Option<f32> = None, AtLeast(0.0);
    }
    check Lookup::check;
}

impl Setting for Lookup {
    const KIND: Kind = Kind::Table(Self::PARAMETERS);
}

impl Lookup {
    fn check(&self) -> Result<(), ParameterError> {
        let (candidates, used) = (self.candidates, self.used);
        match candidates < used {
            false => Ok(()),
            true => Err(ParameterError::new(
                "candidates",
                format!("candidates = {candidates}: expected at least used = {used}"),
            )),
        }
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
