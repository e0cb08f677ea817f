//! The list itself.

use super::super::target::Entry;
use super::super::{
    Background, CameraDesc, Falloff, FilmDesc, Filter, Interval, LightDesc, LightKind, MaterialDesc, Numerics,
    ObjectDesc, Projection, RenderDesc, Shading, Shadows, ShapeDesc, TextureDesc, TextureSource, WorldDesc, Wrap,
    limits,
};
use super::check::default_view_height;
use super::{FileKind, Kind, Parameter, Step, Value};
use crate::math::Rgb;
use glam::DVec3;

/// A parameter that is one field of its entry: `$place` finds it, or `None` where the entry has no such field.
macro_rules! field {
    ($label:literal, $unit:literal, $kind:expr, $value:ident, $of:ty, |$entry:ident| $place:expr) => {
        Parameter {
            label: $label,
            unit: $unit,
            kind: $kind,
            read: |desc, target| {
                let mut copy = <$of>::of(desc, target)?.clone();
                let $entry = &mut copy;
                $place.map(|field| Value::$value(field.clone()))
            },
            write: |desc, target, value| {
                let $entry = <$of>::of_mut(desc, target)?;
                let Value::$value(value) = value else { return None };
                *$place? = value;
                Some(())
            },
        }
    };
}

macro_rules! number {
    ($label:literal, $unit:literal, $range:ident, $step:expr, $of:ty, |$entry:ident| $place:expr) => {
        field!($label, $unit, Kind::Number { range: Interval::$range, step: $step }, Number, $of, |$entry| $place)
    };
}

/// A whole number that its entry keeps as `$type`.
macro_rules! integer {
    ($label:literal, $unit:literal, $range:expr, $step:expr, $type:ty, $of:ty, $($field:ident).+) => {
        Parameter {
            label: $label,
            unit: $unit,
            kind: Kind::Integer { range: $range, step: $step },
            read: |desc, target| Some(Value::Integer(<$of>::of(desc, target)?.$($field).+.into())),
            write: |desc, target, value| {
                let Value::Integer(value) = value else { return None };
                <$of>::of_mut(desc, target)?.$($field).+ = <$type>::try_from(value).ok()?;
                Some(())
            },
        }
    };
}

/// A choice among the named values of `$type`.
macro_rules! named {
    ($label:literal, $type:ty, $of:ty, |$entry:ident| $place:expr) => {
        Parameter {
            label: $label,
            unit: "",
            kind: Kind::Choice(|_, _| <$type>::NAMES.iter().map(|(name, _)| (*name).to_owned()).collect()),
            read: |desc, target| {
                let mut copy = <$of>::of(desc, target)?.clone();
                let $entry = &mut copy;
                let now: $type = *$place?;
                <$type>::NAMES.iter().position(|(_, value)| *value == now).map(Value::Choice)
            },
            write: |desc, target, value| {
                let $entry = <$of>::of_mut(desc, target)?;
                let Value::Choice(index) = value else { return None };
                *$place? = <$type>::NAMES.get(index)?.1;
                Some(())
            },
        }
    };
}

pub(super) static FILM: &[Parameter] = &[
    integer!("width", "px", 1..=limits::MAX_SIDE as i64, Step::Factor(1.1), u32, FilmDesc, width),
    integer!("height", "px", 1..=limits::MAX_SIDE as i64, Step::Factor(1.1), u32, FilmDesc, height),
];

pub(super) static CAMERA: &[Parameter] = &[
    number!("position x", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.position.x)),
    number!("position y", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.position.y)),
    number!("position z", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.position.z)),
    number!("look_at x", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.look_at.x)),
    number!("look_at y", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.look_at.y)),
    number!("look_at z", "units", PLACE, Step::View, CameraDesc, |c| Some(&mut c.look_at.z)),
    number!("up x", "", PLACE, Step::Linear(0.1), CameraDesc, |c| Some(&mut c.up.x)),
    number!("up y", "", PLACE, Step::Linear(0.1), CameraDesc, |c| Some(&mut c.up.y)),
    number!("up z", "", PLACE, Step::Linear(0.1), CameraDesc, |c| Some(&mut c.up.z)),
    Parameter {
        label: "projection",
        unit: "",
        kind: Kind::Choice(|_, _| vec!["perspective".into(), "orthographic".into()]),
        read: |desc, target| {
            let orthographic = matches!(CameraDesc::of(desc, target)?.projection, Projection::Orthographic { .. });
            Some(Value::Choice(usize::from(orthographic)))
        },
        write: |desc, target, value| {
            let camera = CameraDesc::of_mut(desc, target)?;
            camera.projection = reprojected(camera, value)?;
            Some(())
        },
    },
    number!("fov", "°", FOV, Step::Linear(5.0), CameraDesc, |c| match &mut c.projection {
        Projection::Perspective { fov } => Some(fov),
        Projection::Orthographic { .. } => None,
    }),
    number!("view_height", "units", LENGTH, Step::Factor(1.1), CameraDesc, |c| match &mut c.projection {
        Projection::Perspective { .. } => None,
        Projection::Orthographic { view_height } => Some(view_height),
    }),
];

