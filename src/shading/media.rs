//! The transparent bodies that rays are inside of, kept once for all rays that share them: a ray carries a number of
//! four bytes, not a stack of eighty.

use crate::bvh::TreeKernels;
use crate::scene::{Inside, MediumStack, Scene};

/// All that the rays of a packet and those that follow from it are inside of.
#[derive(Debug, Default)]
pub(super) struct Media {
    stacks: Vec<MediumStack>,
    facts: Vec<Facts>,
}

/// What is asked of a stack again and again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// Refractive index of the place.
    pub ior: f64,
    pub inside: Inside,
    /// The body that a ray has only to find the way out of, since it meets nothing else there.
    pub free: Option<u32>,
}

impl Media {
    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.stacks.clear();
        self.facts.clear();
    }

    /// Takes a stack in. Returns its number.
    pub fn add<K: TreeKernels>(&mut self, scene: &Scene, stack: &MediumStack) -> u32 {
        // Rays that come together mostly go through the same surface.
        let is_last = |last: &MediumStack| last == stack && last.is_overfull() == stack.is_overfull();
        if !self.stacks.last().is_some_and(is_last) {
            let free = stack.only().filter(|&body| scene.is_free::<K>(body));
            self.facts.push(Facts { ior: stack.ior(scene), inside: stack.inside(), free });
            self.stacks.push(*stack);
        }
        self.stacks.len() as u32 - 1
    }

    /// One of them.
    pub fn stack(&self, number: u32) -> &MediumStack {
        &self.stacks[number as usize]
    }

    /// One of them, if there is any glass.
    pub fn get(&self, number: u32) -> Option<&MediumStack> {
        self.stacks.get(number as usize)
    }

    /// What is to be known of it.
    pub fn facts(&self, number: u32) -> &Facts {
        &self.facts[number as usize]
    }
}
