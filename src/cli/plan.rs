//! `plan`: the frozen job list; and the selection that `run` shares.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glob::Pattern;

use super::args::{PlanArgs, Selection};
use super::exit::{self, Failure};
use super::out::say;
use super::shard::Shard;
use crate::experiment::{
    Config, Job, JobMemory, Override, Plan, Source, Store, Suite, foresee, plan,
};

/// A planned config and its results folder.
pub struct Planned {
    pub config: Config,
    pub plan: Plan,
    pub folder: PathBuf,
    /// The suite it is part of.
    pub suite: Option<Rc<PlannedSuite>>,
}

/// Experiments that are run as one.
pub struct PlannedSuite {
    pub title: String,
    pub folder: PathBuf,
}

/// Of two overrides of one key only the last would count.
fn refuse_twice(overrides: &[Override]) -> Result<(), Failure> {
    let mut seen = BTreeSet::new();
    match overrides.iter().find(|o| !seen.insert(&o.key)) {
        None => Ok(()),
        Some(again) => {
            let key = &again.key;
            Err(Failure::usage(format!(
                "`{key}` is given twice; {key}=A,B runs with both values, one after the other"
            )))
        }
    }
}

/// The configs that write the folders of a run.
#[derive(Default)]
struct Folders(BTreeMap<PathBuf, String>);

impl Folders {
    /// Refuses a second config that would write the same folder.
    fn take(&mut self, folder: &Path, config: &str) -> Result<(), Failure> {
        match self.0.insert(folder.to_owned(), config.to_owned()) {
            None => Ok(()),
            Some(other) => Err(Failure::usage(format!(
                "{other} and {config} would both write {}: give one of them another `name`",
                folder.display()
            ))),
        }
    }
}

/// Plans every config of the selection and applies its filters.
pub fn planned(selection: &Selection) -> Result<Vec<Planned>, Failure> {
    let (settings, configs): (Vec<&String>, Vec<&String>) = selection
        .inputs
        .iter()
        .partition(|input| input.contains('='));
    if configs.is_empty() {
        return Err(Failure::usage(
            "no config given, only overrides; `lightbench list configs` has those that are shipped",
        ));
    }
    if selection.out.is_some() && configs.len() > 1 {
        return Err(Failure::usage(
            "--out names one folder, but several configs are given",
        ));
    }
    let mut overrides = settings
        .iter()
        .map(|text| Override::parse(text))
        .collect::<Result<Vec<_>, _>>()?;
    if let Some(repeats) = selection.repeats {
        overrides.push(Override::parse(&format!("repeats={repeats}"))?);
    }
    refuse_twice(&overrides)?;
    let filter = Filter::new(selection)?;
    let mut all = Vec::new();
    let mut folders = Folders::default();
    let folder = |name: &str| {
        let named = || PathBuf::from("results").join(name);
        selection.out.clone().unwrap_or_else(named)
    };
    for file in configs {
        let source = Source::find(file)?;
        let Some(suite) = Suite::of(&source)? else {
            let (config, plan) = plan(&source, &overrides)?;
            let folder = folder(&config.name);
            folders.take(&folder, file)?;
            all.push(Planned {
                folder,
                config,
                plan,
                suite: None,
            });
            continue;
        };
        let planned = Rc::new(PlannedSuite {
            folder: folder(&suite.name),
            title: if suite.title.is_empty() {
                suite.name.clone()
            } else {
                suite.title.clone()
            },
        });
        for (file, overrides) in suite.members(&source.file, &overrides)? {
            let file = file.to_string_lossy();
            let (config, plan) = plan(&Source::find(&file)?, &overrides)?;
            let folder = planned.folder.join(&config.name);
            folders.take(&folder, &file)?;
            all.push(Planned {
                folder,
                config,
                plan,
                suite: Some(planned.clone()),
            });
        }
    }
    let mut scenes: BTreeSet<String> = BTreeSet::new();
    for planned in &mut all {
        let jobs = std::mem::take(&mut planned.plan.jobs);
        let alike = jobs.chunk_by(|a, b| a.scene == b.scene);
        scenes.extend(alike.map(|jobs| jobs[0].scene.clone()));
        let selected = filter.selected(jobs);
        planned.plan.sharded = (!filter.shard.is_whole()).then_some(selected.len());
        planned.plan.jobs = filter.shard.own(selected);
    }
    if all.iter().all(|p| p.plan.jobs.is_empty()) {
        let scenes: Vec<String> = scenes.into_iter().collect();
        return Err(Failure::nothing(format!(
            "no job is selected: look at --scene, --method and --shard; scenes are {}",
            scenes.join(", ")
        )));
    }
    Ok(all)
}

struct Filter {
    scene: Option<Pattern>,
    method: Option<Pattern>,
    shard: Shard,
}

