//! S13: bodies of glass, water and air that hold, cut and touch each other.

use super::scenes::{SKY, apart, at, bare, checker, clear, cuboid, empty, object, perspective, pictures, sphere, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use crate::description::{MaterialDesc, ObjectDesc, SceneDesc, ShapeDesc};
use crate::math::Rgb;
use glam::DVec3;

/// Where the camera is.
const EYES: [(&str, DVec3); 4] = [
    ("seen from the air: pixels off", DVec3::new(0.3, 0.8, 6.0)),
    ("seen from the water: pixels off", DVec3::new(0.3, 0.2, 1.3)),
    ("seen from the glass: pixels off", DVec3::new(0.01, 0.75, 0.0)),
    ("seen from the bubble: pixels off", DVec3::new(0.05, 0.02, 0.1)),
];

/// A ball of glass with a bubble of air in a block of water.
fn tank(side: u32, eye: DVec3, objects: &[ObjectDesc]) -> SceneDesc {
    let mut desc = empty(side * 4 / 3, side, perspective(eye, v(-0.1, 0.0, 0.0), 40.0));
    desc.world.background = SKY;
    // A seam between bodies costs a ray that crosses it a step of depth, and rays that start in the water are caught in
    // the block for long: with 40 steps, 6 of 27,648 pixels ended black with the seam and not without, in any
    // arithmetic. With the most that a scene may ask for, none does.
    desc.render.max_depth = 64;
    let floor = MaterialDesc {
        ambient: 1.0,
        texture: checker([Rgb::WHITE, Rgb::new(0.1, 0.2, 0.5)], 0.5),
        ..bare("floor", Rgb::WHITE)
    };
    desc.materials = vec![
        clear("glass", 1.5),
        clear("air", 1.0),
        clear("water", 1.33),
        MaterialDesc { priority: 2, ..clear("strong air", 1.0) },
        MaterialDesc { priority: 1, ..clear("strong glass", 1.5) },
        floor,
    ];
    desc.objects = objects.to_vec();
    desc.objects.push(at(v(0.0, -3.0, 0.0), object(ShapeDesc::Plane, "floor")));
    desc
}

/// S13: the block in two halves that overlap by less and less, the balls by priority, against the whole block with
/// balls of which the smaller wins.
pub fn media(effort: &Effort) -> Vec<Sweep> {
    let side = effort.choose(36, 144);
    let whole = [
        cuboid(DVec3::ZERO, v(4.0, 3.0, 4.0), "water"),
        sphere(DVec3::ZERO, 1.0, "glass"),
        sphere(v(0.1, 0.0, 0.0), 0.5, "air"),
    ];
    let sweeps = EYES.iter().map(|&(measure, eye)| {
        let [_, _, _, twin] = pictures(effort, &tank(side, eye, &whole));
        let rows = [0.5, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12, 2f64.powi(-53)].map(|overlap| {
            // The last one is less than the coordinates can tell: the halves touch.
            let half = |sign: f64| {
                let width = 2.0 + overlap / 2.0;
                cuboid(v(sign * (2.0 - width / 2.0), 0.0, 0.0), v(width, 3.0, 4.0), "water")
            };
            let parts = [
                sphere(v(0.1, 0.0, 0.0), 0.5, "strong air"),
                half(-1.0),
                half(1.0),
                sphere(DVec3::ZERO, 1.0, "strong glass"),
            ];
            let pictures = pictures(effort, &tank(side, eye, &parts));
            let mut tally = Tally::default();
            for (pixel, right) in twin.iter().enumerate() {
                tally.judge([0, 1, 2, 3].map(|preset| apart(&pictures[preset][pixel], right)));
            }
            Row::rates(1.0 / overlap, &tally, 0.0)
        });
        Sweep::new(measure, "size / overlap", rows.to_vec())
    });
    sweeps.collect()
}
