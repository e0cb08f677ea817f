//! Errors in scene files, shown with the offending text.

use super::printable;
use annotate_snippets::{AnnotationKind, Level, Origin, Renderer, Snippet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// One mistake in a scene file (or in a file of spheres): where it is, what it is, and what to do. All texts are
/// printable: control characters of the file are already replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The file with the mistake.
    pub file: PathBuf,
    /// From 1.
    pub line: usize,
    /// From 1, in characters; one past the last where something is missing at the end of the line.
    pub column: usize,
    /// What is wrong, in one line.
    pub message: String,
    /// What stands beside the underlined text; may be empty.
    pub label: String,
    /// What to do about it, in one line.
    pub help: Option<String>,
    /// The line of the file, tabs expanded, cut about `marked` if it is long.
    excerpt: String,
    /// Bytes of `excerpt` to underline.
    marked: Range<usize>,
}

/// Longest part of a line that is shown, in characters.
const EXCERPT: usize = 100;
/// How much of it may stand before the mistake, where the line must be cut.
const LEAD: usize = 40;

impl Diagnostic {
    /// A mistake at the bytes `span` of `text`, the content of `file`; any span will do, it is moved to whole
    /// characters and cut at the end of its first line.
    pub(super) fn new(file: &Path, text: &str, span: Range<usize>, message: &str, label: &str) -> Self {
        let start = char_boundary(text, span.start);
        let end = char_boundary(text, span.end).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let line = text[line_start..line_end].trim_end_matches('\r');
        let from = (start - line_start).min(line.len());
        let to = (end - line_start).clamp(from, line.len());
        let (excerpt, marked) = cut(line, from..to);
        Self {
            file: file.to_owned(),
            line: 1 + text[..line_start].matches('\n').count(),
            column: 1 + line[..from].chars().count(),
            message: printable(message).into_owned(),
            label: printable(label).into_owned(),
            help: None,
            excerpt,
            marked,
        }
    }

    /// The same with advice.
    pub(super) fn with_help(self, help: Option<&str>) -> Self {
        Self { help: help.map(|text| printable(text).into_owned()), ..self }
    }

    /// The mistake as compilers show it: message, file:line:column, the line with the mistake underlined, help. With
    /// escape sequences for a terminal if `color`. Ends without a newline.
    pub fn render(&self, color: bool) -> String {
        let path = self.file.to_string_lossy();
        let label = (!self.label.is_empty()).then_some(self.label.as_str());
        let group = Level::ERROR
            .primary_title(self.message.as_str())
            .element(Origin::path(printable(&path)).line(self.line).char_column(self.column))
            .element(
                Snippet::source(self.excerpt.as_str())
                    .line_start(self.line)
                    .annotation(AnnotationKind::Primary.span(self.marked.clone()).label(label)),
            )
            .elements(self.help.as_deref().map(|help| Level::HELP.message(help)));
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let rendered = renderer.render(&[group]);
        // The place stands apart from the excerpt, whose columns are not the file's; annotate-snippets takes the
        // excerpt for that of a second, nameless file and announces it in the fourth line.
        let announces = |(at, line): &(usize, &str)| *at == 3 && line.contains(":::");
        let lines: Vec<_> =
            rendered.lines().enumerate().filter(|line| !announces(line)).map(|(_, line)| line).collect();
        lines.join("\n")
    }
}

/// One line: `file:line:column: message (label)`.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.file.to_string_lossy();
        write!(f, "{}:{}:{}: {}", printable(&path), self.line, self.column, self.message)?;
        if self.label.is_empty() { Ok(()) } else { write!(f, " ({})", self.label) }
    }
}

impl std::error::Error for Diagnostic {}

/// The nearest beginning of a character at or before the byte `at`.
pub(super) fn char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0)
}

/// What is shown of `line`, and where the bytes `span` of the line are in it.
fn cut(line: &str, span: Range<usize>) -> (String, Range<usize>) {
    let first = match line[span.end..].char_indices().nth(EXCERPT) {
        None if line.chars().count() <= EXCERPT => 0,
        _ => line[..span.start].char_indices().rev().nth(LEAD - 1).map_or(0, |(at, _)| at),
    };
    let last = line[first..].char_indices().nth(EXCERPT).map_or(line.len(), |(at, _)| first + at);
    let show = |text: &str| printable(&text.replace('\t', "    ")).into_owned();
    let mut excerpt = String::new();
    if first > 0 {
        excerpt.push('…');
    }
    excerpt += &show(&line[first..span.start]);
    let start = excerpt.len();
    excerpt += &show(&line[span.start..span.end.min(last)]);
    let marked = start..excerpt.len();
    excerpt += &show(&line[span.end.min(last)..last]);
    if last < line.len() {
        excerpt.push('…');
    }
    (excerpt, marked)
}
