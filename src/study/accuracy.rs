//! What accuracy costs: the error of a picture against the time that it took, over settings.

use super::chart::{Axis, Chart, Data, Limit, Point, Series};
use super::metrics::{Difference, difference};
use super::reference::{Reference, reference};
use super::sweep::{Sampling, Setting, Sweep};
use super::{Cell, Console, Plan, Report, Stats, StudyError, SystemClock, Table, four_figures, render};
use crate::description::{Numerics, SceneDesc};
use crate::render::Settings;
use crate::scene::compile;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// What a setting came to.
struct Outcome {
    setting: Setting,
    /// By round.
    times: Vec<f64>,
    seconds: Stats,
    error: Difference,
    rays: u64,
    /// Whether nothing faster is better.
    on_front: bool,
}

/// Renders the scene in every setting of the sweep and compares the pictures with a reference, which is kept in
/// `cache`.
pub fn accuracy(desc: &SceneDesc, sweep: &Sweep, cache: &Path, console: &Console) -> Result<Report, StudyError> {
    let mut report = Report::new("accuracy");
    let own = Setting::of(&desc.render);
    let sweep = sweep.with(own);
    let settings = sweep.settings(own);
    report.set("size", vec![desc.film.width, desc.film.height]);
    report.set("repeats", sweep.repeats);
    report.set("settings", settings.len());
    report.set("own", own.name());
    let base = compile(desc, None)?;
    // The most accurate setting decides how good the reference must be.
    let most = sweep.samples.iter().copied().max().unwrap_or(1);
    let least = sweep.errors.iter().copied().min_by(f64::total_cmp);
    let candidates = [Some(Sampling::Uniform(most)), least.map(Sampling::Adaptive)];
    let scene_of = |setting: &Setting| {
        let changed = SceneDesc { render: setting.render(&desc.render), ..desc.clone() };
        compile(&changed, Some(&base)).map(Arc::new)
    };
    let mut probes = Vec::new();
    for sampling in candidates.into_iter().flatten() {
        console.step(0, 0, format_args!("the most accurate: {}", sampling.name()))?;
        let setting = Setting { sampling, ..own };
        probes.push(render(&scene_of(&setting)?, Settings::default(), console, |_| {})?.film);
    }
    // Nothing that is measured may be more exact than the reference.
    let deepest = sweep.depths.iter().copied().fold(own.max_depth, u32::max);
    let enough = (most, sweep.reference_samples);
    let reference = reference(desc, &base, &probes, deepest, enough, cache, console)?;
    let plan = Plan { settings: settings.len(), rounds: sweep.repeats, warm_up: 0, seed: 3 };
    let (mut done, total) = (0, settings.len() * sweep.repeats);
    let mut errors: Vec<Option<(Difference, u64)>> = vec![None; settings.len()];
    let runs = plan.measure(&SystemClock::default(), |index| {
        console.step(done, total, settings[index].name())?;
        done += 1;
        let trial = render(&scene_of(&settings[index])?, Settings::default(), console, |_| {})?;
        if errors[index].is_none() {
            // Pictures are the same in every round.
            errors[index] = difference(&trial.film, &reference.film).map(|error| (error, trial.progress.rays.total()));
        }
        Ok::<_, StudyError>(trial.time)
    })?;
    console.clear();
    let mut outcomes = Vec::new();
    for ((setting, runs), found) in settings.iter().zip(&runs).zip(errors) {
        let times: Vec<f64> = runs.iter().map(|run| run.value.as_secs_f64()).collect();
        if let (Some(seconds), Some((error, rays))) = (Stats::of(&times), found) {
            outcomes.push(Outcome { setting: *setting, times, seconds, error, rays, on_front: false });
        }
    }
    mark_front(&mut outcomes);
    report.samples = Table::new(
        "",
        &[
            "shading",
            "numerics",
            "depth",
            "sampling",
            "round",
            "time (s)",
            "rays",
            "RMSE (codes)",
            "RMSE (linear)",
            "PSNR (dB)",
            "largest (codes)",
            "FLIP",
            "on front",
        ],
    );
    for (outcome, runs) in outcomes.iter().zip(&runs) {
        let Outcome { setting, error, .. } = outcome;
        for run in runs {
            report.samples.push([
                setting.shading.name().into(),
                setting.numerics.name().into(),
                setting.max_depth.into(),
                setting.sampling.name().into(),
                run.round.into(),
                run.value.as_secs_f64().into(),
                outcome.rays.into(),
                error.rmse.into(),
                error.rmse_linear.into(),
                Some(error.psnr).filter(|psnr| psnr.is_finite()).into(),
                error.max.into(),
                error.flip.into(),
                u64::from(outcome.on_front).into(),
            ] as [Cell; 13]);
        }
    }
    tell(&mut report, own, &sweep, &outcomes, &reference);
    Ok(report)
}

