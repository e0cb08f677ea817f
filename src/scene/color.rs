//! The colours of many hits, side by side in arrays: in loops that the compiler makes vector code of, with the
//! functions that single hits take ([`Scene::uv`], [`Material::color`]), so that every hit gets the bits that it gets
//! alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots run over several arrays at once.

use super::surfaces::{FEWEST, WIDTH};
use super::texture::{Source, Texels, Texture, is_second};
use super::{Material, Scene, Shape};
use crate::bvh::Task;
use crate::description::Wrap;
use crate::geometry::{Hit, cap_uv, cone_uv, cuboid_uv, cylinder_uv, plane_uv, quad_uv, sphere_uv, triangle_surface};
use crate::math::{Rgb, srgb8_table};
use glam::{DAffine3, DVec2, DVec3};
use std::ops::Range;

/// Room for what is computed on the way to colours, slot by slot.
#[derive(Debug)]
#[repr(align(64))]
pub struct ColorRoom<const N: usize> {
    local: Local<N>,
    uv: [[f64; N]; 2],
    texels: TexelRows<N>,
}

/// Hits in object space.
#[derive(Debug)]
struct Local<const N: usize> {
    point: [[f64; N]; 3],
    face: [u32; N],
}

/// [`Texels`], slot by slot.
#[derive(Debug)]
struct TexelRows<const N: usize> {
    at: [[u32; N]; 4],
    part: [[f64; N]; 2],
}

impl<const N: usize> Default for ColorRoom<N> {
    fn default() -> Self {
        Self {
            local: Local { point: [[0.0; N]; 3], face: [0; N] },
            uv: [[0.0; N]; 2],
            texels: TexelRows { at: [[0; N]; 4], part: [[0.0; N]; 2] },
        }
    }
}

impl Scene {
    /// The colours of surfaces of one material: what [`Material::color`] gives at the coordinates that [`Scene::uv`]
    /// gives for the hit and the point in each slot; any colour where there is no hit. It goes the faster the more hits
    /// with one object stand side by side, or with balls. Up to 7 colours behind the slots are overwritten, too.
    pub fn colors<'a, const N: usize>(
        &self,
        material: &Material,
        slots: Range<usize>,
        hit: impl Fn(usize) -> Option<&'a Hit>,
        point: &[[f64; N]; 3],
        room: &mut ColorRoom<N>,
        color: &mut [[f64; N]; 3],
    ) {
        let Some(Texture { source, scale, offset }) = &material.texture else {
            let Rgb { r, g, b } = material.color;
            for (row, value) in color.iter_mut().zip([r, g, b]) {
                row[slots.clone()].fill(value);
            }
            return;
        };
        self.find_uv(slots.clone(), hit, point, room);
        let place = Placed { range: whole::<N>(&slots), scale: *scale, offset: *offset };
        match source {
            &Source::Checker { colors, size } => self.run(Squares { place, colors, size }, &room.uv, color),
            Source::Image(image, wrap) => {
                let task = Surroundings { place, size: image.size(), wrap: *wrap };
                self.run(task, &room.uv, &mut room.texels);
                // Not a task: most of it are loads from places that depend on the hit. Texels of four linear f32 would
                // be less work but more memory: 1.25 times the time with 256² texels, twice with 1024².
                let (TexelRows { at, part }, linear) = (&room.texels, srgb8_table());
                for i in slots {
                    let texels =
                        Texels { at: [at[0][i], at[1][i], at[2][i], at[3][i]], part: [part[0][i], part[1][i]] };
                    let Rgb { r, g, b } = image.blend(linear, &texels);
                    (color[0][i], color[1][i], color[2][i]) = (r, g, b);
                }
            }
        }
    }

    /// Texture coordinates, object by object.
    fn find_uv<'a, const N: usize>(
        &self,
        slots: Range<usize>,
        hit: impl Fn(usize) -> Option<&'a Hit>,
        point: &[[f64; N]; 3],
        room: &mut ColorRoom<N>,
    ) {
        let is_ball = |object: u32| matches!(self.objects()[object as usize].shape, Shape::Ball { .. });
        let mut start = slots.start;
        while start < slots.end {
            let Some(first) = hit(start) else {
                (room.uv[0][start], room.uv[1][start]) = (0.0, 0.0);
                start += 1;
                continue;
            };
            let balls = is_ball(first.object);
            let alike = |hit: &Hit| hit.object == first.object || (balls && is_ball(hit.object));
            let end = (start + 1..slots.end).find(|&slot| !hit(slot).is_some_and(alike)).unwrap_or(slots.end);
            let hits = (start..end).filter_map(|slot| Some((slot, hit(slot)?)));
            if end - start < FEWEST {
                for (slot, hit) in hits {
                    room.put_uv(slot, self.uv(hit, vector(point, slot)));
                }
            } else {
                self.find_uv_alike(start..end, first.object, hits, point, room);
            }
            start = end;
        }
    }

    /// The same for hits with this object or with balls.
    fn find_uv_alike<'a, const N: usize>(
        &self,
        slots: Range<usize>,
        object: u32,
        hits: impl Iterator<Item = (usize, &'a Hit)>,
        point: &[[f64; N]; 3],
        room: &mut ColorRoom<N>,
    ) {
        let object = &self.objects()[object as usize];
        let range = whole::<N>(&slots);
        match &object.shape {
            Shape::Mesh(mesh) if mesh.has_uv() => {
                hits.for_each(|(slot, hit)| room.put_uv(slot, mesh.uv(hit.primitive, hit.u, hit.v)));
                return;
            }
            Shape::Mesh(mesh) => {
                for (slot, hit) in hits {
                    let surface = triangle_surface(mesh.corners(hit.primitive), hit.u, hit.v);
                    room.local.put(slot, surface.point);
                }
            }
            Shape::Ball { .. } => {
                for (slot, hit) in hits {
                    let inverse = &self.objects()[hit.object as usize].map.inverse;
                    room.local.put(slot, inverse.transform_point3(vector(point, slot)));
                }
            }
            _ => {
                hits.for_each(|(slot, hit)| room.local.face[slot] = hit.primitive);
                self.run(
                    IntoObject { range: range.clone(), inverse: object.map.inverse },
                    point,
                    &mut room.local.point,
                );
            }
        }
        let ColorRoom { local, uv, .. } = room;
        macro_rules! run {
            ($shape:ident) => {
                self.run(Coordinates::<$shape, N> { range }, local, uv)
            };
        }
        // Flat faces have no angles to find, and often nothing else of a body is seen.
        let flat = || local.face[slots.clone()].iter().all(|face| *face != 0);
        match &object.shape {
            Shape::Ball { .. } | Shape::Ellipsoid | Shape::Mesh(_) => run!(SPHERE),
            Shape::Cuboid => run!(CUBOID),
            Shape::Cylinder | Shape::Cone if flat() => run!(CAPS),
            Shape::Cylinder => run!(CYLINDER),
            Shape::Cone => run!(CONE),
            Shape::Plane => run!(PLANE),
            Shape::Quad => run!(QUAD),
        }
    }
}

