//! The interface at work: threads, the loop that joins them, and the effects of the state in the world.

use super::app::App;
use super::color::ColorMode;
use super::engine::Engine;
use super::errands::{Errand, Errands};
use super::event::{Effect, Event, Exit};
use super::listen;
use super::terminal::{self, Guard};
use super::watch::{INTERVAL, watch};
use super::writer::{self, Frame, Mailbox};
use super::{Error, Options, Outcome};
use crate::output::save_png;
use crate::render::{Film, View};
use crossbeam_channel::{Sender, unbounded};
use std::any::Any;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

struct Session {
    engine: Engine,
    mailbox: Mailbox,
    guard: Guard,
    saver: Saver,
    errands: Errands,
    /// To the thread that watches them.
    watched: Sender<BTreeSet<PathBuf>>,
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
    if options.view != View::Final {
        // Nothing is traced for it before there is a scene.
        drop(app.show(options.view));
    }
    app.set_keymap(options.keymap);
    app.set_directory(options.directory);
    app.set_time_limit(options.time);
    if let Some(source) = options.source {
        app.set_source(source);
    }
    let engine = Engine::new(app, isa, threads, options.time);
    let events = engine.sender();
    let mailbox = Mailbox::default();
    // Signals first: none of them may find the terminal changed and nobody listening.
    let signals = listen::signals(events.clone()).map_err(Error::Terminal)?;
    let guard = Guard::enter().map_err(Error::Terminal)?;
    spawn("signals", &events, signals).map_err(Error::Broken)?;
    spawn("keys", &events, {
        let (events, mailbox) = (events.clone(), mailbox.clone());
        move || {
            if listen::input(&events, &mailbox).is_err() {
                // Nobody listens if the interface has ended.
                let _ = events.send(Event::HungUp);
            }
        }
    })
    .map_err(Error::Broken)?;
    spawn("screen", &events, {
        let (events, mailbox, terminal) = (events.clone(), mailbox.clone(), guard.terminal().clone());
        move || {
            if writer::run(&mailbox, &terminal).is_err() {
                let _ = events.send(Event::HungUp);
            }
        }
    })
    .map_err(Error::Broken)?;
    let saver = Saver::new(output, &events).map_err(Error::Broken)?;
    let (watched, watch_list) = unbounded();
    spawn("watched files", &events, {
        let events = events.clone();
        move || watch(&watch_list, INTERVAL, |changed| events.send(Event::FilesChanged(changed)).is_ok())
    })
    .map_err(Error::Broken)?;
    let errands = Errands::start(&events).map_err(Error::Broken)?;
    Session { engine, mailbox, guard, saver, errands, watched, fresh: true }.run()
}

impl Session {
    fn run(mut self) -> Result<Outcome, Error> {
        while self.engine.app.exit().is_none() {
            let mut effects = self.engine.compile();
            effects.extend(self.engine.app.begin_watch());
            self.perform(effects);
            if let Some(buffer) = self.engine.frame() {
                let fresh = std::mem::take(&mut self.fresh);
                self.mailbox.post(Frame { buffer, exact: self.engine.app.is_final() }, fresh);
            }
            let effects = self.engine.wait(None);
            self.perform(effects);
            self.engine.app.lose_patience(Instant::now());
        }
        self.end()
    }

    fn perform(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            self.perform_one(effect);
        }
    }

    fn take(&mut self, event: Event) {
        let effects = self.engine.take(event);
        self.perform(effects);
    }

    fn perform_one(&mut self, effect: Effect) {
        match effect {
            Effect::List(directory, endings) => self.errands.send(Errand::List(directory, endings)),
            Effect::Look(file) => self.errands.send(Errand::Look(file)),
            Effect::Measure(file) => self.errands.send(Errand::Measure(file)),
            // If the thread has panicked, the interface knows already.
            Effect::Watch(files) => drop(self.watched.send(files)),
            Effect::Reread(file) => self.errands.send(Errand::Reread(file)),
            Effect::WriteScene(written) => self.errands.send(Errand::Write(written)),
            Effect::WriteModel { change, text } => self.errands.send(Errand::WriteModel(change, text)),
            Effect::Save(percent) => self.saver.save(self.engine.app.film().clone(), percent),
            Effect::Stop if terminal::can_stop() => {
                self.mailbox.hold();
                self.guard.terminal().leave();
                terminal::stop();
            }
            Effect::Stop => self.engine.app.cannot_stop(Instant::now()),
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
            // Done by the engine.
            Effect::Threads(_) | Effect::Start(_) | Effect::Probe(_) | Effect::Pause(_) | Effect::Advise { .. } => {}
        }
    }

    /// Restores the terminal and says how it went.
    fn end(self) -> Result<Outcome, Error> {
        let (mut app, events) = self.engine.end();
        self.mailbox.hold();
        drop(self.guard);
        let exit = app.exit().cloned().unwrap_or(Exit::Quit);
        for event in events.try_iter().filter(|event| matches!(event, Event::Saved(_))) {
            app.update(event, Instant::now());
        }
        let signal = match exit {
            Exit::Compile(error) => return Err(Error::Compile(error)),
            Exit::Broken(message) => return Err(Error::Broken(message)),
            Exit::Signal(number) => Some(number),
            Exit::Quit => None,
        };
        let file = app.output_text();
        let (line, code) = match app.saved() {
            _ if app.is_saving() => (format!("left before the picture was saved as {file}"), 1),
            Some(Ok(100)) => (format!("saved {file}"), 0),
            Some(Ok(percent)) => (format!("saved {file} at {percent} %"), 0),
            Some(Err(reason)) => (format!("cannot save {file}: {reason}"), 1),
            None => (format!("left at {} %; nothing was saved", app.percent()), 0),
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
