//! `glimt explain`: why a pixel has its colour.

use super::args::ExplainArgs;
use super::{Failure, print, say};
use crate::render::{Layers, RenderEvent, Settings, explain as replay, start};
use crate::scene::Scene;
use std::process::ExitCode;
use std::sync::Arc;

/// Prints the ray tree of a pixel.
pub fn explain(args: &ExplainArgs) -> Result<ExitCode, Failure> {
    let opened = args.scene.open(None)?;
    let scene = Arc::new(opened.compile()?);
    let (x, y) = args.pixel;
    if x >= scene.width || y >= scene.height {
        let (width, height) = (scene.width - 1, scene.height - 1);
        return Err(Failure::Asked(format!(
            "there is no pixel {x},{y}: the last one of the picture is {width},{height}"
        )));
    }
    let samples = match scene.render.error {
        // How many samples a pixel gets depends on the picture.
        Some(_) => rendered_samples(&scene, (x, y))?,
        None => scene.render.samples,
    };
    if let Some(sample) = args.sample.filter(|sample| *sample >= samples) {
        let last = samples - 1;
        let message = format!("there is no sample {sample}: the last one of this pixel is {last} (see --samples)");
        return Err(Failure::Asked(message));
    }
    let explanation = replay(&scene, &opened.desc, (x, y), samples, args.sample);
    if args.json {
        print(serde_json::to_string(&explanation).map_err(Failure::could_not)?)?;
    } else {
        print(explanation)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Samples that a pixel has at the end of a render.
fn rendered_samples(scene: &Arc<Scene>, (x, y): (u32, u32)) -> Result<u32, Failure> {
    say("rendering the picture, to learn how many samples this pixel gets");
    let mut layers = Layers::new(scene.width, scene.height);
    let handle = start(Arc::clone(scene), Settings::default());
    for event in handle.events() {
        match event {
            RenderEvent::TileFinished { tile, .. } => layers.write(tile),
            RenderEvent::Failed(error) => return Err(Failure::could_not(error)),
            _ => {}
        }
    }
    Ok(layers.samples(x, y).max(1))
}
