//! Names of files in a scene: resolved, and looked for.

use super::Span;
use super::nearest::{nearest, quoted};
use super::report::{Report, Words};
use super::value::Value;
use crate::description::builtin;
use std::collections::HashMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Directory entries that are read to find the nearest name.
const ENTRIES: usize = 1000;

/// The directory that paths are relative to, and what has been found out about files there.
pub(super) struct Files<'a> {
    directory: &'a Path,
    checked: HashMap<PathBuf, Option<Rc<str>>>,
}

impl<'a> Files<'a> {
    /// For a scene in `file`.
    pub fn beside(file: &'a Path) -> Self {
        Self { directory: file.parent().unwrap_or(Path::new("")), checked: HashMap::new() }
    }

    /// The path that `value` means; a mistake unless it can be read.
    pub fn path(&mut self, report: &mut Report<'a>, value: Value<'a>) -> Option<PathBuf> {
        let written = value.text(report)?;
        // A scene of the user may use the pictures of the demo.
        let path = match builtin(Path::new(written)) {
            Some(_) => PathBuf::from(written),
            None => self.directory.join(written),
        };
        let problem = self.checked.entry(path.clone()).or_insert_with(|| problem_with(&path).map(Rc::from)).clone();
        match problem {
            None => Some(path),
            Some(problem) => {
                unreadable(report, value.span(), written, path, problem);
                None
            }
        }
    }
}

/// Why the file cannot be read, if it cannot. Pipes and devices count as unreadable: opening one may wait for ever.
fn problem_with(path: &Path) -> Option<String> {
    if builtin(path).is_some() {
        return None;
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Some("this is a directory".to_owned()),
        Ok(found) if !found.is_file() => Some("this is not a regular file".to_owned()),
        Ok(_) => File::open(path).err().map(|error| reason(&error)),
        Err(error) => Some(reason(&error)),
    }
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => "no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "reading it is not permitted".to_owned(),
        _ => error.to_string(),
    }
}

fn unreadable<'a>(report: &mut Report<'a>, span: Span, written: &'a str, path: PathBuf, problem: Rc<str>) {
    report.mistake(span, move || {
        let words = Words::new(format!("cannot read {}", quoted(written)), &*problem);
        if path.exists() { words } else { words.help(advice(written, &path)) }
    });
}

/// What to do about a file that does not exist.
fn advice(written: &str, path: &Path) -> String {
    if path.is_symlink() {
        return "it is a link, and what it leads to does not exist".to_owned();
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = fs::read_dir(parent) else {
        let parent = Path::new(written).parent().unwrap_or(Path::new(written));
        return format!("there is no directory {}", quoted(&parent.to_string_lossy()));
    };
    let names: Vec<String> =
        entries.take(ENTRIES).filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    let name = path.file_name().unwrap_or_default();
    let similar = names.iter().map(String::as_str).filter(|other| {
        let other = Path::new(other);
        other.extension() == Path::new(name).extension() || other.file_stem() == Path::new(name).file_stem()
    });
    match nearest(&name.to_string_lossy(), similar) {
        Some(other) => format!("did you mean {}?", quoted(&Path::new(written).with_file_name(other).to_string_lossy())),
        None if written.contains('\\') => "directories are divided by /".to_owned(),
        None => "paths are relative to the directory of the scene file".to_owned(),
    }
}
