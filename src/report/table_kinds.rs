//! The tables of a config: one line a method, a stage, or a method under a sweep.

use super::against_first::against_first;
use super::data::{Asked, Data, SceneOf};
use super::escape;
use super::estimate::{Estimate, Standing, ranks, standings};
use super::number::Style;
use super::stage_table::stages;
use super::table::{Block, Cell, Group, Line, Record, Table};
use crate::experiment::{Column, Unit};
use crate::experiment::{Swept, TableKind, TableSpec};

/// Every table of the config; errors by method when it names none.
pub fn all(data: &Data) -> Vec<Table> {
    let specs = &data.config.table;
    if specs.is_empty() {
        return vec![overview(data, &errors())];
    }
    specs
        .iter()
        .map(|spec| match spec.kind {
            TableKind::Methods => methods(data, spec, &data.scenes),
            TableKind::Averages => averages(data, spec),
            TableKind::Stages => stages(data, spec),
            TableKind::Sweep => sweep(data, spec),
            TableKind::Change | TableKind::EqualCost | TableKind::EqualError => {
                against_first(data, spec, start(spec, "Method"))
            }
        })
        .collect()
}

fn errors() -> TableSpec {
    TableSpec {
        name: "errors".into(),
        title: "Error".into(),
        kind: TableKind::Methods,
        metrics: vec!["rmse".into(), "flip_ldr".into()],
        cost: String::new(),
    }
}

/// What every job cost: counted, and CPU seconds.
pub fn costs(data: &Data) -> Table {
    let metrics = [
        "caches",
        "all_rays",
        "lookups",
        "bytes_scene",
        "bytes_cache",
        "bytes_work",
        "cpu_seconds_total",
    ];
    overview(
        data,
        &TableSpec {
            name: "costs".into(),
            title: "Costs".into(),
            kind: TableKind::Methods,
            metrics: metrics.map(String::from).to_vec(),
            cost: String::new(),
        },
    )
}

/// Most scenes that stand side by side where the config does not say how.
pub(super) const MOST_SCENES: usize = 12;

/// Every scene, or the means of many.
fn overview(data: &Data, spec: &TableSpec) -> Table {
    if data.scenes.len() > MOST_SCENES {
        averages(data, spec)
    } else {
        methods(data, spec, &data.scenes)
    }
}

/// One line a method, the mean over all scenes and the mean rank of each metric.
fn averages(data: &Data, spec: &TableSpec) -> Table {
    methods(data, spec, &[SceneOf::all()])
}

/// A column and the way its numbers are written all over a table.
struct Metric {
    column: Column,
    style: Style,
}

impl Metric {
    fn new(data: &Data, key: &str) -> Self {
        let column = Column::of(key);
        let style = style_of(data, &[key.to_owned()], column.unit);
        Self { column, style }
    }

    /// `RMSE ↓`, `CPU time, s ↓`.
    fn heading(&self) -> String {
        let unit = self.style.unit;
        let comma = if unit.is_empty() { "" } else { ", " };
        format!(
            "{}{comma}{unit}{}",
            self.column.heading,
            self.column.arrow()
        )
    }
}

/// One style for several columns that are compared with one another.
pub(super) fn style_of(data: &Data, keys: &[String], unit: Unit) -> Style {
    let mut values = Vec::new();
    for scene in &data.scenes {
        for point in data.points() {
            for label in data.labels() {
                for key in keys {
                    let case = asked(scene, label, point);
                    values.extend(data.estimate(case, key).map(|e| e.mean));
                    values.extend(data.published(asked(scene, label, point), key));
                }
            }
        }
    }
    Style::of(unit, values.into_iter())
}

pub(super) fn asked<'a>(scene: &'a SceneOf, label: &'a str, point: &'a Swept) -> Asked<'a> {
    Asked {
        scene,
        label,
        point,
    }
}

/// The estimates of all methods in one column, with their standings; recorded for the CSV.
pub(super) fn column_of(
    data: &Data,
    scene: &SceneOf,
    point: &Swept,
    column: &Column,
    records: &mut Vec<Record>,
) -> Vec<(Option<Estimate>, Standing)> {
    let estimates: Vec<Option<Estimate>> = data
        .labels()
        .iter()
        .map(|label| data.estimate(asked(scene, label, point), &column.key))
        .collect();
    let rivals: Vec<Option<&Estimate>> = estimates.iter().map(Option::as_ref).collect();
    let marks = match column.lower_is_better {
        Some(lower) => standings(&rivals, lower),
        None => vec![Standing::Plain; rivals.len()],
    };
    for ((label, estimate), standing) in data.labels().iter().zip(&estimates).zip(&marks) {
        records.push(Record {
            scene: scene.name.clone(),
            paper_scene: scene.paper.clone(),
            sweep: point.text(),
            method: label.clone(),
            metric: column.key.clone(),
            estimate: estimate.clone(),
            ends: None,
            budgets: None,
            published: data.published(asked(scene, label, point), &column.key),
            standing: *standing,
        });
    }
    estimates.into_iter().zip(marks).collect()
}

