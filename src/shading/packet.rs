//! Room for packets of rays and what they meet.

use super::tail::Tail;
use crate::geometry::{Hit, Ray, ShadowStart};
use crate::math::Rgb;
use crate::scene::{MediumStack, PacketScratch, Surfaces, Way};
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
    pub rays: Vec<Ray>,
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
}

/// Rays that go on from a packet.
#[derive(Debug, Default)]
pub(super) struct Branches {
    pub rays: Vec<(Ray, Path)>,
    /// As in [`Level::media`].
    pub media: Vec<MediumStack>,
}

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
    /// As far as glass lets light through.
    pub ways: Vec<Way>,
    /// With transparent objects along a shadow ray.
    pub glass: Vec<Hit>,
    /// Light that was not asked for, by sample: what it would bring to the sample, were all lit. Empty if none is to be spared.
    pub spent: Vec<f64>,
}

/// A surface that light can fall on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// Of the ray that meets it, in its packet.
    pub index: u32,
    /// Of the material in the scene.
    pub material: u32,
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
        let Branches { rays, media } = branches;
        let octant = |ray: &Ray| ray.direction.is_negative_bitmask() as usize;
        let mut starts = [0; 8];
        for (ray, _) in rays.iter() {
            starts[octant(ray)] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += std::mem::replace(start, sum);
        }
        let Some(&(ray, path)) = rays.first() else { return self.clear() };
        // What was there before is written over.
        self.rays.resize(rays.len(), ray);
        self.paths.resize(rays.len(), path);
        self.media.resize(media.len(), MediumStack::default());
        for (k, (ray, path)) in rays.iter().enumerate() {
            let start = &mut starts[octant(ray)];
            (self.rays[*start], self.paths[*start]) = (*ray, *path);
            if let Some(media) = media.get(k) {
                self.media[*start] = *media;
            }
            *start += 1;
        }
        branches.clear();
    }
}

impl Branches {
    pub fn push(&mut self, ray: Ray, path: Path, media: Option<&MediumStack>) {
        self.rays.push((ray, path));
        self.media.extend(media);
    }

    /// Drops the branches whose paths are not worth it.
    pub fn retain(&mut self, mut worth_it: impl FnMut(&Path) -> bool) {
        let mut kept = 0;
        for k in 0..self.rays.len() {
            if worth_it(&self.rays[k].1) {
                self.rays[kept] = self.rays[k];
                self.media[kept] = self.media[k];
                kept += 1;
            }
        }
        self.rays.truncate(kept);
        self.media.truncate(kept);
    }

    fn clear(&mut self) {
        self.rays.clear();
        self.media.clear();
    }
}
