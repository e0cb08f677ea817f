//! Progress on stderr.

use crate::render::{Eta, Progress, Settings};
use crate::scene::Scene;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// How progress is told.
pub enum Meter {
    /// Not at all.
    Quiet,
    /// A bar that is redrawn, on a terminal.
    Bar(ProgressBar),
    /// A line at every tenth, for logs.
    Lines {
        /// The last tenth that was told.
        tenth: u32,
        /// When.
        last: Instant,
    },
}

/// Least time between two lines, so that a quick render does not fill a log.
const LINE_INTERVAL: Duration = Duration::from_secs(1);

impl Meter {
    /// What suits stderr. Lines begin with one that says what is being done.
    pub fn new(quiet: bool, scene: &Scene, settings: Settings, now: Instant) -> Self {
        if quiet {
            return Self::Quiet;
        }
        let style = ProgressStyle::with_template("[{bar:30}] {msg}").map(|style| style.progress_chars("=> "));
        match style {
            Ok(style) if io::stderr().is_terminal() => {
                let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr_with_hz(10));
                Self::Bar(bar.with_style(style))
            }
            _ => {
                let (width, height) = (scene.width, scene.height);
                let plural = |number: usize| if number == 1 { "" } else { "s" };
                let threads = settings.threads.get();
                let samples = scene.render.samples;
                let aim = match scene.render.error {
                    Some(error) if error > 0.0 => format!("to an error of {error} of 255"),
                    Some(_) => "as well as time allows".to_owned(),
                    None => format!("{samples} sample{} a pixel", plural(samples as usize)),
                };
                let isa = scene.isa().name();
                tell(format_args!("rendering {width}x{height}, {aim}, {threads} thread{}, {isa}", plural(threads)));
                Self::Lines { tenth: 0, last: now }
            }
        }
    }

    /// Tells how far the render is, if it is time to.
    pub fn show(&mut self, progress: &Progress, now: Instant) {
        match self {
            Self::Quiet => {}
            Self::Bar(bar) => {
                bar.set_length(1000);
                bar.set_position((1000.0 * progress.part()) as u64);
                bar.set_message(line(progress, now));
            }
            Self::Lines { tenth, last } => {
                let reached = progress.percent() / 10;
                if reached > *tenth && reached < 10 && now.saturating_duration_since(*last) >= LINE_INTERVAL {
                    (*tenth, *last) = (reached, now);
                    tell(line(progress, now));
                }
            }
        }
    }

    /// Takes the bar away.
    pub fn end(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// A line on stderr. Who closed it does not want to know.
fn tell(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// "42 %, 12 s gone, 15 to 18 s left".
fn line(progress: &Progress, now: Instant) -> String {
    let gone = span(progress.elapsed(now));
    let left = progress.eta(now).map_or(String::new(), |eta| format!(", {} left", range(eta)));
    let error = progress.error().map_or(String::new(), |error| format!(", error {error:.2} of 255"));
    format!("{} %, {gone} gone{left}{error}", progress.percent())
}

/// "12 s to 15 s": whole seconds, outward.
fn range(eta: Eta) -> String {
    let whole = |seconds: u64| span(Duration::from_secs(seconds.max(1)));
    let (low, high) = (eta.low.as_secs(), eta.high.as_millis().div_ceil(1000) as u64);
    match (low, high) {
        (0, _) => format!("at most {}", whole(high)),
        (low, high) if whole(low) == whole(high) => whole(high),
        (low, high) => format!("{} to {}", whole(low), whole(high)),
    }
}

/// A time in two figures or so, rounded down: "850 ms", "12 s", "3 min 05 s", "2 h 07 min".
pub fn span(time: Duration) -> String {
    match time.as_secs() {
        0 => format!("{} ms", time.as_millis()),
        s @ 1..10 if time.subsec_millis() >= 100 => format!("{s}.{} s", time.subsec_millis() / 100),
        s @ 1..60 => format!("{s} s"),
        s @ 60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        s => format!("{} h {:02} min", s / 3600, s % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short_and_rounded_down() {
        let shown =
            [0.0, 0.8509, 1.999, 2.05, 59.9, 60.0, 3599.9, 3600.0, 90_061.0].map(Duration::from_secs_f64).map(span);
        let expected =
            ["0 ms", "850 ms", "1.9 s", "2 s", "59 s", "1 min 00 s", "59 min 59 s", "1 h 00 min", "25 h 01 min"];
        assert_eq!(shown, expected);
    }

    #[test]
    fn ranges_are_whole_seconds_outward() {
        let eta = |low, high| range(Eta { low: Duration::from_millis(low), high: Duration::from_millis(high) });
        assert_eq!(eta(0, 0), "at most 1 s");
        assert_eq!(eta(900, 2_100), "at most 3 s");
        assert_eq!(eta(9_900, 12_100), "9 s to 13 s");
        assert_eq!(eta(12_000, 12_000), "12 s");
        assert_eq!(eta(3_600_000, 3_610_000), "1 h 00 min");
    }
}