impl Filter {
    fn new(selection: &Selection) -> Result<Self, Failure> {
        let glob = |flag: &str, pattern: &Option<String>| {
            let parsed = pattern.as_deref().map(Pattern::new).transpose();
            parsed.map_err(|error| {
                let pattern = pattern.as_deref().unwrap_or_default();
                Failure::usage(format!("{flag} {pattern}: no pattern of names: {error}"))
            })
        };
        let shard = selection.shard.as_deref().map(Shard::parse).transpose()?;
        Ok(Self {
            scene: glob("--scene", &selection.scene)?,
            method: glob("--method", &selection.method)?,
            shard: shard.unwrap_or(Shard::WHOLE),
        })
    }

    /// Those of the scenes and methods that are asked for.
    fn selected(&self, jobs: Vec<Job>) -> Vec<Job> {
        let matches = |glob: &Option<Pattern>, name: &str| {
            glob.as_ref().is_none_or(|glob| glob.matches(name))
        };
        jobs.into_iter()
            .filter(|j| matches(&self.scene, &j.scene) && matches(&self.method, &j.label))
            .collect()
    }
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct PlanWithEstimates<'a> {
    #[serde(flatten)]
    plan: &'a Plan,
    estimates: serde_json::Value,
}

/// Prints the plan of each config.
pub fn run(args: &PlanArgs) -> Result<u8, Failure> {
    for planned in planned(&args.selection)? {
        if args.json {
            let mut estimates = serde_json::json!({
                "record_bytes_peak": record_bytes_peak(&planned),
            });
            if args.memory {
                let memory = foresee(&planned.plan.jobs)?;
                estimates["memory"] = memory.iter().map(memory_as_json).collect();
            }
            let shown = PlanWithEstimates {
                plan: &planned.plan,
                estimates,
            };
            say!("{}", serde_json::to_string_pretty(&shown)?);
        } else {
            print(&planned);
            if args.memory {
                print_memory(&foresee(&planned.plan.jobs)?);
            }
        }
    }
    Ok(exit::OK)
}

/// Bytes of the records of the job that has most; jobs run one after the other.
fn record_bytes_peak(planned: &Planned) -> u64 {
    let jobs = planned.plan.jobs.iter();
    jobs.map(|job| job.estimated_bytes()).max().unwrap_or(0)
}

fn memory_as_json(memory: &JobMemory) -> serde_json::Value {
    serde_json::json!({
        "job": memory.job.id,
        "bytes_cache": memory.bytes.cache.round(),
        "bytes_work": memory.bytes.work.round(),
    })
}

/// One line for each case whose memory can be foreseen.
fn print_memory(memory: &[JobMemory]) {
    if memory.is_empty() {
        say!("no method of this plan can tell how much memory it will take");
    }
    let mebibytes = |bytes: f64| bytes / f64::from(1 << 20);
    for JobMemory { job, bytes } in memory {
        let swept: Vec<String> = job.sweep.iter().map(|(k, v)| format!("{k}={v}")).collect();
        say!(
            "{:<16} {:<20} {:.1} MiB in the cache, {:.1} MiB of work memory {}",
            job.scene,
            job.label,
            mebibytes(bytes.cache),
            mebibytes(bytes.work),
            swept.join(" ")
        );
    }
}

/// One line a job, then the sum.
pub fn print(planned: &Planned) {
    let store = Store::at(&planned.folder);
    let mut references: HashSet<&str> = HashSet::new();
    let (mut rays, mut done) = (0u64, 0);
    for job in &planned.plan.jobs {
        let finished = store.row(&job.id).is_some_and(|row| row.ok());
        done += usize::from(finished);
        if !finished {
            rays += job.estimated_rays();
            let all = job.references.iter();
            let new = all.filter(|reference| references.insert(reference)).count();
            rays += job.reference_rays() * new as u64 / job.references.len().max(1) as u64;
        }
        say!(
            "{} {:<16} {:<10} seed {:<3} {}x{} spp {} {} {}",
            job.id,
            job.scene,
            job.label,
            job.seed,
            job.width,
            job.height,
            job.spp,
            job.budget,
            if finished { "done" } else { "" }
        );
    }
    for note in &planned.plan.notes {
        say!("note: {note}");
    }
    say!(
        "{}: {} jobs, {done} done; the rest casts about {:.1} million rays, {} references included",
        planned.plan.name,
        planned.plan.jobs.len(),
        rays as f64 / 1e6,
        references.len()
    );
    let bytes = record_bytes_peak(planned);
    if bytes > 0 {
        let mebibytes = bytes as f64 / (1 << 20) as f64;
        say!("records take up to {mebibytes:.1} MiB in a job");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_configs_do_not_write_one_folder() {
        let mut folders = Folders::default();
        assert!(folders.take(Path::new("results/a"), "a.toml").is_ok());
        assert!(folders.take(Path::new("results/b"), "b.toml").is_ok());
        let refused = folders.take(Path::new("results/a"), "other.toml");
        let message = refused.expect_err("the folder is taken").to_string();
        assert_eq!(
            message,
            "a.toml and other.toml would both write results/a: give one of them another `name`"
        );
    }
}
