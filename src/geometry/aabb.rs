//! Axis-aligned boxes.

use glam::{DAffine3, DVec3, Vec3};

/// Box of all points between two corners, in f32, rounded outward wherever it is made from f64. Empty if
/// `lower > upper`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub lower: Vec3,
    /// Largest coordinates.
    pub upper: Vec3,
}

impl Aabb {
    /// The box of no points.
    pub const EMPTY: Aabb = Aabb { lower: Vec3::INFINITY, upper: Vec3::NEG_INFINITY };

    /// The box of the given points.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { lower: b.lower.min(p), upper: b.upper.max(p) })
    }

    /// The smallest f32 box that holds the f64 box.
    pub fn rounded_outward(lower: DVec3, upper: DVec3) -> Self {
        let down = |v: f64| if f64::from(v as f32) > v { (v as f32).next_down() } else { v as f32 };
        let up = |v: f64| if f64::from(v as f32) < v { (v as f32).next_up() } else { v as f32 };
        Self {
            lower: Vec3::new(down(lower.x), down(lower.y), down(lower.z)),
            upper: Vec3::new(up(upper.x), up(upper.y), up(upper.z)),
        }
    }

    /// Holds the image of the unit ball under `map`.
    pub fn of_ball(map: &DAffine3) -> Self {
        let rows = map.matrix3.transpose();
        Self::around(map.translation, DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()))
    }

    /// Holds the image of the box from `lower` to `upper` under `map`.
    pub fn of_box(map: &DAffine3, lower: DVec3, upper: DVec3) -> Self {
        let (centre, half) = ((lower + upper) / 2.0, (upper - lower) / 2.0);
        let m = map.matrix3;
        Self::around(
            map.transform_point3(centre),
            m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z,
        )
    }

    /// The box `centre ± half`, widened by more than the rounding errors of computing the two.
    fn around(centre: DVec3, half: DVec3) -> Self {
        let pad = DVec3::splat(16.0 * 2f64.powi(-53) * (centre.abs().max_element() + half.max_element()));
        Self::rounded_outward(centre - half - pad, centre + half + pad)
    }

    /// The box of both.
    pub fn union(self, other: Self) -> Self {
        Self { lower: self.lower.min(other.lower), upper: self.upper.max(other.upper) }
    }

    /// Half the surface area, 0 if empty.
    pub fn half_area(&self) -> f32 {
        let d = (self.upper - self.lower).max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// Whether `other` lies inside, borders included.
    pub fn encloses(&self, other: &Aabb) -> bool {
        self.lower.cmple(other.lower).all() && self.upper.cmpge(other.upper).all()
    }

    /// Whether the two have a point in common, borders included.
    pub fn overlaps(&self, other: &Aabb) -> bool {
        self.lower.cmple(other.upper).all() && self.upper.cmpge(other.lower).all()
    }

    /// A lower bound on the distance between points of the two: the widest gap along an axis, 0 if they overlap.
    pub fn distance(&self, other: &Aabb) -> f64 {
        let gap = |lower: Vec3, upper: Vec3| (lower.as_dvec3() - upper.as_dvec3()).max_element();
        gap(self.lower, other.upper).max(gap(other.lower, self.upper)).max(0.0)
    }

    /// The largest absolute coordinate, 0 if empty.
    pub fn max_abs(&self) -> f64 {
        if self.lower.x > self.upper.x { 0.0 } else { f64::from(self.lower.abs().max(self.upper.abs()).max_element()) }
    }
}
