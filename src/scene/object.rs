//! Things in the scene, placed.

use super::mesh::Mesh;
use crate::description::ShapeDesc;
use crate::geometry::Aabb;
use crate::math::Affine;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A shape with its place.
#[derive(Clone, Debug)]
pub struct Object {
    /// Form, in object space.
    pub shape: Shape,
    /// World from object.
    pub map: Affine,
    /// Index of the `[[object]]` that it comes from.
    pub source: u32,
    /// Volume in world space; infinite for planes, 0 for quads. Ranks overlapping media.
    pub volume: f64,
    /// Bounds the error of points on the surface: `error_scale * max(|point|, reach)`.
    pub error_scale: f64,
    /// Unit normals in world space of flat faces that look along x, y and z in object space.
    pub(super) axes: [DVec3; 3],
    /// Distance of the world's origin from the far side of the object (0 for planes).
    pub reach: f64,
}

/// A form in its canonical object space (see `geometry`).
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere that is round in world space, met there.
    Ball {
        /// World space.
        centre: DVec3,
        /// World space.
        radius: f64,
    },
    /// A sphere that is stretched.
    Ellipsoid,
    /// [-1, 1]³
    Cuboid,
    /// Radius 1, y in [-1, 1]
    Cylinder,
    /// Base of radius 1 at y = -1, apex at y = 1
    Cone,
    /// y = 0
    Plane,
    /// y = 0, x and z in [-1, 1]
    Quad,
    /// Triangles
    Mesh(Arc<Mesh>),
}

/// Offset of 64 half-ulps of the largest coordinate: numerics.md, section 2, "f64 re-projected P + 16 (also 64) ulp".
const ERROR: f64 = 64.0 / 9_007_199_254_740_992.0;

impl Object {
    /// Places a shape.
    pub(super) fn new(shape: Shape, world_from_shape: Affine, source: u32) -> Self {
        let det = world_from_shape.forward.matrix3.determinant().abs();
        let volume = det
            * match &shape {
                Shape::Ball { .. } | Shape::Ellipsoid => 4.0 / 3.0 * PI,
                Shape::Cuboid => 8.0,
                Shape::Cylinder => 2.0 * PI,
                Shape::Cone => 2.0 / 3.0 * PI,
                Shape::Plane => f64::INFINITY,
                Shape::Quad => 0.0,
                Shape::Mesh(mesh) => mesh.volume,
            };
        // Shapes bounded by planes along their axes are met axis by axis; for the others errors along a long axis reach
        // the short ones through products.
        let condition = match &shape {
            Shape::Cuboid | Shape::Plane | Shape::Quad => 1.0,
            _ => world_from_shape.condition,
        };
        let axes = DVec3::AXES.map(|axis| normal_of(&world_from_shape, axis));
        let mut object =
            Self { shape, map: world_from_shape, axes, source, volume, error_scale: ERROR * condition, reach: 0.0 };
        if let Some(bounds) = object.bounds() {
            object.reach = bounds.lower.abs().max(bounds.upper.abs()).as_dvec3().length();
        } else {
            object.reach = object.map.forward.translation.length();
        }
        object
    }

    /// Whether a ray that leaves it does not meet it again.
    pub fn is_convex(&self) -> bool {
        !matches!(self.shape, Shape::Mesh(_))
    }

    /// Centre and radius of a sphere around it in world space; infinite for planes and for meshes without triangles.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        let Some(bounds) = self.bounds() else { return (DVec3::ZERO, f64::INFINITY) };
        let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
        let around_box = (upper - lower).length() / 2.0;
        match self.shape {
            // Rounding of the map is covered by the factor.
            Shape::Ball { centre, radius } => (centre, radius * 1.000_000_1),
            _ => ((lower + upper) / 2.0, around_box * 1.000_000_1),
        }
    }

    /// Its box in world space; `None` if it is infinite.
    pub fn bounds(&self) -> Option<Aabb> {
        let map: &DAffine3 = &self.map.forward;
        Some(match &self.shape {
            Shape::Ball { .. } | Shape::Ellipsoid => Aabb::of_ball(map),
            Shape::Cuboid | Shape::Cylinder | Shape::Cone => Aabb::of_box(map, DVec3::NEG_ONE, DVec3::ONE),
            Shape::Quad => Aabb::of_box(map, DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0)),
            Shape::Mesh(mesh) if mesh.is_empty() => return None,
            Shape::Mesh(mesh) => Aabb::of_box(map, mesh.bounds().lower.as_dvec3(), mesh.bounds().upper.as_dvec3()),
            Shape::Plane => return None,
        })
    }
}

fn normal_of(map: &Affine, normal: DVec3) -> DVec3 {
    (map.normal * normal).normalize_or(DVec3::Y)
}

/// The map from a shape's canonical space to the space that its description speaks of.
pub(super) fn canonical_scale(shape: &ShapeDesc) -> DVec3 {
    match *shape {
        ShapeDesc::Sphere { radius } => DVec3::splat(radius),
        ShapeDesc::Cuboid { size } => size / 2.0,
        ShapeDesc::Cylinder { radius, height } | ShapeDesc::Cone { radius, height } => {
            DVec3::new(radius, height / 2.0, radius)
        }
        // Any thickness would do; one of the quad's own size keeps the map well conditioned at every scale.
        ShapeDesc::Quad { size } => DVec3::new(size.x, size.max_element(), size.y) / 2.0,
        ShapeDesc::Plane | ShapeDesc::Mesh { .. } | ShapeDesc::Spheres { .. } => DVec3::ONE,
    }
}
