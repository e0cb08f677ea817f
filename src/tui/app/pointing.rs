//! The mouse, and the cursor that picks with keys.

use super::{App, Focus, Tone};
use crate::description::Target;
use crate::tui::command::Command;
use crate::tui::decode::{Mouse, MouseAction};
use crate::tui::event::Effect;
use crate::tui::side::SideLayout;
use crate::tui::tree::Row;
use ratatui::layout::Position;
use std::time::Instant;

/// Pixels that the cursor moves by with Shift.
const FAR: isize = 8;

impl App {
    pub(super) fn mouse(&mut self, mouse: Mouse, now: Instant) -> Vec<Effect> {
        if self.dialog.is_some() || self.searching || self.editor.properties.entry.is_some() || self.transform.is_some()
        {
            return Vec::new();
        }
        let at = Position::new(mouse.column, mouse.row);
        let turned = match mouse.action {
            MouseAction::Press => None,
            MouseAction::WheelUp => Some(-1),
            MouseAction::WheelDown => Some(1),
        };
        let preview = self.layout.preview;
        if preview.contains(at) {
            return match turned {
                Some(by) => self.command(Command::Dolly(-by), now),
                None => {
                    self.focus = Focus::Picture;
                    self.cursor = None;
                    // The middle of a cell lies between its two pixels: the upper one of them.
                    let (x, y) = (at.x - preview.x, at.y - preview.y);
                    self.clicked = self.preview.film_pixel(usize::from(x), 2 * usize::from(y));
                    self.pick(usize::from(x), 2 * usize::from(y), mouse.held);
                    Vec::new()
                }
            };
        }
        let Some(area) = self.layout.editor.filter(|area| area.contains(at)) else { return Vec::new() };
        let side = SideLayout::new(self, area);
        if side.tree.contains(at) {
            self.click_tree(turned, (at.y - side.tree.y).into(), side.tree.height.into(), mouse.held);
        } else if side.properties.contains(at) {
            let sections = self.editor.sections();
            let (line, height) = ((at.y - side.properties.y).into(), side.properties.height.into());
            match turned {
                Some(by) => self.editor.properties.step(&sections, by.into()),
                None => {
                    self.editor.properties.go_to(&sections, line, height);
                    self.focus = Focus::Properties;
                }
            }
        }
        Vec::new()
    }

    fn click_tree(&mut self, turned: Option<i8>, line: usize, height: usize, held: bool) {
        let desc = self.editor.desc().clone();
        let tree = &mut self.editor.tree;
        match turned {
            Some(by) => tree.step(&desc, by.into()),
            None => {
                self.focus = Focus::Tree;
                match tree.at(&desc, line, height) {
                    Some(Row::Entry(target)) if held => tree.toggle(target),
                    Some(Row::Entry(target)) => tree.select(target),
                    Some(Row::Heading(group, _) | Row::More(group, _)) => tree.toggle_fold(group, &desc),
                    None => {}
                }
            }
        }
    }

    /// Puts the cursor into the middle of the picture.
    pub(super) fn begin_pick(&mut self) {
        let (across, down) = self.preview.pixels();
        self.cursor = self.preview.nearest(across / 2, down / 2);
        self.under_cursor();
    }

    /// Moves the cursor, or picks with it.
    pub(super) fn move_cursor(&mut self, command: Command) {
        let Some((x, y)) = self.cursor else { return };
        let (right, below) = match command {
            Command::Turn(by) => (isize::from(by), 0),
            Command::TurnFar(by) => (FAR * isize::from(by), 0),
            Command::Step(by) => (0, isize::from(by)),
            Command::StepFar(by) => (0, FAR * isize::from(by)),
            Command::Accept => {
                self.pick(x, y, false);
                return;
            }
            Command::Mark => {
                self.pick(x, y, true);
                return;
            }
            Command::Cancel => {
                self.cursor = None;
                return;
            }
            _ => return,
        };
        self.cursor = self.preview.nearest(x.saturating_add_signed(right), y.saturating_add_signed(below));
        self.under_cursor();
    }

    /// The entry that a pixel of the preview shows: an object, or the world where there is none.
    fn entry_at(&self, x: usize, y: usize) -> Option<Target> {
        let scene = self.scene.as_deref()?;
        let (column, row) = self.preview.film_pixel(x, y)?;
        let target = scene.pick(column, row).map_or(Target::World, |pick| Target::Object(pick.object));
        // The compiled scene may be older than what is edited.
        target.exists(self.editor.desc()).then_some(target)
    }

    /// Tells what is under the cursor.
    fn under_cursor(&mut self) {
        let Some((x, y)) = self.cursor else { return };
        let text = match self.entry_at(x, y) {
            Some(target) => target.label(self.editor.desc()),
            None => "nothing is known here yet".into(),
        };
        self.tell(Tone::Plain, text);
    }

    fn pick(&mut self, x: usize, y: usize, add: bool) {
        // Beside the picture nothing is picked.
        if let Some(target) = self.entry_at(x, y) {
            self.picked(target, add);
        }
    }
}
