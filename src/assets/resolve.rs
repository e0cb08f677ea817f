//! Finding the files that a model names: written on another system, in other case, with other slashes.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Finds files by the names that models give them; remembers what it found, for many materials share a picture.
pub(super) struct Resolver {
    found: HashMap<(String, PathBuf), Option<PathBuf>>,
    /// By directory: the real name of each entry by its name in lower case.
    listings: HashMap<PathBuf, HashMap<String, OsString>>,
    /// Beside the OBJ file.
    home: PathBuf,
}

impl Resolver {
    /// Looks beside `model`.
    pub fn beside(model: &Path) -> Self {
        Self { found: HashMap::new(), listings: HashMap::new(), home: directory(model) }
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
            exact.or_else(|| places.iter().find_map(|p| self.without_case(p, name)))
        });
        self.found.insert(key, found.clone());
        found
    }

    /// The file `name` below `place` with the case of every component as it is on the disk.
    fn without_case(&mut self, place: &Path, name: &Path) -> Option<PathBuf> {
        let mut path = place.to_owned();
        for component in name.components() {
            let Component::Normal(wanted) = component else {
                path.push(component);
                continue;
            };
            let real = self.listing(&path).get(&wanted.to_string_lossy().to_lowercase());
            // Exact names come first, and names that are not listed may yet be there.
            let exact = path.join(wanted);
            path = if exact.exists() { exact } else { path.join(real?) };
        }
        path.is_file().then_some(path)
    }

    fn listing(&mut self, directory: &Path) -> &HashMap<String, OsString> {
        self.listings.entry(directory.to_owned()).or_insert_with(|| {
            let listed = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
            let entries = fs::read_dir(listed).into_iter().flatten();
            let mut names: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.file_name())).collect();
            // Of names alike the first, because the order of a directory is the disk's own affair.
            names.sort_by(|a, b| b.cmp(a));
            names.into_iter().map(|name| (name.to_string_lossy().to_lowercase(), name)).collect()
        })
    }
}

fn directory(file: &Path) -> PathBuf {
    file.parent().map(PathBuf::from).unwrap_or_default()
}
