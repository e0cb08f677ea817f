//! The surfaces where many rays end, side by side in arrays. Hits are sorted by what computes them: those with balls
//! together, those with any other object by object. The functions are those that single hits take (`surface`) in loops
//! that the compiler makes vector code of, so every surface gets the bits that it gets alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots and axes run over several arrays at once.

use super::color::ColorRoom;
use super::surface::{Facet, Placement};
use super::{Material, Object, Scene, Shape};
use crate::bvh::{Bvh, PACKET, Rays, Task, TreeKernels};
use crate::geometry::{
    Hit, Kernels, Ray, ShadowStart, SurfaceInteraction, cone_surface_at, cuboid_surface, cylinder_surface,
    plane_surface, sphere_surface, triangle_surface,
};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::Range;

/// Slots are computed so many at a time.
pub(super) const WIDTH: usize = 8;

/// Objects that hits are sorted by at most; those with others are computed one by one.
const GROUPS: usize = 8;

/// One a hit, and room for the last ones that are computed together.
pub const SLOTS: usize = PACKET + WIDTH;

/// Fewer than so many hits are computed one by one.
pub(super) const FEWEST: usize = 3;

/// Stands for no material: of a surface that is not there after all.
const NOTHING: u32 = u32::MAX;

/// Surfaces where rays end; room for [`Scene::surfaces`], which takes no memory once it is there.
#[derive(Debug, Default)]
pub struct Surfaces {
    room: Box<Room>,
}

#[derive(Debug, Default)]
struct Room {
    hits: Hits,
    found: SurfaceRows,
    /// Of each ray.
    groups: GroupOfRays,
    colors: ColorRoom<SLOTS>,
}

/// Which group each hit is in, by number of its ray.
#[derive(Debug)]
struct GroupOfRays([u8; PACKET]);

impl Default for GroupOfRays {
    fn default() -> Self {
        Self([0; PACKET])
    }
}

/// Hits and the rays that have them, slot by slot.
#[derive(Debug)]
#[repr(align(64))]
struct Hits {
    origin: [[f64; SLOTS]; 3],
    direction: [[f64; SLOTS]; 3],
    t: [f64; SLOTS],
    weights: [[f64; SLOTS]; 2],
    primitive: [u32; SLOTS],
    /// What differs from hit to hit of a group: centre, radius, scale of errors and reach of a ball; the point in
    /// object space and its distance from the axis of a cone; three corners and their normals of a triangle.
    shape: [[f64; SLOTS]; 18],
}

impl Default for Hits {
    fn default() -> Self {
        let zero = [0.0; SLOTS];
        Self {
            origin: [zero; 3],
            direction: [zero; 3],
            t: zero,
            weights: [zero; 2],
            primitive: [0; SLOTS],
            shape: [zero; 18],
        }
    }
}

/// What [`SurfaceInteraction`] holds, side by side. Surfaces that are computed together stand together; the others
/// follow.
#[derive(Debug)]
#[repr(align(64))]
pub struct SurfaceRows {
    /// How many there are.
    pub count: usize,
    /// Whether shading normals may differ from those of facets.
    pub is_smooth: bool,
    /// The ray that ends there.
    pub ray: [u16; SLOTS],
    /// Of the material in the scene.
    material: [u32; SLOTS],
    /// See [`SurfaceInteraction`].
    point: [[f64; SLOTS]; 3],
    /// See [`SurfaceInteraction`].
    point_error: [f64; SLOTS],
    /// See [`SurfaceInteraction`].
    geometric_normal: [[f64; SLOTS]; 3],
    /// See [`SurfaceInteraction`].
    shading_normal: [[f64; SLOTS]; 3],
    /// See [`SurfaceInteraction`].
    shadow_point: [[f64; SLOTS]; 3],
    /// The side that the viewer is on: 1 for rays that enter, -1 for those that leave.
    side: [f64; SLOTS],
}

impl Default for SurfaceRows {
    fn default() -> Self {
        let zero = [0.0; SLOTS];
        Self {
            count: 0,
            is_smooth: false,
            ray: [0; SLOTS],
            material: [0; SLOTS],
            point: [zero; 3],
            point_error: zero,
            geometric_normal: [zero; 3],
            shading_normal: [zero; 3],
            shadow_point: [zero; 3],
            side: zero,
        }
    }
}

