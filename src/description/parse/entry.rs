//! Where the entries of a scene stand in its text, for errors that show only after parsing.

use super::{CAMERA, MATERIAL, OBJECT, single, tables};
use crate::description::Diagnostic;
use std::path::Path;
use toml::de::DeTable;

/// An entry of a scene; those that may be many are counted from 0, as in the description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// `[camera]`
    Camera,
    /// A `[[material]]`.
    Material(usize),
    /// An `[[object]]`.
    Object(usize),
}

/// A mistake in an entry of a `text` that [`parse`](super::parse) has accepted: it underlines the value of the first of
/// `keys` that the entry has, else its title. `None` if there is no such entry.
pub fn point_out(
    text: &str,
    file: &Path,
    entry: Entry,
    keys: &[&str],
    message: &str,
    label: &str,
) -> Option<Diagnostic> {
    let text = super::without_mark(text);
    let (root, _) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    let section = match entry {
        Entry::Camera => single(&root, CAMERA),
        Entry::Material(index) => tables(&root, MATERIAL).nth(index),
        Entry::Object(index) => tables(&root, OBJECT).nth(index),
    }?;
    let value = keys.iter().find_map(|key| section.value(key));
    let span = value.map_or_else(|| section.span.clone(), |value| value.span());
    Some(Diagnostic::new(file, text, span, message, label))
}
