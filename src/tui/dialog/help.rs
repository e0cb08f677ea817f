//! The help screen: every key.

use crate::tui::bindings::BINDINGS;
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::keymap::Keymap;
use crate::tui::widget::popup;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Widget};

/// Which part of the help is shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct Help {
    /// Lines above what is shown.
    scroll: usize,
    /// Lines shown at once when it was last drawn; a page is as long.
    page: usize,
}

impl Help {
    /// Takes a key's meaning; whether it scrolls.
    pub fn command(&mut self, command: Option<Command>, screen_rows: u16) -> bool {
        self.page = usize::from(screen_rows).saturating_sub(4).max(1);
        let page = self.page as isize;
        let by = match command {
            Some(Command::Step(rows)) => rows.into(),
            Some(Command::Page(pages) | Command::StepFar(pages)) => isize::from(pages) * page,
            _ => return false,
        };
        self.scroll = self.scroll.saturating_add_signed(by);
        true
    }

    /// Keeps the last line from leaving the screen.
    pub fn clamp(&mut self, keymap: &Keymap, room: Rect) {
        let columns = columns(ColorMode::None, keymap, room.width);
        let lines = columns.iter().map(Vec::len).max().unwrap_or(0);
        self.scroll = self.scroll.min(lines.saturating_sub(usize::from(room.height.saturating_sub(2))));
    }

    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let columns = columns(mode, keymap, room.width);
        let widths: Vec<_> = columns.iter().map(|lines| widest(lines)).collect();
        let width = widths.iter().sum::<u16>() + GAP * (columns.len() as u16 - 1);
        let height = columns.iter().map(Vec::len).max().unwrap_or(0);
        let hidden = height > usize::from(room.height.saturating_sub(2));
        let scroll_hint = if hidden { "↑↓".to_string() } else { String::new() };
        let hints = [(scroll_hint, "scroll"), (keymap.key_of(Command::ToggleHelp), "close")];
        let mut inner = popup(mode, room, "Keys", &hints, (width, height as u16), buffer);
        for (lines, width) in columns.into_iter().zip(widths) {
            let shown: Vec<_> = lines.into_iter().skip(self.scroll).collect();
            Paragraph::new(shown).render(inner, buffer);
            let moved = (width + GAP).min(inner.width);
            inner = Rect { x: inner.x + moved, width: inner.width - moved, ..inner };
        }
    }
}

/// Columns between two lists.
const GAP: u16 = 3;

/// All groups in as many lists side by side as fit, of about the same length.
fn columns(mode: ColorMode, keymap: &Keymap, room: u16) -> Vec<Vec<Line<'static>>> {
    let mut names: Vec<&str> = BINDINGS.iter().map(|binding| binding.group).collect();
    names.dedup();
    let mut all = group_lines(mode, keymap, &names);
    all.extend(mouse_lines(mode));
    for count in (2..=4).rev() {
        let target = all.len().div_ceil(count);
        let mut lists: Vec<Vec<&'static str>> = vec![Vec::new()];
        let mut length = 0;
        for name in &names {
            let own = BINDINGS.iter().filter(|binding| binding.group == *name).count() + 2;
            if length + own / 2 > target && lists.len() < count {
                lists.push(Vec::new());
                length = 0;
            }
            length += own;
            lists.last_mut().into_iter().for_each(|list| list.push(name));
        }
        let mut columns: Vec<_> = lists.iter().map(|names| group_lines(mode, keymap, names)).collect();
        columns.last_mut().into_iter().for_each(|last| last.extend(mouse_lines(mode)));
        let width = columns.iter().map(|lines| widest(lines) + GAP).sum::<u16>() - GAP + 4;
        if width <= room {
            return columns;
        }
    }
    vec![all]
}

/// What the mouse does: the same everywhere, so it stands in no table.
const MOUSE: [(&str, &str); 3] = [
    ("click", "select in picture and tree, go to a property"),
    ("Ctrl-click", "add to the selection"),
    ("wheel", "nearer, farther; scroll the panel"),
];

fn mouse_lines(mode: ColorMode) -> Vec<Line<'static>> {
    let mut lines = vec![Line::default(), Line::styled("Mouse", mode.style(Role::Strong))];
    lines.extend(MOUSE.iter().map(|(what, help)| {
        Line::from(vec![Span::styled(format!("{what:<10}"), mode.style(Role::Key)), Span::raw(format!("  {help}"))])
    }));
    lines
}

fn widest(lines: &[Line]) -> u16 {
    lines.iter().map(Line::width).max().unwrap_or(0) as u16
}

/// The groups with their keys, an empty line between two.
fn group_lines(mode: ColorMode, keymap: &Keymap, groups: &[&'static str]) -> Vec<Line<'static>> {
    let of = |group: &'static str| BINDINGS.iter().filter(move |binding| binding.group == group);
    let texts = groups.iter().flat_map(|group| of(group)).map(|binding| keymap.text(binding));
    let key_width = texts.map(|text| Span::raw(text).width()).max().unwrap_or(0);
    let mut lines = Vec::new();
    for group in groups {
        if !lines.is_empty() {
            lines.push(Line::default());
        }
        let scopes: Vec<_> = of(group).map(|binding| binding.scope).collect();
        // A group whose keys hold in one place says so once.
        let common = scopes.iter().all(|scope| *scope == scopes[0]);
        let place = if common { scopes.first().map_or("", |scope| scope.text()) } else { "" };
        lines.push(Line::from(vec![
            Span::styled(*group, mode.style(Role::Strong)),
            Span::styled(format!(" {place}"), mode.style(Role::Dim)),
        ]));
        for binding in of(group) {
            let keys = keymap.text(binding);
            let gap = key_width - Span::raw(&keys).width();
            let place = if common { "" } else { binding.scope.text() };
            let place = if place.is_empty() { String::new() } else { format!(" ({place})") };
            lines.push(Line::from(vec![
                Span::styled(keys, mode.style(Role::Key)),
                Span::raw(format!("{}  {}", " ".repeat(gap), binding.help)),
                Span::styled(place, mode.style(Role::Dim)),
            ]));
        }
    }
    lines
}
