//! Where objects are seen that are thinner than a pixel, so that single samples would miss them.

use crate::scene::{Camera, Object, Scene, Shape, Shell};
use glam::{DVec2, DVec3};

/// In a scene of more objects, samples alone tell: looking at each would take longer than a frame.
const MOST_OBJECTS: usize = 1 << 16;

/// A mesh of more triangles is taken whole: finding its parts would take longer than a frame.
const MOST_TRIANGLES: usize = 1 << 16;

/// Samples that are expected to fall on a thing where it crosses a pixel.
pub(super) const HITS: f64 = 4.0;

/// Samples that a pixel gets for it at least and at most.
const LEAST: u8 = 4;
const MOST: u8 = 128;

/// Parts of a long object are about so many pixels long.
const PART: f64 = 4.0;

/// For each pixel of the film, row by row, how many samples it takes to see the objects there that are thinner than a
/// pixel; 0 where there are none. Empty if there are none at all.
///
/// An object is taken for its box, a long one for a row of boxes; a mesh for the boxes of its parts. What is seen in
/// mirrors and through glass, shadows and textures are not looked at, nor wires of a mesh that are bent or hang
/// together.
pub(super) fn thin(scene: &Scene) -> Vec<u8> {
    let mut marks = Marks { width: scene.width, height: scene.height, samples: Vec::new() };
    if scene.objects().len() <= MOST_OBJECTS {
        scene.objects().iter().for_each(|object| boxes(object, |shell| mark(&mut marks, &scene.camera, shell)));
    }
    marks.samples
}

struct Marks {
    width: u32,
    height: u32,
    samples: Vec<u8>,
}

impl Marks {
    /// Puts down `samples` in all pixels of a rectangle on the film.
    fn put(&mut self, lower: DVec2, upper: DVec2, samples: u8) {
        // Casts saturate, so that what is off the film is cut off.
        let (left, top) = (lower.x.floor() as u32, lower.y.floor() as u32);
        let (right, bottom) = ((upper.x.ceil() as u32).min(self.width), (upper.y.ceil() as u32).min(self.height));
        if left >= right || top >= bottom {
            return;
        }
        if self.samples.is_empty() {
            self.samples = vec![0; self.width as usize * self.height as usize];
        }
        for y in top..bottom {
            let row = y as usize * self.width as usize;
            for mark in &mut self.samples[row + left as usize..row + right as usize] {
                *mark = samples.max(*mark);
            }
        }
    }
}

/// `shell`: in world space.
fn mark(marks: &mut Marks, camera: &Camera, shell: Shell) {
    let Shell { middle: centre, mut edges } = shell;
    edges.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    let ends = (camera.project(centre - edges[0]), camera.project(centre + edges[0]));
    let parts = match ends {
        (Some(a), Some(b)) => (a.distance(b) / PART).ceil().clamp(1.0, 4096.0),
        (None, None) => return,
        // One end is behind the eye.
        _ => (f64::from(marks.width + marks.height) / PART).ceil(),
    };
    let step = edges[0] / parts;
    for part in 0..parts as u32 {
        let middle = centre + step * (f64::from(2 * part + 1) - parts);
        let Some(at) = camera.project(middle) else { continue };
        let ends = [step, edges[1], edges[2]].map(|edge| camera.project(middle + edge));
        let [Some(a), Some(b), Some(c)] = ends else { continue };
        let halves = [a - at, b - at, c - at];
        // How thick a part of a long object is says nothing along it.
        let width = if parts > 1.0 { across(halves, halves[0]) } else { width(halves) };
        if width < 1.0 {
            let reach = halves.into_iter().fold(DVec2::ZERO, |sum, half| sum + half.abs());
            let samples = ((HITS / width).min(MOST.into()).ceil() as u8).max(LEAST).next_power_of_two();
            marks.put(at - reach, at + reach, samples);
        }
    }
}

/// The smallest width of the parallel projection of a box with these halves of edges: across one of them.
fn width(halves: [DVec2; 3]) -> f64 {
    let long = halves.iter().filter(|half| half.length_squared() > 1e-24);
    long.map(|half| across(halves, *half)).fold(f64::INFINITY, f64::min)
}