/// The slots, to the end of the last vector.
fn whole<const N: usize>(slots: &Range<usize>) -> Range<usize> {
    slots.start..(slots.start + slots.len().next_multiple_of(WIDTH)).min(N)
}

#[inline(always)]
fn vector<const N: usize>(from: &[[f64; N]; 3], i: usize) -> DVec3 {
    DVec3::new(from[0][i], from[1][i], from[2][i])
}

impl<const N: usize> ColorRoom<N> {
    #[inline(always)]
    fn put_uv(&mut self, i: usize, uv: DVec2) {
        (self.uv[0][i], self.uv[1][i]) = (uv.x, uv.y);
    }
}

impl<const N: usize> Local<N> {
    #[inline(always)]
    fn put(&mut self, i: usize, p: DVec3) {
        (self.point[0][i], self.point[1][i], self.point[2][i]) = (p.x, p.y, p.z);
    }
}

/// Takes points into the space of an object.
struct IntoObject<const N: usize> {
    range: Range<usize>,
    /// Object from world.
    inverse: DAffine3,
}

impl<const N: usize> Task for IntoObject<N> {
    type Input = [[f64; N]; 3];
    type Output = [[f64; N]; 3];

    #[inline(always)]
    fn run(self, point: &[[f64; N]; 3], local: &mut [[f64; N]; 3]) {
        let Self { range, inverse } = self;
        for i in range.start..range.end.min(N) {
            let p = inverse.transform_point3(vector(point, i));
            (local[0][i], local[1][i], local[2][i]) = (p.x, p.y, p.z);
        }
    }
}

/// Finds the texture coordinates of hits with one kind of shape.
struct Coordinates<const SHAPE: u8, const N: usize> {
    range: Range<usize>,
}

const SPHERE: u8 = 0;
const CUBOID: u8 = 1;
const CYLINDER: u8 = 2;
const CONE: u8 = 3;
const CAPS: u8 = 4;
const PLANE: u8 = 5;
const QUAD: u8 = 6;

impl<const SHAPE: u8, const N: usize> Task for Coordinates<SHAPE, N> {
    type Input = Local<N>;
    type Output = [[f64; N]; 2];

