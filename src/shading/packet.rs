//! Room for packets of rays and what they meet.

use super::lit::{Beams, Lit};
use super::onward::Onward;
use super::tail::Tail;
use crate::bvh::{PACKET, RayPacket};
use crate::geometry::{Hit, Ray};
use crate::math::Rgb;
use crate::scene::{Inside, MediumStack, PacketScratch, Surfaces, Way};

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
    pub reflected: Branches,
    pub refracted: Branches,
    /// Numbers of branches in the order that they are taken in.
    order: Vec<u16>,
}

/// Rays that go on from a packet.
#[derive(Debug, Default)]
pub(super) struct Branches {
    rays: Box<RayPacket>,
    paths: Vec<Path>,
    /// As in [`Level::media`].
    media: Vec<MediumStack>,
    /// In which order they are taken: by octant, and at last those that meet nothing but the body that they are inside
    /// of.
    kinds: Vec<u8>,
    /// How many rays there are of each kind.
    counts: [usize; 9],
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

impl Level {
    /// Makes room for a packet of rays and takes away what was there.
    pub fn clear(&mut self) {
        self.rays.set_len(0);
        self.paths.clear();
        self.media.clear();
    }

    /// Takes all branches as its packet. Rays of one octant of directions come together, so that they stay together in
    /// the tree.
    pub fn take(&mut self, branches: &mut Branches) {
        self.clear();
        let count = branches.paths.len();
        self.outside = count - branches.counts[usize::from(INSIDE)];
        let mut starts = branches.counts;
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        self.order.clear();
        self.order.resize(count, 0);
        for (number, &kind) in (0..).zip(&branches.kinds) {
            let start = &mut starts[usize::from(kind)];
            self.order[*start] = number;
            *start += 1;
        }
        self.rays.take(&branches.rays, &self.order);
        let order = self.order.iter().map(|&number| usize::from(number));
        self.paths.extend(order.clone().map(|number| branches.paths[number]));
        if !branches.media.is_empty() {
            self.media.extend(order.map(|number| branches.media[number]));
        }
        branches.clear();
    }
}

/// Which of the eight octants of directions a ray runs in.
fn octant(ray: &Ray) -> u8 {
    ray.direction.is_negative_bitmask() as u8
}

impl Branches {
    /// `inside`: whether the ray meets nothing but the body that it is inside of.
    pub fn push(&mut self, ray: &Ray, path: Path, media: Option<&MediumStack>, inside: bool) {
        let kind = if inside { INSIDE } else { octant(ray) };
        self.counts[usize::from(kind)] += 1;
        self.kinds.push(kind);
        debug_assert!(self.paths.len() < PACKET, "a ray sends on one of a kind");
        self.rays.put(self.paths.len(), ray);
        self.paths.push(path);
        self.media.extend(media);
    }

    /// Drops the branches whose paths are not worth it.
    pub fn retain(&mut self, mut worth_it: impl FnMut(&Path) -> bool) {
        let mut kept = 0;
        for k in 0..self.paths.len() {
            if worth_it(&self.paths[k]) {
                if kept < k {
                    self.rays.put(kept, &self.rays.ray(k));
                    self.paths[kept] = self.paths[k];
                    (self.media[kept], self.kinds[kept]) = (self.media[k], self.kinds[k]);
                }
                kept += 1;
            } else {
                self.counts[usize::from(self.kinds[k])] -= 1;
            }
        }
        self.paths.truncate(kept);
        self.media.truncate(kept);
        self.kinds.truncate(kept);
    }

    fn clear(&mut self) {
        self.paths.clear();
        self.media.clear();
        self.kinds.clear();
        self.counts = [0; 9];
    }
}
