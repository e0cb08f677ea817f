//! Undo and redo.

use super::{CameraDesc, FilmDesc, LightDesc, MaterialDesc, ObjectDesc, RenderDesc, SceneDesc, WorldDesc};
use std::sync::Arc;

/// A description with all that was done to it, without limit. A step keeps only the entries that it changed, so that ten
/// thousand of them take a few megabytes however large the scene is.
#[derive(Debug)]
pub struct History {
    now: Arc<SceneDesc>,
    saved: Arc<SceneDesc>,
    done: Vec<Step>,
    undone: Vec<Step>,
}

/// One thing that can be undone or redone.
#[derive(Debug)]
struct Step {
    label: String,
    gesture: Option<u64>,
    /// Swapped with the description to undo, and again to redo.
    other: Delta,
}

impl History {
    /// Begins with a description that is as its file says.
    pub fn new(desc: Arc<SceneDesc>) -> Self {
        Self { saved: desc.clone(), now: desc, done: Vec::new(), undone: Vec::new() }
    }

    /// What is there now.
    pub fn now(&self) -> &Arc<SceneDesc> {
        &self.now
    }

    /// Takes in an edited description as one step, called `label` ("move ball"); nothing if it is the same. Edits with one
    /// `gesture` (a held key, a drag: the caller numbers them) and one label, right after each other, are one step.
    /// Returns whether anything changed.
    pub fn record(&mut self, edited: SceneDesc, label: &str, gesture: Option<u64>) -> bool {
        let back = Delta::between(&edited, &self.now);
        if back.is_empty() {
            return false;
        }
        self.undone.clear();
        match self.done.last_mut().filter(|step| gesture.is_some() && step.gesture == gesture && step.label == label) {
            Some(step) => {
                let mut base = (*self.now).clone();
                step.other.swap(&mut base);
                step.other = Delta::between(&edited, &base);
                if step.other.is_empty() {
                    self.done.pop();
                }
            }
            None => self.done.push(Step { label: label.to_owned(), gesture, other: back }),
        }
        self.now = Arc::new(edited);
        true
    }

    /// Takes back the last step and returns its label; `None` if there is none.
    pub fn undo(&mut self) -> Option<&str> {
        let step = self.done.pop()?;
        Some(Self::swap(&mut self.now, step, &mut self.undone))
    }

    /// Does again what was taken back last, and returns its label; `None` if there is nothing.
    pub fn redo(&mut self) -> Option<&str> {
        let step = self.undone.pop()?;
        Some(Self::swap(&mut self.now, step, &mut self.done))
    }

    fn swap<'a>(now: &mut Arc<SceneDesc>, mut step: Step, onto: &'a mut Vec<Step>) -> &'a str {
        step.other.swap(Arc::make_mut(now));
        // What comes after is another gesture.
        step.gesture = None;
        onto.push(step);
        onto.last().map_or("", |step| &step.label)
    }

    /// Labels of what can be undone and redone next.
    pub fn next(&self) -> (Option<&str>, Option<&str>) {
        (self.done.last().map(|step| step.label.as_str()), self.undone.last().map(|step| step.label.as_str()))
    }

    /// What is there now is what the file says.
    pub fn mark_saved(&mut self) {
        self.saved = self.now.clone();
    }

    /// What the file says.
    pub fn saved(&self) -> &Arc<SceneDesc> {
        &self.saved
    }

    /// Whether what is there now differs from what the file says; false again where an edit is undone, or made back by hand.
    pub fn is_unsaved(&self) -> bool {
        !Arc::ptr_eq(&self.now, &self.saved) && self.now != self.saved
    }

    /// The file says something else now (it was changed on the disk): what is there becomes that, as a step that can be undone.
    pub fn reload(&mut self, desc: SceneDesc, label: &str) {
        self.record(desc, label, None);
        self.mark_saved();
    }
}

/// The entries in which two descriptions differ, as one of them has them.
#[derive(Debug, Default)]
struct Delta {
    film: Option<FilmDesc>,
    camera: Option<Box<CameraDesc>>,
    world: Option<Box<WorldDesc>>,
    render: Option<RenderDesc>,
    lights: ListDelta<LightDesc>,
    materials: ListDelta<MaterialDesc>,
    objects: ListDelta<ObjectDesc>,
}

impl Delta {
    /// What makes `to` of `from`.
    fn between(from: &SceneDesc, to: &SceneDesc) -> Self {
        Self {
            film: (from.film != to.film).then_some(to.film),
            camera: (from.camera != to.camera).then(|| Box::new(to.camera)),
            world: (from.world != to.world).then(|| Box::new(to.world)),
            render: (from.render != to.render).then_some(to.render),
            lights: ListDelta::between(&from.lights, &to.lights),
            materials: ListDelta::between(&from.materials, &to.materials),
            objects: ListDelta::between(&from.objects, &to.objects),
        }
    }

    fn is_empty(&self) -> bool {
        self.film.is_none()
            && self.camera.is_none()
            && self.world.is_none()
            && self.render.is_none()
            && self.lights.is_empty()
            && self.materials.is_empty()
            && self.objects.is_empty()
    }

    /// Makes of `desc` the other description, and becomes what leads back.
    fn swap(&mut self, desc: &mut SceneDesc) {
        if let Some(film) = &mut self.film {
            std::mem::swap(film, &mut desc.film);
        }
        if let Some(camera) = &mut self.camera {
            std::mem::swap(&mut **camera, &mut desc.camera);
        }
        if let Some(world) = &mut self.world {
            std::mem::swap(&mut **world, &mut desc.world);
        }
        if let Some(render) = &mut self.render {
            std::mem::swap(render, &mut desc.render);
        }
        self.lights.swap(&mut desc.lights);
        self.materials.swap(&mut desc.materials);
        self.objects.swap(&mut desc.objects);
    }
}

/// How a list differs from another.
#[derive(Debug)]
enum ListDelta<T> {
    /// As long: these elements differ.
    Elements(Box<[(usize, T)]>),
    /// In place of this many elements from `start` on, the other list has these.
    Splice { start: usize, len: usize, elements: Box<[T]> },
}

impl<T> Default for ListDelta<T> {
    fn default() -> Self {
        Self::Elements(Box::default())
    }
}

impl<T: Clone + PartialEq> ListDelta<T> {
    fn between(from: &[T], to: &[T]) -> Self {
        if from.len() == to.len() {
            let differing = from.iter().zip(to).enumerate().filter(|(_, (from, to))| from != to);
            return Self::Elements(differing.map(|(index, (_, to))| (index, to.clone())).collect());
        }
        let start = from.iter().zip(to).take_while(|(from, to)| from == to).count();
        let rest = (&from[start..], &to[start..]);
        let end = rest.0.iter().rev().zip(rest.1.iter().rev()).take_while(|(from, to)| from == to).count();
        let elements = to[start..to.len() - end].into();
        Self::Splice { start, len: from.len() - end - start, elements }
    }

    fn is_empty(&self) -> bool {
        matches!(self, Self::Elements(elements) if elements.is_empty())
    }

    fn swap(&mut self, list: &mut Vec<T>) {
        match self {
            Self::Elements(elements) => {
                for (index, element) in elements {
                    std::mem::swap(element, &mut list[*index]);
                }
            }
            Self::Splice { start, len, elements } => {
                let count = elements.len();
                let replaced = list.splice(*start..*start + *len, std::mem::take(elements)).collect();
                *elements = replaced;
                *len = count;
            }
        }
    }
}
