//! Colours of pictures and patterns on surfaces.

use crate::support::*;
use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::{Rgb, srgb8_to_linear};
use std::path::{Path, PathBuf};

const SIZE: (usize, usize) = (5, 4);

/// Codes of texel (i, j), row 0 on top: all different, no symmetry.
fn texel(i: usize, j: usize) -> [u8; 3] {
    [(40 * i + 13 * j) as u8, (250 - 31 * i - 20 * j) as u8, (17 * i * j + 60) as u8]
}

fn picture(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.png", std::process::id()));
    let texels: Vec<u8> = (0..SIZE.1).flat_map(|j| (0..SIZE.0).flat_map(move |i| texel(i, j))).collect();
    image::save_buffer(&path, &texels, SIZE.0 as u32, SIZE.1 as u32, image::ExtendedColorType::Rgb8)
        .expect("a picture can be written");
    path
}

/// The place of a texel index that may lie outside of 0..n.
fn wrapped(i: i64, n: i64, wrap: Wrap) -> usize {
    (match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    }) as usize
}

/// Bilinear: texel centres at (i + 1/2) / W, v upward, blended in linear light.
fn bilinear(uv: DVec2, wrap: Wrap) -> [f64; 3] {
    let (w, h) = (SIZE.0 as f64, SIZE.1 as f64);
    let (x, y) = (uv.x * w - 0.5, (1.0 - uv.y) * h - 0.5);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let at = |dx: i64, dy: i64| {
        let i = wrapped(x.floor() as i64 + dx, SIZE.0 as i64, wrap);
        let j = wrapped(y.floor() as i64 + dy, SIZE.1 as i64, wrap);
        texel(i, j).map(srgb8_to_linear)
    };
    let row = |dy: i64| plus(scale(at(0, dy), 1.0 - fx), scale(at(1, dy), fx));
    plus(scale(row(0), 1.0 - fy), scale(row(1), fy))
}

#[test]
fn a_picture_is_blended_between_texels_in_linear_light_and_continued_as_asked() {
    // A plane seen from straight above: u = x, v = -z in scene units, the picture upright for an eye with -z upward.
    let file = picture("bilinear");
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
        for (stretch, offset) in [(DVec2::ONE, DVec2::ZERO), (DVec2::new(0.7, -1.3), DVec2::new(0.25, 3.4))] {
            let mut d = desc(70, 60, orthographic(v(0.3, 5.0, -0.4), v(0.3, 0.0, -0.4), DVec3::NEG_Z, 3.3));
            let source = TextureSource::Image { file: file.clone(), wrap };
            let texture = Some(TextureDesc { source, scale: stretch, offset });
            d.materials = vec![MaterialDesc { texture, ..flat("picture", Rgb::WHITE) }];
            d.objects = vec![object(ShapeDesc::Plane, "picture")];
            assert_image("bilinear", &render(&d), Tolerance { absolute: 1e-6, ..EXACT }, |x, y| {
                let (o, _) = pixel_ray(&d, x, y);
                Some(bilinear(DVec2::new(o.x, -o.z) * stretch + offset, wrap))
            });
        }
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn pictures_stand_upright_on_every_face_of_a_cuboid_and_around_ball_cylinder_and_cone() {
    // Seen from outside with the shape's y (for lids -z, for the floor +z) upward, u runs to the right and v upward.
    let file = picture("upright");
    let mut d = desc(50, 50, CameraDesc::default());
    let texture = Some(TextureDesc {
        source: TextureSource::Image { file: file.clone(), wrap: Wrap::Clamp },
        scale: DVec2::ONE,
        offset: DVec2::ZERO,
    });
    d.materials = vec![MaterialDesc { texture, ..flat("picture", Rgb::WHITE) }];
    let size = v(2.0, 1.5, 1.2);
    d.objects = vec![cuboid(DVec3::ZERO, size, "picture")];
    for (toward, up) in [
        (DVec3::Z, DVec3::Y),
        (DVec3::NEG_Z, DVec3::Y),
        (DVec3::X, DVec3::Y),
        (DVec3::NEG_X, DVec3::Y),
        (DVec3::Y, DVec3::NEG_Z),
        (DVec3::NEG_Y, DVec3::Z),
    ] {
        let right = up.cross(toward);
        d.camera = orthographic(toward * 5.0, DVec3::ZERO, up, 2.1);
        assert_image("upright-cuboid", &render(&d), Tolerance { absolute: 1e-6, ..EXACT }, |x, y| {
            let (o, _) = pixel_ray(&d, x, y);
            let (s, t) = (o.dot(right) / size.dot(right.abs()), o.dot(up) / size.dot(up.abs()));
            if s.abs().max(t.abs()) > 0.5 {
                return Some([0.0; 3]);
            }
            Some(bilinear(DVec2::new(0.5 + s, 0.5 + t), Wrap::Clamp))
        });
    }
    // u = 1/2 looks along +z and grows toward +x, as a label around a tin.
    d.camera = orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 2.1);
    let around = |x: f64, radius: f64| 0.5 + (x / radius).asin() / std::f64::consts::TAU;
    let shapes = [
        ShapeDesc::Sphere { radius: 1.0 },
        ShapeDesc::Cylinder { radius: 0.8, height: 1.6 },
        ShapeDesc::Cone { radius: 0.8, height: 1.6 },
    ];
    for shape in shapes {
        d.objects = vec![object(shape.clone(), "picture")];
        assert_image("upright-round", &render(&d), Tolerance { absolute: 1e-6, ..EXACT }, |x, y| {
            let (o, _) = pixel_ray(&d, x, y);
            let (radius, height) = match shape {
                ShapeDesc::Sphere { .. } => ((1.0 - o.y * o.y).max(0.0).sqrt(), 2.0),
                ShapeDesc::Cone { .. } => (0.8 * (0.5 - o.y / 1.6), 1.6),
                _ => (0.8, 1.6),
            };
            if o.y.abs() >= height / 2.0 || o.x.abs() >= radius {
                return Some([0.0; 3]);
            }
            let v = match shape {
                ShapeDesc::Sphere { .. } => 0.5 + o.y.asin() / std::f64::consts::PI,
                _ => 0.5 + o.y / height,
            };
            Some(bilinear(DVec2::new(around(o.x, radius), v), Wrap::Clamp))
        });
    }
    std::fs::remove_file(file).ok();
}
