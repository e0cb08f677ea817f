//! Which body a point lies in: nested media by a priority stack (Schmidt and Budge, "Simple Nested Dielectrics in Ray
//! Traced Images", JGT 7(2) 2002).

use super::{Scene, Shape};
use crate::bvh::TreeKernels;
use crate::geometry::{Ray, Robust};
use glam::DVec3;

/// Most bodies that a ray can be inside of at once; what is entered beyond is passed over, which is counted.
pub const MOST_BODIES: usize = 8;

/// The transparent bodies that a ray is inside of.
#[derive(Clone, Copy, Debug, Default)]
pub struct MediumStack {
    bodies: [Body; MOST_BODIES],
    len: usize,
    /// Whether a body was passed over on the way here because there was no room for it.
    overfull: bool,
}

/// What was passed over has no part in it.
impl PartialEq for MediumStack {
    fn eq(&self, o: &Self) -> bool {
        self.bodies[..self.len] == o.bodies[..o.len]
    }
}

/// What of bodies is around the start of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// None.
    Nothing,
    /// This one.
    One(u32),
    /// More than one.
    Several,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Body {
    object: u32,
    material: u32,
}

impl MediumStack {
    /// The body that a ray is inside of, if there is just one.
    pub fn only(&self) -> Option<u32> {
        (self.len == 1).then_some(self.bodies[0].object)
    }

    /// How many bodies a ray is inside of, as far as it matters.
    pub fn inside(&self) -> Inside {
        match self.len {
            0 => Inside::Nothing,
            1 => Inside::One(self.bodies[0].object),
            _ => Inside::Several,
        }
    }

    /// Whether more bodies were entered than there is room for.
    pub fn is_overfull(&self) -> bool {
        self.overfull
    }

    /// Crosses the surface of `object`. A quad has no inside. (In place: a stack that is written in parts and copied as
    /// a whole at once makes the processor wait.)
    pub fn cross(&mut self, scene: &Scene, object: u32, material: u32, entering: bool) {
        match scene.objects()[object as usize].shape {
            Shape::Quad => {}
            _ if entering => self.enter(object, material),
            _ => self.leave(object),
        }
    }

    /// Crosses the surface of `object` inward.
    fn enter(&mut self, object: u32, material: u32) {
        // A body is entered once: a second entrance comes from an open or self-overlapping mesh.
        if self.bodies[..self.len].iter().any(|b| b.object == object) {
            return;
        }
        match self.bodies.get_mut(self.len) {
            Some(free) => {
                *free = Body { object, material };
                self.len += 1;
            }
            None => self.overfull = true,
        }
    }

    /// Crosses the surface of `object` outward.
    fn leave(&mut self, object: u32) {
        if let Some(at) = self.bodies[..self.len].iter().position(|b| b.object == object) {
            self.bodies.copy_within(at + 1..self.len, at);
            self.len -= 1;
        }
    }

    /// The object whose medium fills the place: of those that the ray is inside of the one with the highest priority,
    /// of equals the smallest, of equals the last in the file. `None`: the world.
    pub fn filling(&self, scene: &Scene) -> Option<u32> {
        self.top(scene).map(|b| b.object)
    }

    /// Refractive index of the place.
    pub fn ior(&self, scene: &Scene) -> f64 {
        self.top(scene).map_or(scene.world.ior, |b| scene.materials[b.material as usize].ior)
    }

    fn top(&self, scene: &Scene) -> Option<&Body> {
        self.bodies[..self.len].iter().max_by(|a, b| {
            let priority = |x: &Body| scene.materials[x.material as usize].priority;
            let volume = |x: &Body| scene.objects()[x.object as usize].volume;
            (priority(a).cmp(&priority(b))).then(volume(b).total_cmp(&volume(a))).then(a.object.cmp(&b.object))
        })
    }
}

impl Scene {
    /// The transparent bodies that hold `point`.
    pub fn media_at(&self, point: DVec3) -> MediumStack {
        let mut media = MediumStack::default();
        for index in 0..self.objects().len() as u32 {
            if let Some(primitive) = self.inside_of(index, point) {
                let material = self.material_of(index, primitive);
                if self.materials[material as usize].transmit > 0.0 {
                    media.enter(index, material);
                }
            }
        }
        media
    }

    /// If `point` is inside the body of an object, a primitive whose material tells what is there. A quad has no
    /// inside; a plane's is the half-space below.
    fn inside_of(&self, index: u32, point: DVec3) -> Option<u32> {
        let object = &self.objects()[index as usize];
        let p = object.map.inverse.transform_point3(point);
        let inside = match &object.shape {
            Shape::Ball { centre, radius } => point.distance(*centre) < *radius,
            Shape::Ellipsoid => p.length() < 1.0,
            Shape::Cuboid => p.abs().max_element() < 1.0,
            Shape::Cylinder => p.y.abs() < 1.0 && p.x.hypot(p.z) < 1.0,
            Shape::Cone => p.y > -1.0 && p.x.hypot(p.z) < (1.0 - p.y) / 2.0,
            Shape::Plane => p.y < 0.0,
            Shape::Quad => false,
            Shape::Mesh(mesh) => return mesh.enclosing_triangle::<Robust>(p),
        };
        inside.then_some(0)
    }
}

impl super::Mesh {
    /// If a point of object space is inside, a triangle around it: more surfaces of the mesh are left than entered on
    /// the way out. Surfaces are counted by their side, so that a hit on a shared edge does not upset the count.
    fn enclosing_triangle<K: TreeKernels>(&self, point: DVec3) -> Option<u32> {
        // An arbitrary direction without symmetry, so that no common mesh has an edge in its way.
        let direction = DVec3::new(0.541_196_1, 0.640_293_7, 0.545_147_9);
        let mut ray = Ray::new(point, direction);
        let (mut depth, mut first) = (0i64, None);
        while let Some(hit) = self.intersect::<K>(&ray) {
            depth += if self.normal_of(hit.triangle).dot(direction) > 0.0 { 1 } else { -1 };
            first = first.or(Some(hit.triangle));
            ray.t_min = hit.t;
        }
        first.filter(|_| depth > 0)
    }
}
