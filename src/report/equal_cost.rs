//! Error at equal cost, or cost at equal error: where each method's curve over the swept budgets costs, or
//! errs, as much as the first method did.

use super::column::Column;
use super::data::{Case, Data, SceneOf};
use super::estimate::{Estimate, Standing};
use super::table::{Block, Cell, Group, Line, Record, Table};
use crate::experiment::{TableKind, TableSpec};

/// What is held equal and what is compared, of a method at each swept budget, as logarithms, by rising
/// first number.
type Curve = Vec<(f64, f64)>;

/// One line a method, columns scene × metric. [`TableKind::EqualCost`]: how much larger or smaller its
/// error is than that of the first method at the same cost, in per cent. [`TableKind::EqualError`]: its
/// cost where it errs as much as the first method, in costs of that.
///
/// Between budgets curves are interpolated linearly in logarithms; where a curve
/// does not reach what the first method has nothing is said, nothing is extrapolated. Over several of
/// its budgets, and over all scenes, ratios are averaged geometrically.
pub fn equal_cost(data: &Data, spec: &TableSpec, mut table: Table) -> Table {
    let cost = Column::of(&spec.cost);
    let is_cost_equal = spec.kind == TableKind::EqualCost;
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
            columns.push(match is_cost_equal {
                true => format!("{error}, %"),
                false => format!("at equal {error}, ×"),
            });
            let axes = match is_cost_equal {
                true => [spec.cost.as_str(), key],
                false => [key, spec.cost.as_str()],
            };
            let ratios: Vec<Option<f64>> = data
                .labels
                .iter()
                .map(|label| mean_ratio(data, scenes, (label, axes)))
                .collect();
            let best = ratios.iter().flatten().copied().reduce(f64::min);
            for ((label, line), ratio) in data.labels.iter().zip(&mut lines).zip(ratios) {
                let change = ratio.map(|ratio| match is_cost_equal {
                    true => 100.0 * ratio.exp_m1(),
                    false => ratio.exp(),
                });
                let standing = match ratio {
                    Some(_) if ratio == best && data.labels.len() > 1 => Standing::Best,
                    _ => Standing::Plain,
                };
                line.cells
                    .push(change.map_or_else(Cell::empty, |change| Cell {
                        text: match is_cost_equal {
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
                    metric: match is_cost_equal {
                        true => format!("{key} at equal {}, change in per cent", cost.key),
                        false => format!("{} at equal {key}, ratio", cost.key),
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
    let first = data.labels.first().map_or("", String::as_str);
    let (what, none) = match is_cost_equal {
        true => (
            format!(
                "Change of the error against {first} at equal {}, per cent",
                cost.heading
            ),
            "no budget of the two costs the same",
        ),
        false => (
            format!(
                "{} at the error of {first}, in those of {first}",
                cost.heading
            ),
            "no budget of the two errs as much",
        ),
    };
    table.notes = vec![
        format!(
            "{what}: curves over the swept budgets, interpolated linearly in logarithms, never \
             extrapolated; ratios averaged geometrically."
        ),
        format!("Bold: best of its column. —: {none}."),
    ];
    table
}

/// Mean logarithm of what a method has over what the first method has, in the second of the columns
/// `axes`, where the first is equal: over scenes and the first method's budgets that the method's curve
/// reaches.
fn mean_ratio(data: &Data, scenes: &[SceneOf], (label, axes): (&str, [&str; 2])) -> Option<f64> {
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

fn curve(data: &Data, scene: &SceneOf, (label, axes): (&str, [&str; 2])) -> Curve {
    let mut curve: Curve = data
        .points
        .iter()
        .filter_map(|point| {
            let case = || Case {
                scene: &scene.name,
                label,
                point,
            };
            let [held, compared] = axes.map(|axis| data.estimate(case(), axis));
            let (held, compared) = (held?.mean, compared?.mean);
            (held > 0.0 && compared > 0.0).then(|| (held.ln(), compared.ln()))
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
