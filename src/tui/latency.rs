//! How long the interface takes from a key to a whole new picture of what the key has changed.
//!
//! Measured by telling the interface keys as a terminal would, in the loop that it runs in with one, up to the screen
//! as cells: what is sent after that is the terminal's and the network's time. The edits come while the picture before
//! them is still refined, since that is how people edit.

use super::Options;
use super::app::{Activity, App};
use super::color::ColorMode;
use super::engine::Engine;
use super::event::{Effect, Event};
use super::key::{Code, Key};
use super::writer::{Frame, Screen};
use crate::description::{SceneDesc, Target};
use crate::math::SplitMix64;
use crate::render::{Film, Settings, start};
use crate::scene::{CompileError, Scene, compile_for};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What is edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edit {
    /// An arrow key orbits the eye.
    Camera,
    /// The diffuse reflection of the first material is nudged.
    Material,
    /// The intensity of the first light is nudged.
    Light,
    /// The first object is nudged along an axis.
    Object,
}

impl Edit {
    /// All of them.
    pub const ALL: [Edit; 4] = [Edit::Camera, Edit::Material, Edit::Light, Edit::Object];

    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Material => "material",
            Self::Light => "light",
            Self::Object => "object",
        }
    }

    /// What has to be selected, and the row of its properties that is nudged; `None` if the scene has no such thing.
    fn place(self, desc: &SceneDesc) -> Option<(Target, &'static str)> {
        let (target, label) = match self {
            Self::Camera => return None,
            Self::Material => (Target::Material(0), "diffuse"),
            Self::Light => (Target::Light(0), "intensity"),
            Self::Object => (Target::Object(0), "translate x"),
        };
        target.exists(desc).then_some((target, label))
    }
}

/// Times since a key was pressed.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Until the new scene was compiled.
    pub compiled: Duration,
    /// Until every part of the picture had a sample of it.
    pub traced: Duration,
    /// Until all cells of the screen were painted with them.
    pub painted: Duration,
}

/// An interface without a terminal, to be told keys and timed.
pub struct Bench {
    engine: Engine,
    random: SplitMix64,
}

/// Keys come so long after the picture before them was whole: in the middle of its refinement.
const PAUSES: std::ops::Range<f64> = 0.02..0.12;
/// Longest a picture is waited for.
const PATIENCE: Duration = Duration::from_secs(60);

/// What showing a whole render took.
#[derive(Debug)]
pub struct Shown {
    /// The picture.
    pub film: Arc<Film>,
    /// From the start to the end of the render.
    pub time: Duration,
    /// Frames that were painted.
    pub frames: usize,
    /// What a terminal would have been sent.
    pub bytes: usize,
}

/// Renders the scene to its end while the interface paints it and turns it into what a terminal is sent. `None` if the
/// render fails.
pub fn show(options: Options, size: (u16, u16)) -> Result<Option<Shown>, CompileError> {
    let mut bench = Bench::start(options, size)?;
    let (mut screen, mut frames, mut bytes) = (Screen::default(), 0, 0);
    let begun = Instant::now();
    while !matches!(bench.app().activity(), Activity::Finished | Activity::Failed) {
        let effects = bench.engine.compile();
        bench.perform(effects);
        if let Some(buffer) = bench.engine.frame() {
            frames += 1;
            bytes += screen.chunk(&Frame { buffer, exact: bench.app().is_final() }, usize::MAX).0.len();
        }
        let effects = bench.engine.wait(None);
        bench.perform(effects);
    }
    let time = begun.elapsed();
    let is_whole = bench.app().activity() == Activity::Finished;
    Ok(is_whole.then(|| Shown { film: bench.app().film().clone(), time, frames, bytes }))
}

impl Bench {
    /// Shows the scene on a screen of `size` columns and rows, up to its first whole picture.
    pub fn new(options: Options, size: (u16, u16)) -> Result<Self, CompileError> {
        let mut bench = Self::start(options, size)?;
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end && !bench.app().is_whole() {
            bench.turn(end);
        }
        Ok(bench)
    }

