//! The state of the interface and what events make of it. No input or output happens here.

use super::chart;
use super::color::ColorMode;
use super::command::{Command, command_for, key_of};
use super::edit::edit;
use super::event::{Effect, Event, Exit};
use super::key::Key;
use super::layout::{self, Layout};
use super::numbers::Numbers;
use super::preview::Preview;
use crate::bvh::Isa;
use crate::description::{SceneDesc, printable};
use crate::render::{Film, Progress, RenderEvent};
use crate::scene::{CompileError, Scene};
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

/// Everything that the screen shows.
pub struct App {
    /// What is edited.
    desc: Arc<SceneDesc>,
    /// As it was at the start.
    original: Arc<SceneDesc>,
    name: String,
    output: PathBuf,
    threads: usize,
    mode: ColorMode,
    layout: Layout,
    size: (u16, u16),
    preview: Preview,
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
    help: bool,
    /// Whether the chart is asked for or not wanted.
    chart: Option<bool>,
    /// The description is newer than what was last given to the compiler.
    edited: bool,
    compiling: bool,
    /// A save waits for the first whole picture.
    save_wanted: bool,
    /// The last save: how much of the picture was done, or why it failed.
    saved: Option<Result<u32, String>>,
    saves_running: u32,
    /// The program was asked to stop and does not know yet that it goes on.
    stopped: bool,
    hung_up: bool,
    /// Leaves when the saves that run are done, or else at this time.
    leaving: Option<(Exit, Instant)>,
    exit: Option<Exit>,
}

