//! The failure catalogue (numerics.md section 1) as pictures: what the default arithmetic must get right.

#[path = "../support/mod.rs"]
mod support;

mod degenerate;
mod edges;
mod equivariance;
mod hostile;
mod media;
mod presets;
mod surfaces;

use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::Rgb;
use std::f64::consts::TAU;
use support::*;

const WHITE: Rgb = Rgb::WHITE;

/// Bodies of all shapes and kinds over a floor, all lengths times `k`.
fn mixed(k: f64, offset: DVec3) -> SceneDesc {
    let p = |x: f64, y: f64, z: f64| v(x, y, z) * k + offset;
    let mut d = desc(96, 72, perspective(p(1.0, 2.0, 5.0), p(0.0, 0.25, 0.0), DVec3::Y, 45.0));
    d.world.background = SKY;
    d.render.max_depth = 6;
    d.materials = vec![
        MaterialDesc {
            ambient: 0.1,
            diffuse: 0.7,
            specular: 0.3,
            shininess: 12.5,
            ..bare("plain", Rgb::new(0.8, 0.5, 0.2))
        },
        MaterialDesc { texture: checker(WHITE, Rgb::new(0.1, 0.2, 0.4), 0.2), ambient: 0.1, ..matte("checker", WHITE) },
        mirror("mirror", Rgb::grey(0.04), 0.8),
        fresnel("fresnel", 1.5),
        MaterialDesc {
            specular: 0.5,
            diffuse: 0.1,
            reflect: 0.1,
            transmit: 0.8,
            ior: 1.3,
            ..bare("glass", Rgb::new(0.5, 0.1, 0.7))
        },
    ];
    d.objects = vec![
        cuboid(p(0.0, -1.0, 0.0), v(20.0, 1.0, 20.0) * k, "checker"),
        sphere(p(-1.25, 0.25, 0.25), 0.625 * k, "mirror"),
        sphere(p(0.25, 0.25, 1.25), 0.5 * k, "fresnel"),
        ObjectDesc { rotate: v(10.0, 40.0, 0.0), ..cuboid(p(1.5, 0.25, -0.25), DVec3::splat(0.875 * k), "checker") },
        at(p(0.375, 0.25, -0.75), object(ShapeDesc::Cylinder { radius: 0.375 * k, height: 1.25 * k }, "glass")),
        at(p(-0.5, 0.25, -1.25), object(ShapeDesc::Cone { radius: 0.625 * k, height: 1.5 * k }, "plain")),
        ObjectDesc {
            rotate: v(30.0, 10.0, 5.0),
            ..at(p(0.0, 1.5, -0.5), object(ShapeDesc::Quad { size: DVec2::new(1.0, 0.5) * k }, "plain"))
        },
    ];
    d.lights =
        vec![point_light(p(4.0, 6.0, 3.0), WHITE, 0.7, Falloff::None), sun(v(0.2, 1.0, 0.4), Rgb::grey(0.9), 0.3)];
    d
}

/// A cube of side 2, two triangles a face.
fn cube_obj() -> String {
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
     f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n"
        .into()
}

fn octahedron_obj() -> String {
    "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
     f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n"
        .into()
}

/// A ball of `bands` by 2 `bands` quads, each two triangles, radius 1.
fn ball_obj(bands: usize) -> String {
    let mut text = String::from("v 0 1 0\n");
    for i in 1..bands {
        for j in 0..2 * bands {
            let (t, p) = (TAU / 2.0 * i as f64 / bands as f64, TAU * j as f64 / (2 * bands) as f64);
            text += &format!("v {} {} {}\n", t.sin() * p.sin(), t.cos(), t.sin() * p.cos());
        }
    }
    text += "v 0 -1 0\n";
    let ring = |i: usize, j: usize| 2 + (i - 1) * 2 * bands + j % (2 * bands);
    let last = 2 + (bands - 1) * 2 * bands;
    for j in 0..2 * bands {
        text += &format!("f 1 {} {}\n", ring(1, j), ring(1, j + 1));
        text += &format!("f {last} {} {}\n", ring(bands - 1, j + 1), ring(bands - 1, j));
        for i in 1..bands - 1 {
            text += &format!("f {} {} {}\n", ring(i, j), ring(i + 1, j), ring(i + 1, j + 1));
            text += &format!("f {} {} {}\n", ring(i, j), ring(i + 1, j + 1), ring(i, j + 1));
        }
    }
    text
}

/// `mixed` with two instances of a model, one of glass.
fn mixed_with_model(k: f64, offset: DVec3, file: &std::path::Path) -> SceneDesc {
    let mut d = mixed(k, offset);
    for (place, scale, material) in
        [(v(0.875, 0.75, 1.0), v(0.375, 0.375, 0.375), "glass"), (v(-0.25, 0.125, 1.875), v(0.375, 0.5, 0.25), "plain")]
    {
        d.objects.push(ObjectDesc { scale: scale * k, ..at(place * k + offset, mesh(file, material)) });
    }
    d
}
