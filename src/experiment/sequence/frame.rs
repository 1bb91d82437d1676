//! What one frame of a job was for one viewer, and how frames become a row.

use std::io;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::super::{Row, SEARCH_STAGE};
use crate::metric::Comparison;
use crate::technique::{Rendered, Seconds};

/// One frame as one viewer saw it: a line of `frames.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Number of the frame in the sequence.
    pub frame: u32,
    /// Number of the viewer, from 0.
    pub viewer: u16,
    /// What time of the scene it shows.
    pub time_s: f64,
    /// Against the reference; `None` for frames that are not measured.
    pub metrics: Option<Metrics>,
    /// RMSE of the frame rendered without memory of those before.
    pub rmse_cold: Option<f64>,
    /// Mean square of the change of the error since the frame before, if that was measured too.
    pub error_change: Option<f64>,
    /// Key of the reference image.
    pub reference: Option<String>,
    /// RMSE of the reference's own noise.
    pub reference_floor: Option<f64>,
    /// Records that the image was made with, as the contender reports them.
    pub records: u64,
    /// Lights of a global set; `None` where there is no set.
    pub lights: Option<u64>,
    /// Closest-hit rays, without those of a search for settings.
    pub rays: u64,
    /// Any-hit rays, without those of a search for settings.
    pub shadow_rays: u64,
    /// Searches for the records near a point.
    pub lookups: u64,
    /// What the method keeps.
    pub bytes_cache: u64,
    /// Peak of what it needed beside that while the frame was made.
    pub bytes_work: u64,
    /// Samples that were kept out of the image.
    pub non_finite: u64,
    /// In order of execution.
    pub stages: Vec<StageRecord>,
    /// `None` where nothing was searched for.
    pub search: Option<SearchRecord>,
    /// Parameters that were found (σ_s, chosen cluster size, …), by name.
    pub found: Vec<(String, f64)>,
    /// Shortfalls and fallbacks, a sentence each.
    pub notes: Vec<String>,
}

/// Errors of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    pub rmse: f64,
    pub relmse: f64,
    pub relmse_display: f64,
    /// `None` where the reference is black.
    pub mean_error: Option<f64>,
    /// `None` where the images are equal.
    pub psnr: Option<f64>,
    pub ssim: f64,
    pub ms_ssim: f64,
    pub flip_ldr: f64,
    pub flip_hdr: Option<f64>,
}

/// What a stage of a frame took, seconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageRecord {
    pub name: String,
    pub wall: f64,
    pub cpu: f64,
    pub serial: f64,
}

/// What a search for settings took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SearchRecord {
    /// Wall time.
    pub seconds: f64,
    pub cpu: f64,
    pub rays: u64,
    pub shadow_rays: u64,
}

impl Metrics {
    pub fn of(comparison: &Comparison) -> Self {
        Self {
            rmse: comparison.rmse,
            relmse: comparison.relmse,
            relmse_display: comparison.relmse_display,
            mean_error: comparison.mean_error,
            psnr: comparison.psnr,
            ssim: comparison.ssim,
            ms_ssim: comparison.ms_ssim,
            flip_ldr: comparison.flip_ldr,
            flip_hdr: comparison.flip_hdr,
        }
    }
}

impl FrameRecord {
    /// What a contender says of its image.
    pub fn of(rendered: &Rendered) -> Self {
        let stage = |stage: &crate::technique::Stage| StageRecord {
            name: stage.name.to_owned(),
            wall: stage.seconds.wall,
            cpu: stage.seconds.cpu,
            serial: stage.seconds.serial,
        };
        let search = SearchRecord {
            seconds: rendered.search.seconds.wall,
            cpu: rendered.search.seconds.cpu,
            rays: rendered.search.rays.closest,
            shadow_rays: rendered.search.rays.shadow,
        };
        let found = rendered.found.iter();
        Self {
            records: rendered.records.len() as u64,
            lights: rendered.lights.as_ref().map(|set| set.lights.len() as u64),
            rays: rendered.rays.closest,
            shadow_rays: rendered.rays.shadow,
            lookups: rendered.lookups,
            bytes_cache: rendered.bytes_cache as u64,
            bytes_work: rendered.bytes_work as u64,
            non_finite: rendered.non_finite,
            stages: rendered.stages.0.iter().map(stage).collect(),
            search: (search != SearchRecord::default()).then_some(search),
            found: found
                .map(|(key, value)| ((*key).to_owned(), *value))
                .collect(),
            notes: rendered.notes.clone(),
            ..Self::default()
        }
    }
}

