//! Looks whether files have changed on the disk.

use crate::assets::Fingerprints;
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

/// Time between two looks. A change is told of after the second look at it. Looking again and again works on every file
/// system, those of networks too, which announce nothing.
pub const INTERVAL: Duration = Duration::from_millis(500);

/// Watches the files that come through the channel, always those that came last, and tells which of them have changed.
/// Ends when the channel is closed or `tell` gives false: nobody listens any more.
pub fn watch(files: &Receiver<BTreeSet<PathBuf>>, interval: Duration, mut tell: impl FnMut(Vec<PathBuf>) -> bool) {
    let mut prints = Fingerprints::default();
    loop {
        match files.recv_timeout(interval) {
            Ok(files) => prints.watch(&files),
            Err(RecvTimeoutError::Timeout) => {
                let changed = prints.changed();
                if !changed.is_empty() && !tell(changed) {
                    return;
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crossbeam_channel::unbounded;
    use std::{fs, thread};

    #[test]
    fn a_file_that_is_written_anew_is_told_of_and_a_closed_channel_ends_the_watch() {
        let file = std::env::temp_dir().join(format!("glimt-watch-{}", std::process::id()));
        fs::write(&file, "before").unwrap();
        let (files, watched) = unbounded();
        let (told, changes) = unbounded();
        let watcher =
            thread::spawn(move || watch(&watched, Duration::from_millis(5), |changed| told.send(changed).is_ok()));
        files.send([file.clone()].into()).unwrap();
        // However late the watcher comes to look first: until it has seen another content, there is another.
        let mut content = 0;
        let change = loop {
            content += 1;
            fs::write(&file, "x".repeat(content)).unwrap();
            if let Ok(change) = changes.recv_timeout(Duration::from_millis(100)) {
                break change;
            }
            assert!(content < 600, "never told");
        };
        assert_eq!(change, std::slice::from_ref(&file));
        drop(files);
        watcher.join().unwrap();
        fs::remove_file(file).unwrap();
    }
}
