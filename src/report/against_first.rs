//! Each method against the first: error at the same budgets or at equal cost, or cost at equal error, where its
//! curve over the swept budgets costs, or errs, as much as the first method did.

use super::data::{Asked, Data, SceneOf};
use super::estimate::{Estimate, Standing, standings};
use super::table::{Block, Cell, Group, Line, Record, Table};
use super::table_kinds::repeats_note;
use crate::experiment::Column;
use crate::experiment::{Swept, TableKind, TableSpec};

/// What is held equal and what is compared, of a method at each swept budget, as logarithms.
type Curve = Vec<(f64, f64)>;

/// The columns of a curve: what is held equal (`None`: the budget) and what is compared.
#[derive(Clone, Copy)]
struct Axes<'a> {
    held: Option<&'a str>,
    compared: &'a str,
}

/// Half widths of logarithms up to this are those of equal ratios.
const ROUNDING: f64 = 1e-12;

/// One line a method, columns scene × metric. [`TableKind::Change`] and [`TableKind::EqualCost`]: how much
/// larger or smaller its error is than that of the first method at the same budget, or at the same cost, in per
/// cent. [`TableKind::EqualError`]: its cost where it errs as much as the first method, in costs of that.
///
/// Ratios are formed seed by seed, and their interval is that of the mean of their logarithms. Between
/// budgets curves are interpolated linearly in logarithms; where a curve does not reach what the first method
/// has nothing is said, nothing is extrapolated. Over several of its budgets, and over all scenes, ratios are
/// averaged geometrically; over all scenes nothing is said where one of them has no ratio.
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
            let ratios: Vec<Option<Estimate>> = data
                .labels()
                .iter()
                .map(|label| mean_ratio(data, scenes, label, axes))
                .collect();
            let rivals: Vec<Option<&Estimate>> = ratios.iter().map(Option::as_ref).collect();
            let lower = spec.kind == TableKind::EqualError || error.lower_is_better != Some(false);
            let marks = standings(&rivals, lower);
            for (((label, line), ratio), standing) in
                data.labels().iter().zip(&mut lines).zip(&ratios).zip(marks)
            {
                line.cells.push(cell(ratio.as_ref(), spec.kind, standing));
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
                    estimate: ratio.as_ref().and_then(|ratio| told(ratio, spec.kind)),
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
    table.notes = notes(data, &table, (spec.kind, &cost.heading));
    table
}

/// A logarithm of a ratio as the ratio, or as a change in per cent.
fn shown(logarithm: f64, kind: TableKind) -> f64 {
    match kind {
        TableKind::EqualError => logarithm.exp(),
        _ => 100.0 * logarithm.exp_m1(),
    }
}

/// `-33.3 [-35.0, -31.5]`: the ratio and the ends of its interval, if it has one.
fn cell(ratio: Option<&Estimate>, kind: TableKind, standing: Standing) -> Cell {
    let Some(ratio) = ratio else {
        return Cell::empty();
    };
    let text = |logarithm: f64| match kind {
        TableKind::EqualError => format!("{:.2}", shown(logarithm, kind)),
        _ => format!("{:+.1}", shown(logarithm, kind)),
    };
    let mean = text(ratio.mean);
    Cell {
        text: match ratio.half_width.filter(|half| *half > ROUNDING) {
            Some(half) => {
                let ends = [ratio.mean - half, ratio.mean + half].map(text);
                format!("{mean} [{}, {}]", ends[0], ends[1])
            }
            None => mean,
        },
        standing,
        published: false,
    }
}

/// A ratio for the CSV: its half width is half the length of the interval.
fn told(ratio: &Estimate, kind: TableKind) -> Option<Estimate> {
    let by_seed = ratio.by_seed.iter();
    let told = Estimate::new(by_seed.map(|(seed, v)| (*seed, shown(*v, kind))).collect())?;
    Some(Estimate {
        mean: shown(ratio.mean, kind),
        half_width: ratio
            .half_width
            .map(|half| 0.5 * (shown(ratio.mean + half, kind) - shown(ratio.mean - half, kind))),
        ..told
    })
}

