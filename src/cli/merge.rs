//! `merge`: the union of shards.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use super::args::MergeArgs;
use super::exit::{self, Failure};
use super::out;
use crate::experiment::{Plan, Store};

/// Copies every finished job once, unites the plans and rebuilds the report.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    let stores = args
        .folders
        .iter()
        .map(|folder| Store::open(folder))
        .collect::<Result<Vec<_>, _>>()?;
    let plans = stores
        .iter()
        .map(Store::plan)
        .collect::<Result<Vec<Plan>, _>>()?;
    let mut united = plans[0].clone();
    if let Some(other) = plans.iter().find(|p| p.name != united.name) {
        return Err(Failure::usage(format!(
            "these are different experiments: `{}` and `{}`",
            united.name, other.name
        )));
    }
    let mut seen = HashSet::new();
    united.jobs = plans.into_iter().flat_map(|p| p.jobs).collect();
    united
        .jobs
        .retain(|job| seen.insert((job.id.clone(), job.label.clone())));
    let target = Store::create(&args.out)?;
    for store in &stores {
        for job in united.jobs.iter().filter(|j| store.row(&j.id).is_some()) {
            let place = target.job_folder(&job.id);
            if !place.exists() {
                copy_folder(&store.job_folder(&job.id), &place)?;
            }
        }
    }
    fs::copy(
        stores[0].folder.join("config.json"),
        args.out.join("config.json"),
    )?;
    target.write("plan.json", &serde_json::to_string_pretty(&united)?)?;
    target.write_rows(&target.rows(&united))?;
    let written = crate::report::write(&args.out)?;
    out::write(written.summary);
    Ok(exit::OK)
}

fn copy_folder(from: &Path, to: &Path) -> std::io::Result<()> {
    let unfinished = to.with_file_name(format!(
        ".unfinished-{}",
        to.file_name().unwrap_or_default().to_string_lossy()
    ));
    fs::create_dir_all(&unfinished)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        fs::copy(entry.path(), unfinished.join(entry.file_name()))?;
    }
    fs::rename(unfinished, to)
}
