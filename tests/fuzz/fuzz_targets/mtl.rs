//! Material libraries, with a good model.

#![no_main]

#[path = "../targets.rs"]
#[allow(dead_code, reason = "each target uses its own")]
mod targets;

use libfuzzer_sys::fuzz_target;

const MODEL: &[u8] = b"mtllib small.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\nusemtl glass\nf 3 2 1\n";

fuzz_target!(|mtl: &[u8]| {
    let folder = std::env::temp_dir().join(format!("glimt-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a directory for the files");
    targets::model(MODEL, mtl, &folder, u64::from(mtl.first().copied().unwrap_or(0)));
});
