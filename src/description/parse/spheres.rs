//! Spheres by the thousand: `data` of a `spheres` object, inline or from a file of lines `x, y, z, radius`.

use super::report::{Report, Words};
use super::value::Value;
use crate::description::Diagnostic;
use crate::description::interval::Interval;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml::de::DeValue;

/// Mistakes told of one file.
const SHOWN: usize = 5;

/// `data = [[x, y, z, r], ..]`
pub(super) fn inline<'a>(report: &mut Report<'a>, value: Value<'a>) -> Option<Arc<[[f64; 4]]>> {
    let DeValue::Array(array) = value.toml.get_ref() else {
        value.wrong_type(
            report,
            "an array of spheres",
            Some("write data = [[x, y, z, radius], ..], or file = \"..\" for a file of such lines"),
        );
        return None;
    };
    let spheres: Vec<Option<[f64; 4]>> = array
        .iter()
        .map(|toml| {
            let sphere = Value { toml, element: true, ..value };
            let [x, y, z, r] = sphere.elements(report, "[x, y, z, radius]")?;
            let [x, y, z] = [x, y, z].map(|v| v.number(report, Interval::PLACE));
            let r = r.number(report, Interval::LENGTH);
            Some([x?, y?, z?, r?])
        })
        .collect();
    if spheres.is_empty() {
        report.mistake(value.span(), || {
            Words::new("`data` has no sphere", "this is empty").help("write data = [[x, y, z, radius], ..]")
        });
        return None;
    }
    spheres.into_iter().collect::<Option<Vec<_>>>().map(Arc::from)
}

/// Lines of four numbers, divided by commas or blanks; `#` begins a comment. The mistakes are the file's own.
pub(super) fn from_text(text: &str, file: &Path) -> Result<Arc<[[f64; 4]]>, Vec<Diagnostic>> {
    let mut spheres = Vec::new();
    let mut mistakes = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let content = line.split('#').next().unwrap_or_default().trim_end();
        if !content.trim_start().is_empty() {
            match sphere(content) {
                Ok(sphere) => spheres.push(sphere),
                Err((at, message)) => {
                    let span = start + at.start..start + at.end;
                    let help = "each line holds one sphere: x, y, z, radius";
                    mistakes.push(Diagnostic::new(file, text, span, &message, "").with_help(Some(help)));
                }
            }
        }
        start += line.len();
        if mistakes.len() == SHOWN {
            let rest = Diagnostic::new(file, text, start..start, "the rest of this file was not read", "");
            return Err(mistakes.into_iter().chain([rest]).collect());
        }
    }
    if spheres.is_empty() && mistakes.is_empty() {
        mistakes.push(Diagnostic::new(file, text, 0..0, "no sphere in this file", ""));
    }
    if mistakes.is_empty() { Ok(spheres.into()) } else { Err(mistakes) }
}

/// One line, or which bytes of it are wrong.
fn sphere(line: &str) -> Result<[f64; 4], (Range<usize>, String)> {
    let mut numbers = [0.0; 4];
    let mut count = 0;
    for field in line.split(|c: char| c == ',' || c.is_whitespace()).filter(|field| !field.is_empty()) {
        let start = field.as_ptr() as usize - line.as_ptr() as usize;
        let at = start..start + field.len();
        let Some(number) = numbers.get_mut(count) else {
            return Err((at.start..line.len(), "this line has more than 4 numbers".to_owned()));
        };
        let range = if count < 3 { Interval::PLACE } else { Interval::LENGTH };
        *number = field.parse().map_err(|_| (at.clone(), "not a number".to_owned()))?;
        if !range.contains(*number) {
            return Err((at, format!("the number must be {}", range.words())));
        }
        count += 1;
    }
    if count < 4 {
        let start = line.len() - line.trim_start().len();
        return Err((start..line.len(), format!("this line has {count} of 4 numbers")));
    }
    Ok(numbers)
}
