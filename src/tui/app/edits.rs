//! Changes of the scene.

use super::{App, Focus, Tone};
use crate::description::edit::{Bounds, New, add, assign, centre, delete, duplicate, move_by, set_visible};
use crate::description::parameter::{Value, parameter};
use crate::description::{LightKind, Refused, RenderDesc, SceneDesc, Shading, Target, limits};
use crate::tui::camera;
use crate::tui::command::{Command, Motion};
use crate::tui::dialog::Addition;
use crate::tui::event::Effect;
use crate::tui::format::{samples, view};
use crate::tui::properties::materials_of;
use crate::tui::transform::Transform;
use glam::DVec3;
use std::time::Instant;

/// Steps of one key press.
const ORBIT_DEGREES: f64 = 5.0;
const PAN_PART: f64 = 0.05;
const DOLLY_FACTOR: f64 = 0.9;
const FOV_FACTOR: f64 = 1.05;

impl App {
    /// Makes a change as a step of undo and renders it; what it gives, or tells why it was refused.
    pub(super) fn change<T>(
        &mut self,
        label: &str,
        gesture: Option<u64>,
        change: impl FnOnce(&mut SceneDesc) -> Result<T, Refused>,
    ) -> Option<T> {
        match self.editor.edit(label, gesture, change) {
            Ok((result, changed)) => {
                if changed {
                    self.restart();
                }
                Some(result)
            }
            Err(refused) => {
                self.tell(Tone::Bad, refused.to_string());
                None
            }
        }
    }

    /// Puts a whole description in place, as part of a gesture.
    pub(super) fn replace(&mut self, desc: SceneDesc, label: &str, gesture: u64) {
        self.change(label, Some(gesture), |now| {
            *now = desc;
            Ok(())
        });
    }

    /// A change by a key that may be held: as long as it is, all is one step.
    fn turn(&mut self, label: &str, now: Instant, change: impl FnOnce(&mut SceneDesc)) {
        let gesture = self.editor.held_gesture(label, now);
        self.change(label, Some(gesture), |desc| {
            change(desc);
            Ok(())
        });
    }

    /// Commands that change the scene.
    pub(super) fn edit_command(&mut self, command: Command, now: Instant) -> Vec<Effect> {
        let selected = self.editor.selected();
        match command {
            Command::Undo => self.step_back(),
            Command::Redo => self.step_forth(),
            Command::Transform(motion) => self.begin_transform(motion),
            Command::ToggleHidden => {
                let hidden = |target: &Target| {
                    let visible = parameter(*target, "visible");
                    visible.and_then(|v| v.get(self.editor.desc(), &[*target])) == Some(Value::Toggle(false))
                };
                let show = selected.iter().all(hidden);
                self.change(if show { "show" } else { "hide" }, None, |desc| set_visible(desc, &selected, show));
            }
            Command::Rename => self.ask_name(),
            Command::Duplicate => {
                if let Some(copies) = self.change("duplicate", None, |desc| duplicate(desc, &selected)) {
                    self.editor.tree.select_all(&copies);
                    self.tell(Tone::Plain, "duplicated".into());
                }
            }
            Command::Delete => {
                let what = match &selected[..] {
                    [one] => one.label(self.editor.desc()),
                    many => format!("{} things", many.len()),
                };
                let label = format!("delete {what}");
                if self.change(&label, None, |desc| delete(desc, &selected)).is_some() {
                    self.editor.tree.forget_marks();
                    let undo = self.keymap.key_of(Command::Undo);
                    self.tell(Tone::Plain, format!("deleted {what}; {undo} brings it back"));
                }
            }
            Command::Reorder(by) => self.reorder(by, now),
            Command::EditColor => self.open_color(),
            Command::EditTexture => return self.open_texture(),
            Command::StoreView => self.ask_view(),
            Command::RecallView(number) => self.recall_view(number),
            Command::Frame => self.frame(&selected),
            command => self.look(command, now),
        }
        Vec::new()
    }

    fn step_back(&mut self) {
        match self.editor.undo() {
            Some(label) => {
                self.restart();
                self.tell(Tone::Plain, format!("undone: {label}"));
            }
            None => self.tell(Tone::Plain, "nothing to undo".into()),
        }
    }

    fn step_forth(&mut self) {
        match self.editor.redo() {
            Some(label) => {
                self.restart();
                self.tell(Tone::Plain, format!("done again: {label}"));
            }
            None => self.tell(Tone::Plain, "nothing to do again".into()),
        }
    }

