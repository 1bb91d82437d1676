//! Carries out a plan: one scene at a time, one reference a shot, then its jobs.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::DVec3;

use super::light_files::write_lights;
use super::panics::with_panics_as_errors;
use super::provenance::{self, Provenance};
use super::reference::{Reference, ReferenceStore};
use super::{Budget, Config, Job, Plan, Row, Store, equal_time, progress::Progress};
use crate::image::{Attributes, Image, Layer, Plane, write_exr, write_png};
use crate::memory;
use crate::metric::{CompareOptions, Comparison, compare};
use crate::scene::{Needs, Scene, SceneDescription, find_environment, find_scene};
use crate::technique::{Choice, Film, Rendered, Search, Shot, Technique, TechniqueEntry, Terms};
use crate::world::{Moment, World};

/// How often the rows so far are written, at most.
const ROWS_EVERY: Duration = Duration::from_secs(5);

/// Where results go and what to do about failures.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// `results/<name>/`.
    pub folder: PathBuf,
    pub references: PathBuf,
    /// Stop at the first job that fails.
    pub fail_fast: bool,
    pub quiet: bool,
}

/// How many jobs were done now, earlier, and in vain.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    pub done: usize,
    pub found: usize,
    pub failed: usize,
}

/// An error that ends the run; failures of single jobs are rows.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error("{0}")]
    Scene(#[from] crate::scene::SceneError),
    #[error("results: {0}")]
    Io(#[from] io::Error),
    #[error("{0}")]
    Image(#[from] crate::image::ImageError),
    #[error("{0}")]
    Technique(String),
}

/// Runs the jobs of a plan that are not there yet. Jobs of the same configs that the folder has from
/// other selections stay in its plan and in its rows.
pub fn run(plan: &Plan, config: &Config, options: &RunOptions) -> Result<Outcome, RunError> {
    let store = Store::create(&options.folder)?;
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
        rows_written: Instant::now(),
        references: ReferenceStore {
            folder: options.references.clone(),
        },
        outcome: Outcome::default(),
        keeps_lights: config.figure.iter().any(|f| f.kind.shows_lights()),
        bytes_scene: 0,
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
    runner.progress.start(&open, runner.outcome.found);
    for jobs in open.chunk_by(|a, b| same_scene(a, b)) {
        runner.scene(jobs, options.fail_fast)?;
        if options.fail_fast && runner.outcome.failed > 0 {
            break;
        }
    }
    let rows = runner.store.rows(&runner.plan);
    runner.store.write_rows(&rows)?;
    runner.progress.finish(&rows);
    Ok(runner.outcome)
}

/// Whether two jobs look at the same loaded scene.
fn same_scene(a: &Job, b: &Job) -> bool {
    let loaded = |job: &Job| (job.transform, job.metres_per_unit, job.incomplete);
    a.found == b.found && a.environment == b.environment && loaded(a) == loaded(b)
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
    rows_written: Instant,
    /// Whether a figure asks for the lights of the jobs.
    keeps_lights: bool,
    /// Bytes of the loaded scene and its trees.
    bytes_scene: u64,
}

impl Runner {
    /// All open jobs of one scene; they fail if it does not load.
    fn scene(&mut self, jobs: &[&Job], fail_fast: bool) -> Result<(), RunError> {
        self.progress.stage(&format!("{}: loading", jobs[0].scene));
        let held_before = memory::held();
        self.scene_notes.clear();
        let mut world =
            match with_panics_as_errors(|| self.load(jobs[0]).map_err(|e| e.to_string())) {
                Ok(world) => world,
                Err(reason) => return self.fail(jobs, &reason, fail_fast),
            };
        let moment = world.at(0.0);
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
            self.shot(jobs, moment, fail_fast)?;
            if fail_fast && self.outcome.failed > 0 {
                break;
            }
        }
        Ok(())
    }

    fn load(&self, job: &Job) -> Result<World, RunError> {
        let technique = build_technique(job)?;
        let progress = &self.progress;
        let needs = technique.needs();
        let description = describe_scene(job, needs)?;
        let scene = progress.time("loading", || Scene::build(&description, needs))?;
        Ok(progress.time("building trees", || World::declared(scene, &description)))
    }

    /// All open jobs that share a reference.
    fn shot(&mut self, jobs: &[&Job], moment: Moment, fail_fast: bool) -> Result<(), RunError> {
        let technique = build_technique(jobs[0])?;
        let mut shot = shot_of(jobs[0], moment)?;
        let progress = &self.progress;
        let obtain = || {
            self.references.obtain(
                &jobs[0].reference,
                (technique.as_ref(), &shot),
                &|done, all| progress.reference(jobs[0], done, all),
            )
        };
        let obtain = || {
            progress
                .time("references", obtain)
                .map_err(|e| e.to_string())
        };
        let reference = match with_panics_as_errors(obtain) {
            Ok(reference) => reference,
            Err(reason) => return self.fail(jobs, &format!("no reference: {reason}"), fail_fast),
        };
        shot.layer = progress.time("shared layers", || technique.shared_layer(&shot));
        for job in jobs {
            let (row, pictures) = self.job(job, (technique.as_ref(), &shot), &reference);
            let keeps_lights = self.keeps_lights;
            self.keep(job, &row, |folder| match &pictures {
                Some(pictures) => {
                    if let Some(set) = &pictures.rendered.lights
                        && let Some(map) = &shot.scene.environment
                        && keeps_lights
                    {
                        write_lights(folder, set, map)?;
                    }
                    pictures.write(folder, &row)
                }
                None => Ok(()),
            })?;
            if fail_fast && !row.ok() {
                break;
            }
        }
        Ok(())
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

    /// Writes a job, counts it, and now and then writes the rows so far.
    fn keep(
        &mut self,
        job: &Job,
        row: &Row,
        fill: impl FnOnce(&Path) -> io::Result<()>,
    ) -> io::Result<()> {
        self.outcome.failed += usize::from(!row.ok());
        self.outcome.done += 1;
        let (store, progress) = (&self.store, &self.progress);
        progress.time("writing", || store.write_job(row, fill))?;
        progress.job(job, row);
        if self.rows_written.elapsed() > ROWS_EVERY {
            store.write_rows(&store.rows(&self.plan))?;
            self.rows_written = Instant::now();
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

    fn job(
        &self,
        job: &Job,
        (technique, shot): (&dyn Technique, &Shot),
        reference: &Reference,
    ) -> (Row, Option<Pictures>) {
        let mut row = self.row(job);
        row.bytes_scene = self.bytes_scene;
        let start = Instant::now();
        let options = CompareOptions {
            exposure: technique.exposure_stops(shot.scene),
            maps: true,
            ..CompareOptions::default()
        };
        let render = |count: u64| {
            let choice = Choice {
                method: &job.method,
                parameters: &job.method_parameters,
                terms: Terms {
                    budget: count as usize,
                    seed: job.seed,
                },
            };
            choice.still(technique, shot, Some(&reference.mean))
        };
        let render = || match job.budget {
            Budget::Caches(count) | Budget::Lights(count) | Budget::Samples(count) => render(count),
            Budget::Seconds(seconds) => equal_time::render_within(seconds, render),
        };
        let result = with_panics_as_errors(render).and_then(|rendered| {
            let uncharged = start.elapsed().as_secs_f64() - rendered.stages.total().wall;
            self.progress.spend("not charged", uncharged);
            self.progress
                .time("metrics", || {
                    compare(&reference.mean, &rendered.image, &options)
                })
                .map(|comparison| (rendered, comparison))
                .map_err(|e| e.to_string())
        });
        match result {
            Err(reason) => {
                row.status = format!("failed: {reason}");
                (row, None)
            }
            Ok((rendered, comparison)) => {
                fill(&mut row, job, (&rendered, &comparison), reference);
                let pictures = Pictures {
                    rendered,
                    comparison,
                    reference: reference.mean.clone(),
                    exposure: technique.exposure_stops(shot.scene),
                };
                (row, Some(pictures))
            }
        }
    }
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
pub fn describe_scene(job: &Job, needs: Needs) -> Result<SceneDescription, RunError> {
    let mut description = find_scene(&job.found)?;
    if let Some(name) = &job.environment {
        description.environment = Some(find_environment(name)?);
    }
    if let Some(metres) = job.metres_per_unit {
        description.metres_per_unit = Some(metres);
    }
    description.require_files(needs, job.incomplete)?;
    Ok(match job.transform {
        Some(t) => description.transformed(t.scale, t.rotate_y_deg, DVec3::from(t.translate)),
        None => description,
    })
}

/// The world of a job, with only what the technique needs.
pub fn load_world(job: &Job, technique: &dyn Technique) -> Result<World, RunError> {
    let needs = technique.needs();
    let description = describe_scene(job, needs)?;
    let scene = Scene::build(&description, needs)?;
    Ok(World::declared(scene, &description))
}

/// The shot of a job in a loaded scene.
pub fn shot_of<'a>(job: &Job, moment: Moment<'a>) -> Result<Shot<'a>, RunError> {
    let view = moment
        .scene
        .views
        .iter()
        .find(|v| v.name == job.view)
        .ok_or_else(|| RunError::Technique(format!("{} has no view `{}`", job.scene, job.view)))?;
    let film = Film {
        width: job.width,
        height: job.height,
        spp: job.spp,
    };
    let technique = build_technique(job)?;
    Ok(Shot::exposed_for(technique.as_ref(), moment, view, film))
}

fn fill(
    row: &mut Row,
    job: &Job,
    (rendered, comparison): (&Rendered, &Comparison),
    reference: &Reference,
) {
    match job.budget {
        Budget::Caches(_) => row.caches = Some(rendered.records.len() as u64),
        Budget::Samples(_) => {}
        Budget::Lights(_) | Budget::Seconds(_) => {
            row.lights = rendered.lights.as_ref().map(|l| l.lights.len() as u64)
        }
    }
    row.rays = rendered.rays.closest;
    row.shadow_rays = rendered.rays.shadow;
    row.lookups = rendered.lookups;
    row.bytes_cache = rendered.bytes_cache as u64;
    row.bytes_work = rendered.bytes_work as u64;
    for stage in &rendered.stages.0 {
        let name = || stage.name.to_owned();
        row.seconds.insert(name(), stage.seconds.wall.into());
        row.cpu_seconds.insert(name(), stage.seconds.cpu.into());
        row.serial_share
            .insert(name(), stage.seconds.serial_share().into());
    }
    let total = rendered.stages.total();
    row.seconds_total = total.wall;
    row.cpu_seconds_total = total.cpu;
    if rendered.search != Search::default() {
        row.seconds
            .insert("search_settings".into(), rendered.search.seconds.into());
        row.search_rays = rendered.search.rays.closest;
        row.search_shadow_rays = rendered.search.rays.shadow;
    }
    for (key, value) in &job.method_parameters {
        if let Ok(value) = serde_json::to_value(value) {
            row.params.insert(key.clone(), value);
        }
    }
    for (key, value) in &rendered.found {
        row.params.insert((*key).to_owned(), (*value).into());
    }
    row.rmse = Some(comparison.rmse);
    row.relmse = Some(comparison.relmse);
    row.psnr = comparison.psnr;
    row.ssim = Some(comparison.ssim);
    row.ms_ssim = Some(comparison.ms_ssim);
    row.flip_ldr = Some(comparison.flip_ldr);
    row.flip_hdr = comparison.flip_hdr;
    row.reference_floor = reference.floor();
    row.non_finite = rendered.non_finite;
    row.notes.extend_from_slice(&rendered.notes);
    if rendered.non_finite > 0 && !job.allow_non_finite {
        row.status = format!(
            "failed: {} non-finite values; `allow_non_finite = true` tolerates them",
            rendered.non_finite
        );
    }
}

/// What a job leaves to look at.
struct Pictures {
    rendered: Rendered,
    comparison: Comparison,
    reference: Image,
    /// Stops.
    exposure: f32,
}

impl Pictures {
    fn write(&self, folder: &Path, row: &Row) -> io::Result<()> {
        let image = &self.rendered.image;
        let plane = |values: Vec<f32>| Plane {
            width: image.width,
            height: image.height,
            values,
        };
        let mut layers = vec![
            Layer::color("beauty", image.clone()),
            Layer::color("reference", self.reference.clone()),
            Layer::color("error", difference(image, &self.reference)),
            Layer::gray("records", plane(self.record_map())),
        ];
        if let Some(maps) = &self.comparison.maps {
            layers.push(Layer::gray("flip", maps.flip_ldr.clone()));
        }
        if let Some(map) = &self.rendered.discontinuity {
            layers.push(Layer::gray("discontinuity", plane(map.clone())));
        }
        let mut attributes = Attributes::new();
        for key in ["job", "scene", "view", "method", "label", "budget"] {
            let value = serde_json::to_value(row)?[key].clone();
            attributes.insert(key.into(), value);
        }
        attributes.insert("exposure".into(), f64::from(self.exposure).into());
        write_exr(&folder.join("image.exr"), &layers, &attributes).map_err(io::Error::other)?;
        write_png(&folder.join("preview.png"), image, self.exposure).map_err(io::Error::other)
    }

    /// 1 where the first stage put a record, 2 where the refinement did.
    fn record_map(&self) -> Vec<f32> {
        let mut map = vec![0.0; self.rendered.image.pixels.len()];
        for record in &self.rendered.records {
            map[record.pixel as usize] = f32::from(record.stage) + 1.0;
        }
        map
    }
}

fn difference(image: &Image, reference: &Image) -> Image {
    let mut error = image.clone();
    for (e, r) in error.pixels.iter_mut().zip(&reference.pixels) {
        (0..3).for_each(|c| e[c] -= r[c]);
    }
    error
}
