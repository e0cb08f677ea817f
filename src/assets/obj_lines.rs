//! The lines and words of OBJ and MTL text, as people and exporters really write them: byte order mark, CRLF or lone
//! CR, tabs, blanks at either end, comments, lines continued with `\`, bytes that are no UTF-8.

use super::AssetError;
use std::io::BufRead;
use std::path::Path;

/// One logical line: continued lines are joined. Neither part has blanks at its ends; the keyword is not empty.
pub(super) struct Line<'a> {
    /// Number of its first physical line, from 1.
    pub number: usize,
    /// The first word.
    pub keyword: &'a [u8],
    /// The rest, comment included.
    pub rest: &'a [u8],
}

/// Deals out logical lines that are not empty and not comments.
#[derive(Clone)]
pub(super) struct Lines<'a> {
    text: &'a [u8],
    /// Physical lines before `text`.
    pub number: usize,
    separator: u8,
    joined: Vec<u8>,
}

impl<'a> Lines<'a> {
    /// Lines of a file's bytes; refuses what is no text.
    pub fn new(file: &Path, bytes: &'a [u8]) -> Result<Self, AssetError> {
        let refuse = |reason: &str| Err(AssetError::new(file, None, reason));
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return refuse("is UTF-16; save it as UTF-8");
        }
        if bytes.iter().take(4096).any(|&b| b == 0) {
            return refuse("is not a text file");
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let separator = if !text.contains(&b'\n') && text.contains(&b'\r') { b'\r' } else { b'\n' };
        Ok(Self { text, number: 0, separator, joined: Vec::new() })
    }

    /// Parts of about `size` bytes, cut where a logical line ends, each numbered from its own first line.
    pub fn parts(mut self, size: usize) -> Vec<Self> {
        let mut parts = Vec::new();
        while !self.text.is_empty() {
            let whole = self.text;
            // The line that the cut falls into, and all that it goes on in.
            self.text = &whole[whole.len().min(size)..];
            self.physical();
            while self.physical().is_some_and(|line| trim(line).ends_with(b"\\")) {}
            let part = &whole[..whole.len() - self.text.len()];
            parts.push(Self { text: part, number: 0, separator: self.separator, joined: Vec::new() });
        }
        parts
    }

    /// The next logical line. It borrows from `self` because joined lines stand in a buffer.
    pub fn next(&mut self) -> Option<Line<'_>> {
        loop {
            let line = trim(self.physical()?);
            let number = self.number;
            match line.first() {
                None | Some(b'#') => continue,
                Some(_) if !continues(line) => return Some(split(number, line)),
                Some(_) => {}
            }
            let mut part = line;
            self.joined.clear();
            while continues(part) {
                self.joined.extend_from_slice(&part[..part.len() - 1]);
                self.joined.push(b' ');
                part = trim(self.physical().unwrap_or_default());
            }
            self.joined.extend_from_slice(part);
            // A lone backslash joins nothing.
            if !trim(&self.joined).is_empty() {
                return Some(split(number, trim(&self.joined)));
            }
        }
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.text.is_empty() {
            return None;
        }
        self.number += 1;
        let text = self.text;
        // The way to the C library's search: a third less than a loop over the bytes.
        let length = self.text.skip_until(self.separator).unwrap_or(text.len());
        let line = &text[..length];
        Some(line.strip_suffix(&[self.separator]).unwrap_or(line))
    }
}

/// Whether a trimmed line goes on in the next. A backslash that ends a comment does not count.
fn continues(line: &[u8]) -> bool {
    line.ends_with(b"\\") && without_comment(line).len() == line.len()
}

fn split(number: usize, line: &[u8]) -> Line<'_> {
    let end = line.iter().position(|&b| is_blank(b)).unwrap_or(line.len());
    let (keyword, rest) = line.split_at(end);
    Line { number, keyword, rest: trim(rest) }
}

pub(super) fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// `text` without blanks at its ends.
pub(super) fn trim(mut text: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = text
        && is_blank(*first)
    {
        text = rest;
    }
    while let [rest @ .., last] = text
        && is_blank(*last)
    {
        text = rest;
    }
    text
}

/// `text` up to a `#` that stands first or after a blank (names may contain one), trimmed.
pub(super) fn without_comment(text: &[u8]) -> &[u8] {
    let starts = |&at: &usize| text[at] == b'#' && (at == 0 || is_blank(text[at - 1]));
    trim((0..text.len()).find(starts).map_or(text, |at| &text[..at]))
}

/// The words of a line of numbers. A `#` ends them, at the start of a word or within, but not after a point, where it
/// is the `1.#INF` of old C libraries.
pub(super) struct Words<'a>(pub &'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let mut start = 0;
        while start < self.0.len() && is_blank(self.0[start]) {
            start += 1;
        }
        let text = &self.0[start..];
        let mut end = 0;
        while end < text.len() && !is_blank(text[end]) {
            if text[end] == b'#' && (end == 0 || text[end - 1] != b'.') {
                self.0 = &[];
                return (end > 0).then(|| &text[..end]);
            }
            end += 1;
        }
        self.0 = &text[end..];
        (end > 0).then(|| &text[..end])
    }
}

