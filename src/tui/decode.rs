//! The bytes that a terminal sends, as keys, mouse clicks, pasted text and answers.

use super::key::{Code, Key};

/// What came from the terminal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Input {
    /// A key was pressed.
    Key(Key),
    /// A button of the mouse was pressed, or its wheel turned.
    Mouse(Mouse),
    /// Text was pasted.
    Pasted(String),
    /// The answer to `CSI 6n`: the cursor's column, from 1.
    CursorColumn(u16),
}

/// A press of a button of the mouse, or a turn of its wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mouse {
    /// Cell, from 0.
    pub column: u16,
    /// Cell, from 0.
    pub row: u16,
    /// What was done there.
    pub action: MouseAction,
    /// With Shift, Alt or Control. Many terminals keep the one with Shift for themselves.
    pub held: bool,
}

/// What a mouse does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MouseAction {
    /// The left button goes down.
    Press,
    /// The wheel turns away from the hand.
    WheelUp,
    /// The wheel turns toward the hand.
    WheelDown,
}

/// Finds keys and reports in the byte stream of a terminal. Sequences may be split between reads. Pasted text comes as
/// text: it must not act as keys.
#[derive(Debug, Default)]
pub struct Decoder {
    pending: Vec<u8>,
    /// What was pasted so far.
    pasting: Option<Vec<u8>>,
    /// An ESC was just taken for the Escape key because nothing followed.
    escaped: bool,
}

/// Pasted text is cut here: fields are single lines.
const LONGEST_PASTE: usize = 4096;

/// No sequence that means something is longer; what is longer is rubbish and dropped.
const LONGEST_SEQUENCE: usize = 64;
const PASTE_END: &[u8] = b"\x1b[201~";

impl Decoder {
    /// Takes bytes, returns what is complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Input> {
        // On a slow link a sequence may be split after its ESC for longer than one waits. Nobody types two such
        // characters in one read, so this is its rest: without the ESC it would be taken for typing.
        let late = std::mem::take(&mut self.escaped) && matches!(bytes, [b'[' | b'O', _, ..]);
        if late {
            self.pending.push(ESC);
        }
        self.pending.extend_from_slice(bytes);
        let mut found = Vec::new();
        loop {
            if let Some(pasted) = &mut self.pasting {
                let end = self.pending.windows(PASTE_END.len()).position(|w| w == PASTE_END);
                let text_end = end.unwrap_or(self.pending.len().saturating_sub(PASTE_END.len() - 1));
                let room = LONGEST_PASTE.saturating_sub(pasted.len());
                pasted.extend(self.pending.drain(..text_end).take(room));
                if end.is_none() {
                    return found;
                }
                self.pending.drain(..PASTE_END.len());
                let text = String::from_utf8_lossy(&self.pasting.take().unwrap_or_default()).into_owned();
                found.push(Input::Pasted(text));
            }
            let Some((length, token)) = token(&self.pending) else { return found };
            self.pending.drain(..length);
            match token {
                Token::Input(input) => found.push(input),
                Token::PasteStart => self.pasting = Some(Vec::new()),
                Token::Nothing => {}
            }
        }
    }

    /// Whether the bytes so far may be an Escape key or the beginning of a sequence: only time can tell.
    pub fn is_waiting(&self) -> bool {
        self.pasting.is_none() && !self.pending.is_empty()
    }

    /// No more bytes came for a while: a lone ESC was the Escape key, other beginnings are dropped.
    pub fn flush(&mut self) -> Option<Input> {
        self.escaped = self.pending == [ESC];
        self.pending.clear();
        self.escaped.then_some(Input::Key(Key::plain(Code::Escape)))
    }
}

const ESC: u8 = 0x1b;

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
        ESC => match *bytes.get(1)? {
            b'[' => control_sequence(bytes),
            b'O' => Some((3, key(Key::plain(cursor_key(*bytes.get(2)?))))),
            ESC => Some((1, key(Key::plain(Code::Escape)))),
            _ => match token(&bytes[1..])? {
                (length, Token::Input(Input::Key(k))) => Some((length + 1, key(Key { alt: true, ..k }))),
                (length, other) => Some((length + 1, other)),
            },
        },
        b'\r' => Some((1, key(Key::plain(Code::Enter)))),
        b'\t' => Some((1, key(Key::plain(Code::Tab)))),
        // Which of the two a terminal sends for the key is a matter of taste.
        0x08 | 0x7f => Some((1, key(Key::plain(Code::Backspace)))),
        0 => Some((1, key(Key::ctrl(' ')))),
        0x01..=0x1a => Some((1, key(Key::ctrl((first + 0x60) as char)))),
        0x1c..0x20 => Some((1, key(Key::plain(Code::Other)))),
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
    let held = |code| {
        let held = number(1).saturating_sub(1);
        key(Key { code, shift: held & 1 != 0, alt: held & 2 != 0, ctrl: held & 4 != 0 })
    };
    let token = match last {
        b'M' | b'm' if parameters.starts_with(b"<") => {
            let button = std::str::from_utf8(&parameters[1..]).ok().and_then(|t| t.split(';').next()?.parse().ok());
            mouse(button.unwrap_or(RELEASED), number(1), number(2), last == b'M')
        }
        // The old form, from terminals that do not know the new one: three bytes follow.
        b'M' if parameters.is_empty() => {
            let [button, column, row] = *bytes.get(length..length + 3)?.first_chunk()?;
            let position = |byte: u8| u16::from(byte).saturating_sub(32);
            return Some((length + 3, mouse(position(button), position(column), position(row), true)));
        }
        b'R' if parameters.contains(&b';') => Token::Input(Input::CursorColumn(number(1))),
        b'~' if parameters == b"200" => Token::PasteStart,
        b'Z' => key(Key::shift(Code::Tab)),
        b'~' => held(match number(0) {
            1 | 7 => Code::Home,
            3 => Code::Delete,
            4 | 8 => Code::End,
            5 => Code::PageUp,
            6 => Code::PageDown,
            _ => Code::Other,
        }),
        b'A'..=b'D' | b'F' | b'H' => held(cursor_key(last)),
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
        b'F' => Code::End,
        b'H' => Code::Home,
        _ => Code::Other,
    }
}

