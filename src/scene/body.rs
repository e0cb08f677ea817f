//! Shapes in their place, as loops over rays in arrays meet them.

use crate::geometry::{Kernels, Ray, cuboid_surface, cylinder_surface};
use glam::{DAffine3, DMat3, DVec3};

/// A shape that is neither a mesh nor of one kind with others: every one is a type of its own, so that loops over rays
/// are, too. (The compiler left one loop for all shapes scalar but for two divisions.)
///
/// The functions are those that single rays use; floating-point operations are neither fused nor reordered by the
/// compiler, so every ray gets the bits that it gets alone.
pub(super) trait Body: Copy {
    /// Whether it has an inside, which rays that enter it must leave.
    const IS_SOLID: bool;

    /// Where a ray meets it first, and which face.
    fn meet<K: Kernels>(&self, ray: &Ray) -> Option<(f64, u32)>;

    /// The normal at a hit, out of the body and of any length. All in world space.
    fn normal(&self, ray: &Ray, t: f64, face: u32) -> DVec3;
}

/// The hit of a shape that has one face only.
macro_rules! whole {
    ($t:expr) => {
        match $t {
            Some(t) => Some((t, 0)),
            None => None,
        }
    };
}

/// A sphere that is round in world space, met there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub centre: DVec3,
    pub radius: f64,
}

impl Body for Ball {
    const IS_SOLID: bool = true;

    #[inline(always)]
    fn meet<K: Kernels>(&self, ray: &Ray) -> Option<(f64, u32)> {
        whole!(K::sphere(ray, self.centre, self.radius))
    }

    #[inline(always)]
    fn normal(&self, ray: &Ray, t: f64, _face: u32) -> DVec3 {
        ray.at(t) - self.centre
    }
}

/// Shapes that are met in a space of their own.
macro_rules! bodies {
    ($($(#[$doc:meta])* $name:ident, $is_solid:literal, |$ray:ident| $hit:expr, |$point:ident, $face:ident| $normal:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $name {
            /// Object from world.
            pub inverse: DAffine3,
            /// Takes normals into the world.
            pub normal: DMat3,
        }

        impl Body for $name {
            const IS_SOLID: bool = $is_solid;

            #[inline(always)]
            fn meet<K: Kernels>(&self, ray: &Ray) -> Option<(f64, u32)> {
                let $ray = &ray.transformed(&self.inverse);
                $hit
            }

            #[inline(always)]
            fn normal(&self, ray: &Ray, t: f64, $face: u32) -> DVec3 {
                let $point = self.inverse.transform_point3(ray.at(t));
                self.normal * $normal
            }
        }
    )*};
}

bodies! {
    /// Other spheres.
    Ellipsoid, true, |ray| whole!(K::sphere(ray, DVec3::ZERO, 1.0)), |point, _face| point;
    /// A cuboid.
    Cuboid, true, |ray| K::cuboid(ray), |point, face| cuboid_surface(point, face).normal;
    /// A cylinder.
    Cylinder, true, |ray| K::cylinder(ray), |point, face| cylinder_surface(point, face).normal;
    /// A cone.
    Cone, true, |ray| K::cone(ray), |point, face| {
        // Without the divisions of `cone_surface`. The compiler leaves the loop of `passage` over cones scalar, with or
        // without them.
        let rho = (point.x * point.x + point.z * point.z).sqrt();
        if face == 0 { DVec3::new(point.x, 0.5 * rho, point.z) } else { DVec3::NEG_Y }
    };
    /// A plane.
    Plane, true, |ray| whole!(K::plane(ray)), |_point, _face| DVec3::Y;
    /// A quad.
    Quad, false, |ray| whole!(K::quad(ray)), |_point, _face| DVec3::Y;
}

/// Does something with the [`Body`] of an object, which each shape has a type of its own for.
macro_rules! with_body {
    ($object:expr, |$body:ident| $do:expr) => {{
        use $crate::scene::{Shape, body};
        let object = $object;
        let (inverse, normal) = (object.map.inverse, object.map.normal);
        match object.shape {
            Shape::Ball { centre, radius } => with_body!(@ $body = body::Ball { centre, radius }, $do),
            Shape::Ellipsoid => with_body!(@ $body = body::Ellipsoid { inverse, normal }, $do),
            Shape::Cuboid => with_body!(@ $body = body::Cuboid { inverse, normal }, $do),
            Shape::Cylinder => with_body!(@ $body = body::Cylinder { inverse, normal }, $do),
            Shape::Cone => with_body!(@ $body = body::Cone { inverse, normal }, $do),
            Shape::Plane => with_body!(@ $body = body::Plane { inverse, normal }, $do),
            Shape::Quad => with_body!(@ $body = body::Quad { inverse, normal }, $do),
            Shape::Mesh(_) => unreachable!("meshes are met triangle by triangle"),
        }
    }};
    (@ $body:ident = $value:expr, $do:expr) => {{
        let $body = $value;
        $do
    }};
}
pub(super) use with_body;
