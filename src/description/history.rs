//! Undo and redo.

use super::{CameraDesc, FilmDesc, LightDesc, MaterialDesc, ObjectDesc, RenderDesc, SceneDesc, WorldDesc};
use std::sync::Arc;

/// A description with all that was done to it, without limit. A step keeps only the entries that it changed, so that
/// ten thousand of them take a few megabytes however large the scene is.
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
    /// Makes of the description the one on the other side of this step.
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

    /// Takes in an edited description as one step, called `label` ("move ball"); nothing if it is the same. Edits with
    /// one `gesture` (a held key, a drag: the caller numbers them) and one label, right after each other, are one step.
    /// Returns whether anything changed.
    pub fn record(&mut self, edited: SceneDesc, label: &str, gesture: Option<u64>) -> bool {
        let back = Delta::between(&edited, &self.now);
        if back.is_empty() {
            return false;
        }
        self.undone.clear();
        match self.done.last_mut().filter(|step| gesture.is_some() && step.gesture == gesture && step.label == label) {
            Some(step) => {
                step.other = Delta::between(&edited, &step.other.apply(&self.now));
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
        let other = step.other.apply(now);
        step.other = Delta::between(&other, now);
        *now = Arc::new(other);
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

    /// Whether what is there now differs from what the file says; false again where an edit is undone, or made back by
    /// hand.
    pub fn is_unsaved(&self) -> bool {
        !Arc::ptr_eq(&self.now, &self.saved) && self.now != self.saved
    }

    /// The file says something else now (it was changed on the disk): what is there becomes that, as a step that can be
    /// undone. The camera stays where it is, unless it is what was changed in the file.
    pub fn reload(&mut self, desc: SceneDesc, label: &str) {
        let camera = if desc.camera == self.saved.camera { self.now.camera } else { desc.camera };
        self.record(SceneDesc { camera, ..desc.clone() }, label, None);
        self.saved = Arc::new(desc);
    }
}

/// What of a description differs from another one, as the other one has it.
#[derive(Debug)]
struct Delta {
    film: Option<FilmDesc>,
    camera: Option<Box<CameraDesc>>,
    world: Option<Box<WorldDesc>>,
    render: Option<RenderDesc>,
    lights: Option<Pieces<LightDesc>>,
    materials: Option<Pieces<MaterialDesc>>,
    objects: Option<Pieces<ObjectDesc>>,
}

impl Delta {
    /// What makes `to` of `from`.
    fn between(from: &SceneDesc, to: &SceneDesc) -> Self {
        Self {
            film: (from.film != to.film).then_some(to.film),
            camera: (from.camera != to.camera).then(|| Box::new(to.camera)),
            world: (from.world != to.world).then(|| Box::new(to.world)),
            render: (from.render != to.render).then_some(to.render),
            lights: pieces(&from.lights, &to.lights),
            materials: pieces(&from.materials, &to.materials),
            objects: pieces(&from.objects, &to.objects),
        }
    }

    fn is_empty(&self) -> bool {
        self.film.is_none()
            && self.camera.is_none()
            && self.world.is_none()
            && self.render.is_none()
            && self.lights.is_none()
            && self.materials.is_none()
            && self.objects.is_none()
    }

    /// The other description.
    fn apply(&self, desc: &SceneDesc) -> SceneDesc {
        SceneDesc {
            film: self.film.unwrap_or(desc.film),
            camera: self.camera.as_deref().copied().unwrap_or(desc.camera),
            world: self.world.as_deref().copied().unwrap_or(desc.world),
            render: self.render.unwrap_or(desc.render),
            lights: assemble(&desc.lights, &self.lights),
            materials: assemble(&desc.materials, &self.materials),
            objects: assemble(&desc.objects, &self.objects),
        }
    }
}

/// A list, told by what of another list it is made of.
type Pieces<T> = Box<[Piece<T>]>;

#[derive(Debug)]
enum Piece<T> {
    /// So many elements of the other list from this one on.
    Same(u32, u32),
    /// One that the other list does not have.
    New(Box<T>),
}

/// Elements are looked for so far from where they are expected: what is not found is kept whole, that is all.
const REACH: usize = 1000;
/// Of several equal elements the one is taken after which most others follow alike, up to so many.
const LONGEST_RUN: usize = 32;

/// `None` if the lists are equal.
fn pieces<T: Clone + PartialEq>(from: &[T], to: &[T]) -> Option<Pieces<T>> {
    if from == to {
        return None;
    }
    let mut pieces = Vec::new();
    // Where in `from` the next element is expected.
    let mut expected = 0;
    for (index, element) in to.iter().enumerate() {
        // How far the lists go on alike from here.
        let run = |at: usize, index: usize| {
            let pairs = from.iter().skip(at).zip(to.iter().skip(index)).take(LONGEST_RUN);
            pairs.take_while(|(from, to)| from == to).count()
        };
        let place = if from.get(expected) == Some(element) {
            Some(expected)
        } else {
            let around = expected.saturating_sub(REACH)..from.len().min(expected + REACH);
            let best = around.filter(|at| from[*at] == *element).map(|at| (run(at, index), at)).max();
            // Or else it was changed where it stood, or put there.
            let (changed, added) = (run(expected + 1, index + 1), run(expected, index + 1));
            if best.is_none_or(|(run, _)| run <= changed) && changed >= added {
                expected += 1;
                None
            } else {
                best.filter(|(run, _)| *run > added).map(|(_, at)| at)
            }
        };
        match place {
            Some(at) => {
                match pieces.last_mut() {
                    Some(Piece::Same(start, len)) if *start as usize + *len as usize == at => *len += 1,
                    _ => pieces.push(Piece::Same(at as u32, 1)),
                }
                expected = at + 1;
            }
            None => pieces.push(Piece::New(Box::new(element.clone()))),
        }
    }
    Some(pieces.into())
}

fn assemble<T: Clone>(from: &[T], pieces: &Option<Pieces<T>>) -> Vec<T> {
    let Some(pieces) = pieces else { return from.to_vec() };
    let mut list = Vec::new();
    for piece in pieces {
        match piece {
            Piece::Same(start, len) => list.extend_from_slice(&from[*start as usize..][..*len as usize]),
            Piece::New(element) => list.push((**element).clone()),
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::super::{DEMO, ShapeDesc, builtin, parse};
    use super::*;
    use crate::math::SplitMix64;
    use std::path::Path;

    fn demo() -> SceneDesc {
        let text = std::str::from_utf8(builtin(Path::new(DEMO)).unwrap()).unwrap();
        parse(text, Path::new(DEMO)).unwrap()
    }

    fn edited(desc: &SceneDesc, edit: impl FnOnce(&mut SceneDesc)) -> SceneDesc {
        let mut desc = desc.clone();
        edit(&mut desc);
        desc
    }

    #[test]
    fn undo_and_redo_walk_through_every_state() {
        let mut random = SplitMix64(8);
        let mut history = History::new(Arc::new(demo()));
        let mut states = vec![demo()];
        for step in 0..400 {
            let next = edited(history.now(), |desc| match random.next_u64() % 7 {
                0 => desc.objects.push(ObjectDesc::new(ShapeDesc::Plane)),
                1 => drop((!desc.objects.is_empty()).then(|| desc.objects.remove(0))),
                2 => desc.lights.push(LightDesc { intensity: f64::from(step), ..LightDesc::default() }),
                3 => desc.objects.reverse(),
                4 => desc.materials.iter_mut().for_each(|m| m.ambient += 1.0),
                5 => desc.film.width += 1,
                _ => desc.camera.position.x += 1.0,
            });
            if history.record(next.clone(), "edit", None) {
                states.push(next);
            }
            // Now and then some steps back and forth, or another branch.
            if random.next_u64().is_multiple_of(10) {
                for _ in 0..random.next_u64() % 5 {
                    if history.undo().is_some() {
                        states.pop();
                    }
                }
                assert_eq!(history.now().as_ref(), states.last().unwrap());
            }
        }
        let last = states.len() - 1;
        for state in states[..last].iter().rev() {
            assert_eq!(history.undo(), Some("edit"));
            assert_eq!(history.now().as_ref(), state);
        }
        assert_eq!(history.undo(), None);
        for state in &states[1..] {
            assert_eq!(history.redo(), Some("edit"));
            assert_eq!(history.now().as_ref(), state);
        }
        assert_eq!(history.redo(), None);
    }

    #[test]
    fn edits_of_one_gesture_are_one_step_and_those_of_another_are_not() {
        let mut history = History::new(Arc::new(demo()));
        let turn = |history: &mut History, label, gesture| {
            let next = edited(history.now(), |desc| desc.camera.position.x += 1.0);
            history.record(next, label, gesture);
        };
        for _ in 0..10 {
            turn(&mut history, "orbit", Some(1));
        }
        turn(&mut history, "orbit", Some(2));
        turn(&mut history, "pan", Some(2));
        turn(&mut history, "pan", None);
        turn(&mut history, "pan", None);
        let x = demo().camera.position.x;
        for (label, left) in [("pan", 13.0), ("pan", 12.0), ("pan", 11.0), ("orbit", 10.0), ("orbit", 0.0)] {
            assert_eq!(history.next().0, Some(label));
            assert_eq!(history.undo(), Some(label));
            assert_eq!(history.now().camera.position.x, x + left);
        }
        assert_eq!(history.redo(), Some("orbit"));
        assert_eq!(history.now().camera.position.x, x + 10.0);
        // The same gesture after an undo or redo is another step.
        turn(&mut history, "orbit", Some(1));
        history.undo();
        assert_eq!(history.now().camera.position.x, x + 10.0);
        // A gesture that ends where it began is no step.
        history.record(edited(history.now(), |desc| desc.film.width += 1), "size", Some(7));
        history.record(edited(history.now(), |desc| desc.film.width -= 1), "size", Some(7));
        assert_eq!(history.next(), (Some("orbit"), None));
        assert!(!history.record((**history.now()).clone(), "nothing", None));
    }

    #[test]
    fn unsaved_is_what_differs_from_the_file() {
        let mut history = History::new(Arc::new(demo()));
        assert!(!history.is_unsaved());
        history.record(edited(history.now(), |desc| desc.film.width += 1), "size", None);
        assert!(history.is_unsaved());
        history.undo();
        assert!(!history.is_unsaved());
        history.redo();
        history.mark_saved();
        assert!(!history.is_unsaved());
        history.undo();
        assert!(history.is_unsaved());
        // Typing the old value is as good as a redo.
        history.record(edited(history.now(), |desc| desc.film.width += 1), "size", None);
        assert!(!history.is_unsaved());
        history.reload(SceneDesc::default(), "reload");
        assert!(!history.is_unsaved());
        assert_eq!(history.undo(), Some("reload"));
        assert!(history.is_unsaved());
    }

    /// Bytes that a step holds on the heap, counted from its parts.
    fn bytes(step: &Step) -> usize {
        fn list<T>(pieces: &Option<Pieces<T>>, own: impl Fn(&T) -> usize) -> usize {
            let of_piece = |piece: &Piece<T>| match piece {
                Piece::Same(..) => 0,
                Piece::New(element) => size_of::<T>() + own(element),
            };
            pieces.iter().flatten().map(|piece| size_of::<Piece<T>>() + of_piece(piece)).sum()
        }
        let delta = &step.other;
        size_of::<Step>()
            + step.label.capacity()
            + delta.camera.as_ref().map_or(0, |_| size_of::<CameraDesc>())
            + delta.world.as_ref().map_or(0, |_| size_of::<WorldDesc>())
            + list(&delta.lights, |light| light.name.capacity())
            + list(&delta.materials, |material| material.name.capacity())
            + list(&delta.objects, |o| o.name.capacity() + o.material.as_ref().map_or(0, String::capacity))
    }

    #[test]
    fn ten_thousand_edits_of_a_large_scene_take_a_few_megabytes() {
        let mut desc = demo();
        for index in 0..1000 {
            let name = format!("ball {index}");
            desc.objects.push(ObjectDesc { name, ..ObjectDesc::new(ShapeDesc::Sphere { radius: 1.0 }) });
        }
        let mut random = SplitMix64(10);
        let mut history = History::new(Arc::new(desc));
        for _ in 0..10_000 {
            let next = edited(history.now(), |desc| {
                let at = (random.next_u64() % desc.objects.len() as u64) as usize;
                match random.next_u64() % 4 {
                    0 => desc.camera.position.x += 1.0,
                    1 => desc.materials[0].ambient += 0.001,
                    2 => drop(desc.objects.remove(at)),
                    _ => desc.objects[at].translate.x += 1.0,
                }
                if desc.objects.len() < 1000 {
                    desc.objects.push(ObjectDesc::new(ShapeDesc::Plane));
                }
            });
            history.record(next, "move the ball", None);
        }
        assert!(history.done.len() > 9_900);
        let sizes = || history.done.iter().map(bytes);
        assert!(sizes().max().unwrap() < 2_000, "{:?}", sizes().max());
        assert!(sizes().sum::<usize>() < 8_000_000, "{}", sizes().sum::<usize>());
    }
}