/// No button: what a release of one is reported as.
const RELEASED: u16 = 3;

/// A report of the mouse; columns and rows are from 1.
fn mouse(button: u16, column: u16, row: u16, pressed: bool) -> Token {
    const MOVED: u16 = 32;
    const HELD: u16 = 4 | 8 | 16;
    let action = match button & !HELD {
        0 => MouseAction::Press,
        64 => MouseAction::WheelUp,
        65 => MouseAction::WheelDown,
        // Other buttons, releases and moves mean nothing here.
        _ => return Token::Nothing,
    };
    if !pressed || button & MOVED != 0 || column == 0 || row == 0 {
        return Token::Nothing;
    }
    Token::Input(Input::Mouse(Mouse { column: column - 1, row: row - 1, action, held: button & HELD != 0 }))
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
        let table: [(&[u8], Key); 24] = [
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
            (b"\t", Key::plain(Code::Tab)),
            (b"\x1b[Z", Key::shift(Code::Tab)),
            (b"\x7f", Key::plain(Code::Backspace)),
            (b"\x08", Key::plain(Code::Backspace)),
            (b"\x1b[3~", Key::plain(Code::Delete)),
            (b"\x1b[H", Key::plain(Code::Home)),
            (b"\x1bOF", Key::plain(Code::End)),
            (b"\x1b[1~", Key::plain(Code::Home)),
            (b"\x1b[5~", Key::plain(Code::PageUp)),
            (b"\x1b[6;2~", Key::shift(Code::PageDown)),
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
    fn pasted_text_is_text_and_does_not_act() {
        let pasted = Input::Pasted("qqq\x1b[A\r".into());
        assert_eq!(decode(b"\x1b[200~qqq\x1b[A\r\x1b[201~x"), [pasted, Input::Key(Key::char('x'))]);
        let long = [b"\x1b[200~".to_vec(), vec![b'a'; 10_000], PASTE_END.to_vec()].concat();
        assert!(matches!(&decode(&long)[..], [Input::Pasted(text)] if text.len() == LONGEST_PASTE));
    }

    #[test]
    fn clicks_and_wheels_are_told_and_releases_are_not() {
        let at = |column, row, action, held| Input::Mouse(Mouse { column, row, action, held });
        assert_eq!(decode(b"\x1b[<0;1;1M\x1b[<0;1;1m"), [at(0, 0, MouseAction::Press, false)]);
        assert_eq!(decode(b"\x1b[<16;200;60M"), [at(199, 59, MouseAction::Press, true)]);
        assert_eq!(decode(b"\x1b[<64;5;6M"), [at(4, 5, MouseAction::WheelUp, false)]);
        assert_eq!(decode(b"\x1b[<69;5;6M"), [at(4, 5, MouseAction::WheelDown, true)]);
        // The old form, whose bytes must not be taken for typing.
        assert_eq!(decode(b"\x1b[M !#\x1b[M#!#"), [at(0, 2, MouseAction::Press, false)]);
        for rubbish in
            [&b"\x1b[<2;3;4M"[..], b"\x1b[<35;3;4M", b"\x1b[<0;0;4M", b"\x1b[<;;M", b"\x1b[<M", b"\x1b[<32;3;4M"]
        {
            assert_eq!(decode(rubbish), [], "{rubbish:?}");
        }
    }

    #[test]
    fn an_escape_is_told_from_a_sequence_by_time_and_the_rest_of_a_late_one_is_no_typing() {
        let escape = Input::Key(Key::plain(Code::Escape));
        let mut decoder = Decoder::default();
        assert_eq!(decoder.push(b"\x1b"), []);
        assert!(decoder.is_waiting());
        assert_eq!(decoder.push(b"[A"), [Input::Key(Key::plain(Code::Up))]);
        assert_eq!(decoder.push(b"\x1b"), []);
        assert_eq!(decoder.flush(), Some(escape));
        assert!(!decoder.is_waiting());
        assert_eq!(decoder.push(b"[A"), [Input::Key(Key::plain(Code::Up))]);
        // Typed after Escape, one by one.
        decoder.push(b"\x1b");
        decoder.flush();
        assert_eq!(decoder.push(b"["), [Input::Key(Key::char('['))]);
        assert_eq!(decoder.push(b"A"), [Input::Key(Key::char('A'))]);
    }

    #[test]
    fn any_split_of_the_stream_gives_the_same_keys() {
        let stream = "q\x1b[A\x1b[1;2D€\x1b[2;3R\x1b[200~rubbish\x1b[201~\x1bOC\x1b[<0;12;7M\x1b[M !!\x03ö ".as_bytes();
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
