//! The stability study as the binary runs it: robust arithmetic holds every threshold.

use std::path::Path;
use std::process::Command;

/// The quick run, with all its files.
#[test]
fn robust_arithmetic_holds_every_threshold_of_the_quick_study() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("stability-{}", std::process::id()));
    let done = Command::new(env!("CARGO_BIN_EXE_glimt"))
        .args(["study", "stability", "--quick", "--out"])
        .arg(&out)
        .output()
        .expect("the binary runs");
    let (text, errors) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{errors}\n{text}");
    // One line for each experiment, and its files.
    let summary = text.split("Rows in which").nth(1).expect("there is a summary");
    for number in 1..=21 {
        assert!(summary.contains(&format!("  S{number} ")), "no S{number} in {summary}");
        for ending in ["csv", "json", "png", "svg"] {
            let file = out.join(format!("stability-s{number}.{ending}"));
            assert!(file.metadata().is_ok_and(|data| data.len() > 100), "{}", file.display());
        }
    }
    // The arms that are there to be compared with do fail, or the trials would be too easy.
    for id in ["S1", "S2", "S4", "S5", "S7", "S8", "S9", "S10", "S11", "S13", "S16"] {
        let line = summary.lines().find(|line| line.trim_start().starts_with(&format!("{id} "))).expect("a line each");
        let kept: Vec<_> = line.split_whitespace().filter(|word| word.contains('/')).collect();
        assert_eq!(kept.len(), 4, "{line}");
        assert_ne!(kept[0], kept[2], "classic holds all of {id}: {line}");
    }
    std::fs::remove_dir_all(out).ok();
}

#[test]
fn an_experiment_that_does_not_exist_is_refused_and_leaves_nothing() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("stability-none-{}", std::process::id()));
    let done = Command::new(env!("CARGO_BIN_EXE_glimt"))
        .args(["study", "stability", "--only", "S99", "--out"])
        .arg(&out)
        .output()
        .expect("the binary runs");
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("S1 to S21"));
    assert!(!out.exists());
}
