//! Pictures of one row, smooth mirrors, doubled faces, slivers, flattened bodies.

use crate::support::*;
use crate::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;

#[test]
fn a_picture_of_one_column_or_one_row_is_that_line_of_a_larger_one() {
    // The field of view is that of the height: a column of width 1 is the middle of one of width 7, ray by ray. A row
    // is the middle one of three under three times the view height, up to the rounding of rays.
    let mut d = mixed(1.0, DVec3::ZERO);
    (d.film.width, d.film.height) = (7, 40);
    let wide = render(&d);
    d.film.width = 1;
    let column = render(&d);
    for y in 0..40 {
        assert_eq!(column.pixel(0, y).map(f32::to_bits), wide.pixel(3, y).map(f32::to_bits), "row {y}");
    }
    d.camera = orthographic(v(1.0, 2.0, 5.0), v(0.0, 0.25, 0.0), DVec3::Y, 0.15);
    (d.film.width, d.film.height) = (60, 3);
    let three = render(&d);
    d.film.height = 1;
    d.camera.projection = Projection::Orthographic { view_height: 0.05 };
    let middle = (0..60).map(|x| three.pixel(x, 1)).collect();
    assert_within_one_code("one-row", &render(&d), &film_of(60, 1, middle), 1);
}

#[test]
fn a_smooth_convex_mirror_of_any_size_reflects_nothing_of_itself_and_never_below_its_facets() {
    // Under a white sky each pixel of a mirror of k_r = 1/2 is exactly 1/2; a ray sent below a facet would meet the
    // body again and bring 1/4. The normals are interpolated over facets of up to 45 degrees, and the eye sees them up
    // to the rim.
    for (name, obj) in [("smooth-mirror-coarse", octahedron_obj()), ("smooth-mirror-fine", ball_obj(8))] {
        let file = model_file(name, &obj);
        for size in [1e-6, 1.0, 1e6] {
            for far in [0.0, 1e4] {
                let offset = v(1.0, -2.0, 0.5) * (size * far);
                let mut d = desc(64, 64, perspective(offset + v(1.0, 2.0, 3.0) * size, offset, DVec3::Y, 34.0));
                d.world.background = Background::Solid(WHITE);
                d.materials = vec![MaterialDesc { reflect: 0.5, ..bare("mirror", Rgb::BLACK) }];
                let shape = ShapeDesc::Mesh { file: file.clone(), crease: 180.0 };
                d.objects = vec![ObjectDesc { scale: DVec3::splat(size), ..at(offset, object(shape, "mirror")) }];
                let film = render(&d);
                assert!(film.pixels().iter().all(|p| p[0] == 0.5 || p[0] == 1.0), "{name} of size {size} at {far}");
                assert!(film.pixels().iter().filter(|p| p[0] == 0.5).count() > 300);
            }
        }
        std::fs::remove_file(file).ok();
    }
}

#[test]
fn a_mesh_with_every_face_twice_is_the_mesh() {
    // Doubled in the file, and doubled as an object in the same place: of opaque ones the first is seen, and bodies of
    // glass that hold each other are crossed together.
    let single = model_file("faces-once", &octahedron_obj());
    let faces: String =
        octahedron_obj().lines().filter(|line| line.starts_with('f')).map(|l| format!("{l}\n")).collect();
    let double = model_file("faces-twice", &(octahedron_obj() + &faces));
    let mut d = desc(80, 60, perspective(v(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.world.background = SKY;
    d.materials = vec![
        MaterialDesc { ambient: 0.2, ..matte("first", Rgb::new(0.9, 0.3, 0.1)) },
        MaterialDesc { ambient: 0.2, ..matte("second", Rgb::new(0.1, 0.3, 0.9)) },
        fresnel("glass", 1.5),
    ];
    d.lights = vec![point_light(v(2.0, 4.0, 3.0), WHITE, 1.0, Falloff::None)];
    for material in ["first", "glass"] {
        d.objects = vec![mesh(&single, material)];
        let once = render(&d);
        d.objects = vec![mesh(&double, material)];
        assert_eq!(render(&d).hash(), once.hash(), "doubled in the file, {material}");
        let other = if material == "first" { "second" } else { "glass" };
        d.objects = vec![mesh(&single, material), mesh(&single, other)];
        assert_within_one_code("doubled-object", &render(&d), &once, 0);
    }
    std::fs::remove_file(single).ok();
    std::fs::remove_file(double).ok();
}

#[test]
fn a_closed_body_of_slivers_has_no_hole() {
    // Two flat pyramids of a thousand triangles each, base to base, 300 to 30,000 times as long as wide or high, looked
    // at from inside: no sky shows.
    for height in [1.0, 1e-2, 1e-4] {
        let count = 1000;
        let mut text = format!("v 0 {height} 0\nv 0 -{height} 0\n");
        for i in 0..count {
            let (s, c) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
            text += &format!("v {s} 0 {c}\n");
        }
        for i in 0..count {
            let (a, b) = (3 + i, 3 + (i + 1) % count);
            text += &format!("f 1 {a} {b}\nf 2 {b} {a}\n");
        }
        let file = model_file(&format!("slivers-{height}"), &text);
        for (size, offset) in [(1.0, DVec3::ZERO), (1e-5, DVec3::ZERO), (1.0, v(1e4, -2e4, 3e3))] {
            let eye = offset + v(0.1, 0.1 * height, 0.2) * size;
            for toward in [v(1.0, 0.0, 0.3), v(0.2, height, -0.1), v(-0.3, -height, -0.6)] {
                let mut d = desc(120, 90, perspective(eye, eye + toward * size, v(0.1, 1.0, 0.2), 120.0));
                d.world.background = Background::Solid(Rgb::new(1.0, 0.0, 0.0));
                d.materials = vec![flat("wall", WHITE)];
                d.objects = vec![ObjectDesc { scale: DVec3::splat(size), ..at(offset, mesh(&file, "wall")) }];
                assert_image("slivers", &render(&d), EXACT, |_, _| Some([1.0; 3]));
            }
        }
        std::fs::remove_file(file).ok();
    }
}

#[test]
fn a_body_flattened_ten_million_times_covers_its_disc_and_a_flat_one_is_refused() {
    let mut d = desc(81, 81, orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.4));
    d.materials = vec![matte("matte", WHITE)];
    d.lights = vec![sun(DVec3::Y, WHITE, 1.0)];
    for shape in [ShapeDesc::Sphere { radius: 1.0 }, ShapeDesc::Cylinder { radius: 1.0, height: 2.0 }] {
        for flat in [1.0, -1.0] {
            // Mirrored or not, its upper side looks up.
            let scale = v(1.0, 1e-7, flat);
            d.objects = vec![ObjectDesc { scale, ..object(shape.clone(), "matte") }];
            let tolerance = Tolerance { absolute: 1e-6, ..EXACT };
            let excluded = assert_image("flattened", &render(&d), tolerance, |x, y| {
                let (o, _) = pixel_ray(&d, x, y);
                let rho = o.x.hypot(o.z);
                ((rho - 1.0).abs() > 1e-3).then_some([if rho < 1.0 { 1.0 } else { 0.0 }; 3])
            });
            assert!(excluded <= 12, "{excluded}");
            d.objects[0].scale.y = 0.0;
            assert!(glimt::scene::compile(&d, None).is_err());
            d.objects[0].scale.y = 1e-12;
            assert!(glimt::scene::compile(&d, None).is_err());
        }
    }
}