/// A number of ours.
pub(super) fn ours(estimate: Option<&Estimate>, standing: Standing, style: &Style) -> Cell {
    estimate.map_or_else(Cell::empty, |e| Cell {
        text: style.estimate(e),
        standing,
        published: false,
    })
}

/// A number of the paper.
pub(super) fn theirs(value: Option<f64>, style: &Style) -> Cell {
    Cell {
        published: true,
        ..value.map_or_else(Cell::empty, |v| Cell {
            text: style.number(v),
            ..Cell::default()
        })
    }
}

/// One line a method, columns scene × metric, a block for each swept value.
fn methods(data: &Data, spec: &TableSpec, scenes: &[SceneOf]) -> Table {
    let metrics: Vec<Metric> = spec
        .metrics
        .iter()
        .map(|key| Metric::new(data, key))
        .collect();
    let mut table = start(spec, "Method");
    for scene in scenes {
        let mut columns = Vec::new();
        for metric in &metrics {
            columns.push(metric.heading());
            if data.has_published(scene, &metric.column.key) {
                columns.push("paper".into());
            }
        }
        table.groups.push(Group {
            heading: scene.title(),
            columns,
        });
    }
    let ranked: Vec<&Metric> = metrics
        .iter()
        .filter(|m| data.scenes.len() > 1 && tells_apart(data, &m.column))
        .collect();
    if !ranked.is_empty() {
        table.groups.push(Group {
            heading: "Mean rank".into(),
            columns: ranked
                .iter()
                .flat_map(|m| {
                    let beside = published_rank(data, m).map(|_| "paper".to_owned());
                    std::iter::once(m.column.heading.clone()).chain(beside)
                })
                .collect(),
        });
    }
    for point in data.points() {
        let mut lines = lines_of(data.labels());
        for scene in scenes {
            for metric in &metrics {
                let column = column_of(data, scene, point, &metric.column, &mut table.records);
                let beside = data.has_published(scene, &metric.column.key);
                for (line, (estimate, standing)) in lines.iter_mut().zip(column) {
                    line.cells
                        .push(ours(estimate.as_ref(), standing, &metric.style));
                    if beside {
                        let value =
                            data.published(asked(scene, &line.heading, point), &metric.column.key);
                        line.cells.push(theirs(value, &metric.style));
                    }
                }
            }
        }
        for metric in &ranked {
            for (line, cell) in lines
                .iter_mut()
                .zip(mean_ranks(data, point, &metric.column))
            {
                line.cells.push(cell);
                if let Some(key) = published_rank(data, metric) {
                    let all = SceneOf::all();
                    let value = data.published(asked(&all, &line.heading, point), &key);
                    line.cells.push(Cell {
                        published: true,
                        ..value.map_or_else(Cell::empty, |v| Cell {
                            text: format!("{v:.2}"),
                            ..Cell::default()
                        })
                    });
                }
            }
        }
        table.blocks.push(Block {
            heading: point.text(),
            lines,
        });
    }
    notes(data, &mut table);
    table
}

/// The key of the paper's mean ranks of a metric, such as `rank_rmse`, where it prints some.
fn published_rank(data: &Data, metric: &Metric) -> Option<String> {
    let key = format!("rank_{}", metric.column.key);
    data.has_published(&SceneOf::all(), &key).then_some(key)
}

/// Whether a column has a best method anywhere.
fn tells_apart(data: &Data, column: &Column) -> bool {
    let cases = data
        .scenes
        .iter()
        .flat_map(|s| data.points().iter().map(move |p| (s, p)));
    cases.into_iter().any(|(scene, point)| {
        let column = column_of(data, scene, point, column, &mut Vec::new());
        column
            .iter()
            .any(|(_, standing)| *standing == Standing::Best)
    })
}

/// The rank of each method, averaged over the scenes: among the methods that have a value in every scene with
/// every seed; the others have no rank.
fn mean_ranks(data: &Data, point: &Swept, column: &Column) -> Vec<Cell> {
    let lower = column.lower_is_better.unwrap_or(true);
    let by_scene: Vec<Vec<Option<Estimate>>> = data
        .expected(point)
        .map(|scene| {
            let column = column_of(data, scene, point, column, &mut Vec::new());
            let estimates = column.into_iter().map(|(estimate, _)| estimate);
            estimates.map(|e| e.filter(Estimate::is_whole)).collect()
        })
        .collect();
    let everywhere = |method: &usize| by_scene.iter().all(|scene| scene[*method].is_some());
    let ranked: Vec<usize> = (0..data.labels().len()).filter(everywhere).collect();
    let mut sums = vec![None; data.labels().len()];
    for scene in &by_scene {
        let rivals: Vec<Option<&Estimate>> = ranked.iter().map(|m| scene[*m].as_ref()).collect();
        for (method, rank) in ranked.iter().zip(ranks(&rivals, lower).unwrap_or_default()) {
            *sums[*method].get_or_insert(0.0) += rank;
        }
    }
    let means: Vec<Option<Estimate>> = sums
        .iter()
        .map(|sum| Estimate::exact((*sum)? / by_scene.len() as f64))
        .collect();
    let rivals: Vec<Option<&Estimate>> = means.iter().map(Option::as_ref).collect();
    let marks = standings(&rivals, true);
    means
        .iter()
        .zip(marks)
        .map(|(mean, standing)| {
            mean.as_ref().map_or_else(Cell::empty, |m| Cell {
                text: format!("{:.2}", m.mean),
                standing,
                published: false,
            })
        })
        .collect()
}

