//! Items 3 and 12: projected outlines.

use crate::support::*;
use glam::{DQuat, DVec2, DVec3};
use glimt::description::*;
use glimt::math::Rgb;
use std::f64::consts::{PI, TAU};

/// One white object without light or shade, on black.
fn silhouette(mut d: SceneDesc, object: ObjectDesc) -> SceneDesc {
    d.materials.push(flat("white", Rgb::WHITE));
    d.objects.push(object);
    d
}

#[test]
fn a_ball_in_perspective_covers_exactly_the_pixels_inside_its_cone() {
    // A ray from the eye meets the ball exactly if the angle to its centre is below asin(r/D).
    for (c, r) in
        [(v(0.0, 0.0, -5.0), 1.5), (v(2.1, 1.4, -5.0), 1.0), (v(-3.0, -2.0, -4.0), 0.8), (v(0.5, 0.5, -9.0), 8.9)]
    {
        let d = desc(200, 150, perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 75.0));
        let d = silhouette(d, sphere(c, r, "white"));
        let excluded = assert_exact("ball-outline", &d, 1e-12, |x, y| {
            let (_, dir) = pixel_ray(&d, x, y);
            let margin = c.dot(dir) - (c.length_squared() - r * r).sqrt();
            (margin.abs() > 1e-11).then_some([if margin > 0.0 { 1.0 } else { 0.0 }; 3])
        });
        assert!(excluded <= 2);
    }
}

