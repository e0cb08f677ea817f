//! How time and memory grow with triangles, spheres, lights, pixels and depth.

use super::chart::{Axis, Chart, Data, Point, Series};
use super::growth::Growing;
use super::memory::{forget_peak, held_and_peak};
use super::{Cell, Console, Plan, PowerLaw, Report, Stats, StudyError, SystemClock, Table, render};
use crate::render::Settings;
use serde_json::json;
use std::time::Instant;

/// One size of one thing that grows.
struct Size {
    growing: Growing,
    size: u64,
    build: Stats,
    trace: Stats,
    rays: u64,
    /// Bytes that the scene takes, and the most that building it took.
    memory: Option<(u64, u64)>,
}

struct Run {
    build: f64,
    trace: f64,
    rays: u64,
}

/// Less than this many bytes is lost in what else the process holds.
const SEEN: u64 = 1 << 20;
/// Times below are mostly start-up, seconds.
const MEASURABLE: f64 = 2e-3;

/// Builds and renders generated scenes; triangles and spheres up to `most`.
pub fn scale(quick: bool, most: u64, repeats: usize, console: &Console) -> Result<Report, StudyError> {
    let mut report = Report::new("scale");
    report.set("max", most);
    report.set("quick", quick);
    report.set("repeats", repeats);
    let columns =
        ["growing", "size", "round", "build (s)", "trace (s)", "rays", "memory (bytes)", "peak while building (bytes)"];
    report.samples = Table::new("", &columns);
    let mut sizes = Vec::new();
    for growing in Growing::ALL {
        sizes.extend(measure(growing, &growing.sizes(quick, most), repeats, console, &mut report.samples)?);
    }
    console.clear();
    tell(&mut report, &sizes);
    Ok(report)
}

fn measure(
    growing: Growing,
    sizes: &[u64],
    repeats: usize,
    console: &Console,
    samples: &mut Table,
) -> Result<Vec<Size>, StudyError> {
    let name = growing.name();
    // Memory is measured once, the small ones first: what large ones give back may be kept for later.
    let mut memory = Vec::new();
    for &size in sizes {
        console.step(0, 0, format_args!("memory of {size} {name}"))?;
        memory.push(taken(growing, size)?);
    }
    let plan = Plan { settings: sizes.len(), rounds: repeats, warm_up: 0, seed: 2 };
    let (mut done, total) = (0, sizes.len() * repeats);
    let runs = plan.measure(&SystemClock::default(), |index| {
        console.step(done, total, format_args!("{} {name}", sizes[index]))?;
        done += 1;
        let seed = growing.make(sizes[index])?;
        let begun = Instant::now();
        let scene = seed.compile()?;
        let build = begun.elapsed().as_secs_f64();
        let trial = render(&scene, Settings::default(), console, |_| {})?;
        Ok::<_, StudyError>(Run { build, trace: trial.time.as_secs_f64(), rays: trial.progress.rays.total() })
    })?;
    let mut measured = Vec::new();
    for ((&size, runs), memory) in sizes.iter().zip(&runs).zip(memory) {
        for run in runs {
            let Run { build, trace, rays } = run.value;
            samples.push([
                name.into(),
                size.into(),
                run.round.into(),
                build.into(),
                trace.into(),
                rays.into(),
                memory.map(|m| m.0).into(),
                memory.map(|m| m.1).into(),
            ] as [Cell; 8]);
        }
        let of = |f: fn(&Run) -> f64| Stats::of(&runs.iter().map(|run| f(&run.value)).collect::<Vec<_>>());
        if let (Some(build), Some(trace), Some(run)) = (of(|run| run.build), of(|run| run.trace), runs.first()) {
            measured.push(Size { growing, size, build, trace, rays: run.value.rays, memory });
        }
    }
    Ok(measured)
}

/// Bytes that a scene holds more than there were before it was made, and the most that building it held beyond that.
fn taken(growing: Growing, size: u64) -> Result<Option<(u64, u64)>, StudyError> {
    let before = held_and_peak();
    let seed = growing.make(size)?;
    forget_peak();
    let scene = seed.compile()?;
    let after = held_and_peak();
    drop(scene);
    Ok(before.zip(after).map(|((before, _), (held, peak))| (held.saturating_sub(before), peak.saturating_sub(before))))
}

/// The points of one quantity of one thing that grows, where they mean something.
fn points(sizes: &[Size], growing: Growing, quantity: fn(&Size) -> Option<f64>) -> Vec<(f64, f64)> {
    let of_it = sizes.iter().filter(|size| size.growing == growing);
    of_it.filter_map(|size| quantity(size).map(|value| (size.size as f64, value))).collect()
}

