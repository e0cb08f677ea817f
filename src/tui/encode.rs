//! Cells to bytes, with as few escape sequences as will do.

use super::preview::UPPER_HALF;
use ratatui::buffer::Cell;
use ratatui::style::{Color, Modifier};
use ratatui::text::Span;
use std::io::Write;

/// Writes cells and remembers the pen and the cursor of the terminal.
#[derive(Debug, Default)]
pub struct Encoder {
    pen: Pen,
    /// Where the next character lands; `None` if that is not sure.
    cursor: Option<(u16, u16)>,
    out: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Pen {
    fg: Color,
    bg: Color,
    modifier: Modifier,
}

impl Default for Pen {
    fn default() -> Self {
        Self { fg: Color::Reset, bg: Color::Reset, modifier: Modifier::empty() }
    }
}

impl Encoder {
    /// Clears the screen and forgets what was known of pen and cursor.
    pub fn clear(&mut self) {
        self.pen = Pen::default();
        self.cursor = None;
        self.out.extend_from_slice(b"\x1b[0m\x1b[2J");
    }

    /// Bytes gathered so far.
    pub fn len(&self) -> usize {
        self.out.len()
    }

    /// The bytes gathered, which the caller will send, and may move the cursor afterwards.
    pub fn take(&mut self) -> Vec<u8> {
        self.cursor = None;
        std::mem::take(&mut self.out)
    }

    /// Shows `cell` in column `x`, row `y`. Returns how many columns it covers.
    pub fn put(&mut self, x: u16, y: u16, cell: &Cell) -> u16 {
        self.go_to(x, y);
        // Without a colour below, `▀` is the only way: the default background is no foreground.
        if cell.symbol() == UPPER_HALF && cell.bg != Color::Reset {
            self.put_pixels(cell);
            self.cursor = Some((x + 1, y));
            return 1;
        }
        self.set_pen(Pen { fg: cell.fg, bg: cell.bg, modifier: cell.modifier });
        self.out.extend_from_slice(cell.symbol().as_bytes());
        if cell.symbol().is_ascii() || cell.symbol() == UPPER_HALF {
            self.cursor = Some((x + 1, y));
            return 1;
        }
        // Terminals do not agree on the width of every character.
        self.cursor = None;
        (Span::raw(cell.symbol()).width() as u16).max(1)
    }

    fn go_to(&mut self, x: u16, y: u16) {
        match self.cursor {
            Some(cursor) if cursor == (x, y) => {}
            Some((from, row)) if row == y && from + 1 == x => self.out.extend_from_slice(b"\x1b[C"),
            Some((from, row)) if row == y && from < x => self.print(format_args!("\x1b[{}C", x - from)),
            _ => self.print(format_args!("\x1b[{};{}H", y + 1, x + 1)),
        }
    }

    /// Two pixels in a cell: `▀`, the same upside down, or a space if they are equal, whichever needs fewer changes
    /// of colour.
    fn put_pixels(&mut self, cell: &Cell) {
        let upright = Pen { fg: cell.fg, bg: cell.bg, modifier: Modifier::empty() };
        if cell.fg == cell.bg {
            // The pen's foreground does not matter for a space, nor its background for a full block.
            if self.pen.fg == cell.fg && self.pen.bg != cell.bg {
                self.set_pen(Pen { modifier: Modifier::empty(), ..self.pen });
                self.out.extend_from_slice("█".as_bytes());
            } else {
                self.set_pen(Pen { fg: self.pen.fg, ..upright });
                self.out.push(b' ');
            }
            return;
        }
        let inverted = Pen { fg: cell.bg, bg: cell.fg, ..upright };
        let changes = |pen: Pen| u8::from(pen.fg != self.pen.fg) + u8::from(pen.bg != self.pen.bg);
        if changes(inverted) < changes(upright) {
            self.set_pen(inverted);
            self.out.extend_from_slice("▄".as_bytes());
        } else {
            self.set_pen(upright);
            self.out.extend_from_slice("▀".as_bytes());
        }
    }

    fn set_pen(&mut self, pen: Pen) {
        let start = self.out.len();
        let dropped = self.pen.modifier - pen.modifier;
        let before = if dropped.is_empty() { self.pen } else { Pen::default() };
        if !dropped.is_empty() {
            self.out.extend_from_slice(b"0;");
        }
        for (flag, code) in
            [(Modifier::BOLD, "1;"), (Modifier::DIM, "2;"), (Modifier::UNDERLINED, "4;"), (Modifier::REVERSED, "7;")]
        {
            if (pen.modifier - before.modifier).contains(flag) {
                self.out.extend_from_slice(code.as_bytes());
            }
        }
        if pen.fg != before.fg {
            self.color(pen.fg, 30);
        }
        if pen.bg != before.bg {
            self.color(pen.bg, 40);
        }
        if self.out.len() > start {
            self.out.splice(start..start, *b"\x1b[");
            self.out.pop();
            self.out.push(b'm');
        }
        self.pen = pen;
    }

    /// `base`: 30 for the foreground, 40 for the background. The interface uses no other colours than these.
    fn color(&mut self, color: Color, base: u8) {
        match color {
            Color::Rgb(r, g, b) => self.print(format_args!("{};2;{r};{g};{b};", base + 8)),
            Color::Indexed(i) => self.print(format_args!("{};5;{i};", base + 8)),
            _ => self.print(format_args!("{};", base + 9)),
        }
    }

    fn print(&mut self, text: std::fmt::Arguments) {
        // Writing to a Vec cannot fail.
        let _ = self.out.write_fmt(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(cells: &[(Color, Color)]) -> String {
        let mut encoder = Encoder::default();
        for (x, (fg, bg)) in (0..).zip(cells) {
            let mut cell = Cell::new(UPPER_HALF);
            cell.set_fg(*fg).set_bg(*bg);
            encoder.put(x, 0, &cell);
        }
        String::from_utf8(encoder.take()).unwrap()
    }

    #[test]
    fn only_what_changes_is_sent() {
        let [a, b, c] = [1, 2, 3].map(Color::Indexed);
        let start = "\x1b[1;1H\x1b[38;5;1;48;5;2m▀";
        for (cells, rest) in [
            (&[(a, b), (a, b)][..], "▀"),
            (&[(a, b), (a, c)], "\x1b[48;5;3m▀"),
            (&[(a, b), (b, a)], "▄"),
            (&[(a, b), (b, c)], "\x1b[38;5;3m▄"),
            (&[(a, b), (b, b)], " "),
            (&[(a, b), (a, a)], "█"),
            (&[(a, b), (c, c)], "\x1b[48;5;3m "),
            (&[(a, b), (c, Color::Reset)], "\x1b[38;5;3;49m▀"),
        ] {
            assert_eq!(text(cells), format!("{start}{rest}"));
        }
        // Above the default background: not the same upside down, whatever the pen holds.
        assert!(text(&[(b, a), (a, Color::Reset)]).ends_with("m▀"));
    }

    #[test]
    fn attributes_are_taken_back() {
        let mut encoder = Encoder::default();
        let mut cell = Cell::new("a");
        cell.modifier = Modifier::BOLD;
        cell.fg = Color::Indexed(7);
        encoder.put(0, 0, &cell);
        cell.modifier = Modifier::empty();
        encoder.put(1, 0, &cell);
        assert_eq!(encoder.take(), b"\x1b[1;1H\x1b[1;38;5;7ma\x1b[0;38;5;7ma");
    }
}
