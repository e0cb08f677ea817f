//! Why a pixel has its colour, and pictures of something else than light.

mod support;

use glimt::description::*;
use glimt::math::Rgb;
use glimt::render::{Explanation, Film, Layers, RenderEvent, View, explain, start, start_probe};
use glimt::scene::compile as compile_scene;
use glimt::shading::{Branch, End, Probe, RayTree};
use std::path::{Path, PathBuf};
use support::*;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;

/// Every scene that is delivered, made small.
fn gallery() -> Vec<(PathBuf, SceneDesc)> {
    let mut found = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), "toml", &mut found);
    found.sort();
    let small = |file: PathBuf| {
        let mut desc = parse(&std::fs::read_to_string(&file).unwrap(), &file).unwrap();
        (desc.film.width, desc.film.height) = (WIDTH, HEIGHT);
        (desc.render.samples, desc.render.error) = (3, None);
        (file, desc)
    };
    found.into_iter().map(small).collect()
}

/// The terms of a tree added up in the order of the equation, each ray from its own terms.
fn added(ray: &RayTree) -> Rgb {
    let End::Surface(surface) = &ray.end else { return ray.radiance };
    let mut sum = surface.ambient;
    for light in surface.lights.iter().filter(|light| light.part != 0.0) {
        sum += light.sum;
    }
    for branch in &surface.branches {
        if let Branch::Ray(ray) = branch {
            sum += added(ray) * ray.share;
        }
    }
    sum
}

fn bits(c: Rgb) -> [u64; 3] {
    [c.r, c.g, c.b].map(f64::to_bits)
}

fn visit<'a>(ray: &'a RayTree, see: &mut impl FnMut(&'a RayTree)) {
    see(ray);
    if let End::Surface(surface) = &ray.end {
        for branch in &surface.branches {
            if let Branch::Ray(ray) = branch {
                visit(ray, see);
            }
        }
    }
}

#[test]
fn the_terms_of_every_pixel_add_up_to_the_rendered_colour_bit_for_bit() {
    let (mut shadows, mut filtered, mut behind, mut cuts, mut refracted, mut media, mut triangles) =
        (0, 0, 0, 0, 0, 0, 0);
    let scenes = gallery();
    assert!(scenes.len() >= 20);
    for (file, desc) in scenes {
        let scene = compile(&desc);
        let film = finish(start(scene.clone(), settings(2, 8)), WIDTH, HEIGHT);
        for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).step_by(5) {
            let told: Explanation = explain(&scene, &desc, (x, y), 3, Some(y % 3));
            let name = file.display();
            assert_eq!(told.color.map(f32::to_bits), film.pixel(x, y).map(f32::to_bits), "{name} at {x},{y}");
            assert_eq!(bits(told.radiance), bits(told.tree.radiance), "{name} at {x},{y}");
            assert_eq!(bits(added(&told.tree)), bits(told.radiance), "{name} at {x},{y}:\n{told}");
            visit(&told.tree, &mut |ray| {
                refracted += usize::from(ray.kind == glimt::shading::RayKind::Refraction);
                media += usize::from(ray.medium.object.is_some());
                let End::Surface(surface) = &ray.end else { return };
                triangles += usize::from(surface.primitive > 6);
                for light in &surface.lights {
                    behind += usize::from(light.behind);
                    shadows += usize::from(light.part == 0.0 && light.shadow_of.is_some());
                    filtered += usize::from(light.part > 0.0 && light.part < 1.0);
                }
                cuts += surface.branches.iter().filter(|branch| matches!(branch, Branch::Cut(_))).count();
            });
        }
    }
    // All that a tree can tell is in the gallery.
    let seen = [shadows, filtered, behind, cuts, refracted, media, triangles];
    assert!(seen.iter().all(|count| *count > 20), "{seen:?}");
}