#[test]
fn the_image_of_a_ball_has_the_area_of_its_conic() {
    // On a picture at distance f from the eye the outline is an ellipse of area
    // pi f² sin²b cos b / (cos²p - sin²b)^(3/2), sin b = r/D, p the angle from the axis; on the axis a circle of
    // radius f r / sqrt(D² - r²).
    let (w, h, fov) = (400, 300, 70.0_f64);
    let pixel = 2.0 * (fov.to_radians() / 2.0).tan() / f64::from(h); // f = 1
    for (c, r) in [(v(0.0, 0.0, -4.0), 1.6), (v(1.2, -0.7, -4.0), 0.9), (v(-1.9, 1.0, -4.0), 0.8)] {
        let mut d = desc(w, h, perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov));
        d.render.samples = 16;
        let film = render(&silhouette(d, sphere(c, r, "white")));
        let distance = c.length();
        let (sin_b, cos_p) = (r / distance, -c.z / distance);
        let area = PI * sin_b.powi(2) * (1.0 - sin_b * sin_b).sqrt() / (cos_p * cos_p - sin_b * sin_b).powf(1.5);
        let got = sum(&film) * pixel * pixel;
        // As an offset of the whole outline, in pixels: an ellipse's perimeter is at least that of the circle of its
        // area.
        let offset = (got - area) / (2.0 * (PI * area).sqrt()) / pixel;
        assert!(offset.abs() < 0.01, "outline off by {offset} pixels: {got}, expected {area}");
        if c.x == 0.0 {
            let radius = (got / PI).sqrt();
            let want = r / (distance * distance - r * r).sqrt();
            assert!((radius - want).abs() < 0.01 * pixel, "{radius}, expected {want}");
        }
    }
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while chain.len() > 1 && {
                let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
                (b - a).perp_dot(p - a) <= 0.0
            } {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

fn area(hull: &[DVec2]) -> f64 {
    hull.iter().zip(hull.iter().cycle().skip(1)).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0
}

/// Distance of `p` from the inside of a convex polygon's nearest edge line: positive inside.
fn depth_inside(hull: &[DVec2], p: DVec2) -> f64 {
    hull.iter()
        .zip(hull.iter().cycle().skip(1))
        .map(|(a, b)| (*b - *a).perp_dot(p - *a) / (*b - *a).length())
        .fold(f64::INFINITY, f64::min)
}

/// Points whose convex hull is the shape, in object space. A circle is this many points: the polygon lies inside by
/// r (1 - cos(pi/n)) = 1.2e-6 r.
fn extreme_points(shape: &ShapeDesc) -> Vec<DVec3> {
    const N: usize = 2000;
    let circle = |r: f64, y: f64| {
        (0..N).map(move |i| {
            let a = TAU * i as f64 / N as f64;
            v(r * a.cos(), y, r * a.sin())
        })
    };
    match *shape {
        ShapeDesc::Cuboid { size } => {
            let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            (0..8).map(|i| v(sign(i, 0), sign(i, 1), sign(i, 2)) * size).collect()
        }
        ShapeDesc::Cylinder { radius, height } => {
            circle(radius, -height / 2.0).chain(circle(radius, height / 2.0)).collect()
        }
        ShapeDesc::Cone { radius, height } => {
            circle(radius, -height / 2.0).chain([v(0.0, height / 2.0, 0.0)]).collect()
        }
        ShapeDesc::Quad { size } => {
            let (x, z) = (size.x / 2.0, size.y / 2.0);
            vec![v(x, 0.0, z), v(-x, 0.0, z), v(x, 0.0, -z), v(-x, 0.0, -z)]
        }
        _ => unreachable!("no outline for this shape here"),
    }
}

#[test]
fn cube_cylinder_cone_and_quad_cover_exactly_the_hull_of_their_projected_edges() {
    // The image of a convex body is the convex hull of the images of its extreme points: the corners of a cuboid, the
    // rims of a cylinder, the rim and the apex of a cone.
    let shapes = [
        ShapeDesc::Cuboid { size: v(1.5, 1.0, 0.8) },
        ShapeDesc::Cylinder { radius: 0.6, height: 1.6 },
        ShapeDesc::Cone { radius: 0.8, height: 1.7 },
        ShapeDesc::Quad { size: DVec2::new(1.7, 1.1) },
    ];
    let turns = [v(0.0, 0.0, 0.0), v(25.0, 40.0, 10.0), v(100.0, -20.0, 75.0)];
    let scales = [DVec3::ONE, v(0.7, 1.3, 1.1)];
    let (w, h, fov) = (160, 120, 50.0_f64);
    let eye = v(0.3, 0.9, 4.0);
    let mut d = desc(w, h, perspective(eye, v(0.3, 0.2, 0.0), DVec3::Y, fov));
    let forward = (d.camera.look_at - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let half = (fov.to_radians() / 2.0).tan();
    // Pixel units, row 0 on top.
    let project = |p: DVec3| {
        let q = p - eye;
        let (x, y) = (q.dot(right) / q.dot(forward) / half, q.dot(up) / q.dot(forward) / half);
        DVec2::new((f64::from(w) + f64::from(h) * x) / 2.0, f64::from(h) * (1.0 - y) / 2.0)
    };
    for shape in shapes {
        for rotate in turns {
            for scale in scales {
                let turn = DQuat::from_rotation_z(rotate.z.to_radians())
                    * DQuat::from_rotation_y(rotate.y.to_radians())
                    * DQuat::from_rotation_x(rotate.x.to_radians());
                let translate = v(0.2, 0.3, -0.1);
                let points = extreme_points(&shape).into_iter().map(|p| project(turn * (p * scale) + translate));
                let outline = hull(points.collect());
                d.materials.clear();
                d.objects.clear();
                d.render.samples = 1;
                let mut d =
                    silhouette(d.clone(), ObjectDesc { translate, rotate, scale, ..object(shape.clone(), "white") });
                let name = format!("outline-{}", matches!(shape, ShapeDesc::Cone { .. }));
                let film = render(&d);
                let excluded = assert_image(&name, &film, EXACT, |x, y| {
                    let inside = depth_inside(&outline, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
                    // The polygon for the circle is exact to 1e-4 pixels.
                    (inside.abs() > 1e-4).then_some([if inside > 0.0 { 1.0 } else { 0.0 }; 3])
                });
                assert!(excluded <= 3, "{excluded} pixels on the outline");
                d.render.samples = 16;
                let (got, want) = (sum(&render(&d)), area(&outline));
                let perimeter: f64 =
                    outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| (*b - *a).length()).sum();
                let offset = (got - want) / perimeter;
                assert!(offset.abs() < 0.02, "{shape:?} {rotate} {scale}: outline off by {offset} pixels");
            }
        }
    }
}
