//! The result of one job: one line of `rows.jsonl` and `rows.csv`.

use std::io;

use serde::{Deserialize, Serialize};

use super::Job;

/// A job's result. Missing metrics are `None`: not computed, or not defined (a failed job).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Content id: hexadecimal hash of everything that determines the result.
    pub job: String,
    pub experiment: String,
    pub scene: String,
    pub view: String,
    pub frame: u32,
    pub technique: String,
    /// Canonical id of the method.
    pub method: String,
    /// What tables call this contender: the method's id unless the config names it.
    pub label: String,
    /// The paper's name of the scene.
    pub paper: Option<String>,
    /// Swept keys and their values.
    pub sweep: serde_json::Map<String, serde_json::Value>,
    /// Resolved and found parameters.
    pub params: serde_json::Map<String, serde_json::Value>,
    /// What the contenders share, for example `caches=7500` or `lights=16`.
    pub budget: String,
    pub seed: u64,
    pub width: usize,
    pub height: usize,
    pub spp: u32,
    pub caches: Option<u64>,
    pub lights: Option<u64>,
    /// Closest-hit rays.
    pub rays: u64,
    /// Any-hit rays.
    pub shadow_rays: u64,
    pub lookups: u64,
    /// Bytes of geometry, tree, textures and map.
    #[serde(default)]
    pub bytes_scene: u64,
    /// Bytes that the method keeps.
    #[serde(default)]
    pub bytes_cache: u64,
    /// Peak bytes of everything else.
    #[serde(default)]
    pub bytes_work: u64,
    /// Closest-hit rays of a search for settings, not in `rays`.
    #[serde(default)]
    pub search_rays: u64,
    /// Any-hit rays of a search for settings, not in `shadow_rays`.
    #[serde(default)]
    pub search_shadow_rays: u64,
    #[serde(default)]
    pub cpu_seconds: serde_json::Map<String, serde_json::Value>,
    #[serde(default)]
    pub cpu_seconds_total: f64,
    #[serde(default)]
    pub serial_share: serde_json::Map<String, serde_json::Value>,
    pub seconds_total: f64,
    /// Stage name → seconds, in order of execution.
    pub seconds: serde_json::Map<String, serde_json::Value>,
    pub rmse: Option<f64>,
    pub relmse: Option<f64>,
    pub psnr: Option<f64>,
    pub ssim: Option<f64>,
    pub ms_ssim: Option<f64>,
    pub flip_ldr: Option<f64>,
    pub flip_hdr: Option<f64>,
    /// Key of the reference image.
    pub reference: String,
    /// RMSE of the reference's own noise (0 for deterministic references).
    pub reference_floor: Option<f64>,
    /// Non-finite samples that were kept out of the image.
    pub non_finite: u64,
    /// `ok` or the reason of failure.
    pub status: String,
    /// Shortfalls and fallbacks.
    pub notes: Vec<String>,
}

impl Row {
    /// Fills in what the plan knows of the job.
    pub fn describe(&mut self, job: &Job, experiment: &str) {
        self.job.clone_from(&job.id);
        self.experiment = experiment.to_owned();
        self.scene.clone_from(&job.scene);
        self.view.clone_from(&job.view);
        self.technique.clone_from(&job.technique);
        self.method.clone_from(&job.method);
        self.label.clone_from(&job.label);
        self.paper.clone_from(&job.paper);
        self.sweep = job
            .sweep
            .iter()
            .filter_map(|(k, v)| Some((k.clone(), serde_json::to_value(v).ok()?)))
            .collect();
        self.budget = job.budget.to_string();
        self.seed = job.seed;
        self.width = job.width;
        self.height = job.height;
        self.spp = job.spp;
        self.reference.clone_from(&job.reference);
    }

    /// A numeric column by its name in `rows.csv`, for tables, plots and claims; `seconds_<stage>`
    /// reads one stage.
    pub fn number(&self, column: &str) -> Option<f64> {
        let count = |n: u64| Some(n as f64);
        match column {
            "rmse" => self.rmse,
            "relmse" => self.relmse,
            "psnr" => self.psnr,
            "ssim" => self.ssim,
            "ms_ssim" => self.ms_ssim,
            "flip_ldr" | "flip" => self.flip_ldr,
            "flip_hdr" => self.flip_hdr,
            "caches" => self.caches.and_then(count),
            "lights" => self.lights.and_then(count),
            "rays" => count(self.rays),
            "shadow_rays" => count(self.shadow_rays),
            "all_rays" => count(self.rays + self.shadow_rays),
            "rmse_above_noise" => self.above_noise(),
            "lookups" => count(self.lookups),
            "bytes_cache" => count(self.bytes_cache),
            "non_finite" => count(self.non_finite),
            "reference_floor" => self.reference_floor,
            "seconds_total" => Some(self.seconds_total),
            _ => {
                let value = match column.strip_prefix("seconds_") {
                    Some(stage) => self.seconds.get(stage),
                    None => self.params.get(column).or_else(|| self.sweep.get(column)),
                };
                value.and_then(serde_json::Value::as_f64)
            }
        }
    }

