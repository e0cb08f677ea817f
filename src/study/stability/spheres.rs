//! S1 to S3: balls far away, just grazed, and as floors.

use super::oracle::Dd;
use super::solids;
use super::sweep::{Row, Sweep};
use super::trials::{Effort, each_preset};
use super::vectors::{orthogonal, unit, within};
use crate::geometry::{Kernels, Ray};
use crate::math::SplitMix64;
use glam::DVec3;

/// Distance of `t` from the exact one in units of its last place, or of that of the radius, 1, where t is less: closer
/// to the ball than that t says less than the origin does.
fn ulps(t: f64, exact: Dd) -> f64 {
    let size = exact.to_f64().abs().max(1.0);
    (Dd::from(t) - exact).abs().to_f64() / (size.next_up() - size)
}

/// A ray from `distance` radii of a unit ball (about `centre`) that passes its middle at `impact` radii.
fn past(rng: &mut SplitMix64, centre: DVec3, distance: f64, impact: f64) -> Ray {
    let toward = unit(rng);
    let foot = centre + orthogonal(toward, rng) * impact;
    Ray::new(foot - toward * distance, toward)
}

/// The first hit of every preset and the exact one.
fn hits(ray: &Ray, centre: DVec3) -> ([Option<f64>; 4], Option<Dd>) {
    let exact = solids::sphere(ray, centre, 1.0).and_then(|chord| chord.first());
    (each_preset!(K => K::sphere(ray, centre, 1.0)), exact)
}

/// S1: impact parameters uniform up to 1.1 radii.
pub fn far(effort: &Effort) -> Vec<Sweep> {
    let (mut wrong, mut off, mut worst) = (Vec::new(), Vec::new(), Vec::new());
    for exponent in 0..=7 {
        let ratio = 10f64.powi(exponent);
        let count = effort.choose(10_000, 1_000_000);
        let [misjudged, t_error] = effort.run(100 + exponent as u64, count, |rng, [misjudged, t_error]| {
            let centre = within(rng, 2.0);
            let impact = 1.1 * rng.unit();
            // From the ball's surface on, at least.
            let ray = past(rng, centre, ratio.max(1.2), impact);
            let (hits, exact) = hits(&ray, centre);
            misjudged.judge(hits.map(|hit| hit.is_some() != exact.is_some()));
            if let Some(exact) = exact {
                let errors = hits.map(|hit| hit.map_or(0.0, |t| ulps(t, exact)));
                t_error.judge(errors.map(|error| error > 8.0));
                t_error.measure(errors);
            }
        });
        wrong.push(Row::rates(ratio, &misjudged, 0.0));
        off.push(Row::rates(ratio, &t_error, 1e-3));
        worst.push(Row::worst(ratio, &t_error, 2000.0));
    }
    let axis = "distance / radius";
    vec![
        Sweep::new("wrong hit or miss", axis, wrong),
        Sweep::new("t off by more than 8 ulp", axis, off),
        Sweep::new("largest error of t in ulp", axis, worst),
    ]
}

/// S2: rays that pass the outline at this part of the radius, inside and outside.
pub fn grazing(effort: &Effort) -> Vec<Sweep> {
    let rows = (1..=7).map(|exponent| {
        let gap = 10f64.powi(-exponent);
        let [tally] = effort.run(200 + exponent as u64, effort.choose(10_000, 1_000_000), |rng, [tally]| {
            let centre = within(rng, 2.0);
            let side = if rng.next_u64().is_multiple_of(2) { 1.0 } else { -1.0 };
            let impact = 1.0 + side * gap * rng.range(0.5, 1.5);
            let ray = past(rng, centre, 10.0, impact);
            let (hits, exact) = hits(&ray, centre);
            tally.judge(hits.map(|hit| hit.is_some() != exact.is_some()));
        });
        Row::rates(1.0 / gap, &tally, 0.0)
    });
    vec![Sweep::new("wrong hit or miss", "radius / distance from the outline", rows.collect())]
}

/// S3: a ball as large as a planet, looked at from a height of 1, straight down to just past its horizon.
pub fn floor(effort: &Effort) -> Vec<Sweep> {
    let (mut worst, mut grazing, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for exponent in 0..=7 {
        let radius = 10f64.powi(exponent);
        // Where the planet curves away; up to there the height is what t is sensitive to.
        let horizon = radius.sqrt().recip().min(0.1);
        let count = effort.choose(10_000, 1_000_000);
        let [above, beyond, missed] = effort.run(300 + exponent as u64, count, |rng, [above, beyond, missed]| {
            let toward = unit(rng);
            let down = if rng.unit() < 0.5 { rng.range(0.1, 1.0) } else { 10f64.powf(rng.range(-4.5, -1.0)) };
            let direction = DVec3::new(toward.x, -down, toward.z).normalize();
            let ray = Ray::new(DVec3::new(rng.range(-0.1, 0.1), rng.range(0.5, 1.0), rng.range(-0.1, 0.1)), direction);
            let centre = DVec3::NEG_Y * radius;
            let hits = each_preset!(K => K::sphere(&ray, centre, radius));
            let exact = solids::sphere(&ray, centre, radius).and_then(|chord| chord.first());
            missed.judge(hits.map(|hit| hit.is_some() != exact.is_some()));
            let Some(exact) = exact else { return };
            let cosine = -((ray.at(exact.to_f64()) - centre) / radius).dot(direction);
            let relative = |t: f64| ((Dd::from(t) - exact) / exact).abs().to_f64();
            let errors = hits.map(|hit| hit.map_or(0.0, relative));
            if cosine >= horizon {
                above.trials += 1;
                above.measure(errors);
            } else {
                // dt / db = 1 / cosine: what any rounding does to a ray that grazes.
                beyond.trials += 1;
                beyond.measure(errors.map(|error| error * (cosine / horizon)));
            }
        });
        let threshold = 1e-15 * (8.0 + 8.0 * radius);
        worst.push(Row::worst(radius, &above, threshold));
        grazing.push(Row::worst(radius, &beyond, threshold));
        wrong.push(Row::rates(radius, &missed, 0.0));
    }
    let axis = "radius / height";
    vec![
        Sweep::new("largest relative error of t", axis, worst).noted(
            "1e-15 (8 + 8 R / h), as numerics.md asks, of all rays up to a cosine of sqrt(h / R), or 0.1 where that is less",
        ),
        Sweep::new("the same where rays graze, times cosine / least cosine", axis, grazing).noted(
            "numerics.md makes no exception for grazing rays, but t of a tangent is a double root: an error of u in the \
             discriminant moves t without bound as the cosine goes to 0, whatever the formula, as long as it is rounded to f64. \
             So the threshold is asked of the error times cosine / least cosine",
        ),
        Sweep::new("wrong hit or miss", axis, wrong),
    ]
}