fn mark_front(outcomes: &mut [Outcome]) {
    let mut order: Vec<usize> = (0..outcomes.len()).collect();
    order.sort_by(|a, b| {
        let key = |i: &usize| (outcomes[*i].seconds.median, outcomes[*i].error.rmse);
        let ((t, e), (u, f)) = (key(a), key(b));
        t.total_cmp(&u).then(e.total_cmp(&f))
    });
    let mut best = f64::INFINITY;
    for index in order {
        let error = outcomes[index].error.rmse;
        outcomes[index].on_front = error < best;
        best = best.min(error);
    }
}

/// The fastest of those whose error is below.
fn cheapest(outcomes: &[Outcome], below: f64) -> Option<&Outcome> {
    let good = outcomes.iter().filter(|outcome| outcome.error.rmse < below);
    good.min_by(|a, b| a.seconds.median.total_cmp(&b.seconds.median))
}

/// What the scene's own settings cost until the error is `below`, with uniform and with adaptive sampling.
struct Gain {
    /// Seconds.
    uniform: Stats,
    adaptive: Stats,
    /// Uniform over adaptive time, in each round.
    ratio: Stats,
    /// The same of rays.
    rays: f64,
}

impl Gain {
    /// `None` if one of them does not pass through that error.
    fn at(below: f64, own: Setting, outcomes: &[Outcome]) -> Option<Self> {
        let of_own = |outcome: &&Outcome| Setting { sampling: own.sampling, ..outcome.setting } == own;
        let (adaptive, uniform): (Vec<&Outcome>, Vec<&Outcome>) = outcomes
            .iter()
            .filter(of_own)
            .partition(|outcome| matches!(outcome.setting.sampling, Sampling::Adaptive(_)));
        let cost = |curve: &[&Outcome], cost: &dyn Fn(&Outcome) -> f64| {
            let points: Vec<(f64, f64)> = curve.iter().map(|outcome| (cost(outcome), outcome.error.rmse)).collect();
            cost_of(below, &points)
        };
        let rounds = uniform.first()?.times.len();
        let in_rounds = |curve: &[&Outcome]| -> Option<Vec<f64>> {
            (0..rounds).map(|round| cost(curve, &|outcome| outcome.times[round])).collect()
        };
        let (slow, quick) = (in_rounds(&uniform)?, in_rounds(&adaptive)?);
        let ratios: Vec<f64> = slow.iter().zip(&quick).map(|(slow, quick)| slow / quick).collect();
        let rays = |curve: &[&Outcome]| cost(curve, &|outcome| outcome.rays as f64);
        Some(Self {
            uniform: Stats::of(&slow)?,
            adaptive: Stats::of(&quick)?,
            ratio: Stats::of(&ratios)?,
            rays: rays(&uniform)? / rays(&adaptive)?,
        })
    }
}

/// What an error costs on a curve through points of cost and error: between two of them as a power law.
fn cost_of(error: f64, points: &[(f64, f64)]) -> Option<f64> {
    let mut points = points.to_vec();
    points.sort_by(|a, b| b.1.total_cmp(&a.1));
    let after = points.iter().position(|point| point.1 <= error)?;
    let ((cheap, large), (dear, small)) = (points[after.checked_sub(1)?], points[after]);
    let part = if large > small { (large / error).ln() / (large / small).ln() } else { 1.0 };
    Some(cheap * (dear / cheap).powf(part))
}

