//! Keys, and the bytes that a terminal sends for them.

use std::fmt;

/// A key as every terminal can send it, tmux and screen included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Which one.
    pub code: Code,
    /// With Control.
    pub ctrl: bool,
    /// With Alt.
    pub alt: bool,
    /// With Shift; never set for a [`Code::Char`], whose character tells.
    pub shift: bool,
}

/// Which key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// A character, lower case with Control.
    Char(char),
    /// Arrow.
    Up,
    /// Arrow.
    Down,
    /// Arrow.
    Left,
    /// Arrow.
    Right,
    /// Return.
    Enter,
    /// Escape.
    Escape,
    /// A key that nothing is bound to.
    Other,
}

impl Key {
    /// The key alone.
    pub const fn plain(code: Code) -> Self {
        Self { code, ctrl: false, alt: false, shift: false }
    }

    /// The character.
    pub const fn char(c: char) -> Self {
        Self::plain(Code::Char(c))
    }

    /// Control and a lower-case letter.
    pub const fn ctrl(c: char) -> Self {
        Self { ctrl: true, ..Self::char(c) }
    }

    /// Shift and a key that is no character.
    pub const fn shift(code: Code) -> Self {
        Self { shift: true, ..Self::plain(code) }
    }
}

impl fmt::Display for Key {
    /// As people write it: `q`, `Ctrl-C`, `Shift-←`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (set, name) in [(self.ctrl, "Ctrl-"), (self.alt, "Alt-"), (self.shift, "Shift-")] {
            if set {
                f.write_str(name)?;
            }
        }
        match self.code {
            Code::Char(' ') => f.write_str("Space"),
            Code::Char(c) if self.ctrl => write!(f, "{}", c.to_ascii_uppercase()),
            Code::Char(c) => write!(f, "{c}"),
            Code::Up => f.write_str("↑"),
            Code::Down => f.write_str("↓"),
            Code::Left => f.write_str("←"),
            Code::Right => f.write_str("→"),
            Code::Enter => f.write_str("Enter"),
            Code::Escape => f.write_str("Esc"),
            Code::Other => f.write_str("?"),
        }
    }
}

/// What came from the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// A key was pressed.
    Key(Key),
    /// The answer to `CSI 6n`: the cursor's column, from 1.
    CursorColumn(u16),
}

/// Finds keys and reports in the byte stream of a terminal. Sequences may be split between reads. Pasted text is
/// dropped: nothing takes text, and it must not act as keys.
#[derive(Debug, Default)]
pub struct Decoder {
    pending: Vec<u8>,
    pasting: bool,
}

/// No sequence that means something is longer; what is longer is rubbish and dropped.
const LONGEST_SEQUENCE: usize = 64;
const PASTE_END: &[u8] = b"\x1b[201~";

impl Decoder {
    /// Takes bytes, returns what is complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Input> {
        self.pending.extend_from_slice(bytes);
        let mut found = Vec::new();
        loop {
            if self.pasting {
                match self.pending.windows(PASTE_END.len()).position(|w| w == PASTE_END) {
                    Some(end) => {
                        self.pending.drain(..end + PASTE_END.len());
                        self.pasting = false;
                    }
                    None => {
                        let kept = self.pending.len().min(PASTE_END.len() - 1);
                        self.pending.drain(..self.pending.len() - kept);
                        return found;
                    }
                }
            }
            let Some((length, token)) = token(&self.pending) else { return found };
            self.pending.drain(..length);
            match token {
                Token::Input(input) => found.push(input),
                Token::PasteStart => self.pasting = true,
                Token::Nothing => {}
            }
        }
    }

    /// Whether the bytes so far may be an Escape key or the beginning of a sequence: only time can tell.
    pub fn is_waiting(&self) -> bool {
        !self.pasting && !self.pending.is_empty()
    }

    /// No more bytes came for a while: a lone ESC was the Escape key, other beginnings are dropped.
    pub fn flush(&mut self) -> Option<Input> {
        let escape = self.pending == [0x1b];
        self.pending.clear();
        escape.then_some(Input::Key(Key::plain(Code::Escape)))
    }
}

enum Token {
    Input(Input),
    PasteStart,
    Nothing,
}

fn key(key: Key) -> Token {
    Token::Input(Input::Key(key))
}

/// The first token of `bytes` and its length; `None` if more bytes are needed.
fn token(bytes: &[u8]) -> Option<(usize, Token)> {
    let first = *bytes.first()?;
    match first {
        0x1b => match *bytes.get(1)? {
            b'[' => control_sequence(bytes),
            b'O' => Some((3, key(Key::plain(cursor_key(*bytes.get(2)?))))),
            0x1b => Some((1, key(Key::plain(Code::Escape)))),
            _ => match token(&bytes[1..])? {
                (length, Token::Input(Input::Key(k))) => Some((length + 1, key(Key { alt: true, ..k }))),
                (length, other) => Some((length + 1, other)),
            },
        },
        b'\r' => Some((1, key(Key::plain(Code::Enter)))),
        0 => Some((1, key(Key::ctrl(' ')))),
        0x01..=0x1a if first != b'\t' && first != 0x08 => Some((1, key(Key::ctrl((first + 0x60) as char)))),
        0..0x20 | 0x7f => Some((1, key(Key::plain(Code::Other)))),
        _ => {
            let length = match first {
                0..0x80 => 1,
                0xc2..=0xdf => 2,
                0xe0..=0xef => 3,
                0xf0..=0xf4 => 4,
                _ => return Some((1, Token::Nothing)),
            };
            // A byte that cannot go on the character shows at once that it is none; else wait for the rest.
            let tail = &bytes[1..length.min(bytes.len())];
            if tail.iter().any(|b| !(0x80..0xc0).contains(b)) {
                return Some((1, Token::Nothing));
            }
            let character = std::str::from_utf8(bytes.get(..length)?).ok().and_then(|s| s.chars().next());
            Some((length, character.map_or(Token::Nothing, |c| key(Key::char(c)))))
        }
    }
}

