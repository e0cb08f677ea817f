//! What a render tells of its pixels besides their colours.

use super::{Film, TileImage, View};

/// Samples of each pixel, how wrong it may be, and what was left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: u32,
    height: u32,
    samples: Vec<u32>,
    /// Below 0: nothing can be said.
    errors: Vec<f32>,
    non_finite: Vec<u32>,
}

impl Layers {
    /// Of a film without samples.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self { width, height, samples: vec![0; pixels], errors: vec![-1.0; pixels], non_finite: vec![0; pixels] }
    }

    /// Takes in what a tile tells.
    pub fn write(&mut self, tile: &TileImage) {
        let rect = tile.rect;
        for row in 0..rect.height as usize {
            let start = (rect.y as usize + row) * self.width as usize + rect.x as usize;
            let (to, from) = (start..start + rect.width as usize, row * rect.width as usize);
            let from = from..from + rect.width as usize;
            if let Some(samples) = tile.samples.get(from.clone()) {
                self.samples[to.clone()].copy_from_slice(samples);
            }
            match tile.errors.get(from.clone()) {
                Some(errors) => self.errors[to.clone()].copy_from_slice(errors),
                None => self.errors[to.clone()].fill(-1.0),
            }
            match tile.non_finite.get(from) {
                Some(counts) => self.non_finite[to].copy_from_slice(counts),
                None => self.non_finite[to].fill(0),
            }
        }
    }

    /// Samples of the pixel in column `x`, row `y`.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        self.samples[y as usize * self.width as usize + x as usize]
    }

    /// The values that one of the views of a render shows; `None` for another view.
    pub fn values(&self, view: View) -> Option<Film> {
        let pixels: Vec<[f32; 3]> = match view {
            View::Samples => self.samples.iter().map(|n| [*n as f32; 3]).collect(),
            View::Error => self.errors.iter().map(|error| [*error; 3]).collect(),
            View::NonFinite => self.non_finite.iter().map(|n| [*n as f32; 3]).collect(),
            _ => return None,
        };
        Some(Film::of_pixels(self.width, self.height, pixels))
    }
}
