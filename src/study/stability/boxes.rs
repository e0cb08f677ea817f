//! S7: boxes of the hierarchy that the exact ray touches.

use super::sweep::{Row, Sweep};
use super::trials::{Effort, each_preset};
use crate::bvh::TreeKernels;
use crate::geometry::{Aabb, Ray, Slab};
use crate::math::SplitMix64;
use glam::DVec3;

/// How a ray touches its box.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Touch {
    InPlane,
    AlongEdge,
    Corner,
    Edge,
    FlatRim,
}

/// Whole numbers of this unit make rays whose arithmetic has no rounding, so that "touches" is meant exactly.
const UNIT: f64 = 1.0 / 1024.0;

fn whole(rng: &mut SplitMix64, low: i64, high: i64) -> f64 {
    (low + (rng.next_u64() % (high - low + 1) as u64) as i64) as f64 * UNIT
}

impl Touch {
    const ALL: [(Touch, &'static str); 5] = [
        (Self::InPlane, "false miss: in the plane of a face"),
        (Self::AlongEdge, "false miss: along an edge"),
        (Self::Corner, "false miss: through a corner"),
        (Self::Edge, "false miss: through an edge"),
        (Self::FlatRim, "false miss: rim of a flat box"),
    ];

    /// A box, a ray from `distance` sizes that meets it exactly, and t where it does.
    fn sample(self, rng: &mut SplitMix64, distance: f64) -> (Aabb, Ray, f64) {
        let (mut lower, mut upper) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..3 {
            lower[k] = whole(rng, -2000, 1000);
            upper[k] = lower[k] + whole(rng, 100, 2000);
        }
        let axis = (rng.next_u64() % 3) as usize;
        if self == Self::FlatRim {
            upper[axis] = lower[axis];
        }
        // A point of the box: at the end of some axes, anywhere between on the others.
        let at_end = |k: usize| match self {
            Self::InPlane | Self::FlatRim => k == axis || k == (axis + 1) % 3,
            Self::AlongEdge | Self::Edge => k != axis,
            Self::Corner => true,
        };
        let (mut target, mut direction) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..3 {
            let steps = ((upper[k] - lower[k]) / UNIT) as i64;
            target[k] = lower[k]
                + if at_end(k) {
                    [0.0, upper[k] - lower[k]][usize::from(rng.unit() < 0.5)]
                } else {
                    whole(rng, 0, steps)
                };
            let sign = if rng.unit() < 0.5 { -1.0 } else { 1.0 };
            direction[k] = match self {
                Self::InPlane if k == axis => 0.0 * sign,
                Self::AlongEdge if k != axis => 0.0 * sign,
                _ => whole(rng, 1, 1024) * sign,
            };
        }
        let bounds = Aabb { lower: lower.as_vec3(), upper: upper.as_vec3() };
        (bounds, Ray::new(target - direction * distance, direction), distance)
    }
}

fn misses<K: TreeKernels>(bounds: &Aabb, ray: &Ray, t_max: f64) -> bool {
    let slab = <K::Boxes as Slab>::new(ray, bounds.max_abs());
    slab.entry(bounds, slab.limit(t_max)).is_none()
}

/// S7
pub fn slabs(effort: &Effort) -> Vec<Sweep> {
    let tables = Touch::ALL.iter().zip(0..).map(|(&(touch, measure), case)| {
        let rows = [0, 4, 8, 12, 16, 20, 24, 28].map(|exponent| {
            let distance = 2f64.powi(exponent);
            let seed = 700 + 40 * case + exponent as u64;
            let [tally] = effort.run(seed, effort.choose(2_500, 250_000), |rng, [tally]| {
                let (bounds, ray, t) = touch.sample(rng, distance);
                // Some rays end where they touch.
                let t_max = if rng.unit() < 0.5 { t } else { f64::INFINITY };
                tally.judge(each_preset!(K => misses::<K>(&bounds, &ray, t_max)));
            });
            Row::rates(distance, &tally, 0.0)
        });
        Sweep::new(measure, "distance / size", rows.to_vec())
    });
    tables.collect()
}
