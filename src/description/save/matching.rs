//! Which entry of an edited list is which of the original one.

use super::field::Described;
use std::collections::HashMap;

/// Entries farther than this from where one is looked for are not compared with it: thousands of unnamed ones would
/// take long.
const REACH: usize = 256;

/// For every new entry the index of the old one that it was, if any: one of the same name, else an equal one, else the
/// one that has most keys in common. It decides where comments stay, not what is saved.
pub fn matched<T: Described>(old: &[T], new: &[T]) -> Vec<Option<usize>> {
    let mut of_new = vec![None; new.len()];
    let mut free = vec![true; old.len()];
    let names: HashMap<&str, usize> = old
        .iter()
        .enumerate()
        .filter(|(_, entry)| !entry.name().is_empty())
        .map(|(at, entry)| (entry.name(), at))
        .collect();
    for (entry, of) in new.iter().zip(&mut of_new) {
        if let Some(&at) = names.get(entry.name()).filter(|at| free[**at]) {
            (*of, free[at]) = (Some(at), false);
        }
    }
    let mut next = 0;
    for (entry, of) in new.iter().zip(&mut of_new).filter(|(_, of)| of.is_none()) {
        while next < old.len() && !free[next] {
            next += 1;
        }
        let found = (next..old.len()).take(REACH).find(|at| free[*at] && old[*at] == *entry);
        if let Some(at) = found {
            (*of, free[at]) = (Some(at), false);
        }
    }
    let free_at: Vec<usize> = (0..old.len()).filter(|at| free[*at]).collect();
    let fields: Vec<_> = free_at.iter().take(REACH).map(|at| (*at, old[*at].fields())).collect();
    for (entry, of) in new.iter().zip(&mut of_new).filter(|(_, of)| of.is_none()) {
        let own = entry.fields();
        let alike = |at: usize, other: &super::field::Fields| {
            free[at].then(|| other.iter().filter(|field| own.contains(field)).count())
        };
        // Of those equally alike the first.
        let best =
            fields.iter().rev().filter_map(|(at, other)| Some((alike(*at, other)?, *at))).max_by_key(|(n, _)| *n);
        let same_shape = |at: usize| {
            let shape = |fields: &super::field::Fields| {
                fields.iter().find(|field| matches!(field.key, "shape" | "kind")).map(|field| field.field.clone())
            };
            shape(&old[at].fields()) == shape(&own)
        };
        if let Some((_, at)) = best.filter(|(_, at)| same_shape(*at)) {
            (*of, free[at]) = (Some(at), false);
        }
    }
    of_new
}
