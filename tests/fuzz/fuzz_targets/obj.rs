//! Models, with a good material library.

#![no_main]

#[path = "../targets.rs"]
#[allow(dead_code, reason = "each target uses its own")]
mod targets;

use libfuzzer_sys::fuzz_target;

const MATERIALS: &[u8] = b"newmtl red\nKd 1 0 0\nnewmtl glass\nd 0.2\nNi 1.5\n";

fuzz_target!(|obj: &[u8]| {
    let folder = std::env::temp_dir().join(format!("glimt-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a directory for the files");
    targets::model(obj, MATERIALS, &folder, u64::from(obj.first().copied().unwrap_or(0)));
});
