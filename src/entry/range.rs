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
                Self::AtLeast(least) => number >= least,
                Self::Above(bound) => number > bound,
                Self::Within(least, most) => (least..=most).contains(&number),
                Self::AboveUpTo(bound, most) => number > bound && number <= most,
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
