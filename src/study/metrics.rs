//! How far two pictures are apart.

use super::flip::mean_flip;
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
    /// Mean LDR-FLIP (see `flip`): 0 looks equal, 1 is as different as colours can be.
    pub flip: f64,
}

fn finite<S: serde::Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { to.serialize_f64(*value) } else { to.serialize_none() }
}

/// `None` if the sizes differ.
pub fn difference(a: &Film, b: &Film) -> Option<Difference> {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return None;
    }
    let (mut linear, mut max) = (0.0, 0.0f64);
    for (a, b) in a.pixels().iter().flatten().zip(b.pixels().iter().flatten()) {
        let (a, b) = (f64::from(*a), f64::from(*b));
        linear += (a - b) * (a - b);
        max = max.max((code(a) - code(b)).abs());
    }
    let rmse = rmse(a, b)?;
    let rmse_linear = (linear / (3.0 * a.pixels().len() as f64)).sqrt();
    Some(Difference { rmse, rmse_linear, psnr: psnr(rmse), max, flip: mean_flip(a, b) })
}

/// Root mean square of the differences in 8-bit codes; `None` if the sizes differ.
pub fn rmse(a: &Film, b: &Film) -> Option<f64> {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return None;
    }
    let squares = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let sum: f64 = squares.map(|(a, b)| (code(f64::from(*a)) - code(f64::from(*b))).powi(2)).sum();
    Some((sum / (3.0 * a.pixels().len() as f64)).sqrt())
}

/// Peak signal to noise ratio of a root mean square in codes, decibels.
fn psnr(rmse: f64) -> f64 {
    20.0 * (255.0 / rmse).log10()
}

/// Where the films, of one size, differ, as sRGB codes: black where less than half a code apart, then by the logarithm
/// of the largest difference of a channel through purple, red and orange to pale yellow at 255.
pub fn error_map(a: &Film, b: &Film) -> Vec<u8> {
    /// Ends of equal steps of the colour map "inferno" (van der Walt and Smith 2015): equal steps look equal.
    const COLORS: [[f64; 3]; 6] = [
        [0.0, 0.0, 4.0],
        [66.0, 10.0, 104.0],
        [147.0, 38.0, 103.0],
        [221.0, 81.0, 58.0],
        [252.0, 165.0, 10.0],
        [252.0, 255.0, 164.0],
    ];
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| {
        let apart = |i: usize| (code(f64::from(a[i])) - code(f64::from(b[i]))).abs();
        let apart = apart(0).max(apart(1)).max(apart(2));
        let place = (apart / 0.5).ln() / (255.0f64 / 0.5).ln() * (COLORS.len() - 1) as f64;
        let step = (place.max(0.0) as usize).min(COLORS.len() - 2);
        let part = (place - step as f64).clamp(0.0, 1.0);
        [0, 1, 2].map(|i| (COLORS[step][i] + (COLORS[step + 1][i] - COLORS[step][i]) * part).round() as u8)
    };
    a.pixels().iter().zip(b.pixels()).flat_map(pixel).collect()
}

/// The 8-bit code of a linear value before it is rounded.
fn code(linear: f64) -> f64 {
    255.0 * linear_to_srgb(linear)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::srgb8_to_linear;

    pub(in crate::study) fn film(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 3]) -> Film {
        let pixel = |i| color(i % width, i / width).map(|code| srgb8_to_linear(code) as f32);
        Film::of_pixels(width, height, (0..width * height).map(pixel).collect())
    }

    #[test]
    fn equal_pictures_do_not_differ_and_other_sizes_are_not_compared() {
        let picture = film(7, 5, |x, y| [x as u8 * 30, y as u8 * 50, 77]);
        let same = difference(&picture, &picture).unwrap();
        assert_eq!((same.rmse, same.rmse_linear, same.max), (0.0, 0.0, 0.0));
        assert_eq!(same.psnr, f64::INFINITY);
        assert_eq!(difference(&picture, &film(5, 7, |_, _| [0; 3])), None);
        assert!(error_map(&picture, &picture).chunks(3).all(|codes| codes == [0, 0, 4]));
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
        let map = error_map(&a, &b);
        assert_eq!(map.chunks(3).filter(|codes| *codes != [0, 0, 4]).count(), 1);
        assert_eq!(map[3 * (4 * 8 + 3)..][..3], [252, 255, 164]);
    }
}
