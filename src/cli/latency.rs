//! `glimt study latency`

use super::Failure;
use super::args::{IsaArg, size, threads, whole};
use super::open::Opened;
use super::study::{StudyArgs, refuse};
use crate::bvh::Isa;
use crate::render::{Settings, View, default_threads};
use crate::scene::compile_for;
use crate::study::chart::{Axis, Chart, Data, Point, Series};
use crate::study::{Cell, Console, Report, Stats, Table, landscape};
use crate::tui::latency::{Bench, Edit, cancels};
use crate::tui::{ColorChoice, Keymap, Options};
use clap::Args;
use serde_json::{Map, json};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct LatencyArgs {
    /// Scene (.toml) or model (.obj) [default: the demo scene, then generated hills of a million triangles]
    scene: Option<PathBuf>,
    /// Columns and rows of the screen
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "200x60", allow_hyphen_values = true)]
    screen: (u32, u32),
    /// Render threads [default: all processors]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
    /// Edits of each kind [default: 40, with --quick 6]
    #[arg(long, value_name = "N", value_parser = whole(1, 10_000), allow_negative_numbers = true)]
    repeats: Option<u32>,
    #[command(flatten)]
    isa: IsaArg,
    #[command(flatten)]
    pub study: StudyArgs,
}

/// Triangles of the generated scene, and with `--quick`.
const TRIANGLES: [u64; 2] = [1_000_000, 100_000];

/// One row of the results: a kind of edit in a scene, or cancelling there.
struct Line {
    scene: String,
    what: &'static str,
    /// Milliseconds until the whole new picture is on the screen, or until the render is gone.
    whole: Vec<f64>,
    /// Milliseconds until the scene is compiled, and until it is traced.
    parts: Vec<[f64; 2]>,
}

/// Measures the scene that is named, or the two that are not.
pub fn latency(args: &LatencyArgs, console: &Console) -> Result<Report, Failure> {
    let isa = args.isa.chosen()?;
    let threads = args.threads.unwrap_or_else(default_threads);
    let count = args.repeats.unwrap_or(if args.study.quick { 6 } else { 40 }) as usize;
    let opened = Opened::new(args.scene.as_deref(), None, isa)?;
    let options = |name: String| Options { scene_name: name, ..unattended(&opened, threads, isa) };
    let mut scenes = vec![options(opened.name().to_string_lossy().into_owned())];
    scenes[0].compiled = Some(Arc::new(opened.compile()?));
    if args.scene.is_none() {
        let triangles = TRIANGLES[usize::from(args.study.quick)];
        let (desc, lent) = landscape(triangles).map_err(|error| refuse(error, None))?;
        scenes.push(Options { desc, compiled: Some(Arc::new(lent)), ..options(format!("{triangles} triangles")) });
    }
    let mut report = Report::new("latency");
    report.set("screen", vec![args.screen.0, args.screen.1]);
    report.set("threads", threads.get());
    report.set("repeats", count);
    let steps = scenes.len() * (Edit::ALL.len() + 1);
    let mut lines: Vec<Line> = Vec::new();
    for options in scenes {
        let name = options.scene_name.clone();
        let step = |lines: &[Line], what: &str| {
            let done = console.step(lines.len(), steps, format_args!("{name}, {what}"));
            done.map_err(|error| refuse(error, None))
        };
        let scene = compile_for(&options.desc, options.compiled.as_deref(), isa).map_err(Failure::asked)?;
        let screen = (args.screen.0 as u16, args.screen.1 as u16);
        let mut bench = Bench::new(options, screen).map_err(Failure::asked)?;
        for edit in Edit::ALL {
            step(&lines, edit.name())?;
            let Some(answers) = bench.measure(edit, count) else { continue };
            let parts = answers.iter().map(|answer| [answer.compiled, answer.traced].map(milliseconds)).collect();
            let whole = answers.iter().map(|answer| milliseconds(answer.painted)).collect();
            lines.push(Line { scene: name.clone(), what: edit.name(), whole, parts });
        }
        drop(bench);
        step(&lines, "cancel")?;
        let times = cancels(&Arc::new(scene), Settings { threads, ..Settings::default() }, count);
        let whole = times.into_iter().map(milliseconds).collect();
        lines.push(Line { scene: name.clone(), what: "cancel", whole, parts: Vec::new() });
    }
    console.clear();
    tell(&mut report, &lines);
    Ok(report)
}

