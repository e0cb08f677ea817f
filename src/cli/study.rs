//! `glimt study`: measurements, their tables, files and charts.

use super::args::{ColorArg, IsaArg, codes, error, named, size, threads, usual_isa, whole};
use super::latency::{self, LatencyArgs};
use super::open::Opened;
use super::overhead::{self, OverheadArgs};
use super::stability::{self, StabilityArgs};
use super::{Failure, print, say};
use crate::bvh::Isa;
use crate::description::{FilmDesc, Numerics, Shading, limits, printable};
use crate::headless::Signals;
use crate::render::default_threads;
use crate::study::chart::TerminalStyle;
use crate::study::{self, Console, KernelOptions, Report, StudyError, Sweep, SystemClock};
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
    /// Where each arithmetic fails: exit code 1 if the default one misses a threshold
    Stability(StabilityArgs),
    /// How fast rays are traced and trees are built, and how wrong each speed is
    Kernel(KernelArgs),
    /// How time and memory grow with triangles, spheres, lights, pixels and depth
    Scale(ScaleArgs),
    /// What accuracy costs: error against time over settings
    Accuracy(AccuracyArgs),
    /// How long the interface takes from a key to the new picture
    Latency(LatencyArgs),
    /// What progressiveness, streaming and the interface cost, against one plain pass of the same samples
    Overhead(OverheadArgs),
}

#[derive(Debug, Args)]
pub struct ScaleArgs {
    /// Most triangles, and most spheres [default: 10000000, with --quick 100000; never more than 1000000 spheres]
    #[arg(long, value_name = "N", value_parser = whole(1000, 10_000_000), allow_negative_numbers = true)]
    max: Option<u32>,
    #[command(flatten)]
    repeats: RepeatsArg,
    #[command(flatten)]
    study: StudyArgs,
}

#[derive(Debug, Args)]
pub struct AccuracyArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Lighting models
    #[arg(long, value_name = "MODEL,...", value_delimiter = ',', value_parser = named(Shading::NAMES))]
    shading: Vec<Shading>,
    /// Arithmetics
    #[arg(long, value_name = "PRESET,...", value_delimiter = ',', value_parser = named(Numerics::NAMES))]
    numerics: Vec<Numerics>,
    /// Depths of ray trees
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = whole(0, limits::MAX_DEPTH))]
    max_depth: Vec<u32>,
    /// Samples of every pixel [default: 1,2,4,8,16,32,64, with --quick 1,4,16]
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = whole(1, limits::MAX_SAMPLES))]
    samples: Vec<u32>,
    /// Errors that adaptive sampling aims at, 8-bit codes [default: 4,2,1,0.5, with --quick 4,1]
    #[arg(long, value_name = "CODES,...", value_delimiter = ',', value_parser = error)]
    error: Vec<f64>,
    /// Every combination, instead of one change at a time from what the scene says
    #[arg(long)]
    all: bool,
    /// Name the cheapest setting whose error is below this many 8-bit codes
    #[arg(long, value_name = "CODES", value_parser = codes, default_value_t = 1.0, allow_negative_numbers = true)]
    below: f64,
    /// Directory in which references are kept [default: glimt in the user's cache]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Most samples of the reference [default: 4096, with --quick 256]
    #[arg(long, value_name = "N", value_parser = whole(32, limits::MAX_SAMPLES), allow_negative_numbers = true)]
    reference_samples: Option<u32>,
    #[command(flatten)]
    repeats: RepeatsArg,
    #[command(flatten)]
    isa: IsaArg,
    #[command(flatten)]
    study: StudyArgs,
}

#[derive(Debug, Args)]
pub struct ThreadsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Numbers of threads, separated by commas
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = threads, default_value = "1,2,4,8,12,16")]
    threads: Vec<NonZeroUsize>,
    #[command(flatten)]
    repeats: RepeatsArg,
    #[command(flatten)]
    isa: IsaArg,
    #[command(flatten)]
    study: StudyArgs,
}

