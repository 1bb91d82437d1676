//! `merge`: the union of shards.

use std::collections::{BTreeSet, HashMap, HashSet};

use rayon::prelude::*;

use super::args::MergeArgs;
use super::exit::{self, Failure};
use super::{out, rivals};
use crate::experiment::{Plan, Provenance, ReferenceStore, Row, Store, described};
use crate::standard_error::tell;

/// Takes every job once, finished ones before failed ones, unites the plans and rebuilds the report.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    // What lies in the target is a part of it.
    let target = Some(&args.out).filter(|out| out.join("plan.json").is_file());
    let parts = args.folders.iter().chain(target);
    let stores = parts
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
    let techniques: BTreeSet<&str> = plans
        .iter()
        .flat_map(|plan| &plan.jobs)
        .map(|job| job.technique.as_str())
        .collect();
    if techniques.len() > 1 {
        let techniques: Vec<&str> = techniques.into_iter().collect();
        return Err(Failure::usage(format!(
            "these are experiments of different techniques: {}",
            techniques.join(" and ")
        )));
    }
    let mut seen = HashSet::new();
    united.sharded = plans.iter().filter_map(|plan| plan.sharded).max();
    united.selected_of = plans.iter().filter_map(|plan| plan.selected_of).max();
    united.jobs = plans.into_iter().flat_map(|p| p.jobs).collect();
    let mut repeated = Vec::new();
    united.jobs.retain(|job| {
        let is_new = seen.insert(job.place());
        if !is_new {
            repeated.push(job.id.clone());
        }
        is_new
    });
    rivals::leave_one_of_each(&mut united.jobs, &stores)?;
    rivals::tell_of_other_reports(&stores);
    if united.in_other_shards() > 0 {
        let jobs = united.in_other_shards();
        tell!("note: {jobs} jobs are in shards that are not among these folders");
    }
    // All that is read of the parts is read before anything is written: one of them may be the target.
    let config = stores[0].config_text()?;
    let target = Store::create(&args.out)?;
    let mut provenance = Provenance::of(&target);
    for store in &stores {
        provenance.unite(Provenance::of(store));
    }
    for id in &repeated {
        tell_of_other_results(&target, &stores, id);
    }
    let ids: HashSet<&str> = united.jobs.iter().map(|job| job.id.as_str()).collect();
    let adopted = |id| adopt_best(&target, &stores, id).transpose();
    let rows = ids.into_par_iter().filter_map(adopted);
    let rows: HashMap<String, Row> = rows.collect::<std::io::Result<_>>()?;
    adopt_references(&target, &stores, &united)?;
    target.write("config.json", &config)?;
    provenance.write(&target)?;
    target.write("plan.json", &serde_json::to_string_pretty(&united)?)?;
    let rows = described(&united, |id| rows.get(id).cloned());
    target.write_rows(&rows)?;
    let written = crate::report::write_known(&args.out, united, rows)?;
    out::write(written.summary);
    Ok(exit::OK)
}

/// Says where the target or parts finished the same job with different results, of which the first is taken.
fn tell_of_other_results(target: &Store, parts: &[Store], id: &str) {
    let finished = |part| Some((part, Store::row(part, id).filter(Row::ok)?));
    let all = std::iter::once(target).chain(parts);
    let mut finished = all.filter_map(finished);
    let Some((first, row)) = finished.next() else {
        return;
    };
    for (other, differing) in finished.filter(|(_, other)| other.rmse != row.rmse) {
        let [ours, theirs] = [first, other].map(|store| store.folder.display());
        let [kept, left_out] = [row.rmse, differing.rmse].map(|rmse| rmse.unwrap_or(f64::NAN));
        tell!(
            "warning: job {id} has an RMSE of {kept} in {ours} and of {left_out} in {theirs}: the first is taken"
        );
    }
}

/// Brings the references of the jobs to the store beside the merged folder, where reports look for them.
fn adopt_references(target: &Store, parts: &[Store], plan: &Plan) -> std::io::Result<()> {
    let here = ReferenceStore::beside(&target.folder);
    let there = parts.iter().map(|p| ReferenceStore::beside(&p.folder));
    let mut there: Vec<ReferenceStore> = there.collect();
    // Shards beside one another share theirs.
    there.dedup_by(|a, b| a.folder == b.folder);
    let mut wanted: HashSet<String> = HashSet::new();
    for job in &plan.jobs {
        match job.sequence.is_still() {
            true => _ = wanted.insert(job.reference.clone()),
            false => wanted.extend(target.references_of(&job.id)),
        }
    }
    wanted.retain(|key| !here.path(key).exists());
    wanted.par_iter().try_for_each(|key| {
        let there = there.iter().filter(|store| store.path(key).exists());
        let there: Vec<&ReferenceStore> = there.collect();
        match there.iter().find(|store| store.read(key).is_ok()) {
            Some(sound) => {
                let bytes = std::fs::read(sound.path(key))?;
                crate::files::write(&here.path(key), bytes)?;
            }
            None => there.iter().for_each(|damaged| {
                let path = damaged.path(key);
                tell!(
                    "warning: the reference {} is damaged: left out",
                    path.display()
                );
            }),
        }
        Ok(())
    })
}

/// Takes the job from the first part in which it finished, else from one in which it failed, and gives the row that it
/// has then.
fn adopt_best(target: &Store, parts: &[Store], id: &str) -> std::io::Result<Option<(String, Row)>> {
    let own = target.row(id);
    if own.as_ref().is_some_and(Row::ok) {
        return Ok(own.map(|row| (id.to_owned(), row)));
    }
    let mut failed = None;
    for part in parts {
        match part.row(id) {
            Some(row) if row.ok() => {
                target.adopt(part, id)?;
                return Ok(Some((id.to_owned(), row)));
            }
            Some(row) if failed.is_none() => failed = Some((part, row)),
            _ => {}
        }
    }
    if let (None, Some((part, _))) = (&own, &failed) {
        target.adopt(part, id)?;
    }
    let row = own.or(failed.map(|(_, row)| row));
    Ok(row.map(|row| (id.to_owned(), row)))
}
