//! Where the entries of a scene stand in its text, for errors that show only after parsing.

use super::{CAMERA, FILM, LIGHT, MATERIAL, OBJECT, RENDER, WORLD, single, tables};
use crate::description::{Diagnostic, Target};
use std::path::Path;
use toml::de::DeTable;

/// A mistake in an entry of a `text` that [`parse`](super::parse) has accepted: it underlines the value of the first of
/// `keys` that the entry has, else its title. `None` if there is no such entry.
pub fn point_out(
    text: &str,
    file: &Path,
    entry: Target,
    keys: &[&str],
    message: &str,
    label: &str,
) -> Option<Diagnostic> {
    let text = super::without_mark(text);
    let (root, _) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    let section = match entry {
        Target::Film => single(&root, FILM),
        Target::Camera => single(&root, CAMERA),
        Target::World => single(&root, WORLD),
        Target::Render => single(&root, RENDER),
        Target::Light(index) => tables(&root, LIGHT).nth(index),
        Target::Material(index) => tables(&root, MATERIAL).nth(index),
        Target::Object(index) => tables(&root, OBJECT).nth(index),
    }?;
    let value = keys.iter().find_map(|key| section.value(key));
    let span = value.map_or_else(|| section.span.clone(), |value| value.span());
    Some(Diagnostic::new(file, text, span, message, label))
}
