//! The scene of a job at work: its world, and the cameras that look at it.

use glam::DVec3;

use super::{Job, RunError, darkness};
use crate::scene::{Needs, Scene, SceneDescription, View, find_environment, find_scene};
use crate::technique::{Film, Shot, Technique, TechniqueEntry};
use crate::world::World;

/// A scene that was loaded for a job, with only what its technique needs.
pub struct Loaded {
    /// The scene over time, with its trees.
    pub world: World,
    /// As its file and the config declare it.
    pub declared: SceneDescription,
    /// The same, scaled, turned and moved as the config says.
    pub(super) moved: SceneDescription,
}

impl Loaded {
    /// Reads the scene of a job and builds its trees.
    ///
    /// # Errors
    /// Scenes, maps and files that are absent or damaged; no light, where the technique shows nothing else.
    pub fn new(job: &Job, technique: &dyn Technique) -> Result<Self, RunError> {
        let needs = technique.needs();
        let declared = describe(job, needs)?;
        let moved = moved(job, &declared);
        let scene = Scene::build(&moved, needs)?;
        darkness::refuse_loaded(needs, &scene).map_err(RunError::Unfit)?;
        Ok(Self {
            world: World::declared(scene, &moved)?,
            declared,
            moved,
        })
    }

    /// The cameras of a job in one of its frames, in the coordinates of the world.
    ///
    /// # Errors
    /// A sentence, where the scene has no longer what they follow.
    pub fn views(&self, job: &Job, frame: u32) -> Result<Vec<View>, String> {
        let views = job
            .sequence
            .views(&self.moved, job.sequence.time_s(frame))
            .ok_or_else(|| format!("{} has no view or path `{}`", job.scene, job.view))?;
        let origin = self.world.origin();
        let inside = views.into_iter().map(|view| View {
            origin: view.origin - origin,
            ..view
        });
        Ok(inside.collect())
    }

    /// What the first viewer of a job sees in one of its frames, exposed as if the sequence began there.
    ///
    /// # Errors
    /// As [`Loaded::views`].
    pub fn shot<'a>(
        &'a mut self,
        job: &Job,
        frame: u32,
        view: &'a View,
        technique: &dyn Technique,
    ) -> Shot<'a> {
        let moment = self.world.at(job.sequence.time_s(frame));
        Shot::exposed_for(technique, moment, view, Film::of(job))
    }
}

impl Film {
    /// Of the images of a job.
    pub(super) fn of(job: &Job) -> Self {
        Self {
            width: job.width,
            height: job.height,
            spp: job.spp,
        }
    }
}

/// A scene scaled, turned and moved as the config says.
fn moved(job: &Job, declared: &SceneDescription) -> SceneDescription {
    match job.transform {
        Some(t) => {
            let shift = DVec3::from(t.translate);
            declared.clone().transformed(t.scale, t.rotate_y_deg, shift)
        }
        None => declared.clone(),
    }
}

/// The positions and triangles of the scene of a job, without anything else.
///
/// # Errors
/// As [`Loaded::new`].
pub(super) fn geometry(job: &Job) -> Result<Scene, RunError> {
    let declared = describe(job, Needs::POSITIONS)?;
    Ok(Scene::build(&moved(job, &declared), Needs::POSITIONS)?)
}

/// The technique of a job with its parameters.
pub fn build_technique(job: &Job) -> Result<Box<dyn Technique>, RunError> {
    let build = technique_of(job)?.build;
    build(&job.technique_parameters).map_err(|e| RunError::Technique(e.to_string()))
}

fn technique_of(job: &Job) -> Result<&'static TechniqueEntry, RunError> {
    crate::registry::technique(&job.technique)
        .ok_or_else(|| RunError::Technique(format!("no technique is called `{}`", job.technique)))
}

/// The scene of a job as declared; the files that a technique needs of it are there.
fn describe(job: &Job, needs: Needs) -> Result<SceneDescription, RunError> {
    let mut description = find_scene(&job.found)?;
    if let Some(metres) = job.metres_per_unit {
        description.metres_per_unit = Some(metres);
    }
    if let Some(edges) = job.max_depth {
        description.max_depth = edges;
    }
    if let Some(name) = &job.environment {
        description.environment = Some(find_environment(name)?);
    }
    // Under the map, which a motion may turn.
    if let Some(additions) = &job.additions {
        additions.add_to(&mut description)?;
    }
    description.require_files(needs, job.incomplete)?;
    Ok(description)
}
