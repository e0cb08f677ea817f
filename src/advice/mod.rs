//! What a scene pays for and does not need: "model no more than a scene needs".
//!
//! Every [`Advice`] is a [`Change`] of the description whose worth was measured, not guessed: the scene is rendered
//! small with and without it, by the renderer itself, and rays, time and pixels are compared.

mod change;
mod coarse;
mod solid;
mod trial;

pub use change::{Change, CoarseModel};
pub use trial::Failure;

use crate::description::{Numerics, SceneDesc, Shading, ShapeDesc, limits};
use crate::render::{JUDGED, Settings};
use crate::scene::{Scene, Shape};
use std::collections::HashSet;
use trial::{Bench, Weighed};

/// A change that is worth making.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// What to do.
    pub change: Change,
    /// Why, in one line for people, safe to print.
    pub reason: String,
    /// Part of the rays that it saves, 0 to 1.
    pub rays: f64,
    /// Part of the time that it saves; negative if it took longer. Times scatter by some percent.
    pub time: f64,
    /// Root mean square of what it changes in the picture, 8-bit codes.
    pub rmse: f64,
    /// The largest change of a channel of a pixel, 8-bit codes.
    pub largest: f64,
}

/// What a change may do to the picture and still be advised.
#[derive(Clone, Copy)]
enum Allowed {
    /// No pixel changes by half a code.
    Nothing,
    /// The root mean square of the changes is below half a code.
    Noise,
    /// What a quarter of a pixel does at the outline.
    Outline,
}

/// Half of a step of 8-bit codes: less is not seen in a PNG but by rounding.
const HALF: f64 = 0.5;
/// Most lights, textures and objects that are tried one by one.
const MOST: usize = 32;
/// A shape may replace a mesh that differs from it by no more pixels than this.
const QUARTER: f64 = 0.25;
/// Triangles of less than this part of a pixel are too many.
const TENTH: f64 = 0.1;
/// What takes other samples must save this part of the rays.
const WORTH_RAYS: f64 = 0.1;
/// What changes only the time must save this part of it to be advised.
const WORTH: f64 = 0.05;

