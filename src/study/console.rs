//! Between a study and who waits for it: progress on stderr, and the wish to stop.

use crate::description::printable;
use crate::render::RenderError;
use crate::scene::CompileError;
use std::cell::Cell;
use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// Why a study has no result.
#[derive(Debug)]
pub enum StudyError {
    /// The person or the system asked to stop.
    Interrupted,
    /// What was asked for makes no sense.
    Asked(String),
    /// A scene cannot be compiled.
    Compile(CompileError),
    /// A render failed.
    Render(RenderError),
    /// A file cannot be read or written.
    Io(io::Error),
    /// A chart cannot be drawn.
    Chart(String),
}

impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interrupted => f.write_str("stopped"),
            Self::Asked(what) => f.write_str(what),
            Self::Compile(error) => error.fmt(f),
            Self::Render(error) => error.fmt(f),
            Self::Io(error) => error.fmt(f),
            Self::Chart(error) => write!(f, "cannot draw the chart: {error}"),
        }
    }
}

impl std::error::Error for StudyError {}

impl From<CompileError> for StudyError {
    fn from(error: CompileError) -> Self {
        Self::Compile(error)
    }
}

impl From<RenderError> for StudyError {
    fn from(error: RenderError) -> Self {
        Self::Render(error)
    }
}

impl From<io::Error> for StudyError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Tells progress, asks whether to go on.
pub struct Console<'a> {
    interrupted: &'a dyn Fn() -> bool,
    quiet: bool,
    terminal: bool,
    begun: Instant,
    told: Cell<Option<Instant>>,
}

/// Least time between two lines of a log, and between two states of the line on a terminal.
const LOG_INTERVAL: Duration = Duration::from_secs(5);
const LINE_INTERVAL: Duration = Duration::from_millis(100);

impl<'a> Console<'a> {
    /// `interrupted`: whether to stop; asked often, between and within renders. `quiet`: no progress.
    pub fn new(interrupted: &'a dyn Fn() -> bool, quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        Self { interrupted, quiet, terminal, begun: Instant::now(), told: Cell::new(None) }
    }

    /// An error if the study shall stop.
    pub fn go_on(&self) -> Result<(), StudyError> {
        if (self.interrupted)() {
            self.clear();
            return Err(StudyError::Interrupted);
        }
        Ok(())
    }

    /// Says that `done` of `total` parts (0: unknown) are done and what is next. An error if the study shall stop.
    pub fn step(&self, done: usize, total: usize, what: impl fmt::Display) -> Result<(), StudyError> {
        self.go_on()?;
        let interval = if self.terminal { LINE_INTERVAL } else { LOG_INTERVAL };
        if self.quiet || self.told.get().is_some_and(|last| last.elapsed() < interval) {
            return Ok(());
        }
        self.told.set(Some(Instant::now()));
        let seconds = self.begun.elapsed().as_secs();
        let counted = if total == 0 { String::new() } else { format!("{done} of {total}, ") };
        let what = what.to_string();
        let what = printable(&what);
        // Who closed stderr does not want to know.
        let _ = if self.terminal {
            write!(io::stderr(), "\r\x1b[K{counted}{seconds} s: {what}").and_then(|()| io::stderr().flush())
        } else {
            writeln!(io::stderr(), "{counted}{seconds} s: {what}")
        };
        Ok(())
    }

    /// Takes the line of progress away.
    pub fn clear(&self) {
        if self.terminal && self.told.take().is_some() {
            let _ = write!(io::stderr(), "\r\x1b[K").and_then(|()| io::stderr().flush());
        }
    }
}
