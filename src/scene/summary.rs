//! What a scene has, for `check`, `--json` and the interface.

use crate::assets::ImportReport;
use crate::bvh::BvhStats;
use std::path::PathBuf;
use std::time::Duration;

/// What became of a model.
#[derive(Clone, Debug)]
pub struct Imported {
    /// Its path.
    pub file: PathBuf,
    /// What importing found.
    pub report: ImportReport,
    /// The tree over its triangles.
    pub tree: BvhStats,
}

/// Counts, reports and warnings of compiling a scene.
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
    /// Pictures.
    pub textures: usize,
    /// The tree over the objects.
    pub tree: BvhStats,
    /// Models, by path.
    pub imports: Vec<Imported>,
    /// Things that are probably not meant, and what models name that is missing or ignored, one sentence each.
    pub warnings: Vec<String>,
    /// Time to read models and pictures (zero for what was shared with the previous scene).
    pub load_time: Duration,
    /// Time to build trees.
    pub build_time: Duration,
}
