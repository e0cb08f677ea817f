//! Text from files, made safe for a terminal.

use std::borrow::Cow;

/// `text` with every control character (escape sequences included) and every invisible direction mark replaced by
/// U+FFFD, so that it can be printed. Borrowed if there was none.
pub fn printable(text: &str) -> Cow<'_, str> {
    let bad = |c: char| {
        c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    if text.contains(bad) {
        Cow::Owned(text.chars().map(|c| if bad(c) { '\u{fffd}' } else { c }).collect())
    } else {
        Cow::Borrowed(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escape_sequences_and_direction_marks_do_not_survive() {
        assert_eq!(printable("plain räksmörgås"), "plain räksmörgås");
        assert_eq!(printable("a\x1b[31mb\u{202e}c\n\u{9b}"), "a\u{fffd}[31mb\u{fffd}c\u{fffd}\u{fffd}");
    }
}
