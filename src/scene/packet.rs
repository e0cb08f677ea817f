//! Many rays against the whole scene at once.
//!
//! In a scene of few objects every object is asked in turn, with no tree: first which rays pass its bounding sphere at
//! all, then groups of rays that do, eight or more at a time (see `front`). In trees over many objects and in meshes,
//! rays that run alike share the nodes ([`Bvh::traverse_packet`]; for objects see `crowd`). To share no more than the
//! nodes gained nothing: 1.00 of the frame's CPU time on the sphereflake, 1.02 on the field of glass balls, where
//! objects were met one ray at a time all the same. Nor did it gain to meet the meshes among many objects first and
//! together, and then go through the tree without them: 1.04 on the terrain with glass balls; nor blocks of eight balls
//! in the leaves, tested at once in f32 before the formula: for single rays 0.98 on the sphereflake, but 1.05 on the
//! terrain and on the field of glass, where the ray is prepared for few balls.

use super::body::with_body;
use super::crowd::{ANY, CLOSEST, Crowd, Found, OPAQUE, Source};
use super::front::{CAPACITY, DONE, Front, Keep, Meet, Met, Pass, ToObject};
use super::leaving::Leaving;
use super::through::{Passage, Tally};
use super::{Inside, Mesh, Object, Scene, Shape};
use crate::bvh::{BallRows, Bvh, PACKET, PacketRoom, Packets, RayPacket, RaySet, Rays, Room, TreeKernels, TriangleHit};
use crate::geometry::{Hit, Ray};
use std::cell::RefCell;
use std::marker::PhantomData;
use std::ops::Range;

/// Rays that are met or passed over together.
const GROUP: usize = 8;

/// Up to so many objects with a box, no tree is used.
const FEW: usize = 8;

/// Room that packets of rays need while they are traced; kept by whoever traces, so that tracing takes no memory.
#[derive(Debug, Default)]
pub struct PacketScratch {
    packet: Option<Box<Packet>>,
    /// For the tree over objects.
    in_tree: Option<Box<Room<BallRows>>>,
    /// For rays inside of bodies.
    pub(super) leaving: Box<Leaving>,
}

/// What is in the way of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// Nothing.
    Clear,
    /// Something opaque.
    Blocked,
    /// Glass that lets this part of the light through.
    Part(f64),
    /// Nothing opaque, but something that may let light through.
    Glass,
    /// Not known.
    Unknown,
}

#[derive(Debug)]
pub(super) struct Packet {
    pub front: Front,
    /// Weights of the corners where the hit is on a mesh.
    corners: [[f64; 2]; CAPACITY],
    /// Which rays may meet the object in question.
    pub near: [u8; CAPACITY],
    /// Where they do.
    pub met: Met,
    /// How they pass it.
    pub passages: [Passage; CAPACITY],
    in_mesh: InMesh,
    /// What shadow rays pass.
    pub tally: Tally,
}

/// The rays of a packet that are near a mesh.
#[derive(Debug, Default)]
struct InMesh {
    /// In its space.
    rays: Box<RayPacket>,
    /// Their numbers in the packet.
    numbers: Vec<u16>,
    room: PacketRoom,
}

impl InMesh {
    /// Takes those of the first `count` rays that are near.
    fn take(&mut self, tree: &Bvh, count: usize, object: &Object, front: &Front, near: &[u8; CAPACITY]) {
        let inverse = object.map.inverse;
        runs(&near[..count], |range| tree.run(ToObject { range, inverse }, front, &mut self.rays.rows));
        self.numbers.clear();
        self.numbers.extend((0..).zip(&near[..count]).filter(|(_, near)| **near != 0).map(|(number, _)| number));
        self.rays.set_len(count);
        self.rays.keep(&self.numbers);
    }
}