/// The other projection, showing as much at the distance of `look_at`.
fn reprojected(camera: &CameraDesc, value: Value) -> Option<Projection> {
    let distance = camera.position.distance(camera.look_at);
    Some(match (value, camera.projection) {
        (Value::Choice(0), Projection::Orthographic { view_height }) => {
            Projection::Perspective { fov: Interval::FOV.clamp(2.0 * (view_height / 2.0).atan2(distance).to_degrees()) }
        }
        (Value::Choice(1), Projection::Perspective { fov }) => Projection::Orthographic {
            view_height: if fov == limits::DEFAULT_FOV {
                default_view_height(distance)
            } else {
                Interval::LENGTH.clamp(2.0 * distance * (fov.to_radians() / 2.0).tan())
            },
        },
        (Value::Choice(0 | 1), same) => same,
        _ => return None,
    })
}

pub(super) static WORLD: &[Parameter] = &[
    field!("ambient", "", Kind::Color, Color, WorldDesc, |w| Some(&mut w.ambient)),
    Parameter {
        label: "background",
        unit: "",
        kind: Kind::Choice(|_, _| vec!["solid".into(), "gradient".into()]),
        read: |desc, target| {
            let gradient = matches!(WorldDesc::of(desc, target)?.background, Background::Gradient { .. });
            Some(Value::Choice(usize::from(gradient)))
        },
        write: |desc, target, value| {
            let world = WorldDesc::of_mut(desc, target)?;
            world.background = match (value, world.background) {
                (Value::Choice(0), Background::Gradient { top, .. }) => Background::Solid(top),
                (Value::Choice(1), Background::Solid(color)) => Background::Gradient { top: color, bottom: color },
                (Value::Choice(0 | 1), same) => same,
                _ => return None,
            };
            Some(())
        },
    },
    field!("background color", "", Kind::Color, Color, WorldDesc, |w| match &mut w.background {
        Background::Solid(color) => Some(color),
        Background::Gradient { .. } => None,
    }),
    field!("background top", "", Kind::Color, Color, WorldDesc, |w| match &mut w.background {
        Background::Gradient { top, .. } => Some(top),
        Background::Solid(_) => None,
    }),
    field!("background bottom", "", Kind::Color, Color, WorldDesc, |w| match &mut w.background {
        Background::Gradient { bottom, .. } => Some(bottom),
        Background::Solid(_) => None,
    }),
    number!("ior", "", IOR, Step::Linear(0.05), WorldDesc, |w| Some(&mut w.ior)),
];

pub(super) static RENDER: &[Parameter] = &[
    named!("shading", Shading, RenderDesc, |r| Some(&mut r.shading)),
    integer!("max_depth", "", 0..=limits::MAX_DEPTH as i64, Step::Linear(1.0), u32, RenderDesc, max_depth),
    integer!("samples", "per pixel", 1..=limits::MAX_SAMPLES as i64, Step::Factor(2.0), u32, RenderDesc, samples),
    Parameter {
        label: "until error",
        unit: "",
        kind: Kind::Toggle,
        read: |desc, target| Some(Value::Toggle(RenderDesc::of(desc, target)?.error.is_some())),
        write: |desc, target, value| {
            let render = RenderDesc::of_mut(desc, target)?;
            let Value::Toggle(on) = value else { return None };
            // On the way to an error `samples` is only a limit, and has another default.
            let usual = RenderDesc::default().samples;
            match (on, render.samples) {
                (true, samples) if samples == usual => render.samples = limits::ADAPTIVE_SAMPLES,
                (false, limits::ADAPTIVE_SAMPLES) => render.samples = usual,
                _ => {}
            }
            render.error = on.then_some(render.error.unwrap_or(limits::USUAL_ERROR));
            Some(())
        },
    },
    number!("error", "codes", ERROR, Step::Factor(1.25), RenderDesc, |r| r.error.as_mut()),
    named!("filter", Filter, RenderDesc, |r| Some(&mut r.filter)),
    named!("shadows", Shadows, RenderDesc, |r| Some(&mut r.shadows)),
    named!("numerics", Numerics, RenderDesc, |r| Some(&mut r.numerics)),
];

