//! Files that appear whole or not at all.

use crate::description::printable;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Whether a picture can be written to `file`: asked before a render, so that hours of work do not end in a wrong
/// path. Leaves nothing behind.
pub fn check_target(file: &Path) -> io::Result<()> {
    match Target::of(file)? {
        Target::Device => Ok(()),
        Target::File(file) => Part::create(&file).map(drop),
    }
    .map_err(|e| explain(file, &e))
}

/// Writes `bytes` to a temporary file beside `file` and renames it when they have reached the disk. On failure the
/// temporary file is removed and `file` is as it was.
pub fn write_whole(file: &Path, bytes: &[u8]) -> io::Result<()> {
    match Target::of(file)? {
        Target::Device => OpenOptions::new().write(true).open(file).and_then(|mut device| device.write_all(bytes)),
        Target::File(target) => Part::create(&target).and_then(|mut part| {
            part.file.write_all(bytes)?;
            part.file.sync_all()?;
            part.rename_to(&target)
        }),
    }
    .map_err(|e| explain(file, &e))
}

/// What a path to write to leads to.
enum Target {
    /// A regular file, or nothing yet. Links are followed, so that the file behind one is replaced, not the link.
    File(PathBuf),
    /// `/dev/null`, which must not be replaced by a file.
    Device,
}

const ADD_A_NAME: &str = "add a file name such as picture.png";

impl Target {
    fn of(file: &Path) -> io::Result<Self> {
        let refuse = |kind, why: &str| Err(io::Error::new(kind, format!("cannot write {}: {why}", shown(file))));
        if file.file_name().is_none() || file.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return refuse(ErrorKind::InvalidInput, &format!("this names no file; {ADD_A_NAME}"));
        }
        match fs::metadata(file) {
            Ok(found) if found.is_dir() => {
                refuse(ErrorKind::IsADirectory, &format!("this is a directory; {ADD_A_NAME}"))
            }
            Ok(found) if found.is_file() => Ok(Self::File(fs::canonicalize(file).map_err(|e| explain(file, &e))?)),
            Ok(found) if is_null(&found) => Ok(Self::Device),
            // A pipe could keep us waiting for ever, a terminal would show the bytes, a disk would be overwritten.
            Ok(_) => {
                let what = "this is a pipe, a terminal or another device";
                refuse(ErrorKind::InvalidInput, &format!("{what}; name a file such as picture.png, or /dev/null"))
            }
            Err(e) if e.kind() == ErrorKind::NotFound => {
                let target = behind_links(file);
                let directory = directory_of(&target);
                if directory.is_dir() {
                    return Ok(Self::File(target));
                }
                refuse(ErrorKind::NotFound, &format!("there is no directory {}; make it first", shown(directory)))
            }
            Err(e) => Err(explain(file, &e)),
        }
    }
}

/// Whether this is the device that forgets what is written to it.
#[cfg(unix)]
fn is_null(found: &Metadata) -> bool {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    found.file_type().is_char_device() && fs::metadata("/dev/null").is_ok_and(|null| null.rdev() == found.rdev())
}

#[cfg(not(unix))]
fn is_null(_found: &Metadata) -> bool {
    false
}

/// Where a link leads that leads to nothing yet; links in a circle are an error of the system before it comes to this.
fn behind_links(file: &Path) -> PathBuf {
    let mut path = file.to_path_buf();
    while let Ok(next) = fs::read_link(&path) {
        path = directory_of(&path).join(next);
    }
    path
}

/// A temporary file, removed when it is dropped before `rename_to`.
struct Part {
    path: PathBuf,
    file: File,
    renamed: bool,
}

