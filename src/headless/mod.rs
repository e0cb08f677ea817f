//! Rendering without a terminal: a loop over the events, a progress bar or lines on stderr, a report at the end.

mod memory;
mod meter;
mod report;
mod signals;

pub use memory::{TooLarge, check_memory};
pub use report::{Report, Seconds};
pub use signals::Signals;

use crate::render::{Film, Layers, Progress, RenderError, RenderEvent, Scale, Settings, View, start, start_probe};
use crate::scene::Scene;
use meter::Meter;
use std::fmt;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A finished render.
pub struct Rendered {
    /// The picture.
    pub film: Film,
    /// What its colours mean, if it shows a quantity instead of light.
    pub scale: Option<Scale>,
    /// What it took.
    pub progress: Progress,
    /// Wall time from the start of the workers until every pixel had a sample.
    pub first_picture: Duration,
    /// Wall time from the start of the workers to the last sample.
    pub time: Duration,
}

/// Why a render did not come to its end.
#[derive(Debug)]
pub enum Unfinished {
    /// A signal asked to stop.
    Signal {
        /// Its number.
        number: u8,
        /// How far the render was.
        percent: u32,
    },
    /// A worker failed.
    Failed(RenderError),
    /// Signals could not be listened to.
    Signals(io::Error),
}

impl fmt::Display for Unfinished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Signal { number, percent } => {
                let name = signals::name(*number);
                write!(f, "stopped by {name} at {percent} %; nothing was written")
            }
            Self::Failed(error) => error.fmt(f),
            Self::Signals(error) => write!(f, "cannot listen to signals: {error}"),
        }
    }
}

impl std::error::Error for Unfinished {}

/// How long a signal may go unnoticed, and the bar unmoved.
const PATIENCE: Duration = Duration::from_millis(100);

/// Renders a view of a scene to its end, or for this time. Progress goes to stderr unless `quiet`. SIGINT and SIGTERM
/// end it early; they are still held back when this returns, so that what follows is not cut off in the middle.
pub fn render(
    scene: Arc<Scene>,
    view: View,
    settings: Settings,
    limit: Option<Duration>,
    quiet: bool,
) -> Result<Rendered, Unfinished> {
    let signals = Signals::listen().map_err(Unfinished::Signals)?;
    let begun = Instant::now();
    let mut film = Film::new(scene.width, scene.height);
    let mut layers = match (view, view.probe()) {
        (View::Final, _) | (_, Some(_)) => None,
        _ => Some(Layers::new(scene.width, scene.height)),
    };
    let mut progress = match view.probe() {
        Some(_) => Progress::of_probe(&scene, settings.threads.get(), begun),
        None => Progress::new(&scene, settings.threads.get(), begun),
    };
    let mut meter = Meter::new(quiet, &scene, settings, begun);
    let handle = match view.probe() {
        Some(probe) => start_probe(scene, probe, settings),
        None => start(scene, settings),
    };
    if let Some(limit) = limit {
        progress.set_time_limit(limit);
        handle.finish_by(begun + limit);
    }
    // By the clocks of the workers: this thread may be late.
    let (mut time, mut first_picture) = (Duration::ZERO, None);
    loop {
        let event = handle.next_event(PATIENCE);
        let now = Instant::now();
        if let Some(number) = signals.caught() {
            meter.end();
            return Err(Unfinished::Signal { number, percent: progress.percent() });
        }
        match event {
            Ok(event) => {
                progress.update(&event, now);
                match event {
                    RenderEvent::TileFinished { tile, stats, .. } => {
                        film.write(&tile);
                        time = time.max(stats.done);
                        if progress.first_picture.is_some() {
                            first_picture.get_or_insert(time);
                        }
                        if let Some(layers) = &mut layers {
                            layers.write(tile);
                        }
                    }
                    RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
                    RenderEvent::Finished => break,
                    RenderEvent::Failed(error) => {
                        meter.end();
                        return Err(Unfinished::Failed(error));
                    }
                }
            }
            Err(nothing) if nothing.is_timeout() => {}
            Err(_) => {
                meter.end();
                let message = "all threads ended before the picture was done".to_owned();
                return Err(Unfinished::Failed(RenderError { worker: 0, message }));
            }
        }
        meter.show(&progress, now);
    }
    meter.end();
    let values = layers.and_then(|layers| layers.values(view)).unwrap_or(film);
    let (film, scale) = match view {
        View::Final => (values, None),
        _ => {
            let (film, scale) = view.paint(&values);
            (film, view.unit().map(|_| scale))
        }
    };
    Ok(Rendered { film, scale, progress, first_picture: first_picture.unwrap_or(time), time })
}
