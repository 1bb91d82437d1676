//! Carries out a plan: one scene at a time, one reference a frame, then its jobs.

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;

use super::caught::caught;
use super::light_files::write_lights;
use super::reference::{Reference, ReferenceStore};
use super::{Budget, Config, Job, Plan, Row, Store, equal_time, progress::Progress};
use crate::image::{Attributes, Image, Layer, Plane, write_exr, write_png};
use crate::metric::{CompareOptions, Comparison, compare};
use crate::scene::{Scene, find_environment, find_scene};
use crate::technique::TechniqueEntry;
use crate::technique::{Contender, Film, Frame, Method, Rendered, Technique};
use crate::trace::Tracer;

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
    #[error("cannot write results: {0}")]
    Io(#[from] io::Error),
    #[error("{0}")]
    Image(#[from] crate::image::ImageError),
    #[error("{0}")]
    Technique(String),
}

/// Runs the jobs of a plan that are not there yet.
pub fn run(plan: &Plan, config: &Config, options: &RunOptions) -> Result<Outcome, RunError> {
    let store = Store::create(&options.folder)?;
    store.write(
        "plan.json",
        &serde_json::to_string_pretty(plan).map_err(io::Error::other)?,
    )?;
    store.write(
        "config.json",
        &serde_json::to_string_pretty(config).map_err(io::Error::other)?,
    )?;
    let mut runner = Runner {
        store,
        references: ReferenceStore {
            folder: options.references.clone(),
        },
        progress: Progress::new(plan, options.quiet),
        outcome: Outcome::default(),
        experiment: plan.name.clone(),
        keeps_lights: config.figure.iter().any(|f| f.kind.shows_lights()),
    };
    runner
        .store
        .write("provenance.json", &super::provenance::collect(plan))?;
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
    let rows = runner.store.rows(plan);
    runner.store.write_rows(&rows)?;
    runner.progress.finish(&rows);
    Ok(runner.outcome)
}

/// Whether two jobs look at the same loaded scene.
fn same_scene(a: &Job, b: &Job) -> bool {
    a.found == b.found && a.transform == b.transform && a.environment == b.environment
}

struct Runner {
    store: Store,
    references: ReferenceStore,
    progress: Progress,
    outcome: Outcome,
    experiment: String,
    /// Whether a figure asks for the lights of the jobs.
    keeps_lights: bool,
}

impl Runner {
    /// All open jobs of one scene.
    fn scene(&mut self, jobs: &[&Job], fail_fast: bool) -> Result<(), RunError> {
        let technique = build_technique(jobs[0])?;
        self.progress.stage(&format!("{}: loading", jobs[0].scene));
        let progress = &self.progress;
        let loaded = progress.time("loading", || load_scene(jobs[0], technique.as_ref()))?;
        let tracer = progress.time("building trees", || {
            Tracer::new(&loaded.positions, &loaded.triangles)
        });
        for jobs in jobs.chunk_by(|a, b| a.reference == b.reference) {
            self.frame(jobs, (&loaded, &tracer), fail_fast)?;
            if fail_fast && self.outcome.failed > 0 {
                break;
            }
        }
        Ok(())
    }

    /// All open jobs that share a reference.
    fn frame(
        &mut self,
        jobs: &[&Job],
        scene: (&Scene, &Tracer),
        fail_fast: bool,
    ) -> Result<(), RunError> {
        let technique = build_technique(jobs[0])?;
        let frame = frame_of(jobs[0], scene)?;
        let progress = &self.progress;
        let reference = progress.time("references", || {
            self.references.obtain(
                &jobs[0].reference,
                (technique.as_ref(), &frame),
                &|done, all| progress.reference(jobs[0], done, all),
            )
        })?;
        for job in jobs {
            let (row, pictures) = self.job(job, (technique.as_ref(), &frame), &reference);
            if !row.ok() {
                self.outcome.failed += 1;
            }
            self.outcome.done += 1;
            self.progress.time("writing", || {
                self.store.write_job(&row, |folder| match &pictures {
                    Some(pictures) => {
                        if let Some(set) = &pictures.rendered.lights
                            && let Some(map) = &frame.scene.environment
                            && self.keeps_lights
                        {
                            write_lights(folder, set, map)?;
                        }
                        pictures.write(folder, &row)
                    }
                    None => Ok(()),
                })
            })?;
            self.progress.job(job, &row);
            if fail_fast && !row.ok() {
                break;
            }
        }
        Ok(())
    }

    fn job(
        &self,
        job: &Job,
        (technique, frame): (&dyn Technique, &Frame),
        reference: &Reference,
    ) -> (Row, Option<Pictures>) {
        let mut row = Row {
            status: "ok".into(),
            ..Row::default()
        };
        row.describe(job, &self.experiment);
        let start = Instant::now();
        let method = match build_method(job) {
            Ok(method) => method,
            Err(error) => {
                row.status = format!("failed: {error}");
                return (row, None);
            }
        };
        let render = |count: u64| {
            let contender = Contender {
                method: &method,
                budget: count as usize,
                seed: job.seed,
                reference: Some(&reference.mean),
            };
            technique.render(frame, &contender)
        };
        let render = || match job.budget {
            Budget::Caches(count) | Budget::Lights(count) => render(count),
            Budget::Seconds(seconds) => equal_time::render_within(seconds, render),
        };
        let options = CompareOptions {
            exposure: technique.exposure_stops(frame.scene),
            maps: true,
            ..CompareOptions::default()
        };
        let result = caught(render).and_then(|rendered| {
            let uncharged = start.elapsed().as_secs_f64() - rendered.stages.total();
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
                row.seconds_total = rendered.stages.total();
                let pictures = Pictures {
                    rendered,
                    comparison,
                    reference: reference.mean.clone(),
                    exposure: technique.exposure_stops(frame.scene),
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

/// The method of a job with its parameters.
pub fn build_method(job: &Job) -> Result<Method, RunError> {
    Method::new(technique_of(job)?, &job.method, &job.method_parameters)
        .map_err(|e| RunError::Technique(e.to_string()))
}

fn technique_of(job: &Job) -> Result<&'static TechniqueEntry, RunError> {
    crate::registry::technique(&job.technique)
        .ok_or_else(|| RunError::Technique(format!("no technique is called `{}`", job.technique)))
}

/// The scene of a job, with only what the technique needs.
pub fn load_scene(job: &Job, technique: &dyn Technique) -> Result<Scene, RunError> {
    let mut description = find_scene(&job.found)?;
    if let Some(name) = &job.environment {
        description.environment = Some(find_environment(name)?);
    }
    if let Some(t) = job.transform {
        description = description.transformed(t.scale, t.rotate_y_deg, DVec3::from(t.translate));
    }
    Ok(Scene::build(&description, technique.needs())?)
}

/// The frame of a job in a loaded scene.
pub fn frame_of<'a>(
    job: &Job,
    (scene, tracer): (&'a Scene, &'a Tracer),
) -> Result<Frame<'a>, RunError> {
    let view = scene
        .views
        .iter()
        .find(|v| v.name == job.view)
        .ok_or_else(|| RunError::Technique(format!("{} has no view `{}`", job.scene, job.view)))?;
    let film = Film {
        width: job.width,
        height: job.height,
        spp: job.spp,
    };
    Ok(Frame::new((scene, tracer), view, film))
}

fn fill(
    row: &mut Row,
    job: &Job,
    (rendered, comparison): (&Rendered, &Comparison),
    reference: &Reference,
) {
    match job.budget {
        Budget::Caches(_) => row.caches = Some(rendered.records.len() as u64),
        Budget::Lights(_) | Budget::Seconds(_) => {
            row.lights = rendered.lights.as_ref().map(|l| l.lights.len() as u64)
        }
    }
    row.rays = rendered.rays.closest;
    row.shadow_rays = rendered.rays.shadow;
    row.lookups = rendered.lookups;
    row.bytes_work = rendered.bytes_peak as u64;
    for (stage, seconds) in &rendered.stages.0 {
        row.seconds.insert((*stage).to_owned(), (*seconds).into());
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
    row.notes.clone_from(&rendered.notes);
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
