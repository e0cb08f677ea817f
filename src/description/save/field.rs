//! The entries of a description as the keys and values of a scene file.

use super::super::parameter::default_view_height;
use super::super::{
    Background, CameraDesc, FilmDesc, LightDesc, LightKind, MaterialDesc, ObjectDesc, Projection, RenderDesc,
    ShapeDesc, TextureDesc, TextureSource, WorldDesc, Wrap, limits,
};
use crate::math::Rgb;
use std::path::PathBuf;
use std::sync::Arc;

/// A value of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    Number(f64),
    Integer(i64),
    Toggle(bool),
    /// A name or a choice.
    Text(String),
    Path(PathBuf),
    Color(Rgb),
    Colors([Rgb; 2]),
    Numbers(Vec<f64>),
    /// Written as one number where all are equal.
    Factors(Vec<f64>),
    Spheres(Arc<[[f64; 4]]>),
    Table(Fields),
}

/// Keys and values in the order of a new entry.
pub type Fields = Vec<KeyField>;

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyField {
    pub key: &'static str,
    pub field: Field,
    /// What the file means where it does not have the key; `None` where a new entry tells it anyway.
    pub default: Option<Field>,
}

/// What can be written as the keys of a table.
pub trait Described: PartialEq {
    /// All keys that apply, with those that have their default.
    fn fields(&self) -> Fields;

    /// For people; empty if it has none.
    fn name(&self) -> &str {
        ""
    }
}

fn told(key: &'static str, field: Field) -> KeyField {
    KeyField { key, field, default: None }
}

fn defaulted<T: PartialEq>(key: &'static str, value: T, default: T, field: impl Fn(T) -> Field) -> KeyField {
    KeyField { key, field: field(value), default: Some(field(default)) }
}

fn text(text: &str) -> Field {
    Field::Text(text.to_owned())
}

fn name_field(name: &str) -> Option<KeyField> {
    (!name.is_empty()).then(|| told("name", text(name)))
}

impl Described for FilmDesc {
    fn fields(&self) -> Fields {
        vec![told("width", Field::Integer(self.width.into())), told("height", Field::Integer(self.height.into()))]
    }
}

impl Described for CameraDesc {
    fn fields(&self) -> Fields {
        let up = CameraDesc::default().up;
        let mut fields = vec![
            told("position", Field::Numbers(self.position.to_array().into())),
            told("look_at", Field::Numbers(self.look_at.to_array().into())),
            defaulted("up", self.up, up, |v| Field::Numbers(v.to_array().into())),
        ];
        match self.projection {
            Projection::Perspective { fov } => {
                fields.push(defaulted("projection", "perspective", "perspective", text));
                fields.push(defaulted("fov", fov, limits::DEFAULT_FOV, Field::Number));
            }
            Projection::Orthographic { view_height } => {
                let usual = default_view_height(self.position.distance(self.look_at));
                fields.push(defaulted("projection", "orthographic", "perspective", text));
                fields.push(defaulted("view_height", view_height, usual, Field::Number));
            }
        }
        fields
    }
}

impl Described for WorldDesc {
    fn fields(&self) -> Fields {
        let default = WorldDesc::default();
        let background = |background| match background {
            Background::Solid(color) => Field::Color(color),
            Background::Gradient { top, bottom } => {
                Field::Table(vec![told("top", Field::Color(top)), told("bottom", Field::Color(bottom))])
            }
        };
        vec![
            defaulted("ambient", self.ambient, default.ambient, Field::Color),
            defaulted("background", self.background, default.background, background),
            defaulted("ior", self.ior, default.ior, Field::Number),
        ]
    }
}

impl Described for RenderDesc {
    fn fields(&self) -> Fields {
        let default = RenderDesc::default();
        let integer = |v: u32| Field::Integer(v.into());
        let samples = if self.error.is_some() { limits::ADAPTIVE_SAMPLES } else { default.samples };
        let mut fields = vec![
            defaulted("shading", self.shading.name(), default.shading.name(), text),
            defaulted("max_depth", self.max_depth, default.max_depth, integer),
            defaulted("samples", self.samples, samples, integer),
            defaulted("filter", self.filter.name(), default.filter.name(), text),
            defaulted("shadows", self.shadows.name(), default.shadows.name(), text),
            defaulted("numerics", self.numerics.name(), default.numerics.name(), text),
        ];
        fields.extend(self.error.map(|error| told("error", Field::Number(error))));
        fields
    }
}

