//! `glimt study`: measurements, their tables, files and charts.

use super::args::{ColorArg, IsaArg, size, threads, usual_isa, whole};
use super::open::Opened;
use super::{Failure, print, say};
use crate::bvh::Isa;
use crate::description::FilmDesc;
use crate::description::printable;
use crate::headless::Signals;
use crate::render::default_threads;
use crate::study::chart::TerminalStyle;
use crate::study::{self, Console, KernelOptions, Report, StudyError, SystemClock};
use crate::tui::ColorChoice;
use clap::{Args, Subcommand};
use std::fs;
use std::io::{self, IsTerminal};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Debug, Subcommand)]
pub enum StudyCommand {
    /// How rendering time falls with the number of threads
    Threads(ThreadsArgs),
    /// How fast rays are traced and trees are built, and how wrong each speed is
    Kernel(KernelArgs),
}

#[derive(Debug, Args)]
pub struct ThreadsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Numbers of threads, separated by commas
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = threads, default_value = "1,2,4,8,12,16")]
    threads: Vec<NonZeroUsize>,
    /// How often each is measured [default: 5, with --quick 2]
    #[arg(long, value_name = "N", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    repeats: Option<u32>,
    #[command(flatten)]
    isa: IsaArg,
    #[command(flatten)]
    study: StudyArgs,
}

#[derive(Debug, Args)]
pub struct KernelArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Instruction sets, separated by commas: portable (or sse2), avx2, avx512 [default: GLIMT_ISA, or the fastest here]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = str::parse::<Isa>)]
    isa: Vec<Isa>,
    /// Rays of each kind, about [default: 131072, with --quick 16384]
    #[arg(long, value_name = "N", value_parser = whole(1, 1 << 26), allow_negative_numbers = true)]
    rays: Option<u32>,
    /// Threads that trees are built with, beside one [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    /// How often each is measured [default: 5, with --quick 2]
    #[arg(long, value_name = "N", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    repeats: Option<u32>,
    #[command(flatten)]
    study: StudyArgs,
}

/// What is rendered.
#[derive(Debug, Args)]
struct SceneArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, which is built in]
    scene: Option<PathBuf>,
    /// Pixels across and down, instead of the scene's [with --quick: at most 320 across]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    size: Option<(u32, u32)>,
}

/// What every study is told.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Directory for CSV, JSON, PNG and SVG files; made if it is not there [default: glimt-study/<NAME>]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// A short run: fewer and smaller measurements
    #[arg(long)]
    pub quick: bool,
    /// No progress on stderr
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub color: ColorArg,
}

/// Most pixels across in a short run, unless a size is asked for.
const QUICK_WIDTH: u32 = 320;

impl SceneArgs {
    fn open(&self, quick: bool, isa: Isa) -> Result<Opened, Failure> {
        let film = self.size.map(|(width, height)| FilmDesc { width, height });
        let mut opened = Opened::new(self.scene.as_deref(), film, isa)?;
        let shown = &mut opened.desc.film;
        if let Some(film) = film {
            *shown = film;
        } else if quick && shown.width > QUICK_WIDTH {
            shown.height = (shown.height * QUICK_WIDTH).div_ceil(shown.width);
            shown.width = QUICK_WIDTH;
        }
        Ok(opened)
    }
}

impl StudyCommand {
    fn common(&self) -> &StudyArgs {
        match self {
            Self::Threads(args) => &args.study,
            Self::Kernel(args) => &args.study,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Threads(_) => "threads",
            Self::Kernel(_) => "kernel",
        }
    }

    /// `--color`
    pub fn color(&self) -> ColorChoice {
        self.common().color.color
    }
}

