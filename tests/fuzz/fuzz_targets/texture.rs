//! Pictures of every format; the first byte chooses the extension.

#![no_main]

#[path = "../targets.rs"]
#[allow(dead_code, reason = "each target uses its own")]
mod targets;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let folder = std::env::temp_dir().join(format!("glimt-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a directory for the files");
    let Some((kind, bytes)) = bytes.split_first() else { return };
    targets::picture(bytes, ["png", "jpg", "bmp", "tga"][usize::from(kind % 4)], &folder);
});
