//! A description back into the text of its file: what differs is changed, all else stays, byte by byte.

mod field;
mod list;
mod matching;
mod path;
mod write;

#[cfg(test)]
mod tests;

use super::{SceneDesc, ShapeDesc, printable};
use field::Described;
use path::Directories;
use std::collections::HashMap;
use std::fmt;
use std::path::Path;
use toml_edit::{DocumentMut, Item, Table};

/// What a scene was read from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The text of the file; empty for a scene that came from none.
    pub text: &'a str,
    /// What [`parse`](super::parse) made of it; the default scene for an empty text.
    pub desc: &'a SceneDesc,
    /// Where it stands.
    pub file: &'a Path,
}

/// Why a description cannot be written. Safe to print.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SaveError(String);

impl SaveError {
    fn new(reason: String) -> Self {
        Self(printable(&reason).into_owned())
    }
}

impl fmt::Display for SaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SaveError {}

/// Whether the text of a scene file says `samples` or `error`, and so where a render ends.
pub fn says_where_to_end(text: &str) -> bool {
    let document = text.strip_prefix('\u{feff}').unwrap_or(text).parse::<DocumentMut>();
    let render = document.as_ref().ok().and_then(|document| document.get("render"));
    render.is_some_and(|render| ["samples", "error"].iter().any(|key| render.get(key).is_some()))
}

/// The text of a scene file at `file` that says `edited`: the text of `source` with what differs changed, added or
/// removed (with the comments right above it), and every other line as it was. Nothing is read or written. Paths that
/// lie in other directories are made relative by names alone, where need be with the help of the working directory.
pub fn save(source: Source<'_>, edited: &SceneDesc, file: &Path) -> Result<String, SaveError> {
    let mut directories = Directories::of(source.file, file);
    let is_new = source.text.trim().is_empty();
    if source.desc == edited && !is_new && !directories.differ() {
        return Ok(source.text.to_owned());
    }
    let text = source.text.strip_prefix('\u{feff}').unwrap_or(source.text);
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| SaveError::new(error.message().to_owned()))?;

    note_spheres(&document, source.desc, &mut directories);
    let root = document.as_table_mut();
    section(root, "film", is_new, &source.desc.film, &edited.film, &directories)?;
    section(root, "camera", is_new, &source.desc.camera, &edited.camera, &directories)?;
    section(root, "world", false, &source.desc.world, &edited.world, &directories)?;
    section(root, "render", false, &source.desc.render, &edited.render, &directories)?;
    list::update(&mut document, "light", &source.desc.lights, &edited.lights, &directories)?;
    list::update(&mut document, "material", &source.desc.materials, &edited.materials, &directories)?;
    list::update(&mut document, "object", &source.desc.objects, &edited.objects, &directories)?;

    let mark = if text.len() < source.text.len() { "\u{feff}" } else { "" };
    let written = document.to_string();
    let written = written.trim_start_matches(if is_new { "\n" } else { "" });
    Ok(format!("{mark}{}", with_endings_of(text, written)))
}

/// A section that stands once. `whole`: even what equals the default is written.
fn section<T: Described>(
    root: &mut Table,
    key: &str,
    whole: bool,
    old: &T,
    new: &T,
    directories: &Directories,
) -> Result<(), SaveError> {
    if old == new && !whole {
        return Ok(());
    }
    let is_new = !root.contains_key(key);
    let item = root.entry(key).or_insert_with(|| Item::Table(Table::new()));
    // Of a new section only what differs from the defaults is told.
    let old = if whole && is_new { Vec::new() } else { old.fields() };
    write::update_item(item, &old, &new.fields(), directories)
}

fn note_spheres(document: &DocumentMut, desc: &SceneDesc, directories: &mut Directories) {
    for (object, table) in desc.objects.iter().zip(list::tables(document, "object")) {
        if let ShapeDesc::Spheres { data } = &object.shape
            && let Some(file) = table.get("file").and_then(Item::as_str)
        {
            directories.note_spheres(data.clone(), file);
        }
    }
}

/// The editor of TOML ends every line with a line feed. Lines of the original end as there, new ones like its first.
fn with_endings_of(original: &str, written: &str) -> String {
    if !original.contains('\r') {
        let cut = !original.is_empty() && !original.ends_with('\n') && written.ends_with('\n');
        return written[..written.len() - usize::from(cut)].to_owned();
    }
    let first = original.split_inclusive('\n').next().is_some_and(|line| line.ends_with("\r\n"));
    let endings: HashMap<&str, bool> = original
        .split_inclusive('\n')
        .filter_map(|line| line.strip_suffix('\n'))
        .map(|line| line.strip_suffix('\r').map_or((line, false), |line| (line, true)))
        .collect();
    let mut text = String::with_capacity(written.len() + written.len() / 32);
    for line in written.split_inclusive('\n') {
        match line.strip_suffix('\n') {
            Some(line) => {
                let line = line.strip_suffix('\r').unwrap_or(line);
                text.push_str(line);
                text.push_str(if endings.get(line).copied().unwrap_or(first) { "\r\n" } else { "\n" });
            }
            None => text.push_str(line),
        }
    }
    text
}