/// Measures what could be left out of a scene that compiles. `compiled` lends models and pictures; `stop` is asked
/// between trials and ends it.
pub fn advise(
    desc: &SceneDesc,
    compiled: &Scene,
    settings: Settings,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Advice>, Failure> {
    let mut bench = Bench::new(desc, compiled, settings, stop)?;
    let mut advice = Vec::new();
    let local = shading(&mut bench, &mut advice)?;
    if desc.render.shading == Shading::Whitted && !local {
        depth(&mut bench, &mut advice)?;
    }
    lights(&mut bench, &mut advice)?;
    unseen(&mut bench, &mut advice)?;
    textures(&mut bench, &mut advice)?;
    solids(&mut bench, &mut advice)?;
    triangles(&mut bench, &mut advice)?;
    samples(&mut bench, &mut advice)?;
    target(&mut bench, &mut advice)?;
    numerics(&mut bench, &mut advice)?;
    advice.sort_by(|a, b| (b.rays.max(b.time)).total_cmp(&a.rays.max(a.time)));
    Ok(advice)
}

/// Tries a change, and keeps it if the picture allows; whether it does.
fn consider(
    bench: &mut Bench,
    advice: &mut Vec<Advice>,
    change: Change,
    allowed: Allowed,
    reason: impl FnOnce(&SceneDesc) -> String,
) -> Result<bool, Failure> {
    let fits = |weighed: &Weighed| match allowed {
        Allowed::Nothing => weighed.largest < HALF,
        Allowed::Noise => weighed.rmse < HALF,
        Allowed::Outline => true,
    };
    let Some(Weighed { rays, time, rmse, largest }) = bench.weigh(&change, fits)? else { return Ok(false) };
    let reason = reason(bench.desc());
    advice.push(Advice { change, reason, rays, time, rmse, largest });
    Ok(true)
}

/// A lighting model with fewer terms that gives the same picture.
fn shading(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<bool, Failure> {
    let simpler: &[Shading] = match bench.desc().render.shading {
        Shading::Lambert => &[],
        Shading::Phong => &[Shading::Lambert],
        Shading::Whitted => &[Shading::Lambert, Shading::Phong],
    };
    for model in simpler {
        let reason =
            |desc: &SceneDesc| format!("nothing that {} adds to {} is seen", desc.render.shading.name(), model.name());
        if consider(bench, advice, Change::Shading(*model), Allowed::Nothing, reason)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The least depth that gives the same picture.
fn depth(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    for depth in 0..bench.desc().render.max_depth {
        let reason = |desc: &SceneDesc| match depth {
            0 => "no mirror and no glass is seen".to_owned(),
            _ => format!("nothing is seen of what lies deeper than {depth} (of {})", desc.render.max_depth),
        };
        if consider(bench, advice, Change::Depth(depth), Allowed::Nothing, reason)? {
            break;
        }
    }
    Ok(())
}

fn lights(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let lights: Vec<usize> = (0..bench.desc().lights.len()).filter(|&i| bench.desc().lights[i].visible).collect();
    for index in lights.into_iter().take(MOST) {
        consider(bench, advice, Change::HideLight(index), Allowed::Nothing, |_| "it lights nothing".into())?;
    }
    Ok(())
}

/// Objects that are not seen, neither directly nor in mirrors, and throw no shadow that is.
fn unseen(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let scene = bench.scene();
    let (width, height) = (scene.width, scene.height);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let seen: HashSet<usize> = pixels.filter_map(|(x, y)| scene.pick(x, y)).map(|pick| pick.object).collect();
    let objects = &bench.desc().objects;
    let hidden: Vec<usize> = (0..objects.len()).filter(|i| objects[*i].visible && !seen.contains(i)).collect();
    if hidden.is_empty() {
        return Ok(());
    }
    let reason = |_: &SceneDesc| "nothing of it is seen, nor its shadow, nor its mirror image".to_owned();
    if !consider(bench, advice, Change::HideObjects(hidden.clone()), Allowed::Nothing, reason)? && hidden.len() > 1 {
        for index in hidden.into_iter().take(MOST) {
            consider(bench, advice, Change::HideObjects(vec![index]), Allowed::Nothing, reason)?;
        }
    }
    Ok(())
}

fn textures(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let materials = &bench.desc().materials;
    let used: HashSet<&str> = bench.desc().objects.iter().filter_map(|o| o.material.as_deref()).collect();
    let textured = |&i: &usize| materials[i].texture.is_some() && used.contains(materials[i].name.as_str());
    let textured: Vec<usize> = (0..materials.len()).filter(textured).collect();
    for index in textured.into_iter().take(MOST) {
        let reason = |_: &SceneDesc| "its texture is not seen".to_owned();
        consider(bench, advice, Change::RemoveTexture(index), Allowed::Nothing, reason)?;
    }
    Ok(())
}

/// Meshes that are spheres or boxes.
fn solids(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let scene = bench.scene();
    let desc = bench.desc().clone();
    let mut found = Vec::new();
    for object in scene.objects() {
        let (index, Shape::Mesh(mesh)) = (object.source as usize, &object.shape) else { continue };
        let own = &desc.objects[index];
        let material = own.material.as_ref().and_then(|name| desc.materials.iter().find(|m| m.name == *name));
        // What the model's file says of materials and textures would be lost.
        let is_plain = material.map_or(mesh.materials.is_empty(), |material| material.texture.is_none());
        if !is_plain || !matches!(own.shape, ShapeDesc::Mesh { .. }) {
            continue;
        }
        let Some(pixel) = solid::pixel_size(&desc, object) else { continue };
        if let Some(solid) = solid::fit(mesh, own, QUARTER * pixel) {
            found.push((index, mesh.len(), solid));
        }
    }
    for (index, triangles, solid) in found.into_iter().take(MOST) {
        let shape = solid::word(&solid.shape);
        let reason = |_: &SceneDesc| format!("its {triangles} triangles are a {shape} to within a quarter of a pixel");
        consider(bench, advice, Change::Replace(index, Box::new(solid)), Allowed::Outline, reason)?;
    }
    Ok(())
}

/// Meshes whose triangles are below a tenth of a pixel where they are nearest to the eye.
fn triangles(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let scene = bench.scene();
    let desc = bench.desc().clone();
    let mut found: Vec<(usize, usize, usize, CoarseModel)> = Vec::new();
    for object in scene.objects().iter().filter(|object| !advised(advice, object.source as usize)) {
        let (index, Shape::Mesh(mesh)) = (object.source as usize, &object.shape) else { continue };
        let own = &desc.objects[index];
        let ShapeDesc::Mesh { file, .. } = &own.shape else { continue };
        let material = own.material.as_ref().and_then(|name| desc.materials.iter().find(|m| m.name == *name));
        // What the file says of materials and textures would be lost, and glass must stay closed.
        let is_plain = material.map_or(mesh.materials.is_empty(), |m| m.texture.is_none() && m.transmit == 0.0);
        let Some(pixel) = solid::pixel_size(&desc, object).filter(|_| is_plain) else { continue };
        let cell = pixel / own.scale.abs().max_element();
        if coarse::mean_area(mesh) >= TENTH * cell * cell {
            continue;
        }
        let (text, left) = coarse::coarser(mesh, cell / 2.0);
        if left > 0 && left <= mesh.len() / 2 {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            // No file is written over.
            let names =
                (1..100).map(|n| format!("{stem}-coarse{}.obj", if n == 1 { String::new() } else { n.to_string() }));
            let free = names.map(|name| file.with_file_name(name)).find(|file| !file.exists());
            found.extend(free.map(|file| (index, mesh.len(), left, CoarseModel { file, text })));
        }
    }
    for (index, before, left, model) in found.into_iter().take(MOST) {
        let reason =
            |_: &SceneDesc| format!("its {before} triangles are below a tenth of a pixel; {left} look the same");
        consider(bench, advice, Change::Coarsen(index, model.into()), Allowed::Noise, reason)?;
    }
    Ok(())
}

/// Whether an object becomes something simpler anyway.
fn advised(advice: &[Advice], object: usize) -> bool {
    advice.iter().any(|advice| match &advice.change {
        Change::Replace(index, _) => *index == object,
        Change::HideObjects(objects) => objects.contains(&object),
        _ => false,
    })
}

/// The fewest samples whose picture is the same but for noise below half a code.
fn samples(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    if bench.desc().render.error.is_some() {
        // They end by themselves when the error is small enough.
        return Ok(());
    }
    let mut best = Vec::new();
    let mut fewer = bench.desc().render.samples / 2;
    while fewer >= 1 {
        let reason = |desc: &SceneDesc| {
            format!("the picture of {} samples differs by less than half a code", desc.render.samples)
        };
        let mut one = Vec::new();
        if !consider(bench, &mut one, Change::Samples(fewer), Allowed::Noise, reason)? {
            break;
        }
        best = one;
        fewer /= 2;
    }
    advice.append(&mut best);
    Ok(())
}

/// Samples everywhere, though most pixels have come to the usual target before: those beyond it.
fn target(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let render = bench.desc().render;
    if render.error.is_some() || render.samples <= JUDGED {
        // Fewer samples than can be judged are the same everywhere.
        return Ok(());
    }
    let mut one = Vec::new();
    let reason =
        |_: &SceneDesc| "samples beyond it change no pixel that is seen; they go where the picture needs them".into();
    consider(bench, &mut one, Change::Error(limits::USUAL_ERROR), Allowed::Noise, reason)?;
    advice.extend(one.into_iter().filter(|one| one.rays > WORTH_RAYS));
    Ok(())
}

/// Arithmetic that is quicker and gives the same picture.
fn numerics(bench: &mut Bench, advice: &mut Vec<Advice>) -> Result<(), Failure> {
    let quicker = match bench.desc().render.numerics {
        Numerics::Reference => Numerics::Robust,
        Numerics::Robust | Numerics::Classic => Numerics::Fast,
        Numerics::Fast => return Ok(()),
    };
    let mut one = Vec::new();
    let reason = |desc: &SceneDesc| format!("{} gives the picture of {}", quicker.name(), desc.render.numerics.name());
    consider(bench, &mut one, Change::Numerics(quicker), Allowed::Nothing, reason)?;
    advice.extend(one.into_iter().filter(|one| one.time > WORTH));
    Ok(())
}
