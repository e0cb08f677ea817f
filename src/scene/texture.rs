//! Colours from texture coordinates.

use crate::assets::Image;
use crate::description::Wrap;
use crate::math::{Rgb, floor, srgb8_table};
use glam::DVec2;
use std::sync::Arc;

/// A colour for every uv.
#[derive(Clone, Debug)]
pub struct Texture {
    /// What is looked up.
    pub source: Source,
    /// Factor on uv.
    pub scale: DVec2,
    /// Added after scaling.
    pub offset: DVec2,
}

/// What a texture is made of.
#[derive(Clone, Debug)]
pub enum Source {
    /// A picture.
    Image(Arc<Image>, Wrap),
    /// Squares of side `size`, the first colour at the origin.
    Checker {
        /// The two colours.
        colors: [Rgb; 2],
        /// Side of a square in uv.
        size: f64,
    },
}

impl Texture {
    /// No channel of any colour is above that of this one.
    pub fn brightest(&self) -> Rgb {
        match &self.source {
            // Codes of 8 bits.
            Source::Image(..) => Rgb::WHITE,
            Source::Checker { colors: [a, b], .. } => Rgb::new(a.r.max(b.r), a.g.max(b.g), a.b.max(b.b)),
        }
    }

    /// The colour at `uv`.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        let uv = uv * self.scale + self.offset;
        match &self.source {
            Source::Image(image, wrap) => bilinear(image, *wrap, uv),
            Source::Checker { colors, size } => {
                let cell = (uv / *size).map(floor);
                colors[usize::from(modulo_2(cell.x + cell.y) == 1.0)]
            }
        }
    }
}

/// The remainder in 0..2, exact. (`rem_euclid` calls the library's `fmod`.)
fn modulo_2(t: f64) -> f64 {
    t - 2.0 * floor(t / 2.0)
}

/// The four nearest texels, weighted, in linear light. v = 0 is the lower edge of the lowest row.
fn bilinear(image: &Image, wrap: Wrap, uv: DVec2) -> Rgb {
    if !uv.is_finite() {
        return Rgb::BLACK;
    }
    // Texel (i, j) has its centre at (i + 1/2) / width. Wrapping happens per texel, so that no seam is filtered
    // wrongly.
    let place = |t: f64, n: u32| {
        // Whole periods carry no information; without them the arithmetic below is exact enough at any distance.
        let x = if wrap == Wrap::Clamp { t.clamp(-1.0, 2.0) } else { modulo_2(t) } * f64::from(n) - 0.5;
        let whole = floor(x);
        (wrapped(whole as i64, n, wrap), wrapped(whole as i64 + 1, n, wrap), x - whole)
    };
    let (left, right, fx) = place(uv.x, image.width);
    let (upper, lower, fy) = place(1.0 - uv.y, image.height);
    let (width, linear) = (image.width as usize, srgb8_table());
    let (above, below) = (&image.texels[upper * width..][..width], &image.texels[lower * width..][..width]);
    let texel = |row: &[[u8; 3]], column: usize| {
        let [r, g, b] = row[column];
        Rgb::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)])
    };
    texel(above, left).lerp(texel(above, right), fx).lerp(texel(below, left).lerp(texel(below, right), fx), fy)
}

/// Texel index `i` of the first two periods, or one beside them, brought into `0..n`.
fn wrapped(i: i64, n: u32, wrap: Wrap) -> usize {
    let n = i64::from(n);
    debug_assert!(wrap == Wrap::Clamp || (-1..=2 * n).contains(&i));
    // In 0..2n, without a division: four of them a lookup would cost more than the rest of it.
    let m = if i < 0 { i + 2 * n } else { i - if i < 2 * n { 0 } else { 2 * n } };
    let index = match wrap {
        Wrap::Repeat => m - if m < n { 0 } else { n },
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => m.min(2 * n - 1 - m),
    };
    index as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Arc<Image> {
        // Top row: black, white; bottom row: red, blue.
        Arc::new(Image { width: 2, height: 2, texels: vec![[0; 3], [255; 3], [255, 0, 0], [0, 0, 255]] })
    }

    fn at(wrap: Wrap, u: f64, v: f64) -> Rgb {
        Texture { source: Source::Image(picture(), wrap), scale: DVec2::ONE, offset: DVec2::ZERO }
            .lookup(DVec2::new(u, v))
    }

    #[test]
    fn texel_centres_give_texels_and_v_runs_upward() {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            assert_eq!(at(wrap, 0.25, 0.75), Rgb::BLACK);
            assert_eq!(at(wrap, 0.75, 0.75), Rgb::WHITE);
            assert_eq!(at(wrap, 0.25, 0.25), Rgb::new(1.0, 0.0, 0.0));
            assert_eq!(at(wrap, 0.75, 0.25), Rgb::new(0.0, 0.0, 1.0));
        }
        assert_eq!(at(Wrap::Clamp, 0.5, 0.75), Rgb::grey(0.5));
    }

    #[test]
    fn wrapping_continues_the_picture_as_named_at_any_distance() {
        for k in [-1_000_000.0, -3.0, 1.0, 1_000_000.0] {
            assert_eq!(at(Wrap::Repeat, 0.25 + k, 0.75), Rgb::BLACK, "{k}");
            let mirrored = if (k as i64) % 2 == 0 { 0.25 + k } else { 0.75 + k };
            assert_eq!(at(Wrap::Mirror, mirrored, 0.75), Rgb::BLACK, "{k}");
        }
        assert_eq!(at(Wrap::Clamp, -7.0, 0.75), Rgb::BLACK);
        assert_eq!(at(Wrap::Clamp, 1e9, 0.75), Rgb::WHITE);
        // Repeating filters across the seam, clamping does not.
        assert_eq!(at(Wrap::Repeat, 0.0, 0.75), Rgb::grey(0.5));
        assert_eq!(at(Wrap::Clamp, 0.0, 0.75), Rgb::BLACK);
        assert_eq!(at(Wrap::Repeat, f64::NAN, 0.0), Rgb::BLACK);
    }

    #[test]
    fn checkers_alternate_also_below_zero() {
        let t = Texture {
            source: Source::Checker { colors: [Rgb::WHITE, Rgb::BLACK], size: 0.5 },
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
        };
        let at = |u, v| t.lookup(DVec2::new(u, v));
        assert_eq!(at(0.1, 0.1), Rgb::WHITE);
        assert_eq!(at(0.6, 0.1), Rgb::BLACK);
        assert_eq!(at(-0.1, 0.1), Rgb::BLACK);
        assert_eq!(at(-0.1, -0.1), Rgb::WHITE);
    }
}