/// Its width across a direction.
fn across(halves: [DVec2; 3], direction: DVec2) -> f64 {
    let normal = direction.perp().normalize_or_zero();
    (2.0 * halves.iter().map(|half| half.dot(normal).abs()).sum::<f64>()).max(1e-9)
}

/// Calls `visit` with boxes around an object or its parts, in world space; with none if it has no end.
fn boxes(object: &Object, mut visit: impl FnMut(Shell)) {
    let map = &object.map.forward;
    let mut place = |Shell { middle, edges }| {
        let edges = edges.map(|edge| map.transform_vector3(edge));
        visit(Shell { middle: map.transform_point3(middle), edges });
    };
    let (lower, upper) = match &object.shape {
        Shape::Plane => return,
        Shape::Mesh(mesh) if mesh.is_empty() => return,
        Shape::Mesh(mesh) if mesh.len() <= MOST_TRIANGLES => return mesh.shells().iter().copied().for_each(place),
        Shape::Mesh(mesh) => (mesh.bounds().lower.as_dvec3(), mesh.bounds().upper.as_dvec3()),
        Shape::Quad => (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0)),
        _ => (DVec3::NEG_ONE, DVec3::ONE),
    };
    let half = (upper - lower) / 2.0;
    place(Shell { middle: (lower + upper) / 2.0, edges: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z] });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{CameraDesc, ObjectDesc, Projection, SceneDesc, ShapeDesc};
    use crate::scene::compile;

    /// A box of this size in the middle of a film of 40 by 30 pixels, each one unit wide, turned about the line of
    /// sight.
    fn marks(size: DVec3, degrees: f64, projection: Projection) -> Vec<u8> {
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (40, 30);
        desc.camera =
            CameraDesc { position: DVec3::new(0.0, 0.0, 100.0), look_at: DVec3::ZERO, up: DVec3::Y, projection };
        let shape = ShapeDesc::Cuboid { size };
        desc.objects = vec![ObjectDesc { rotate: DVec3::Z * degrees, ..ObjectDesc::new(shape) }];
        thin(&compile(&desc, None).unwrap())
    }

    const FLAT: Projection = Projection::Orthographic { view_height: 30.0 };

    #[test]
    fn all_pixels_that_a_turned_wire_crosses_are_marked_and_few_others() {
        for degrees in [0.0f64, 1.0, 23.0, 45.0, 61.0, 90.0, 137.0] {
            for width in [0.03, 0.1, 0.4, 0.9] {
                let marks = marks(DVec3::new(24.0, width, 0.2), degrees, FLAT);
                let (sin, cos) = degrees.to_radians().sin_cos();
                // The ends lie between two pixels.
                for i in 1..1000 {
                    let along = 24.0 * (f64::from(i) / 1000.0 - 0.5);
                    let (x, y) = (20.0 + along * cos, 15.0 - along * sin);
                    let mark = marks[y as usize * 40 + x as usize];
                    assert!(f64::from(mark) * width >= 3.8, "{degrees} degrees, {width} wide: {mark} at {x}, {y}");
                }
                let marked = marks.iter().filter(|mark| **mark > 0).count();
                assert!(marked < 6 * 26, "{degrees} degrees, {width} wide: {marked}");
            }
        }
    }

    #[test]
    fn what_is_as_thick_as_a_pixel_is_not_marked_and_perspective_counts() {
        let thick = DVec3::new(24.0, 1.2, 1.2);
        assert!(marks(thick, 30.0, FLAT).is_empty());
        // A floor seen aslant: no part of it is thin.
        let mut desc = SceneDesc::default();
        (desc.film.width, desc.film.height) = (53, 29);
        desc.camera =
            CameraDesc { position: DVec3::new(1.76, 1.48, 4.8), look_at: DVec3::Y * 0.42, ..CameraDesc::default() };
        desc.objects = vec![ObjectDesc::new(ShapeDesc::Quad { size: DVec2::new(9.9, 6.6) })];
        assert!(thin(&compile(&desc, None).unwrap()).is_empty());
        // The film is 30 pixels high; at distance 100 an angle of 2 atan(0.6) shows 120 units.
        let wide = Projection::Perspective { fov: 2.0 * 0.6f64.atan().to_degrees() };
        assert_eq!(marks(thick, 30.0, wide)[15 * 40 + 20], 16);
    }
}
