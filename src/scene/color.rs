//! The colours of many hits, side by side in arrays: in loops that the compiler makes vector code of, with the functions
//! that single hits take ([`Scene::uv`](super::Scene::uv), [`Material::color`]), so that every hit gets the bits that it
//! gets alone.

#![allow(clippy::needless_range_loop)] // Numbers of slots run over several arrays at once.

use super::texture::{Source, Texels, Texture, is_second};
use super::{Material, Object, Shape};
use crate::bvh::{Bvh, Task};
use crate::description::Wrap;
use crate::geometry::{cap_uv, cone_uv, cuboid_uv, cylinder_uv, plane_uv, quad_uv, sphere_uv};
use crate::math::{Rgb, srgb8_table};
use glam::{DAffine3, DVec2, DVec3};
use std::ops::Range;

/// Slots are computed so many at a time.
const WIDTH: usize = 8;

/// Hits, number by number.
pub(super) struct Spots<'a, const N: usize> {
    /// On the surface, in world space.
    pub point: &'a [[f64; N]; 3],
    /// What was met of the object.
    pub primitive: &'a [u32; N],
    /// Of the second and third corner of a triangle.
    pub weights: &'a [[f64; N]; 2],
}

/// Room for what is computed on the way.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct ColorRoom<const N: usize> {
    uv: [[f64; N]; 2],
    texels: TexelRows<N>,
}

/// [`Texels`], number by number.
#[derive(Debug)]
struct TexelRows<const N: usize> {
    at: [[u32; N]; 4],
    part: [[f64; N]; 2],
}

impl<const N: usize> Default for ColorRoom<N> {
    fn default() -> Self {
        Self { uv: [[0.0; N]; 2], texels: TexelRows { at: [[0; N]; 4], part: [[0.0; N]; 2] } }
    }
}

/// The colours of the hits of a range, all with one object and one of its materials: what [`Material::color`] gives at
/// the coordinates that [`Scene::uv`](super::Scene::uv) gives. Colours behind the range are overwritten, too, until a
/// multiple of [`WIDTH`] is done.
pub(super) fn colors<const N: usize>(
    tree: &Bvh,
    object: &Object,
    material: &Material,
    range: Range<usize>,
    spots: &Spots<N>,
    room: &mut ColorRoom<N>,
    color: &mut [[f64; N]; 3],
) {
    let Some(Texture { source, scale, offset }) = &material.texture else {
        let Rgb { r, g, b } = material.color;
        for (row, value) in color.iter_mut().zip([r, g, b]) {
            row[range.clone()].fill(value);
        }
        return;
    };
    find_uv(tree, object, range.clone(), spots, &mut room.uv);
    let place = Placed { range: whole::<N>(&range), scale: *scale, offset: *offset };
    match source {
        &Source::Checker { colors, size } => tree.run(Squares { place, colors, size }, &room.uv, color),
        Source::Image(image, wrap) => {
            let task = Surroundings { place, size: image.size(), wrap: *wrap };
            tree.run(task, &room.uv, &mut room.texels);
            // Not a task: most of it are loads from places that depend on the hit. Texels of four linear f32 would be
            // less work but more memory: 1.25 times the time with 256² texels, twice with 1024².
            let (TexelRows { at, part }, linear) = (&room.texels, srgb8_table());
            for i in range {
                let texels = Texels { at: [at[0][i], at[1][i], at[2][i], at[3][i]], part: [part[0][i], part[1][i]] };
                let Rgb { r, g, b } = image.blend(linear, &texels);
                (color[0][i], color[1][i], color[2][i]) = (r, g, b);
            }
        }
    }
}

/// The range, to the end of its last vector.
fn whole<const N: usize>(range: &Range<usize>) -> Range<usize> {
    range.start..(range.start + range.len().next_multiple_of(WIDTH)).min(N)
}

