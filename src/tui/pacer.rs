//! How much may be sent, and when, so that keys are echoed at once on a slow link too.
//!
//! Buffers between the program and the terminal (the pty's, sshd's, TCP's) swallow far more than the link carries in
//! the time between two keys, and a frame that they have swallowed cannot be recalled. So output goes in chunks of what
//! the link carries in [`CHUNK`]. Each ends with a question (`CSI 6n`), and the next one waits for the answer, which
//! comes when the terminal has really got everything. The cursor is hidden, so its column numbers the question.

use std::time::{Duration, Instant};

/// What a chunk may take on the link.
const CHUNK: Duration = Duration::from_millis(100);
/// An answer that takes longer is not waited for.
const PATIENCE: Duration = Duration::from_secs(3);
/// The same for the first answer, when it is not known yet whether the terminal gives any.
const FIRST_PATIENCE: Duration = Duration::from_secs(1);
/// Pause between chunks for terminals that have never answered.
const UNANSWERED: Duration = Duration::from_millis(50);
/// Limits of a chunk, bytes.
const SMALLEST: usize = 1 << 10;
const LARGEST: usize = 4 << 20;
/// The first chunk: small, so that its answer shows the round trip.
const FIRST: usize = SMALLEST;
/// Chunks to a terminal that does not answer.
const BLIND: usize = 8 << 10;
/// How fast the size of chunks may grow.
const GROWTH: usize = 4;

/// Decides on the size and the time of chunks. Knows no terminal and no clock.
#[derive(Debug)]
pub struct Pacer {
    allowance: usize,
    /// The quickest answer so far: the way there and back without waiting.
    round_trip: Option<Duration>,
    open: Option<Question>,
    next_column: u16,
    /// Whether a question was given up, and whether one was ever answered.
    gave_up: bool,
    answers: bool,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    column: u16,
    asked: Instant,
    bytes: usize,
}

impl Default for Pacer {
    fn default() -> Self {
        Self { allowance: FIRST, round_trip: None, open: None, next_column: 1, gave_up: false, answers: false }
    }
}

impl Pacer {
    /// How many bytes the next chunk may have.
    pub fn allowance(&self) -> usize {
        self.allowance
    }

    /// When a chunk may be sent even if no answer comes; `None`: at once.
    pub fn waits_until(&self) -> Option<Instant> {
        let patience = match (self.answers, self.gave_up) {
            (true, _) => PATIENCE,
            (false, false) => FIRST_PATIENCE,
            (false, true) => UNANSWERED,
        };
        self.open.map(|question| question.asked + patience)
    }

    /// Whether the last question will probably be answered.
    pub fn expects_answer(&self) -> bool {
        self.open.is_some() && (self.answers || !self.gave_up)
    }

    /// A chunk is about to be sent. Returns the column to put the cursor in for the question at its end, out of the
    /// `width` there are.
    pub fn send(&mut self, bytes: usize, width: u16, now: Instant) -> u16 {
        if self.open.is_some() {
            self.gave_up = true;
            self.allowance = if self.answers { self.allowance.min(BLIND) } else { BLIND };
        }
        let column = self.next_column.min(width).max(1);
        self.next_column = self.next_column % 8 + 1;
        self.open = Some(Question { column, asked: now, bytes });
        column
    }

    /// An answer came. Returns whether it was the one waited for.
    pub fn answer(&mut self, column: u16, now: Instant) -> bool {
        self.answers = true;
        let Some(question) = self.open.take_if(|question| question.column == column) else { return false };
        let took = now.saturating_duration_since(question.asked);
        let round_trip = self.round_trip.map_or(took, |quickest| quickest.min(took));
        self.round_trip = Some(round_trip);
        // Only a chunk that used what it was allowed shows how fast the link is.
        if question.bytes * 4 >= self.allowance * 3 {
            let on_the_link = (took - round_trip).max(Duration::from_millis(1));
            let fitting = question.bytes as f64 * CHUNK.as_secs_f64() / on_the_link.as_secs_f64();
            let wanted = (fitting as usize).min(self.allowance.saturating_mul(GROWTH));
            self.allowance = wanted.clamp(SMALLEST, LARGEST);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sends full chunks over a link of `rate` bytes a second; returns the time of each chunk from the ninth on.
    fn link(rate: f64, round_trip: Duration) -> Vec<Duration> {
        let (mut pacer, mut now, mut times) = (Pacer::default(), Instant::now(), Vec::new());
        for i in 0..40 {
            // Now and then there is little to say.
            let bytes = if i % 5 == 4 { 200 } else { pacer.allowance() };
            let column = pacer.send(bytes, 80, now);
            let took = round_trip + Duration::from_secs_f64(bytes as f64 / rate);
            now += took;
            assert!(pacer.answer(column, now));
            if i > 8 && bytes > 200 {
                times.push(took);
            }
        }
        times
    }

    #[test]
    fn chunks_take_a_tenth_of_a_second_on_any_link() {
        for rate in [10e3, 30e3, 200e3, 2e6] {
            for round_trip in [1, 20, 50, 200, 400] {
                let round_trip = Duration::from_millis(round_trip);
                for took in link(rate, round_trip) {
                    let sending = (took - round_trip).as_secs_f64();
                    assert!((0.05..0.25).contains(&sending), "{rate} {round_trip:?}: {sending}");
                }
            }
        }
    }

    #[test]
    fn a_fast_link_gets_large_chunks() {
        let (mut pacer, mut now) = (Pacer::default(), Instant::now());
        for _ in 0..20 {
            let column = pacer.send(pacer.allowance(), 80, now);
            now += Duration::from_micros(300);
            pacer.answer(column, now);
        }
        assert_eq!(pacer.allowance(), LARGEST);
    }

    #[test]
    fn a_late_answer_is_not_taken_for_that_of_the_next_chunk() {
        let (mut pacer, now) = (Pacer::default(), Instant::now());
        let first = pacer.send(100, 80, now);
        let second = pacer.send(100, 80, now + PATIENCE);
        assert!(!pacer.answer(first, now + PATIENCE));
        assert!(pacer.waits_until().is_some());
        assert!(pacer.answer(second, now + PATIENCE));
        assert_eq!(pacer.waits_until(), None);
    }

    #[test]
    fn a_terminal_that_never_answers_is_waited_for_only_once() {
        let (mut pacer, mut now) = (Pacer::default(), Instant::now());
        let mut waits = Vec::new();
        for _ in 0..4 {
            pacer.send(pacer.allowance(), 80, now);
            let until = pacer.waits_until().unwrap_or(now);
            waits.push(until - now);
            now = until;
        }
        assert_eq!(waits, [FIRST_PATIENCE, UNANSWERED, UNANSWERED, UNANSWERED]);
        assert_eq!(pacer.allowance(), BLIND);
        // One answer, however late, and its answers are waited for again.
        pacer.answer(1, now);
        assert_eq!(pacer.waits_until(), Some(now - UNANSWERED + PATIENCE));
    }
}
