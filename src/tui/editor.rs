//! What is edited: the description with its history, what is selected, and where the scene is saved.

use super::properties::{Properties, Section, sections};
use super::tree::Tree;
use crate::description::{CameraDesc, History, Refused, SceneDesc, Source, Target, builtin, files_named, save};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The state of editing.
#[derive(Debug)]
pub struct Editor {
    history: History,
    /// As it was at the start: what the camera is reset to.
    original: Arc<SceneDesc>,
    /// The file that the scene was read from, and its text; `None` for a model.
    source: Option<FileText>,
    /// What its text names, itself first.
    named: Vec<PathBuf>,
    /// Selection.
    pub tree: Tree,
    /// Rows of the selection.
    pub properties: Properties,
    /// Cameras kept under 1 to 9.
    pub views: [Option<CameraDesc>; 9],
    /// sRGB codes that were chosen last, the newest first.
    pub recent: Vec<[u8; 3]>,
    gesture: Gesture,
}

/// A scene file as it was read or written.
#[derive(Clone, Debug)]
pub struct FileText {
    /// Where it is.
    pub file: PathBuf,
    /// What stands in it.
    pub text: String,
    /// What that says.
    pub desc: Arc<SceneDesc>,
}

/// Edits that belong together: one key held.
#[derive(Debug, Default)]
struct Gesture {
    number: u64,
    label: String,
    last: Option<Instant>,
}

/// A key that comes again within this time is still held, or as good as.
const HELD: Duration = Duration::from_millis(600);
/// Colours that are remembered.
const RECENT: usize = 12;

impl Editor {
    /// Begins with a description; `source`: what it was read from, if it is a scene file.
    pub fn new(desc: SceneDesc) -> Self {
        let desc = Arc::new(desc);
        Self {
            original: desc.clone(),
            history: History::new(desc),
            source: None,
            named: Vec::new(),
            tree: Tree::default(),
            properties: Properties::default(),
            views: [None; 9],
            recent: Vec::new(),
            gesture: Gesture::default(),
        }
    }

    /// The scene came from this file.
    pub fn set_source(&mut self, source: FileText) {
        self.source = Some(source);
        self.name_files();
    }

    /// What is there now.
    pub fn desc(&self) -> &Arc<SceneDesc> {
        self.history.now()
    }

    /// As it was at the start.
    pub fn original(&self) -> &SceneDesc {
        &self.original
    }

    /// Undo, redo, unsaved.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// What is selected.
    pub fn selected(&self) -> Vec<Target> {
        self.tree.selected()
    }

    /// Rows of what is selected.
    pub fn sections(&self) -> Vec<Section> {
        sections(self.desc(), &self.selected())
    }

    /// Makes a change as one step of undo. `gesture`: changes of one gesture and label are one step. Returns what the
    /// change did and whether anything is different.
    pub fn edit<T>(
        &mut self,
        label: &str,
        gesture: Option<u64>,
        change: impl FnOnce(&mut SceneDesc) -> Result<T, Refused>,
    ) -> Result<(T, bool), Refused> {
        let mut edited = (**self.desc()).clone();
        let result = change(&mut edited)?;
        let changed = self.history.record(edited, label, gesture);
        self.tree.keep_existing(self.history.now());
        Ok((result, changed))
    }

    /// Number of a gesture of its own.
    pub fn new_gesture(&mut self) -> u64 {
        self.gesture = Gesture { number: self.gesture.number + 1, ..Gesture::default() };
        self.gesture.number
    }

    /// Number of the gesture that an edit of this label belongs to now: of a held key all have the same.
    pub fn held_gesture(&mut self, label: &str, now: Instant) -> u64 {
        let goes_on = self.gesture.label == label
            && self.gesture.last.is_some_and(|last| now.saturating_duration_since(last) < HELD);
        let number = if goes_on { self.gesture.number } else { self.gesture.number + 1 };
        self.gesture = Gesture { number, label: label.to_owned(), last: Some(now) };
        number
    }

    /// Takes back the last step; what it was.
    pub fn undo(&mut self) -> Option<String> {
        self.gesture = Gesture { number: self.gesture.number + 1, ..Gesture::default() };
        let label = self.history.undo().map(str::to_owned);
        self.tree.keep_existing(self.history.now());
        label
    }

    /// Does it again; what it was.
    pub fn redo(&mut self) -> Option<String> {
        self.gesture = Gesture { number: self.gesture.number + 1, ..Gesture::default() };
        let label = self.history.redo().map(str::to_owned);
        self.tree.keep_existing(self.history.now());
        label
    }

    /// Remembers a colour.
    pub fn remember(&mut self, codes: [u8; 3]) {
        self.recent.retain(|known| *known != codes);
        self.recent.insert(0, codes);
        self.recent.truncate(RECENT);
    }

    /// The scene's file, if it has one that can be written.
    pub fn file(&self) -> Option<&Path> {
        let file = self.source.as_ref().map(|source| source.file.as_path())?;
        builtin(file).is_none().then_some(file)
    }

    /// Whether this is what the scene's file was read or written with last.
    pub fn is_from(&self, text: &str, desc: &SceneDesc) -> bool {
        self.source.as_ref().is_some_and(|source| source.text == text && *source.desc == *desc)
    }

    /// The scene's file and all that it names.
    pub fn files_named(&self) -> &[PathBuf] {
        &self.named
    }

    fn name_files(&mut self) {
        self.named = match (&self.source, self.file()) {
            (Some(source), Some(file)) => files_named(&source.text, file),
            _ => Vec::new(),
        };
    }

    /// The text of a file that says what is there now.
    pub fn text_for(&self, file: &Path) -> Result<String, String> {
        let Some(source) = &self.source else {
            let nothing = Source { text: "", desc: &SceneDesc::default(), file: Path::new("") };
            return save(nothing, self.desc(), file).map_err(|error| error.to_string());
        };
        let mut said = (**self.desc()).clone();
        // What flags of the command line said is not for the file, unless it was changed here.
        if said.film == self.original.film {
            said.film = source.desc.film;
        }
        if said.render == self.original.render {
            said.render = source.desc.render;
        }
        let source = Source { text: &source.text, desc: &source.desc, file: &source.file };
        save(source, &said, file).map_err(|error| error.to_string())
    }

    /// The scene was written.
    pub fn saved(&mut self, written: FileText) {
        // An edit since then is not in the file.
        if Arc::ptr_eq(self.history.now(), &written.desc) {
            self.history.mark_saved();
        }
        self.source = Some(written);
        self.name_files();
    }

    /// The file says something else: that is what is there now, as a step that can be undone. What flags of the command
    /// line said stays, the camera stays where it was moved, and the selection stays by name.
    pub fn reload(&mut self, text: String, desc: SceneDesc) {
        let Some(source) = &mut self.source else { return };
        let before = self.history.now().clone();
        let mut shown = desc.clone();
        if before.film == self.original.film && self.original.film != source.desc.film {
            shown.film = before.film;
        }
        if before.render == self.original.render && self.original.render != source.desc.render {
            shown.render = before.render;
        }
        (source.text, source.desc) = (text, Arc::new(desc));
        self.history.reload(shown, "reload");
        let now = self.history.now().clone();
        self.tree.follow(&before, &now);
        self.name_files();
    }
}
