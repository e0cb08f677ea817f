//! Pictures for textures.

use super::AssetError;
use std::path::Path;

/// A picture: 8-bit sRGB codes, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` texels, row by row.
    pub texels: Vec<[u8; 3]>,
}

/// Reads a picture in any supported format, within limits of memory.
pub fn load_image(_file: &Path) -> Result<Image, AssetError> {
    todo!()
}
