//! `run`: everything.

use std::rc::Rc;
use std::time::Duration;

use super::args::RunArgs;
use super::exit::{self, Failure};
use super::out;
use super::plan::{Planned, PlannedSuite, planned, print};
use super::profile;
use crate::experiment::{ReferenceStore, RunOptions, Store, run as run_plan};
use crate::standard_error::tell;

/// Plans all configs first, so that nothing is written when one of them is wrong.
pub fn run(args: &RunArgs) -> Result<u8, Failure> {
    set_threads(args.threads)?;
    let all = planned(&args.selection)?;
    if args.dry_run {
        all.iter().for_each(print);
        return Ok(exit::OK);
    }
    let mut failed = 0;
    for group in all.chunk_by(|a, b| same_suite(a.suite.as_ref(), b.suite.as_ref())) {
        let mut done = Vec::new();
        for planned in group {
            failed += run_one(planned, args)?;
            done.push(planned.config.name.clone());
            if failed > 0 && args.fail_fast {
                break;
            }
        }
        if let Some(suite) = &group[0].suite {
            let page = crate::report::write_suite(&suite.folder, &suite.title, &done)?;
            tell!("suite:   {}", page.display());
        }
        if failed > 0 && args.fail_fast {
            break;
        }
    }
    Ok(if failed > 0 {
        exit::SOME_FAILED
    } else {
        exit::OK
    })
}

fn same_suite(a: Option<&Rc<PlannedSuite>>, b: Option<&Rc<PlannedSuite>>) -> bool {
    a.zip(b).is_some_and(|(a, b)| Rc::ptr_eq(a, b))
}

fn run_one(planned: &Planned, args: &RunArgs) -> Result<usize, Failure> {
    let options = RunOptions {
        folder: planned.folder.clone(),
        references: ReferenceStore::beside(&planned.folder).folder,
        fail_fast: args.fail_fast,
        quiet: args.quiet,
        checkpoint_every: Duration::from_secs_f64(args.checkpoint),
    };
    for note in planned.plan.notes.iter().filter(|_| !args.quiet) {
        tell!("note: {note}");
    }
    let outcome = run_plan(&planned.plan, &planned.config, &options)?;
    let written = crate::report::write(&planned.folder)?;
    out::write(written.summary);
    if args.profile {
        let store = Store::open(&planned.folder)?;
        out::write(profile::text(&store.rows(&planned.plan), &outcome.besides));
    }
    if !args.quiet {
        tell!("results: {}", planned.folder.display());
        tell!("report:  {}", planned.folder.join("report.html").display());
    }
    Ok(outcome.failed)
}

/// Most threads for each processor, and most where there are few. Threads beyond the processors look for work at each
/// other's cost: 1024 on two of them take 20 s for a job of 0.3 s.
const THREADS_PER_PROCESSOR: usize = 4;
const MOST_THREADS: usize = 256;

fn most_threads() -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    MOST_THREADS.max(THREADS_PER_PROCESSOR.saturating_mul(processors))
}

/// Sets the size of the global thread pool.
pub fn set_threads(threads: Option<usize>) -> Result<(), Failure> {
    match threads {
        None => Ok(()),
        Some(n) if !(1..=most_threads()).contains(&n) => Err(Failure::usage(format!(
            "--threads {n}: expected 1 to {}; more threads than processors are no faster",
            most_threads()
        ))),
        Some(n) => rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build_global()
            .map_err(Failure::usage),
    }
}
