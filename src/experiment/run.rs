//! Carries out a plan: one scene at a time, one reference a shot, then its jobs.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::loaded::{Loaded, build_technique};
use super::panics::with_panics_as_errors;
use super::play::Player;
use super::provenance::{self, Provenance};
use super::reference_store::ReferenceStore;
use super::sequence::{FrameRecord, frames_csv};
use super::truths::Truths;
use super::{Config, Job, Plan, Row, Store, progress::Progress};
use crate::memory;
use crate::technique::{CACHES, Stages};

/// Rows are written again after a job once so many times what that took has gone by since.
const ROWS_SHARE: u32 = 20;

/// Where results go and what to do about failures.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// `results/<name>/`.
    pub folder: PathBuf,
    /// The reference store that experiments share.
    pub references: PathBuf,
    /// Stop at the first job that fails.
    pub fail_fast: bool,
    /// Whether progress is kept from standard error.
    pub quiet: bool,
    /// How often a sequence at work is saved, so that it goes on there after an interruption.
    pub checkpoint_every: Duration,
}

/// How many jobs were run now, in vain, and earlier, and what was done besides.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Jobs that were run now, with or without success.
    pub run: usize,
    /// Jobs that had a row without failure already.
    pub found: usize,
    /// Jobs of `run` whose row gives a reason of failure.
    pub failed: usize,
    /// What belongs to no job: loading, references, metrics, files.
    pub besides: Stages,
}

/// An error that ends the run; failures of single jobs are rows.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A scene, map or file of a scene is absent or damaged.
    #[error("{0}")]
    Scene(#[from] crate::scene::SceneError),
    /// The results folder or the reference store cannot be read or written.
    #[error("results: {0}")]
    Io(#[from] io::Error),
    /// An image of the run cannot be read or written.
    #[error("{0}")]
    Image(#[from] crate::image::ImageError),
    /// A technique is unknown, or it or a contender refuses its parameters.
    #[error("{0}")]
    Technique(String),
    /// A folder with results of another experiment.
    #[error(
        "{folder}: holds results of the experiment `{name}`; choose another folder, or remove it"
    )]
    Foreign {
        /// The folder of results.
        folder: PathBuf,
        /// The experiment that it is of.
        name: String,
    },
    /// A scene that has not what a technique is about.
    #[error("{0}")]
    Unfit(String),
}

/// Runs the jobs of a plan that are not there yet. Jobs of the same configs that the folder has from
/// other selections stay in its plan and in its rows.
pub fn run(plan: &Plan, config: &Config, options: &RunOptions) -> Result<Outcome, RunError> {
    let store = Store::create(&options.folder)?;
    if let Ok(earlier) = store.plan()
        && earlier.name != plan.name
    {
        return Err(RunError::Foreign {
            folder: options.folder.clone(),
            name: earlier.name,
        });
    }
    let (united, gone) = store.united(plan);
    store.write(
        "plan.json",
        &serde_json::to_string_pretty(&united).map_err(io::Error::other)?,
    )?;
    store.write(
        "config.json",
        &serde_json::to_string_pretty(config).map_err(io::Error::other)?,
    )?;
    let mut provenance = Provenance::of(&store);
    provenance.start(plan);
    provenance.write(&store)?;
    let mut runner = Runner {
        progress: Progress::new(&united, options.quiet),
        store,
        plan: united,
        provenance,
        scene_notes: Vec::new(),
        rows_written: None,
        references: ReferenceStore {
            folder: options.references.clone(),
        },
        outcome: Outcome::default(),
        keeps_lights: config.figure.iter().any(|f| f.kind.shows_lights()),
        bytes_scene: 0,
        checkpoint_every: options.checkpoint_every,
    };
    if gone > 0 {
        runner.progress.note(&format!(
            "{gone} jobs in this folder are no longer in the config: they leave its plan and report"
        ));
    }
    let finished: HashSet<&str> = plan
        .jobs
        .iter()
        .filter(|job| runner.store.row(&job.id).is_some_and(|row| row.ok()))
        .map(|job| job.id.as_str())
        .collect();
    let mut seen = HashSet::new();
    let open: Vec<&Job> = plan
        .jobs
        .iter()
        .filter(|job| seen.insert(job.id.as_str()))
        .filter(|job| !finished.contains(job.id.as_str()))
        .collect();
    runner.outcome.found = seen.len() - open.len();
    let references = &runner.references;
    let is_stored = |key: &str| references.path(key).is_file();
    (runner.progress).start(&open, runner.outcome.found, is_stored);
    for jobs in open.chunk_by(|a, b| same_scene(a, b)) {
        runner.scene(jobs, options.fail_fast)?;
        if options.fail_fast && runner.outcome.failed > 0 {
            break;
        }
    }
    let rows = runner.store.rows(&runner.plan);
    runner.store.write_rows(&rows)?;
    runner.progress.finish(&rows);
    runner.outcome.besides = runner.progress.besides();
    Ok(runner.outcome)
}

