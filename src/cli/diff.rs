//! `diff`: the same jobs in two runs: what changed, and whether significantly.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::args::DiffArgs;
use super::exit::{self, Failure};
use super::number::{half_width, told};
use super::out::say;
use crate::experiment::{Case, Plan, Row, Store};
use crate::metric::statistics::Summary;

/// What is compared; of costs, which are judged here, only those that do not change with the number of threads.
const COLUMNS: &[&str] = &[
    "rmse",
    "relmse",
    "flip_ldr",
    "ssim",
    "rays",
    "shadow_rays",
    "lookups",
    "cpu_seconds_total",
];

/// Pairs finished rows of one case by their seeds, and prints mean relative changes.
pub fn run(args: &DiffArgs) -> Result<u8, Failure> {
    let read = |folder: &Path| -> Result<Vec<Planned>, Failure> {
        let store = Store::open(folder)?;
        let plan = store.plan()?;
        Ok(planned(&plan, store.rows(&plan)))
    };
    let (before, after) = (read(&args.before)?, read(&args.after)?);
    let (known, new) = (cases(&before), cases(&after));
    let is_in = |cases: &[Case], case: &Case| cases.contains(case);
    let common: Vec<&Case> = known.iter().filter(|case| is_in(&new, case)).collect();
    if common.is_empty() {
        return Err(Failure::nothing(
            "the two folders have no job in common (same scene, view, technique, label and swept values)",
        ));
    }
    let mut changed = 0;
    for case in &common {
        let compared = Compared::of(case, &before, &after);
        changed += usize::from(compared.is_changed);
        if !compared.lines.is_empty() {
            say!("{case}");
            compared.lines.iter().for_each(|line| say!("  {line}"));
        }
    }
    let mut counts = format!(
        "{} contenders in common, {changed} changed beyond noise or without data",
        common.len()
    );
    for (folder, own, other) in [(&args.before, &known, &new), (&args.after, &new, &known)] {
        let alone: Vec<&Case> = own.iter().filter(|case| !is_in(other, case)).collect();
        for case in &alone {
            say!("{case}\n  only in {}", folder.display());
        }
        if !alone.is_empty() {
            counts += &format!(", {} only in {}", alone.len(), folder.display());
        }
    }
    say!("{counts}");
    Ok(exit::OK)
}

/// A job of one of the folders.
struct Planned {
    case: Case,
    seed: u64,
    /// `None` where it has no result.
    row: Option<Row>,
}

impl Planned {
    fn finished(&self) -> Option<&Row> {
        self.row.as_ref().filter(|row| row.ok())
    }
}

fn planned(plan: &Plan, rows: Vec<Row>) -> Vec<Planned> {
    let mut rows: HashMap<String, Row> =
        rows.into_iter().map(|row| (row.job.clone(), row)).collect();
    let jobs = plan.jobs.iter().map(|job| Planned {
        case: Case::of_job(job),
        seed: job.seed,
        row: rows.remove(&job.id),
    });
    jobs.collect()
}

/// Each case once, in the order of the plan.
fn cases(jobs: &[Planned]) -> Vec<Case> {
    let mut known = HashSet::new();
    let cases = jobs.iter().map(|job| job.case.clone());
    cases.filter(|case| known.insert(case.clone())).collect()
}

/// A case in both folders.
#[derive(Debug, Default)]
struct Compared {
    /// As they are printed; none where all is the same.
    lines: Vec<String>,
    /// Whether it changed beyond noise, or may have: a run of it failed or is missing.
    is_changed: bool,
}

impl Compared {
    /// Of the seeds that both plans have: changes if all of them finished in both, else what is lacking.
    fn of(case: &Case, before: &[Planned], after: &[Planned]) -> Self {
        let of_case = |job: &&Planned| job.case == *case;
        let ours: Vec<&Planned> = before.iter().filter(of_case).collect();
        let theirs: Vec<&Planned> = after.iter().filter(of_case).collect();
        let pairs: Vec<(&Planned, &Planned)> = ours
            .iter()
            .filter_map(|job| Some((*job, *theirs.iter().find(|o| o.seed == job.seed)?)))
            .collect();
        let mut compared = Self::default();
        let lacking = [
            lacking("before", pairs.iter().map(|pair| pair.0)),
            lacking("after", pairs.iter().map(|pair| pair.1)),
        ]
        .concat();
        if pairs.is_empty() || !lacking.is_empty() {
            let none = "no seed in common".to_owned();
            let why = if pairs.is_empty() {
                none
            } else {
                lacking.join("; ")
            };
            compared.lines.push(format!("no data: {why}"));
            compared.is_changed = true;
            return compared;
        }
        let rows: Vec<(&Row, &Row)> = pairs
            .iter()
            .filter_map(|(a, b)| Some((a.finished()?, b.finished()?)))
            .collect();
        if let Some(sizes) = different_sizes(&rows) {
            compared.lines.push(format!("no data: {sizes}"));
            compared.is_changed = true;
            return compared;
        }
        for change in COLUMNS.iter().filter_map(|column| change(column, &rows)) {
            compared.is_changed |= !change.is_noise;
            compared.lines.push(change.line);
        }
        let alone = ours.len() + theirs.len() - 2 * pairs.len();
        if alone > 0 && !compared.lines.is_empty() {
            let paired = pairs.len();
            compared.lines.push(format!(
                "over {paired} seeds; {alone} more are in one plan only"
            ));
        }
        compared
    }
}

/// Says it where images of a pair have different sizes, so that neither their errors nor their costs are of the same.
fn different_sizes(pairs: &[(&Row, &Row)]) -> Option<String> {
    let size = |row: &Row| (row.width, row.height, row.spp);
    let (a, b) = pairs.iter().find(|(a, b)| size(a) != size(b))?;
    let told = |row: &Row| format!("{} × {} × {} samples", row.width, row.height, row.spp);
    Some(format!(
        "images of {} before and of {} after",
        told(a),
        told(b)
    ))
}

