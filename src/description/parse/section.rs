//! A table of the file, read key by key.

use super::nearest::{did_you_mean, list, quoted};
use super::report::{Report, Words};
use super::value::Value;
use super::{Span, Toml};
use toml::de::DeTable;

/// A table with a known set of keys.
pub(super) struct Section<'a> {
    /// As in the file, for messages: `[[light]]`.
    title: &'static str,
    /// Where it begins.
    pub span: Span,
    table: &'a DeTable<'a>,
    /// What it may be, and what it is.
    kinds: &'static [Kind],
    kind: Option<&'static Kind>,
}

/// What a section may be, and the keys that only this kind of it has.
pub(super) struct Kind {
    /// How the file says it.
    pub name: &'static str,
    /// With its article, for messages: "a directional light".
    pub noun: &'static str,
    pub keys: &'static [&'static str],
}

impl<'a> Section<'a> {
    /// The section in `toml`, if that is a table.
    pub fn of(title: &'static str, toml: &'a Toml<'a>) -> Option<Self> {
        let table = toml.get_ref().as_table()?;
        Some(Self { title, span: toml.span(), table, kinds: &[], kind: None })
    }

    /// The same, being a `kind` of `kinds`; `None` if it is not known which.
    pub fn with_kind(self, kinds: &'static [Kind], kind: Option<&'static Kind>) -> Self {
        Self { kinds, kind, ..self }
    }

    /// The value of a key, if the file has it.
    pub fn value(&self, key: &str) -> Option<Value<'a>> {
        let (key, toml) = self.table.get_key_value(key)?;
        Some(Value { key: key.get_ref(), toml, element: false })
    }

    /// Reads the value of a key; `None` if the file does not have it, or has it wrong.
    pub fn read<T>(&self, key: &str, read: impl FnOnce(Value<'a>) -> Option<T>) -> Option<T> {
        self.value(key).and_then(read)
    }

    /// The value of a key that the file must have. `form` shows how it is written.
    pub fn require(&self, report: &mut Report<'a>, key: &'static str, form: &'static str) -> Option<Value<'a>> {
        let found = self.value(key);
        if found.is_none() {
            let noun = self.noun();
            report.conflict(self.span.clone(), move || {
                Words::new(format!("{noun} needs `{key}`"), format!("`{key}` is missing")).help(form)
            });
        }
        found
    }

    /// Adds a mistake for every key that is not known. Beside the `common` ones a section has the keys of its kind; if
    /// that is not known, those of all its kinds.
    pub fn check_keys(&self, report: &mut Report<'a>, common: &'static [&'static str]) {
        let own = self.kind.map_or(&[][..], |kind| kind.keys);
        for key in self.table.keys() {
            let name: &'a str = key.get_ref();
            if common.contains(&name) || own.contains(&name) {
                continue;
            }
            let mut having = self.kinds.iter().filter(move |kind| kind.keys.contains(&name)).peekable();
            let (title, noun, kinds) = (self.title, self.noun(), self.kinds);
            match (having.peek(), self.kind) {
                (None, kind) => report.mistake(key.span(), move || {
                    let others = kinds.iter().filter(|_| kind.is_none()).flat_map(|kind| kind.keys);
                    let names = own.iter().chain(common).chain(others).copied();
                    Words::new(format!("{title} has no key {}", quoted(name)), did_you_mean(name, names, "not known"))
                        .help(keys_of(noun, own, common))
                }),
                (Some(_), Some(_)) => report.conflict(key.span(), move || {
                    let having: Vec<_> = having.map(|kind| kind.noun).collect();
                    let message = format!("`{name}` does not apply to {noun}");
                    Words::new(message, format!("only {} has it", having.join(" or "))).help(keys_of(noun, own, common))
                }),
                (Some(_), None) => {}
            }
        }
    }

    /// What this is, for messages.
    fn noun(&self) -> &'static str {
        self.kind.map_or(self.title, |kind| kind.noun)
    }
}

fn keys_of(noun: &str, own: &[&str], common: &[&str]) -> String {
    format!("keys of {noun}: {}", list(own.iter().chain(common).copied()))
}
