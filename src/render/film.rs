//! The picture as far as it is known.

use super::TileImage;
use crate::math::linear_to_srgb8;
use xxhash_rust::xxh3::xxh3_64;

/// Linear radiance of every pixel, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Film {
    /// A black film of `width * height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// A film of these pixels, row by row.
    ///
    /// # Panics
    /// If they are not `width * height`.
    pub fn of_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize, "pixels of a film of {width}x{height}");
        Self { width, height, pixels }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The pixel in column `x`, row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Puts a tile in its place, or the points of it that are told.
    pub fn write(&mut self, tile: &TileImage) {
        if tile.points.is_some() {
            for (index, pixel) in tile.pixels.iter().enumerate() {
                let (x, y) = tile.place(index);
                self.pixels[y as usize * self.width as usize + x as usize] = *pixel;
            }
            return;
        }
        let (w, rect, step) = (self.width as usize, tile.rect, tile.step as usize);
        let (width, height) = (rect.width as usize, rect.height as usize);
        for (row, line) in tile.pixels.chunks_exact(tile.columns() as usize).enumerate() {
            let start = (rect.y as usize + row * step) * w + rect.x as usize;
            if step == 1 {
                self.pixels[start..start + width].copy_from_slice(line);
                continue;
            }
            for (pixels, known) in self.pixels[start..start + width].chunks_mut(step).zip(line) {
                pixels.fill(*known);
            }
            for below in 1..step.min(height - row * step) {
                self.pixels.copy_within(start..start + width, start + below * w);
            }
        }
    }

    /// 8-bit sRGB codes, three a pixel: what the PNG holds.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|p| p.map(|c| linear_to_srgb8(f64::from(c)))).collect()
    }

    /// A hash (XXH3, 64 bits) of size and linear pixels: equal for bit-identical pictures.
    pub fn hash(&self) -> u64 {
        let mut bytes = Vec::with_capacity(8 + self.pixels.len() * 12);
        bytes.extend(self.width.to_le_bytes());
        bytes.extend(self.height.to_le_bytes());
        for c in self.pixels.iter().flatten() {
            bytes.extend(c.to_bits().to_le_bytes());
        }
        xxh3_64(&bytes)
    }
}
