//! What happens to the interface, and what it wants done: the two sides of `App::update`.

use super::decode::Mouse;
use super::dialog::files::{Entry, Thumbnail};
use super::editor::FileText;
use super::key::Key;
use crate::advice::{Advice, Change};
use crate::description::SceneDesc;
use crate::description::edit::Bounds;
use crate::render::RenderEvent;
use crate::scene::{CompileError, Scene};
use crate::shading::Probe;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Weak};

/// What happened.
#[derive(Debug)]
pub enum Event {
    /// A key was pressed.
    Key(Key),
    /// A button of the mouse was pressed, or its wheel turned.
    Mouse(Mouse),
    /// Text was pasted.
    Pasted(String),
    /// The terminal has this many columns and rows.
    Resize(u16, u16),
    /// A worker reports.
    Render(RenderEvent),
    /// A worker reports of the view.
    Probed(RenderEvent),
    /// The description was compiled.
    Compiled(Result<Arc<Scene>, CompileError>),
    /// The picture was saved when this much of it was done, or why it was not.
    Saved(Result<u32, String>),
    /// What a directory holds, or why that is not known.
    Listed {
        /// Which one.
        directory: PathBuf,
        /// Directories and files that can be opened.
        entries: Result<Vec<Entry>, String>,
    },
    /// What a picture looks like, or why that is not known.
    Looked {
        /// Which one.
        file: PathBuf,
        /// Made small.
        picture: Result<Thumbnail, String>,
    },
    /// What the scene does not need, or why that is not known.
    Advised {
        /// What was measured.
        desc: Arc<SceneDesc>,
        /// The most worth first.
        found: Result<Vec<Advice>, String>,
    },
    /// How large a model is, or why that is not known.
    Measured {
        /// Which one.
        file: PathBuf,
        /// Its box, object space.
        bounds: Result<Bounds, String>,
    },
    /// The scene was written, or why it was not.
    SceneWritten {
        /// What should be in the file.
        written: FileText,
        /// How it went.
        result: Result<(), String>,
    },
    /// The model that a change needs was written, or why it was not.
    ModelWritten {
        /// What is to be done now.
        change: Change,
        /// The same in a few words.
        text: String,
        /// How it went.
        result: Result<(), String>,
    },
    /// These files are other ones than before: the scene's own, or what it uses.
    FilesChanged(Vec<PathBuf>),
    /// What the scene's file says now, or what is wrong with it.
    Reread {
        /// Which one.
        file: PathBuf,
        /// Its text and what that says; else lines that tell every mistake, safe to print.
        result: Result<(String, SceneDesc), Vec<String>>,
    },
    /// A signal asks to end.
    Terminated(i32),
    /// The shell asks to stop.
    StopAsked,
    /// The shell lets the program go on.
    Continued,
    /// The terminal is gone.
    HungUp,
    /// A thread of the interface could not be started, or panicked.
    Broken(String),
}

/// What has to be done in the world.
#[derive(Clone)]
pub enum Effect {
    /// Render this scene.
    Start(Arc<Scene>),
    /// Trace this for the view of the picture, or nothing more.
    Probe(Option<(Arc<Scene>, Probe)>),
    /// Stop the workers, or let them go on.
    Pause(bool),
    /// Render with so many threads from now on.
    Threads(usize),
    /// Save the film, of which this many percent are done.
    Save(u32),
    /// Tell what a directory holds: its directories, and the files with these endings.
    List(PathBuf, &'static [&'static str]),
    /// Tell what a picture looks like.
    Look(PathBuf),
    /// Tell what a scene does not need, as long as somebody waits for it.
    Advise {
        /// What to measure.
        desc: Arc<SceneDesc>,
        /// Lends models and pictures.
        scene: Arc<Scene>,
        /// Dead when nobody waits any more.
        waits: Weak<()>,
    },
    /// Tell how large a model is.
    Measure(PathBuf),
    /// Write a scene.
    WriteScene(FileText),
    /// Write the model that a change needs.
    WriteModel {
        /// What is to be done then.
        change: Change,
        /// The same in a few words.
        text: String,
    },
    /// Tell when one of these files changes, and no others any more.
    Watch(BTreeSet<PathBuf>),
    /// Read the scene's file again.
    Reread(PathBuf),
    /// Give the terminal back and stop the program.
    Stop,
    /// Take the terminal again.
    Reenter,
    /// Send the whole screen again.
    Redraw,
    /// Live on without a terminal.
    Detach,
}

/// Why the interface ends.
#[derive(Clone, Debug, PartialEq)]
pub enum Exit {
    /// The user has quit, or there is nothing left to do.
    Quit,
    /// By this signal.
    Signal(i32),
    /// The scene at the start cannot be rendered.
    Compile(CompileError),
    /// A thread of the interface could not be started, or panicked.
    Broken(String),
}
