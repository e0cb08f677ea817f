//! Rows 1 to 3, 15 to 18: far, tiny and huge bodies, and rays that start on a surface.

use crate::support::*;
use crate::*;
use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::geometry::{Ray, Robust, reflect};
use glimt::math::{Rgb, SplitMix64};

#[test]
fn convex_bodies_of_any_size_show_no_acne() {
    // A point of a convex body that faces the light is lit: the picture under shadows is the picture without them
    // (Phong's model), at sizes from 1e-6 to 1e6, near and far from the origin, light near and far.
    let shapes = [
        ShapeDesc::Sphere { radius: 1.0 },
        ShapeDesc::Cuboid { size: v(1.5, 1.2, 1.0) },
        ShapeDesc::Cylinder { radius: 0.7, height: 1.5 },
        ShapeDesc::Cone { radius: 0.9, height: 1.6 },
    ];
    for exponent in -6..=6 {
        let size = 10f64.powi(exponent);
        for (i, shape) in shapes.iter().enumerate() {
            for (eye, light) in [(4.0, 1.5), (4.0, 1e4), (300.0_f64, 3.0)] {
                let offset = v(1.0, -2.0, 0.5) * if exponent % 2 == 0 { size * 100.0 } else { 0.0 };
                let toward = v(0.4, 0.6, 0.7).normalize();
                let fov = 2.0 * (1.3 / eye).atan().to_degrees();
                let mut d = desc(48, 48, perspective(offset + toward * (eye * size), offset, DVec3::Y, fov));
                d.materials = vec![matte("matte", WHITE)];
                d.objects.push(ObjectDesc {
                    scale: DVec3::splat(size),
                    rotate: v(20.0, 30.0, 10.0),
                    ..at(offset, object(shape.clone(), "matte"))
                });
                let lamp = offset + v(0.9, 0.4, 0.5).normalize() * (light * size);
                d.lights = vec![point_light(lamp, WHITE, 1.0, Falloff::None)];
                let shadowed = render(&d);
                d.render.shading = Shading::Lambert;
                let plain = render(&d);
                assert!(sum(&plain) > 100.0, "the body is seen");
                // Where light grazes, rounding decides between 0 and nearly 0.
                assert_same(&format!("acne-{i}-{exponent}"), &shadowed, &plain, Tolerance { absolute: 1e-7, ..EXACT });
            }
        }
    }
}

#[test]
fn contacts_keep_their_shadow_down_to_a_millionth_of_the_size() {
    // A ball over a floor at a gap of 1e-6 of its radius, lit from straight above: the floor under it is dark, seen
    // from below through nothing at all (the floor is a thin quad seen from its lit side at a slant that reaches
    // under).
    for size in [1e-3, 1.0, 1e3] {
        for gap in [1e-6, 1e-4, 1e-2] {
            // Looking along the floor from very near the contact.
            let eye = v(0.0, 0.002, 0.3) * size;
            let mut d = desc(32, 16, perspective(eye, v(0.0, 0.0, 0.02) * size, DVec3::Y, 8.0));
            d.materials = vec![matte("floor", WHITE), bare("ball", Rgb::BLACK)];
            d.objects = vec![
                quad(DVec3::ZERO, 100.0 * size, DVec3::ZERO, "floor"),
                sphere(v(0.0, (1.0 + gap) * size, 0.0), size, "ball"),
            ];
            d.lights = vec![point_light(v(0.0, 5.0, 0.0) * size, WHITE, 1.0, Falloff::None)];
            // The shadow has a radius above 1; what is seen of the floor nearer than that is dark. So is all else but
            // the far floor.
            let mut near = 0;
            assert_image("contact", &render(&d), EXACT, |x, y| {
                let (o, dir) = pixel_ray(&d, x, y);
                let rho = meet_plane(o, dir, DVec3::ZERO, DVec3::Y).length() / size;
                near += (dir.y < 0.0 && rho < 1.0) as u32;
                (dir.y >= 0.0 || rho < 1.0).then_some([0.0; 3])
            });
            assert!(near > 100, "{near}");
        }
    }
}

