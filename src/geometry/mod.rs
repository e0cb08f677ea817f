//! Rays, boxes and shapes: the kernels that decide hits, and what is known of a surface where a ray meets it.
//!
//! Analytic shapes live in one canonical object space each; size, place and turn are in the transform:
//!
//! | shape | object space | primitive numbers |
//! |---|---|---|
//! | sphere | radius 1 about the origin | 0 |
//! | cuboid | [-1, 1]³ | 0..6: -x, +x, -y, +y, -z, +z |
//! | cylinder | radius 1 about y, y in [-1, 1] | 0 side, 1 bottom, 2 top |
//! | cone | base of radius 1 at y = -1, apex at y = 1 | 0 side, 1 base |
//! | plane | y = 0, outside is +y | 0 |
//! | quad | y = 0, x and z in [-1, 1] | 0 |
//!
//! A cuboid, a cylinder and a cone are intersections of convex sets, and so their hits are intersections of intervals
//! of t: no ray can slip between a side and its cap, whatever rounding does.
//!
//! Directions need not be of unit length: a ray keeps its t when it is taken to object space.
//!
//! [`Kernels`] bundles one kernel per shape into the presets that a scene chooses from.
//!
#![doc = include_str!("NUMERICS.md")]

mod aabb;
mod cone;
mod cuboid;
mod cylinder;
mod interaction;
mod interval;
mod kernels;
mod plane;
mod quadratic;
mod ray;
mod slab;
mod sphere;
mod triangle;

pub use aabb::Aabb;
pub use cone::{cone_intersect, cone_surface, cone_surface_at, cone_uv};
pub use cuboid::{cuboid_intersect, cuboid_surface, cuboid_uv};
pub use cylinder::{cap_uv, cylinder_intersect, cylinder_surface, cylinder_uv};
pub use interaction::{
    ShadowStart, SurfaceInteraction, SurfacePoint, fresnel, mirror, reflect, refract, smooth, spawn_ray,
};
pub use kernels::{Classic, Fast, Kernels, Reference, Robust};
pub use plane::{plane_intersect, plane_surface, plane_uv, quad_intersect, quad_uv};
pub use ray::{Hit, Ray};
pub use slab::{PaddedSlab, PlainSlab, Slab, WideSlab};
pub use sphere::{leaves_sphere, sphere_intersect, sphere_surface, sphere_uv};
pub use triangle::{TriangleRay, triangle_surface};
