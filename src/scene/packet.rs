//! Many rays against the whole scene at once.
//!
//! In a scene of few objects every object is asked in turn, with no tree: first which rays pass its bounding sphere at all,
//! then groups of rays that do, by the very functions that single rays use ([`Kernels`](crate::geometry::Kernels)). Those are free
//! of calls and stand in loops over plain arrays, which the compiler may turn into vectors of rays (so far it does for some of them only); floating-point
//! operations are neither fused nor reordered by it, so every ray gets the bits that it gets alone.

use super::{Object, Scene, Shape};
use crate::bvh::{Task, TreeKernels};
use crate::geometry::{Hit, Ray};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Rays that are traced together at most.
const CAPACITY: usize = 256;

/// Rays that are met or passed over together.
const GROUP: usize = 8;

/// Up to so many objects with a box, no tree is used.
const FEW: usize = 8;

/// Room that packets of rays need while they are traced; kept by whoever traces, so that tracing takes no memory.
#[derive(Debug, Default)]
pub struct PacketScratch {
    room: Option<Box<Packet>>,
}

/// Rays and what they have met, number by number.
#[derive(Debug)]
struct Packet {
    rays: Rays,
    best: Best,
    /// Which rays pass the bounding sphere of the object in question.
    near: [u8; CAPACITY],
    /// Where they meet the object in question: NaN if they do not.
    met: Met,
}

#[derive(Debug)]
#[repr(align(64))]
struct Rays {
    origin: [[f64; CAPACITY]; 3],
    direction: [[f64; CAPACITY]; 3],
    t_min: [f64; CAPACITY],
    t_max: [f64; CAPACITY],
}

#[derive(Debug)]
#[repr(align(64))]
struct Best {
    /// Hits beyond this do not count any more.
    limit: [f64; CAPACITY],
    t: [f64; CAPACITY],
    /// `u32::MAX` for none.
    object: [u32; CAPACITY],
    primitive: [u32; CAPACITY],
    u: [f64; CAPACITY],
    v: [f64; CAPACITY],
}

#[derive(Debug)]
#[repr(align(64))]
struct Met {
    t: [f64; CAPACITY],
    primitive: [u32; CAPACITY],
}

/// Limit of a ray that needs no further hit.
const DONE: f64 = f64::NEG_INFINITY;

impl Packet {
    fn new() -> Box<Self> {
        let zero = [0.0; CAPACITY];
        Box::new(Self {
            rays: Rays { origin: [zero; 3], direction: [zero; 3], t_min: zero, t_max: zero },
            best: Best { limit: zero, t: zero, object: [0; CAPACITY], primitive: [0; CAPACITY], u: zero, v: zero },
            near: [0; CAPACITY],
            met: Met { t: zero, primitive: [0; CAPACITY] },
        })
    }

    /// Takes rays in. Returns their number, rounded up to whole groups; what fills the last one up meets nothing.
    fn load(&mut self, rays: &[Ray]) -> usize {
        let Self { rays: to, best, .. } = self;
        let padded = rays.len().next_multiple_of(GROUP).min(CAPACITY);
        for i in 0..padded {
            let filler = Ray { t_max: DONE, ..rays[0] };
            let ray = rays.get(i).unwrap_or(&filler);
            for axis in 0..3 {
                to.origin[axis][i] = ray.origin[axis];
                to.direction[axis][i] = ray.direction[axis];
            }
            (to.t_min[i], to.t_max[i], best.limit[i]) = (ray.t_min, ray.t_max, ray.t_max);
            (best.t[i], best.object[i], best.primitive[i]) = (f64::INFINITY, u32::MAX, u32::MAX);
        }
        padded
    }

    fn hit(&self, i: usize) -> Option<Hit> {
        let Best { t, object, primitive, u, v, .. } = &self.best;
        let (u, v) = (u[i], v[i]);
        (object[i] != u32::MAX).then(|| Hit { t: t[i], object: object[i], primitive: primitive[i], u, v })
    }

    /// Takes a hit of ray `i` with an object if it is the best one.
    fn offer(&mut self, i: usize, hit: Hit) {
        let best = &mut self.best;
        let old = Hit { t: best.t[i], object: best.object[i], primitive: best.primitive[i], u: 0.0, v: 0.0 };
        if hit.beats(&old) {
            (best.t[i], best.object[i], best.primitive[i]) = (hit.t, hit.object, hit.primitive);
            (best.u[i], best.v[i]) = (hit.u, hit.v);
            best.limit[i] = hit.reach().min(self.rays.t_max[i]);
        }
    }
}

