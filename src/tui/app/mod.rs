//! The state of the interface and what events make of it. No input or output happens here.

mod commands;
mod dialogs;
mod edits;
mod files;
mod pointing;
mod read;
mod render;
mod saving;
mod views;

use super::color::ColorMode;
use super::command::Command;
use super::dialog::Dialog;
use super::editor::{Editor, FileText};
use super::event::{Effect, Event, Exit};
use super::keymap::Keymap;
use super::layout::{self, Layout, Parts};
use super::numbers::Numbers;
use super::preview::Preview;
use super::shown::Shown;
use super::transform::Transform;
use crate::description::{SceneDesc, printable};
use crate::render::{Film, Progress};
use crate::scene::Scene;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What is going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Reading models, building trees.
    Compiling,
    /// Tracing.
    Rendering,
    /// Workers are stopped by the user.
    Paused,
    /// Every sample is done.
    Finished,
    /// The render broke off.
    Failed,
}

/// The last thing the user should know.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// One line.
    pub text: String,
    /// What kind of news it is.
    pub tone: Tone,
}

/// What kind of news a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// An answer to a key.
    Plain,
    /// Something is done.
    Good,
    /// Something went wrong.
    Bad,
}

/// Which part of the screen has the keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Focus {
    /// The picture.
    Picture,
    /// The tree of the scene.
    Tree,
    /// The properties of what is selected.
    Properties,
}

/// A change that a dialog makes while it is open: one step of undo, taken back as a whole.
struct Live {
    gesture: u64,
    label: &'static str,
    before: Arc<SceneDesc>,
}

/// Everything that the screen shows.
pub struct App {
    editor: Editor,
    keymap: Keymap,
    name: String,
    output: PathBuf,
    /// Where models and pictures are looked for first.
    directory: PathBuf,
    threads: usize,
    /// Time after which a render ends.
    time: Option<Duration>,
    mode: ColorMode,
    layout: Layout,
    parts: Parts,
    size: (u16, u16),
    focus: Focus,
    dialog: Option<Dialog>,
    /// What the open dialog changes.
    live: Option<Live>,
    /// The search of the tree is being typed.
    searching: bool,
    transform: Option<Transform>,
    /// Whether the chart is asked for or not wanted.
    chart: Option<bool>,
    /// The pixel of the preview that is pointed at.
    cursor: Option<(usize, usize)>,
    /// The pixel of the film that was clicked last.
    clicked: Option<(u32, u32)>,
    preview: Preview,
    /// What the picture shows instead of the film.
    shown: Shown,
    /// Shared with a save that is under way, which then costs a copy at the next tile and none if there is no more.
    film: Arc<Film>,
    scene: Option<Arc<Scene>>,
    /// What the first compile may share.
    lent: Option<Arc<Scene>>,
    progress: Option<Progress>,
    /// The numbers on the screen: renewed only so often that they can be read.
    numbers: Option<Numbers>,
    activity: Activity,
    message: Option<Message>,
    /// What became of the picture: beside the message, since it is the answer to no key.
    note: Option<Message>,
    /// What is wrong with the scene's file on the disk.
    broken_file: Option<Vec<String>>,
    /// Files that have changed since the scene was compiled.
    changed: Vec<PathBuf>,
    /// Files whose changes are told.
    watched: BTreeSet<PathBuf>,
    /// They may be others now.
    watch_due: bool,
    /// The description is newer than what was last given to the compiler.
    edited: bool,
    compiling: bool,
    /// When the oldest edit was made that the compiler was not given yet.
    unheard: Option<Instant>,
    /// When the oldest edit was made that it was given and no whole picture shows yet.
    unseen: Option<Instant>,
    /// How long an edit waits for the first whole picture of the one before.
    patience: Duration,
    /// From an edit to the first whole picture of it.
    latency: Option<Duration>,
    /// A save waits for the first whole picture.
    save_wanted: bool,
    /// The last save: how much of the picture was done, or why it failed.
    saved: Option<Result<u32, String>>,
    saves_running: u32,
    /// Leaves when the scene is written.
    leave_when_written: bool,
    /// The program was asked to stop and does not know yet that it goes on.
    stopped: bool,
    hung_up: bool,
    /// Leaves when the saves that run are done, or else at this time.
    leaving: Option<(Exit, Instant)>,
    exit: Option<Exit>,
}

