//! The HTML report: one page that works from the file system.

use std::io;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;
use serde_json::{Value, json};

use super::claims::Claim;
use super::data::Data;
use super::escape;
use super::figure::{Drawn, Figure};
use super::job_lines;
use super::number;
use super::pixels::Shelf;
use super::table::Table;
use super::table_kinds;
use crate::experiment::{Budget, Case, Job, Row};

const TEMPLATE: &str = include_str!("page/report.html");
const STYLE: &str = include_str!("page/style.css");
/// What moves in the page; each file builds on those before it.
const SCRIPT: &str = concat!(
    "\"use strict\";\n",
    include_str!("page/commands.js"),
    include_str!("page/pixels.js"),
    include_str!("page/paint.js"),
    include_str!("page/stage.js"),
    include_str!("page/viewer.js"),
    include_str!("page/tables.js"),
);

/// Letters of a table that fit the page side by side.
const LETTERS: usize = 128;

/// A line of the list of failures.
#[derive(Serialize)]
struct Failure {
    job: String,
    scene: String,
    label: String,
    budget: String,
    seed: u64,
    reason: String,
}

/// A scene as the page introduces it.
#[derive(Serialize)]
struct SceneLine {
    name: String,
    view: String,
    size: String,
    spp: u32,
    budget: String,
    technique: String,
}

/// Fills the template.
pub fn page(
    data: &Data,
    tables: &[Table],
    claims: &[Claim],
    drawn: &Drawn,
    shelf: Shelf,
) -> io::Result<String> {
    let title = data.title();
    let costs = table_kinds::costs(data);
    let count =
        |rows: &dyn Fn(&str) -> bool| claims.iter().filter(|c| !c.gate && rows(&c.class)).count();
    let tally = json!({
        "holds": count(&|c| c == "holds"), "fails": count(&|c| c == "fails"),
        "open": count(&|c| c == "open"), "other": count(&|c| c == "none" || c == "error"),
    });
    let missing: Vec<String> = data
        .missing()
        .iter()
        .map(|j| {
            format!(
                "{} ({}) · {} · {} · seed {}",
                j.scene, j.view, j.label, j.budget, j.seed
            )
        })
        .collect();
    let (headings, lines) = job_lines::all(data);
    let sources = shelf.sources();
    let page = json!({
        "style": STYLE,
        "script": SCRIPT,
        "inside": shelf.into_inside(),
        "folder": place(data),
        "headings": headings,
        "lines": lines,
        "rows": data.cases.rows.len(),
        "title": title,
        "name": data.plan.name,
        "tables": tables.iter().map(|t| t.parts_within(LETTERS)).collect::<Vec<_>>(),
        "costs": costs.parts_within(LETTERS),
        "claims": claims.iter().filter(|c| !c.gate).collect::<Vec<_>>(),
        "gates": claims.iter().filter(|c| c.gate).collect::<Vec<_>>(),
        "tally": tally,
        "figures": figures(data, drawn),
        "viewers": drawn.viewers,
        "notes": notes(data, drawn),
        "failed": failures(data),
        "missing": missing,
        "jobs": data.plan.jobs.len(),
        "finished": data.cases.rows.iter().filter(|r| r.ok()).count(),
        "scenes": scenes(data),
        "labels": data.labels(),
        "sweep": data.points().iter().map(|p| p.text()).filter(|t| !t.is_empty()).collect::<Vec<_>>(),
        "seeds": data.config.repeats,
        "provenance": provenance(data),
        "command": command(data),
        "again": format!("lightbench report {}", folder(data)),
    });
    let mut environment = environment();
    environment.add_filter("source", move |file: String| sources.of(&file));
    render(environment, "report.html", TEMPLATE, page)
}

/// A template of a name with its values put in, escaped for HTML.
pub fn fill(name: &str, template: &str, values: Value) -> io::Result<String> {
    render(environment(), name, template, values)
}

fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_filter("link", |path: String| escape::link(&path));
    environment.add_filter("extension", |path: String| {
        path.rsplit('.').next().unwrap_or_default().to_uppercase()
    });
    environment
}

fn render(
    mut environment: Environment,
    name: &str,
    template: &str,
    values: Value,
) -> io::Result<String> {
    let name = name.to_owned();
    environment
        .add_template_owned(name.clone(), template.to_owned())
        .map_err(io::Error::other)?;
    let template = environment.get_template(&name).map_err(io::Error::other)?;
    template
        .render(minijinja::Value::from(Serde(values)))
        .map_err(io::Error::other)
}

/// Figures; plots with their drawing, so that their points tell what they stand for.
fn figures(data: &Data, drawn: &Drawn) -> Vec<Value> {
    let told = |figure: &Figure| {
        let first = figure.files.first().filter(|file| file.ends_with(".svg"));
        let path = first.map(|file| data.store.folder.join(file));
        let svg = path.and_then(|path| std::fs::read_to_string(path).ok());
        json!({
            "title": figure.title, "caption": figure.caption, "files": figure.files, "svg": svg,
            "width": figure.width, "height": figure.height,
        })
    };
    drawn.figures.iter().map(told).collect()
}

