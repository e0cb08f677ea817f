//! Rows 21 to 27: bodies in bodies, total reflection.

use crate::support::*;
use crate::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;

#[test]
fn a_camera_inside_glass_sees_the_world_from_inside_it() {
    // At the centre of a ball of glass every ray leaves at a right angle, unbent: the ball cannot be seen. Elsewhere
    // in a slab rays leave by Snell's law from the index of the slab.
    let mut d = desc(60, 40, perspective(DVec3::ZERO, v(0.3, 0.4, -1.0), DVec3::Y, 70.0));
    d.world.background = SKY;
    d.materials = vec![clear("glass", 1.5), clear("water", 1.33)];
    d.objects = vec![sphere(DVec3::ZERO, 1.0, "glass")];
    assert_image("inside-ball", &render(&d), EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
    // In a ball in a slab: unbent out of the ball, then sin(t) = n sin(i) out of the water.
    d.objects.push(cuboid(DVec3::ZERO, v(1e4, 4.0, 1e4), "water"));
    d.camera.look_at = v(0.1, 1.0, 0.0);
    assert_image("inside-ball-in-water", &render(&d), EXACT, |x, y| {
        let (_, dir) = pixel_ray(&d, x, y);
        let sin = 1.33 * (1.0 - dir.y * dir.y).sqrt();
        // Beyond the critical angle it goes to and fro in the slab; 8 steps deep there is nothing.
        (sin < 1.0 && dir.y > 0.0).then(|| sky((1.0 - sin * sin).sqrt()))
    });
}

#[test]
fn a_bubble_is_the_same_as_overlapping_bodies_and_as_nested_surfaces() {
    // S13. Three ways to build a glass ball with an air bubble in a sea: two bodies of which the smaller wins; the
    // same with priorities; and the bubble much larger in volume but winning by priority only where it matters. And
    // three ways to build a block of water: whole, two halves that touch, two halves that overlap.
    let scene = |objects: Vec<ObjectDesc>, eye: DVec3| {
        let mut d = desc(96, 72, perspective(eye, v(-0.1, 0.0, 0.0), DVec3::Y, 40.0));
        d.world.background = SKY;
        // Crossing a seam may cost a step of depth: enough for no path to notice.
        d.render.max_depth = 40;
        d.materials = vec![
            clear("glass", 1.5),
            clear("air", 1.0),
            clear("water", 1.33),
            MaterialDesc { priority: 2, ..clear("strong air", 1.0) },
            MaterialDesc { priority: 1, ..clear("middle glass", 1.5) },
            MaterialDesc { texture: checker(WHITE, Rgb::new(0.1, 0.2, 0.5), 0.5), ..flat("floor", WHITE) },
        ];
        d.objects = objects;
        d.objects.push(at(v(0.0, -3.0, 0.0), object(ShapeDesc::Plane, "floor")));
        render(&d)
    };
    for eye in [v(0.3, 0.8, 6.0), v(0.3, 0.2, 1.3), v(0.05, 0.02, 0.1), v(0.01, 0.75, 0.0)] {
        let water = cuboid(DVec3::ZERO, v(4.0, 3.0, 4.0), "water");
        let plain = [water.clone(), sphere(DVec3::ZERO, 1.0, "glass"), sphere(v(0.1, 0.0, 0.0), 0.5, "air")];
        let ranked =
            [sphere(v(0.1, 0.0, 0.0), 0.5, "strong air"), water.clone(), sphere(DVec3::ZERO, 1.0, "middle glass")];
        let a = scene(plain.to_vec(), eye);
        let b = scene(ranked.to_vec(), eye);
        assert_within_one_code("bubble", &b, &a, 0);
        // Water in halves: faces that coincide at x = 0, then halves that overlap by a quarter, both drowned faces of
        // one index.
        let half = |x: f64, width: f64| cuboid(v(x, 0.0, 0.0), v(width, 3.0, 4.0), "water");
        let inner = [sphere(DVec3::ZERO, 1.0, "middle glass"), sphere(v(0.1, 0.0, 0.0), 0.5, "strong air")];
        let touching = [&[half(-1.0, 2.0), half(1.0, 2.0)], &inner[..]].concat();
        let overlapping = [&[half(-0.75, 2.5), half(1.0, 2.0)], &inner[..]].concat();
        // Nothing may change, but on the seam.
        assert_within_one_code("halves-touching", &scene(touching, eye), &b, 2);
        assert_within_one_code("halves-overlapping", &scene(overlapping, eye), &b, 2);
    }
}

#[test]
fn layers_that_touch_up_to_rounding_refract_as_layers_that_touch() {
    // 3.4 + 0.2 and 2.95 + 0.25 are not the same number as the one they mean; a unit in the last place of gap or
    // overlap may not lose a boundary.
    let picture = |tops: [f64; 3], t: [f64; 3]| {
        let mut d = desc(60, 44, perspective(v(0.3, 5.0, 0.2), v(1.5, 0.0, 0.5), DVec3::Y, 60.0));
        let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 0.5, 1.2);
        ruler.add_to(&mut d, 1000.0);
        for (i, n) in [1.5, 2.0, 1.33].into_iter().enumerate() {
            d.materials.push(clear(&format!("glass {i}"), n));
            let center = v(0.0, tops[i] - t[i] / 2.0, 0.0);
            d.objects.push(cuboid(center, v(400.0, t[i], 400.0), &format!("glass {i}")));
        }
        render(&d)
    };
    let want = picture([3.5, 3.0, 2.5], [0.5; 3]);
    for ulps in [-3.0, -1.0, 1.0, 3.0] {
        let step = ulps * f64::EPSILON * 2.0;
        let got = picture([3.5 + step, 3.0, 2.5 - step], [0.5; 3]);
        assert_same("touching-layers", &got, &want, Tolerance { relative: 1e-5, ..EXACT });
    }
}

