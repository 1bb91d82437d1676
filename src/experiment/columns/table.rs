//! The columns of rows, in the order of `rows.csv`.

use serde_json::{Map, Value};

use super::{Cells, ColumnEntry, Unit};
use crate::experiment::Row;

const LOWER: Option<bool> = Some(true);
const HIGHER: Option<bool> = Some(false);

const fn text(key: &'static str, meaning: &'static str, get: fn(&Row) -> String) -> ColumnEntry {
    entry(key, key, Unit::None, None, meaning, Cells::Text(get))
}

const fn entry(
    key: &'static str,
    heading: &'static str,
    unit: Unit,
    lower_is_better: Option<bool>,
    meaning: &'static str,
    cells: Cells,
) -> ColumnEntry {
    ColumnEntry {
        key,
        heading,
        unit,
        lower_is_better,
        meaning,
        cells,
    }
}

const fn count(
    key: &'static str,
    heading: &'static str,
    better: Option<bool>,
    meaning: &'static str,
    get: fn(&Row) -> Option<u64>,
) -> ColumnEntry {
    entry(
        key,
        heading,
        Unit::Count,
        better,
        meaning,
        Cells::Count(get),
    )
}

const fn bytes(
    key: &'static str,
    heading: &'static str,
    meaning: &'static str,
    get: fn(&Row) -> Option<u64>,
) -> ColumnEntry {
    entry(key, heading, Unit::Bytes, LOWER, meaning, Cells::Count(get))
}

const fn metric(
    key: &'static str,
    heading: &'static str,
    better: Option<bool>,
    meaning: &'static str,
    get: fn(&Row) -> Option<f64>,
) -> ColumnEntry {
    entry(
        key,
        heading,
        Unit::None,
        better,
        meaning,
        Cells::Number(get),
    )
}

const fn derived(
    key: &'static str,
    heading: &'static str,
    better: Option<bool>,
    meaning: &'static str,
    get: fn(&Row) -> Option<f64>,
) -> ColumnEntry {
    entry(
        key,
        heading,
        Unit::Count,
        better,
        meaning,
        Cells::Derived(get),
    )
}

fn json(map: &Map<String, Value>) -> String {
    serde_json::to_string(map).unwrap_or_default()
}