/// Whether two jobs look at the same loaded scene.
pub(super) fn same_scene(a: &Job, b: &Job) -> bool {
    let loaded = |job: &Job| {
        let replaced = (job.metres_per_unit, job.max_depth);
        (job.transform, replaced, job.incomplete)
    };
    // What is loaded of a scene is what the technique needs.
    a.technique == b.technique
        && a.found == b.found
        && a.environment == b.environment
        && a.additions == b.additions
        && loaded(a) == loaded(b)
}

struct Runner {
    store: Store,
    references: ReferenceStore,
    progress: Progress,
    outcome: Outcome,
    /// What the folder is about: the plan that is run and what was there before.
    plan: Plan,
    provenance: Provenance,
    /// What was lost of the scene at work.
    scene_notes: Vec<String>,
    /// When the rows so far were written last, and how long that took.
    rows_written: Option<(Instant, Duration)>,
    /// Whether a figure asks for the lights of the jobs.
    keeps_lights: bool,
    /// Bytes of the loaded scene and its trees.
    bytes_scene: u64,
    checkpoint_every: Duration,
}

impl Runner {
    /// All open jobs of one scene; they fail if it does not load.
    fn scene(&mut self, jobs: &[&Job], fail_fast: bool) -> Result<(), RunError> {
        self.progress.stage(&format!("{}: loading", jobs[0].scene));
        let held_before = memory::held();
        self.scene_notes.clear();
        let mut loaded =
            match with_panics_as_errors(|| self.load(jobs[0]).map_err(|e| e.to_string())) {
                Ok(loaded) => loaded,
                Err(reason) => return self.fail(jobs, &reason, fail_fast),
            };
        let moment = loaded.world.at(0.0);
        self.bytes_scene = memory::held().saturating_sub(held_before) as u64;
        self.scene_notes = moment.scene.report.sentences();
        if self.provenance.note(&jobs[0].scene, &self.scene_notes) {
            self.provenance.write(&self.store)?;
        }
        for note in &self.scene_notes {
            self.progress
                .note(&format!("scene `{}`: {note}", jobs[0].scene));
        }
        for jobs in jobs.chunk_by(|a, b| a.reference == b.reference) {
            // Seed by seed: what is interrupted has something of every method, and the time that is left is known early.
            let mut jobs = jobs.to_vec();
            jobs.sort_by_key(|job| job.seed);
            self.sequence(&jobs, &mut loaded, fail_fast)?;
            if fail_fast && self.outcome.failed > 0 {
                break;
            }
        }
        Ok(())
    }

    fn load(&self, job: &Job) -> Result<Loaded, RunError> {
        let technique = build_technique(job)?;
        let load = || Loaded::new(job, technique.as_ref());
        self.progress.time("loading", load)
    }

