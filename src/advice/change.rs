//! What can be advised.

use crate::description::{Numerics, ObjectDesc, SceneDesc, Shading, Target};

/// A change of a description that leaves every index as it is.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// `max_depth`
    Depth(u32),
    /// `shading`
    Shading(Shading),
    /// `numerics`
    Numerics(Numerics),
    /// `samples`
    Samples(u32),
    /// A light is made invisible.
    HideLight(usize),
    /// Objects are made invisible.
    HideObjects(Vec<usize>),
    /// A material loses its texture.
    RemoveTexture(usize),
    /// An object becomes this one.
    Replace(usize, Box<ObjectDesc>),
}

impl Change {
    /// Makes the change. What is not there any more is left alone.
    pub fn apply(&self, desc: &mut SceneDesc) {
        match self {
            Self::Depth(depth) => desc.render.max_depth = *depth,
            Self::Shading(shading) => desc.render.shading = *shading,
            Self::Numerics(numerics) => desc.render.numerics = *numerics,
            Self::Samples(samples) => desc.render.samples = *samples,
            Self::HideLight(index) => desc.lights.iter_mut().skip(*index).take(1).for_each(|l| l.visible = false),
            Self::HideObjects(indices) => {
                for index in indices {
                    desc.objects.iter_mut().skip(*index).take(1).for_each(|object| object.visible = false);
                }
            }
            Self::RemoveTexture(index) => {
                desc.materials.iter_mut().skip(*index).take(1).for_each(|material| material.texture = None);
            }
            Self::Replace(index, object) => {
                desc.objects.iter_mut().skip(*index).take(1).for_each(|old| *old = (**object).clone());
            }
        }
    }

    /// What to do, in a few words for people, safe to print.
    pub fn text(&self, desc: &SceneDesc) -> String {
        match self {
            Self::Depth(depth) => format!("max_depth = {depth}"),
            Self::Shading(shading) => format!("shading = {}", shading.name()),
            Self::Numerics(numerics) => format!("numerics = {}", numerics.name()),
            Self::Samples(samples) => format!("samples = {samples}"),
            Self::HideLight(index) => format!("hide {}", Target::Light(*index).label(desc)),
            Self::HideObjects(indices) => match indices[..] {
                [index] => format!("hide {}", Target::Object(index).label(desc)),
                _ => format!("hide {} objects", indices.len()),
            },
            Self::RemoveTexture(index) => format!("no texture on {}", Target::Material(*index).label(desc)),
            Self::Replace(index, object) => {
                format!("make {} a {}", Target::Object(*index).label(desc), super::solid::word(&object.shape))
            }
        }
    }
}
