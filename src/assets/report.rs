//! What importing a model found, mended, dropped and missed.

use crate::description::printable;
use std::fmt;

/// Counts and warnings of one import.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportReport {
    /// Triangles kept.
    pub triangles: usize,
    /// Triangles dropped because their area is exactly 0.
    pub dropped_degenerate: usize,
    /// Triangles dropped because another has the same corners in the same sense.
    pub dropped_duplicates: usize,
    /// How normals were computed that the file lacks.
    pub normals: Option<String>,
    /// One sentence each: what was ignored or not found.
    pub notes: Vec<String>,
}

/// All of it in one line: "69,451 triangles; 12 dropped (zero area); normals computed (crease 30 degrees)".
impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", counted(self.triangles, "triangle"))?;
        if self.dropped_degenerate > 0 {
            write!(f, "; {} dropped (zero area)", grouped(self.dropped_degenerate))?;
        }
        if self.dropped_duplicates > 0 {
            write!(f, "; {} dropped (duplicates)", grouped(self.dropped_duplicates))?;
        }
        self.normals.iter().chain(&self.notes).try_for_each(|note| write!(f, "; {}", printable(note)))
    }
}

/// "1 vertex", "1,200 vertices": `noun` in the singular.
pub(super) fn counted(count: usize, noun: &str) -> String {
    let plural = match noun.strip_suffix("ex") {
        _ if count == 1 => noun.to_owned(),
        Some(stem) => format!("{stem}ices"),
        None => format!("{noun}s"),
    };
    format!("{} {plural}", grouped(count))
}

/// Digits in groups of three.
pub(super) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The first few of a list, and how many more there are.
pub(super) fn listed<'a>(items: impl IntoIterator<Item = &'a String>) -> String {
    const SHOWN: usize = 5;
    let mut items = items.into_iter();
    let shown = items.by_ref().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    match items.count() {
        0 => shown,
        more => format!("{shown} and {} more", grouped(more)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_one_sentence() {
        let report = ImportReport {
            triangles: 69_451,
            dropped_degenerate: 12,
            dropped_duplicates: 0,
            normals: Some("normals computed (crease 30 degrees)".into()),
            notes: vec!["2 textures not found: a.png, \x1bb.png".into()],
        };
        let expected = "69,451 triangles; 12 dropped (zero area); normals computed (crease 30 degrees); \
                        2 textures not found: a.png, \u{fffd}b.png";
        assert_eq!(report.to_string(), expected);
        assert_eq!(ImportReport { triangles: 1, ..Default::default() }.to_string(), "1 triangle");
        assert_eq!(grouped(1_234_567), "1,234,567");
        assert_eq!(counted(2, "vertex"), "2 vertices");
    }
}
