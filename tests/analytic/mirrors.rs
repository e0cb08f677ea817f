//! Items 9 and 10: mirrors.

use crate::UNSPENT;
use crate::support::*;
use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::Rgb;
use std::f64::consts::PI;

/// The object seen in a mirror at z = 0: translation and scale with z negated, and the turns about x and y reversed,
/// since M R_z R_y R_x M = R_z R_-y R_-x for the mirroring M.
fn mirrored(o: &ObjectDesc) -> ObjectDesc {
    let flip = v(1.0, 1.0, -1.0);
    ObjectDesc {
        translate: o.translate * flip,
        rotate: o.rotate * v(-1.0, -1.0, 1.0),
        scale: o.scale * flip,
        ..o.clone()
    }
}

#[test]
fn a_plane_mirror_shows_the_mirrored_scene() {
    let file = model_file(
        "mirror-tetrahedron",
        "v 0 0 0\nv 1 0 0.2\nv 0.3 0.1 1\nv 0.4 1 0.3\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n",
    );
    let mut base = desc(120, 90, perspective(v(0.2, 1.0, 3.0), v(0.0, 0.6, 0.0), DVec3::Y, 60.0));
    base.world.background = SKY;
    let (a, b) = (Rgb::new(0.9, 0.3, 0.1), Rgb::new(0.2, 0.6, 0.9));
    base.materials = vec![
        MaterialDesc { texture: checker(a, b, 0.125), ambient: 0.2, specular: 0.3, ..matte("checker", Rgb::WHITE) },
        MaterialDesc { texture: checker(a, b, 0.5), ..matte("floor", Rgb::WHITE) },
        MaterialDesc { specular: 0.5, shininess: 20.5, ..matte("plain", Rgb::new(0.3, 0.8, 0.4)) },
        MaterialDesc { reflect: 1.0, ..bare("mirror", Rgb::BLACK) },
    ];
    // All between the mirror and the eye's plane or behind the eye; the eye sees nothing but the mirror.
    let objects = vec![
        sphere(v(-1.4, 0.7, 4.5), 0.6, "checker"),
        ObjectDesc {
            rotate: v(20.0, 35.0, 10.0),
            scale: v(1.0, 1.4, 0.8),
            ..cuboid(v(0.6, 0.8, 5.0), v(0.9, 0.6, 0.7), "checker")
        },
        ObjectDesc {
            rotate: v(-30.0, 10.0, 25.0),
            ..at(v(1.9, 0.9, 4.2), object(ShapeDesc::Cone { radius: 0.5, height: 1.1 }, "checker"))
        },
        ObjectDesc {
            rotate: v(70.0, -15.0, 5.0),
            ..at(v(-0.4, 1.8, 5.0), object(ShapeDesc::Cylinder { radius: 0.3, height: 1.1 }, "checker"))
        },
        ObjectDesc { rotate: v(0.0, 30.0, 0.0), ..at(v(-0.5, 0.0, 3.9), mesh(&file, "plain")) },
        // Floor from z = 3.5 on, below the view line to the mirror.
        at(v(0.0, -0.01, 43.5), object(ShapeDesc::Quad { size: DVec2::splat(80.0) }, "floor")),
    ];
    let lamp = v(1.0, 4.0, 3.0);
    let light = |position| vec![point_light(position, Rgb::new(1.0, 0.9, 0.8), 1.2, Falloff::None)];
    let mut direct = base.clone();
    direct.objects = objects.iter().map(mirrored).collect();
    direct.lights = light(lamp * v(1.0, 1.0, -1.0));
    let mut reflected = base.clone();
    reflected.lights = light(lamp);
    reflected.objects = objects;
    reflected.objects.push(quad(DVec3::ZERO, 1e3, v(90.0, 0.0, 0.0), "mirror"));
    // Both ways of rounding may fall on different sides of an edge in a pixel or two.
    assert_same(
        "plane-mirror",
        &render(&reflected),
        &render(&direct),
        Tolerance { relative: 1e-6, absolute: 1e-6, pixels: 2 },
    );
    std::fs::remove_file(file).ok();
}

