//! The thread that asks the disk: directories, pictures, models, writing scenes. The interface never waits for it.

use super::dialog::files::{Entry, Thumbnail, ends_in};
use super::editor::FileText;
use super::event::Event;
use super::session::spawn;
use crate::assets::{load_image, load_obj};
use crate::description::edit::Bounds;
use crate::description::{SceneDesc, parse, printable};
use crate::output::write_whole;
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

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
    for errand in queue {
        let answer = match errand {
            Errand::List(directory, endings) => {
                let entries = list(&directory, endings).map_err(|error| error.to_string());
                Event::Listed { directory, entries }
            }
            Errand::Look(file) => {
                // Only the last picture that was asked for is still looked at.
                let passed = queue.is_empty();
                if !passed {
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
