//! Rows 4 to 14 and 19: edges, rims, apices, seams between triangles.

use crate::support::*;
use crate::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;
use glimt::render::{self};
use std::f64::consts::TAU;

#[test]
fn a_cylinder_seen_along_its_axis_is_its_cap_and_nothing_else() {
    // Rays exactly along the axis never cross the side: inside the radius they see the cap (normal +y, fully lit),
    // outside nothing. Tilted by a tiny angle the picture is the same but for the rim.
    let mut d = desc(65, 65, orthographic(v(0.0, 9.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.57));
    d.materials = vec![matte("matte", WHITE)];
    d.objects = vec![object(ShapeDesc::Cylinder { radius: 1.0, height: 3.0 }, "matte")];
    d.lights = vec![sun(DVec3::Y, WHITE, 1.0)];
    assert_image("cylinder-axis", &render(&d), EXACT, |x, y| {
        let (o, _) = pixel_ray(&d, x, y);
        Some([if o.x.hypot(o.z) <= 1.0 { 1.0 } else { 0.0 }; 3])
    });
    for tilt in [1e-5, 1e-7, 1e-9, 1e-12] {
        d.camera.position = v(tilt * 9.0, 9.0, 0.0);
        let excluded =
            assert_image("cylinder-near-axis", &render(&d), Tolerance { absolute: 1e-6, ..EXACT }, |x, y| {
                let (o, dir) = pixel_ray(&d, x, y);
                let p = meet_plane(o, dir, v(0.0, 1.5, 0.0), DVec3::Y);
                let rho = p.x.hypot(p.z);
                ((rho - 1.0).abs() > 4.0 * tilt + 1e-12).then_some([if rho < 1.0 { 1.0 } else { 0.0 }; 3])
            });
        assert!(excluded <= 4);
    }
}

#[test]
fn from_inside_a_closed_body_every_ray_meets_its_wall() {
    // Rows 7, 10, 13 and 19: rims, edges, corners and apices, looked at exactly, from inside, near and far. No sky may
    // show through. Rays are aimed by 1 x 1 pictures; the wall is white, the sky red.
    let (cube, octahedron) =
        (model_file("inside-cube", &cube_obj()), model_file("inside-octahedron", &octahedron_obj()));
    let rim = |y: f64, r: f64| {
        (0..24).map(move |i| v(r * (TAU * f64::from(i) / 24.0).cos(), y, r * (TAU * f64::from(i) / 24.0).sin()))
    };
    let corners: Vec<DVec3> = (0..8)
        .map(|i| v(f64::from(i & 1) * 2.0 - 1.0, f64::from(i >> 1 & 1) * 2.0 - 1.0, f64::from(i >> 2 & 1) * 2.0 - 1.0))
        .collect();
    let mut edges = corners.clone();
    for a in &corners {
        for b in &corners {
            edges.extend([a.lerp(*b, 0.5), a.lerp(*b, 0.3)].into_iter().filter(|p| p.abs().cmpeq(DVec3::ONE).any()));
        }
    }
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let mut between: Vec<DVec3> = axes.to_vec();
    for a in axes {
        for b in axes {
            between.extend([a.lerp(b, 0.5), a.lerp(b, 0.25)].into_iter().filter(|p| p.length() > 0.1));
        }
    }
    let cases: Vec<(ObjectDesc, Vec<DVec3>)> = vec![
        (object(ShapeDesc::Cuboid { size: DVec3::splat(2.0) }, "wall"), edges.clone()),
        (mesh(&cube, "wall"), edges),
        (mesh(&octahedron, "wall"), between),
        (
            object(ShapeDesc::Cylinder { radius: 1.0, height: 2.0 }, "wall"),
            rim(1.0, 1.0).chain(rim(-1.0, 1.0)).collect(),
        ),
        (object(ShapeDesc::Cone { radius: 1.0, height: 2.0 }, "wall"), rim(-1.0, 1.0).chain([DVec3::Y]).collect()),
    ];
    let eyes = [DVec3::ZERO, v(0.1, -0.35, 0.2), v(-0.05, -0.6, 0.01), v(0.25, -0.5, -0.125)];
    for (object, targets) in cases {
        for scale in [1.0, 1e-5, 3e4] {
            for rotate in [DVec3::ZERO, v(33.0, 14.0, 71.0)] {
                let mut d = desc(1, 1, CameraDesc::default());
                d.world.background = Background::Solid(Rgb::new(1.0, 0.0, 0.0));
                d.materials = vec![flat("wall", WHITE)];
                d.objects = vec![ObjectDesc { scale: DVec3::splat(scale), rotate, ..object.clone() }];
                let turn = glam::DQuat::from_rotation_z(rotate.z.to_radians())
                    * glam::DQuat::from_rotation_y(rotate.y.to_radians())
                    * glam::DQuat::from_rotation_x(rotate.x.to_radians());
                let mut compiled = compile(&d);
                for eye in eyes {
                    for target in &targets {
                        let up = if (*target - eye).normalize().y.abs() > 0.9 { DVec3::X } else { DVec3::Y };
                        d.camera = perspective(turn * eye * scale, turn * *target * scale, up, 1.0);
                        let scene = glimt::scene::compile(&d, Some(&compiled)).unwrap_or_else(|e| panic!("{e}"));
                        compiled = std::sync::Arc::new(scene);
                        let film = finish(render::start(compiled.clone(), settings(1, 8)), 1, 1);
                        assert_eq!(film.pixel(0, 0), [1.0; 3], "{:?} from {eye} to {target} at {scale}", object.shape);
                    }
                }
            }
        }
    }
    std::fs::remove_file(cube).ok();
    std::fs::remove_file(octahedron).ok();
}

#[test]
fn no_ray_leaves_a_closed_mesh_from_inside_at_any_size_and_distance_from_the_origin() {
    let file = model_file("watertight-ball", &ball_obj(24));
    for size in [1e-6, 1.0, 1e6] {
        for offset in [DVec3::ZERO, v(1e5, -2e5, 3e4)] {
            let center = offset * size;
            let eye = center + v(0.1, 0.2, -0.3) * size;
            let mut d = desc(200, 150, perspective(eye, eye + v(0.3, 0.8, 0.2) * size, DVec3::Z, 150.0));
            d.world.background = Background::Solid(Rgb::new(1.0, 0.0, 0.0));
            d.materials = vec![flat("wall", WHITE)];
            d.objects = vec![ObjectDesc { scale: DVec3::splat(size), ..at(center, mesh(&file, "wall")) }];
            d.render.samples = 4;
            assert_image("watertight", &render(&d), EXACT, |_, _| Some([1.0; 3]));
        }
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn the_apex_of_a_cone_has_a_normal_and_its_other_nappe_does_not_show() {
    // Exactly at the apex, and around it within a millionth: covered below, empty above, all values finite.
    let mut d = desc(65, 65, orthographic(v(0.0, 0.5, 9.0), v(0.0, 0.5, 0.0), DVec3::Y, 1e-5));
    d.materials = vec![flat("white", WHITE)];
    d.objects = vec![object(ShapeDesc::Cone { radius: 0.437, height: 1.0 }, "white")];
    let excluded = assert_image("apex", &render(&d), EXACT, |x, y| {
        let (o, _) = pixel_ray(&d, x, y);
        // Seen level, the outline is |x| = (0.5 - y) r / h.
        let margin = (0.5 - o.y) * 0.437 - o.x.abs();
        (margin.abs() > 1e-12).then_some([if margin > 0.0 { 1.0 } else { 0.0 }; 3])
    });
    assert!(excluded <= 3, "{excluded}");
    // From straight above, lit from above: the pixel in the middle sees the apex itself.
    d.camera = orthographic(v(0.0, 9.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 1.2);
    d.materials = vec![MaterialDesc { specular: 0.5, shininess: 3.3, reflect: 0.5, ..matte("white", WHITE) }];
    d.world.background = Background::Solid(WHITE);
    d.lights = vec![sun(DVec3::Y, WHITE, 1.0)];
    let film = render(&d);
    assert!(film.pixel(32, 32).iter().all(|c| c.is_finite() && *c > 0.5), "{:?}", film.pixel(32, 32));
    // Around it every flank has the same slope: (n, l) = r / sqrt(r² + h²).
    let want = f64::from(film.pixel(33, 32)[0]);
    for (x, y) in [(31, 32), (32, 31), (32, 33), (40, 32), (32, 20)] {
        assert!((f64::from(film.pixel(x, y)[0]) - want).abs() < 1e-5);
    }
}

#[test]
fn rims_of_glass_let_no_ray_in_without_letting_it_out() {
    // If a ray passed between side and cap, glass would lose track of where it is. In a white furnace with k_t = 1 each
    // pixel is white, whatever way it goes, unless it is caught until the depth ends; so black is only allowed where
    // a ray is caught, and index-matched glass (not caught, not bent) must be invisible to the last pixel.
    for shape in [
        ShapeDesc::Cylinder { radius: 1.0, height: 1.0 },
        ShapeDesc::Cone { radius: 1.0, height: 1.0 },
        ShapeDesc::Cuboid { size: DVec3::ONE },
    ] {
        let mut d = desc(257, 129, orthographic(v(0.0, 0.0, 9.0), DVec3::ZERO, DVec3::Y, 1.001));
        d.world.background = SKY;
        d.materials = vec![clear("glass", 1.0)];
        d.objects = vec![object(shape, "glass")];
        for eye in [v(0.0, 0.0, 9.0), v(0.0, 4.5, 9.0), v(9.0, 9.0, 9.0), v(0.0, -9.0, 1e-3)] {
            d.camera.position = eye;
            assert_image("rims", &render(&d), EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
        }
    }
}

#[test]
fn rays_exactly_through_edges_and_vertices_of_a_glass_mesh_count_its_surfaces_right() {
    // Row 13. A cube of two triangles a face and an octahedron, seen along axes on a grid of pixels that runs exactly
    // along edges and diagonals and through vertices. A slab or ball of another glass behind it would show if a ray
    // believed itself still inside; so the picture behind index-matched glass must be the one without it.
    for (name, obj) in [("edge-cube", cube_obj()), ("edge-octahedron", octahedron_obj())] {
        let file = model_file(name, &obj);
        for (eye, up) in [
            (v(0.0, 0.0, 8.0), DVec3::Y),
            (v(0.0, 8.0, 0.0), DVec3::Z),
            (v(-8.0, 0.0, 0.0), DVec3::Y),
            (v(8.0, 8.0, 0.0), DVec3::Y),
            (v(8.0, 8.0, 8.0), DVec3::Y),
        ] {
            // Pixel centres at multiples of 1/32 (65 of them from -1 to 1): the film ends at 65/64.
            let mut d = desc(65, 65, orthographic(eye, DVec3::ZERO, up, 65.0 / 32.0));
            d.world.background = SKY;
            // In the world's index the mesh is nothing; the ball behind is glass.
            d.materials = vec![clear("nothing", 1.0), clear("glass", 1.5)];
            d.objects = vec![sphere(-eye * 0.4, 0.9, "glass")];
            let without = render(&d);
            d.objects.push(mesh(&file, "nothing"));
            assert_same(name, &render(&d), &without, Tolerance { absolute: 1e-6, ..EXACT });
        }
        std::fs::remove_file(file).ok();
    }
}
