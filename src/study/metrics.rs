//! How far two pictures are apart.

use crate::math::linear_to_srgb;
use crate::render::Film;
use serde::Serialize;

/// Differences of two pictures of one size, over all pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Root mean square, in 8-bit sRGB codes: of encoded values times 255, clamped to 0..=255 and not rounded.
    pub rmse: f64,
    /// Root mean square of linear values, not clamped.
    pub rmse_linear: f64,
    /// Peak signal to noise ratio of the codes, decibels; `null` (infinite) for equal pictures.
    #[serde(serialize_with = "finite")]
    pub psnr: f64,
    /// The largest difference of a channel, in codes.
    pub max: f64,
}

fn finite<S: serde::Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { to.serialize_f64(*value) } else { to.serialize_none() }
}

/// `None` if the sizes differ.
pub fn difference(a: &Film, b: &Film) -> Option<Difference> {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return None;
    }
    let (mut codes, mut linear, mut max) = (0.0, 0.0, 0.0f64);
    for (a, b) in a.pixels().iter().flatten().zip(b.pixels().iter().flatten()) {
        let (a, b) = (f64::from(*a), f64::from(*b));
        let apart = (code(a) - code(b)).abs();
        codes += apart * apart;
        linear += (a - b) * (a - b);
        max = max.max(apart);
    }
    let count = 3.0 * a.pixels().len() as f64;
    let rmse = (codes / count).sqrt();
    Some(Difference { rmse, rmse_linear: (linear / count).sqrt(), psnr: 20.0 * (255.0 / rmse).log10(), max })
}

/// The 8-bit code of a linear value before it is rounded.
fn code(linear: f64) -> f64 {
    255.0 * linear_to_srgb(linear.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::srgb8_to_linear;
    use crate::render::{Rect, TileImage};

    pub(in crate::study) fn film(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 3]) -> Film {
        let mut film = Film::new(width, height);
        let pixels =
            (0..width * height).map(|i| color(i % width, i / width).map(|code| srgb8_to_linear(code) as f32)).collect();
        film.write(&TileImage { rect: Rect { x: 0, y: 0, width, height }, pixels });
        film
    }

    #[test]
    fn equal_pictures_do_not_differ_and_other_sizes_are_not_compared() {
        let picture = film(7, 5, |x, y| [x as u8 * 30, y as u8 * 50, 77]);
        let same = difference(&picture, &picture).unwrap();
        assert_eq!((same.rmse, same.rmse_linear, same.max), (0.0, 0.0, 0.0));
        assert_eq!(same.psnr, f64::INFINITY);
        assert_eq!(difference(&picture, &film(5, 7, |_, _| [0; 3])), None);
    }

    #[test]
    fn known_differences() {
        // Ten codes more in every channel, at any level.
        let (a, b) = (film(8, 8, |x, _| [x as u8 * 20; 3]), film(8, 8, |x, _| [x as u8 * 20 + 10; 3]));
        let d = difference(&a, &b).unwrap();
        assert!((d.rmse - 10.0).abs() < 1e-4 && (d.max - 10.0).abs() < 1e-4, "{d:?}");
        assert!((d.psnr - 20.0 * 25.5f64.log10()).abs() < 1e-4, "{d:?}");
        // One channel of one of 64 pixels from black to white: 255 / sqrt(192) codes, 1 / sqrt(192) linear.
        let (a, b) = (film(8, 8, |_, _| [0; 3]), film(8, 8, |x, y| [0, if (x, y) == (3, 4) { 255 } else { 0 }, 0]));
        let d = difference(&a, &b).unwrap();
        assert!((d.rmse - 255.0 / 192f64.sqrt()).abs() < 1e-9 && (d.rmse_linear - 1.0 / 192f64.sqrt()).abs() < 1e-9);
        assert!((d.max - 255.0).abs() < 1e-9);
    }
}
