//! Balls against rays that run alike.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::simd::{ExactRays, PACKET, RayRows, Room, Row, Wide, of_group};
use crate::geometry::Ray;
use glam::DVec3;

/// The rays of a packet as balls are tested against them: in f32 with a proven bound, so that few are left for the f64
/// formula.
///
/// With u = 2^-24 and S the sum of the coordinates of the origin and the largest one of the tree: the vector f from the
/// origin to the centre is off by 2uS an axis and rounded by as much, 7uS in all. The foot t = (f, d) of the centre on
/// the line is off by that, by the rounding of d (2u|f|), by what d lacks to unit length and by the sum of products
/// (3u|f|), the rest f - t d by all that again and 4u|f|. With |f| < 1.8 S it is less than 50uS in length. The relative
/// errors of lengths and radii are less than 10uS, and there is room for the rounding of the f64 formula.
#[derive(Debug, Default)]
pub struct BallRows {
    /// The rays as they come.
    pub rays: ExactRays,
    slack: Row,
}

impl RayRows for BallRows {
    #[inline(always)]
    fn exact(&mut self) -> Option<&mut ExactRays> {
        Some(&mut self.rays)
    }
}

/// Where rays meet a ball, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Near {
    /// They may: all that do meet it, and few others.
    pub maybe: u32,
    /// They do.
    pub surely: u32,
    /// They go in and out again, at a cosine to the normal of more than 0.002.
    pub through: u32,
}

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

impl BallRows {
    /// Whether a ray can be taken: it is finite, its squares neither overflow nor vanish, and its direction is as long
    /// as those of rays of the world.
    #[inline(always)]
    pub fn is_fit(ray: &Ray, extent: f64) -> bool {
        let size = ray.origin.x.abs() + ray.origin.y.abs() + ray.origin.z.abs() + extent;
        (1e-12..=1e12).contains(&size) & ((ray.direction.length_squared() - 1.0).abs() <= U)
    }

    /// Takes rays for balls whose coordinates are at most `extent` in magnitude; false if one of them is not fit.
    #[inline(always)]
    pub fn take(room: &mut Room<Self>, extent: f64) -> bool {
        let Room { together, rows, .. } = room;
        let filled = together.filled.min(PACKET);
        let mut unfit = 0;
        for i in 0..filled {
            unfit |= u8::from(!Self::is_fit(&rows.rays.ray(i), extent));
        }
        let ([x, y, z], slack) = (&together.origin, &mut rows.slack.0);
        for i in 0..filled {
            slack[i] = (64.1 * U) as f32 * (x.0[i].abs() + y.0[i].abs() + z.0[i].abs() + extent as f32);
        }
        unfit == 0
    }

    /// Which rays of the group that starts at place `at` meet a ball before they end.
    ///
    /// They do where the line goes deep enough, its foot lies on the ray, and the ray ends behind the ball. What is not
    /// a number may be a hit.
    #[inline(always)]
    pub fn near<W: Wide>(w: W, room: &Room<Self>, (centre, radius): (DVec3, f64), at: usize) -> Near {
        let Room { together, slabs, rows } = room;
        let [ox, oy, oz] = of_group(w, &together.origin, at);
        let [dx, dy, dz] = of_group(w, &together.direction, at);
        let (start, end, slack) = (slabs.t_min.group(w, at), slabs.limit.group(w, at), rows.slack.group(w, at));
        let x = w.sub(w.splat(centre.x as f32), ox);
        let y = w.sub(w.splat(centre.y as f32), oy);
        let z = w.sub(w.splat(centre.z as f32), oz);
        let radius = w.splat(radius as f32);
        let foot = w.mul_add(x, dx, w.mul_add(y, dy, w.mul(z, dz)));
        let x = w.neg_mul_add(foot, dx, x);
        let y = w.neg_mul_add(foot, dy, y);
        let z = w.neg_mul_add(foot, dz, z);
        let distance2 = w.mul_add(x, x, w.mul_add(y, y, w.mul(z, z)));
        let (reach, depth) = (w.add(radius, slack), w.sub(radius, slack));
        let aside = w.le(w.mul(reach, reach), distance2);
        let behind = w.lt(w.add(foot, reach), start);
        let beyond = w.lt(end, w.sub(foot, reach));
        let inside = w.lt(distance2, w.mul(depth, depth)) & w.lt(slack, radius);
        // `start` and `end` are rounded outward.
        let ahead = w.lt(w.mul(start, w.splat((1.0 + 64.0 * U) as f32)), w.sub(foot, slack));
        let before = w.lt(w.add(foot, reach), w.mul(end, w.splat((1.0 - 64.0 * U) as f32)));
        // The cosine is (1 - (d / r)^2)^(1/2) > (130uS / r)^(1/2), with d < r - 66uS and r <= S.
        let deeper = w.sub(depth, slack);
        let deep = w.lt(distance2, w.mul(deeper, deeper)) & w.lt(w.add(slack, slack), radius);
        let outside = w.lt(w.mul(start, w.splat((1.0 + 64.0 * U) as f32)), w.sub(foot, reach));
        Near { maybe: !(aside | behind | beyond), surely: inside & ahead & before, through: deep & outside & before }
    }
}

