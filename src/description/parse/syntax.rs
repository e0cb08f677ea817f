//! Mistakes in the TOML itself: what the TOML parser says, in words for people who only want to write a scene, and
//! without the errors that merely follow from an earlier one.

use super::nearest::quoted;
use super::report::{Report, Words};
use super::{REPEATED, Span, Toml, key_of, titles};
use crate::description::diagnostic::char_boundary;
use toml::de::{DeTable, DeValue, Error};

/// Adds the parser's `errors`, and removes the mistakes of the report that may be consequences of them.
pub(super) fn check<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>, errors: &[Error]) {
    let text = report.text;
    let mut errors: Vec<(Span, &str)> =
        errors.iter().map(|error| (error.span().unwrap_or(0..0), error.message())).collect();
    errors.sort_by_key(|(span, _)| span.start);

    // Nothing after a value that is never closed is what it seems.
    let unclosed = errors
        .iter()
        .find(|(_, message)| UNCLOSED.iter().any(|start| message.starts_with(start)))
        .and_then(|(end, _)| root.values().filter_map(|value| opening(text, value, end.start)).min());
    if let Some((open, what, close)) = unclosed {
        report.syntax(open..line_around(text, open).end, move || {
            Words::new(format!("this {what} is not closed"), format!("the {close} is missing"))
        });
    }
    let readable = unclosed.map_or(usize::MAX, |(open, ..)| open);

    // Among thousands of errors only the first are of use.
    errors.truncate(LOOKED_AT);
    let mut doubtful: Vec<Span> = Vec::new();
    let mut told: Option<Span> = None;
    let mut again: Option<Span> = None;
    for (span, message) in errors {
        // One error is told of a line.
        if span.start >= readable || told.as_ref().is_some_and(|line| (line.start..=line.end).contains(&span.start)) {
            continue;
        }
        let line = line_around(text, span.start);
        let is_duplicate = message == "duplicate key";
        let section = is_title(slice(text, &line)).then(|| section_around(text, &line));
        if is_duplicate {
            // What stands below a title that is given again was given before, too.
            if again.as_ref().is_some_and(|section| section.contains(&span.start)) {
                continue;
            }
            // That [light] should be [[light]] is told already.
            let key = slice(text, &span);
            let is_list = REPEATED.into_iter().any(|title| key_of(title) == key);
            if !(is_list && root.get(key).is_some_and(|value| value.get_ref().is_table())) {
                let at = span.clone();
                report.mistake(span, move || duplicate(text, at));
            }
            again = section.or(again);
        } else {
            told = Some(line.clone());
            doubtful.push(section.unwrap_or(line.start..line.end + 1));
            if let Some(comment) = foreign_comment(text, &line) {
                report.syntax(comment, || Words::new("this is not a line of a scene", "a comment begins with #"));
            } else {
                let (message, at) = (message.to_owned(), span.clone());
                report.syntax(span, move || words(text, at, &message));
            }
        }
    }
    if !doubtful.is_empty() || unclosed.is_some() {
        // Values that the parser made up have no extent.
        let doubtful = |at: usize| at >= readable || doubtful.iter().any(|lines| lines.contains(&at));
        report.doubt(|span| span.is_empty() || doubtful(span.start));
    }
}

/// Most errors of the parser that are looked at.
const LOOKED_AT: usize = 1000;

/// How the parser's messages begin where a value of many lines has no end.
const UNCLOSED: [&str; 4] = [
    "unclosed array,",
    "unclosed inline table,",
    "invalid multi-line basic string, expected `\"`",
    "invalid multi-line literal string, expected `'`",
];

