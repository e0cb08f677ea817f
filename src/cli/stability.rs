//! `glimt study stability`

use super::args::{size, threads, usual_isa};
use super::open::Opened;
use super::study::{StudyArgs, refuse, shown};
use super::{Failure, print, say};
use crate::description::{FilmDesc, printable};
use crate::headless::Signals;
use crate::output::write_whole;
use crate::render::default_threads;
use crate::study::stability::{self, Plan};
use crate::study::{Console, StudyError};
use clap::Args;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// Experiments, separated by commas: S1 to S21 [default: all]
    #[arg(long, value_name = "ID,...", value_delimiter = ',')]
    only: Vec<String>,
    /// Instead of experiments, map what flips in this scene (.toml) or model (.obj) under changes that must not change
    /// it
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["only", "resume"])]
    scene: Option<PathBuf>,
    /// Size of the map [default: the scene's, at most 640 across, with --quick 160]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true, requires = "scene")]
    size: Option<(u32, u32)>,
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
    if let Some(scene) = &args.scene {
        return map(args, scene, out, console, signals);
    }
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
    if findings.is_err() {
        // Goes only if it is empty.
        let _ = std::fs::remove_dir(out);
    }
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

/// Draws the map of a scene. The exit code is 1 if a pixel flips with the default arithmetic.
fn map(
    args: &StabilityArgs,
    scene: &Path,
    out: &Path,
    console: &Console,
    signals: &Signals,
) -> Result<ExitCode, Failure> {
    let film = args.size.map(|(width, height)| FilmDesc { width, height });
    let mut opened = Opened::new(Some(scene), film, usual_isa()?)?;
    let size = &mut opened.desc.film;
    let most = if args.study.quick { 160 } else { 640 };
    match film {
        Some(film) => *size = film,
        None if size.width > most => {
            size.height = (size.height * most).div_ceil(size.width);
            size.width = most;
        }
        None => {}
    }
    let threads = args.threads.unwrap_or_else(default_threads);
    let drawn = stability::map(&opened.desc, args.study.quick, threads, console);
    console.clear();
    if drawn.is_err() {
        let _ = std::fs::remove_dir(out);
    }
    let mut map = drawn.map_err(|error| match signals.caught() {
        Some(number) => Failure::Signal { number, message: "stopped; no map was written".to_owned() },
        None => refuse(error, Some(&opened)),
    })?;
    map.report.set("scene", opened.file.to_string_lossy().into_owned());
    let picture = out.join("stability-map.png");
    map.report.write(out).map_err(|error| refuse(error, None))?;
    write_whole(&picture, &map.png).map_err(Failure::could_not)?;
    print(shown(&map.report, &args.study).trim_end())?;
    if !args.study.quiet {
        say(format_args!("written to {}", printable(&picture.to_string_lossy())));
    }
    if map.flipped == 0 {
        Ok(ExitCode::SUCCESS)
    } else {
        Err(Failure::CouldNot(format!("{} pixels flip with robust arithmetic", map.flipped)))
    }
}
