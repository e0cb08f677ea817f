//! Points of the film that are traced together.

use super::batch::BATCH;
use crate::bvh::Task;
use crate::description::Filter;
use crate::math::{sample_in_pixel, tent};
use crate::scene::Scene;
use glam::DVec2;

/// Where on the film sample `index` of a pixel is, in pixels from its upper left corner; without a filter in the
/// pixel's middle.
#[inline(always)]
pub(super) fn film_point(filter: Option<Filter>, x: u32, y: u32, index: u32) -> DVec2 {
    let (u, v) = sample_in_pixel(x, y, index);
    let (u, v) = match filter {
        None => (0.5, 0.5),
        Some(Filter::Box) => (u, v),
        Some(Filter::Tent) => (tent(u), tent(v)),
    };
    DVec2::new(f64::from(x) + u, f64::from(y) + v)
}

/// Up to [`BATCH`] samples, and where on the film they are.
#[derive(Debug)]
pub struct FilmPoints {
    samples: Box<Samples>,
    points: Box<[DVec2; BATCH]>,
    count: usize,
}

/// Pixels and the indices of samples in them, side by side.
#[derive(Debug)]
#[repr(align(64))]
struct Samples {
    x: [u32; BATCH],
    y: [u32; BATCH],
    index: [u32; BATCH],
}

impl Default for FilmPoints {
    fn default() -> Self {
        let samples = Samples { x: [0; BATCH], y: [0; BATCH], index: [0; BATCH] };
        Self { samples: Box::new(samples), points: Box::new([DVec2::ZERO; BATCH]), count: 0 }
    }
}

impl FilmPoints {
    /// How many samples there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes in a sample of a pixel. Panics if there are [`BATCH`] already.
    pub fn push(&mut self, x: u32, y: u32, index: u32) {
        let (at, samples) = (self.count, &mut *self.samples);
        (samples.x[at], samples.y[at], samples.index[at]) = (x, y, index);
        self.count += 1;
    }

    /// What [`film_point`] says of each of them.
    pub fn find(&mut self, scene: &Scene, filter: Option<Filter>) -> &[DVec2] {
        scene.run(Find { filter, count: self.count }, &self.samples, &mut self.points);
        &self.points[..self.count]
    }
}

struct Find {
    filter: Option<Filter>,
    count: usize,
}

impl Task for Find {
    type Input = Samples;
    type Output = [DVec2; BATCH];

    #[inline(always)]
    fn run(self, Samples { x, y, index }: &Samples, points: &mut [DVec2; BATCH]) {
        // A loop for each filter, so that none asks for it sample by sample.
        match self.filter {
            None => (0..self.count.min(BATCH)).for_each(|i| points[i] = film_point(None, x[i], y[i], index[i])),
            Some(Filter::Box) => {
                for i in 0..self.count.min(BATCH) {
                    points[i] = film_point(Some(Filter::Box), x[i], y[i], index[i]);
                }
            }
            Some(Filter::Tent) => {
                for i in 0..self.count.min(BATCH) {
                    points[i] = film_point(Some(Filter::Tent), x[i], y[i], index[i]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Isa;
    use crate::description::SceneDesc;
    use crate::math::SplitMix64;
    use crate::scene::compile_for;

    #[test]
    fn points_found_together_are_those_found_alone() {
        let mut random = SplitMix64(41);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let scene = compile_for(&SceneDesc::default(), None, isa).expect("the scene is right");
            for filter in [None, Some(Filter::Box), Some(Filter::Tent)] {
                for count in [0, 1, 7, 8, 200, BATCH] {
                    let mut points = FilmPoints::default();
                    let bits = |random: &mut SplitMix64, mask: u64| (random.next_u64() & mask) as u32;
                    let samples: Vec<[u32; 3]> = (0..count)
                        .map(|_| [bits(&mut random, 4095), bits(&mut random, 4095), bits(&mut random, 31)])
                        .collect();
                    for &[x, y, index] in &samples {
                        points.push(x, y, index);
                    }
                    let alone = samples.iter().map(|&[x, y, index]| film_point(filter, x, y, index));
                    assert!(points.find(&scene, filter).iter().copied().eq(alone), "{} {filter:?} {count}", isa.name());
                }
            }
        }
    }
}
