//! One ray against eight boxes.

use super::Lanes;

/// Reciprocal direction, constants of the near and the far planes, and t_min, spread over lanes; which rows of planes are near
/// and which far.
#[derive(Clone, Copy)]
pub struct SlabLanes<L: Lanes> {
    reciprocal: [L::V; 3],
    near: [L::V; 3],
    far: [L::V; 3],
    t_min: L::V,
    entry_factor: L::V,
    /// Row of the near plane of each axis; the far one is its neighbour, row ^ 1.
    rows: [usize; 3],
}

impl<L: Lanes> SlabLanes<L> {
    /// Spreads a slab's numbers.
    #[inline(always)]
    pub fn new(lanes: L, reciprocal: [f32; 3], [near, far]: [[f32; 3]; 2], t_min: f32, entry_factor: f32) -> Self {
        let row = |axis: usize| 2 * axis + usize::from(reciprocal[axis] < 0.0);
        let spread = |v: [f32; 3]| [lanes.splat(v[0]), lanes.splat(v[1]), lanes.splat(v[2])];
        Self {
            reciprocal: spread(reciprocal),
            near: spread(near),
            far: spread(far),
            t_min: lanes.splat(t_min),
            entry_factor: lanes.splat(entry_factor),
            rows: [row(0), row(1), row(2)],
        }
    }

    /// plane * reciprocal - constant, the largest of the near and the smallest of the far ones. `min` and `max` return their
    /// second argument where the first is NaN, so a NaN (from overflow) bounds nothing.
    #[inline(always)]
    pub fn entries(&self, lanes: L, planes: &[[f32; 8]; 6], limit: f32) -> (u32, L::V) {
        // SAFETY: `new` makes rows below 6. The six checks a node took 5 % of single rays.
        let row = |row: usize| lanes.load(unsafe { planes.get_unchecked(row) });
        let near = |k: usize| lanes.mul_sub(row(self.rows[k]), self.reciprocal[k], self.near[k]);
        let far = |k: usize| lanes.mul_sub(row(self.rows[k] ^ 1), self.reciprocal[k], self.far[k]);
        let enter = lanes.max(near(2), lanes.max(near(1), lanes.max(near(0), self.t_min)));
        let enter = lanes.mul(enter, self.entry_factor);
        let exit = lanes.min(far(2), lanes.min(far(1), lanes.min(far(0), lanes.splat(limit))));
        (lanes.le(enter, exit), enter)
    }
}
