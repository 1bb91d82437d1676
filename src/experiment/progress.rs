//! What a run says while it works: plain lines on stderr, a live line on a terminal.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::{Job, Plan, Row};
use crate::standard_error::tell;

/// Progress over the estimated rays of all open jobs and their references.
pub struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    jobs: usize,
    state: Mutex<State>,
    started: Instant,
}

#[derive(Default)]
struct State {
    open: usize,
    done_jobs: usize,
    rays_all: u64,
    rays_done: u64,
    /// Rays of finished passes of the reference at work.
    reference_done: u64,
    last_line: Option<Instant>,
    stages: Vec<(String, f64)>,
}

impl State {
    fn spend(&mut self, stage: &str, seconds: f64) {
        match self.stages.iter_mut().find(|(name, _)| name == stage) {
            Some((_, total)) => *total += seconds,
            None => self.stages.push((stage.to_owned(), seconds)),
        }
    }
}

/// Metrics of one pixel take about as long as this many rays; they are most of a small job.
const RAYS_PER_COMPARED_PIXEL: u64 = 60;

/// What a job costs beside its reference, in rays.
fn work(job: &Job) -> u64 {
    let pixels = (job.width * job.height * job.sequence.images()) as u64;
    job.estimated_rays() + RAYS_PER_COMPARED_PIXEL * pixels
}

impl Progress {
    pub fn new(plan: &Plan, quiet: bool) -> Self {
        let live = !quiet && std::io::stderr().is_terminal();
        Self {
            bar: live.then(|| {
                let bar = ProgressBar::new(1);
                let style = ProgressStyle::with_template("{bar:24} {percent:>3}% {msg}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.enable_steady_tick(Duration::from_millis(500));
                bar
            }),
            quiet,
            jobs: plan.jobs.len(),
            state: Mutex::default(),
            started: Instant::now(),
        }
    }

    /// `open` jobs are to be done, `found` were finished before.
    pub fn start(&self, open: &[&Job], found: usize) {
        let mut references: Vec<&str> = Vec::new();
        let mut rays = 0;
        for job in open {
            rays += work(job);
            if !references.contains(&job.reference.as_str()) {
                references.push(&job.reference);
                rays += job.reference_rays();
            }
        }
        let mut state = self.lock();
        state.open = open.len();
        state.rays_all = rays;
        drop(state);
        if let Some(bar) = &self.bar {
            bar.set_length(rays.max(1));
        }
        let again = if found > 0 {
            format!(", {found} finished earlier and kept")
        } else {
            String::new()
        };
        self.line(&format!("{} jobs to run{again}", open.len()));
    }

    /// A step that has no length of its own.
    pub fn stage(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(text.to_owned()),
            None => self.line(text),
        }
    }

    /// `done` of `all` passes of a job's reference are there.
    pub fn reference(&self, job: &Job, done: u32, all: u32) {
        let mut state = self.lock();
        let per_pass = job.rays_of_reference() / u64::from(all.max(1));
        if done == 0 {
            state.reference_done = 0;
        }
        let rays = per_pass * u64::from(done);
        state.rays_done += rays.saturating_sub(state.reference_done);
        state.reference_done = rays;
        let quiet_for = state.last_line.map_or(Duration::MAX, |at| at.elapsed());
        let text = format!(
            "{}: reference {done}/{all} {}",
            job.scene,
            self.remaining(&state)
        );
        let due = quiet_for > Duration::from_secs(10);
        if due {
            state.last_line = Some(Instant::now());
        }
        let rays = state.rays_done;
        drop(state);
        match &self.bar {
            Some(bar) => {
                bar.set_position(rays);
                bar.set_message(text);
            }
            None if due => self.line(&text),
            None => {}
        }
    }

