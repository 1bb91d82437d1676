//! What all jobs of one sequence are measured against and share: references, exposure, and light that every
//! contender gets.

use std::collections::HashMap;
use std::rc::Rc;

use super::Job;
use super::progress::Progress;
use super::reference::Reference;
use super::reference_store::ReferenceStore;
use crate::image::Image;
use crate::scene::SceneDescription;
use crate::technique::{Shot, Technique};

/// Bytes of references and layers that are held between jobs; longer sequences read or make them again.
const HELD_BYTES: usize = 256 << 20;

/// What one image is measured against.
pub(super) struct Truth {
    /// Of the reference in its store.
    pub key: String,
    pub reference: Reference,
}

/// See the module.
pub(super) struct Truths<'a> {
    store: &'a ReferenceStore,
    description: &'a SceneDescription,
    /// Of each viewer, by its first shot.
    exposures: Option<Vec<f32>>,
    /// By frame and viewer, where all of the sequence can be held.
    references: Option<HashMap<(u32, u16), Rc<Truth>>>,
    layers: Option<HashMap<(u32, u16), Option<Image>>>,
}

impl<'a> Truths<'a> {
    /// Of the sequence of a job.
    pub fn new(store: &'a ReferenceStore, description: &'a SceneDescription, job: &Job) -> Self {
        let pixels = job.width * job.height * job.sequence.images();
        let image = pixels * size_of::<[f32; 3]>();
        Self {
            store,
            description,
            exposures: None,
            references: (2 * image <= HELD_BYTES).then(HashMap::new),
            layers: (image <= HELD_BYTES).then(HashMap::new),
        }
    }

    /// The exposure of each viewer, decided by `of_first` when it is asked for first.
    ///
    /// # Errors
    /// Those of `of_first`.
    pub fn exposures(
        &mut self,
        of_first: impl FnOnce() -> Result<Vec<f32>, String>,
    ) -> Result<Vec<f32>, String> {
        if self.exposures.is_none() {
            self.exposures = Some(of_first()?);
        }
        Ok(self.exposures.clone().unwrap_or_default())
    }

    /// Light of a shot that all contenders share.
    pub fn layer(&mut self, technique: &dyn Technique, shot: &Shot) -> Option<Image> {
        match &mut self.layers {
            None => technique.shared_layer(shot),
            Some(held) => held
                .entry((shot.frame, shot.viewer))
                .or_insert_with(|| technique.shared_layer(shot))
                .clone(),
        }
    }

    /// Key of a shot's reference.
    ///
    /// # Errors
    /// A sentence, where the scene has no longer what the viewer follows.
    fn key(&self, job: &Job, shot: &Shot) -> Result<String, String> {
        let keys = job.references_of(shot.frame, self.description);
        let key = keys.and_then(|keys| keys.into_iter().nth(usize::from(shot.viewer)));
        key.ok_or_else(|| format!("{} has no view or path `{}`", job.scene, job.view))
    }

    /// The complete reference of a shot, with its key.
    ///
    /// # Errors
    /// A sentence, where it can be neither read nor rendered.
    pub fn of(
        &mut self,
        job: &Job,
        technique: &dyn Technique,
        shot: &Shot,
        progress: &Progress,
    ) -> Result<Rc<Truth>, String> {
        let place = (shot.frame, shot.viewer);
        if let Some(known) = self.references.as_ref().and_then(|held| held.get(&place)) {
            return Ok(known.clone());
        }
        let key = self.key(job, shot)?;
        let shown = |done, all| progress.reference(job, done, all);
        let obtained = progress.time("references", || {
            self.store.obtain(&key, technique, shot, &shown)
        });
        let reference = obtained.map_err(|error| format!("no reference: {error}"))?;
        let truth = Rc::new(Truth { key, reference });
        if let Some(held) = &mut self.references {
            held.insert(place, truth.clone());
        }
        Ok(truth)
    }
}
