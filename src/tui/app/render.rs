//! The render from compile to saved picture.

use super::{Activity, App, HANG_UP, Message, SAVE_PATIENCE_ALONE, Tone};
use crate::description::{SceneDesc, printable};
use crate::render::{Film, Progress, RenderEvent};
use crate::scene::{CompileError, Scene};
use crate::tui::event::{Effect, Exit};
use crate::tui::numbers::Numbers;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// An edit waits not longer than this for the first whole picture of the one before, so that a held key shows whole
/// pictures however many edits it makes. Each time that it was not enough the next wait is twice as long: in the end it
/// is.
pub(super) const PATIENCE: Duration = Duration::from_millis(100);

/// What is to be compiled, the scene whose parts can be shared, and the files that are others now than those it was
/// made of.
pub type Compile = (Arc<SceneDesc>, Option<Arc<Scene>>, Vec<PathBuf>);

impl App {
    /// What has to be compiled now: nothing if nothing was edited, or the compiler is still at work, or the picture of
    /// the edit before is about to be whole. To be asked when a batch of events is taken in, so that a burst of keys is
    /// one restart. With it the scene whose parts can be shared, and the files that are others now than those it was
    /// made of.
    pub fn begin_compile(&mut self, now: Instant) -> Option<Compile> {
        if self.compiling || !self.edited || self.is_awaited() {
            return None;
        }
        let begun = self.progress.as_ref().filter(|_| self.activity == Activity::Rendering);
        let coming = begun.filter(|progress| progress.first_picture.is_none());
        if coming.is_some_and(|progress| progress.elapsed(now) < self.patience) {
            return None;
        }
        self.patience = if coming.is_some() { self.patience.saturating_mul(2) } else { PATIENCE };
        (self.edited, self.compiling) = (false, true);
        self.unseen = self.unseen.or(self.unheard);
        self.unheard = None;
        let previous = self.lent.take().or_else(|| self.scene.clone());
        Some((self.editor.desc().clone(), previous, self.changed.clone()))
    }

    /// Brings preview and numbers up to date for a frame at `now`.
    pub fn refresh(&mut self, now: Instant) {
        self.refresh_picture(now);
        if self.is_awaited() {
            self.latency = self.unseen.take().map(|since| now.saturating_duration_since(since));
        }
        let ended = matches!(self.activity, Activity::Finished | Activity::Failed);
        if ended || self.numbers.as_ref().is_none_or(|numbers| numbers.are_old(now)) {
            let before = self.numbers.take();
            self.numbers = self.progress.as_ref().map(|progress| Numbers::new(progress, now));
            if let (Some(numbers), Some(before), false) = (&mut self.numbers, before, ended) {
                numbers.keep_tiles(&before);
            }
        }
    }

    /// A restart ends a pause: whoever edits wants to see what it does. A pause that comes later is one of the new
    /// render.
    pub(super) fn restart(&mut self) {
        self.edited = true;
        self.note = None;
        if self.activity == Activity::Paused {
            self.activity = Activity::Compiling;
        }
    }

    /// Whether a new render is on its way.
    pub fn is_restarting(&self) -> bool {
        self.edited || self.compiling
    }

    pub(super) fn set_paused(&mut self, paused: bool, now: Instant) -> Vec<Effect> {
        self.activity = match paused {
            true => Activity::Paused,
            false if self.is_restarting() => Activity::Compiling,
            false => Activity::Rendering,
        };
        if paused {
            // What takes longer now is the user's will.
            (self.unheard, self.unseen) = (None, None);
        }
        if let Some(progress) = &mut self.progress {
            progress.set_paused(paused, now);
        }
        vec![Effect::Pause(paused)]
    }

