//! One ray against eight boxes.

use super::Lanes;

/// Reciprocal directions and constants of the near and the far planes, and t_min, spread over lanes; which rows of planes are
/// near and which far.
#[derive(Clone, Copy)]
pub struct SlabLanes<L: Lanes> {
    near: [Plane<L>; 3],
    far: [Plane<L>; 3],
    t_min: L::V,
    /// Row of the near plane of each axis; the far one is its neighbour, row ^ 1.
    rows: [usize; 3],
}

/// A plane is met at its coordinate times `reciprocal` less `constant`.
#[derive(Clone, Copy)]
struct Plane<L: Lanes> {
    reciprocal: L::V,
    constant: L::V,
}

impl<L: Lanes> SlabLanes<L> {
    /// Spreads a slab's numbers: the first three reciprocals and constants of the near planes, and of the far ones.
    #[inline(always)]
    pub fn new(lanes: L, near: [[f32; 4]; 2], far: [[f32; 4]; 2], t_min: f32) -> Self {
        let row = |axis: usize| 2 * axis + usize::from(far[0][axis] < 0.0);
        let spread = |[reciprocal, constant]: [[f32; 4]; 2]| {
            let (reciprocal, constant) = (lanes.splat3(reciprocal), lanes.splat3(constant));
            let plane = |axis: usize| Plane { reciprocal: reciprocal[axis], constant: constant[axis] };
            [plane(0), plane(1), plane(2)]
        };
        Self { near: spread(near), far: spread(far), t_min: lanes.splat(t_min), rows: [row(0), row(1), row(2)] }
    }

    /// The largest of the near and the smallest of the far planes, two by two. `min` and `max` return their second argument where
    /// one is NaN, so a NaN (from overflow) bounds nothing.
    #[inline(always)]
    pub fn entries(&self, lanes: L, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        let met = |row: usize, plane: &Plane<L>| {
            // SAFETY: `new` makes rows below 6. The six checks a node took 5 % of single rays.
            let row = lanes.load(unsafe { planes.get_unchecked(row) });
            lanes.mul_sub(row, plane.reciprocal, plane.constant)
        };
        let near = |k: usize| met(self.rows[k], &self.near[k]);
        let far = |k: usize| met(self.rows[k] ^ 1, &self.far[k]);
        let enter = lanes.max(lanes.max(near(0), near(1)), lanes.max(near(2), self.t_min));
        let exit = lanes.min(lanes.min(far(0), far(1)), lanes.min(far(2), lanes.splat(limit)));
        (lanes.bits(lanes.le(enter, exit)), enter)
    }
}
