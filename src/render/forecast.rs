//! How long a render will yet take. Tested through [`Progress`](super::Progress).

use super::{Rect, TileStats};
use std::collections::{HashMap, VecDeque};
use std::time::Duration;

/// Time that is left, as a range: the least and the most that recent forecasts say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eta {
    /// By the quickest of the recent forecasts.
    pub low: Duration,
    /// By the slowest of the recent forecasts.
    pub high: Duration,
}

/// What is left, from what each tile has cost: every pass goes over all tiles, so the last visit to a tile tells what
/// the next will cost, and glass does not count like sky. Dividing by how many seconds of tracing fit in a second of
/// time gives the time that is left. How far recent forecasts of the whole time lie apart is the range.
#[derive(Clone, Debug, Default)]
pub(super) struct Forecast {
    tiles: HashMap<(u32, u32), TileCost>,
    /// Sum of what is left of all tiles known, seconds of tracing.
    work_left: f64,
    /// Seconds of tracing so far.
    work_done: f64,
    notes: VecDeque<Note>,
}

#[derive(Clone, Copy, Debug, Default)]
struct TileCost {
    samples_left: u64,
    /// Seconds of tracing to come.
    work_left: f64,
}

/// The forecast at one moment, seconds.
#[derive(Clone, Copy, Debug)]
struct Note {
    elapsed: f64,
    work_done: f64,
    total: f64,
}

/// Forecasts that make a range.
const NOTES: usize = 8;
/// Forecasts that are needed before a range is shown.
const NOTES_NEEDED: usize = 3;
/// Seconds between two forecasts at the start; later a share of the time gone, so that they span its last third.
const NOTE_INTERVAL: f64 = 0.25;
const NOTE_SHARE: f64 = 1.0 / 16.0;
/// How much of the time left every range is widened on both sides: no machine keeps its pace better than that.
const MARGIN: f64 = 0.05;
/// How far from the newest forecast older ones may pull the range: the machine was busy then with something else.
const FACTOR: f64 = 2.0;

impl Forecast {
    /// Takes in what a visit to a tile has cost.
    pub fn learn(&mut self, rect: Rect, stats: &TileStats, samples_per_pixel: u64) {
        let busy = stats.busy.as_secs_f64();
        self.work_done += busy;
        if stats.samples == 0 {
            return; // A narrow tile may have no point of a lattice.
        }
        let all = TileCost { samples_left: rect.area() * samples_per_pixel, ..TileCost::default() };
        let tile = self.tiles.entry((rect.x, rect.y)).or_insert(all);
        self.work_left -= tile.work_left;
        tile.samples_left = tile.samples_left.saturating_sub(stats.samples);
        tile.work_left = busy / stats.samples as f64 * tile.samples_left as f64;
        self.work_left += tile.work_left;
    }

    /// Keeps a forecast if it is time for one.
    pub fn note(&mut self, elapsed: Duration) {
        let elapsed = elapsed.as_secs_f64();
        let last = self.notes.back().map_or(0.0, |n| n.elapsed);
        if elapsed - last < (elapsed * NOTE_SHARE).max(NOTE_INTERVAL) {
            return;
        }
        let total = elapsed + self.left(elapsed);
        if self.notes.len() == NOTES {
            self.notes.pop_front();
        }
        self.notes.push_back(Note { elapsed, work_done: self.work_done, total });
    }

    /// Seconds left, at the pace since the oldest note.
    fn left(&self, elapsed: f64) -> f64 {
        let since = self.notes.front().map_or((0.0, 0.0), |n| (n.elapsed, n.work_done));
        let pace = (self.work_done - since.1) / (elapsed - since.0);
        // Rounding may leave a little less than nothing; no work in no time is no pace.
        if pace > 0.0 { self.work_left.max(0.0) / pace } else { 0.0 }
    }

    /// `None` until there are enough forecasts.
    pub fn eta(&self, elapsed: Duration) -> Option<Eta> {
        if self.notes.len() < NOTES_NEEDED {
            return None;
        }
        let elapsed = elapsed.as_secs_f64();
        let left = self.left(elapsed);
        let (low, high) = self
            .notes
            .iter()
            .map(|note| note.total - elapsed)
            .fold((left, left), |(low, high), l| (low.min(l), high.max(l)));
        let (low, high) = (low.max(left / FACTOR), high.min(left * FACTOR));
        let duration = |seconds: f64| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Some(Eta { low: duration(low * (1.0 - MARGIN)), high: duration(high * (1.0 + MARGIN)) })
    }
}
