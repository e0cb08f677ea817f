//! Scene files and models to descriptions.

use super::Failure;
use super::model_scene::scene_of_model;
use crate::bvh::Isa;
use crate::description::{DEMO, FilmDesc, SceneDesc, builtin, parse, point_out, printable, says_where_to_end};
use crate::render::View;
use crate::scene::{CompileError, Scene, compile_for};
use crate::tui::FileText;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene as the command line names it.
pub struct Opened {
    pub desc: SceneDesc,
    /// The text that says so; `None` for a model.
    text: Option<String>,
    /// The file, or [`DEMO`].
    pub file: PathBuf,
    /// What it is compiled for.
    pub isa: Isa,
    /// What of it is compiled already.
    pub compiled: Option<Scene>,
    /// Time to read it, without that to build trees.
    pub load_time: Duration,
    /// Time to build trees.
    pub build_time: Duration,
}

/// Longest scene file, bytes: far above any that people or programs make, far below what fills memory.
const MAX_TEXT: u64 = 256 << 20;

impl Opened {
    /// Reads a scene, or makes one for a model; the demo scene if there is no file. `film`: the size that the flags
    /// ask for, which a model is framed for.
    pub fn new(file: Option<&Path>, film: Option<FilmDesc>, isa: Isa) -> Result<Self, Failure> {
        let begun = Instant::now();
        let file = file.unwrap_or(Path::new(DEMO));
        let is_model = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"));
        let (desc, text, compiled) = if is_model {
            let (desc, model) = scene_of_model(file, film.unwrap_or_default(), isa).map_err(Failure::asked)?;
            (desc, None, Some(model))
        } else {
            let text = read(file)?;
            let desc = parse(&text, file).map_err(|mistakes| match looks_like_obj(&text) {
                true => Failure::Asked(format!(
                    "cannot read {0}: it looks like an OBJ model; models are known by .obj at the end of the name, so \
                     rename it to {0}.obj",
                    file.display()
                )),
                false => Failure::Scene(mistakes),
            })?;
            (desc, Some(text), None)
        };
        let build_time = compiled.as_ref().map_or(Duration::ZERO, |model| model.summary.build_time);
        let load_time = begun.elapsed().saturating_sub(build_time);
        Ok(Self { desc, text, file: file.to_path_buf(), isa, compiled, load_time, build_time })
    }

    /// The scene that rays meet.
    pub fn compile(&self) -> Result<Scene, Failure> {
        compile_for(&self.desc, self.compiled.as_ref(), self.isa).map_err(|error| self.locate(error))
    }

    /// Shows where in the scene file it stands what cannot be compiled.
    pub fn locate(&self, error: CompileError) -> Failure {
        let (entry, keys) = error.place();
        let (message, label) = match &error {
            CompileError::Asset { error, .. } => (error.to_string(), "needed here"),
            _ => (error.to_string(), "here"),
        };
        let text = self.text.as_deref();
        match text.and_then(|text| point_out(text, &self.file, entry, keys, &message, label)) {
            Some(mistake) => Failure::Scene(vec![mistake]),
            None => Failure::asked(error),
        }
    }

    /// Whether the scene itself says where a render ends.
    pub fn says_where_to_end(&self) -> bool {
        self.text.as_deref().is_some_and(says_where_to_end)
    }

    /// What the interface saves into: the file as it was read; `None` for a model.
    pub fn source(&self) -> Option<FileText> {
        let text = self.text.clone()?;
        // Without the flags, which are not written into the file.
        let desc = parse(&text, &self.file).ok()?;
        Some(FileText { file: self.file.clone(), text, desc: Arc::new(desc) })
    }

    /// Where the file is, absolute; for the built-in scene the working directory.
    pub fn directory(&self) -> PathBuf {
        let parent = match builtin(&self.file) {
            Some(_) => Path::new(""),
            None => self.file.parent().unwrap_or(Path::new("")),
        };
        let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        parent.canonicalize().unwrap_or_else(|_| parent.to_owned())
    }

    /// The file's name without its ending.
    pub fn name(&self) -> &OsStr {
        self.file.file_stem().unwrap_or(OsStr::new("scene"))
    }

    /// `<scene>.png` in the working directory; of a view that does not show light `<scene>-<view>.png`.
    pub fn default_output(&self, view: View) -> PathBuf {
        let mut name = OsString::from(self.name());
        if view != View::Final {
            name.push(format!("-{}", view.name()));
        }
        name.push(".png");
        name.into()
    }
}

/// Whether the first lines that are no comments are those of an OBJ file.
fn looks_like_obj(text: &str) -> bool {
    const KEYWORDS: [&str; 9] = ["v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"];
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).take(3);
    let is_obj = |line: &str| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(|word| KEYWORDS.contains(&word)) && words.next().is_some_and(|w| !w.starts_with('='))
    };
    lines.next().is_some_and(is_obj) && lines.all(is_obj)
}

fn read(file: &Path) -> Result<String, Failure> {
    let name = printable(&file.to_string_lossy()).into_owned();
    let refuse = |why: String| Failure::Asked(format!("cannot read {name}: {why}"));
    let reason = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => "there is no such file".to_owned(),
        ErrorKind::IsADirectory => "this is a directory".to_owned(),
        _ => error.to_string(),
    };
    let mut bytes = Vec::new();
    match builtin(file) {
        Some(content) => bytes.extend(content),
        None => {
            let opened = File::open(file).map_err(|e| refuse(reason(e)))?;
            opened.take(MAX_TEXT + 1).read_to_end(&mut bytes).map_err(|e| refuse(reason(e)))?;
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
