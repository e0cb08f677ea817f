//! `glimt study overhead`

use super::Failure;
use super::args::{IsaArg, size, threads, whole};
use super::latency::unattended;
use super::study::{QUICK_WIDTH, SceneArgs, StudyArgs, refuse};
use crate::description::limits;
use crate::render::{Film, Settings, default_threads};
use crate::study::chart::{Axis, Chart, Data, Point, Series};
use crate::study::{Cell, Console, Plan, Report, Stats, StudyError, SystemClock, Table, plain, render};
use crate::tui::Options;
use crate::tui::latency::show;
use clap::Args;
use serde_json::json;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Instant;

#[derive(Debug, Args)]
pub struct OverheadArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Samples of every pixel [default: 8]
    #[arg(long, value_name = "N", value_parser = whole(1, limits::MAX_SAMPLES), allow_negative_numbers = true)]
    samples: Option<u32>,
    /// Columns and rows of the screen
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "200x60", allow_hyphen_values = true)]
    screen: (u32, u32),
    /// Render threads [default: all processors]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    /// How often each is measured [default: 9, with --quick 3]
    #[arg(long, value_name = "N", value_parser = whole(1, 1000), allow_negative_numbers = true)]
    repeats: Option<u32>,
    #[command(flatten)]
    isa: IsaArg,
    #[command(flatten)]
    pub study: StudyArgs,
}

/// Ways to the same picture.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// One pass, nothing told.
    Plain,
    /// Pass after pass, tiles streamed to a reader that keeps the film.
    Streamed,
    /// The same, read by the interface, which paints it.
    Interface,
}

const WAYS: [Way; 3] = [Way::Plain, Way::Streamed, Way::Interface];

impl Way {
    fn name(self) -> &'static str {
        match self {
            Self::Plain => "one plain pass",
            Self::Streamed => "progressive, streamed",
            Self::Interface => "shown by the interface",
        }
    }
}

/// What one render took.
struct Run {
    seconds: f64,
    frames: usize,
    bytes: usize,
}

/// Renders the same samples in each way, in interleaved rounds.
pub fn overhead(args: &OverheadArgs, console: &Console) -> Result<Report, Failure> {
    let isa = args.isa.chosen()?;
    let threads = args.threads.unwrap_or_else(default_threads);
    let rounds = args.repeats.unwrap_or(if args.study.quick { 3 } else { 9 }) as usize;
    let mut opened = args.scene.open(if args.study.quick { QUICK_WIDTH } else { limits::MAX_SIDE }, isa)?;
    let render_desc = &mut opened.desc.render;
    (render_desc.samples, render_desc.error) = (args.samples.unwrap_or(8), None);
    let scene = Arc::new(opened.compile()?);
    let options = || Options { compiled: Some(scene.clone()), ..unattended(&opened, threads, isa) };
    let screen = (args.screen.0 as u16, args.screen.1 as u16);
    let plan = Plan { settings: WAYS.len(), rounds, warm_up: 1, seed: 4 };
    let (mut done, total) = (0, WAYS.len() * (rounds + 1));
    let mut films: [Option<Arc<Film>>; WAYS.len()] = [const { None }; WAYS.len()];
    let runs = plan.measure(&SystemClock::default(), |way| {
        console.step(done, total, WAYS[way].name())?;
        done += 1;
        let begun = Instant::now();
        let (film, frames, bytes, time) = match WAYS[way] {
            Way::Plain => (Arc::new(plain(&scene, threads)), 0, 0, begun.elapsed()),
            Way::Streamed => {
                let settings = Settings { threads, ..Settings::default() };
                (Arc::new(render(&scene, settings, console, |_| {})?.film), 0, 0, begun.elapsed())
            }
            Way::Interface => {
                let broken = || StudyError::Asked("the render failed in the interface".to_owned());
                let shown = show(options(), screen)?.ok_or_else(broken)?;
                (shown.film, shown.frames, shown.bytes, shown.time)
            }
        };
        films[way] = Some(film);
        Ok::<_, StudyError>(Run { seconds: time.as_secs_f64(), frames, bytes })
    });
    let runs = runs.map_err(|error| refuse(error, Some(&opened)))?;
    console.clear();
    let same = films.iter().flatten().all(|film| Some(film) == films[0].as_ref());
    let runs: Vec<Vec<Run>> = runs.into_iter().map(|runs| runs.into_iter().map(|run| run.value).collect()).collect();
    let mut report = Report::new("overhead");
    report.set("scene", opened.file.to_string_lossy().into_owned());
    report.set("size", vec![scene.width, scene.height]);
    report.set("samples", scene.render.samples);
    report.set("threads", threads.get());
    report.set("screen", vec![args.screen.0, args.screen.1]);
    report.set("repeats", rounds);
    tell(&mut report, &runs, same);
    Ok(report)
}

fn tell(report: &mut Report, runs: &[Vec<Run>], same: bool) {
    report.samples = Table::new("", &["way", "round", "time (s)", "frames", "bytes sent"]);
    let columns = ["way", "time (s)", "MAD (s)", "overhead (%)", "MAD (%)", "frames", "bytes sent"];
    let mut table =
        Table::new("From the start to the whole picture, and what it costs more than one plain pass", &columns);
    let (mut summary, mut series) = (Vec::new(), Vec::new());
    for (way, of_way) in WAYS.iter().zip(runs) {
        for (round, run) in of_way.iter().enumerate() {
            report.samples.push([
                way.name().into(),
                round.into(),
                run.seconds.into(),
                run.frames.into(),
                run.bytes.into(),
            ] as [Cell; 5]);
        }
        let costs: Vec<f64> =
            of_way.iter().zip(&runs[0]).map(|(run, plain)| 100.0 * (run.seconds / plain.seconds - 1.0)).collect();
        let seconds: Vec<f64> = of_way.iter().map(|run| run.seconds).collect();
        let (Some(seconds), Some(cost), Some(last)) = (Stats::of(&seconds), Stats::of(&costs), of_way.last()) else {
            continue;
        };
        let shown = |number: usize| if *way == Way::Interface { number.into() } else { Cell::Nothing };
        let percent = |number: f64| if *way == Way::Plain { Cell::Nothing } else { number.into() };
        table.push([
            way.name().into(),
            seconds.median.into(),
            seconds.mad.into(),
            percent(cost.median),
            percent(cost.mad),
            shown(last.frames),
            shown(last.bytes),
        ] as [Cell; 7]);
        summary.push(json!({ "way": way.name(), "seconds": seconds, "overhead_percent": cost }));
        let points =
            of_way.iter().enumerate().map(|(round, run)| Point::new(round as f64 + 1.0, run.seconds)).collect();
        series.push(Series { name: way.name().to_owned(), data: Data::Line(points) });
    }
    report.tables = vec![table];
    report.summary = json!({ "ways": summary, "same_picture": same });
    report.notes = vec![
        format!(
            "The pictures are {}. The overhead is the median over the rounds of the ratio within a round.",
            if same { "the same, bit for bit" } else { "NOT the same: this is a bug in glimt" }
        ),
        "Shown by the interface: with everything up to the bytes that a terminal would be sent; saving is not in it."
            .to_owned(),
    ];
    let chart = Chart {
        title: "What progressiveness and streaming cost".to_owned(),
        subtitle: report.machine.cpu.clone(),
        x: Axis::linear("round"),
        y: Axis::linear("time (s)"),
        series,
        limits: Vec::new(),
    };
    report.chart("", chart);
}
