//! Rectangles of pixels.

/// A rectangle of pixels of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rect {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// Pixels in it.
    pub fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Divides a film into tiles of this side (smaller ones at the right and lower edges), the middle first, then
    /// outward.
    pub fn spiral(width: u32, height: u32, side: u32) -> Vec<Rect> {
        let mut tiles: Vec<Rect> = (0..height.div_ceil(side))
            .flat_map(|row| (0..width.div_ceil(side)).map(move |column| (column * side, row * side)))
            .map(|(x, y)| Rect { x, y, width: side.min(width - x), height: side.min(height - y) })
            .collect();
        let from_middle = |r: &Rect| {
            let off =
                |start: u32, size: u32, whole: u32| (2 * i64::from(start) + i64::from(size) - i64::from(whole)).pow(2);
            off(r.x, r.width, width) + off(r.y, r.height, height)
        };
        tiles.sort_by_key(from_middle);
        tiles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tiles_of_any_film_cover_every_pixel_once_and_start_in_the_middle() {
        for (width, height) in [(1, 1), (1, 50), (33, 65), (640, 360)] {
            let mut seen = vec![0; (width * height) as usize];
            let tiles = Rect::spiral(width, height, 16);
            for r in &tiles {
                for y in r.y..r.y + r.height {
                    for x in r.x..r.x + r.width {
                        seen[(y * width + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{width}x{height}");
            let first = tiles[0];
            assert!(first.x <= width / 2 && width / 2 <= first.x + first.width + 8);
        }
    }
}