fn build(size: &Size) -> Option<f64> {
    Some(size.build.median).filter(|seconds| *seconds >= MEASURABLE)
}

fn trace(size: &Size) -> Option<f64> {
    Some(size.trace.median).filter(|seconds| *seconds >= MEASURABLE)
}

fn held(size: &Size) -> Option<f64> {
    size.memory.filter(|memory| memory.0 >= SEEN).map(|memory| memory.0 as f64)
}

fn peak(size: &Size) -> Option<f64> {
    size.memory.filter(|memory| memory.0 >= SEEN).map(|memory| memory.1 as f64)
}

type Quantity = (&'static str, fn(&Size) -> Option<f64>);

fn tell(report: &mut Report, sizes: &[Size]) {
    let mut table = Table::new(
        "Time and memory by size",
        &[
            "growing",
            "size",
            "build (ms)",
            "MAD (ms)",
            "trace (ms)",
            "MAD (ms)",
            "rays",
            "ns a ray",
            "memory (MB)",
            "bytes each",
        ],
    );
    for size in sizes {
        let memory = held(size);
        table.push([
            size.growing.name().into(),
            size.size.into(),
            (size.build.median * 1e3).into(),
            (size.build.mad * 1e3).into(),
            (size.trace.median * 1e3).into(),
            (size.trace.mad * 1e3).into(),
            size.rays.into(),
            (size.trace.median * 1e9 / size.rays.max(1) as f64).into(),
            memory.map(|bytes| bytes / 1e6).into(),
            memory.map(|bytes| bytes / size.size as f64).into(),
        ] as [Cell; 10]);
    }
    let mut laws =
        Table::new("Exponents: quantity ~ size^exponent", &["growing", "quantity", "exponent", "+-", "sizes"]);
    let mut summary = Vec::new();
    let in_objects: [Quantity; 4] =
        [("build time", build), ("trace time", trace), ("memory", held), ("peak while building", peak)];
    let in_tracing: [Quantity; 1] = [("trace time", trace)];
    for growing in Growing::ALL {
        let is_tree = matches!(growing, Growing::Triangles | Growing::Spheres);
        let quantities: &[Quantity] = if is_tree { &in_objects } else { &in_tracing };
        for (name, quantity) in quantities {
            let points = points(sizes, growing, *quantity);
            if let Some(law) = PowerLaw::fit(&points) {
                laws.push([
                    growing.name().into(),
                    (*name).into(),
                    law.exponent.into(),
                    law.error.into(),
                    points.len().into(),
                ] as [Cell; 5]);
                summary.push(json!({ "growing": growing.name(), "quantity": name, "law": law, "points": points }));
            }
        }
    }
    report.tables = vec![table, laws];
    report.summary = json!({ "laws": summary });
    report.notes = vec![
        "The picture stays the same while triangles and spheres grow (320x240, one sample, Whitted): the exponent of \
         trace time would be 1 without a hierarchy."
            .to_owned(),
        "Fitted are times from 2 ms on and memory from 1 MiB on. Peaks hold the model itself, too.".to_owned(),
    ];
    let series = |growing: Growing, (name, quantity): Quantity| Series {
        name: format!("{name}, {}", growing.name()),
        data: Data::Line(points(sizes, growing, quantity).into_iter().map(|(x, y)| Point::new(x, y)).collect()),
    };
    let (triangles, spheres) = (Growing::Triangles, Growing::Spheres);
    let machine = report.machine.cpu.clone();
    let chart = |title: &str, x: &str, y: &str, series: Vec<Series>| Chart {
        title: title.to_owned(),
        subtitle: machine.clone(),
        x: Axis::log(x),
        y: Axis::log(y),
        series,
        limits: Vec::new(),
    };
    let both = |quantities: [Quantity; 2]| {
        [triangles, spheres].into_iter().flat_map(|growing| quantities.map(|q| series(growing, q))).collect()
    };
    let time =
        chart("Time by number of objects", "triangles or spheres", "time (s)", both([in_objects[0], in_objects[1]]));
    let memory =
        chart("Memory by number of objects", "triangles or spheres", "bytes", both([in_objects[2], in_objects[3]]));
    let rest = [Growing::Lights, Growing::Pixels, Growing::Depth];
    let rest = rest.map(|growing| series(growing, in_tracing[0])).to_vec();
    let rest = chart("Trace time by lights, pixels and depth", "lights, pixels or depth", "time (s)", rest);
    report.chart("", time);
    report.chart("memory", memory);
    report.chart("lights-pixels-depth", rest);
}
