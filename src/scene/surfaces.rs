//! The surfaces where many rays end, side by side in arrays. Hits are sorted by what computes them: those with balls
//! together, those with any other object by object. The functions are those that single hits take (`surface`) in loops
//! that the compiler makes vector code of, so every surface gets the bits that it gets alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots and axes run over several arrays at once.

use super::surface::{Facet, Placement};
use super::{Object, Scene, Shape};
use crate::bvh::{Bvh, Task, TreeKernels};
use crate::geometry::{
    Hit, Kernels, Ray, SurfaceInteraction, cone_surface_at, cuboid_surface, cylinder_surface, plane_surface,
    sphere_surface, triangle_surface,
};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Slots are computed so many at a time: groups of hits start at multiples of it.
const WIDTH: usize = 8;

/// Objects that hits are sorted by at most; those with others are computed one by one.
const GROUPS: usize = 8;

const SLOTS: usize = MOST_SURFACES + WIDTH * GROUPS;

/// Fewer than so many hits are computed one by one.
const FEWEST: usize = 3;

/// Rays that [`Scene::surfaces`] takes at most. With 1024, so that more rays run alike after many turns: 0.97 of the
/// time on the field of glass, 1.0 to 1.06 elsewhere.
pub const MOST_SURFACES: usize = 256;

/// Surfaces where rays end; room for [`Scene::surfaces`], which takes no memory once it is there.
#[derive(Debug, Default)]
pub struct Surfaces {
    room: Option<Box<Room>>,
}

#[derive(Debug)]
struct Room {
    /// Where each hit is, by number of its ray: first its group, then its slot.
    slots: [u16; MOST_SURFACES],
    hits: Hits,
    found: Found,
}

/// Hits and the rays that have them, number by number.
#[derive(Debug)]
#[repr(align(64))]
struct Hits {
    origin: [[f64; SLOTS]; 3],
    direction: [[f64; SLOTS]; 3],
    t: [f64; SLOTS],
    u: [f64; SLOTS],
    v: [f64; SLOTS],
    primitive: [u32; SLOTS],
    /// What differs from hit to hit of a group: centre, radius, scale of errors and reach of a ball; the point in
    /// object space and its distance from the axis of a cone; three corners and their normals of a triangle.
    shape: [[f64; SLOTS]; 18],
}

/// What [`SurfaceInteraction`] holds, number by number.
#[derive(Debug)]
#[repr(align(64))]
struct Found {
    point: [[f64; SLOTS]; 3],
    point_error: [f64; SLOTS],
    geometric_normal: [[f64; SLOTS]; 3],
    shading_normal: [[f64; SLOTS]; 3],
    shadow_point: [[f64; SLOTS]; 3],
    /// 1 for rays that enter, -1 for those that leave.
    side: [f64; SLOTS],
}

/// Hits that are computed together.
#[derive(Clone, Debug, Default)]
struct Group {
    /// One of the objects.
    object: u32,
    /// Whether they are with balls, of which all are computed together.
    balls: bool,
    count: usize,
    slots: Range<usize>,
}

impl Surfaces {
    /// What [`Scene::surfaces`] found for the ray of this number and its hit, or what was put in its place.
    #[inline(always)]
    pub fn get(&self, scene: &Scene, number: usize, hit: &Hit) -> SurfaceInteraction {
        let room = self.room.as_ref().expect("surfaces are computed before they are asked for");
        let i = usize::from(room.slots[number]).min(SLOTS - 1);
        let Found { point, point_error, geometric_normal, shading_normal, shadow_point, side } = &room.found;
        SurfaceInteraction {
            point: vector(point, i),
            point_error: point_error[i],
            geometric_normal: vector(geometric_normal, i),
            shading_normal: vector(shading_normal, i),
            shadow_point: vector(shadow_point, i),
            hit: *hit,
            material: scene.material_of(hit.object, hit.primitive),
            entering: side[i] > 0.0,
        }
    }

    /// Puts another one in the place of a surface.
    pub fn set(&mut self, number: usize, interaction: &SurfaceInteraction) {
        if let Some(room) = &mut self.room {
            room.found.put(usize::from(room.slots[number]), interaction);
        }
    }
}

impl Found {
    fn put(&mut self, i: usize, from: &SurfaceInteraction) {
        put(&mut self.point, i, from.point);
        self.point_error[i] = from.point_error;
        put(&mut self.geometric_normal, i, from.geometric_normal);
        put(&mut self.shading_normal, i, from.shading_normal);
        put(&mut self.shadow_point, i, from.shadow_point);
        self.side[i] = if from.entering { 1.0 } else { -1.0 };
    }
}