/// Which jobs of a case failed or have no result; empty if all finished.
fn lacking<'a>(side: &str, jobs: impl Iterator<Item = &'a Planned>) -> Vec<String> {
    let jobs: Vec<&Planned> = jobs.collect();
    let failed: Vec<&Row> = jobs
        .iter()
        .filter_map(|job| job.row.as_ref())
        .filter(|row| !row.ok())
        .collect();
    let missing = jobs.iter().filter(|job| job.row.is_none()).count();
    let mut lacking = Vec::new();
    if let Some(first) = failed.first() {
        let reason = first.status.trim_start_matches("failed: ");
        let (count, all) = (failed.len(), jobs.len());
        lacking.push(format!("{count} of {all} seeds failed {side}: {reason}"));
    }
    if missing > 0 {
        lacking.push(format!("{missing} of {} seeds missing {side}", jobs.len()));
    }
    lacking
}

/// A column's change, as it is printed.
struct Change {
    line: String,
    /// Whether it lies within the interval over seeds.
    is_noise: bool,
}

/// One column's change; `None` if it is the same in all pairs.
fn change(column: &str, pairs: &[(&Row, &Row)]) -> Option<Change> {
    let numbers = |(a, b): &(&Row, &Row)| (a.number(column), b.number(column));
    if pairs.iter().map(numbers).all(|(a, b)| a == b) {
        return None;
    }
    let values: Vec<(f64, f64)> = pairs
        .iter()
        .map(numbers)
        .filter_map(|(a, b)| Some((a?, b?)))
        .collect();
    if values.len() < pairs.len() {
        let (lacking, all) = (pairs.len() - values.len(), pairs.len());
        return Some(Change {
            line: format!("{column:<17} no data: {lacking} of {all} seeds have no such value"),
            is_noise: false,
        });
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
        "{column:<17} {} → {} ({:+.2} %), {significance}",
        told(a),
        told(b),
        100.0 * (b - a) / a
    );
    Some(Change { line, is_noise })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A job of one contender seen from a view; `Err` why it failed.
    fn job(view: &str, seed: u64, rmse: Result<f64, &str>) -> Planned {
        let row = Row {
            scene: "kitchen".into(),
            view: view.into(),
            seed,
            rmse: rmse.ok(),
            rays: if rmse.is_ok() { 100 } else { 0 },
            status: rmse
                .err()
                .map_or("ok".into(), |why| format!("failed: {why}")),
            ..Row::default()
        };
        Planned {
            case: Case::of_row(&row),
            seed,
            row: Some(row),
        }
    }

    fn compared(before: &[Planned], after: &[Planned]) -> Compared {
        Compared::of(&before[0].case, before, after)
    }

    #[test]
    fn views_of_a_scene_are_compared_each_with_its_own() {
        let after = [job("top", 1, Ok(0.1)), job("front", 1, Ok(0.3))];
        let same = compared(&[job("front", 1, Ok(0.3))], &after);
        assert!(same.lines.is_empty() && !same.is_changed, "{same:?}");
        let other = compared(&[job("top", 1, Ok(0.3))], &after);
        assert!(
            other.is_changed && other.lines[0].starts_with("rmse"),
            "{other:?}"
        );
        assert!(!cases(&after).contains(&job("back", 1, Ok(0.3)).case));
    }

    #[test]
    fn what_failed_is_no_data_and_neither_a_saving_of_rays_nor_left_out_of_means() {
        let whole = || [1, 2, 3].map(|seed| job("top", seed, Ok(0.1)));
        let failing = || {
            let mut jobs = whole();
            jobs[1] = job("top", 2, Err("no memory"));
            jobs
        };
        for (before, after, said) in [
            (
                whole(),
                failing(),
                "no data: 1 of 3 seeds failed after: no memory",
            ),
            (
                failing(),
                whole(),
                "no data: 1 of 3 seeds failed before: no memory",
            ),
        ] {
            let compared = compared(&before, &after);
            assert_eq!(compared.lines, [said]);
            assert!(compared.is_changed);
        }
        let mut unfinished = whole();
        unfinished[0].row = None;
        let missing = compared(&whole(), &unfinished);
        assert_eq!(missing.lines, ["no data: 1 of 3 seeds missing after"]);
    }

    #[test]
    fn images_of_different_sizes_are_not_compared() {
        let before = [job("top", 1, Ok(0.1))];
        let mut after = [job("top", 1, Ok(0.2))];
        after[0].row.as_mut().expect("a row").width = 24;
        let compared = compared(&before, &after);
        assert_eq!(
            compared.lines,
            ["no data: images of 0 × 0 × 0 samples before and of 24 × 0 × 0 samples after"]
        );
        assert!(compared.is_changed);
    }

    #[test]
    fn seeds_of_one_plan_are_told_and_a_value_of_some_seeds_is_no_mean() {
        let one = [job("top", 1, Ok(0.1))];
        let two = [job("top", 1, Ok(0.2)), job("top", 2, Ok(0.2))];
        let lines = compared(&one, &two).lines;
        assert_eq!(lines[1], "over 1 seeds; 1 more are in one plan only");
        assert_eq!(
            compared(&one, &two[1..]).lines,
            ["no data: no seed in common"]
        );
        let mut without = [1, 2].map(|seed| job("top", seed, Ok(0.2)));
        without[0].row.as_mut().expect("a row").rmse = None;
        let lines = compared(&two, &without).lines;
        assert!(
            lines[0].ends_with("no data: 1 of 2 seeds have no such value"),
            "{lines:?}"
        );
    }
}