    /// √(RMSE² − reference noise²): what of the RMSE is the method's own; 0 where noise is all.
    fn above_noise(&self) -> Option<f64> {
        let (rmse, floor) = (self.rmse?, self.reference_floor.unwrap_or(0.0));
        Some((rmse * rmse - floor * floor).max(0.0).sqrt())
    }

    /// Whether the job finished.
    pub fn ok(&self) -> bool {
        self.status == "ok"
    }
}

/// The columns that tables, plots and claims may name, besides `seconds_<stage>` and parameters.
pub const NUMBER_COLUMNS: &[&str] = &[
    "rmse",
    "relmse",
    "psnr",
    "ssim",
    "ms_ssim",
    "flip_ldr",
    "flip_hdr",
    "caches",
    "lights",
    "rays",
    "shadow_rays",
    "all_rays",
    "rmse_above_noise",
    "lookups",
    "bytes_cache",
    "non_finite",
    "reference_floor",
    "seconds_total",
];

/// Tidy CSV: one line a row, one column for each stage that any row has.
pub fn to_csv(rows: &[Row]) -> io::Result<String> {
    let mut stages: Vec<&str> = Vec::new();
    for stage in rows.iter().flat_map(|r| r.seconds.keys()) {
        if !stages.contains(&stage.as_str()) {
            stages.push(stage);
        }
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    let fixed = [
        "job",
        "experiment",
        "scene",
        "view",
        "frame",
        "technique",
        "method",
        "label",
        "params",
        "sweep",
        "budget",
        "seed",
        "width",
        "height",
        "spp",
        "caches",
        "lights",
        "rays",
        "shadow_rays",
        "lookups",
        "bytes_cache",
        "seconds_total",
    ];
    let metrics = [
        "rmse", "relmse", "psnr", "ssim", "ms_ssim", "flip_ldr", "flip_hdr",
    ];
    let tail = ["reference", "reference_floor", "non_finite", "status"];
    let mut header: Vec<String> = fixed.iter().map(|s| (*s).to_owned()).collect();
    header.extend(stages.iter().map(|s| format!("seconds_{s}")));
    header.extend(metrics.iter().chain(&tail).map(|s| (*s).to_owned()));
    writer.write_record(&header)?;
    let optional = |n: Option<f64>| n.map(|v| v.to_string()).unwrap_or_default();
    let count = |n: Option<u64>| n.map(|v| v.to_string()).unwrap_or_default();
    for row in rows {
        let mut cells = vec![
            row.job.clone(),
            row.experiment.clone(),
            row.scene.clone(),
            row.view.clone(),
            row.frame.to_string(),
            row.technique.clone(),
            row.method.clone(),
            row.label.clone(),
            serde_json::to_string(&row.params)?,
            serde_json::to_string(&row.sweep)?,
            row.budget.clone(),
            row.seed.to_string(),
            row.width.to_string(),
            row.height.to_string(),
            row.spp.to_string(),
            count(row.caches),
            count(row.lights),
            row.rays.to_string(),
            row.shadow_rays.to_string(),
            row.lookups.to_string(),
            row.bytes_cache.to_string(),
            row.seconds_total.to_string(),
        ];
        for stage in &stages {
            cells.push(optional(
                row.seconds.get(*stage).and_then(serde_json::Value::as_f64),
            ));
        }
        cells.extend(metrics.iter().map(|m| optional(row.number(m))));
        cells.push(row.reference.clone());
        cells.push(optional(row.reference_floor));
        cells.push(row.non_finite.to_string());
        cells.push(row.status.clone());
        writer.write_record(&cells)?;
    }
    let bytes = writer.into_inner().map_err(|e| e.into_error())?;
    String::from_utf8(bytes).map_err(io::Error::other)
}
