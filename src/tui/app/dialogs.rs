//! Dialogs: opening them, and what their answers do.

use super::{App, Live, Tone};
use crate::advice::{Advice, Change};
use crate::description::edit::{Bounds, New, rename};
use crate::description::parameter::{Kind, Value, parameter};
use crate::description::{Refused, SceneDesc, Target, printable};
use crate::math::Rgb;
use crate::tui::command::Command;
use crate::tui::dialog::files::{Entry, Thumbnail};
use crate::tui::dialog::{
    About, Adviser, Ask, ColorDialog, Dialog, Files, MODELS, PICTURES, Prompt, Purpose, Question, TextureDialog, Wish,
};
use crate::tui::event::{Effect, Exit};
use crate::tui::field::Field;
use crate::tui::key::{Code, Key};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

impl App {
    /// A key while something is open that takes them all.
    pub(super) fn dialog_key(&mut self, key: Key, command: Option<Command>, now: Instant) -> Vec<Effect> {
        if command == Some(Command::Cancel) {
            self.close(true);
            return Vec::new();
        }
        if self.searching {
            self.search_key(key, command);
            return Vec::new();
        }
        if self.editor.properties.entry.is_some() {
            self.entry_key(key, command);
            return Vec::new();
        }
        let Some(mut dialog) = self.dialog.take() else { return Vec::new() };
        let mut effects = Vec::new();
        match &mut dialog {
            Dialog::Help(help) => {
                if help.command(command, self.size.1) {
                    let room = ratatui::layout::Rect::new(0, 0, self.size.0, self.size.1);
                    help.clamp(&self.keymap, room);
                    self.dialog = Some(dialog);
                }
                // Any other key closes it.
            }
            Dialog::Rays(rays) => {
                if rays.command(command, self.size.1) {
                    self.dialog = Some(dialog);
                }
                // Any other key closes it.
            }
            Dialog::Adviser(adviser) => {
                let (advice, text) = (adviser.key(command), adviser.desc.clone());
                self.dialog = Some(dialog);
                if let Some(advice) = advice {
                    return self.follow(&advice, &text);
                }
            }
            Dialog::Palette(palette) => match palette.key(key, command) {
                Some(chosen) => return self.command(chosen, now),
                None => self.dialog = Some(dialog),
            },
            Dialog::Add(menu) => match menu.key(key, command) {
                Some(addition) => return self.add_new(addition),
                None => self.dialog = Some(dialog),
            },
            Dialog::Prompt(prompt) if command == Some(Command::Accept) => {
                let (purpose, text) = (prompt.purpose, prompt.field.text());
                match self.answered(purpose, text.trim()) {
                    Ok(wanted) => effects = wanted,
                    Err(mistake) => {
                        prompt.mistake = Some(mistake);
                        self.dialog = Some(dialog);
                    }
                }
            }
            Dialog::Prompt(prompt) => {
                prompt.field.key(key);
                self.dialog = Some(dialog);
            }
            Dialog::Model(files) => {
                let wish = files.key(key, command);
                self.dialog = Some(dialog);
                match wish {
                    Some(Wish::List(directory)) => effects.push(Effect::List(directory, MODELS)),
                    Some(Wish::Take(file)) => {
                        self.dialog = None;
                        self.tell(Tone::Plain, format!("reading {}", name_of(&file)));
                        effects.push(Effect::Measure(file));
                    }
                    Some(Wish::Look(_)) | None => {}
                }
            }
            Dialog::Color(color, targets, label) => {
                if command == Some(Command::Accept) {
                    self.editor.remember(color.codes());
                    self.live = None;
                    return effects;
                }
                if color.key(key, command) {
                    let (value, targets, label) = (Value::Color(color.color()), targets.clone(), *label);
                    self.set_live(&targets, label, &value);
                }
                self.dialog = Some(dialog);
            }
            Dialog::Texture(texture, targets) => {
                let (ask, targets) = (texture.key(key, command), targets.clone());
                self.dialog = Some(dialog);
                effects = self.texture_asks(ask, &targets);
            }
            Dialog::Question(question) => {
                let Code::Char(c) = key.code else {
                    self.dialog = Some(dialog);
                    return effects;
                };
                if !question.answers.iter().any(|(key, _)| *key == c) {
                    self.dialog = Some(dialog);
                    return effects;
                }
                match (question.about, c) {
                    (About::Unsaved, 's') => {
                        self.leave_when_written = true;
                        return self.save_scene();
                    }
                    (About::Unsaved, _) => self.leave(Exit::Quit, now),
                    (About::StoreView, digit) => self.store_view(digit),
                }
            }
        }
        effects
    }

