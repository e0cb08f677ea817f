//! Carries out experiments, and keeps what they find.

use super::sweep::{Row, Sweep};
use super::trials::{Effort, PRESETS};
use super::{EXPERIMENTS, Experiment};
use crate::study::chart::{Axis, Chart, Data, Limit, Point, Series};
use crate::study::machine::program;
use crate::study::{Cell, Console, Report, StudyError, Table};
use serde_json::{Value, json};
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// A hundredth of all trials.
    pub quick: bool,
    /// Experiments by id; all of them if there is none.
    pub only: Vec<String>,
    /// Where files go.
    pub out: PathBuf,
    /// Whether experiments that are found there are taken as done.
    pub resume: bool,
    /// Threads for trials.
    pub threads: NonZeroUsize,
}

/// What one experiment found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which one.
    pub id: &'static str,
    /// In words.
    pub title: &'static str,
    /// One after the other.
    pub sweeps: Vec<Sweep>,
}

impl Finding {
    /// Whether `robust` keeps every promise. An experiment that found nothing keeps none.
    pub fn holds(&self) -> bool {
        !self.sweeps.is_empty() && self.sweeps.iter().all(Sweep::holds)
    }
}

/// Whether all promises are kept: what the exit status tells.
pub fn all_hold(findings: &[Finding]) -> bool {
    findings.iter().all(Finding::holds)
}

/// Does what is asked. `show` is called with each experiment that is done and its report, of which the files are
/// written.
pub fn run(
    plan: &Plan,
    console: &Console,
    mut show: impl FnMut(&Finding, &Report) -> Result<(), StudyError>,
) -> Result<Vec<Finding>, StudyError> {
    let chosen = choose(&plan.only)?;
    std::fs::create_dir_all(&plan.out)?;
    let mut findings = Vec::new();
    for (done, experiment) in chosen.iter().enumerate() {
        console.step(done, chosen.len(), format_args!("{} {}", experiment.id, experiment.title))?;
        let kept = if plan.resume { resume(plan, experiment) } else { None };
        let is_new = kept.is_none();
        let finding = match kept {
            Some(finding) => finding,
            None => {
                let go_on = |part: f64| {
                    let what = format_args!("{} {}, {:.0} % of a row", experiment.id, experiment.title, 100.0 * part);
                    console.step(done, chosen.len(), what).is_ok()
                };
                let effort = Effort { quick: plan.quick, threads: plan.threads, go_on: &go_on };
                let sweeps = (experiment.run)(&effort);
                // What an interrupted experiment found is not kept.
                console.go_on()?;
                Finding { id: experiment.id, title: experiment.title, sweeps }
            }
        };
        let report = report(plan, experiment, &finding);
        if is_new {
            report.write(&plan.out)?;
        }
        console.clear();
        show(&finding, &report)?;
        findings.push(finding);
    }
    Ok(findings)
}

/// The experiments of these ids, in any case of letters.
fn choose(ids: &[String]) -> Result<Vec<&'static Experiment>, StudyError> {
    if ids.is_empty() {
        return Ok(EXPERIMENTS.iter().collect());
    }
    let named = |id: &String| {
        let found = EXPERIMENTS.iter().find(|experiment| experiment.id.eq_ignore_ascii_case(id));
        let last = EXPERIMENTS.last().map_or("", |experiment| experiment.id);
        found.ok_or_else(|| StudyError::Asked(format!("there is no experiment {id}; they are S1 to {last}")))
    };
    ids.iter().map(named).collect()
}

/// What an earlier run of the same kind, by this very program, left behind.
fn resume(plan: &Plan, experiment: &Experiment) -> Option<Finding> {
    let text = std::fs::read_to_string(plan.out.join(format!("{}.json", file_name(experiment)))).ok()?;
    let mut json: Value = serde_json::from_str(&text).ok()?;
    let settings = &json["settings"];
    let same = settings["program"] == of_program()? && settings["quick"] == plan.quick;
    let sweeps = same.then(|| json["summary"]["sweeps"].take())?;
    let sweeps = serde_json::from_value(sweeps).ok()?;
    Some(Finding { id: experiment.id, title: experiment.title, sweeps })
}

/// What is written of the program that found something; `None` if it cannot be read.
fn of_program() -> Option<String> {
    program().ok().map(|hash| format!("{hash:016x}"))
}

fn file_name(experiment: &Experiment) -> String {
    format!("stability-{}", experiment.id.to_ascii_lowercase())
}

