//! The thread that owns the terminal's output: it sends what differs from what the far end shows, text first, then
//! the parts of the picture that changed most, no more at a time than the link carries.

use super::color::delta_e;
use super::encode::Encoder;
use super::pacer::Pacer;
use super::preview::UPPER_HALF;
use super::terminal::Terminal;
use ratatui::buffer::{Buffer, Cell};
use ratatui::layout::Rect;
use ratatui::style::Color;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A screen to be shown.
#[derive(Clone, Debug)]
pub struct Frame {
    /// All its cells.
    pub buffer: Buffer,
    /// Whether the picture is final, so that its colours are sent however little they differ from those shown.
    pub exact: bool,
}

/// Picture cells whose colours differ less than this (CIE76) from those shown are left as they are: noise that nobody
/// sees would be most of what is sent. The error is bounded, because the comparison is with what was last sent.
const HELD: f32 = 1.0;
/// Cells that are sent or left together.
const SEGMENT: u16 = 16;
/// About what a picture cell takes.
const BYTES_PER_CELL: usize = 20;

/// What the far end shows, and the way from there to the next frame. Does no input or output.
#[derive(Debug)]
pub struct Screen {
    shown: Buffer,
    encoder: Encoder,
}

/// Cells of one row that differ.
struct Segment {
    x: u16,
    y: u16,
    end: u16,
    cells: usize,
    change: f32,
}

impl Default for Screen {
    fn default() -> Self {
        Self { shown: Buffer::empty(Rect::ZERO), encoder: Encoder::default() }
    }
}

impl Screen {
    /// The far end's screen is not known any more: the next chunk begins with clearing it.
    pub fn forget(&mut self) {
        self.shown = Buffer::empty(Rect::ZERO);
    }

    /// Bytes that bring the far end nearer to `frame`, about `allowance` of them, and whether that is all there is to
    /// do. Empty if there is nothing.
    pub fn chunk(&mut self, frame: &Frame, allowance: usize) -> (Vec<u8>, bool) {
        if self.shown.area != frame.buffer.area {
            self.shown = Buffer::empty(frame.buffer.area);
            self.encoder.clear();
        }
        let (mut text, mut picture) = self.differences(frame);
        let mut complete = true;
        // The last row first: it is the one that answers keys.
        text.sort_by_key(|segment| segment.y + 1 != frame.buffer.area.height);
        for segment in &text {
            if self.encoder.len() > allowance {
                complete = false;
                break;
            }
            self.send(segment, frame);
        }
        let left = allowance.saturating_sub(self.encoder.len());
        let cells: usize = picture.iter().map(|s| s.cells).sum();
        if cells * BYTES_PER_CELL > left {
            picture.sort_by(|a, b| b.change.total_cmp(&a.change));
        }
        for segment in &picture {
            if self.encoder.len() > allowance {
                complete = false;
                break;
            }
            self.send(segment, frame);
        }
        (self.encoder.take(), complete)
    }

    /// What differs by enough: text, and picture.
    fn differences(&self, frame: &Frame) -> (Vec<Segment>, Vec<Segment>) {
        let held = if frame.exact { 0.0 } else { HELD };
        let area = frame.buffer.area;
        let (mut text, mut picture) = (Vec::new(), Vec::new());
        for y in 0..area.height {
            for x in (0..area.width).step_by(SEGMENT.into()) {
                let end = (x + SEGMENT).min(area.width);
                let mut segments = [(); 2].map(|()| Segment { x, y, end, cells: 0, change: 0.0 });
                for column in x..end {
                    let (wanted, shown) = (&frame.buffer[(column, y)], &self.shown[(column, y)]);
                    let change = change(wanted, shown);
                    if change > held {
                        let segment = &mut segments[usize::from(wanted.symbol() == UPPER_HALF)];
                        segment.cells += 1;
                        segment.change += change;
                    }
                }
                let [words, pixels] = segments;
                if words.cells > 0 {
                    text.push(words);
                }
                if pixels.cells > 0 {
                    picture.push(pixels);
                }
            }
        }
        (text, picture)
    }

    fn send(&mut self, segment: &Segment, frame: &Frame) {
        let held = if frame.exact { 0.0 } else { HELD };
        let mut x = segment.x;
        while x < segment.end {
            let wanted = &frame.buffer[(x, segment.y)];
            let mut width = 1;
            if change(wanted, &self.shown[(x, segment.y)]) > held {
                width = self.encoder.put(x, segment.y, wanted);
                for covered in x..(x + width).min(frame.buffer.area.width) {
                    self.shown[(covered, segment.y)] = frame.buffer[(covered, segment.y)].clone();
                }
            }
            x += width;
        }
    }
}