fn notes(data: &Data, table: &Table, (kind, cost): (TableKind, &str)) -> Vec<String> {
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
            "no budget of the two errs as much, or a job of them is missing or failed",
        ),
        _ => (
            format!("Change of the error against {first} at equal {cost}, per cent: {CURVES}."),
            "no budget of the two costs the same, or a job of them is missing or failed",
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
    let marks = format!("Bold: best of its column{tied}. —: {none}.");
    vec![what, interval, marks]
}

/// Logarithm, for each seed, of what a method has over what the first method has where the held columns
/// are equal: the mean over the first method's budgets that the method's curves of all seeds reach, then over
/// scenes. `None` where a scene has none.
fn mean_ratio(data: &Data, scenes: &[SceneOf], label: &str, axes: Axes) -> Option<Estimate> {
    let of_scene = |scene: &SceneOf| ratio(data, scene, (label, axes));
    let ratios: Vec<Estimate> = scenes.iter().map(of_scene).collect::<Option<_>>()?;
    Estimate::mean_of(&ratios)
}

fn ratio(data: &Data, scene: &SceneOf, (label, axes): (&str, Axes)) -> Option<Estimate> {
    let first = data.labels().first()?;
    let of_seed = |seed: &u64| {
        let base = curve(data, scene, first, *seed, axes)?;
        let mut own = curve(data, scene, label, *seed, axes)?;
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ratio = |(at, value): &(f64, f64)| Some(interpolate(&own, *at)? - value);
        Some((*seed, base.iter().map(ratio).collect::<Vec<_>>()))
    };
    let by_seed: Vec<(u64, Vec<Option<f64>>)> =
        data.cases.seeds.iter().filter_map(of_seed).collect();
    let budgets = by_seed.first()?.1.len();
    let reached = |budget: &usize| by_seed.iter().all(|(_, ratios)| ratios[*budget].is_some());
    let reached: Vec<usize> = (0..budgets).filter(reached).collect();
    let mean = |ratios: &[Option<f64>]| {
        let sum: f64 = reached.iter().filter_map(|budget| ratios[*budget]).sum();
        sum / reached.len() as f64
    };
    Estimate::new(by_seed.iter().map(|(seed, r)| (*seed, mean(r))).collect())
        .filter(|_| !reached.is_empty())
}

/// A method's curve with one seed, in the order of the budgets; `None` where a budget has no result.
fn curve(data: &Data, scene: &SceneOf, label: &str, seed: u64, axes: Axes) -> Option<Curve> {
    let place = |(budget, point): (usize, &Swept)| {
        let case = data.case(Asked {
            scene,
            label,
            point,
        });
        let logarithm = |column: &str| {
            let value = data.cases.value(&case, seed, column)?;
            (value > 0.0).then(|| value.ln())
        };
        let held = match axes.held {
            Some(column) => logarithm(column)?,
            None => budget as f64,
        };
        Some((held, logarithm(axes.compared)?))
    };
    let points = data.points().iter().enumerate();
    points
        .filter(|(_, point)| data.cases.expects(&scene.place, point))
        .map(place)
        .collect()
}

/// The value of a curve, `None` outside of it.
fn interpolate(curve: &[(f64, f64)], at: f64) -> Option<f64> {
    if let Some((_, value)) = curve.iter().find(|(held, _)| *held == at) {
        return Some(*value);
    }
    let after = curve.iter().position(|(held, _)| *held > at)?;
    let ((a, from), (b, to)) = (*curve.get(after.checked_sub(1)?)?, curve[after]);
    Some(from + (to - from) * (at - a) / (b - a))
}

#[cfg(test)]
mod tests {
    use super::interpolate;

    #[test]
    fn curves_are_read_between_their_ends_only() {
        let curve = vec![(0.0, 4.0), (1.0, 2.0), (3.0, 1.0)];
        assert_eq!(interpolate(&curve, 1.0), Some(2.0));
        assert_eq!(interpolate(&curve, 2.0), Some(1.5));
        assert_eq!(interpolate(&curve, -0.1), None);
        assert_eq!(interpolate(&curve, 3.1), None);
        assert_eq!(interpolate(&[], 0.0), None);
    }
}
