//! The interface at work: threads, the loop that joins them, and the effects of the state in the world.

use super::app::App;
use super::color::ColorMode;
use super::errands::{Errand, Errands};
use super::event::{Effect, Event, Exit};
use super::listen;
use super::terminal::{self, Guard};
use super::view::view;
use super::watch::{INTERVAL, watch};
use super::writer::{self, Frame, Mailbox};
use super::{Error, Options, Outcome};
use crate::bvh::Isa;
use crate::output::save_png;
use crate::render::{Film, RenderHandle, Settings, start};
use crate::scene::{compile_for, recompile};
use crossbeam_channel::{Receiver, Sender, never, select, unbounded};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use std::any::Any;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Time between two frames while only the picture changes, and the least time between any two.
const FRAME: Duration = Duration::from_millis(33);
const QUICK_FRAME: Duration = Duration::from_millis(8);
/// Time between two frames while only clocks run.
const CLOCK_FRAME: Duration = Duration::from_millis(125);
/// Events are taken in for not longer than this before the next frame has a chance.
const BATCH: Duration = Duration::from_millis(8);

struct Session {
    app: App,
    isa: Isa,
    settings: Settings,
    /// Time after which a render ends.
    time: Option<Duration>,
    render: Option<RenderHandle>,
    events: (Sender<Event>, Receiver<Event>),
    mailbox: Mailbox,
    guard: Guard,
    saver: Saver,
    errands: Errands,
    /// To the thread that watches them.
    watched: Sender<BTreeSet<PathBuf>>,
    /// When the next frame is due.
    frame_due: Option<Instant>,
    last_frame: Instant,
    /// The next frame is to be sent whole.
    fresh: bool,
}

/// See [`super::run`].
pub fn run(options: Options) -> Result<Outcome, Error> {
    let mode = ColorMode::detect(options.color, |name| std::env::var(name).ok());
    let size = crossterm::terminal::size().map_err(Error::Terminal)?;
    let (threads, isa, output) = (options.threads, options.isa, options.output);
    let mut app = App::new(options.desc, &options.scene_name, &output, threads.get(), mode, size);
    if let Some(compiled) = options.compiled {
        app.lend(compiled);
    }
    app.set_keymap(options.keymap);
    app.set_directory(options.directory);
    app.set_time_limit(options.time);
    if let Some(source) = options.source {
        app.set_source(source);
    }
    let events = unbounded();
    let mailbox = Mailbox::default();
    // Signals first: none of them may find the terminal changed and nobody listening.
    let signals = listen::signals(events.0.clone()).map_err(Error::Terminal)?;
    let guard = Guard::enter().map_err(Error::Terminal)?;
    spawn("signals", &events.0, signals).map_err(Error::Broken)?;
    spawn("keys", &events.0, {
        let (events, mailbox) = (events.0.clone(), mailbox.clone());
        move || {
            if listen::input(&events, &mailbox).is_err() {
                // Nobody listens if the interface has ended.
                let _ = events.send(Event::HungUp);
            }
        }
    })
    .map_err(Error::Broken)?;
    spawn("screen", &events.0, {
        let (events, mailbox, terminal) = (events.0.clone(), mailbox.clone(), guard.terminal().clone());
        move || {
            if writer::run(&mailbox, &terminal).is_err() {
                let _ = events.send(Event::HungUp);
            }
        }
    })
    .map_err(Error::Broken)?;
    let saver = Saver::new(output, &events.0).map_err(Error::Broken)?;
    let (watched, watch_list) = unbounded();
    spawn("watched files", &events.0, {
        let events = events.0.clone();
        move || watch(&watch_list, INTERVAL, |changed| events.send(Event::FilesChanged(changed)).is_ok())
    })
    .map_err(Error::Broken)?;
    let errands = Errands::start(&events.0).map_err(Error::Broken)?;
    let settings = Settings { threads, ..Settings::default() };
    let now = Instant::now();
    let session = Session {
        app,
        isa,
        settings,
        time: options.time,
        render: None,
        events,
        mailbox,
        guard,
        saver,
        errands,
        watched,
        frame_due: Some(now),
        last_frame: now,
        fresh: true,
    };
    session.run()
}

