//! S8 and S9: closed meshes, slivers and triangles seen edge on.

use super::oracle::Dd;
use super::solids::triangle_plane;
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally, each_preset};
use super::vectors::{orthogonal, unit};
use crate::bvh::{Isa, TriangleHit, Triangles};
use crate::geometry::{Ray, Robust};
use crate::math::SplitMix64;
use glam::{DVec3, Vec3};
use std::num::NonZeroUsize;

/// A closed ball of 20 * 4^level triangles, radius 1, whose neighbours share their corners bit for bit.
pub fn icosphere(level: u32) -> Vec<[Vec3; 3]> {
    let golden = (1.0 + 5f32.sqrt()) / 2.0;
    let corners: Vec<Vec3> = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
        .iter()
        .flat_map(|&(a, b)| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
        .collect();
    // All triples of corners that are neighbours of each other (at distance 2), turned outward.
    let near = |a: Vec3, b: Vec3| (a.distance_squared(b) - 4.0).abs() < 1e-3;
    let mut faces = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1).filter(|&&c| near(a, b) && near(b, c) && near(a, c)) {
                let outward = (b - a).cross(c - a).dot(a) > 0.0;
                faces.push((if outward { [a, b, c] } else { [a, c, b] }).map(Vec3::normalize));
            }
        }
    }
    for _ in 0..level {
        let middle = |a: Vec3, b: Vec3| ((a + b) / 2.0).normalize();
        let split = |[a, b, c]: [Vec3; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    faces
}

fn tree(triangles: &[[Vec3; 3]], isa: Isa, threads: NonZeroUsize) -> Triangles {
    Triangles::build(triangles.len(), |i| triangles[i], isa, threads)
}

/// A closed mesh and what rays are aimed at.
struct Body {
    triangles: Vec<[Vec3; 3]>,
    tree: Triangles,
    centre: DVec3,
    /// Half axes.
    half: DVec3,
}

impl Body {
    fn new(effort: &Effort, centre: DVec3, half: DVec3) -> Self {
        let place = |p: Vec3| (centre + p.as_dvec3() * half).as_vec3();
        let triangles: Vec<_> = icosphere(effort.choose(4, 5)).into_iter().map(|t| t.map(place)).collect();
        let tree = tree(&triangles, Isa::best(), effort.threads);
        Self { triangles, tree, centre, half }
    }

    /// A point that is hard to decide: a corner, on an edge, beside an edge by 1e-5 to 1e-14 of the triangle.
    fn hard_point(&self, rng: &mut SplitMix64) -> DVec3 {
        let index = (rng.next_u64() % self.triangles.len() as u64) as usize;
        let [a, b, _] = self.triangles[index].map(|p| p.as_dvec3());
        match rng.next_u64() % 4 {
            0 => a,
            1 => (a + b) / 2.0,
            2 => a.lerp(b, rng.unit()),
            _ => a.lerp(b, rng.unit()) + unit(rng) * (b - a).length() * 10f64.powf(rng.range(-14.0, -5.0)),
        }
    }

    /// A ray from inside to such a point; not always of unit length.
    fn ray_from_inside(&self, rng: &mut SplitMix64) -> Ray {
        let origin = self.centre + unit(rng) * self.half * (0.9 * rng.unit());
        let way = self.hard_point(rng) - origin;
        Ray::new(origin, if rng.unit() < 0.5 { way } else { way.normalize() })
    }

    /// Counts rays that get out.
    fn leaks(&self, effort: &Effort, seed: u64, count: u64) -> Tally {
        let [tally] = effort.run(seed, count, |rng, [tally]| {
            let ray = self.ray_from_inside(rng);
            tally.judge(each_preset!(K => self.tree.intersect::<K>(&ray).is_none()));
        });
        tally
    }
}

/// S8: leaks of closed meshes through the whole hierarchy, and hits that boxes in f32 lose.
pub fn watertight(effort: &Effort) -> Vec<Sweep> {
    let count = effort.choose(40_000, 6_000_000);
    let by_size = [-10, -6, -3, 0, 3, 8].map(|exponent| {
        let size = 10f64.powi(exponent);
        let body = Body::new(effort, DVec3::ZERO, DVec3::splat(size));
        Row::rates(size, &body.leaks(effort, (850 + exponent) as u64, count), 0.0)
    });
    let by_aspect = [0, 1, 2, 3, 4, 5, 6].map(|exponent| {
        let aspect = 10f64.powi(exponent);
        let body = Body::new(effort, DVec3::ZERO, DVec3::new(1.0, 1.0 / aspect, 1.0));
        Row::rates(aspect, &body.leaks(effort, 880 + exponent as u64, count), 0.0)
    });
    let by_offset = [0, 2, 4].map(|exponent| {
        let offset = 10f64.powi(exponent);
        let body = Body::new(effort, DVec3::new(0.6, -0.5, 0.62) * offset, DVec3::ONE);
        Row::rates(offset, &body.leaks(effort, 900 + exponent as u64, count), 0.0)
    });
    let lost = [0, 2, 4].map(|exponent| {
        let offset = 10f64.powi(exponent);
        let body = Body::new(effort, DVec3::new(0.6, -0.5, 0.62) * offset, DVec3::ONE);
        let available = Isa::ALL.into_iter().filter(|isa| isa.is_available());
        let trees: Vec<_> = available.map(|isa| tree(&body.triangles, isa, effort.threads)).collect();
        let [tally] = effort.run(920 + exponent as u64, count, |rng, [tally]| {
            let origin = body.centre + unit(rng) * 10f64.powf(rng.range(0.2, 4.3));
            let ray = Ray::new(origin, (body.hard_point(rng) - origin).normalize());
            let hits = each_preset!(K => body.tree.intersect::<K>(&ray));
            let other_bits = trees.iter().any(|tree| tree.intersect::<Robust>(&ray) != hits[3]);
            tally.judge([elsewhere(hits[0], hits[3]), elsewhere(hits[1], hits[3]), other_bits, false]);
        });
        Row::rates(offset, &tally, 0.0)
    });
    vec![
        Sweep::new("leaks from inside", "size", by_size.to_vec()),
        Sweep::new("leaks from inside, flattened", "width / height", by_aspect.to_vec()),
        Sweep::new("leaks from inside, away from the origin", "offset / size", by_offset.to_vec()),
        // `robust` is asked for the bits of `reference` on every instruction set, the others for a hit within 1e-3 of the size.
        Sweep::new("hits that differ from those of f64 boxes", "offset / size", lost.to_vec()),
    ]
}

/// Whether a hit is lost, invented or a thousandth of the body away.
fn elsewhere(hit: Option<TriangleHit>, exact: Option<TriangleHit>) -> bool {
    match (hit, exact) {
        (Some(hit), Some(exact)) => (hit.t - exact.t).abs() > 1e-3,
        _ => hit.is_some() != exact.is_some(),
    }
}

/// A triangle alone in a tree, as every preset meets it.
fn meet(corners: [Vec3; 3], ray: &Ray) -> [Option<TriangleHit>; 4] {
    let tree = tree(&[corners], Isa::best(), NonZeroUsize::MIN);
    each_preset!(K => tree.intersect::<K>(ray))
}

/// Two tables: the error of t, at most 5e-16 for each unit of difficulty and as much for the nine roundings of t itself, and
/// how often the triangle is missed.
fn t_errors(
    effort: &Effort,
    (seed, axis): (u64, &str),
    exponents: std::ops::RangeInclusive<i32>,
    sample: impl Fn(&mut SplitMix64, f64) -> ([Vec3; 3], Ray) + Sync,
) -> [Sweep; 2] {
    let (mut worst, mut missed) = (Vec::new(), Vec::new());
    for exponent in exponents {
        let difficulty = 10f64.powi(exponent);
        let count = effort.choose(2_000, 200_000);
        let [tally] = effort.run(seed + exponent as u64, count, |rng, [tally]| {
            let (corners, ray) = sample(rng, difficulty);
            let exact = triangle_plane(&ray, corners.map(|p| p.as_dvec3()));
            let hits = meet(corners, &ray);
            tally.judge(hits.map(|hit| hit.is_none()));
            let relative = |hit: TriangleHit| ((Dd::from(hit.t) - exact) / exact).abs().to_f64();
            tally.measure(hits.map(|hit| hit.map_or(0.0, relative)));
        });
        worst.push(Row::worst(difficulty, &tally, 5e-16 * (1.0 + difficulty)));
        missed.push(Row::rates(difficulty, &tally, 0.0));
    }
    [Sweep::new("largest relative error of t", axis, worst), Sweep::new("triangle missed", axis, missed)]
}

/// A point well inside of a triangle.
fn inner_point([a, b, c]: [Vec3; 3], rng: &mut SplitMix64) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    let (u, v) = (rng.range(0.1, 0.45), rng.range(0.1, 0.45));
    a + (b - a) * u + (c - a) * v
}

