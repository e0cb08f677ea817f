//! S10: rays that start on a surface meet neither that surface nor pass what stands a millionth of the size away.

use super::scenes::{
    ModelFile, NUMERICS, at, compile, cuboid, empty, matte, mesh, object, perspective, picture, point_light, v,
};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally, each_preset};
use super::triangles::icosphere;
use super::vectors::unit;
use crate::bvh::TreeKernels;
use crate::description::{CameraDesc, Falloff, ObjectDesc, Shading, ShapeDesc};
use crate::geometry::{Ray, reflect};
use crate::math::SplitMix64;
use crate::scene::Scene;
use glam::{DVec2, DVec3};
use std::path::Path;

/// Distances of the camera and of the world's origin, in sizes.
const AWAY: [f64; 4] = [5.0, 1e2, 1e3, 1e5];

/// Gaps between the body and a shell around it, in sizes.
const GAPS: [f64; 4] = [1e-1, 1e-2, 1e-4, 1e-6];

/// Tallies of shadow acne and mirror acne by distance, then of lost shadows and lost mirror images by gap.
type Tallies = [Tally; 4 * AWAY.len()];

/// Convex bodies, with their stretch.
fn bodies(model: &Path) -> [(ShapeDesc, DVec3); 7] {
    [
        (ShapeDesc::Sphere { radius: 1.0 }, DVec3::ONE),
        (ShapeDesc::Sphere { radius: 1.0 }, v(1.0, 0.3, 2.0)),
        (ShapeDesc::Cuboid { size: v(2.0, 1.5, 1.0) }, DVec3::ONE),
        (ShapeDesc::Cylinder { radius: 0.8, height: 1.6 }, v(1.0, 1.0, 0.4)),
        (ShapeDesc::Cone { radius: 1.0, height: 1.4 }, DVec3::ONE),
        (ShapeDesc::Quad { size: DVec2::splat(2.0) }, DVec3::ONE),
        (ShapeDesc::Mesh { file: model.into(), crease: 0.0 }, DVec3::ONE),
    ]
}

/// A body at its place, and shells around it.
struct Cell {
    scene: Scene,
    shells: [Scene; GAPS.len()],
    centre: DVec3,
    size: f64,
    /// Index of the distance from the origin among `AWAY`; 0 also at the origin.
    away: usize,
}

impl Cell {
    fn new(shape: &ShapeDesc, stretch: DVec3, size: f64, away: usize, previous: Option<&Scene>) -> Self {
        let centre = if away == 0 { DVec3::ZERO } else { v(0.6, -0.5, 0.62) * (AWAY[away] * size) };
        let turned = ObjectDesc { rotate: v(20.0, 70.0, 30.0), ..object(shape.clone(), "body") };
        let body = ObjectDesc { scale: stretch * size, ..at(centre, turned) };
        let make = |objects: Vec<ObjectDesc>, previous: Option<&Scene>| {
            let mut desc = empty(1, 1, CameraDesc::default());
            desc.materials = vec![matte("body")];
            desc.objects = objects;
            compile(&desc, previous)
        };
        let scene = make(vec![body.clone()], previous);
        let shells = GAPS.map(|gap| {
            if matches!(shape, ShapeDesc::Quad { .. }) {
                // A larger one over it and another one under it.
                let up = (scene.objects()[0].map.forward.matrix3 * DVec3::Y).normalize() * (gap * size);
                let lid =
                    |side: f64| ObjectDesc { scale: body.scale * 1e3, translate: centre + up * side, ..body.clone() };
                return make(vec![lid(1.0), lid(-1.0)], None);
            }
            // Scaled about its middle it stands off by the gap times the least extent, at least.
            make(vec![ObjectDesc { scale: body.scale * (1.0 + gap), ..body.clone() }], Some(&scene))
        });
        Self { scene, shells, centre, size, away }
    }

    /// What became of one hit: shadow acne, mirror acne, and the shells that let the shadow ray and the mirrored ray
    /// pass.
    fn judge<K: TreeKernels>(&self, ray: &Ray, toward: DVec3, light_at: f64) -> Option<Verdict> {
        let hit = self.scene.intersect::<K>(ray)?;
        let surface = self.scene.interaction::<K>(ray, &hit);
        let side = if surface.entering { 1.0 } else { -1.0 };
        let normal = surface.geometric_normal * side;
        // Not within a thousandth of the tangent plane: there a shell of a millionth is far away.
        let toward = (normal * 1.001 + toward).normalize();
        let light = surface.point + toward * (light_at * self.size);
        let shadow = surface.shadow_start().ray_to::<K>(light)?;
        let mirrored = surface.spawn_ray::<K>(reflect(ray.direction, normal, normal));
        Some(Verdict {
            shadow_acne: self.scene.occluded::<K>(&shadow),
            mirror_acne: self.scene.occluded::<K>(&mirrored),
            lost_shadow: [0, 1, 2, 3].map(|gap| !self.shells[gap].occluded::<K>(&shadow)),
            lost_image: [0, 1, 2, 3].map(|gap| !self.shells[gap].occluded::<K>(&mirrored)),
        })
    }

