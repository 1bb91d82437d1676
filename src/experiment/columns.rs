//! The columns of rows: one table for `rows.csv`, checks, tables, plots, claims and `docs/columns.md`.

mod found;
#[cfg(test)]
mod page;
mod table;

use serde_json::{Map, Value};

pub use found::FOUND;
pub use table::COLUMNS;

use super::Row;

/// What a column is measured in, which decides how its numbers are scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nothing: a plain number, or text.
    None,
    /// dB, never scaled.
    Decibel,
    /// Shown in seconds, short ones in milliseconds.
    Seconds,
    /// Shown in KiB or MiB.
    Bytes,
    /// A count, shown in powers of a thousand.
    Count,
}

/// How a column is read from a row.
#[derive(Clone, Copy)]
pub enum Cells {
    /// Words of the row.
    Text(fn(&Row) -> String),
    /// A whole number; `None` leaves the cell empty.
    Count(fn(&Row) -> Option<u64>),
    /// A real number; `None` leaves the cell empty.
    Number(fn(&Row) -> Option<f64>),
    /// Follows from other columns: for tables, plots and claims, not in `rows.csv`.
    Derived(fn(&Row) -> Option<f64>),
    /// One column for each stage, `<key>_<stage>`.
    Stages(fn(&Row) -> &Map<String, Value>),
    /// One of the row's `params`.
    Found,
}

/// A column as the table of columns declares it.
#[derive(Clone, Copy)]
pub struct ColumnEntry {
    /// Name in `rows.csv`.
    pub key: &'static str,
    /// What tables and axes call it; of columns of stages what comes before the stage.
    pub heading: &'static str,
    /// Of all its numbers.
    pub unit: Unit,
    /// Whether smaller values are better; `None` where neither way is.
    pub lower_is_better: Option<bool>,
    /// A phrase for the page of columns.
    pub meaning: &'static str,
    /// Where its values come from.
    pub cells: Cells,
}

/// A column as tables and plots show it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name in `rows.csv`.
    pub key: String,
    /// What tables and axes call it.
    pub heading: String,
    /// Of all its numbers.
    pub unit: Unit,
    /// Whether smaller values are better; `None` where neither way is.
    pub lower_is_better: Option<bool>,
}

/// `flip` is short for `flip_ldr`.
fn spelled_out(key: &str) -> &str {
    match key {
        "flip" => "flip_ldr",
        _ => key,
    }
}

impl ColumnEntry {
    /// Its number in a row; `None` for text and for columns of stages.
    fn number(&self, row: &Row) -> Option<f64> {
        match self.cells {
            Cells::Count(get) => get(row).map(|n| n as f64),
            Cells::Number(get) | Cells::Derived(get) => get(row),
            Cells::Text(_) | Cells::Stages(_) => None,
            Cells::Found => row.params.get(self.key).and_then(Value::as_f64),
        }
    }

    /// The stage of `<key>_<stage>`.
    fn stage<'a>(&self, key: &'a str) -> Option<&'a str> {
        match self.cells {
            Cells::Stages(_) => key.strip_prefix(self.key)?.strip_prefix('_'),
            _ => None,
        }
    }

    fn is_numeric(&self) -> bool {
        !matches!(self.cells, Cells::Text(_) | Cells::Stages(_))
    }
}

/// The entry of a key, with the stage if it is a column of stages.
fn find(key: &str) -> Option<(&'static ColumnEntry, Option<&str>)> {
    let key = spelled_out(key);
    let named = COLUMNS.iter().chain(FOUND).filter(|e| e.is_numeric());
    let stages = || {
        COLUMNS
            .iter()
            .filter_map(|e| Some((e, Some(e.stage(key)?))))
    };
    named
        .into_iter()
        .find(|e| e.key == key)
        .map(|e| (e, None))
        .or_else(|| stages().next())
}

/// A number of a row by the name of its column, else by a parameter or a swept key.
pub fn number(row: &Row, key: &str) -> Option<f64> {
    let value = match find(key) {
        Some((entry, None)) => return entry.number(row),
        Some((
            ColumnEntry {
                cells: Cells::Stages(get),
                ..
            },
            Some(stage),
        )) => get(row).get(stage),
        _ => row.params.get(key).or_else(|| row.sweep.get(key)),
    };
    value.and_then(Value::as_f64)
}

/// Whether a number of this name is declared: a column, a stage or something that methods find.
pub fn is_declared(key: &str) -> bool {
    find(key).is_some()
}

/// Names of all declared numbers but the stages' own.
pub fn declared() -> impl Iterator<Item = &'static str> {
    let entries = COLUMNS.iter().chain(FOUND);
    entries.filter(|e| e.is_numeric()).map(|e| e.key)
}

impl Column {
    /// The column of a name in `rows.csv`; unknown names are parameters.
    pub fn of(key: &str) -> Self {
        let (heading, unit, lower_is_better) = match find(key) {
            Some((e, None)) => (e.heading.to_owned(), e.unit, e.lower_is_better),
            Some((e, Some(stage))) => {
                let heading = format!("{}{}", e.heading, stage.replace('_', " "));
                (heading, e.unit, e.lower_is_better)
            }
            None => (key.to_owned(), Unit::None, None),
        };
        Self {
            key: key.to_owned(),
            heading,
            unit,
            lower_is_better,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_there_once() {
        let entries = COLUMNS.iter().chain(FOUND);
        let mut keys: Vec<&str> = entries.map(|e| e.key).collect();
        keys.sort_unstable();
        let all = keys.len();
        keys.dedup();
        assert_eq!(keys.len(), all);
    }

    #[test]
    fn stages_parameters_and_swept_keys_are_numbers_too() {
        let mut row = Row {
            rays: 3,
            shadow_rays: 4,
            cpu_seconds_total: 2.0,
            flip_ldr: Some(0.5),
            ..Row::default()
        };
        row.seconds.insert("placement".into(), 0.25.into());
        row.cpu_seconds.insert("placement".into(), 0.5.into());
        row.serial_share.insert("placement".into(), 0.125.into());
        row.params.insert("allowed_error".into(), 0.75.into());
        row.sweep.insert("side".into(), 8.into());
        for (key, value) in [
            ("all_rays", 7.0),
            ("flip", 0.5),
            ("seconds_placement", 0.25),
            ("cpu_seconds_total", 2.0),
            ("cpu_seconds_placement", 0.5),
            ("serial_share_placement", 0.125),
            ("allowed_error", 0.75),
            ("side", 8.0),
        ] {
            assert_eq!(number(&row, key), Some(value), "{key}");
        }
        assert_eq!(number(&row, "method"), None);
        assert_eq!(Column::of("cpu_seconds_placement").heading, "CPU placement");
        assert!(is_declared("passes") && is_declared("seconds_any") && !is_declared("label"));
    }
}
