//! How rendering time falls with the number of threads: the coursework's experiment, with repeats.

use super::chart::{Axis, Chart, Data, Point, Series, Span};
use super::{Cell, Console, Plan, Report, Stats, StudyError, SystemClock, Table, Timed, render};
use crate::render::{Pass, RenderEvent, Settings, WorkerProgress};
use crate::scene::Scene;
use serde_json::json;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

/// What the coursework published: threads and milliseconds, on an i5-1135G7 (4 cores, 8 hardware threads).
const COURSEWORK: [(u32, f64); 6] = [(1, 19430.0), (2, 11719.0), (4, 10024.0), (8, 6050.0), (12, 6469.0), (16, 6927.0)];

/// One render.
struct Run {
    time: Duration,
    workers: Vec<WorkerProgress>,
    tiles: Vec<TileSpan>,
}

/// When a thread worked on a tile, seconds.
struct TileSpan {
    worker: usize,
    pass: Pass,
    from: f64,
    to: f64,
}

/// Renders the scene with each number of threads in `repeats` interleaved rounds, after one that is not kept.
pub fn threads(
    scene: &Arc<Scene>,
    counts: &[NonZeroUsize],
    repeats: usize,
    console: &Console,
) -> Result<Report, StudyError> {
    let mut report = Report::new("threads");
    let settings = Settings::default();
    report.set("size", vec![scene.width, scene.height]);
    report.set("samples", scene.render.samples);
    report.set("shading", scene.render.shading.name());
    report.set("numerics", scene.render.numerics.name());
    report.set("max_depth", scene.render.max_depth);
    report.set("tile_size", settings.tile_size);
    report.set("threads", counts.iter().map(|n| n.get()).collect::<Vec<_>>());
    report.set("repeats", repeats);
    let plan = Plan { settings: counts.len(), rounds: repeats, warm_up: 1, seed: 1 };
    let (mut done, total) = (0, counts.len() * (repeats + 1));
    let runs = plan.measure(&SystemClock::default(), |setting| {
        console.step(done, total, format_args!("{} threads", counts[setting]))?;
        done += 1;
        run(scene, Settings { threads: counts[setting], ..settings }, console)
    })?;
    console.clear();
    tell(&mut report, counts, &runs);
    Ok(report)
}

fn run(scene: &Arc<Scene>, settings: Settings, console: &Console) -> Result<Run, StudyError> {
    let mut tiles: Vec<TileSpan> = Vec::new();
    let trial = render(scene, settings, console, |event| {
        if let RenderEvent::TileFinished { worker, stats, pass, .. } = event {
            let to = stats.done.as_secs_f64();
            let from = (to - stats.busy.as_secs_f64()).max(0.0);
            tiles.push(TileSpan { worker: *worker, pass: *pass, from, to });
        }
    })?;
    Ok(Run { time: trial.time, workers: trial.progress.workers, tiles })
}

/// Everything about one number of threads.
struct Line {
    threads: usize,
    seconds: Stats,
    /// Ratios of times within one round, so that what slows the machine for a while cancels out.
    speedup: Stats,
    busy: Stats,
}

fn tell(report: &mut Report, counts: &[NonZeroUsize], runs: &[Vec<Timed<Run>>]) {
    let processors = report.machine.threads;
    let columns = ["threads", "round", "thread", "time (s)", "busy (s)", "busy share", "idle share", "tiles", "rays"];
    report.samples = Table::new("", &columns);
    for (count, runs) in counts.iter().zip(runs) {
        for Timed { round, value: run, .. } in runs {
            let time = run.time.as_secs_f64();
            for (index, worker) in run.workers.iter().enumerate() {
                let busy = worker.busy.as_secs_f64();
                report.samples.push([
                    count.get().into(),
                    (*round).into(),
                    index.into(),
                    time.into(),
                    busy.into(),
                    (busy / time).into(),
                    (1.0 - busy / time).into(),
                    worker.tiles.into(),
                    worker.rays.into(),
                ] as [Cell; 9]);
            }
        }
    }
    let lines: Vec<Line> =
        counts.iter().zip(runs).filter_map(|(n, runs_of)| line(n.get(), runs_of, counts[0].get(), &runs[0])).collect();
    report.tables = vec![table(&lines, processors), published()];
    report.summary = json!({
        "threads": lines.iter().map(|line| json!({
            "threads": line.threads,
            "seconds": line.seconds,
            "speedup": line.speedup,
            "efficiency": line.speedup.median / line.threads as f64,
            "efficiency_of_processors": line.speedup.median / line.threads.min(processors) as f64,
            "busy_share": line.busy,
        })).collect::<Vec<_>>(),
        "coursework": COURSEWORK.map(|(threads, ms)| json!({ "threads": threads, "speedup": COURSEWORK[0].1 / ms })),
    });
    report.notes = vec![
        format!(
            "Speed-up: median over {} rounds of the ratio to {} of the same round.",
            runs[0].len(),
            plural(counts[0].get())
        ),
        "Busy: share of the time that a thread spent tracing, with the time in which the system let another one run."
            .to_owned(),
        format!(
            "This machine: {} processors, load {} at the start. The coursework's had 4 cores and 8 hardware threads.",
            processors,
            report.machine.load.map_or("unknown".to_owned(), |load| load.to_string())
        ),
    ];
    report.chart("", speedups(&lines, processors, &report.machine.cpu));
    for (count, runs) in counts.iter().zip(runs) {
        let median = lines.iter().find(|line| line.threads == count.get()).map_or(0.0, |line| line.seconds.median);
        let apart = |run: &Timed<Run>| (run.value.time.as_secs_f64() - median).abs();
        if let Some(typical) = runs.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))) {
            report.chart(format!("gantt-{count}"), gantt(&typical.value, &report.machine.cpu));
        }
    }
}

