//! Keys to commands, and what commands do that change no scene.

use super::{Activity, App, Focus, Tone};
use crate::description::Target;
use crate::tui::command::{Command, Scope};
use crate::tui::dialog::{About, AddMenu, Dialog, Help, Palette};
use crate::tui::event::{Effect, Event, Exit};
use crate::tui::key::Key;
use crate::tui::transform::Progress as Step;
use std::time::Instant;

/// Part of the view that one key press shifts it by.
const SHIFT_PART: f64 = 0.2;
/// Rows of a page in a list.
const PAGE: isize = 10;

impl App {
    pub(super) fn key(&mut self, key: Key, now: Instant) -> Vec<Effect> {
        let scope = self.scope();
        let command = self.keymap.find(key, scope);
        let is_open = matches!(scope, Scope::Dialog | Scope::Transform | Scope::Pick);
        match command {
            Some(Command::Quit) if is_open => return self.quit_from(now),
            Some(command @ (Command::Redraw | Command::Suspend)) => return self.command(command, now),
            _ if scope == Scope::Dialog => return self.dialog_key(key, command, now),
            _ => {}
        }
        if let Some(transform) = &mut self.transform {
            let step = transform.key(key, command);
            self.transformed(step);
            return Vec::new();
        }
        if let Some(command) = command {
            return self.command(command, now);
        }
        let keys = self.keymap.key_of(Command::ToggleHelp);
        self.tell(Tone::Plain, format!("{key} does nothing here; {keys} lists the keys"));
        Vec::new()
    }

    /// Does what a key means.
    pub fn command(&mut self, command: Command, now: Instant) -> Vec<Effect> {
        (self.message, self.note) = (None, None);
        match command {
            Command::Quit => self.quit(now),
            Command::ToggleHelp => self.dialog = Some(Dialog::Help(Help::default())),
            Command::OpenPalette => self.dialog = Some(Dialog::Palette(Palette::default())),
            Command::Add => self.dialog = Some(Dialog::Add(AddMenu::default())),
            Command::Advise => return self.ask_adviser(),
            Command::TogglePause => match self.activity {
                Activity::Paused => return self.set_paused(false, now),
                Activity::Finished | Activity::Failed if !self.is_restarting() => {}
                _ => return self.set_paused(true, now),
            },
            Command::Restart => self.restart(),
            Command::SaveImage => return self.save(),
            Command::SaveScene => return self.save_scene(),
            Command::SaveSceneAs => self.ask_file(),
            Command::Suspend => return self.update(Event::StopAsked, now),
            Command::Redraw => return vec![Effect::Redraw],
            Command::Threads(more) => return self.set_threads(more),
            Command::Zoom(steps) => self.preview.zoom_by(2f64.powf(f64::from(steps) / 2.0)),
            Command::Fit => self.preview.fit(),
            Command::Shift(right, below) => {
                self.preview.shift(f64::from(right) * SHIFT_PART, f64::from(below) * SHIFT_PART);
            }
            Command::Focus(by) => self.move_focus(by),
            Command::TogglePanel => {
                self.parts.editor = !self.parts.editor;
                self.focus = Focus::Picture;
                self.lay_out();
            }
            Command::ToggleNumbers => {
                self.parts.numbers = !self.parts.numbers;
                self.lay_out();
            }
            Command::Filter => {
                self.show_editor();
                if self.layout.editor.is_some() {
                    self.focus = Focus::Tree;
                    self.searching = true;
                    self.editor.tree.filter_mut();
                }
            }
            Command::PickMode => self.begin_pick(),
            Command::Explain => self.explain(),
            Command::CycleView(by) => return self.show(self.shown.view().moved(by)),
            Command::ShowView(view) => return self.show(view),
            Command::ToggleChart => self.chart = Some(!self.shows_chart()),
            Command::Step(_)
            | Command::Page(_)
            | Command::Ends(_)
            | Command::Turn(_)
            | Command::TurnFar(_)
            | Command::StepFar(_)
            | Command::Extend(_)
            | Command::Mark
            | Command::Accept
            | Command::Cancel
            | Command::Reset => self.navigate(command, now),
            _ => return self.edit_command(command, now),
        }
        Vec::new()
    }

    /// Leaves though something is open, which ends; the question whether to leave, asked twice, is answered.
    fn quit_from(&mut self, now: Instant) -> Vec<Effect> {
        let asked = matches!(&self.dialog, Some(Dialog::Question(question)) if question.about == About::Unsaved);
        self.cursor = None;
        self.transformed(Step::Cancel);
        self.close(false);
        if asked {
            self.leave(Exit::Quit, now);
        } else {
            self.quit(now);
        }
        Vec::new()
    }