fn report(plan: &Plan, experiment: &Experiment, finding: &Finding) -> Report {
    let mut report = Report::new(file_name(experiment));
    report.set("quick", plan.quick);
    report.set("program", of_program());
    report.set("oracle", experiment.oracle);
    report.summary = json!({ "holds": finding.holds(), "sweeps": finding.sweeps });
    report.notes.extend(alike(finding).map(str::to_owned));
    let mut columns = vec!["measure", "axis", "difficulty", "trials"];
    columns.extend(PRESETS);
    columns.extend(["threshold", "holds"]);
    report.samples = Table::new("", &columns);
    for (index, sweep) in finding.sweeps.iter().enumerate() {
        let mut columns = vec![sweep.axis.as_str(), "trials"];
        columns.extend(PRESETS);
        columns.extend(["at most", ""]);
        let mut table = Table::new(format!("{} {}: {}", experiment.id, experiment.title, sweep.measure), &columns);
        for row in &sweep.rows {
            let values = row.values.map(Cell::from);
            let numbers = [&[row.difficulty.into(), row.trials.into()], &values[..], &[row.threshold.into()]].concat();
            let verdict = if row.holds() { "" } else { "missed" };
            table.push([&numbers[..], &[verdict.into()]].concat());
            let text = [sweep.measure.as_str().into(), sweep.axis.as_str().into()];
            report.samples.push([&text[..], &numbers, &[row.holds().to_string().into()]].concat());
        }
        report.tables.push(table);
        if !sweep.note.is_empty() {
            report.notes.push(format!("{}: {}", sweep.measure, sweep.note));
        }
        let ending = if index == 0 { String::new() } else { slug(&sweep.measure, index) };
        report.chart(ending, chart(experiment, sweep));
    }
    report
}

/// Why presets do not differ, where they do not.
fn alike(finding: &Finding) -> Option<&'static str> {
    let same =
        |a: usize, b: usize| finding.sweeps.iter().flat_map(|s| &s.rows).all(|row| row.values[a] == row.values[b]);
    match (same(0, 1), same(0, 2)) {
        (true, true) => Some("all presets are alike here: they share this code, or none fails"),
        (true, false) => Some(
            "classic and fast are alike here: as presets of the renderer they share the school formulas of shapes in f32, and \
             differ in triangles, offsets, shadow rays, refraction and highlights",
        ),
        _ => None,
    }
}

/// What a file may be called after a measure.
fn slug(measure: &str, index: usize) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
    let words: String = measure.chars().map(plain).collect();
    format!("{}-{}", index + 1, words.split_whitespace().collect::<Vec<_>>().join("-"))
}

/// All presets in one picture, double logarithmic, with the threshold of `robust`.
fn chart(experiment: &Experiment, sweep: &Sweep) -> Chart {
    let line = |preset: usize| sweep.rows.iter().map(|row| Point::new(row.difficulty, row.values[preset])).collect();
    // A line each, always in the same colours; those of the same values are drawn over each other and say so.
    let mut series: Vec<Series> = Vec::new();
    for (preset, name) in PRESETS.into_iter().enumerate() {
        let data = Data::Line(line(preset));
        let same = series.iter().position(|other| other.data == data).map(|first| PRESETS[first]);
        let name = same.map_or(name.to_owned(), |first| format!("{name} (as {first})"));
        series.push(Series { name, data });
    }
    // Nothing of nothing is no line on logarithmic paper: the lower end of the chart is 0.
    let limits: Vec<f64> = sweep.rows.iter().filter_map(|row| row.threshold).filter(|&t| t > 0.0).collect();
    let even = limits.windows(2).all(|pair| pair[0] == pair[1]);
    let mut chart_limits = Vec::new();
    match limits.first() {
        Some(&y) if even => chart_limits.push(Limit { name: "robust: at most".into(), y }),
        Some(_) => {
            let points = |row: &Row| Some((row.difficulty, row.threshold?));
            let guide = sweep.rows.iter().filter_map(points).collect();
            series.push(Series { name: "robust: at most".into(), data: Data::Guide(guide) });
        }
        None => {}
    }
    Chart {
        title: format!("{} {}: {}", experiment.id, experiment.title, sweep.measure),
        subtitle: format!("oracle: {}; hollow, at the lower end: 0", experiment.oracle),
        x: Axis::log(sweep.axis.as_str()),
        y: Axis::log(sweep.measure.as_str()),
        series,
        limits: chart_limits,
    }
}

