//! Every number, switch and choice of a scene that a person may turn: one list, which feeds the rows of a panel, keys
//! that nudge, fields that take text, and the check that an edited description stays within its limits.

mod check;
mod table;

#[cfg(test)]
mod tests;

pub(super) use check::{check, default_view_height};

use super::expression::Expression;
use super::{Interval, Refused, SceneDesc, Target, color_code, parse_color, printable};
use crate::math::Rgb;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// One thing that a person may turn.
pub struct Parameter {
    /// What it is called: the key of the scene file, with the component where there are several.
    pub label: &'static str,
    /// What it is measured in; empty for plain numbers.
    pub unit: &'static str,
    /// What values it takes.
    pub kind: Kind,
    read: fn(&SceneDesc, Target) -> Option<Value>,
    /// Without regard to limits. `None` if it does not apply.
    write: fn(&mut SceneDesc, Target, Value) -> Option<()>,
}

/// What values a parameter takes.
pub enum Kind {
    /// A number of a range.
    Number {
        /// From where to where.
        range: Interval,
        /// How far a nudge goes.
        step: Step,
    },
    /// A whole number of a range.
    Integer {
        /// From where to where.
        range: RangeInclusive<i64>,
        /// How far a nudge goes; at least 1.
        step: Step,
    },
    /// On or off.
    Toggle,
    /// One of [`Parameter::choices`].
    Choice(fn(&SceneDesc, Target) -> Vec<String>),
    /// A linear colour.
    Color,
    /// A name.
    Name,
    /// A file.
    Path(FileKind),
}

/// What a file must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// PNG, JPEG, BMP, TGA.
    Picture,
    /// OBJ.
    Model,
}

/// How far one coarse nudge goes; a fine one goes a tenth of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// This much.
    Linear(f64),
    /// By this factor; a fine one by its tenth root.
    Factor(f64),
    /// A round length near a fiftieth of the distance that the camera looks over.
    View,
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of a number.
    Number(f64),
    /// Of a whole number.
    Integer(i64),
    /// On or off.
    Toggle(bool),
    /// Index into [`Parameter::choices`].
    Choice(usize),
    /// Linear.
    Color(Rgb),
    /// A name; may be empty.
    Text(String),
    /// Resolved.
    Path(PathBuf),
    /// Several entries have several values. Only read, never set.
    Mixed,
}

/// Every parameter of this kind of entry, in the order of a panel; some do not apply to every entry.
pub fn parameters(target: Target) -> &'static [Parameter] {
    match target {
        Target::Film => table::FILM,
        Target::Camera => table::CAMERA,
        Target::World => table::WORLD,
        Target::Render => table::RENDER,
        Target::Light(_) => table::LIGHT,
        Target::Material(_) => table::MATERIAL,
        Target::Object(_) => table::OBJECT,
    }
}

/// The parameters that apply to all of the targets: none unless they are entries of one kind.
pub fn shared_parameters(desc: &SceneDesc, targets: &[Target]) -> Vec<&'static Parameter> {
    let Some(first) = targets.first() else { return Vec::new() };
    parameters(*first).iter().filter(|parameter| parameter.get(desc, targets).is_some()).collect()
}

/// The parameter of this kind of entry with this label.
pub fn parameter(target: Target, label: &str) -> Option<&'static Parameter> {
    parameters(target).iter().find(|parameter| parameter.label == label)
}

impl Parameter {
    /// The value that all targets have, or [`Value::Mixed`]; `None` if there is no target, or one to which this does
    /// not apply.
    pub fn get(&self, desc: &SceneDesc, targets: &[Target]) -> Option<Value> {
        let mut values = targets.iter().map(|target| (self.read)(desc, *target));
        let first = values.next()??;
        let mut mixed = false;
        for value in values {
            mixed |= value? != first;
        }
        Some(if mixed { Value::Mixed } else { first })
    }

    /// What the entry would have if the file did not say; `None` if this does not apply to it.
    pub fn default(&self, desc: &SceneDesc, target: Target) -> Option<Value> {
        let (bare, target) = check::bare(desc, target)?;
        (self.read)(&bare, target)
    }

    /// Gives all targets the value. If that is refused for one of them, nothing is changed.
    pub fn set(&self, desc: &mut SceneDesc, targets: &[Target], value: &Value) -> Result<(), Refused> {
        self.check(value)?;
        self.change(desc, targets, |_, _| Ok(value.clone()))
    }

