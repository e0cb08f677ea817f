//! Intervals of t, each end with the number of the face that makes it.

use super::Ray;

/// Where a line is inside a convex set: from `enter` to `exit`, with the faces met there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub enter: f64,
    pub exit: f64,
    pub enter_face: u32,
    pub exit_face: u32,
}

impl Interval {
    /// The whole line.
    pub const ALL: Interval = Interval { enter: f64::NEG_INFINITY, exit: f64::INFINITY, enter_face: 0, exit_face: 0 };

    /// The part inside of another convex set. Written so that a NaN bound changes nothing: it comes from a ray that
    /// runs inside of a bounding plane, where the plane does not bound.
    #[inline(always)]
    pub fn clip(&mut self, enter: f64, enter_face: u32, exit: f64, exit_face: u32) {
        if enter > self.enter {
            (self.enter, self.enter_face) = (enter, enter_face);
        }
        if exit < self.exit {
            (self.exit, self.exit_face) = (exit, exit_face);
        }
    }

    /// The part between the planes at -1 (face `low_face`) and +1 (`high_face`) of an axis on which the ray starts at
    /// `o` and moves by `d`: Williams et al. 2005 with sign-ordered planes, divisions instead of a rounded reciprocal.
    #[inline(always)]
    pub fn clip_slab(&mut self, o: f64, d: f64, low_face: u32, high_face: u32) {
        if d.is_sign_negative() {
            self.clip((1.0 - o) / d, high_face, (-1.0 - o) / d, low_face);
        } else {
            self.clip((-1.0 - o) / d, low_face, (1.0 - o) / d, high_face);
        }
    }

    /// The first end that lies on the ray, shifted by `t0`, with its face.
    #[inline(always)]
    pub fn first_on(&self, ray: &Ray, t0: f64) -> Option<(f64, u32)> {
        if self.enter > self.exit {
            return None;
        }
        let (enter, exit) = (self.enter + t0, self.exit + t0);
        if ray.contains(enter) {
            Some((enter, self.enter_face))
        } else {
            // A ray that starts inside leaves through `exit`; one whose entrance lies beyond t_max meets nothing.
            (enter <= ray.t_min && ray.contains(exit)).then_some((exit, self.exit_face))
        }
    }
}
