//! A part of an OBJ file: what the [`Cleaner`] finds, and the numbers that tobj reads.

use super::obj_clean::{Before, Cleaner, Found};
use super::obj_lines::Lines;
use super::{AssetError, guard};
use glam::{DVec3, Vec2, Vec3};
use std::path::Path;

/// What one part holds.
pub(super) struct Part {
    pub found: Found,
    /// Coordinates of each `v`, three by three.
    pub positions: Vec<f64>,
    /// Each `vt`.
    pub uvs: Vec<Vec2>,
    /// Each `vn` at unit length; 0 if it is of no use.
    pub normals: Vec<Vec3>,
}

impl Part {
    /// Reads a part of `file`.
    pub fn read(file: &Path, lines: Lines, before: Before) -> Result<Self, AssetError> {
        let mut cleaner = Cleaner::new(file, lines, before);
        // A list of its own for positions, texture coordinates and normals.
        let options = tobj::LoadOptions { single_index: false, ..tobj::LoadOptions::default() };
        let parsed = guard(|| tobj::load_obj_buf(&mut cleaner, &options, |_| Ok(Default::default())));
        let found = cleaner.into_found()?;
        let mesh = match parsed {
            Some(Ok((models, _))) => models.into_iter().next().map(|model| model.mesh).unwrap_or_default(),
            Some(Err(error)) => return Err(AssetError::new(file, None, format!("cannot be read as OBJ: {error}"))),
            None => return Err(AssetError::new(file, None, "cannot be read as OBJ")),
        };
        let [v, vt, vn] = found.vertices.map(|count| count as usize);
        // Without a `v` there is one that stands in, which nothing refers to.
        let mut positions = mesh.positions;
        positions.truncate(3 * v);
        if [positions.len(), mesh.texcoords.len(), mesh.normals.len()] != [3 * v, 2 * vt, 3 * vn] {
            return Err(AssetError::new(file, None, "cannot be read as OBJ: vertices are missing"));
        }
        let uvs = mesh.texcoords.as_chunks::<2>().0.iter().map(|&[u, v]| Vec2::new(u as f32, v as f32)).collect();
        let normals = mesh.normals.as_chunks::<3>().0.iter().map(|&n| unit(DVec3::from_array(n))).collect();
        Ok(Self { found, positions, uvs, normals })
    }
}

/// `n` at unit length whatever its size; 0 stays 0.
fn unit(n: DVec3) -> Vec3 {
    (n / n.abs().max_element()).normalize_or_zero().as_vec3()
}
