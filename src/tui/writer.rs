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
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

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
        let (text, mut picture) = self.differences(frame);
        let mut complete = true;
        // The last row first: it is the one that answers keys.
        for segment in text.iter().rev() {
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
pub struct Mailbox(Arc<(Mutex<Mail>, Condvar)>);

#[derive(Debug, Default)]
struct Mail {
    frame: Option<Frame>,
    answers: Vec<(u16, Instant)>,
    forget: bool,
    closed: bool,
}

impl Mailbox {
    /// The newest frame replaces one that was not taken.
    pub fn post(&self, frame: Frame) {
        self.change(|mail| mail.frame = Some(frame));
    }

    /// The terminal has answered a question for the cursor's column.
    pub fn answer(&self, column: u16) {
        self.change(|mail| mail.answers.push((column, Instant::now())));
    }

    /// What the terminal shows has been destroyed.
    pub fn forget(&self) {
        self.change(|mail| mail.forget = true);
    }

    /// The writer thread shall end.
    pub fn close(&self) {
        self.change(|mail| mail.closed = true);
    }

    fn change(&self, change: impl FnOnce(&mut Mail)) {
        change(&mut self.lock());
        self.0.1.notify_one();
    }

    fn lock(&self) -> MutexGuard<'_, Mail> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for mail, not longer than `until`; `None` if the mailbox is closed.
    fn wait(&self, until: Option<Instant>) -> Option<Mail> {
        let mut mail = self.lock();
        loop {
            if mail.closed {
                return None;
            }
            let late = until.is_some_and(|until| until <= Instant::now());
            if late || mail.frame.is_some() || !mail.answers.is_empty() || mail.forget {
                return Some(std::mem::take(&mut *mail));
            }
            let arrived = &self.0.1;
            mail = match until {
                None => arrived.wait(mail).unwrap_or_else(PoisonError::into_inner),
                Some(until) => {
                    let timeout = until.saturating_duration_since(Instant::now());
                    arrived.wait_timeout(mail, timeout).unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }
}

/// Body of the writer thread. Returns when the mailbox is closed (`Ok`) or the terminal is gone.
pub fn run(mailbox: &Mailbox, terminal: &Terminal) -> std::io::Result<()> {
    let (mut screen, mut pacer) = (Screen::default(), Pacer::default());
    let mut frame: Option<Frame> = None;
    let mut complete = true;
    loop {
        // With something to send, wait until that is allowed; without, until there is something.
        let until = if complete { None } else { pacer.waits_until().or_else(|| Some(Instant::now())) };
        let Some(mail) = mailbox.wait(until) else { return Ok(()) };
        for (column, when) in mail.answers {
            pacer.answer(column, when);
        }
        if mail.forget {
            screen.forget();
            complete = false;
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
        if !terminal.write(&wrap(chunk, column, area.height))? {
            // Suspended: whoever resumes says so.
            screen.forget();
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
