//! Scene file to description.
//!
//! The text becomes a tree of TOML values that know their place; [`Section`] and [`Value`] read it, and put every
//! mistake on the [`Report`] instead of stopping at it.

mod color;
mod entry;
mod file;
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

pub use color::{color_code, parse_color};
pub use entry::{files_named, point_out};

use super::{Diagnostic, SceneDesc};
use file::Files;
use nearest::{nearest, quoted};
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
/// Where the text is not TOML, mistakes that may be mere consequences of that are left out.
pub fn parse(text: &str, file: &Path) -> Result<SceneDesc, Vec<Diagnostic>> {
    let text = without_mark(text);
    let (root, errors) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    // Mistakes quote the names of materials, so these live longer than the report.
    let mut materials = Vec::new();
    let mut report = Report::new(text, file);
    let mut files = Files::beside(file);

    check_sections(&mut report, &root);
    for title in REPEATED {
        check_names(&mut report, &root, title);
    }
    let mut scene = settings::settings(&mut report, &root);
    scene.lights = tables(&root, LIGHT).filter_map(|section| settings::light(&mut report, section)).collect();
    materials.extend(tables(&root, MATERIAL).map(|section| material::material(&mut report, &mut files, &section)));
    let mut reader = ObjectReader::new(&materials);
    scene.objects =
        tables(&root, OBJECT).filter_map(|section| reader.object(&mut report, &mut files, section)).collect();

    syntax::check(&mut report, &root, &errors);
    let mistakes = report.into_diagnostics();
    scene.materials = materials;
    if mistakes.is_empty() { Ok(scene) } else { Err(mistakes) }
}

/// Some editors begin files with a byte order mark.
fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

const FILM: &str = "[film]";
const CAMERA: &str = "[camera]";
const WORLD: &str = "[world]";
const RENDER: &str = "[render]";
const LIGHT: &str = "[[light]]";
const MATERIAL: &str = "[[material]]";
const OBJECT: &str = "[[object]]";
/// Titles of the sections that stand once.
const SINGLE: [&str; 4] = [FILM, CAMERA, WORLD, RENDER];
/// Titles of the sections of which there may be many.
const REPEATED: [&str; 3] = [LIGHT, MATERIAL, OBJECT];

/// The titles of all sections.
fn titles() -> impl Iterator<Item = &'static str> {
    SINGLE.into_iter().chain(REPEATED)
}

/// The key of a section: its title without the brackets.
fn key_of(title: &'static str) -> &'static str {
    title.trim_matches(['[', ']'])
}

/// The section with this title that stands once, if the file has it.
fn single<'a>(root: &'a DeTable<'a>, title: &'static str) -> Option<Section<'a>> {
    Section::of(title, root.get(key_of(title))?)
}

/// All sections with this title.
fn tables<'a>(root: &'a DeTable<'a>, title: &'static str) -> impl Iterator<Item = Section<'a>> {
    let list = root.get(key_of(title)).and_then(|toml| toml.get_ref().as_array());
    list.into_iter().flat_map(|array| array.iter()).filter_map(move |toml| Section::of(title, toml))
}

/// Adds a mistake for everything at the top of the file that is not a section, or not the right sort of one.
fn check_sections<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>) {
    for (key, value) in root {
        let name: &'a str = key.get_ref();
        let title = titles().find(|title| key_of(title) == name);
        match (title, value.get_ref()) {
            (None, found) => unknown_section(report, key.span(), name, found),
            (Some(title), DeValue::Table(_)) if SINGLE.contains(&title) => {}
            (Some(title), DeValue::Array(array)) if REPEATED.contains(&title) => {
                for element in array.iter().filter(|element| !element.get_ref().is_table()) {
                    misplaced(report, element.span(), title);
                }
            }
            (Some(title), DeValue::Array(array)) => {
                misplaced(report, array.first().map_or(value.span(), |first| first.span()), title);
            }
            (Some(title), _) => misplaced(report, value.span(), title),
        }
    }
}

fn unknown_section<'a>(report: &mut Report<'a>, span: Span, name: &'a str, found: &DeValue<'_>) {
    let is_section = found.is_table() || found.is_array();
    report.mistake(span, move || {
        let (what, otherwise) = if is_section {
            ("section", "not known")
        } else {
            ("key", "a key must stand below the title of a section")
        };
        let label = nearest(name, titles().map(key_of))
            .and_then(|near| titles().find(|title| key_of(title) == near))
            .map_or_else(|| otherwise.to_owned(), |title| format!("did you mean {title}?"));
        let sections: Vec<_> = titles().collect();
        Words::new(format!("a scene has no {what} {}", quoted(name)), label)
            .help(format!("sections: {}", sections.join(", ")))
    });
}

fn misplaced(report: &mut Report<'_>, span: Span, title: &'static str) {
    report.mistake(span, move || {
        let help = if SINGLE.contains(&title) {
            format!("there is one {title}, and its keys stand below this title")
        } else {
            format!("there may be many, and each begins with {title}")
        };
        Words::new(format!("`{}` is a section with the title {title}", key_of(title)), format!("write {title}"))
            .help(help)
    });
}

/// Adds a mistake for every name that an earlier section with the same title has.
fn check_names<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>, title: &'static str) {
    let mut first: HashMap<&'a str, Span> = HashMap::new();
    for name in tables(root, title).filter_map(|section| section.value("name")) {
        let Some(text) = name.toml.get_ref().as_str().filter(|text| !text.is_empty()) else { continue };
        let Some(earlier) = first.get(text) else {
            first.insert(text, name.span());
            continue;
        };
        let (source, at) = (report.text, earlier.start);
        report.mistake(name.span(), move || {
            let line = 1 + source.bytes().take(at).filter(|byte| *byte == b'\n').count();
            Words::new(
                format!("two {title} sections have the name {}", quoted(text)),
                format!("the first is in line {line}"),
            )
            .help(format!("every {} needs a name of its own", key_of(title)))
        });
    }
}
