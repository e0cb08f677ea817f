//! S14: smooth meshes where light grazes them.

use super::scenes::{ModelFile, NUMERICS, compile, empty, matte, mesh, orthographic, picture, sun, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use super::triangles::icosphere;
use crate::description::Shading;
use glam::DVec3;

/// S14: balls of 20 to 20480 triangles with smooth normals against the ball that they stand for.
pub fn terminator(effort: &Effort) -> Vec<Sweep> {
    let (mut black, mut error) = (Vec::new(), Vec::new());
    let toward = v(0.9, 0.3, 0.3).normalize();
    let side = effort.choose(48, 400);
    let height = 2.1;
    let mut before: Option<f64> = None;
    for level in 0..=effort.choose(4, 5) {
        let triangles = icosphere(level);
        let model = ModelFile::smooth_ball(&triangles);
        let mut desc = empty(side, side, orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, height));
        desc.materials = vec![matte("ball")];
        desc.objects = vec![mesh(model.path(), 0.0, "ball")];
        desc.lights = vec![sun(toward, 1.0)];
        let mut scene = compile(&desc, None);
        let (mut tally, mut square, mut judged) = (Tally::default(), [0.0; 4], 0u64);
        let pictures = NUMERICS.map(|numerics| {
            let mut with = |shading| {
                (scene.render.numerics, scene.render.shading) = (numerics, shading);
                picture(effort, &scene)
            };
            (with(Shading::Whitted), with(Shading::Lambert))
        });
        for pixel in 0..(side * side) as usize {
            // Lit by its smooth normal, dark by the shadow of facets.
            let lost = [0, 1, 2, 3].map(|k| {
                let (shadowed, plain) = (&pictures[k].0[pixel], &pictures[k].1[pixel]);
                plain.radiance.g > 0.0 && shadowed.radiance.g == 0.0
            });
            if pictures[3].1[pixel].radiance.g > 0.0 {
                tally.judge(lost);
            }
            let place = |i: usize| ((i as f64 + 0.5) / f64::from(side) - 0.5) * height;
            let (x, y) = (place(pixel % side as usize), -place(pixel / side as usize));
            let z2 = 1.0 - x * x - y * y;
            // Away from the outline, where the mesh itself ends.
            if z2 > 0.1 {
                let right = v(x, y, z2.sqrt()).dot(toward).max(0.0);
                judged += 1;
                for k in 0..4 {
                    square[k] += (pictures[k].0[pixel].radiance.g - right).powi(2);
                }
            }
        }
        let count = triangles.len() as f64;
        black.push(Row::rates(count, &tally, 0.0));
        let rmse = square.map(|sum| (sum / judged as f64).sqrt());
        // From one level to the next, with four times the triangles, the error falls as their number to the power of -0.8.
        let threshold = before.map(|before| before * 0.25f64.powf(0.8));
        error.push(Row { difficulty: count, trials: judged, values: rmse, threshold });
        before = Some(rmse[2]);
    }
    vec![
        Sweep::new("lit pixels that are black", "triangles", black),
        Sweep::new("RMSE against the ball", "triangles", error),
    ]
}
