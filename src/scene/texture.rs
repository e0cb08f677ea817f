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

    /// The colour at `uv`: for one point here, for many at once in `color`.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        let uv = uv * self.scale + self.offset;
        match &self.source {
            Source::Image(image, wrap) => image.blend(srgb8_table(), &Texels::around(uv, image.size(), *wrap)),
            Source::Checker { colors, size } => colors[usize::from(is_second(uv, *size))],
        }
    }
}

/// Whether a square of a checker is one of the second colour.
#[inline(always)]
pub(super) fn is_second(uv: DVec2, size: f64) -> bool {
    modulo_2(floor(uv.x / size) + floor(uv.y / size)) == 1.0
}

/// The remainder in 0..2, exact. (`rem_euclid` calls the library's `fmod`.)
#[inline(always)]
fn modulo_2(t: f64) -> f64 {
    t - 2.0 * floor(t / 2.0)
}

/// The four texels around a point.
pub(super) struct Texels {
    /// Numbers of the upper left one, the upper right, the lower left and the lower right, row by row from the top.
    pub at: [u32; 4],
    /// Weights of the right ones and of the lower ones; NaN where there is no point.
    pub part: [f64; 2],
}

impl Texels {
    /// Those around `uv` in a picture of `size` texels. v = 0 is the lower edge of the lowest row. All in f64 and
    /// without branches, so that loops over it become vector code.
    #[inline(always)]
    pub fn around(uv: DVec2, size: DVec2, wrap: Wrap) -> Self {
        let ([left, right], of_right) = neighbours(uv.x, size.x, wrap);
        let ([upper, lower], of_lower) = neighbours(1.0 - uv.y, size.y, wrap);
        // Added to 2^52, a whole number stands in the lowest bits.
        let number = |row: f64, column: f64| (row * size.x + column + (1u64 << 52) as f64).to_bits() as u32;
        let at = [number(upper, left), number(upper, right), number(lower, left), number(lower, right)];
        Self { at, part: [of_right, of_lower] }
    }
}

/// The texels whose centres are beside place `t` in a row of `n` and the weight of the second, which is NaN where t is;
/// texels are named even then. Texel i has its centre at (i + 1/2) / n. Wrapping happens per texel, so that no seam is
/// filtered wrongly.
#[inline(always)]
fn neighbours(t: f64, n: f64, wrap: Wrap) -> ([f64; 2], f64) {
    // Whole periods carry no information; without them the arithmetic below is exact enough at any distance.
    let within = match wrap {
        Wrap::Repeat => t - floor(t),
        Wrap::Clamp => t.clamp(-1.0, 2.0),
        Wrap::Mirror => modulo_2(t),
    };
    let x = within * n - 0.5;
    let first = floor(x);
    let second = first + 1.0;
    // From -1 to n here and to 2n when mirrored. No comparison holds for NaN.
    let (least, most) = (|a: f64, b: f64| if a < b { a } else { b }, |a: f64, b: f64| if a > b { a } else { b });
    let clamped = |i: f64| least(most(i, 0.0), n - 1.0);
    let mirrored = |i: f64| most(least(i, 2.0 * n - 1.0 - i), 0.0);
    let texels = match wrap {
        Wrap::Repeat => [if first >= 0.0 { first } else { n - 1.0 }, if second < n { second } else { 0.0 }],
        Wrap::Clamp => [clamped(first), clamped(second)],
        Wrap::Mirror => [mirrored(first), mirrored(second)],
    };
    (texels, x - first)
}

impl Image {
    /// Width and height.
    #[inline(always)]
    pub(super) fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height))
    }

    /// Texels, weighted, in linear light; black where there is no point. `linear`: see [`srgb8_table`].
    #[inline(always)]
    pub(super) fn blend(&self, linear: &[f64; 256], texels: &Texels) -> Rgb {
        let [of_right, of_lower] = texels.part;
        if (of_right + of_lower).is_nan() {
            return Rgb::BLACK;
        }
        // Not `map`, which was a call: half of the time.
        let texel = |k: usize| {
            let [r, g, b] = self.texels[texels.at[k] as usize];
            Rgb::new(linear[usize::from(r)], linear[usize::from(g)], linear[usize::from(b)])
        };
        texel(0).lerp(texel(1), of_right).lerp(texel(2).lerp(texel(3), of_right), of_lower)
    }
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