impl Part {
    /// Creates an empty file of a new name beside `target`. The name is short, whatever the target's.
    fn create(target: &Path) -> io::Result<Self> {
        let directory = directory_of(target);
        for attempt in 0..1000 {
            let path = directory.join(format!(".glimt-{}-{attempt}.part", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { path, file, renamed: false }),
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::new(ErrorKind::AlreadyExists, "too many .part files lie beside it; remove them"))
    }

    fn rename_to(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if !self.renamed {
            // A failure here has nobody left to be told.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// The directory a file lies in.
fn directory_of(file: &Path) -> &Path {
    match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

fn explain(file: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("cannot write {}: {error}", shown(file)))
}

fn shown(path: &Path) -> String {
    printable(&path.to_string_lossy()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of its own for each test, removed at its end.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("glimt-atomic-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn names(&self) -> Vec<String> {
            let mut names: Vec<_> =
                fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let dir = Scratch::new("replace");
        let file = dir.0.join("a.png");
        write_whole(&file, b"first").unwrap();
        write_whole(&file, b"second").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"second");
        assert_eq!(dir.names(), ["a.png"]);
    }

    #[test]
    fn checking_a_target_leaves_nothing_and_keeps_what_is_there() {
        let dir = Scratch::new("check");
        let file = dir.0.join("a.png");
        check_target(&file).unwrap();
        assert!(dir.names().is_empty());
        fs::write(&file, b"old").unwrap();
        check_target(&file).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"old");
    }

    #[test]
    fn directories_and_missing_directories_are_refused_with_advice() {
        let dir = Scratch::new("refuse");
        for attempt in [check_target, |f: &Path| write_whole(f, b"x")] {
            let message = attempt(&dir.0).unwrap_err().to_string();
            assert!(message.contains("this is a directory"), "{message}");
            let message = attempt(&dir.0.join("missing/a.png")).unwrap_err().to_string();
            assert!(message.contains("missing; make it first"), "{message}");
            for no_file in ["..", "a.png/"] {
                let message = attempt(Path::new(no_file)).unwrap_err().to_string();
                assert!(message.contains("file name"), "{message}");
            }
        }
        assert!(dir.names().is_empty());
    }

    #[test]
    fn a_name_that_is_too_long_fails_without_a_trace() {
        let dir = Scratch::new("long");
        let message = write_whole(&dir.0.join("n".repeat(300)), b"x").unwrap_err().to_string();
        assert!(message.starts_with("cannot write "), "{message}");
        assert!(dir.names().is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn the_file_behind_a_link_is_replaced_and_a_device_is_written_to() {
        let dir = Scratch::new("link");
        let (file, link) = (dir.0.join("a.png"), dir.0.join("link.png"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        write_whole(Path::new("/dev/null"), b"x").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_yet_stays_a_link_and_its_target_is_made() {
        let dir = Scratch::new("dangling");
        fs::create_dir(dir.0.join("sub")).unwrap();
        let link = |from: &str, to: &str| std::os::unix::fs::symlink(to, dir.0.join(from)).unwrap();
        link("first.png", "sub/second.png");
        link("sub/second.png", "../a.png");
        link("astray.png", "missing/a.png");
        link("circle.png", "circle.png");
        let first = dir.0.join("first.png");
        check_target(&first).unwrap();
        assert!(!dir.0.join("a.png").exists());
        write_whole(&first, b"new").unwrap();
        assert!(fs::symlink_metadata(&first).unwrap().is_symlink());
        assert_eq!(fs::read(dir.0.join("a.png")).unwrap(), b"new");
        let message = check_target(&dir.0.join("astray.png")).unwrap_err().to_string();
        assert!(message.contains("missing; make it first"), "{message}");
        assert!(check_target(&dir.0.join("circle.png")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn sockets_and_devices_other_than_null_are_refused() {
        let dir = Scratch::new("devices");
        let socket = dir.0.join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for file in [&socket, Path::new("/dev/zero"), Path::new("/dev/tty")] {
            for attempt in [check_target, |f: &Path| write_whole(f, b"x")] {
                let message = attempt(file).unwrap_err().to_string();
                assert!(message.contains("name a file such as picture.png"), "{message}");
            }
        }
    }
}