/// What the interface is told when nobody looks at it.
pub(super) fn unattended(opened: &Opened, threads: NonZeroUsize, isa: Isa) -> Options {
    Options {
        view: View::Final,
        time: None,
        desc: opened.desc.clone(),
        compiled: None,
        source: None,
        directory: opened.directory(),
        keymap: Keymap::default(),
        scene_name: opened.name().to_string_lossy().into_owned(),
        output: PathBuf::new(),
        threads,
        isa,
        color: ColorChoice::Truecolor,
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn tell(report: &mut Report, lines: &[Line]) {
    let columns = ["scene", "edit", "number", "compiled (ms)", "traced (ms)", "painted (ms)"];
    report.samples = Table::new("", &columns);
    let title = "From a key to the whole new picture on the screen; from cancelling to the end of all workers";
    let columns =
        ["scene", "edit", "median (ms)", "MAD (ms)", "quickest (ms)", "slowest (ms)", "compiled (ms)", "traced (ms)"];
    let mut table = Table::new(title, &columns);
    let (mut series, mut summary) = (Vec::new(), Vec::new());
    for line in lines {
        for (number, whole) in line.whole.iter().enumerate() {
            let part = |which: usize| line.parts.get(number).map_or(Cell::Nothing, |parts| parts[which].into());
            let row = [line.scene.as_str().into(), line.what.into(), number.into(), part(0), part(1), (*whole).into()];
            report.samples.push(row as [Cell; 6]);
        }
        let Some(stats) = Stats::of(&line.whole) else { continue };
        let part = |which: usize| {
            let times: Vec<f64> = line.parts.iter().map(|parts| parts[which]).collect();
            Stats::of(&times).map_or(Cell::Nothing, |stats| stats.median.into())
        };
        table.push([
            line.scene.as_str().into(),
            line.what.into(),
            stats.median.into(),
            stats.mad.into(),
            stats.min.into(),
            stats.max.into(),
            part(0),
            part(1),
        ] as [Cell; 8]);
        let mut entry = Map::new();
        entry.insert("scene".into(), line.scene.as_str().into());
        entry.insert("edit".into(), line.what.into());
        entry.insert("milliseconds".into(), json!(stats));
        summary.push(entry);
        let mut sorted = line.whole.clone();
        sorted.sort_by(f64::total_cmp);
        let share = |rank: usize| 100.0 * (rank + 1) as f64 / sorted.len() as f64;
        let points = sorted.iter().enumerate().map(|(rank, time)| Point::new(*time, share(rank))).collect();
        series.push((line, Series { name: line.what.to_owned(), data: Data::Line(points) }));
    }
    report.summary = json!(summary);
    report.tables = vec![table];
    report.notes = vec![
        "Whole: every part of the picture has a sample of the edited scene, and every cell was painted with it. Edits \
         come while the picture before is being refined."
            .to_owned(),
        "Painted into cells; sending them is the terminal's time. Compiled and traced: when that was done, since the key."
            .to_owned(),
    ];
    let mut scenes: Vec<&str> = lines.iter().map(|line| line.scene.as_str()).collect();
    scenes.dedup();
    for (number, scene) in scenes.iter().enumerate() {
        let of_scene = series.iter().filter(|(line, _)| line.scene == *scene).map(|(_, series)| series.clone());
        let chart = Chart {
            title: format!("From a key to the new picture: {scene}"),
            subtitle: report.machine.cpu.clone(),
            x: Axis::log("time (ms)"),
            y: Axis { range: Some((0.0, 100.0)), ..Axis::linear("edits that took no longer (%)") },
            series: of_scene.collect(),
            limits: Vec::new(),
        };
        report.chart(if number == 0 { String::new() } else { "generated".to_owned() }, chart);
    }
}