    /// Camera and render settings by single keys.
    fn look(&mut self, command: Command, now: Instant) {
        let render = self.editor.desc().render;
        let original = self.editor.original().camera;
        match command {
            Command::Orbit(right, above) => {
                let [right, above] = [right, above].map(|steps| f64::from(steps) * ORBIT_DEGREES);
                self.turn("orbit", now, |desc| camera::orbit(&mut desc.camera, right, above));
            }
            Command::Pan(right, above) => {
                let [right, above] = [right, above].map(|steps| f64::from(steps) * PAN_PART);
                self.turn("pan", now, |desc| camera::pan(&mut desc.camera, right, above));
            }
            Command::Dolly(steps) => {
                self.turn("dolly", now, |desc| camera::dolly(&mut desc.camera, DOLLY_FACTOR.powi(steps.into())));
            }
            Command::Widen(steps) => {
                self.turn("angle of view", now, |d| camera::widen(&mut d.camera, FOV_FACTOR.powi(steps.into())));
                self.tell(Tone::Plain, view(self.editor.desc().camera.projection));
            }
            Command::ResetCamera => {
                self.turn("reset camera", now, |desc| desc.camera = original);
                self.tell(Tone::Plain, "the camera is that of the scene again".into());
            }
            Command::Samples(doublings) if render.error.is_some() => {
                let (least, most) = (*limits::ERROR.start(), *limits::ERROR.end());
                let error = render.error.unwrap_or_default() * 0.5f64.powi(doublings.into());
                let error = error.clamp(least, most);
                self.turn("error", now, |desc| desc.render.error = Some(error));
                self.tell(Tone::Plain, format!("until the error is {error} of 255"));
            }
            Command::ToggleAdaptive => {
                let original = self.editor.original().render;
                let uniform = original.error.is_none().then_some(original.samples);
                let (error, count) = match render.error {
                    None => (Some(limits::USUAL_ERROR), limits::ADAPTIVE_SAMPLES),
                    Some(_) => (None, uniform.unwrap_or(RenderDesc::default().samples)),
                };
                self.turn("samples", now, |desc| (desc.render.error, desc.render.samples) = (error, count));
                self.tell(
                    Tone::Plain,
                    match error {
                        Some(error) => format!("until the error is {error} of 255"),
                        None => format!("{} a pixel", samples(count)),
                    },
                );
            }
            Command::Samples(doublings) => {
                let count = if doublings > 0 { render.samples.saturating_mul(2) } else { render.samples / 2 };
                let count = count.clamp(1, limits::MAX_SAMPLES);
                self.turn("samples", now, |desc| desc.render.samples = count);
                self.tell(Tone::Plain, format!("{} a pixel", samples(count)));
            }
            Command::Depth(more) => {
                let depth = render.max_depth.saturating_add_signed(more.into()).min(limits::MAX_DEPTH);
                self.turn("depth", now, |desc| desc.render.max_depth = depth);
                self.tell(Tone::Plain, format!("depth {depth}"));
            }
            Command::CycleShading => {
                let next = match render.shading {
                    Shading::Lambert => Shading::Phong,
                    Shading::Phong => Shading::Whitted,
                    Shading::Whitted => Shading::Lambert,
                };
                self.turn("lighting model", now, |desc| desc.render.shading = next);
                self.tell(Tone::Plain, format!("lighting model {}", next.name()));
            }
            _ => {}
        }
    }

    fn begin_transform(&mut self, motion: Motion) {
        let desc = self.editor.desc().clone();
        let placed = |target: &Target| match target {
            Target::Object(_) => true,
            Target::Light(index) => desc.lights.get(*index).is_some_and(|light| match light.kind {
                LightKind::Point { .. } => true,
                LightKind::Directional { .. } => motion == Motion::Rotate,
            }),
            _ => false,
        };
        let targets: Vec<_> = self.editor.selected().into_iter().filter(placed).collect();
        if targets.is_empty() {
            self.tell(Tone::Plain, "select objects or lights first: click on one, or choose it in the tree".into());
            return;
        }
        let pivot = centre(&desc, &targets, |index| self.bounds_of(index));
        let gesture = self.editor.new_gesture();
        self.transform = Some(Transform::new(motion, &desc, targets, pivot.unwrap_or(DVec3::ZERO), gesture));
    }

    fn reorder(&mut self, by: i8, now: Instant) {
        let target = self.editor.tree.cursor();
        let gesture = self.editor.held_gesture("reorder", now);
        if let Some(moved) = self.change("reorder", Some(gesture), |desc| move_by(desc, target, by.into())) {
            self.editor.tree.select(moved);
        }
    }

    /// Adds something and selects it.
    pub(super) fn add_new(&mut self, addition: Addition) -> Vec<Effect> {
        let new = match addition {
            Addition::Sphere => New::Sphere,
            Addition::Cuboid => New::Cuboid,
            Addition::Cylinder => New::Cylinder,
            Addition::Cone => New::Cone,
            Addition::Plane => New::Plane,
            Addition::Quad => New::Quad,
            Addition::PointLight => New::PointLight,
            Addition::DirectionalLight => New::DirectionalLight,
            Addition::Material => New::Material,
            Addition::Model => return self.open_models(),
        };
        self.add_entry(new);
        Vec::new()
    }

