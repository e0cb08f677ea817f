//! S18: numbers that mean harm. Whatever is asked for, there is an error message or a picture; never a panic, never a
//! NaN.

use super::scenes::{NUMERICS, at, clear, cuboid, empty, matte, object, perspective, picture, point_light, sphere, v};
use super::sweep::{Row, Sweep};
use super::trials::{Effort, Tally};
use crate::description::*;
use crate::math::Rgb;
use crate::scene;
use crate::shading::Sample;
use glam::{DVec2, DVec3};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Judges a description in every preset: bad are panics and what `is_bad` says of a sample. An error is a fair answer.
fn judge(effort: &Effort, desc: &SceneDesc, tally: &mut Tally, is_bad: impl Fn(&Sample) -> bool) {
    let failed = NUMERICS.map(|numerics| {
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            let mut scene = scene::compile(desc, None).ok()?;
            scene.render.numerics = numerics;
            Some(picture(effort, &scene))
        }));
        match outcome {
            Ok(Some(samples)) => samples.iter().any(&is_bad),
            Ok(None) => false,
            Err(_panic) => true,
        }
    });
    tally.judge(failed);
}

fn not_finite(sample: &Sample) -> bool {
    !sample.radiance.is_finite()
}

/// A ball, a block of glass and a floor under a lamp.
fn still_life() -> SceneDesc {
    let mut desc = empty(24, 18, perspective(v(1.0, 2.0, 5.0), DVec3::ZERO, 45.0));
    desc.materials = vec![
        MaterialDesc { specular: 0.5, shininess: 2.5, reflect: 0.2, ..matte("matte") },
        MaterialDesc { fresnel: true, ..clear("glass", 1.5) },
    ];
    desc.objects = vec![
        sphere(v(-1.0, 0.5, 0.0), 0.5, "matte"),
        cuboid(v(1.0, 0.5, 0.0), DVec3::ONE, "glass"),
        object(ShapeDesc::Plane, "matte"),
    ];
    desc.lights = vec![point_light(v(2.0, 4.0, 3.0), 1.0, Falloff::InverseSquare)];
    desc
}