    /// `done` of `all` frames of a job are there.
    pub fn frame(&self, job: &Job, done: usize, all: usize) {
        if all == 1 {
            return;
        }
        let text = format!("{} {}: frame {done}/{all}", job.scene, job.label);
        match &self.bar {
            Some(bar) => bar.set_message(text),
            None => {
                let mut state = self.lock();
                let quiet_for = state.last_line.map_or(Duration::MAX, |at| at.elapsed());
                if quiet_for > Duration::from_secs(10) {
                    state.last_line = Some(Instant::now());
                    drop(state);
                    self.line(&text);
                }
            }
        }
    }

    /// A job is finished.
    pub fn job(&self, job: &Job, row: &Row) {
        let mut state = self.lock();
        state.done_jobs += 1;
        if state.reference_done > 0 {
            state.rays_done += job.reference_rays().saturating_sub(state.reference_done);
            state.reference_done = 0;
        }
        state.rays_done += work(job);
        for (stage, seconds) in &row.seconds {
            state.spend(stage, seconds.as_f64().unwrap_or(0.0));
        }
        let result = match (row.ok(), row.rmse, row.flip_ldr) {
            (true, Some(rmse), Some(flip)) => format!("rmse {rmse:.5} flip {flip:.5}"),
            _ => row.status.clone(),
        };
        let text = format!(
            "[{}/{}] {} {} seed {}{}: {result}, {:.1} s {}",
            state.done_jobs,
            state.open,
            job.scene,
            job.label,
            job.seed,
            sweep_text(job),
            row.seconds_total,
            self.remaining(&state)
        );
        let rays = state.rays_done;
        drop(state);
        if let Some(bar) = &self.bar {
            bar.set_position(rays);
            bar.println(text);
        } else {
            self.line(&text);
        }
    }

    /// Where time went.
    pub fn finish(&self, rows: &[Row]) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let state = self.lock();
        let wall = self.started.elapsed().as_secs_f64();
        let failed = rows.iter().filter(|r| !r.ok()).count();
        self.line(&format!(
            "{} of {} jobs have a row, {failed} failed; this run took {wall:.1} s",
            rows.len(),
            self.jobs
        ));
        let known: f64 = state.stages.iter().map(|(_, s)| s).sum();
        for (stage, seconds) in &state.stages {
            let share = 100.0 * seconds / wall.max(1e-9);
            self.line(&format!("  {stage:<20} {seconds:>8.2} s {share:>5.1} %"));
        }
        let rest = (wall - known).max(0.0);
        self.line(&format!(
            "  {:<20} {rest:>8.2} s {:>5.1} %",
            "rest",
            100.0 * rest / wall.max(1e-9)
        ));
    }

    /// Runs work that belongs to no job's row, and remembers how long it took.
    pub fn time<T>(&self, stage: &str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.spend(stage, start.elapsed().as_secs_f64());
        result
    }

    /// Remembers time that belongs to no job's row.
    pub fn spend(&self, stage: &str, seconds: f64) {
        self.lock().spend(stage, seconds);
    }

    fn remaining(&self, state: &State) -> String {
        if state.rays_done == 0 || state.rays_all <= state.rays_done {
            return String::new();
        }
        let elapsed = self.started.elapsed().as_secs_f64();
        let left = elapsed * (state.rays_all - state.rays_done) as f64 / state.rays_done as f64;
        match left as u64 {
            seconds @ 0..=89 => format!("(about {seconds} s left)"),
            seconds => format!("(about {} min left)", seconds.div_ceil(60)),
        }
    }

    /// Something to know about results, printed at once.
    pub fn note(&self, text: &str) {
        let text = format!("note: {text}");
        match &self.bar {
            Some(bar) => bar.println(text),
            None => self.line(&text),
        }
    }

    fn line(&self, text: &str) {
        if !self.quiet {
            tell!("{text}");
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

fn sweep_text(job: &Job) -> String {
    job.sweep
        .iter()
        .map(|(key, value)| format!(" {key}={value}"))
        .collect()
}