fn tell(report: &mut Report, own: Setting, sweep: &Sweep, outcomes: &[Outcome], reference: &Reference) {
    let columns = ["setting", "time (s)", "MAD (s)", "RMSE (codes)", "PSNR (dB)", "FLIP", "rays", "front"];
    let row = |outcome: &Outcome| {
        [
            outcome.setting.name().into(),
            outcome.seconds.median.into(),
            outcome.seconds.mad.into(),
            outcome.error.rmse.into(),
            Some(outcome.error.psnr).filter(|psnr| psnr.is_finite()).into(),
            outcome.error.flip.into(),
            outcome.rays.into(),
            if outcome.on_front { "*" } else { "" }.into(),
        ] as [Cell; 8]
    };
    let mut all = Table::new("Error against the reference, and time", &columns);
    outcomes.iter().for_each(|outcome| all.push(row(outcome)));
    let mut front = Table::new("Pareto front: nothing faster has a smaller error", &columns);
    let mut on_front: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.on_front).collect();
    on_front.sort_by(|a, b| a.seconds.median.total_cmp(&b.seconds.median));
    on_front.iter().for_each(|outcome| front.push(row(outcome)));
    report.tables = vec![all, front];
    let smallest = outcomes.iter().map(|outcome| outcome.error.rmse).fold(f64::INFINITY, f64::min);
    let answer = cheapest(outcomes, sweep.below);
    report.notes.push(match answer {
        Some(outcome) => format!(
            "The cheapest setting below {} codes: {}; RMSE {} in {} s.",
            sweep.below,
            outcome.setting.name(),
            four_figures(outcome.error.rmse),
            four_figures(outcome.seconds.median)
        ),
        None => format!("No setting comes below {} codes; the smallest is {}.", sweep.below, four_figures(smallest)),
    });
    let gain = Gain::at(sweep.below, own, outcomes);
    if let Some(gain) = &gain {
        report.notes.push(format!(
            "To {} codes with the scene's own settings: {} s with uniform samples, {} s where the picture is wrong: {} \
             times shorter (median of the rounds, MAD {}), with {} times fewer rays. Between two measured errors the cost \
             is taken for a power of the error.",
            sweep.below,
            four_figures(gain.uniform.median),
            four_figures(gain.adaptive.median),
            four_figures(gain.ratio.median),
            four_figures(gain.ratio.mad),
            four_figures(gain.rays),
        ));
    }
    report.notes.push(format!(
        "Reference: {} numerics, depth {}, {} samples a pixel{}; its own error is about {} codes, {} of the \
         smallest measured.",
        Numerics::Reference.name(),
        reference.max_depth,
        reference.samples,
        if reference.cached { " (from the cache)" } else { "" },
        four_figures(reference.error),
        four_figures(reference.error / smallest),
    ));
    if outcomes.iter().any(|outcome| outcome.setting.shading != own.shading) {
        report.notes.push(format!(
            "Models other than the scene's own ({}) converge to another picture: their curves level off at that error.",
            own.shading.name()
        ));
    }
    let entry = |outcome: &Outcome| {
        json!({
            "setting": outcome.setting.name(), "seconds": outcome.seconds, "error": outcome.error,
            "rays": outcome.rays, "on_front": outcome.on_front,
        })
    };
    report.summary = json!({
        "reference": {
            "samples": reference.samples, "max_depth": reference.max_depth, "error": reference.error,
            "share_of_smallest": reference.error / smallest,
        },
        "below": sweep.below,
        "cheapest": answer.map(entry),
        "gain": gain.map(|gain| json!({
            "uniform_seconds": gain.uniform, "adaptive_seconds": gain.adaptive, "ratio": gain.ratio, "rays": gain.rays,
        })),
        "settings": outcomes.iter().map(entry).collect::<Vec<_>>(),
    });
    let kinds = [
        ("", "What accuracy costs: lighting models", CODES, Vary::Shading),
        ("numerics", "What accuracy costs: arithmetic", CODES, Vary::Numerics),
        ("depth", "What accuracy costs: depth of ray trees", CODES, Vary::Depth),
        ("flip", "What accuracy costs: as it looks", "FLIP", Vary::Shading),
    ];
    for (ending, title, label, vary) in kinds {
        let mut chart = Chart {
            title: title.to_owned(),
            subtitle: format!("{}; marks are numbers of samples or error targets", report.machine.cpu),
            x: Axis::log("time (s)"),
            y: Axis::log(label),
            series: curves(own, outcomes, vary, label),
            limits: Vec::new(),
        };
        if label == CODES {
            let front = on_front.iter().map(|outcome| (outcome.seconds.median, outcome.error.rmse)).collect();
            chart.series.push(Series { name: "Pareto front of all".to_owned(), data: Data::Guide(front) });
            chart.limits.push(Limit { name: format!("{} codes", sweep.below), y: sweep.below });
        }
        report.chart(ending, chart);
    }
}

const CODES: &str = "RMSE (8-bit codes)";

/// What differs between the curves of a chart.
#[derive(Clone, Copy, PartialEq)]
enum Vary {
    Shading,
    Numerics,
    Depth,
}

