//! Worker threads and their handle.

use super::batch::{BATCH, Batch, Traced, Tracer, trace};
use super::census::{Census, Plan};
use super::control::Control;
use super::event::{Cut, RenderError, RenderEvent, TileStats};
use super::map::Map;
use super::pass::{COARSEST, Pass};
use super::rect::Rect;
use super::rooms::Rooms;
use super::round::Round;
use super::scatter::JUDGED;
use super::thin::thin;
use super::tile::{Tile, is_valid_side};
use crate::description::Filter;
use crate::scene::Scene;
use crate::shading::{Probe, Sampler, probe_sampler, sampler};
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded, unbounded};
use std::convert::Infallible;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

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
    /// Disconnected as soon as all workers have left.
    ended: Receiver<Infallible>,
    begun: Instant,
    control: Arc<Control>,
}

impl RenderHandle {
    /// The render's own channel: no event of another render can arrive here. Ends after `Finished` or `Failed`.
    pub fn events(&self) -> &Receiver<RenderEvent> {
        &self.events
    }

    /// The next event, for those who do nothing else meanwhile. Where none is waiting, some are let come together
    /// first, for up to 5 ms or a 64th of the time that has passed: to wake a sleeping thread for every tile took 6 %
    /// of the processor time on the demo scene.
    pub fn next_event(&self, patience: Duration) -> Result<RenderEvent, RecvTimeoutError> {
        if self.events.is_empty() {
            let _ = self.ended.recv_timeout((self.begun.elapsed() / 64).min(Duration::from_millis(5)));
        }
        self.events.recv_timeout(patience)
    }

    /// Stops the workers between two samples until `resume`.
    pub fn pause(&self) {
        self.control.pause(true);
    }

    /// Goes on after `pause`.
    pub fn resume(&self) {
        self.control.pause(false);
    }

    /// Ends the render at this time with `Finished` and all that is known then, but not before there is a whole
    /// picture. Pauses put it off. This alone makes a picture that is not a function of the scene.
    pub fn finish_by(&self, deadline: Instant) {
        self.control.set_deadline(deadline);
    }
}

impl Drop for RenderHandle {
    fn drop(&mut self) {
        self.control.cancel();
    }
}

/// Starts worker threads on a scene and returns at once.
///
/// Tiles wait in a queue, in the order of [`Rect::spiral`], for their first pass some of them together. A worker takes
/// the first, traces its next pass, reports it, and puts the tile at the end of the queue if it has passes to come. So
/// all tiles go through the passes together, a tile is in one pair of hands at a time, and nobody waits for anybody.
///
/// With an error to reach, the passes that give every pixel its first sample are followed by rounds. When all tiles
/// have been traced, each pixel is judged by its samples and its neighbours; when all have been judged, who comes last
/// adds up how wrong the picture is and plans which pixels are worth more samples.
///
/// # Panics
/// If `settings.tile_size` is not a multiple of 8.
pub fn start(scene: Arc<Scene>, settings: Settings) -> RenderHandle {
    start_in(scene, settings, &Rooms::default())
}

/// The same in rooms of earlier renders.
///
/// # Panics
/// As [`start`].
pub fn start_in(scene: Arc<Scene>, settings: Settings, rooms: &Rooms) -> RenderHandle {
    let (filter, sampler) = (Some(scene.render.filter), sampler(&scene));
    launch(scene, settings, sampler, filter, rooms)
}

/// Starts worker threads that tell something else than light: the pixels of the tiles hold what [`Probe`] says, found
/// through the middle of each pixel.
///
/// # Panics
/// As [`start`].
pub fn start_probe(scene: Arc<Scene>, probe: Probe, settings: Settings) -> RenderHandle {
    let sampler = probe_sampler(&scene, probe);
    launch(scene, settings, sampler, None, &Rooms::default())
}

