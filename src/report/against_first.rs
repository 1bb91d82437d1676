//! Each method against the first: error at the same budgets or at equal cost, or cost at equal error, where its
//! curve over the swept budgets costs, or errs, as much as the first method did.

use super::data::{Case, Data, SceneOf};
use super::estimate::{Estimate, Standing};
use super::table::{Block, Cell, Group, Line, Record, Table};
use crate::experiment::Column;
use crate::experiment::{TableKind, TableSpec};

/// What is held equal and what is compared, of a method at each swept budget, as logarithms, by rising
/// first number.
type Curve = Vec<(f64, f64)>;

/// One line a method, columns scene × metric. [`TableKind::Change`] and [`TableKind::EqualCost`]: how much
/// larger or smaller its error is than that of the first method at the same budget, or at the same cost, in per
/// cent. [`TableKind::EqualError`]: its cost where it errs as much as the first method, in costs of that.
///
/// Between budgets curves are interpolated linearly in logarithms; where a curve
/// does not reach what the first method has nothing is said, nothing is extrapolated. Over several of
/// its budgets, and over all scenes, ratios are averaged geometrically.
pub fn against_first(data: &Data, spec: &TableSpec, mut table: Table) -> Table {
    let cost = Column::of(&spec.cost);
    let is_of_error = spec.kind != TableKind::EqualError;
    let mut lines: Vec<Line> = data
        .labels
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
            let error = Column::of(key).heading;
            columns.push(match is_of_error {
                true => format!("{error}, %"),
                false => format!("at equal {error}, ×"),
            });
            let axes = match spec.kind {
                TableKind::Change => [None, Some(key.as_str())],
                TableKind::EqualError => [Some(key.as_str()), Some(spec.cost.as_str())],
                _ => [Some(spec.cost.as_str()), Some(key.as_str())],
            };
            let ratios: Vec<Option<f64>> = data
                .labels
                .iter()
                .map(|label| mean_ratio(data, scenes, (label, axes)))
                .collect();
            let best = ratios.iter().flatten().copied().reduce(f64::min);
            for ((label, line), ratio) in data.labels.iter().zip(&mut lines).zip(ratios) {
                let change = ratio.map(|ratio| match is_of_error {
                    true => 100.0 * ratio.exp_m1(),
                    false => ratio.exp(),
                });
                let standing = match ratio {
                    Some(_) if ratio == best && data.labels.len() > 1 => Standing::Best,
                    _ => Standing::Plain,
                };
                line.cells
                    .push(change.map_or_else(Cell::empty, |change| Cell {
                        text: match is_of_error {
                            true => format!("{change:+.1}"),
                            false => format!("{change:.2}"),
                        },
                        standing,
                        published: false,
                    }));
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
                    estimate: change.and_then(Estimate::exact),
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
    table.notes = notes(data, spec.kind, &cost.heading);
    table
}

fn notes(data: &Data, kind: TableKind, cost: &str) -> Vec<String> {
    const CURVES: &str = "curves over the swept budgets, interpolated linearly in logarithms, never \
                          extrapolated; ratios averaged geometrically";
    let first = data.labels.first().map_or("", String::as_str);
    let (what, none) = match kind {
        TableKind::Change => (
            format!(
                "Change of the mean error against {first} at the same budgets, per cent: ratios averaged \
                 geometrically."
            ),
            "no budget of the two",
        ),
        TableKind::EqualError => (
            format!("{cost} at the error of {first}, in those of {first}: {CURVES}."),
            "no budget of the two errs as much",
        ),
        _ => (
            format!("Change of the error against {first} at equal {cost}, per cent: {CURVES}."),
            "no budget of the two costs the same",
        ),
    };
    vec![what, format!("Bold: best of its column. —: {none}.")]
}

/// Mean logarithm of what a method has over what the first method has, in the second of the columns
/// `axes`, where the first is equal (`None`: the budget): over scenes and the first method's budgets that the method's curve
/// reaches.
fn mean_ratio(
    data: &Data,
    scenes: &[SceneOf],
    (label, axes): (&str, [Option<&str>; 2]),
) -> Option<f64> {
    let first = data.labels.first()?;
    let mut means = Vec::new();
    for scene in scenes {
        let base = curve(data, scene, (first, axes));
        let own = curve(data, scene, (label, axes));
        let ratios: Vec<f64> = base
            .iter()
            .filter_map(|(at, value)| Some(interpolate(&own, *at)? - value))
            .collect();
        if !ratios.is_empty() {
            means.push(ratios.iter().sum::<f64>() / ratios.len() as f64);
        }
    }
    (!means.is_empty()).then(|| means.iter().sum::<f64>() / means.len() as f64)
}

fn curve(data: &Data, scene: &SceneOf, (label, axes): (&str, [Option<&str>; 2])) -> Curve {
    let mut curve: Curve = data
        .points
        .iter()
        .enumerate()
        .filter_map(|(budget, point)| {
            let case = || Case {
                scene: &scene.name,
                label,
                point,
            };
            let logarithm = |axis: Option<&str>| {
                let Some(axis) = axis else {
                    return Some(budget as f64);
                };
                let mean = data.estimate(case(), axis)?.mean;
                (mean > 0.0).then(|| mean.ln())
            };
            Some((logarithm(axes[0])?, logarithm(axes[1])?))
        })
        .collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// The value of a curve, `None` outside of it.
fn interpolate(curve: &Curve, at: f64) -> Option<f64> {
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
        assert_eq!(interpolate(&vec![], 0.0), None);
    }
}
