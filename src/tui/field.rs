//! A line of text being typed.

use super::key::{Code, Key};
use ratatui::style::{Modifier, Style};
use ratatui::text::Span;

/// Longest text that a field takes, in characters.
const LONGEST: usize = 1000;

/// Text with a cursor. Control characters never get in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    characters: Vec<char>,
    /// Characters before the cursor.
    cursor: usize,
}

impl Field {
    /// With the cursor at the end of `text`.
    pub fn new(text: &str) -> Self {
        let mut field = Self::default();
        field.paste(text);
        field
    }

    /// What was typed.
    pub fn text(&self) -> String {
        self.characters.iter().collect()
    }

    /// Whether nothing was typed.
    pub fn is_empty(&self) -> bool {
        self.characters.is_empty()
    }

    /// Takes a key that writes, erases or moves the cursor; whether it was one.
    pub fn key(&mut self, key: Key) -> bool {
        if key.ctrl || key.alt {
            return false;
        }
        match key.code {
            Code::Char(c) => self.insert(c),
            Code::Backspace if self.cursor > 0 => {
                self.cursor -= 1;
                self.characters.remove(self.cursor);
            }
            Code::Delete if self.cursor < self.characters.len() => {
                self.characters.remove(self.cursor);
            }
            Code::Backspace | Code::Delete => {}
            Code::Left => self.cursor = self.cursor.saturating_sub(1),
            Code::Right => self.cursor = (self.cursor + 1).min(self.characters.len()),
            Code::Home => self.cursor = 0,
            Code::End => self.cursor = self.characters.len(),
            _ => return false,
        }
        true
    }

    /// Puts in text as if it was typed; its line ends and other control characters are left out.
    pub fn paste(&mut self, text: &str) {
        text.chars().for_each(|c| self.insert(c));
    }

    fn insert(&mut self, c: char) {
        let mut bytes = [0; 4];
        let safe = crate::description::printable(c.encode_utf8(&mut bytes)) == c.to_string().as_str();
        if safe && self.characters.len() < LONGEST {
            self.characters.insert(self.cursor, c);
            self.cursor += 1;
        }
    }

    /// The part about the cursor that fits into `width` columns; the cursor is a reversed cell.
    pub fn spans(&self, width: usize, style: Style) -> Vec<Span<'static>> {
        let text = |characters: &[char]| characters.iter().collect::<String>();
        let columns = |characters: &[char]| Span::raw(text(characters)).width();
        let mut first = 0;
        while first < self.cursor && columns(&self.characters[first..self.cursor]) + 2 > width {
            first += 1;
        }
        let under = self.characters.get(self.cursor).map_or(" ".into(), char::to_string);
        let mut last = (self.cursor + 1).min(self.characters.len());
        let used = columns(&self.characters[first..self.cursor]) + Span::raw(&under).width();
        let behind = last;
        while last < self.characters.len() && used + columns(&self.characters[behind..=last]) <= width {
            last += 1;
        }
        vec![
            Span::styled(text(&self.characters[first..self.cursor]), style),
            Span::styled(under, style.add_modifier(Modifier::REVERSED)),
            Span::styled(text(&self.characters[behind..last]), style),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_erasing_and_moving_do_what_they_do_everywhere() {
        let mut field = Field::new("ab\x1b[31m\n\u{202e}");
        assert_eq!(field.text(), "ab[31m");
        for (code, expected) in [
            (Code::Home, "ab[31m"),
            (Code::Char('ö'), "öab[31m"),
            (Code::Delete, "öb[31m"),
            (Code::End, "öb[31m"),
            (Code::Backspace, "öb[31"),
            (Code::Left, "öb[31"),
            (Code::Backspace, "öb[1"),
            (Code::Right, "öb[1"),
            (Code::Right, "öb[1"),
            (Code::Delete, "öb[1"),
        ] {
            assert!(field.key(Key::plain(code)));
            assert_eq!(field.text(), expected, "{code:?}");
        }
        assert!(!field.key(Key::plain(Code::Enter)) && !field.key(Key::ctrl('u')));
    }

    #[test]
    fn what_is_shown_has_the_cursor_and_fits() {
        let mut field = Field::new("0123456789 日本語");
        for _ in 0..15 {
            for width in 1..20 {
                let spans = field.spans(width, Style::new());
                let shown: usize = spans.iter().map(Span::width).sum();
                assert!(shown <= width.max(2), "{shown} columns of {width}");
                assert!(spans[1].style.add_modifier.contains(Modifier::REVERSED));
            }
            field.key(Key::plain(Code::Left));
        }
    }
}