impl Row {
    /// Fills in what the frames of a job say together. Errors are means over measured frames and viewers, of RMSE
    /// and noise root mean squares; costs are sums, memory the most at any time.
    pub(in crate::experiment) fn sum_up(&mut self, frames: &[FrameRecord]) {
        let sum = |of: fn(&FrameRecord) -> u64| frames.iter().map(of).sum::<u64>();
        self.rays = sum(|f| f.rays);
        self.shadow_rays = sum(|f| f.shadow_rays);
        self.lookups = sum(|f| f.lookups);
        self.non_finite = sum(|f| f.non_finite);
        self.bytes_cache = most_at_once(frames, |f| f.bytes_cache);
        self.bytes_work = frames.iter().map(|f| f.bytes_work).max().unwrap_or(0);
        let images = frames.len().max(1) as f64;
        let rendered = frames.len() as u64 / self.viewers.max(1);
        if rendered < self.frames {
            self.notes.push(format!(
                "{} of {} frames were rendered, those that are measured or kept: totals are of these",
                rendered, self.frames
            ));
            self.frames = rendered;
        }
        self.caches = self
            .caches
            .map(|_| (sum(|f| f.records) as f64 / images).round() as u64);
        let lights: Vec<f64> = frames
            .iter()
            .filter_map(|f| Some(f.lights? as f64))
            .collect();
        self.lights = mean(&lights).map(|mean| mean.round() as u64);
        self.sum_up_stages(frames);
        for key in found_keys(frames) {
            let values = frames.iter().flat_map(|f| &f.found);
            let values: Vec<f64> = values.filter(|(k, _)| k == key).map(|(_, v)| *v).collect();
            self.params.insert(key.to_owned(), mean(&values).into());
        }
        self.sum_up_errors(frames);
        for note in frames.iter().flat_map(|f| &f.notes) {
            if !self.notes.contains(note) {
                self.notes.push(note.clone());
            }
        }
    }

    fn sum_up_stages(&mut self, frames: &[FrameRecord]) {
        let mut stages: Vec<(&str, Seconds)> = Vec::new();
        for stage in frames.iter().flat_map(|f| &f.stages) {
            let known = stages.iter().position(|(name, _)| *name == stage.name);
            let place = known.unwrap_or_else(|| {
                stages.push((&stage.name, Seconds::default()));
                stages.len() - 1
            });
            let seconds = &mut stages[place].1;
            seconds.wall += stage.wall;
            seconds.cpu += stage.cpu;
            seconds.serial += stage.serial;
        }
        for (name, seconds) in stages {
            self.seconds_total += seconds.wall;
            self.cpu_seconds_total += seconds.cpu;
            self.seconds.insert(name.to_owned(), seconds.wall.into());
            self.cpu_seconds.insert(name.to_owned(), seconds.cpu.into());
            let share = seconds.serial_share();
            self.serial_share.insert(name.to_owned(), share.into());
        }
        let searches: Vec<&SearchRecord> =
            frames.iter().filter_map(|f| f.search.as_ref()).collect();
        if !searches.is_empty() {
            let sum = |of: fn(&SearchRecord) -> f64| searches.iter().map(|s| of(s)).sum::<f64>();
            let (wall, cpu) = (sum(|s| s.seconds), sum(|s| s.cpu));
            self.seconds.insert(SEARCH_STAGE.into(), wall.into());
            self.cpu_seconds.insert(SEARCH_STAGE.into(), cpu.into());
            self.search_rays = searches.iter().map(|s| s.rays).sum();
            self.search_shadow_rays = searches.iter().map(|s| s.shadow_rays).sum();
        }
    }

    fn sum_up_errors(&mut self, frames: &[FrameRecord]) {
        let measured: Vec<&Metrics> = frames.iter().filter_map(|f| f.metrics.as_ref()).collect();
        let each =
            |of: fn(&Metrics) -> f64| -> Vec<f64> { measured.iter().map(|m| of(m)).collect() };
        let some = |of: fn(&Metrics) -> Option<f64>| -> Vec<f64> {
            measured.iter().filter_map(|m| of(m)).collect()
        };
        self.rmse = root_mean_square(&each(|m| m.rmse));
        self.rmse_worst = each(|m| m.rmse).into_iter().reduce(f64::max);
        self.relmse = mean(&each(|m| m.relmse));
        self.relmse_display = mean(&each(|m| m.relmse_display));
        let signed = some(|m| m.mean_error);
        self.mean_error = mean(&signed).filter(|_| signed.len() == measured.len());
        self.psnr = mean(&some(|m| m.psnr));
        self.ssim = mean(&each(|m| m.ssim));
        self.ms_ssim = mean(&each(|m| m.ms_ssim));
        self.flip_ldr = mean(&each(|m| m.flip_ldr));
        self.flip_hdr = mean(&some(|m| m.flip_hdr));
        let cold: Vec<f64> = frames.iter().filter_map(|f| f.rmse_cold).collect();
        self.rmse_cold = root_mean_square(&cold);
        let changes: Vec<f64> = frames.iter().filter_map(|f| f.error_change).collect();
        self.flicker = mean(&changes).map(f64::sqrt);
        let floors: Vec<f64> = frames.iter().filter_map(|f| f.reference_floor).collect();
        self.reference_floor = match floors.len() == measured.len() {
            true => root_mean_square(&floors),
            false => None,
        };
    }
}

