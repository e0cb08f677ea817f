//! LDR-FLIP: how different two pictures look when one is flipped to the other in place.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG; the names and constants are the paper's. Written here, because the authors' code, which the package
//! `nv-flip` wraps, needs a C++ compiler. The filters are separated into rows and columns, which changes nothing but
//! the rounding.

use crate::render::Film;
use std::f64::consts::PI;

/// Pixels per degree of a 0.7 m wide screen of 3,840 pixels, 0.7 m away: the paper's default.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

const Q_C: f64 = 0.7;
const P_C: f64 = 0.4;
const P_T: f64 = 0.95;
const Q_F: f64 = 0.5;
/// Width of the edges and points that are detected, degrees.
const FEATURE: f64 = 0.082;

/// Contrast sensitivity of the achromatic, red-green and blue-yellow channel: pairs of weight and width of Gaussians in
/// the frequency domain.
const SENSITIVITY: [[(f64, f64); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// The mean difference, 0 to 1. The films have one size.
pub(super) fn mean_flip(a: &Film, b: &Film) -> f64 {
    let map = flip(a, b);
    map.iter().sum::<f64>() / map.len() as f64
}

/// The difference of each pixel, 0 (looks the same) to 1.
fn flip(a: &Film, b: &Film) -> Vec<f64> {
    let (of_a, of_b) = (Seen::new(a), Seen::new(b));
    let largest = hyab(hunt(lab([0.0, 1.0, 0.0])), hunt(lab([0.0, 0.0, 1.0]))).powf(Q_C);
    let pixel = |i: usize| {
        let color = redistributed(hyab(of_a.colors[i], of_b.colors[i]).powf(Q_C), largest);
        let edge = (of_a.edges[i] - of_b.edges[i]).abs();
        let point = (of_a.points[i] - of_b.points[i]).abs();
        let feature = (edge.max(point) / 2f64.sqrt()).powf(Q_F);
        color.powf(1.0 - feature)
    };
    (0..of_a.colors.len()).map(pixel).collect()
}

/// Spreads differences of colour over 0..1: most of it for the common small ones.
fn redistributed(difference: f64, largest: f64) -> f64 {
    let bend = P_C * largest;
    if difference < bend { P_T / bend * difference } else { P_T + (difference - bend) / (largest - bend) * (1.0 - P_T) }
}

/// A picture as an eye at that distance takes it in.
struct Seen {
    /// L*a*b*, blurred as far as the eye blurs, a* and b* weaker in the dark.
    colors: Vec<[f64; 3]>,
    /// Strength of edges and of points.
    edges: Vec<f64>,
    points: Vec<f64>,
}

impl Seen {
    fn new(film: &Film) -> Self {
        let (width, height) = (film.width() as usize, film.height() as usize);
        let opponent: Vec<[f64; 3]> =
            film.pixels().iter().map(|p| to_opponent(p.map(|c| f64::from(c).clamp(0.0, 1.0)))).collect();
        let plane = |channel: usize| Plane { width, height, values: opponent.iter().map(|p| p[channel]).collect() };
        let blurred: Vec<Plane> = (0..3).map(|channel| blur(&plane(channel), SENSITIVITY[channel])).collect();
        let colors = (0..width * height)
            .map(|i| {
                let rgb = from_opponent([blurred[0].values[i], blurred[1].values[i], blurred[2].values[i]]);
                hunt(lab(rgb.map(|c| c.clamp(0.0, 1.0))))
            })
            .collect();
        let mut grey = plane(0);
        grey.values.iter_mut().for_each(|y| *y = (*y + 16.0) / 116.0);
        Self { colors, edges: features(&grey, edge_detector), points: features(&grey, point_detector) }
    }
}

/// One channel of a picture.
struct Plane {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

impl Plane {
    /// Convolves rows with one kernel, then columns with another. Beyond its edge the picture goes on as at its edge.
    fn filtered(&self, rows: &[f64], columns: &[f64]) -> Self {
        let (width, height) = (self.width, self.height);
        let at = |i: usize, offset: usize, kernel: &[f64], end: usize| {
            (i + offset).saturating_sub(kernel.len() / 2).min(end - 1)
        };
        let sum = |kernel: &[f64], value: &dyn Fn(usize) -> f64| {
            kernel.iter().enumerate().map(|(offset, weight)| weight * value(offset)).sum::<f64>()
        };
        let mut across = Vec::with_capacity(self.values.len());
        for line in self.values.chunks_exact(width) {
            across.extend((0..width).map(|x| sum(rows, &|offset| line[at(x, offset, rows, width)])));
        }
        let mut values = Vec::with_capacity(self.values.len());
        for y in 0..height {
            values.extend((0..width).map(|x| sum(columns, &|o| across[at(y, o, columns, height) * width + x])));
        }
        Self { width, height, values }
    }
}

/// Convolves with the Fourier transform of the contrast sensitivity.
fn blur(plane: &Plane, gaussians: [(f64, f64); 2]) -> Plane {
    let widest = SENSITIVITY.iter().flatten().map(|g| g.1).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let parts: Vec<(f64, Vec<f64>)> = gaussians
        .iter()
        .filter(|(weight, _)| *weight > 0.0)
        .map(|(weight, width)| {
            let line =
                (-radius..=radius).map(|x| (-(PI * f64::from(x) / PIXELS_PER_DEGREE).powi(2) / width).exp()).collect();
            (weight * (PI / width).sqrt(), line)
        })
        .collect();
    let total: f64 = parts.iter().map(|(weight, line)| weight * line.iter().sum::<f64>().powi(2)).sum();
    let mut sum = Plane { width: plane.width, height: plane.height, values: vec![0.0; plane.values.len()] };
    for (weight, line) in parts {
        let part = plane.filtered(&line, &line);
        sum.values.iter_mut().zip(part.values).for_each(|(sum, value)| *sum += weight / total * value);
    }
    sum
}

/// How strongly a feature stands in each pixel, by the filter across and the one along it.
fn features(grey: &Plane, detector: fn(f64, f64) -> f64) -> Vec<f64> {
    let deviation = 0.5 * FEATURE * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let line = |f: &dyn Fn(f64) -> f64| -> Vec<f64> { (-radius..=radius).map(|x| f(f64::from(x))).collect() };
    let mut along = line(&|x| (-x * x / (2.0 * deviation * deviation)).exp());
    let sum: f64 = along.iter().sum();
    along.iter_mut().for_each(|w| *w /= sum);
    let mut across = line(&|x| detector(x, deviation));
    // The weights above 0 have the sum 1, those below -1.
    let above: f64 = across.iter().filter(|w| **w > 0.0).sum();
    let below: f64 = -across.iter().filter(|w| **w < 0.0).sum::<f64>();
    across.iter_mut().for_each(|w| *w /= if *w > 0.0 { above } else { below });
    let (x, y) = (grey.filtered(&across, &along), grey.filtered(&along, &across));
    x.values.iter().zip(&y.values).map(|(x, y)| x.hypot(*y)).collect()
}

/// The first derivative of a Gaussian.
fn edge_detector(x: f64, deviation: f64) -> f64 {
    -x * (-x * x / (2.0 * deviation * deviation)).exp()
}

/// The second.
fn point_detector(x: f64, deviation: f64) -> f64 {
    let square = x * x / (deviation * deviation);
    (square - 1.0) * (-square / 2.0).exp()
}

/// Linear Rec. 709 to CIE XYZ, rows.
const XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

/// XYZ over that of white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    XYZ.map(|row| {
        let white: f64 = row.iter().sum();
        row.iter().zip(rgb).map(|(weight, c)| weight * c).sum::<f64>() / white
    })
}

