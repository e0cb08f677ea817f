//! The interface at work, but for terminal and disk: the state, the threads that compile and trace for it, and the
//! times of its frames.

use super::app::{Activity, App};
use super::event::{Effect, Event};
use super::session::spawn;
use super::view::view;
use crate::advice::advise;
use crate::bvh::Isa;
use crate::description::printable;
use crate::render::{RenderHandle, Rooms, Settings, start_in, start_probe};
use crate::scene::{compile_for, recompile};
use crossbeam_channel::{Receiver, Sender, TryRecvError, never, select, unbounded};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time between two frames while only the picture changes, and the least time between any two.
const FRAME: Duration = Duration::from_millis(33);
const QUICK_FRAME: Duration = Duration::from_millis(8);
/// Time between two frames while only clocks run.
const CLOCK_FRAME: Duration = Duration::from_millis(125);
/// Tiles are asked for so often: were the loop woken for each, it would take the time of a worker (the first picture of
/// 1280x720 has 920 tiles). The second where the first whole picture of an edit is waited for.
const POLL: [Duration; 2] = [Duration::from_millis(2), Duration::from_micros(500)];
/// The answer to a key that starts a render waits so long for the picture: both are painted at once, which leaves the
/// processors to it. Nobody sees a thirtieth of a second.
const TOGETHER: Duration = Duration::from_millis(25);
/// Events are taken in for not longer than this before the next frame has a chance.
const BATCH: Duration = Duration::from_millis(8);

/// What joins the state with its workers.
pub(super) struct Engine {
    pub app: App,
    isa: Isa,
    settings: Settings,
    /// Time after which a render ends.
    time: Option<Duration>,
    render: Option<RenderHandle>,
    /// What renders are traced in.
    rooms: Rooms,
    /// What is traced for a view of the picture.
    probe: Option<RenderHandle>,
    events: (Sender<Event>, Receiver<Event>),
    /// When the next frame is due.
    frame_due: Option<Instant>,
    /// Until when it waits for the whole picture of an edit.
    held: Option<Instant>,
    last_frame: Instant,
}

impl Engine {
    /// With the first frame due. `time`: after it a render ends.
    pub fn new(app: App, isa: Isa, threads: NonZeroUsize, time: Option<Duration>) -> Self {
        let now = Instant::now();
        let settings = Settings { threads, ..Settings::default() };
        Self {
            app,
            isa,
            settings,
            time,
            render: None,
            rooms: Rooms::default(),
            probe: None,
            events: unbounded(),
            frame_due: Some(now),
            held: None,
            last_frame: now,
        }
    }

    /// Where its threads send what happens.
    pub fn sender(&self) -> Sender<Event> {
        self.events.0.clone()
    }

    /// Begins to compile what was edited. What is left to be done by the caller.
    pub fn compile(&mut self) -> Vec<Effect> {
        let Some((desc, previous, changed)) = self.app.begin_compile(Instant::now()) else { return Vec::new() };
        // Its workers make room at once; its picture stays.
        (self.render, self.probe) = (None, None);
        let (isa, events) = (self.isa, self.sender());
        let begun = spawn("compiler", &self.events.0, move || {
            let compiled = match previous.as_deref() {
                Some(previous) if !changed.is_empty() => recompile(&desc, previous, &changed),
                previous => compile_for(&desc, previous, isa),
            };
            let _ = events.send(Event::Compiled(compiled.map(Arc::new)));
        });
        match begun {
            Ok(()) => Vec::new(),
            Err(refused) => self.take(Event::Broken(refused)),
        }
    }

