//! Values into a TOML document, next to what stands there.

use super::super::color_code;
use super::SaveError;
use super::field::{Field, Fields};
use super::path::Directories;
use crate::math::Rgb;
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

/// Makes a table say `new` where it says `old`, and touches nothing else. An empty `old` is that of a new table.
pub fn update(
    table: &mut dyn TableLike,
    old: &Fields,
    new: &Fields,
    directories: &Directories,
) -> Result<(), SaveError> {
    for gone in old.iter().filter(|gone| !new.iter().any(|kept| kept.key == gone.key)) {
        table.remove(gone.key);
        if let Field::Spheres(_) = gone.field {
            table.remove("file");
        }
    }
    for entry in new {
        let before = old.iter().find(|before| before.key == entry.key);
        match before {
            Some(before) if before.field == entry.field => {
                // What the file leaves to a default that has changed must be told now.
                if before.default != entry.default && !table.contains_key(entry.key) {
                    put(table, entry.key, &entry.field, directories)?;
                } else if directories.differ() {
                    rebase(table, entry.key, &entry.field, directories)?;
                }
            }
            None if entry.default.as_ref() == Some(&entry.field) => {}
            Some(before) => match (&before.field, &entry.field) {
                (Field::Table(old), Field::Table(new)) if is_table(table, entry.key) => {
                    if let Some(inner) = table.get_mut(entry.key) {
                        update_item(inner, old, new, directories)?;
                    }
                }
                _ => put(table, entry.key, &entry.field, directories)?,
            },
            None => put(table, entry.key, &entry.field, directories)?,
        }
    }
    Ok(())
}

/// The same for a table however it is written.
pub fn update_item(item: &mut Item, old: &Fields, new: &Fields, directories: &Directories) -> Result<(), SaveError> {
    match item {
        Item::Value(Value::InlineTable(table)) => update_inline(table, old, new, directories),
        item => match item.as_table_like_mut() {
            Some(table) => update(table, old, new, directories),
            None => Err(SaveError::new("the file has a value where there must be a section".to_owned())),
        },
    }
}

/// The same for `{ a = 1 }`, which becomes `{ a = 1, b = 2 }` and not `{ a = 1 , b = 2}`.
pub fn update_inline(
    table: &mut InlineTable,
    old: &Fields,
    new: &Fields,
    directories: &Directories,
) -> Result<(), SaveError> {
    let count = table.len();
    update(table, old, new, directories)?;
    if table.len() != count {
        let last = table.len().saturating_sub(1);
        for (index, (_, value)) in table.iter_mut().enumerate() {
            let is_blank =
                value.decor().suffix().and_then(|suffix| suffix.as_str()).is_none_or(|s| s.trim().is_empty());
            if is_blank {
                value.decor_mut().set_suffix(if index == last { " " } else { "" });
            }
        }
    }
    Ok(())
}

fn is_table(table: &dyn TableLike, key: &str) -> bool {
    table.get(key).is_some_and(Item::is_table_like)
}

/// Writes paths anew, relative to where the scene will be.
fn rebase(table: &mut dyn TableLike, key: &str, field: &Field, directories: &Directories) -> Result<(), SaveError> {
    match field {
        Field::Path(_) => put(table, key, field, directories),
        Field::Table(fields) => match table.get_mut(key).and_then(Item::as_table_like_mut) {
            Some(inner) => fields.iter().try_for_each(|entry| rebase(inner, entry.key, &entry.field, directories)),
            None => Ok(()),
        },
        Field::Spheres(_) => match table.get("file").and_then(Item::as_str) {
            Some(file) => {
                let file = directories.written_from_old(file)?;
                set(table, "file", Value::from(file));
                Ok(())
            }
            None => Ok(()),
        },
        _ => Ok(()),
    }
}

