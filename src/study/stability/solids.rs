//! Lines against solids in double-double arithmetic, by the textbook formulas: with 31 digits nothing cancels that
//! matters.

use super::oracle::{Dd, DdVec3};
use crate::geometry::Ray;
use glam::DVec3;

/// Where a line is inside of a convex solid.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// t of the entrance.
    pub enter: Dd,
    /// t of the exit.
    pub exit: Dd,
}

impl Chord {
    /// The whole line.
    fn all() -> Self {
        Self { enter: -Dd::INFINITY, exit: Dd::INFINITY }
    }

    fn clip(&mut self, enter: Dd, exit: Dd) {
        if enter > self.enter {
            self.enter = enter;
        }
        if exit < self.exit {
            self.exit = exit;
        }
    }

    /// The part between -1 and 1 of an axis on which the line starts at `o` and moves by `d`; `None` beside it.
    fn clip_slab(&mut self, o: Dd, d: Dd) -> Option<()> {
        if d == Dd::ZERO {
            return (o.abs() <= Dd::ONE).then_some(());
        }
        let (a, b) = ((-Dd::ONE - o) / d, (Dd::ONE - o) / d);
        if a < b {
            self.clip(a, b)
        } else {
            self.clip(b, a)
        }
        Some(())
    }

    /// The chord, if there is one.
    fn if_any(self) -> Option<Self> {
        (self.enter <= self.exit).then_some(self)
    }

    /// The first end in front of the ray's start.
    pub fn first(&self) -> Option<Dd> {
        [self.enter, self.exit].into_iter().find(|&t| t > Dd::ZERO)
    }
}

/// The roots of a t² + 2 b t + c, a != 0, in order.
fn roots(a: Dd, b: Dd, c: Dd) -> Option<(Dd, Dd)> {
    let disc = b * b - a * c;
    if disc < Dd::ZERO {
        return None;
    }
    let root = disc.sqrt();
    let (s, t) = ((-b - root) / a, (-b + root) / a);
    Some(if s < t { (s, t) } else { (t, s) })
}

/// The ball.
pub fn sphere(ray: &Ray, centre: DVec3, radius: f64) -> Option<Chord> {
    let (d, f) = (DdVec3::from(ray.direction), DdVec3::from(ray.origin).minus(centre.into()));
    let (a, b, r) = (d.dot(d), f.dot(d), Dd::from(radius));
    // The discriminant through the distance of the line from the centre, so that 31 digits last for any distance.
    let across = f.cross(d);
    let disc = r * r * a - across.dot(across);
    if disc < Dd::ZERO {
        return None;
    }
    let root = disc.sqrt();
    Some(Chord { enter: (-b - root) / a, exit: (-b + root) / a })
}

/// The cylinder of radius 1 about y, capped at y = ±1.
pub fn cylinder(ray: &Ray) -> Option<Chord> {
    let (DdVec3([ox, oy, oz]), DdVec3([dx, dy, dz])) = (ray.origin.into(), ray.direction.into());
    let mut chord = Chord::all();
    chord.clip_slab(oy, dy)?;
    let (a, c) = (dx * dx + dz * dz, ox * ox + oz * oz - Dd::ONE);
    if a == Dd::ZERO {
        return if c > Dd::ZERO { None } else { chord.if_any() };
    }
    let (near, far) = roots(a, ox * dx + oz * dz, c)?;
    chord.clip(near, far);
    chord.if_any()
}

/// The cone with its base of radius 1 at y = -1 and its apex at y = 1.
pub fn cone(ray: &Ray) -> Option<Chord> {
    let (DdVec3([ox, oy, oz]), DdVec3([dx, dy, dz])) = (ray.origin.into(), ray.direction.into());
    let mut chord = Chord::all();
    chord.clip_slab(oy, dy)?;
    // x² + z² = w² / 4 at w below the apex.
    let (ow, dw, quarter) = (Dd::ONE - oy, -dy, Dd::from(0.25));
    let a = dx * dx + dz * dz - quarter * dw * dw;
    let b = ox * dx + oz * dz - quarter * ow * dw;
    let c = ox * ox + oz * oz - quarter * ow * ow;
    if a == Dd::ZERO {
        if b == Dd::ZERO {
            return if c > Dd::ZERO { None } else { chord.if_any() };
        }
        let root = -c / (b + b);
        if b > Dd::ZERO {
            chord.clip(-Dd::INFINITY, root)
        } else {
            chord.clip(root, Dd::INFINITY)
        }
        return chord.if_any();
    }
    let crossings = roots(a, b, c);
    if a > Dd::ZERO {
        let (near, far) = crossings?;
        chord.clip(near, far);
    } else if let Some((near, far)) = crossings {
        // Inside before the first and behind the second, each in a nappe of its own; ours is the one below the apex.
        if dw > Dd::ZERO { chord.clip(far, Dd::INFINITY) } else { chord.clip(-Dd::INFINITY, near) }
    }
    chord.if_any()
}

/// t where the ray meets the plane of a triangle.
pub fn triangle_plane(ray: &Ray, corners: [DVec3; 3]) -> Dd {
    let [a, b, c] = corners.map(DdVec3::from);
    let normal = b.minus(a).cross(c.minus(a));
    a.minus(ray.origin.into()).dot(normal) / DdVec3::from(ray.direction).dot(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_through_the_middle_are_what_anybody_can_work_out() {
        let chord = |c: Option<Chord>| c.map(|c| (c.enter.to_f64(), c.exit.to_f64()));
        let ray = |o: [f64; 3], d: [f64; 3]| Ray::new(o.into(), d.into());
        let level = ray([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        assert_eq!(chord(sphere(&level, DVec3::X, 2.0)), Some((2.0, 6.0)));
        assert_eq!(chord(cylinder(&level)), Some((2.0, 4.0)));
        assert_eq!(chord(cone(&level)), Some((2.5, 3.5)));
        let down = ray([0.0, 5.0, 0.0], [0.0, -2.0, 0.0]);
        assert_eq!(chord(cylinder(&down)), Some((2.0, 3.0)));
        assert_eq!(chord(cone(&down)), Some((2.0, 3.0)));
        // Parallel to a generator, through the axis at y = 0.
        assert_eq!(chord(cone(&ray([0.0, 0.0, 0.0], [0.5, -1.0, 0.0]))), Some((-0.5, 1.0)));
        // Over the apex, beside the wall, and through the nappe that is not there.
        for missed in [ray([-3.0, 1.5, 0.0], [1.0, 0.0, 0.0]), ray([1.1, 3.0, 0.0], [0.0, -1.0, 0.0])] {
            assert!(cone(&missed).is_none() && cylinder(&missed).is_none());
        }
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(triangle_plane(&ray([0.0, 0.0, 3.0], [1.0, 1.0, -2.0]), corners).to_f64(), 1.5);
    }
}