/// Of all viewers of a frame together, the most in any frame.
fn most_at_once(frames: &[FrameRecord], of: fn(&FrameRecord) -> u64) -> u64 {
    let together = frames.chunk_by(|a, b| a.frame == b.frame);
    let sums = together.map(|viewers| viewers.iter().map(of).sum());
    sums.max().unwrap_or(0)
}

fn found_keys(frames: &[FrameRecord]) -> Vec<&str> {
    let mut keys: Vec<&str> = Vec::new();
    for (key, _) in frames.iter().flat_map(|f| &f.found) {
        if !keys.contains(&key.as_str()) {
            keys.push(key);
        }
    }
    keys
}

/// Of one value that value, to the bit.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn root_mean_square(values: &[f64]) -> Option<f64> {
    match values {
        [] => None,
        [one] => Some(*one),
        _ => {
            let squares: Vec<f64> = values.iter().map(|x| x * x).collect();
            mean(&squares).map(f64::sqrt)
        }
    }
}

/// `frames.csv`: one line a frame and viewer.
pub fn frames_csv(frames: &[FrameRecord]) -> io::Result<String> {
    let mut stages: Vec<&str> = Vec::new();
    for stage in frames.iter().flat_map(|f| &f.stages) {
        if !stages.contains(&stage.name.as_str()) {
            stages.push(&stage.name);
        }
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut lines = frames.iter().map(|frame| line(frame, &stages)).peekable();
    if let Some(first) = lines.peek() {
        writer.write_record(first.keys())?;
    }
    for line in lines {
        writer.write_record(line.values().map(|value| match value {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }))?;
    }
    let bytes = writer.into_inner().map_err(|e| e.into_error())?;
    String::from_utf8(bytes).map_err(io::Error::other)
}

/// Names and values of a line, in order.
pub(super) fn line(frame: &FrameRecord, stages: &[&str]) -> Map<String, Value> {
    let metrics = frame.metrics;
    let metric = |of: fn(&Metrics) -> f64| metrics.as_ref().map(of);
    let seconds = |of: fn(&StageRecord) -> f64| frame.stages.iter().map(of).sum::<f64>();
    let mut line = Map::new();
    let mut put = |key: &str, value: Value| _ = line.insert(key.to_owned(), value);
    put("frame", frame.frame.into());
    put("viewer", frame.viewer.into());
    put("time_s", frame.time_s.into());
    put("measured", metrics.is_some().into());
    put("rmse", metric(|m| m.rmse).into());
    put("rmse_cold", frame.rmse_cold.into());
    put("error_change", frame.error_change.map(f64::sqrt).into());
    put("relmse", metric(|m| m.relmse).into());
    put("relmse_display", metric(|m| m.relmse_display).into());
    put("mean_error", metrics.and_then(|m| m.mean_error).into());
    put("psnr", metrics.and_then(|m| m.psnr).into());
    put("ssim", metric(|m| m.ssim).into());
    put("ms_ssim", metric(|m| m.ms_ssim).into());
    put("flip_ldr", metric(|m| m.flip_ldr).into());
    put("flip_hdr", metrics.and_then(|m| m.flip_hdr).into());
    put("reference", frame.reference.clone().into());
    put("reference_floor", frame.reference_floor.into());
    put("records", frame.records.into());
    put("lights", frame.lights.into());
    put("rays", frame.rays.into());
    put("shadow_rays", frame.shadow_rays.into());
    put("lookups", frame.lookups.into());
    put("bytes_cache", frame.bytes_cache.into());
    put("bytes_work", frame.bytes_work.into());
    put("non_finite", frame.non_finite.into());
    put("seconds_total", seconds(|s| s.wall).into());
    put("cpu_seconds_total", seconds(|s| s.cpu).into());
    for name in stages {
        let stage = frame.stages.iter().find(|stage| stage.name == *name);
        put(&format!("seconds_{name}"), stage.map(|s| s.wall).into());
        put(&format!("cpu_seconds_{name}"), stage.map(|s| s.cpu).into());
    }
    line
}

#[cfg(test)]
mod tests;