pub(super) static LIGHT: &[Parameter] = &[
    field!("name", "", Kind::Name, Text, LightDesc, |l| Some(&mut l.name)),
    field!("visible", "", Kind::Toggle, Toggle, LightDesc, |l| Some(&mut l.visible)),
    Parameter {
        label: "kind",
        unit: "",
        kind: Kind::Choice(|_, _| vec!["point".into(), "directional".into()]),
        read: |desc, target| {
            let directional = matches!(LightDesc::of(desc, target)?.kind, LightKind::Directional { .. });
            Some(Value::Choice(usize::from(directional)))
        },
        write: |desc, target, value| {
            let camera = desc.camera;
            let light = LightDesc::of_mut(desc, target)?;
            light.kind = redirected(&camera, light.kind, value)?;
            Some(())
        },
    },
    number!("position x", "units", PLACE, Step::View, LightDesc, |l| position(l).map(|p| &mut p.x)),
    number!("position y", "units", PLACE, Step::View, LightDesc, |l| position(l).map(|p| &mut p.y)),
    number!("position z", "units", PLACE, Step::View, LightDesc, |l| position(l).map(|p| &mut p.z)),
    number!("direction x", "", PLACE, Step::Linear(0.1), LightDesc, |l| direction(l).map(|d| &mut d.x)),
    number!("direction y", "", PLACE, Step::Linear(0.1), LightDesc, |l| direction(l).map(|d| &mut d.y)),
    number!("direction z", "", PLACE, Step::Linear(0.1), LightDesc, |l| direction(l).map(|d| &mut d.z)),
    named!("falloff", Falloff, LightDesc, |l| match &mut l.kind {
        LightKind::Point { falloff, .. } => Some(falloff),
        LightKind::Directional { .. } => None,
    }),
    field!("color", "", Kind::Color, Color, LightDesc, |l| Some(&mut l.color)),
    number!("intensity", "", LIGHT, Step::Linear(0.1), LightDesc, |l| Some(&mut l.intensity)),
];

fn position(light: &mut LightDesc) -> Option<&mut DVec3> {
    match &mut light.kind {
        LightKind::Point { position, .. } => Some(position),
        LightKind::Directional { .. } => None,
    }
}

fn direction(light: &mut LightDesc) -> Option<&mut DVec3> {
    match &mut light.kind {
        LightKind::Point { .. } => None,
        LightKind::Directional { direction } => Some(direction),
    }
}

/// The other kind of light, lighting the middle of the view from the same side.
fn redirected(camera: &CameraDesc, kind: LightKind, value: Value) -> Option<LightKind> {
    let distance = camera.position.distance(camera.look_at);
    Some(match (value, kind) {
        (Value::Choice(0), LightKind::Directional { direction }) => LightKind::Point {
            position: camera.look_at - direction.normalize_or(DVec3::NEG_Y) * distance,
            falloff: Falloff::None,
        },
        (Value::Choice(1), LightKind::Point { position, .. }) => {
            LightKind::Directional { direction: (camera.look_at - position).normalize_or(DVec3::NEG_Y) }
        }
        (Value::Choice(0 | 1), same) => same,
        _ => return None,
    })
}