/// Where a value begins that is still open at `end`, or ends without its bracket; what it is, and what would close it.
/// Of nested ones the outermost.
fn opening(text: &str, toml: &Toml<'_>, end: usize) -> Option<(usize, &'static str, &'static str)> {
    let span = toml.span();
    let content = slice(text, &span);
    let is_open = |from: &str, to: &str| {
        content.starts_with(from) && (span.end == end || span.contains(&end) || !content.ends_with(to))
    };
    match toml.get_ref() {
        DeValue::Array(_) if is_open("[", "]") => Some((span.start, "array", "]")),
        DeValue::Table(_) if is_open("{", "}") => Some((span.start, "table", "}")),
        DeValue::String(_) if span.end == end && content.starts_with("\"\"\"") => {
            Some((span.start, "string", "\"\"\""))
        }
        DeValue::String(_) if span.end == end && content.starts_with("'''") => Some((span.start, "string", "'''")),
        DeValue::Array(array) => array.iter().find_map(|element| opening(text, element, end)),
        DeValue::Table(table) => table.values().find_map(|value| opening(text, value, end)),
        _ => None,
    }
}

/// The bytes `span` of the text; nothing if they are not whole characters.
fn slice<'t>(text: &'t str, span: &Span) -> &'t str {
    text.get(span.clone()).unwrap_or_default()
}

/// The line about the byte `at`, without its newline.
fn line_around(text: &str, at: usize) -> Span {
    let at = char_boundary(text, at);
    let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    start..text[at..].find('\n').map_or(text.len(), |newline| at + newline)
}

/// Whether a line begins as `[section]` or `[[section]]` does, and not as a row of numbers.
fn is_title(line: &str) -> bool {
    let line = line.trim_start();
    let inner = line.trim_start_matches(['[', ' ', '\t']);
    line.starts_with('[') && !inner.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | '#'))
}

/// From the title in `line` to the next title.
fn section_around(text: &str, line: &Span) -> Span {
    let mut end = line.end;
    for below in slice(text, &(line.end..text.len())).split_inclusive('\n').skip(1) {
        if is_title(below) {
            break;
        }
        end += below.len();
    }
    line.start..end + 1
}

/// What is a comment in other languages, if the line begins as one.
fn foreign_comment(text: &str, line: &Span) -> Option<Span> {
    let content = slice(text, line).trim_start();
    let is_comment = ["//", "/*", "--", ";"].iter().any(|mark| content.starts_with(mark));
    is_comment.then(|| line.end - content.len()..line.end)
}

fn duplicate(text: &str, span: Span) -> Words {
    let title = slice(text, &line_around(text, span.start)).trim();
    let key = quoted(slice(text, &span));
    if title.starts_with("[[") {
        Words::new(format!("{key} is given in two ways"), "it has a value already")
            .help("begin every one with a title like this, and remove the other value")
    } else if is_title(title) {
        Words::new(format!("the section {} stands twice", quoted(title)), "it began further up")
            .help("put all its keys below the first title")
    } else {
        Words::new(format!("{key} is given twice"), "it has a value already").help("remove one of the two")
    }
}

