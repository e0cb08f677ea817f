//! S11 and S12: total reflection, media that almost match, and where the light goes.

use super::oracle::{Dd, DdVec3};
use super::scenes::{clear, empty, object, orthographic, pictures, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally, each_preset};
use super::vectors::{orthogonal, unit};
use crate::description::{Background, MaterialDesc, ShapeDesc};
use crate::geometry::Kernels;
use crate::math::{Rgb, SplitMix64};
use glam::DVec3;

/// Snell's law: the direction behind a surface, `None` for total reflection.
fn exact(direction: DVec3, normal: DVec3, eta: f64) -> Option<DdVec3> {
    let (d, n) = (DdVec3::from(direction), DdVec3::from(normal));
    let (d, n) = (scaled(d, Dd::ONE / d.length()), scaled(n, Dd::ONE / n.length()));
    let tangential = scaled(d.plus(n, -d.dot(n)), Dd::from(eta));
    let cos2 = Dd::ONE - tangential.dot(tangential);
    (cos2 >= Dd::ZERO).then(|| tangential.plus(n, -cos2.sqrt()))
}

fn scaled(v: DdVec3, k: Dd) -> DdVec3 {
    DdVec3([Dd::ZERO; 3]).plus(v, k)
}

/// Counts wrong decisions and NaN, and measures angles in radians.
fn judge(direction: DVec3, normal: DVec3, eta: f64, [wrong, angle]: &mut [Tally; 2]) {
    let right = exact(direction, normal, eta);
    // The coursework inverts nothing on the way out: what leaves the denser side is its hard case.
    let bent = each_preset!(K => K::refract(direction, normal, eta, eta < 1.0));
    wrong.judge(bent.map(|bent| bent.is_some() != right.is_some() || bent.is_some_and(|b| !b.is_finite())));
    if let Some(right) = right {
        angle.trials += 1;
        angle.measure(bent.map(|bent| match bent {
            Some(bent) if bent.is_finite() => DdVec3::from(bent).cross(right).length().to_f64(),
            _ => 0.0,
        }));
    }
}

/// S11
pub fn refraction(effort: &Effort) -> Vec<Sweep> {
    let sweep = |seed: u64, axis: &str, sample: fn(&mut SplitMix64, f64) -> (DVec3, DVec3, f64)| {
        let (mut wrong, mut off) = (Vec::new(), Vec::new());
        for exponent in 1..=9 {
            let difficulty = 10f64.powi(exponent);
            let count = effort.choose(10_000, 1_000_000);
            let [decisions, angles] = effort.run(seed + exponent as u64, count, |rng, tallies| {
                let (direction, normal, eta) = sample(rng, difficulty);
                judge(direction, normal, eta, tallies);
            });
            wrong.push(Row::rates(difficulty, &decisions, 0.0));
            off.push(Row::worst(difficulty, &angles, 1e-9));
        }
        [Sweep::new("wrong decision or NaN", axis, wrong), Sweep::new("largest angle off, radians", axis, off)]
    };
    let mut sweeps = Vec::new();
    sweeps.extend(sweep(1100, "1 / angle from the critical one", |rng, closeness| {
        let eta = rng.range(1.2, 2.5);
        let side = if rng.unit() < 0.5 { 1.0 } else { -1.0 };
        let angle = (1.0 / eta).asin() + side * rng.range(0.5, 1.5) / closeness;
        let (direction, normal) = at_angle(rng, angle);
        (direction, normal, eta)
    }));
    sweeps.extend(sweep(1120, "1 / difference of the indices", |rng, closeness| {
        let side = if rng.unit() < 0.5 { 1.0 } else { -1.0 };
        let eta = 1.0 + side * rng.range(0.5, 1.5) / closeness;
        // Up to a slant of 85 degrees, which no pair of these turns back but the first.
        let angle = rng.range(0.0, 85f64.to_radians());
        let (direction, normal) = at_angle(rng, angle);
        (direction, normal, eta)
    }));
    sweeps
}

/// A direction at this angle to a normal, and the normal.
fn at_angle(rng: &mut SplitMix64, angle: f64) -> (DVec3, DVec3) {
    let normal = unit(rng);
    let (sin, cos) = angle.sin_cos();
    ((orthogonal(normal, rng) * sin - normal * cos).normalize(), normal)
}

/// S12: a ball of glass in a white furnace shows 1 everywhere, less what was not followed.
pub fn energy(effort: &Effort) -> Vec<Sweep> {
    let (mut unspent, mut missing, mut most) = (Vec::new(), Vec::new(), Vec::new());
    let side = effort.choose(48, 256);
    for depth in [1, 2, 4, 8, 16, 32, 64] {
        let mut desc = empty(side, side, orthographic(v(0.3, 0.4, 5.0), DVec3::ZERO, 2.1));
        desc.world.background = Background::Solid(Rgb::WHITE);
        desc.materials = vec![MaterialDesc { fresnel: true, ..clear("glass", 1.5) }];
        desc.objects = vec![object(ShapeDesc::Sphere { radius: 1.0 }, "glass")];
        desc.render.max_depth = depth;
        let pictures = pictures(effort, &desc);
        let (mut tally, mut mean) = (Tally::default(), [0.0; 4]);
        for pixel in 0..pictures[0].len() {
            let samples = [0, 1, 2, 3].map(|preset| pictures[preset][pixel]);
            // NaN is beyond every bound.
            let lost = samples.map(|s| (1.0 - s.radiance.g).abs());
            tally.judge([0, 1, 2, 3].map(|k| lost[k].is_nan() || lost[k] > samples[k].cut + 1e-12));
            tally.measure(lost);
            for k in 0..4 {
                mean[k] += if lost[k].is_nan() { 1.0 } else { lost[k] } / pictures[0].len() as f64;
            }
        }
        unspent.push(Row::rates(depth.into(), &tally, 0.0));
        let threshold = (depth >= 8).then_some(1.0 / 512.0);
        missing.push(Row { difficulty: depth.into(), trials: tally.trials, values: mean, threshold });
        most.push(Row::worst(depth.into(), &tally, caught(depth) + f64::from(depth) * NEGLIGIBLE));
    }
    vec![
        Sweep::new("pixels off by more than the weight cut", "depth", unspent),
        Sweep::new("mean light missing", "depth", missing),
        Sweep::new("most light missing in a pixel", "depth", most).noted(
            "numerics.md asks for 1/512 in every pixel from depth 8 on. A ray that enters with reflectance F is reflected \
             inside with the same F each time, so (1 - F) F^(d-1) of its light is still inside after d steps: up to 1 / (e d), \
             which is above 1/512 at every depth up to 188, in exact arithmetic too. What is asked of a pixel is the largest of \
             that, which is (1 - 1/d)^(d-1) / d, plus the weights too small to follow; 1/512 is asked of the mean",
        ),
    ]
}

/// The most light that is still inside of a ball after so many steps: the largest (1 - F) F^(d-1).
fn caught(depth: u32) -> f64 {
    let d = f64::from(depth);
    (1.0 - 1.0 / d).powf(d - 1.0) / d
}

/// A path that weighs less than this is not followed; at most one is dropped a step.
const NEGLIGIBLE: f64 = 1.0 / 1_048_576.0;
