//! The rows as the page lists them, each with the commands that run the job again and that replay a pixel of it.

use serde::Serialize;

use super::data::Data;
use super::number::Style;
use super::{escape, html};
use crate::experiment::{Column, Row};

/// Rows that the page lists at most.
const MOST: usize = 2000;
/// Columns that are listed if any row has them.
const COLUMNS: [&str; 7] = [
    "rmse",
    "flip_ldr",
    "all_rays",
    "seconds_total",
    "inefficiency",
    "cpu_seconds_total",
    "non_finite",
];

/// A row.
#[derive(Serialize)]
pub struct JobLine {
    scene: String,
    label: String,
    budget: String,
    swept: String,
    seed: u64,
    /// As shown, and in full for sorting.
    numbers: Vec<(String, String)>,
    status: String,
    run: String,
    replay: String,
}

/// Headings of the numbers, and the rows.
pub fn all(data: &Data) -> (Vec<String>, Vec<JobLine>) {
    let rows = || data.cases.rows.iter().take(MOST);
    let values = |key: &'static str| rows().filter_map(move |row| row.number(key));
    let shown = |key: &&&'static str| match **key {
        "non_finite" => values("non_finite").any(|n| n > 0.0),
        key => values(key).next().is_some(),
    };
    let columns = COLUMNS.iter().filter(shown).map(|key| {
        let column = Column::of(key);
        let style = Style::of(column.unit, values(key));
        (*key, column, style)
    });
    let columns: Vec<_> = columns.collect();
    let headings = columns.iter().map(|(_, column, style)| {
        let unit = match style.unit.is_empty() {
            true => String::new(),
            false => format!(", {}", style.unit),
        };
        format!("{}{unit}", column.heading)
    });
    let headings = headings.collect();
    let lines = rows().map(|row| {
        let number = |(key, _, style): &(&str, Column, Style)| match row.number(key) {
            Some(value) => (style.number(value), value.to_string()),
            None => ("—".into(), "—".into()),
        };
        JobLine {
            scene: data.cases.name_of(row),
            label: row.label.clone(),
            budget: row.budget.clone(),
            swept: swept(row),
            seed: row.seed,
            numbers: columns.iter().map(number).collect(),
            status: row.status.clone(),
            run: again(data, row),
            replay: format!(
                "lightbench replay {} --pixel {}",
                folder(data, row),
                pixel(row)
            ),
        }
    });
    (headings, lines.collect())
}

fn swept(row: &Row) -> String {
    let pairs = row.sweep.iter().map(|(key, value)| match value.as_str() {
        Some(text) => format!("{key} {text}"),
        None => format!("{key} {value}"),
    });
    pairs.collect::<Vec<_>>().join(", ")
}

/// The first pixel that was not finite, or a stand-in for any.
fn pixel(row: &Row) -> &str {
    let located = row.notes.iter();
    let mut located = located.filter_map(|note| note.strip_prefix("not finite: pixel "));
    let place = located.next().and_then(|place| place.split(' ').next());
    place.unwrap_or("X,Y")
}

/// The folder of a row's job.
fn folder(data: &Data, row: &Row) -> String {
    escape::shell(&format!("{}/jobs/{}", html::place(data), row.job))
}

/// A finished job is kept unless its folder goes; the filters leave the other scenes and methods alone.
fn again(data: &Data, row: &Row) -> String {
    format!(
        "rm -r {} && {} --scene {} --method {} --out {}",
        folder(data, row),
        html::command(data),
        escape::shell(&row.scene),
        escape::shell(&row.label),
        html::folder(data)
    )
}
