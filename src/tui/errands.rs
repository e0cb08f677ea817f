//! The thread that asks the disk: directories, pictures, models, writing scenes. The interface never waits for it.

use super::dialog::files::{Entry, Thumbnail, ends_in};
use super::editor::FileText;
use super::event::Event;
use super::session::spawn;
use crate::advice::{Change, CoarseModel};
use crate::assets::{load_image, load_obj};
use crate::description::edit::Bounds;
use crate::description::{SceneDesc, parse, printable};
use crate::output::write_whole;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::collections::VecDeque;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is asked of the disk.
pub enum Errand {
    /// What a directory holds: directories, and files with these endings.
    List(PathBuf, &'static [&'static str]),
    /// What a picture looks like.
    Look(PathBuf),
    /// How large a model is.
    Measure(PathBuf),
    /// Write a scene.
    Write(FileText),
    /// Write the model that a change needs; told in a few words.
    WriteModel(Change, String),
    /// Read a scene again.
    Reread(PathBuf),
}

/// The way to the thread.
pub struct Errands(Sender<Errand>);

impl Errands {
    /// Starts the thread; answers come as events.
    pub fn start(events: &Sender<Event>) -> Result<Self, String> {
        let (errands, queue) = unbounded();
        let told = events.clone();
        spawn("files", events, move || run(&queue, &told))?;
        Ok(Self(errands))
    }

    /// Asks for something.
    pub fn send(&self, errand: Errand) {
        // If the thread has panicked, the interface knows already.
        let _ = self.0.send(errand);
    }
}

fn run(queue: &Receiver<Errand>, events: &Sender<Event>) {
    let mut waiting = VecDeque::new();
    while let Some(errand) = waiting.pop_front().or_else(|| queue.recv().ok()) {
        waiting.extend(queue.try_iter());
        let answer = match errand {
            Errand::List(directory, endings) => {
                let entries = list(&directory, endings).map_err(|error| error.to_string());
                Event::Listed { directory, entries }
            }
            Errand::Look(file) => {
                // Only the last picture that was asked for is still looked at.
                if waiting.iter().any(|errand| matches!(errand, Errand::Look(_))) {
                    continue;
                }
                let picture = load_image(&file).map_err(|error| error.reason);
                let picture = picture.map(|image| Thumbnail::new((image.width, image.height), &image.texels));
                Event::Looked { file, picture }
            }
            Errand::Measure(file) => {
                let bounds = measure(&file);
                Event::Measured { file, bounds }
            }
            Errand::Reread(file) => {
                let result = reread(&file);
                Event::Reread { file, result }
            }
            Errand::WriteModel(change, text) => {
                let write = |model: &Arc<CoarseModel>| write_whole(&model.file, model.text.as_bytes());
                let result = change.model().map_or(Ok(()), write).map_err(|error| error.to_string());
                Event::ModelWritten { change, text, result }
            }
            Errand::Write(written) => {
                let result = write_whole(&written.file, written.text.as_bytes()).map_err(|error| error.to_string());
                Event::SceneWritten { written, result }
            }
        };
        if events.send(answer).is_err() {
            return;
        }
    }
}

fn list(directory: &Path, endings: &[&str]) -> io::Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let entry = entry?;
        let name = entry.file_name();
        // Links are followed: what they lead to can be opened.
        let Ok(data) = std::fs::metadata(entry.path()) else { continue };
        let hidden = name.to_string_lossy().starts_with('.');
        if !hidden && (data.is_dir() || (data.is_file() && ends_in(Path::new(&name), endings))) {
            entries.push(Entry { is_file: data.is_file(), name });
        }
    }
    Ok(entries)
}

fn measure(file: &Path) -> Result<Bounds, String> {
    let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let model = load_obj(file, 0.0, threads).map_err(|error| error.to_string())?;
    let corners = model.positions.iter().map(|p| model.centre + p.as_dvec3());
    let bounds = corners.fold(None, |bounds: Option<Bounds>, p| {
        let Bounds { lower, upper } = bounds.unwrap_or(Bounds { lower: p, upper: p });
        Some(Bounds { lower: lower.min(p), upper: upper.max(p) })
    });
    bounds.ok_or_else(|| format!("{} holds no triangles", file.display()))
}

/// What a scene file says; else lines that tell its mistakes.
fn reread(file: &Path) -> Result<(String, SceneDesc), Vec<String>> {
    let lines = |text: String| text.lines().map(|line| printable(line).into_owned()).collect::<Vec<_>>();
    let text = std::fs::read_to_string(file).map_err(|error| lines(format!("cannot be read: {error}")))?;
    let desc = parse(&text, file).map_err(|mistakes| {
        let all: Vec<_> = mistakes.iter().map(|mistake| mistake.render(false)).collect();
        lines(all.join("\n"))
    })?;
    Ok((text, desc))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn directories_are_listed_with_what_can_be_opened_and_scenes_are_read_with_their_mistakes() {
        let directory = std::env::temp_dir().join(format!("glimt-errands-{}", std::process::id()));
        fs::create_dir_all(directory.join("sub")).unwrap();
        for name in ["a.PNG", "b.obj", "c.txt", ".hidden.png"] {
            fs::write(directory.join(name), "").unwrap();
        }
        let mut found = list(&directory, &["png"]).unwrap();
        found.sort();
        let entry = |is_file, name: &str| Entry { is_file, name: name.into() };
        assert_eq!(found, [entry(false, "sub"), entry(true, "a.PNG")]);
        assert!(list(&directory.join("none"), &["png"]).is_err());

        let file = directory.join("scene.toml");
        fs::write(&file, "[[object]]\nshape = \"sphere\"\nradus = 1 # \u{1b}[2J\n").unwrap();
        let mistakes = reread(&file).unwrap_err();
        assert!(mistakes.iter().any(|line| line.contains("radus")), "{mistakes:?}");
        assert!(mistakes.iter().all(|line| !line.contains(char::is_control)), "{mistakes:?}");
        fs::write(&file, "[[object]]\nshape = \"sphere\"\n").unwrap();
        assert_eq!(reread(&file).unwrap().1.objects.len(), 1);
        fs::write(directory.join("two.obj"), "v 1 2 3\nv 4 2 3\nv 1 6 3\nf 1 2 3\n").unwrap();
        let bounds = measure(&directory.join("two.obj")).unwrap();
        assert!(bounds.lower.abs_diff_eq(glam::DVec3::new(1.0, 2.0, 3.0), 1e-5), "{bounds:?}");
        assert!(bounds.upper.abs_diff_eq(glam::DVec3::new(4.0, 6.0, 3.0), 1e-5), "{bounds:?}");
        assert!(measure(&directory.join("b.obj")).is_err());
        fs::remove_dir_all(directory).unwrap();
    }
}
