//! What the contenders of an experiment share.

use serde::{Deserialize, Serialize};

use super::config::{Config, SceneChoice};
use crate::technique::Unit;

/// Longest budget of one image, seconds: a day.
const LONGEST_S: f64 = 86_400.0;

/// What the contenders of an experiment share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Budget {
    /// Records.
    Caches(u64),
    /// Shadow rays per shading point: lights at full resolution, or samples.
    Lights(u64),
    /// Paths through each pixel of a frame.
    Samples(u64),
    /// Seconds in all; how many shadow rays per shading point they pay for is found by
    /// `super::equal_time`.
    Seconds(f64),
}

impl Budget {
    /// Records or shadow rays; `None` where they follow from the time.
    pub fn count(self) -> Option<u64> {
        match self {
            Self::Caches(count) | Self::Lights(count) | Self::Samples(count) => Some(count),
            Self::Seconds(_) => None,
        }
    }

    /// What a single image gets unless it is told: 16 lights, a path a pixel, or the records per pixel of
    /// 120,000 at full HD.
    pub(super) fn usual(unit: Unit, [width, height]: [usize; 2]) -> u64 {
        let of_paper = (width * height) as f64 * 120_000.0 / (1920.0 * 1080.0);
        match unit {
            Unit::Lights => 16,
            Unit::Samples => 1,
            Unit::Caches => (of_paper.round() as u64).max(1),
        }
    }

    /// The budget of one scene; an error names the key at fault. `usual` is the count where none is set;
    /// without it one must be.
    pub(super) fn of(
        config: &Config,
        choice: &SceneChoice,
        usual: Option<u64>,
    ) -> Result<Self, (&'static str, String)> {
        let unit = crate::registry::technique(&config.technique).map_or(Unit::Caches, |t| t.unit);
        let caches = choice.caches.or(config.caches);
        let lights = choice.lights.or(config.lights);
        let samples = choice.samples.or(config.samples);
        let seconds = choice.seconds.or(config.seconds);
        let given = [
            ("caches", caches.is_some()),
            ("lights", lights.is_some()),
            ("samples", samples.is_some()),
            ("seconds", seconds.is_some()),
        ];
        let (wanted, takes, count): (_, &[&str], _) = match unit {
            Unit::Caches => ("caches", &["caches"], caches),
            Unit::Lights => ("lights", &["lights", "seconds"], lights),
            Unit::Samples => ("samples", &["samples"], samples),
        };
        let given = given
            .iter()
            .filter(|(_, there)| *there)
            .map(|(key, _)| *key);
        let given: Vec<&'static str> = given.collect();
        if let Some(key) = given.iter().find(|key| !takes.contains(key)) {
            let takes = takes.join("` or `");
            let message = format!(
                "{} takes `{takes}`, not `{key}`, as its budget",
                config.technique
            );
            return Err((key, message));
        }
        if given.len() > 1 {
            let message = format!(
                "two budgets, `{}`: expected one of them, for the experiment and its scenes alike",
                given.join("` and `")
            );
            return Err(("seconds", message));
        }
        if let Some(seconds) = seconds {
            if seconds.is_finite() && seconds > 0.0 && seconds <= LONGEST_S {
                return Ok(Self::Seconds(seconds));
            }
            let message = format!("seconds: expected a number above 0 and up to {LONGEST_S}");
            return Err(("seconds", message));
        }
        let count = count.or(usual).filter(|n| *n > 0).ok_or_else(|| {
            let message =
                format!("no number of {wanted}: set `{wanted}` for the experiment or the scene");
            (wanted, message)
        })?;
        Ok(match unit {
            Unit::Lights => Self::Lights(count),
            Unit::Samples => Self::Samples(count),
            Unit::Caches => {
                let scaled = count as f64 * config.scale.0 * config.scale.0;
                Self::Caches((scaled.round() as u64).max(1))
            }
        })
    }
}

impl std::fmt::Display for Budget {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Caches(amount) => write!(f, "caches={amount}"),
            Self::Lights(amount) => write!(f, "lights={amount}"),
            Self::Samples(amount) => write!(f, "samples={amount}"),
            Self::Seconds(seconds) => write!(f, "seconds={seconds}"),
        }
    }
}
