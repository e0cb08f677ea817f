//! Files on the disk: what is watched, and what a change of them does.

use super::{App, Tone};
use crate::description::{SceneDesc, ShapeDesc, TextureSource, builtin, printable};
use crate::tui::command::Command;
use crate::tui::event::Effect;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

impl App {
    /// Files that the scene is made of, to be watched, if they are others than those that were told last.
    pub fn begin_watch(&mut self) -> Option<Effect> {
        let files = self.files();
        if files == self.watched {
            return None;
        }
        self.watched.clone_from(&files);
        Some(Effect::Watch(files))
    }

    fn files(&self) -> BTreeSet<PathBuf> {
        let desc = self.editor.desc();
        let models = desc.objects.iter().filter_map(|object| match &object.shape {
            ShapeDesc::Mesh { file, .. } => Some(file.as_path()),
            _ => None,
        });
        let pictures = desc.materials.iter().filter_map(|material| match &material.texture.as_ref()?.source {
            TextureSource::Image { file, .. } => Some(file.as_path()),
            TextureSource::Checker { .. } => None,
        });
        let all = models.chain(pictures).chain(self.editor.file());
        all.filter(|file| builtin(file).is_none()).map(Path::to_owned).collect()
    }

    /// Files have changed: the scene's own is read again, and what it uses is compiled again.
    pub(super) fn files_changed(&mut self, files: &[PathBuf]) -> Vec<Effect> {
        let own = self.editor.file().map(Path::to_owned);
        let mut effects = Vec::new();
        for file in files {
            if Some(file) == own.as_ref() {
                effects.push(Effect::Reread(file.clone()));
            } else if self.files().contains(file) {
                self.tell(Tone::Plain, format!("{} has changed", printable(&file.to_string_lossy())));
                self.restart();
            }
        }
        effects
    }

    /// The scene's file was read again.
    pub(super) fn reread(&mut self, file: &Path, result: Result<(String, SceneDesc), Vec<String>>) {
        if self.editor.file() != Some(file) {
            return;
        }
        match result {
            // Nothing else stands there than what was read or written last.
            Ok((text, _)) if self.editor.has_text(&text) => self.broken_file = None,
            Ok((text, desc)) => {
                self.broken_file = None;
                let lost = self.editor.history().is_unsaved();
                self.editor.reload(text, desc);
                self.restart();
                let undo = self.keymap.key_of(Command::Undo);
                let note = if lost { format!("; {undo} brings your changes back") } else { String::new() };
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                self.tell(Tone::Good, format!("{} has changed: reloaded{note}", printable(&name)));
            }
            Err(mistakes) => self.broken_file = Some(mistakes),
        }
    }
}