/// One line for each experiment.
pub fn summary(findings: &[Finding]) -> Table {
    let columns = ["", "experiment", "trials", "classic", "fast", "robust", "reference", "robust holds"];
    let mut table = Table::new("Rows in which each preset stays within the thresholds of robust", &columns);
    for finding in findings {
        let rows = || finding.sweeps.iter().flat_map(|sweep| &sweep.rows).filter(|row| row.threshold.is_some());
        let within = |preset: usize| {
            let kept = rows().filter(|row| row.is_within(preset)).count();
            Cell::from(format!("{kept}/{}", rows().count()))
        };
        let trials: u64 = finding.sweeps.iter().flat_map(|sweep| &sweep.rows).map(|row| row.trials).sum();
        let verdict = if finding.holds() { "yes" } else { "NO" };
        let mut line = vec![finding.id.into(), finding.title.into(), trials.into()];
        line.extend((0..4).map(within));
        line.push(verdict.into());
        table.push(line);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(robust: f64, threshold: f64) -> Finding {
        let row = Row { difficulty: 10.0, trials: 100, values: [1.0, 0.5, robust, 0.0], threshold: Some(threshold) };
        let sweep = Sweep::new("wrong", "distance", vec![row.clone(), Row { threshold: None, ..row }]);
        Finding { id: "S1", title: "test", sweeps: vec![sweep] }
    }

    #[test]
    fn a_missed_threshold_fails_the_study_and_is_seen_in_the_summary() {
        let (kept, missed) = (finding(0.0, 0.0), finding(1e-6, 0.0));
        assert!(all_hold(&[kept.clone(), finding(0.1, 0.1)]));
        assert!(!all_hold(&[kept.clone(), missed.clone()]));
        // Of the other presets nothing is asked; of robust no NaN is accepted; nor is an experiment without trials.
        assert!(!finding(f64::NAN, 1.0).holds());
        assert!(!Finding { sweeps: vec![], ..kept.clone() }.holds());
        let mut untried = kept.clone();
        untried.sweeps[0].rows[0].trials = 0;
        assert!(!untried.holds());
        // A reader is told why two lines of a chart are one.
        assert_eq!(alike(&missed), None);
        let mut shared = missed.clone();
        shared.sweeps[0].rows.iter_mut().for_each(|row| row.values[1] = row.values[0]);
        assert!(alike(&shared).is_some_and(|note| note.starts_with("classic and fast")));
        let text = summary(&[kept, missed]).to_string();
        assert!(text.contains("yes") && text.contains("NO") && text.contains("0/1"), "{text}");
    }

    #[test]
    fn findings_are_kept_in_files_and_taken_up_again() {
        let out = std::env::temp_dir().join(format!("glimt-stability-test-{}", std::process::id()));
        let only = vec!["s20".to_owned()];
        let mut plan = Plan { quick: true, only, out: out.clone(), resume: false, threads: NonZeroUsize::MIN };
        let console = Console::new(&|| false, true);
        let first = run(&plan, &console, |_, _| Ok(())).unwrap();
        assert!(all_hold(&first) && first.len() == 1);
        for file in ["stability-s20.csv", "stability-s20.json", "stability-s20.png", "stability-s20.svg"] {
            assert!(out.join(file).exists(), "{file}");
        }
        // What is found there is believed, so that it is this that comes back.
        let path = out.join("stability-s20.json");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("codes that do not survive", "codes that were read")).unwrap();
        plan.resume = true;
        assert_eq!(run(&plan, &console, |_, _| Ok(())).unwrap()[0].sweeps[0].measure, "codes that were read");
        // But not that of another program or another kind of run.
        let of_other = std::fs::read_to_string(&path).unwrap().replace(&of_program().unwrap(), "0123456789abcdef");
        std::fs::write(&path, of_other).unwrap();
        assert_eq!(run(&plan, &console, |_, _| Ok(())).unwrap()[0].sweeps[0].measure, "codes that do not survive");
        plan.quick = false;
        assert_eq!(run(&plan, &console, |_, _| Ok(())).unwrap()[0].sweeps[0].measure, "codes that do not survive");
        plan.only = vec!["S99".to_owned()];
        assert!(matches!(run(&plan, &console, |_, _| Ok(())), Err(StudyError::Asked(_))));
        std::fs::remove_dir_all(out).ok();
    }

    #[test]
    fn who_asks_to_stop_gets_no_findings() {
        let out = std::env::temp_dir().join(format!("glimt-stability-stop-{}", std::process::id()));
        let plan = Plan { quick: true, only: vec![], out: out.clone(), resume: false, threads: NonZeroUsize::MIN };
        let asked = std::cell::Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > 5
        };
        let outcome = run(&plan, &Console::new(&stop, true), |_, _| Ok(()));
        assert!(matches!(outcome, Err(StudyError::Interrupted)));
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0, "half an experiment was written");
        std::fs::remove_dir_all(out).ok();
    }
}
