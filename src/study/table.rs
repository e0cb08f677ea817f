//! Tables, for people and for programs.

use serde::{Serialize, Serializer};
use std::fmt;

/// Columns and rows of what was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// One line above it.
    pub title: String,
    /// Names, with the unit in brackets: `time (ms)`.
    pub columns: Vec<String>,
    /// As many cells each as there are columns.
    pub rows: Vec<Vec<Cell>>,
}

/// One entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Left-aligned.
    Text(String),
    /// A count.
    Whole(u64),
    /// A measured number: four figures for people, all of them for programs.
    Real(f64),
    /// Does not apply.
    Nothing,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            title: title.into(),
            columns: columns.iter().map(|column| (*column).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it has not one cell for each column.
    pub fn push(&mut self, row: impl Into<Vec<Cell>>) {
        let row = row.into();
        assert_eq!(row.len(), self.columns.len(), "the table \"{}\" has other columns", self.title);
        self.rows.push(row);
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<u64> for Cell {
    fn from(number: u64) -> Self {
        Self::Whole(number)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Self {
        Self::Whole(number as u64)
    }
}

impl From<u32> for Cell {
    fn from(number: u32) -> Self {
        Self::Whole(number.into())
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, Into::into)
    }
}

/// With all figures, as programs read it; nothing where it does not apply.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Whole(number) => number.fmt(f),
            Self::Real(number) => number.fmt(f),
            Self::Nothing => Ok(()),
        }
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => to.serialize_str(text),
            Self::Whole(number) => to.serialize_u64(*number),
            Self::Real(number) => to.serialize_f64(*number),
            Self::Nothing => to.serialize_none(),
        }
    }
}

impl Cell {
    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Whole(number) => number.to_string(),
            Self::Real(number) => four_figures(*number),
            Self::Nothing => "-".to_owned(),
        }
    }
}

/// A number in four figures: `0.01235`, `12.35`, `12346`, `1.235e-7`.
pub fn four_figures(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    // What rounding to four figures makes of it decides how it is written: 0.99999 is 1.000.
    let rounded: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    match rounded.abs().log10().floor() as i32 {
        magnitude @ -3..=3 => format!("{rounded:.*}", (3 - magnitude) as usize),
        4..=6 => format!("{number:.0}"),
        _ => format!("{number:.3e}"),
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = |text: &str| text.chars().count();
        let shown: Vec<Vec<String>> = self.rows.iter().map(|row| row.iter().map(Cell::shown).collect()).collect();
        let is_text: Vec<bool> =
            (0..self.columns.len()).map(|c| self.rows.iter().any(|row| matches!(row[c], Cell::Text(_)))).collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|c| shown.iter().map(|row| width(&row[c])).fold(width(&self.columns[c]), usize::max))
            .collect();
        let line = |cells: &[String]| {
            let mut line = String::new();
            for (c, cell) in cells.iter().enumerate() {
                let gap = " ".repeat(widths[c] - width(cell));
                line += "  ";
                line += &if is_text[c] { format!("{cell}{gap}") } else { format!("{gap}{cell}") };
            }
            line.trim_end().to_owned()
        };
        if !self.title.is_empty() {
            writeln!(f, "{}", self.title)?;
        }
        writeln!(f, "{}", line(&self.columns))?;
        writeln!(f, "  {}", "-".repeat(widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1)))?;
        for row in &shown {
            writeln!(f, "{}", line(row))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_right_texts_left_and_nothing_is_a_dash() {
        let mut table = Table::new("Some", &["name", "n", "time (ms)"]);
        table.push([Cell::from("a"), Cell::from(5usize), Cell::from(0.123456)]);
        table.push([Cell::from("long"), Cell::from(1234usize), Cell::from(None::<f64>)]);
        let expected = "Some\n  name     n  time (ms)\n  ---------------------\n  a        5     0.1235\n  \
                        long  1234          -\n";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn four_figures_of_any_size() {
        let shown = [0.0, 1.0, 0.99999, -12.3456, 1234.56, 9999.6, 123_456.7, 1.5e9, 0.001_234_56, 1.5e-7];
        let expected = ["0", "1.000", "1.000", "-12.35", "1235", "10000", "123457", "1.500e9", "0.001235", "1.500e-7"];
        assert_eq!(shown.map(four_figures), expected);
    }
}
