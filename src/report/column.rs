//! What the columns of rows are called, measured in, and which way is better.

/// A row column as tables and plots show it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name in `rows.csv`.
    pub key: String,
    pub heading: String,
    pub unit: Unit,
    /// Whether smaller values are better; `None` where neither way is.
    pub lower_is_better: Option<bool>,
}

/// What a column is measured in, which decides how its numbers are scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    None,
    Decibel,
    Seconds,
    Bytes,
    /// A count, shown in powers of a thousand.
    Count,
}

impl Column {
    /// The column of a name in `rows.csv`; unknown names are parameters.
    pub fn of(key: &str) -> Self {
        let (heading, unit, lower_is_better) = match key {
            "rmse" => ("RMSE", Unit::None, Some(true)),
            "rmse_above_noise" => ("RMSE above noise", Unit::None, Some(true)),
            "relmse" => ("relMSE", Unit::None, Some(true)),
            "psnr" => ("PSNR", Unit::Decibel, Some(false)),
            "ssim" => ("SSIM", Unit::None, Some(false)),
            "ms_ssim" => ("MS-SSIM", Unit::None, Some(false)),
            "flip" | "flip_ldr" => ("FLIP", Unit::None, Some(true)),
            "flip_hdr" => ("HDR-FLIP", Unit::None, Some(true)),
            "caches" => ("records", Unit::Count, None),
            "lights" => ("lights", Unit::Count, None),
            "lights_in_time" => ("lights or samples", Unit::Count, None),
            "rays" => ("closest-hit rays", Unit::Count, Some(true)),
            "shadow_rays" => ("shadow rays", Unit::Count, Some(true)),
            "all_rays" => ("rays", Unit::Count, Some(true)),
            "lookups" => ("lookups", Unit::Count, Some(true)),
            "bytes_peak" => ("peak memory", Unit::Bytes, Some(true)),
            "non_finite" => ("non-finite", Unit::Count, Some(true)),
            "reference_floor" => ("reference noise", Unit::None, None),
            "seconds_total" => ("time", Unit::Seconds, Some(true)),
            _ => match key.strip_prefix("seconds_") {
                Some(stage) => return Self::stage(stage),
                None => (key, Unit::None, None),
            },
        };
        Self {
            key: key.to_owned(),
            heading: heading.to_owned(),
            unit,
            lower_is_better,
        }
    }

    /// Seconds of one stage.
    pub fn stage(stage: &str) -> Self {
        Self {
            key: format!("seconds_{stage}"),
            heading: stage.replace('_', " "),
            unit: Unit::Seconds,
            lower_is_better: Some(true),
        }
    }

    /// An arrow towards the better values, with a space before it, or nothing.
    pub fn arrow(&self) -> &'static str {
        match self.lower_is_better {
            Some(true) => " ↓",
            Some(false) => " ↑",
            None => "",
        }
    }
}
