//! S4 to S6: cylinders and cones from afar, along their axis and generators, past the apex, and through their rims.

use super::oracle::Dd;
use super::solids::{self, Chord};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally, each_preset};
use super::vectors::{orthogonal, unit, within};
use crate::geometry::{Kernels, Ray, cone_surface, cuboid_surface, cylinder_surface};
use crate::math::SplitMix64;
use glam::DVec3;
use std::f64::consts::TAU;

/// A shape in its object space.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Solid {
    Cuboid,
    Cylinder,
    Cone,
}

impl Solid {
    /// The first hit with its face.
    fn intersect<K: Kernels>(self, ray: &Ray) -> Option<(f64, u32)> {
        match self {
            Self::Cuboid => K::cuboid(ray),
            Self::Cylinder => K::cylinder(ray),
            Self::Cone => K::cone(ray),
        }
    }

    /// The chord of the solids that have an oracle.
    fn exact(self, ray: &Ray) -> Option<Chord> {
        if self == Self::Cone { solids::cone(ray) } else { solids::cylinder(ray) }
    }

    /// Where rays from the hit start.
    fn start<K: Kernels>(self, ray: &Ray, (t, face): (f64, u32)) -> DVec3 {
        let p = ray.at(t);
        let surface = match self {
            Self::Cuboid => cuboid_surface(p, face),
            Self::Cylinder => cylinder_surface(p, face),
            Self::Cone => cone_surface(p, face),
        };
        K::surface_point(ray, t, surface.point, 0.0).0
    }

    /// Distance of `p` from a face, of size 1.
    fn residual(self, p: DVec3, face: u32) -> f64 {
        let [x, y, z] = p.to_array().map(Dd::from);
        let rho = (x * x + z * z).sqrt();
        let off = match (self, face) {
            (Self::Cone, 0) => (rho - (Dd::ONE - y) / Dd::from(2.0)) * Dd::from(0.8f64.sqrt()),
            (_, 0) => rho - Dd::ONE,
            (_, 1) => y + Dd::ONE,
            _ => y - Dd::ONE,
        };
        off.abs().to_f64()
    }

    /// Part of the size by which a hit may be off before it is taken for another one: what is behind a rim that leaks.
    const ELSEWHERE: f64 = 1e-3;

    /// Judges the hits of all presets: `wrong` counts, `off` measures how far off the surface the start of the next ray
    /// is.
    fn judge(self, ray: &Ray, wrong: &mut Tally, off: &mut Tally) {
        let exact = self.exact(ray).and_then(|chord| chord.first());
        let hits = each_preset!(K => self.intersect::<K>(ray).map(|hit| (hit, self.start::<K>(ray, hit))));
        let mut errors = [0.0; 4];
        let mut failed = [false; 4];
        for k in 0..4 {
            failed[k] = match (hits[k], exact) {
                (Some((hit, start)), Some(exact)) => {
                    errors[k] = self.residual(start, hit.1);
                    (Dd::from(hit.0) - exact).abs().to_f64() > Self::ELSEWHERE
                }
                (hit, exact) => hit.is_some() != exact.is_some(),
            };
        }
        wrong.judge(failed);
        off.trials += 1;
        off.measure(errors);
    }

    /// Two tables over an axis: wrong hits, and starting points off the surface.
    fn sweep(
        self,
        effort: &Effort,
        (seed, axis): (u64, &str),
        difficulties: impl Iterator<Item = f64>,
        ray: impl Fn(&mut SplitMix64, f64) -> Ray + Sync,
    ) -> [Sweep; 2] {
        let (mut wrong, mut off) = (Vec::new(), Vec::new());
        for (difficulty, k) in difficulties.zip(0..) {
            let count = effort.choose(5_000, 1_000_000);
            let [judged, measured] = effort.run(seed + k, count, |rng, [judged, measured]| {
                self.judge(&ray(rng, difficulty), judged, measured);
            });
            wrong.push(Row::rates(difficulty, &judged, 0.0));
            off.push(Row::worst(difficulty, &measured, 1e-14));
        }
        [Sweep::new("wrong hit or miss", axis, wrong), Sweep::new("starting point off the surface, sizes", axis, off)]
    }
}

fn decades(from: i32, to: i32) -> impl Iterator<Item = f64> {
    (from..=to).map(|exponent| 10f64.powi(exponent))
}

/// A ray from `distance` that passes a point in the neighbourhood of the shape.
fn from_afar(rng: &mut SplitMix64, distance: f64) -> Ray {
    let (toward, target) = (unit(rng), within(rng, 1.2));
    Ray::new(target - toward * distance.max(3.0), toward)
}

