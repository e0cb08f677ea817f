//! What an edit speaks of, and why it may be refused.

use super::{CameraDesc, FilmDesc, LightDesc, MaterialDesc, ObjectDesc, RenderDesc, SceneDesc, WorldDesc, printable};
use std::fmt;

/// An entry of a description; those that may be many are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Target {
    /// `[film]`
    Film,
    /// `[camera]`
    Camera,
    /// `[world]`
    World,
    /// `[render]`
    Render,
    /// A `[[light]]`.
    Light(usize),
    /// A `[[material]]`.
    Material(usize),
    /// An `[[object]]`.
    Object(usize),
}

impl Target {
    /// Whether the description has it.
    pub fn exists(self, desc: &SceneDesc) -> bool {
        match self {
            Self::Film | Self::Camera | Self::World | Self::Render => true,
            Self::Light(index) => index < desc.lights.len(),
            Self::Material(index) => index < desc.materials.len(),
            Self::Object(index) => index < desc.objects.len(),
        }
    }

    /// What to call it, safe to print: its name, or `object 3`.
    pub fn label(self, desc: &SceneDesc) -> String {
        let (kind, index, name) = match self {
            Self::Film => return "film".into(),
            Self::Camera => return "camera".into(),
            Self::World => return "world".into(),
            Self::Render => return "render".into(),
            Self::Light(index) => ("light", index, desc.lights.get(index).map(|light| &light.name)),
            Self::Material(index) => ("material", index, desc.materials.get(index).map(|material| &material.name)),
            Self::Object(index) => ("object", index, desc.objects.get(index).map(|object| &object.name)),
        };
        match name {
            Some(name) if !name.is_empty() => printable(name).into_owned(),
            _ => format!("{kind} {}", index + 1),
        }
    }
}

/// Why an edit was not made, in one line for people: what is wrong and what to do. Safe to print.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(String);

impl Refused {
    pub(super) fn new(reason: impl AsRef<str>) -> Self {
        Self(printable(reason.as_ref()).into_owned())
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

/// A type of entry: how to find the one that a target means.
pub(super) trait Entry: Clone {
    fn of(desc: &SceneDesc, target: Target) -> Option<&Self>;
    fn of_mut(desc: &mut SceneDesc, target: Target) -> Option<&mut Self>;
}

macro_rules! entry {
    ($type:ty, $target:ident, $section:ident) => {
        impl Entry for $type {
            fn of(desc: &SceneDesc, target: Target) -> Option<&Self> {
                (target == Target::$target).then_some(&desc.$section)
            }

            fn of_mut(desc: &mut SceneDesc, target: Target) -> Option<&mut Self> {
                (target == Target::$target).then_some(&mut desc.$section)
            }
        }
    };
    ($type:ty, many $target:ident, $section:ident) => {
        impl Entry for $type {
            fn of(desc: &SceneDesc, target: Target) -> Option<&Self> {
                let Target::$target(index) = target else { return None };
                desc.$section.get(index)
            }

            fn of_mut(desc: &mut SceneDesc, target: Target) -> Option<&mut Self> {
                let Target::$target(index) = target else { return None };
                desc.$section.get_mut(index)
            }
        }
    };
}

entry!(FilmDesc, Film, film);
entry!(CameraDesc, Camera, camera);
entry!(WorldDesc, World, world);
entry!(RenderDesc, Render, render);
entry!(LightDesc, many Light, lights);
entry!(MaterialDesc, many Material, materials);
entry!(ObjectDesc, many Object, objects);
