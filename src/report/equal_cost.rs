//! Error at equal cost: each method's error where its curve over the swept budgets costs as much as
//! the first method did.

use super::column::Column;
use super::data::{Case, Data, SceneOf};
use super::estimate::{Estimate, Standing};
use super::table::{Block, Cell, Group, Line, Record, Table};
use crate::experiment::TableSpec;

/// Cost and error of a method at each swept budget, as logarithms, by rising cost.
type Curve = Vec<(f64, f64)>;

/// One line a method, columns scene × metric: how much larger or smaller its error is than that of the
/// first method at the same cost, in per cent.
///
/// Errors between budgets are interpolated along the curve, linearly in logarithms; where a curve
/// does not reach the first method's cost nothing is said, nothing is extrapolated. Over several of
/// its budgets, and over all scenes, ratios are averaged geometrically.
pub fn equal_cost(data: &Data, spec: &TableSpec, mut table: Table) -> Table {
    let cost = Column::of(&spec.cost);
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
            columns.push(format!("{}, %", Column::of(key).heading));
            let ratios: Vec<Option<f64>> = data
                .labels
                .iter()
                .map(|label| mean_ratio(data, scenes, (label, key, &spec.cost)))
                .collect();
            let best = ratios.iter().flatten().copied().reduce(f64::min);
            for ((label, line), ratio) in data.labels.iter().zip(&mut lines).zip(ratios) {
                let change = ratio.map(|ratio| 100.0 * ratio.exp_m1());
                let standing = match ratio {
                    Some(_) if ratio == best && data.labels.len() > 1 => Standing::Best,
                    _ => Standing::Plain,
                };
                line.cells
                    .push(change.map_or_else(Cell::empty, |change| Cell {
                        text: format!("{change:+.1}"),
                        standing,
                        published: false,
                    }));
                table.records.push(Record {
                    scene: scene.name.clone(),
                    paper_scene: scene.paper.clone(),
                    sweep: String::new(),
                    method: label.clone(),
                    metric: format!("{key} at equal {}, change in per cent", cost.key),
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
    let first = data.labels.first().map_or("", String::as_str);
    table.notes = vec![
        format!(
            "Change of the error against {first} at equal {}, per cent: curves over the swept budgets, \
             interpolated linearly in logarithms, never extrapolated; ratios averaged geometrically.",
            cost.heading
        ),
        "Bold: best of its column. —: no budget of the two costs the same.".into(),
    ];
    table
}

/// Mean logarithm of a method's error over the first method's at the same cost, over scenes and the
/// first method's budgets that the method's curve reaches.
fn mean_ratio(
    data: &Data,
    scenes: &[SceneOf],
    (label, metric, cost): (&str, &str, &str),
) -> Option<f64> {
    let first = data.labels.first()?;
    let mut means = Vec::new();
    for scene in scenes {
        let base = curve(data, scene, (first, metric, cost));
        let own = curve(data, scene, (label, metric, cost));
        let ratios: Vec<f64> = base
            .iter()
            .filter_map(|(at, error)| Some(interpolate(&own, *at)? - error))
            .collect();
        if !ratios.is_empty() {
            means.push(ratios.iter().sum::<f64>() / ratios.len() as f64);
        }
    }
    (!means.is_empty()).then(|| means.iter().sum::<f64>() / means.len() as f64)
}

fn curve(data: &Data, scene: &SceneOf, (label, metric, cost): (&str, &str, &str)) -> Curve {
    let mut curve: Curve = data
        .points
        .iter()
        .filter_map(|point| {
            let case = || Case {
                scene: &scene.name,
                label,
                point,
            };
            let cost = data.estimate(case(), cost)?.mean;
            let error = data.estimate(case(), metric)?.mean;
            (cost > 0.0 && error > 0.0).then(|| (cost.ln(), error.ln()))
        })
        .collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// The value of a curve, `None` outside of it.
fn interpolate(curve: &Curve, at: f64) -> Option<f64> {
    if let Some((_, error)) = curve.iter().find(|(cost, _)| *cost == at) {
        return Some(*error);
    }
    let after = curve.iter().position(|(cost, _)| *cost > at)?;
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
