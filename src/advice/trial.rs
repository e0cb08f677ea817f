//! Small renders with and without a change.

use super::{Change, CoarseModel};
use crate::description::SceneDesc;
use crate::math::linear_to_srgb;
use crate::render::{Film, RenderError, RenderEvent, Settings, start};
use crate::scene::{CompileError, Scene, compile_for};
use std::fmt;
use std::sync::Arc;

/// Why there is no advice.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// It was asked to stop.
    Stopped,
    /// The scene cannot be compiled.
    Compile(CompileError),
    /// A render failed.
    Render(RenderError),
    /// A model that is to be tried could not be written.
    File(String),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped => f.write_str("stopped"),
            Self::Compile(error) => error.fmt(f),
            Self::Render(error) => error.fmt(f),
            Self::File(error) => f.write_str(error),
        }
    }
}

impl std::error::Error for Failure {}

/// Most pixels across, and most samples: first to reject what is wrong, then to be sure and to measure.
const QUICK: (u32, u32) = (160, 1);
const SURE: (u32, u32) = (640, 2);
/// More samples than that are not rendered to judge how many are needed.
const MOST_SAMPLES: u32 = 16;
/// A render that is timed is made so often, in turn with what it is compared to; the quickest counts.
const TIMED: usize = 2;

/// One render.
struct Trial {
    film: Film,
    rays: u64,
    /// Of all threads together.
    seconds: f64,
}

/// What a change brings.
pub(super) struct Weighed {
    /// Parts saved.
    pub rays: f64,
    pub time: f64,
    /// Changes of the picture, codes.
    pub rmse: f64,
    pub largest: f64,
}

/// The scene as it is, and its pictures.
pub(super) struct Bench<'a> {
    desc: &'a SceneDesc,
    compiled: &'a Scene,
    settings: Settings,
    stop: &'a dyn Fn() -> bool,
    scene: Arc<Scene>,
    quick: Trial,
    sure: Option<Trial>,
}

impl<'a> Bench<'a> {
    pub fn new(
        desc: &'a SceneDesc,
        compiled: &'a Scene,
        settings: Settings,
        stop: &'a dyn Fn() -> bool,
    ) -> Result<Self, Failure> {
        let scene = small(desc, compiled, QUICK)?;
        let quick = run(&scene, settings, stop)?;
        Ok(Self { desc, compiled, settings, stop, scene, quick, sure: None })
    }

    pub fn desc(&self) -> &'a SceneDesc {
        self.desc
    }

    /// Compiled for the quick picture.
    pub fn scene(&self) -> Arc<Scene> {
        self.scene.clone()
    }

    /// What a change does, if a small and then a larger picture fit.
    pub fn weigh(&mut self, change: &Change, fits: impl Fn(&Weighed) -> bool) -> Result<Option<Weighed>, Failure> {
        let mut edited = self.desc.clone();
        let mut written = None;
        match change {
            // It is not there yet: one like it is tried, and away again.
            Change::Coarsen(index, model) => {
                let tried = written.insert(Tried::write(model).map_err(Failure::File)?);
                Change::Coarsen(*index, tried.0.clone()).apply(&mut edited);
            }
            change => change.apply(&mut edited),
        }
        if matches!(change, Change::Samples(_) | Change::Error(_)) {
            // Those of the trials themselves are compared; half the width has the same noise.
            let before = self.desc.render.samples.min(MOST_SAMPLES);
            let after = edited.render.samples.min(before);
            if after == before && edited.render.error.is_none() {
                // More than that would take too long to find out.
                return Ok(None);
            }
            let trials = [(before, None), (after, edited.render.error)].map(|(samples, error)| {
                let mut desc = self.desc.clone();
                desc.render.samples = samples;
                let scene = sized(desc, error, self.compiled, SURE.0 / 2)?;
                run(&scene, self.settings, self.stop)
            });
            let [before, after] = trials;
            let weighed = weigh(&before?, &after?);
            return Ok(fits(&weighed).then_some(weighed));
        }
        let quick = run(&small(&edited, self.compiled, QUICK)?, self.settings, self.stop)?;
        if !fits(&weigh(&self.quick, &quick)) {
            return Ok(None);
        }
        let scenes = [small(self.desc, self.compiled, SURE)?, small(&edited, self.compiled, SURE)?];
        let mut best: Option<Trial> = None;
        for _ in 0..TIMED {
            let before = run(&scenes[0], self.settings, self.stop)?;
            let after = run(&scenes[1], self.settings, self.stop)?;
            self.sure = Some(quicker(self.sure.take(), before));
            best = Some(quicker(best, after));
            if let (Some(before), Some(after)) = (&self.sure, &best)
                && !fits(&weigh(before, after))
            {
                return Ok(None);
            }
        }
        Ok(self.sure.as_ref().zip(best.as_ref()).map(|(before, after)| weigh(before, after)))
    }
}

