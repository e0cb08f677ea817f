//! Balls in blocks of eight, and which of them a ray may meet.
//!
//! A block takes the place of a node of eight leaves: the balls themselves are tested at once, not their boxes. What the test lets through
//! (seldom more than one of eight) is decided by the formula of a ball alone, so every hit keeps its bits.

#![allow(clippy::needless_range_loop)] // Numbers of rays and axes run over several arrays at once.

use super::EMPTY_SLOT;
use super::simd::{Beam, PACKET, Row, Slabs, Together, Wide, groups, ones};
use crate::geometry::Ray;
use glam::DVec3;

/// Up to eight balls, number by number.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct BallBlock {
    /// Rounded; NaN where there is none.
    centre: [[f32; 8]; 3],
    radius: [f32; 8],
    /// Numbers of the objects.
    ids: [u32; 8],
    exact: [(DVec3, f64); 8],
    /// Lanes with a ball, a bit each.
    filled: u32,
}

impl BallBlock {
    /// Takes up to eight balls: number of the object, centre and radius in world space.
    pub fn new(balls: impl IntoIterator<Item = (u32, DVec3, f64)>) -> Self {
        let none = [f32::NAN; 8];
        let mut block = Self {
            centre: [none; 3],
            radius: [0.0; 8],
            ids: [EMPTY_SLOT; 8],
            exact: [(DVec3::ZERO, 0.0); 8],
            filled: 0,
        };
        for (lane, (id, centre, radius)) in balls.into_iter().enumerate() {
            for axis in 0..3 {
                block.centre[axis][lane] = centre[axis] as f32;
            }
            (block.radius[lane], block.ids[lane], block.exact[lane]) = (radius as f32, id, (centre, radius));
            block.filled |= 1 << lane;
        }
        block
    }

    /// Number, centre and radius of the ball in a lane.
    #[inline(always)]
    pub fn ball(&self, lane: usize) -> (u32, DVec3, f64) {
        let (centre, radius) = self.exact[lane & 7];
        (self.ids[lane & 7], centre, radius)
    }

    /// Centres and radii.
    #[inline(always)]
    fn lanes<E: Wide>(&self, e: E) -> ([E::V; 3], E::V) {
        let [x, y, z] = &self.centre;
        ([e.load(x), e.load(y), e.load(z)], e.load(&self.radius))
    }

    /// Which balls the rays of a beam may meet, a bit each.
    #[inline(always)]
    pub fn cull<E: Wide>(&self, e: E, beam: &Beam<E>) -> u32 {
        let ([x, y, z], radius) = self.lanes(e);
        let (low, high) = (
            [e.sub(x, radius), e.sub(y, radius), e.sub(z, radius)],
            [e.add(x, radius), e.add(y, radius), e.add(z, radius)],
        );
        beam.meets(e, low, high) & self.filled
    }

    /// Numbers of the objects.
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.ids.into_iter().take_while(|&id| id != EMPTY_SLOT)
    }
}

/// A ray against blocks of balls.
pub trait BallTest {
    /// Prepares a ray for balls whose coordinates are at most `extent` in magnitude.
    fn new(ray: &Ray, extent: f64) -> Self;

    /// The lanes whose balls the ray may meet, a bit each: all that it does meet, and few others.
    fn candidates<E: Wide>(&self, eight: E, block: &BallBlock) -> u32;

    /// Tells that hits beyond `t_max` do not count any more.
    fn shorten(&mut self, t_max: f64);
}

/// All of them: the yardstick.
pub struct EveryBall;

impl BallTest for EveryBall {
    #[inline(always)]
    fn new(_ray: &Ray, _extent: f64) -> Self {
        Self
    }

    #[inline(always)]
    fn candidates<E: Wide>(&self, _eight: E, block: &BallBlock) -> u32 {
        block.filled
    }

    #[inline(always)]
    fn shorten(&mut self, _t_max: f64) {}
}

