//! Every scene in tests/scenes/bad is refused with the message that stands beside it in a `.txt` file, to the letter.
//!
//! After a change of messages run `GLIMT_BLESS=1 cargo test --test bad_scenes` and read the difference: the texts are
//! a promise to the user, and whoever blesses them has read them.

use std::fs;
use std::path::{Path, PathBuf};

fn scenes() -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/bad");
    let mut scenes: Vec<_> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    scenes.sort();
    scenes
}

/// What a user sees of the scene's mistakes, with paths as from its own directory.
fn messages(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let Err(mistakes) = glimt::description::parse(&text, path) else { return "no mistake\n".to_owned() };
    let directory = format!("{}/", path.parent().unwrap().display());
    let shown: Vec<_> = mistakes.iter().map(|mistake| mistake.render(false).replace(&directory, "")).collect();
    shown.join("\n\n") + "\n"
}

#[test]
fn every_bad_scene_is_refused_with_the_message_beside_it() {
    let bless = std::env::var_os("GLIMT_BLESS").is_some();
    let scenes = scenes();
    assert!(scenes.len() >= 40, "only {} scenes found", scenes.len());
    let mut wrong = Vec::new();
    for path in scenes {
        let found = messages(&path);
        let beside = path.with_extension("txt");
        if bless {
            fs::write(&beside, &found).unwrap();
        }
        let expected = fs::read_to_string(&beside).unwrap_or_default();
        if found != expected || found == "no mistake\n" {
            wrong.push(format!("{}\nexpected:\n{expected}\nfound:\n{found}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