impl Packet {
    fn new() -> Box<Self> {
        let (zero, none) = ([0.0; CAPACITY], [0; CAPACITY]);
        Box::new(Self {
            front: Front {
                origin: [zero; 3],
                direction: [zero; 3],
                t_min: zero,
                limit: zero,
                t_max: zero,
                t: zero,
                object: none,
                primitive: none,
                tied: [0; CAPACITY],
            },
            corners: [[0.0; 2]; CAPACITY],
            near: [0; CAPACITY],
            met: Met::default(),
            passages: [Passage::Misses; CAPACITY],
            in_mesh: InMesh::default(),
            tally: Tally::NEW,
        })
    }

    /// Takes rays in. Returns their number, rounded up to whole groups; what fills the last one up meets nothing.
    fn load<S: Rays + ?Sized>(&mut self, rays: &S) -> usize {
        let (to, count) = (&mut self.front, rays.count().min(CAPACITY));
        let padded = count.next_multiple_of(GROUP);
        if S::IN_ROWS {
            let Front { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max, .. } = to;
            (0..count).for_each(|i| ox[i] = rays.ray(i).origin.x);
            (0..count).for_each(|i| oy[i] = rays.ray(i).origin.y);
            (0..count).for_each(|i| oz[i] = rays.ray(i).origin.z);
            (0..count).for_each(|i| dx[i] = rays.ray(i).direction.x);
            (0..count).for_each(|i| dy[i] = rays.ray(i).direction.y);
            (0..count).for_each(|i| dz[i] = rays.ray(i).direction.z);
            (0..count).for_each(|i| t_min[i] = rays.ray(i).t_min);
            (0..count).for_each(|i| t_max[i] = rays.ray(i).t_max);
        } else {
            for i in 0..count {
                let ray = rays.ray(i);
                for axis in 0..3 {
                    to.origin[axis][i] = ray.origin[axis];
                    to.direction[axis][i] = ray.direction[axis];
                }
                (to.t_min[i], to.t_max[i]) = (ray.t_min, ray.t_max);
            }
        }
        for i in count..padded {
            for axis in 0..3 {
                to.origin[axis][i] = to.origin[axis][0];
                to.direction[axis][i] = to.direction[axis][0];
            }
            (to.t_min[i], to.t_max[i]) = (to.t_min[0], DONE);
        }
        to.limit[..padded].copy_from_slice(&to.t_max[..padded]);
        to.t[..padded].fill(f64::INFINITY);
        to.object[..padded].fill(u32::MAX);
        to.primitive[..padded].fill(u32::MAX);
        to.tied[..padded].fill(0);
        padded
    }

    pub fn hit(&self, i: usize, objects: &[Object]) -> Option<Hit> {
        let Front { t, object, primitive, .. } = &self.front;
        let shape = &objects.get(object[i] as usize)?.shape;
        let [u, v] = if let Shape::Mesh(_) = shape { self.corners[i] } else { [0.0; 2] };
        Some(Hit { t: t[i], object: object[i], primitive: primitive[i], u, v })
    }

    /// Meets a mesh with those of the first `count` rays that are near. `tree`: the scene's.
    pub fn meet_mesh<K: TreeKernels, const ANY_HIT: bool>(
        &mut self,
        tree: &Bvh,
        count: usize,
        (index, object): (u32, &Object),
        mesh: &Mesh,
    ) {
        let Self { in_mesh, front, near, corners, .. } = self;
        in_mesh.take(tree, count, object, front, near);
        let InMesh { rays, numbers, room } = in_mesh;
        let number = |k: usize| usize::from(numbers[k]);
        if ANY_HIT {
            mesh.occluded_packet::<K>(&rays.all(), room, |k| {
                (front.object[number(k)], front.limit[number(k)]) = (index, DONE);
            });
        } else {
            mesh.intersect_packet::<K>(&rays.all(), room, |k, hit| {
                if let Some(TriangleHit { t, triangle, u, v }) = hit {
                    offer(front, corners, number(k), Hit { t, object: index, primitive: triangle, u, v });
                }
            });
        }
    }

    /// Tells which of the rays that are near meet a mesh, and ends none.
    pub fn look_along_mesh<K: TreeKernels>(
        &mut self,
        tree: &Bvh,
        count: usize,
        object: &Object,
        mesh: &Mesh,
        mut meets: impl FnMut(usize),
    ) {
        self.in_mesh.take(tree, count, object, &self.front, &self.near);
        let InMesh { rays, numbers, room } = &mut self.in_mesh;
        mesh.occluded_packet::<K>(&rays.all(), room, |k| meets(numbers[k].into()));
    }

