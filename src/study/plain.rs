//! The plainest renderer that traces the same samples: what progressiveness and streaming are measured against.

use crate::math::Rgb;
use crate::render::{BATCH, Film, FilmPoints, Rect, blocks};
use crate::scene::Scene;
use crate::shading::{RayCounts, Sample, Scratch, sampler};
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

/// Side of a tile.
const TILE: u32 = 32;

/// Traces all samples of every pixel in one pass over tiles that threads take from a counter. Nothing is told, nobody
/// can pause it, no error is estimated. The picture is that of a uniform render, bit for bit; samples that are not
/// finite are left out there, too.
pub fn plain(scene: &Scene, threads: NonZeroUsize) -> Film {
    let tiles = Rect::spiral(scene.width, scene.height, TILE);
    let next = AtomicUsize::new(0);
    let film = Mutex::new(vec![[0.0; 3]; scene.width as usize * scene.height as usize]);
    thread::scope(|scope| {
        for _ in 0..threads.get() {
            scope.spawn(|| {
                let mut worker = Worker::new(scene);
                while let Some(rect) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                    worker.trace(*rect);
                    let mut film = film.lock().expect("no thread panics while it copies");
                    for (&(x, y), (sum, count)) in worker.pixels.iter().zip(&worker.sums) {
                        film[(y * scene.width + x) as usize] = (*sum / f64::from((*count).max(1))).to_f32();
                    }
                }
            });
        }
    });
    Film::of_pixels(scene.width, scene.height, film.into_inner().expect("no thread panics while it copies"))
}

/// One thread's buffers.
struct Worker<'a> {
    scene: &'a Scene,
    /// Pixels of the tile in blocks, and the sums and numbers of their samples.
    pixels: Vec<(u32, u32)>,
    sums: Vec<(Rgb, u32)>,
    points: FilmPoints,
    /// The pixel that each point belongs to.
    owners: Vec<usize>,
    samples: Vec<Sample>,
    scratch: Scratch,
}

impl<'a> Worker<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            pixels: Vec::new(),
            sums: Vec::new(),
            points: FilmPoints::default(),
            owners: Vec::new(),
            samples: vec![Sample::default(); BATCH],
            scratch: Scratch::default(),
        }
    }

    fn trace(&mut self, rect: Rect) {
        self.pixels.clear();
        self.pixels.extend(blocks(rect.width, rect.height).map(|(row, column)| (rect.x + column, rect.y + row)));
        self.sums.clear();
        self.sums.resize(self.pixels.len(), (Rgb::BLACK, 0));
        for pixel in 0..self.pixels.len() {
            let (x, y) = self.pixels[pixel];
            for index in 0..self.scene.render.samples {
                self.points.push(x, y, index);
                self.owners.push(pixel);
                if self.points.count() == BATCH {
                    self.flush();
                }
            }
        }
        self.flush();
    }

    fn flush(&mut self) {
        let points = self.points.find(self.scene, Some(self.scene.render.filter));
        let samples = &mut self.samples[..points.len()];
        let (mut rays, never) = (RayCounts::default(), AtomicBool::new(false));
        sampler(self.scene)(self.scene, points, samples, &mut rays, &mut self.scratch, &never);
        for (&pixel, sample) in self.owners.iter().zip(&*samples).filter(|(_, sample)| sample.radiance.is_finite()) {
            self.sums[pixel].0 += sample.radiance;
            self.sums[pixel].1 += 1;
        }
        self.points.clear();
        self.owners.clear();
    }
}