pub(super) static MATERIAL: &[Parameter] = &[
    Parameter {
        label: "name",
        unit: "",
        kind: Kind::Name,
        read: |desc, target| Some(Value::Text(MaterialDesc::of(desc, target)?.name.clone())),
        write: |desc, target, value| {
            let Value::Text(name) = value else { return None };
            let before = std::mem::replace(&mut MaterialDesc::of_mut(desc, target)?.name, name.clone());
            for object in desc.objects.iter_mut().filter(|object| object.material.as_ref() == Some(&before)) {
                object.material = Some(name.clone());
            }
            Some(())
        },
    },
    field!("color", "", Kind::Color, Color, MaterialDesc, |m| Some(&mut m.color)),
    number!("ambient", "k_a", COEFFICIENT, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.ambient)),
    number!("diffuse", "k_d", COEFFICIENT, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.diffuse)),
    number!("specular", "k_s", COEFFICIENT, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.specular)),
    number!("shininess", "s", SHININESS, Step::Factor(1.25), MaterialDesc, |m| Some(&mut m.shininess)),
    number!("reflect", "k_r", SHARE, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.reflect)),
    number!("transmit", "k_t", SHARE, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.transmit)),
    number!("ior", "", IOR, Step::Linear(0.05), MaterialDesc, |m| Some(&mut m.ior)),
    field!("fresnel", "", Kind::Toggle, Toggle, MaterialDesc, |m| Some(&mut m.fresnel)),
    integer!("priority", "", limits::PRIORITY, Step::Linear(1.0), i32, MaterialDesc, priority),
    Parameter {
        label: "texture",
        unit: "",
        kind: Kind::Choice(|_, _| vec!["none".into(), "checker".into(), "picture".into()]),
        read: |desc, target| {
            let texture = MaterialDesc::of(desc, target)?.texture.as_ref();
            Some(Value::Choice(match texture.map(|texture| &texture.source) {
                None => 0,
                Some(TextureSource::Checker { .. }) => 1,
                Some(TextureSource::Image { .. }) => 2,
            }))
        },
        write: |desc, target, value| {
            let material = MaterialDesc::of_mut(desc, target)?;
            let pictured = matches!(&material.texture, Some(t) if matches!(t.source, TextureSource::Image { .. }));
            match value {
                Value::Choice(0) => material.texture = None,
                Value::Choice(1) if material.texture.is_none() || pictured => {
                    let colors = [material.color, material.color * 0.25];
                    set_source(material, TextureSource::Checker { colors, size: 1.0 });
                }
                Value::Choice(1) => {}
                Value::Choice(2) if pictured => {}
                // A picture needs a file: see "picture".
                _ => return None,
            }
            Some(())
        },
    },
    Parameter {
        label: "picture",
        unit: "",
        kind: Kind::Path(FileKind::Picture),
        read: |desc, target| match &MaterialDesc::of(desc, target)?.texture {
            Some(TextureDesc { source: TextureSource::Image { file, .. }, .. }) => Some(Value::Path(file.clone())),
            _ => None,
        },
        write: |desc, target, value| {
            let material = MaterialDesc::of_mut(desc, target)?;
            let Value::Path(file) = value else { return None };
            let wrap = match &material.texture {
                Some(TextureDesc { source: TextureSource::Image { wrap, .. }, .. }) => *wrap,
                _ => Wrap::Repeat,
            };
            set_source(material, TextureSource::Image { file, wrap });
            Some(())
        },
    },
    named!("wrap", Wrap, MaterialDesc, |m| match source(m)? {
        TextureSource::Image { wrap, .. } => Some(wrap),
        TextureSource::Checker { .. } => None,
    }),
    field!("checker first", "", Kind::Color, Color, MaterialDesc, |m| squares(m).map(|[first, _]| first)),
    field!("checker second", "", Kind::Color, Color, MaterialDesc, |m| squares(m).map(|[_, second]| second)),
    number!("checker size", "uv", LENGTH, Step::Factor(1.25), MaterialDesc, |m| match source(m)? {
        TextureSource::Image { .. } => None,
        TextureSource::Checker { size, .. } => Some(size),
    }),
    number!("texture scale u", "", UV, Step::Linear(0.5), MaterialDesc, |m| texture(m).map(|t| &mut t.scale.x)),
    number!("texture scale v", "", UV, Step::Linear(0.5), MaterialDesc, |m| texture(m).map(|t| &mut t.scale.y)),
    number!("texture offset u", "", UV, Step::Linear(0.1), MaterialDesc, |m| texture(m).map(|t| &mut t.offset.x)),
    number!("texture offset v", "", UV, Step::Linear(0.1), MaterialDesc, |m| texture(m).map(|t| &mut t.offset.y)),
];

fn texture(material: &mut MaterialDesc) -> Option<&mut TextureDesc> {
    material.texture.as_mut()
}

fn source(material: &mut MaterialDesc) -> Option<&mut TextureSource> {
    texture(material).map(|texture| &mut texture.source)
}

