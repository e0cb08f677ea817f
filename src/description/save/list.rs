//! Sections of which there are many: kept, changed, moved, removed and added.

use super::SaveError;
use super::field::{Described, Fields};
use super::matching::matched;
use super::path::Directories;
use super::write;
use toml_edit::{Array, ArrayOfTables, Decor, DocumentMut, Item, Table, TableLike, Value};

/// The tables of a list, however it is written.
pub fn tables<'a>(document: &'a DocumentMut, key: &str) -> Box<dyn Iterator<Item = &'a dyn TableLike> + 'a> {
    match document.get(key) {
        Some(Item::ArrayOfTables(list)) => Box::new(list.iter().map(|table| table as &dyn TableLike)),
        Some(Item::Value(Value::Array(list))) => {
            Box::new(list.iter().filter_map(|value| value.as_inline_table().map(|table| table as &dyn TableLike)))
        }
        _ => Box::new(std::iter::empty()),
    }
}

/// Makes a list say `new` where it says `old`.
pub fn update<T: Described>(
    document: &mut DocumentMut,
    key: &str,
    old: &[T],
    new: &[T],
    directories: &Directories,
) -> Result<(), SaveError> {
    if old == new && !directories.differ() {
        return Ok(());
    }
    if tables(document, key).count() != old.len() {
        return Err(SaveError::new(format!("the file has another number of [[{key}]] than the scene was read with")));
    }
    let order = matched(old, new);
    let changes = Changes { old, new, order: &order, directories };
    match document.get_mut(key) {
        Some(Item::Value(Value::Array(list))) => changes.of_array(list),
        Some(Item::ArrayOfTables(list)) => {
            let orphans = changes.of_tables(list)?;
            if new.is_empty() {
                document.remove(key);
            }
            for (position, comments) in orphans.into_iter().rev() {
                adopt(document, position, comments);
            }
            Ok(())
        }
        _ => {
            let mut list = ArrayOfTables::new();
            changes.of_tables(&mut list)?;
            if !new.is_empty() {
                document.insert(key, Item::ArrayOfTables(list));
            }
            Ok(())
        }
    }
}

/// Comments of a removed table that are not its own, and where it was in the document.
type Orphans = Vec<(isize, String)>;

struct Changes<'a, T> {
    old: &'a [T],
    new: &'a [T],
    /// Which old one each new one was.
    order: &'a [Option<usize>],
    directories: &'a Directories,
}

impl<T: Described> Changes<'_, T> {
    /// What an entry said and what it says now.
    fn fields(&self, index: usize) -> (Fields, Fields) {
        let old = self.order[index].map(|at| self.old[at].fields()).unwrap_or_default();
        (old, self.new[index].fields())
    }

    /// `object = [{ .. }, { .. }]`
    fn of_array(&self, list: &mut Array) -> Result<(), SaveError> {
        let before: Vec<Value> = list.iter().cloned().collect();
        // New ones stand apart like the last.
        let gap =
            before.last().and_then(|last| last.decor().prefix()?.as_str()).map(|prefix| match prefix.rfind('\n') {
                Some(at) => prefix[at..].to_owned(),
                None => " ".to_owned(),
            });
        list.clear();
        for (index, of) in self.order.iter().enumerate() {
            let mut value = match of {
                Some(at) => before[*at].clone(),
                None => {
                    let mut value = Value::InlineTable(toml_edit::InlineTable::new());
                    value.decor_mut().set_prefix(gap.as_deref().unwrap_or(" "));
                    value
                }
            };
            if let Value::InlineTable(table) = &mut value {
                let (old, new) = self.fields(index);
                write::update_inline(table, &old, &new, self.directories)?;
            }
            list.push_formatted(value);
        }
        Ok(())
    }

    /// `[[object]]`
    fn of_tables(&self, list: &mut ArrayOfTables) -> Result<Orphans, SaveError> {
        let mut before: Vec<Option<Table>> = std::mem::take(list).into_iter().map(Some).collect();
        let mut kept: Vec<usize> = self.order.iter().flatten().copied().collect();
        kept.sort_unstable();
        let mut orphans = Vec::new();
        for (at, table) in before.iter().enumerate().filter(|(at, _)| kept.binary_search(at).is_err()) {
            let Some(table) = table else { continue };
            let (apart, _) = split(table.decor());
            if apart.contains('#') {
                orphans.push((table.position().unwrap_or(at as isize), apart));
            }
        }
        // The places in the document that the kept ones have, with the comments that stand apart.
        let places: Vec<_> = kept
            .iter()
            .filter_map(|at| before[*at].as_ref())
            .map(|table| (table.position(), split(table.decor()).0))
            .collect();
        let mut places = places.into_iter().zip(kept);
        for (index, of) in self.order.iter().enumerate() {
            let mut table = match *of {
                Some(at) => {
                    let (Some(mut table), Some(((position, apart), was))) = (before[at].take(), places.next()) else {
                        continue;
                    };
                    if was != at {
                        let (_, own) = split(table.decor());
                        table.decor_mut().set_prefix(apart + &own);
                        table.set_position(position);
                        // What belongs to it follows it.
                        for (_, item) in table.iter_mut() {
                            unplace(item);
                        }
                    }
                    table
                }
                None => Table::new(),
            };
            let (old, new) = self.fields(index);
            write::update(&mut table, &old, &new, self.directories)?;
            list.push(table);
        }
        Ok(orphans)
    }
}

/// What stands above the title of a table: the paragraphs apart from it, and the one right above it.
fn split(decor: &Decor) -> (String, String) {
    let prefix = decor.prefix().and_then(|prefix| prefix.as_str()).unwrap_or("\n");
    let mut at = 0;
    let mut start = 0;
    for line in prefix.split_inclusive('\n') {
        start += line.len();
        if line.trim().is_empty() && line.ends_with('\n') {
            at = start;
        }
    }
    (prefix[..at].to_owned(), prefix[at..].to_owned())
}

fn unplace(item: &mut Item) {
    if let Item::Table(table) = item {
        table.set_position(None);
        for (_, item) in table.iter_mut() {
            unplace(item);
        }
    }
}

/// Gives comments to the next table of the document, or to its end.
fn adopt(document: &mut DocumentMut, position: isize, comments: String) {
    fn next<'a>(table: &'a mut Table, after: isize, best: &mut Option<&'a mut Table>) {
        for (_, item) in table.iter_mut() {
            match item {
                Item::Table(table) => consider(table, after, best),
                Item::ArrayOfTables(list) => list.iter_mut().for_each(|table| consider(table, after, best)),
                _ => {}
            }
        }
    }
    fn consider<'a>(table: &'a mut Table, after: isize, best: &mut Option<&'a mut Table>) {
        let is_next = table.position().is_some_and(|at| {
            at > after && best.as_ref().is_none_or(|best| best.position().is_none_or(|best| at < best))
        });
        if is_next && !table.is_dotted() {
            *best = Some(table);
        } else {
            next(table, after, best);
        }
    }
    let mut best = None;
    next(document.as_table_mut(), position, &mut best);
    match best {
        Some(table) => {
            let prefix = table.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or("\n");
            let prefix = comments + prefix.strip_prefix('\n').unwrap_or(prefix);
            table.decor_mut().set_prefix(prefix);
        }
        None => {
            let trailing = document.trailing().as_str().unwrap_or_default();
            document.set_trailing(comments + trailing);
        }
    }
}