    /// Asks what the scene does not need.
    pub(super) fn ask_adviser(&mut self) -> Vec<Effect> {
        let Some(scene) = self.scene.clone() else {
            self.tell(Tone::Plain, "the scene is still being loaded".into());
            return Vec::new();
        };
        let adviser = Adviser::new(self.editor.desc().clone());
        let effect = Effect::Advise { desc: adviser.desc.clone(), scene, waits: adviser.waits() };
        self.dialog = Some(Dialog::Adviser(adviser));
        vec![effect]
    }

    /// The adviser has measured; it was about this description.
    pub(super) fn advised(&mut self, desc: &Arc<SceneDesc>, found: Result<Vec<Advice>, String>) {
        if let Some(Dialog::Adviser(adviser)) = &mut self.dialog
            && Arc::ptr_eq(&adviser.desc, desc)
        {
            adviser.answer(found);
        }
    }

    /// Does what was advised about a description: one step of undo. A model that it needs is written first.
    fn follow(&mut self, advice: &Advice, about: &SceneDesc) -> Vec<Effect> {
        let (change, text) = (advice.change.clone(), advice.change.text(about));
        if change.model().is_some() {
            return vec![Effect::WriteModel { change, text }];
        }
        self.make(&change, text);
        Vec::new()
    }

    fn make(&mut self, change: &Change, text: String) {
        let made = self.change(&format!("advice: {text}"), None, |desc| {
            change.apply(desc);
            Ok(())
        });
        if made.is_some() {
            self.tell(Tone::Good, text);
        }
    }

    /// The model that an advice needs is there, or why it is not.
    pub(super) fn model_written(&mut self, change: &Change, text: String, result: Result<(), String>) {
        match result {
            Ok(()) => self.make(change, text),
            Err(reason) => self.tell(Tone::Bad, format!("cannot {text}: {}", printable(&reason))),
        }
    }

    /// Closes what is open. `revert`: what it changed is as before.
    pub(super) fn close(&mut self, revert: bool) {
        self.leave_when_written = false;
        if self.searching {
            self.searching = false;
            self.editor.tree.cancel();
            return;
        }
        if self.editor.properties.entry.take().is_some() {
            return;
        }
        if let Some(live) = self.live.take()
            && revert
        {
            self.replace((*live.before).clone(), live.label, live.gesture);
        }
        self.dialog = None;
    }

    /// Takes pasted text where text is typed; elsewhere it must not act.
    pub(super) fn paste(&mut self, text: &str) -> Vec<Effect> {
        if self.searching {
            self.editor.tree.filter_mut().paste(text);
            let desc = self.editor.desc().clone();
            self.editor.tree.refilter(&desc);
            return Vec::new();
        }
        if let Some(field) = &mut self.editor.properties.entry {
            field.paste(text);
            return Vec::new();
        }
        match &mut self.dialog {
            Some(Dialog::Palette(palette)) => palette.paste(text),
            Some(Dialog::Prompt(prompt)) => prompt.field.paste(text),
            Some(Dialog::Model(files)) => drop(files.paste(text)),
            Some(Dialog::Texture(texture, _)) => {
                if let Some(Wish::Look(file)) = texture.files.paste(text) {
                    texture.looking_at(&file);
                    return vec![Effect::Look(file)];
                }
            }
            Some(Dialog::Color(color, targets, label)) => {
                let (taken, targets, label) = (color.paste(text), targets.clone(), *label);
                if !taken {
                    return Vec::new();
                }
                let value = Value::Color(color.color());
                self.set_live(&targets, label, &value);
            }
            _ => {}
        }
        Vec::new()
    }

    fn search_key(&mut self, key: Key, command: Option<Command>) {
        let desc = self.editor.desc().clone();
        match command {
            Some(Command::Accept) => {
                self.searching = false;
                self.editor.tree.end_search();
            }
            Some(Command::Step(by)) => self.editor.tree.step(&desc, by.into()),
            _ => {
                self.editor.tree.filter_mut().key(key);
                self.editor.tree.refilter(&desc);
            }
        }
    }

    /// A value of a property is typed.
    fn entry_key(&mut self, key: Key, command: Option<Command>) {
        let Some(field) = &mut self.editor.properties.entry else { return };
        if command != Some(Command::Accept) {
            field.key(key);
            return;
        }
        let text = field.text();
        let Some(property) = self.editor.properties.current(&self.editor.sections()) else { return };
        let label = format!("change {}", property.parameter.label);
        self.message = None;
        let done = self.change(&label, None, |desc| property.parameter.enter(desc, &property.targets, &text));
        if done.is_some() {
            self.editor.properties.entry = None;
        }
    }

