//! Models and pictures from files: the only place that reads them. Whatever a file holds, loading ends in a value, or
//! in an [`AssetError`] that names file, line and reason; never in a panic.

mod fans;
mod fingerprint;
mod image;
mod intern;
mod mesh;
mod normals;
mod obj;
mod obj_clean;
mod obj_lines;
mod obj_mtl;
mod obj_outline;
mod obj_part;
mod report;
mod resolve;
mod triangulate;

pub use self::image::{Image, load_image, load_images};
pub use fingerprint::Fingerprints;
pub use obj::load_obj;
pub use report::ImportReport;

use crate::description::MaterialDesc;
use crate::workers;
use glam::{DVec3, Vec2, Vec3};
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A triangle mesh as read from a file, in f32 about its own centre (numerics.md 31): `centre + position` is a point
/// of the file.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Centre of the model's box, object space.
    pub centre: DVec3,
    /// Relative to `centre`. Corners that share a place hold bit-identical positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normal of each position, zero where the faces around have none (polygons whose area cancels out);
    /// empty if every face is flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of each position, v upward; empty if the file has none.
    pub uvs: Vec<Vec2>,
    /// Indices of three positions, counter-clockwise from outside. No triangle has exact area 0.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` of each triangle; empty if `materials` has at most one.
    pub triangle_materials: Vec<u32>,
    /// Materials of the file in order of first use; empty if it names none that could be found.
    pub materials: Vec<MaterialDesc>,
    /// The material libraries (MTL) that were read.
    pub libraries: Vec<PathBuf>,
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

impl AssetError {
    fn new(file: &Path, line: Option<usize>, reason: impl Into<String>) -> Self {
        Self { file: file.to_owned(), line, reason: reason.into() }
    }
}

/// Refuses what is no regular file (a pipe could keep us waiting for ever) or is larger than `limit` bytes.
fn check_file(file: &Path, limit: u64) -> Result<(), AssetError> {
    let refuse = |reason: String| Err(AssetError::new(file, None, reason));
    match fs::metadata(file) {
        Err(error) => refuse(format!("cannot be read: {error}")),
        Ok(data) if data.is_dir() => refuse("is a directory, not a file".to_owned()),
        Ok(data) if !data.is_file() => refuse("is not a regular file".to_owned()),
        Ok(data) if data.len() > limit => refuse(format!("is larger than {} MiB", limit >> 20)),
        Ok(_) => Ok(()),
    }
}

/// The bytes of a file of at most `limit` bytes.
fn read_file(file: &Path, limit: u64) -> Result<Vec<u8>, AssetError> {
    check_file(file, limit)?;
    let read = || {
        let opened = File::open(file)?;
        let mut bytes = Vec::with_capacity(opened.metadata()?.len().min(limit) as usize + 1);
        // It may have grown since.
        opened.take(limit).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|error: std::io::Error| AssetError::new(file, None, format!("cannot be read: {error}")))
}

/// [`read_file`] by many threads, each a piece: most of the time goes into getting memory.
fn read_file_on(threads: NonZeroUsize, file: &Path, limit: u64) -> Result<Vec<u8>, AssetError> {
    const PIECE: usize = 1 << 20;
    check_file(file, limit)?;
    let length = fs::metadata(file).map_or(0, |data| data.len().min(limit) as usize);
    let mut bytes = vec![0; length];
    let pieces = (0..).step_by(PIECE).zip(bytes.chunks_mut(PIECE)).collect();
    let read = workers::map(threads, pieces, |(start, piece): (u64, &mut [u8])| {
        let mut opened = File::open(file)?;
        opened.seek(SeekFrom::Start(start))?;
        opened.read_exact(piece)
    });
    // A file that changes meanwhile, or cannot be read: the simple way knows what to do.
    if read.iter().all(io::Result::is_ok) { Ok(bytes) } else { read_file(file, limit) }
}

/// Runs code of another crate; `None` if it panics. The last belt only: what is known to make it panic is kept from it.
fn guard<T>(run: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(run)).ok()
}
