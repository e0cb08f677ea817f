//! Worker threads and their handle.

use super::control::Control;
use super::event::{RenderError, RenderEvent};
use super::pass::Pass;
use super::tile::{Batch, Rect, Tile, is_valid_side};
use crate::scene::Scene;
use crate::shading::sampler;
use crossbeam_channel::{Receiver, Sender, TrySendError, bounded, unbounded};
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// How a render is carried out; nothing here changes a bit of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Worker threads.
    pub threads: NonZeroUsize,
    /// Side of a tile in pixels, a multiple of 8.
    pub tile_size: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { threads: default_threads(), tile_size: 32 }
    }
}

/// As many threads as there are processors to use.
pub fn default_threads() -> NonZeroUsize {
    thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// Events that may wait to be taken; workers wait for room.
const EVENTS_IN_FLIGHT: usize = 1024;

/// Recursion over 64 levels of reflection needs little; this is plenty.
const STACK: usize = 4 << 20;

/// A running render. Dropping it cancels the render before the next sample of each worker, without waiting.
#[derive(Debug)]
pub struct RenderHandle {
    events: Receiver<RenderEvent>,
    control: Arc<Control>,
}

impl RenderHandle {
    /// The render's own channel: no event of another render can arrive here. Ends after `Finished` or `Failed`.
    pub fn events(&self) -> &Receiver<RenderEvent> {
        &self.events
    }

    /// Stops the workers between two samples until `resume`.
    pub fn pause(&self) {
        self.control.pause(true);
    }

    /// Goes on after `pause`.
    pub fn resume(&self) {
        self.control.pause(false);
    }
}

impl Drop for RenderHandle {
    fn drop(&mut self) {
        self.control.cancel();
    }
}

/// Starts worker threads on a scene and returns at once.
///
/// Tiles wait in a queue, in the order of [`Rect::spiral`]. A worker takes the first, traces its next pass, reports it, and
/// puts the tile at the end of the queue if it has passes to come. So all tiles go through the passes together, a tile is
/// in one pair of hands at a time, and nobody waits for anybody.
///
/// # Panics
/// If `settings.tile_size` is not a multiple of 8.
pub fn start(scene: Arc<Scene>, settings: Settings) -> RenderHandle {
    assert!(is_valid_side(settings.tile_size), "tile size {} is not a multiple of 8", settings.tile_size);
    let control = Arc::new(Control::default());
    let (event_sender, events) = bounded(EVENTS_IN_FLIGHT);
    let (queue_sender, queue) = unbounded();
    let tiles = Rect::spiral(scene.width, scene.height, settings.tile_size);
    let open = Arc::new(AtomicUsize::new(tiles.len()));
    for rect in tiles {
        // The queue outlives the loop, so this can not fail.
        let _ = queue_sender.send(Some((Tile::new(rect), 0)));
    }
    let passes: Arc<[Pass]> = Pass::sequence(scene.render.samples).into();
    for index in 0..settings.threads.get() {
        let worker = Worker {
            index,
            scene: scene.clone(),
            passes: passes.clone(),
            control: control.clone(),
            events: event_sender.clone(),
            queue: queue.clone(),
            requeue: queue_sender.clone(),
            open: open.clone(),
        };
        let started =
            thread::Builder::new().name(format!("render {index}")).stack_size(STACK).spawn(move || worker.run());
        if let Err(error) = started {
            control.cancel();
            let message = format!("the system started no thread: {error}");
            report_failure(&event_sender, &events, RenderError { worker: index, message });
            break;
        }
    }
    RenderHandle { events, control }
}

/// Puts the failure into the channel though nobody reads yet: what workers have reported gives way to it.
fn report_failure(sender: &Sender<RenderEvent>, events: &Receiver<RenderEvent>, error: RenderError) {
    let mut event = RenderEvent::Failed(error);
    while let Err(TrySendError::Full(back)) = sender.try_send(event) {
        let _ = events.try_recv();
        event = back;
    }
}

/// A tile with the number of its next pass; `None` tells a worker to go home.
type Job = Option<(Tile, usize)>;

struct Worker {
    index: usize,
    scene: Arc<Scene>,
    passes: Arc<[Pass]>,
    control: Arc<Control>,
    events: Sender<RenderEvent>,
    queue: Receiver<Job>,
    requeue: Sender<Job>,
    /// Tiles that are not through all passes.
    open: Arc<AtomicUsize>,
}

impl Worker {
    fn run(self) {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.work()));
        if let Err(panic) = outcome {
            self.control.cancel();
            let text = |p: &(dyn std::any::Any + Send)| {
                p.downcast_ref::<&str>().map(ToString::to_string).or_else(|| p.downcast_ref::<String>().cloned())
            };
            let message = text(&*panic).unwrap_or_else(|| "panic without a message".into());
            let _ = self.events.send(RenderEvent::Failed(RenderError { worker: self.index, message }));
        }
        // Wake one that waits for a tile, since there will be none; it wakes the next.
        let _ = self.requeue.send(None);
    }

    fn work(&self) {
        let sampler = sampler(&self.scene);
        let mut batch = Batch::default();
        while let Ok(Some((mut tile, number))) = self.queue.recv() {
            let pass = self.passes[number];
            let started = RenderEvent::TileStarted { worker: self.index, rect: tile.rect(), pass };
            if self.events.send(started).is_err() {
                return;
            }
            let Some(stats) = tile.trace(&self.scene, sampler, pass, &mut batch, &self.control) else { return };
            let image = tile.image(pass);
            if self.events.send(RenderEvent::TileFinished { worker: self.index, tile: image, stats, pass }).is_err() {
                return;
            }
            if number + 1 < self.passes.len() {
                let _ = self.requeue.send(Some((tile, number + 1)));
            } else if self.open.fetch_sub(1, Ordering::AcqRel) == 1 {
                // This was the last tile, and its event is in the channel behind all others.
                let _ = self.events.send(RenderEvent::Finished);
                return;
            }
        }
    }
}
