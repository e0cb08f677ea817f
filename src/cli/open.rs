//! Scene files and models to descriptions.

use super::Failure;
use super::model_scene::scene_of_model;
use crate::description::{DEMO, FilmDesc, SceneDesc, builtin, parse, printable};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A scene as the command line names it.
pub struct Opened {
    pub desc: SceneDesc,
    /// The file, or [`DEMO`].
    pub file: PathBuf,
    /// Time to read it.
    pub time: Duration,
}

/// Longest scene file, bytes: far above any that people or programs make, far below what fills memory.
const MAX_TEXT: u64 = 256 << 20;

impl Opened {
    /// Reads a scene, or makes one for a model; the demo scene if there is no file. `film`: the size that the flags
    /// ask for, which a model is framed for.
    pub fn new(file: Option<&Path>, film: Option<FilmDesc>) -> Result<Self, Failure> {
        let begun = Instant::now();
        let file = file.unwrap_or(Path::new(DEMO));
        let is_model = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"));
        let desc = if is_model {
            scene_of_model(file, film.unwrap_or_default()).map_err(|error| Failure::Asked(error.to_string()))?
        } else {
            parse(&read(file)?, file).map_err(Failure::Scene)?
        };
        Ok(Self { desc, file: file.to_path_buf(), time: begun.elapsed() })
    }

    /// The file's name without its ending.
    pub fn name(&self) -> &OsStr {
        self.file.file_stem().unwrap_or(OsStr::new("scene"))
    }

    /// `<scene>.png` in the working directory.
    pub fn default_output(&self) -> PathBuf {
        let mut name = OsString::from(self.name());
        name.push(".png");
        name.into()
    }
}

fn read(file: &Path) -> Result<String, Failure> {
    let name = printable(&file.to_string_lossy()).into_owned();
    let refuse = |why: String| Failure::Asked(format!("cannot read {name}: {why}"));
    let mut bytes = Vec::new();
    match builtin(file) {
        Some(content) => bytes.extend(content),
        None => {
            let opened = File::open(file).map_err(|e| refuse(e.to_string()))?;
            opened.take(MAX_TEXT + 1).read_to_end(&mut bytes).map_err(|e| refuse(e.to_string()))?;
        }
    }
    if bytes.len() as u64 > MAX_TEXT {
        return Err(refuse(format!("it is longer than {} MiB", MAX_TEXT >> 20)));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let line = 1 + e.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
        refuse(format!("line {line} is not UTF-8 text; glimt opens scenes (.toml) and models (.obj)"))
    })
}