/// Hits that are computed together.
#[derive(Clone, Debug, Default)]
struct Group {
    /// One of the objects.
    object: u32,
    /// Whether they are with balls, of which all are computed together.
    balls: bool,
    /// Of all of them, if that is known.
    material: Option<u32>,
    count: usize,
    slots: Range<usize>,
}

impl Surfaces {
    /// What [`Scene::surfaces`] found, or what was put in its place.
    pub fn rows(&self) -> &SurfaceRows {
        &self.room.found
    }

    /// Directions of the rays that end in the slots.
    pub fn directions(&self) -> &[[f64; SLOTS]; 3] {
        &self.room.hits.direction
    }

    /// The surface in a slot; `hit`: of the ray that ends there.
    #[inline(always)]
    pub fn get(&self, slot: usize, hit: &Hit) -> SurfaceInteraction {
        let i = slot.min(SLOTS - 1);
        let SurfaceRows { material, point, point_error, geometric_normal, shading_normal, shadow_point, side, .. } =
            &self.room.found;
        SurfaceInteraction {
            point: vector(point, i),
            point_error: point_error[i],
            geometric_normal: vector(geometric_normal, i),
            shading_normal: vector(shading_normal, i),
            shadow_point: vector(shadow_point, i),
            hit: *hit,
            material: material[i],
            entering: side[i] > 0.0,
        }
    }

    /// Puts another surface in a slot; none if the ray goes on for good.
    pub fn set(&mut self, slot: usize, interaction: Option<&SurfaceInteraction>) {
        let found = &mut self.room.found;
        match interaction {
            Some(interaction) => found.put(slot, interaction),
            None => found.material[slot] = NOTHING,
        }
    }

    /// The colours of the surfaces in some slots, all of one material; they are asked for in the order of slots.
    /// `hits`: of all rays.
    pub fn colors(
        &mut self,
        scene: &Scene,
        slots: Range<usize>,
        material: &Material,
        hits: &[Option<Hit>],
        color: &mut [[f64; SLOTS]; 3],
    ) {
        let Room { found, colors, .. } = &mut *self.room;
        let hit = |slot: usize| hits[usize::from(found.ray[slot])].as_ref();
        scene.colors(material, slots, hit, &found.point, colors, color);
    }
}