/// What the parser means by `message`, at the bytes `span`.
fn words(text: &str, span: Span, message: &str) -> Words {
    let line = line_around(text, span.start);
    let (before, content) = (slice(text, &(line.start..span.start)).trim(), slice(text, &line).trim());
    let found = slice(text, &(span.start..span.end.min(line.end))).trim();
    let (problem, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    match problem {
        "string values must be quoted" => unquoted(slice(text, &line), before, found),
        _ if slice(text, &(span.start..text.len())).starts_with(':') => {
            Words::new("a key and its value are divided by =", "not by a colon").help("write key = value")
        }
        "key with no value" | "missing value for key" => {
            Words::new("a key needs a value", "= is missing here").help("write key = value")
        }
        "extra `=`" => Words::new("one = is enough", "remove this"),
        "missing assignment between key-value pairs" => Words::new("a key needs a value", "= is missing here"),
        "missing value" => Words::new("a key needs a value", "the value is missing"),
        "invalid unquoted key" => Words::new("this cannot stand in a key", "letters, digits, _ and - can"),
        "unclosed table" | "unclosed array table" => {
            let close = if content.starts_with("[[") { "]]" } else { "]" };
            Words::new("the title of the section is not closed", format!("{close} is missing"))
                .help(format!("titles: {}", titles().collect::<Vec<_>>().join(", ")))
        }
        "unquoted keys cannot be empty" => Words::new("a name is missing", "here"),
        "missing comma between array elements" | "missing comma between key-value pairs" => {
            Words::new("a comma is missing", "write , before this")
        }
        "invalid basic string" | "invalid literal string" if expected.len() <= 3 => {
            Words::new("the string is not closed", "the quote is missing")
        }
        "invalid basic string" | "invalid literal string" => Words::new("a control character in a string", "remove it"),
        "missing escaped value"
        | "invalid escape sequence"
        | "invalid unicode 4-digit hex code"
        | "invalid unicode 8-digit hex code" => {
            Words::new("a backslash in a string begins an escape", "unknown escape")
                .help("divide directories by /, and write \\\\ for a backslash that is meant")
        }
        "unexpected leading zero" => Words::new("this is not a number", "a number must not begin with 0"),
        "invalid mantissa" => Words::new("this is not a number", "a digit is missing before or after the point")
            .help("write 0.5 for .5 and 1.0 for 1."),
        "invalid exponent" => Words::new("this is not a number", "digits are missing after the e"),
        "invalid float" | "invalid integer" if found.contains('=') => {
            Words::new("a line holds one key and one value", "a new line must begin here")
        }
        "invalid float" | "invalid integer" => Words::new("this is not a number", "wrong from here"),
        "unexpected key or value" if slice(text, &(span.start..text.len())).starts_with(',') => {
            Words::new("several numbers need brackets", "write [1, 2, 3]")
        }
        "unexpected key or value" => {
            Words::new("a line holds one key and one value", "a new line must begin before this")
        }
        "cannot recurse further; max recursion depth met" => {
            Words::new("arrays and tables are nested too deeply", "no scene needs so many")
        }
        "invalid comment character" => Words::new("a control character in a comment", "remove it"),
        _ => Words::new(
            format!("not TOML: {problem}"),
            if expected.is_empty() { String::new() } else { format!("expected {expected}") },
        ),
    }
}

/// A value that is no number and has no quotes, `found` in `line` after `before`.
fn unquoted(line: &str, before: &str, found: &str) -> Words {
    let message = "a string must stand in quotes";
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    if found.is_empty() || found.starts_with('#') {
        let value = line.split_once('#').map_or("", |(_, comment)| comment);
        let hex = value.split_whitespace().next().unwrap_or_default();
        let words = Words::new("a key needs a value", "the value is missing");
        return if before.ends_with('=') && matches!(hex.len(), 3 | 6) && hex.chars().all(|c| c.is_ascii_hexdigit()) {
            words.help(format!("a # outside of quotes begins a comment; write \"#{hex}\""))
        } else {
            words
        };
    }
    if found.starts_with(['“', '”', '‘', '’', '„', '«', '`']) {
        return Words::new(message, "these are other quotes").help("write \" before and after");
    }
    let is_many = found.contains([' ', ',']) && found.split([' ', ',']).filter(|word| !word.is_empty()).all(is_number);
    if is_many && line.contains('[') {
        return Words::new("a comma is missing", "numbers of an array are divided by commas");
    }
    if is_many {
        return Words::new("several numbers need brackets", "write [1, 2, 3]");
    }
    if found.starts_with('(') {
        return Words::new("an array stands in square brackets", "write [1, 2, 3]");
    }
    if found.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) {
        return Words::new("this is not a number", "only digits, a point and an exponent; strings need quotes");
    }
    if found.contains(['"', '\\', '\'']) {
        return Words::new(message, "a quote is missing");
    }
    Words::new(message, format!("write \"{}\"", quoted(found).trim_matches('`')))
}
