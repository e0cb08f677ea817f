//! What the lines of an OBJ file say about each other across its parts.

use super::AssetError;
use super::obj_clean::{Change, Found, MAX_LIBRARIES, NOUNS};
use std::collections::HashMap;
use std::path::Path;

/// How a face wants its normals where the file gives none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Smoothing {
    /// `s off`: its own.
    Flat,
    /// Said nothing: smooth across edges that are not too sharp.
    Crease,
    /// `s`: smooth with all faces of the same object and group; groups are numbered from 0.
    Group(u32),
}

/// Faces one after another that are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// The first of them; the first of the next run ends it.
    pub first: u32,
    /// Index into [`Outline::materials`], or [`NO_MATERIAL`].
    pub material: u32,
    /// How they are to be smoothed.
    pub smoothing: Smoothing,
}

impl Run {
    fn is_like(&self, other: &Self) -> bool {
        (self.material, self.smoothing) == (other.material, other.smoothing)
    }
}

/// Faces before any `usemtl`.
pub(super) const NO_MATERIAL: u32 = u32::MAX;

/// A whole file but for its vertices and faces.
pub(super) struct Outline {
    /// All faces; never empty.
    pub runs: Vec<Run>,
    /// Names in `usemtl` lines, the whole rest of each line.
    pub materials: Vec<Vec<u8>>,
    /// As in [`Found`].
    pub libraries: Vec<Vec<u8>>,
    pub lines_and_points: usize,
    pub free_form: usize,
    pub colored: usize,
    pub weighted: usize,
    pub unknown: (usize, Option<(usize, String)>),
}

impl Outline {
    /// Puts together what was found in the parts of `file`; refuses indices that are too high.
    pub fn of<'a>(file: &Path, parts: impl Iterator<Item = &'a mut Found>) -> Result<Self, AssetError> {
        let run = Run { first: 0, material: NO_MATERIAL, smoothing: Smoothing::Crease };
        let mut outline = Self {
            runs: vec![run],
            materials: Vec::new(),
            libraries: Vec::new(),
            lines_and_points: 0,
            free_form: 0,
            colored: 0,
            weighted: 0,
            unknown: (0, None),
        };
        let mut teller = Teller { run, object: 0, group: None, groups: HashMap::new(), numbers: HashMap::new() };
        let mut faces = 0;
        let (mut counts, mut highest) = ([0; 3], [(0, 0); 3]);
        for part in parts {
            for (before, change) in part.changes.drain(..) {
                teller.run.first = faces + before;
                teller.change(change, &mut outline.materials);
                while outline.runs.last().is_some_and(|last| last.first == teller.run.first) {
                    outline.runs.pop();
                }
                if !outline.runs.last().is_some_and(|last| last.is_like(&teller.run)) {
                    outline.runs.push(teller.run);
                }
            }
            faces += part.faces.len() as u32;
            for kind in 0..3 {
                counts[kind] += part.vertices[kind];
                if part.highest[kind].0 > highest[kind].0 {
                    highest[kind] = part.highest[kind];
                }
            }
            for name in part.libraries.drain(..) {
                if outline.libraries.len() < MAX_LIBRARIES && !outline.libraries.contains(&name) {
                    outline.libraries.push(name);
                }
            }
            outline.lines_and_points += part.lines_and_points;
            outline.free_form += part.free_form;
            outline.colored += part.colored;
            outline.weighted += part.weighted;
            outline.unknown.0 += part.unknown.0;
            outline.unknown.1 = outline.unknown.1.or(part.unknown.1.take());
        }
        if outline.runs.len() > 1 && outline.runs.last().is_some_and(|last| last.first == faces) {
            outline.runs.pop();
        }
        for ((index, line), (count, noun)) in highest.into_iter().zip(counts.into_iter().zip(NOUNS)) {
            if index > count {
                let reason = format!("index {index} is too high: the file has {count} {noun}");
                return Err(AssetError::new(file, Some(line), reason));
            }
        }
        Ok(outline)
    }

    /// What `of` says of each of the faces; nothing if it says the same of all.
    pub fn each<T: Copy>(&self, faces: usize, of: impl Fn(&Run) -> T) -> Vec<T> {
        let mut each = Vec::new();
        if self.runs.len() > 1 {
            each.reserve_exact(faces);
            let ends = self.runs.iter().skip(1).map(|run| run.first as usize).chain([faces]);
            for (run, end) in self.runs.iter().zip(ends) {
                each.resize(end, of(run));
            }
        }
        each
    }
}

/// What goes on from line to line.
struct Teller {
    run: Run,
    object: u32,
    /// Number in the last `s`.
    group: Option<u32>,
    groups: HashMap<(u32, u32), u32>,
    numbers: HashMap<Vec<u8>, u32>,
}

impl Teller {
    fn change(&mut self, change: Change, materials: &mut Vec<Vec<u8>>) {
        match change {
            Change::Material(name) => {
                self.run.material = match self.numbers.get(&name) {
                    _ if name.is_empty() => NO_MATERIAL,
                    Some(&number) => number,
                    None => {
                        let number = materials.len() as u32;
                        materials.push(name.clone());
                        self.numbers.insert(name, number);
                        number
                    }
                };
            }
            Change::Smoothing(group) => self.smooth(group),
            Change::Object => {
                // The group number goes on, but nothing is smoothed across objects.
                self.object += 1;
                if let Some(group) = self.group {
                    self.smooth(group);
                }
            }
        }
    }

    fn smooth(&mut self, group: u32) {
        self.group = Some(group);
        self.run.smoothing = if group == 0 {
            Smoothing::Flat
        } else {
            let next = self.groups.len() as u32;
            Smoothing::Group(*self.groups.entry((self.object, group)).or_insert(next))
        };
    }
}