/// S18
pub fn hostile(effort: &Effort) -> Vec<Sweep> {
    let rows = |difficulties: &[f64], case: &dyn Fn(f64, &mut Tally)| {
        let rows = difficulties.iter().map(|&difficulty| {
            let mut tally = Tally::default();
            case(difficulty, &mut tally);
            Row::rates(difficulty, &tally, 0.0)
        });
        rows.collect::<Vec<_>>()
    };
    let flattened = rows(&[1.0, 1e4, 1e8, 1e16, 1e30], &|ratio, tally| {
        for shape in [
            ShapeDesc::Sphere { radius: 1.0 },
            ShapeDesc::Cuboid { size: DVec3::ONE },
            ShapeDesc::Cylinder { radius: 1.0, height: 1.0 },
            ShapeDesc::Cone { radius: 1.0, height: 1.0 },
            ShapeDesc::Plane,
            ShapeDesc::Quad { size: DVec2::ONE },
        ] {
            for scale in [v(1.0, 1.0 / ratio, 1.0), v(ratio, 1.0, -1.0), v(1.0, ratio.powi(9), 1.0 / ratio.powi(10))] {
                for material in ["matte", "glass"] {
                    let mut desc = still_life();
                    let turned = ObjectDesc { rotate: v(20.0, 30.0, 0.0), ..object(shape.clone(), material) };
                    desc.objects.push(ObjectDesc { scale, ..at(v(0.0, 0.7, 1.0), turned) });
                    judge(effort, &desc, tally, not_finite);
                }
            }
        }
    });
    let narrow = rows(&[1.0, 2.0, 7.0, 100.0, 3000.0], &|side, tally| {
        for (width, height) in [(1, side as u32), (side as u32, 1)] {
            let mut desc = still_life();
            desc.film = FilmDesc { width, height };
            judge(effort, &desc, tally, not_finite);
        }
    });
    let near_light = rows(&[1e0, 1e4, 1e8, 1e12, 1e16, 1e30], &|closeness, tally| {
        // Over the point of the floor that the middle of the picture sees, at the rim of a block, in a ball's surface.
        for place in [v(0.0, 0.0, 0.0), v(1.5, 1.0, 0.5), v(-1.0, 1.0, 0.0)] {
            for falloff in [Falloff::None, Falloff::InverseSquare] {
                let mut desc = still_life();
                desc.camera.look_at = place;
                desc.lights.push(point_light(place + DVec3::Y / closeness, 1.0, falloff));
                judge(effort, &desc, tally, not_finite);
            }
        }
    });
    let coincident = rows(&[2f64.powi(50), 2f64.powi(51), 2f64.powi(52), 1e30], &|closeness, tally| {
        // Two blocks in the same place up to rounding, the first of them red: no speck of green is seen.
        for rotate in [DVec3::ZERO, v(33.0, 20.0, 71.0)] {
            for shape in [ShapeDesc::Cuboid { size: DVec3::ONE }, ShapeDesc::Quad { size: DVec2::ONE }] {
                let mut desc = empty(40, 30, perspective(v(2.0, 2.0, 3.0), DVec3::ZERO, 40.0));
                let flat = |name: &str, color| MaterialDesc { ambient: 1.0, color, diffuse: 0.0, ..matte(name) };
                desc.materials = vec![flat("red", Rgb::new(1.0, 0.0, 0.0)), flat("green", Rgb::new(0.0, 1.0, 0.0))];
                let block = |material: &str| ObjectDesc { rotate, ..object(shape.clone(), material) };
                desc.objects = vec![block("red"), at(DVec3::splat(1.0 / closeness), block("green"))];
                judge(effort, &desc, tally, |s| not_finite(s) || s.radiance.g > 0.0);
            }
        }
    });
    let text = rows(&[1.0], &|_, tally| {
        for number in ["nan", "inf", "-inf", "1e999", "-1e999", "1e308", "-0.0", "0", "5e-324", "-1"] {
            for line in [
                format!("[camera]\nposition = [{number}, 0, 5]"),
                format!("[camera]\nfov = {number}"),
                format!("[film]\nwidth = {number}"),
                format!("[render]\nsamples = {number}"),
                format!("[[object]]\nshape = \"sphere\"\nradius = {number}"),
                format!("[[object]]\nshape = \"cuboid\"\nsize = [1, {number}, 1]\nscale = [{number}, 1, 1]"),
                format!("[[object]]\nshape = \"cone\"\nradius = 1\nheight = {number}\nrotate = [0, {number}, 0]"),
                format!("[[light]]\nposition = [{number}, 1, 1]\nintensity = {number}\n[[object]]\nshape = \"plane\""),
                format!(
                    "[[material]]\nname = \"m\"\nior = {number}\ntransmit = 1\n[[object]]\nshape = \"quad\"\nsize = [1, 1]"
                ),
            ] {
                let parsed = catch_unwind(|| parse(&line, Path::new("hostile.toml")));
                match parsed {
                    Ok(Ok(mut desc)) => {
                        desc.film = FilmDesc { width: 8, height: 6 };
                        desc.render.samples = 1;
                        judge(effort, &desc, tally, not_finite);
                    }
                    Ok(Err(_)) => tally.judge([false; 4]),
                    Err(_panic) => tally.judge([true; 4]),
                }
            }
        }
    });
    vec![
        Sweep::new("panic or NaN: bodies flattened", "ratio of scales", flattened),
        Sweep::new("panic or NaN: pictures of one row or column", "pixels", narrow),
        Sweep::new("panic or NaN: lights on surfaces", "1 / distance", near_light),
        Sweep::new("specks of a coincident body", "size / displacement", coincident),
        Sweep::new("panic or NaN: hostile numbers in a scene file", "files", text),
    ]
}
