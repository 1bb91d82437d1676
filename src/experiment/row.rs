//! The result of one job: one line of `rows.jsonl` and `rows.csv`.

use serde::{Deserialize, Serialize};

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
    pub method: String,
    /// Resolved and found parameters.
    pub params: serde_json::Map<String, serde_json::Value>,
    /// What the contenders share, for example `caches=7500`.
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
    /// Peak bytes of the structures the job built.
    pub bytes_peak: u64,
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