    /// Takes a hit of ray `i` if it is the best one.
    pub fn offer(&mut self, i: usize, hit: Hit) {
        offer(&mut self.front, &mut self.corners, i, hit);
    }
}

/// Takes a hit of ray `i` if it is the best one.
fn offer(best: &mut Front, corners: &mut [[f64; 2]; CAPACITY], i: usize, hit: Hit) {
    let old = Hit { t: best.t[i], object: best.object[i], primitive: best.primitive[i], u: 0.0, v: 0.0 };
    best.tied[i] |= u8::from(hit.ties(&old) & (old.object != u32::MAX));
    if hit.beats(&old) {
        (best.t[i], best.object[i], best.primitive[i]) = (hit.t, hit.object, hit.primitive);
        best.limit[i] = hit.reach().min(best.t_max[i]);
        corners[i] = [hit.u, hit.v];
    }
}

/// Finds where a range of rays meets an analytic shape.
pub(super) fn meet_shape<K: TreeKernels>(
    tree: &Bvh,
    object: &Object,
    range: Range<usize>,
    front: &Front,
    met: &mut Met,
) {
    let kernels = PhantomData::<K>;
    with_body!(object, |body| tree.run(Meet { range, body, kernels }, front, met));
}

/// Calls `visit` with the runs of groups in which any ray is marked.
pub(super) fn runs(near: &[u8], mut visit: impl FnMut(Range<usize>)) {
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
    /// For each of up to [`PACKET`] rays what [`Scene::intersect`] gives, to the last bit but for what
    /// [`Packets`](crate::bvh::Packets) says of meshes; quicker where rays run alike.
    pub fn intersect_packet<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        hits: &mut [Option<Hit>],
        scratch: &mut PacketScratch,
    ) {
        assert!(rays.count() <= hits.len().min(PACKET), "one packet of rays");
        if !self.is_simple() {
            return self.intersect_crowd::<K>(rays, hits, scratch);
        }
        let packet = scratch.packet.get_or_insert_with(Packet::new);
        let count = packet.load(rays);
        for (index, object) in (0..).zip(self.objects()) {
            self.meet::<K, false>(packet, count, index, object);
        }
        for (i, hit) in hits[..rays.count()].iter_mut().enumerate() {
            *hit = packet.hit(i, self.objects());
        }
    }

    /// For each of up to [`PACKET`] rays what [`Scene::occluded`] gives.
    pub fn occluded_packet<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        occluded: &mut [bool],
        scratch: &mut PacketScratch,
    ) {
        assert!(rays.count() <= occluded.len().min(PACKET), "one packet of rays");
        if !self.is_simple() {
            let mut last = None;
            let left = self.trace_crowd::<K, ANY>(rays, &[], scratch, |i, found| occluded[i] = found.ended);
            left.each(|i| occluded[i] = self.occluded_again::<K>(&rays.ray(i), &mut last));
            return;
        }
        let packet = scratch.packet.get_or_insert_with(Packet::new);
        let count = packet.load(rays);
        for (index, object) in (0..).zip(self.objects()) {
            self.meet::<K, true>(packet, count, index, object);
        }
        for (i, occluded) in occluded[..rays.count()].iter_mut().enumerate() {
            *occluded = packet.front.object[i] != u32::MAX;
        }
    }

    /// [`Scene::intersect_packet`] through the tree.
    fn intersect_crowd<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        hits: &mut [Option<Hit>],
        scratch: &mut PacketScratch,
    ) {
        let mut tied = RaySet::NONE;
        let left = self.trace_crowd::<K, CLOSEST>(rays, &[], scratch, |i, found| {
            hits[i] = found.hit;
            if found.tied {
                tied.insert(i);
            }
        });
        left.with(&tied).each(|i| hits[i] = self.intersect::<K>(&rays.ray(i)));
    }

    /// Traces up to [`PACKET`] rays through the tree, those together that run alike. Returns those that are left.
    fn trace_crowd<K: TreeKernels, const SEARCH: u8>(
        &self,
        rays: &(impl Rays + ?Sized),
        inside: &[Inside],
        scratch: &mut PacketScratch,
        mut take: impl FnMut(usize, Found),
    ) -> RaySet {
        if K::PACKETS != Some(Packets::Watertight) {
            return RaySet::first(rays.count());
        }
        let PacketScratch { packet, in_tree, .. } = scratch;
        let packet = RefCell::new(&mut **packet.get_or_insert_with(Packet::new));
        let (source, room) = (Source { scene: self, packet, inside }, in_tree.get_or_insert_default());
        self.geometry.tree.traverse_packet::<Crowd<K, SEARCH>, _>(rays, &source, room, &mut take)
    }

    /// Whether a ray meets anything, asked first of the object that was last in the way of one like it. Where what is
    /// found depends on the way through the tree, that would change the answer.
    fn occluded_again<K: TreeKernels>(&self, ray: &Ray, last: &mut Option<u32>) -> bool {
        let again = |index: u32| K::CONSERVATIVE && self.objects()[index as usize].is_occluded_quickly::<K>(ray);
        if last.is_some_and(again) {
            return true;
        }
        let occluder = self.occluder::<K>(ray);
        *last = occluder.or(*last);
        occluder.is_some()
    }

    /// For each of up to [`PACKET`] rays what is in its way, as far as can be told without following it through glass.
    /// `inside`: what each starts in.
    pub fn look_along_packet<K: TreeKernels>(
        &self,
        rays: &(impl Rays + ?Sized),
        inside: &[Inside],
        ways: &mut [Way],
        scratch: &mut PacketScratch,
    ) {
        assert!(rays.count() <= ways.len().min(inside.len()).min(PACKET), "one packet of rays");
        if !self.is_simple() {
            ways.fill(Way::Unknown);
            self.trace_crowd::<K, OPAQUE>(rays, inside, scratch, |i, found| {
                ways[i] = if found.ended { Way::Blocked } else { found.way };
            });
            return;
        }
        let packet = scratch.packet.get_or_insert_with(Packet::new);
        let count = packet.load(rays);
        self.look_along_few::<K>(packet, count, &inside[..rays.count()], &mut ways[..rays.count()]);
    }

    /// Whether all objects are asked one after the other, with no tree: quicker for few.
    pub(super) fn is_simple(&self) -> bool {
        self.geometry.objects.len() <= FEW
    }

    /// Finds out which rays of a packet may meet an object.
    pub(super) fn near_in_packet(&self, packet: &mut Packet, count: usize, index: u32, object: &Object) {
        let (centre, radius) = self.geometry.spheres[index as usize];
        if radius < f64::INFINITY {
            let pass = Pass { count, centre, radius, error: object.error_scale };
            self.geometry.tree.run(pass, &packet.front, &mut packet.near);
        } else {
            packet.near[..count].fill(1);
        }
    }

    /// Meets a packet with one object.
    pub(super) fn meet<K: TreeKernels, const ANY_HIT: bool>(
        &self,
        packet: &mut Packet,
        count: usize,
        index: u32,
        object: &Object,
    ) {
        self.near_in_packet(packet, count, index, object);
        let tree = &self.geometry.tree;
        let Packet { front, near, met, .. } = packet;
        if let Shape::Mesh(mesh) = &object.shape {
            return packet.meet_mesh::<K, ANY_HIT>(&self.geometry.tree, count, (index, object), mesh);
        }
        runs(&near[..count], |range| {
            meet_shape::<K>(tree, object, range.clone(), front, met);
            if !K::CONSERVATIVE {
                // A ray alone is not asked where it passes by, and the shape might say yes all the same.
                for i in range.clone().filter(|&i| near[i] == 0) {
                    met.t[i] = f64::NAN;
                }
            }
            tree.run(Keep::<ANY_HIT> { range, object: index }, met, front);
        });
    }
}
