//! Small parts that several parts of the screen are made of.

use super::color::{ColorMode, Role};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Widget};
use std::ops::Range;

/// Draws an empty box with a title in the middle of `room`, as near to the size wanted inside as fits, and a line of
/// hints in its lower edge. Returns what is inside, a column of air on both sides left out.
pub fn popup(
    mode: ColorMode,
    room: Rect,
    title: &str,
    hints: &[(String, &str)],
    (width, height): (u16, u16),
    buffer: &mut Buffer,
) -> Rect {
    let (width, height) = (width.saturating_add(4).min(room.width), height.saturating_add(2).min(room.height));
    let area = Rect { x: room.x + (room.width - width) / 2, y: room.y + (room.height - height) / 2, width, height };
    Clear.render(area, buffer);
    let block = Block::bordered().border_type(BorderType::Rounded).border_style(mode.style(Role::Dim));
    let block = block.title(Line::styled(format!(" {title} "), mode.style(Role::Strong)));
    let block = block.title_bottom(hint_line(mode, hints, usize::from(width).saturating_sub(4)).right_aligned());
    let inner = block.inner(area);
    block.render(area, buffer);
    Rect { x: inner.x + 1, width: inner.width.saturating_sub(2), ..inner }
}

/// Keys and what they do, as many from the first as fit into `room` columns.
pub fn hint_line(mode: ColorMode, hints: &[(String, &str)], mut room: usize) -> Line<'static> {
    let mut spans = Vec::new();
    for (key, text) in hints.iter().filter(|(key, _)| !key.is_empty()) {
        let width = Span::raw(key.as_str()).width() + Span::raw(*text).width() + 3;
        // The first that does not fit ends the list: the most useful ones come first.
        if width > room {
            break;
        }
        room -= width;
        spans.push(Span::styled(format!(" {key}"), mode.style(Role::Key)));
        spans.push(Span::styled(format!(" {text} "), mode.style(Role::Dim)));
    }
    Line::from(spans)
}

/// Which of `count` rows to show in `height` lines so that the one at `cursor` is among them.
pub fn window(count: usize, cursor: usize, height: usize) -> Range<usize> {
    let first = cursor.saturating_sub(height / 2).min(count.saturating_sub(height));
    first..(first + height).min(count)
}

/// `text` in exactly `width` columns: cut with an ellipsis, or filled up.
pub fn fit(text: &str, width: usize) -> String {
    let mut cut = String::new();
    let full = Span::raw(text).width();
    let room = if full > width { width.saturating_sub(1) } else { width };
    let mut used = 0;
    let mut bytes = [0; 4];
    for c in text.chars() {
        let columns = Span::raw(&*c.encode_utf8(&mut bytes)).width();
        if used + columns > room {
            break;
        }
        cut.push(c);
        used += columns;
    }
    if full > width && width > 0 {
        cut.push('…');
        used += 1;
    }
    cut + &" ".repeat(width - used)
}

/// Rows of `area`, each one cell high.
pub fn rows(area: Rect) -> impl Iterator<Item = Rect> {
    (area.top()..area.bottom()).map(move |y| Rect { y, height: 1, ..area })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_fitted_to_the_column() {
        for (text, width, fitted) in [
            ("abc", 5, "abc  "),
            ("abcdef", 4, "abc…"),
            ("abc", 3, "abc"),
            ("abc", 0, ""),
            ("abc", 1, "…"),
            ("日本語", 5, "日本…"),
            ("日本語", 4, "日… "),
        ] {
            assert_eq!(fit(text, width), fitted, "{text} in {width}");
        }
    }

    #[test]
    fn the_row_of_the_cursor_is_always_shown() {
        for count in 0..20 {
            for cursor in 0..count {
                for height in 1..25 {
                    let shown = window(count, cursor, height);
                    assert!(shown.contains(&cursor) && shown.len() == height.min(count) && shown.end <= count);
                }
            }
        }
        assert!(window(5, 2, 0).is_empty());
    }
}
