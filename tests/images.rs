//! Whole pictures of mixed scenes against a second, naive tracer (support/twin.rs) that shares nothing with the
//! renderer but the description.

mod support;

use glam::{DQuat, DVec3};
use glimt::description::*;
use glimt::math::{Rgb, SplitMix64};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use support::twin::Twin;
use support::*;

type Models = HashMap<PathBuf, Vec<[DVec3; 3]>>;

/// Two tracers that round differently may part ways on an edge or deep inside glass: at so few pixels.
fn compare(name: &str, d: &SceneDesc, models: &Models, stray: usize) {
    let twin = Twin::new(d, models);
    let tolerance = Tolerance { relative: 2e-6, absolute: 1e-6, pixels: stray };
    assert_image(name, &render(d), tolerance, |x, y| Some(twin.pixel(x, y)));
}

/// A twisted octahedron, its file and its triangles.
fn octahedron(name: &str) -> (PathBuf, Models) {
    let vertices = [
        v(0.9, 0.05, 0.1),
        v(-0.8, 0.1, 0.0),
        v(0.1, 0.95, -0.1),
        v(0.0, -0.7, 0.2),
        v(0.15, 0.1, 0.85),
        v(-0.1, 0.0, -0.75),
    ];
    // Counter-clockwise from outside: a cycle of +x, +y, +z corners, turned round once for every minus.
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut text = String::new();
    for p in vertices {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for f in faces {
        text += &format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
    }
    let file = model_file(name, &text);
    // The file's numbers are kept in f32 about the centre of the model's box.
    let (lower, upper) = vertices.iter().fold((vertices[0], vertices[0]), |(l, u), p| (l.min(*p), u.max(*p)));
    let center = (lower + upper) / 2.0;
    let kept = vertices.map(|p| center + (p - center).as_vec3().as_dvec3());
    (file.clone(), HashMap::from([(file, faces.map(|f| f.map(|i| kept[i])).to_vec())]))
}

fn colors(rng: &mut SplitMix64) -> Rgb {
    Rgb::new(rng.range(0.1, 1.0), rng.range(0.1, 1.0), rng.range(0.1, 1.0))
}

/// Matte, shiny, chequered, mirroring, glassy: one material of each.
fn palette(rng: &mut SplitMix64) -> Vec<MaterialDesc> {
    let mut all = vec![
        MaterialDesc { ambient: 0.2, diffuse: 0.7, ..bare("matte", colors(rng)) },
        MaterialDesc { ambient: 0.1, diffuse: 0.5, specular: 0.5, shininess: 23.7, ..bare("shiny", colors(rng)) },
        // Five squares each way: whichever way round caps and faces are mapped.
        MaterialDesc {
            ambient: 0.2,
            diffuse: 0.8,
            texture: checker(colors(rng), colors(rng), 0.2),
            ..bare("chequered", Rgb::WHITE)
        },
        MaterialDesc { diffuse: 0.1, specular: 0.6, reflect: 0.7, ..bare("mirror", colors(rng)) },
        MaterialDesc {
            diffuse: 0.1,
            specular: 0.4,
            reflect: 0.1,
            transmit: 0.8,
            ior: 1.3,
            ..bare("glass", colors(rng))
        },
        MaterialDesc {
            specular: 0.3,
            reflect: 0.2,
            ior: 1.5,
            fresnel: true,
            transmit: 0.75,
            ..bare("fresnel", colors(rng))
        },
        MaterialDesc { diffuse: 0.4, reflect: 0.9, ior: 1.6, fresnel: true, ..bare("lacquer", colors(rng)) },
        MaterialDesc { diffuse: 0.2, transmit: 0.6, ..bare("pane", colors(rng)) },
    ];
    all.push(MaterialDesc {
        texture: checker(colors(rng), colors(rng), 0.8),
        ambient: 0.15,
        diffuse: 0.8,
        reflect: 0.1,
        ..bare("floor", Rgb::WHITE)
    });
    all
}

/// Bodies of all shapes and materials on a grid, so that none overlap, over a floor.
fn mixed_scene(seed: u64, mesh_file: &std::path::Path) -> SceneDesc {
    let mut rng = SplitMix64(seed);
    let eye = v(rng.range(-2.0, 2.0), rng.range(1.5, 4.0), rng.range(5.0, 7.0));
    let mut d = desc(96, 72, perspective(eye, v(0.0, 0.4, 0.0), DVec3::Y, 50.0));
    d.world.background = SKY;
    d.world.ambient = colors(&mut rng);
    d.render.max_depth = 6;
    d.materials = palette(&mut rng);
    d.objects.push(at(v(0.0, -0.8, 0.0), object(ShapeDesc::Plane, "floor")));
    for i in 0..12 {
        let material = &d.materials[rng.next_u64() as usize % 7].name.clone();
        let shape = match i % 6 {
            0 => ShapeDesc::Sphere { radius: 0.5 },
            1 => ShapeDesc::Cuboid { size: v(0.7, 0.6, 0.5) },
            2 => ShapeDesc::Cylinder { radius: 0.35, height: 0.8 },
            3 => ShapeDesc::Cone { radius: 0.45, height: 0.9 },
            4 => ShapeDesc::Mesh { file: mesh_file.into(), crease: 0.0 },
            _ => ShapeDesc::Quad { size: glam::DVec2::new(0.9, 0.7) },
        };
        let material = match (i % 6, material.as_str()) {
            (5, _) => "pane",
            (4, "chequered") => "shiny", // The model has no texture coordinates.
            (_, other) => other,
        };
        let place = v(f64::from(i % 4) * 1.4 - 2.1, f64::from(i / 4) * 1.3 - 0.1, rng.range(-1.0, 1.0));
        let sign = if rng.unit() < 0.3 { -1.0 } else { 1.0 };
        d.objects.push(ObjectDesc {
            rotate: v(rng.range(0.0, 360.0), rng.range(0.0, 360.0), rng.range(0.0, 360.0)),
            scale: v(rng.range(0.7, 1.0) * sign, rng.range(0.7, 1.0), rng.range(0.7, 1.0)) * 0.8,
            ..at(place, object(shape, material))
        });
    }
    d.lights = vec![
        point_light(v(-4.0, 6.0, 4.0), Rgb::new(1.0, 0.95, 0.9), 0.5, Falloff::None),
        point_light(v(2.0, 4.0, 1.0), Rgb::new(0.8, 0.9, 1.0), 6.0, Falloff::InverseSquare),
        sun(v(0.4, 1.0, 0.7), Rgb::new(0.9, 0.9, 0.7), 0.3),
    ];
    d
}

#[test]
fn mixed_scenes_of_all_shapes_and_materials_are_as_the_naive_tracer_paints_them() {
    let (file, models) = octahedron("images-mixed");
    for seed in 1..=10 {
        compare(&format!("mixed-{seed}"), &mixed_scene(seed, &file), &models, 2);
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn mixed_scenes_under_filtered_shadows_are_as_the_naive_tracer_paints_them() {
    let (file, models) = octahedron("images-filtered");
    for seed in 11..=14 {
        let mut d = mixed_scene(seed, &file);
        d.render.shadows = Shadows::Filtered;
        compare(&format!("filtered-{seed}"), &d, &models, 2);
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn the_local_models_are_as_the_naive_tracer_paints_them() {
    let (file, models) = octahedron("images-local");
    for shading in [Shading::Lambert, Shading::Phong] {
        let mut d = mixed_scene(15, &file);
        d.render.shading = shading;
        compare("local", &d, &models, 2);
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn an_orthographic_picture_and_every_depth_are_as_the_naive_tracer_paints_them() {
    let (file, models) = octahedron("images-depth");
    let mut d = mixed_scene(16, &file);
    d.camera.projection = Projection::Orthographic { view_height: 5.0 };
    for depth in 0..=5 {
        d.render.max_depth = depth;
        compare(&format!("depth-{depth}"), &d, &models, 2);
    }
    std::fs::remove_file(file).ok();
}

/// Glass bodies that lie in each other and overlap, against the sky.
fn media(objects: Vec<ObjectDesc>) -> SceneDesc {
    let mut d = desc(96, 72, perspective(v(0.4, 1.0, 4.2), v(0.0, 0.0, 0.0), DVec3::Y, 42.0));
    d.world.background = SKY;
    d.render.max_depth = 10;
    let glass =
        |name: &str, ior, priority| MaterialDesc { priority, reflect: 0.05, transmit: 0.95, ..clear(name, ior) };
    d.materials = vec![
        glass("glass", 1.5, 0),
        glass("water", 1.33, 0),
        glass("air", 1.0, 0),
        glass("strong glass", 1.5, 5),
        glass("strong water", 1.33, 3),
        fresnel("fresnel", 1.4),
        MaterialDesc { texture: checker(Rgb::WHITE, Rgb::new(0.1, 0.1, 0.4), 0.5), ..flat("floor", Rgb::WHITE) },
        flat("pearl", Rgb::new(0.8, 0.2, 0.2)),
    ];
    d.objects = objects;
    d.objects.push(quad(v(0.0, -2.5, 0.0), 40.0, DVec3::ZERO, "floor"));
    d
}

#[test]
fn nested_bodies_refract_as_the_bodies_that_contain_each_point_say() {
    let scenes = [
        // A bubble of air in glass in water; the smaller body is what is there.
        vec![
            cuboid(DVec3::ZERO, v(3.0, 2.2, 2.2), "water"),
            sphere(DVec3::ZERO, 1.0, "glass"),
            sphere(v(0.2, 0.1, 0.1), 0.5, "air"),
        ],
        // The same bodies the other way round in the file.
        vec![
            sphere(v(0.2, 0.1, 0.1), 0.5, "air"),
            sphere(DVec3::ZERO, 1.0, "glass"),
            cuboid(DVec3::ZERO, v(3.0, 2.2, 2.2), "water"),
        ],
        // A pearl in a ball of glass, beside a cone that stands half in a block.
        vec![
            sphere(v(-0.6, 0.0, 0.0), 0.9, "fresnel"),
            sphere(v(-0.6, 0.1, 0.0), 0.3, "pearl"),
            cuboid(v(1.0, -0.5, 0.0), v(1.0, 0.8, 1.0), "strong glass"),
            at(v(1.05, 0.2, 0.1), object(ShapeDesc::Cone { radius: 0.4, height: 1.3 }, "water")),
        ],
        // Overlap decided by priority against size, both ways round.
        vec![
            sphere(v(-0.5, 0.0, 0.0), 0.9, "strong glass"),
            sphere(v(0.5, 0.0, 0.0), 0.6, "strong water"),
            sphere(v(1.2, 0.3, 0.1), 0.5, "air"),
        ],
        vec![sphere(v(-0.4, 0.0, 0.0), 0.9, "glass"), sphere(v(0.5, 0.1, 0.0), 0.7, "strong water")],
        // An onion of eight shells.
        (0..8)
            .map(|i| {
                sphere(v(0.02 * f64::from(i), 0.0, 0.0), 1.2 - 0.14 * f64::from(i), ["glass", "water"][i as usize % 2])
            })
            .collect(),
    ];
    for (i, objects) in scenes.into_iter().enumerate() {
        // Seen from outside; and from inside the first body.
        for eye in [v(0.4, 1.0, 4.2), objects[0].translate + v(-0.61, 0.05, 0.3)] {
            let mut d = media(objects.clone());
            d.camera.position = eye;
            d.camera.look_at = v(0.3, 0.0, 0.0);
            if d.objects.len() > 6 {
                d.film = FilmDesc { width: 32, height: 24 }; // Every shell doubles the paths.
            }
            compare(&format!("media-{i}"), &d, &Models::new(), 2);
        }
    }
}

#[test]
fn bodies_that_overlap_at_random_are_as_the_naive_tracer_paints_them() {
    let (file, models) = octahedron("images-overlap");
    for seed in 100..130 {
        let mut d = mixed_scene(seed, &file);
        let mut rng = SplitMix64(seed * 77);
        d.film = FilmDesc { width: 48, height: 36 };
        d.camera.projection = Projection::Perspective { fov: 22.0 };
        if seed % 4 == 0 {
            // The eye among them, in glass or not.
            d.camera.position = v(rng.range(-1.0, 1.0), rng.range(0.0, 1.0), rng.range(-1.0, 1.0));
            d.camera.projection = Projection::Perspective { fov: 90.0 };
        }
        if seed % 3 == 0 {
            d.render.shadows = Shadows::Filtered;
        }
        d.materials.iter_mut().for_each(|m| m.priority = (rng.next_u64() % 3) as i32);
        for (i, o) in d.objects.iter_mut().enumerate().skip(1) {
            o.translate = v(rng.range(-1.2, 1.2), rng.range(0.0, 1.6), rng.range(-1.2, 1.2));
            if i % 6 != 0 && i % 2 == 0 {
                o.material = Some(["glass", "fresnel"][i / 2 % 2].into());
            }
        }
        compare(&format!("overlap-{seed}"), &d, &models, 2);
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn blocks_of_glass_that_touch_up_to_rounding_are_as_the_naive_tracer_paints_them() {
    // A turned lattice of cubes face to face, each of another index: their faces coincide, but for the last digits, and
    // light goes from one glass into the next without air between.
    for seed in 1..=8 {
        let mut rng = SplitMix64(seed);
        let mut d = desc(48, 36, perspective(v(1.0, 1.5, 6.0), DVec3::ZERO, DVec3::Y, 32.0));
        d.world.background = SKY;
        d.render.max_depth = 12;
        let rotate = v(rng.range(0.0, 90.0), rng.range(0.0, 90.0), rng.range(0.0, 90.0));
        let turn = DQuat::from_rotation_z(rotate.z.to_radians())
            * DQuat::from_rotation_y(rotate.y.to_radians())
            * DQuat::from_rotation_x(rotate.x.to_radians());
        let side = rng.range(0.5, 0.9);
        for i in 0..12 {
            let name = format!("glass {i}");
            // Fresnel's part would double the paths at every face.
            d.materials.push(clear(&name, rng.range(1.05, 1.9)));
            let place = v(f64::from(i % 3) - 1.0, f64::from(i / 3 % 2) - 0.5, f64::from(i / 6) - 0.5) * side;
            d.objects.push(ObjectDesc { rotate, ..cuboid(turn * place, DVec3::splat(side), &name) });
        }
        compare(&format!("lattice-{seed}"), &d, &Models::new(), 4);
    }
}

#[test]
fn text_and_code_describe_the_same_picture() {
    let text = r##"
[film]
width = 40
height = 30
[camera]
position = [0, 1, 6]
look_at = [0, 0, 0]
up = [0, 1, 0]
fov = 40
[world]
ambient = [1, 1, 1]
background = { top = [1, 0.2, 0], bottom = [0.1, 0.9, 0.5] }
ior = 1.0
[render]
shading = "whitted"
max_depth = 5
samples = 1
[[light]]
kind = "point"
position = [4, 6, 3]
color = [1, 1, 1]
intensity = 0.8
[[material]]
name = "glass"
color = [0.5, 0.2, 0.7]
ambient = 0.1
diffuse = 0.1
specular = 0.6
shininess = 80
reflect = 0.1
transmit = 0.8
ior = 1.3
[[material]]
name = "floor"
color = [0.3, 0.4, 0.5]
ambient = 0.2
diffuse = 0.7
specular = 0
[[object]]
shape = "sphere"
radius = 0.8
material = "glass"
translate = [0, 0.5, 0]
rotate = [0, 30, 0]
scale = [1, 1.5, 1]
[[object]]
shape = "plane"
material = "floor"
translate = [0, -1, 0]
"##;
    let mut d = desc(40, 30, perspective(v(0.0, 1.0, 6.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.world.background = SKY;
    d.render.max_depth = 5;
    d.lights = vec![point_light(v(4.0, 6.0, 3.0), Rgb::WHITE, 0.8, Falloff::None)];
    d.materials = vec![
        MaterialDesc {
            ambient: 0.1,
            diffuse: 0.1,
            specular: 0.6,
            shininess: 80.0,
            reflect: 0.1,
            transmit: 0.8,
            ior: 1.3,
            ..bare("glass", Rgb::new(0.5, 0.2, 0.7))
        },
        MaterialDesc { ambient: 0.2, diffuse: 0.7, ..bare("floor", Rgb::new(0.3, 0.4, 0.5)) },
    ];
    d.objects = vec![
        ObjectDesc { rotate: v(0.0, 30.0, 0.0), scale: v(1.0, 1.5, 1.0), ..sphere(v(0.0, 0.5, 0.0), 0.8, "glass") },
        at(v(0.0, -1.0, 0.0), object(ShapeDesc::Plane, "floor")),
    ];
    assert_eq!(render_text(text).hash(), render(&d).hash());
}

#[test]
fn every_scene_that_ships_has_a_picture_that_all_f64_arithmetic_confirms() {
    let mut paths = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), "toml", &mut paths);
    assert!(!paths.is_empty());
    for path in paths {
        let text = std::fs::read_to_string(&path).expect("a scene can be read");
        let mut d = parse(&text, &path).unwrap_or_else(|errors| panic!("{}: {errors:#?}", path.display()));
        d.film = FilmDesc { width: 96, height: (96 * d.film.height / d.film.width).max(1) };
        d.render.samples = 1;
        let robust = render(&d); // Fails on samples that are not finite.
        let bright = robust.pixels().iter().flatten().filter(|c| **c > 0.0).count();
        assert!(bright > 0, "{} is black", path.display());
        d.render.numerics = Numerics::Reference;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        assert_within_one_code(&name, &robust, &render(&d), 0);
    }
}
