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
        if !std::mem::take(&mut self.watch_due) {
            return None;
        }
        let files = self.files();
        if files == self.watched {
            return None;
        }
        self.watched.clone_from(&files);
        Some(Effect::Watch(files))
    }

    /// Models, what belongs to them, and pictures.
    fn assets(&self) -> BTreeSet<PathBuf> {
        let desc = self.editor.desc();
        let models = desc.objects.iter().filter_map(|object| match &object.shape {
            ShapeDesc::Mesh { file, .. } => Some(file.clone()),
            _ => None,
        });
        let pictures = desc.materials.iter().filter_map(|material| match &material.texture.as_ref()?.source {
            TextureSource::Image { file, .. } => Some(file.clone()),
            TextureSource::Checker { .. } => None,
        });
        let compiled = self.scene.iter().flat_map(|scene| scene.files());
        models.chain(pictures).chain(compiled).filter(|file| builtin(file).is_none()).collect()
    }

    fn files(&self) -> BTreeSet<PathBuf> {
        let mut files = self.assets();
        files.extend(self.editor.files_named().iter().cloned());
        files
    }

    /// Files have changed: what the scene uses is compiled again, and its own file, with those that it is written in,
    /// is read again.
    pub(super) fn files_changed(&mut self, files: Vec<PathBuf>) -> Vec<Effect> {
        let (own, assets) = (self.editor.file().map(Path::to_owned), self.assets());
        let (used, written): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| assets.contains(file));
        if let Some(file) = used.first() {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            self.tell(Tone::Plain, format!("{} has changed", printable(&name)));
            self.changed.extend(used);
            self.restart();
        }
        match own {
            Some(own) if !written.is_empty() => vec![Effect::Reread(own)],
            _ => Vec::new(),
        }
    }

    /// The scene's file was read again.
    pub(super) fn reread(&mut self, file: &Path, result: Result<(String, SceneDesc), Vec<String>>) {
        if self.editor.file() != Some(file) {
            return;
        }
        match result {
            // Nothing else stands there than what was read or written last.
            Ok((text, desc)) if self.editor.is_from(&text, &desc) => self.broken_file = None,
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
