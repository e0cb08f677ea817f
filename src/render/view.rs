//! Pictures of something else than light: what they show, in which colours, and what those mean.

use super::Film;
use crate::math::srgb_to_linear;
use crate::shading::Probe;

/// What a picture shows of the scene or of its render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// Light.
    #[default]
    Final,
    /// Shading normals where the rays through the middles of the pixels end.
    Normals,
    /// Distances along those rays.
    Depth,
    /// Texture coordinates there.
    Uv,
    /// Objects there.
    Object,
    /// Materials there.
    Material,
    /// Samples that each pixel has got.
    Samples,
    /// Rays that one sample takes.
    Rays,
    /// Nodes and leaves of the hierarchies that those look at.
    Visits,
    /// Time that one sample takes.
    Time,
    /// Estimated error of each pixel.
    Error,
    /// Samples that were not finite.
    NonFinite,
}

impl View {
    /// Every view with its name.
    pub const NAMES: &[(&str, Self)] = &[
        ("final", Self::Final),
        ("normals", Self::Normals),
        ("depth", Self::Depth),
        ("uv", Self::Uv),
        ("object", Self::Object),
        ("material", Self::Material),
        ("samples", Self::Samples),
        ("rays", Self::Rays),
        ("visits", Self::Visits),
        ("time", Self::Time),
        ("error", Self::Error),
        ("non-finite", Self::NonFinite),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].0
    }

    /// The view `by` places further in the list, which is a ring.
    pub fn moved(self, by: i8) -> Self {
        let at = (self as isize + isize::from(by)).rem_euclid(Self::NAMES.len() as isize);
        Self::NAMES[at as usize].1
    }

    /// What has to be traced for it; `None`: what the render itself tells.
    pub fn probe(self) -> Option<Probe> {
        match self {
            Self::Final | Self::Samples | Self::Error | Self::NonFinite => None,
            Self::Normals => Some(Probe::Normals),
            Self::Depth => Some(Probe::Depth),
            Self::Uv => Some(Probe::Uv),
            Self::Object => Some(Probe::Object),
            Self::Material => Some(Probe::Material),
            Self::Rays => Some(Probe::Rays),
            Self::Visits => Some(Probe::Visits),
            Self::Time => Some(Probe::Time),
        }
    }

    /// What its numbers count, for people; `None` where they are no quantity.
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::Depth => Some("units"),
            Self::Samples => Some("samples"),
            Self::Rays => Some("rays"),
            Self::Visits => Some("visits"),
            Self::Time => Some("µs"),
            Self::Error => Some("of 255"),
            Self::NonFinite => Some("samples"),
            Self::Final | Self::Normals | Self::Uv | Self::Object | Self::Material => None,
        }
    }

    /// Whether nothing is seen or known in a pixel of this value.
    fn is_nothing(self, [a, b, c]: [f32; 3]) -> bool {
        match self {
            Self::Final | Self::Rays | Self::Visits | Self::Time => false,
            Self::Normals | Self::Depth | Self::Object | Self::Material | Self::Samples => [a, b, c] == [0.0; 3],
            Self::Uv => c == 0.0,
            Self::Error => a < 0.0,
            Self::NonFinite => a == 0.0,
        }
    }

    /// The scale on which all values of a picture lie. It ends at round numbers, so that it seldom changes while the
    /// picture grows.
    pub fn scale(self, values: &[[f32; 3]]) -> Scale {
        let seen = values.iter().filter(|value| !self.is_nothing(**value)).map(|value| value[0]);
        let (low, high) = seen.fold((f32::MAX, 0.0f32), |(low, high), v| (low.min(v), high.max(v)));
        let low = low.min(high);
        match self {
            Self::Depth => {
                let step = round_up((high - low).max(high * 1e-3)) / 20.0;
                Scale { low: (low / step).floor() * step, high: (high / step).ceil() * step, is_log: false }
            }
            Self::Samples => Scale { low: 1.0, high: high.max(2.0).log2().ceil().exp2(), is_log: true },
            _ => Scale { low: 0.0, high: round_up(high), is_log: false },
        }
    }

    /// The colour of a value, linear light.
    pub fn color(self, value: [f32; 3], scale: Scale) -> [f32; 3] {
        let linear = |code: f32| srgb_to_linear(f64::from(code)) as f32;
        if self.is_nothing(value) {
            return NOTHING.map(linear);
        }
        let codes = match self {
            Self::Final => return value,
            Self::Normals => value.map(|c| 0.5 + 0.5 * c),
            Self::Uv => [value[0], value[1], 0.0],
            Self::Object | Self::Material => index_color(value[0] as u32),
            _ => viridis(scale.part(value[0])),
        };
        codes.map(linear)
    }

    /// The picture of these values.
    pub fn paint(self, values: &Film) -> (Film, Scale) {
        let scale = self.scale(values.pixels());
        let pixels = values.pixels().iter().map(|value| self.color(*value, scale)).collect();
        (Film::of_pixels(values.width(), values.height(), pixels), scale)
    }
}