    #[inline(always)]
    fn run(self, local: &Local<N>, uv: &mut [[f64; N]; 2]) {
        for i in self.range.start..self.range.end.min(N) {
            let (p, face) = (vector(&local.point, i), local.face[i]);
            let found = match SHAPE {
                SPHERE => sphere_uv(p),
                CUBOID => cuboid_uv(p, face),
                CYLINDER => cylinder_uv(p, face),
                CONE => cone_uv(p, face),
                CAPS => cap_uv(p, face),
                PLANE => plane_uv(p),
                _ => quad_uv(p),
            };
            (uv[0][i], uv[1][i]) = (found.x, found.y);
        }
    }
}

/// Slots with the place of a texture.
struct Placed<const N: usize> {
    range: Range<usize>,
    scale: DVec2,
    offset: DVec2,
}

impl<const N: usize> Placed<N> {
    /// Visits each with its coordinates on the texture.
    #[inline(always)]
    fn each(&self, uv: &[[f64; N]; 2], mut visit: impl FnMut(usize, DVec2)) {
        for i in self.range.start..self.range.end.min(N) {
            visit(i, DVec2::new(uv[0][i], uv[1][i]) * self.scale + self.offset);
        }
    }
}

/// Finds the colours of a checker.
struct Squares<const N: usize> {
    place: Placed<N>,
    colors: [Rgb; 2],
    size: f64,
}

impl<const N: usize> Task for Squares<N> {
    type Input = [[f64; N]; 2];
    type Output = [[f64; N]; 3];

    #[inline(always)]
    fn run(self, uv: &[[f64; N]; 2], color: &mut [[f64; N]; 3]) {
        let [a, b] = self.colors;
        self.place.each(
            uv,
            #[inline(always)]
            |i, uv| {
                let second = is_second(uv, self.size);
                color[0][i] = if second { b.r } else { a.r };
                color[1][i] = if second { b.g } else { a.g };
                color[2][i] = if second { b.b } else { a.b };
            },
        );
    }
}

/// Finds the texels around each point.
struct Surroundings<const N: usize> {
    place: Placed<N>,
    size: DVec2,
    wrap: Wrap,
}

impl<const N: usize> Surroundings<N> {
    #[inline(always)]
    fn find(self, wrap: Wrap, uv: &[[f64; N]; 2], rows: &mut TexelRows<N>) {
        self.place.each(
            uv,
            #[inline(always)]
            |i, uv| {
                let Texels { at, part } = Texels::around(uv, self.size, wrap);
                (rows.at[0][i], rows.at[1][i], rows.at[2][i], rows.at[3][i]) = (at[0], at[1], at[2], at[3]);
                (rows.part[0][i], rows.part[1][i]) = (part[0], part[1]);
            },
        );
    }
}

impl<const N: usize> Task for Surroundings<N> {
    type Input = [[f64; N]; 2];
    type Output = TexelRows<N>;

