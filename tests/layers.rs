//! The boundaries between modules and around packages, as the sources keep them.

use std::fs;
use std::path::Path;

/// Modules from low to high: each may use those of earlier rows, none of its own row. `lib.rs` tells the same.
const LAYERS: &[&[&str]] = &[
    &["math", "workers"],
    &["geometry", "description"],
    &["bvh", "assets"],
    &["scene"],
    &["shading"],
    &["render"],
    &["output", "advice"],
    &["headless", "study", "tui"],
    &["cli"],
    &["main"],
];

/// Packages that only some files may use, by the beginning of their path in `src`.
const PACKAGES: &[(&str, &[&str])] = &[
    ("annotate_snippets", &["description/"]),
    ("clap", &["cli/"]),
    ("crossbeam_channel", &["render/", "tui/"]),
    ("crossterm", &["tui/"]),
    ("csv", &["study/"]),
    ("csscolorparser", &["description/"]),
    ("directories", &["tui/keymap"]),
    ("image", &["assets/", "output/"]),
    ("indicatif", &["headless/"]),
    ("plotters", &["study/chart/"]),
    ("ratatui", &["study/chart/", "tui/"]),
    ("tobj", &["assets/obj"]),
    ("toml", &["description/", "tui/keymap"]),
    ("toml_edit", &["description/save/"]),
];

/// The only folder with unsafe code.
const UNSAFE: &str = "bvh/simd/";

fn row(module: &str) -> Option<usize> {
    LAYERS.iter().position(|row| row.contains(&module))
}

/// What the file `path` (in `src`) breaks.
fn violations(path: &str, text: &str) -> Vec<String> {
    let module = path.split(['/', '.']).next().unwrap();
    let Some(own) = row(module) else { return vec![format!("{path}: {module} is in no layer")] };
    let code: Vec<_> = text.lines().map(|line| line.split("//").next().unwrap()).collect();
    let code = code.join("\n");
    let mut found = Vec::new();
    for used in used_modules(&code) {
        if used != module && row(&used).is_some_and(|used| used >= own) {
            found.push(format!("{path}: {module} must not use {used}"));
        }
    }
    for (package, places) in PACKAGES {
        if names_package(&code, package) && !places.iter().any(|place| path.starts_with(place)) {
            found.push(format!("{path}: only {places:?} may use {package}"));
        }
    }
    if words(&code).any(|(word, ..)| word == "unsafe") && !path.starts_with(UNSAFE) {
        found.push(format!("{path}: only {UNSAFE} may hold unsafe code"));
    }
    found
}

/// Words, each with the text before and after it.
fn words(code: &str) -> impl Iterator<Item = (&str, &str, &str)> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    code.split(move |c| !is_part(c)).filter(|word| !word.is_empty()).map(|word| {
        let start = word.as_ptr() as usize - code.as_ptr() as usize;
        (word, &code[..start], &code[start + word.len()..])
    })
}

/// Modules named after the crate's root or one reached by `super`, and those of a group `crate::{a, b::c}`.
fn used_modules(code: &str) -> Vec<String> {
    let mut used = Vec::new();
    for (word, before, after) in words(code) {
        let of_crate = before.ends_with("crate::") || before.ends_with("glimt::");
        if of_crate || (before.ends_with("super::") && after.starts_with("::")) {
            used.push(word.to_owned());
        }
        if let ("crate" | "glimt", Some(group)) = (word, after.strip_prefix("::{")) {
            let mut depth = 0;
            let end = group.find(|c| {
                depth += i32::from(c == '{') - i32::from(c == '}');
                depth < 0
            });
            used.extend(words(&group[..end.unwrap_or(group.len())]).map(|(word, ..)| word.to_owned()));
        }
    }
    used
}

/// Whether a path begins with the package: `package::x` or `use package`, but not `module::package::x`.
fn names_package(code: &str, package: &str) -> bool {
    words(code).any(|(word, before, after)| {
        let used = after.starts_with("::") || before.trim_end().ends_with("use");
        word == package && used && !before.ends_with("::")
    })
}

fn sources(folder: &Path, visit: &mut impl FnMut(&Path)) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, visit);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            visit(&path);
        }
    }
}

#[test]
fn every_file_keeps_the_boundaries() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut files) = (Vec::new(), 0);
    sources(&root, &mut |path| {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        if name != "lib.rs" {
            files += 1;
            found.extend(violations(&name, &fs::read_to_string(path).unwrap()));
        }
    });
    assert!(files > 20, "only {files} files were found");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_map_in_lib_rs_tells_the_same() {
    let rows: Vec<_> = LAYERS.iter().map(|row| row.join(", ")).collect();
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    assert!(lib.contains(&format!("//! {}\n", rows.join(" < "))));
}

#[test]
fn broken_boundaries_are_found() {
    for (path, code) in [
        ("math/rgb.rs", "use crate::scene::Scene;"),
        ("geometry/ray.rs", "fn f(_: crate::description::Shading) {}"),
        ("scene/mod.rs", "use crate::{math::Rgb, render::{Film, Tile}};"),
        ("scene/mod.rs", "use super::render::Film;"),
        ("headless/mod.rs", "use crate::tui;"),
        ("unheard_of/mod.rs", ""),
        ("render/job.rs", "use crossterm::event;"),
        ("assets/image.rs", "use tobj;"),
        ("tui/view.rs", "let p = image::RgbImage::new(1, 1);"),
        ("bvh/build.rs", "unsafe { f() }"),
        ("math/x.rs", "#[test] unsafe fn f() {}"),
    ] {
        assert!(!violations(path, code).is_empty(), "{path}: {code}");
    }
    for (path, code) in [
        ("scene/mod.rs", "use crate::{math::Rgb, bvh::{Bvh, Node}};\nuse super::compile::x; // crate::render"),
        ("assets/mod.rs", "pub use self::image::load_image; // unsafe"),
        ("assets/obj_mtl.rs", "use tobj::Model;"),
        ("bvh/simd/avx2.rs", "unsafe { f() }"),
        ("main.rs", "fn main() { glimt::cli::run() }"),
    ] {
        assert_eq!(violations(path, code), [""; 0], "{path}: {code}");
    }
}