#[test]
fn a_far_ball_keeps_its_outline_to_ten_million_radii() {
    for exponent in 0..=7 {
        let distance = 2.0 * 10f64.powi(exponent);
        let c = v(0.3, 0.5, -1.0).normalize() * distance;
        let fov = 2.0 * (1.2 / distance).atan().to_degrees();
        let mut d = desc(64, 64, perspective(DVec3::ZERO, c, DVec3::Y, fov));
        d.materials = vec![flat("white", WHITE)];
        d.objects = vec![sphere(c, 1.0, "white")];
        let pixel = 2.0 * 1.2 / 64.0;
        let excluded = assert_image("far-ball", &render(&d), EXACT, |x, y| {
            let (_, dir) = pixel_ray(&d, x, y);
            // |c x d| is the distance of the ray from the centre without cancellation, but for tangents: r < D.
            let b = c.cross(dir).length();
            ((b - 1.0).abs() > 1e-8).then_some([if b < 1.0 { 1.0 } else { 0.0 }; 3])
        });
        assert!(excluded <= 2, "{excluded} pixels of {pixel} on the outline");
    }
}

#[test]
fn a_huge_ball_is_as_good_a_floor_as_a_plane() {
    // Row 3. A ball of radius 1e7 under the origin, seen from a height of 1: over the few units in view it is flat to
    // 1e-6, has the picture of the plane and no acne.
    for radius in [1e4, 1e5, 1e6, 1e7] {
        let mut d = desc(80, 60, perspective(v(0.0, 1.0, 3.0), v(0.0, 0.0, 0.0), DVec3::Y, 40.0));
        d.materials = vec![matte("floor", WHITE), flat("ball", Rgb::new(0.2, 0.2, 0.9))];
        d.objects = vec![sphere(v(0.0, -radius, 0.0), radius, "floor"), sphere(v(0.0, 0.25, 0.0), 0.25, "ball")];
        d.lights = vec![point_light(v(1.0, 2.0, 1.0), WHITE, 1.0, Falloff::None)];
        let ball = render(&d);
        d.objects[0] = object(ShapeDesc::Plane, "floor");
        let plane = render(&d);
        // 30 units away it has sunk by 30² / 2 R.
        let sunk = 900.0 / (2.0 * radius);
        let difference =
            ball.pixels().iter().zip(plane.pixels()).filter(|(a, b)| (a[0] - b[0]).abs() > 2.0 * sunk as f32 + 1e-5);
        let apart = difference.count();
        assert!(apart <= if radius < 1e6 { 60 } else { 6 }, "radius {radius}: {apart} pixels differ");
    }
}