    /// Enter on a property: a dialog for colours, the other value of a switch, a field for the rest.
    pub(super) fn enter_property(&mut self) {
        let Some(property) = self.editor.properties.current(&self.editor.sections()) else { return };
        let desc = self.editor.desc();
        let value = property.parameter.get(desc, &property.targets);
        match (&property.parameter.kind, value) {
            (Kind::Color, value) => {
                let color = if let Some(Value::Color(color)) = value { color } else { Rgb::WHITE };
                self.begin_live("change color");
                self.show_color(property.targets, property.parameter.label, color);
            }
            (Kind::Toggle, _) => {
                let label = format!("change {}", property.parameter.label);
                self.change(&label, None, |desc| property.parameter.nudge(desc, &property.targets, 1, false));
            }
            (_, value) => {
                let target = property.targets.first().copied().unwrap_or(Target::Film);
                let text = match &value {
                    Some(Value::Path(path)) => path.to_string_lossy().into_owned(),
                    Some(Value::Mixed) | None => String::new(),
                    Some(value) => property.parameter.show(desc, target, value),
                };
                self.editor.properties.entry = Some(Field::new(&text));
            }
        }
    }

    /// Colours of the selection: of materials, or of what has one itself.
    pub(super) fn open_color(&mut self) {
        let selected = self.editor.selected();
        self.begin_live("change color");
        let (targets, label) = match selected.first() {
            Some(Target::World) => (vec![Target::World], "background color"),
            Some(Target::Light(_)) => {
                let is_light = |target: &Target| matches!(target, Target::Light(_));
                (selected.into_iter().filter(is_light).collect(), "color")
            }
            _ => match self.materials_to_edit() {
                Some(materials) => (materials, "color"),
                None => return self.tell(Tone::Plain, "this has no colour".into()),
            },
        };
        let first = targets.first().and_then(|target| parameter(*target, label));
        match first.and_then(|parameter| parameter.get(self.editor.desc(), &targets[..1])) {
            Some(Value::Color(color)) => self.show_color(targets, label, color),
            _ => self.tell(Tone::Plain, "choose one of its colours in the properties".into()),
        }
    }

    fn show_color(&mut self, targets: Vec<Target>, label: &'static str, color: Rgb) {
        self.dialog = Some(Dialog::Color(ColorDialog::new(color, &self.editor.recent), targets, label));
    }

    /// What is changed from now on is one step of undo, until the dialog closes.
    fn begin_live(&mut self, label: &'static str) {
        let gesture = self.editor.new_gesture();
        self.live = Some(Live { gesture, label, before: self.editor.desc().clone() });
    }

    /// Makes a change as part of what the open dialog does.
    pub(super) fn change_live(&mut self, change: impl FnOnce(&mut SceneDesc) -> Result<(), Refused>) -> Option<()> {
        let live = self.live.as_ref()?;
        let (label, gesture) = (live.label, live.gesture);
        self.message = None;
        self.change(label, Some(gesture), change)
    }

    fn set_live(&mut self, targets: &[Target], label: &'static str, value: &Value) {
        if let Some(parameter) = targets.first().and_then(|target| parameter(*target, label)) {
            self.change_live(|desc| parameter.set(desc, targets, value));
        }
    }

    /// Textures of the materials of the selection.
    pub(super) fn open_texture(&mut self) -> Vec<Effect> {
        self.begin_live("change texture");
        let Some(materials) = self.materials_to_edit() else {
            self.tell(Tone::Plain, "this has no texture: select an object or a material".into());
            return Vec::new();
        };
        let now = parameter(Target::Material(0), "picture").and_then(|p| p.get(self.editor.desc(), &materials[..1]));
        let directory = match now {
            // Not where the program's own pictures are.
            Some(Value::Path(file)) if file.is_absolute() => file.parent().map(Path::to_owned),
            _ => None,
        };
        let directory = directory.unwrap_or_else(|| self.directory.clone());
        self.dialog = Some(Dialog::Texture(TextureDialog::new(&directory), materials));
        vec![Effect::List(directory, PICTURES)]
    }

