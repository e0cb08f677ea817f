//! One render inside a study.

use super::{Console, StudyError};
use crate::render::{Film, Progress, RenderError, RenderEvent, Settings, start};
use crate::scene::Scene;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A render that came to its end.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The picture.
    pub film: Film,
    /// What it took: rays, and the busy time of each thread.
    pub progress: Progress,
    /// Wall time from the start of the threads to the last sample.
    pub time: Duration,
}

/// How long a wish to stop may go unnoticed.
const PATIENCE: Duration = Duration::from_millis(100);

/// Renders a scene to its end. `watch` sees every event.
pub fn render(
    scene: &Arc<Scene>,
    settings: Settings,
    console: &Console,
    mut watch: impl FnMut(&RenderEvent),
) -> Result<Trial, StudyError> {
    let mut film = Film::new(scene.width, scene.height);
    let mut time = Duration::ZERO;
    let mut progress = Progress::new(scene, settings.threads.get(), Instant::now());
    let handle = start(Arc::clone(scene), settings);
    loop {
        let event = match handle.next_event(PATIENCE) {
            Ok(event) => event,
            Err(nothing) if nothing.is_timeout() => {
                console.go_on()?;
                continue;
            }
            Err(_) => {
                let message = "all threads ended before the picture was done".to_owned();
                return Err(RenderError { worker: 0, message }.into());
            }
        };
        console.go_on()?;
        let now = Instant::now();
        progress.update(&event, now);
        watch(&event);
        match event {
            RenderEvent::TileFinished { tile, stats, .. } => {
                film.write(&tile);
                time = time.max(stats.done);
            }
            RenderEvent::Finished => return Ok(Trial { film, progress, time }),
            RenderEvent::Failed(error) => return Err(error.into()),
            _ => {}
        }
    }
}