    /// All open jobs that share references.
    fn sequence(
        &mut self,
        jobs: &[&Job],
        loaded: &mut Loaded,
        fail_fast: bool,
    ) -> Result<(), RunError> {
        let references = self.references.clone();
        let declared = loaded.declared.clone();
        let mut truths = Truths::new(&references, &declared, jobs[0]);
        for job in jobs {
            let folder = self.store.begin(&job.id)?;
            // Its own: parameters that references do not depend on may differ from job to job.
            let technique = build_technique(job)?;
            let player = Player {
                job,
                technique: technique.as_ref(),
                folder: &folder,
                checkpoint_every: self.checkpoint_every,
                keeps_lights: self.keeps_lights,
                progress: &self.progress,
            };
            let played = with_panics_as_errors(|| player.play(loaded, &mut truths));
            let (row, frames) = self.told(job, played);
            // A still has none; a sequence has them, however few of its frames were rendered.
            let sequence = &job.sequence;
            let is_still = sequence.frames.len() * sequence.viewers.len() <= 1;
            self.keep(job, &row, |folder| match is_still || frames.is_empty() {
                true => Ok(()),
                false => crate::files::write(&folder.join("frames.csv"), frames_csv(&frames)?),
            })?;
            if fail_fast && !row.ok() {
                break;
            }
        }
        Ok(())
    }

    /// The row of a job that was played, and its frames.
    fn told(&self, job: &Job, played: Result<Vec<FrameRecord>, String>) -> (Row, Vec<FrameRecord>) {
        let mut row = self.row(job);
        row.bytes_scene = self.bytes_scene;
        let frames = match played {
            Ok(frames) => frames,
            Err(reason) => {
                row.status = format!("failed: {reason}");
                return (row, Vec::new());
            }
        };
        if *job.budget.unit == CACHES {
            row.caches = Some(0);
        }
        for (key, value) in &job.method_parameters {
            if let Ok(value) = serde_json::to_value(value) {
                row.params.insert(key.clone(), value);
            }
        }
        row.sum_up(&frames);
        if row.non_finite > 0 && !job.allow_non_finite {
            row.status = format!(
                "failed: {} non-finite values; `allow_non_finite = true` tolerates them",
                row.non_finite
            );
        }
        (row, frames)
    }

    /// Rows of jobs that cannot begin.
    fn fail(&mut self, jobs: &[&Job], reason: &str, fail_fast: bool) -> Result<(), RunError> {
        for job in jobs {
            let row = Row {
                status: format!("failed: {reason}"),
                ..self.row(job)
            };
            self.keep(job, &row, |_| Ok(()))?;
            if fail_fast {
                break;
            }
        }
        Ok(())
    }

    /// Writes a job and counts it. The rows so far are written with it, unless that was done just before: it takes a
    /// twentieth of the time at most.
    fn keep(
        &mut self,
        job: &Job,
        row: &Row,
        fill: impl FnOnce(&Path) -> io::Result<()>,
    ) -> io::Result<()> {
        self.outcome.failed += usize::from(!row.ok());
        self.outcome.run += 1;
        let (store, progress) = (&self.store, &self.progress);
        progress.time("writing", || store.write_job(row, fill))?;
        progress.job(job, row);
        let is_due = |(at, took): (Instant, Duration)| at.elapsed() >= took * ROWS_SHARE;
        if self.rows_written.is_none_or(is_due) {
            let start = Instant::now();
            store.write_rows(&store.rows(&self.plan))?;
            self.rows_written = Some((Instant::now(), start.elapsed()));
        }
        Ok(())
    }

    /// What is known of a job before it runs.
    fn row(&self, job: &Job) -> Row {
        let mut row = Row {
            status: "ok".into(),
            notes: self.scene_notes.clone(),
            program: provenance::program(),
            kernel: provenance::kernel(),
            machine: provenance::machine(),
            ..Row::default()
        };
        row.describe(job, &self.plan.name);
        row
    }
}
