//! DGS: discontinuity-guided sampling.
//!
//! A map over pixels says where the records of the first stage are likely to interpolate badly: the mean and
//! the largest difference between the gathering samples of the records around a pixel, and how much normals
//! vary in the 5 × 5 pixels around it, each scaled to its maximum. The records kept back are drawn from the
//! map by importance, without repetition.

use super::discontinuity::{Recipe, draw, measure};
use super::{Placement, Refinable, Refinement};
use crate::cache::interpolation::inverse_distance;
use crate::entry::{About, Bias, parameters, words};
use crate::placement::RefinementEntry;

words! {
    /// Which terms of eq. 4 are used.
    pub enum Terms {
        /// Their sum.
        Both = "both",
        /// Differences between records.
        Diff = "diff",
        /// The geometry term.
        Geom = "geom",
    }
}

parameters! {
    /// Draws pixels from a map of discontinuities in shading and geometry.
    #[derive(Clone, Copy, Debug)]
    pub struct DiscontinuityGuided {
        /// R: share of the records kept back for this stage.
        pub ratio: f64 = 0.15, Within(0.0, 0.9);
        /// Terms of the map: both, diff (differences between records) or geom (normals around).
        pub terms: Terms = Terms::Both;
        /// K: nearest records that are compared.
        pub records: usize = 6, Within(2.0, 32.0);
        /// Differences above this percentile of the pixels are cut off.
        pub clamp_percentile: f64 = 100.0, Within(50.0, 100.0), "%";
    }
}

/// Registry entry.
pub const ENTRY: RefinementEntry = RefinementEntry {
    about: About {
        id: "DGS",
        module: crate::entry::head_comment!("dgs.rs"),
        aliases: &["discontinuity-guided"],
        summary: "pixels drawn from a map of discontinuities in shading and geometry",
        source: "Wu & Shen 2023, section 3.2, eq. 3 and 4. Readings: K = 6 ranked by eq. 5, all \
                 pairs among the K, terms divided by their image maximum",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "A large geometry term oversamples regions where records hardly differ.",
            "One extreme difference makes the rest of the map near black; clamp_percentile = 99.9 \
             mends that.",
            "A discontinuity between records that all miss it is not seen.",
        ],
        parameters: DiscontinuityGuided::PARAMETERS,
    },
    build: |table| Ok(Box::new(DiscontinuityGuided::read(table)?)),
    interpolation: &inverse_distance::ENTRY,
};

impl DiscontinuityGuided {
    fn recipe(&self) -> Recipe {
        Recipe {
            difference: self.terms != Terms::Geom,
            geometry: self.terms != Terms::Diff,
            records: self.records,
            clamp_quantile: self.clamp_percentile / 100.0,
        }
    }
}

impl Refinement for DiscontinuityGuided {
    fn ratio(&self) -> f64 {
        self.ratio
    }

    /// A row by its marginal, a pixel of it by its conditional probability; a pixel that is drawn
    /// again is drawn anew. Where too few pixels have a positive value all of them are taken and
    /// the rest is uniformly random.
    fn refine(&self, input: &mut Refinable, count: usize, seed: u64) -> Placement {
        let (map, pairs) = measure(input, self.recipe());
        // D(s) of eq. 4, 0 at records and where there is no shading point.
        let picture = input.points.picture(|point| map[point]);
        let (mut sites, by_importance) = draw(input, map, count, seed);
        input.points.sort_by_block(&mut sites);
        let mut notes = Vec::new();
        if by_importance < sites.len() {
            notes.push(format!(
                "only {by_importance} pixels show a discontinuity; the other {} records are \
                 uniformly random",
                sites.len() - by_importance
            ));
        }
        if sites.len() < count {
            notes.push(format!(
                "only {} free points for {count} records",
                sites.len()
            ));
        }
        Placement {
            sites,
            found: vec![
                ("pairs", pairs as f64),
                ("by_importance", by_importance as f64),
            ],
            notes,
            map: Some(picture),
        }
    }
}
