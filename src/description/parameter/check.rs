//! Whether an entry is one that a scene file may hold.

use super::super::target::Entry;
use super::super::{
    Background, LightDesc, LightKind, MaterialDesc, ObjectDesc, Projection, Refused, SceneDesc, ShapeDesc, Target,
    TextureDesc, TextureSource, Wrap,
};
use super::{Interval, parameters};
use crate::description::limits;
use glam::{DVec2, DVec3};

/// Whether an entry keeps every limit of the scene language, so that what is saved of it can be parsed.
pub fn check(desc: &SceneDesc, target: Target) -> Result<(), Refused> {
    for parameter in parameters(target) {
        if let Some(value) = (parameter.read)(desc, target) {
            parameter.check(&value)?;
        }
    }
    match target {
        Target::Camera => check_camera(desc),
        Target::Object(index) => check_object(desc, index),
        Target::Light(index) => {
            let light = &desc.lights[index];
            let names = desc.lights.iter().map(|light| light.name.as_str());
            check_name("light", &light.name, names)?;
            match light.kind {
                // The square of what is shorter could round to 0.
                LightKind::Directional { direction } if direction.abs().max_element() < 1e-100 => {
                    Err(Refused::new("a direction of 0, 0, 0 leads nowhere"))
                }
                _ => Ok(()),
            }
        }
        Target::Material(index) => {
            let material = &desc.materials[index];
            if material.name.is_empty() {
                return Err(Refused::new("a material needs a name"));
            }
            let names = desc.materials.iter().map(|material| material.name.as_str());
            check_name("material", &material.name, names)?;
            match &material.texture {
                Some(TextureDesc { scale, .. }) if scale.x == 0.0 || scale.y == 0.0 => Err(scale_of_zero()),
                _ => Ok(()),
            }
        }
        Target::Film | Target::World | Target::Render => Ok(()),
    }
}

fn check_camera(desc: &SceneDesc) -> Result<(), Refused> {
    let camera = &desc.camera;
    if camera.up.abs().max_element() < 1e-100 {
        return Err(Refused::new("up of 0, 0, 0 leads nowhere"));
    }
    let view = (camera.look_at - camera.position).normalize_or_zero();
    if view == DVec3::ZERO {
        Err(Refused::new("the camera cannot look at its own position"))
    } else if view.cross(camera.up.normalize_or_zero()).length() < limits::MIN_UP_SINE {
        Err(Refused::new("the camera cannot look along its up"))
    } else {
        Ok(())
    }
}

fn check_object(desc: &SceneDesc, index: usize) -> Result<(), Refused> {
    let object = &desc.objects[index];
    check_name("object", &object.name, desc.objects.iter().map(|object| object.name.as_str()))?;
    if object.scale.abs().min_element() < limits::MIN_LENGTH {
        return Err(scale_of_zero());
    }
    match &object.material {
        Some(name) if !desc.materials.iter().any(|material| material.name == *name) => {
            Err(Refused::new(format!("there is no material {name}")))
        }
        _ => Ok(()),
    }
}

fn scale_of_zero() -> Refused {
    Refused::new("a scale of 0 leaves nothing")
}

fn check_name<'a>(kind: &str, name: &str, all: impl Iterator<Item = &'a str>) -> Result<(), Refused> {
    match name {
        "" => Ok(()),
        name if all.filter(|other| *other == name).count() > 1 => {
            Err(Refused::new(format!("another {kind} is named {name}")))
        }
        _ => Ok(()),
    }
}

/// A description in which the entry is as if the file said nothing of it but what kind it is, and where that entry is.
pub(super) fn bare(desc: &SceneDesc, target: Target) -> Option<(SceneDesc, Target)> {
    let mut bare = SceneDesc::default();
    let at = match target {
        Target::Object(_) => {
            let object = ObjectDesc::of(desc, target)?;
            bare.materials.clone_from(&desc.materials);
            bare.objects.push(ObjectDesc::new(bare_shape(&object.shape)));
            Target::Object(0)
        }
        Target::Light(_) => {
            let light = LightDesc::of(desc, target)?;
            let kind = match light.kind {
                LightKind::Point { .. } => LightDesc::default().kind,
                LightKind::Directional { .. } => LightKind::Directional { direction: DVec3::NEG_Y },
            };
            bare.lights.push(LightDesc { kind, ..LightDesc::default() });
            Target::Light(0)
        }
        Target::Material(_) => {
            let material = MaterialDesc::of(desc, target)?;
            let texture = material.texture.as_ref().map(bare_texture);
            bare.materials.push(MaterialDesc { texture, name: material.name.clone(), ..MaterialDesc::default() });
            Target::Material(0)
        }
        Target::Camera => {
            if let Projection::Orthographic { .. } = desc.camera.projection {
                let distance = desc.camera.position.distance(desc.camera.look_at);
                bare.camera.projection = Projection::Orthographic { view_height: default_view_height(distance) };
            }
            Target::Camera
        }
        Target::World => {
            // A gradient has no colours of its own.
            if let gradient @ Background::Gradient { .. } = desc.world.background {
                bare.world.background = gradient;
            }
            Target::World
        }
        Target::Render => {
            // As the parser has it.
            if desc.render.error.is_some() {
                bare.render.samples = limits::ADAPTIVE_SAMPLES;
            }
            target
        }
        Target::Film => target,
    };
    Some((bare, at))
}

fn bare_shape(shape: &ShapeDesc) -> ShapeDesc {
    match shape {
        ShapeDesc::Sphere { .. } => ShapeDesc::Sphere { radius: 0.5 },
        ShapeDesc::Cuboid { .. } => ShapeDesc::Cuboid { size: DVec3::ONE },
        ShapeDesc::Cylinder { .. } => ShapeDesc::Cylinder { radius: 0.5, height: 1.0 },
        ShapeDesc::Cone { .. } => ShapeDesc::Cone { radius: 0.5, height: 1.0 },
        ShapeDesc::Quad { .. } => ShapeDesc::Quad { size: DVec2::ONE },
        ShapeDesc::Mesh { file, .. } => ShapeDesc::Mesh { file: file.clone(), crease: limits::DEFAULT_CREASE },
        ShapeDesc::Plane | ShapeDesc::Spheres { .. } => shape.clone(),
    }
}

/// Files and colours have no default, they stay.
fn bare_texture(texture: &TextureDesc) -> TextureDesc {
    let source = match &texture.source {
        TextureSource::Image { file, .. } => TextureSource::Image { file: file.clone(), wrap: Wrap::Repeat },
        TextureSource::Checker { colors, .. } => TextureSource::Checker { colors: *colors, size: 1.0 },
    };
    TextureDesc { source, scale: DVec2::ONE, offset: DVec2::ZERO }
}

/// What a perspective camera with the default angle shows at this distance.
pub fn default_view_height(distance: f64) -> f64 {
    Interval::LENGTH.clamp(2.0 * distance * (limits::DEFAULT_FOV / 2.0).to_radians().tan())
}