/// A model that is there as long as this lives.
struct Tried(Arc<CoarseModel>);

impl Tried {
    fn write(model: &CoarseModel) -> Result<Self, String> {
        let file = std::env::temp_dir().join(format!("glimt-coarse-{}-{model:p}.obj", std::process::id()));
        let told = |error: &dyn fmt::Display| format!("cannot write {}: {error}", file.display());
        std::fs::write(&file, &model.text).map_err(|error| told(&error))?;
        Ok(Self(Arc::new(CoarseModel { file, text: String::new() })))
    }
}

impl Drop for Tried {
    fn drop(&mut self) {
        // Nothing depends on it.
        let _ = std::fs::remove_file(&self.0.file);
    }
}

fn quicker(a: Option<Trial>, b: Trial) -> Trial {
    match a {
        Some(a) if a.seconds <= b.seconds => a,
        _ => b,
    }
}

fn weigh(before: &Trial, after: &Trial) -> Weighed {
    let (mut squares, mut largest) = (0.0, 0.0f64);
    for (a, b) in before.film.pixels().iter().flatten().zip(after.film.pixels().iter().flatten()) {
        let apart = 255.0 * (linear_to_srgb(f64::from(*a)) - linear_to_srgb(f64::from(*b))).abs();
        squares += apart * apart;
        largest = largest.max(apart);
    }
    let channels = 3.0 * before.film.pixels().len() as f64;
    Weighed {
        rays: 1.0 - after.rays as f64 / before.rays.max(1) as f64,
        time: 1.0 - after.seconds / before.seconds.max(1e-9),
        rmse: (squares / channels).sqrt(),
        largest,
    }
}

/// The scene for a picture at most so wide, with at most so many samples everywhere.
fn small(desc: &SceneDesc, compiled: &Scene, (widest, samples): (u32, u32)) -> Result<Arc<Scene>, Failure> {
    let mut desc = desc.clone();
    desc.render.samples = desc.render.samples.min(samples);
    sized(desc, None, compiled, widest)
}

/// The scene for a picture at most so wide, to this error.
fn sized(mut desc: SceneDesc, error: Option<f64>, compiled: &Scene, widest: u32) -> Result<Arc<Scene>, Failure> {
    if desc.film.width > widest {
        desc.film.height = (desc.film.height * widest).div_ceil(desc.film.width).max(1);
        desc.film.width = widest;
    }
    desc.render.error = error;
    compile_for(&desc, Some(compiled), compiled.isa()).map(Arc::new).map_err(Failure::Compile)
}

fn run(scene: &Arc<Scene>, settings: Settings, stop: &dyn Fn() -> bool) -> Result<Trial, Failure> {
    let mut trial = Trial { film: Film::new(scene.width, scene.height), rays: 0, seconds: 0.0 };
    let handle = start(scene.clone(), settings);
    for event in handle.events() {
        if stop() {
            return Err(Failure::Stopped);
        }
        match event {
            RenderEvent::TileFinished { tile, stats, .. } => {
                trial.film.write(&tile);
                trial.rays += stats.rays.total();
                trial.seconds += stats.busy.as_secs_f64();
            }
            RenderEvent::Failed(error) => return Err(Failure::Render(error)),
            _ => {}
        }
    }
    Ok(trial)
}
