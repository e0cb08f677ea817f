//! S8 and S9: closed meshes, slivers and triangles seen edge on.

use super::oracle::Dd;
use super::scenes::{ModelFile, at, compile, empty, matte, mesh, object};
use super::solids::triangle_plane;
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally, each_preset};
use super::vectors::{orthogonal, unit};
use crate::bvh::{Isa, TriangleHit, Triangles};
use crate::description::{CameraDesc, ObjectDesc, ShapeDesc};
use crate::geometry::{Ray, Robust};
use crate::math::SplitMix64;
use crate::scene::{PacketScratch, Scene};
use glam::{DVec2, DVec3, Vec3};
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
    /// The ball that it is made of.
    ball: Vec<[Vec3; 3]>,
    /// The same body as an object, for packets.
    scene: Scene,
}

/// Rays in a packet of the experiment: as many as a scene takes at once.
const PACKET: usize = 256;

impl Body {
    fn new(effort: &Effort, model: &ModelFile, centre: DVec3, half: DVec3, previous: Option<&Scene>) -> Self {
        let place = |p: Vec3| (centre + p.as_dvec3() * half).as_vec3();
        let ball = ball(effort);
        let triangles: Vec<_> = ball.iter().map(|t| t.map(place)).collect();
        let tree = tree(&triangles, Isa::best(), effort.threads);
        let mut desc = empty(1, 1, CameraDesc::default());
        desc.materials = vec![matte("body")];
        desc.objects = vec![ObjectDesc { scale: half, ..at(centre, mesh(model.path(), 0.0, "body")) }];
        Self { triangles, tree, centre, half, ball, scene: compile(&desc, previous) }
    }

    fn any_triangle(&self, rng: &mut SplitMix64) -> usize {
        (rng.next_u64() % self.triangles.len() as u64) as usize
    }

    /// A hard point of the tree's triangles.
    fn target(&self, rng: &mut SplitMix64) -> DVec3 {
        hard_point(self.triangles[self.any_triangle(rng)].map(|p| p.as_dvec3()), rng)
    }

    /// A point well inside.
    fn inside(&self, rng: &mut SplitMix64) -> DVec3 {
        self.centre + unit(rng) * self.half * (0.9 * rng.unit())
    }

    /// A ray from inside to such a point; not always of unit length.
    fn ray_from_inside(&self, rng: &mut SplitMix64) -> Ray {
        let origin = self.inside(rng);
        let way = self.target(rng) - origin;
        Ray::new(origin, if rng.unit() < 0.5 { way } else { way.normalize() })
    }

    /// Rays from one place, or from places that are close together, to such points of neighbouring triangles.
    fn packet_from_inside(&self, rng: &mut SplitMix64) -> [Ray; PACKET] {
        let (origin, first) = (self.inside(rng), self.any_triangle(rng));
        let apart = if rng.unit() < 0.5 { 0.0 } else { 0.01 };
        std::array::from_fn(|k| {
            let origin = origin + unit(rng) * self.half * apart;
            // Faces in a row were one face once. The object has the ball's own corners, not those rounded to f32 at its
            // place.
            let corners = self.ball[(first + k / 4) % self.ball.len()].map(|p| self.centre + p.as_dvec3() * self.half);
            let way = hard_point(corners, rng) - origin;
            Ray::new(origin, way.normalize())
        })
    }

    /// The part of rays that get out, of each preset; of `robust` alone and in packets, `count` of either.
    fn leaks(&self, effort: &Effort, seed: u64, count: u64, difficulty: f64) -> Row {
        let [others] = effort.run(seed, count / SHARE, |rng, [tally]| {
            let ray = self.ray_from_inside(rng);
            tally.judge(each_preset!(K => self.tree.intersect::<K>(&ray).is_none()));
        });
        let only_robust = |leaks: bool| [false, false, leaks, false];
        let [alone] = effort.run(seed + 1000, count, |rng, [tally]| {
            tally.judge(only_robust(self.tree.intersect::<Robust>(&self.ray_from_inside(rng)).is_none()));
        });
        let packets = count.div_ceil(PACKET as u64);
        let [together] = effort.run(seed + 2000, packets, |rng, [tally]| {
            let rays = self.packet_from_inside(rng);
            let (mut hits, mut occluded, mut scratch) = ([None; PACKET], [false; PACKET], PacketScratch::default());
            self.scene.intersect_packet::<Robust>(&rays[..], &mut hits, &mut scratch);
            self.scene.occluded_packet::<Robust>(&rays[..], &mut occluded, &mut scratch);
            for (hit, occluded) in hits.iter().zip(occluded) {
                tally.judge(only_robust(hit.is_none() || !occluded));
            }
        });
        let mut robust = alone;
        robust += together;
        let [classic, fast, _, reference] = others.rates();
        Row { values: [classic, fast, robust.rates()[2], reference], ..Row::rates(difficulty, &robust, 0.0) }
    }
}

