//! Scene file to description.

use super::{Diagnostic, SceneDesc};
use crate::math::Rgb;
use std::path::Path;

/// Parses the text of a scene file. `file` is for messages, and paths in the text are relative to its directory.
/// All mistakes are reported, in the order of the text.
pub fn parse(_text: &str, _file: &Path) -> Result<SceneDesc, Vec<Diagnostic>> {
    todo!()
}

/// `"#rrggbb"`, `"#rgb"` or a CSS name (sRGB) to linear colour; `None` if it is neither.
pub fn parse_color(_text: &str) -> Option<Rgb> {
    todo!()
}
