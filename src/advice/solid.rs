//! Meshes that are something simpler.

use crate::description::{ObjectDesc, Projection, SceneDesc, ShapeDesc};
use crate::math::Affine;
use crate::scene::{Mesh, Object};
use glam::DVec3;
use std::f64::consts::PI;

/// How large a pixel of the scene's own film is, where an object is nearest to the eye; `None` if the eye may be in it.
pub(super) fn pixel_size(desc: &SceneDesc, object: &Object) -> Option<f64> {
    let height = f64::from(desc.film.height);
    match desc.camera.projection {
        Projection::Orthographic { view_height } => Some(view_height / height),
        Projection::Perspective { fov } => {
            let bounds = object.bounds()?;
            let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
            let distance = desc.camera.position.clamp(lower, upper).distance(desc.camera.position);
            (distance > 0.0).then(|| 2.0 * distance * (fov.to_radians() / 2.0).tan() / height)
        }
    }
}

/// The object as a sphere or a cuboid, if the mesh is one to within `allowed` in world space.
pub(super) fn fit(mesh: &Mesh, own: &ObjectDesc, allowed: f64) -> Option<ObjectDesc> {
    let map = Affine::from_scale_rotate_translate(own.scale, own.rotate, own.translate)?;
    let allowed = allowed / own.scale.abs().max_element();
    let (shape, centre) = sphere(mesh, allowed).or_else(|| cuboid(mesh, allowed))?;
    Some(ObjectDesc { shape, translate: map.forward.transform_point3(mesh.centre + centre), ..own.clone() })
}

/// What it is called.
pub(super) fn word(shape: &ShapeDesc) -> &'static str {
    if matches!(shape, ShapeDesc::Sphere { .. }) { "sphere" } else { "cuboid" }
}

fn bounds(mesh: &Mesh) -> Option<(DVec3, DVec3)> {
    let corners = (0..mesh.len() as u32).flat_map(|triangle| mesh.corners(triangle));
    corners.map(|p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// All of it lies between two spheres that are closer together than `allowed`, and it encloses as much: the sphere in
/// the middle.
fn sphere(mesh: &Mesh, allowed: f64) -> Option<(ShapeDesc, DVec3)> {
    let (lower, upper) = bounds(mesh)?;
    let centre = (lower + upper) / 2.0;
    let (mut inner, mut outer) = (f64::INFINITY, 0.0f64);
    for triangle in 0..mesh.len() as u32 {
        let corners = mesh.corners(triangle);
        let [a, b, c] = corners.map(|p| p - centre);
        // Where it is deepest, nearly. Not its plane: that of a sliver at a pole may be any.
        let deepest = [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        inner = deepest.iter().fold(inner, |inner, p| inner.min(p.length()));
        outer = corners.iter().fold(outer, |outer, p| outer.max(p.distance(centre)));
    }
    let radius = (inner + outer) / 2.0;
    let volume = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
    let is_whole = (volume(inner)..=volume(outer)).contains(&mesh.volume);
    (outer - inner <= 2.0 * allowed && is_whole).then_some((ShapeDesc::Sphere { radius }, centre))
}

/// All of it lies as close as `allowed` to a face of its box, and it encloses as much.
fn cuboid(mesh: &Mesh, allowed: f64) -> Option<(ShapeDesc, DVec3)> {
    let (lower, upper) = bounds(mesh)?;
    let size = upper - lower;
    let lies_on_a_face = |triangle: u32| {
        let corners = mesh.corners(triangle);
        (0..3).any(|axis| {
            let near = |face: f64| corners.iter().all(|p| (p[axis] - face).abs() <= allowed);
            near(lower[axis]) || near(upper[axis])
        })
    };
    let whole = size.element_product();
    // What a layer of that thickness holds.
    let missing = allowed * 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let is_whole = whole > 0.0 && (mesh.volume - whole).abs() <= missing;
    let fits = is_whole && size.min_element() > 4.0 * allowed && (0..mesh.len() as u32).all(lies_on_a_face);
    fits.then_some((ShapeDesc::Cuboid { size }, (lower + upper) / 2.0))
}