/// `CSI parameters final`.
fn control_sequence(bytes: &[u8]) -> Option<(usize, Token)> {
    // The Linux console sends CSI [ A for F1.
    if bytes.get(2) == Some(&b'[') {
        bytes.get(3)?;
        return Some((4, key(Key::plain(Code::Other))));
    }
    let Some(end) = bytes[2..].iter().position(|b| !(0x20..0x40).contains(b)) else {
        return (bytes.len() > LONGEST_SEQUENCE).then_some((bytes.len(), Token::Nothing));
    };
    let (parameters, last, length) = (&bytes[2..2 + end], bytes[2 + end], end + 3);
    if !(0x40..0x7f).contains(&last) {
        // A control character breaks the sequence and counts itself.
        return Some((length - 1, Token::Nothing));
    }
    let number = |i: usize| -> u16 {
        let text = parameters.split(|b| *b == b';').nth(i).unwrap_or_default();
        std::str::from_utf8(text).ok().and_then(|t| t.parse().ok()).unwrap_or(0)
    };
    let token = match last {
        b'R' if parameters.contains(&b';') => Token::Input(Input::CursorColumn(number(1))),
        b'~' if parameters == b"200" => Token::PasteStart,
        b'A'..=b'D' => {
            let held = number(1).saturating_sub(1);
            key(Key { code: cursor_key(last), shift: held & 1 != 0, alt: held & 2 != 0, ctrl: held & 4 != 0 })
        }
        b'I' | b'O' | b'c' | b'n' | b'y' | b't' | b'u' => Token::Nothing,
        _ => key(Key::plain(Code::Other)),
    };
    Some((length, token))
}

fn cursor_key(last: u8) -> Code {
    match last {
        b'A' => Code::Up,
        b'B' => Code::Down,
        b'C' => Code::Right,
        b'D' => Code::Left,
        _ => Code::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    fn decode(bytes: &[u8]) -> Vec<Input> {
        let mut decoder = Decoder::default();
        let mut found = decoder.push(bytes);
        found.extend(decoder.flush());
        found
    }

    #[test]
    fn legacy_sequences_are_keys() {
        let table: [(&[u8], Key); 14] = [
            (b"q", Key::char('q')),
            (b"H", Key::char('H')),
            (b" ", Key::char(' ')),
            ("ö".as_bytes(), Key::char('ö')),
            ("€".as_bytes(), Key::char('€')),
            (b"\x03", Key::ctrl('c')),
            (b"\x1a", Key::ctrl('z')),
            (b"\r", Key::plain(Code::Enter)),
            (b"\x1b", Key::plain(Code::Escape)),
            (b"\x1b[A", Key::plain(Code::Up)),
            (b"\x1bOD", Key::plain(Code::Left)),
            (b"\x1b[1;2C", Key::shift(Code::Right)),
            (b"\x1bq", Key { alt: true, ..Key::char('q') }),
            (b"\x1b[15~", Key::plain(Code::Other)),
        ];
        for (bytes, key) in table {
            assert_eq!(decode(bytes), [Input::Key(key)], "{bytes:?}");
        }
    }

    #[test]
    fn a_cursor_report_is_no_key() {
        assert_eq!(decode(b"\x1b[2;7R"), [Input::CursorColumn(7)]);
        assert_eq!(decode(b"a\x1b[2;8Rb").len(), 3);
    }

    #[test]
    fn pasted_text_does_not_act() {
        assert_eq!(decode(b"\x1b[200~qqq\x1b[A\r\x1b[201~x"), [Input::Key(Key::char('x'))]);
    }

    #[test]
    fn any_split_of_the_stream_gives_the_same_keys() {
        let stream = "q\x1b[A\x1b[1;2D€\x1b[2;3R\x1b[200~rubbish\x1b[201~\x1bOC\x03ö ".as_bytes();
        let whole = decode(stream);
        for cut in 1..stream.len() {
            let mut decoder = Decoder::default();
            let mut found = decoder.push(&stream[..cut]);
            found.extend(decoder.push(&stream[cut..]));
            assert_eq!(found, whole, "cut at {cut}");
        }
    }

    #[test]
    fn random_bytes_do_not_stop_the_decoder() {
        let mut random = SplitMix64(7);
        for _ in 0..2000 {
            let bytes: Vec<u8> = (0..40)
                .map(|_| {
                    let r = random.next_u64();
                    if r & 0x300 == 0 {
                        0x1b
                    } else if r & 0x400 == 0 {
                        b"[O;0~1A"[(r % 7) as usize]
                    } else {
                        r as u8
                    }
                })
                .collect();
            let mut decoder = Decoder::default();
            decoder.push(&bytes);
            decoder.flush();
            // An unfinished paste is the one state that swallows keys until its end.
            decoder.push(PASTE_END);
            decoder.flush();
            assert!(decoder.push(b"q").contains(&Input::Key(Key::char('q'))), "{bytes:?}");
        }
    }
}
