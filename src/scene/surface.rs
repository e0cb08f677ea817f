//! The surface where a ray ends: one at a time here, many at once in `surfaces`.

use super::{Mesh, Object, Scene, Shape};
use crate::bvh::TreeKernels;
use crate::geometry::{
    Hit, Kernels, Ray, SurfaceInteraction, SurfacePoint, cone_surface, cone_uv, cuboid_surface, cuboid_uv,
    cylinder_surface, cylinder_uv, plane_surface, plane_uv, quad_uv, smooth, sphere_surface, sphere_uv,
};
use crate::math::Affine;
use glam::{DVec2, DVec3};

/// A surface as it is where the shape is taken for what it is made of: flat triangles and all else.
#[derive(Clone, Copy)]
pub struct Facet {
    /// On the surface.
    pub point: DVec3,
    /// Bound on the distance of later rays' hits from `point`.
    pub point_error: f64,
    /// Unit, out of the body.
    pub normal: DVec3,
    /// Whether the ray goes into the body.
    pub entering: bool,
}

impl Facet {
    #[inline(always)]
    fn new<K: Kernels>(ray: &Ray, t: f64, on_surface: DVec3, normal: DVec3, bound: f64) -> Self {
        let (point, point_error) = K::surface_point(ray, t, on_surface, bound);
        Self { point, point_error, normal, entering: ray.direction.dot(normal) < 0.0 }
    }

    /// Of a ball. In world space, so that the point is on the sphere that later rays meet. `error_scale` and `reach`:
    /// the object's.
    #[inline(always)]
    pub(super) fn of_ball<K: Kernels>(
        ray: &Ray,
        t: f64,
        (centre, radius): (DVec3, f64),
        (error_scale, reach): (f64, f64),
    ) -> Self {
        let normal = (ray.at(t) - centre).normalize_or(DVec3::Y);
        let on_surface = centre + normal * radius;
        Self::new::<K>(ray, t, on_surface, normal, error_scale * on_surface.length().max(reach))
    }
}

/// What of an object brings a surface from its space into the world. (Borrowed: copied, it took a third longer for one
/// hit.)
#[derive(Clone, Copy)]
pub(super) struct Placement<'a> {
    pub map: &'a Affine,
    pub axes: &'a [DVec3; 3],
    pub error_scale: f64,
    pub reach: f64,
}

impl<'a> Placement<'a> {
    #[inline(always)]
    pub fn of(object: &'a Object) -> Self {
        Self { map: &object.map, axes: &object.axes, error_scale: object.error_scale, reach: object.reach }
    }

    /// The point at `t` in object space.
    #[inline(always)]
    pub fn local(&self, ray: &Ray, t: f64) -> DVec3 {
        self.map.inverse.transform_point3(ray.at(t))
    }

    /// The facet where a shape has this surface.
    #[inline(always)]
    pub fn facet<K: Kernels>(&self, ray: &Ray, t: f64, surface: SurfacePoint) -> Facet {
        let on_surface = self.map.forward.transform_point3(surface.point);
        let bound = self.error_scale * on_surface.length().max(self.reach);
        Facet::new::<K>(ray, t, on_surface, self.normal(surface.normal), bound)
    }

    /// The unit normal in world space where `normal` is the one in object space; most often it is that of a flat face.
    #[inline(always)]
    fn normal(&self, normal: DVec3) -> DVec3 {
        match normal.to_array() {
            [x, 0.0, 0.0] => self.axes[0] * x,
            [0.0, y, 0.0] => self.axes[1] * y,
            [0.0, 0.0, z] => self.axes[2] * z,
            _ => (self.map.normal * normal).normalize_or(DVec3::Y),
        }
    }

