//! Room for packets of rays and what they meet.

use super::tail::Tail;
use crate::geometry::{Hit, Ray, ShadowStart};
use crate::math::Rgb;
use crate::scene::{Inside, MediumStack, PacketScratch, Surfaces, Way};
use glam::DVec3;

/// Room that tracing needs; kept by whoever traces, so that tracing takes no memory once the room has grown.
#[derive(Debug, Default)]
pub struct Scratch<R = ()> {
    /// One a depth.
    pub(super) levels: Vec<Level>,
    pub(super) lighting: Lighting,
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
    pub rays: Vec<Ray>,
    /// How many come before.
    pub outside: usize,
    pub paths: Vec<Path>,
    /// The transparent bodies that each ray starts in; empty in scenes without.
    pub media: Vec<MediumStack>,
    pub hits: Vec<Option<Hit>>,
    /// The transparent bodies behind the surface that each ray ends on, if light gets there; empty in scenes without.
    pub beyond: Vec<Option<MediumStack>>,
    /// Numbers of the rays that end on surfaces which light goes on from.
    pub onward: Vec<u32>,
    /// Radiance along each ray, as far as it is known.
    pub sums: Vec<Rgb>,
    pub reflected: Branches,
    pub refracted: Branches,
    /// Numbers of branches in the order that they are taken in.
    order: Vec<u32>,
}

/// Rays that go on from a packet.
#[derive(Debug, Default)]
pub(super) struct Branches {
    rays: Vec<Ray>,
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
    pub surfaces: Vec<Surface>,
    /// From the light in question: first those that a shadow ray is traced for.
    pub beams: Vec<Beam>,
    /// Those for which none is.
    pub unasked: Vec<Beam>,
    /// Toward the light, one a beam.
    pub shadow_rays: Vec<Ray>,
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

/// A surface that light can fall on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// Of the ray that meets it, in its packet.
    pub index: u32,
    /// Of the material in the scene.
    pub material: u32,
    /// The bodies that are around it on the viewer's side.
    pub inside: Inside,
    pub point: DVec3,
    pub shadow_start: ShadowStart,
    /// Unit, on the viewer's side.
    pub normal: DVec3,
    /// Unit, toward the viewer.
    pub view: DVec3,
    pub color: Rgb,
}

/// Light on its way to a surface in front of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    pub surface: u32,
    /// Unit, toward the light.
    pub direction: DVec3,
    /// Of the angle to the normal.
    pub cosine: f64,
    pub radiance: Rgb,
    /// The part of it that arrives.
    pub part: f64,
    /// If no shadow ray is traced: by how much that part may be wrong, as radiance of the sample.
    pub doubt: Option<f64>,
}

impl<R> Scratch<R> {
    /// Empty room, and a recorder.
    pub(super) fn with(recorder: R) -> Self {
        Self {
            levels: Vec::new(),
            lighting: Lighting::default(),
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
        self.rays.clear();
        self.paths.clear();
        self.media.clear();
    }

    /// Takes all branches as its packet. Rays of one octant of directions come together, so that they stay together in
    /// the tree.
    pub fn take(&mut self, branches: &mut Branches) {
        self.clear();
        self.outside = branches.rays.len() - branches.counts[usize::from(INSIDE)];
        if branches.counts.contains(&branches.rays.len()) {
            // In order as they are. (Changing places with them would let both grow again and again.)
            self.rays.extend_from_slice(&branches.rays);
            self.paths.extend_from_slice(&branches.paths);
            self.media.extend_from_slice(&branches.media);
        } else {
            let mut starts = branches.counts;
            let mut sum = 0;
            for start in &mut starts {
                sum += std::mem::replace(start, sum);
            }
            self.order.clear();
            self.order.resize(branches.rays.len(), 0);
            for (number, &kind) in (0..).zip(&branches.kinds) {
                let start = &mut starts[usize::from(kind)];
                self.order[*start] = number;
                *start += 1;
            }
            let order = self.order.iter().map(|&number| number as usize);
            self.rays.extend(order.clone().map(|number| branches.rays[number]));
            self.paths.extend(order.clone().map(|number| branches.paths[number]));
            if !branches.media.is_empty() {
                self.media.extend(order.map(|number| branches.media[number]));
            }
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
    pub fn push(&mut self, ray: Ray, path: Path, media: Option<&MediumStack>, inside: bool) {
        let kind = if inside { INSIDE } else { octant(&ray) };
        self.counts[usize::from(kind)] += 1;
        self.kinds.push(kind);
        self.rays.push(ray);
        self.paths.push(path);
        self.media.extend(media);
    }

    /// Drops the branches whose paths are not worth it.
    pub fn retain(&mut self, mut worth_it: impl FnMut(&Path) -> bool) {
        let mut kept = 0;
        for k in 0..self.rays.len() {
            if worth_it(&self.paths[k]) {
                if kept < k {
                    (self.rays[kept], self.paths[kept]) = (self.rays[k], self.paths[k]);
                    (self.media[kept], self.kinds[kept]) = (self.media[k], self.kinds[k]);
                }
                kept += 1;
            } else {
                self.counts[usize::from(self.kinds[k])] -= 1;
            }
        }
        self.rays.truncate(kept);
        self.paths.truncate(kept);
        self.media.truncate(kept);
        self.kinds.truncate(kept);
    }

    fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
        self.media.clear();
        self.kinds.clear();
        self.counts = [0; 9];
    }
}
