//! How wrong the picture is, and when it will be right enough.

use super::{ErrorChange, Eta, Rect};
use std::time::Duration;

/// The estimated error of a picture over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Convergence {
    pixels: f64,
    /// Pixels of the tiles that can be judged, and the sum of their squared errors.
    judged: u64,
    sum: f64,
    history: Vec<(Duration, f64)>,
}

/// Between two points of the history lies at least this part of the time.
const SPACING: f64 = 1.0 / 32.0;

/// The slowest and the fastest that errors fall: as this power of the time. Independent samples give 1/2.
const SLOWEST: f64 = 0.5;
const FASTEST: f64 = 1.5;

/// How much faster or slower than so far the error may fall from now on.
const MARGIN: f64 = 1.3;

impl Convergence {
    pub fn of_pixels(pixels: u64) -> Self {
        Self { pixels: pixels as f64, ..Self::default() }
    }

    /// Takes in what a tile says of itself.
    pub fn learn(&mut self, rect: Rect, change: ErrorChange, elapsed: Duration) {
        if change.before.is_none() {
            self.judged += rect.area();
        }
        self.sum = (self.sum + change.now - change.before.unwrap_or_default()).max(0.0);
        self.note(elapsed);
    }

    /// Takes in what the whole picture says.
    pub fn judge(&mut self, error: f64, elapsed: Duration) {
        self.judged = self.pixels as u64;
        self.sum = error * error * self.pixels;
        self.history.push((elapsed, error));
    }

    fn note(&mut self, elapsed: Duration) {
        let last = self.history.last().map_or(Duration::ZERO, |(time, _)| *time);
        if let Some(error) = self.error()
            && elapsed.saturating_sub(last) >= elapsed.mul_f64(SPACING)
        {
            self.history.push((elapsed, error));
        }
    }

    /// Root mean square of the error, 8-bit codes; `None` before all of the picture can be judged.
    pub fn error(&self) -> Option<f64> {
        (self.judged as f64 >= self.pixels).then(|| (self.sum / self.pixels.max(1.0)).sqrt())
    }

    /// Time and error, in the order of time.
    pub fn history(&self) -> &[(Duration, f64)] {
        &self.history
    }

    /// Time until the error is down to `target`: errors fall as a power of the time.
    pub fn until(&self, target: f64, elapsed: Duration) -> Option<Eta> {
        let error = self.error()?;
        if error <= target {
            return Some(Eta { low: Duration::ZERO, high: Duration::ZERO });
        }
        // Over the last factor of 4 in time, if there is so much.
        let now = elapsed.as_secs_f64();
        let since = self.history.iter().find(|(time, _)| time.as_secs_f64() * 4.0 >= now)?;
        let (time, before) = (since.0.as_secs_f64(), since.1);
        let power = if before > error && now > 1.2 * time { (before / error).ln() / (now / time).ln() } else { 0.75 };
        let at = |power: f64| now * ((error / target).powf(1.0 / power.clamp(SLOWEST, FASTEST)) - 1.0);
        let duration = |seconds: f64| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Some(Eta { low: duration(at(power * MARGIN)), high: duration(at(power / MARGIN)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x: u32) -> Rect {
        Rect { x, y: 0, width: 8, height: 8 }
    }

    #[test]
    fn the_error_is_that_of_all_tiles_together_once_all_are_known() {
        let mut convergence = Convergence::of_pixels(128);
        let change = |before: Option<f64>, now: f64| ErrorChange { before: before.map(|b| 64.0 * b), now: 64.0 * now };
        convergence.learn(rect(0), change(None, 9.0), Duration::from_secs(1));
        assert_eq!(convergence.error(), None);
        convergence.learn(rect(8), change(None, 16.0), Duration::from_secs(2));
        assert_eq!(convergence.error(), Some(12.5f64.sqrt()));
        convergence.learn(rect(0), change(Some(9.0), 0.0), Duration::from_secs(3));
        assert_eq!(convergence.error(), Some(8f64.sqrt()));
        convergence.judge(0.5, Duration::from_secs(4));
        assert_eq!(convergence.error(), Some(0.5));
        assert_eq!(convergence.history().last(), Some(&(Duration::from_secs(4), 0.5)));
        // What the whole picture says holds, whatever the tiles said before.
        convergence.learn(rect(8), change(Some(0.25), 0.05), Duration::from_secs(5));
        assert!((convergence.error().unwrap() - 0.15f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn an_error_that_falls_as_a_power_of_the_time_crosses_the_target_within_the_range() {
        for power in [0.5, 0.75, 1.0, 1.5] {
            let mut convergence = Convergence::of_pixels(64);
            let mut before = None;
            let at = |t: f64| 8.0 * t.powf(-power);
            for i in 1..=40 {
                let time = 0.1 * 1.1f64.powi(i);
                let elapsed = Duration::from_secs_f64(time);
                let now = 64.0 * at(time).powi(2);
                convergence.learn(rect(0), ErrorChange { before: before.replace(now), now }, elapsed);
                let target = at(100.0);
                let eta = convergence.until(target, elapsed).unwrap();
                let truth = Duration::from_secs_f64(100.0 - time);
                if i > 15 {
                    let slack = Duration::from_millis(1);
                    assert!(eta.low <= truth + slack && truth <= eta.high + slack, "{power} at {time}: {eta:?}");
                }
            }
        }
    }

    #[test]
    fn a_long_render_keeps_a_short_history() {
        let mut convergence = Convergence::of_pixels(64);
        for i in 1..200_000u32 {
            let before = (i > 1).then_some(1.0);
            convergence.learn(rect(0), ErrorChange { before, now: 1.0 }, Duration::from_millis(i.into()));
        }
        assert!(convergence.history().len() < 500);
    }
}