#[test]
fn a_mirror_ball_turns_every_ray_by_the_closed_form() {
    // Light along a direction at impact parameter b = sin(i) (in radii) is turned by pi - 2 i in the plane with the
    // centre, away from it, at the point of the surface. A ruler behind the eye shows where it goes.
    let (c, r) = (v(0.2, 0.1, 0.0), 1.1);
    for camera in [
        orthographic(v(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y, 2.4),
        perspective(v(0.5, 0.4, 4.0), DVec3::ZERO, DVec3::Y, 32.0),
    ] {
        let mut d = desc(90, 80, camera);
        let ruler = Ruler::new(v(0.0, -6.0, 0.0), DVec3::Y, 1.5, 2.5);
        ruler.add_to(&mut d, 1e5);
        d.materials.push(MaterialDesc { reflect: 0.9, ..bare("mirror", Rgb::BLACK) });
        d.objects.push(sphere(c, r, "mirror"));
        let excluded = assert_exact("mirror-ball", &d, 1e-9, |x, y| {
            let (o, dir) = pixel_ray(&d, x, y);
            let q = o - c;
            let foot = q - dir * q.dot(dir);
            let b = foot.length() / r;
            if (b - 1.0).abs() < 1e-6 {
                return None;
            }
            let (p, dir, k) = if b > 1.0 {
                (o, dir, 1.0)
            } else {
                let i = b.asin();
                let side = foot.normalize_or_zero();
                let p = c + r * (side * i.sin() - dir * i.cos());
                let turned = PI - 2.0 * i;
                (p, dir * turned.cos() + side * turned.sin(), 0.9)
            };
            // Level rays meet the floor nowhere near; 5e4 is the edge of it.
            if dir.y >= 0.0 {
                return Some([0.0; 3]);
            }
            let at = meet_plane(p, dir, ruler.point, DVec3::Y);
            let reach = at.x.abs().max(at.z.abs());
            if (reach - 5e4).abs() < 1.0 {
                return None;
            }
            Some(if reach > 5e4 { [0.0; 3] } else { scale(ruler.color_at(at), k) })
        });
        assert!(excluded <= 3);
    }
}

#[test]
fn a_convex_mirror_has_its_focus_half_a_radius_behind_its_surface() {
    // Light parallel to the axis at b comes back as if from the axis at R / (2 cos(i)) from the centre, R / 2 for
    // small b. The edge of a wall at distance rho from the axis is seen where tan(2 i) = rho / (Z - R / 2), which is
    // b = R sin(atan(rho / (Z - R / 2)) / 2), up to third order in b.
    let (r, z, rho) = (2.0, 4.0, 0.3_f64);
    let mut d = desc(400, 1, orthographic(v(0.0, 0.0, 3.0), DVec3::ZERO, DVec3::Y, 0.4 / 400.0));
    d.materials = vec![MaterialDesc { reflect: 1.0, ..bare("mirror", Rgb::BLACK) }, flat("white", Rgb::WHITE)];
    d.objects = vec![
        sphere(DVec3::ZERO, r, "mirror"),
        // Behind the eye, from x = rho on.
        quad(v(rho + 500.0, 0.0, z), 1000.0, v(90.0, 0.0, 0.0), "white"),
    ];
    let film = render(&d);
    let edge = (0..400).find(|&x| film.pixel(x, 0)[0] > 0.5).expect("the wall is seen");
    let (b, pixel) = (pixel_ray(&d, edge, 0).0.x, 0.4 / 400.0);
    let focus_at = |f: f64| r * ((rho / (z - f)).atan() / 2.0).sin();
    let want = focus_at(r / 2.0);
    assert!(b > want - 0.1 * pixel && b < want + 1.1 * pixel, "edge at {b}, expected {want}");
    // A focus elsewhere by a twentieth of the radius would move the edge by three pixels.
    assert!((focus_at(0.55 * r) - want).abs() > 3.0 * pixel);
}

/// Two mirrors facing each other at z = 0 and z = `length`, each showing `base` and reflecting the part `k`.
fn corridor(mut d: SceneDesc, length: f64, base: Rgb, k: f64) -> SceneDesc {
    d.materials.push(mirror("mirror", base, k));
    d.objects.push(quad(DVec3::ZERO, 1e6, v(90.0, 0.0, 0.0), "mirror"));
    d.objects.push(quad(v(0.0, 0.0, length), 1e6, v(90.0, 0.0, 0.0), "mirror"));
    d
}

#[test]
fn a_corridor_of_two_mirrors_adds_up_to_the_geometric_sum_of_its_depth() {
    // Every step shows base and passes on the part k: base (1 + k + ... + k^m) at depth m.
    for k in [0.5, 0.9, 1.0] {
        for depth in [0, 1, 2, 3, 7, 16, 40, 64] {
            let d = desc(9, 7, perspective(v(0.0, 0.0, 1.3), v(0.1, 0.2, 0.0), DVec3::Y, 40.0));
            let mut d = corridor(d, 3.0, Rgb::new(0.3, 0.02, 0.1), k);
            d.render.max_depth = depth;
            let steps: f64 = (0..=depth).map(|j| k.powi(j as i32)).sum();
            assert_exact("corridor", &d, UNSPENT, |_, _| Some([0.3 * steps, 0.02 * steps, 0.1 * steps]));
        }
    }
}

#[test]
fn a_ball_in_a_corridor_is_seen_at_its_mirrored_places_with_the_weight_of_its_order() {
    // Unfolded, the ray goes straight on through rooms of the mirrors' distance L; the ball stands in every room, at
    // z = c, 2 L - c, ... mirrored in turn. Seen in room j it has the weight k^j, after j times base.
    let (length, k, depth) = (3.0, 0.8, 12);
    let (c, r) = (v(0.35, -0.2, 1.9), 0.25);
    let base = [0.05, 0.1, 0.02];
    let d = desc(120, 90, perspective(v(0.0, 0.1, 0.6), v(0.12, 0.0, 0.0), DVec3::Y, 75.0));
    let mut d = corridor(d, length, Rgb::new(base[0], base[1], base[2]), k);
    d.render.max_depth = depth;
    d.materials.push(flat("ball", Rgb::new(0.9, 0.8, 0.1)));
    d.objects.push(sphere(c, r, "ball"));
    let mut orders = [0; 13];
    let excluded = assert_exact("corridor-ball", &d, 1e-9, |x, y| {
        let (o, dir) = pixel_ray(&d, x, y);
        assert!(dir.z < 0.0);
        let mut sum = [0.0; 3];
        for j in 0..=depth {
            // Rooms are stacked toward -z: room j spans z from -j L to (1 - j) L.
            let z = if j % 2 == 0 { c.z - f64::from(j) * length } else { f64::from(1 - j as i32) * length - c.z };
            let q = v(c.x, c.y, z) - o;
            let distance = (q - dir * q.dot(dir)).length();
            if (distance - r).abs() < 1e-10 {
                return None;
            }
            if q.dot(dir) > 0.0 && distance < r {
                orders[j as usize] += 1;
                return Some(plus(sum, scale([0.9, 0.8, 0.1], k.powi(j as i32))));
            }
            sum = plus(sum, scale(base, k.powi(j as i32)));
        }
        Some(sum)
    });
    assert!(excluded <= 2);
    // Its second image, in the far mirror, and more are there; it stands behind the eye in its own room.
    assert!(orders[0] == 0 && orders[1] > 20 && orders[2] > 5 && orders[3] > 1, "{orders:?}");
}
