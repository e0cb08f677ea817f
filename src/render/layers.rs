//! What a render tells of its pixels besides their colours.

use super::{Film, TileImage, View};
use std::collections::BTreeMap;

/// Replaces some values.
fn put<T: Copy + Default>(values: &mut Vec<T>, points: &[u32], told: &[T]) {
    for (point, value) in points.iter().zip(told) {
        if values.len() <= *point as usize {
            values.resize(*point as usize + 1, T::default());
        }
        values[*point as usize] = *value;
    }
}

/// Samples of each pixel, how wrong it may be, and what was left out: what tiles have told last, as they told it, since
/// it is seldom looked at.
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
        let at = (tile.rect.y, tile.rect.x);
        if let (Some(points), Some(known)) = (&tile.points, self.tiles.get_mut(&at)) {
            put(&mut known.samples, points, &tile.samples);
            put(&mut known.errors, points, &tile.errors);
            put(&mut known.non_finite, points, &tile.non_finite);
            return;
        }
        debug_assert!(tile.points.is_none(), "the first that a tile tells is all of it");
        self.tiles.insert(at, TileImage { pixels: Vec::new(), ..tile });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Rect;

    #[test]
    fn points_that_are_told_alone_replace_those_and_no_others() {
        let rect = Rect { x: 8, y: 8, width: 4, height: 2 };
        let mut layers = Layers::new(12, 10);
        let mut film = Film::new(12, 10);
        let whole = TileImage {
            rect,
            pixels: vec![[0.25; 3]; 8],
            samples: vec![1; 8],
            errors: vec![2.0; 8],
            ..TileImage::default()
        };
        film.write(&whole);
        layers.write(whole);
        let part = TileImage {
            rect,
            points: Some(vec![1, 6]),
            pixels: vec![[0.5; 3], [0.75; 3]],
            samples: vec![4, 16],
            errors: vec![1.0, 0.5],
            non_finite: vec![0, 3],
            ..TileImage::default()
        };
        assert_eq!([part.place(0), part.place(1)], [(9, 8), (10, 9)]);
        film.write(&part);
        layers.write(part);
        let all = (0..120).map(|at| (at % 12, at / 12));
        for (x, y) in all {
            let (red, samples, error, left_out) = match (x, y) {
                (9, 8) => (0.5, 4, 1.0, 0.0),
                (10, 9) => (0.75, 16, 0.5, 3.0),
                (8.., 8..) => (0.25, 1, 2.0, 0.0),
                _ => (0.0, 0, -1.0, 0.0),
            };
            let value = |view| layers.values(view).unwrap().pixel(x, y)[0];
            assert_eq!(film.pixel(x, y)[0], red, "{x}, {y}");
            assert_eq!(layers.samples(x, y), samples, "{x}, {y}");
            assert_eq!((value(View::Error), value(View::NonFinite)), (error, left_out), "{x}, {y}");
        }
    }
}