#[derive(Debug, Args)]
pub struct KernelArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Instruction sets, separated by commas: portable (or sse2), avx2, avx512 [default: GLIMT_ISA, or the fastest
    /// here]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = str::parse::<Isa>)]
    isa: Vec<Isa>,
    /// Rays of each kind, about [default: 131072, with --quick 16384]
    #[arg(long, value_name = "N", value_parser = whole(1, 1 << 26), allow_negative_numbers = true)]
    rays: Option<u32>,
    /// Threads that trees are built with, beside one [default: all processors]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    #[command(flatten)]
    repeats: RepeatsArg,
    #[command(flatten)]
    study: StudyArgs,
}

/// What is rendered.
#[derive(Debug, Args)]
pub(super) struct SceneArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, which is built in]
    scene: Option<PathBuf>,
    /// Pixels across and down [default: the scene's, at most 640 across for accuracy, 320 with --quick]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    size: Option<(u32, u32)>,
}

#[derive(Debug, Args)]
struct RepeatsArg {
    /// How often each is measured [default: 5, for accuracy and scale 3; with --quick 2 and 1]
    #[arg(long, value_name = "N", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    repeats: Option<u32>,
}

impl RepeatsArg {
    /// Or so many.
    fn or(&self, usual: u32) -> usize {
        self.repeats.unwrap_or(usual) as usize
    }
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

/// Most pixels across in a short run, and in one that renders a picture many times.
pub(super) const QUICK_WIDTH: u32 = 320;
const ACCURACY_WIDTH: u32 = 640;

impl SceneArgs {
    /// `widest`: most pixels across, unless a size is asked for.
    pub(super) fn open(&self, widest: u32, isa: Isa) -> Result<Opened, Failure> {
        let film = self.size.map(|(width, height)| FilmDesc { width, height });
        let mut opened = Opened::new(self.scene.as_deref(), film, isa)?;
        let shown = &mut opened.desc.film;
        if let Some(film) = film {
            *shown = film;
        } else if shown.width > widest {
            shown.height = (shown.height * widest).div_ceil(shown.width);
            shown.width = widest;
        }
        Ok(opened)
    }
}

impl StudyCommand {
    fn common(&self) -> &StudyArgs {
        match self {
            Self::Threads(args) => &args.study,
            Self::Stability(args) => &args.study,
            Self::Kernel(args) => &args.study,
            Self::Scale(args) => &args.study,
            Self::Accuracy(args) => &args.study,
            Self::Latency(args) => &args.study,
            Self::Overhead(args) => &args.study,
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Threads(_) => "threads",
            Self::Stability(_) => "stability",
            Self::Kernel(_) => "kernel",
            Self::Scale(_) => "scale",
            Self::Accuracy(_) => "accuracy",
            Self::Latency(_) => "latency",
            Self::Overhead(_) => "overhead",
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
    if let StudyCommand::Stability(args) = command {
        // Many reports, each written when it is there.
        return stability::run(args, &out, &console, &signals);
    }
    let studied = study(command, &console).and_then(|report| {
        let files = report.write(&out).map_err(|error| refuse(error, None))?;
        Ok((report, files))
    });
    console.clear();
    let (report, files) = match studied {
        Ok(studied) => studied,
        Err(failure) => {
            // What was made goes again, but only if it is empty.
            let made = if args.out.is_none() { 2 } else { 1 };
            for directory in out.ancestors().take(made) {
                let _ = fs::remove_dir(directory);
            }
            return Err(match failure {
                Failure::Signal { number, message } => {
                    Failure::Signal { number: signals.caught().unwrap_or(number), message }
                }
                other => other,
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
            let widest = if args.study.quick { QUICK_WIDTH } else { limits::MAX_SIDE };
            let opened = args.scene.open(widest, args.isa.chosen()?)?;
            let scene = Arc::new(opened.compile()?);
            let repeats = args.repeats.or(if args.study.quick { 2 } else { 5 });
            let mut report = study::threads(&scene, &args.threads, repeats, console)
                .map_err(|error| refuse(error, Some(&opened)))?;
            report.set("scene", opened.file.to_string_lossy().into_owned());
            Ok(report)
        }
        StudyCommand::Stability(_) => unreachable!("it has reports of its own"),
        StudyCommand::Kernel(args) => {
            let isas = if args.isa.is_empty() { vec![usual_isa()?] } else { args.isa.clone() };
            let (rays, repeats) = if args.study.quick { (1 << 14, 2) } else { (1 << 17, 5) };
            let widest = if args.study.quick { QUICK_WIDTH } else { limits::MAX_SIDE };
            let opened = args.scene.open(widest, isas[0])?;
            let options = KernelOptions {
                isas,
                rays: args.rays.unwrap_or(rays) as usize,
                rounds: args.repeats.or(repeats),
                threads: args.threads.unwrap_or_else(default_threads),
                ..KernelOptions::default()
            };
            let mut report = study::kernel(&opened.desc, &options, &SystemClock::default(), console)
                .map_err(|error| refuse(error, Some(&opened)))?;
            report.set("scene", opened.file.to_string_lossy().into_owned());
            Ok(report)
        }
        StudyCommand::Scale(args) => {
            let quick = args.study.quick;
            let most = args.max.unwrap_or(if quick { 100_000 } else { 10_000_000 });
            let repeats = args.repeats.or(if quick { 1 } else { 3 });
            study::scale(quick, most.into(), repeats, console).map_err(|error| refuse(error, None))
        }
        StudyCommand::Latency(args) => latency::latency(args, console),
        StudyCommand::Overhead(args) => overhead::overhead(args, console),
        StudyCommand::Accuracy(args) => {
            let quick = args.study.quick;
            let isa = args.isa.chosen()?;
            let opened = args.scene.open(if quick { QUICK_WIDTH } else { ACCURACY_WIDTH }, isa)?;
            let sweep = Sweep {
                shadings: all_or(&args.shading, Shading::NAMES),
                numerics: all_or(&args.numerics, Numerics::NAMES),
                depths: given_or(&args.max_depth, if quick { &[1, 4] } else { &[1, 2, 4, 8] }),
                samples: given_or(&args.samples, if quick { &[1, 4, 16] } else { &[1, 2, 4, 8, 16, 32, 64] }),
                errors: given_or(&args.error, if quick { &[4.0, 1.0] } else { &[4.0, 2.0, 1.0, 0.5] }),
                all: args.all,
                repeats: args.repeats.or(if quick { 1 } else { 3 }),
                below: args.below,
                reference_samples: args.reference_samples.unwrap_or(if quick { 256 } else { 4096 }),
            };
            let cache = args.cache.clone().unwrap_or_else(study::default_cache);
            let mut report =
                study::accuracy(&opened.desc, &sweep, &cache, console).map_err(|error| refuse(error, Some(&opened)))?;
            report.set("scene", opened.file.to_string_lossy().into_owned());
            Ok(report)
        }
    }
}

/// What was asked for, else all there is.
fn all_or<T: Copy>(given: &[T], names: &[(&str, T)]) -> Vec<T> {
    given_or(given, &names.iter().map(|(_, value)| *value).collect::<Vec<_>>())
}

fn given_or<T: Copy>(given: &[T], otherwise: &[T]) -> Vec<T> {
    if given.is_empty() { otherwise.to_vec() } else { given.to_vec() }
}

/// Whose fault it is.
pub(super) fn refuse(error: StudyError, opened: Option<&Opened>) -> Failure {
    match (error, opened) {
        (StudyError::Compile(error), Some(opened)) => opened.locate(error),
        (error @ (StudyError::Asked(_) | StudyError::Compile(_)), _) => Failure::asked(error),
        // Which signal, the caller knows.
        (StudyError::Interrupted, _) => {
            Failure::Signal { number: 0, message: "stopped; nothing was written".to_owned() }
        }
        (error, _) => Failure::could_not(error),
    }
}

/// Tables and notes, and where stdout is a terminal the charts.
pub(super) fn shown(report: &Report, args: &StudyArgs) -> String {
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
