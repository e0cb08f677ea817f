//! Where rays leave the bodies that they are inside of, many at once: sorted by what computes it, each with the numbers
//! of its own body.

#![allow(clippy::needless_range_loop)] // Numbers of rays run over several arrays at once.

use super::front::{CAPACITY, Met};
use super::{PacketScratch, Scene, Shape};
use crate::bvh::{ExactRays, RayPacket, Task, TreeKernels};
use crate::geometry::{Hit, Ray};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Room for [`Scene::leave_packet`].
#[derive(Debug, Default)]
pub(super) struct Leaving {
    /// Numbers of the rays, by shape.
    numbers: [Vec<u16>; 4],
    local: Local,
    met: Met,
}

/// Rays in the space of the bodies that they are inside of.
#[derive(Debug)]
struct Local {
    rays: ExactRays,
    /// Of spheres there.
    radius: [f64; CAPACITY],
}

impl Default for Local {
    fn default() -> Self {
        Self { rays: ExactRays::default(), radius: [1.0; CAPACITY] }
    }
}

const SPHERE: u8 = 0;
const CUBOID: u8 = 1;
const CYLINDER: u8 = 2;
const CONE: u8 = 3;

/// Finds where rays meet a shape about the origin.
struct Leave<K, const SHAPE: u8> {
    count: usize,
    kernels: PhantomData<K>,
}

impl<K: TreeKernels, const SHAPE: u8> Task for Leave<K, SHAPE> {
    type Input = Local;
    type Output = Met;

    #[inline(always)]
    #[allow(clippy::manual_map)] // `Option::map` is not inlined always.
    fn run(self, local: &Local, met: &mut Met) {
        for i in 0..self.count.min(CAPACITY) {
            let ray = local.rays.ray(i);
            let hit = match SHAPE {
                SPHERE => match K::sphere(&ray, DVec3::ZERO, local.radius[i]) {
                    Some(t) => Some((t, 0)),
                    None => None,
                },
                CUBOID => K::cuboid(&ray),
                CYLINDER => K::cylinder(&ray),
                _ => K::cone(&ray),
            };
            (met.t[i], met.primitive[i]) = match hit {
                Some((t, face)) => (t, face),
                None => (f64::NAN, 0),
            };
        }
    }
}

impl Scene {
    /// For each ray of a range what [`Scene::intersect`] finds; quicker where that is the body that the ray starts in.
    /// `body`: that, if it is known, by the number of the ray.
    pub fn leave_packet<K: TreeKernels>(
        &self,
        rays: &RayPacket,
        range: Range<usize>,
        body: impl Fn(usize) -> Option<u32>,
        hits: &mut [Option<Hit>],
        scratch: &mut PacketScratch,
    ) {
        let room = &mut *scratch.leaving;
        room.numbers.iter_mut().for_each(Vec::clear);
        for number in range {
            let ray = &rays.ray(number);
            let body = body(number).filter(|&body| self.leaves_next::<K>(ray, body));
            let shape = match body.map(|body| &self.objects()[body as usize].shape) {
                Some(Shape::Ball { .. } | Shape::Ellipsoid) => SPHERE,
                Some(Shape::Cuboid) => CUBOID,
                Some(Shape::Cylinder) => CYLINDER,
                Some(Shape::Cone) => CONE,
                _ => {
                    hits[number] = self.intersect::<K>(ray);
                    continue;
                }
            };
            room.numbers[usize::from(shape)].push(number as u16);
        }
        self.leave_shape::<K, SPHERE>(rays, &body, hits, room);
        self.leave_shape::<K, CUBOID>(rays, &body, hits, room);
        self.leave_shape::<K, CYLINDER>(rays, &body, hits, room);
        self.leave_shape::<K, CONE>(rays, &body, hits, room);
    }

    fn leave_shape<K: TreeKernels, const SHAPE: u8>(
        &self,
        rays: &RayPacket,
        body: &impl Fn(usize) -> Option<u32>,
        hits: &mut [Option<Hit>],
        room: &mut Leaving,
    ) {
        let Leaving { numbers, local, met } = room;
        let numbers = &numbers[usize::from(SHAPE)];
        if numbers.is_empty() {
            return;
        }
        let body = |number: u16| body(number.into()).unwrap_or_default();
        for (i, &number) in numbers.iter().enumerate() {
            let ray = rays.ray(number.into());
            let object = &self.objects()[body(number) as usize];
            let (ray, radius) = match object.shape {
                // The first thing that is done with both anyway.
                Shape::Ball { centre, radius } => (Ray { origin: ray.origin - centre, ..ray }, radius),
                _ => (ray.transformed(&object.map.inverse), 1.0),
            };
            local.rays.put(i, &ray);
            local.radius[i] = radius;
        }
        self.run(Leave::<K, SHAPE> { count: numbers.len(), kernels: PhantomData }, local, met);
        for (i, &number) in numbers.iter().enumerate() {
            let hit = Hit { t: met.t[i], object: body(number), primitive: met.primitive[i], u: 0.0, v: 0.0 };
            let number = usize::from(number);
            hits[number] = if hit.t.is_nan() { self.intersect::<K>(&rays.ray(number)) } else { Some(hit) };
        }
    }
}