/// How much two cells differ; more than any two colours if it is not only the colours of pixels.
fn change(wanted: &Cell, shown: &Cell) -> f32 {
    if wanted == shown {
        return 0.0;
    }
    if wanted.symbol() != UPPER_HALF || shown.symbol() != UPPER_HALF {
        return 200.0;
    }
    let part = |wanted, shown| match (wanted, shown) {
        (Color::Rgb(r, g, b), Color::Rgb(s, h, c)) => delta_e([r, g, b], [s, h, c]),
        _ if wanted == shown => 0.0,
        _ => 10.0,
    };
    part(wanted.fg, shown.fg).max(part(wanted.bg, shown.bg))
}

/// Where the interface leaves the newest frame and answers for the writer thread: nobody waits for it.
#[derive(Clone, Debug, Default)]
pub struct Mailbox(Arc<(Mutex<State>, Condvar)>);

#[derive(Debug, Default)]
struct State {
    mail: Mail,
    /// Nothing may be sent.
    held: bool,
    /// An answer of the terminal is on its way.
    asked: bool,
}

/// What the writer thread has to know.
#[derive(Debug, Default)]
struct Mail {
    frame: Option<Frame>,
    answers: Vec<(u16, Instant)>,
    fresh: bool,
}

/// An answer that takes longer is not waited for when the terminal is given back.
const HOLD_PATIENCE: Duration = Duration::from_secs(1);

impl Mailbox {
    /// The newest frame replaces one that was not taken. `fresh`: what the terminal shows may have been destroyed, so
    /// everything is to be sent, held or not.
    pub fn post(&self, frame: Frame, fresh: bool) {
        let mut state = self.lock();
        state.mail.frame = Some(frame);
        state.mail.fresh |= fresh;
        state.held &= !fresh;
        self.0.1.notify_all();
    }

    /// The terminal has answered a question for the cursor's column.
    pub fn answer(&self, column: u16) {
        self.lock().mail.answers.push((column, Instant::now()));
        self.0.1.notify_all();
    }

    /// Nothing is sent from now on; waits for the answer that is on its way, which the shell would take for typing.
    pub fn hold(&self) {
        let mut state = self.lock();
        state.held = true;
        let _ = self.0.1.wait_timeout_while(state, HOLD_PATIENCE, |state| state.asked);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for mail, not longer than `until`.
    fn wait(&self, until: Option<Instant>) -> Mail {
        let mut state = self.lock();
        loop {
            let late = until.is_some_and(|until| until <= Instant::now());
            if late || state.mail.frame.is_some() || !state.mail.answers.is_empty() {
                return std::mem::take(&mut state.mail);
            }
            let arrived = &self.0.1;
            state = match until {
                None => arrived.wait(state).unwrap_or_else(PoisonError::into_inner),
                Some(until) => {
                    let timeout = until.saturating_duration_since(Instant::now());
                    arrived.wait_timeout(state, timeout).unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    /// Whether a chunk may be sent; if so its answer is on its way.
    fn begin_sending(&self) -> bool {
        let mut state = self.lock();
        state.asked |= !state.held;
        !state.held
    }

    /// Whether an answer is on its way.
    fn set_asked(&self, asked: bool) {
        self.lock().asked = asked;
        self.0.1.notify_all();
    }
}

/// Body of the writer thread. Returns when the terminal is gone.
pub fn run(mailbox: &Mailbox, terminal: &Terminal) -> io::Result<()> {
    let (mut screen, mut pacer) = (Screen::default(), Pacer::default());
    let mut frame: Option<Frame> = None;
    let mut complete = true;
    loop {
        // With something to send, wait until that is allowed; without, until there is something.
        let until = if complete { None } else { pacer.waits_until().or_else(|| Some(Instant::now())) };
        let mail = mailbox.wait(until);
        for (column, when) in mail.answers {
            if pacer.answer(column, when) {
                mailbox.set_asked(false);
            }
        }
        if mail.fresh {
            screen.forget();
        }
        if mail.frame.is_some() {
            frame = mail.frame;
            complete = false;
        }
        let Some(frame) = &frame else { continue };
        if complete || pacer.waits_until().is_some_and(|until| Instant::now() < until) {
            continue;
        }
        let chunk;
        (chunk, complete) = screen.chunk(frame, pacer.allowance());
        if chunk.is_empty() {
            continue;
        }
        let area = frame.buffer.area;
        let column = pacer.send(chunk.len(), area.width, Instant::now());
        if !mailbox.begin_sending() || !terminal.write(&wrap(chunk, column, area.height))? {
            // The terminal is given back. When it is ours again everything is sent again.
            mailbox.set_asked(false);
            complete = true;
        } else if !pacer.expects_answer() {
            mailbox.set_asked(false);
        }
    }
}

/// A chunk as one update of the screen, with a question for the cursor at its end.
fn wrap(chunk: Vec<u8>, column: u16, height: u16) -> Vec<u8> {
    let mut bytes = b"\x1b[?2026h".to_vec();
    bytes.extend(chunk);
    // Not in the first row if there is another: there the answer would look like a function key.
    bytes.extend(format!("\x1b[{};{column}H\x1b[?2026l\x1b[6n", height.clamp(1, 2)).bytes());
    bytes
}
