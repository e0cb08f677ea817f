//! A scene around a model: a camera that frames it, two lights and a floor.

use crate::bvh::Isa;
use crate::description::{
    Background, CameraDesc, FilmDesc, LightDesc, LightKind, MaterialDesc, ObjectDesc, Projection, RenderDesc,
    SceneDesc, ShapeDesc, WorldDesc, limits, parse_color,
};
use crate::math::Rgb;
use crate::scene::{CompileError, Object, Scene, Shape, compile_for};
use glam::DVec3;
use std::path::Path;

/// Vertical angle of view, degrees.
const FOV: f64 = 32.0;
/// From the model to the eye: from the front, a little from the right and from above.
const TO_EYE: DVec3 = DVec3::new(0.45, 0.32, 1.0);
/// Share of the picture's width or height that the model's box may fill.
const FILL: f64 = 0.92;

/// A scene that shows the model in `file`, framed for `film`, and the model compiled, so that it need not be read
/// again. Errors are those of reading the model.
pub fn scene_of_model(file: &Path, film: FilmDesc, isa: Isa) -> Result<(SceneDesc, Scene), CompileError> {
    let stem = file.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
    let mesh = ShapeDesc::Mesh { file: file.to_path_buf(), crease: limits::DEFAULT_CREASE };
    let model = ObjectDesc { name: stem, ..ObjectDesc::new(mesh) };
    let alone = compile_for(&SceneDesc { objects: vec![model.clone()], ..SceneDesc::default() }, None, isa)?;
    let (lower, upper) = alone
        .objects()
        .iter()
        .find_map(Object::bounds)
        .map_or((DVec3::NEG_ONE, DVec3::ONE), |bounds| (bounds.lower.as_dvec3(), bounds.upper.as_dvec3()));
    Ok((around(model, is_bare(&alone), lower, upper, film), alone))
}

/// Whether the model's file has no materials of its own.
fn is_bare(alone: &Scene) -> bool {
    alone.objects().iter().all(|object| matches!(&object.shape, Shape::Mesh(mesh) if mesh.materials.is_empty()))
}

/// The scene around a model with this box. A bare model is made of clay.
fn around(model: ObjectDesc, bare: bool, lower: DVec3, upper: DVec3, film: FilmDesc) -> SceneDesc {
    let (centre, radius) = ((lower + upper) / 2.0, (upper - lower).length() / 2.0);
    let clay = MaterialDesc { color: color("#d9c7b0"), ambient: 0.2, specular: 0.15, ..named("clay") };
    let floor = MaterialDesc { color: color("#c9ccd1"), ambient: 0.25, specular: 0.0, reflect: 0.06, ..named("floor") };
    let light = |name: &str, from: DVec3, tint: &str, intensity| LightDesc {
        name: name.into(),
        kind: LightKind::Directional { direction: -from },
        color: color(tint),
        intensity,
        visible: true,
    };
    let ground = ObjectDesc {
        name: "floor".into(),
        material: Some(floor.name.clone()),
        // Not in the plane of a model that is flat itself.
        translate: DVec3::new(centre.x, lower.y - 1e-4 * radius, centre.z),
        ..ObjectDesc::new(ShapeDesc::Plane)
    };
    SceneDesc {
        film,
        camera: framing(lower, upper, f64::from(film.width) / f64::from(film.height)),
        world: WorldDesc {
            background: Background::Gradient { top: color("#5f86bd"), bottom: color("#f3efe8") },
            ..WorldDesc::default()
        },
        render: RenderDesc::default(),
        lights: vec![
            light("key", DVec3::new(-2.4, 3.6, 3.0), "#fff4e2", 0.75),
            light("fill", DVec3::new(3.4, 2.2, 2.2), "#dbe7ff", 0.35),
        ],
        objects: vec![ObjectDesc { material: bare.then(|| clay.name.clone()), ..model }, ground],
        materials: if bare { vec![clay, floor] } else { vec![floor] },
    }
}

/// A camera from whose eye no corner of the box lies outside of the picture, and which is no farther than that needs.
fn framing(lower: DVec3, upper: DVec3, aspect: f64) -> CameraDesc {
    let centre = (lower + upper) / 2.0;
    let back = TO_EYE.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let slope_up = FILL * (FOV.to_radians() / 2.0).tan();
    let slope_right = slope_up * aspect;
    let half = (upper - lower) / 2.0;
    let distance = (0..8)
        .map(|corner| {
            let sign = |bit: i32| if corner & bit == 0 { -1.0 } else { 1.0 };
            let corner = half * DVec3::new(sign(1), sign(2), sign(4));
            corner.dot(back) + (corner.dot(right).abs() / slope_right).max(corner.dot(up).abs() / slope_up)
        })
        .fold(half.length(), f64::max);
    CameraDesc {
        position: centre + distance * back,
        look_at: centre,
        up: DVec3::Y,
        projection: Projection::Perspective { fov: FOV },
    }
}

fn named(name: &str) -> MaterialDesc {
    MaterialDesc { name: name.into(), ..MaterialDesc::default() }
}

fn color(code: &str) -> Rgb {
    parse_color(code).unwrap_or(Rgb::WHITE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    #[test]
    fn every_corner_of_any_box_is_inside_the_picture_and_one_is_near_its_edge() {
        let mut random = SplitMix64(11);
        for _ in 0..1000 {
            let scale = 10f64.powf(random.range(-3.0, 4.0));
            let mut point = || DVec3::from_array([(); 3].map(|()| scale * random.range(-1.0, 1.0)));
            let (a, b) = (point(), point());
            let (lower, upper) = (a.min(b), a.max(b));
            let aspect = 2f64.powf(random.range(-3.0, 3.0));
            let camera = framing(lower, upper, aspect);
            let forward = (camera.look_at - camera.position).normalize();
            let right = forward.cross(camera.up).normalize();
            let up = right.cross(forward);
            let slope = (FOV.to_radians() / 2.0).tan();
            let mut farthest = 0f64;
            for corner in 0..8 {
                let pick = |bit: i32, axis: usize| if corner & bit == 0 { lower[axis] } else { upper[axis] };
                let to = DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2)) - camera.position;
                assert!(to.dot(forward) > 0.0);
                let (x, y) = (to.dot(right) / to.dot(forward), to.dot(up) / to.dot(forward));
                farthest = farthest.max(x.abs() / (slope * aspect)).max(y.abs() / slope);
            }
            assert!((0.2..=FILL + 1e-9).contains(&farthest), "{farthest} for {lower} {upper} {aspect}");
        }
    }
}
