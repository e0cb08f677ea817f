//! Scene file to description.
//!
//! The text becomes a tree of TOML values that know their place; [`Section`] and [`Value`] read it, and put every
//! mistake on the [`Report`] instead of stopping at it.

mod color;
mod file;
mod interval;
mod material;
mod nearest;
mod object;
mod report;
mod section;
mod settings;
mod spheres;
mod syntax;
mod value;

#[cfg(test)]
mod tests;

pub use color::parse_color;

use super::{Diagnostic, SceneDesc};
use file::Files;
use nearest::{did_you_mean, quoted};
use object::ObjectReader;
use report::{Report, Words};
use section::Section;
use std::collections::HashMap;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Bytes of the text.
type Span = std::ops::Range<usize>;
/// A TOML value and its place.
type Toml<'a> = toml::Spanned<DeValue<'a>>;

/// Parses the text of a scene file. `file` is for messages, and paths in the text are relative to its directory.
/// All mistakes are reported, in the order of the text; of very many the first ones, and one that counts the rest.
pub fn parse(text: &str, file: &Path) -> Result<SceneDesc, Vec<Diagnostic>> {
    // Some editors begin files with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (root, errors) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    let mut materials = Vec::new();
    let mut report = Report::new(text, file);
    let mut files = Files::beside(file);

    check_sections(&mut report, &root);
    each(&mut report, &root, "material", "a material", |report, section| {
        materials.push(material::material(report, &mut files, section));
    });
    check_names(&mut report, &root, "material");
    let mut scene = settings::settings(&mut report, &root);
    check_names(&mut report, &root, "light");
    each(&mut report, &root, "light", "a light", |report, section| {
        scene.lights.extend(settings::light(report, section));
    });
    let mut reader = ObjectReader::new(&materials);
    each(&mut report, &root, "object", "an object", |report, section| {
        scene.objects.extend(reader.object(report, &mut files, section));
    });
    check_names(&mut report, &root, "object");

    syntax::add(&mut report, &errors);
    let mistakes = report.into_diagnostics();
    scene.materials = materials;
    if mistakes.is_empty() { Ok(scene) } else { Err(mistakes) }
}

/// Sections that stand once.
const SINGLE: [&str; 4] = ["film", "camera", "world", "render"];
/// Sections of which there may be many.
const REPEATED: [&str; 3] = ["light", "material", "object"];

/// Adds a mistake for every section that does not exist.
fn check_sections<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>) {
    for (key, value) in root {
        let name: &'a str = key.get_ref();
        if SINGLE.contains(&name) || REPEATED.contains(&name) {
            continue;
        }
        let is_table = matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_));
        report.mistake(key.span(), move || {
            let (what, label) =
                if is_table { ("section", "not known") } else { ("key", "a key must stand in a section") };
            Words::new(
                format!("a scene has no {what} {}", quoted(name)),
                did_you_mean(name, SINGLE.into_iter().chain(REPEATED), label),
            )
            .help("sections: [film], [camera], [world], [render], [[light]], [[material]], [[object]]")
        });
    }
}

/// Reads every `[[key]]`.
fn each<'a>(
    report: &mut Report<'a>,
    root: &'a DeTable<'a>,
    key: &'static str,
    noun: &'static str,
    mut read: impl FnMut(&mut Report<'a>, &Section<'a>),
) {
    for toml in tables(root, key) {
        if let Some(section) = Section::open(report, key, toml, noun, "write [[..]] and keys below it") {
            read(report, &section);
        }
    }
    if let Some(toml) = root.get(key)
        && !matches!(toml.get_ref(), DeValue::Array(_))
    {
        report.mistake(toml.span(), move || {
            Words::new(format!("`{key}` is a list"), format!("write [[{key}]]")).help("there may be many of them")
        });
    }
}

/// The elements of the array `key`.
fn tables<'a>(root: &'a DeTable<'a>, key: &str) -> impl Iterator<Item = &'a Toml<'a>> {
    root.get(key).and_then(|toml| toml.get_ref().as_array()).into_iter().flat_map(|array| array.iter())
}

/// Adds a mistake for every name that another `[[key]]` has.
fn check_names<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>, key: &'static str) {
    let mut first: HashMap<&'a str, Span> = HashMap::new();
    for toml in tables(root, key) {
        let Some(name) = toml.get_ref().as_table().and_then(|table| table.get("name")) else { continue };
        let Some(text) = name.get_ref().as_str().filter(|text| !text.is_empty()) else { continue };
        match first.get(text) {
            None => {
                first.insert(text, name.span());
            }
            Some(earlier) => {
                let (source, at) = (report.text, earlier.start);
                report.mistake(name.span(), move || {
                    let line = 1 + source.as_bytes().iter().take(at).filter(|b| **b == b'\n').count();
                    Words::new(format!("two {key}s are named {}", quoted(text)), format!("the first is in line {line}"))
                        .help(format!("every {key} needs a name of its own"))
                });
            }
        }
    }
}

/// The single section `key`, if the file has it.
fn single<'a>(
    report: &mut Report<'a>,
    root: &'a DeTable<'a>,
    key: &'static str,
    noun: &'static str,
    form: &'static str,
) -> Option<Section<'a>> {
    let toml = root.get(key)?;
    if let DeValue::Array(array) = toml.get_ref() {
        let span = array.first().map_or(toml.span(), |first| first.span());
        report.mistake(span, move || Words::new(format!("`{key}` is no list"), form));
        return None;
    }
    Section::open(report, key, toml, noun, form)
}