fn launch(
    scene: Arc<Scene>,
    settings: Settings,
    sampler: Sampler,
    filter: Option<Filter>,
    rooms: &Rooms,
) -> RenderHandle {
    assert!(is_valid_side(settings.tile_size), "tile size {} is not a multiple of 8", settings.tile_size);
    let begun = Instant::now();
    let (event_sender, events) = bounded(EVENTS_IN_FLIGHT);
    let (queue_sender, queued) = unbounded();
    let (working, ended) = bounded(0);
    let tiles = Rect::spiral(scene.width, scene.height, settings.tile_size);
    let control = Arc::new(Control::new(tiles.len()));
    let render = scene.render;
    // Fewer samples than can be judged are the same everywhere.
    let target = render.error.filter(|_| render.samples > JUDGED && filter.is_some());
    let samples = if filter.is_some() { render.samples } else { 1 };
    let shared = Arc::new(Shared {
        begun,
        passes: if target.is_some() { Pass::lattices() } else { Pass::sequence(samples) },
        target,
        sampler,
        filter,
        map: OnceLock::new(),
        rooms: rooms.clone(),
        scene,
        control: control.clone(),
        tiles: tiles.len(),
        settings,
        done: AtomicUsize::new(0),
        at_work: AtomicUsize::new(settings.threads.get()),
        gathering: Mutex::default(),
    });
    queue(&queue_sender, tiles.into_iter().map(Tile::new), shared.together(1), Step::Listed(0));
    for index in 0..settings.threads.get() {
        let worker = Worker {
            index,
            shared: shared.clone(),
            events: event_sender.clone(),
            queue: queued.clone(),
            requeue: queue_sender.clone(),
            _working: working.clone(),
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
    RenderHandle { events, ended, begun, control }
}

/// Puts the failure into the channel though nobody reads yet: what workers have reported gives way to it.
fn report_failure(sender: &Sender<RenderEvent>, events: &Receiver<RenderEvent>, error: RenderError) {
    let mut event = RenderEvent::Failed(error);
    while let Err(TrySendError::Full(back)) = sender.try_send(event) {
        let _ = events.try_recv();
        event = back;
    }
}

/// A step of some tiles.
struct Job {
    tiles: Vec<Tile>,
    step: Step,
}

#[derive(Clone)]
enum Step {
    /// A pass of the list.
    Listed(usize),
    /// A round of refinement; the first has no plan.
    Round(u32, Option<Arc<Plan>>),
    /// What comes after the round: how wrong the pixels are.
    Judge(u32),
}

/// Lets a step be done, of so many tiles together.
fn queue(queue: &Sender<Option<Job>>, tiles: impl IntoIterator<Item = Tile>, together: usize, step: Step) {
    let mut tiles = tiles.into_iter().peekable();
    while tiles.peek().is_some() {
        // The queue outlives whoever has tiles, so this can not fail.
        let _ = queue.send(Some(Job { tiles: tiles.by_ref().take(together).collect(), step: step.clone() }));
    }
}

/// What all workers know.
struct Shared {
    begun: Instant,
    scene: Arc<Scene>,
    sampler: Sampler,
    filter: Option<Filter>,
    /// Those that are the same for every picture.
    passes: Vec<Pass>,
    /// The error to reach by rounds of refinement after the passes.
    target: Option<f64>,
    /// Made by the first worker that needs it, so that the first coarse picture does not wait for it.
    map: OnceLock<Map>,
    rooms: Rooms,
    control: Arc<Control>,
    tiles: usize,
    settings: Settings,
    /// Tiles that are through all passes.
    done: AtomicUsize,
    /// Workers that have not left.
    at_work: AtomicUsize,
    gathering: Mutex<Gathering>,
}

impl Shared {
    /// Tiles that are traced together if so many samples of each square of the coarsest lattice are: such that they
    /// fill a batch, but no worker is left without.
    fn together(&self, samples: usize) -> usize {
        let samples = samples * (self.settings.tile_size / COARSEST).pow(2) as usize;
        (self.tiles / (4 * self.settings.threads.get())).min(BATCH / samples).max(1)
    }

    fn round<'a>(&self, map: &'a Map, plan: Option<&'a Plan>) -> Round<'a> {
        Round { map, plan, limit: self.scene.render.samples }
    }
}

/// Tiles that wait for the next round, and what the round has brought.
#[derive(Default)]
struct Gathering {
    tiles: Vec<Tile>,
    /// Of the film.
    census: Census,
    /// Whether a tile was refined in the round under way.
    refined: bool,
}

struct Worker {
    index: usize,
    shared: Arc<Shared>,
    events: Sender<RenderEvent>,
    queue: Receiver<Option<Job>>,
    /// `None` tells a worker to go home.
    requeue: Sender<Option<Job>>,
    /// Dropped when the worker has left.
    _working: Sender<Infallible>,
}

/// Why a worker goes home.
struct Leave;

impl Worker {
    fn run(self) {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.work()));
        let control = &self.shared.control;
        if let Err(panic) = outcome {
            control.cancel();
            let text = |p: &(dyn std::any::Any + Send)| {
                p.downcast_ref::<&str>().map(ToString::to_string).or_else(|| p.downcast_ref::<String>().cloned())
            };
            let message = text(&*panic).unwrap_or_else(|| "panic without a message".into());
            let _ = self.events.send(RenderEvent::Failed(RenderError { worker: self.index, message }));
        }
        // Wake one that waits for a tile, since there will be none; it wakes the next.
        let _ = self.requeue.send(None);
        let last = self.shared.at_work.fetch_sub(1, Ordering::AcqRel) == 1;
        if last && !control.is_cancelled() {
            // Behind all that the others have sent.
            let _ = self.events.send(RenderEvent::Finished);
        }
    }

    fn work(&self) {
        let mut batch = Batch::new(self.shared.rooms.take());
        while let Ok(Some(job)) = self.queue.recv() {
            let done = match job.step {
                Step::Listed(number) => self.pass(job.tiles, number, &mut batch),
                Step::Round(number, plan) => self.round(job.tiles, number, plan.as_deref(), &mut batch),
                Step::Judge(number) => self.judge(job.tiles, number, &mut batch),
            };
            if let Err(Leave) = done {
                break;
            }
        }
        self.shared.rooms.give(batch.into_room());
    }

    fn tracer(&self) -> Tracer<'_> {
        let Shared { scene, sampler, filter, control, target, .. } = &*self.shared;
        Tracer { scene, sampler: *sampler, filter: *filter, control, differences: target.is_some() }
    }

    /// Traces a pass of the list.
    fn pass(&self, mut tiles: Vec<Tile>, number: usize, batch: &mut Batch) -> Result<(), Leave> {
        let (pass, tracer) = (self.shared.passes[number], self.tracer());
        self.start(&tiles[0], pass)?;
        let entering = Instant::now();
        batch.clear();
        (0..).zip(&mut tiles).for_each(|(at, tile)| tile.enter(at, pass, tracer.differences, batch));
        let mut stats = TileStats { busy: entering.elapsed(), ..TileStats::default() };
        let traced = trace(&mut tiles, tracer, batch, &mut stats);
        if traced == Traced::Cancelled {
            return Err(Leave);
        }
        let count = tiles.len() as u32;
        let busy = stats.busy / count;
        for (at, tile) in (0..).zip(&mut tiles) {
            let samples = tile.samples(at, batch);
            // Where a lattice is not whole, the picture of the coarser one is there already.
            if matches!(pass, Pass::Lattice { .. }) && samples < batch.of(at).len() as u64 {
                continue;
            }
            if at > 0 {
                self.start(tile, pass)?;
            }
            let stats = TileStats { samples, busy, ..std::mem::take(&mut stats) };
            self.tell(tile, pass, stats, busy * (count - 1 - at))?;
            if number == 0 {
                self.shared.control.cover();
            }
        }
        if traced == Traced::Part { Err(Leave) } else { self.pass_on(tiles, number) }
    }

    /// Reports that a tile is begun with: of those that are traced together the first before, the others when they are
    /// told.
    fn start(&self, tile: &Tile, pass: Pass) -> Result<(), Leave> {
        self.send(RenderEvent::TileStarted { worker: self.index, rect: tile.rect(), pass })
    }

    /// Reports a tile after a pass of the list. `others`: busy time since, of those that were traced with it.
    fn tell(&self, tile: &mut Tile, pass: Pass, mut stats: TileStats, others: Duration) -> Result<(), Leave> {
        let judging = Instant::now();
        let mut image = tile.image(None);
        if let Some((change, errors)) = tile.own_errors(pass, &image.pixels) {
            (stats.squared_error, image.errors) = (Some(change), errors);
        }
        stats.cut = tile.count_cut();
        stats.busy += judging.elapsed();
        stats.done = self.shared.begun.elapsed().saturating_sub(others);
        self.send(RenderEvent::TileFinished { worker: self.index, tile: image, stats, pass })
    }

    /// Passes tiles on to the next pass of the list: alone, where they have points enough.
    fn pass_on(&self, tiles: Vec<Tile>, number: usize) -> Result<(), Leave> {
        let shared = &*self.shared;
        if let Some(next) = shared.passes.get(number + 1) {
            let together = if matches!(next, Pass::Lattice { step } if *step > 2) { tiles.len() } else { 1 };
            queue(&self.requeue, tiles, together, Step::Listed(number + 1));
            return Ok(());
        }
        let count = tiles.len();
        if shared.target.is_some() {
            let Scene { width, height, .. } = *shared.scene;
            let map = shared.map.get_or_init(|| Map::new(width, height, thin(&shared.scene)));
            for tile in tiles {
                tile.write(map);
                self.gather_traced(tile, 0, None);
            }
        } else if shared.done.fetch_add(count, Ordering::AcqRel) + count == shared.tiles {
            return Err(Leave);
        }
        Ok(())
    }

    /// Traces what tiles need in a round of refinement.
    fn round(&self, mut tiles: Vec<Tile>, number: u32, plan: Option<&Plan>, batch: &mut Batch) -> Result<(), Leave> {
        let shared = &*self.shared;
        let Some(map) = shared.map.get() else { return Err(Leave) };
        let (round, pass) = (shared.round(map, plan), Pass::Adapt { round: number });
        batch.clear();
        (0..).zip(&tiles).for_each(|(at, tile)| tile.choose(at, &round, batch));
        let wanted: Vec<u32> = (0..tiles.len() as u32).filter(|at| batch.wants(*at)).collect();
        let Some(&first) = wanted.first() else {
            tiles.into_iter().for_each(|tile| self.gather_traced(tile, number, None));
            return Ok(());
        };
        self.start(&tiles[first as usize], pass)?;
        let cuts: Vec<Cut> = (0..).zip(&tiles).map(|(at, tile)| tile.cut_of(at, batch)).collect();
        let mut stats = TileStats { busy: std::mem::take(&mut batch.untold), ..TileStats::default() };
        let traced = trace(&mut tiles, self.tracer(), batch, &mut stats);
        if traced == Traced::Cancelled {
            return Err(Leave);
        }
        let mut count = wanted.len() as u32;
        let busy = stats.busy / count;
        for (at, (mut tile, cut)) in (0..).zip(tiles.into_iter().zip(cuts)) {
            if !batch.wants(at) {
                self.gather_traced(tile, number, None);
                continue;
            }
            if at != first {
                self.start(&tile, pass)?;
            }
            let (mut census, judging) = (Census::default(), Instant::now());
            let mut stats = TileStats { samples: tile.samples(at, batch), busy, ..std::mem::take(&mut stats) };
            tile.note(at, &round, batch, &mut census);
            let (image, change) = tile.refined(at, &round, batch);
            (stats.squared_error, stats.cut) = (change, tile.recount_cut(at, cut, batch));
            stats.busy += judging.elapsed();
            count -= 1;
            stats.done = shared.begun.elapsed().saturating_sub(busy * count);
            self.send(RenderEvent::TileFinished { worker: self.index, tile: image, stats, pass })?;
            if traced == Traced::Whole {
                self.gather_traced(tile, number, Some(&census));
            }
        }
        if traced == Traced::Part { Err(Leave) } else { Ok(()) }
    }

    /// Takes a tile in that has been traced in a round, with what its census says if it was refined. Who brings the
    /// last one lets all be judged.
    fn gather_traced(&self, tile: Tile, number: u32, census: Option<&Census>) {
        let mut gathering = self.shared.gathering.lock().unwrap_or_else(PoisonError::into_inner);
        gathering.tiles.push(tile);
        if let Some(census) = census {
            gathering.census.merge(census);
            gathering.refined = true;
        }
        if gathering.tiles.len() < self.shared.tiles {
            return;
        }
        // A plan that refines nothing would come again for ever. In round 1 the lot may fall on no pixel of a small
        // film.
        let refined = std::mem::take(&mut gathering.refined);
        assert!(refined || number <= 1, "round {number} has refined nothing");
        queue(&self.requeue, gathering.tiles.drain(..), self.shared.together(1), Step::Judge(number));
    }

    /// Judges the pixels of tiles after a round. Who judges the last one plans the next round.
    fn judge(&self, mut tiles: Vec<Tile>, number: u32, batch: &mut Batch) -> Result<(), Leave> {
        let shared = &*self.shared;
        let Some(map) = shared.map.get() else { return Err(Leave) };
        let (mut census, judging) = (Census::default(), Instant::now());
        tiles.iter_mut().for_each(|tile| tile.judge(&shared.round(map, None), batch, &mut census));
        batch.untold += judging.elapsed();
        let mut gathering = shared.gathering.lock().unwrap_or_else(PoisonError::into_inner);
        gathering.tiles.append(&mut tiles);
        gathering.census.merge(&census);
        if gathering.tiles.len() < shared.tiles {
            return Ok(());
        }
        let mut plan = None;
        if number > 0 {
            self.send(RenderEvent::Estimated { error: gathering.census.error() })?;
            plan = gathering.census.plan(shared.target.unwrap_or_default()).map(Arc::new);
            if plan.is_none() {
                return Err(Leave);
            }
        }
        gathering.census.age();
        // The longest first, so that nobody waits long for the last.
        gathering.tiles.sort_by(|a, b| b.told().total_cmp(&a.told()));
        let together = if number == 0 { shared.together(JUDGED as usize - 1) } else { 1 };
        queue(&self.requeue, gathering.tiles.drain(..), together, Step::Round(number + 1, plan));
        Ok(())
    }

    /// Reports; nobody listens any more if the render is to be left.
    fn send(&self, event: RenderEvent) -> Result<(), Leave> {
        self.events.send(event).map_err(|_| Leave)
    }
}
