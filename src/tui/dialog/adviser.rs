//! The adviser: what the scene pays for and does not need.

use crate::advice::Advice;
use crate::description::SceneDesc;
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::{Command, Scope};
use crate::tui::keymap::Keymap;
use crate::tui::widget::{fit, popup, rows, window};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Widget;
use std::sync::{Arc, Weak};

/// A list of advice about one description.
#[derive(Clone, Debug)]
pub struct Adviser {
    /// What is measured.
    pub desc: Arc<SceneDesc>,
    /// `None` while it is measured; or why there is none.
    pub found: Option<Result<Vec<Advice>, String>>,
    /// As long as this lives, somebody waits for the answer.
    waits: Arc<()>,
    /// Which of them were taken.
    taken: Vec<bool>,
    cursor: usize,
}

impl Adviser {
    /// Being measured.
    pub fn new(desc: Arc<SceneDesc>) -> Self {
        Self { desc, found: None, waits: Arc::new(()), taken: Vec::new(), cursor: 0 }
    }

    /// Dead when the dialog is closed.
    pub fn waits(&self) -> Weak<()> {
        Arc::downgrade(&self.waits)
    }

    /// All is measured.
    pub fn answer(&mut self, found: Result<Vec<Advice>, String>) {
        self.taken = vec![false; found.as_ref().map_or(0, Vec::len)];
        self.found = Some(found);
    }

    /// Moves, or takes the advice with the cursor, once.
    pub fn key(&mut self, command: Option<Command>) -> Option<Advice> {
        let Some(Ok(found)) = &self.found else { return None };
        let last = found.len().checked_sub(1)?;
        match command {
            Some(Command::Step(by)) => self.cursor = self.cursor.saturating_add_signed(by.into()).min(last),
            Some(Command::Accept) if !std::mem::replace(&mut self.taken[self.cursor], true) => {
                return Some(found[self.cursor].clone());
            }
            _ => {}
        }
        None
    }

    /// Draws the box: two lines for each, what to do and what it brings.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let key = |command| keymap.key_in(Scope::Dialog, command);
        let hints = [(key(Command::Accept), "take"), (key(Command::Cancel), "close")];
        let size = (room.width.saturating_sub(8).min(76), room.height.saturating_sub(4).min(16));
        let inner = popup(mode, room, "What the scene does not need", &hints, size, buffer);
        let mut note =
            |text: &str, role| Line::styled(fit(text, inner.width.into()), mode.style(role)).render(inner, buffer);
        let found = match &self.found {
            None => return note("measuring…", Role::Dim),
            Some(Err(reason)) => return note(reason, Role::Bad),
            Some(Ok(found)) if found.is_empty() => return note("nothing: it needs all that it pays for", Role::Good),
            Some(Ok(found)) => found,
        };
        let shown = window(found.len(), self.cursor, usize::from(inner.height / 2).max(1));
        let mut lines = rows(inner);
        for index in shown {
            let advice = &found[index];
            let role = if index == self.cursor { Role::Cursor } else { Role::Text };
            let mark = if self.taken[index] { "✓" } else { " " };
            let text = format!("{mark} {}: {}", advice.change.text(&self.desc), advice.reason);
            let saves = format!(
                "    saves {:.0} % of the rays, {:.0} % of the time; error {:.2} codes, at most {:.1}",
                100.0 * advice.rays,
                100.0 * advice.time,
                advice.rmse,
                advice.largest
            );
            for (text, role) in [(text, role), (saves, Role::Dim)] {
                let Some(row) = lines.next() else { return };
                Line::styled(fit(&text, row.width.into()), mode.style(role)).render(row, buffer);
            }
        }
    }
}