#[test]
fn total_internal_reflection_and_fractional_highlights_give_no_nan() {
    // Rows 21, 22, 27: a block of dense glass full of total reflection, and highlights with (v, r) < 0 under fractional
    // exponents. Film and counters stay clean (finish() checks the counter).
    let mut d = mixed(1.0, DVec3::ZERO);
    d.materials.push(MaterialDesc { shininess: 7.3, specular: 0.9, diffuse: 0.2, ..fresnel("dense", 2.4) });
    d.materials.push(MaterialDesc { shininess: 0.5, specular: 0.9, diffuse: 0.2, ..clear("denser", 3.0) });
    d.objects.push(ObjectDesc { rotate: v(20.0, 50.0, 0.0), ..cuboid(v(0.0, 1.2, 1.0), DVec3::splat(0.9), "dense") });
    d.objects.push(ObjectDesc { rotate: v(50.0, 10.0, 0.0), ..cuboid(v(-1.0, 1.4, 1.0), DVec3::splat(0.6), "denser") });
    d.render.max_depth = 12;
    d.lights.push(point_light(v(-1.0, -0.3, -2.0), WHITE, 1.0, Falloff::InverseSquare));
    assert!(render(&d).pixels().iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
    // No ghost: where (v, r) < 0 there is no highlight, for even exponents either. Light and eye on opposite slants.
    let mut d = desc(31, 31, orthographic(v(5.0, 1.0, 0.0), DVec3::ZERO, DVec3::Y, 1.0));
    for shininess in [1.0, 2.0, 10.0, 0.5, 3.7] {
        d.materials = vec![MaterialDesc { specular: 1.0, shininess, ..bare("shiny", WHITE) }];
        d.objects = vec![object(ShapeDesc::Plane, "shiny")];
        // The mirrored light goes toward +x up only if the light stands at -x; this one stands at +x.
        d.lights = vec![sun(v(5.0, 0.9, 0.0), WHITE, 1.0)];
        assert_image("ghost", &render(&d), EXACT, |_, _| Some([0.0; 3]));
    }
}

#[test]
fn an_orthographic_camera_may_start_its_rays_inside_and_outside_of_glass() {
    // Each ray has its own start: half of them begin inside of a ball of index 1.5 and leave it by Snell's law, half
    // begin outside. At impact parameter b, inside from the equator plane on: sin(t) = n b, beyond 1/n total
    // reflection.
    let mut d = desc(81, 61, orthographic(DVec3::ZERO, DVec3::NEG_Y, DVec3::NEG_Z, 2.4));
    d.world.background = SKY;
    d.render.max_depth = 1;
    d.materials = vec![clear("glass", 1.5)];
    d.objects = vec![sphere(DVec3::ZERO, 1.0, "glass")];
    let excluded = assert_exact("ortho-inside", &d, 1e-9, |x, y| {
        let (o, _) = pixel_ray(&d, x, y);
        let b = o.x.hypot(o.z);
        if (b - 1.0).abs() < 1e-6 || (b - 1.0 / 1.5).abs() < 1e-6 {
            return None;
        }
        if b > 1.0 {
            return Some(sky(-1.0));
        }
        if 1.5 * b > 1.0 {
            return Some([0.0; 3]); // Caught: one step of depth brings it to the wall again.
        }
        // Turned toward the axis, as leaving dense glass turns away from the normal.
        let turned = (1.5 * b).asin() - b.asin();
        Some(sky(-turned.cos()))
    });
    assert!(excluded <= 4);
}

#[test]
fn a_pane_of_glass_fifty_million_times_as_wide_as_thick_still_has_two_sides() {
    // Seen through it, sideways by less than a millionth, is the sky in the same direction; a pane that lost its back
    // would bend what is behind.
    // The last one is 2e-8 of its width.
    for thickness in [1e-2, 1e-4, 1e-6, 1.6e-7] {
        let mut d = desc(40, 30, perspective(v(1.0, 2.0, 6.0), DVec3::ZERO, DVec3::Y, 40.0));
        d.world.background = SKY;
        d.materials = vec![clear("glass", 1.5)];
        d.objects =
            vec![ObjectDesc { rotate: v(20.0, 30.0, 0.0), ..cuboid(DVec3::ZERO, v(8.0, 8.0, thickness), "glass") }];
        assert_image("pane", &render(&d), EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
    }
}

#[test]
fn blocks_that_touch_are_one_block_from_a_million_sizes_away() {
    // At that distance t is rounded to 1e-10: the faces that touch, turned so that no number of them is exact, are met
    // at any side of each other. One block of glass, and the same in halves.
    for distance in [1e2, 1e4, 1e6] {
        let rotate = v(25.0, 37.0, 11.0);
        let across = glam::DQuat::from_rotation_z(rotate.z.to_radians())
            * glam::DQuat::from_rotation_y(rotate.y.to_radians())
            * glam::DQuat::from_rotation_x(rotate.x.to_radians())
            * DVec3::X;
        let eye = v(0.3, 0.5, 1.0).normalize() * distance;
        let fov = 2.0 * (1.2 / distance).atan().to_degrees();
        let mut d = desc(80, 60, perspective(eye, DVec3::ZERO, DVec3::Y, fov));
        d.world.background = SKY;
        d.render.max_depth = 24;
        d.materials = vec![clear("glass", 1.5)];
        let block = |x: f64, width: f64| ObjectDesc { rotate, ..cuboid(across * x, v(width, 1.1, 0.9), "glass") };
        d.objects = vec![block(0.0, 1.4)];
        let whole = render(&d);
        d.objects = vec![block(-0.35, 0.7), block(0.35, 0.7)];
        // The seam itself, where a ray runs along it, is allowed a few pixels.
        assert_within_one_code("far-halves", &render(&d), &whole, 6);
    }
}

/// How many samples of a picture had a ray in too many bodies.
fn overfull(d: &SceneDesc) -> u64 {
    let handle = glimt::render::start(compile(d), settings(2, 32));
    let stats = handle.events().into_iter().map(|event| match event {
        glimt::render::RenderEvent::TileFinished { stats, .. } => stats.overfull,
        _ => 0,
    });
    stats.sum()
}

#[test]
fn bodies_beyond_the_eighth_around_a_ray_are_counted() {
    // Balls in balls, all of the world's index, so that no ray is bent: the ninth is entered by the rays that pass the
    // middle within its radius.
    let mut d = desc(41, 31, orthographic(v(0.0, 0.0, 9.0), DVec3::ZERO, DVec3::Y, 4.2));
    d.world.background = SKY;
    d.render.max_depth = 40;
    d.materials = vec![clear("nothing", 1.0)];
    let radius = |k: u32| 2.0 - 0.1 * f64::from(k);
    d.objects = (0..8).map(|k| sphere(DVec3::ZERO, radius(k), "nothing")).collect();
    assert_eq!(overfull(&d), 0);
    d.objects.push(sphere(DVec3::ZERO, radius(8), "nothing"));
    let within = |x: u32, y: u32| {
        let (o, _) = pixel_ray(&d, x, y);
        o.x.hypot(o.y) < radius(8)
    };
    let inside = (0..31).flat_map(|y| (0..41).map(move |x| (x, y))).filter(|&(x, y)| within(x, y)).count() as u64;
    assert!(inside > 200);
    assert_eq!(overfull(&d), inside);
    // The program tells: a warning, and a number for programs.
    let mut text =
        String::from("[film]\nwidth = 20\nheight = 20\n[camera]\nposition = [0, 0, 9]\n[render]\nmax_depth = 40\n");
    text += "[[material]]\nname = \"nothing\"\ntransmit = 1\nior = 1\n";
    for k in 0..9 {
        text += &format!("[[object]]\nshape = \"sphere\"\nradius = {}\nmaterial = \"nothing\"\n", radius(k));
    }
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("nested-{}.toml", std::process::id()));
    std::fs::write(&file, text).expect("the scene can be written");
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_glimt"))
        .args(["render", "--samples", "1", "--json"])
        .arg(&file)
        .arg("-o")
        .arg(file.with_extension("png"))
        .output()
        .expect("the binary runs");
    let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{err}");
    assert!(err.contains("more than 8 transparent bodies"), "{err}");
    assert!(out.contains("\"overfull_media\":") && !out.contains("\"overfull_media\":0,"), "{out}");
    std::fs::remove_file(file.with_extension("png")).ok();
    std::fs::remove_file(file).ok();
}

#[test]
fn light_out_of_water_under_air_in_a_tumbler_loses_the_part_of_the_water_and_no_more() {
    // The tumbler of scenes/lighting/media.toml: the top of the water and the bottom of the air are one face up to
    // rounding (0.525 + 0.85 / 2 and 1.2 - 0.5 / 2), both inside of a body of glass that they outrank. Light from above
    // crosses that face and no other that counts. In f32 either body may come first, and half of the rays then lose
    // nothing.
    for numerics in [Numerics::Robust, Numerics::Reference] {
        for (turn, lean) in [(0.0, v(0.0, 1.0, 0.0)), (33.0, v(0.1, 1.0, -0.05)), (71.0, v(-0.1, 1.0, 0.13))] {
            let mut d = desc(40, 40, orthographic(v(0.0, 0.5, 0.0), v(0.0, 0.4, 0.0), DVec3::NEG_Z, 0.2));
            d.render.shadows = Shadows::Filtered;
            d.render.numerics = numerics;
            d.materials = vec![
                MaterialDesc { transmit: 0.98, ..clear("glass", 1.5) },
                MaterialDesc { transmit: 0.96, priority: 1, ..clear("water", 1.333) },
                MaterialDesc { priority: 1, ..clear("air", 1.0) },
                matte("coin", WHITE),
            ];
            let tube = |y: f64, radius: f64, height: f64, material: &str| ObjectDesc {
                rotate: v(0.0, turn, 0.0),
                ..at(v(0.0, y, 0.0), object(ShapeDesc::Cylinder { radius, height }, material))
            };
            d.objects = vec![
                tube(0.651, 0.52, 1.3, "glass"),
                tube(0.525, 0.46, 0.85, "water"),
                tube(1.2, 0.46, 0.5, "air"),
                quad(v(0.0, 0.4, 0.0), 0.3, DVec3::ZERO, "coin"),
            ];
            d.lights = vec![sun(lean, WHITE, 1.0)];
            let cosine = lean.normalize().y;
            assert_image("tumbler", &render(&d), EXACT, |_, _| Some([0.96 * cosine; 3]));
        }
    }
}
