//! `diff`: the same jobs in two runs: what changed, and whether significantly.

use super::args::DiffArgs;
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{Row, Store};
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

/// One contender on one scene and one combination of swept values.
type Group = (String, String, String);

/// Pairs rows by scene, label, sweep and seed, and prints mean relative changes.
pub fn run(args: &DiffArgs) -> Result<u8, Failure> {
    let rows = |folder| -> Result<Vec<Row>, Failure> {
        let store = Store::open(folder)?;
        Ok(store.rows(&store.plan()?))
    };
    let (before, after) = (rows(&args.before)?, rows(&args.after)?);
    let mut groups: Vec<Group> = Vec::new();
    for row in before.iter().filter(|r| partner(r, &after).is_some()) {
        if !groups.contains(&group(row)) {
            groups.push(group(row));
        }
    }
    if groups.is_empty() {
        return Err(Failure::nothing(
            "the two folders have no job in common (same scene, label, sweep and seed)",
        ));
    }
    let mut changed = 0;
    for name in &groups {
        let pairs: Vec<(&Row, &Row)> = before
            .iter()
            .filter(|r| group(r) == *name)
            .filter_map(|r| Some((r, partner(r, &after)?)))
            .collect();
        let lines: Vec<String> = COLUMNS.iter().filter_map(|c| change(c, &pairs)).collect();
        changed += usize::from(!lines.is_empty());
        if !lines.is_empty() {
            say!("{} {} {}", name.0, name.1, name.2);
            lines.iter().for_each(|line| say!("  {line}"));
        }
    }
    say!("{} contenders in common, {changed} changed", groups.len());
    Ok(exit::OK)
}

fn group(row: &Row) -> Group {
    let sweep = serde_json::Value::Object(row.sweep.clone()).to_string();
    (row.scene.clone(), row.label.clone(), sweep)
}

fn partner<'a>(row: &Row, others: &'a [Row]) -> Option<&'a Row> {
    others
        .iter()
        .find(|o| o.seed == row.seed && group(o) == group(row))
}

/// One column's change; `None` if it is the same in all pairs.
fn change(column: &str, pairs: &[(&Row, &Row)]) -> Option<String> {
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
    let significance = match Summary::of(&differences).and_then(|s| s.half_width) {
        None => "one pair".to_owned(),
        Some(half) if (b - a).abs() > half => format!("significant, ±{half:.2e}"),
        Some(half) => format!("within noise, ±{half:.2e}"),
    };
    Some(format!(
        "{column:<14} {a:.6} → {b:.6} ({:+.2} %), {significance}",
        100.0 * (b - a) / a
    ))
}