/// A point of a triangle that is hard to decide: a corner, on an edge, beside an edge by 1e-5 to 1e-14 of the triangle.
fn hard_point([a, b, _]: [DVec3; 3], rng: &mut SplitMix64) -> DVec3 {
    match rng.next_u64() % 4 {
        0 => a,
        1 => (a + b) / 2.0,
        2 => a.lerp(b, rng.unit()),
        _ => a.lerp(b, rng.unit()) + unit(rng) * (b - a).length() * 10f64.powf(rng.range(-14.0, -5.0)),
    }
}

/// Of so many rays against closed meshes that `robust` is asked, the others are asked one.
const SHARE: u64 = 16;

/// The ball of these experiments.
fn ball(effort: &Effort) -> Vec<[Vec3; 3]> {
    icosphere(effort.choose(4, 5))
}

/// S8: leaks of closed meshes through the whole hierarchy, alone and in packets; hits that boxes in f32 lose, and
/// packets.
pub fn watertight(effort: &Effort) -> Vec<Sweep> {
    // Sixteen bodies: 1e8 rays one by one, and as many in packets.
    let count = effort.choose(40_000, 6_250_000);
    let model = ModelFile::new(&ball(effort));
    let first = Body::new(effort, &model, DVec3::ZERO, DVec3::ONE, None);
    let body = |centre: DVec3, half: DVec3| Body::new(effort, &model, centre, half, Some(&first.scene));
    let away = |offset: f64| body(DVec3::new(0.6, -0.5, 0.62) * offset, DVec3::ONE);
    let by_size = [-10, -6, -3, 0, 3, 8].map(|exponent| {
        let size = 10f64.powi(exponent);
        body(DVec3::ZERO, DVec3::splat(size)).leaks(effort, (850 + exponent) as u64, count, size)
    });
    let by_aspect = [0, 1, 2, 3, 4, 5, 6].map(|exponent| {
        let aspect = 10f64.powi(exponent);
        body(DVec3::ZERO, DVec3::new(1.0, 1.0 / aspect, 1.0)).leaks(effort, 880 + exponent as u64, count, aspect)
    });
    let by_offset = [0, 2, 4].map(|exponent| {
        let offset = 10f64.powi(exponent);
        away(offset).leaks(effort, 900 + exponent as u64, count, offset)
    });
    let lost = [0, 2, 4].map(|exponent| {
        let offset = 10f64.powi(exponent);
        let body = away(offset);
        let available = Isa::ALL.into_iter().filter(|isa| isa.is_available());
        let trees: Vec<_> = available.map(|isa| tree(&body.triangles, isa, effort.threads)).collect();
        let [tally] = effort.run(920 + exponent as u64, count, |rng, [tally]| {
            let origin = body.centre + unit(rng) * 10f64.powf(rng.range(0.2, 4.3));
            let target = body.target(rng);
            let ray = Ray::new(origin, (target - origin).normalize());
            let hits = each_preset!(K => body.tree.intersect::<K>(&ray));
            let other_bits = trees.iter().any(|tree| tree.intersect::<Robust>(&ray) != hits[3]);
            tally.judge([elsewhere(hits[0], hits[3]), elsewhere(hits[1], hits[3]), other_bits, false]);
        });
        Row::rates(offset, &tally, 0.0)
    });
    let together = [0, 2, 4].map(|exponent| {
        let offset = 10f64.powi(exponent);
        let scene = shapes(DVec3::new(0.6, -0.5, 0.62) * offset, &model, &first.scene);
        let packets = effort.choose(40_000u64, 1_000_000).div_ceil(PACKET as u64);
        let [tally] =
            effort.run(940 + exponent as u64, packets, |rng, [tally]| packet_of_shapes(&scene, offset, rng, tally));
        Row::rates(offset, &tally, 0.0)
    });
    let leaks = format!(
        "of robust, half of the trials are rays alone and half are rays in packets; the other presets \
         are asked one ray for {SHARE} of those alone"
    );
    vec![
        Sweep::new("leaks from inside", "size", by_size.to_vec()).noted(leaks.as_str()),
        Sweep::new("leaks from inside, flattened", "width / height", by_aspect.to_vec()),
        Sweep::new("leaks from inside, away from the origin", "offset / size", by_offset.to_vec()),
        Sweep::new("hits that differ from those of f64 boxes", "offset / size", lost.to_vec()).noted(
            "robust is asked for the bits of reference on every instruction set of this processor, classic and fast for \
             a hit within 1e-3 of the size",
        ),
        Sweep::new("hits in packets that differ from those of rays alone", "offset / size", together.to_vec())
            .noted("every shape and a mesh, with shadow rays"),
    ]
}