/// One line a method, columns the swept values, a block for each scene and metric.
fn sweep(data: &Data, spec: &TableSpec) -> Table {
    let mut table = start(spec, "Method");
    table.groups.push(Group {
        heading: data.points()[0].keys(),
        columns: data.points().iter().map(Swept::short).collect(),
    });
    for scene in &data.scenes {
        for key in &spec.metrics {
            let metric = Metric::new(data, key);
            let mut lines = lines_of(data.labels());
            for point in data.points() {
                let column = column_of(data, scene, point, &metric.column, &mut table.records);
                for (line, (estimate, standing)) in lines.iter_mut().zip(column) {
                    line.cells
                        .push(ours(estimate.as_ref(), standing, &metric.style));
                }
            }
            for label in data.labels() {
                let values = data
                    .points()
                    .iter()
                    .map(|p| data.published(asked(scene, label, p), key));
                let values: Vec<Option<f64>> = values.collect();
                if values.iter().any(Option::is_some) {
                    lines.push(Line {
                        heading: format!("{label} (paper)"),
                        cells: values
                            .into_iter()
                            .map(|v| theirs(v, &metric.style))
                            .collect(),
                    });
                }
            }
            table.blocks.push(Block {
                heading: format!("{} · {}", scene.title(), metric.heading()),
                lines,
            });
        }
    }
    notes(data, &mut table);
    table
}

/// A table without lines.
pub(super) fn start(spec: &TableSpec, corner: &str) -> Table {
    Table {
        file: escape::file_name(&spec.name),
        title: if spec.title.is_empty() {
            spec.name.clone()
        } else {
            spec.title.clone()
        },
        corner: corner.into(),
        ..Table::default()
    }
}

fn lines_of(labels: &[String]) -> Vec<Line> {
    labels
        .iter()
        .map(|label| Line {
            heading: label.clone(),
            cells: Vec::new(),
        })
        .collect()
}

/// Over how many seeds the intervals of a table, called `interval`, are; or why there are none.
pub(super) fn repeats_note(table: &Table, interval: &str) -> String {
    let repeats = table
        .records
        .iter()
        .filter_map(|r| r.estimate.as_ref())
        .map(Estimate::repeats);
    match repeats.fold((usize::MAX, 0), |(a, b), n| (a.min(n), b.max(n))) {
        (_, 0) => "No finished job has these values.".to_owned(),
        (_, 1) => "One run each; no interval.".to_owned(),
        (a, b) if a == b => format!("{interval} over {b} seeds."),
        (a, b) => format!("{interval} over {a} to {b} seeds."),
    }
}

/// What cells with fewer seeds than are expected are, if there are some.
pub(super) fn lacking_note(table: &Table) -> Option<String> {
    let mut estimates = table.records.iter().filter_map(|r| r.estimate.as_ref());
    let lacks = estimates.any(|e| !e.is_whole());
    lacks.then(|| {
        "(n of m seeds): runs with the others failed, are missing or have no such value; what lacks a seed is no rival          in its column, and no data in means over scenes, ranks, claims and gates."
            .to_owned()
    })
}

/// How to read the numbers: what is in the table decides what is said.
pub(super) fn notes(data: &Data, table: &mut Table) {
    let cells: Vec<&Cell> = table
        .blocks
        .iter()
        .flat_map(|b| &b.lines)
        .flat_map(|l| &l.cells)
        .collect();
    let mut notes = vec![repeats_note(table, "Mean ± 95 % confidence interval")];
    if cells.iter().any(|c| c.standing == Standing::Best) {
        let tied = cells.iter().any(|c| c.standing == Standing::Tied);
        let tied = if tied {
            "; italic: not distinguishable from it (95 %, paired by seed)"
        } else {
            ""
        };
        notes.push(format!("Bold: best of its column{tied}."));
    }
    if cells.iter().any(|c| c.published) {
        let all = SceneOf::all();
        let mut places: Vec<&str> = data.places_of(&all);
        places.extend(data.scenes.iter().flat_map(|s| data.places_of(s)));
        places.sort_unstable();
        places.dedup();
        notes.push(format!(
            "paper: as printed ({}), on the authors' scenes, sizes and machine.",
            places.join(", ")
        ));
    }
    notes.extend(lacking_note(table));
    let empty = |c: &&Cell| c.text == super::table::NOTHING && !c.published;
    if table.records.iter().any(|r| r.estimate.is_some()) && cells.iter().any(empty) {
        notes.push("—: no value (no such stage, or a run of it failed or is missing).".into());
    }
    table.notes = notes;
}