/// The texture coordinates of hits with an object.
fn find_uv<const N: usize>(tree: &Bvh, object: &Object, range: Range<usize>, spots: &Spots<N>, uv: &mut [[f64; N]; 2]) {
    macro_rules! run {
        ($shape:ident) => {
            tree.run(Coordinates::<$shape, N> { range: whole::<N>(&range), inverse: &object.map.inverse }, spots, uv)
        };
    }
    // Flat faces have no angles to find, and often nothing else of a body is seen.
    let flat = || spots.primitive[range.clone()].iter().all(|face| *face != 0);
    match &object.shape {
        Shape::Ball { .. } | Shape::Ellipsoid => run!(SPHERE),
        Shape::Cuboid => run!(CUBOID),
        Shape::Cylinder | Shape::Cone if flat() => run!(CAPS),
        Shape::Cylinder => run!(CYLINDER),
        Shape::Cone => run!(CONE),
        Shape::Plane => run!(PLANE),
        Shape::Quad => run!(QUAD),
        Shape::Mesh(mesh) => {
            for i in range {
                let found = mesh.uv(spots.primitive[i], spots.weights[0][i], spots.weights[1][i]);
                (uv[0][i], uv[1][i]) = (found.x, found.y);
            }
        }
    }
}

/// Finds the texture coordinates of hits with one kind of shape.
struct Coordinates<'a, const SHAPE: u8, const N: usize> {
    range: Range<usize>,
    /// Object from world.
    inverse: &'a DAffine3,
}

const SPHERE: u8 = 0;
const CUBOID: u8 = 1;
const CYLINDER: u8 = 2;
const CONE: u8 = 3;
const CAPS: u8 = 4;
const PLANE: u8 = 5;
const QUAD: u8 = 6;

impl<'a, const SHAPE: u8, const N: usize> Task for Coordinates<'a, SHAPE, N> {
    type Input = Spots<'a, N>;
    type Output = [[f64; N]; 2];

    #[inline(always)]
    fn run(self, spots: &Spots<'a, N>, uv: &mut [[f64; N]; 2]) {
        let (point, inverse) = (spots.point, *self.inverse);
        for i in self.range.start..self.range.end.min(N) {
            let p = inverse.transform_point3(DVec3::new(point[0][i], point[1][i], point[2][i]));
            let face = spots.primitive[i];
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
    use crate::geometry::Hit;
    use crate::math::SplitMix64;
    use crate::scene::{Scene, compile_for};
    use std::path::Path;
    use std::sync::Arc;

    const N: usize = 48;

    /// Two objects of each shape: as it is, and turned and stretched.
    fn objects(random: &mut SplitMix64) -> Vec<ObjectDesc> {
        let model = |name: &str| {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/models").join(name);
            ShapeDesc::Mesh { file, crease: 30.0 }
        };
        let shapes = [
            ShapeDesc::Sphere { radius: 1.3 },
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

    fn compare(random: &mut SplitMix64, scene: &Scene, number: usize, material: &Material) {
        let object = &scene.objects()[number];
        let mut primitive = [0; N];
        let least = u32::from(matches!(object.shape, Shape::Cylinder | Shape::Cone) && random.unit() < 0.5);
        primitive.fill_with(|| least + random.next_u64() as u32 % (faces(&object.shape) - least));
        let weights = [(); 2].map(|()| [(); N].map(|()| random.range(0.0, 0.5)));
        let mut points = [[0.0; N]; 3];
        for i in 0..N {
            let p = point(random, object);
            (points[0][i], points[1][i], points[2][i]) = (p.x, p.y, p.z);
        }
        let start = [0, 8, 40, 5][random.next_u64() as usize % 4];
        let range = start..start + random.next_u64() as usize % (N - start + 1);
        let (mut room, mut found) = (Box::<ColorRoom<N>>::default(), [[7.0; N]; 3]);
        let spots = Spots { point: &points, primitive: &primitive, weights: &weights };
        colors(&scene.geometry.tree, object, material, range.clone(), &spots, &mut room, &mut found);
        for i in 0..N {
            let found = [found[0][i], found[1][i], found[2][i]];
            let place = DVec3::new(points[0][i], points[1][i], points[2][i]);
            let (u, v) = (weights[0][i], weights[1][i]);
            let hit = Hit { t: 1.0, object: number as u32, primitive: primitive[i], u, v };
            let Rgb { r, g, b } = material.color(|| scene.uv(&hit, place));
            if range.contains(&i) {
                assert_eq!(found.map(f64::to_bits), [r, g, b].map(f64::to_bits), "{place}: {found:?}, {material:?}");
            } else if !whole::<N>(&range).contains(&i) {
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
                for number in (0..scene.objects().len()).cycle().take(48) {
                    compare(&mut random, &scene, number, &material);
                }
            }
        }
    }
}