/// YyCxCz: L*a*b* without its cube roots, so that light adds up.
fn to_opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([yy, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (yy + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    let absolute = [0, 1, 2].map(|i| xyz[i] * XYZ[i].iter().sum::<f64>());
    // Cramer's rule.
    let column = |i: usize| [XYZ[0][i], XYZ[1][i], XYZ[2][i]];
    let determinant = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let (r, g, b) = (column(0), column(1), column(2));
    let all = determinant(r, g, b);
    [determinant(absolute, g, b) / all, determinant(r, absolute, b) / all, determinant(r, g, absolute) / all]
}

fn lab(rgb: [f64; 3]) -> [f64; 3] {
    const BEND: f64 = 6.0 / 29.0;
    let [x, y, z] =
        relative_xyz(rgb).map(|t: f64| if t > BEND.powi(3) { t.cbrt() } else { t / (3.0 * BEND * BEND) + 4.0 / 29.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Colours are the less strong the darker they are.
fn hunt([l, a, b]: [f64; 3]) -> [f64; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// Distance of colours: lightness by its difference, hue and chroma by Euclid.
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::super::metrics::tests::film;
    use super::*;

    #[test]
    fn pictures_of_one_colour_differ_by_their_colours_alone() {
        let of = |a: [u8; 3], b: [u8; 3]| mean_flip(&film(9, 4, |_, _| a), &film(9, 4, |_, _| b));
        let (green, blue, black, white) = ([0, 255, 0], [0, 0, 255], [0; 3], [255; 3]);
        assert!(of(white, white) < 1e-12);
        // The scale ends at green against blue.
        assert!((of(green, blue) - 1.0).abs() < 1e-9, "{}", of(green, blue));
        // Black against white: 100 of lightness. Green is L*a*b* 87.735, -86.183, 83.180, blue 32.299, 79.191, -107.865
        // (with hunt 0.87735 and 0.32299 of a* and b*), so the largest is 203.2^0.7, and by hand:
        let largest = (87.735f64 - 32.299 + (75.612f64 + 25.578).hypot(72.978 + 34.839)).powf(0.7);
        let expected = 0.95 + 0.05 * (100f64.powf(0.7) - 0.4 * largest) / (0.6 * largest);
        assert!((of(black, white) - expected).abs() < 1e-4, "{} {expected}", of(black, white));
    }

    #[test]
    fn it_is_symmetric_and_grows_with_the_difference_but_not_with_place() {
        let dot = |x0: u32, y0: u32, code: u8| {
            film(48, 40, move |x, y| if (x / 2, y / 2) == (x0, y0) { [code; 3] } else { [90; 3] })
        };
        let plain = film(48, 40, |_, _| [90; 3]);
        let weak = mean_flip(&plain, &dot(11, 9, 110));
        let strong = mean_flip(&plain, &dot(11, 9, 200));
        assert!(0.0 < weak && weak < strong && strong < 1.0);
        assert!((mean_flip(&dot(11, 9, 200), &plain) - strong).abs() < 1e-12);
        // Filters reach nine pixels at most, so these see no edge of the picture.
        assert!((mean_flip(&plain, &dot(12, 10, 200)) - strong).abs() < 1e-12);
    }

    #[test]
    fn an_edge_is_felt_at_the_edge_and_a_fine_checkerboard_looks_grey() {
        let step = film(40, 8, |x, _| [if x < 20 { 40 } else { 210 }; 3]);
        let seen = Seen::new(&step);
        let row = &seen.edges[..40];
        let strongest = (0..40).max_by(|a, b| row[*a].total_cmp(&row[*b])).unwrap();
        assert!([19, 20].contains(&strongest), "{row:?}");
        assert!(row[5] < 1e-9 && row[34] < 1e-9);
        // 188 is the code of half the light of white.
        let colors = |film: &Film| Seen::new(film).colors[20 * 40 + 20];
        let checker = film(40, 40, |x, y| [255 * ((x + y) % 2) as u8; 3]);
        let grey = film(40, 40, |_, _| [188; 3]);
        let apart = hyab(colors(&checker), colors(&grey));
        assert!(apart < 3.0, "{apart}");
    }

    #[test]
    fn the_opponent_space_is_left_as_it_was_entered() {
        for rgb in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.7, 0.1]] {
            let back = from_opponent(to_opponent(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{rgb:?} {back:?}");
        }
    }
}
