//! Changes of a description that are more than one parameter. Every one of them is made as a whole or not at all, and
//! leaves a description that keeps the limits of the scene language.

mod new;
mod place;

#[cfg(test)]
mod tests;

pub use new::{New, add};
pub use place::{Axis, Bounds, centre, rotate, scale, translate};

use super::parameter::{check, parameter, view_step};
use super::{LightKind, Refused, SceneDesc, Target};
use glam::DVec3;

/// Makes a change on a copy, and keeps it if it succeeds and what it `touched` keeps the limits.
fn attempt<T>(
    desc: &mut SceneDesc,
    change: impl FnOnce(&mut SceneDesc) -> Result<(T, Vec<Target>), Refused>,
) -> Result<T, Refused> {
    let mut edited = desc.clone();
    let (result, touched) = change(&mut edited)?;
    for target in touched {
        check(&edited, target)?;
    }
    *desc = edited;
    Ok(result)
}

/// Deletes objects, lights and materials; others are refused. Objects made of a deleted material get the default one
/// (for a mesh the file's own).
pub fn delete(desc: &mut SceneDesc, targets: &[Target]) -> Result<(), Refused> {
    attempt(desc, |desc| {
        let mut targets = targets.to_vec();
        // From the last to the first, so that indices stay right.
        targets.sort_unstable_by(|a, b| b.cmp(a));
        targets.dedup();
        for target in targets {
            require(desc, target)?;
            match target {
                Target::Object(index) => drop(desc.objects.remove(index)),
                Target::Light(index) => drop(desc.lights.remove(index)),
                Target::Material(index) => {
                    let name = desc.materials.remove(index).name;
                    desc.objects
                        .iter_mut()
                        .filter(|o| o.material.as_ref() == Some(&name))
                        .for_each(|o| o.material = None);
                }
                _ => return Err(Refused::new(format!("the {} cannot be deleted", target.label(desc)))),
            }
        }
        Ok(((), Vec::new()))
    })
}

/// Copies objects, lights and materials, each right behind the original and moved a little so that it is seen. Returns
/// the copies.
pub fn duplicate(desc: &mut SceneDesc, targets: &[Target]) -> Result<Vec<Target>, Refused> {
    attempt(desc, |desc| {
        let mut targets = targets.to_vec();
        targets.sort_unstable();
        targets.dedup();
        let away = Axis::Right.direction(&desc.camera) * (5.0 * view_step(desc));
        let mut copies: Vec<Target> = Vec::new();
        for target in targets {
            require(desc, target)?;
            // Copies that are there already have moved it down.
            let before = copies.iter().filter(|copy| same_kind(**copy, target)).count();
            copies.push(match target {
                Target::Object(index) => {
                    let at = index + before;
                    let mut copy = desc.objects[at].clone();
                    copy.name = free_name(&copy.name, |name| desc.objects.iter().any(|o| o.name == name));
                    copy.translate += away;
                    desc.objects.insert(at + 1, copy);
                    Target::Object(at + 1)
                }
                Target::Light(index) => {
                    let at = index + before;
                    let mut copy = desc.lights[at].clone();
                    copy.name = free_name(&copy.name, |name| desc.lights.iter().any(|l| l.name == name));
                    if let LightKind::Point { position, .. } = &mut copy.kind {
                        *position += away;
                    }
                    desc.lights.insert(at + 1, copy);
                    Target::Light(at + 1)
                }
                Target::Material(index) => {
                    let at = index + before;
                    let mut copy = desc.materials[at].clone();
                    copy.name = free_name(&copy.name, |name| desc.materials.iter().any(|m| m.name == name));
                    desc.materials.insert(at + 1, copy);
                    Target::Material(at + 1)
                }
                _ => return Err(Refused::new(format!("the {} cannot be duplicated", target.label(desc)))),
            });
        }
        Ok((copies.clone(), copies))
    })
}

/// Gives an object, light or material another name; of a material also where it is used. Objects and lights may have
/// none.
pub fn rename(desc: &mut SceneDesc, target: Target, name: &str) -> Result<(), Refused> {
    let Some(parameter) = parameter(target, "name") else {
        return Err(Refused::new(format!("the {} has no name", target.label(desc))));
    };
    parameter.enter(desc, &[target], name)
}

/// Moves an object, light or material so many places down its list (up if negative), as far as it goes. Returns where
/// it is.
pub fn move_by(desc: &mut SceneDesc, target: Target, places: isize) -> Result<Target, Refused> {
    require(desc, target)?;
    fn shift<T>(list: &mut [T], from: usize, places: isize) -> usize {
        let to = from.saturating_add_signed(places).min(list.len() - 1);
        if from < to {
            list[from..=to].rotate_left(1)
        } else {
            list[to..=from].rotate_right(1)
        }
        to
    }
    match target {
        Target::Object(index) => Ok(Target::Object(shift(&mut desc.objects, index, places))),
        Target::Light(index) => Ok(Target::Light(shift(&mut desc.lights, index, places))),
        Target::Material(index) => Ok(Target::Material(shift(&mut desc.materials, index, places))),
        _ => Err(Refused::new(format!("the {} has its place", target.label(desc)))),
    }
}

/// Shows or hides objects and lights.
pub fn set_visible(desc: &mut SceneDesc, targets: &[Target], visible: bool) -> Result<(), Refused> {
    attempt(desc, |desc| {
        for &target in targets {
            require(desc, target)?;
            match target {
                Target::Object(index) => desc.objects[index].visible = visible,
                Target::Light(index) => desc.lights[index].visible = visible,
                _ => return Err(Refused::new("only objects and lights can be hidden")),
            }
        }
        Ok(((), Vec::new()))
    })
}

/// Makes objects of the material with this index; `None`: of the default one, or for a mesh of the file's own.
pub fn assign(desc: &mut SceneDesc, targets: &[Target], material: Option<usize>) -> Result<(), Refused> {
    attempt(desc, |desc| {
        let name = match material {
            None => None,
            Some(index) => {
                let found = desc.materials.get(index).ok_or_else(|| Refused::new("there is no such material"))?;
                Some(found.name.clone())
            }
        };
        for &target in targets {
            require(desc, target)?;
            let Target::Object(index) = target else { return Err(Refused::new("only objects are made of a material")) };
            desc.objects[index].material.clone_from(&name);
        }
        Ok(((), Vec::new()))
    })
}

fn require(desc: &SceneDesc, target: Target) -> Result<(), Refused> {
    if target.exists(desc) { Ok(()) } else { Err(Refused::new(format!("there is no {}", target.label(desc)))) }
}

fn same_kind(a: Target, b: Target) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}

/// `name`, or with the first number that is free; no name stays none.
fn free_name(name: &str, taken: impl Fn(&str) -> bool) -> String {
    if name.is_empty() || !taken(name) {
        return name.to_owned();
    }
    // "ball 2" is followed by "ball 3".
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
    let stem = if stem.is_empty() { name } else { stem };
    (2..).map(|number| format!("{stem} {number}")).find(|name| !taken(name)).unwrap_or_default()
}

/// A point so far in front of the eye that it lies in the middle of what the camera looks at.
fn view_centre(desc: &SceneDesc) -> (DVec3, f64) {
    (desc.camera.look_at, desc.camera.position.distance(desc.camera.look_at))
}