    fn try_one(&self, rng: &mut SplitMix64, tallies: &mut Tallies) {
        let camera = [0, 2, 3][(rng.next_u64() % 3) as usize];
        let light_at = [1e-2, 1.0, 1e4][(rng.next_u64() % 3) as usize];
        let eye = self.centre + unit(rng) * (AWAY[camera] * self.size);
        let target = self.centre + unit(rng) * (rng.unit() * 0.5 * self.size);
        let ray = Ray::new(eye, (target - eye).normalize());
        let toward = unit(rng);
        let verdicts = each_preset!(K => self.judge::<K>(&ray, toward, light_at));
        // What the yardstick misses is no start for a ray; what another one misses is another experiment's.
        if verdicts[3].is_none() {
            return;
        }
        let failed = |bad: fn(&Verdict, usize) -> bool, k| verdicts.map(|v| v.is_some_and(|v| bad(&v, k)));
        let distance = camera.max(self.away);
        tallies[distance].judge(failed(|v, _| v.shadow_acne, 0));
        tallies[4 + distance].judge(failed(|v, _| v.mirror_acne, 0));
        for gap in 0..GAPS.len() {
            // Nearer lights may be inside of the shell.
            if light_at > 1e3 {
                tallies[8 + gap].judge(failed(|v, gap| v.lost_shadow[gap], gap));
            }
            tallies[12 + gap].judge(failed(|v, gap| v.lost_image[gap], gap));
        }
    }
}

#[derive(Clone, Copy)]
struct Verdict {
    shadow_acne: bool,
    mirror_acne: bool,
    lost_shadow: [bool; GAPS.len()],
    lost_image: [bool; GAPS.len()],
}

/// S10
pub fn acne(effort: &Effort) -> Vec<Sweep> {
    let model = ModelFile::new(&icosphere(3));
    let mut total: Tallies = Default::default();
    let mut seed = 1000;
    for (shape, stretch) in bodies(model.path()) {
        let mut previous: Option<Scene> = None;
        for size in [1e-3, 1.0, 1e6] {
            for away in [0, 1, 3] {
                let cell = Cell::new(&shape, stretch, size, away, previous.as_ref());
                seed += 1;
                let count = effort.choose(500, 50_000);
                let tallies = effort.run(seed, count, |rng, tallies: &mut Tallies| cell.try_one(rng, tallies));
                for (sum, part) in total.iter_mut().zip(tallies) {
                    *sum += part;
                }
                previous = Some(cell.scene);
            }
        }
    }
    let rows = |first: usize, difficulties: [f64; 4]| {
        difficulties.into_iter().zip(&total[first..]).map(|(d, tally)| Row::rates(d, tally, 0.0)).collect()
    };
    let (distance, gap) = ("distance of camera or origin / size", "size / gap");
    vec![
        Sweep::new("shadow acne", distance, rows(0, AWAY)),
        Sweep::new("mirror acne", distance, rows(4, AWAY)),
        Sweep::new("contact shadow lost", gap, rows(8, GAPS.map(f64::recip))),
        Sweep::new("mirrored contact lost", gap, rows(12, GAPS.map(f64::recip))),
        images(effort, model.path()),
    ]
}

/// Convex bodies as pictures: under shadows the same as without.
fn images(effort: &Effort, model: &Path) -> Sweep {
    let shapes = [
        cuboid(DVec3::ZERO, v(1.5, 1.2, 1.0), "body"),
        object(ShapeDesc::Sphere { radius: 1.0 }, "body"),
        object(ShapeDesc::Cylinder { radius: 0.7, height: 1.5 }, "body"),
        object(ShapeDesc::Cone { radius: 0.9, height: 1.6 }, "body"),
        mesh(model, 0.0, "body"),
    ];
    let exponents: &[i32] = effort.choose(&[-6, -3, 0, 3, 6], &[-6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6]);
    let rows = exponents.iter().map(|&exponent| {
        let size = 10f64.powi(exponent);
        let mut tally = Tally::default();
        for shape in &shapes {
            for (eye, light, away) in [(4.0f64, 1.5, 0.0), (300.0, 1e4, 100.0)] {
                let offset = v(1.0, -2.0, 0.5) * (size * away);
                let fov = 2.0 * (1.3 / eye).atan().to_degrees();
                let camera = perspective(offset + v(0.4, 0.6, 0.7).normalize() * (eye * size), offset, fov);
                let mut desc = empty(effort.choose(32, 128), effort.choose(32, 128), camera);
                desc.materials = vec![matte("body")];
                let turned = ObjectDesc { rotate: v(20.0, 30.0, 10.0), ..shape.clone() };
                desc.objects = vec![ObjectDesc { scale: DVec3::splat(size), ..at(offset, turned) }];
                let lamp = offset + v(0.9, 0.4, 0.5).normalize() * (light * size);
                desc.lights = vec![point_light(lamp, 1.0, Falloff::None)];
                let mut scene = compile(&desc, None);
                let dark = NUMERICS.map(|numerics| {
                    let mut with = |shading| {
                        (scene.render.numerics, scene.render.shading) = (numerics, shading);
                        picture(effort, &scene)
                    };
                    let (shadowed, plain) = (with(Shading::Whitted), with(Shading::Lambert));
                    // Where light grazes, rounding decides between nothing and next to nothing.
                    let differ = |(a, b): (&crate::shading::Sample, &crate::shading::Sample)| {
                        (a.radiance.r - b.radiance.r).abs() > 1e-7
                    };
                    shadowed.iter().zip(&plain).map(differ).collect::<Vec<_>>()
                });
                let [classic, fast, robust, reference] = &dark;
                for (((&classic, &fast), &robust), &reference) in classic.iter().zip(fast).zip(robust).zip(reference) {
                    tally.judge([classic, fast, robust, reference]);
                }
            }
        }
        Row::rates(size, &tally, 0.0)
    });
    Sweep::new("pixels with acne", "size", rows.collect())
}
