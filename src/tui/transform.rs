//! Moving, turning and scaling what is selected.

use super::command::{Command, Motion};
use super::field::Field;
use super::key::{Code, Key};
use crate::description::edit::{Axis, rotate, scale, translate};
use crate::description::parameter::view_step;
use crate::description::{Expression, Refused, SceneDesc, Target};
use glam::DVec3;
use std::sync::Arc;

/// A change of place under way. What it makes is always computed from where it began, so nothing drifts.
#[derive(Clone, Debug)]
pub struct Transform {
    /// What is done.
    pub motion: Motion,
    /// Number of the gesture, so that all of it is one step of undo.
    pub gesture: u64,
    targets: Vec<Target>,
    pivot: DVec3,
    /// As it was before.
    begun: Arc<SceneDesc>,
    /// As it was when the axis was last changed.
    base: Arc<SceneDesc>,
    axis: Option<u8>,
    /// Whether the axes are those of the view.
    of_view: bool,
    shift: DVec3,
    degrees: f64,
    factor: f64,
    typed: Field,
}

/// What a key made of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// [`Transform::result`] is another one.
    Changed,
    /// It is done.
    Keep,
    /// It is taken back.
    Cancel,
    /// The key means nothing here.
    Unknown,
}

/// A fine and a coarse nudge of a turn, degrees.
const DEGREES: [f64; 2] = [5.0, 45.0];
/// A fine and a coarse nudge of a scale.
const FACTORS: [f64; 2] = [1.05, 1.5];
/// Coarse nudges of a move, in fine ones.
const FAR: f64 = 10.0;

impl Transform {
    /// Begins about `pivot`, world space.
    pub fn new(motion: Motion, desc: &Arc<SceneDesc>, targets: Vec<Target>, pivot: DVec3, gesture: u64) -> Self {
        Self {
            motion,
            gesture,
            targets,
            pivot,
            begun: desc.clone(),
            base: desc.clone(),
            axis: (motion == Motion::Rotate).then_some(1),
            of_view: false,
            shift: DVec3::ZERO,
            degrees: 0.0,
            factor: 1.0,
            typed: Field::default(),
        }
    }

    /// As it was before.
    pub fn begun(&self) -> &Arc<SceneDesc> {
        &self.begun
    }

    /// Takes a key.
    pub fn key(&mut self, key: Key, command: Option<Command>) -> Progress {
        match command {
            Some(Command::Accept) => return Progress::Keep,
            Some(Command::Cancel) => return Progress::Cancel,
            Some(Command::Axis(axis)) => {
                self.rebase();
                let again = self.axis == Some(axis) && self.motion != Motion::Rotate;
                self.axis = if again { None } else { Some(axis) };
            }
            Some(Command::ToggleViewAxes) => {
                self.rebase();
                self.of_view = !self.of_view;
            }
            Some(Command::Turn(by)) => self.nudge(f64::from(by), 0.0, false),
            Some(Command::TurnFar(by)) => self.nudge(f64::from(by), 0.0, true),
            Some(Command::Step(by)) => self.nudge(0.0, -f64::from(by), false),
            Some(Command::StepFar(by)) => self.nudge(0.0, -f64::from(by), true),
            None => {
                let number = matches!(key.code, Code::Char(c) if c.is_ascii_digit() || "+-*/.()".contains(c));
                let edits = !self.typed.is_empty() && !matches!(key.code, Code::Char(_));
                if !(number || edits) || !self.typed.key(key) {
                    return Progress::Unknown;
                }
            }
            Some(_) => return Progress::Unknown,
        }
        Progress::Changed
    }

    /// What was done so far stays; the next axis begins from it.
    fn rebase(&mut self) {
        if let Ok(result) = self.result() {
            self.base = Arc::new(result);
            (self.shift, self.degrees, self.factor) = (DVec3::ZERO, 0.0, 1.0);
        }
        self.typed = Field::default();
    }