/// S9: t on slivers, and on triangles that are seen at a small angle.
pub fn slivers(effort: &Effort) -> Vec<Sweep> {
    let mut tables = Vec::new();
    tables.extend(t_errors(effort, (950, "length / height"), 2..=6, |rng, aspect| {
        let along = unit(rng);
        let across = orthogonal(along, rng);
        let start = unit(rng) * rng.unit();
        let corners = [start, start + along, start + along * rng.unit() + across / aspect].map(|p| p.as_vec3());
        let target = inner_point(corners, rng);
        let normal = along.cross(across);
        let toward = (normal + unit(rng) * 0.8).normalize();
        (corners, Ray::new(target - toward * rng.range(1.0, 10.0), toward))
    }));
    tables.extend(t_errors(effort, (970, "1 / angle to the plane"), 0..=7, |rng, closeness| {
        let along = unit(rng);
        let across = orthogonal(along, rng);
        let start = unit(rng) * rng.unit();
        let corners = [start, start + along, start + along * 0.5 + across * 0.87].map(|p| p.as_vec3());
        let target = inner_point(corners, rng);
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let normal = (b - a).cross(c - a).normalize();
        let toward = (orthogonal(normal, rng) + normal * (1.0 / closeness).tan()).normalize();
        (corners, Ray::new(target - toward * rng.range(1.0, 10.0), toward))
    }));
    tables
}