/// The outcomes that differ from the scene's own settings in nothing but samples and what varies.
fn curves(own: Setting, outcomes: &[Outcome], vary: Vary, label: &str) -> Vec<Series> {
    let mut curves: Vec<(String, Vec<Point>)> = Vec::new();
    for outcome in outcomes {
        let s = outcome.setting;
        let others_are_own = (vary == Vary::Shading || s.shading == own.shading)
            && (vary == Vary::Numerics || s.numerics == own.numerics)
            && (vary == Vary::Depth || s.max_depth == own.max_depth);
        if !others_are_own {
            continue;
        }
        let is_adaptive = matches!(s.sampling, Sampling::Adaptive(_));
        let name = match vary {
            Vary::Shading => s.shading.name().to_owned(),
            Vary::Numerics => s.numerics.name().to_owned(),
            Vary::Depth => format!("depth {}", s.max_depth),
        };
        // Both kinds of sampling for the scene's own model; elsewhere adaptive ones would hide the rest.
        let name = match (vary, is_adaptive) {
            (_, false) => name,
            (Vary::Shading, true) if s.shading == own.shading => format!("{name}, adaptive"),
            _ => continue,
        };
        let error = if label == CODES { outcome.error.rmse } else { outcome.error.flip };
        let point = Point::new(outcome.seconds.median, error);
        match curves.iter_mut().find(|(known, _)| *known == name) {
            Some((_, points)) => points.push(point),
            None => curves.push((name, vec![point])),
        }
    }
    curves.into_iter().map(|(name, points)| Series { name, data: Data::Line(points) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::RenderDesc;

    fn outcome(time: f64, rmse: f64) -> Outcome {
        Outcome {
            setting: Setting::of(&RenderDesc::default()),
            times: vec![time],
            seconds: Stats::of(&[time]).unwrap(),
            error: Difference { rmse, rmse_linear: 0.0, psnr: 0.0, max: 0.0, flip: 0.0 },
            rays: 0,
            on_front: false,
        }
    }

    #[test]
    fn the_front_is_what_nothing_faster_beats_and_the_cheapest_lies_on_it() {
        let pairs = [(1.0, 8.0), (3.0, 2.0), (2.0, 4.0), (2.5, 5.0), (4.0, 2.0), (9.0, 0.5), (2.0, 3.0)];
        let mut outcomes: Vec<Outcome> = pairs.iter().map(|&(time, rmse)| outcome(time, rmse)).collect();
        mark_front(&mut outcomes);
        let front: Vec<bool> = outcomes.iter().map(|outcome| outcome.on_front).collect();
        assert_eq!(front, [true, true, false, false, false, true, true]);
        let time = |below| cheapest(&outcomes, below).map(|outcome| outcome.seconds.median);
        assert_eq!((time(100.0), time(3.5), time(2.0), time(0.1)), (Some(1.0), Some(2.0), Some(9.0), None));
    }

    #[test]
    fn the_gain_is_the_ratio_of_costs_at_the_same_error() {
        // 8 / n^(3/4) codes for n seconds, and a fifth of the time for the same.
        let own = Setting { sampling: Sampling::Uniform(1), ..Setting::of(&RenderDesc::default()) };
        let error = |n: f64| 8.0 / n.powf(0.75);
        let of = |sampling, time: f64, rmse| Outcome { setting: Setting { sampling, ..own }, ..outcome(time, rmse) };
        let uniform = [1u32, 4, 16, 64].map(|n| of(Sampling::Uniform(n), n.into(), error(n.into())));
        let adaptive = [4.0, 0.5].map(|e: f64| of(Sampling::Adaptive(e), (8.0 / e).powf(4.0 / 3.0) / 5.0, e));
        let mut outcomes: Vec<Outcome> = uniform.into_iter().chain(adaptive).collect();
        let gain = Gain::at(1.0, own, &outcomes).unwrap();
        assert!((gain.uniform.median - 16.0).abs() < 1e-9 && (gain.ratio.median - 5.0).abs() < 1e-9);
        // Beyond what was measured nothing is known.
        assert!(Gain::at(0.1, own, &outcomes).is_none() && Gain::at(8.1, own, &outcomes).is_none());
        // Other settings are no part of it.
        outcomes.push(Outcome { setting: Setting { max_depth: 1, ..own }, ..outcome(1e-3, 1.0) });
        assert!((Gain::at(1.0, own, &outcomes).unwrap().ratio.median - 5.0).abs() < 1e-9);
    }
}