    fn nudge(&mut self, right: f64, above: f64, far: bool) {
        self.typed = Field::default();
        let step = view_step(&self.begun) * if far { FAR } else { 1.0 };
        let along = right + above;
        match self.motion {
            Motion::Move => {
                let camera = &self.begun.camera;
                self.shift += match self.direction() {
                    Some(direction) => direction * (along * step),
                    None => (Axis::Right.direction(camera) * right + Axis::Up.direction(camera) * above) * step,
                };
            }
            Motion::Rotate => self.degrees += along * DEGREES[usize::from(far)],
            Motion::Scale => self.factor *= FACTORS[usize::from(far)].powf(along),
        }
    }

    /// The axis as a unit vector of world space.
    fn direction(&self) -> Option<DVec3> {
        let axes = match self.of_view {
            false => [Axis::X, Axis::Y, Axis::Z],
            true => [Axis::Right, Axis::Up, Axis::Forward],
        };
        Some(axes[usize::from(self.axis?)].direction(&self.begun.camera))
    }

    /// The description with it done.
    ///
    /// # Errors
    /// Why what is typed means nothing, or leads out of the limits.
    pub fn result(&self) -> Result<SceneDesc, Refused> {
        let mut desc = (*self.base).clone();
        let typed = |now: f64| -> Result<Option<f64>, Refused> {
            let text = self.typed.text();
            // The beginning of a number is none yet.
            if text.is_empty() || ["+", "-", "*", "/", ".", "("].contains(&text.as_str()) {
                return Ok(None);
            }
            Expression::parse(&text)?.apply(now).map(Some)
        };
        match self.motion {
            Motion::Move => {
                let along = self.direction().unwrap_or_else(|| Axis::Right.direction(&self.begun.camera));
                let shift = typed(0.0)?.map_or(self.shift, |length| along * length);
                translate(&mut desc, &self.targets, shift)?;
            }
            Motion::Rotate => {
                let degrees = typed(0.0)?.unwrap_or(self.degrees);
                if degrees != 0.0 {
                    rotate(&mut desc, &self.targets, self.pivot, self.direction().unwrap_or(DVec3::Y), degrees)?;
                }
            }
            Motion::Scale => {
                let factor = typed(1.0)?.unwrap_or(self.factor);
                if factor != 1.0 {
                    scale(&mut desc, &self.targets, self.pivot, self.direction(), factor)?;
                }
            }
        }
        Ok(desc)
    }

    /// What is going on, in a line.
    pub fn text(&self) -> String {
        let axis = match (self.axis, self.of_view) {
            (None, _) => "",
            (Some(axis), false) => [" x", " y", " z"][usize::from(axis)],
            (Some(axis), true) => [" right", " up", " into the view"][usize::from(axis)],
        };
        let number = |value: f64| format!("{}", (value * 1e4).round() / 1e4);
        let typed = self.typed.text();
        let (words, value) = match self.motion {
            Motion::Move => {
                let along = self.direction().map(|direction| direction.dot(self.shift));
                let [x, y, z] = self.shift.to_array().map(number);
                (format!("move{axis}"), along.map_or(format!("{x}, {y}, {z}"), number))
            }
            Motion::Rotate => (format!("turn about{axis}"), format!("{}°", number(self.degrees))),
            Motion::Scale => (format!("scale{axis}"), format!("× {}", number(self.factor))),
        };
        if typed.is_empty() { format!("{words}: {value}") } else { format!("{words}: {typed}▏") }
    }

    /// What a step of undo is called.
    pub fn label(&self) -> String {
        let word = match self.motion {
            Motion::Move => "move",
            Motion::Rotate => "turn",
            Motion::Scale => "scale",
        };
        match &self.targets[..] {
            [one] => format!("{word} {}", one.label(&self.begun)),
            many => format!("{word} {} things", many.len()),
        }
    }
}
