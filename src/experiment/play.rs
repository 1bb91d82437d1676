//! Plays a job: its frames one after another, each for all viewers, measured against their references.

use std::path::Path;
use std::rc::Rc;

use super::Job;
use super::afford::{Afforded, afford};
use super::loaded::Loaded;
use super::pictures::{self, Shown};
use super::progress::Progress;
use super::sequence::{Animation, Checkpoint, FrameRecord, Metrics, Thumbnail};
use super::truths::{Truth, Truths};
use crate::image::Image;
use crate::metric::{CompareOptions, Comparison, compare, pixel_errors};
use crate::technique::{Contender, Film, Playing, Rendered, Shot, Technique};

/// A job and all that it is played with.
pub(super) struct Player<'a> {
    pub job: &'a Job,
    pub technique: &'a dyn Technique,
    /// Where the job's files are put until it is complete.
    pub folder: &'a Path,
    pub checkpoint_every: std::time::Duration,
    pub keeps_lights: bool,
    pub progress: &'a Progress,
}

/// What the frames of a job are made from.
struct Sources<'a, 't> {
    loaded: &'a mut Loaded,
    truths: &'a mut Truths<'t>,
    /// Of each viewer.
    exposures: Vec<f32>,
}

/// A frame of a job, as all its viewers see it.
struct Frame<'a> {
    place: usize,
    number: u32,
    time_s: f64,
    shots: &'a [Shot<'a>],
}

/// Whether a contender renders a frame of a job: one that nobody looks at is left out where nothing follows from it.
pub(super) fn renders(job: &Job, contender: &dyn Contender, place: usize) -> bool {
    let sequence = &job.sequence;
    let follows = contender.remembers() || contender.searches() || job.budget.count().is_none();
    !sequence.skip_unmeasured || follows || sequence.is_looked_at(place)
}

