//! What a run says while it works: plain lines on stderr, a live line on a terminal.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::remaining::Remaining;
use super::{Job, Plan, Row};
use crate::standard_error::tell;
use crate::technique::{Clock, Stages};

/// Parts of the live bar.
const BAR: u64 = 1000;

/// Progress over all open jobs and their references.
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
    remaining: Remaining,
    /// When something was done last, which says what the next thing took.
    told: Option<Instant>,
    last_line: Option<Instant>,
    stages: Vec<(String, f64)>,
    /// Of what belongs to no job's row.
    besides: Stages,
}

impl State {
    /// Seconds since something was done last.
    fn since_told(&mut self) -> f64 {
        let before = self.told.replace(Instant::now());
        before.map_or(0.0, |at| at.elapsed().as_secs_f64())
    }

    fn spend(&mut self, stage: &str, seconds: f64) {
        match self.stages.iter_mut().find(|(name, _)| name == stage) {
            Some((_, total)) => *total += seconds,
            None => self.stages.push((stage.to_owned(), seconds)),
        }
    }
}

impl Progress {
    pub fn new(plan: &Plan, quiet: bool) -> Self {
        let live = !quiet && std::io::stderr().is_terminal();
        Self {
            bar: live.then(|| {
                let bar = ProgressBar::new(BAR);
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

    /// `open` jobs are to be done, `found` were finished before; `is_stored` says which references are there.
    pub fn start(&self, open: &[&Job], found: usize, is_stored: impl Fn(&str) -> bool) {
        let mut state = self.lock();
        state.open = open.len();
        state.remaining = Remaining::of(open, is_stored);
        drop(state);
        let again = if found > 0 {
            format!(", {found} finished earlier and kept")
        } else {
            String::new()
        };
        self.line(&format!("{} jobs to run{again}", open.len()));
    }

    /// A step that has no length of its own.
    pub fn stage(&self, text: &str) {
        self.lock().told = Some(Instant::now());
        match &self.bar {
            Some(bar) => bar.set_message(text.to_owned()),
            None => self.line(text),
        }
    }

    /// `done` of `all` passes of a job's reference are there.
    pub fn reference(&self, job: &Job, done: u32, all: u32) {
        let mut state = self.lock();
        let seconds = state.since_told();
        state.remaining.reference(job, done, all, seconds);
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
        let position = self.position(&state);
        drop(state);
        match &self.bar {
            Some(bar) => {
                bar.set_position(position);
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
        let mut state = self.lock();
        let seconds = state.since_told();
        let share = done as f64 / all as f64;
        // Metrics and files of the whole job are still to come.
        state.remaining.job(job, share.min(0.99), seconds);
        let left = self.remaining(&state);
        let text = format!("{} {}: frame {done}/{all} {left}", job.scene, job.label);
        match &self.bar {
            Some(bar) => {
                bar.set_position(self.position(&state));
                bar.set_message(text);
            }
            None => {
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
        let seconds = state.since_told();
        state.remaining.job(job, 1.0, seconds);
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
        let position = self.position(&state);
        drop(state);
        if let Some(bar) = &self.bar {
            bar.set_position(position);
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
    pub fn time<T>(&self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let clock = Clock::start();
        let result = work();
        let seconds = clock.seconds();
        let mut state = self.lock();
        state.spend(stage, seconds.wall);
        state.besides.add(stage, seconds);
        result
    }

    /// What was timed so.
    pub fn besides(&self) -> Stages {
        self.lock().besides.clone()
    }

    /// Remembers time that belongs to no job's row.
    pub fn spend(&self, stage: &str, seconds: f64) {
        self.lock().spend(stage, seconds);
    }

    fn remaining(&self, state: &State) -> String {
        let left = state.remaining.seconds().filter(|seconds| *seconds > 0.0);
        left.map_or_else(String::new, |left| match left.ceil() as u64 {
            seconds @ 0..=119 => format!("(about {seconds} s left)"),
            seconds @ 120..=7199 => format!("(about {} min left)", (seconds + 30) / 60),
            seconds => format!("(about {:.1} h left)", seconds as f64 / 3600.0),
        })
    }

    /// How far the live bar is.
    fn position(&self, state: &State) -> u64 {
        let elapsed = self.started.elapsed().as_secs_f64();
        let left = state.remaining.seconds().unwrap_or(f64::INFINITY);
        (BAR as f64 * elapsed / (elapsed + left)) as u64
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

pub(super) fn sweep_text(job: &Job) -> String {
    job.sweep
        .iter()
        .map(|(key, value)| format!(" {key}={value}"))
        .collect()
}