impl SurfaceRows {
    /// The material of a surface; none if there is no surface any more.
    #[inline(always)]
    pub fn material<'a>(&self, scene: &'a Scene, slot: usize) -> Option<&'a Material> {
        scene.materials.get(self.material[slot] as usize)
    }

    /// The slots from this one on that are of the same material.
    #[inline(always)]
    pub fn alike(&self, start: usize) -> Range<usize> {
        let first = self.material[start];
        let alike = self.material[start..self.count].iter().position(|&material| material != first);
        start..alike.map_or(self.count, |count| start + count)
    }

    /// The point of a surface where the ray ends.
    #[inline(always)]
    pub fn point(&self, slot: usize) -> DVec3 {
        vector(&self.point, slot)
    }

    /// Shading normal on the viewer's side.
    #[inline(always)]
    pub fn normal(&self, slot: usize) -> DVec3 {
        vector(&self.shading_normal, slot) * self.side[slot]
    }

    /// Normal of the facet.
    #[inline(always)]
    pub fn geometric_normal(&self, slot: usize) -> DVec3 {
        vector(&self.geometric_normal, slot)
    }

    /// The same on the viewer's side.
    #[inline(always)]
    pub fn facet(&self, slot: usize) -> DVec3 {
        self.geometric_normal(slot) * self.side[slot]
    }

    /// The side that the viewer is on: 1 outside of the body, -1 inside.
    #[inline(always)]
    pub fn side(&self, slot: usize) -> f64 {
        self.side[slot]
    }

    /// Bound on the distance of later rays' hits from the point.
    #[inline(always)]
    pub fn point_error(&self, slot: usize) -> f64 {
        self.point_error[slot]
    }

    /// Where shadow rays of a surface start.
    #[inline(always)]
    pub fn shadow_start(&self, slot: usize) -> ShadowStart {
        let (point, normal) = (vector(&self.shadow_point, slot), vector(&self.geometric_normal, slot));
        ShadowStart::new(point, normal, self.side[slot], self.point_error[slot])
    }

    fn put(&mut self, i: usize, from: &SurfaceInteraction) {
        put(&mut self.point, i, from.point);
        self.point_error[i] = from.point_error;
        put(&mut self.geometric_normal, i, from.geometric_normal);
        put(&mut self.shading_normal, i, from.shading_normal);
        put(&mut self.shadow_point, i, from.shadow_point);
        self.side[i] = from.side();
        self.material[i] = from.material;
        self.is_smooth |= from.shading_normal != from.geometric_normal;
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
                (self.weights[0][i], self.weights[1][i]) = (hit.u, hit.v);
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
    type Output = SurfaceRows;

    #[inline(always)]
    fn run(self, hits: &Hits, found: &mut SurfaceRows) {
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
                    place.facet::<K>(&ray, t, triangle_surface(corners, hits.weights[0][i], hits.weights[1][i]))
                }
            };
            let (shading_normal, shadow_point) = if SHAPE == SMOOTH_MESH {
                let corners = [hits.get(0, i), hits.get(3, i), hits.get(6, i)];
                let normals = [hits.get(9, i), hits.get(12, i), hits.get(15, i)];
                place.smooth(&facet, corners, normals, (hits.weights[0][i], hits.weights[1][i]))
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
fn compute<K: Kernels>(tree: &Bvh, object: &Object, range: Range<usize>, hits: &Hits, found: &mut SurfaceRows) {
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
    /// Computes for each hit what [`Scene::interaction`] gives, to the last bit. Takes [`PACKET`] rays at most.
    pub fn surfaces<K: TreeKernels>(&self, rays: &(impl Rays + ?Sized), hits: &[Option<Hit>], surfaces: &mut Surfaces) {
        assert!(hits.len() <= PACKET && hits.len() <= rays.count(), "surfaces come in packets");
        let Room { groups: GroupOfRays(group_of), hits: sorted, found, .. } = &mut *surfaces.room;
        let objects = self.objects();
        found.is_smooth = false;
        let (mut groups, mut open) = (<[Group; GROUPS]>::default(), 0);
        let (mut last, mut of_last) = (u32::MAX, 0);
        for (group_of, hit) in group_of.iter_mut().zip(hits) {
            let Some(hit) = hit else { continue };
            if hit.object != last {
                let shape = &objects[hit.object as usize].shape;
                found.is_smooth |= matches!(shape, Shape::Mesh(mesh) if mesh.is_smooth());
                let balls = matches!(shape, Shape::Ball { .. });
                let same = |group: &Group| group.object == hit.object || (balls && group.balls);
                let group = groups[..open].iter().position(same).unwrap_or(open);
                if group == open && open < GROUPS {
                    let material = if balls { None } else { self.only_material_of(hit.object) };
                    groups[open] = Group { object: hit.object, balls, material, ..Group::default() };
                    open += 1;
                }
                (last, of_last) = (hit.object, group as u8);
            }
            *group_of = of_last;
            if let Some(group) = groups.get_mut(usize::from(of_last)) {
                group.count += 1;
            }
        }
        let groups = &mut groups[..open];
        let mut free = 0;
        for group in groups.iter_mut().filter(|group| group.count >= FEWEST) {
            group.slots = free..free;
            free += group.count;
        }
        let alone = free;
        for (number, (group, hit)) in (0..).zip(group_of.iter().zip(hits)) {
            let Some(hit) = hit else { continue };
            let (slot, material) = match groups.get_mut(usize::from(*group)) {
                Some(group) if group.count >= FEWEST => {
                    group.slots.end += 1;
                    (group.slots.end - 1, group.material)
                }
                _ => {
                    free += 1;
                    (free - 1, None)
                }
            };
            sorted.take(slot, &rays.ray(number), hit, &objects[hit.object as usize]);
            found.ray[slot] = number as u16;
            found.material[slot] = material.unwrap_or_else(|| self.material_of(hit.object, hit.primitive));
        }
        found.count = free;
        // In order: each also writes up to where vectors end, into slots that are filled after it.
        for group in groups.iter().filter(|group| group.count >= FEWEST) {
            let range = group.slots.start..group.slots.start + group.count.next_multiple_of(WIDTH);
            compute::<K>(&self.geometry.tree, &objects[group.object as usize], range, sorted, found);
        }
        for slot in alone..free {
            let number = usize::from(found.ray[slot]);
            if let Some(hit) = &hits[number] {
                found.put(slot, &self.interaction::<K>(&rays.ray(number), hit));
            }
        }
    }
}