/// Leaving does not wait longer than this for saves: a pipe that nobody reads or a disk that is gone takes for ever.
const SAVE_PATIENCE: Duration = Duration::from_secs(2);
/// When the terminal is gone nobody can leave at once: there is more time, for large pictures.
const SAVE_PATIENCE_ALONE: Duration = Duration::from_secs(10);
/// SIGHUP, on every system that has it.
const HANG_UP: i32 = 1;

impl App {
    /// The interface at its start on a terminal of `size` columns and rows.
    pub fn new(
        desc: SceneDesc,
        name: &str,
        output: &Path,
        threads: usize,
        mode: ColorMode,
        (columns, rows): (u16, u16),
    ) -> Self {
        let film = Arc::new(Film::new(desc.film.width, desc.film.height));
        let mut app = Self {
            editor: Editor::new(desc),
            keymap: Keymap::default(),
            name: printable(name).into_owned(),
            output: output.to_path_buf(),
            directory: PathBuf::from("."),
            threads,
            time: None,
            mode,
            layout: Layout::default(),
            parts: Parts { editor: layout::has_room_for_editor(columns), numbers: true },
            size: (columns, rows),
            focus: Focus::Picture,
            dialog: None,
            live: None,
            searching: false,
            transform: None,
            chart: None,
            cursor: None,
            clicked: None,
            preview: Preview::default(),
            shown: Shown::new(film.width(), film.height()),
            film,
            scene: None,
            lent: None,
            progress: None,
            numbers: None,
            activity: Activity::Compiling,
            message: None,
            note: None,
            broken_file: None,
            changed: Vec::new(),
            watched: BTreeSet::new(),
            watch_due: true,
            edited: true,
            compiling: false,
            unheard: None,
            unseen: None,
            patience: render::PATIENCE,
            latency: None,
            save_wanted: false,
            saved: None,
            saves_running: 0,
            leave_when_written: false,
            stopped: false,
            hung_up: false,
            leaving: None,
            exit: None,
        };
        app.lay_out();
        app
    }

    /// Lends the first compile a scene that has meshes, pictures or trees which it would read or build again.
    pub fn lend(&mut self, compiled: Arc<Scene>) {
        self.lent = Some(compiled);
    }

    /// The scene was read from this file.
    pub fn set_source(&mut self, source: FileText) {
        self.editor.set_source(source);
    }

    /// Models and pictures are looked for here first.
    pub fn set_directory(&mut self, directory: PathBuf) {
        self.directory = directory;
    }

    /// Renders end after this time.
    pub fn set_time_limit(&mut self, time: Option<Duration>) {
        self.time = time;
    }

    /// The user's own keys.
    pub fn set_keymap(&mut self, keymap: Keymap) {
        self.keymap = keymap;
    }

    /// Takes in what happened and tells what has to be done. An edit only marks the description as edited: see
    /// [`App::begin_compile`].
    pub fn update(&mut self, event: Event, now: Instant) -> Vec<Effect> {
        let was_edited = self.edited;
        let effects = self.happened(event, now);
        if self.edited && !was_edited && self.scene.is_some() {
            self.unheard.get_or_insert(now);
        }
        effects
    }

