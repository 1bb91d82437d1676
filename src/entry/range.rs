//! Ranges of parameters.

use toml::Value;

/// Which numbers a parameter takes; infinity and NaN are in no range.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    /// All finite numbers.
    Any,
    /// From here on.
    AtLeast(f64),
    /// From here on, exclusive.
    Above(f64),
    /// From one to the other.
    Within(f64, f64),
    /// From one, exclusive, to the other.
    AboveUpTo(f64, f64),
}

impl Range {
    fn contains(self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Self::Any => true,
                Self::AtLeast(least) => number >= lowered(least),
                Self::Above(bound) => number > bound,
                Self::Within(least, most) => (lowered(least)..=raised(most)).contains(&number),
                Self::AboveUpTo(bound, most) => number > bound && number <= raised(most),
            }
    }

    /// Whether it contains every number of a value.
    pub(super) fn fits(self, value: &Value) -> bool {
        match value {
            Value::Integer(number) => self.contains(*number as f64),
            Value::Float(number) => self.contains(*number),
            Value::Array(items) => items.iter().all(|item| self.fits(item)),
            _ => true,
        }
    }
}

/// A lower bound, or what single precision makes of it where that is less: numbers are kept so.
fn lowered(bound: f64) -> f64 {
    bound.min(f64::from(bound as f32))
}

/// An upper bound, likewise.
fn raised(bound: f64) -> f64 {
    bound.max(f64::from(bound as f32))
}

impl std::fmt::Display for Range {
    /// As it follows "a number".
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Any => Ok(()),
            Self::AtLeast(least) => write!(f, ", {least} or more"),
            Self::Above(bound) => write!(f, " above {bound}"),
            Self::Within(least, most) => write!(f, " from {least} to {most}"),
            Self::AboveUpTo(bound, most) => write!(f, " above {bound} and up to {most}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.01 in single precision is less than 0.01.
    #[test]
    fn bounds_are_taken_in_single_precision_too() {
        let single = |number: f32| Value::Float(f64::from(number));
        assert!(f64::from(0.01f32) < 0.01 && f64::from(0.1f32) > 0.1);
        assert!(Range::Within(0.01, 0.1).fits(&single(0.01)));
        assert!(Range::Within(0.01, 0.1).fits(&single(0.1)));
        assert!(Range::AtLeast(0.01).fits(&single(0.01)));
        assert!(Range::AboveUpTo(0.0, 0.1).fits(&single(0.1)));
        for number in [0.0099, 0.1001, f64::NAN, f64::INFINITY] {
            assert!(!Range::Within(0.01, 0.1).fits(&Value::Float(number)));
        }
    }
}
