//! What src/geometry/NUMERICS.md says exists: every function, test and experiment that it names.

use glimt::study::stability::EXPERIMENTS;
use std::fs;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn text() -> String {
    fs::read_to_string(Path::new(ROOT).join("src/geometry/NUMERICS.md")).expect("it is there")
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// The items of the lists that begin with these words, whole.
fn items(text: &str, begin: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let Some(first) = line.strip_prefix(begin) else { continue };
        let mut item = first.to_owned();
        while let Some(more) = lines.next_if(|line| line.starts_with("  ")) {
            item += more;
        }
        found.push(item);
    }
    found
}

/// What stands between backticks.
fn quoted(item: &str) -> impl Iterator<Item = &str> {
    item.split('`').skip(1).step_by(2)
}

/// Whether some source defines a function or type of this name.
fn is_defined(name: &str, code: &[String]) -> bool {
    ["fn ", "struct "].iter().any(|keyword| {
        let start = format!("{keyword}{name}");
        let ends = |text: &str| !text.starts_with(|c: char| c.is_alphanumeric() || c == '_');
        code.iter().any(|text| text.match_indices(&start).any(|(at, _)| ends(&text[at + start.len()..])))
    })
}

#[test]
fn every_function_that_is_said_to_hold_a_promise_exists() {
    let mut paths = Vec::new();
    sources(&Path::new(ROOT).join("src"), &mut paths);
    let code: Vec<_> = paths.iter().map(|path| fs::read_to_string(path).expect("a source")).collect();
    let text = text();
    let held = items(&text, "- Held by ");
    let missing: Vec<_> = held.iter().flat_map(|item| quoted(item)).filter(|name| !is_defined(name, &code)).collect();
    assert!(missing.is_empty(), "no such functions: {missing:?}");
    assert!(!is_defined("spawn_ra", &code) && is_defined("spawn_ray", &code));
    // As many promises as derivations, and each held and tested by something.
    let promises = text.matches("**Promise.**").count();
    let tested = items(&text, "- Tested by ");
    assert!(promises >= 10);
    assert_eq!((text.matches("**Derivation.**").count(), held.len(), tested.len()), (promises, promises, promises));
    assert!(held.iter().chain(&tested).all(|item| quoted(item).count() > 0));
}

#[test]
fn every_test_and_experiment_that_is_said_to_check_a_promise_exists() {
    let text = text();
    let tested = items(&text, "- Tested by ");
    let mut named = Vec::new();
    for item in &tested {
        for test in quoted(item) {
            let (file, name) = test.split_once("::").expect("file::test");
            let code = fs::read_to_string(Path::new(ROOT).join(file)).unwrap_or_else(|_| panic!("no file {file}"));
            let lines: Vec<_> = code.lines().map(str::trim).collect();
            let at = lines.iter().position(|line| line.starts_with(&format!("fn {name}(")));
            let at = at.unwrap_or_else(|| panic!("no test {name} in {file}"));
            assert_eq!(lines[at - 1], "#[test]", "{name} is no test");
        }
        let words = item.split('`').step_by(2).flat_map(|text| text.split([' ', ',', '.']));
        named.extend(words.filter(|word| word.starts_with('S')).map(str::to_owned));
    }
    // All experiments, and none that is not there.
    for experiment in EXPERIMENTS {
        assert!(named.iter().any(|name| name == experiment.id), "{} checks no promise", experiment.id);
    }
    for name in named {
        assert!(EXPERIMENTS.iter().any(|experiment| experiment.id == name), "no experiment {name}");
    }
}