#[cfg(test)]
mod tests {
    use super::super::simd::{Portable, RaySet, Take, Task};
    use super::*;
    use crate::geometry::sphere_intersect;
    use crate::math::SplitMix64;

    /// Rays at and past the silhouette of a ball, from its surface, from inside of it, ended before, in and behind it,
    /// near to and far from the origin of the world.
    #[test]
    fn a_ball_that_is_met_may_be_and_one_that_surely_is_is_met() {
        let mut rng = SplitMix64(52);
        let mut room = Room::<BallRows>::default();
        let (mut met, mut may, mut sure, mut pass) = (0u32, 0u32, 0u32, 0u32);
        for round in 0..10_000u32 {
            let size = 10f64.powi((round % 5) as i32 - 2);
            let mut vector =
                |size: f64| DVec3::new(rng.range(-size, size), rng.range(-size, size), rng.range(-size, size));
            let (centre, radius) = (vector(size), vector(1.0).x.abs() * [1.0, 1e-2, 1e-5][round as usize % 3]);
            let extent = centre.abs().max_element() + radius;
            let mut rays = [Ray::new(DVec3::ZERO, DVec3::X); PACKET];
            for (i, ray) in rays.iter_mut().enumerate() {
                let normal = vector(1.0).normalize();
                let side = vector(1.0).cross(normal).normalize();
                let beside = 1.0 + [0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3, -0.5, 0.5][i % 11];
                let target = centre + side * (radius * beside);
                let back = [0.0, radius, 2.0 * radius, 0.5 * radius, 3.0, 50.0][i % 6];
                *ray = Ray::new(target - normal * back, normal);
                if i % 7 == 0 {
                    *ray = Ray::new(centre + normal * radius, vector(1.0).normalize());
                }
                if i % 5 == 0 {
                    ray.t_max = back + radius * [-1.1, -1.0, -0.5, 0.0, 0.5, 1.0, 1.1][i % 7];
                }
                if i % 8 == 0 {
                    ray.t_min = (back + radius * [-1.0, 0.0, 1.0][i % 3]).max(0.0);
                }
            }
            Take::new(&RaySet::first(PACKET)).run(&rays[..], &mut room);
            assert!(BallRows::take(&mut room, extent));
            room.slabs.take(Portable, &room.together, 0.0, extent);
            for (at, rays) in (0..).step_by(8).zip(rays.chunks(8)) {
                let Near { maybe, surely, through } = BallRows::near(Portable, &room, (centre, radius), at);
                for (k, ray) in rays.iter().enumerate() {
                    let (maybe, surely) = (maybe >> k & 1 != 0, surely >> k & 1 != 0);
                    let is_met = sphere_intersect(ray, centre, radius).is_some();
                    assert!(maybe || !is_met, "lost: {ray:?} {centre:?} {radius:?}");
                    assert!(is_met || !surely, "invented: {ray:?} {centre:?} {radius:?}");
                    if through >> k & 1 != 0 {
                        let near = sphere_intersect(ray, centre, radius).unwrap();
                        let far = sphere_intersect(&Ray { t_min: near, ..*ray }, centre, radius).unwrap();
                        assert!(far - near > 0.004 * radius, "grazing: {ray:?} {centre:?} {radius:?}");
                        pass += 1;
                    }
                    met += u32::from(is_met);
                    may += u32::from(maybe);
                    sure += u32::from(surely);
                }
            }
        }
        assert!(met > 500_000 && may < 2 * met && sure > met / 8, "{may} may be met, {met} are, {sure} surely");
        assert!(pass > sure / 8, "{pass} go through");
    }

    #[test]
    fn rays_that_are_not_finite_or_of_unit_length_are_not_taken() {
        let good = Ray::new(DVec3::ONE, DVec3::X);
        let mut bad = [good; 5];
        bad[0].origin.y = f64::NAN;
        bad[1].origin.z = f64::INFINITY;
        bad[2].direction.x = f64::NAN;
        bad[3].direction.x = 1.001;
        bad[4].direction.y = f64::NEG_INFINITY;
        assert!(BallRows::is_fit(&good, 1.0));
        for ray in bad {
            assert!(!BallRows::is_fit(&ray, 1.0), "{ray:?}");
            let mut rays = [good; 20];
            rays[17] = ray;
            let mut room = Room::<BallRows>::default();
            Take::new(&RaySet::first(20)).run(&rays[..], &mut room);
            assert!(!BallRows::take(&mut room, 1.0), "{ray:?}");
        }
    }
}
