//! Description to scene.

use super::Scene;
use crate::assets::AssetError;
use crate::description::SceneDesc;
use std::fmt;

/// Why a description cannot be compiled.
#[derive(Clone, Debug, PartialEq)]
pub struct CompileError {
    /// Name or number of the object or material at fault.
    pub subject: String,
    /// What is wrong and what to do.
    pub reason: String,
    /// The file behind it, if it is one.
    pub asset: Option<AssetError>,
}

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.subject, self.reason)?;
        self.asset.as_ref().map_or(Ok(()), |a| write!(f, "{a}"))
    }
}

impl std::error::Error for CompileError {}

/// Compiles a description, sharing with `previous` every mesh, texture and tree whose inputs are equal.
pub fn compile(_desc: &SceneDesc, _previous: Option<&Scene>) -> Result<Scene, CompileError> {
    todo!()
}
