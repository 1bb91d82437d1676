//! Tables of each method against the first: error at the same budgets or at equal cost, or cost at equal error.

use super::data::{Data, SceneOf};
use super::estimate::{Estimate, Standing, standings};
use super::number::lacking;
use super::ratio::{Axes, NoRatio, Ratio, mean_ratio};
use super::table::{Block, Cell, Group, Line, NOTHING, Record, Table};
use super::table_kinds::{lacking_note, repeats_note};
use crate::experiment::{Column, TableKind, TableSpec, Unit};

/// Half widths of logarithms up to this are those of equal ratios.
const ROUNDING: f64 = 1e-12;

/// One line a method, columns scene × metric. [`TableKind::Change`] and [`TableKind::EqualCost`]: how much
/// larger or smaller its error is than that of the first method at the same budget, or at the same cost, in per
/// cent. [`TableKind::EqualError`]: its cost where it errs as much as the first method, in costs of that.
///
/// Nothing is best in a column in which a method has no ratio.
pub fn against_first(data: &Data, spec: &TableSpec, mut table: Table) -> Table {
    let cost = Column::of(&spec.cost);
    let mut lines: Vec<Line> = data
        .labels()
        .iter()
        .map(|label| Line {
            heading: label.clone(),
            cells: Vec::new(),
        })
        .collect();
    let every: Vec<&[SceneOf]> = data.scenes.chunks(1).collect();
    let together = (data.scenes.len() > 1).then_some(&data.scenes[..]);
    for scenes in every.into_iter().chain(together) {
        let scene = match scenes {
            [scene] => scene.clone(),
            _ => SceneOf::all(),
        };
        let mut columns = Vec::new();
        for key in &spec.metrics {
            let error = Column::of(key);
            columns.push(match spec.kind {
                TableKind::EqualError => format!("at equal {}, ×", error.heading),
                _ => format!("{}, %", error.heading),
            });
            let (held, compared) = match spec.kind {
                TableKind::Change => (None, key),
                TableKind::EqualError => (Some(key.as_str()), &spec.cost),
                _ => (Some(spec.cost.as_str()), key),
            };
            let axes = Axes { held, compared };
            let ratios: Vec<Result<Ratio, NoRatio>> = data
                .labels()
                .iter()
                .map(|label| mean_ratio(data, scenes, label, axes))
                .collect();
            let judged = Column::of(compared);
            let is_wall_time = judged.unit == Unit::Seconds && judged.lower_is_better.is_none();
            let marks = match is_wall_time {
                true => vec![Standing::Plain; ratios.len()],
                false => marks(&ratios, judged.lower_is_better.unwrap_or(true)),
            };
            for (((label, line), ratio), standing) in
                data.labels().iter().zip(&mut lines).zip(&ratios).zip(marks)
            {
                line.cells.push(Cell {
                    text: match ratio {
                        Ok(ratio) => text(ratio, spec.kind),
                        Err(why) => without(*why).to_owned(),
                    },
                    standing,
                    published: false,
                });
                let ratio = ratio.as_ref().ok();
                table.records.push(Record {
                    scene: scene.name.clone(),
                    paper_scene: scene.paper.clone(),
                    sweep: String::new(),
                    method: label.clone(),
                    metric: match spec.kind {
                        TableKind::Change => format!("{key}, change in per cent"),
                        TableKind::EqualError => format!("{} at equal {key}, ratio", cost.key),
                        _ => format!("{key} at equal {}, change in per cent", cost.key),
                    },
                    estimate: ratio.and_then(|ratio| told(&ratio.logarithm, spec.kind)),
                    ends: ratio.and_then(|ratio| ends(&ratio.logarithm, spec.kind)),
                    budgets: ratio.map(|ratio| ratio.budgets),
                    published: None,
                    standing,
                });
            }
        }
        table.groups.push(Group {
            heading: scene.title(),
            columns,
        });
    }
    table.blocks.push(Block {
        heading: String::new(),
        lines,
    });
    table.notes = notes(data, &table, spec.kind, &cost.heading);
    table
}

/// A logarithm of a ratio as the ratio, or as a change in per cent.
fn shown(logarithm: f64, kind: TableKind) -> f64 {
    match kind {
        TableKind::EqualError => logarithm.exp(),
        _ => 100.0 * logarithm.exp_m1(),
    }
}