#[test]
fn a_convex_mirror_of_any_size_never_reflects_itself() {
    // Row 15. Under a white sky each pixel of a mirror of k_r = 1/2 is exactly 1/2; a second reflection would make it
    // 1/4.
    let file = model_file("mirror-convex", &octahedron_obj());
    let shapes = [
        ShapeDesc::Sphere { radius: 1.0 },
        ShapeDesc::Cuboid { size: v(1.5, 1.2, 1.0) },
        ShapeDesc::Cylinder { radius: 0.7, height: 1.5 },
        ShapeDesc::Cone { radius: 0.9, height: 1.6 },
        ShapeDesc::Mesh { file: file.clone(), crease: 0.0 },
    ];
    for exponent in -6..=6 {
        let size = 10f64.powi(exponent);
        for shape in &shapes {
            for (distance, far) in [(4.0, 0.0), (1e4_f64, 300.0)] {
                let offset = v(1.0, -2.0, 0.5) * (size * far);
                let fov = 2.0 * (1.3 / distance).atan().to_degrees();
                let eye = offset + v(0.4, 0.6, 0.7).normalize() * (distance * size);
                let mut d = desc(48, 48, perspective(eye, offset, DVec3::Y, fov));
                d.world.background = Background::Solid(WHITE);
                d.materials = vec![MaterialDesc { reflect: 0.5, ..bare("mirror", Rgb::BLACK) }];
                d.objects.push(ObjectDesc {
                    scale: DVec3::splat(size),
                    rotate: v(20.0, 30.0, 10.0),
                    ..at(offset, object(shape.clone(), "mirror"))
                });
                let film = render(&d);
                assert!(film.pixels().iter().all(|p| p[0] == 0.5 || p[0] == 1.0), "{shape:?} of size {size}");
                assert!(film.pixels().iter().filter(|p| p[0] == 0.5).count() > 300);
            }
        }
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn a_flat_shaded_convex_mesh_of_any_size_shows_no_acne() {
    let file = model_file("acne-mesh", &ball_obj(10));
    for exponent in [-6, -3, 0, 3, 6] {
        let size = 10f64.powi(exponent);
        for far in [0.0, 1e4] {
            let offset = v(1.0, -2.0, 0.5) * (size * far);
            let mut d = desc(64, 64, perspective(offset + v(1.0, 2.0, 3.0) * size, offset, DVec3::Y, 40.0));
            d.materials = vec![matte("matte", WHITE)];
            d.objects.push(ObjectDesc { scale: DVec3::splat(size), ..at(offset, mesh(&file, "matte")) });
            d.lights = vec![point_light(offset + v(2.0, 1.0, 1.0) * size, WHITE, 1.0, Falloff::None)];
            let shadowed = render(&d);
            d.render.shading = Shading::Lambert;
            assert_same("acne-mesh", &shadowed, &render(&d), Tolerance { absolute: 1e-7, ..EXACT });
        }
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn smooth_meshes_have_no_black_facets_at_the_terminator_and_come_near_the_ball_they_stand_for() {
    // Row 17, S14: no pixel that the smooth normal lights may be black, and the error against the exact ball falls with
    // the number of triangles N at least as N^-0.8.
    let toward = v(0.9, 0.3, 0.3).normalize();
    let mut before: Option<(f64, f64)> = None;
    for bands in [8, 16, 32] {
        let file = model_file(&format!("terminator-{bands}"), &ball_obj(bands));
        let mut d = desc(120, 120, orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 2.1));
        d.materials = vec![matte("matte", WHITE)];
        let mut ball = mesh(&file, "matte");
        ball.shape = ShapeDesc::Mesh { file: file.clone(), crease: 180.0 };
        d.objects = vec![ball];
        d.lights = vec![sun(toward, WHITE, 1.0)];
        let film = render(&d);
        d.render.shading = Shading::Lambert;
        let smooth = render(&d);
        let black = film.pixels().iter().zip(smooth.pixels()).filter(|(f, s)| s[0] > 0.0 && f[0] == 0.0).count();
        assert_eq!(black, 0, "black pixels on the lit side with {bands} bands");
        let (mut square, mut n) = (0.0, 0);
        for y in 0..120 {
            for x in 0..120 {
                let (o, _) = pixel_ray(&d, x, y);
                let z2 = 1.0 - o.x * o.x - o.y * o.y;
                // Away from the silhouette, where the mesh itself ends.
                if z2 > 0.1 {
                    let exact = v(o.x, o.y, z2.sqrt()).dot(toward).max(0.0);
                    square += (f64::from(film.pixel(x, y)[0]) - exact).powi(2);
                    n += 1;
                }
            }
        }
        let (triangles, rmse) = ((4 * bands * (bands - 1)) as f64, (square / f64::from(n)).sqrt());
        if let Some((fewer, worse)) = before {
            let order = (worse / rmse).ln() / (triangles / fewer).ln();
            assert!(order > 0.8, "from {fewer} to {triangles} triangles the error goes from {worse} to {rmse}");
        }
        before = Some((triangles, rmse));
        std::fs::remove_file(file).ok();
    }
}

#[test]
fn a_cylinder_and_a_cone_keep_their_outline_to_ten_million_sizes() {
    // Rows 4 and 6. Seen level from z = D the outline is that of the rectangle or triangle x-y section, up to 1/D.
    for exponent in 1..=7 {
        let distance = 3.0 * 10f64.powi(exponent);
        for is_cone in [false, true] {
            let fov = 2.0 * (1.2 / distance).atan().to_degrees();
            let mut d = desc(64, 64, perspective(v(0.0, 0.0, distance), DVec3::ZERO, DVec3::Y, fov));
            d.materials = vec![flat("white", WHITE)];
            let (radius, height) = (0.8, 1.7);
            d.objects = vec![if is_cone {
                object(ShapeDesc::Cone { radius, height }, "white")
            } else {
                object(ShapeDesc::Cylinder { radius, height }, "white")
            }];
            let excluded = assert_image("far-cylinder", &render(&d), EXACT, |x, y| {
                let (o, dir) = pixel_ray(&d, x, y);
                let p = meet_plane(o, dir, DVec3::ZERO, DVec3::Z);
                let width = if is_cone { radius * (0.5 - p.y / height) } else { radius };
                let margin = (width - p.x.abs()).min(height / 2.0 - p.y.abs());
                (margin.abs() > 1.0 / distance).then_some([if margin > 0.0 { 1.0 } else { 0.0 }; 3])
            });
            assert!(excluded <= if exponent == 1 { 400 } else { 40 }, "{excluded} at {distance}");
        }
    }
}

fn unit(rng: &mut SplitMix64) -> DVec3 {
    loop {
        let p = v(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

#[test]
fn over_all_sizes_and_distances_rays_leave_their_surface_and_meet_what_stands_a_millionth_of_the_size_away() {
    // S10. Bodies of size 1e-3 to 1e6, the eye at 5 to 1e5 sizes, the light at 1e-2 to 1e4 sizes, all of it up to 1e5
    // sizes from the origin. Outside of a convex body no shadow ray or mirrored ray meets the body itself; and a shell
    // around the body at a gap of 1e-6 to 1e-1 sizes stops every ray that goes farther.
    let file = model_file("cells", &ball_obj(8));
    let (mut rng, mut checked) = (SplitMix64(10), 0);
    let shapes = [
        (ShapeDesc::Sphere { radius: 1.0 }, DVec3::ONE),
        (ShapeDesc::Sphere { radius: 1.0 }, v(1.0, 0.3, 2.0)),
        (ShapeDesc::Quad { size: DVec2::splat(2.0) }, DVec3::ONE),
        (ShapeDesc::Mesh { file: file.clone(), crease: 0.0 }, DVec3::ONE),
        (ShapeDesc::Cuboid { size: v(2.0, 1.5, 1.0) }, DVec3::ONE),
        (ShapeDesc::Cylinder { radius: 0.8, height: 1.6 }, v(1.0, 1.0, 0.4)),
        (ShapeDesc::Cone { radius: 1.0, height: 1.4 }, DVec3::ONE),
    ];
    let shading = |body: &ObjectDesc| {
        let mut d = desc(1, 1, CameraDesc::default());
        d.materials = vec![flat("white", WHITE)];
        d.objects = vec![body.clone()];
        compile(&d)
    };
    for (shape, stretch) in shapes {
        for size in [1e-3, 1.0, 1e6] {
            for away in [0.0, 1e2, 1e5] {
                let center = v(0.6, -0.5, 0.62) * (away * size);
                let body = ObjectDesc {
                    scale: stretch * size,
                    rotate: v(20.0, 70.0, 30.0),
                    ..at(center, object(shape.clone(), "white"))
                };
                let scene = shading(&body);
                let is_quad = matches!(shape, ShapeDesc::Quad { .. });
                let shells: Vec<_> = [1e-6, 1e-4, 1e-2, 1e-1]
                    .into_iter()
                    .map(|gap| {
                        let mut shell = body.clone();
                        if is_quad {
                            // A larger quad over it and another one under it.
                            let turn = scene.objects()[0].map.forward.matrix3;
                            let up = (turn * DVec3::Y).normalize() * (gap * size);
                            let lid = |side: f64| ObjectDesc {
                                scale: body.scale * 1e3,
                                translate: center + up * side,
                                ..body.clone()
                            };
                            let mut d = desc(1, 1, CameraDesc::default());
                            d.materials = vec![flat("white", WHITE)];
                            d.objects = vec![lid(1.0), lid(-1.0)];
                            return (gap, compile(&d));
                        }
                        // Scaled about its middle, the shell stands off by at least the gap times the least extent.
                        shell.scale *= 1.0 + gap;
                        (gap, shading(&shell))
                    })
                    .collect();
                for eye_at in [5.0, 1e3, 1e5] {
                    for light_at in [1e-2, 1.0, 1e4] {
                        for _ in 0..300 {
                            let eye = center + unit(&mut rng) * (eye_at * size);
                            let target = center + unit(&mut rng) * (rng.unit() * 0.5 * size);
                            let ray = Ray::new(eye, (target - eye).normalize());
                            let Some(hit) = scene.intersect::<Robust>(&ray) else { continue };
                            let surface = scene.interaction::<Robust>(&ray, &hit);
                            let side = if surface.entering { 1.0 } else { -1.0 };
                            let normal = surface.geometric_normal * side;
                            // Not within a thousandth of the tangent plane: there a shell of a millionth is far away.
                            let toward = (normal * 1.001 + unit(&mut rng)).normalize();
                            let light = surface.point + toward * (light_at * size);
                            let shadow =
                                surface.shadow_start().ray_to::<Robust>(light).expect("the light is elsewhere");
                            let mirrored = surface.spawn_ray::<Robust>(reflect(ray.direction, normal, normal));
                            let case = format!("{shape:?} size {size} away {away} eye {eye_at} light {light_at}");
                            checked += 1;
                            assert!(!scene.occluded::<Robust>(&shadow), "shadow acne: {case}");
                            assert!(!scene.occluded::<Robust>(&mirrored), "mirror acne: {case}");
                            for (gap, shell) in &shells {
                                assert!(shell.occluded::<Robust>(&mirrored), "mirror leak at gap {gap}: {case}");
                                // The other lights may be inside of the shell.
                                if light_at > 1e3 {
                                    assert!(shell.occluded::<Robust>(&shadow), "shadow leak at gap {gap}: {case}");
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(checked > 100_000, "{checked}");
    std::fs::remove_file(file).ok();
}
