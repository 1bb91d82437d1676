//! Memory of the jobs of a plan, foreseen from the geometry of their scenes.

use super::loaded::{build_technique, geometry};
use super::run::same_scene;
use super::{Case, Job, RunError};
use crate::technique::{Film, Foreseen};

/// A job, and what it is about to take.
pub struct JobMemory<'a> {
    /// The first job of its case.
    pub job: &'a Job,
    /// What it keeps, and what it needs beside.
    pub bytes: Foreseen,
}

/// The first job of every case whose contender can tell, with the memory that it will take. Scenes are read for their
/// geometry.
///
/// # Errors
/// Scenes, maps and files that are absent or damaged.
pub fn foresee(jobs: &[Job]) -> Result<Vec<JobMemory<'_>>, RunError> {
    let mut told: Vec<JobMemory> = Vec::new();
    for jobs in jobs.chunk_by(same_scene) {
        let mut scene = None;
        for job in jobs {
            let case = Case::of_job(job);
            if told.iter().any(|known| Case::of_job(known.job) == case) {
                continue;
            }
            let technique = build_technique(job)?;
            let started = job
                .choice(job.budget.count().unwrap_or(1))
                .start(technique.as_ref());
            let contender = started.map_err(RunError::Technique)?.contender;
            if contender
                .foreseen(&Default::default(), Film::of(job))
                .is_none()
            {
                continue;
            }
            let scene = match &scene {
                Some(scene) => scene,
                None => scene.insert(geometry(job)?),
            };
            if let Some(bytes) = contender.foreseen(scene, Film::of(job)) {
                told.push(JobMemory { job, bytes });
            }
        }
    }
    Ok(told)
}
