//! Scene files. Start from those in scenes/: `cargo +nightly fuzz run --fuzz-dir tests/fuzz scene
//! tests/fuzz/corpus/scene scenes`.

#![no_main]

#[path = "../targets.rs"]
#[allow(dead_code, reason = "each target uses its own")]
mod targets;

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    // The first byte chooses the arithmetic.
    targets::scene_text(text, Path::new("scenes/fuzz.toml"), u64::from(text.bytes().next().unwrap_or(0)));
});
