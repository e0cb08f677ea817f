//! Saving the scene.

use super::dialogs::name_of;
use super::{App, Tone};
use crate::description::printable;
use crate::tui::dialog::{Dialog, Prompt, Purpose};
use crate::tui::editor::FileText;
use crate::tui::event::{Effect, Exit};
use std::path::{Path, PathBuf};
use std::time::Instant;

impl App {
    /// Asks for the file to save the scene as.
    pub(super) fn ask_file(&mut self) {
        let file = match self.editor.file() {
            Some(file) => file.to_owned(),
            None => self.directory.join(format!("{}.toml", self.name)),
        };
        let text = file.to_string_lossy().into_owned();
        self.dialog = Some(Dialog::Prompt(Prompt::new(Purpose::SaveAs, "Save the scene as", &text)));
    }

    /// Writes the scene to its file, or asks for one.
    pub(super) fn save_scene(&mut self) -> Vec<Effect> {
        let Some(file) = self.editor.file().map(Path::to_owned) else {
            self.ask_file();
            return Vec::new();
        };
        self.write_scene(file).unwrap_or_else(|mistake| {
            self.leave_when_written = false;
            self.tell(Tone::Bad, mistake);
            Vec::new()
        })
    }

    pub(super) fn write_scene(&mut self, file: PathBuf) -> Result<Vec<Effect>, String> {
        let text = self.editor.text_for(&file)?;
        self.saves_running += 1;
        Ok(vec![Effect::WriteScene(FileText { file, text, desc: self.editor.desc().clone() })])
    }

    pub(super) fn scene_written(&mut self, written: FileText, result: Result<(), String>, now: Instant) {
        self.saves_running = self.saves_running.saturating_sub(1);
        let name = name_of(&written.file);
        match result {
            Ok(()) => {
                self.name = printable(&written.file.file_stem().unwrap_or_default().to_string_lossy()).into_owned();
                self.editor.saved(written);
                self.watch_due = true;
                self.broken_file = None;
                self.tell(Tone::Good, format!("saved {name}"));
                if std::mem::take(&mut self.leave_when_written) {
                    self.leave(Exit::Quit, now);
                }
            }
            Err(reason) => {
                self.leave_when_written = false;
                self.tell(Tone::Bad, format!("cannot save {name}: {}", printable(&reason)));
            }
        }
        self.saves_end();
    }
}