    fn texture_asks(&mut self, ask: Option<Ask>, materials: &[Target]) -> Vec<Effect> {
        match ask {
            Some(Ask::Files(Wish::List(directory))) => return vec![Effect::List(directory, PICTURES)],
            Some(Ask::Files(Wish::Look(file))) => return vec![Effect::Look(file)],
            Some(Ask::Files(Wish::Take(file))) => self.set_live(materials, "picture", &Value::Path(file)),
            Some(Ask::Nudge(label, steps, fine)) => {
                if let Some(parameter) = parameter(Target::Material(0), label) {
                    self.change_live(|desc| parameter.nudge(desc, materials, steps, fine));
                }
            }
            Some(Ask::Keep) => {
                self.dialog = None;
                self.live = None;
            }
            None => {}
        }
        Vec::new()
    }

    pub(super) fn open_models(&mut self) -> Vec<Effect> {
        self.dialog = Some(Dialog::Model(Files::new(&self.directory)));
        vec![Effect::List(self.directory.clone(), MODELS)]
    }

    pub(super) fn listed(&mut self, directory: &Path, entries: Result<Vec<Entry>, String>) -> Vec<Effect> {
        match &mut self.dialog {
            Some(Dialog::Model(files)) => drop(files.listed(directory, entries)),
            Some(Dialog::Texture(texture, _)) => {
                if let Some(Wish::Look(file)) = texture.files.listed(directory, entries) {
                    texture.looking_at(&file);
                    return vec![Effect::Look(file)];
                }
            }
            _ => {}
        }
        Vec::new()
    }

    pub(super) fn looked(&mut self, file: &Path, picture: Result<Thumbnail, String>) {
        if let Some(Dialog::Texture(texture, _)) = &mut self.dialog {
            texture.looked(file, picture);
        }
    }

    pub(super) fn measured(&mut self, file: PathBuf, bounds: Result<Bounds, String>) {
        match bounds {
            Ok(bounds) => self.add_entry(New::Mesh { file, bounds }),
            Err(reason) => self.tell(Tone::Bad, printable(&reason).into_owned()),
        }
    }

    pub(super) fn ask_name(&mut self) {
        let (target, desc) = (self.editor.tree.cursor(), self.editor.desc());
        let name = match target {
            Target::Object(index) => desc.objects.get(index).map(|object| object.name.clone()),
            Target::Light(index) => desc.lights.get(index).map(|light| light.name.clone()),
            Target::Material(index) => desc.materials.get(index).map(|material| material.name.clone()),
            _ => None,
        };
        match name {
            Some(name) => self.dialog = Some(Dialog::Prompt(Prompt::new(Purpose::Rename, "Rename", &name))),
            None => self.tell(Tone::Plain, format!("the {} has no name", target.label(desc))),
        }
    }

    pub(super) fn ask_unsaved(&mut self) {
        self.dialog = Some(Dialog::Question(Question {
            title: "The scene has changes that are not saved".into(),
            answers: vec![('s', "save them and quit"), ('q', "quit without saving")],
            about: About::Unsaved,
        }));
    }

    pub(super) fn ask_view(&mut self) {
        let word =
            |i: usize| if self.editor.views[i].is_some() { "replace the view kept here" } else { "keep it here" };
        let answers = ('1'..='9').enumerate().map(|(i, digit)| (digit, word(i))).collect();
        self.dialog =
            Some(Dialog::Question(Question { title: "Keep this view".into(), answers, about: About::StoreView }));
    }

    fn store_view(&mut self, digit: char) {
        let index = digit.to_digit(10).and_then(|digit| (digit as usize).checked_sub(1));
        let camera = self.editor.desc().camera;
        if let Some(view) = index.and_then(|index| self.editor.views.get_mut(index)) {
            *view = Some(camera);
        }
        self.tell(Tone::Plain, format!("this is view {digit} now"));
    }

    /// The line of a prompt is typed.
    fn answered(&mut self, purpose: Purpose, text: &str) -> Result<Vec<Effect>, String> {
        match purpose {
            Purpose::Rename => {
                let target = self.editor.tree.cursor();
                let renamed = self.editor.edit("rename", None, |desc| rename(desc, target, text));
                renamed.map_err(|refused| refused.to_string())?;
                // A name is not seen in the picture: it goes on.
                Ok(Vec::new())
            }
            Purpose::SaveAs => {
                let file = PathBuf::from(text);
                if text.is_empty() {
                    return Err("type the name of a file that ends in .toml".into());
                }
                if !file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
                    return Err("the name of a scene ends in .toml".into());
                }
                self.write_scene(file)
            }
        }
    }
}

/// The name of a file without its directories, safe to print.
pub(super) fn name_of(file: &Path) -> String {
    printable(&file.file_name().unwrap_or_default().to_string_lossy()).into_owned()
}
