//! What a render tells of its pixels besides their colours.

use super::{Film, TileImage, View};
use std::collections::BTreeMap;

/// Samples of each pixel, how wrong it may be, and what was left out: what tiles have told last, as they told it, since it
/// is seldom looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    width: u32,
    height: u32,
    /// Without colours, by row and column of their upper left corner.
    tiles: BTreeMap<(u32, u32), TileImage>,
}

impl Layers {
    /// Of a film without samples.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, tiles: BTreeMap::new() }
    }

    /// Takes in what a tile tells.
    pub fn write(&mut self, tile: TileImage) {
        self.tiles.insert((tile.rect.y, tile.rect.x), TileImage { pixels: Vec::new(), ..tile });
    }

    /// Samples of the pixel in column `x`, row `y`.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        let holds = |tile: &&TileImage| {
            let rect = tile.rect;
            (rect.x..rect.x + rect.width).contains(&x) && (rect.y..rect.y + rect.height).contains(&y)
        };
        let Some(tile) = self.tiles.values().find(holds) else { return 0 };
        let at =
            |place: u32, corner: u32| (place - corner).is_multiple_of(tile.step).then(|| (place - corner) / tile.step);
        let point = at(x, tile.rect.x).zip(at(y, tile.rect.y)).map(|(column, row)| row * tile.columns() + column);
        point.and_then(|point| tile.samples.get(point as usize)).copied().unwrap_or(0)
    }

    /// The values that one of the views of a render shows; `None` for another view.
    pub fn values(&self, view: View) -> Option<Film> {
        if !matches!(view, View::Samples | View::Error | View::NonFinite) {
            return None;
        }
        let nothing = if view == View::Error { -1.0 } else { 0.0 };
        let mut pixels = vec![[nothing; 3]; self.width as usize * self.height as usize];
        for tile in self.tiles.values() {
            let mut put = |index: usize, value: f32| {
                let (x, y) = tile.place(index);
                pixels[y as usize * self.width as usize + x as usize] = [value; 3];
            };
            match view {
                View::Samples => tile.samples.iter().enumerate().for_each(|(i, n)| put(i, *n as f32)),
                View::Error => tile.errors.iter().enumerate().for_each(|(i, error)| put(i, *error)),
                _ => tile.non_finite.iter().enumerate().for_each(|(i, n)| put(i, *n as f32)),
            }
        }
        Some(Film::of_pixels(self.width, self.height, pixels))
    }
}