    #[inline(always)]
    fn run(self, uv: &[[f64; N]; 2], rows: &mut TexelRows<N>) {
        // A loop each.
        match self.wrap {
            Wrap::Repeat => self.find(Wrap::Repeat, uv, rows),
            Wrap::Clamp => self.find(Wrap::Clamp, uv, rows),
            Wrap::Mirror => self.find(Wrap::Mirror, uv, rows),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Image;
    use crate::bvh::Isa;
    use crate::description::{MaterialDesc, ObjectDesc, SceneDesc, ShapeDesc};
    use crate::math::SplitMix64;
    use crate::scene::{Object, compile_for};
    use std::path::Path;
    use std::sync::Arc;

    const N: usize = 96;

    /// Two objects of each shape: as it is, and turned and stretched.
    fn objects(random: &mut SplitMix64) -> Vec<ObjectDesc> {
        let model = |name: &str| {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/models").join(name);
            ShapeDesc::Mesh { file, crease: 30.0 }
        };
        let shapes = [
            ShapeDesc::Sphere { radius: 1.3 },
            ShapeDesc::Sphere { radius: 0.2 },
            ShapeDesc::Cuboid { size: DVec3::new(1.0, 2.0, 0.3) },
            ShapeDesc::Cylinder { radius: 0.8, height: 0.2 },
            ShapeDesc::Cone { radius: 1.5, height: 0.7 },
            ShapeDesc::Plane,
            ShapeDesc::Quad { size: DVec2::new(3.0, 0.5) },
            // With texture coordinates and without.
            model("knot.obj"),
            model("gem.obj"),
        ];
        let mut vector = |lower: f64, upper: f64| DVec3::from_array([(); 3].map(|()| random.range(lower, upper)));
        let placed = |shape: ShapeDesc| {
            let (translate, rotate, scale) = (vector(-3.0, 3.0), vector(-180.0, 180.0), vector(0.5, 2.0));
            ObjectDesc { translate, rotate, scale, ..ObjectDesc::new(shape) }
        };
        shapes.clone().map(ObjectDesc::new).into_iter().chain(shapes.map(placed)).collect()
    }

    fn textures(random: &mut SplitMix64) -> Vec<Option<Texture>> {
        let mut color = || [(); 3].map(|()| random.next_u64() as u8);
        let mut sources = vec![];
        for (width, height) in [(1, 1), (2, 1), (5, 4), (1, 7)] {
            let texels = (0..width * height).map(|_| color()).collect();
            let image = Arc::new(Image { width, height, texels });
            sources.extend([Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(|wrap| Source::Image(image.clone(), wrap)));
        }
        let colors = [Rgb::new(0.1, 0.2, 0.3), Rgb::new(0.9, 0.8, 0.7)];
        sources.extend([0.0625, 0.3, 7.0].map(|size| Source::Checker { colors, size }));
        let mut all = vec![None];
        for source in sources {
            for scale in [DVec2::ONE, DVec2::new(-3.7, 1e6), DVec2::new(1e-3, 0.0), DVec2::new(1e18, 11.0)] {
                let offset = DVec2::new(random.range(-2.0, 2.0), random.range(-2.0, 2.0));
                all.push(Some(Texture { source: source.clone(), scale, offset }));
            }
        }
        all
    }

    /// A place on or near an object: anywhere, on an axis or in a plane through two, where nothing is, at no place.
    fn point(random: &mut SplitMix64, object: &Object) -> DVec3 {
        let mut coordinate = || match random.next_u64() % 40 {
            0..8 => [0.0, -0.0, 1.0, -1.0][random.next_u64() as usize % 4],
            8 => [1e-200, -1e300, 1e17, f64::NAN, f64::INFINITY, f64::NEG_INFINITY][random.next_u64() as usize % 6],
            _ => random.range(-1.2, 1.2),
        };
        object.map.forward.transform_point3(DVec3::new(coordinate(), coordinate(), coordinate()))
    }

    fn faces(shape: &Shape) -> u32 {
        match shape {
            Shape::Cuboid => 6,
            Shape::Cylinder => 3,
            Shape::Cone => 2,
            Shape::Mesh(mesh) => mesh.len() as u32,
            _ => 1,
        }
    }

    fn compare(random: &mut SplitMix64, scene: &Scene, material: &Material) {
        let objects = scene.objects();
        let mut number = 0;
        let hits: Vec<Option<Hit>> = (0..N)
            .map(|_| {
                // Now and then another one.
                if random.next_u64().is_multiple_of(9) {
                    number = random.next_u64() as usize % objects.len();
                }
                let shape = &objects[number].shape;
                let least = u32::from(matches!(shape, Shape::Cylinder | Shape::Cone) && random.unit() < 0.9);
                let primitive = least + random.next_u64() as u32 % (faces(shape) - least);
                let (u, v) = (random.range(0.0, 0.5), random.range(0.0, 0.5));
                (random.unit() < 0.98).then_some(Hit { t: 1.0, object: number as u32, primitive, u, v })
            })
            .collect();
        let mut points = [[0.0; N]; 3];
        for i in 0..N {
            let p = point(random, &objects[hits[i].map_or(0, |hit| hit.object as usize)]);
            (points[0][i], points[1][i], points[2][i]) = (p.x, p.y, p.z);
        }
        let start = [0, 8, 40, 5][random.next_u64() as usize % 4];
        let slots = start..start + random.next_u64() as usize % (N - start + 1);
        let (mut room, mut found) = (Box::<ColorRoom<N>>::default(), [[7.0; N]; 3]);
        scene.colors(material, slots.clone(), |slot| hits[slot].as_ref(), &points, &mut room, &mut found);
        for i in 0..N {
            let (found, place) = ([found[0][i], found[1][i], found[2][i]], vector(&points, i));
            if let (true, Some(hit)) = (slots.contains(&i), &hits[i]) {
                let Rgb { r, g, b } = material.color(|| scene.uv(hit, place));
                assert_eq!(found.map(f64::to_bits), [r, g, b].map(f64::to_bits), "{place}: {found:?}, {material:?}");
            } else if !whole::<N>(&slots).contains(&i) {
                assert_eq!(found, [7.0; 3]);
            }
        }
    }

    #[test]
    fn colors_side_by_side_have_the_bits_of_single_ones() {
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let mut random = SplitMix64(11);
            let desc = SceneDesc { objects: objects(&mut random), ..SceneDesc::default() };
            let scene = compile_for(&desc, None, isa).expect("the scene is right");
            for texture in textures(&mut random) {
                let material = Material::new(&MaterialDesc::default(), texture);
                for _ in 0..40 {
                    compare(&mut random, &scene, &material);
                }
            }
        }
    }
}