    fn quit(&mut self, now: Instant) {
        if self.editor.history().is_unsaved() && self.leaving.is_none() {
            self.ask_unsaved();
        } else {
            self.leave(Exit::Quit, now);
        }
    }

    fn set_threads(&mut self, more: i8) -> Vec<Effect> {
        /// More than any machine has processors.
        const MOST: usize = 1024;
        let threads = self.threads.saturating_add_signed(more.into()).clamp(1, MOST);
        if threads != self.threads {
            self.threads = threads;
            self.lay_out();
            self.restart();
        }
        let word = if threads == 1 { "thread" } else { "threads" };
        self.tell(Tone::Plain, format!("{threads} {word}"));
        vec![Effect::Threads(threads)]
    }

    /// Shows tree and properties, if there is room.
    pub(super) fn show_editor(&mut self) {
        if !self.parts.editor {
            self.parts.editor = true;
            self.lay_out();
        }
        if self.layout.editor.is_none() {
            self.tell(Tone::Plain, "the screen is too small for the panel".into());
        }
    }

    fn move_focus(&mut self, by: i8) {
        self.show_editor();
        if self.layout.editor.is_none() {
            return;
        }
        // Where there is no room for the picture, it is not reached.
        let order: &[Focus] = match self.layout.preview.width {
            0 => &[Focus::Tree, Focus::Properties],
            _ => &[Focus::Picture, Focus::Tree, Focus::Properties],
        };
        let now = order.iter().position(|focus| *focus == self.focus).unwrap_or(order.len() - 1) as isize;
        self.focus = order[(now + isize::from(by)).rem_euclid(order.len() as isize) as usize];
    }

    /// Selects an entry and gives the keys to the row of its properties with this label.
    pub fn go_to(&mut self, target: Target, label: &str) {
        self.editor.tree.select(target);
        self.focus = Focus::Properties;
        let sections = self.editor.sections();
        self.editor.properties.find(&sections, label);
    }

    /// Gives the keys to the picture.
    pub fn go_to_picture(&mut self) {
        self.focus = Focus::Picture;
    }

    /// Moves in what has the keys.
    fn navigate(&mut self, command: Command, now: Instant) {
        if self.cursor.is_some() {
            self.move_cursor(command);
        } else if self.focus == Focus::Properties {
            self.in_properties(command, now);
        } else if self.focus == Focus::Tree {
            self.in_tree(command);
        }
    }

    fn in_tree(&mut self, command: Command) {
        let desc = self.editor.desc().clone();
        let tree = &mut self.editor.tree;
        match command {
            Command::Step(by) => tree.step(&desc, by.into()),
            Command::Page(by) => tree.step(&desc, PAGE * isize::from(by)),
            Command::Ends(to) => tree.step(&desc, if to < 0 { isize::MIN } else { isize::MAX }),
            Command::Extend(by) => tree.extend(&desc, by.into()),
            Command::Turn(by) => tree.fold(by < 0),
            Command::Mark => {
                tree.toggle(tree.cursor());
                tree.step(&desc, 1);
            }
            Command::Accept => self.focus = Focus::Properties,
            Command::Cancel if !tree.cancel() => self.focus = Focus::Picture,
            _ => {}
        }
    }

    fn in_properties(&mut self, command: Command, now: Instant) {
        let sections = self.editor.sections();
        match command {
            Command::Step(by) => self.editor.properties.step(&sections, by.into()),
            Command::Page(by) => self.editor.properties.step(&sections, PAGE * isize::from(by)),
            Command::Ends(to) => {
                self.editor.properties.step(&sections, if to < 0 { isize::MIN } else { isize::MAX });
            }
            Command::Turn(by) => self.nudge(by.into(), true, now),
            Command::TurnFar(by) => self.nudge(by.into(), false, now),
            Command::Reset => self.reset_property(),
            Command::Accept => self.enter_property(),
            Command::Cancel => self.focus = Focus::Tree,
            _ => {}
        }
    }

    /// A move, turn or scale has come this far.
    fn transformed(&mut self, step: Step) {
        let Some(transform) = self.transform.clone() else { return };
        match step {
            Step::Changed => match transform.result() {
                Ok(desc) => {
                    self.message = None;
                    self.replace(desc, &transform.label(), transform.gesture);
                }
                Err(refused) => self.tell(Tone::Bad, refused.to_string()),
            },
            Step::Keep => {
                self.transform = None;
                self.message = None;
            }
            Step::Cancel => {
                self.replace((**transform.begun()).clone(), &transform.label(), transform.gesture);
                self.transform = None;
                self.message = None;
            }
            Step::Unknown => {
                let key = self.keymap.key_in(Scope::Transform, Command::Cancel);
                self.tell(Tone::Plain, format!("{key} takes the change back, and then other keys work again"));
            }
        }
    }
}
