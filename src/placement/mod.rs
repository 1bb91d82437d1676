//! Cache distributions: first stages that see geometry only, and refinements that also see the
//! records already computed. A placement knows nothing of the cached function; it picks shading
//! points, by index.

pub mod adaptive;
mod cones;
mod cut;
pub mod dgs;
mod disagreement;
mod discontinuity;
pub mod egr;
#[cfg(test)]
mod example;
mod growth;
mod hierarchy;
pub mod im;
mod members;
mod pairs;
mod partition;
mod pick;
mod representative;
pub mod sd;
mod share;
pub mod vgc;

use glam::Vec3;
use rayon::prelude::*;

use crate::cache::interpolation::InterpolationEntry;
use crate::cache::{RecordSearch, ShadingPoints};
use crate::entry::About;
use crate::entry::ParameterError;

/// Chosen shading points (distinct indices) and what is worth reporting.
#[derive(Clone, Debug, Default)]
pub struct Placement {
    /// Indices of shading points, in order of creation.
    pub sites: Vec<u32>,
    /// Quantities found on the way (σ_s, τ, leaves, …), for the row's `params`.
    pub found: Vec<(&'static str, f64)>,
    /// Shortfalls and fallbacks, a sentence each.
    pub notes: Vec<String>,
    /// The per-pixel map that guided a refinement, row-major, if it has one.
    pub map: Option<Vec<f32>>,
}

/// A distribution that needs geometry only.
pub trait FirstStage: Send + Sync {
    /// Exactly `count` distinct points, or all of them if there are fewer.
    fn place(&self, points: &ShadingPoints, count: usize, seed: u64) -> Placement;

    /// For parameters that the paper picks per scene by error: the settings to try. Empty for all
    /// others.
    fn candidates(&self) -> Vec<Box<dyn FirstStage>> {
        Vec::new()
    }
}

/// The records of a job, as a refinement knows them: by index, in order of creation.
pub trait Records: Sync {
    /// Summed absolute difference of the gathering samples of two records.
    fn difference(&self, a: u32, b: u32) -> f32;

    /// What a record alone says of a shading point (index), linear RGB as in the image, and how far it
    /// is to be believed beside others at the same distance.
    fn predict(&self, record: u32, point: u32) -> (Vec3, f32);

    /// Evaluates shading points, which become the next records.
    fn add(&mut self, points: &[u32]);
}

/// What a refinement sees.
pub struct Refinable<'a> {
    /// All that may become records.
    pub points: &'a ShadingPoints,
    /// Records of the first stage in order of creation: indices into `points`.
    pub sites: &'a [u32],
    /// Search over those records, by the rule of the job's interpolation.
    pub search: &'a RecordSearch,
    /// p of the weights 1/Dᵖ that records are interpolated with.
    pub power: i32,
    /// Their values, and where new ones are made.
    pub records: &'a mut dyn Records,
}

impl Refinable<'_> {
    /// Positions and normals of the records.
    fn placed(&self) -> (Vec<Vec3>, Vec<Vec3>) {
        let sites = self.sites.par_iter().map(|&i| i as usize);
        sites
            .map(|i| (self.points.position[i], self.points.normal[i]))
            .unzip()
    }
}

/// Additional records where the first ones show that they are needed.
pub trait Refinement: Send + Sync {
    /// Share of the budget that is kept back for this stage (R).
    fn ratio(&self) -> f64;

    /// Whether it asks what records say of shading points.
    fn predicts(&self) -> bool {
        false
    }

    /// `count` distinct points that are not yet records, or as many as there are. It may make
    /// records of the first of them on the way; those it makes are the first it returns.
    fn refine(&self, input: &mut Refinable, count: usize, seed: u64) -> Placement;
}

/// A first stage of placement.
pub struct FirstStageEntry {
    /// What the registry says of it.
    pub about: About,
    /// Makes the stage with the parameters of a table, which it checks.
    pub build: fn(&toml::Table) -> Result<Box<dyn FirstStage>, ParameterError>,
}

/// A refinement of placement.
pub struct RefinementEntry {
    /// What the registry says of it.
    pub about: About,
    /// How its records are interpolated unless the method says otherwise.
    pub interpolation: &'static InterpolationEntry,
    /// Makes the refinement with the parameters of a table, which it checks.
    pub build: fn(&toml::Table) -> Result<Box<dyn Refinement>, ParameterError>,
}

/// All first stages of placement.
pub const FIRST_STAGES: &[FirstStageEntry] = &[im::ENTRY, sd::ENTRY, vgc::ENTRY];

/// All refinements of placement.
pub const REFINEMENTS: &[RefinementEntry] = &[adaptive::ENTRY, dgs::ENTRY, egr::ENTRY];

/// The first stage with this id or alias, in any case.
pub fn first_stage(id: &str) -> Option<&'static FirstStageEntry> {
    FIRST_STAGES.iter().find(|entry| entry.about.answers_to(id))
}

/// The refinement with this id or alias, in any case.
pub fn refinement(id: &str) -> Option<&'static RefinementEntry> {
    REFINEMENTS.iter().find(|entry| entry.about.answers_to(id))
}
