//! A line to be typed, and questions with few answers.

use crate::tui::color::{ColorMode, Role};
use crate::tui::command::{Command, Scope};
use crate::tui::field::Field;
use crate::tui::keymap::Keymap;
use crate::tui::widget::{fit, popup, rows};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;
use ratatui::widgets::Widget;

/// A line of text that is asked for.
#[derive(Clone, Debug)]
pub struct Prompt {
    /// Heading.
    pub title: String,
    /// What is typed.
    pub field: Field,
    /// What the text is for.
    pub purpose: Purpose,
    /// Why the last try was refused.
    pub mistake: Option<String>,
}

/// What a typed line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The new name of the selected thing.
    Rename,
    /// The file that the scene is written to.
    SaveAs,
}

impl Prompt {
    /// With something to begin from.
    pub fn new(purpose: Purpose, title: impl Into<String>, text: &str) -> Self {
        Self { title: title.into(), field: Field::new(text), purpose, mistake: None }
    }

    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let hints = accept_hints(keymap);
        let height = 1 + u16::from(self.mistake.is_some());
        let inner = popup(mode, room, &self.title, &hints, (room.width.saturating_sub(8).min(60), height), buffer);
        let width = usize::from(inner.width);
        let mut lines = rows(inner);
        if let Some(area) = lines.next() {
            Line::from(self.field.spans(width, mode.style(Role::Text))).render(area, buffer);
        }
        if let (Some(mistake), Some(area)) = (&self.mistake, lines.next()) {
            Line::styled(fit(mistake, width), mode.style(Role::Bad)).render(area, buffer);
        }
    }
}

/// The two ways out of a dialog.
pub fn accept_hints(keymap: &Keymap) -> [(String, &'static str); 2] {
    let key = |command| keymap.key_in(Scope::Dialog, command);
    [(key(Command::Accept), "take"), (key(Command::Cancel), "leave as it was")]
}

/// A question that is answered by one key.
#[derive(Clone, Debug)]
pub struct Question {
    /// Heading.
    pub title: String,
    /// Key, and what it does.
    pub answers: Vec<(char, &'static str)>,
    /// What the answer is for.
    pub about: About,
}

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// Leaving with changes that are not saved.
    Unsaved,
    /// The digit to keep the camera under.
    StoreView,
}

impl Question {
    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let hints = [(keymap.key_in(Scope::Dialog, Command::Cancel), "back")];
        let width = self.answers.iter().map(|(_, text)| text.len() + 4).max().unwrap_or(0).max(self.title.len() + 2);
        let size = (width as u16, self.answers.len() as u16);
        let inner = popup(mode, room, &self.title, &hints, size, buffer);
        for ((key, text), area) in self.answers.iter().zip(rows(inner)) {
            let spans = [
                ratatui::text::Span::styled(format!(" {key}  "), mode.style(Role::Key)),
                ratatui::text::Span::raw(*text),
            ];
            Line::from(spans.to_vec()).render(area, buffer);
        }
    }
}