/// Runs a study, prints its tables, on a terminal its charts too, and writes its files.
pub fn run(command: &StudyCommand) -> Result<ExitCode, Failure> {
    let args = command.common();
    let signals = Signals::listen().map_err(Failure::could_not)?;
    let interrupted = || signals.caught().is_some();
    let console = Console::new(&interrupted, args.quiet);
    let out = args.out.clone().unwrap_or_else(|| Path::new("glimt-study").join(command.name()));
    // A path that cannot be written to is found before the work, not after it.
    fs::create_dir_all(&out)
        .map_err(|error| Failure::Asked(format!("cannot make the directory {}: {error}", out.display())))?;
    let studied = study(command, &console).and_then(|report| {
        let files = report.write(&out).map_err(|error| refuse(error, None))?;
        Ok((report, files))
    });
    console.clear();
    let (report, files) = match studied {
        Ok(studied) => studied,
        Err(failure) => {
            // Goes only if it is empty.
            let _ = fs::remove_dir(&out);
            return Err(match signals.caught() {
                Some(number) => {
                    Failure::Signal { number, message: format!("stopped; nothing was written to {}", out.display()) }
                }
                None => failure,
            });
        }
    };
    print(shown(&report, args).trim_end())?;
    if !args.quiet {
        let names: Vec<_> =
            files.iter().filter_map(|file| file.file_name()).map(|name| name.to_string_lossy()).collect();
        say(format_args!("written to {}: {}", printable(&out.to_string_lossy()), names.join(", ")));
    }
    Ok(ExitCode::SUCCESS)
}

fn study(command: &StudyCommand, console: &Console) -> Result<Report, Failure> {
    match command {
        StudyCommand::Threads(args) => {
            let opened = args.scene.open(args.study.quick, args.isa.chosen()?)?;
            let scene = Arc::new(opened.compile()?);
            let repeats = args.repeats.unwrap_or(if args.study.quick { 2 } else { 5 });
            let mut report = study::threads(&scene, &args.threads, repeats as usize, console)
                .map_err(|error| refuse(error, Some(&opened)))?;
            report.set("scene", opened.file.to_string_lossy().into_owned());
            Ok(report)
        }
        StudyCommand::Kernel(args) => {
            let isas = if args.isa.is_empty() { vec![usual_isa()?] } else { args.isa.clone() };
            let (rays, repeats) = if args.study.quick { (1 << 14, 2) } else { (1 << 17, 5) };
            let opened = args.scene.open(args.study.quick, isas[0])?;
            let options = KernelOptions {
                isas,
                rays: args.rays.unwrap_or(rays) as usize,
                rounds: args.repeats.unwrap_or(repeats) as usize,
                threads: args.threads.unwrap_or_else(default_threads),
                ..KernelOptions::default()
            };
            let mut report = study::kernel(&opened.desc, &options, &SystemClock::default(), console)
                .map_err(|error| refuse(error, Some(&opened)))?;
            report.set("scene", opened.file.to_string_lossy().into_owned());
            Ok(report)
        }
    }
}

/// Whose fault it is.
fn refuse(error: StudyError, opened: Option<&Opened>) -> Failure {
    match (error, opened) {
        (StudyError::Compile(error), Some(opened)) => opened.locate(error),
        (error @ (StudyError::Asked(_) | StudyError::Compile(_)), _) => Failure::asked(error),
        (error, _) => Failure::could_not(error),
    }
}

/// Tables and notes, and where stdout is a terminal the charts.
fn shown(report: &Report, args: &StudyArgs) -> String {
    let mut text = report.text();
    if let Some((width, height)) = terminal_size() {
        let unset = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let color = match args.color.color {
            ColorChoice::Auto => unset,
            choice => choice != ColorChoice::Never,
        };
        let style = TerminalStyle { width, height: (height * 3 / 4).clamp(16, 32), color };
        for (_, chart) in &report.charts {
            text += &format!("\n{}", chart.to_terminal(style));
        }
    }
    text
}

/// Columns and lines of the terminal that stdout is; `None` if it is none.
fn terminal_size() -> Option<(u16, u16)> {
    if !io::stdout().is_terminal() || std::env::var_os("TERM").is_some_and(|term| term == "dumb") {
        return None;
    }
    #[cfg(unix)]
    if let Ok(size) = rustix::termios::tcgetwinsize(io::stdout()) {
        return Some((size.ws_col.max(1), size.ws_row.max(1)));
    }
    Some((80, 24))
}
