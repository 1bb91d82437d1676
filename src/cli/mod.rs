//! The command line: one short file per verb, one table of exit codes.

mod args;
mod caches;
mod check;
mod compare;
mod diff;
mod exit;
mod gate;
mod lights;
mod list;
mod merge;
mod new;
mod number;
mod out;
mod plan;
mod profile;
mod reference;
mod render;
mod replay;
mod report;
mod rivals;
mod run;
mod shard;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

pub use args::Cli;
use args::{RefVerb, SceneVerb, Verb};
use exit::Failure;

use crate::standard_error::tell;
use crate::trace::Kernel;

/// Runs the program and maps errors to exit codes.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Nothing more can be said if the terminal is gone.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { exit::USAGE } else { 0 });
        }
    };
    if ctrlc::set_handler(interrupted).is_err() {
        tell!("warning: interrupts are not caught; finished jobs are kept all the same");
    }
    if let Err(message) = Kernel::requested() {
        tell!("error: {message}");
        return ExitCode::from(exit::USAGE);
    }
    match dispatch(cli.verb) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            tell!("error: {failure}");
            ExitCode::from(failure.code)
        }
    }
}

/// Every finished job is in its place already, so there is nothing to save.
fn interrupted() {
    tell!("\ninterrupted; finished jobs are kept, run the same command to go on");
    std::process::exit(i32::from(exit::INTERRUPTED));
}

fn dispatch(verb: Verb) -> Result<u8, Failure> {
    match verb {
        Verb::Run(args) => run::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Report(args) => report::run(&args),
        Verb::Gate(args) => gate::run(&args),
        Verb::Diff(args) => diff::run(&args),
        Verb::Merge(args) => merge::run(&args),
        Verb::Render(args) => render::run(&args),
        Verb::Compare(args) => compare::run(&args),
        Verb::Caches(args) => caches::run(&args),
        Verb::Lights(args) => lights::run(&args),
        Verb::Scene(SceneVerb::Check(args)) => check::run(&args),
        Verb::New(verb) => new::run(&verb),
        Verb::Ref(RefVerb::Status(args)) => reference::status(&args),
        Verb::Ref(RefVerb::Extend(args)) => reference::extend(&args),
        Verb::Replay(args) => replay::run(&args),
        Verb::List(args) => list::list(&args),
        Verb::Explain(args) => list::explain(&args),
        Verb::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "lightbench", &mut script);
            out::write(String::from_utf8_lossy(&script));
            Ok(exit::OK)
        }
        Verb::Man => {
            let mut page = Vec::new();
            clap_mangen::Man::new(Cli::command()).render(&mut page)?;
            out::write(String::from_utf8_lossy(&page));
            Ok(exit::OK)
        }
    }
}
