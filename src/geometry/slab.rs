//! Does a ray meet a box? Three answers: conservative in f32, conservative in f64, and the usual quick one.

use super::aabb::Aabb;
use super::ray::Ray;
use crate::math::Four;

/// A ray prepared for tests against the boxes of one tree. Distances are in the ray's t, possibly shifted by a
/// constant; they serve to order and to prune, never to decide a hit.
pub trait Slab: Copy {
    /// Prepares a ray for boxes whose coordinates are at most `extent` in magnitude.
    fn new(ray: &Ray, extent: f64) -> Self;

    /// `t_max` in the units of `entry`, rounded up.
    fn limit(&self, t_max: f64) -> f32;

    /// Where the ray enters the box, or `None` if it misses it or enters beyond `limit`.
    fn entry(&self, bounds: &Aabb, limit: f32) -> Option<f32>;
}

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

/// More than the rounding of what f32 can hold only with less than 24 bits.
const TINY: f64 = f32::MIN_POSITIVE as f64;

/// f32 boxes, f64 ray; the entry is a lower bound of the exact one, and a box that the exact ray touches is never
/// missed.
///
/// A plane at b is met at t = b/d - o/d. With u = 2^-24, rounding the reciprocal, the product and the difference are
/// off by u|b/d|, u|b/d| (not if fused) and u|t|, the constant by u|o/d|; since |b/d| <= |t| + |o/d|, all together by
/// at most 3u|t| + 3u|o/d|. The second part is a pad of 4u|o|/|d| inside of the constant. The first one is relative to
/// t itself, and so entry (1 - 3u) <= exit (1 + 3u) misses nothing: reciprocal and constant of the near planes are
/// smaller by a factor of 1 - 8u. (A product a node instead took 0 to 5 % more time for single rays, interior and
/// blobs100k.) (robust-leaf.md, "Boxes (N2)", pads by the extent of the whole tree instead, which makes a floor of
/// radius 1e7 in a scene of unit balls cost a thousand times the time.)
#[derive(Clone, Copy, Debug)]
pub struct PaddedSlab {
    /// 1 / direction, for far planes. The fourth of each is not used.
    pub reciprocal: [f32; 4],
    /// The same for near planes, smaller by [`PaddedSlab::ENTRY_FACTOR`].
    pub near_reciprocal: [f32; 4],
    /// Subtracted from near plane times reciprocal.
    pub near: [f32; 4],
    /// Subtracted from far plane times reciprocal.
    pub far: [f32; 4],
    /// In the units of `entry`, rounded down; not negative.
    pub t_min: f32,
    /// t of the point that distances are counted from: a far origin is advanced to before its closest approach.
    start: f64,
}

impl PaddedSlab {
    /// Factor on the entry that makes up for the relative errors of entry and exit.
    pub const ENTRY_FACTOR: f64 = 1.0 - 8.0 * U;

    /// t of the point that distances are counted from: 0 but for far origins.
    #[inline(always)]
    pub fn start(&self) -> f64 {
        self.start
    }

    /// [`Slab::new`], computed with registers of four: `o` and `d` are the origin and the direction of the ray, and
    /// anything.
    #[inline(always)]
    pub fn with<F: Four>(ray: &Ray, mut o: F, d: F, extent: f64) -> Self {
        let mut size = ray.origin.abs().max_element();
        let (mut start, mut pad) = (0.0, 0.0);
        if size > 8.0 * extent {
            // To two extents (of the box's corners, so 4 > 2 sqrt 3) before the closest approach: what is met lies
            // ahead.
            let speed = ray.direction.length();
            start = (-ray.origin.dot(ray.direction) / speed - 4.0 * extent) / speed;
            o = o + d * start;
            pad = 1e-15 * size;
            size = ray.at(start).abs().max_element();
        }
        // A component that is (almost) zero is widened to 2^-40 of the largest: no product of 0 and infinity. Over the
        // way to the far side of the tree that shifts the ray by less than the last term.
        let least = ray.direction.abs().max_element() * 2f64.powi(-40);
        pad += 4.0 * U * size + 2f64.powi(-37) * (extent + size);
        let inverse = d.splat(1.0) / d.abs().max(d.splat(least)).copysign(d);
        let (constant, pad) = (o * inverse, inverse.abs() * pad);
        Self {
            reciprocal: inverse.as_f32(),
            near_reciprocal: (inverse * Self::ENTRY_FACTOR).as_f32(),
            near: ((constant + pad) * Self::ENTRY_FACTOR).as_f32(),
            far: (constant - pad).as_f32(),
            // Never negative, so that distances compare as their bits do.
            t_min: (((ray.t_min - start) * (Self::ENTRY_FACTOR - 2.0 * U) - TINY) as f32).max(0.0),
            start,
        }
    }
}

