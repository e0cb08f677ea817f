//! Room for packets of rays and what they meet.

use super::lit::{Beams, Lit};
use super::media::Media;
use super::onward::Onward;
use super::tail::Tail;
use crate::bvh::{PACKET, RayPacket};
use crate::geometry::Hit;
use crate::math::Rgb;
use crate::scene::{Inside, PacketScratch, Surfaces, Way};
use glam::DVec3;

/// Room that tracing needs; kept by whoever traces, so that tracing takes no memory once the room has grown.
#[derive(Debug, Default)]
pub struct Scratch<R = ()> {
    /// One a depth.
    pub(super) levels: Vec<Level>,
    pub(super) lighting: Lighting,
    pub(super) onward: Box<Onward>,
    pub(super) media: Media,
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
    /// What it starts in, as a number in [`Media`]; means nothing in scenes without glass.
    pub media: u32,
    /// The ray that it comes from, in the packet one level up.
    pub parent: u32,
    /// Weight in the radiance of that ray.
    pub share: f64,
    /// Product of all shares (shares of what there is, where a material gives back more than it gets).
    pub weight: f64,
}

impl Path {
    const NONE: Self = Self { sample: 0, media: 0, parent: 0, share: 0.0, weight: 0.0 };
}

/// Rays of one depth and what comes back along them.
#[derive(Debug)]
pub(super) struct Level {
    /// Last come those that are inside of a body where they meet nothing else.
    pub rays: Box<RayPacket>,
    /// How many come before.
    pub outside: usize,
    pub paths: Vec<Path>,
    pub hits: Vec<Option<Hit>>,
    /// What is behind the surface that each ray ends on, if light gets there, as a number in [`Media`]; empty in scenes
    /// without glass.
    pub beyond: Vec<Option<u32>>,
    /// Radiance along each ray, as far as it is known.
    pub sums: Vec<Rgb>,
    pub reflected: Branches,
    pub refracted: Branches,
}

/// Rays that go on from a packet. Those of one octant of directions come together, so that they stay together in the
/// tree.
#[derive(Debug)]
pub(super) struct Branches {
    /// As in [`Level::rays`].
    rays: Box<RayPacket>,
    outside: usize,
    /// As they come in, until [`Branches::sort`].
    paths: Vec<Path>,
    sorted: Vec<Path>,
    /// The slots of the surfaces that they come from, as they come in.
    slots: Vec<u16>,
    /// The same in order.
    order: Vec<u16>,
    /// In which order they are taken: by octant, and at last those that meet nothing but the body that they are inside
    /// of.
    kinds: Vec<u8>,
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
            media: Media::default(),
            packets: PacketScratch::default(),
            surfaces: Surfaces::default(),
            tails: Vec::new(),
            recorder,
        }
    }
}

impl Default for Level {
    fn default() -> Self {
        Self {
            rays: Box::default(),
            outside: 0,
            paths: Vec::with_capacity(PACKET),
            hits: Vec::new(),
            beyond: Vec::new(),
            sums: Vec::new(),
            reflected: Branches::default(),
            refracted: Branches::default(),
        }
    }
}

impl Default for Branches {
    /// Room for a packet, since it is given to whoever follows the rays, for other room.
    fn default() -> Self {
        Self {
            rays: Box::default(),
            outside: 0,
            paths: Vec::with_capacity(PACKET),
            sorted: Vec::with_capacity(PACKET),
            slots: Vec::with_capacity(PACKET),
            order: Vec::with_capacity(PACKET),
            kinds: Vec::with_capacity(PACKET),
        }
    }
}

impl Level {
    /// Makes room for a packet of rays and takes away what was there.
    pub fn clear(&mut self) {
        self.rays.set_len(0);
        self.paths.clear();
    }

    /// Takes all branches as its packet.
    pub fn take(&mut self, branches: &mut Branches) {
        self.outside = branches.outside;
        std::mem::swap(&mut self.rays, &mut branches.rays);
        std::mem::swap(&mut self.paths, &mut branches.sorted);
    }
}

/// Which of the eight octants of directions a ray runs in.
fn octant(direction: DVec3) -> u8 {
    direction.is_negative_bitmask() as u8
}

impl Branches {
    /// Forgets what was there.
    pub fn clear(&mut self) {
        self.rays.set_len(0);
        self.outside = 0;
        self.paths.clear();
        self.sorted.clear();
        self.slots.clear();
        self.kinds.clear();
    }

    /// Takes in a ray in this direction from the surface in a slot. `inside`: whether it meets nothing but the body
    /// that it is inside of.
    pub fn push(&mut self, slot: usize, direction: DVec3, path: Path, inside: bool) {
        self.slots.push(slot as u16);
        self.paths.push(path);
        self.kinds.push(if inside { INSIDE } else { octant(direction) });
    }

    /// Brings them in order. `rays`: those of all slots.
    pub fn sort(&mut self, rays: &RayPacket) {
        let mut counts = [0; 9];
        for &kind in &self.kinds {
            counts[usize::from(kind)] += 1;
        }
        self.outside = self.kinds.len() - counts[usize::from(INSIDE)];
        let (mut starts, mut sum) = (counts, 0);
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        self.order.clear();
        self.order.resize(self.slots.len(), 0);
        self.sorted.resize(self.slots.len(), Path::NONE);
        for ((&slot, &kind), &path) in self.slots.iter().zip(&self.kinds).zip(&self.paths) {
            let at = &mut starts[usize::from(kind)];
            (self.order[*at], self.sorted[*at]) = (slot, path);
            *at += 1;
        }
        self.rays.take(rays, &self.order);
    }

    /// Drops the branches whose paths are not worth it.
    pub fn retain(&mut self, mut worth_it: impl FnMut(&Path) -> bool) {
        self.order.clear();
        self.order.extend((0..).zip(&self.sorted).filter(|(_, path)| worth_it(path)).map(|(number, _)| number));
        if self.order.len() < self.sorted.len() {
            self.outside = self.order.partition_point(|&number| usize::from(number) < self.outside);
            self.rays.keep(&self.order);
            for (to, &number) in self.order.iter().enumerate() {
                self.sorted[to] = self.sorted[usize::from(number)];
            }
            self.sorted.truncate(self.order.len());
        }
    }
}