impl Session {
    fn run(mut self) -> Result<Outcome, Error> {
        while self.app.exit().is_none() {
            if let Some((desc, previous, changed)) = self.app.begin_compile() {
                // Its workers make room at once; its picture stays.
                self.render = None;
                let (isa, events) = (self.isa, self.events.0.clone());
                let begun = spawn("compiler", &self.events.0, move || {
                    let compiled = match previous.as_deref() {
                        Some(previous) if !changed.is_empty() => recompile(&desc, previous, &changed),
                        previous => compile_for(&desc, previous, isa),
                    };
                    let _ = events.send(Event::Compiled(compiled.map(Arc::new)));
                });
                if let Err(refused) = begun {
                    self.take(Event::Broken(refused));
                }
            }
            if let Some(effect) = self.app.begin_watch() {
                self.perform(effect);
            }
            self.draw();
            self.take_events();
            self.app.lose_patience(Instant::now());
        }
        self.end()
    }

    /// Waits for an event or the time of the next frame, and takes in all that has come.
    fn take_events(&mut self) {
        let rendered = self.render.as_ref().map_or_else(never, |render| render.events().clone());
        let clock = if self.app.is_running() { Some(self.last_frame + CLOCK_FRAME) } else { None };
        let until = [self.frame_due, clock, self.app.leaves_by()].into_iter().flatten().min();
        let wait = until.map_or(never(), crossbeam_channel::at);
        let event = select! {
            recv(self.events.1) -> event => event.ok(),
            recv(rendered) -> event => {
                if event.is_err() {
                    // All is told.
                    self.render = None;
                }
                event.ok().map(Event::Render)
            }
            recv(wait) -> now => {
                self.frame_due = now.ok();
                None
            }
        };
        let Some(event) = event else { return };
        self.take(event);
        let end = Instant::now() + BATCH;
        while self.app.exit().is_none() && Instant::now() < end {
            // Keys before tiles.
            if let Ok(event) = self.events.1.try_recv() {
                self.take(event);
            } else if let Some(Ok(event)) = self.render.as_ref().map(|render| render.events().try_recv()) {
                self.take(Event::Render(event));
            } else {
                break;
            }
        }
    }

    fn take(&mut self, event: Event) {
        let now = Instant::now();
        let period = if matches!(event, Event::Render(_)) { FRAME } else { QUICK_FRAME };
        let due = self.last_frame + period;
        self.frame_due = Some(self.frame_due.map_or(due, |earlier| earlier.min(due)));
        for effect in self.app.update(event, now) {
            self.perform(effect);
        }
    }

    fn perform(&mut self, effect: Effect) {
        match effect {
            Effect::Threads(count) => {
                self.settings.threads = NonZeroUsize::new(count).unwrap_or(self.settings.threads);
            }
            Effect::List(directory, endings) => self.errands.send(Errand::List(directory, endings)),
            Effect::Look(file) => self.errands.send(Errand::Look(file)),
            Effect::Measure(file) => self.errands.send(Errand::Measure(file)),
            // If the thread has panicked, the interface knows already.
            Effect::Watch(files) => drop(self.watched.send(files)),
            Effect::Reread(file) => self.errands.send(Errand::Reread(file)),
            Effect::WriteScene(written) => self.errands.send(Errand::Write(written)),
            Effect::Start(scene) => {
                let render = start(scene, self.settings);
                // A time too long for the clock never ends.
                if let Some(deadline) = self.time.and_then(|time| Instant::now().checked_add(time)) {
                    render.finish_by(deadline);
                }
                self.render = Some(render);
            }
            Effect::Pause(paused) => match &self.render {
                Some(render) if paused => render.pause(),
                Some(render) => render.resume(),
                None => {}
            },
            Effect::Save(percent) => self.saver.save(self.app.film().clone(), percent),
            Effect::Stop if terminal::can_stop() => {
                self.mailbox.hold();
                self.guard.terminal().leave();
                terminal::stop();
            }
            Effect::Stop => self.app.cannot_stop(Instant::now()),
            Effect::Reenter => {
                let back = self.guard.terminal().reenter();
                let size = crossterm::terminal::size();
                match back.and(size) {
                    Ok((columns, rows)) => self.take(Event::Resize(columns, rows)),
                    Err(_) => self.take(Event::HungUp),
                }
            }
            Effect::Redraw => self.fresh = true,
            Effect::Detach => terminal::detach(),
        }
    }