    /// Adds an entry and selects it.
    pub(super) fn add_entry(&mut self, new: New) {
        if let Some(target) = self.change("add", None, |desc| add(desc, new)) {
            self.editor.tree.select(target);
            let text = format!("added {}", target.label(self.editor.desc()));
            self.tell(Tone::Good, text);
        }
    }

    /// Materials of the selection; objects without one get one of their own, as part of what the open dialog does.
    pub(super) fn materials_to_edit(&mut self) -> Option<Vec<Target>> {
        let selected = self.editor.selected();
        let desc = self.editor.desc();
        let bare = |target: &Target| match target {
            Target::Object(index) => desc.objects.get(*index).is_some_and(|object| object.material.is_none()),
            _ => false,
        };
        let bare: Vec<_> = selected.iter().copied().filter(bare).collect();
        if !bare.is_empty() {
            self.change_live(|desc| match add(desc, New::Material)? {
                Target::Material(index) => assign(desc, &bare, Some(index)),
                _ => Ok(()),
            })?;
        }
        let materials = materials_of(self.editor.desc(), &selected);
        (!materials.is_empty()).then_some(materials)
    }

    /// The row of the properties with the cursor goes up or down.
    pub(super) fn nudge(&mut self, steps: i32, fine: bool, now: Instant) {
        let Some(property) = self.editor.properties.current(&self.editor.sections()) else { return };
        let label = format!("change {}", property.parameter.label);
        // The same row of something else is another gesture.
        let gesture = self.editor.held_gesture(&format!("{label} of {:?}", property.targets), now);
        self.change(&label, Some(gesture), |desc| property.parameter.nudge(desc, &property.targets, steps, fine));
    }

    pub(super) fn reset_property(&mut self) {
        let Some(property) = self.editor.properties.current(&self.editor.sections()) else { return };
        let label = format!("reset {}", property.parameter.label);
        self.change(&label, None, |desc| property.parameter.reset(desc, &property.targets));
    }

    fn recall_view(&mut self, number: u8) {
        let stored = self.editor.views.get(usize::from(number).wrapping_sub(1)).copied().flatten();
        match stored {
            Some(camera) => {
                self.change("recall view", None, |desc| {
                    desc.camera = camera;
                    Ok(())
                });
                self.tell(Tone::Plain, format!("view {number}"));
            }
            None => {
                let key = self.keymap.key_of(Command::StoreView);
                self.tell(Tone::Plain, format!("there is no view {number} yet: {key} {number} keeps this one"));
            }
        }
    }

    /// The selection fills the view; everything if nothing of it has a place.
    fn frame(&mut self, selected: &[Target]) {
        let boxes = |targets: &mut dyn Iterator<Item = Target>| {
            let desc = self.editor.desc();
            let one = |target| match target {
                Target::Object(index) => self.bounds_of(index),
                Target::Light(index) => match desc.lights.get(index)?.kind {
                    LightKind::Point { position, .. } => Some(Bounds { lower: position, upper: position }),
                    LightKind::Directional { .. } => None,
                },
                _ => None,
            };
            let join = |a: Bounds, b: Bounds| Bounds { lower: a.lower.min(b.lower), upper: a.upper.max(b.upper) };
            targets.filter_map(one).reduce(join)
        };
        let all = boxes(&mut selected.iter().copied());
        let all = all.or_else(|| boxes(&mut (0..self.editor.desc().objects.len()).map(Target::Object)));
        let Some(Bounds { lower, upper }) = all else {
            self.tell(Tone::Plain, "there is nothing with an end to frame".into());
            return;
        };
        let film = self.editor.desc().film;
        let aspect = f64::from(film.width) / f64::from(film.height);
        let (middle, radius) = ((lower + upper) / 2.0, lower.distance(upper) / 2.0);
        self.change("frame", None, |desc| {
            camera::frame(&mut desc.camera, aspect, middle, radius);
            Ok(())
        });
    }

    /// The box of an object as it is edited now; the compiled scene may be older.
    fn bounds_of(&self, index: usize) -> Option<Bounds> {
        let bounds = self.scene.as_ref()?.bounds_of(self.editor.desc().objects.get(index)?)?;
        Some(Bounds { lower: bounds.lower.as_dvec3(), upper: bounds.upper.as_dvec3() })
    }

    /// Shows what was picked in the panel.
    pub(super) fn picked(&mut self, target: Target, add: bool) {
        if add {
            self.editor.tree.add(target);
        } else {
            self.editor.tree.select(target);
        }
        let label = target.label(self.editor.desc());
        self.tell(Tone::Plain, label);
        if self.focus == Focus::Tree {
            self.focus = Focus::Properties;
        }
    }
}
