//! A table of the file, read key by key.

use super::nearest::{did_you_mean, list, quoted};
use super::report::{Report, Words};
use super::value::Value;
use super::{Span, Toml};
use toml::de::DeTable;

/// A table with a known set of keys.
pub(super) struct Section<'a> {
    /// With its article, for messages: "a light".
    noun: &'static str,
    /// Where it begins.
    pub span: Span,
    table: &'a DeTable<'a>,
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
    /// The table `toml`; a mistake if it is something else. `form` shows how such a table is written.
    pub fn open(
        report: &mut Report<'a>,
        key: &'a str,
        toml: &'a Toml<'a>,
        noun: &'static str,
        form: &'static str,
    ) -> Option<Self> {
        let table = toml.get_ref().as_table();
        if table.is_none() {
            Value { key, toml }.wrong_type(report, "a table", Some(form));
        }
        Some(Self { noun, span: toml.span(), table: table? })
    }

    /// The value of a key, if the file has it.
    pub fn value(&self, key: &str) -> Option<Value<'a>> {
        let (key, toml) = self.table.get_key_value(key)?;
        Some(Value { key: key.get_ref(), toml })
    }

    /// Reads the value of a key; `None` if the file does not have it, or has it wrong.
    pub fn read<T>(&self, key: &str, read: impl FnOnce(Value<'a>) -> Option<T>) -> Option<T> {
        self.value(key).and_then(read)
    }

    /// The value of a key that the file must have. `form` shows how it is written.
    pub fn require(&self, report: &mut Report<'a>, key: &'static str, form: &'static str) -> Option<Value<'a>> {
        let found = self.value(key);
        if found.is_none() {
            let noun = self.noun;
            report.mistake(self.span.clone(), move || {
                Words::new(format!("{noun} needs `{key}`"), format!("`{key}` is missing")).help(form)
            });
        }
        found
    }

    /// Adds a mistake for every key that is not known. Beside the `common` ones a section has the keys of its `kind`;
    /// if that is not known, those of all `kinds`.
    pub fn check_keys(
        &self,
        report: &mut Report<'a>,
        common: &'static [&'static str],
        kinds: &'static [Kind],
        kind: Option<&'static Kind>,
    ) {
        let own = kind.map_or(&[][..], |kind| kind.keys);
        for key in self.table.keys() {
            let name: &'a str = key.get_ref();
            if common.contains(&name) || own.contains(&name) {
                continue;
            }
            let mut having = kinds.iter().filter(move |kind| kind.keys.contains(&name)).peekable();
            match (having.peek(), kind) {
                (Some(_), None) => {}
                (Some(_), Some(kind)) => report.mistake(key.span(), move || {
                    let having: Vec<_> = having.map(|kind| kind.noun).collect();
                    let message = format!("`{name}` does not apply to {}", kind.noun);
                    Words::new(message, format!("only {} has it", having.join(" or ")))
                        .help(keys_of(kind.noun, common, kind.keys))
                }),
                (None, _) => {
                    let (noun, all) = (kind.map_or(self.noun, |kind| kind.noun), kinds);
                    report.mistake(key.span(), move || {
                        let others = all.iter().flat_map(|kind| kind.keys).filter(|_| kind.is_none());
                        let names = || common.iter().chain(own).chain(others.clone()).copied();
                        Words::new(
                            format!("{noun} has no key {}", quoted(name)),
                            did_you_mean(name, names(), "not known"),
                        )
                        .help(keys_of(noun, common, own))
                    });
                }
            }
        }
    }
}

fn keys_of(noun: &str, common: &[&str], own: &[&str]) -> String {
    format!("keys of {noun}: {}", list(own.iter().chain(common).copied()))
}
