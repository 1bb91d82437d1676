//! Parts of a merge that have different jobs for one case and seed, or that ask for different reports.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use super::exit::Failure;
use crate::experiment::{Case, Job, Row, Store};
use crate::standard_error::tell;

/// What became of a job in the parts.
struct Rival<'a> {
    job: &'a Job,
    /// Its finished row, else its failed one, and the folder of it; none where no part has a row.
    found: Option<(Row, &'a Path)>,
}

impl<'a> Rival<'a> {
    fn of(job: &'a Job, parts: &'a [Store]) -> Self {
        let row_in = |part: &'a Store| Some((part.row(&job.id)?, part.folder.as_path()));
        let mut found: Option<(Row, &Path)> = None;
        for other in parts.iter().filter_map(row_in) {
            let is_better = |kept: &(Row, &Path)| other.0.ok() && !kept.0.ok();
            if found.as_ref().is_none_or(is_better) {
                found = Some(other);
            }
        }
        Self { job, found }
    }

    fn finished(&self) -> bool {
        self.found.as_ref().is_some_and(|(row, _)| row.ok())
    }

    /// `job 1f… (caches=60) in results/a`.
    fn text(&self) -> String {
        let Job { id, budget, .. } = self.job;
        match &self.found {
            Some((_, folder)) => format!("job {id} ({budget}) in {}", folder.display()),
            None => format!("job {id} ({budget}), which has no row"),
        }
    }
}

/// Leaves one job of each case and seed, as tables have room for one: the finished one.
///
/// # Errors
/// Two finished ones, with their folders.
pub fn leave_one_of_each(jobs: &mut Vec<Job>, parts: &[Store]) -> Result<(), Failure> {
    let mut groups: HashMap<(Case, u64), Vec<&Job>> = HashMap::new();
    for job in jobs.iter() {
        let group = groups.entry((Case::of_job(job), job.seed)).or_default();
        if group.iter().all(|other| other.id != job.id) {
            group.push(job);
        }
    }
    // By their places: another label may share the job.
    let mut left_out = HashSet::new();
    for job in jobs.iter() {
        let Some(group) = groups.remove(&(Case::of_job(job), job.seed)) else {
            continue;
        };
        if group.len() > 1 {
            let rivals: Vec<Rival> = group.iter().map(|job| Rival::of(job, parts)).collect();
            let kept = the_one(&rivals)?;
            for rival in rivals.iter().filter(|rival| rival.job.id != kept.job.id) {
                tell_of(rival, kept);
                left_out.insert(rival.job.place());
            }
        }
    }
    jobs.retain(|job| !left_out.contains(&job.place()));
    Ok(())
}

/// The finished one of several, else one that failed, else the first.
fn the_one<'r, 'a>(rivals: &'r [Rival<'a>]) -> Result<&'r Rival<'a>, Failure> {
    let finished: Vec<&Rival> = rivals.iter().filter(|rival| rival.finished()).collect();
    if let [first, second, ..] = finished[..] {
        return Err(Failure::usage(format!(
            "{}, seed {} has two results: {} and {}. They are of different settings or of different versions of the \
             scene: merge folders of one experiment alone, or give the scene or method another `label` and run it again",
            Case::of_job(first.job),
            first.job.seed,
            first.text(),
            second.text()
        )));
    }
    let failed = rivals.iter().find(|rival| rival.found.is_some());
    Ok(finished.first().copied().or(failed).unwrap_or(&rivals[0]))
}

fn tell_of(left_out: &Rival, kept: &Rival) {
    let row = match &left_out.found {
        Some(_) => "the failed row of ",
        None => "",
    };
    let (left_out, kept, case) = (left_out.text(), kept.text(), Case::of_job(kept.job));
    tell!("warning: {row}{left_out} is left out: {case} is taken of {kept}");
}

/// Says where a part asks for other gates, claims, tables or figures than the first one, whose are taken.
pub fn tell_of_other_reports(parts: &[Store]) {
    let asked = |part: &Store| {
        let config = serde_json::to_value(part.config().ok()?).ok()?;
        Some(["gate", "claim", "table", "figure"].map(|key| config[key].clone()))
    };
    let Some((first, ours)) = parts.first().and_then(|p| Some((p, asked(p)?))) else {
        return;
    };
    for (part, theirs) in parts.iter().filter_map(|p| Some((p, asked(p)?))) {
        let names = ["gates", "claims", "tables", "figures"];
        let differing = (0..names.len()).filter(|&i| ours[i] != theirs[i]);
        let differing: Vec<&str> = differing.map(|i| names[i]).collect();
        if !differing.is_empty() {
            let [ours, theirs] = [first, part].map(|store| store.folder.display());
            let differing = differing.join(", ");
            tell!("note: {differing} of {theirs} differ from those of {ours}, which are taken");
        }
    }
}
