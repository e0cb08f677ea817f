//! The list of mistakes found so far.

use super::Span;
use crate::description::Diagnostic;
use std::path::Path;

/// How many mistakes are told one by one.
const SHOWN: usize = 20;

/// The text being parsed and the mistakes in it. What a mistake says is worked out only if it is among those told.
pub(super) struct Report<'a> {
    pub text: &'a str,
    pub file: &'a Path,
    mistakes: Vec<Mistake<'a>>,
}

struct Mistake<'a> {
    span: Span,
    certainty: Certainty,
    tell: Box<dyn FnOnce() -> Words + 'a>,
}

/// Whether a mistake is one even if other parts of the text could not be read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Certainty {
    /// It shows in the underlined text alone.
    Alone,
    /// It shows only together with the rest.
    Together,
    /// It is what could not be read.
    Syntax,
}

/// What a mistake says.
pub(super) enum Words {
    /// About the underlined text.
    Here { message: String, label: String, help: Option<String> },
    /// About another file, which the underlined text names.
    Elsewhere(Diagnostic),
}

impl Words {
    pub fn new(message: impl Into<String>, label: impl Into<String>) -> Self {
        Words::Here { message: message.into(), label: label.into(), help: None }
    }

    pub fn help(mut self, advice: impl Into<String>) -> Self {
        if let Words::Here { help, .. } = &mut self {
            *help = Some(advice.into());
        }
        self
    }
}

impl<'a> Report<'a> {
    pub fn new(text: &'a str, file: &'a Path) -> Self {
        Self { text, file, mistakes: Vec::new() }
    }

    /// A mistake in the bytes `span` of the text, whatever stands elsewhere.
    pub fn mistake(&mut self, span: Span, tell: impl FnOnce() -> Words + 'a) {
        self.mistakes.push(Mistake { span, certainty: Certainty::Alone, tell: Box::new(tell) });
    }

    /// Bytes `span` of the text that do not fit the rest of it: something is missing, or contradicts.
    pub fn conflict(&mut self, span: Span, tell: impl FnOnce() -> Words + 'a) {
        self.mistakes.push(Mistake { span, certainty: Certainty::Together, tell: Box::new(tell) });
    }

    /// Bytes `span` of the text that are no TOML.
    pub fn syntax(&mut self, span: Span, tell: impl FnOnce() -> Words + 'a) {
        self.mistakes.push(Mistake { span, certainty: Certainty::Syntax, tell: Box::new(tell) });
    }

    /// Number of mistakes so far.
    pub fn count(&self) -> usize {
        self.mistakes.len()
    }

    /// Where the text could not be read: forgets the mistakes that may follow from that, which are all conflicts, and
    /// the others whose place is `doubtful`.
    pub fn doubt(&mut self, doubtful: impl Fn(&Span) -> bool) {
        self.mistakes.retain(|mistake| match mistake.certainty {
            Certainty::Alone => !doubtful(&mistake.span),
            Certainty::Together => false,
            Certainty::Syntax => true,
        });
    }

    /// The mistakes in the order of the text; of many, the first ones and how many follow.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        let Self { text, file, mut mistakes } = self;
        mistakes.sort_by_key(|m| m.span.start);
        let rest = mistakes.split_off(SHOWN.min(mistakes.len()));
        let mut told: Vec<_> = mistakes
            .into_iter()
            .map(|mistake| match (mistake.tell)() {
                Words::Elsewhere(diagnostic) => diagnostic,
                Words::Here { message, label, help } => {
                    Diagnostic::new(file, text, mistake.span, &message, &label).with_help(help.as_deref())
                }
            })
            .collect();
        if let Some(next) = rest.first() {
            let message = match rest.len() {
                1 => "1 more mistake".to_owned(),
                many => format!("{many} more mistakes"),
            };
            told.push(Diagnostic::new(file, text, next.span.clone(), &message, "the next one is here"));
        }
        told
    }
}
