//! What can be advised.

use crate::description::{Numerics, ObjectDesc, SceneDesc, Shading, ShapeDesc, Target, printable};
use std::path::PathBuf;
use std::sync::Arc;

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
    /// `error`: samples are spent until it is reached, and no more.
    Error(f64),
    /// A light is made invisible.
    HideLight(usize),
    /// Objects are made invisible.
    HideObjects(Vec<usize>),
    /// A material loses its texture.
    RemoveTexture(usize),
    /// An object becomes this one.
    Replace(usize, Box<ObjectDesc>),
    /// An object's model becomes that of another file, which has to be written first.
    Coarsen(usize, Arc<CoarseModel>),
}

/// A model with fewer triangles, and where it will be.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseModel {
    /// Beside the model that it comes from.
    pub file: PathBuf,
    /// The text of an OBJ file.
    pub text: String,
}

impl Change {
    /// Makes the change. What is not there any more is left alone.
    pub fn apply(&self, desc: &mut SceneDesc) {
        match self {
            Self::Depth(depth) => desc.render.max_depth = *depth,
            Self::Shading(shading) => desc.render.shading = *shading,
            Self::Numerics(numerics) => desc.render.numerics = *numerics,
            Self::Samples(samples) => desc.render.samples = *samples,
            Self::Error(error) => desc.render.error = Some(*error),
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
            Self::Coarsen(index, model) => {
                if let Some(ShapeDesc::Mesh { file, .. }) = desc.objects.get_mut(*index).map(|object| &mut object.shape)
                {
                    file.clone_from(&model.file);
                }
            }
        }
    }

    /// The model that has to be written before the change is made.
    pub fn model(&self) -> Option<&Arc<CoarseModel>> {
        if let Self::Coarsen(_, model) = self { Some(model) } else { None }
    }

    /// What to do, in a few words for people, safe to print.
    pub fn text(&self, desc: &SceneDesc) -> String {
        match self {
            Self::Depth(depth) => format!("max_depth = {depth}"),
            Self::Shading(shading) => format!("shading = {}", shading.name()),
            Self::Numerics(numerics) => format!("numerics = {}", numerics.name()),
            Self::Samples(samples) => format!("samples = {samples}"),
            Self::Error(error) => format!("error = {error}"),
            Self::HideLight(index) => format!("hide {}", Target::Light(*index).label(desc)),
            Self::HideObjects(indices) => match indices[..] {
                [index] => format!("hide {}", Target::Object(index).label(desc)),
                _ => format!("hide {} objects", indices.len()),
            },
            Self::RemoveTexture(index) => format!("no texture on {}", Target::Material(*index).label(desc)),
            Self::Replace(index, object) => {
                format!("make {} a {}", Target::Object(*index).label(desc), super::solid::word(&object.shape))
            }
            Self::Coarsen(index, model) => {
                let name = model.file.file_name().unwrap_or_default().to_string_lossy();
                format!("write {} for {}", printable(&name), Target::Object(*index).label(desc))
            }
        }
    }
}
