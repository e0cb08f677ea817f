//! Why this colour? The ray tree of a pixel.

use crate::render::Explanation;
use crate::shading::{Emphasis, Line as Told};
use crate::tui::color::{ColorMode, Role};
use crate::tui::command::Command;
use crate::tui::command::Scope;
use crate::tui::keymap::Keymap;
use crate::tui::widget::{fit, popup, rows};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// The rays of one sample, and how far they are scrolled.
#[derive(Clone, Debug)]
pub struct Rays {
    title: String,
    lines: Vec<Told>,
    scroll: usize,
}

/// A screen of at least so many columns has the box in its right half: the pixel asked about can stay in view.
const WIDE: u16 = 140;

impl Rays {
    /// Of the sample explained; `color`: the pixel's in the film, linear light, the mean of `samples`.
    pub fn new(explanation: &Explanation, color: [f32; 3], samples: u32) -> Self {
        let [x, y] = explanation.pixel;
        let mut lines = explanation.tree.lines();
        let [r, g, b] = color;
        let of = if samples == 1 { "its one sample".into() } else { format!("mean of {samples} samples") };
        let text = format!("pixel {r:.5} {g:.5} {b:.5}, {of}");
        lines.push(Told { depth: 0, emphasis: Emphasis::Sum, text });
        Self { title: format!("Why this colour? Pixel {x},{y}, sample {}", explanation.sample), lines, scroll: 0 }
    }

    /// Takes a key's meaning; whether it scrolls.
    pub fn command(&mut self, command: Option<Command>, screen_rows: u16) -> bool {
        let page = usize::from(screen_rows).saturating_sub(4).max(1);
        let by = match command {
            Some(Command::Step(rows)) => rows.into(),
            Some(Command::Page(pages)) => isize::from(pages) * page as isize,
            _ => return false,
        };
        self.scroll = self.scroll.saturating_add_signed(by).min(self.lines.len().saturating_sub(page));
        true
    }

    /// Draws the box.
    pub fn draw(&self, mode: ColorMode, keymap: &Keymap, room: Rect, buffer: &mut Buffer) {
        let left = if room.width >= WIDE { room.width / 2 } else { 0 };
        let room = Rect { x: room.x + left, width: room.width - left, ..room };
        let close = keymap.key_in(Scope::Dialog, Command::Cancel);
        let hints = [("↑↓".to_string(), "scroll"), (close, "close")];
        let inner = popup(mode, room, &self.title, &hints, (room.width, self.lines.len() as u16), buffer);
        for (line, row) in self.lines.iter().skip(self.scroll).zip(rows(inner)) {
            let role = match line.emphasis {
                Emphasis::Ray => Role::Key,
                Emphasis::Hit => Role::Strong,
                Emphasis::Plain => Role::Dim,
                Emphasis::Term => Role::Text,
                Emphasis::Cut => Role::Bad,
                Emphasis::Sum => Role::Good,
            };
            // Deep trees stay on the screen.
            let indent = (2 * line.depth).min(usize::from(row.width) / 2);
            let text = fit(&line.text, usize::from(row.width) - indent);
            Line::from(vec![Span::raw(" ".repeat(indent)), Span::styled(text, mode.style(role))]).render(row, buffer);
        }
    }
}
