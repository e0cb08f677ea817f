//! S19 to S21: sums, codes and texture coordinates. All presets share this code.

use super::oracle::Dd;
use super::scenes::{at, bare, checker, compile, empty, object, orthographic, picture, sphere, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use crate::description::*;
use crate::geometry::{cone_uv, cylinder_uv, sphere_uv};
use crate::math::{Rgb, SplitMix64, linear_to_srgb8, srgb_to_linear, srgb8_to_linear};
use crate::output::save_png;
use crate::render::{self, Film, Rect, RenderEvent, Settings, TileImage};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// S19: sums of samples as tiles keep them, and a picture of one even colour, whose mean is that colour.
pub fn accumulation(effort: &Effort) -> Vec<Sweep> {
    let sums = (2..=effort.choose(6, 8)).map(|exponent| {
        let count = 10u64.pow(exponent);
        let mut rng = SplitMix64(1900 + u64::from(exponent));
        let (mut sum, mut exact) = (Rgb::BLACK, Dd::ZERO);
        for _ in 0..count {
            // Samples between dark and bright.
            let value = rng.unit() * 2.0;
            sum += Rgb::grey(value);
            exact = exact + Dd::from(value);
        }
        let error = ((Dd::from(sum.g) - exact) / exact).abs().to_f64();
        Row { difficulty: count as f64, trials: count, values: [error; 4], threshold: Some(1e-12) }
    });
    let pictures = (2..=effort.choose(5, 7)).map(|exponent| {
        let colors = Rgb::new(0.1, 0.7, 1.3);
        let mut desc = empty(1, 1, CameraDesc::default());
        desc.world.background = Background::Solid(colors);
        desc.render.samples = 10u32.pow(exponent);
        let handle = render::start(Arc::new(compile(&desc, None)), Settings { threads: effort.threads, tile_size: 8 });
        let mut film = Film::new(1, 1);
        for event in handle.events() {
            if let RenderEvent::TileFinished { tile, .. } = event {
                film.write(&tile);
            }
        }
        let mut tally = Tally::default();
        tally.judge([film.pixel(0, 0) != colors.to_f32(); 4]);
        Row::rates(desc.render.samples.into(), &tally, 0.0)
    });
    vec![
        Sweep::new("relative error of a sum", "samples", sums.collect()),
        Sweep::new("even picture off its colour", "samples a pixel", pictures.collect()),
    ]
}

/// x^(2.4) by a fifth root in double-double arithmetic, x > 0.
fn power_2_4(x: Dd) -> Dd {
    let square = x * x;
    let fourth = |y: Dd| y * y * y * y;
    let mut root = Dd::from(square.to_f64().powf(0.2));
    for _ in 0..3 {
        // Newton's step for y^5 = x².
        root = root - (root * fourth(root) - square) / (Dd::from(5.0) * fourth(root));
    }
    square * root * root / root
}

/// The linear value of an sRGB value.
fn decoded(v: Dd) -> Dd {
    if v <= Dd::from(0.04045) { v / Dd::from(12.92) } else { power_2_4((v + Dd::from(0.055)) / Dd::from(1.055)) }
}

/// S20: every code there and back, and every border between two codes from both sides.
pub fn codes(effort: &Effort) -> Vec<Sweep> {
    let _ = effort;
    let mut whole = Tally::default();
    for code in 0..=255u8 {
        let exact = decoded(Dd::from(f64::from(code)) / Dd::from(255.0)).to_f64();
        let near = |value: f64| (value - exact).abs() <= 4.0 * f64::EPSILON * exact;
        let right = near(srgb8_to_linear(code))
            && near(srgb_to_linear(f64::from(code) / 255.0))
            && linear_to_srgb8(exact) == code
            && linear_to_srgb8(f64::from(exact as f32)) == code;
        whole.judge([!right; 4]);
    }
    let borders = [40, 20, 8, 2].map(|bits| {
        let ulps = 2f64.powi(bits);
        let mut tally = Tally::default();
        for code in 0..255u8 {
            let border = decoded((Dd::from(f64::from(code)) + Dd::from(0.5)) / Dd::from(255.0)).to_f64();
            let step = border * f64::EPSILON * ulps;
            let right = linear_to_srgb8(border - step) == code && linear_to_srgb8(border + step) == code + 1;
            tally.judge([!right; 4]);
        }
        Row::rates(2f64.powi(52) / ulps, &tally, 0.0)
    });
    vec![
        Sweep::new("codes that do not survive", "tables", vec![Row::rates(1.0, &whole, 0.0)]),
        Sweep::new("codes wrong beside a border", "value / distance", borders.to_vec()),
    ]
}

/// Texels round a body.
const TEXELS: f64 = 4096.0;

/// Whether `got` lies in another texel than `right`, which is not at a border.
fn off_texel(got: f64, right: f64) -> bool {
    let place = (right * TEXELS).rem_euclid(TEXELS);
    let at_border = (place - place.round()).abs() < 1e-4;
    !at_border && (got * TEXELS).rem_euclid(TEXELS).floor() != place.floor() || !got.is_finite()
}

/// S21: longitudes next to poles and apices, the seam from both sides, and pictures repeated a million times.
pub fn texture_coordinates(effort: &Effort) -> Vec<Sweep> {
    let poles = (1..=15).map(|exponent| {
        let closeness = 10f64.powi(exponent);
        let [tally] = effort.run(2100 + exponent as u64, effort.choose(2_000, 100_000), |rng, [tally]| {
            let (longitude, side) = (rng.range(-PI, PI), if rng.unit() < 0.5 { -1.0 } else { 1.0 });
            let angle = rng.range(0.5, 1.5) / closeness;
            let p = DVec3::new(angle.sin() * longitude.sin(), side * angle.cos(), angle.sin() * longitude.cos());
            let (u, latitude) = (0.5 + longitude / TAU, 0.5 + side * (0.5 - angle / PI));
            let uv = sphere_uv(p);
            let wrong = off_texel(uv.x, u)
                || off_texel(uv.y, latitude)
                || off_texel(cone_uv(p, 0).x, u)
                || off_texel(cylinder_uv(p, 0).x, u);
            tally.judge([wrong; 4]);
        });
        Row::rates(closeness, &tally, 0.0)
    });
    let mut exactly = Tally::default();
    for x in [0.0, -0.0] {
        for z in [0.0, -0.0, 1.0, -1.0] {
            for y in [1.0, -1.0, 0.5] {
                let p = DVec3::new(x, y, z);
                let uvs = [sphere_uv(p), cone_uv(p, 0), cylinder_uv(p, 0)];
                // On the seam both ends of the picture are right.
                let right = |uv: DVec2| uv.is_finite() && [0.0, 0.5, 1.0].contains(&uv.x);
                exactly.judge([!uvs.into_iter().all(right); 4]);
            }
        }
    }
    vec![
        Sweep::new("off-texel near a pole", "1 / angle from the pole", poles.collect()),
        Sweep::new("off-texel at poles and seams", "places", vec![Row::rates(1.0, &exactly, 0.0)]),
        seam(effort),
        repeated(effort),
    ]
}

/// A checkered ball, looked at from where the seam is in the middle, closer and closer.
fn seam(effort: &Effort) -> Sweep {
    let rows = (0..=7).map(|exponent| {
        let closeness = 10f64.powi(exponent);
        let side = effort.choose(32, 200);
        let height = 2.2 / closeness;
        let mut desc = empty(side, side, orthographic(v(0.0, 0.0, -5.0), DVec3::ZERO, height));
        let squares = checker([Rgb::WHITE, Rgb::BLACK], 0.125 / closeness);
        desc.materials = vec![MaterialDesc { ambient: 1.0, texture: squares, ..bare("squares", Rgb::WHITE) }];
        desc.objects = vec![sphere(DVec3::ZERO, 1.0, "squares")];
        let mut tally = Tally::default();
        for (pixel, sample) in picture(effort, &compile(&desc, None)).iter().enumerate() {
            let place = |i: usize| ((i as f64 + 0.5) / f64::from(side) - 0.5) * height;
            // Seen from -z, x runs to the left.
            let (x, y) = (-place(pixel % side as usize), -place(pixel / side as usize));
            let z2 = 1.0 - x * x - y * y;
            let size = 0.125 / closeness;
            let (s, t) = ((0.5 + x.atan2(-z2.sqrt()) / TAU) / size, (0.5 + y.asin() / PI) / size);
            let near_border = |a: f64| (a - a.round()).abs() < 1e-6;
            if z2 < 1e-6 || near_border(s) || near_border(t) {
                continue;
            }
            let white = (s.floor() + t.floor()).rem_euclid(2.0) == 0.0;
            tally.judge([(sample.radiance.g > 0.5) != white; 4]);
        }
        Row::rates(closeness, &tally, 0.0)
    });
    Sweep::new("wrong square beside the seam", "size / width of the view", rows.collect())
}

/// A picture on a quad, moved by whole periods.
fn repeated(effort: &Effort) -> Sweep {
    let mut rng = SplitMix64(21);
    let mut film = Film::new(7, 5);
    let pixels = (0..35).map(|_| [0; 3].map(|_| rng.unit() as f32)).collect();
    film.write(&TileImage {
        rect: Rect { x: 0, y: 0, width: 7, height: 5 },
        pixels,
        samples: vec![1; 35],
        ..TileImage::default()
    });
    let file = std::env::temp_dir().join(format!("glimt-stability-{}.png", std::process::id()));
    save_png(&film, &file).unwrap_or_else(|error| panic!("cannot write {}: {error}", file.display()));
    let rows = (0..=6).map(|exponent| {
        let periods = 10f64.powi(exponent);
        let mut tally = Tally::default();
        for wrap in [Wrap::Repeat, Wrap::Mirror] {
            let show = |offset: f64| {
                let side = effort.choose(32, 200);
                let mut desc = empty(side, side, orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, 2.0));
                desc.camera.up = DVec3::NEG_Z;
                let texture = TextureDesc {
                    source: TextureSource::Image { file: file.clone(), wrap },
                    scale: DVec2::splat(1.0),
                    offset: DVec2::new(offset, -offset),
                };
                desc.materials =
                    vec![MaterialDesc { ambient: 1.0, texture: Some(texture), ..bare("picture", Rgb::WHITE) }];
                desc.objects = vec![at(DVec3::ZERO, object(ShapeDesc::Quad { size: DVec2::splat(2.0) }, "picture"))];
                picture(effort, &compile(&desc, None))
            };
            // Mirrored pictures repeat after two.
            for (a, b) in show(0.0).iter().zip(&show(2.0 * periods)) {
                tally.judge([(a.radiance.g - b.radiance.g).abs() > 1e-6; 4]);
            }
        }
        Row::rates(periods, &tally, 0.0)
    });
    let sweep = Sweep::new("picture off where it repeats", "periods", rows.collect());
    let _ = std::fs::remove_file(&file);
    sweep
}