impl Slab for PaddedSlab {
    #[inline(always)]
    fn new(ray: &Ray, extent: f64) -> Self {
        Self::with(ray, ray.origin.extend(0.0), ray.direction.extend(0.0), extent)
    }

    #[inline(always)]
    fn limit(&self, t_max: f64) -> f32 {
        // Not `f32::next_up`, which branches three times.
        ((t_max - self.start) * (1.0 + 2.0 * U) + TINY) as f32
    }

    #[inline(always)]
    fn entry(&self, bounds: &Aabb, limit: f32) -> Option<f32> {
        let (mut near, mut far) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let r = self.reciprocal[k];
            let (first, last) =
                if r < 0.0 { (bounds.upper[k], bounds.lower[k]) } else { (bounds.lower[k], bounds.upper[k]) };
            (near[k], far[k]) = (first * self.near_reciprocal[k] - self.near[k], last * r - self.far[k]);
        }
        // The second argument where one is NaN (from overflow): such a plane bounds nothing, nor does its pair.
        let max = |a: f32, b: f32| if a > b { a } else { b };
        let min = |a: f32, b: f32| if a < b { a } else { b };
        let enter = max(max(near[0], near[1]), max(near[2], self.t_min));
        let exit = min(min(far[0], far[1]), min(far[2], limit));
        (enter <= exit).then_some(enter)
    }
}

/// f64 throughout, widened by more than its own rounding: the yardstick.
#[derive(Clone, Copy, Debug)]
pub struct WideSlab(Ray);

impl Slab for WideSlab {
    #[inline(always)]
    fn new(ray: &Ray, _extent: f64) -> Self {
        Self(*ray)
    }

    #[inline(always)]
    fn limit(&self, t_max: f64) -> f32 {
        (t_max as f32).next_up()
    }

    #[inline(always)]
    fn entry(&self, bounds: &Aabb, limit: f32) -> Option<f32> {
        let (mut enter, mut exit) = (self.0.t_min, f64::from(limit));
        for k in 0..3 {
            let (o, d) = (self.0.origin[k], self.0.direction[k]);
            let (lower, upper) = (f64::from(bounds.lower[k]), f64::from(bounds.upper[k]));
            let (first, last) = if d.is_sign_negative() { (upper, lower) } else { (lower, upper) };
            let (near, far) = ((first - o) / d, (last - o) / d);
            let (near, far) = (near - near.abs() * 1e-15, far + far.abs() * 1e-15);
            enter = if near > enter { near } else { enter };
            exit = if far < exit { far } else { exit };
        }
        (enter <= exit).then(|| (enter as f32).next_down().max(0.0))
    }
}

/// The usual quick test: f32, no pads. Loses rays that run in the plane of a face or graze an edge.
#[derive(Clone, Copy, Debug)]
pub struct PlainSlab {
    /// 1 / direction.
    pub reciprocal: [f32; 3],
    /// Origin / direction.
    pub offset: [f32; 3],
    /// Of the ray.
    pub t_min: f32,
}

