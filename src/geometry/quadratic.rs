//! Roots of a t² + 2 b t + c without cancellation.

/// Both roots in order, from the coefficients and `sqrt(b² - a c)` (computed by the caller in a form that does not
/// cancel). The larger one in magnitude is q / a, the other c / q: finite also where `a` vanishes (Numerical Recipes
/// 5.6).
#[inline(always)]
pub(super) fn roots(a: f64, b: f64, c: f64, sqrt_disc: f64) -> (f64, f64) {
    let q = -(b + sqrt_disc.copysign(b));
    if q == 0.0 {
        return (0.0, 0.0); // b = c = 0: a double root where the line starts.
    }
    let (t0, t1) = (q / a, c / q);
    if t0 < t1 { (t0, t1) } else { (t1, t0) }
}

/// The school formula in f32: both roots, or `None`.
#[inline(always)]
pub(super) fn classic_roots_f32(a: f32, b: f32, c: f32) -> Option<[f32; 2]> {
    let disc = b * b - a * c;
    if disc < 0.0 {
        return None;
    }
    let root = disc.sqrt();
    Some([(-b - root) / a, (-b + root) / a])
}
