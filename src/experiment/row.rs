//! The result of one job: one line of `rows.jsonl` and `rows.csv`.

use std::io;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::columns::{self, COLUMNS, Cells};
use super::{Job, Swept};

/// The stage that stands for a search for settings, in no total.
pub const SEARCH_STAGE: &str = "search_settings";

/// A job's result. Missing metrics are `None`: not computed, or not defined (a failed job). Fields that older
/// rows lack have their defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Row {
    /// Content id: hexadecimal hash of everything that determines the result.
    pub job: String,
    /// Name of the config.
    pub experiment: String,
    /// The config's label of the scene, or its name.
    pub scene: String,
    /// View of the scene, or the paths that viewers follow.
    pub view: String,
    /// Of a sequence the measured frame in the middle, whose image the job keeps as its own; 0 for a still.
    pub frame: u32,
    /// Canonical id of what is computed.
    pub technique: String,
    /// Canonical id of the method.
    pub method: String,
    /// What tables call this contender: the method's id unless the config names it.
    pub label: String,
    /// The paper's name of the scene.
    pub paper: Option<String>,
    /// Swept keys and their values.
    pub sweep: Map<String, Value>,
    /// Resolved and found parameters.
    pub params: Map<String, Value>,
    /// What the contenders share, for example `caches=7500` or `lights=16`.
    pub budget: String,
    /// Tells repeats of a case apart.
    pub seed: u64,
    /// Pixels of a row of the image.
    pub width: usize,
    /// Pixels of a column of the image.
    pub height: usize,
    /// Camera samples a pixel.
    pub spp: u32,
    /// Records that were made, of a sequence in the mean of its images; `None` where records are not the
    /// budget.
    pub caches: Option<u64>,
    /// Lights that were made, of a sequence in the mean of its images; `None` where there is no set of lights.
    pub lights: Option<u64>,
    /// Closest-hit rays.
    pub rays: u64,
    /// Any-hit rays.
    pub shadow_rays: u64,
    /// Closest-hit and any-hit rays of a search for settings, which are in no total; its time is the stage
    /// `search_settings`.
    pub search_rays: u64,
    /// Any-hit rays of that search.
    pub search_shadow_rays: u64,
    /// Searches for the records near a point.
    pub lookups: u64,
    /// Bytes of geometry, trees, textures and map.
    pub bytes_scene: u64,
    /// Bytes that the method keeps.
    pub bytes_cache: u64,
    /// Peak bytes of the rest.
    pub bytes_work: u64,
    /// Wall time of all stages but `search_settings`.
    pub seconds_total: f64,
    /// Stage name → seconds, in order of execution.
    pub seconds: Map<String, Value>,
    /// CPU time of all threads in all stages but `search_settings`.
    pub cpu_seconds_total: f64,
    /// Stage name → CPU seconds of all threads.
    pub cpu_seconds: Map<String, Value>,
    /// Stage name → CPU seconds of the coordinating thread over those of all, in [0, 1].
    pub serial_share: Map<String, Value>,
    /// Root mean square error over pixels and channels.
    pub rmse: Option<f64>,
    /// Relative mean square error.
    pub relmse: Option<f64>,
    /// `relmse` of images that are exposed, clamped and sRGB-coded.
    pub relmse_display: Option<f64>,
    /// Difference of the means of image and reference over that of the reference; `None` also where a reference is black.
    pub mean_error: Option<f64>,
    /// Peak signal-to-noise ratio, dB; `None` also where the images are equal.
    pub psnr: Option<f64>,
    /// Structural similarity, 1 where the images are equal.
    pub ssim: Option<f64>,
    /// Structural similarity over several scales, 1 where the images are equal.
    pub ms_ssim: Option<f64>,
    /// Mean FLIP of the tone-mapped images, in [0, 1].
    pub flip_ldr: Option<f64>,
    /// Mean over pixels of the largest FLIP among several exposures, in [0, 1].
    pub flip_hdr: Option<f64>,
    /// Frames that were rendered, those of them that were measured, and viewers of each.
    pub frames: u64,
    /// Frames that errors are over.
    pub frames_measured: u64,
    /// Cameras that see each frame.
    pub viewers: u64,
    /// RMSE of the worst frame of any viewer.
    pub rmse_worst: Option<f64>,
    /// RMSE of frames rendered without memory of those before.
    pub rmse_cold: Option<f64>,
    /// RMSE of the change of the error between neighbouring frames.
    pub flicker: Option<f64>,
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
    /// Version and commit.
    pub program: String,
    /// The ray kernel.
    pub kernel: String,
    /// Processor and system.
    pub machine: String,
}

impl Row {
    /// Fills in what the plan knows of the job.
    pub fn describe(&mut self, job: &Job, experiment: &str) {
        self.job.clone_from(&job.id);
        self.experiment = experiment.to_owned();
        self.scene.clone_from(&job.scene);
        self.view.clone_from(&job.view);
        self.frame = job.sequence.representative();
        // A job that was played knows better: it may have left some out.
        if self.frames == 0 {
            self.frames = job.sequence.frames.len() as u64;
        }
        self.frames_measured = job.sequence.measured().count() as u64;
        self.viewers = job.sequence.viewers.len() as u64;
        self.technique.clone_from(&job.technique);
        self.method.clone_from(&job.method);
        self.label.clone_from(&job.label);
        self.paper.clone_from(&job.paper);
        self.sweep = Swept::of_job(job).values.into_iter().collect();
        self.budget = job.budget.to_string();
        self.seed = job.seed;
        self.width = job.width;
        self.height = job.height;
        self.spp = job.spp;
        self.reference.clone_from(&job.reference);
    }

