//! Many rays against the whole scene at once.

use super::Scene;
use crate::bvh::TreeKernels;
use crate::geometry::{Hit, Ray};

/// Room that packets of rays need while they are traced; kept by whoever traces, so that tracing takes no memory.
#[derive(Debug, Default)]
pub struct PacketScratch {}

impl Scene {
    /// For each ray what [`Scene::intersect`] gives, to the last bit; quicker where rays run alike.
    pub fn intersect_packet<K: TreeKernels>(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        _scratch: &mut PacketScratch,
    ) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.intersect::<K>(ray);
        }
    }

    /// For each ray what [`Scene::occluded`] gives.
    pub fn occluded_packet<K: TreeKernels>(&self, rays: &[Ray], occluded: &mut [bool], _scratch: &mut PacketScratch) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.occluded::<K>(ray);
        }
    }
}