/// Which numbers the colours stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// Of the first colour.
    pub low: f32,
    /// Of the last colour.
    pub high: f32,
    /// Whether equal steps of colour are equal factors.
    pub is_log: bool,
}

impl Scale {
    /// Where a value lies, 0 to 1.
    pub fn part(self, value: f32) -> f32 {
        let along = |v: f32| if self.is_log { v.max(1e-30).log2() } else { v };
        let (low, high) = (along(self.low), along(self.high));
        if high > low { ((along(value) - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// sRGB of pixels of which there is nothing to show.
const NOTHING: [f32; 3] = [0.08, 0.08, 0.1];

/// The next of 1, 2, 5, 10 and so on.
fn round_up(x: f32) -> f32 {
    if x <= 0.0 || !x.is_finite() {
        return 1.0;
    }
    let decade = 10f32.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|digit| digit * decade).into_iter().find(|round| *round >= x).unwrap_or(10.0 * decade)
}

/// sRGB of the number `index`, from 1: hues as far apart as can be, in turn light and dark.
pub fn index_color(index: u32) -> [f32; 3] {
    let hue = (f64::from(index) * 0.618_033_988_75).fract() as f32 * 6.0;
    let (value, saturation) = [(0.95, 0.6), (0.65, 0.75), (0.85, 0.4)][index as usize % 3];
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + hue) % 6.0;
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

/// sRGB of the map "viridis" (Smith and van der Walt 2015): even steps to the eye, also to eyes that see few colours.
pub fn viridis(part: f32) -> [f32; 3] {
    const STOPS: [[u8; 3]; 9] = [
        [68, 1, 84],
        [71, 45, 123],
        [59, 82, 139],
        [44, 114, 142],
        [33, 145, 140],
        [40, 174, 128],
        [94, 201, 98],
        [173, 220, 48],
        [253, 231, 37],
    ];
    let at = part.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let first = (at as usize).min(STOPS.len() - 2);
    let between = at - first as f32;
    std::array::from_fn(|c| {
        let [a, b] = [STOPS[first][c], STOPS[first + 1][c]].map(|code| f32::from(code) / 255.0);
        a + (b - a) * between
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_the_views() {
        for (index, (name, view)) in View::NAMES.iter().enumerate() {
            assert_eq!((*view as usize, view.name()), (index, *name));
            assert_eq!(view.moved(1).moved(-1), *view);
        }
        assert_eq!(View::Final.moved(-1), View::NonFinite);
    }

    #[test]
    fn scales_end_at_round_numbers_and_hold_all_values() {
        for k in 1..2000 {
            let x = 1.37f32.powi(k % 80 - 40) * (1.0 + k as f32 / 777.0);
            let high = round_up(x);
            assert!(high >= x && high <= 2.6 * x, "{x}: {high}");
        }
        let depths = [[0.0; 3], [7.31; 3], [3.17; 3]];
        let scale = View::Depth.scale(&depths);
        assert!((scale.low - 3.0).abs() < 1e-5 && (scale.high - 7.5).abs() < 1e-5, "{scale:?}");
        let samples = View::Samples.scale(&[[1.0; 3], [100.0; 3]]);
        assert_eq!((samples.low, samples.high, samples.part(1.0), samples.part(128.0)), (1.0, 128.0, 0.0, 1.0));
        assert!((samples.part(8.0) - 3.0 / 7.0).abs() < 1e-6);
    }

    #[test]
    fn neighbouring_numbers_have_colours_that_differ() {
        for index in 1..200 {
            let [a, b] = [index_color(index), index_color(index + 1)];
            assert!(a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.15), "{index}: {a:?} {b:?}");
            assert!(a.iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}