/// How the ratios of a column stand; all are plain where one lacks or lacks a seed.
fn marks(ratios: &[Result<Ratio, NoRatio>], lower_is_better: bool) -> Vec<Standing> {
    let rivals = ratios.iter().map(|ratio| {
        let logarithm = &ratio.as_ref().ok()?.logarithm;
        Some(logarithm).filter(|logarithm| logarithm.is_whole())
    });
    let rivals: Vec<Option<&Estimate>> = rivals.collect();
    match rivals.iter().all(Option::is_some) {
        true => standings(&rivals, lower_is_better),
        false => vec![Standing::Plain; rivals.len()],
    }
}

/// What stands where there is no ratio.
fn without(why: NoRatio) -> &'static str {
    match why {
        NoRatio::Below => "below all",
        NoRatio::Above => "above all",
        NoRatio::NoData => NOTHING,
    }
}

/// The ends of the interval of a ratio, if it has one.
fn ends(logarithm: &Estimate, kind: TableKind) -> Option<[f64; 2]> {
    let half = logarithm.half_width?;
    Some([logarithm.mean - half, logarithm.mean + half].map(|end| shown(end, kind)))
}

/// `-33.3 [-35.0, -31.5] (2 of 5)`: the ratio, the ends of its interval, if it has one, and how many budgets it rests
/// on, where these are not all.
fn text(ratio: &Ratio, kind: TableKind) -> String {
    let logarithm = &ratio.logarithm;
    let number = |value: f64| match kind {
        TableKind::EqualError => format!("{value:.2}"),
        _ => format!("{value:+.1}"),
    };
    let mean = number(shown(logarithm.mean, kind));
    let is_spread = logarithm.half_width.is_some_and(|half| half > ROUNDING);
    let interval = match ends(logarithm, kind).filter(|_| is_spread) {
        Some([low, high]) => format!(" [{}, {}]", number(low), number(high)),
        None => String::new(),
    };
    let budgets = match ratio.budgets < ratio.of_budgets {
        true => format!(" ({} of {})", ratio.budgets, ratio.of_budgets),
        false => String::new(),
    };
    format!("{mean}{interval}{budgets}{}", lacking(logarithm))
}

/// A ratio for the CSV, where its interval is told by its ends.
fn told(logarithm: &Estimate, kind: TableKind) -> Option<Estimate> {
    let by_seed = logarithm.by_seed.iter();
    let told = Estimate::new(by_seed.map(|(seed, v)| (*seed, shown(*v, kind))).collect())?;
    Some(Estimate {
        mean: shown(logarithm.mean, kind),
        half_width: None,
        expected: logarithm.expected,
        ..told
    })
}

fn notes(data: &Data, table: &Table, kind: TableKind, cost: &str) -> Vec<String> {
    const CURVES: &str = "curves over the swept budgets, interpolated linearly in logarithms, never \
                          extrapolated; ratios of each seed, averaged geometrically";
    let first = data.labels().first().map_or("", String::as_str);
    let (what, none) = match kind {
        TableKind::Change => (
            format!(
                "Change of the error against {first} at the same budgets, per cent: ratios of each seed, \
                 averaged geometrically."
            ),
            "a job of the two is missing or failed",
        ),
        TableKind::EqualError => (
            format!("{cost} at the error of {first}, in those of {first}: {CURVES}."),
            "the curves do not overlap, or a job of the two is missing or failed",
        ),
        _ => (
            format!("Change of the error against {first} at equal {cost}, per cent: {CURVES}."),
            "the curves do not overlap, or a job of the two is missing or failed",
        ),
    };
    let cells = || {
        let lines = table.blocks.iter().flat_map(|b| &b.lines);
        lines.flat_map(|l| &l.cells)
    };
    let tied = match cells().any(|c| c.standing == Standing::Tied) {
        true => "; italic: not distinguishable from it (95 %, paired by seed)",
        false => "",
    };
    let interval = repeats_note(table, "[ ]: 95 % confidence interval of the ratio");
    let mut notes = vec![
        what,
        interval,
        format!("Bold: best of its column{tied}; none where a method has no value. —: {none}."),
    ];
    let has = |text: &str| cells().any(|c| c.text == text);
    if has(without(NoRatio::Below)) || has(without(NoRatio::Above)) {
        let held = match kind {
            TableKind::EqualError => "errs less, or more,",
            _ => "costs less, or more,",
        };
        notes.push(format!(
            "below all, above all: each budget {held} than all those of {first}."
        ));
    }
    let mut records = table.records.iter();
    if kind != TableKind::Change && records.any(|r| r.budgets.is_some()) {
        notes.push(format!(
            "(n of m): how many budgets of {first} the curve reaches, on which the ratio rests, where these are not all."
        ));
    }
    notes.extend(lacking_note(table));
    notes
}
