//! Finding the files that a model names: written on another system, in other case, with other slashes.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Finds files by the names that models give them; remembers what it found, for many materials share a picture.
pub(super) struct Resolver {
    found: HashMap<(String, PathBuf), Option<PathBuf>>,
    /// Beside the OBJ file.
    home: PathBuf,
}

impl Resolver {
    /// Looks beside `model`.
    pub fn beside(model: &Path) -> Self {
        Self { found: HashMap::new(), home: directory(model) }
    }

    /// The file called `name` in `mentioned_in`: as it stands, beside that file, then beside the model, then at both
    /// places without regard to case, and at last its last component alone at both places.
    pub fn find(&mut self, name: &str, mentioned_in: &Path) -> Option<PathBuf> {
        let first = directory(mentioned_in);
        let key = (name.to_owned(), first.clone());
        if let Some(known) = self.found.get(&key) {
            return known.clone();
        }
        let places = [first, self.home.clone()];
        let slashed = PathBuf::from(name.replace('\\', "/"));
        let last = slashed.file_name().map(PathBuf::from);
        let found = std::iter::once(&slashed).chain(&last).find_map(|name| {
            let exact = places.iter().map(|p| p.join(name)).find(|p| p.is_file());
            exact.or_else(|| places.iter().find_map(|p| without_case(p, name)))
        });
        self.found.insert(key, found.clone());
        found
    }
}

fn directory(file: &Path) -> PathBuf {
    file.parent().map(PathBuf::from).unwrap_or_default()
}

/// The file `name` below `place` with the case of every component as it is on the disk.
fn without_case(place: &Path, name: &Path) -> Option<PathBuf> {
    let mut path = place.to_owned();
    for component in name.components() {
        let Component::Normal(wanted) = component else {
            path.push(component);
            continue;
        };
        let exact = path.join(wanted);
        if exact.exists() {
            path = exact;
            continue;
        }
        let wanted = wanted.to_string_lossy().to_lowercase();
        let listed = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
        let mut alike: Vec<_> = fs::read_dir(listed)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()))
            .filter(|entry| entry.to_string_lossy().to_lowercase() == wanted)
            .collect();
        // The order of a directory is the disk's own affair.
        alike.sort();
        path.push(alike.into_iter().next()?);
    }
    path.is_file().then_some(path)
}