/// Leaving does not wait longer than this for saves: a pipe that nobody reads or a disk that is gone takes for ever.
const SAVE_PATIENCE: Duration = Duration::from_secs(2);
/// Part of the view that one key press shifts it by.
const SHIFT_PART: f64 = 0.2;

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
        let desc = Arc::new(desc);
        let film = Arc::new(Film::new(desc.film.width, desc.film.height));
        let mut app = Self {
            original: desc.clone(),
            desc,
            name: printable(name).into_owned(),
            output: output.to_path_buf(),
            threads,
            mode,
            layout: Layout::default(),
            size: (columns, rows),
            preview: Preview::default(),
            film,
            scene: None,
            lent: None,
            progress: None,
            numbers: None,
            activity: Activity::Compiling,
            message: None,
            help: false,
            chart: None,
            edited: true,
            compiling: false,
            save_wanted: false,
            saved: None,
            saves_running: 0,
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

    /// Takes in what happened and tells what has to be done. An edit only marks the description as edited: see
    /// [`App::begin_compile`].
    pub fn update(&mut self, event: Event, now: Instant) -> Vec<Effect> {
        match event {
            Event::Key(key) => return self.key(key, now),
            Event::Resize(columns, rows) => {
                self.size = (columns, rows);
                self.lay_out();
                // Even if it is the same size again: what was on the screen may be broken.
                return vec![Effect::Redraw];
            }
            Event::Render(event) => return self.render(event, now),
            Event::Compiled(result) => return self.compiled(result, now),
            Event::Saved(result) => {
                self.saves_running = self.saves_running.saturating_sub(1);
                let file = self.output_text();
                match &result {
                    Ok(100) => self.tell(Tone::Good, format!("saved {file}")),
                    Ok(percent) => self.tell(Tone::Good, format!("saved {file} at {percent} %")),
                    Err(reason) => self.tell(Tone::Bad, format!("cannot save {file}: {}", printable(reason))),
                }
                self.saved = Some(result);
                if self.saves_running == 0
                    && let Some((exit, _)) = self.leaving.take()
                {
                    self.exit = Some(exit);
                }
                self.end_if_alone();
            }
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
                    self.end_if_alone();
                    return effects;
                }
            }
            Event::Broken(message) => self.leave(Exit::Broken(message), now),
        }
        Vec::new()
    }

    /// What has to be compiled now: nothing if nothing was edited or the compiler is still at work. To be asked when a
    /// batch of events is taken in, so that a burst of keys is one restart.
    pub fn begin_compile(&mut self) -> Option<(Arc<SceneDesc>, Option<Arc<Scene>>)> {
        if self.compiling || !std::mem::take(&mut self.edited) {
            return None;
        }
        self.compiling = true;
        Some((self.desc.clone(), self.lent.take().or_else(|| self.scene.clone())))
    }

    /// Leaves as soon as no save is under way; at once if that was asked for before.
    fn leave(&mut self, exit: Exit, now: Instant) {
        if self.saves_running == 0 || self.leaving.is_some() {
            self.exit = Some(exit);
        } else {
            self.tell(Tone::Plain, format!("saving {}; {} leaves at once", self.output_text(), key_of(Command::Quit)));
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

    /// Brings preview and numbers up to date for a frame at `now`.
    pub fn refresh(&mut self, now: Instant) {
        self.preview.refresh(&self.film);
        let ended = matches!(self.activity, Activity::Finished | Activity::Failed);
        if ended || self.numbers.as_ref().is_none_or(|numbers| numbers.are_old(now)) {
            let before = self.numbers.take();
            self.numbers = self.progress.as_ref().map(|progress| Numbers::new(progress, now));
            if let (Some(numbers), Some(before), false) = (&mut self.numbers, before, ended) {
                numbers.keep_tiles(&before);
            }
        }
    }

    fn key(&mut self, key: Key, now: Instant) -> Vec<Effect> {
        if let Some(command) = command_for(key, self.is_zoomed()) {
            return self.command(command, now);
        }
        if self.help {
            self.help = false;
        } else {
            self.tell(Tone::Plain, format!("{key} does nothing here; {} lists the keys", key_of(Command::ToggleHelp)));
        }
        Vec::new()
    }

    /// Does what a key means.
    pub fn command(&mut self, command: Command, now: Instant) -> Vec<Effect> {
        self.message = None;
        match command {
            Command::Quit => self.leave(Exit::Quit, now),
            Command::TogglePause => match self.activity {
                Activity::Paused => return self.set_paused(false, now),
                Activity::Finished | Activity::Failed if !self.is_restarting() => {}
                _ => return self.set_paused(true, now),
            },
            Command::Restart => self.restart(),
            Command::SaveImage => return self.save(),
            Command::ToggleChart => self.chart = Some(!self.shows_chart()),
            Command::ToggleHelp => self.help = !self.help,
            Command::Suspend => return self.update(Event::StopAsked, now),
            Command::Redraw => return vec![Effect::Redraw],
            Command::Zoom(steps) => self.preview.zoom_by(2f64.powf(f64::from(steps) / 2.0)),
            Command::Fit => self.preview.fit(),
            Command::Shift(right, below) => {
                self.preview.shift(f64::from(right) * SHIFT_PART, f64::from(below) * SHIFT_PART);
            }
            _ => self.edit(command),
        }
        Vec::new()
    }

    /// Changes camera or render settings; restarts nothing if they end up the same.
    fn edit(&mut self, command: Command) {
        let before = (self.desc.camera, self.desc.render);
        let answer = edit(Arc::make_mut(&mut self.desc), &self.original, command);
        if before != (self.desc.camera, self.desc.render) {
            self.restart();
        }
        if let Some(answer) = answer {
            self.tell(Tone::Plain, answer);
        }
    }

    /// A restart ends a pause: whoever edits wants to see what it does. A pause that comes later is one of the new
    /// render.
    fn restart(&mut self) {
        self.edited = true;
        if self.activity == Activity::Paused {
            self.activity = Activity::Compiling;
        }
    }

    /// Whether a new render is on its way.
    fn is_restarting(&self) -> bool {
        self.edited || self.compiling
    }

    fn set_paused(&mut self, paused: bool, now: Instant) -> Vec<Effect> {
        self.activity = match paused {
            true => Activity::Paused,
            false if self.is_restarting() => Activity::Compiling,
            false => Activity::Rendering,
        };
        if let Some(progress) = &mut self.progress {
            progress.set_paused(paused, now);
        }
        vec![Effect::Pause(paused)]
    }

    /// The program stops, or goes on: its clock with it.
    fn stopped(&mut self, stopped: bool, now: Instant) {
        if std::mem::replace(&mut self.stopped, stopped) == stopped || self.activity != Activity::Rendering {
            return;
        }
        if let Some(progress) = &mut self.progress {
            progress.set_paused(stopped, now);
        }
    }

    /// A stop was refused: there is no shell to return to.
    pub fn cannot_stop(&mut self, now: Instant) {
        self.stopped(false, now);
        self.tell(Tone::Plain, "there is no shell to go to".into());
    }

    fn compiled(&mut self, result: Result<Arc<Scene>, CompileError>, now: Instant) -> Vec<Effect> {
        self.compiling = false;
        match result {
            Ok(scene) => {
                if (self.film.width(), self.film.height()) != (scene.width, scene.height) {
                    self.film = Arc::new(Film::new(scene.width, scene.height));
                    self.lay_out();
                }
                if let (None, Some(warning)) = (&self.scene, scene.summary.warnings.first()) {
                    let more = match scene.summary.warnings.len() - 1 {
                        0 => String::new(),
                        more => format!(" (and {more} more: see `glimt check`)"),
                    };
                    self.tell(Tone::Plain, format!("{}{more}", printable(warning)));
                }
                // The old picture stays until tiles of the new one replace it.
                self.progress = Some(Progress::new(&scene, self.threads, now));
                self.numbers = None;
                self.scene = Some(scene.clone());
                let mut effects = vec![Effect::Start(scene)];
                match self.activity {
                    Activity::Paused => effects.extend(self.set_paused(true, now)),
                    _ => self.activity = Activity::Rendering,
                }
                effects
            }
            Err(error) if self.scene.is_none() => {
                self.exit = Some(Exit::Compile(error));
                Vec::new()
            }
            Err(error) => {
                self.activity = Activity::Failed;
                self.tell(Tone::Bad, printable(&error.to_string()).into_owned());
                self.end_if_alone();
                Vec::new()
            }
        }
    }

    fn render(&mut self, event: RenderEvent, now: Instant) -> Vec<Effect> {
        if let Some(progress) = &mut self.progress {
            progress.update(&event, now);
        }
        match event {
            RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
            RenderEvent::TileFinished { tile, .. } => {
                Arc::make_mut(&mut self.film).write(&tile);
                self.preview.mark(tile.rect);
                if self.save_wanted && self.is_whole() {
                    return self.save();
                }
            }
            // Of a render that is about to be replaced.
            RenderEvent::Finished if self.edited => {}
            RenderEvent::Finished => {
                self.activity = Activity::Finished;
                return self.save();
            }
            RenderEvent::Failed(error) => {
                self.activity = Activity::Failed;
                self.tell(Tone::Bad, printable(&error.to_string()).into_owned());
                self.end_if_alone();
            }
        }
        Vec::new()
    }

    fn save(&mut self) -> Vec<Effect> {
        // Before that the film still holds parts of the picture before the last edit.
        self.save_wanted = !self.is_whole();
        if self.save_wanted {
            self.tell(Tone::Plain, "will be saved as soon as the whole picture is there".into());
            return Vec::new();
        }
        self.tell(Tone::Plain, format!("saving {}", self.output_text()));
        self.saves_running += 1;
        vec![Effect::Save(self.progress.as_ref().map_or(0, Progress::percent))]
    }

    /// Whether every pixel of the film belongs to the newest scene.
    fn is_whole(&self) -> bool {
        !self.is_restarting() && self.progress.as_ref().is_some_and(|p| p.first_picture.is_some())
    }

    /// Without a terminal the program lives only until the picture is saved.
    fn end_if_alone(&mut self) {
        let working = self.is_restarting()
            || matches!(self.activity, Activity::Compiling | Activity::Rendering)
            || self.saves_running > 0;
        if self.hung_up && !working {
            self.exit = Some(Exit::Signal(HANG_UP));
        }
    }

    fn tell(&mut self, tone: Tone, text: String) {
        self.message = Some(Message { text, tone });
    }

    fn lay_out(&mut self) {
        self.layout = layout::lay_out(self.size, (self.film.width(), self.film.height()), self.threads);
        self.preview.set_film(self.film.width(), self.film.height());
        self.preview.set_area(self.layout.preview.width, self.layout.preview.height);
    }
}

/// SIGHUP, on every system that has it.
const HANG_UP: i32 = 1;

/// What the view reads.
impl App {
    /// As it is edited now.
    pub fn desc(&self) -> &SceneDesc {
        &self.desc
    }

    /// Name of the scene, safe to print.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Colours of the terminal.
    pub fn mode(&self) -> ColorMode {
        self.mode
    }

    /// Where things stand on the screen.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Columns and rows of the screen.
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// The picture in cells.
    pub fn preview(&self) -> &Preview {
        &self.preview
    }

    /// The picture in pixels.
    pub fn film(&self) -> &Arc<Film> {
        &self.film
    }

    /// The numbers to show.
    pub fn numbers(&self) -> Option<&Numbers> {
        self.numbers.as_ref()
    }

    /// The instruction set that rays are traced with, once there is a scene.
    pub fn isa(&self) -> Option<Isa> {
        self.scene.as_ref().map(|scene| scene.isa())
    }

    /// What is going on.
    pub fn activity(&self) -> Activity {
        self.activity
    }

    /// The last thing the user should know.
    pub fn message(&self) -> Option<&Message> {
        self.message.as_ref()
    }

    /// Whether the help screen is open.
    pub fn shows_help(&self) -> bool {
        self.help
    }

    /// Whether the chart of the error is open: by itself where it has a place of its own.
    pub fn shows_chart(&self) -> bool {
        self.chart.unwrap_or_else(|| chart::place(&self.layout).is_some_and(|place| place.is_free))
    }

    /// Whether only a part of the picture is shown.
    pub fn is_zoomed(&self) -> bool {
        self.preview.zoom() > 1.0
    }

    /// Where pictures go, safe to print.
    pub fn output_text(&self) -> String {
        printable(&self.output.to_string_lossy()).into_owned()
    }

    /// Whether the picture shown is the last one of its render: its colours have to be exact.
    pub fn is_final(&self) -> bool {
        self.activity == Activity::Finished
    }

    /// Whether clocks on the screen run.
    pub fn is_running(&self) -> bool {
        matches!(self.activity, Activity::Compiling | Activity::Rendering)
    }

    /// Why the interface ends, when it does.
    pub fn exit(&self) -> Option<&Exit> {
        self.exit.as_ref()
    }

    /// The last save: how much of the picture was done, or why it failed.
    pub fn saved(&self) -> Option<&Result<u32, String>> {
        self.saved.as_ref()
    }

    /// Whether a save is under way.
    pub fn is_saving(&self) -> bool {
        self.saves_running > 0
    }

    /// Whole percent of the running or finished render.
    pub fn percent(&self) -> u32 {
        self.progress.as_ref().map_or(0, Progress::percent)
    }
}
