//! One value of the file, read as what it should be. Every reader adds a mistake to the report where it gives `None`.

use super::nearest::{did_you_mean, list, quoted};
use super::report::{Report, Words};
use super::{Span, Toml};
use crate::description::interval::Interval;
use glam::{DVec2, DVec3};
use std::ops::RangeInclusive;
use toml::de::DeValue;

/// A value and the key that it belongs to.
#[derive(Clone, Copy)]
pub(super) struct Value<'a> {
    pub key: &'a str,
    pub toml: &'a Toml<'a>,
    /// Whether this is an element of the array that belongs to the key.
    pub element: bool,
}

impl<'a> Value<'a> {
    pub fn span(self) -> Span {
        self.toml.span()
    }

    /// For messages: "`fov`", "an element of `position`".
    fn name(self) -> String {
        if self.element { format!("an element of `{}`", self.key) } else { format!("`{}`", self.key) }
    }

    /// "`fov` must be a number": the value is of another type.
    pub fn wrong_type(self, report: &mut Report<'a>, wanted: &'static str, help: Option<&'static str>) {
        report.mistake(self.span(), move || {
            let words =
                Words::new(format!("{} must be {wanted}", self.name()), format!("this is {}", self.type_name()));
            match (help, self.toml.get_ref()) {
                (Some(help), _) => words.help(help),
                (None, DeValue::String(text)) if text.parse::<f64>().is_ok() || text == "true" || text == "false" => {
                    words.help(format!("write {text}, without the quotes"))
                }
                _ => words,
            }
        });
    }

    fn type_name(self) -> &'static str {
        match self.toml.get_ref() {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date or time",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        }
    }

    fn out_of_range(self, report: &mut Report<'a>, range: String) {
        report.mistake(self.span(), move || {
            Words::new(format!("{} is out of range", self.name()), format!("must be {range}"))
        });
    }

    /// A finite number of `range`; integers are numbers too.
    pub fn number(self, report: &mut Report<'a>, range: Interval) -> Option<f64> {
        let number = match self.toml.get_ref() {
            // Those too long for 128 bits are far out of every range.
            DeValue::Integer(i) => i128::from_str_radix(i.as_str(), i.radix()).map_or(f64::MAX, |i| i as f64),
            DeValue::Float(f) => f.as_str().parse().unwrap_or(f64::NAN),
            _ => {
                self.wrong_type(report, "a number", None);
                return None;
            }
        };
        if !number.is_finite() {
            report.mistake(self.span(), move || {
                Words::new(format!("{} must be a finite number", self.name()), format!("must be {}", range.words()))
            });
            None
        } else if range.contains(number) {
            Some(number)
        } else {
            self.out_of_range(report, range.words());
            None
        }
    }

    /// A whole number of `range`.
    pub fn integer(self, report: &mut Report<'a>, range: RangeInclusive<i64>) -> Option<i64> {
        let DeValue::Integer(integer) = self.toml.get_ref() else {
            let help = self.is_number().then_some("a whole number is written without a point");
            self.wrong_type(report, "a whole number", help);
            return None;
        };
        let found = i64::from_str_radix(integer.as_str(), integer.radix()).ok().filter(|i| range.contains(i));
        if found.is_none() {
            self.out_of_range(report, format!("from {} to {}", range.start(), range.end()));
        }
        found
    }

    /// `true` or `false`.
    pub fn boolean(self, report: &mut Report<'a>) -> Option<bool> {
        let found = self.toml.get_ref().as_bool();
        if found.is_none() {
            self.wrong_type(report, "true or false", None);
        }
        found
    }

    /// A string that is not empty.
    pub fn text(self, report: &mut Report<'a>) -> Option<&'a str> {
        let Some(text) = self.toml.get_ref().as_str() else {
            self.wrong_type(report, "a string", None);
            return None;
        };
        if text.is_empty() {
            report.mistake(self.span(), move || Words::new(format!("`{}` is empty", self.key), "needs some text"));
            return None;
        }
        Some(text)
    }

    /// The one of `choices` that has this name.
    pub fn one_of<T>(
        self,
        report: &mut Report<'a>,
        choices: &'static [T],
        name: fn(&T) -> &'static str,
    ) -> Option<&'static T> {
        let names = move || choices.iter().map(name);
        let Some(text) = self.toml.get_ref().as_str() else {
            report.mistake(self.span(), move || {
                let message = format!("`{}` must be a string", self.key);
                Words::new(message, format!("this is {}", self.type_name())).help(format!("one of: {}", list(names())))
            });
            return None;
        };
        let found = choices.iter().find(|choice| name(choice) == text);
        if found.is_none() {
            report.mistake(self.span(), move || {
                let message = format!("`{}` cannot be {}", self.key, quoted(text));
                Words::new(message, did_you_mean(text, names(), "not known")).help(format!("one of: {}", list(names())))
            });
        }
        found
    }

    /// What the name stands for in `choices`.
    pub fn choice<T: Copy>(self, report: &mut Report<'a>, choices: &'static [(&'static str, T)]) -> Option<T> {
        self.one_of(report, choices, |choice| choice.0).map(|choice| choice.1)
    }

    /// The elements of an array of `N`; `wanted` names it with its article.
    pub fn elements<const N: usize>(self, report: &mut Report<'a>, wanted: &'static str) -> Option<[Value<'a>; N]> {
        let Some(array) = self.toml.get_ref().as_array() else {
            self.wrong_type(report, wanted, None);
            return None;
        };
        if array.len() != N {
            let found = array.len();
            report.mistake(self.span(), move || {
                Words::new(format!("{} must be {wanted}", self.name()), format!("this array has {found}"))
            });
            return None;
        }
        Some(std::array::from_fn(|i| Value { toml: &array[i], element: true, ..self }))
    }

    fn numbers<const N: usize>(
        self,
        report: &mut Report<'a>,
        range: Interval,
        wanted: &'static str,
    ) -> Option<[f64; N]> {
        let found = self.elements::<N>(report, wanted)?.map(|element| element.number(report, range));
        let mut numbers = [0.0; N];
        for (number, found) in numbers.iter_mut().zip(found) {
            *number = found?;
        }
        Some(numbers)
    }

    /// `[x, y]`
    pub fn vec2(self, report: &mut Report<'a>, range: Interval) -> Option<DVec2> {
        self.numbers(report, range, "an array of 2 numbers").map(DVec2::from_array)
    }

    /// `[x, y, z]`
    pub fn vec3(self, report: &mut Report<'a>, range: Interval) -> Option<DVec3> {
        self.numbers(report, range, "an array of 3 numbers").map(DVec3::from_array)
    }

    /// `[x, y, z]`, not all of them 0.
    pub fn direction(self, report: &mut Report<'a>) -> Option<DVec3> {
        let found = self.vec3(report, Interval::PLACE)?;
        // The square of what is shorter could round to 0.
        if found.abs().max_element() < 1e-100 {
            report.mistake(self.span(), move || {
                Words::new(format!("`{}` has no direction", self.key), "at least one number must differ from 0")
            });
            return None;
        }
        Some(found)
    }

    /// Whether this is a single number and not an array.
    pub fn is_number(self) -> bool {
        matches!(self.toml.get_ref(), DeValue::Integer(_) | DeValue::Float(_))
    }
}