impl Room {
    fn new() -> Box<Self> {
        let zero = [0.0; SLOTS];
        Box::new(Self {
            slots: [0; MOST_SURFACES],
            hits: Hits {
                origin: [zero; 3],
                direction: [zero; 3],
                t: zero,
                u: zero,
                v: zero,
                primitive: [0; SLOTS],
                shape: [zero; 18],
            },
            found: Found {
                point: [zero; 3],
                point_error: zero,
                geometric_normal: [zero; 3],
                shading_normal: [zero; 3],
                shadow_point: [zero; 3],
                side: zero,
            },
        })
    }
}

#[inline(always)]
fn vector(from: &[[f64; SLOTS]; 3], i: usize) -> DVec3 {
    DVec3::new(from[0][i], from[1][i], from[2][i])
}

#[inline(always)]
fn put(to: &mut [[f64; SLOTS]; 3], i: usize, v: DVec3) {
    (to[0][i], to[1][i], to[2][i]) = (v.x, v.y, v.z);
}

impl Hits {
    /// Takes a hit in.
    #[inline(always)]
    fn take(&mut self, i: usize, ray: &Ray, hit: &Hit, object: &Object) {
        put(&mut self.origin, i, ray.origin);
        put(&mut self.direction, i, ray.direction);
        (self.t[i], self.primitive[i]) = (hit.t, hit.primitive);
        match &object.shape {
            Shape::Ball { centre, radius } => {
                self.put(0, i, *centre);
                self.put(3, i, DVec3::new(*radius, object.error_scale, object.reach));
            }
            Shape::Cone => {
                let p = object.map.inverse.transform_point3(ray.at(hit.t));
                self.put(0, i, p);
                self.shape[3][i] = p.x.hypot(p.z);
            }
            Shape::Mesh(mesh) => {
                (self.u[i], self.v[i]) = (hit.u, hit.v);
                for (k, corner) in mesh.corners(hit.primitive).into_iter().enumerate() {
                    self.put(3 * k, i, corner);
                }
                for (k, normal) in mesh.shading_normals(hit.primitive).into_iter().flatten().enumerate() {
                    self.put(9 + 3 * k, i, normal);
                }
            }
            _ => {}
        }
    }

    /// Three numbers of the shape, from this one on.
    #[inline(always)]
    fn put(&mut self, first: usize, i: usize, v: DVec3) {
        (self.shape[first][i], self.shape[first + 1][i], self.shape[first + 2][i]) = (v.x, v.y, v.z);
    }

    #[inline(always)]
    fn get(&self, first: usize, i: usize) -> DVec3 {
        DVec3::new(self.shape[first][i], self.shape[first + 1][i], self.shape[first + 2][i])
    }

    #[inline(always)]
    fn ray(&self, i: usize) -> Ray {
        Ray::new(vector(&self.origin, i), vector(&self.direction, i))
    }
}

/// Computes the surfaces of a group of one kind of shape.
struct Facets<'a, K, const SHAPE: u8> {
    range: Range<usize>,
    place: Placement<'a>,
    kernels: PhantomData<K>,
}

const BALL: u8 = 0;
const ELLIPSOID: u8 = 1;
const CUBOID: u8 = 2;
const CYLINDER: u8 = 3;
const CONE: u8 = 4;
const PLANE: u8 = 5;
const FLAT_MESH: u8 = 6;
const SMOOTH_MESH: u8 = 7;

impl<K: Kernels, const SHAPE: u8> Task for Facets<'_, K, SHAPE> {
    type Input = Hits;
    type Output = Found;

    #[inline(always)]
    fn run(self, hits: &Hits, found: &mut Found) {
        let Self { range, place, kernels: _ } = self;
        // Of copies the compiler knows that nothing changes them.
        let (map, axes) = (*place.map, *place.axes);
        let place = Placement { map: &map, axes: &axes, ..place };
        for i in range.start..range.end.min(SLOTS) {
            let (ray, t, face) = (hits.ray(i), hits.t[i], hits.primitive[i]);
            let facet = match SHAPE {
                BALL => {
                    let [radius, error_scale, reach] = [hits.shape[3][i], hits.shape[4][i], hits.shape[5][i]];
                    Facet::of_ball::<K>(&ray, t, (hits.get(0, i), radius), (error_scale, reach))
                }
                ELLIPSOID => place.facet::<K>(&ray, t, sphere_surface(place.local(&ray, t))),
                CUBOID => place.facet::<K>(&ray, t, cuboid_surface(place.local(&ray, t), face)),
                CYLINDER => place.facet::<K>(&ray, t, cylinder_surface(place.local(&ray, t), face)),
                CONE => place.facet::<K>(&ray, t, cone_surface_at(hits.get(0, i), hits.shape[3][i], face)),
                PLANE => place.facet::<K>(&ray, t, plane_surface(place.local(&ray, t))),
                _ => {
                    let corners = [hits.get(0, i), hits.get(3, i), hits.get(6, i)];
                    place.facet::<K>(&ray, t, triangle_surface(corners, hits.u[i], hits.v[i]))
                }
            };
            let (shading_normal, shadow_point) = if SHAPE == SMOOTH_MESH {
                let corners = [hits.get(0, i), hits.get(3, i), hits.get(6, i)];
                let normals = [hits.get(9, i), hits.get(12, i), hits.get(15, i)];
                place.smooth(&facet, corners, normals, (hits.u[i], hits.v[i]))
            } else {
                (facet.normal, facet.point)
            };
            put(&mut found.point, i, facet.point);
            found.point_error[i] = facet.point_error;
            put(&mut found.geometric_normal, i, facet.normal);
            put(&mut found.shading_normal, i, shading_normal);
            put(&mut found.shadow_point, i, shadow_point);
            found.side[i] = if facet.entering { 1.0 } else { -1.0 };
        }
    }
}