/// Whether a word is a number in plain notation of a size that f32 holds: what nearly every number in a model is, and
/// a shape that every parser reads alike.
#[inline]
fn is_plain(word: &[u8]) -> bool {
    let digits = match word {
        [b'-' | b'+', rest @ ..] => rest,
        _ => word,
    };
    let (mut before, mut after, mut point) = (0, 0, false);
    for &b in digits {
        match b {
            b'0'..=b'9' if point => after += 1,
            b'0'..=b'9' => before += 1,
            b'.' if !point => point = true,
            _ => return false,
        }
    }
    before <= 30 && before + after > 0
}

/// Whether `text` is nothing but `count` numbers as of [`is_plain`] with single blanks between: what most lines are,
/// and need not be taken apart. Some of them are not found to be.
pub(super) fn are_plain(text: &[u8], count: usize) -> bool {
    let (mut words, mut start) = (1, true);
    let (mut before, mut after, mut point) = (0, 0, false);
    for &b in text {
        match b {
            b'0'..=b'9' if point => after += 1,
            b'0'..=b'9' => before += 1,
            b'.' if !point => point = true,
            b'-' if start => {}
            b' ' if before <= 30 && before + after > 0 => {
                words += 1;
                (before, after, point) = (0, 0, false);
            }
            _ => return false,
        }
        start = b == b' ';
    }
    words == count && before <= 30 && before + after > 0
}

/// Whether a word is a number whatever its size, nan and inf included.
pub(super) fn parse_number(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Checks that a word is a finite number within the range of f32; says what is wrong if not.
#[inline]
pub(super) fn check_number(word: &[u8]) -> Result<(), String> {
    if is_plain(word) { Ok(()) } else { check_odd_number(word) }
}

#[cold]
fn check_odd_number(word: &[u8]) -> Result<(), String> {
    let shown = lossy(word);
    match parse_number(word) {
        Some(v) if v.abs() <= f64::from(f32::MAX) => Ok(()),
        Some(v) if v.is_finite() => Err(format!("`{shown}` is too large (at most 3.4e38)")),
        Some(_) => Err(format!("`{shown}` is not a finite number")),
        None if word.contains(&b',') => Err(format!("`{shown}` is not a number (write a decimal point, not a comma)")),
        None => Err(format!("`{shown}` is not a number")),
    }
}

/// Text of a word or name for people, at most some 80 characters of it.
pub(super) fn lossy(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    match text.char_indices().nth(80) {
        Some((at, _)) => format!("{}...", &text[..at]),
        None => text.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8]) -> Vec<(usize, String, String)> {
        let mut lines = Lines::new(Path::new("x"), text).expect("text");
        let mut found = Vec::new();
        while let Some(l) = lines.next() {
            found.push((l.number, lossy(l.keyword), lossy(l.rest)));
        }
        found
    }

    #[test]
    fn lines_are_joined_trimmed_and_numbered() {
        let text = b"\xef\xbb\xbf# note \\\r\n\tv 1 2\\\r\n 3  \r\n\r\nf\n\\\n\\\n\nusemtl a b # x \\\n l 1 \\";
        let expected = [(2, "v", "1 2 3"), (5, "f", ""), (9, "usemtl", "a b # x \\"), (10, "l", "1")];
        let found = all(text);
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            assert_eq!((f.0, f.1.as_str(), f.2.as_str()), e);
        }
        assert_eq!(all(b"v 1\rv 2\r").len(), 2, "lone CR");
    }

    #[test]
    fn parts_of_any_size_hold_the_same_lines() {
        for text in ["v 1\nv 2 \\\n 3 \\ \n\\\n4\n\n# note \\\nf\n\\\n\\", "v 1\r\nv \\\r\n2\r\nf 3", "a\\\r\r\rb\rc"] {
            let whole = Lines::new(Path::new("x"), text.as_bytes()).expect("text");
            for size in 0..text.len() + 2 {
                let (mut found, mut before) = (Vec::new(), 0);
                for mut part in whole.clone().parts(size) {
                    while let Some(l) = part.next() {
                        found.push((before + l.number, lossy(l.keyword), lossy(l.rest)));
                    }
                    before += part.number;
                }
                assert_eq!(found, all(text.as_bytes()), "{text:?} by {size}");
            }
        }
    }

    #[test]
    fn words_end_at_a_comment_and_plain_numbers_are_what_the_standard_parser_reads() {
        let words: Vec<_> = Words(b" 1 -2.5\t3#note 4").map(lossy).collect();
        assert_eq!(words, ["1", "-2.5", "3"]);
        assert_eq!(Words(b"1 -1.#IND").map(lossy).collect::<Vec<_>>(), ["1", "-1.#IND"]);
        for good in ["1", "-1.5", "+.5", "5.", "1e38", "-3E+2", "1e-400"] {
            assert_eq!(check_number(good.as_bytes()), Ok(()), "{good}");
            assert!(good.parse::<f64>().is_ok());
        }
        for (good, count) in [("1 -2.5 .3", 3), ("-0.", 1)] {
            assert!(are_plain(good.as_bytes(), count));
            assert!(good.split(' ').all(|word| is_plain(word.as_bytes())));
        }
        for bad in ["", "1 2", "1 2 3 4", "1 2  3", "1 2 -", "1 . 3", "1 2 3-", "1 2 1e3", "1 2 3 ", " 1 2 3", "1\t2 3"]
        {
            assert!(!are_plain(bad.as_bytes(), 3), "{bad}");
        }
        for bad in ["", ".", "-", "+-1", "1.2.3", "nan", "-inf", "1e39", "1,5", "0x10", "1.#INF", "١"] {
            assert!(check_number(bad.as_bytes()).is_err(), "{bad}");
        }
    }
}
