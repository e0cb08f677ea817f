//! Rays against the whole scene, and the surface where they end.

use super::{Object, Scene, Shape};
use crate::geometry::{
    Hit, Kernels, Ray, SurfaceInteraction, SurfacePoint, cone_surface, cuboid_surface, cylinder_surface, plane_surface,
    quad_surface, sphere_surface,
};
use glam::DVec3;

impl Object {
    /// The closest hit of a world-space ray with this object alone: (t, primitive, u, v).
    pub fn intersect<K: Kernels>(&self, ray: &Ray) -> Option<(f64, u32, f64, f64)> {
        let local = || ray.transformed(&self.map.inverse);
        let whole = |t: f64| (t, 0, 0.0, 0.0);
        let faced = |(t, face): (f64, u32)| (t, face, 0.0, 0.0);
        match &self.shape {
            Shape::Ball { centre, radius } => K::sphere(ray, *centre, *radius).map(whole),
            Shape::Ellipsoid => K::sphere(&local(), DVec3::ZERO, 1.0).map(whole),
            Shape::Cuboid => K::cuboid(&local()).map(faced),
            Shape::Cylinder => K::cylinder(&local()).map(faced),
            Shape::Cone => K::cone(&local()).map(faced),
            Shape::Plane => K::plane(&local()).map(whole),
            Shape::Quad => K::quad(&local()).map(whole),
            Shape::Mesh(mesh) => mesh.intersect::<K>(&local()),
        }
    }

    fn occluded<K: Kernels>(&self, ray: &Ray) -> bool {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.occluded::<K>(&ray.transformed(&self.map.inverse)),
            _ => self.intersect::<K>(ray).is_some(),
        }
    }
}

impl Scene {
    /// The closest hit of a world-space ray; of hits at the same t the smallest (object, primitive).
    pub fn intersect<K: Kernels>(&self, ray: &Ray) -> Option<Hit> {
        let geometry = &*self.geometry;
        let mut best: Option<Hit> = None;
        let mut test = |index: u32, t_max: f64| {
            let object = &geometry.objects[index as usize];
            let Some((t, primitive, u, v)) = object.intersect::<K>(&Ray { t_max, ..*ray }) else { return t_max };
            let hit = Hit { t, object: index, primitive, u, v };
            if best.is_none_or(|b| hit.beats(&b)) {
                best = Some(hit);
            }
            t
        };
        let t_max = geometry.unbounded.iter().fold(ray.t_max, |t_max, &index| test(index, t_max));
        geometry.tree.traverse::<K::Slab>(&Ray { t_max, ..*ray }, |range, t_max| {
            Some(range.fold(t_max, |t_max, position| test(geometry.bounded[position], t_max)))
        });
        best
    }

    /// Whether a world-space ray meets anything before its end.
    pub fn occluded<K: Kernels>(&self, ray: &Ray) -> bool {
        let geometry = &*self.geometry;
        let blocks = |index: u32| geometry.objects[index as usize].occluded::<K>(ray);
        geometry.unbounded.iter().any(|&index| blocks(index))
            || geometry.tree.traverse::<K::Slab>(ray, |mut range, t_max| {
                if range.any(|position| blocks(geometry.bounded[position])) { None } else { Some(t_max) }
            })
    }

    /// The part of the light that gets through to the end of a ray past transparent surfaces: the product of their k_t.
    pub fn transmittance<K: Kernels>(&self, ray: &Ray) -> f64 {
        let (mut ray, mut part) = (*ray, 1.0);
        while part > 0.0 {
            let Some(hit) = self.intersect::<K>(&ray) else { break };
            part *= self.materials[self.material_of(hit.object, hit.primitive) as usize].transmit;
            // The same ray goes on behind the hit: nothing is computed anew, so nothing is met twice or skipped.
            ray.t_min = hit.t;
        }
        part
    }

    /// Hits with other objects that lie where `hit` does, to within `slack` in t: faces that touch. Rays that start behind one
    /// of them start behind all of them, so a crossing has to deal with them together.
    pub fn coincident<K: Kernels>(&self, ray: &Ray, hit: &Hit, slack: f64, mut visit: impl FnMut(Hit)) {
        let geometry = &*self.geometry;
        let near = Ray { t_min: hit.t - slack, t_max: hit.t + slack, ..*ray };
        let mut test = |index: u32| {
            if index != hit.object
                && let Some((t, primitive, u, v)) = geometry.objects[index as usize].intersect::<K>(&near)
            {
                visit(Hit { t, object: index, primitive, u, v });
            }
        };
        geometry.unbounded.iter().for_each(|&index| test(index));
        geometry.tree.traverse::<K::Slab>(&near, |range, t_max| {
            range.for_each(|position| test(geometry.bounded[position]));
            Some(t_max)
        });
    }

    /// Everything that shading wants to know of a hit of this world-space ray.
    pub fn interaction<K: Kernels>(&self, ray: &Ray, hit: &Hit) -> SurfaceInteraction {
        let object = &self.geometry.objects[hit.object as usize];
        let map = &object.map;
        let local_point = || map.inverse.transform_point3(ray.at(hit.t));
        let mut on_surface = None;
        let surface: SurfacePoint = match &object.shape {
            Shape::Ball { centre, radius } => {
                // In world space, so that the point is on the sphere that later rays meet.
                let normal = (ray.at(hit.t) - *centre).normalize_or(DVec3::Y);
                on_surface = Some((*centre + normal * *radius, normal));
                sphere_surface(map.inverse.transform_vector3(normal))
            }
            Shape::Ellipsoid => sphere_surface(local_point()),
            Shape::Cuboid => cuboid_surface(local_point(), hit.primitive),
            Shape::Cylinder => cylinder_surface(local_point(), hit.primitive),
            Shape::Cone => cone_surface(local_point(), hit.primitive),
            Shape::Plane => plane_surface(local_point()),
            Shape::Quad => quad_surface(local_point()),
            Shape::Mesh(mesh) => mesh.surface(hit.primitive, hit.u, hit.v),
        };
        let (on_surface, geometric_normal) = on_surface.unwrap_or_else(|| {
            let normal = (map.normal * surface.normal).normalize_or(DVec3::Y);
            (map.forward.transform_point3(surface.point), normal)
        });
        let bound = object.error_scale * on_surface.length().max(object.reach);
        let (point, point_error) = K::surface_point(ray, hit.t, on_surface, bound);
        let mut interaction = SurfaceInteraction {
            point,
            point_error,
            geometric_normal,
            shading_normal: geometric_normal,
            shadow_point: point,
            uv: surface.uv,
            material: self.material_of(hit.object, hit.primitive),
            entering: ray.direction.dot(geometric_normal) < 0.0,
        };
        if let Shape::Mesh(mesh) = &object.shape
            && let Some(normals) = mesh.shading_normals(hit.primitive)
        {
            let corners = mesh.corners(hit.primitive).map(|p| map.forward.transform_point3(p));
            let normals = normals.map(|n| {
                let n = (map.normal * n).normalize_or(geometric_normal);
                if n.dot(geometric_normal) < 0.0 { -n } else { n }
            });
            interaction.smooth(corners, normals, hit.u, hit.v);
        }
        interaction
    }
}
