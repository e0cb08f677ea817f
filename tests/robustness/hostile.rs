//! Rows 14, 20, 28, 32: coincidence, singular points, extreme numbers.

use crate::support::*;
use crate::*;
use glam::{DQuat, DVec2, DVec3};
use glimt::description::*;
use glimt::math::{Rgb, SplitMix64};
use glimt::render::{self, RenderEvent};
use std::f64::consts::TAU;

#[test]
fn coincident_faces_show_one_of_them_the_same_one_everywhere_and_for_any_thread_count() {
    let mut d = desc(80, 60, perspective(v(2.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.materials = vec![flat("red", Rgb::new(1.0, 0.0, 0.0)), flat("green", Rgb::new(0.0, 1.0, 0.0))];
    d.objects = vec![
        cuboid(v(0.0, 0.0, 0.0), DVec3::ONE, "red"),
        cuboid(v(0.0, 0.0, 0.0), DVec3::ONE, "green"),
        quad(v(0.0, -1.0, 0.0), 4.0, DVec3::ZERO, "green"),
        quad(v(0.0, -1.0, 0.0), 4.0, DVec3::ZERO, "red"),
    ];
    let one = render_with(&d, settings(1, 64));
    let (red, green) = one.pixels().iter().fold((0, 0), |(r, g), p| (r + (p[0] > 0.5) as u32, g + (p[1] > 0.5) as u32));
    // The first of each pair: a red cube on a green quad, without a speck of the other.
    assert!(red > 200 && green > 200, "{red} {green}");
    d.objects.remove(3);
    d.objects.remove(1);
    assert_eq!(render(&d).hash(), one.hash(), "a speck of the hidden twin shows");
}

#[test]
fn a_light_on_a_surface_or_a_vertex_gives_no_nan() {
    let file = model_file("light-vertex", &octahedron_obj());
    for position in [DVec3::ZERO, v(0.0, 1.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 0.0, 0.0)] {
        for falloff in [Falloff::None, Falloff::InverseSquare] {
            let mut d = desc(33, 33, orthographic(v(0.0, 3.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.0));
            d.materials = vec![MaterialDesc { specular: 0.5, shininess: 2.5, ..matte("matte", WHITE) }];
            // The light is at a point of the floor that the middle pixel sees, or at a vertex of the mesh.
            d.objects = if position == DVec3::ZERO {
                vec![object(ShapeDesc::Plane, "matte")]
            } else {
                vec![mesh(&file, "matte"), at(v(0.0, -1.0, 0.0), object(ShapeDesc::Plane, "matte"))]
            };
            d.lights = vec![point_light(position, WHITE, 1.0, falloff)];
            let film = render(&d);
            assert!(film.pixels().iter().flatten().all(|c| c.is_finite()));
            if position == DVec3::ZERO {
                assert_eq!(film.pixel(16, 16), [0.0; 3], "a light at distance 0 gives nothing");
            }
        }
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn textures_have_no_seam_and_no_hole_at_poles() {
    // Row 28. A ball with an even checker of 16 squares round: rows of the picture cross the seam; the equator's
    // squares must all be equally wide, and the poles finite. Looking at the seam (u = 0 = 1 at -z).
    for toward in [DVec3::NEG_Z, DVec3::Y, DVec3::NEG_Y] {
        let up = if toward.y == 0.0 { DVec3::Y } else { DVec3::Z };
        let mut d = desc(101, 101, orthographic(toward * 5.0, DVec3::ZERO, up, 2.2));
        d.materials = vec![MaterialDesc { texture: checker(WHITE, Rgb::BLACK, 0.125), ..flat("checker", WHITE) }];
        d.objects = vec![sphere(DVec3::ZERO, 1.0, "checker")];
        let excluded = assert_image("poles-and-seam", &render(&d), EXACT, |x, y| {
            let (o, dir) = pixel_ray(&d, x, y);
            let foot = o - dir * o.dot(dir);
            let rho2 = foot.length_squared();
            if rho2 > 1.0 {
                return Some([0.0; 3]);
            }
            let n = foot - dir * (1.0 - rho2).sqrt();
            let (s, t) = ((0.5 + n.x.atan2(n.z) / TAU) * 8.0, (0.5 + n.y.asin() / (TAU / 2.0)) * 8.0);
            // On an edge of a square, or at the very pole where all of u meets.
            if (s - s.round()).abs() < 1e-9 || (t - t.round()).abs() < 1e-9 {
                return None;
            }
            Some([if (s.floor() + t.floor()).rem_euclid(2.0) == 0.0 { 1.0 } else { 0.0 }; 3])
        });
        // The rows and columns through the middle lie on edges.
        assert!(excluded <= 450, "{excluded}");
    }
}

#[test]
fn empty_and_extreme_scenes_have_a_picture() {
    let mut rng = SplitMix64(32);
    let mut d = desc(17, 9, perspective(v(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.world.background = SKY;
    assert_image("empty", &render(&d), EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
    d.lights.push(sun(DVec3::Y, WHITE, 1.0));
    assert_image("only-light", &render(&d), EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
    // Fields of view next to 0 and 180 degrees, sizes and distances over the whole range of f32 and beyond.
    d.materials = vec![matte("matte", WHITE), fresnel("glass", 1.5), mirror("mirror", Rgb::BLACK, 1.0)];
    for _ in 0..200 {
        let mut d = d.clone();
        let mut length = || 10f64.powf(rng.range(-30.0, 30.0));
        let size = length();
        d.camera.position = v(0.0, 0.0, length() + size);
        for (i, shape) in [
            ShapeDesc::Sphere { radius: size },
            ShapeDesc::Cuboid { size: v(length(), size, size) },
            ShapeDesc::Cylinder { radius: size, height: length() },
            ShapeDesc::Cone { radius: length(), height: size },
            ShapeDesc::Plane,
            ShapeDesc::Quad { size: DVec2::new(size, length()) },
        ]
        .into_iter()
        .enumerate()
        {
            let material = ["matte", "glass", "mirror"][i % 3];
            d.objects.push(object(shape, material));
        }
        d.lights.push(point_light(v(length(), length(), length()), WHITE, 1.0, Falloff::InverseSquare));
        d.camera.projection = Projection::Perspective { fov: 10f64.powf(rng.range(-6.0, 2.255)) };
        // Whether such a scene can be compiled is the compiler's to say; if it can, it has a picture.
        if let Ok(scene) = glimt::scene::compile(&d, None) {
            for event in render::start(std::sync::Arc::new(scene), settings(1, 8)).events() {
                match event {
                    RenderEvent::TileFinished { tile, .. } => {
                        assert!(tile.pixels.iter().flatten().all(|c| !c.is_nan()), "{d:#?}");
                    }
                    RenderEvent::Failed(error) => panic!("{error}\n{d:#?}"),
                    _ => {}
                }
            }
        }
    }
}

#[test]
fn rays_parallel_to_a_plane_never_meet_it() {
    // Level rays over and under a plane, and in it: minus one over zero is not a distance.
    for (height, direction) in [
        (1.0, DVec3::NEG_Z),
        (-1.0, DVec3::NEG_Z),
        (0.0, DVec3::X),
        (-1.0, v(1.0, -0.0, 1.0)),
        (1.0, v(1.0, -0.0, 1.0)),
    ] {
        let eye = v(0.0, height, 0.0);
        // A picture of one row, so that all its rays are level.
        for camera in [
            perspective(eye, eye + direction, DVec3::Y, 40.0),
            perspective(eye, eye + direction, DVec3::NEG_Y, 40.0),
            orthographic(eye, eye + direction, DVec3::Y, 1.0),
        ] {
            let mut d = desc(9, 1, camera);
            d.world.background = SKY;
            d.materials = vec![MaterialDesc { reflect: 0.5, ..flat("floor", WHITE) }];
            d.objects = vec![object(ShapeDesc::Plane, "floor")];
            assert_image("level", &render(&d), EXACT, |_, _| Some(sky(0.0)));
        }
    }
    // A plane met at a right angle sends a mirrored ray level along another one.
    let mut d = desc(9, 9, orthographic(v(0.0, -3.0, 0.0), v(0.0, 0.0, 0.0), DVec3::Z, 1.0));
    d.world.background = SKY;
    d.materials = vec![MaterialDesc { reflect: 1.0, ..bare("mirror", Rgb::BLACK) }, flat("floor", WHITE)];
    d.objects = vec![
        // At 45 degrees: rays going up turn toward +x or -x, exactly level up to rounding.
        ObjectDesc { rotate: v(0.0, 0.0, 45.0), ..at(v(0.0, -1.0, 0.0), object(ShapeDesc::Plane, "mirror")) },
        at(v(0.0, 7.0, 0.0), object(ShapeDesc::Plane, "floor")),
    ];
    let film = render(&d);
    assert!(film.pixels().iter().all(|p| p[0] == 1.0 || (f64::from(p[0]) - sky(0.0)[0]).abs() < 1e-6));
}

#[test]
fn an_opaque_face_that_lies_on_a_glass_one_keeps_the_light_out() {
    // Under filtered shadows: a glass block stands on an opaque table, the eye looks at the floor below. Whichever of
    // the two comes first in the file, no light may pass where they touch.
    for glass_first in [true, false] {
        let mut d = desc(40, 40, orthographic(v(0.0, -0.5, 0.0), v(0.0, -2.0, 0.0), DVec3::Z, 1.0));
        d.render.shadows = Shadows::Filtered;
        d.materials = vec![clear("glass", 1.5), bare("table", Rgb::BLACK), matte("floor", WHITE)];
        let block = cuboid(v(0.0, 0.5, 0.0), DVec3::ONE, "glass");
        let table = quad(DVec3::ZERO, 4.0, DVec3::ZERO, "table");
        d.objects = if glass_first { vec![block, table] } else { vec![table, block] };
        d.objects.push(quad(v(0.0, -1.0, 0.0), 100.0, DVec3::ZERO, "floor"));
        d.lights = vec![point_light(v(0.0, 3.0, 0.0), WHITE, 1.0, Falloff::None), sun(v(0.1, 1.0, 0.05), WHITE, 1.0)];
        assert_image("light-through-a-table", &render(&d), EXACT, |_, _| Some([0.0; 3]));
    }
}

#[test]
fn filtered_shadows_take_their_part_at_every_surface_touching_ones_too() {
    // Two panes of glass of k_t = 1/2 that touch: four surfaces, 1/16 of the light.
    let mut d = desc(20, 20, orthographic(v(0.0, 0.5, 0.0), DVec3::ZERO, DVec3::Z, 1.0));
    d.render.shadows = Shadows::Filtered;
    d.materials = vec![MaterialDesc { transmit: 0.5, ..clear("glass", 1.5) }, matte("floor", WHITE)];
    d.objects = vec![
        cuboid(v(0.0, 1.5, 0.0), v(4.0, 1.0, 4.0), "glass"),
        cuboid(v(0.0, 2.5, 0.0), v(4.0, 1.0, 4.0), "glass"),
        object(ShapeDesc::Plane, "floor"),
    ];
    d.lights = vec![sun(DVec3::Y, WHITE, 1.0)];
    assert_image("panes", &render(&d), EXACT, |_, _| Some([1.0 / 16.0; 3]));
}

#[test]
fn faces_that_coincide_up_to_rounding_show_one_of_them_without_specks() {
    // Row 14. A rug on a floor, a picture on a wall: the same plane by different arithmetic. The first in the file is
    // seen.
    for (size, rotate) in [(1.7, v(0.0, 20.0, 0.0)), (2.3, v(33.0, 20.0, 71.0)), (0.9, v(90.0, 0.0, 12.0))] {
        let mut d = desc(90, 70, perspective(v(1.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y, 45.0));
        d.materials = vec![flat("floor", Rgb::new(0.1, 0.2, 0.8)), flat("rug", Rgb::new(0.8, 0.2, 0.1))];
        let up = DQuat::from_rotation_z(rotate.z.to_radians())
            * DQuat::from_rotation_y(rotate.y.to_radians())
            * DQuat::from_rotation_x(rotate.x.to_radians())
            * DVec3::Y;
        let place = v(0.3, 0.1, -0.2);
        let floor = ObjectDesc { rotate, ..at(place, object(ShapeDesc::Plane, "floor")) };
        let rug = quad(place, size, rotate, "rug");
        // A box of which a face lies in the plane, for good measure.
        let block = ObjectDesc { rotate, ..cuboid(place - up * (0.35 * size), v(0.4, 0.7, 0.5) * size, "rug") };
        d.objects = vec![floor.clone()];
        let bare_floor = render(&d);
        d.objects = vec![floor.clone(), rug.clone(), block.clone()];
        let under = render(&d);
        d.objects = vec![rug.clone(), block.clone(), floor.clone()];
        let over = render(&d);
        // The side of the plane that the box is on sees the box.
        if up.dot(d.camera.position - place) > 0.0 {
            assert_eq!(under.hash(), bare_floor.hash());
        }
        // With the floor moved away by a hair, nothing coincides.
        let hair = up * up.dot(d.camera.position - place).signum() * -1e-7;
        d.objects[2].translate += hair;
        assert_within_one_code("rug", &over, &render(&d), 2);
    }
}

#[test]
fn a_material_that_gives_back_twice_what_it_gets_does_not_take_for_ever() {
    // Sixteen mirroring and transparent faces: 2^64 paths at this depth, were all of them followed.
    let mut d = desc(2, 2, perspective(v(0.0, 0.5, 40.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.render.max_depth = 64;
    d.materials = vec![MaterialDesc { reflect: 1.0, ..clear("gain", 1.5) }];
    d.objects = (0..8).map(|i| cuboid(v(0.0, 0.0, f64::from(i)), v(100.0, 100.0, 0.5), "gain")).collect();
    assert!(render(&d).pixels().iter().flatten().all(|c| c.is_finite()));
}