    fn draw(&mut self) {
        let now = Instant::now();
        if self.frame_due.is_none_or(|due| now < due) {
            return;
        }
        (self.frame_due, self.last_frame) = (None, now);
        self.app.refresh(now);
        let (columns, rows) = self.app.size();
        let mut buffer = Buffer::empty(Rect::new(0, 0, columns, rows));
        view(&self.app, &mut buffer);
        let fresh = std::mem::take(&mut self.fresh);
        self.mailbox.post(Frame { buffer, exact: self.app.is_final() }, fresh);
    }

    /// Restores the terminal and says how it went.
    fn end(mut self) -> Result<Outcome, Error> {
        self.render = None;
        self.mailbox.hold();
        drop(self.guard);
        let exit = self.app.exit().cloned().unwrap_or(Exit::Quit);
        for event in self.events.1.try_iter().filter(|event| matches!(event, Event::Saved(_))) {
            self.app.update(event, Instant::now());
        }
        let signal = match exit {
            Exit::Compile(error) => return Err(Error::Compile(error)),
            Exit::Broken(message) => return Err(Error::Broken(message)),
            Exit::Signal(number) => Some(number),
            Exit::Quit => None,
        };
        let file = self.app.output_text();
        let (line, code) = match self.app.saved() {
            _ if self.app.is_saving() => (format!("left before the picture was saved as {file}"), 1),
            Some(Ok(100)) => (format!("saved {file}"), 0),
            Some(Ok(percent)) => (format!("saved {file} at {percent} %"), 0),
            Some(Err(reason)) => (format!("cannot save {file}: {reason}"), 1),
            None => (format!("left at {} %; nothing was saved", self.app.percent()), 0),
        };
        Ok(Outcome { line, exit_code: signal.map_or(code, |number| u8::try_from(128 + number).unwrap_or(1)) })
    }
}

/// The thread that writes pictures, one after the other.
struct Saver(Sender<(Arc<Film>, u32)>);

impl Saver {
    fn new(output: PathBuf, events: &Sender<Event>) -> Result<Self, String> {
        let (films, queue) = unbounded::<(Arc<Film>, u32)>();
        let told = events.clone();
        spawn("saver", events, move || {
            for (film, percent) in queue {
                let result = save_png(&film, &output).map(|()| percent).map_err(|error| error.to_string());
                let _ = told.send(Event::Saved(result));
            }
        })?;
        Ok(Self(films))
    }

    fn save(&self, film: Arc<Film>, percent: u32) {
        // If the thread has panicked, the interface knows already.
        let _ = self.0.send((film, percent));
    }
}

/// Starts a thread of the interface. If it panics the interface ends in an error instead of standing still. The error
/// tells why the system refuses the thread.
pub(super) fn spawn(
    title: &'static str,
    events: &Sender<Event>,
    body: impl FnOnce() + Send + 'static,
) -> Result<(), String> {
    let events = events.clone();
    let guarded = move || {
        if let Err(panic) = catch_unwind(AssertUnwindSafe(body)) {
            let text = panic_text(&*panic);
            let broken = format!("the thread for {title} panicked: {text} (this is a bug in glimt)");
            let _ = events.send(Event::Broken(broken));
        }
    };
    match thread::Builder::new().name(title.into()).spawn(guarded) {
        Ok(_) => Ok(()),
        Err(error) => Err(format!("cannot start a thread for {title}: {error}")),
    }
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