    /// A number by the name of its column in `rows.csv` (`seconds_<stage>` reads one stage), of a parameter
    /// or of a swept key: for tables, plots and claims.
    pub fn number(&self, column: &str) -> Option<f64> {
        columns::number(self, column)
    }

    /// √(RMSE² − reference noise²): what of the RMSE is the method's own; 0 where noise is all.
    pub(super) fn above_noise(&self) -> Option<f64> {
        let (rmse, floor) = (self.rmse?, self.reference_floor.unwrap_or(0.0));
        Some((rmse * rmse - floor * floor).max(0.0).sqrt())
    }

    /// Mean square error times CPU time.
    pub(super) fn inefficiency(&self) -> Option<f64> {
        let rmse = self.rmse?;
        Some(rmse * rmse * self.cpu_seconds_total)
    }

    /// Closest-hit and any-hit rays a frame and viewer.
    pub(super) fn rays_per_image(&self) -> Option<f64> {
        let images = (self.frames * self.viewers).max(1) as f64;
        Some((self.rays + self.shadow_rays) as f64 / images)
    }

    /// CPU time of all threads a frame and viewer.
    pub(super) fn cpu_seconds_per_image(&self) -> Option<f64> {
        let images = (self.frames * self.viewers).max(1) as f64;
        Some(self.cpu_seconds_total / images)
    }

    /// Whether the job finished.
    pub fn ok(&self) -> bool {
        self.status == "ok"
    }
}

/// Tidy CSV: one line a row, one column for each stage that any row has.
pub fn to_csv(rows: &[Row]) -> io::Result<String> {
    let mut columns: Vec<(String, Cell)> = Vec::new();
    for entry in COLUMNS {
        let key = || entry.key.to_owned();
        match entry.cells {
            Cells::Text(get) => columns.push((key(), Box::new(get))),
            Cells::Count(get) => columns.push((key(), Box::new(move |row| optional(get(row))))),
            Cells::Number(get) => columns.push((key(), Box::new(move |row| optional(get(row))))),
            Cells::Derived(_) | Cells::Found => {}
            Cells::Stages(get) => {
                for stage in stages(rows, get) {
                    let name = format!("{}_{stage}", entry.key);
                    let seconds = move |row: &Row| get(row).get(&stage).and_then(Value::as_f64);
                    columns.push((name, Box::new(move |row| optional(seconds(row)))));
                }
            }
        }
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns.iter().map(|(name, _)| name))?;
    for row in rows {
        writer.write_record(columns.iter().map(|(_, cell)| cell(row)))?;
    }
    let bytes = writer.into_inner().map_err(|e| e.into_error())?;
    String::from_utf8(bytes).map_err(io::Error::other)
}

/// A cell of a row, as text.
type Cell = Box<dyn Fn(&Row) -> String>;

fn optional(value: Option<impl ToString>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}

/// Every stage of any row, in the order in which they come.
fn stages(rows: &[Row], of: fn(&Row) -> &Map<String, Value>) -> Vec<String> {
    let mut stages: Vec<String> = Vec::new();
    for stage in rows.iter().flat_map(|row| of(row).keys()) {
        if !stages.contains(stage) {
            stages.push(stage.clone());
        }
    }
    stages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_older_programs_can_be_read() {
        let old = r#"{"job":"a","scene":"s","bytes_peak":7,"rmse":0.5,"status":"ok"}"#;
        let row: Row = serde_json::from_str(old).expect("reads");
        assert_eq!((row.rmse, row.bytes_work, row.ok()), (Some(0.5), 0, true));
    }

    #[test]
    fn the_csv_has_a_column_for_each_stage_of_any_row() {
        let mut row = Row {
            caches: Some(7),
            rmse: Some(0.5),
            status: "ok".into(),
            ..Row::default()
        };
        row.seconds.insert("placement".into(), 0.25.into());
        row.serial_share.insert("placement".into(), 0.125.into());
        let text = to_csv(&[row, Row::default()]).expect("writes");
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().expect("header").clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("row")).collect();
        let cell = |row: usize, name: &str| {
            let column = header.iter().position(|h| h == name);
            rows[row].get(column.expect(name)).expect(name).to_owned()
        };
        for (name, first, second) in [
            ("caches", "7", ""),
            ("rmse", "0.5", ""),
            ("seconds_placement", "0.25", ""),
            ("serial_share_placement", "0.125", ""),
            ("bytes_scene", "0", "0"),
            ("status", "ok", ""),
        ] {
            assert_eq!(
                (cell(0, name), cell(1, name)),
                (first.into(), second.into())
            );
        }
        assert!(!header.iter().any(|h| h == "all_rays"));
    }
}
