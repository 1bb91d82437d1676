//! `diff`: the same jobs in two runs: what changed, and whether significantly.

use super::args::DiffArgs;
use super::exit::{self, Failure};
use super::number::{half_width, told};
use super::out::say;
use crate::experiment::{Case, Row, Store};
use crate::metric::statistics::Summary;

const COLUMNS: &[&str] = &[
    "rmse",
    "relmse",
    "flip_ldr",
    "ssim",
    "rays",
    "shadow_rays",
    "lookups",
    "seconds_total",
];

/// Pairs rows of one case by their seeds, and prints mean relative changes.
pub fn run(args: &DiffArgs) -> Result<u8, Failure> {
    let rows = |folder| -> Result<Vec<Row>, Failure> {
        let store = Store::open(folder)?;
        Ok(store.rows(&store.plan()?))
    };
    let (before, after) = (rows(&args.before)?, rows(&args.after)?);
    let mut cases: Vec<Case> = Vec::new();
    for row in before.iter().filter(|r| partner(r, &after).is_some()) {
        let case = Case::of_row(row);
        if !cases.contains(&case) {
            cases.push(case);
        }
    }
    if cases.is_empty() {
        return Err(Failure::nothing(
            "the two folders have no job in common (same scene, view, technique, label, swept values and seed)",
        ));
    }
    let mut changed = 0;
    for case in &cases {
        let pairs: Vec<(&Row, &Row)> = before
            .iter()
            .filter(|r| Case::of_row(r) == *case)
            .filter_map(|r| Some((r, partner(r, &after)?)))
            .collect();
        let changes: Vec<Change> = COLUMNS.iter().filter_map(|c| change(c, &pairs)).collect();
        changed += usize::from(changes.iter().any(|change| !change.is_noise));
        if !changes.is_empty() {
            say!("{case}");
            changes.iter().for_each(|change| say!("  {}", change.line));
        }
    }
    say!(
        "{} contenders in common, {changed} changed beyond noise",
        cases.len()
    );
    Ok(exit::OK)
}

fn partner<'a>(row: &Row, others: &'a [Row]) -> Option<&'a Row> {
    let case = Case::of_row(row);
    others
        .iter()
        .find(|o| o.seed == row.seed && Case::of_row(o) == case)
}

/// A column's change, as it is printed.
struct Change {
    line: String,
    /// Whether it lies within the interval over seeds.
    is_noise: bool,
}

/// One column's change; `None` if it is the same in all pairs.
fn change(column: &str, pairs: &[(&Row, &Row)]) -> Option<Change> {
    let values: Vec<(f64, f64)> = pairs
        .iter()
        .filter_map(|(a, b)| Some((a.number(column)?, b.number(column)?)))
        .collect();
    if values.is_empty() || values.iter().all(|(a, b)| a == b) {
        return None;
    }
    let mean =
        |side: fn(&(f64, f64)) -> f64| values.iter().map(side).sum::<f64>() / values.len() as f64;
    let (a, b) = (mean(|v| v.0), mean(|v| v.1));
    let differences: Vec<f64> = values.iter().map(|(a, b)| b - a).collect();
    let half = Summary::of(&differences).and_then(|s| s.half_width);
    let is_noise = half.is_some_and(|half| (b - a).abs() <= half);
    let significance = match half {
        None => "one pair".to_owned(),
        Some(half) if is_noise => format!("within noise, {}", half_width(half)),
        Some(half) => format!("significant, {}", half_width(half)),
    };
    let line = format!(
        "{column:<14} {} → {} ({:+.2} %), {significance}",
        told(a),
        told(b),
        100.0 * (b - a) / a
    );
    Some(Change { line, is_noise })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_of_a_scene_are_compared_each_with_its_own() {
        let seen = |view: &str, rmse: f64| Row {
            scene: "kitchen".into(),
            view: view.into(),
            rmse: Some(rmse),
            ..Row::default()
        };
        let after = [seen("top", 0.1), seen("front", 0.3)];
        let partner = partner(&seen("front", 0.3), &after).expect("there");
        assert_eq!(partner.rmse, Some(0.3));
        assert!(super::partner(&seen("back", 0.3), &after).is_none());
    }
}