impl Player<'_> {
    /// Renders and measures all frames that no checkpoint has, and leaves pictures of those that are kept.
    ///
    /// # Errors
    /// A sentence, where the contender, a reference or a file fails.
    pub fn play(
        &self,
        loaded: &mut Loaded,
        truths: &mut Truths,
    ) -> Result<Vec<FrameRecord>, String> {
        let sequence = &self.job.sequence;
        let exposures = truths.exposures(|| self.exposures(loaded))?;
        let mut sources = Sources {
            loaded,
            truths,
            exposures,
        };
        let mut state = Checkpoint::read(self.folder);
        let mut afforded = match state.count {
            None => self.afford(&mut sources)?,
            Some(_) => None,
        };
        state.count = state.count.or(afforded.as_ref().map(|found| found.count));
        let mut playing = self.start(state.count)?;
        self.rewind(&mut sources, playing.contender.as_mut(), state.done)?;
        playing.recall(&state.memory)?;
        let mut written = std::time::Instant::now();
        for place in state.done..sequence.frames.len() {
            if !renders(self.job, playing.contender.as_ref(), place) {
                state.errors.clear();
                state.done = place + 1;
                continue;
            }
            self.at(&mut sources, place, |frame, truths| {
                let images = match afforded.take() {
                    None => self.frame(&mut playing, frame, truths)?,
                    Some(mut found) => {
                        let mut images = std::mem::take(&mut found.images);
                        if images.is_empty() {
                            images = self.frame(&mut playing, frame, truths)?;
                        }
                        found.tell(&mut images);
                        images
                    }
                };
                self.measure(frame, images, &mut state, truths)
            })?;
            state.done = place + 1;
            self.progress
                .frame(self.job, state.done, sequence.frames.len());
            if written.elapsed() >= self.checkpoint_every && state.done < sequence.frames.len() {
                state.memory = playing.contender.memory()?;
                state.write(self.folder).map_err(|e| e.to_string())?;
                written = std::time::Instant::now();
            }
        }
        let animation = Animation::of(sequence);
        animation
            .write(self.folder, &state.thumbnails)
            .map_err(|e| e.to_string())?;
        Checkpoint::remove(self.folder).map_err(|e| e.to_string())?;
        Ok(state.frames)
    }

    /// The contender; `count` is what a budget that is spent was found to pay for.
    fn start(&self, count: Option<u64>) -> Result<Playing<'_>, String> {
        let count = count.or(self.job.budget.count()).unwrap_or(1);
        self.job.choice(count).play_from_start(self.technique)
    }

    /// The world one frame before the next one that is played: the beginning, or after a checkpoint. Then the contender
    /// has seen the first frame's scene again, and searched for its settings.
    fn rewind(
        &self,
        sources: &mut Sources,
        contender: &mut dyn Contender,
        done: usize,
    ) -> Result<(), String> {
        sources.loaded.world.rewind();
        let Some(before) = done.checked_sub(1) else {
            return Ok(());
        };
        self.at(sources, 0, |first, truths| {
            contender.rebuild(first.shots)?;
            match contender.searches() {
                true => self.search(contender, first.shots, truths),
                false => Ok(()),
            }
        })?;
        let sequence = &self.job.sequence;
        sources
            .loaded
            .world
            .at(sequence.time_s(sequence.frames[before]));
        Ok(())
    }

    /// The exposure of each viewer, by its first shot.
    fn exposures(&self, loaded: &mut Loaded) -> Result<Vec<f32>, String> {
        if !self.technique.decides_exposure() {
            return Ok(vec![1.0; self.job.sequence.viewers.len()]);
        }
        let first = self.job.sequence.frames[0];
        let views = loaded.views(self.job, first)?;
        let moment = loaded.world.at(self.job.sequence.time_s(first));
        let shots = views
            .iter()
            .map(|view| Shot::new(moment, view, Film::of(self.job)));
        Ok(shots.map(|shot| self.technique.exposure(&shot)).collect())
    }

    /// Does something with the frame at a place of the sequence: what its viewers see, over the layer that their technique
    /// leaves to others.
    fn at<T>(
        &self,
        sources: &mut Sources,
        place: usize,
        act: impl FnOnce(&Frame, &mut Truths) -> Result<T, String>,
    ) -> Result<T, String> {
        let Sources {
            loaded,
            truths,
            exposures,
        } = sources;
        let number = self.job.sequence.frames[place];
        let time_s = self.job.sequence.time_s(number);
        let views = loaded.views(self.job, number)?;
        let moment = loaded.world.at(time_s);
        let film = Film::of(self.job);
        let seen = views.iter().zip(exposures).zip(0..);
        let shots: Vec<Shot> = seen
            .map(|((view, exposure), viewer)| {
                let mut shot = Shot::new(moment, view, film);
                (shot.frame, shot.viewer, shot.exposure) = (number, viewer, *exposure);
                shot.layer = truths.layer(self.technique, &shot);
                shot
            })
            .collect();
        let frame = Frame {
            place,
            number,
            time_s,
            shots: &shots,
        };
        act(&frame, truths)
    }

    /// Renders a frame, after a search for settings if it is the first.
    fn frame(
        &self,
        playing: &mut Playing,
        frame: &Frame,
        truths: &mut Truths,
    ) -> Result<Vec<Rendered>, String> {
        if frame.place == 0 && playing.contender.searches() {
            self.search(playing.contender.as_mut(), frame.shots, truths)?;
        }
        let start = std::time::Instant::now();
        let images = self.played(playing, frame)?;
        let charged: f64 = images.iter().map(|image| image.stages.total().wall).sum();
        // Charged may be what earlier jobs have found.
        let uncharged = (start.elapsed().as_secs_f64() - charged).max(0.0);
        self.progress.spend("not charged", uncharged);
        Ok(images)
    }

    /// The images of a frame, with the cells that those to be kept show.
    fn played(&self, playing: &mut Playing, frame: &Frame) -> Result<Vec<Rendered>, String> {
        let mut images = playing.frame(frame.shots)?;
        for (shot, rendered) in frame.shots.iter().zip(&mut images) {
            if self.is_image(shot) || self.is_kept(shot) {
                rendered.cells = playing.contender.cells(shot);
            }
        }
        Ok(images)
    }

    /// Whether what a shot shows becomes the job's image.
    fn is_image(&self, shot: &Shot) -> bool {
        shot.frame == self.job.sequence.representative() && shot.viewer == 0
    }

    /// Whether it is among the frames that are kept.
    fn is_kept(&self, shot: &Shot) -> bool {
        let sequence = &self.job.sequence;
        sequence.images() > 1 && sequence.kept.contains(&shot.frame)
    }

    fn search(
        &self,
        contender: &mut dyn Contender,
        shots: &[Shot],
        truths: &mut Truths,
    ) -> Result<(), String> {
        let references = shots.iter().map(|shot| self.truth(truths, shot));
        let references = references.collect::<Result<Vec<Rc<Truth>>, _>>()?;
        let means: Vec<&Image> = references.iter().map(|r| &r.reference.mean).collect();
        contender.search(shots, &means)
    }

    fn truth(&self, truths: &mut Truths, shot: &Shot) -> Result<Rc<Truth>, String> {
        truths.of(self.job, self.technique, shot, self.progress)
    }

    /// How many lights or samples a budget pays for; `None` where they are counted out.
    fn afford(&self, sources: &mut Sources) -> Result<Option<Afforded>, String> {
        afford(self.job.budget, |trial| {
            let mut playing = self.start(Some(trial.count))?;
            sources.loaded.world.rewind();
            for place in 0..self.job.sequence.frames.len() {
                self.at(sources, place, |frame, _| {
                    let images = self.played(&mut playing, frame)?;
                    trial.add(images, frame.shots[0].pixels());
                    Ok(())
                })?;
            }
            Ok(())
        })
    }

    /// Compares the images of a frame with their references and notes what it took.
    fn measure(
        &self,
        frame: &Frame,
        images: Vec<Rendered>,
        state: &mut Checkpoint,
        truths: &mut Truths,
    ) -> Result<(), String> {
        let sequence = &self.job.sequence;
        let exposure = self.technique.exposure_stops(frame.shots[0].scene);
        let cold = self.cold_images(frame, state.count, truths)?;
        let mut errors = Vec::new();
        for (shot, rendered) in frame.shots.iter().zip(images) {
            let mut record = FrameRecord {
                frame: frame.number,
                viewer: shot.viewer,
                time_s: frame.time_s,
                ..FrameRecord::of(&rendered)
            };
            let mut measured = None;
            if sequence.is_measured(frame.place) {
                let truth = self.truth(truths, shot)?;
                let reference = &truth.reference;
                let comparison = self.compare(&reference.mean, &rendered.image, exposure)?;
                let error = pictures::difference(&rendered.image, &reference.mean);
                let viewer = usize::from(shot.viewer);
                let before = state.errors.get(viewer);
                record.error_change = before.map(|before| mean_square_change(&error, before));
                record.metrics = Some(Metrics::of(&comparison));
                record.reference = Some(truth.key.clone());
                record.reference_floor = reference.floor();
                record.rmse_cold = match cold.get(viewer) {
                    Some(image) => Some(pixel_errors(&reference.mean, image).mse.sqrt()),
                    // Without memory a frame alone is the same.
                    None => sequence.cold.then_some(comparison.rmse),
                };
                errors.push(error);
                measured = Some((truth, comparison));
            }
            let shown = Shown {
                shot,
                rendered: &rendered,
                measured: measured.as_ref().map(|(t, c)| (&t.reference.mean, c)),
                key: record.reference.as_deref().unwrap_or_default(),
                exposure,
            };
            self.leave(&shown, &mut state.thumbnails)
                .map_err(|e| format!("pictures: {e}"))?;
            state.frames.push(record);
        }
        state.errors = errors;
        Ok(())
    }

    fn compare(
        &self,
        reference: &Image,
        image: &Image,
        exposure: f32,
    ) -> Result<Comparison, String> {
        let options = CompareOptions {
            exposure,
            maps: true,
            ..CompareOptions::default()
        };
        let compared = || compare(reference, image, &options);
        self.progress
            .time("metrics", compared)
            .map_err(|e| e.to_string())
    }

    /// The images of a measured frame by a contender that has seen no frame before; none where that is not asked for,
    /// and where contenders have no memory.
    fn cold_images(
        &self,
        frame: &Frame,
        count: Option<u64>,
        truths: &mut Truths,
    ) -> Result<Vec<Image>, String> {
        let sequence = &self.job.sequence;
        if !sequence.cold || !sequence.is_measured(frame.place) {
            return Ok(Vec::new());
        }
        let mut playing = self.start(count)?;
        if !playing.contender.remembers() {
            return Ok(Vec::new());
        }
        if playing.contender.searches() {
            self.search(playing.contender.as_mut(), frame.shots, truths)?;
        }
        let images = playing.frame(frame.shots)?;
        Ok(images.into_iter().map(|rendered| rendered.image).collect())
    }

    /// Writes the pictures of a frame that are kept.
    fn leave(&self, shown: &Shown, thumbnails: &mut Vec<Thumbnail>) -> std::io::Result<()> {
        let (frame, viewer) = (shown.shot.frame, shown.shot.viewer);
        let writing = || -> std::io::Result<()> {
            if self.is_image(shown.shot) {
                shown.write(self.folder, self.job, "image", "preview")?;
                if self.keeps_lights {
                    shown.write_lights(self.folder)?;
                }
            }
            if self.is_kept(shown.shot) {
                let folder = self.folder.join("frames");
                let name = format!("{frame:06}-{viewer}");
                shown.write(&folder, self.job, &name, &name)?;
            }
            Ok(())
        };
        self.progress.time("writing", writing)?;
        let animation = Animation::of(&self.job.sequence);
        if shown.measured.is_some() && animation.shows(frame) {
            let picture = Thumbnail::of(&shown.rendered.image, shown.exposure, frame, viewer);
            thumbnails.push(picture);
        }
        Ok(())
    }
}

/// Mean over pixels and channels.
fn mean_square_change(error: &Image, before: &Image) -> f64 {
    let pairs = error
        .pixels
        .iter()
        .flatten()
        .zip(before.pixels.iter().flatten());
    let squares = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    squares.sum::<f64>() / (3 * error.pixels.len()).max(1) as f64
}
