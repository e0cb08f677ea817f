//! Paths as a scene file writes them: relative to its own directory.

use super::super::builtin;
use super::SaveError;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Where a scene was read from, and where it will be.
pub struct Directories {
    old: PathBuf,
    new: PathBuf,
    /// What the text says of spheres that come from files.
    spheres: Vec<(Arc<[[f64; 4]]>, String)>,
}

impl Directories {
    /// Those of two scene files.
    pub fn of(old: &Path, new: &Path) -> Self {
        let directory = |file: &Path| file.parent().map(Path::to_owned).unwrap_or_default();
        Self { old: directory(old), new: directory(new), spheres: Vec::new() }
    }

    /// Notes that the text has spheres from a file.
    pub fn note_spheres(&mut self, data: Arc<[[f64; 4]]>, file: &str) {
        self.spheres.push((data, file.to_owned()));
    }

    /// Whether paths have to be written anew.
    pub fn differ(&self) -> bool {
        self.old != self.new
    }

    /// How the new scene names a file.
    pub fn written(&self, path: &Path) -> Result<String, SaveError> {
        if builtin(path).is_some() {
            return text(path);
        }
        // Two paths of one kind can be compared; else the one has to become absolute.
        let alike = path.is_absolute() == self.new.is_absolute();
        if alike && let Ok(inside) = path.strip_prefix(&self.new) {
            return text(inside);
        }
        let (path, from) = if alike {
            (path.to_owned(), self.new.clone())
        } else {
            let here = |path: &Path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.to_owned() };
            let absolute = |path: &Path| std::path::absolute(here(path)).unwrap_or_else(|_| path.to_owned());
            (absolute(path), absolute(&self.new))
        };
        // From a directory that is reached by `..` nothing leads back by names alone.
        let climbs = |path: &Path| path.components().any(|part| part == Component::ParentDir);
        if climbs(&from) {
            return text(&std::path::absolute(&path).unwrap_or(path));
        }
        let shared = path.components().zip(from.components()).take_while(|(a, b)| a == b).count();
        if path.is_absolute() && shared <= 1 {
            return text(&path);
        }
        let up = from.components().skip(shared).map(|_| Component::ParentDir);
        text(&up.chain(path.components().skip(shared)).collect::<PathBuf>())
    }

    /// The same for a file as the old scene names it.
    pub fn written_from_old(&self, file: &str) -> Result<String, SaveError> {
        self.written(&self.old.join(file))
    }

    /// The file that these spheres come from, if they come from one.
    pub fn file_of_spheres(&self, data: &Arc<[[f64; 4]]>) -> Result<Option<String>, SaveError> {
        let known = self.spheres.iter().find(|(known, _)| Arc::ptr_eq(known, data) || known == data);
        known.map(|(_, file)| self.written_from_old(file)).transpose()
    }
}

/// With slashes on every system.
fn text(path: &Path) -> Result<String, SaveError> {
    let Some(text) = path.to_str() else {
        return Err(SaveError::new(format!("the name of {} is not UTF-8 and cannot stand in a scene", path.display())));
    };
    Ok(if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() })
}