fn plural(threads: usize) -> String {
    format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
}

fn line(threads: usize, runs: &[Timed<Run>], first: usize, runs_of_first: &[Timed<Run>]) -> Option<Line> {
    let seconds: Vec<f64> = runs.iter().map(|run| run.value.time.as_secs_f64()).collect();
    let ratios = runs_of_first.iter().zip(&seconds).map(|(one, n)| first as f64 * one.value.time.as_secs_f64() / n);
    let busy = runs.iter().flat_map(|run| {
        let time = run.value.time.as_secs_f64();
        run.value.workers.iter().map(move |worker| worker.busy.as_secs_f64() / time)
    });
    Some(Line {
        threads,
        speedup: Stats::of(&ratios.collect::<Vec<_>>())?,
        busy: Stats::of(&busy.collect::<Vec<_>>())?,
        seconds: Stats::of(&seconds)?,
    })
}

fn table(lines: &[Line], processors: usize) -> Table {
    let mut table = Table::new(
        "Time by threads",
        &[
            "threads",
            "time (ms)",
            "MAD (ms)",
            "best (ms)",
            "speed-up",
            "efficiency (%)",
            "of processors (%)",
            "busy (%)",
            "idle (%)",
            "idlest (%)",
        ],
    );
    for line in lines {
        table.push([
            line.threads.into(),
            (line.seconds.median * 1e3).into(),
            (line.seconds.mad * 1e3).into(),
            (line.seconds.min * 1e3).into(),
            line.speedup.median.into(),
            (line.speedup.median / line.threads as f64 * 100.0).into(),
            (line.speedup.median / line.threads.min(processors) as f64 * 100.0).into(),
            (line.busy.median * 100.0).into(),
            ((1.0 - line.busy.median) * 100.0).into(),
            ((1.0 - line.busy.min) * 100.0).into(),
        ] as [Cell; 10]);
    }
    table
}

/// The coursework's table, for comparison.
fn published() -> Table {
    let columns = ["threads", "time (ms)", "speed-up", "efficiency (%)"];
    let mut table = Table::new("The coursework's, on an i5-1135G7 (4 cores, 8 hardware threads)", &columns);
    for (threads, ms) in COURSEWORK {
        let speedup = COURSEWORK[0].1 / ms;
        table.push(
            [threads.into(), ms.into(), speedup.into(), (speedup / f64::from(threads) * 100.0).into()] as [Cell; 4]
        );
    }
    table
}

fn speedups(lines: &[Line], processors: usize, cpu: &str) -> Chart {
    let measured = lines.iter().map(|line| Point {
        x: line.threads as f64,
        y: line.speedup.median,
        spread: Some((line.speedup.lower_quartile, line.speedup.upper_quartile)),
    });
    let most = lines.iter().map(|line| line.threads).max().unwrap_or(1);
    let ideal = (1..=most).map(|n| (n as f64, n.min(processors) as f64));
    let coursework = COURSEWORK.map(|(threads, ms)| Point::new(threads.into(), COURSEWORK[0].1 / ms));
    Chart {
        title: "Speed-up by number of threads".to_owned(),
        subtitle: format!("{cpu}, {processors} processors; median and quartiles"),
        x: Axis::linear("threads"),
        y: Axis { range: None, ..Axis::linear("speed-up") },
        series: vec![
            Series { name: "glimt".to_owned(), data: Data::Line(measured.collect()) },
            Series { name: "the coursework (8 hardware threads)".to_owned(), data: Data::Line(coursework.to_vec()) },
            Series { name: format!("ideal on {processors} processors"), data: Data::Guide(ideal.collect()) },
        ],
        limits: Vec::new(),
    }
}

/// A strip for each thread: when it worked on a tile, coloured by pass.
fn gantt(run: &Run, cpu: &str) -> Chart {
    let kinds = ["first sample, coarse to fine", "samples 2 to 4", "samples 5 to 16", "more samples"];
    let kind = |pass: Pass| match pass {
        Pass::Refine { to, .. } if to <= 4 => 1,
        Pass::Refine { to, .. } if to <= 16 => 2,
        Pass::Refine { .. } | Pass::Adapt { .. } => 3,
        Pass::Lattice { .. } => 0,
    };
    let spans = |index: usize| -> Vec<Span> {
        let of_kind = run.tiles.iter().filter(|tile| kind(tile.pass) == index);
        of_kind.map(|tile| Span { lane: tile.worker, from: tile.from * 1e3, to: tile.to * 1e3 }).collect()
    };
    let series =
        kinds.iter().enumerate().map(|(index, name)| (name, spans(index))).filter(|(_, spans)| !spans.is_empty());
    let threads = run.workers.len();
    Chart {
        title: format!("Who works when: {}", plural(threads)),
        subtitle: format!("{cpu}; a box is a pass over a tile, gaps are idle time"),
        x: Axis::linear("time (ms)"),
        y: Axis::names("thread", (0..threads).map(|index| index.to_string()).collect()),
        series: series.map(|(name, spans)| Series { name: (*name).to_owned(), data: Data::Spans(spans) }).collect(),
        limits: Vec::new(),
    }
}
