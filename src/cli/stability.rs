//! `glimt study stability`

use super::args::threads;
use super::study::{StudyArgs, refuse, shown};
use super::{Failure, print, say};
use crate::description::printable;
use crate::headless::Signals;
use crate::render::default_threads;
use crate::study::stability::{self, Plan};
use crate::study::{Console, StudyError};
use clap::Args;
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// Experiments, separated by commas: S1 to S21 [default: all]
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Take experiments as done whose results are in the directory
    #[arg(long)]
    resume: bool,
    /// Threads for trials [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    #[command(flatten)]
    pub study: StudyArgs,
}

/// Runs the experiments and prints each as it ends. The exit code is 1 if `robust` misses a threshold.
pub fn run(args: &StabilityArgs, out: &Path, console: &Console, signals: &Signals) -> Result<ExitCode, Failure> {
    let plan = Plan {
        quick: args.study.quick,
        only: args.only.clone(),
        out: out.to_owned(),
        resume: args.resume,
        threads: args.threads.unwrap_or_else(default_threads),
    };
    let mut unprinted = None;
    let findings = stability::run(&plan, console, |_, report| {
        if let Err(failure) = print(shown(report, &args.study)) {
            unprinted = Some(failure);
            return Err(StudyError::Interrupted);
        }
        Ok(())
    });
    console.clear();
    let findings = match (findings, unprinted, signals.caught()) {
        (_, Some(failure), _) => return Err(failure),
        (Err(_), _, Some(number)) => {
            let message = format!("stopped; --resume goes on with what is in {}", out.display());
            return Err(Failure::Signal { number, message });
        }
        (Err(error), ..) => return Err(refuse(error, None)),
        (Ok(findings), ..) => findings,
    };
    print(stability::summary(&findings).to_string().trim_end())?;
    if !args.study.quiet {
        say(format_args!("written to {}: tables and charts of each experiment", printable(&out.to_string_lossy())));
    }
    if stability::all_hold(&findings) {
        Ok(ExitCode::SUCCESS)
    } else {
        Err(Failure::CouldNot("robust arithmetic misses a threshold".to_owned()))
    }
}
