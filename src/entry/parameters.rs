//! Parameters, each declared once: [`parameters!`] makes its field, its default, its check and its documentation.

use serde::Serialize;
use toml::{Table, Value};

use super::{Kind, ParameterError, Range, Setting};
use crate::suggest::advice;

/// One documented parameter.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name in the parameter table.
    pub key: &'static str,
    /// The default as one writes it in TOML; `None` where the parameter is absent by default.
    pub default: fn() -> Option<String>,
    /// Empty when dimensionless.
    pub unit: &'static str,
    /// What it takes, whatever its range.
    pub kind: Kind,
    /// Which of its numbers are accepted.
    pub range: Range,
    /// A phrase for its page.
    pub meaning: &'static str,
}

impl Parameter {
    /// What it takes, in words.
    pub fn permitted(&self) -> String {
        let range = self.range;
        match self.kind {
            Kind::Number => format!("a number{range}"),
            Kind::NumberOr(word) => format!("a number{range}, or \"{word}\""),
            Kind::Whole => format!("a whole number{range}"),
            Kind::WholeOr(word) => format!("a whole number{range}, or \"{word}\""),
            Kind::Numbers(count) => format!("{count} numbers{range}"),
            Kind::Flag => "true or false".into(),
            Kind::Words(words) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                quoted.join(" or ")
            }
            Kind::Table(_) => "a table".into(),
        }
    }

    /// Its value in a table, checked; `default` where the table leaves it out.
    ///
    /// # Errors
    /// What is no such value or out of range.
    pub fn read<T: Setting>(&self, table: &Table, default: T) -> Result<T, ParameterError> {
        let key = self.key;
        let Some(given) = table.get(key) else {
            return Ok(default);
        };
        let read = match (T::deserialize(given.clone()), self.kind) {
            (Err(error), Kind::Table(_)) => {
                let message = format!("{key}: {}", error.message());
                return Err(ParameterError::new(key, message));
            }
            (read, _) => read.ok(),
        };
        let fits = |read: &T| Value::try_from(read).is_ok_and(|value| self.range.fits(&value));
        read.filter(fits).ok_or_else(|| {
            let unit = match self.unit {
                "" => String::new(),
                unit => format!(" ({unit})"),
            };
            let (given, permitted) = (shown(given), self.permitted());
            let message = format!("{key} = {given}: expected {permitted}{unit}");
            ParameterError::new(key, message)
        })
    }
}

/// A value in a message: a number that has many digits before or behind its point with an exponent.
fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) if *number != 0.0 && !(1e-6..1e15).contains(&number.abs()) => {
            match number.is_finite() {
                true => format!("{number:e}"),
                false => value.to_string(),
            }
        }
        _ => value.to_string(),
    }
}

/// A value as one writes it in TOML; `None` for what is absent.
pub fn written<T: Serialize>(value: &T) -> Option<String> {
    let mut text = String::new();
    let serializer = toml::ser::ValueSerializer::new(&mut text);
    value.serialize(serializer).is_ok().then_some(text)
}

/// Refuses keys that none of the parameters has.
///
/// # Errors
/// The first such key.
pub fn check_keys<'a>(
    table: &Table,
    parameters: impl IntoIterator<Item = &'a Parameter>,
) -> Result<(), ParameterError> {
    let known: Vec<&str> = parameters.into_iter().map(|p| p.key).collect();
    match table.keys().find(|key| !known.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => {
            let message = format!("unknown parameter `{key}`; {}", advice(key, &known));
            Err(ParameterError::new(key, message))
        }
    }
}

/// A struct of parameters, each declared in one place: meaning, name, type and default, and where they say
/// more, range and unit.
///
/// ```text
/// parameters! {
///     /// Clusters that are bounded in space and in direction.
///     #[derive(Clone, Copy, Debug)]
///     pub struct ViewGuided {
///         /// Γ: growth of the thresholds with the depth range.
///         pub gamma: f64 = 0.2, Within(0.0, 1000.0), "1/m";
///         /// Where clusters are split.
///         pub split: Plane = Plane::Midpoint;
///     }
///     check in_order;
/// }
/// ```
///
/// It has a `Default`, the list `PARAMETERS`, and `read`, which takes a table and refuses unknown keys and values of
/// another kind or range; `check`, a function of the struct, may refuse what no range can say. `Deserialize` reads too.
macro_rules! parameters {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident {
            $(
                $(#[doc = $meaning:literal])+
                $seen:vis $field:ident: $type:ty = $default:expr
                    $(, $range:ident($($bound:expr),+))? $(, $unit:literal)?;
            )*
        }
        $(check $check:path;)?
    ) => {
        $(#[$attribute])*
        $visibility struct $name {
            $($(#[doc = $meaning])+ $seen $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// What each field means and takes, in order.
            pub const PARAMETERS: &'static [$crate::entry::Parameter] = &[$(
                $crate::entry::Parameter {
                    key: stringify!($field),
                    default: || $crate::entry::written::<$type>(&$default),
                    unit: concat!($($unit)?),
                    kind: <$type as $crate::entry::Setting>::KIND,
                    range: $crate::entry::parameters!(@range $($range($($bound),+))?),
                    meaning: concat!($($meaning),+).trim_ascii(),
                },
            )*];

            /// Reads and checks a table.
            ///
            /// # Errors
            /// Unknown keys and unfit values; the key is named.
            pub fn read(table: &toml::Table) -> Result<Self, $crate::entry::ParameterError> {
                $crate::entry::check_keys(table, Self::PARAMETERS)?;
                let [$($field),*] = Self::PARAMETERS else {
                    unreachable!("one for each field")
                };
                let read = Self { $($field: $field.read(table, $default)?,)* };
                $($check(&read)?;)?
                Ok(read)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
                let table = toml::Table::deserialize(source)?;
                Self::read(&table).map_err(serde::de::Error::custom)
            }
        }
    };
    (@range) => { $crate::entry::Range::Any };
    (@range $range:ident($($bound:expr),+)) => { $crate::entry::Range::$range($($bound),+) };
}

pub(crate) use parameters;

#[cfg(test)]
mod tests;
