//! `replay`: what went into one pixel of a job.

use super::args::ReplayArgs;
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{AFFORDABLE, Job, Loaded, Row, Store, build_technique};
use crate::standard_error::tell;
use crate::technique::Terms;
use crate::trace::RayCounter;

/// The job with the setting that its run picked by error, as its row tells.
fn with_kept_setting(job: &Job, row: Option<&Row>) -> Job {
    let mut job = job.clone();
    let first = job.method.split('+').next().unwrap_or_default();
    let (Some(row), Some(entry)) = (row, crate::placement::first_stage(first)) else {
        return job;
    };
    for parameter in entry.about.parameters {
        let given = job.method_parameters.get(parameter.key);
        if given.is_some_and(|v| !v.is_str()) {
            continue; // Set by hand: nothing was picked.
        }
        let found = row.params.get(parameter.key).and_then(|v| v.as_f64());
        if let Some(number) = found.filter(|n| n.fract() == 0.0) {
            let value = toml::Value::Integer(number as i64);
            job.method_parameters.insert(parameter.key.into(), value);
        }
    }
    job
}

/// Renders the job's records again and traces one pixel through them.
pub fn run(args: &ReplayArgs) -> Result<u8, Failure> {
    let id = args
        .job
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let folder = args
        .job
        .parent()
        .and_then(|jobs| jobs.parent())
        .ok_or_else(|| {
            Failure::usage(format!(
                "{}: expected results/NAME/jobs/ID",
                args.job.display()
            ))
        })?;
    let store = Store::open(folder)?;
    let plan = store.plan()?;
    let job = plan
        .jobs
        .iter()
        .find(|job| job.id == id)
        .ok_or_else(|| Failure::usage(format!("{} has no job {id}", folder.display())))?;
    let row = store.row(&id);
    let job = &with_kept_setting(job, row.as_ref());
    let found = row.and_then(|row| row.number(AFFORDABLE));
    let budget = job.budget.count().or(found.map(|count| count as u64));
    let budget = budget.ok_or_else(|| {
        Failure::usage(format!(
            "job {id} has a budget that is spent and no row that tells how many lights or samples it paid for; \
             run it first"
        ))
    })?;
    let (x, y) = args
        .pixel
        .split_once(',')
        .and_then(|(x, y)| {
            Some((
                x.trim().parse::<usize>().ok()?,
                y.trim().parse::<usize>().ok()?,
            ))
        })
        .filter(|(x, y)| *x < job.width && *y < job.height)
        .ok_or_else(|| {
            Failure::usage(format!(
                "--pixel {}: expected X,Y below {}x{}",
                args.pixel, job.width, job.height
            ))
        })?;
    let technique = build_technique(job)?;
    let mut loaded = Loaded::new(job, technique.as_ref())?;
    let frame = job.sequence.representative();
    let views = loaded.views(job, frame).map_err(Failure::job)?;
    let shot = loaded.shot(job, frame, &views[0], technique.as_ref());
    if !job.sequence.is_still() {
        tell!("note: frame {frame} is replayed alone, as the first viewer sees it");
    }
    let terms = Terms {
        budget: budget as usize,
        seed: job.seed,
    };
    let started = technique.start(&job.method, &job.method_parameters, terms)?;
    let mut contender = started.contender;
    if contender.searches() {
        tell!(
            "note: this method picks a setting by error and the job's row does not tell which: the \
             first setting is replayed"
        );
    }
    let pixel = (y * job.width + x) as u32;
    say!(
        "job {id}: {} {} seed {}, pixel {x},{y}",
        job.scene,
        job.label,
        job.seed
    );
    let lines = contender.replay(&shot, pixel).map_err(Failure::usage)?;
    lines.iter().for_each(|line| say!("{line}"));
    let counter = RayCounter::default();
    let caster = shot.tracer.caster(&counter);
    let function = technique.shading_function(&shot);
    for sample in 0..technique.reference_samples(shot.spp) {
        let mut exact = [[0.0; 3]];
        let non_finite = function.pixels(&caster, pixel, sample, &mut exact);
        say!(
            "exact, sample {sample}: {:?}, {non_finite} non-finite",
            exact[0]
        );
    }
    Ok(exit::OK)
}