    fn happened(&mut self, event: Event, now: Instant) -> Vec<Effect> {
        match event {
            Event::Key(key) => return self.key(key, now),
            Event::Mouse(mouse) => return self.mouse(mouse, now),
            Event::Pasted(text) => return self.paste(&text),
            Event::Resize(columns, rows) => {
                self.size = (columns, rows);
                self.lay_out();
                // Even if it is the same size again: what was on the screen may be broken.
                return vec![Effect::Redraw];
            }
            Event::Render(event) => return self.render(event, now),
            Event::Probed(event) => self.probed(event),
            Event::Compiled(result) => return self.compiled(result, now),
            Event::Saved(result) => self.picture_saved(result, now),
            Event::Listed { directory, entries } => return self.listed(&directory, entries),
            Event::Looked { file, picture } => self.looked(&file, picture),
            Event::Advised { desc, found } => self.advised(&desc, found),
            Event::Measured { file, bounds } => self.measured(file, bounds),
            Event::SceneWritten { written, result } => self.scene_written(written, result, now),
            Event::ModelWritten { change, text, result } => self.model_written(&change, text, result),
            Event::FilesChanged(files) => return self.files_changed(files),
            Event::Reread { file, result } => self.reread(&file, result),
            Event::Terminated(signal) => self.leave(Exit::Signal(signal), now),
            Event::StopAsked => {
                self.stopped(true, now);
                return vec![Effect::Stop];
            }
            Event::Continued => {
                self.stopped(false, now);
                return vec![Effect::Reenter];
            }
            Event::HungUp => {
                if !std::mem::replace(&mut self.hung_up, true) {
                    let mut effects = vec![Effect::Detach];
                    if self.activity == Activity::Paused {
                        effects.extend(self.set_paused(false, now));
                    }
                    self.end_if_alone(now);
                    return effects;
                }
            }
            Event::Broken(message) => self.leave(Exit::Broken(message), now),
        }
        Vec::new()
    }

    fn picture_saved(&mut self, result: Result<u32, String>, now: Instant) {
        self.saves_running = self.saves_running.saturating_sub(1);
        let file = self.output_text();
        let (tone, text) = match &result {
            Ok(100) => (Tone::Good, format!("saved {file}")),
            Ok(percent) => (Tone::Good, format!("saved {file} at {percent} %")),
            Err(reason) => (Tone::Bad, format!("cannot save {file}: {}", printable(reason))),
        };
        self.note = Some(Message { text, tone });
        self.saved = Some(result);
        self.saves_end();
        self.end_if_alone(now);
    }

    /// Leaves if that waited for the last save.
    fn saves_end(&mut self) {
        if self.saves_running == 0
            && let Some((exit, _)) = self.leaving.take()
        {
            self.exit = Some(exit);
        }
    }

    /// Leaves as soon as no save is under way; at once if that was asked for before.
    fn leave(&mut self, exit: Exit, now: Instant) {
        if self.saves_running == 0 || self.leaving.is_some() {
            self.exit = Some(exit);
        } else {
            let key = self.keymap.key_of(Command::Quit);
            self.note = None;
            self.tell(Tone::Plain, format!("saving {}; {key} leaves at once", self.output_text()));
            self.leaving = Some((exit, now + SAVE_PATIENCE));
        }
    }

    /// Until when saves may keep the interface from leaving.
    pub fn leaves_by(&self) -> Option<Instant> {
        self.leaving.as_ref().map(|(_, by)| *by)
    }

    /// Leaves without its saves if they have taken too long.
    pub fn lose_patience(&mut self, now: Instant) {
        if let Some((exit, _)) = self.leaving.take_if(|(_, by)| *by <= now) {
            self.exit = Some(exit);
        }
    }

    fn tell(&mut self, tone: Tone, text: String) {
        self.message = Some(Message { text, tone });
    }

    fn lay_out(&mut self) {
        let film = (self.film.width(), self.film.height());
        self.layout = layout::lay_out(self.size, film, self.threads, self.parts);
        self.preview.set_film(film.0, film.1);
        self.preview.set_area(self.layout.preview.width, self.layout.preview.height);
        if self.layout.editor.is_none() {
            self.focus = Focus::Picture;
        }
        if let Some((x, y)) = self.cursor {
            self.cursor = self.preview.nearest(x, y);
        }
    }
}
