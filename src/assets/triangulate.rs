//! Triangles of polygons, concave ones too.
//!
//! A polygon is looked at in its own plane: the coordinate axis nearest to its Newell normal (Sutherland, Sproull,
//! Schumacker 1974) is dropped, which keeps sides of lines as they are. If the fan from the first corner is right it is
//! taken; else ears are clipped (Meisters 1975) in the order of a queue, which keeps slivers rare. Coordinates are f32,
//! so the sides of lines are computed in f64 without error for corners of similar size.

use glam::{DVec2, DVec3, Vec3};
use std::collections::VecDeque;

/// Most corners of a polygon whose fan is wrong: clipping takes quadratic time.
pub(super) const MAX_CONCAVE: usize = 8_192;

/// How often a polygon that seems to have no ear is looked through again before corners are forced off.
const MAX_REFILLS: u32 = 16;

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The triangles cover it exactly.
    Covered,
    /// It crosses or touches itself; the triangles use every corner but may overlap.
    SelfCrossing,
    /// Concave, with more than [`MAX_CONCAVE`] corners: no triangles.
    TooLarge,
}

/// Working memory, kept from polygon to polygon.
#[derive(Default)]
pub(super) struct Triangulator {
    flat: Vec<DVec2>,
    previous: Vec<u32>,
    next: Vec<u32>,
    reflex: Vec<u32>,
    queue: VecDeque<u32>,
}

/// Normal of a polygon in the sense of its winding, length twice its area. Exact enough for any plane: the sum is taken
/// about the first corner.
pub(super) fn newell_normal(points: impl Iterator<Item = Vec3> + Clone) -> DVec3 {
    let Some(origin) = points.clone().next().map(Vec3::as_dvec3) else { return DVec3::ZERO };
    let mut from_origin = points.map(|p| p.as_dvec3() - origin).skip(1);
    let Some(mut last) = from_origin.next() else { return DVec3::ZERO };
    let mut sum = DVec3::ZERO;
    for p in from_origin {
        sum += last.cross(p);
        last = p;
    }
    sum
}

