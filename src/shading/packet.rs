//! Room for packets of rays and what they meet.

use super::lit::{Beams, Lit};
use super::onward::Onward;
use super::tail::Tail;
use crate::bvh::{PACKET, RayPacket};
use crate::geometry::Hit;
use crate::math::Rgb;
use crate::scene::{Inside, MediumStack, PacketScratch, Surfaces, Way};
use glam::DVec3;

/// Room that tracing needs; kept by whoever traces, so that tracing takes no memory once the room has grown.
#[derive(Debug, Default)]
pub struct Scratch<R = ()> {
    /// One a depth.
    pub(super) levels: Vec<Level>,
    pub(super) lighting: Lighting,
    pub(super) onward: Box<Onward>,
    pub(super) packets: PacketScratch,
    pub(super) surfaces: Surfaces,
    /// One a sample.
    pub(super) tails: Vec<Tail>,
    /// Hears what is traced.
    pub(super) recorder: R,
}

/// What lies between the eye and the start of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// The sample that it serves.
    pub sample: u32,
    /// The ray that it comes from, in the packet one level up.
    pub parent: u32,
    /// Which way it has gone: 1 at the eye, then twice that of the ray that it comes from, and 1 more if it is
    /// refracted. (Of long paths the last bits.)
    pub way: u32,
    /// Weight in the radiance of that ray.
    pub share: f64,
    /// Product of all shares (shares of what there is, where a material gives back more than it gets).
    pub weight: f64,
}

/// Rays of one depth and what comes back along them.
#[derive(Debug, Default)]
pub(super) struct Level {
    /// Last come those that are inside of a body where they meet nothing else.
    pub rays: Box<RayPacket>,
    /// How many come before.
    pub outside: usize,
    pub paths: Vec<Path>,
    /// The transparent bodies that each ray starts in; empty in scenes without.
    pub media: Vec<MediumStack>,
    pub hits: Vec<Option<Hit>>,
    /// The transparent bodies behind the surface that each ray ends on, if light gets there; empty in scenes without.
    pub beyond: Vec<Option<MediumStack>>,
    /// Radiance along each ray, as far as it is known.
    pub sums: Vec<Rgb>,
    pub branches: Branches,
    /// Where its rays are taken from.
    picks: Vec<u16>,
}

/// Rays that go on from a packet, mirrored and refracted ones together: apart they would be few, and half as many at
/// every depth.
#[derive(Debug, Default)]
pub(super) struct Branches {
    /// By slot of the surfaces that they come from.
    pub mirrored: Box<RayPacket>,
    /// The same.
    pub refracted: Box<RayPacket>,
    pub paths: Vec<Path>,
    /// Where each is: its slot, and 256 more among the refracted ones.
    picks: Vec<u16>,
    /// In which order they are taken: by octant, and at last those that meet nothing but the body that they are inside
    /// of.
    kinds: Vec<u8>,
    /// Numbers of them in the order that they are taken in.
    order: Vec<u16>,
    /// The same before they are sorted.
    unsorted: Vec<u16>,
    /// How many go into each packet.
    packets: Vec<usize>,
    /// What comes back along mirrored and along refracted rays, by the ray that they come from.
    sums: [Vec<Rgb>; 2],
}

/// Kind of the rays that meet nothing but the body that they are inside of.
const INSIDE: u8 = 8;

/// Surfaces that a packet of rays meets, and the light that falls on them.
#[derive(Debug, Default)]
pub(super) struct Lighting {
    pub lit: Box<Lit>,
    /// From the light in question.
    pub beams: Box<Beams>,
    /// The surfaces that a shadow ray is traced for.
    pub asked: Vec<u16>,
    /// Those for which none is, and what their beams may be wrong by, as radiance of the sample.
    pub unasked: Vec<(u16, f64)>,
    pub occluded: Vec<bool>,
    /// The bodies that shadow rays start in.
    pub inside: Vec<Inside>,
    /// As far as glass lets light through.
    pub ways: Vec<Way>,
    /// With transparent objects along a shadow ray.
    pub glass: Vec<Hit>,
    /// Light that was not asked for, by sample: what it would bring to the sample, were all lit. Empty if none is to be
    /// spared.
    pub spent: Vec<f64>,
}

impl<R> Scratch<R> {
    /// Empty room, and a recorder.
    pub(super) fn with(recorder: R) -> Self {
        Self {
            levels: Vec::new(),
            lighting: Lighting::default(),
            onward: Box::default(),
            packets: PacketScratch::default(),
            surfaces: Surfaces::default(),
            tails: Vec::new(),
            recorder,
        }
    }
}

impl Path {
    /// From the eye.
    pub fn of(sample: u32) -> Self {
        Self { sample, parent: 0, way: 1, share: 1.0, weight: 1.0 }
    }

    /// Whether the ray has been refracted, and not mirrored, at its start.
    pub fn is_refracted(&self) -> bool {
        self.way & 1 != 0
    }
}