    /// Moves numbers by so many steps, each from where it is, and stops at the limits; a choice or switch goes to the
    /// next; a colour becomes brighter or darker.
    pub fn nudge(&self, desc: &mut SceneDesc, targets: &[Target], steps: i32, fine: bool) -> Result<(), Refused> {
        let unit = view_step(desc);
        self.change(desc, targets, |desc, target| {
            let now = (self.read)(desc, target).ok_or_else(|| self.does_not_apply(desc, target))?;
            Ok(match (&self.kind, now) {
                (Kind::Number { range, step }, Value::Number(now)) => {
                    Value::Number(range.clamp(nudged(now, steps, fine, *step, unit)))
                }
                (Kind::Integer { range, step }, Value::Integer(now)) => {
                    let moved = nudged(now as f64, steps, fine, *step, unit).round() as i64;
                    // At least by 1, so that small numbers move too.
                    let moved = if moved == now { now + i64::from(steps.signum()) } else { moved };
                    Value::Integer(moved.clamp(*range.start(), *range.end()))
                }
                (Kind::Toggle, Value::Toggle(now)) => Value::Toggle(now ^ (steps % 2 != 0)),
                (Kind::Choice(choices), Value::Choice(now)) => {
                    let count = choices(desc, target).len().max(1) as i64;
                    Value::Choice((now as i64 + i64::from(steps)).rem_euclid(count) as usize)
                }
                (Kind::Color, Value::Color(now)) => {
                    let channel = |v: f64| Interval::LIGHT.clamp(nudged(v, steps, fine, Step::Factor(1.1), unit));
                    Value::Color(Rgb::new(channel(now.r), channel(now.g), channel(now.b)))
                }
                _ => return Err(Refused::new(format!("{} has no steps: type it", self.label))),
            })
        })
    }

    /// Reads what a person typed: for numbers an [`Expression`], which may be relative to what each target has; for a
    /// colour its code or name, or three linear channels; for a choice its name or the beginning of it.
    pub fn enter(&self, desc: &mut SceneDesc, targets: &[Target], text: &str) -> Result<(), Refused> {
        let text = text.trim();
        match &self.kind {
            Kind::Number { .. } | Kind::Integer { .. } => {
                let expression = Expression::parse(text)?;
                self.change(desc, targets, |desc, target| {
                    let now = (self.read)(desc, target).ok_or_else(|| self.does_not_apply(desc, target))?;
                    match now {
                        Value::Number(now) => Ok(Value::Number(expression.apply(now)?)),
                        Value::Integer(now) => {
                            let value = expression.apply(now as f64)?;
                            // A relative one may end between two whole numbers; one that is typed must not.
                            if value.fract() != 0.0 && !expression.is_relative() {
                                return Err(Refused::new(format!("{} must be a whole number", self.label)));
                            }
                            Ok(Value::Integer(value.round() as i64))
                        }
                        _ => Err(self.does_not_apply(desc, target)),
                    }
                })
            }
            Kind::Toggle => match text.to_lowercase().as_str() {
                "true" | "on" | "yes" | "1" => self.set(desc, targets, &Value::Toggle(true)),
                "false" | "off" | "no" | "0" => self.set(desc, targets, &Value::Toggle(false)),
                _ => Err(Refused::new(format!("{} is on or off", self.label))),
            },
            Kind::Choice(choices) => self.change(desc, targets, |desc, target| {
                let names = choices(desc, target);
                let exact = names.iter().position(|name| name == text);
                let found = exact.or_else(|| {
                    let mut alike = names
                        .iter()
                        .enumerate()
                        .filter(|(_, name)| !text.is_empty() && name.to_lowercase().starts_with(&text.to_lowercase()));
                    alike.next().filter(|_| alike.next().is_none()).map(|(index, _)| index)
                });
                found
                    .map(Value::Choice)
                    .ok_or_else(|| Refused::new(format!("{} is one of {}", self.label, names.join(", "))))
            }),
            Kind::Color => self.set(desc, targets, &Value::Color(read_color(text)?)),
            Kind::Name => self.set(desc, targets, &Value::Text(text.to_owned())),
            Kind::Path(_) if text.is_empty() => Err(Refused::new(format!("{} needs the name of a file", self.label))),
            Kind::Path(_) => self.set(desc, targets, &Value::Path(PathBuf::from(text))),
        }
    }

    /// Gives every target what it would have if the file did not say.
    pub fn reset(&self, desc: &mut SceneDesc, targets: &[Target]) -> Result<(), Refused> {
        self.change(desc, targets, |desc, target| {
            let default = self.default(desc, target);
            default.ok_or_else(|| Refused::new(format!("{} has no default", self.label)))
        })
    }

    /// The names that a [`Value::Choice`] counts; empty for other kinds.
    pub fn choices(&self, desc: &SceneDesc, target: Target) -> Vec<String> {
        match &self.kind {
            Kind::Choice(choices) => choices(desc, target),
            _ => Vec::new(),
        }
    }