/// Above 0 if c lies to the left of the line from a to b: twice the area of the triangle.
fn side(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

impl Triangulator {
    /// Appends the `points.len() - 2` triangles of a polygon as indices into `points`, wound as it is. Neighbouring
    /// points should differ.
    pub fn triangulate(&mut self, points: &[Vec3], triangles: &mut Vec<[u32; 3]>) -> Outcome {
        let n = points.len() as u32;
        let fan = (2..n).map(|i| [0, i - 1, i]);
        if n <= 3 {
            triangles.extend(fan);
            return Outcome::Covered;
        }
        let normal = newell_normal(points.iter().copied());
        let size = normal.abs();
        let drop_axis: fn(DVec3) -> DVec2 = match (size.max_position(), normal[size.max_position()] > 0.0) {
            (0, true) => |p| DVec2::new(p.y, p.z),
            (0, false) => |p| DVec2::new(p.z, p.y),
            (1, true) => |p| DVec2::new(p.z, p.x),
            (1, false) => |p| DVec2::new(p.x, p.z),
            (_, true) => |p| DVec2::new(p.x, p.y),
            (_, false) => |p| DVec2::new(p.y, p.x),
        };
        self.flat.clear();
        self.flat.extend(points.iter().map(|p| drop_axis(p.as_dvec3())));
        let flat = &self.flat;
        if flat.windows(2).skip(1).all(|w| side(flat[0], w[0], w[1]) > 0.0) {
            triangles.extend(fan);
            return Outcome::Covered;
        }
        if points.len() > MAX_CONCAVE {
            return Outcome::TooLarge;
        }
        self.clip_ears(triangles)
    }

    fn clip_ears(&mut self, triangles: &mut Vec<[u32; 3]>) -> Outcome {
        let n = self.flat.len() as u32;
        self.previous.clear();
        self.previous.extend((0..n).map(|i| (i + n - 1) % n));
        self.next.clear();
        self.next.extend((0..n).map(|i| (i + 1) % n));
        self.reflex.clear();
        for i in 0..n {
            if self.turn(i) <= 0.0 {
                self.reflex.push(i);
            }
        }
        self.queue.clear();
        self.queue.extend(0..n);
        let mut outcome = Outcome::Covered;
        let (mut left, mut left_at_refill) = (n, n);
        let mut refills = 0;
        let mut any = 0;
        while left > 3 {
            let candidate = self.queue.pop_front();
            let ear = match candidate {
                Some(i) if self.is_clipped(i) || !self.is_ear(i) => continue,
                Some(i) => i,
                None if left < left_at_refill && refills < MAX_REFILLS => {
                    refills += 1;
                    left_at_refill = left;
                    self.queue.extend((0..n).filter(|&i| self.next[i as usize] != i));
                    continue;
                }
                None => {
                    // Not simple. Going on with the corner that turns left most always ends.
                    let remaining = std::iter::successors(Some(any), |&i| Some(self.next[i as usize]));
                    let best = remaining.take(left as usize).max_by(|&a, &b| self.turn(a).total_cmp(&self.turn(b)));
                    let best = best.unwrap_or(any);
                    if self.turn(best) != 0.0 {
                        outcome = Outcome::SelfCrossing;
                    }
                    best
                }
            };
            let (before, after) = (self.previous[ear as usize], self.next[ear as usize]);
            triangles.push([before, ear, after]);
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            (self.next[ear as usize], self.previous[ear as usize]) = (ear, ear);
            any = before;
            left -= 1;
            self.queue.extend([after, before]);
        }
        triangles.push([self.previous[any as usize], any, self.next[any as usize]]);
        // Signed, the triangles cover each point as often as the polygon winds around it.
        if self.turn(any) < 0.0 { Outcome::SelfCrossing } else { outcome }
    }

    /// Clipped corners are their own neighbours.
    fn is_clipped(&self, i: u32) -> bool {
        self.next[i as usize] == i
    }

    fn corner(&self, i: u32) -> (DVec2, DVec2, DVec2) {
        let at = |i: u32| self.flat[i as usize];
        (at(self.previous[i as usize]), at(i), at(self.next[i as usize]))
    }

    /// Above 0 where the polygon turns left.
    fn turn(&self, i: u32) -> f64 {
        let (a, b, c) = self.corner(i);
        side(a, b, c)
    }

    /// Whether the triangle at corner i can be cut off: it turns left and no other corner lies in it or on its rim,
    /// save at its corners (polygons with holes have bridges there). Only corners that do not turn left need be asked.
    fn is_ear(&mut self, i: u32) -> bool {
        let (a, b, c) = self.corner(i);
        if side(a, b, c) <= 0.0 {
            return false;
        }
        let (before, after) = (self.previous[i as usize], self.next[i as usize]);
        let mut k = 0;
        while k < self.reflex.len() {
            let r = self.reflex[k];
            let p = self.flat[r as usize];
            let inside = side(a, b, p) >= 0.0 && side(b, c, p) >= 0.0 && side(c, a, p) >= 0.0;
            if !inside || r == before || r == after || r == i || p == a || p == b || p == c {
                k += 1;
            } else if self.is_clipped(r) || self.turn(r) > 0.0 {
                self.reflex.swap_remove(k);
            } else {
                return false;
            }
        }
        true
    }
}

/// Whether the exact area of a triangle is 0.
pub(super) fn is_degenerate(a: Vec3, b: Vec3, c: Vec3) -> bool {
    let (ab, ac) = (b.as_dvec3() - a.as_dvec3(), c.as_dvec3() - a.as_dvec3());
    let cross = ab.cross(ac);
    // Each component errs by less than 4 roundings of the sizes of its two products.
    let size = DVec3::new(
        (ab.y * ac.z).abs() + (ab.z * ac.y).abs(),
        (ab.z * ac.x).abs() + (ab.x * ac.z).abs(),
        (ab.x * ac.y).abs() + (ab.y * ac.x).abs(),
    );
    if cross.abs().cmpgt(size * 1e-15).any() {
        return false;
    }
    let is_zero = |u: fn(Vec3) -> f32, v: fn(Vec3) -> f32| {
        let [a, b, c] = [a, b, c].map(|p| [f64::from(u(p)), f64::from(v(p))]);
        // (b - a) x (c - a) multiplied out; products of two f32 are exact in f64.
        let terms = [b[0] * c[1], -b[0] * a[1], -a[0] * c[1], -b[1] * c[0], b[1] * a[0], a[1] * c[0]];
        exact_sum_is_zero(terms)
    };
    is_zero(|p| p.x, |p| p.y) && is_zero(|p| p.y, |p| p.z) && is_zero(|p| p.z, |p| p.x)
}

/// Whether the sum is 0 without rounding: an expansion grown by Knuth's two-sum (Shewchuk 1997) is 0 only if each of
/// its parts is.
fn exact_sum_is_zero(terms: [f64; 6]) -> bool {
    let mut parts = [0.0; 6];
    for (n, &term) in terms.iter().enumerate() {
        let mut carry = term;
        for part in &mut parts[..n] {
            let sum = carry + *part;
            let back = sum - carry;
            *part = (carry - (sum - back)) + (*part - back);
            carry = sum;
        }
        parts[n] = carry;
    }
    parts == [0.0; 6]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    #[test]
    fn exact_zero_area_is_told_from_the_smallest_area() {
        let a = Vec3::new(0.1, 0.2, 0.3);
        // Multiples by powers of two lie exactly on a line through the origin.
        assert!(is_degenerate(a, a * 2.0, a * 8.0));
        assert!(is_degenerate(a, a, Vec3::X));
        assert!(is_degenerate(a, Vec3::X, a));
        let mut off = a * 8.0;
        off.y = off.y.next_up();
        assert!(!is_degenerate(a, a * 2.0, off));
        assert!(!is_degenerate(Vec3::ZERO, Vec3::X * 1e-38, Vec3::Y * 1e-38));
        assert!(!is_degenerate(Vec3::splat(1.0), Vec3::new(1e30, 1.0, 1.0), Vec3::new(1.0, 1e-30, 1.0)));
    }

    #[test]
    fn degeneracy_agrees_with_integer_arithmetic() {
        let mut rng = SplitMix64(3);
        let (mut zero, mut not) = (0, 0);
        for _ in 0..200_000 {
            let points: [[i64; 3]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| (rng.next_u64() % 7) as i64 * 1_048_573 - 3_000_000));
            let [p, q, r] = points;
            let d = |i: usize, j: usize| (q[i] - p[i]) * (r[j] - p[j]) - (q[j] - p[j]) * (r[i] - p[i]);
            let expected = d(0, 1) == 0 && d(1, 2) == 0 && d(2, 0) == 0;
            let [a, b, c] = points.map(|p| Vec3::from_array(p.map(|v| v as f32)));
            assert_eq!(is_degenerate(a, b, c), expected, "{points:?}");
            if expected { zero += 1 } else { not += 1 }
        }
        assert!(zero > 100 && not > 100);
    }
}