/// Which of the eight octants of directions a ray runs in.
fn octant(direction: DVec3) -> u8 {
    direction.is_negative_bitmask() as u8
}

impl Branches {
    /// Forgets what was there. `rays`: how many they come from.
    pub fn clear(&mut self, rays: usize) {
        self.paths.clear();
        self.picks.clear();
        self.kinds.clear();
        self.order.clear();
        self.packets.clear();
        for sums in &mut self.sums {
            sums.clear();
            sums.resize(rays, Rgb::BLACK);
        }
    }

    /// Takes in a ray in this direction from the surface in a slot. `inside`: whether it meets nothing but the body
    /// that it is inside of.
    pub fn push(&mut self, slot: usize, direction: DVec3, path: Path, inside: bool) {
        self.picks.push(slot as u16 + if path.is_refracted() { PACKET as u16 } else { 0 });
        self.paths.push(path);
        self.kinds.push(if inside { INSIDE } else { octant(direction) });
    }

    /// Brings them in order, and tells how many packets they are. Rays of one octant of directions come together, so
    /// that they stay together in the tree. All rays of a sample are in one packet, unless they are more than go into
    /// one: so in which order they are traced does not depend on what else is traced with them.
    pub fn sort(&mut self) -> usize {
        let count = self.paths.len();
        self.order.extend(0..count as u16);
        if count <= PACKET {
            self.packets.push(count);
            sort_by_kind(&mut self.order, &self.kinds, &mut self.unsorted);
        } else {
            let Self { order, unsorted, paths, kinds, packets, .. } = self;
            order.sort_by_key(|&number| paths[usize::from(number)].sample);
            let mut start = 0;
            while start < count {
                // As many whole samples as go into a packet; of a larger one its own rays in their order.
                let sample = |at: usize| paths[usize::from(order[at])].sample;
                let mut end = (start + PACKET).min(count);
                if end < count && sample(start) != sample(end) {
                    while sample(end - 1) == sample(end) {
                        end -= 1;
                    }
                } else if end < count {
                    // A sample that is too large.
                    end = (start..count).find(|&at| sample(at) != sample(start)).unwrap_or(count);
                }
                sort_by_kind(&mut order[start..end], kinds, unsorted);
                packets.extend((start..end).step_by(PACKET).map(|at| PACKET.min(end - at)));
                start = end;
            }
        }
        self.packets.len()
    }

    /// Adds what has come back along them.
    pub fn add(&self, sums: &mut [Rgb]) {
        let [mirrored, refracted] = &self.sums;
        for (sum, (&mirrored, &refracted)) in sums.iter_mut().zip(mirrored.iter().zip(refracted)) {
            *sum = *sum + mirrored + refracted;
        }
    }
}

/// Sorts numbers by kind; equal kinds stay in order. `room`: for a copy.
fn sort_by_kind(order: &mut [u16], kinds: &[u8], room: &mut Vec<u16>) {
    room.clear();
    room.extend_from_slice(order);
    let mut starts = [0; INSIDE as usize + 2];
    for &number in &*room {
        starts[usize::from(kinds[usize::from(number)]) + 1] += 1;
    }
    for kind in 1..starts.len() {
        starts[kind] += starts[kind - 1];
    }
    for &number in &*room {
        let at = &mut starts[usize::from(kinds[usize::from(number)])];
        order[*at] = number;
        *at += 1;
    }
}

impl Level {
    /// Makes room for a packet of rays and takes away what was there.
    pub fn clear(&mut self) {
        self.rays.set_len(0);
        self.paths.clear();
        self.media.clear();
    }

    /// Takes one of the packets of rays that go on from another level.
    pub fn take(&mut self, from: &mut Level, packet: usize) {
        self.clear();
        let Level { branches, media, beyond, .. } = from;
        let start = branches.packets[..packet].iter().sum();
        let order = &branches.order[start..][..branches.packets[packet]];
        self.picks.clear();
        self.picks.extend(order.iter().map(|&number| branches.picks[usize::from(number)]));
        self.rays.take([&branches.mirrored, &branches.refracted], &self.picks);
        self.paths.extend(order.iter().map(|&number| branches.paths[usize::from(number)]));
        let is_inside = |number: &u16| branches.kinds[usize::from(*number)] == INSIDE;
        self.outside = order.iter().position(is_inside).unwrap_or(order.len());
        if !media.is_empty() {
            self.media.extend(self.paths.iter().map(|path| {
                let parent = path.parent as usize;
                beyond[parent].filter(|_| path.is_refracted()).unwrap_or(media[parent])
            }));
        }
    }

    /// Gives back what its rays see to the level that they come from.
    pub fn give(&self, to: &mut Branches) {
        for (path, &sum) in self.paths.iter().zip(&self.sums) {
            to.sums[usize::from(path.is_refracted())][path.parent as usize] = sum * path.share;
        }
    }
}