impl Described for LightDesc {
    fn fields(&self) -> Fields {
        let default = LightDesc::default();
        let mut fields = Vec::from_iter(name_field(&self.name));
        match self.kind {
            LightKind::Point { position, falloff } => {
                fields.push(told("kind", text("point")));
                fields.push(told("position", Field::Numbers(position.to_array().into())));
                fields.push(defaulted("falloff", falloff.name(), "none", text));
            }
            LightKind::Directional { direction } => {
                fields.push(told("kind", text("directional")));
                fields.push(told("direction", Field::Numbers(direction.to_array().into())));
            }
        }
        fields.push(defaulted("color", self.color, default.color, Field::Color));
        fields.push(defaulted("intensity", self.intensity, default.intensity, Field::Number));
        fields.push(defaulted("visible", self.visible, true, Field::Toggle));
        fields
    }

    fn name(&self) -> &str {
        &self.name
    }
}

impl Described for MaterialDesc {
    fn fields(&self) -> Fields {
        let default = MaterialDesc::default();
        let number = |key, value, default| defaulted(key, value, default, Field::Number);
        let mut fields = Vec::from_iter(name_field(&self.name));
        fields.push(defaulted("color", self.color, default.color, Field::Color));
        fields.extend(self.texture.as_ref().map(|texture| told("texture", Field::Table(texture_fields(texture)))));
        fields.extend([
            number("ambient", self.ambient, default.ambient),
            number("diffuse", self.diffuse, default.diffuse),
            number("specular", self.specular, default.specular),
            number("shininess", self.shininess, default.shininess),
            number("reflect", self.reflect, default.reflect),
            number("transmit", self.transmit, default.transmit),
            number("ior", self.ior, default.ior),
            defaulted("fresnel", self.fresnel, default.fresnel, Field::Toggle),
            defaulted("priority", self.priority, default.priority, |v| Field::Integer(v.into())),
        ]);
        fields
    }

    fn name(&self) -> &str {
        &self.name
    }
}

fn texture_fields(texture: &TextureDesc) -> Fields {
    let mut fields = match &texture.source {
        TextureSource::Image { file, wrap } => {
            vec![told("file", Field::Path(file.clone())), defaulted("wrap", wrap.name(), Wrap::Repeat.name(), text)]
        }
        TextureSource::Checker { colors, size } => {
            vec![told("checker", Field::Colors(*colors)), defaulted("size", *size, 1.0, Field::Number)]
        }
    };
    fields.push(defaulted("scale", texture.scale, glam::DVec2::ONE, |v| Field::Factors(v.to_array().into())));
    fields.push(defaulted("offset", texture.offset, glam::DVec2::ZERO, |v| Field::Numbers(v.to_array().into())));
    fields
}

impl Described for ObjectDesc {
    fn fields(&self) -> Fields {
        let mut fields = Vec::from_iter(name_field(&self.name));
        let length = |key, value: f64| told(key, Field::Number(value));
        let (shape, own) = match &self.shape {
            ShapeDesc::Sphere { radius } => ("sphere", vec![length("radius", *radius)]),
            ShapeDesc::Cuboid { size } => ("cuboid", vec![told("size", Field::Numbers(size.to_array().into()))]),
            ShapeDesc::Cylinder { radius, height } => {
                ("cylinder", vec![length("radius", *radius), length("height", *height)])
            }
            ShapeDesc::Cone { radius, height } => ("cone", vec![length("radius", *radius), length("height", *height)]),
            ShapeDesc::Plane => ("plane", Vec::new()),
            ShapeDesc::Quad { size } => ("quad", vec![told("size", Field::Numbers(size.to_array().into()))]),
            ShapeDesc::Mesh { file, crease } => {
                let crease = defaulted("crease", *crease, limits::DEFAULT_CREASE, Field::Number);
                ("mesh", vec![told("file", Field::Path(file.clone())), crease])
            }
            ShapeDesc::Spheres { data } => ("spheres", vec![told("data", Field::Spheres(data.clone()))]),
        };
        fields.push(told("shape", text(shape)));
        fields.extend(own);
        fields.extend(self.material.as_ref().map(|name| told("material", text(name))));
        let [none, one] = [0.0, 1.0].map(glam::DVec3::splat);
        fields.extend([
            defaulted("translate", self.translate, none, |v| Field::Numbers(v.to_array().into())),
            defaulted("rotate", self.rotate, none, |v| Field::Numbers(v.to_array().into())),
            defaulted("scale", self.scale, one, |v| Field::Factors(v.to_array().into())),
            defaulted("visible", self.visible, true, Field::Toggle),
        ]);
        fields
    }

    fn name(&self) -> &str {
        &self.name
    }
}
