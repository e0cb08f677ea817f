//! The terminal interface: a scene rendered live, with keys.
//!
//! ```text
//! workers, keys, signals --Event--> App::update --Effect--> render, save, stop
//!                                       |
//!                             view --Frame--> mailbox --> writer thread --chunks--> terminal
//! ```
//!
//! [`app`] is the state and does no input or output; [`view`] is the screen as a function of it. [`editor`] is what is
//! edited, with its history; [`tree`] and [`properties`] show it, [`dialog`] holds the boxes over the screen.
//! [`bindings`] is the one table of commands and keys, [`keymap`] that table as the user's own file changes it.
//! [`writer`] sends what differs, at the pace that `pacer` learns from the terminal's answers; `errands` asks the disk.
//! `engine` joins the state with its workers, `terminal` holds the modes, `session` ties all together.

pub mod app;
pub mod bindings;
pub mod camera;
mod chart;
pub mod color;
pub mod command;
pub mod decode;
pub mod dialog;
pub mod editor;
mod encode;
mod engine;
mod errands;
pub mod event;
pub mod field;
mod format;
pub mod key;
pub mod keymap;
pub mod latency;
pub mod layout;
mod legend;
mod listen;
pub mod numbers;
mod pacer;
mod panel;
pub mod preview;
pub mod properties;
mod session;
pub mod shown;
pub mod side;
mod status;
mod terminal;
pub mod transform;
pub mod tree;
pub mod view;
pub mod watch;
mod widget;
pub mod writer;

pub use editor::FileText;
pub use keymap::Keymap;

use crate::bvh::Isa;
use crate::description::SceneDesc;
use crate::render::View;
use crate::scene::{CompileError, Scene};
use std::fmt;
use std::io;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

/// What to show, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// The scene at the start.
    pub desc: SceneDesc,
    /// What was compiled before and shares models with it, so that they are not read again.
    pub compiled: Option<Arc<Scene>>,
    /// The file that the scene was read from; `None` for a model.
    pub source: Option<FileText>,
    /// Where models and pictures are looked for first, absolute.
    pub directory: PathBuf,
    /// What each key means.
    pub keymap: Keymap,
    /// What the scene is called: a file stem or `demo`.
    pub scene_name: String,
    /// Where finished pictures go (`<scene>.png` if the user did not say).
    pub output: PathBuf,
    /// Worker threads.
    pub threads: NonZeroUsize,
    /// Time after which a render ends.
    pub time: Option<Duration>,
    /// What scenes are compiled for.
    pub isa: Isa,
    /// Colours of the terminal.
    pub color: ColorChoice,
    /// What the picture shows at the start.
    pub view: View,
}

/// `--color`: which colours are sent to the terminal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorChoice {
    /// What the environment tells: `NO_COLOR`, `COLORTERM`, `TERM`.
    #[default]
    Auto,
    /// 24 bits.
    Truecolor,
    /// The palette of 256.
    Indexed,
    /// None: the picture is made of characters.
    Never,
}

impl FromStr for ColorChoice {
    type Err = String;

    /// `auto`, `truecolor`, `256` or `never`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "truecolor" => Ok(Self::Truecolor),
            "256" => Ok(Self::Indexed),
            "never" => Ok(Self::Never),
            _ => Err("use auto, truecolor, 256 or never".into()),
        }
    }
}

/// How the interface ended; the terminal is restored.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// What to print now, one line, such as `saved demo.png`.
    pub line: String,
    /// 0, or 128 + number of the signal that ended it.
    pub exit_code: u8,
}

/// Why the interface could not run or go on; the terminal is restored.
#[derive(Debug)]
pub enum Error {
    /// The terminal could not be set up.
    Terminal(io::Error),
    /// The scene cannot be rendered.
    Compile(CompileError),
    /// A thread could not be started, or panicked.
    Broken(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Terminal(error) => write!(f, "the terminal cannot be used: {error}"),
            Self::Compile(error) => error.fmt(f),
            Self::Broken(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for Error {}

/// Shows the scene in the terminal until the user quits. Blocks.
///
/// Finished renders are saved to `options.output`. Needs a terminal on stdin and stdout; without one the caller
/// renders headless.
pub fn run(options: Options) -> Result<Outcome, Error> {
    session::run(options)
}