/// In f32 with a proven bound, for the f64 formula.
///
/// With u = 2^-24 and S the sum of the largest coordinates of origin and tree: the vector f from the origin to the centre is off by 2uS an
/// axis and rounded by as much, 7uS in all. The foot t = (f, d) of the centre on the line is off by that, by the rounding of d (2u|f|),
/// by what d lacks to unit length and by the sum of products (3u|f|), the rest f - t d by all that again and 4u|f|. With |f| < 1.8 S it is
/// less than 50uS in length. The relative errors of lengths and radii are less than 10uS, and there is room for the rounding of the f64
/// formula.
#[derive(Clone, Copy, Debug)]
pub struct PaddedBalls {
    origin: [f32; 3],
    direction: [f32; 3],
    slack: f32,
    start: f32,
    end: f32,
    /// Lanes that are candidates in any case: all of them where the bound does not hold.
    always: u32,
}

impl BallTest for PaddedBalls {
    #[inline(always)]
    fn new(ray: &Ray, extent: f64) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let size = o.abs().max_element() + extent;
        let holds = SIZES.contains(&size) & is_unit(d);
        let mut test = Self {
            origin: [o.x as f32, o.y as f32, o.z as f32],
            direction: [d.x as f32, d.y as f32, d.z as f32],
            slack: (64.0 * U * size) as f32,
            start: (ray.t_min * (1.0 - 4.0 * U)) as f32,
            end: 0.0,
            always: if holds { 0 } else { 0xff },
        };
        test.shorten(ray.t_max);
        test
    }

    #[inline(always)]
    fn candidates<E: Wide>(&self, e: E, block: &BallBlock) -> u32 {
        let [ox, oy, oz] = self.origin;
        let [dx, dy, dz] = self.direction;
        let rays = Rays {
            origin: [e.splat(ox), e.splat(oy), e.splat(oz)],
            direction: [e.splat(dx), e.splat(dy), e.splat(dz)],
            slack: e.splat(self.slack),
            start: e.splat(self.start),
            end: e.splat(self.end),
        };
        (rays.near(e, block.lanes(e)) | self.always) & block.filled
    }

    #[inline(always)]
    fn shorten(&mut self, t_max: f64) {
        self.end = (t_max * (1.0 + 4.0 * U)) as f32;
    }
}

/// Sizes of which squares neither overflow nor vanish.
const SIZES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Whether a direction is as long as those of rays of the world.
#[inline(always)]
fn is_unit(direction: DVec3) -> bool {
    (direction.length_squared() - 1.0).abs() <= U
}

/// Rays in lanes, or one in all of them.
struct Rays<V> {
    origin: [V; 3],
    direction: [V; 3],
    slack: V,
    start: V,
    end: V,
}

impl<V: Copy> Rays<V> {
    /// Where the balls given by centre and radius are near, a bit a lane; see [`PaddedBalls`]. Also where anything is not a number.
    #[inline(always)]
    fn near<W: Wide<V = V>>(&self, w: W, ([x, y, z], radius): ([V; 3], V)) -> u32 {
        let ([ox, oy, oz], [dx, dy, dz]) = (self.origin, self.direction);
        let (x, y, z) = (w.sub(x, ox), w.sub(y, oy), w.sub(z, oz));
        let foot = w.mul_add(x, dx, w.mul_add(y, dy, w.mul(z, dz)));
        let x = w.neg_mul_add(foot, dx, x);
        let y = w.neg_mul_add(foot, dy, y);
        let z = w.neg_mul_add(foot, dz, z);
        let distance2 = w.mul_add(x, x, w.mul_add(y, y, w.mul(z, z)));
        let reach = w.add(radius, self.slack);
        let aside = w.le(w.mul(reach, reach), distance2);
        let behind = w.lt(w.add(foot, reach), self.start);
        let beyond = w.lt(self.end, w.sub(foot, reach));
        !(aside | behind | beyond)
    }
}

/// The numbers of [`PaddedBalls`] for the rays of a packet.
pub struct BallRays {
    origin: [Row; 3],
    direction: [Row; 3],
    slack: Row,
}

impl BallRays {
    /// Without rays.
    #[inline(always)]
    pub fn new() -> Self {
        let row = Row::new(0.0);
        Self { origin: [row; 3], direction: [row; 3], slack: row }
    }

    /// Whether a ray can be taken: finite, and of unit length.
    #[inline(always)]
    pub fn is_fit(ray: &Ray, extent: f64) -> bool {
        let size = ray.origin.abs().element_sum() + extent;
        SIZES.contains(&size) & is_unit(ray.direction)
    }