#[test]
fn every_preset_and_model_tells_the_colour_that_it_renders() {
    let desc = gallery().into_iter().find(|(file, _)| file.ends_with("media.toml")).unwrap().1;
    for numerics in [Numerics::Classic, Numerics::Fast, Numerics::Reference] {
        for shading in [Shading::Lambert, Shading::Phong, Shading::Whitted] {
            let mut desc = desc.clone();
            (desc.render.numerics, desc.render.shading) = (numerics, shading);
            let scene = compile(&desc);
            let mut film = Film::new(WIDTH, HEIGHT);
            for event in start(scene.clone(), settings(1, 8)).events() {
                if let RenderEvent::TileFinished { tile, .. } = event {
                    film.write(&tile);
                }
            }
            for (x, y) in [(3, 12), (12, 8), (14, 9), (20, 5)] {
                let told = explain(&scene, &desc, (x, y), 3, None);
                assert_eq!(told.color, film.pixel(x, y), "{numerics:?} {shading:?} at {x},{y}");
            }
        }
    }
}

#[test]
fn with_an_error_to_reach_the_tree_and_what_cut_paths_are_taken_to_bring_are_the_colour() {
    let mut cuts = 0;
    for (file, mut desc) in gallery() {
        desc.render.error = Some(20.0);
        let scene = compile(&desc);
        let film = finish(start(scene.clone(), settings(2, 8)), WIDTH, HEIGHT);
        for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).step_by(7) {
            let told: Explanation = explain(&scene, &desc, (x, y), 3, Some(y % 3));
            let name = file.display();
            assert_eq!(told.color.map(f32::to_bits), film.pixel(x, y).map(f32::to_bits), "{name} at {x},{y}");
            assert_eq!(bits(added(&told.tree)), bits(told.tree.radiance), "{name} at {x},{y}:\n{told}");
            assert_eq!(bits(told.tree.radiance + told.tail), bits(told.radiance), "{name} at {x},{y}:\n{told}");
            cuts += usize::from(told.tail != Rgb::BLACK);
        }
    }
    assert!(cuts > 20, "{cuts}");
}

fn probe(desc: &SceneDesc, probe: Probe) -> Film {
    let film = finish(start_probe(compile(desc), probe, settings(2, 8)), desc.film.width, desc.film.height);
    assert_eq!(film, finish(start_probe(compile(desc), probe, settings(1, 32)), desc.film.width, desc.film.height));
    film
}

/// A unit sphere at the origin before a wall, seen straight on by parallel rays: pixels are 1/10 wide.
fn ball_and_wall() -> SceneDesc {
    let mut d = desc(40, 40, orthographic(v(0.0, 0.0, 5.0), v(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), 4.0));
    d.materials = vec![flat("red", Rgb::new(1.0, 0.0, 0.0)), flat("blue", Rgb::new(0.0, 0.0, 1.0))];
    d.objects = vec![sphere(v(0.0, 0.0, 0.0), 1.0, "blue"), quad(v(0.0, 0.0, -2.0), 3.0, v(90.0, 0.0, 0.0), "red")];
    d
}

#[test]
fn first_hits_of_a_ball_before_a_wall_are_what_geometry_says() {
    let d = ball_and_wall();
    let [normals, depth, uv, objects, materials] =
        [Probe::Normals, Probe::Depth, Probe::Uv, Probe::Object, Probe::Material].map(|kind| probe(&d, kind));
    for (i, j) in (0..40).flat_map(|j| (0..40).map(move |i| (i, j))) {
        let (x, y) = ((f64::from(i) + 0.5) / 10.0 - 2.0, 2.0 - (f64::from(j) + 0.5) / 10.0);
        let on_ball = 1.0 - x * x - y * y;
        let near = |film: &Film, expected: [f64; 3]| {
            let found = film.pixel(i, j).map(f64::from);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{i},{j}: {found:?} {expected:?}");
        };
        if on_ball > 0.0 {
            let z = on_ball.sqrt();
            near(&normals, [x, y, z]);
            near(&depth, [5.0 - z; 3]);
            near(&objects, [1.0; 3]);
            near(&materials, [2.0; 3]);
        } else if x.abs() < 1.5 && y.abs() < 1.5 {
            near(&normals, [0.0, 0.0, 1.0]);
            near(&depth, [7.0; 3]);
            near(&objects, [2.0; 3]);
            near(&materials, [1.0; 3]);
            // Across the wall from edge to edge.
            let [u, w, on] = uv.pixel(i, j);
            assert!((f64::from(u) - (x + 1.5) / 3.0).abs() < 1e-6 && (0.0..1.0).contains(&w) && on == 1.0);
        } else {
            for film in [&normals, &depth, &uv, &objects, &materials] {
                near(film, [0.0; 3]);
            }
        }
    }
    // Normals are shown by the usual colours: those of the wall are (128, 128, 255).
    let (picture, _) = View::Normals.paint(&normals);
    assert_eq!(picture.to_srgb8()[3 * (40 * 6 + 6)..][..3], [128, 128, 255]);
    // The nearest is dark violet, the farthest yellow.
    let (picture, scale) = View::Depth.paint(&depth);
    assert!(scale.low <= 4.01 && scale.high >= 7.0 && scale.high < 7.2, "{scale:?}");
    let [middle, wall] = [3 * (40 * 20 + 20), 3 * (40 * 6 + 6)].map(|at| picture.to_srgb8()[at + 1]);
    assert!(middle < 20 && wall > 200, "{middle} {wall}");
}