/// Every column, in the order of `rows.csv`.
pub const COLUMNS: &[ColumnEntry] = &[
    text("job", "content id of the job", |r| r.job.clone()),
    text("experiment", "name of the experiment", |r| {
        r.experiment.clone()
    }),
    text(
        "scene",
        "the config's label of the scene, or its name",
        |r| r.scene.clone(),
    ),
    text("view", "view of the scene", |r| r.view.clone()),
    count(
        "frame",
        "frame",
        None,
        "frame of a sequence, 0 for a still",
        |r| Some(u64::from(r.frame)),
    ),
    text("technique", "what is computed", |r| r.technique.clone()),
    text("method", "canonical id of the method", |r| r.method.clone()),
    text("label", "what tables call the contender", |r| {
        r.label.clone()
    }),
    text("params", "set and found parameters, JSON", |r| {
        json(&r.params)
    }),
    text("sweep", "swept keys and their values, JSON", |r| {
        json(&r.sweep)
    }),
    text("budget", "what the contenders share", |r| r.budget.clone()),
    count("seed", "seed", None, "the repeat", |r| Some(r.seed)),
    count("width", "width", None, "pixels of the image", |r| {
        Some(r.width as u64)
    }),
    count("height", "height", None, "pixels of the image", |r| {
        Some(r.height as u64)
    }),
    count(
        "spp",
        "samples a pixel",
        None,
        "camera samples a pixel",
        |r| Some(u64::from(r.spp)),
    ),
    count("caches", "records", None, "records that were made", |r| {
        r.caches
    }),
    count("lights", "lights", None, "lights that were made", |r| {
        r.lights
    }),
    count(
        "rays",
        "closest-hit rays",
        LOWER,
        "closest-hit rays, without those of a search for settings",
        |r| Some(r.rays),
    ),
    count(
        "shadow_rays",
        "shadow rays",
        LOWER,
        "any-hit rays, without those of a search for settings",
        |r| Some(r.shadow_rays),
    ),
    entry(
        "all_rays",
        "rays",
        Unit::Count,
        LOWER,
        "closest-hit and any-hit rays",
        Cells::Derived(|r| Some((r.rays + r.shadow_rays) as f64)),
    ),
    count(
        "search_rays",
        "rays of the search",
        LOWER,
        "closest-hit rays of a search for settings, in no total",
        |r| Some(r.search_rays),
    ),
    count(
        "search_shadow_rays",
        "shadow rays of the search",
        LOWER,
        "any-hit rays of a search for settings, in no total",
        |r| Some(r.search_shadow_rays),
    ),
    count(
        "lookups",
        "lookups",
        LOWER,
        "searches for the records near a point",
        |r| Some(r.lookups),
    ),
    bytes(
        "bytes_scene",
        "scene memory",
        "geometry, trees, textures and map",
        |r| Some(r.bytes_scene),
    ),
    bytes(
        "bytes_cache",
        "cache memory",
        "what the method keeps",
        |r| Some(r.bytes_cache),
    ),
    bytes("bytes_work", "work memory", "peak of the rest", |r| {
        Some(r.bytes_work)
    }),
    entry(
        "seconds_total",
        "wall time",
        Unit::Seconds,
        None,
        "wall time of the stages, without a search for settings; never ranked, as it depends on the number of threads",
        Cells::Number(|r| Some(r.seconds_total)),
    ),
    entry(
        "seconds",
        "",
        Unit::Seconds,
        None,
        "wall time of a stage; `search_settings` is a search for settings",
        Cells::Stages(|r| &r.seconds),
    ),
    entry(
        "cpu_seconds_total",
        "CPU time",
        Unit::Seconds,
        LOWER,
        "CPU time of all threads, without a search for settings",
        Cells::Number(|r| Some(r.cpu_seconds_total)),
    ),
    entry(
        "cpu_seconds",
        "CPU ",
        Unit::Seconds,
        LOWER,
        "CPU time of all threads in a stage; `search_settings` is a search for settings",
        Cells::Stages(|r| &r.cpu_seconds),
    ),
    entry(
        "serial_share",
        "serial share of ",
        Unit::None,
        LOWER,
        "CPU time of the coordinating thread over that of all threads in a stage",
        Cells::Stages(|r| &r.serial_share),
    ),
    metric(
        "rmse",
        "RMSE",
        LOWER,
        "root mean square error over pixels and channels",
        |r| r.rmse,
    ),
    entry(
        "rmse_above_noise",
        "RMSE above noise",
        Unit::None,
        LOWER,
        "√(RMSE² − reference noise²), 0 where noise is all",
        Cells::Derived(Row::above_noise),
    ),
    metric(
        "relmse",
        "relMSE",
        LOWER,
        "relative mean square error",
        |r| r.relmse,
    ),
    metric(
        "relmse_display",
        "relMSE of display values",
        LOWER,
        "as relMSE, of images that are exposed, clamped and sRGB-coded: what papers report that tone-map first",
        |r| r.relmse_display,
    ),
    entry(
        "mean_error",
        "error of the mean",
        Unit::None,
        None,
        "mean of the image less that of the reference, over the latter, averaged over frames: what is lost (below 0) or gained; bias, \
         where noise is small",
        Cells::Number(|r| r.mean_error),
    ),
    entry(
        "psnr",
        "PSNR",
        Unit::Decibel,
        HIGHER,
        "peak signal-to-noise ratio",
        Cells::Number(|r| r.psnr),
    ),
    metric("ssim", "SSIM", HIGHER, "structural similarity", |r| r.ssim),
    metric(
        "ms_ssim",
        "MS-SSIM",
        HIGHER,
        "structural similarity over several scales",
        |r| r.ms_ssim,
    ),
    metric(
        "flip_ldr",
        "FLIP",
        LOWER,
        "mean FLIP of the tone-mapped images; `flip` for short",
        |r| r.flip_ldr,
    ),
    metric(
        "flip_hdr",
        "HDR-FLIP",
        LOWER,
        "mean FLIP over exposures",
        |r| r.flip_hdr,
    ),
    count(
        "frames",
        "frames",
        None,
        "frames that were rendered, 1 for a still",
        |r| Some(r.frames),
    ),
    count(
        "frames_measured",
        "measured frames",
        None,
        "frames that were measured: errors are means over them and all viewers, RMSE and noise root mean squares",
        |r| Some(r.frames_measured),
    ),
    count(
        "viewers",
        "viewers",
        None,
        "cameras that see each frame",
        |r| Some(r.viewers),
    ),
    derived(
        "rays_per_image",
        "rays a frame and viewer",
        LOWER,
        "closest-hit and any-hit rays of a frame for one viewer",
        Row::rays_per_image,
    ),
    entry(
        "cpu_seconds_per_image",
        "CPU time a frame and viewer",
        Unit::Seconds,
        LOWER,
        "CPU time of all threads, without a search for settings, of a frame for one viewer",
        Cells::Derived(Row::cpu_seconds_per_image),
    ),
    entry(
        "inefficiency",
        "inefficiency",
        Unit::None,
        LOWER,
        "RMSE² × `cpu_seconds_total`: error × time, which more samples do not change where noise is all there is",
        Cells::Derived(Row::inefficiency),
    ),
    metric(
        "rmse_worst",
        "worst RMSE",
        LOWER,
        "RMSE of the worst measured frame of any viewer",
        |r| r.rmse_worst,
    ),
    metric(
        "rmse_cold",
        "RMSE without memory",
        LOWER,
        "RMSE of measured frames rendered each without what the method remembers, where `cold = true`",
        |r| r.rmse_cold,
    ),
    metric(
        "flicker",
        "flicker",
        LOWER,
        "RMSE of the change of the error between neighbouring measured frames",
        |r| r.flicker,
    ),
    text(
        "reference",
        "key of the reference image, or one that stands for those of a sequence",
        |r| r.reference.clone(),
    ),
    metric(
        "reference_floor",
        "reference noise",
        None,
        "RMSE of the reference's own noise",
        |r| r.reference_floor,
    ),
    count(
        "non_finite",
        "non-finite",
        LOWER,
        "non-finite samples that were kept out of the image",
        |r| Some(r.non_finite),
    ),
    text("status", "`ok` or the reason of failure", |r| {
        r.status.clone()
    }),
    text("program", "version and commit of the program", |r| {
        r.program.clone()
    }),
    text("kernel", "ray kernel", |r| r.kernel.clone()),
    text("machine", "processor and system", |r| r.machine.clone()),
];
