//! Affine maps with their inverses.

use glam::{DAffine3, DMat3, DQuat, DVec3};

/// An invertible affine map of 3-space, kept with its inverse and with what error bounds need to know of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The map itself (target from source, such as world from object).
    pub forward: DAffine3,
    /// Its inverse.
    pub inverse: DAffine3,
    /// Cofactor matrix of the linear part, signed by the determinant: takes outward normals to outward normals, for
    /// mirrored maps too. Not normalised.
    pub normal: DMat3,
    /// Bound on the condition number of the linear part (Frobenius norms): how much relative error the inverse may
    /// magnify. At least 1.
    pub condition: f64,
}

/// Above this condition number a map is treated as singular: half the digits of f64 would be gone.
const MAX_CONDITION: f64 = 1e8;

impl Affine {
    /// The identity.
    pub const IDENTITY: Affine =
        Affine { forward: DAffine3::IDENTITY, inverse: DAffine3::IDENTITY, normal: DMat3::IDENTITY, condition: 1.0 };

    /// `None` if the map is singular, close to it (condition number above 1e8) or not finite.
    pub fn new(forward: DAffine3) -> Option<Self> {
        let m = forward.matrix3;
        let inverse = forward.inverse();
        let frobenius =
            |m: &DMat3| (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt();
        let condition = frobenius(&m) * frobenius(&inverse.matrix3) / 3.0;
        if !forward.is_finite() || !inverse.is_finite() || !condition.is_finite() || condition > MAX_CONDITION {
            return None;
        }
        let cofactor = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let normal = cofactor * m.determinant().signum();
        Some(Self { forward, inverse, normal, condition: condition.max(1.0) })
    }

    /// Scale first, then rotation about x, then y, then z (degrees), then translation.
    pub fn from_scale_rotate_translate(scale: DVec3, rotate_degrees: DVec3, translate: DVec3) -> Option<Self> {
        let angle = |d: f64| d.to_radians();
        let rotation = DQuat::from_rotation_z(angle(rotate_degrees.z))
            * DQuat::from_rotation_y(angle(rotate_degrees.y))
            * DQuat::from_rotation_x(angle(rotate_degrees.x));
        let linear = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
        Self::new(DAffine3 { matrix3: linear, translation: translate })
    }

    /// The uniform scale factor if the linear part is a rotation (or reflection) times a scale to within rounding.
    pub fn uniform_scale(&self) -> Option<f64> {
        let m = self.forward.matrix3;
        let (x, y, z) = (m.x_axis.length_squared(), m.y_axis.length_squared(), m.z_axis.length_squared());
        let skew = m.x_axis.dot(m.y_axis).abs() + m.y_axis.dot(m.z_axis).abs() + m.z_axis.dot(m.x_axis).abs();
        let close = |a: f64| (a - x).abs() <= 1e-14 * x;
        (close(y) && close(z) && skew <= 1e-14 * x).then(|| x.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_is_about_x_then_y_then_z() {
        let a = Affine::from_scale_rotate_translate(DVec3::ONE, DVec3::new(90.0, 0.0, 90.0), DVec3::ZERO).unwrap();
        // y goes to z about x, z stays z about z.
        assert!((a.forward.transform_point3(DVec3::Y) - DVec3::Z).length() < 1e-15);
    }

    #[test]
    fn a_flat_scale_is_refused_and_a_mirrored_one_keeps_normals_outward() {
        assert!(Affine::from_scale_rotate_translate(DVec3::new(1.0, 0.0, 1.0), DVec3::ZERO, DVec3::ZERO).is_none());
        let mirrored =
            Affine::from_scale_rotate_translate(DVec3::new(-1.0, 1.0, 1.0), DVec3::ZERO, DVec3::ZERO).unwrap();
        // The outward normal at +x of a body becomes the outward normal at -x.
        assert!((mirrored.normal * DVec3::X).normalize().distance(DVec3::NEG_X) < 1e-15);
        assert!((mirrored.normal * DVec3::Y).normalize().distance(DVec3::Y) < 1e-15);
    }

    #[test]
    fn only_similarities_have_a_uniform_scale() {
        let spin = DVec3::new(10.0, 20.0, 30.0);
        let a = Affine::from_scale_rotate_translate(DVec3::splat(2.5), spin, DVec3::ONE).unwrap();
        assert!((a.uniform_scale().unwrap() - 2.5).abs() < 1e-14);
        assert!(
            Affine::from_scale_rotate_translate(DVec3::new(1.0, 1.0, 1.1), spin, DVec3::ONE)
                .unwrap()
                .uniform_scale()
                .is_none()
        );
    }
}
