//! Models and pictures from files: the only place that reads them. Whatever a file holds, loading ends in a value, or
//! in an [`AssetError`] that names file, line and reason; never in a panic.

mod image;
mod obj;
mod report;

pub use self::image::{Image, load_image};
pub use obj::load_obj;
pub use report::ImportReport;

use crate::description::MaterialDesc;
use glam::{DVec3, Vec2, Vec3};
use std::fmt;
use std::path::PathBuf;

/// A triangle mesh as read from a file, in f32 about its own centre (numerics.md 31): `centre + position` is a point
/// of the file.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Centre of the model's box, object space.
    pub centre: DVec3,
    /// Relative to `centre`. Corners that share a place hold bit-identical positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normal of each position; empty if every face is flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each position, v upward; empty if the file has none.
    pub uvs: Vec<Vec2>,
    /// Indices of three positions, counter-clockwise from outside. No triangle has exact area 0.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` of each triangle; empty if `materials` has at most one.
    pub triangle_materials: Vec<u32>,
    /// Materials of the file in order of first use; empty if it names none that could be found.
    pub materials: Vec<MaterialDesc>,
    /// What was found, mended, dropped and missed.
    pub report: ImportReport,
}

/// Why a model or picture cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct AssetError {
    /// The file at fault.
    pub file: PathBuf,
    /// Its line, from 1, where there is one.
    pub line: Option<usize>,
    /// What is wrong and what to do.
    pub reason: String,
}

impl fmt::Display for AssetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use crate::description::printable;
        write!(f, "{}", printable(&self.file.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", printable(&self.reason))
    }
}

impl std::error::Error for AssetError {}