    /// The shading normal and the start of shadow rays on a triangle that stands for a smooth surface: `corners` and
    /// their `normals` in object space, weights `u` and `v` of the second and third corner.
    #[inline(always)]
    pub fn smooth(
        &self,
        facet: &Facet,
        [a, b, c]: [DVec3; 3],
        [na, nb, nc]: [DVec3; 3],
        (u, v): (f64, f64),
    ) -> (DVec3, DVec3) {
        let forward = &self.map.forward;
        let corners = [forward.transform_point3(a), forward.transform_point3(b), forward.transform_point3(c)];
        let normals = [self.outward(na, facet), self.outward(nb, facet), self.outward(nc, facet)];
        smooth(facet.point, facet.normal, facet.entering, corners, normals, [1.0 - u - v, u, v])
    }

    /// The normal of a corner in world space, on the outer side of the facet.
    #[inline(always)]
    fn outward(&self, normal: DVec3, facet: &Facet) -> DVec3 {
        let normal = (self.map.normal * normal).normalize_or(facet.normal);
        if normal.dot(facet.normal) < 0.0 { -normal } else { normal }
    }
}

impl Scene {
    /// Everything that shading wants to know of a hit of this world-space ray.
    pub fn interaction<K: TreeKernels>(&self, ray: &Ray, hit: &Hit) -> SurfaceInteraction {
        let facet = self.facet::<K>(ray, hit);
        let object = &self.geometry.objects[hit.object as usize];
        let (shading_normal, shadow_point) = match &object.shape {
            Shape::Mesh(mesh) => smooth_at(&Placement::of(object), mesh, hit, &facet),
            _ => (facet.normal, facet.point),
        };
        SurfaceInteraction {
            point: facet.point,
            point_error: facet.point_error,
            geometric_normal: facet.normal,
            shading_normal,
            shadow_point,
            hit: *hit,
            material: self.material_of(hit.object, hit.primitive),
            entering: facet.entering,
        }
    }

    /// What crossing a surface takes to know of a hit of this world-space ray.
    #[inline]
    pub fn facet<K: TreeKernels>(&self, ray: &Ray, hit: &Hit) -> Facet {
        let object = &self.geometry.objects[hit.object as usize];
        let place = Placement::of(object);
        let surface = match &object.shape {
            &Shape::Ball { centre, radius } => {
                return Facet::of_ball::<K>(ray, hit.t, (centre, radius), (object.error_scale, object.reach));
            }
            Shape::Ellipsoid => sphere_surface(place.local(ray, hit.t)),
            Shape::Cuboid => cuboid_surface(place.local(ray, hit.t), hit.primitive),
            Shape::Cylinder => cylinder_surface(place.local(ray, hit.t), hit.primitive),
            Shape::Cone => cone_surface(place.local(ray, hit.t), hit.primitive),
            Shape::Plane | Shape::Quad => plane_surface(place.local(ray, hit.t)),
            Shape::Mesh(mesh) => mesh.surface(hit.primitive, hit.u, hit.v),
        };
        place.facet::<K>(ray, hit.t, surface)
    }

    /// Texture coordinates of a hit at this point of the surface, v upward.
    pub fn uv(&self, hit: &Hit, point: DVec3) -> DVec2 {
        let object = &self.geometry.objects[hit.object as usize];
        let p = object.map.inverse.transform_point3(point);
        match &object.shape {
            Shape::Ball { .. } | Shape::Ellipsoid => sphere_uv(p),
            Shape::Cuboid => cuboid_uv(p, hit.primitive),
            Shape::Cylinder => cylinder_uv(p, hit.primitive),
            Shape::Cone => cone_uv(p, hit.primitive),
            Shape::Plane => plane_uv(p),
            Shape::Quad => quad_uv(p),
            Shape::Mesh(mesh) => mesh.uv(hit.primitive, hit.u, hit.v),
        }
    }
}

/// [`Placement::smooth`] for a hit with a mesh; its facet where it is not smooth.
fn smooth_at(place: &Placement, mesh: &Mesh, hit: &Hit, facet: &Facet) -> (DVec3, DVec3) {
    match mesh.shading_normals(hit.primitive) {
        Some(normals) => place.smooth(facet, mesh.corners(hit.primitive), normals, (hit.u, hit.v)),
        None => (facet.normal, facet.point),
    }
}