/// S4
pub fn cylinder(effort: &Effort) -> Vec<Sweep> {
    let solid = Solid::Cylinder;
    let mut tables = Vec::new();
    tables.extend(solid.sweep(effort, (400, "distance / size"), decades(0, 7), from_afar));
    tables.extend(solid.sweep(effort, (420, "1 / angle to the axis"), decades(1, 7), |rng, steepness| {
        let across = orthogonal(DVec3::Y, rng);
        let toward = (DVec3::NEG_Y + across * rng.range(0.5, 1.5) / steepness).normalize();
        // So close to the side that about half of the rays meet it.
        let target = orthogonal(DVec3::Y, rng) * (1.0 + rng.range(-2.0, 2.0) / steepness);
        Ray::new(target + DVec3::Y * rng.range(-1.0, 1.0) - toward * 5.0, toward)
    }));
    tables
}

/// S5
pub fn cone(effort: &Effort) -> Vec<Sweep> {
    let solid = Solid::Cone;
    let mut tables = Vec::new();
    tables.extend(solid.sweep(effort, (500, "distance / size"), decades(0, 7), from_afar));
    tables.extend(solid.sweep(effort, (520, "1 / angle to a generator"), decades(1, 7), |rng, closeness| {
        let (sin, cos) = (TAU * rng.unit()).sin_cos();
        let generator = DVec3::new(0.5 * sin, -1.0, 0.5 * cos).normalize();
        let toward = (generator + orthogonal(generator, rng) * rng.range(0.5, 1.5) / closeness).normalize();
        Ray::new(within(rng, 1.1) - toward * 5.0, toward)
    }));
    tables.extend(solid.sweep(effort, (540, "size / distance from the apex"), decades(1, 5), |rng, closeness| {
        let toward = unit(rng);
        let target = DVec3::Y + orthogonal(toward, rng) * rng.range(0.5, 1.5) / closeness;
        Ray::new(target - toward * 10f64.powf(rng.range(0.5, 2.0)), toward)
    }));
    tables
}

/// Crossings of a ray with a closed solid, each at a larger t than the one before.
fn crossings<K: Kernels>(solid: Solid, ray: &Ray) -> usize {
    let mut ray = *ray;
    let mut count = 0;
    while let Some((t, _)) = solid.intersect::<K>(&ray) {
        count += 1;
        ray.t_min = t;
        if count > 4 {
            break;
        }
    }
    count
}

/// S6: through points at and beside rims, edges, corners and the apex, from inside (one crossing) and right through the
/// solid (two).
pub fn joints(effort: &Effort) -> Vec<Sweep> {
    let on_joint = |solid: Solid, rng: &mut SplitMix64| {
        let (sin, cos) = (TAU * rng.unit()).sin_cos();
        let side = if rng.next_u64().is_multiple_of(2) { 1.0 } else { -1.0 };
        match solid {
            Solid::Cuboid => {
                let mut p = DVec3::from_array([0; 3].map(|_| if rng.unit() < 0.5 { -1.0 } else { 1.0 }));
                if rng.unit() < 0.7 {
                    p[(rng.next_u64() % 3) as usize] = rng.range(-1.0, 1.0);
                }
                p
            }
            Solid::Cylinder => DVec3::new(sin, side, cos),
            Solid::Cone if rng.unit() < 0.2 => DVec3::Y,
            Solid::Cone => DVec3::new(sin, -1.0, cos),
        }
    };
    let table = |solid: Solid, seed: u64, measure: &str| {
        let rows = [20, 16, 12, 8, 4, 2, 0].map(|bits| {
            let ulps = f64::from(1 << bits);
            let [tally] = effort.run(seed + bits, effort.choose(2_000, 50_000), |rng, [tally]| {
                let mut joint = on_joint(solid, rng);
                for k in 0..3 {
                    joint[k] += (rng.range(-ulps, ulps)).round() * f64::EPSILON;
                }
                // Well inside of every solid here.
                let inside = DVec3::NEG_Y * 0.5 + within(rng, 0.2);
                let way = joint - inside;
                let (ray, right) = if rng.unit() < 0.5 {
                    (Ray::new(inside, way.normalize()), 1)
                } else {
                    (Ray::new(joint + way * 10f64.powf(rng.range(-1.0, 2.0)), -way.normalize()), 2)
                };
                tally.judge(each_preset!(K => crossings::<K>(solid, &ray) != right));
            });
            Row::rates(2f64.powi(52) / ulps, &tally, 0.0)
        });
        Sweep::new(measure, "size / distance from the joint", rows.to_vec())
    };
    vec![
        table(Solid::Cuboid, 600, "cuboid: crossings odd"),
        table(Solid::Cylinder, 630, "cylinder: crossings odd"),
        table(Solid::Cone, 660, "cone: crossings odd"),
    ]
}