impl Slab for PlainSlab {
    #[inline(always)]
    fn new(ray: &Ray, _extent: f64) -> Self {
        let inverse = ray.direction.as_vec3().recip();
        let offset = ray.origin.as_vec3() * inverse;
        Self { reciprocal: inverse.into(), offset: offset.into(), t_min: (ray.t_min as f32).max(0.0) }
    }

    #[inline(always)]
    fn limit(&self, t_max: f64) -> f32 {
        t_max as f32
    }

    #[inline(always)]
    fn entry(&self, bounds: &Aabb, limit: f32) -> Option<f32> {
        let (mut enter, mut exit) = (self.t_min, limit);
        for k in 0..3 {
            let t0 = bounds.lower[k] * self.reciprocal[k] - self.offset[k];
            let t1 = bounds.upper[k] * self.reciprocal[k] - self.offset[k];
            enter = enter.max(t0.min(t1));
            exit = exit.min(t0.max(t1));
        }
        (enter <= exit).then_some(enter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;
    use glam::{DVec3, Vec3};

    fn random_point(rng: &mut SplitMix64, size: f64) -> DVec3 {
        DVec3::new(rng.range(-size, size), rng.range(-size, size), rng.range(-size, size))
    }

    /// numerics.md S7: rays through corners, edges and faces, from near and far, with zero components.
    #[test]
    fn a_box_that_the_exact_ray_touches_is_never_missed() {
        let mut rng = SplitMix64(7);
        for i in 0..400_000u32 {
            let (a, b) = (random_point(&mut rng, 1.0).as_vec3(), random_point(&mut rng, 1.0).as_vec3());
            let flat = i.is_multiple_of(5);
            let bounds = Aabb { lower: a.min(b), upper: if flat { a.max(b).with_y(a.min(b).y) } else { a.max(b) } };
            // A point of the box: a corner, on an edge, on a face or inside.
            let mut target = Vec3::ZERO;
            for k in 0..3 {
                let w = [0.0, 1.0, rng.unit() as f32][(rng.next_u64() % 3) as usize];
                target[k] = if w == 0.0 {
                    bounds.lower[k]
                } else if w == 1.0 {
                    bounds.upper[k]
                } else {
                    (bounds.lower[k] + w * (bounds.upper[k] - bounds.lower[k])).clamp(bounds.lower[k], bounds.upper[k])
                };
            }
            // The ray is exact: steps by a power of two from the target, dyadic components, some of them zero.
            let mut direction = DVec3::ZERO;
            for k in 0..3 {
                direction[k] =
                    [0.0, f64::from(rng.range(-1.0, 1.0) as f32)][usize::from(!rng.next_u64().is_multiple_of(4))];
            }
            if direction == DVec3::ZERO {
                continue;
            }
            let step = 2f64.powi((rng.next_u64() % 24) as i32 - 4);
            let ray = Ray::new(target.as_dvec3() - direction * step, direction);
            let extent = bounds.max_abs();
            let limit = f64::INFINITY;
            let padded = PaddedSlab::new(&ray, extent);
            assert!(padded.entry(&bounds, padded.limit(limit)).is_some(), "padded {ray:?} {bounds:?}");
            let wide = WideSlab::new(&ray, extent);
            assert!(wide.entry(&bounds, wide.limit(limit)).is_some(), "wide {ray:?} {bounds:?}");
            // And not beyond the hit either.
            assert!(padded.entry(&bounds, padded.limit(step)).is_some(), "padded to its end {ray:?} {bounds:?}");
        }
    }

    #[test]
    fn boxes_well_off_the_ray_are_missed() {
        let bounds = Aabb { lower: Vec3::splat(-1.0), upper: Vec3::splat(1.0) };
        let mut rng = SplitMix64(8);
        for _ in 0..10_000 {
            let direction = random_point(&mut rng, 1.0).normalize();
            let side = direction.any_orthonormal_vector() * 1.8;
            let ray = Ray::new(side - direction * rng.range(0.0, 1e4), direction);
            assert!(PaddedSlab::new(&ray, 1.0).entry(&bounds, f32::INFINITY).is_none(), "{ray:?}");
        }
    }
}