    /// The program stops, or goes on: its clock with it.
    pub(super) fn stopped(&mut self, stopped: bool, now: Instant) {
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

    pub(super) fn compiled(&mut self, result: Result<Arc<Scene>, CompileError>, now: Instant) -> Vec<Effect> {
        self.compiling = false;
        self.watch_due = true;
        match result {
            Ok(scene) => {
                self.changed.clear();
                if (self.film.width(), self.film.height()) != (scene.width, scene.height) {
                    self.film = Arc::new(Film::new(scene.width, scene.height));
                    self.shown.resize(scene.width, scene.height);
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
                let mut progress = Progress::new(&scene, self.threads, now);
                if let Some(limit) = self.time {
                    progress.set_time_limit(limit);
                }
                self.progress = Some(progress);
                self.numbers = None;
                self.scene = Some(scene.clone());
                let mut effects = vec![Effect::Start(scene)];
                if self.shown.view().probe().is_some() {
                    effects.push(self.probe());
                }
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
                self.unseen = None;
                self.tell(Tone::Bad, printable(&error.to_string()).into_owned());
                self.end_if_alone(now);
                Vec::new()
            }
        }
    }

    pub(super) fn render(&mut self, event: RenderEvent, now: Instant) -> Vec<Effect> {
        if let Some(progress) = &mut self.progress {
            progress.update(&event, now);
        }
        match event {
            RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
            RenderEvent::TileFinished { tile, .. } => {
                Arc::make_mut(&mut self.film).write(&tile);
                self.preview.mark(tile.rect);
                self.shown.rendered(tile);
                if self.save_wanted && self.is_whole() {
                    return self.save();
                }
            }
            // Of a render that is about to be replaced.
            RenderEvent::Finished if self.edited => {}
            RenderEvent::Finished => {
                self.shown.force();
                self.activity = Activity::Finished;
                let effects = self.save();
                self.end_if_alone(now);
                return effects;
            }
            RenderEvent::Failed(error) => {
                self.activity = Activity::Failed;
                self.unseen = None;
                self.tell(Tone::Bad, printable(&error.to_string()).into_owned());
                self.end_if_alone(now);
            }
        }
        Vec::new()
    }

    pub(super) fn save(&mut self) -> Vec<Effect> {
        const WAITS: &str = "will be saved as soon as the whole picture is there";
        // Before that the film still holds parts of the picture before the last edit.
        self.save_wanted = !self.is_whole();
        if self.save_wanted {
            self.tell(Tone::Plain, WAITS.into());
            return Vec::new();
        }
        self.message.take_if(|message| message.text == WAITS);
        self.note = Some(Message { text: format!("saving {}", self.output_text()), tone: Tone::Plain });
        self.saves_running += 1;
        vec![Effect::Save(self.progress.as_ref().map_or(0, Progress::percent))]
    }

    /// Whether the screen, at its last frame, showed a whole picture of what is edited now.
    pub fn is_seen(&self) -> bool {
        self.unheard.is_none() && self.unseen.is_none()
    }

    /// Whether the next frame is the first to show a whole picture of an edit.
    pub fn is_awaited(&self) -> bool {
        self.unseen.is_some() && !self.compiling && self.has_first_picture()
    }

    fn has_first_picture(&self) -> bool {
        self.progress.as_ref().is_some_and(|progress| progress.first_picture.is_some())
    }

    /// Whether every pixel of the film belongs to the newest scene.
    pub fn is_whole(&self) -> bool {
        !self.is_restarting() && self.has_first_picture()
    }

    /// Without a terminal the program lives only until the picture is saved, and no longer than saving may take.
    pub(super) fn end_if_alone(&mut self, now: Instant) {
        let working = self.is_restarting() || matches!(self.activity, Activity::Compiling | Activity::Rendering);
        if !self.hung_up || working {
            return;
        }
        if self.saves_running == 0 {
            self.exit = Some(Exit::Signal(HANG_UP));
        } else if self.leaving.is_none() {
            self.leaving = Some((Exit::Signal(HANG_UP), now + SAVE_PATIENCE_ALONE));
        }
    }
}
