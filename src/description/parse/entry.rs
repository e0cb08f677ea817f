//! Where the entries of a scene stand in its text, for errors that show only after parsing.

use super::section::Section;
use super::{CAMERA, FILM, LIGHT, MATERIAL, OBJECT, RENDER, WORLD, single, tables};
use crate::description::{Diagnostic, Target, builtin};
use std::path::{Path, PathBuf};
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

/// Every file that a scene names, whether it exists or not, from a `text` that may be wrong: what to watch so as to
/// read the scene again. `file` is its own, and the first of them.
pub fn files_named(text: &str, file: &Path) -> Vec<PathBuf> {
    let (root, _) = DeTable::parse_recoverable(super::without_mark(text));
    let root = root.into_inner();
    let of_objects = tables(&root, OBJECT).filter_map(|section| section.value("file"));
    let textures: Vec<_> = tables(&root, MATERIAL).filter_map(|section| section.value("texture")).collect();
    let of_textures = textures
        .iter()
        .filter_map(|texture| Section::of("texture", texture.toml))
        .filter_map(|section| section.value("file"));
    let named = of_objects.chain(of_textures).filter_map(|value| value.toml.get_ref().as_str());
    let mut files = vec![file.to_owned()];
    for named in named.filter(|named| builtin(Path::new(named)).is_none()) {
        let path = file.parent().unwrap_or(Path::new("")).join(named);
        if builtin(&path).is_none() && !files.contains(&path) {
            files.push(path);
        }
    }
    files
}
