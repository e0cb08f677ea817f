//! What keys do to the description.

use super::camera;
use super::command::Command;
use super::format::{samples, view};
use crate::description::{RenderDesc, SceneDesc, Shading, limits};

/// Steps of one key press.
const ORBIT_DEGREES: f64 = 5.0;
const PAN_PART: f64 = 0.05;
const DOLLY_FACTOR: f64 = 0.9;
const FOV_FACTOR: f64 = 1.05;

/// Changes camera or render settings as the command tells; other commands change nothing. `original`: as it was at the
/// start. Returns what to tell the user, if it can not be seen.
pub fn edit(desc: &mut SceneDesc, original: &SceneDesc, command: Command) -> Option<String> {
    let (camera, render) = (&mut desc.camera, &mut desc.render);
    match command {
        Command::Orbit(right, above) => {
            let [right, above] = [right, above].map(|steps| f64::from(steps) * ORBIT_DEGREES);
            camera::orbit(camera, right, above);
            None
        }
        Command::Pan(right, above) => {
            let [right, above] = [right, above].map(|steps| f64::from(steps) * PAN_PART);
            camera::pan(camera, right, above);
            None
        }
        Command::Dolly(steps) => {
            camera::dolly(camera, DOLLY_FACTOR.powi(steps.into()));
            None
        }
        Command::Widen(steps) => {
            camera::widen(camera, FOV_FACTOR.powi(steps.into()));
            Some(view(camera.projection))
        }
        Command::ResetCamera => {
            *camera = original.camera;
            Some("the camera is that of the scene again".into())
        }
        Command::Samples(doublings) => {
            if let Some(error) = render.error {
                let (least, most) = (*limits::ERROR.start(), *limits::ERROR.end());
                let error = (error * 0.5f64.powi(doublings.into())).clamp(least, most);
                render.error = Some(error);
                return Some(format!("until the error is {error} of 255"));
            }
            let count = if doublings > 0 { render.samples.saturating_mul(2) } else { render.samples / 2 };
            render.samples = count.clamp(1, limits::MAX_SAMPLES);
            Some(format!("{} a pixel", samples(render.samples)))
        }
        Command::ToggleAdaptive => {
            let uniform = (original.render.error.is_none()).then_some(original.render.samples);
            (render.error, render.samples) = match render.error {
                None => (Some(limits::USUAL_ERROR), limits::ADAPTIVE_SAMPLES),
                Some(_) => (None, uniform.unwrap_or(RenderDesc::default().samples)),
            };
            Some(match render.error {
                Some(error) => format!("until the error is {error} of 255"),
                None => format!("{} a pixel", samples(render.samples)),
            })
        }
        Command::Depth(more) => {
            render.max_depth = render.max_depth.saturating_add_signed(more.into()).min(limits::MAX_DEPTH);
            Some(format!("depth {}", render.max_depth))
        }
        Command::CycleShading => {
            render.shading = match render.shading {
                Shading::Lambert => Shading::Phong,
                Shading::Phong => Shading::Whitted,
                Shading::Whitted => Shading::Lambert,
            };
            Some(format!("lighting model {}", render.shading.name()))
        }
        _ => None,
    }
}