impl Rays {
    /// One of them, as long as it still is.
    #[inline(always)]
    fn get(&self, i: usize, limit: f64) -> Ray {
        let [ox, oy, oz] = [self.origin[0][i], self.origin[1][i], self.origin[2][i]];
        let [dx, dy, dz] = [self.direction[0][i], self.direction[1][i], self.direction[2][i]];
        let (origin, direction) = (DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
        Ray { origin, direction, t_min: self.t_min[i], t_max: limit }
    }
}

/// Which rays may meet an object: those that pass its bounding sphere and have not gone by it.
struct Pass<'a> {
    rays: &'a Rays,
    limit: &'a [f64; CAPACITY],
    near: &'a mut [u8; CAPACITY],
    count: usize,
    centre: DVec3,
    radius: f64,
    /// Relative error of the object's own test.
    error: f64,
}

impl Task for Pass<'_> {
    #[inline(always)]
    fn run(self) {
        let Pass { rays, limit, near, count, centre, radius, error } = self;
        let (square, error2) = (radius * radius, error * error);
        for i in 0..count.min(CAPACITY) {
            let Ray { origin, direction, t_max, .. } = rays.get(i, limit[i]);
            let f = origin - centre;
            let (n, f2, d2) = (f.cross(direction), f.length_squared(), direction.length_squared());
            // The last term covers the rounding of the cross product and of the object's own test, the factor all others.
            let reach2 = (square + error2 * f2) * 1.0001;
            let past = (f.dot(direction) > 0.0) & (f2 > reach2);
            // NaN passes.
            near[i] = u8::from(!((n.length_squared() > reach2 * d2) | past | (t_max == DONE)));
        }
    }
}

/// Where rays meet an analytic shape.
struct Meet<'a, K> {
    rays: &'a Rays,
    limit: &'a [f64; CAPACITY],
    met: &'a mut Met,
    range: Range<usize>,
    object: &'a Object,
    kernels: PhantomData<K>,
}

impl<K: TreeKernels> Meet<'_, K> {
    #[allow(clippy::manual_unwrap_or, clippy::manual_unwrap_or_default, clippy::needless_range_loop)] // As for `Option::map` below.
    #[inline(always)]
    fn each(self, test: impl Fn(&Ray) -> Option<(f64, u32)>) {
        let Meet { rays, limit, met, range, .. } = self;
        for i in range.start..range.end.min(CAPACITY) {
            (met.t[i], met.primitive[i]) = match test(&rays.get(i, limit[i])) {
                Some((t, primitive)) => (t, primitive),
                None => (f64::NAN, 0),
            };
        }
    }
}

/// `Option::map` is not inlined always.
macro_rules! whole {
    ($t:expr) => {
        match $t {
            Some(t) => Some((t, 0)),
            None => None,
        }
    };
}

impl<K: TreeKernels> Task for Meet<'_, K> {
    #[inline(always)]
    fn run(self) {
        let object_from_world = self.object.map.inverse;
        match self.object.shape {
            Shape::Ball { centre, radius } => self.each(|ray| whole!(K::sphere(ray, centre, radius))),
            Shape::Ellipsoid => {
                self.each(|ray| whole!(K::sphere(&ray.transformed(&object_from_world), DVec3::ZERO, 1.0)));
            }
            Shape::Cuboid => self.each(|ray| K::cuboid(&ray.transformed(&object_from_world))),
            Shape::Cylinder => self.each(|ray| K::cylinder(&ray.transformed(&object_from_world))),
            Shape::Cone => self.each(|ray| K::cone(&ray.transformed(&object_from_world))),
            Shape::Plane => self.each(|ray| whole!(K::plane(&ray.transformed(&object_from_world)))),
            Shape::Quad => self.each(|ray| whole!(K::quad(&ray.transformed(&object_from_world)))),
            Shape::Mesh(_) => {}
        }
    }
}

/// Takes the hits with an object that are the best so far, as [`Packet::offer`] does.
struct Keep<'a> {
    rays: &'a Rays,
    best: &'a mut Best,
    met: &'a Met,
    range: Range<usize>,
    object: u32,
}

