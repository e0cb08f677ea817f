//! Keys and their names.

use std::fmt;
use std::str::FromStr;

/// A key as every terminal can send it, tmux and screen included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    /// Tabulator; with Shift back.
    Tab,
    /// Takes the character before the cursor.
    Backspace,
    /// Takes the character at the cursor.
    Delete,
    /// To the beginning.
    Home,
    /// To the end.
    End,
    /// A screen up.
    PageUp,
    /// A screen down.
    PageDown,
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

/// Names of keys that are no characters: the one shown first, then what people may write.
const NAMES: &[(Code, &[&str])] = &[
    (Code::Char(' '), &["Space"]),
    (Code::Up, &["↑", "Up"]),
    (Code::Down, &["↓", "Down"]),
    (Code::Left, &["←", "Left"]),
    (Code::Right, &["→", "Right"]),
    (Code::Enter, &["Enter", "Return"]),
    (Code::Escape, &["Esc", "Escape"]),
    (Code::Tab, &["Tab"]),
    (Code::Backspace, &["Backspace"]),
    (Code::Delete, &["Delete", "Del"]),
    (Code::Home, &["Home"]),
    (Code::End, &["End"]),
    (Code::PageUp, &["PageUp", "PgUp"]),
    (Code::PageDown, &["PageDown", "PgDn"]),
];

impl fmt::Display for Key {
    /// As people write it: `q`, `Ctrl-C`, `Shift-←`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (set, name) in [(self.ctrl, "Ctrl-"), (self.alt, "Alt-"), (self.shift, "Shift-")] {
            if set {
                f.write_str(name)?;
            }
        }
        match (NAMES.iter().find(|(code, _)| *code == self.code), self.code) {
            (Some((_, names)), _) => f.write_str(names[0]),
            (None, Code::Char(c)) if self.ctrl => write!(f, "{}", c.to_ascii_uppercase()),
            (None, Code::Char(c)) => write!(f, "{c}"),
            (None, _) => f.write_str("?"),
        }
    }
}

impl FromStr for Key {
    type Err = String;

    /// What [`Key`] displays as, with the names of keys in any case: `ctrl-c`, `Shift-Left`, `PgUp`, `ö`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut key = Key::plain(Code::Other);
        let mut rest = text;
        loop {
            let held = [("ctrl-", &mut key.ctrl), ("alt-", &mut key.alt), ("shift-", &mut key.shift)];
            let found = held.into_iter().find(|(name, _)| {
                rest.len() > name.len() && rest.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name))
            });
            let Some((name, flag)) = found else { break };
            (*flag, rest) = (true, &rest[name.len()..]);
        }
        let named = NAMES.iter().find(|(_, names)| names.iter().any(|name| name.eq_ignore_ascii_case(rest)));
        let mut characters = rest.chars();
        key.code = match (named, characters.next(), characters.next()) {
            (Some((code, _)), ..) => *code,
            (None, Some(c), None) if key.ctrl => Code::Char(c.to_ascii_lowercase()),
            (None, Some(c), None) => Code::Char(c),
            _ => return Err("write it as q, Ctrl-R, Shift-Left, Enter, Space, Tab, Esc, PageUp".into()),
        };
        if key.shift && matches!(key.code, Code::Char(_)) {
            return Err("a character tells by itself whether Shift is held: write Q, not Shift-q".into());
        }
        Ok(key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_read_as_it_is_shown() {
        let codes = NAMES.iter().map(|(code, _)| *code).chain("aQ?ö:-".chars().map(Code::Char));
        for code in codes {
            for (ctrl, alt) in [(false, false), (true, false), (false, true)] {
                let shifts: &[bool] = if matches!(code, Code::Char(_)) { &[false] } else { &[false, true] };
                for &shift in shifts {
                    let key = Key { code, ctrl, alt, shift };
                    if ctrl && code == Code::Char('Q') {
                        continue;
                    }
                    assert_eq!(key.to_string().parse(), Ok(key), "{key}");
                }
            }
        }
        assert_eq!("shift-left".parse(), Ok(Key::shift(Code::Left)));
        assert_eq!("CTRL-R".parse(), Ok(Key::ctrl('r')));
        for wrong in ["", "Ctrl-", "qq", "Shift-q", "Hyper-x"] {
            assert!(wrong.parse::<Key>().is_err(), "{wrong}");
        }
    }
}