/// Writes one key, in the manner of the value that stands there.
fn put(table: &mut dyn TableLike, key: &str, field: &Field, directories: &Directories) -> Result<(), SaveError> {
    if let Field::Spheres(data) = field {
        table.remove("file");
        if let Some(file) = directories.file_of_spheres(data)? {
            table.remove(key);
            set(table, "file", Value::from(file));
            return Ok(());
        }
    }
    let before = table.get_mut(key).and_then(Item::as_value_mut);
    if let (Some(Value::Array(array)), Some(numbers)) = (before, numbers_of(field))
        && array.len() == numbers.len()
        && array.iter().all(|element| number_of(element).is_some())
    {
        // Element by element, so that an array of many lines stays one.
        for (index, number) in numbers.into_iter().enumerate() {
            if let Some(element) = array.get_mut(index)
                && number_of(element) != Some(number)
            {
                replace(element, number_like(Some(element), number));
            }
        }
        return Ok(());
    }
    let before = table.get(key).and_then(Item::as_value);
    let value = value_of(field, before, directories)?;
    set(table, key, value);
    Ok(())
}

/// Puts a value in the place of another or, if there is none, at the end.
fn set(table: &mut dyn TableLike, key: &str, value: Value) {
    match table.get_mut(key) {
        Some(Item::Value(before)) => replace(before, value),
        _ => {
            table.remove(key);
            table.insert(key, Item::Value(value));
        }
    }
}

fn replace(before: &mut Value, mut value: Value) {
    *value.decor_mut() = before.decor().clone();
    *before = value;
}

/// A table of one line with these values.
fn inline(fields: &Fields, directories: &Directories) -> Result<InlineTable, SaveError> {
    let mut table = InlineTable::new();
    update_inline(&mut table, &Vec::new(), fields, directories)?;
    Ok(table)
}

fn value_of(field: &Field, before: Option<&Value>, directories: &Directories) -> Result<Value, SaveError> {
    Ok(match field {
        Field::Number(v) => number_like(before, *v),
        Field::Integer(v) => Value::from(*v),
        Field::Toggle(on) => Value::from(*on),
        Field::Text(text) => text_value(text),
        Field::Path(path) => Value::from(directories.written(path)?),
        Field::Color(color) => color_value(*color),
        Field::Colors(colors) => Value::Array(colors.iter().map(|color| color_value(*color)).collect()),
        Field::Numbers(numbers) => array_of(numbers),
        // The parser takes one number for all.
        Field::Factors(factors) if factors.iter().all(|v| *v == factors[0]) => number_like(before, factors[0]),
        Field::Factors(factors) => array_of(factors),
        Field::Spheres(data) => {
            let mut array: Array = data.iter().map(|sphere| array_of(sphere)).collect();
            for sphere in array.iter_mut() {
                sphere.decor_mut().set_prefix("\n    ");
            }
            array.set_trailing("\n");
            array.set_trailing_comma(true);
            Value::Array(array)
        }
        Field::Table(fields) => Value::InlineTable(inline(fields, directories)?),
    })
}

/// A string of one line: line ends within would be taken for those of the file.
fn text_value(text: &str) -> Value {
    if !text.contains(['\n', '\r']) {
        return Value::from(text);
    }
    let escape = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    };
    let quoted = format!("\"{}\"", text.chars().map(escape).collect::<String>());
    quoted.parse().unwrap_or_else(|_| Value::from(text))
}

fn color_value(color: Rgb) -> Value {
    match color_code(color) {
        Some(code) => Value::from(code),
        None => array_of(&[color.r, color.g, color.b]),
    }
}

fn array_of(numbers: &[f64]) -> Value {
    Value::Array(numbers.iter().map(|v| number_like(None, *v)).collect())
}

/// What an array of numbers in the file would hold.
fn numbers_of(field: &Field) -> Option<Vec<f64>> {
    match field {
        Field::Numbers(numbers) | Field::Factors(numbers) => Some(numbers.clone()),
        Field::Color(c) => Some(vec![c.r, c.g, c.b]),
        _ => None,
    }
}

fn number_of(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}

/// The shortest text that means exactly this number; with a point if what stands there has one.
fn number_like(before: Option<&Value>, v: f64) -> Value {
    let had_point = before.is_some_and(Value::is_float);
    let text = if v == v.trunc() && v.abs() < 1e15 && !had_point { format!("{}", v as i64) } else { format!("{v:?}") };
    text.parse().unwrap_or_else(|_| Value::from(v))
}