/// Every shape once, about `centre`: as many as are asked without a tree.
fn shapes(centre: DVec3, model: &ModelFile, previous: &Scene) -> Scene {
    let mut desc = empty(1, 1, CameraDesc::default());
    desc.materials = vec![matte("body")];
    let place = |x: f64, y: f64, z: f64, shape: ShapeDesc| at(centre + DVec3::new(x, y, z), object(shape, "body"));
    let turned = |object: ObjectDesc| ObjectDesc { rotate: DVec3::new(20.0, 70.0, 30.0), ..object };
    desc.objects = vec![
        place(0.0, -1.5, 0.0, ShapeDesc::Plane),
        place(-1.5, 0.0, 0.0, ShapeDesc::Sphere { radius: 0.7 }),
        ObjectDesc { scale: DVec3::new(0.8, 0.4, 0.6), ..place(0.0, 0.0, 1.5, ShapeDesc::Sphere { radius: 1.0 }) },
        turned(place(1.5, 0.0, 0.0, ShapeDesc::Cuboid { size: DVec3::ONE })),
        turned(place(0.0, 0.0, -1.5, ShapeDesc::Cylinder { radius: 0.5, height: 1.2 })),
        place(0.0, 1.2, 0.0, ShapeDesc::Cone { radius: 0.6, height: 1.0 }),
        turned(place(1.0, 1.2, 1.0, ShapeDesc::Quad { size: DVec2::splat(1.5) })),
        ObjectDesc { scale: DVec3::splat(0.6), ..at(centre, mesh(model.path(), 0.0, "body")) },
    ];
    compile(&desc, Some(previous))
}

/// Rays that run alike, as from a pixel or toward a light, against every shape: the same hits as alone, to the last
/// bit.
fn packet_of_shapes(scene: &Scene, offset: f64, rng: &mut SplitMix64, tally: &mut Tally) {
    let centre = DVec3::new(0.6, -0.5, 0.62) * offset;
    let eye = centre + unit(rng) * 10f64.powf(rng.range(-1.0, 2.0));
    let (target, apart) = (centre + unit(rng) * 1.8, 10f64.powf(rng.range(-9.0, 0.0)));
    let rays: [Ray; PACKET] = std::array::from_fn(|_| {
        let way = target + unit(rng) * apart - eye;
        let ray = Ray::new(eye, way.normalize_or(DVec3::X));
        // Shadow rays end.
        if rng.unit() < 0.5 { ray } else { Ray { t_max: way.length(), ..ray } }
    });
    let mut scratch = PacketScratch::default();
    let differ = each_preset!(K => {
        let (mut hits, mut occluded) = ([None; PACKET], [false; PACKET]);
        scene.intersect_packet::<K>(&rays[..], &mut hits, &mut scratch);
        scene.occluded_packet::<K>(&rays[..], &mut occluded, &mut scratch);
        let same = |k: usize| hits[k] == scene.intersect::<K>(&rays[k]) && occluded[k] == scene.occluded::<K>(&rays[k]);
        std::array::from_fn::<bool, PACKET, _>(|k| !same(k))
    });
    for k in 0..PACKET {
        tally.judge(differ.each_ref().map(|differ| differ[k]));
    }
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

/// Two tables: the error of t, at most 5e-16 for each unit of difficulty, and how often the triangle is missed. Where
/// the difficulty is 1 the nine roundings of t itself count, which are 1e-15 at worst.
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
        worst.push(Row::worst(difficulty, &tally, (5e-16 * difficulty).max(NINE_ROUNDINGS)));
        missed.push(Row::rates(difficulty, &tally, 0.0));
    }
    let note = if worst[0].difficulty < 2.0 {
        "numerics.md asks for 5e-16 / angle. In the first row that is 4.5 u, u = 2^-53; but t of a watertight test is a weighted \
         mean of nine roundings by up to u each, and so 1e-15 is asked of that row. All others are held as stated"
    } else {
        "at most 5e-16 length / height, as numerics.md asks"
    };
    [Sweep::new("largest relative error of t", axis, worst).noted(note), Sweep::new("triangle missed", axis, missed)]
}

/// What t is off by where nothing is difficult: nine roundings.
const NINE_ROUNDINGS: f64 = 9.0 * f64::EPSILON / 2.0;

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
