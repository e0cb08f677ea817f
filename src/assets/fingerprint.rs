//! Whether files on the disk are still what they were.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use xxhash_rust::xxh3::Xxh3Default;

/// What some files were when they were last looked at.
#[derive(Clone, Debug, Default)]
pub struct Fingerprints {
    files: BTreeMap<PathBuf, Known>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// The content that was last told of; `None` if there was no such file.
    content: Option<(Stamp, u64)>,
    /// Another stamp seen since, which may still be changing.
    unsettled: Option<Stamp>,
}

/// What the directory tells of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
}

impl Fingerprints {
    /// Looks at these files from now on and at no others. Those that were looked at already are compared with what they
    /// were then.
    pub fn watch(&mut self, files: &BTreeSet<PathBuf>) {
        self.files.retain(|file, _| files.contains(file));
        for file in files {
            if !self.files.contains_key(file) {
                let content = stamp(file).and_then(|stamp| Some((stamp, hash(file).ok()?)));
                self.files.insert(file.clone(), Known { content, unsettled: None });
            }
        }
    }

    /// Files whose content differs from what it was when last told of. One that is being written is told of when its
    /// length and time have stayed the same from one look to the next; one that is gone, when it is back: programs that
    /// save a file often remove it first. A look takes one call of the system for each file, and reads only what has
    /// another time or length.
    pub fn changed(&mut self) -> Vec<PathBuf> {
        let mut changed = Vec::new();
        for (file, known) in &mut self.files {
            let Some(now) = stamp(file) else {
                known.unsettled = None;
                continue;
            };
            if known.content.is_some_and(|(stamp, _)| stamp == now) {
                known.unsettled = None;
            } else if known.unsettled != Some(now) {
                known.unsettled = Some(now);
            } else if let Ok(hash) = hash(file) {
                if known.content.is_none_or(|(_, before)| before != hash) {
                    changed.push(file.clone());
                }
                *known = Known { content: Some((now, hash)), unsettled: None };
            }
        }
        changed
    }
}

/// `None` if there is no such file, or only something that is not to be read, such as a pipe.
fn stamp(file: &Path) -> Option<Stamp> {
    let data = fs::metadata(file).ok().filter(|data| data.is_file())?;
    Some(Stamp { modified: data.modified().ok(), length: data.len() })
}

fn hash(file: &Path) -> io::Result<u64> {
    let mut opened = File::open(file)?;
    let mut hasher = Xxh3Default::new();
    let mut bytes = vec![0; 1 << 16];
    loop {
        match opened.read(&mut bytes) {
            Ok(0) => return Ok(hasher.digest()),
            Ok(count) => hasher.update(&bytes[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn write(file: &Path, text: &str, second: u64) {
        fs::write(file, text).unwrap();
        set_time(file, second);
    }

    fn set_time(file: &Path, second: u64) {
        let time = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000 + second);
        File::options().append(true).open(file).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn only_content_that_changed_and_settled_is_told_of_and_only_once() {
        let directory = std::env::temp_dir().join(format!("glimt-prints-{}", std::process::id()));
        fs::create_dir_all(&directory).unwrap();
        let [a, b, later] = ["a", "b", "later"].map(|name| directory.join(name));
        write(&a, "one", 0);
        write(&b, "two", 0);
        let mut prints = Fingerprints::default();
        let files: BTreeSet<PathBuf> = [a.clone(), b.clone(), later.clone(), directory.clone()].into();
        prints.watch(&files);
        let none = Vec::<PathBuf>::new();
        assert_eq!(prints.changed(), none);

        write(&a, "another", 1);
        assert_eq!(prints.changed(), none, "it may still be written");
        write(&a, "another one", 2);
        assert_eq!(prints.changed(), none, "and was");
        assert_eq!(prints.changed(), std::slice::from_ref(&a));
        assert_eq!(prints.changed(), none);

        // Touched, or written as it was.
        set_time(&b, 3);
        assert_eq!((prints.changed(), prints.changed()), (none.clone(), none.clone()));
        // Of the same length.
        write(&b, "owt", 4);
        assert_eq!((prints.changed(), prints.changed()), (none.clone(), vec![b.clone()]));

        // Removed and put back: only if it is another.
        fs::remove_file(&a).unwrap();
        assert_eq!(prints.changed(), none);
        write(&a, "another one", 5);
        assert_eq!((prints.changed(), prints.changed()), (none.clone(), none.clone()));
        // A file that was missing.
        write(&later, "", 6);
        assert_eq!((prints.changed(), prints.changed()), (none.clone(), vec![later.clone()]));

        // What is known stays known when other files are added; what is looked at no more is forgotten.
        write(&a, "third", 7);
        prints.watch(&[a.clone(), directory.join("c")].into());
        write(&b, "unwatched", 8);
        assert_eq!((prints.changed(), prints.changed()), (none, vec![a]));
        fs::remove_dir_all(directory).unwrap();
    }
}
