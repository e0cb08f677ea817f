//! What rays meet: indices, boxes and trees, compiled from a description.

mod compile;

pub use compile::{CompileError, compile};

use crate::assets::ImportReport;
use crate::description::RenderDesc;
use std::path::PathBuf;
use std::time::Duration;

/// A compiled scene.
pub struct Scene {
    /// Picture size in pixels.
    pub width: u32,
    /// Picture size in pixels.
    pub height: u32,
    /// How the picture is computed.
    pub render: RenderDesc,
    /// What compiling found and took.
    pub summary: Summary,
}

/// What a scene has, for `check`, `--json` and the interface.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// `[[object]]` entries.
    pub objects: usize,
    /// Analytic shapes that rays are tested against.
    pub primitives: usize,
    /// Triangles in all meshes, each mesh once.
    pub triangles: usize,
    /// Triangles with every instance counted.
    pub instanced_triangles: usize,
    /// Lights.
    pub lights: usize,
    /// Materials.
    pub materials: usize,
    /// Image textures.
    pub textures: usize,
    /// Import reports of models, by path.
    pub imports: Vec<(PathBuf, ImportReport)>,
    /// Things that are probably not meant, one sentence each.
    pub warnings: Vec<String>,
    /// Time to read models and pictures (zero for what was shared with the previous scene).
    pub load_time: Duration,
    /// Time to build trees.
    pub build_time: Duration,
}
