//! Mistakes in the TOML itself: what the TOML parser says, in words for people who only want to write a scene, and
//! without the errors that merely follow from an earlier one.

use super::nearest::quoted;
use super::report::{Report, Words};
use super::{LIGHT, MATERIAL, OBJECT, REPEATED, Span, Toml, key_of};
use toml::de::{DeTable, DeValue, Error};

/// Adds the parser's `errors`, and removes the mistakes of the report that may be consequences of them.
pub(super) fn check<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>, errors: &[Error]) {
    let text = report.text;
    let mut errors: Vec<(Span, &str)> =
        errors.iter().map(|error| (error.span().unwrap_or(0..0), error.message())).collect();
    errors.sort_by_key(|(span, _)| span.start);

    // Nothing after an array or a table that is never closed is what it seems.
    let unclosed = errors
        .iter()
        .find(|(_, message)| message.starts_with("unclosed array,") || message.starts_with("unclosed inline table,"))
        .and_then(|(end, _)| root.values().filter_map(|value| opening(text, value, end.start)).min());
    if let Some(open) = unclosed {
        let (what, close) =
            if slice(text, &(open..text.len())).starts_with('[') { ("array", "]") } else { ("table", "}") };
        report.syntax(open..line_around(text, open).end, move || {
            Words::new(format!("this {what} is not closed"), format!("the {close} is missing"))
        });
    }
    let readable = unclosed.unwrap_or(text.len());

    let mut doubtful: Vec<Span> = Vec::new();
    let mut told = None;
    let mut again: Option<Span> = None;
    for (span, message) in errors {
        let line = line_around(text, span.start);
        let is_duplicate = message == "duplicate key";
        let section = is_title(slice(text, &line)).then(|| section_around(text, &line));
        // One error is told of a line, and what stands below a title that is given again was given before, too.
        let follows = told == Some(line.start)
            || is_duplicate && again.as_ref().is_some_and(|section| section.contains(&span.start));
        if span.start >= readable || follows {
            continue;
        }
        if is_duplicate {
            let key = span.clone();
            let is_list = section.is_some() && REPEATED.into_iter().any(|title| key_of(title) == slice(text, &key));
            again = section.or(again);
            // That [light] should be [[light]] is told already.
            if !is_list {
                report.mistake(span, move || duplicate(text, key));
            }
        } else {
            told = Some(line.start);
            doubtful.push(section.unwrap_or(line.start..line.end + 1));
            let (message, at) = (message.to_owned(), span.clone());
            report.syntax(span, move || words(text, at, &message));
        }
    }
    if !doubtful.is_empty() || unclosed.is_some() {
        // Values that the parser made up have no extent.
        let doubtful = |at: usize| at >= readable || doubtful.iter().any(|lines| lines.contains(&at));
        report.doubt(|span| span.is_empty() || doubtful(span.start));
    }
}

/// Where the array or inline table begins that is still open at `end`; of nested ones the outermost.
fn opening(text: &str, toml: &Toml<'_>, end: usize) -> Option<usize> {
    let span = toml.span();
    let is_open = |bracket| span.start < end && end <= span.end && slice(text, &span).starts_with(bracket);
    match toml.get_ref() {
        DeValue::Array(_) if is_open('[') => Some(span.start),
        DeValue::Table(_) if is_open('{') => Some(span.start),
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
    let at = text.floor_char_boundary(at);
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

fn duplicate(text: &str, span: Span) -> Words {
    let title = slice(text, &line_around(text, span.start)).trim();
    let key = quoted(slice(text, &span));
    if is_title(title) {
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
    if ["//", ";", "--", "/*"].iter().any(|mark| content.starts_with(mark)) {
        return Words::new("this is not a line of a scene", "a comment begins with #");
    }
    let (problem, expected) = message.split_once(", expected ").unwrap_or((message, ""));
    match problem {
        "string values must be quoted" => unquoted(slice(text, &line), before, found),
        "key with no value" | "missing value for key" | "invalid unquoted key"
            if before.contains(':') || found == ":" =>
        {
            Words::new("a key and its value are divided by =", "not by a colon").help("write key = value")
        }
        "key with no value" | "missing value for key" => {
            Words::new("a key needs a value", "= is missing here").help("write key = value")
        }
        "missing value" => Words::new("a key needs a value", "the value is missing"),
        "invalid unquoted key" => Words::new("this cannot stand in a key", "letters, digits, _ and - can"),
        "unclosed table" | "unclosed array table" => {
            let close = if content.starts_with("[[") { "]]" } else { "]" };
            Words::new("the title of the section is not closed", format!("{close} is missing"))
                .help(format!("titles: [film], .., and {LIGHT}, {MATERIAL}, {OBJECT}"))
        }
        "unquoted keys cannot be empty" => Words::new("a name is missing", "here"),
        "missing comma between array elements" | "missing comma between key-value pairs" => {
            Words::new("a comma is missing", "write , before this")
        }
        "invalid basic string" | "invalid literal string" if expected.len() <= 3 => {
            Words::new("the string is not closed", "the quote is missing")
        }
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
        "invalid float" | "invalid integer" | "invalid number" => Words::new("this is not a number", "wrong from here"),
        "unexpected key or value" => Words::new("there is more than one value", "a new line must begin before this"),
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
    if found.contains(' ') && found.split_whitespace().all(is_number) {
        return Words::new("a comma is missing", "numbers of an array are divided by commas");
    }
    if found.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) {
        return Words::new("this is not a number", "nor is it a string, without quotes");
    }
    if found.contains(['"', '\\', '\'']) {
        return Words::new(message, "a quote is missing");
    }
    Words::new(message, format!("write \"{}\"", quoted(found).trim_matches('`')))
}