    /// Waits for an event or the time of the next frame, or `at_most` until then, and takes in all that has come. What
    /// is left to be done.
    pub fn wait(&mut self, at_most: Option<Instant>) -> Vec<Effect> {
        let clock = if self.app.is_running() { Some(self.last_frame + CLOCK_FRAME) } else { None };
        let frame = self.not_before([self.frame_due, clock].into_iter().flatten().min());
        let poll = POLL[usize::from(!self.app.is_seen())];
        let tiles = self.render.as_ref().or(self.probe.as_ref()).map(|_| Instant::now() + poll);
        let until = [frame, tiles, self.app.leaves_by(), at_most].into_iter().flatten().min();
        let wait = until.map_or(never(), crossbeam_channel::at);
        let mut effects = select! {
            recv(self.events.1) -> event => event.map_or_else(|_| Vec::new(), |event| self.take(event)),
            recv(wait) -> now => {
                self.frame_due = match (now, frame) {
                    (Ok(now), Some(due)) if due <= now => Some(now),
                    _ => self.frame_due,
                };
                Vec::new()
            }
        };
        let end = Instant::now() + BATCH;
        // A whole picture of an edit is shown before more is taken in.
        while self.app.exit().is_none() && !self.app.is_awaited() && Instant::now() < end {
            // Keys before tiles.
            if let Ok(event) = self.events.1.try_recv() {
                effects.extend(self.take(event));
                continue;
            }
            match self.render.as_ref().map(|render| render.events().try_recv()) {
                Some(Ok(event)) => effects.extend(self.take(Event::Render(event))),
                Some(Err(TryRecvError::Disconnected)) => self.render = None, // All is told.
                Some(Err(TryRecvError::Empty)) | None => {
                    match self.probe.as_ref().map(|probe| probe.events().try_recv()) {
                        Some(Ok(event)) => effects.extend(self.take(Event::Probed(event))),
                        Some(Err(TryRecvError::Disconnected)) => self.probe = None,
                        Some(Err(TryRecvError::Empty)) | None => break,
                    }
                }
            }
        }
        effects
    }

    /// Takes an event in. What is left to be done.
    pub fn take(&mut self, event: Event) -> Vec<Effect> {
        let now = Instant::now();
        let is_picture = matches!(event, Event::Render(_) | Event::Probed(_));
        let effects = self.app.update(event, now);
        // A whole picture of what was edited is what the user waits for.
        let period = if is_picture && !self.app.is_awaited() { FRAME } else { QUICK_FRAME };
        let due = self.last_frame + period;
        self.frame_due = Some(self.frame_due.map_or(due, |earlier| earlier.min(due)));
        if !is_picture && !self.app.is_seen() {
            self.held.get_or_insert(now + TOGETHER);
        }
        effects.into_iter().filter_map(|effect| self.perform(effect)).collect()
    }

    /// Does it, or gives it back.
    fn perform(&mut self, effect: Effect) -> Option<Effect> {
        match effect {
            Effect::Threads(count) => {
                self.settings.threads = NonZeroUsize::new(count).unwrap_or(self.settings.threads);
            }
            Effect::Advise { desc, scene, waits } => {
                let (events, settings) = (self.sender(), self.settings);
                let begun = spawn("adviser", &self.events.0, move || {
                    let found = advise(&desc, &scene, settings, &|| waits.strong_count() == 0);
                    let found = found.map_err(|failure| printable(&failure.to_string()).into_owned());
                    let _ = events.send(Event::Advised { desc, found });
                });
                if let Err(refused) = begun {
                    let _ = self.events.0.send(Event::Broken(refused));
                }
            }
            Effect::Start(scene) => {
                let render = start_in(scene, self.settings, &self.rooms);
                // A time too long for the clock never ends.
                if let Some(deadline) = self.time.and_then(|time| Instant::now().checked_add(time)) {
                    render.finish_by(deadline);
                }
                self.render = Some(render);
            }
            Effect::Probe(wanted) => {
                self.probe = wanted.map(|(scene, probe)| start_probe(scene, probe, self.settings));
            }
            Effect::Pause(paused) => match &self.render {
                Some(render) if paused => render.pause(),
                Some(render) => render.resume(),
                None => {}
            },
            other => return Some(other),
        }
        None
    }

    /// The time of a frame, put off while the picture of an edit is waited for.
    fn not_before(&self, due: Option<Instant>) -> Option<Instant> {
        let held = self.held.filter(|_| !self.app.is_awaited());
        due.map(|due| held.map_or(due, |held| held.max(due)))
    }

    /// The screen, if it is time for a frame.
    pub fn frame(&mut self) -> Option<Buffer> {
        let now = Instant::now();
        if self.not_before(self.frame_due).is_none_or(|due| now < due) {
            return None;
        }
        (self.frame_due, self.held, self.last_frame) = (None, None, now);
        // The picture that somebody waits for is painted by a processor of its own: the workers rest for these
        // milliseconds.
        let resting =
            self.render.as_ref().filter(|_| self.app.is_awaited() && self.app.activity() == Activity::Rendering);
        resting.iter().for_each(|render| render.pause());
        self.app.refresh(now);
        let (columns, rows) = self.app.size();
        let mut buffer = Buffer::empty(Rect::new(0, 0, columns, rows));
        view(&self.app, &mut buffer);
        resting.iter().for_each(|render| render.resume());
        Some(buffer)
    }

    /// Ends its render. The events that have come, and the state.
    pub fn end(mut self) -> (App, Receiver<Event>) {
        (self.render, self.probe) = (None, None);
        (self.app, self.events.1)
    }
}
