//! One ray against eight boxes.

use super::Lanes;

/// What planes are met with, the near and the far ones, and t_min, spread over lanes; which rows of planes are near and
/// which far.
#[derive(Clone, Copy)]
pub struct SlabLanes<L: Lanes> {
    near: Planes<L>,
    far: Planes<L>,
    t_min: L::V,
    /// Row of the near plane of each axis; the far one is its neighbour, row ^ 1.
    rows: [usize; 3],
}

/// A plane across an axis is met at its coordinate times `reciprocal` less `constant`.
#[derive(Clone, Copy)]
struct Planes<L: Lanes> {
    reciprocal: [L::V; 3],
    constant: [L::V; 3],
}

impl<L: Lanes> Planes<L> {
    #[inline(always)]
    fn new(lanes: L, [reciprocal, constant]: [[f32; 4]; 2]) -> Self {
        Self { reciprocal: lanes.splat3(reciprocal), constant: lanes.splat3(constant) }
    }
}

impl<L: Lanes> SlabLanes<L> {
    /// Spreads a slab's numbers: the first three reciprocals and constants of the near planes, and of the far ones.
    #[inline(always)]
    pub fn new(lanes: L, near: [[f32; 4]; 2], far: [[f32; 4]; 2], t_min: f32) -> Self {
        let [x, y, z, _] = far[0].map(|reciprocal| usize::from(reciprocal < 0.0));
        let (near, far) = (Planes::new(lanes, near), Planes::new(lanes, far));
        Self { near, far, t_min: lanes.splat(t_min), rows: [x, 2 + y, 4 + z] }
    }

    /// The largest of the near and the smallest of the far planes, two by two. `min` and `max` return their second
    /// argument where one is NaN, so a NaN (from overflow) bounds nothing.
    #[inline(always)]
    pub fn entries(&self, lanes: L, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        let met = |row: usize, with: &Planes<L>, k: usize| {
            // SAFETY: `new` makes rows below 6. The six checks a node took 5 % of single rays.
            let row = lanes.load(unsafe { planes.get_unchecked(row) });
            lanes.mul_sub(row, with.reciprocal[k], with.constant[k])
        };
        let near = |k: usize| met(self.rows[k], &self.near, k);
        let far = |k: usize| met(self.rows[k] ^ 1, &self.far, k);
        let enter = lanes.max(lanes.max(near(0), near(1)), lanes.max(near(2), self.t_min));
        let exit = lanes.min(lanes.min(far(0), far(1)), lanes.min(far(2), lanes.splat(limit)));
        (lanes.bits(lanes.le(enter, exit)), enter)
    }
}