fn squares(material: &mut MaterialDesc) -> Option<[&mut Rgb; 2]> {
    match source(material)? {
        TextureSource::Image { .. } => None,
        TextureSource::Checker { colors: [first, second], .. } => Some([first, second]),
    }
}

/// Another source, scaled and shifted as before.
fn set_source(material: &mut MaterialDesc, source: TextureSource) {
    let bare = || TextureDesc { source: source.clone(), scale: glam::DVec2::ONE, offset: glam::DVec2::ZERO };
    let before = material.texture.take().unwrap_or_else(bare);
    material.texture = Some(TextureDesc { source, ..before });
}

pub(super) static OBJECT: &[Parameter] = &[
    field!("name", "", Kind::Name, Text, ObjectDesc, |o| Some(&mut o.name)),
    field!("visible", "", Kind::Toggle, Toggle, ObjectDesc, |o| Some(&mut o.visible)),
    Parameter {
        label: "material",
        unit: "",
        kind: Kind::Choice(|desc, target| {
            let is_mesh = ObjectDesc::of(desc, target).is_some_and(|o| matches!(o.shape, ShapeDesc::Mesh { .. }));
            let none = if is_mesh { "(of the file)" } else { "(default)" };
            let names = desc.materials.iter().map(|material| material.name.clone());
            std::iter::once(none.to_owned()).chain(names).collect()
        }),
        read: |desc, target| {
            Some(Value::Choice(match &ObjectDesc::of(desc, target)?.material {
                None => 0,
                Some(name) => 1 + desc.materials.iter().position(|material| material.name == *name)?,
            }))
        },
        write: |desc, target, value| {
            let material = match value {
                Value::Choice(0) => None,
                Value::Choice(index) => Some(desc.materials.get(index - 1)?.name.clone()),
                _ => return None,
            };
            ObjectDesc::of_mut(desc, target)?.material = material;
            Some(())
        },
    },
    number!("translate x", "units", PLACE, Step::View, ObjectDesc, |o| Some(&mut o.translate.x)),
    number!("translate y", "units", PLACE, Step::View, ObjectDesc, |o| Some(&mut o.translate.y)),
    number!("translate z", "units", PLACE, Step::View, ObjectDesc, |o| Some(&mut o.translate.z)),
    number!("rotate x", "°", DEGREES, Step::Linear(5.0), ObjectDesc, |o| Some(&mut o.rotate.x)),
    number!("rotate y", "°", DEGREES, Step::Linear(5.0), ObjectDesc, |o| Some(&mut o.rotate.y)),
    number!("rotate z", "°", DEGREES, Step::Linear(5.0), ObjectDesc, |o| Some(&mut o.rotate.z)),
    number!("scale x", "", PLACE, Step::Factor(1.1), ObjectDesc, |o| Some(&mut o.scale.x)),
    number!("scale y", "", PLACE, Step::Factor(1.1), ObjectDesc, |o| Some(&mut o.scale.y)),
    number!("scale z", "", PLACE, Step::Factor(1.1), ObjectDesc, |o| Some(&mut o.scale.z)),
    number!("radius", "units", LENGTH, Step::Factor(1.1), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Sphere { radius } | ShapeDesc::Cylinder { radius, .. } | ShapeDesc::Cone { radius, .. } => {
            Some(radius)
        }
        _ => None,
    }),
    number!("height", "units", LENGTH, Step::Factor(1.1), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Cylinder { height, .. } | ShapeDesc::Cone { height, .. } => Some(height),
        _ => None,
    }),
    number!("size x", "units", LENGTH, Step::Factor(1.1), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Cuboid { size } => Some(&mut size.x),
        ShapeDesc::Quad { size } => Some(&mut size.x),
        _ => None,
    }),
    number!("size y", "units", LENGTH, Step::Factor(1.1), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Cuboid { size } => Some(&mut size.y),
        _ => None,
    }),
    number!("size z", "units", LENGTH, Step::Factor(1.1), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Cuboid { size } => Some(&mut size.z),
        ShapeDesc::Quad { size } => Some(&mut size.y),
        _ => None,
    }),
    field!("file", "", Kind::Path(FileKind::Model), Path, ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Mesh { file, .. } => Some(file),
        _ => None,
    }),
    number!("crease", "°", CREASE, Step::Linear(5.0), ObjectDesc, |o| match &mut o.shape {
        ShapeDesc::Mesh { crease, .. } => Some(crease),
        _ => None,
    }),
];
