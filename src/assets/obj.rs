//! Wavefront OBJ and MTL.

use super::{AssetError, Model};
use std::path::Path;

/// Reads a model. `crease`: see `description::ShapeDesc::Mesh`.
pub fn load_obj(_file: &Path, _crease: f64) -> Result<Model, AssetError> {
    todo!()
}