    /// Takes rays; false if one of them is not fit.
    #[inline(always)]
    pub fn take(&mut self, together: &Together, extent: f64) -> bool {
        let filled = together.filled.min(PACKET);
        let mut fit = true;
        for i in 0..filled {
            fit &= Self::is_fit(&together.ray(i), extent);
        }
        for axis in 0..3 {
            for i in 0..filled {
                self.origin[axis].0[i] = together.origin[axis].0[i] as f32;
                self.direction[axis].0[i] = together.direction[axis].0[i] as f32;
            }
        }
        let ([x, y, z], slack) = (&self.origin, &mut self.slack.0);
        for i in 0..filled {
            // No less than the largest of them.
            let size = x.0[i].abs() + y.0[i].abs() + z.0[i].abs() + extent as f32;
            slack[i] = 64.0 * 1.001 * U as f32 * size;
        }
        fit
    }

    /// Which rays of the group that starts at place `at` the ball in a lane is near to, a bit each.
    #[inline(always)]
    pub fn near_ball<W: Wide>(&self, w: W, slabs: &Slabs, block: &BallBlock, lane: usize, at: usize) -> u32 {
        let rays = Rays {
            origin: groups(w, &self.origin, at),
            direction: groups(w, &self.direction, at),
            slack: self.slack.group(w, at),
            start: slabs.t_min.group(w, at),
            end: slabs.limit.group(w, at),
        };
        let ([x, y, z], lane) = (&block.centre, lane & 7);
        rays.near(w, ([w.splat(x[lane]), w.splat(y[lane]), w.splat(z[lane])], w.splat(block.radius[lane])))
    }

    /// Which balls of a block are near to a ray, a bit each.
    #[inline(always)]
    pub fn near_ray<E: Wide>(&self, e: E, slabs: &Slabs, block: &BallBlock, ray: usize) -> u32 {
        let rays = Rays {
            origin: ones(e, &self.origin, ray),
            direction: ones(e, &self.direction, ray),
            slack: self.slack.one(e, ray),
            start: slabs.t_min.one(e, ray),
            end: slabs.limit.one(e, ray),
        };
        rays.near(e, block.lanes(e)) & block.filled
    }
}

/// Unit roundoff of f32.
const U: f64 = 1.0 / 16_777_216.0;

/// The bits of the school formula in f32, without fused operations, up to its discriminant.
pub struct PlainBalls {
    origin: [f32; 3],
    direction: [f32; 3],
    /// (d, d)
    a: f32,
    /// Where b and c are not below this, both roots are negative: -b + sqrt(b² - a c) <= -b + |b|.
    behind: f32,
}

impl BallTest for PlainBalls {
    #[inline(always)]
    fn new(ray: &Ray, _extent: f64) -> Self {
        let (o, d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
        let behind = if ray.t_min >= 0.0 { 0.0 } else { f32::INFINITY };
        Self { origin: [o.x, o.y, o.z], direction: [d.x, d.y, d.z], a: d.dot(d), behind }
    }

    #[inline(always)]
    fn candidates<E: Wide>(&self, e: E, block: &BallBlock) -> u32 {
        let ([ox, oy, oz], [dx, dy, dz], [cx, cy, cz]) = (&self.origin, &self.direction, &block.centre);
        let x = e.sub(e.splat(*ox), e.load(cx));
        let y = e.sub(e.splat(*oy), e.load(cy));
        let z = e.sub(e.splat(*oz), e.load(cz));
        let (dx, dy, dz, radius) = (e.splat(*dx), e.splat(*dy), e.splat(*dz), e.load(&block.radius));
        let b = e.add(e.add(e.mul(x, dx), e.mul(y, dy)), e.mul(z, dz));
        let c = e.sub(e.add(e.add(e.mul(x, x), e.mul(y, y)), e.mul(z, z)), e.mul(radius, radius));
        let discriminant = e.sub(e.mul(b, b), e.mul(e.splat(self.a), c));
        // A discriminant that is not a number has no roots.
        e.le(e.splat(0.0), discriminant) & !e.le(e.splat(self.behind), e.min(b, c)) & block.filled
    }

    #[inline(always)]
    fn shorten(&mut self, _t_max: f64) {}
}
