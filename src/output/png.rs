//! The film as a PNG file.

use super::atomic::write_whole;
use crate::render::Film;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::io;
use std::path::Path;

/// Where the IHDR chunk ends: 8 bytes of signature, 25 of chunk. What else describes the colours follows it.
const AFTER_HEADER: usize = 33;

/// The chunk that says "these codes are sRGB" (perceptual intent), with length, name and CRC; the encoder writes none.
const SRGB_CHUNK: [u8; 13] = [0, 0, 0, 1, b's', b'R', b'G', b'B', 0, 0xae, 0xce, 0x1c, 0xe9];

/// Writes the film as an 8-bit sRGB PNG. The file appears whole or not at all, and replaces one that was there. The
/// directory must exist. Errors name the file and say what to do.
pub fn save_png(film: &Film, file: &Path) -> io::Result<()> {
    write_whole(file, &encode(film)?)
}

/// The bytes of the PNG file.
fn encode(film: &Film) -> io::Result<Vec<u8>> {
    encode_png(film.width(), film.height(), &film.to_srgb8())
}

/// The bytes of a PNG file with these sRGB codes, three a pixel, row by row.
pub fn encode_png(width: u32, height: u32, codes: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(codes, width, height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    bytes.splice(AFTER_HEADER..AFTER_HEADER, SRGB_CHUNK);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{SplitMix64, linear_to_srgb8};
    use crate::render::{Rect, TileImage};

    fn noise(width: u32, height: u32) -> Film {
        let mut random = SplitMix64(7);
        let pixels =
            (0..width * height).map(|_| [(); 3].map(|()| random.range(-0.1, 1.2) as f32)).collect::<Vec<[f32; 3]>>();
        let mut film = Film::new(width, height);
        film.write(&TileImage { rect: Rect { x: 0, y: 0, width, height }, pixels, ..TileImage::default() });
        film
    }

    #[test]
    fn what_is_read_back_is_the_films_srgb_codes_for_any_size() {
        for (width, height) in [(1, 1), (1, 7), (7, 1), (33, 20), (256, 3)] {
            let film = noise(width, height);
            let read = image::load_from_memory(&encode(&film).unwrap()).unwrap().into_rgb8();
            assert_eq!(read.dimensions(), (width, height));
            for (x, y, pixel) in read.enumerate_pixels() {
                assert_eq!(pixel.0, film.pixel(x, y).map(|c| linear_to_srgb8(f64::from(c))), "at {x} {y}");
            }
        }
    }

    #[test]
    fn the_file_says_that_it_is_srgb() {
        let bytes = encode(&noise(4, 4)).unwrap();
        assert_eq!(&bytes[12..16], b"IHDR");
        assert_eq!(&bytes[AFTER_HEADER + 4..AFTER_HEADER + 8], b"sRGB");
        // The checksum of the chunk's name and data, by the polynomial of the PNG specification.
        let crc = bytes[AFTER_HEADER + 4..AFTER_HEADER + 9].iter().fold(!0u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
        });
        assert_eq!(bytes[AFTER_HEADER + 9..AFTER_HEADER + 13], (!crc).to_be_bytes());
    }
}
