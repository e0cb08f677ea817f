//! Why a pixel has its colour: its samples again, one of them ray by ray.

use super::pixel::Pixel;
use super::points::film_point;
use crate::description::SceneDesc;
use crate::math::{Rgb, linear_to_srgb8};
use crate::scene::Scene;
use crate::shading::{RayCounts, RayTree, Sample, Scratch, sampler, trace_tree};
use serde::Serialize;
use std::fmt;
use std::sync::atomic::AtomicBool;

/// A pixel's colour, and the ray tree of one of its samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// Column and row.
    pub pixel: [u32; 2],
    /// How many samples its colour is the mean of, those that are not finite left out.
    pub samples: u32,
    /// Samples that are not finite.
    pub non_finite: u32,
    /// Linear light, as in the film: bit for bit.
    pub color: [f32; 3],
    /// As in the PNG.
    pub codes: [u8; 3],
    /// The sample whose rays follow, from 0.
    pub sample: u32,
    /// Where on the film it is, in pixels from the upper left corner.
    pub point: [f64; 2],
    /// What it sees.
    pub radiance: Rgb,
    /// Weight of its paths that were not followed and of the light that was not asked for.
    pub cut: f64,
    /// What those paths are taken to bring: the radiance is this and that of the tree.
    pub tail: Rgb,
    /// Its rays.
    pub tree: RayTree,
}

/// Traces `samples` samples of the pixel (x, y), as rendering does, and tells of sample `sample`, or else of the first
/// that is not finite, or else of the first. `desc`: what the scene was compiled from, for the names.
pub fn explain(scene: &Scene, desc: &SceneDesc, (x, y): (u32, u32), samples: u32, sample: Option<u32>) -> Explanation {
    let (sampler, mut scratch, stop) = (sampler(scene), Scratch::default(), AtomicBool::new(false));
    let (mut pixel, mut bad) = (Pixel::default(), None);
    let point = |index| film_point(Some(scene.render.filter), x, y, index);
    for index in 0..samples {
        let mut traced = [Sample::default()];
        sampler(scene, &[point(index)], &mut traced, &mut RayCounts::default(), &mut scratch, &stop);
        if !pixel.add(&traced[0]) {
            bad = bad.or(Some(index));
        }
    }
    let sample = sample.or(bad).unwrap_or(0);
    let (traced, tree) = trace_tree(scene, desc, point(sample));
    let color = pixel.mean().to_f32();
    Explanation {
        pixel: [x, y],
        samples,
        non_finite: pixel.non_finite(),
        color,
        codes: color.map(|c| linear_to_srgb8(f64::from(c))),
        sample,
        point: point(sample).to_array(),
        radiance: traced.radiance,
        cut: traced.cut,
        tail: traced.tail,
        tree,
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.pixel;
        writeln!(f, "pixel {x},{y}, sample {} at ({:.4} {:.4})", self.sample, self.point[0], self.point[1])?;
        write!(f, "{}", self.tree)?;
        if self.cut > 0.0 {
            let Rgb { r, g, b } = self.tail;
            writeln!(f, "not followed or asked: weight {:.3e}; paths taken to bring ({r:.5} {g:.5} {b:.5})", self.cut)?;
        }
        let ([r, g, b], [cr, cg, cb]) = (self.color, self.codes);
        let mean =
            if self.samples == 1 { "its one sample".into() } else { format!("mean of {} samples", self.samples) };
        let left_out = match self.non_finite {
            0 => String::new(),
            n => format!(", {n} of them not finite and left out"),
        };
        write!(f, "pixel {r} {g} {b} ({mean}{left_out}), sRGB {cr} {cg} {cb}")
    }
}
