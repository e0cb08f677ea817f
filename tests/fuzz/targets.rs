//! What is fuzzed: one function a kind of file, which must neither panic nor hang nor break what it promises, whatever
//! the bytes. `tests/mutation.rs` runs them on stable Rust in every test run, `tests/fuzz/fuzz_targets` under
//! cargo-fuzz.

use glimt::assets::{load_image, load_obj};
use glimt::description::{LightDesc, Numerics, ObjectDesc, SceneDesc, ShapeDesc, parse};
use glimt::render::{self, RenderEvent, Settings};
use glimt::scene;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

const SETTINGS: Settings = Settings { threads: NonZeroUsize::MIN, tile_size: 8 };

/// The text of a scene file that is said to stand at `path`.
pub fn scene_text(text: &str, path: &Path, seed: u64) {
    match parse(text, path) {
        Ok(desc) => look(desc, seed),
        Err(errors) => {
            assert!(!errors.is_empty(), "refused without a reason");
            for e in &errors {
                assert!(e.line >= 1 && e.column >= 1 && !e.message.is_empty(), "{e:?}");
            }
        }
    }
}

/// A model with the material library `small.mtl` beside it, both written to `folder`.
pub fn model(obj: &[u8], mtl: &[u8], folder: &Path, seed: u64) {
    let file = folder.join("small.obj");
    write(&file, obj);
    write(&folder.join("small.mtl"), mtl);
    let crease = [0.0, 30.0, 180.0][(seed % 3) as usize];
    match load_obj(&file, crease, NonZeroUsize::MIN) {
        Err(error) => assert!(!error.reason.is_empty()),
        Ok(m) => {
            let n = m.positions.len();
            assert!(m.triangles.iter().flatten().all(|i| (*i as usize) < n), "an index is out of range");
            assert!(m.positions.iter().all(|p| p.is_finite()) && m.centre.is_finite());
            assert!(m.normals.is_empty() || m.normals.len() == n);
            // Unit, or zero where the faces around have none.
            let fit = |q: &glam::Vec3| *q == glam::Vec3::ZERO || (q.length() - 1.0).abs() < 1e-3;
            assert!(m.normals.iter().all(fit), "a normal is not unit");
            assert!(m.uvs.is_empty() || m.uvs.len() == n);
            assert!(m.triangle_materials.is_empty() || m.triangle_materials.len() == m.triangles.len());
            let kinds = m.materials.len().max(1);
            assert!(m.triangle_materials.iter().all(|i| (*i as usize) < kinds));
            for t in &m.triangles {
                let [a, b, c] = t.map(|i| m.positions[i as usize].as_dvec3());
                assert!((b - a).cross(c - a) != glam::DVec3::ZERO, "a triangle without area");
            }
            let mut desc = SceneDesc::default();
            desc.lights.push(LightDesc::default());
            desc.objects.push(ObjectDesc::new(ShapeDesc::Mesh { file, crease }));
            look(desc, seed);
        }
    }
}

/// A picture whose name ends in `extension`.
pub fn picture(bytes: &[u8], extension: &str, folder: &Path) {
    let file = folder.join(format!("small.{extension}"));
    write(&file, bytes);
    if let Err(error) = load_image(&file) {
        assert!(!error.reason.is_empty());
    }
}

/// A new file each time: some file systems wait for the disk when one is written over.
fn write(path: &Path, bytes: &[u8]) {
    std::fs::remove_file(path).ok();
    std::fs::write(path, bytes).expect("the fuzzer's directory can be written");
}

/// Compiles and renders a few pixels of whatever was parsed, now and then with another preset of arithmetic.
fn look(mut desc: SceneDesc, seed: u64) {
    if let Some(other) = [Numerics::Classic, Numerics::Fast, Numerics::Reference].get((seed % 8) as usize) {
        desc.render.numerics = *other;
    }
    desc.film.width = desc.film.width.min(6);
    desc.film.height = desc.film.height.min(5);
    desc.render.samples = desc.render.samples.min(2);
    desc.render.max_depth = desc.render.max_depth.min(5);
    match scene::compile(&desc, None) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(scene) => {
            let handle = render::start(Arc::new(scene), SETTINGS);
            loop {
                match handle.events().recv_timeout(Duration::from_secs(120)).expect("the render hangs") {
                    RenderEvent::TileFinished { tile, .. } => {
                        assert!(tile.pixels.iter().flatten().all(|c| !c.is_nan()), "NaN in the film");
                    }
                    RenderEvent::Finished => return,
                    RenderEvent::Failed(error) => panic!("{error}"),
                    RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
                }
            }
        }
    }
}