    fn start(options: Options, size: (u16, u16)) -> Result<Self, CompileError> {
        let Options { desc, compiled, isa, threads, .. } = options;
        // What may go wrong goes wrong here.
        let scene = Arc::new(compile_for(&desc, compiled.as_deref(), isa)?);
        let mut app = App::new(desc, &options.scene_name, &options.output, threads.get(), ColorMode::Truecolor, size);
        app.lend(scene);
        Ok(Self { engine: Engine::new(app, isa, threads, None), random: SplitMix64(1) })
    }

    /// The scene that is shown.
    pub fn app(&self) -> &App {
        &self.engine.app
    }

    /// Makes `count` edits of a kind and times each; `None` if the scene has nothing of that kind.
    pub fn measure(&mut self, edit: Edit, count: usize) -> Option<Vec<Answer>> {
        let place = edit.place(self.app().desc());
        if place.is_none() && edit != Edit::Camera {
            return None;
        }
        if let Some((target, label)) = place {
            self.engine.app.go_to(target, label);
        } else {
            self.engine.app.go_to_picture();
        }
        let mut answers = Vec::with_capacity(count);
        for number in 0..count {
            let code = if number % 2 == 0 { Code::Left } else { Code::Right };
            let pause = Duration::from_secs_f64(self.random.range(PAUSES.start, PAUSES.end));
            self.run_for(pause);
            answers.push(self.answer(Key::plain(code))?);
        }
        Some(answers)
    }

    /// Presses a key; `None` if that changes nothing.
    pub fn answer(&mut self, key: Key) -> Option<Answer> {
        let begun = Instant::now();
        let mut answer = Answer { compiled: Duration::ZERO, traced: Duration::ZERO, painted: Duration::ZERO };
        self.take(Event::Key(key));
        if self.app().is_seen() {
            return None;
        }
        while begun.elapsed() < PATIENCE {
            self.turn(begun + PATIENCE);
            let now = begun.elapsed();
            let note = |time: &mut Duration, is_so: bool| {
                if is_so && time.is_zero() {
                    *time = now;
                }
            };
            note(&mut answer.compiled, !self.app().is_restarting());
            note(&mut answer.traced, self.app().is_awaited() || self.app().is_seen());
            if self.app().is_seen() {
                return Some(Answer { painted: now, ..answer });
            }
        }
        None
    }

    /// One turn of the loop.
    fn turn(&mut self, until: Instant) {
        let effects = self.engine.compile();
        self.perform(effects);
        let was_seen = self.app().is_seen();
        // Painting is what is measured; the cells are not needed.
        let painted = self.engine.frame().is_some();
        if !(painted && self.app().is_seen() && !was_seen) {
            let effects = self.engine.wait(Some(until));
            self.perform(effects);
        }
    }

    fn run_for(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while Instant::now() < end {
            self.turn(end);
        }
    }

    fn take(&mut self, event: Event) {
        let effects = self.engine.take(event);
        self.perform(effects);
    }

    /// Nothing is written here.
    fn perform(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            if let Effect::Save(percent) = effect {
                self.take(Event::Saved(Ok(percent)));
            }
        }
    }
}

/// Times from dropping the handle of a running render until all its workers have left.
pub fn cancels(scene: &Arc<Scene>, settings: Settings, count: usize) -> Vec<Duration> {
    let mut random = SplitMix64(2);
    let cancel = |_| {
        let render = start(scene.clone(), settings);
        let events = render.events().clone();
        let end = Instant::now() + Duration::from_secs_f64(random.range(PAUSES.start, PAUSES.end));
        while events.recv_deadline(end).is_ok() {}
        let begun = Instant::now();
        drop(render);
        while events.recv().is_ok() {}
        begun.elapsed()
    };
    (0..count).map(cancel).collect()
}
