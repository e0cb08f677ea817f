//! The palette: every command by its name.

use crate::tui::color::{ColorMode, Role};
use crate::tui::command::{Action, Command, Scope};
use crate::tui::field::Field;
use crate::tui::key::Key;
use crate::tui::keymap::{Keymap, actions};
use crate::tui::widget::{fit, popup, rows, window};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// What was typed, and the line that is chosen.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    query: Field,
    cursor: usize,
}

impl Palette {
    /// Takes a key that is typed or moves; the command if one was chosen.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> Option<Command> {
        let found = self.found();
        match command {
            Some(Command::Step(rows)) => self.step(rows.into(), found.len()),
            Some(Command::Page(pages)) => self.step(isize::from(pages) * ROWS as isize, found.len()),
            Some(Command::Accept) => return found.get(self.cursor).map(|action| action.command),
            _ if self.query.key(key) => self.cursor = 0,
            _ => {}
        }
        None
    }

    /// Takes pasted text.
    pub fn paste(&mut self, text: &str) {
        self.query.paste(text);
        self.cursor = 0;
    }

    fn step(&mut self, by: isize, count: usize) {
        self.cursor = self.cursor.saturating_add_signed(by).min(count.saturating_sub(1));
    }

    /// Commands that fit what was typed, the best first.
    fn found(&self) -> Vec<&'static Action> {
        let query = self.query.text().to_lowercase();
        let mut found: Vec<(usize, &Action)> = Vec::new();
        for (binding, action) in actions() {
            // Those of dialogs and modes mean nothing outside of them.
            let everywhere = matches!(
                binding.scope,
                Scope::Anywhere | Scope::Screen | Scope::Picture | Scope::Fitted | Scope::Zoomed
            );
            let known = found.iter().any(|(_, other)| other.command == action.command);
            if everywhere
                && !known
                && action.command != Command::OpenPalette
                && let Some(rank) = rank(&query, action.title)
            {
                found.push((rank, action));
            }
        }
        found.sort_by_key(|(rank, _)| *rank);
        found.into_iter().map(|(_, action)| action).collect()
    }

    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let found = self.found();
        let take = keymap.key_in(Scope::Dialog, Command::Accept);
        let hints = [(take, "do it"), (keymap.key_in(Scope::Dialog, Command::Cancel), "close")];
        let inner = popup(mode, room, "Commands", &hints, (46, ROWS as u16 + 2), buffer);
        let width = usize::from(inner.width);
        let mut lines = rows(inner);
        let Some(top) = lines.next() else { return };
        let mut prompt = vec![Span::styled(": ", mode.style(Role::Key))];
        prompt.extend(self.query.spans(width.saturating_sub(2), mode.style(Role::Text)));
        Line::from(prompt).render(top, buffer);
        lines.next();
        if found.is_empty() {
            let none = Line::styled("no such command", mode.style(Role::Dim));
            lines.next().into_iter().for_each(|area| none.clone().render(area, buffer));
            return;
        }
        let shown = window(found.len(), self.cursor, usize::from(inner.height).saturating_sub(2));
        for (index, area) in shown.zip(lines) {
            let action = found[index];
            let keys = keymap.key_of(action.command);
            let title = fit(action.title, width.saturating_sub(Span::raw(&keys).width() + 1));
            let (text, key) = if index == self.cursor { (Role::Cursor, Role::Cursor) } else { (Role::Text, Role::Key) };
            let spans = vec![Span::styled(format!("{title} "), mode.style(text)), Span::styled(keys, mode.style(key))];
            Line::from(spans).render(area, buffer);
        }
    }
}

/// Commands shown at once.
const ROWS: usize = 14;

/// How well a title fits a query in lower case: less is better; `None` if not all of its characters stand there in
/// their order. A piece at the beginning is better than one inside, and that better than scattered characters.
pub fn rank(query: &str, title: &str) -> Option<usize> {
    let title = title.to_lowercase();
    if let Some(at) = title.find(query) {
        let begins_word = at == 0 || title[..at].ends_with(' ');
        return Some(if at == 0 {
            0
        } else if begins_word {
            100 + at
        } else {
            200 + at
        });
    }
    let mut rest = title.chars();
    let mut skipped = 0;
    for wanted in query.chars().filter(|c| *c != ' ') {
        skipped += rest.position(|c| c == wanted)?;
    }
    Some(300 + skipped)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_come_before_scattered_characters_and_the_rest_is_left_out() {
        assert_eq!(rank("", "undo"), Some(0));
        assert!(rank("un", "undo") < rank("do", "undo"));
        assert!(rank("sc", "save scene") < rank("sne", "save scene"));
        assert!(rank("ss", "save scene").is_some());
        for (query, title) in [("x", "undo"), ("odnu", "undo"), ("undoo", "undo")] {
            assert_eq!(rank(query, title), None, "{query} in {title}");
        }
    }
}
