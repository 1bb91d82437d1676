//! The scale of an experiment's images.

use serde::{Deserialize, Serialize};

/// A positive factor written as a number or as a fraction, `0.25` or `"1/4"`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scale(pub f64);

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(
            untagged,
            expecting = "expected a positive scale such as 0.25 or \"1/4\""
        )]
        enum Form {
            Number(f64),
            Integer(i64),
            Text(String),
        }
        let value = match Form::deserialize(deserializer)? {
            Form::Number(x) => Some(x),
            Form::Integer(x) => Some(x as f64),
            Form::Text(text) => match text.split_once('/') {
                Some((a, b)) => a
                    .trim()
                    .parse::<f64>()
                    .ok()
                    .zip(b.trim().parse::<f64>().ok())
                    .map(|(a, b)| a / b),
                None => text.trim().parse().ok(),
            },
        };
        value
            .filter(|v| v.is_finite() && *v > 0.0)
            .map(Scale)
            .ok_or_else(|| {
                serde::de::Error::custom("expected a positive scale such as 0.25 or \"1/4\"")
            })
    }
}