/// Stand-ins, shortfalls and undrawn figures; failed and missing jobs have their own lists.
fn notes(data: &Data, drawn: &Drawn) -> Vec<String> {
    let mut notes = data.plan.told();
    for note in data.cases.notes() {
        notes.push(format!("{} — {}", note.text, note.runs.join(", ")));
    }
    notes.extend(data.unplaced());
    notes.extend(drawn.notes.iter().cloned());
    notes
}

fn failures(data: &Data) -> Vec<Failure> {
    data.failed()
        .iter()
        .map(|row| Failure {
            job: row.job.clone(),
            scene: data.cases.name_of(row),
            label: row.label.clone(),
            budget: row.budget.clone(),
            seed: row.seed,
            reason: reason(row),
        })
        .collect()
}

/// Why a job failed, and what else is known: where values were not finite, for one.
fn reason(row: &Row) -> String {
    let status = row.status.strip_prefix("failed: ").unwrap_or(&row.status);
    let notes = row.notes.iter().map(String::as_str);
    [status]
        .into_iter()
        .chain(notes)
        .collect::<Vec<_>>()
        .join(" — ")
}

fn scenes(data: &Data) -> Vec<SceneLine> {
    data.scenes
        .iter()
        .filter_map(|scene| {
            let jobs: Vec<_> = data
                .plan
                .jobs
                .iter()
                .filter(|job| Case::of_job(job).place == scene.place)
                .collect();
            let job = jobs.first()?;
            let budget = budgets(&jobs);
            Some(SceneLine {
                name: scene.title(),
                view: seen(job),
                size: format!("{} × {}", job.width, job.height),
                spp: job.spp,
                budget,
                technique: job.technique.clone(),
            })
        })
        .collect()
}

/// From where a scene is seen, and over how many frames.
fn seen(job: &Job) -> String {
    match job.sequence.frames.len() {
        1 => job.view.clone(),
        count => format!("{}, {count} frames", job.view),
    }
}

/// The budget of a scene's jobs, or its range; they are of one kind.
fn budgets(jobs: &[&Job]) -> String {
    let told = |budget: Budget| {
        let amount = budget.amount;
        let text = budget.count().map_or(amount.to_string(), number::count);
        (amount, text, budget.unit.heading)
    };
    let mut all: Vec<(f64, String, &str)> = jobs.iter().map(|job| told(job.budget)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    match (all.first(), all.last()) {
        (Some(least), Some(most)) if least.0 < most.0 => {
            format!("{} to {} {}", least.1, most.1, most.2)
        }
        (Some(only), _) => number::with_unit(&only.1, only.2),
        _ => String::new(),
    }
}

/// Keys and values of `provenance.json`; lists are joined, times are made readable.
fn provenance(data: &Data) -> Vec<(String, String)> {
    let entries = data.provenance["entries"].as_array().into_iter().flatten();
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Array(list) => {
            let parts: Vec<String> = list
                .iter()
                .map(|v| v.as_str().map_or_else(|| v.to_string(), str::to_owned))
                .collect();
            parts.join(" ")
        }
        other => other.to_string(),
    };
    entries
        .filter_map(Value::as_object)
        .flatten()
        .map(|(key, value)| match (key.as_str(), value.as_u64()) {
            ("started_unix_seconds", Some(seconds)) => ("started".to_owned(), date(seconds)),
            ("last_started_unix_seconds", Some(seconds)) => ("last started".into(), date(seconds)),
            _ => (key.replace('_', " "), text(value)),
        })
        .filter(|(_, value)| !value.is_empty())
        .collect()
}

/// UTC date and time of a Unix time (days to civil date as in the Gregorian calendar).
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let day_of_era = shifted % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 {
        shifted_month + 3
    } else {
        shifted_month - 9
    };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year}-{month:02}-{day:02} {:02}:{:02} UTC",
        rest / 3600,
        rest / 60 % 60
    )
}

/// The results, as they lie where nobody says otherwise; the page puts its own place there.
pub fn folder(data: &Data) -> String {
    escape::shell(&place(data))
}

/// Where the results lie, if that is below `results` as it is of members of suites, or else where they lie by default.
pub fn place(data: &Data) -> String {
    match data.store.folder.to_str() {
        Some(folder) if folder.starts_with("results/") => folder.trim_end_matches('/').to_owned(),
        _ => format!("results/{}", data.plan.name),
    }
}

/// The command that made the results.
pub fn command(data: &Data) -> String {
    let configs = data
        .plan
        .configs
        .iter()
        .map(|c| escape::shell(&c.display().to_string()));
    let overrides = data.plan.overrides.iter().map(|o| escape::shell(o));
    let words: Vec<String> = configs.chain(overrides).collect();
    format!("lightbench run {}", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(date(0), "1970-01-01 00:00 UTC");
        assert_eq!(date(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(date(1_700_000_000), "2023-11-14 22:13 UTC");
    }
}