    /// A value of this parameter in few characters, safe to print; what [`Parameter::enter`] takes again, except that
    /// paths are shortened to the file's name.
    pub fn show(&self, desc: &SceneDesc, target: Target, value: &Value) -> String {
        match value {
            Value::Number(v) => short(*v),
            Value::Integer(v) => v.to_string(),
            Value::Toggle(on) => if *on { "on" } else { "off" }.to_owned(),
            Value::Choice(index) => {
                let names = self.choices(desc, target);
                names.get(*index).map(|name| printable(name).into_owned()).unwrap_or_default()
            }
            Value::Color(c) => {
                color_code(*c).unwrap_or_else(|| format!("{}, {}, {}", short(c.r), short(c.g), short(c.b)))
            }
            Value::Text(text) => printable(text).into_owned(),
            Value::Path(path) => {
                let name = Path::new(path).file_name().unwrap_or_default();
                printable(&name.to_string_lossy()).into_owned()
            }
            Value::Mixed => "mixed".to_owned(),
        }
    }

    fn does_not_apply(&self, desc: &SceneDesc, target: Target) -> Refused {
        Refused::new(format!("{} has no {}", target.label(desc), self.label))
    }

    /// Whether the value lies within the limits of this parameter.
    fn check(&self, value: &Value) -> Result<(), Refused> {
        match (&self.kind, value) {
            (Kind::Number { range, .. }, Value::Number(v)) if !range.contains(*v) => {
                Err(Refused::new(format!("{} must be {}", self.label, range.words())))
            }
            (Kind::Integer { range, .. }, Value::Integer(v)) if !range.contains(v) => {
                Err(Refused::new(format!("{} must be from {} to {}", self.label, range.start(), range.end())))
            }
            (Kind::Color, Value::Color(c)) if ![c.r, c.g, c.b].iter().all(|v| Interval::LIGHT.contains(*v)) => {
                Err(Refused::new(format!("the channels of {} must be {}", self.label, Interval::LIGHT.words())))
            }
            _ => Ok(()),
        }
    }

    /// Writes what `new` makes of every target. All or nothing.
    fn change(
        &self,
        desc: &mut SceneDesc,
        targets: &[Target],
        new: impl Fn(&SceneDesc, Target) -> Result<Value, Refused>,
    ) -> Result<(), Refused> {
        let mut edited = desc.clone();
        for &target in targets {
            let value = new(&edited, target)?;
            self.check(&value)?;
            if (self.read)(&edited, target).as_ref() == Some(&value) {
                continue;
            }
            let is_choice = matches!(value, Value::Choice(_));
            if (self.write)(&mut edited, target, value).is_none() {
                return Err(match (self.read)(desc, target) {
                    Some(Value::Choice(_)) if is_choice => Refused::new("a picture needs a file: choose one"),
                    Some(_) => Refused::new(format!("this is no value of {}", self.label)),
                    None => self.does_not_apply(desc, target),
                });
            }
            check(&edited, target)?;
        }
        *desc = edited;
        Ok(())
    }
}

/// A round length (1, 2 or 5 times a power of ten) near a fiftieth of the distance that the camera looks over.
pub fn view_step(desc: &SceneDesc) -> f64 {
    let distance = desc.camera.position.distance(desc.camera.look_at);
    let wanted = (distance / 50.0).clamp(1e-9, 1e9);
    let power = 10f64.powf(wanted.log10().floor());
    let digit = [1.0, 2.0, 5.0, 10.0].into_iter().rfind(|digit| digit * power <= wanted * (1.0 + 1e-9)).unwrap_or(1.0);
    without_noise(digit * power)
}

fn nudged(now: f64, steps: i32, fine: bool, step: Step, view_step: f64) -> f64 {
    let part = if fine { 0.1 } else { 1.0 };
    let by = |length: f64| now + length * part * f64::from(steps);
    without_noise(match step {
        Step::Linear(length) => by(length),
        Step::View => by(view_step),
        Step::Factor(factor) => now * factor.powf(part * f64::from(steps)),
    })
}

/// To 12 digits: what sums of decimal steps leave behind is gone, so that 0.1 + 0.2 is 0.3.
pub(super) fn without_noise(v: f64) -> f64 {
    if v == 0.0 || !v.is_finite() {
        return v;
    }
    format!("{v:.11e}").parse().unwrap_or(v)
}

/// At most 6 digits.
fn short(v: f64) -> String {
    let rounded: f64 = format!("{v:.5e}").parse().unwrap_or(v);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) { format!("{rounded:e}") } else { format!("{rounded}") }
}

fn read_color(text: &str) -> Result<Rgb, Refused> {
    if let Some(color) = parse_color(text) {
        return Ok(color);
    }
    let parts: Vec<f64> = text
        .trim_matches(['[', ']'])
        .split([',', ' '])
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok())
        .collect::<Option<_>>()
        .unwrap_or_default();
    match parts[..] {
        [r, g, b] => Ok(Rgb::new(r, g, b)),
        _ => Err(Refused::new("a colour is #rrggbb, a CSS name such as tomato, or r, g, b in linear light")),
    }
}