impl Task for Keep<'_> {
    #[inline(always)]
    fn run(self) {
        let Keep { rays, best, met, range, object } = self;
        for i in range.start..range.end.min(CAPACITY) {
            let hit = Hit { t: met.t[i], object, primitive: met.primitive[i], u: 0.0, v: 0.0 };
            let old = Hit { t: best.t[i], object: best.object[i], primitive: best.primitive[i], u: 0.0, v: 0.0 };
            let wins = hit.beats(&old);
            best.t[i] = if wins { hit.t } else { old.t };
            best.object[i] = if wins { object } else { old.object };
            best.primitive[i] = if wins { hit.primitive } else { old.primitive };
            best.u[i] = if wins { 0.0 } else { best.u[i] };
            best.v[i] = if wins { 0.0 } else { best.v[i] };
            best.limit[i] = if wins { hit.reach().min(rays.t_max[i]) } else { best.limit[i] };
        }
    }
}

/// Calls `visit` with the runs of groups in which any ray is marked.
fn runs(near: &[u8], mut visit: impl FnMut(Range<usize>)) {
    let mut start = None;
    for (group, marks) in near.chunks_exact(GROUP).enumerate() {
        match (marks.iter().any(|&mark| mark != 0), start) {
            (true, None) => start = Some(group),
            (false, Some(first)) => {
                visit(first * GROUP..group * GROUP);
                start = None;
            }
            _ => {}
        }
    }
    if let Some(first) = start {
        visit(first * GROUP..near.len());
    }
}

impl Scene {
    /// For each ray what [`Scene::intersect`] gives, to the last bit; quicker where rays run alike.
    pub fn intersect_packet<K: TreeKernels>(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        scratch: &mut PacketScratch,
    ) {
        if !self.is_simple::<K>() {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.intersect::<K>(ray);
            }
            return;
        }
        let packet = scratch.room.get_or_insert_with(Packet::new);
        for (rays, hits) in rays.chunks(CAPACITY).zip(hits.chunks_mut(CAPACITY)) {
            let count = packet.load(rays);
            for (index, object) in (0..).zip(self.objects()) {
                self.meet::<K, false>(packet, count, index, object);
            }
            for (i, hit) in hits.iter_mut().enumerate() {
                *hit = packet.hit(i);
            }
        }
    }

    /// For each ray what [`Scene::occluded`] gives.
    pub fn occluded_packet<K: TreeKernels>(&self, rays: &[Ray], occluded: &mut [bool], scratch: &mut PacketScratch) {
        if !self.is_simple::<K>() {
            for (ray, occluded) in rays.iter().zip(occluded) {
                *occluded = self.occluded::<K>(ray);
            }
            return;
        }
        let packet = scratch.room.get_or_insert_with(Packet::new);
        for (rays, occluded) in rays.chunks(CAPACITY).zip(occluded.chunks_mut(CAPACITY)) {
            let count = packet.load(rays);
            for (index, object) in (0..).zip(self.objects()) {
                self.meet::<K, true>(packet, count, index, object);
            }
            for (i, occluded) in occluded.iter_mut().enumerate() {
                *occluded = packet.best.object[i] != u32::MAX;
            }
        }
    }

    /// Whether asking one object after the other is quicker than the tree, and finds the same.
    fn is_simple<K: TreeKernels>(&self) -> bool {
        K::CONSERVATIVE && self.geometry.objects.len() <= FEW
    }

    /// Meets a packet with one object.
    fn meet<K: TreeKernels, const ANY_HIT: bool>(
        &self,
        packet: &mut Packet,
        count: usize,
        index: u32,
        object: &Object,
    ) {
        let tree = &self.geometry.tree;
        let Packet { rays, best, near, met } = packet;
        let (centre, radius) = self.geometry.spheres[index as usize];
        if radius < f64::INFINITY {
            tree.run(Pass { rays, limit: &best.limit, near, count, centre, radius, error: object.error_scale });
        } else {
            near[..count].fill(1);
        }
        if let Shape::Mesh(_) = object.shape {
            for i in 0..count {
                if packet.near[i] == 0 {
                    continue;
                }
                let ray = packet.rays.get(i, packet.best.limit[i]);
                if ANY_HIT {
                    if object.occluded::<K>(&ray) {
                        (packet.best.object[i], packet.best.limit[i]) = (index, DONE);
                    }
                } else if let Some(hit) = object.intersect::<K>(&ray, index) {
                    packet.offer(i, hit);
                }
            }
            return;
        }
        runs(&near[..count], |range| {
            let limit = &best.limit;
            tree.run(Meet::<K> { rays, limit, met, range: range.clone(), object, kernels: PhantomData });
            if ANY_HIT {
                for i in range {
                    if !met.t[i].is_nan() {
                        (best.object[i], best.limit[i]) = (index, DONE);
                    }
                }
            } else {
                tree.run(Keep { rays, best, met, range, object: index });
            }
        });
    }
}