#[test]
fn rays_visits_and_times_are_those_of_one_sample() {
    let mut d = ball_and_wall();
    d.lights = vec![sun(v(0.0, 0.0, 1.0), Rgb::WHITE, 1.0)];
    d.materials[1] = MaterialDesc { reflect: 0.5, ..matte("blue", Rgb::WHITE) };
    d.materials[0] = matte("red", Rgb::WHITE);
    d.render.max_depth = 1;
    let (rays, visits, time) = (probe(&d, Probe::Rays), probe(&d, Probe::Visits), Probe::Time);
    // The background: the camera's ray alone. The wall: and a shadow ray. The ball: those, and a mirrored ray to
    // nowhere.
    assert_eq!([(0, 0), (6, 6), (20, 20)].map(|(x, y)| rays.pixel(x, y)[0]), [1.0, 2.0, 3.0]);
    // A node over both: rays that miss its box open it and no more.
    let seen = [(0, 0), (6, 6), (20, 20)].map(|(x, y)| visits.pixel(x, y)[0]);
    assert!(seen[0] >= 1.0 && seen[1] > seen[0] && seen[2] > seen[0], "{seen:?}");
    let told = explain(&compile(&d), &d, (20, 20), 1, None);
    assert_eq!(told.tree.all_visits() as f32, seen[2]);
    let times = finish(start_probe(compile(&d), time, settings(1, 8)), 40, 40);
    assert!(times.pixels().iter().all(|t| t[0] > 0.0 && t[0] < 1e6));
}

#[test]
fn samples_and_losses_are_told_by_the_render() {
    // As in `robustness`: the coursework's formula of refraction loses every sample on this sea.
    let mut d = desc(20, 20, perspective(v(0.0, 2.0, 0.0), v(0.0, 0.0, -6.0), v(0.0, 1.0, 0.0), 10.0));
    d.world.background = Background::Gradient { top: Rgb::WHITE, bottom: Rgb::BLACK };
    d.materials = vec![clear("thin", 0.75)];
    d.objects = vec![object(ShapeDesc::Plane, "thin")];
    d.render.numerics = Numerics::Classic;
    d.render.samples = 2;
    let scene = std::sync::Arc::new(compile_scene(&d, None).unwrap());
    let mut layers = Layers::new(20, 20);
    for event in start(scene.clone(), settings(1, 8)).events() {
        if let RenderEvent::TileFinished { tile, .. } = event {
            layers.write(tile);
        }
    }
    assert!(layers.values(View::Samples).unwrap().pixels().iter().all(|n| n[0] == 2.0));
    let lost = layers.values(View::NonFinite).unwrap();
    assert!(lost.pixels().iter().all(|n| n[0] == 2.0));
    assert!(layers.values(View::Error).unwrap().pixels().iter().all(|e| e[0] < 0.0), "two samples tell nothing");
    assert_eq!(layers.values(View::Depth), None);
    let told = explain(&scene, &d, (3, 4), 2, None);
    assert_eq!((told.non_finite, told.sample, told.color), (2, 0, [0.0; 3]));
    assert!(!told.tree.radiance.is_finite());
}
