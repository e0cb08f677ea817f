//! Worker threads and their handle.

use super::RenderEvent;
use crate::scene::Scene;
use crossbeam_channel::Receiver;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// How a render is carried out; nothing here changes a bit of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Worker threads.
    pub threads: NonZeroUsize,
    /// Side of a tile in pixels, a multiple of 8.
    pub tile_size: u32,
}

/// As many threads as there are processors to use.
pub fn default_threads() -> NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// A running render. Dropping it cancels the render within one row of a tile, without waiting.
pub struct RenderHandle {
    events: Receiver<RenderEvent>,
}

impl RenderHandle {
    /// The render's own channel: no event of another render can arrive here.
    pub fn events(&self) -> &Receiver<RenderEvent> {
        &self.events
    }

    /// Stops the workers between two rows until `resume`.
    pub fn pause(&self) {
        todo!()
    }

    /// Goes on after `pause`.
    pub fn resume(&self) {
        todo!()
    }
}

/// Starts worker threads on a scene and returns at once.
pub fn start(_scene: Arc<Scene>, _settings: Settings) -> RenderHandle {
    todo!()
}