/// Computes the surfaces of a group of hits with an object.
fn compute<K: Kernels>(tree: &Bvh, object: &Object, range: Range<usize>, hits: &Hits, found: &mut Found) {
    let place = Placement::of(object);
    macro_rules! run {
        ($shape:ident) => {
            tree.run(Facets::<K, $shape> { range, place, kernels: PhantomData }, hits, found)
        };
    }
    match &object.shape {
        Shape::Ball { .. } => run!(BALL),
        Shape::Ellipsoid => run!(ELLIPSOID),
        Shape::Cuboid => run!(CUBOID),
        Shape::Cylinder => run!(CYLINDER),
        Shape::Cone => run!(CONE),
        Shape::Plane | Shape::Quad => run!(PLANE),
        Shape::Mesh(mesh) if mesh.is_smooth() => run!(SMOOTH_MESH),
        Shape::Mesh(_) => run!(FLAT_MESH),
    }
}

impl Scene {
    /// Computes for each hit what [`Scene::interaction`] gives, to the last bit; [`Surfaces::get`] tells it. Takes
    /// [`MOST_SURFACES`] rays at most.
    pub fn surfaces<K: TreeKernels>(&self, rays: &[Ray], hits: &[Option<Hit>], surfaces: &mut Surfaces) {
        debug_assert!(rays.len() <= MOST_SURFACES);
        let Room { slots, hits: sorted, found } = &mut **surfaces.room.get_or_insert_with(Room::new);
        let objects = self.objects();
        let (mut groups, mut open) = (<[Group; GROUPS]>::default(), 0);
        let (mut last, mut of_last) = (u32::MAX, 0);
        for (slot, hit) in slots.iter_mut().zip(hits) {
            let Some(hit) = hit else { continue };
            if hit.object != last {
                let balls = matches!(objects[hit.object as usize].shape, Shape::Ball { .. });
                let same = |group: &Group| group.object == hit.object || (balls && group.balls);
                let group = groups[..open].iter().position(same).unwrap_or(open);
                if group == open && open < GROUPS {
                    groups[open] = Group { object: hit.object, balls, ..Group::default() };
                    open += 1;
                }
                (last, of_last) = (hit.object, group as u16);
            }
            *slot = of_last;
            if let Some(group) = groups.get_mut(usize::from(of_last)) {
                group.count += 1;
            }
        }
        let groups = &mut groups[..open];
        let mut free = 0;
        for group in groups.iter_mut().filter(|group| group.count >= FEWEST) {
            group.slots = free..free;
            free = (free + group.count).next_multiple_of(WIDTH);
        }
        for ((slot, hit), ray) in slots.iter_mut().zip(hits).zip(rays) {
            let Some(hit) = hit else { continue };
            match groups.get_mut(usize::from(*slot)) {
                Some(group) if group.count >= FEWEST => {
                    *slot = group.slots.end as u16;
                    sorted.take(group.slots.end, ray, hit, &objects[hit.object as usize]);
                    group.slots.end += 1;
                }
                _ => {
                    *slot = free as u16;
                    found.put(free, &self.interaction::<K>(ray, hit));
                    free += 1;
                }
            }
        }
        for group in groups.iter().filter(|group| group.count >= FEWEST) {
            let range = group.slots.start..group.slots.end.next_multiple_of(WIDTH);
            compute::<K>(&self.geometry.tree, &objects[group.object as usize], range, sorted, found);
        }
    }
}
