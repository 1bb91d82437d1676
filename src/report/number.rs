//! Numbers as text: one scale and one number of decimals for all values that are compared.

use super::estimate::Estimate;
use crate::experiment::Unit;
use crate::technique::UNITS;

/// How the numbers of one quantity are written.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Values are divided by it.
    scale: f64,
    /// What the scale and unit are called, empty when plain.
    pub unit: &'static str,
    decimals: usize,
    scientific: bool,
}

impl Style {
    /// A style in which every value has about three significant digits, and none more than two
    /// beyond those of the largest. Whole counts get no decimals.
    pub fn of(unit: Unit, values: impl Iterator<Item = f64> + Clone) -> Self {
        let sizes = values
            .clone()
            .map(f64::abs)
            .filter(|v| *v > 0.0 && v.is_finite());
        let largest = sizes.clone().fold(0.0, f64::max);
        let smallest = sizes.fold(f64::INFINITY, f64::min);
        let (scale, name) = scale_of(unit, largest);
        if largest == 0.0 {
            return Self {
                scale,
                unit: name,
                decimals: 0,
                scientific: false,
            };
        }
        let exponent = |v: f64| (v / scale).log10().floor();
        let scientific = !(-6.0..7.0).contains(&exponent(largest));
        let least = (2.0 - exponent(largest)).max(0.0);
        let most = (2.0 - exponent(smallest)).clamp(least, least + 2.0);
        let whole = scale == 1.0 && values.clone().all(|v| v.fract() == 0.0);
        Self {
            scale,
            unit: name,
            decimals: if whole { 0 } else { most as usize },
            scientific,
        }
    }

    /// One number.
    pub fn number(&self, value: f64) -> String {
        let value = value / self.scale;
        if self.scientific {
            return format!("{value:.2e}");
        }
        let text = format!("{value:.*}", self.decimals);
        if value.abs() >= 10_000.0 {
            grouped(&text)
        } else {
            text
        }
    }

    /// The half width of an interval: nothing when it is zero or unknown.
    pub fn half_width(&self, estimate: &Estimate) -> Option<String> {
        let half = estimate.half_width.filter(|h| *h > 0.0)?;
        let text = self.number(half);
        let vanishes = !self.scientific && !text.contains(|c: char| ('1'..='9').contains(&c));
        Some(match vanishes {
            true => format!(
                "<{}",
                self.number(self.scale * 10f64.powi(-(self.decimals as i32)))
            ),
            false => text,
        })
    }

    /// `mean ± half width`, and over how many seeds it is where it lacks some.
    pub fn estimate(&self, estimate: &Estimate) -> String {
        let mean = self.number(estimate.mean);
        let lacking = lacking(estimate);
        match self.half_width(estimate) {
            Some(half) => format!("{mean} ± {half}{lacking}"),
            None => format!("{mean}{lacking}"),
        }
    }
}

/// ` (2 of 3 seeds)`, or nothing where all are there.
pub fn lacking(estimate: &Estimate) -> String {
    match estimate.is_whole() {
        true => String::new(),
        false => format!(" ({} of {} seeds)", estimate.repeats(), estimate.expected),
    }
}

fn scale_of(unit: Unit, largest: f64) -> (f64, &'static str) {
    match unit {
        Unit::None => (1.0, ""),
        Unit::Decibel => (1.0, "dB"),
        Unit::Seconds if largest > 0.0 && largest < 0.1 => (1e-3, "ms"),
        Unit::Seconds => (1.0, "s"),
        Unit::Bytes if largest >= 1024.0 * 1024.0 => (1024.0 * 1024.0, "MiB"),
        Unit::Bytes => (1024.0, "KiB"),
        Unit::Count if largest >= 1e9 => (1e9, "10⁹"),
        Unit::Count if largest >= 1e6 => (1e6, "10⁶"),
        Unit::Count => (1.0, ""),
    }
}

/// Thin groups of three digits before the decimal point, split by commas.
fn grouped(text: &str) -> String {
    let (whole, fraction) = text
        .split_once('.')
        .map_or((text, None), |(w, f)| (w, Some(f)));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |d| ("-", d));
    let mut out = sign.to_owned();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            out.push(',');
        }
        out.push(digit);
    }
    if let Some(fraction) = fraction {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// A whole number with groups of three digits.
pub fn count(value: u64) -> String {
    grouped(&value.to_string())
}

/// A budget as rows have it, in words: `lights=16` is `16 rays a point`.
pub fn budget(text: &str) -> String {
    let told = text.split_once('=').and_then(|(key, amount)| {
        let unit = UNITS.into_iter().find(|unit| unit.key == key)?;
        let amount = amount.parse().map_or(amount.to_owned(), count);
        Some(with_unit(&amount, unit.heading))
    });
    told.unwrap_or_else(|| text.to_owned())
}

/// `16 rays a point`, `1 ray a point`.
pub fn with_unit(amount: &str, heading: &str) -> String {
    let (thing, of) = heading.split_once(' ').unwrap_or((heading, ""));
    let thing = match thing.strip_suffix('s') {
        Some(one) if amount == "1" && !one.is_empty() => one,
        _ => thing,
    };
    format!("{amount} {thing} {of}").trim_end().to_owned()
}

/// A lone number with four significant digits.
pub fn lone(value: f64) -> String {
    if !value.is_finite() {
        return "—".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10().floor();
    if !(-5.0..7.0).contains(&exponent) {
        return format!("{value:.3e}");
    }
    grouped(&format!("{value:.*}", (3.0 - exponent).max(0.0) as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::SECONDS;

    fn written(unit: Unit, values: &[f64]) -> Vec<String> {
        let style = Style::of(unit, values.iter().copied());
        values.iter().map(|v| style.number(*v)).collect()
    }

    #[test]
    fn decimals_follow_the_sizes() {
        assert_eq!(written(Unit::None, &[0.084, 0.0245]), ["0.0840", "0.0245"]);
        assert_eq!(written(Unit::None, &[0.15, 0.0245]), ["0.1500", "0.0245"]);
        assert_eq!(written(Unit::None, &[12.0, 1e-9]), ["12.000", "0.000"]);
        assert_eq!(
            written(Unit::Count, &[7500.0, 120_000.0]),
            ["7500", "120,000"]
        );
        assert_eq!(written(Unit::Count, &[7.68e6, 12.3e6]), ["7.68", "12.30"]);
        assert_eq!(written(Unit::Seconds, &[0.012]), ["12.0"]);
        assert_eq!(written(Unit::None, &[1e-12]), ["1.00e-12"]);
        assert_eq!(written(Unit::None, &[0.0, 0.0]), ["0", "0"]);
        assert_eq!(written(Unit::None, &[f64::INFINITY]), ["inf"]);
    }

    #[test]
    fn tiny_intervals_are_bounded_instead_of_zero() {
        let style = Style::of(Unit::None, [0.084].into_iter());
        let mut estimate = Estimate::exact(0.084).expect("finite");
        estimate.half_width = Some(1e-7);
        assert_eq!(style.estimate(&estimate), "0.0840 ± <0.0001");
        assert_eq!(lone(-12_345.678), "-12,346");
        assert_eq!(lone(0.0012345), "0.001234");
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!(budget("caches=12500"), "12,500 records");
        assert_eq!(budget("seconds=0.5"), format!("0.5 {}", SECONDS.heading));
        assert_eq!(budget("samples=1"), "1 path a pixel");
        assert_eq!(budget("seconds=1"), "1 CPU s");
        assert_eq!(budget("none"), "none");
    }
}
