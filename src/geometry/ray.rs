//! Rays and what traversal returns.

use glam::{DAffine3, DVec3};

/// The points `origin + t * direction` with `t_min < t <= t_max`. World or object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: DVec3,
    /// Not zero; of unit length in world space.
    pub direction: DVec3,
    /// Hits at or before this do not count.
    pub t_min: f64,
    /// Hits beyond this do not count.
    pub t_max: f64,
}

impl Ray {
    /// Everything in front of `origin`, at finite distance: a ray that runs along a plane does not meet it at infinity.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::MAX }
    }

    /// The point at `t`.
    #[inline(always)]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The same ray in another space; t means the same point.
    #[inline(always)]
    pub fn transformed(&self, target_from_source: &DAffine3) -> Self {
        Self {
            origin: target_from_source.transform_point3(self.origin),
            direction: target_from_source.transform_vector3(self.direction),
            ..*self
        }
    }

    /// Whether `t` lies on the ray.
    #[inline(always)]
    pub fn contains(&self, t: f64) -> bool {
        t > self.t_min && t <= self.t_max
    }
}

/// What traversal returns: which primitive is met and where on the ray. Small; see
/// [`SurfaceInteraction`](super::SurfaceInteraction) for the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f64,
    /// Index of the object in the scene.
    pub object: u32,
    /// Which triangle of a mesh or face of a shape.
    pub primitive: u32,
    /// Weight of the triangle's second corner (0 for other shapes).
    pub u: f64,
    /// Weight of the triangle's third corner (0 for other shapes).
    pub v: f64,
}

/// Hits of two objects that are nearer to each other than this part of t are one place: the rounding of t along rays
/// that do not graze, far below what can be seen between two faces.
const SAME_PLACE: f64 = 1.0 / 35_184_372_088_832.0; // 2^-45

impl Hit {
    /// Where a hit must lie at most to be in the same place as this one.
    #[inline(always)]
    pub fn reach(&self) -> f64 {
        self.t * (1.0 + SAME_PLACE)
    }

    /// Whether this hit is in the same place as one with another object, which comes first or not by its number.
    #[inline(always)]
    pub fn ties(&self, other: &Hit) -> bool {
        (self.object != other.object) & ((self.t - other.t).abs() <= other.t * SAME_PLACE)
    }

    /// Whether this hit wins over `other`: nearer, or in the same place and of the smaller object, or of the same
    /// object at the same t and of the smaller primitive. So of two objects whose faces coincide up to rounding one is
    /// seen, not specks of both, and the winner does not depend on the order of traversal.
    ///
    /// No rule that takes near for equal is transitive: of three objects each of which ties with the next but not with
    /// the one after (three faces within 2⁻⁴⁴ of t, yet not within 2⁻⁴⁵), each may beat another one, and the first
    /// asked decides which two are compared. Any of them is a right answer, since they are one place; and pictures stay
    /// reproducible because the order is a function of ray and scene: that of the objects in small scenes, alone and in
    /// packets; that of the tree in others, where rays with a tie leave the packet, and the tree is the same for any
    /// number of threads.
    #[inline(always)]
    pub fn beats(&self, other: &Hit) -> bool {
        // Without branches, so that loops over rays become vector code.
        let same_place = self.ties(other);
        let before = (self.t < other.t) | ((self.t == other.t) & (self.primitive < other.primitive));
        (same_place & (self.object < other.object)) | (!same_place & before)
    }
}
