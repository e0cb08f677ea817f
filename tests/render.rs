//! The picture is a function of the scene alone, and a render can be stopped, held and left at any time.

mod support;

use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::{Rgb, sample_in_pixel};
use glimt::render::{self, Film, Pass, Progress, Rect, RenderEvent};
use glimt::scene::Scene;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use support::*;

/// A model and a picture for the scene below; removed when dropped.
struct Files {
    model: PathBuf,
    picture: PathBuf,
}

impl Files {
    fn new(name: &str) -> Self {
        // A wavy sheet, closed by nothing: 2 * 12 * 12 triangles with texture coordinates.
        let (n, mut text) = (12, String::new());
        for i in 0..=n {
            for j in 0..=n {
                let (x, z) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                text += &format!("v {x} {} {z}\nvt {x} {z}\n", 0.1 * (9.0 * x).sin() * (7.0 * z).cos());
            }
        }
        for i in 0..n {
            for j in 0..n {
                let a = i * (n + 1) + j + 1;
                let (b, c, e) = (a + 1, a + n + 2, a + n + 1);
                text += &format!("f {a}/{a} {b}/{b} {c}/{c}\nf {a}/{a} {c}/{c} {e}/{e}\n");
            }
        }
        let picture = model_file(name, "").with_extension("png");
        let texels: Vec<u8> = (0..16 * 8 * 3).map(|i| (i * 37 % 256) as u8).collect();
        image::save_buffer(&picture, &texels, 16, 8, image::ExtendedColorType::Rgb8).expect("a picture can be written");
        Self { model: model_file(name, &text), picture }
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        std::fs::remove_file(&self.model).ok();
        std::fs::remove_file(&self.picture).ok();
    }
}

/// Something of everything: glass, mirrors, a mesh twice, pictures and patterns, all kinds of light.
fn everything(files: &Files, width: u32, height: u32) -> SceneDesc {
    let mut d = desc(width, height, perspective(v(1.0, 2.0, 5.0), v(0.0, 0.3, 0.0), DVec3::Y, 45.0));
    d.world.background = SKY;
    d.render.max_depth = 5;
    let picture = TextureDesc {
        source: TextureSource::Image { file: files.picture.clone(), wrap: Wrap::Repeat },
        scale: DVec2::new(2.0, 1.5),
        offset: DVec2::new(0.1, 0.0),
    };
    d.materials = vec![
        MaterialDesc {
            texture: checker(Rgb::WHITE, Rgb::new(0.2, 0.1, 0.3), 0.7),
            ambient: 0.1,
            ..matte("floor", Rgb::WHITE)
        },
        MaterialDesc { texture: Some(picture), ambient: 0.2, ..matte("picture", Rgb::WHITE) },
        mirror("mirror", Rgb::grey(0.05), 0.85),
        fresnel("fresnel", 1.5),
        MaterialDesc {
            specular: 0.6,
            diffuse: 0.1,
            reflect: 0.1,
            transmit: 0.8,
            ior: 1.3,
            ..bare("glass", Rgb::new(0.5, 0.1, 0.7))
        },
    ];
    d.objects = vec![
        at(v(0.0, -0.5, 0.0), object(ShapeDesc::Plane, "floor")),
        sphere(v(-1.2, 0.2, 0.3), 0.6, "mirror"),
        sphere(v(0.2, 0.3, 1.2), 0.5, "fresnel"),
        ObjectDesc { rotate: v(10.0, 40.0, 0.0), ..cuboid(v(1.4, 0.2, -0.3), v(0.9, 0.9, 0.9), "picture") },
        at(v(0.4, 0.2, -0.8), object(ShapeDesc::Cylinder { radius: 0.35, height: 1.3 }, "glass")),
        at(v(-0.5, 0.3, -1.2), object(ShapeDesc::Cone { radius: 0.6, height: 1.4 }, "picture")),
        ObjectDesc { scale: v(2.0, 1.0, 1.0), ..at(v(-1.0, 1.2, -1.0), mesh(&files.model, "picture")) },
        ObjectDesc { rotate: v(70.0, 20.0, 0.0), ..at(v(0.6, 0.6, 0.0), mesh(&files.model, "mirror")) },
    ];
    d.lights = vec![
        point_light(v(4.0, 6.0, 3.0), Rgb::WHITE, 0.7, Falloff::None),
        point_light(v(-3.0, 3.0, 2.0), Rgb::new(1.0, 0.8, 0.6), 5.0, Falloff::InverseSquare),
        sun(v(0.2, 1.0, 0.4), Rgb::grey(0.9), 0.3),
    ];
    d
}

fn film(scene: &Arc<Scene>, threads: usize, tile_size: u32) -> Film {
    finish(render::start(Arc::clone(scene), settings(threads, tile_size)), scene.width, scene.height)
}

#[test]
fn the_picture_has_the_same_bits_for_any_number_of_threads_and_any_size_of_tile() {
    let files = Files::new("render-bits");
    for samples in [1, 3, 16] {
        let mut d = everything(&files, 93, 67);
        d.render.samples = samples;
        let scene = compile(&d);
        let want = film(&scene, 1, 8).hash();
        for (threads, tile_size) in [(2, 8), (3, 16), (7, 32), (1, 64), (7, 8), (2, 64), (3, 32)] {
            assert_eq!(
                film(&scene, threads, tile_size).hash(),
                want,
                "{threads} threads, tiles of {tile_size}, {samples}"
            );
        }
        // Compiled again: the same too.
        assert_eq!(render(&d).hash(), want);
    }
}

/// Where meshes are met by rays that run alike together, what a ray finds must not depend on the others, in any
/// arithmetic.
#[test]
fn so_it_has_where_rays_meet_meshes_together() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/mesh.toml");
    let mut d = parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
    (d.film.width, d.film.height, d.render.samples) = (93, 67, 4);
    for numerics in [Numerics::Classic, Numerics::Fast, Numerics::Robust] {
        d.render.numerics = numerics;
        let scene = compile(&d);
        let want = film(&scene, 1, 8).hash();
        for (threads, tile_size) in [(3, 16), (2, 32), (1, 64)] {
            assert_eq!(film(&scene, threads, tile_size).hash(), want, "{numerics:?}, tiles of {tile_size}");
        }
    }
}

#[test]
fn pausing_and_resuming_does_not_change_a_bit() {
    let files = Files::new("render-pause");
    let mut d = everything(&files, 93, 67);
    d.render.samples = 8;
    let scene = compile(&d);
    let want = film(&scene, 2, 16).hash();
    let handle = render::start(Arc::clone(&scene), settings(3, 16));
    let mut picture = Film::new(scene.width, scene.height);
    for (i, event) in handle.events().iter().enumerate() {
        match event {
            RenderEvent::TileFinished { tile, .. } => picture.write(&tile),
            RenderEvent::Failed(error) => panic!("{error}"),
            RenderEvent::Finished => break,
            RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
        }
        if i % 40 == 7 {
            handle.pause();
            std::thread::sleep(Duration::from_millis(2));
            handle.resume();
        }
    }
    assert_eq!(picture.hash(), want);
}

#[test]
fn a_paused_render_stands_still_and_goes_on_when_resumed() {
    let files = Files::new("render-still");
    let mut d = everything(&files, 93, 67);
    // More events than fit into the channel: it cannot end while nobody takes them.
    d.render.samples = 1 << 16;
    let scene = compile(&d);
    let handle = render::start(Arc::clone(&scene), settings(2, 16));
    // Running first.
    handle.events().recv().expect("a render reports");
    handle.pause();
    // What is under way is finished; after that nothing more comes. Time is not judged: silence, once it is there,
    // lasts.
    let mut silence = 0;
    while silence < 5 {
        match handle.events().recv_timeout(Duration::from_millis(60)) {
            Ok(RenderEvent::Finished) => panic!("finished in spite of the pause"),
            Ok(_) => silence = 0,
            Err(_) => silence += 1,
        }
    }
    handle.resume();
    let tiles = handle.events().iter().filter(|e| matches!(e, RenderEvent::TileFinished { .. }));
    assert_eq!(tiles.take(40).count(), 40);
}

#[test]
fn dropping_the_handle_ends_the_workers_running_or_paused() {
    let files = Files::new("render-drop");
    let mut d = everything(&files, 256, 192);
    d.render.samples = 1 << 16;
    for pause in [false, true] {
        let scene = compile(&d);
        let handle = render::start(Arc::clone(&scene), settings(3, 16));
        handle.events().recv().expect("a render reports");
        if pause {
            handle.pause();
        }
        drop(handle);
        // The workers hold the scene: when they are gone nobody else does.
        let started = Instant::now();
        while Arc::strong_count(&scene) > 1 {
            assert!(started.elapsed() < Duration::from_secs(60), "workers still run");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn every_row_and_column_is_rendered_at_any_size() {
    // Pixel (x, y) of a W x H picture, told by a floor under lights that makes every place different. Row 0 is on top.
    for (w, h) in [(1, 1), (1, 7), (7, 1), (1, 65), (65, 1), (13, 7), (33, 65), (8, 8), (64, 33), (9, 16)] {
        for (threads, tile) in [(1, 8), (3, 32), (7, 8)] {
            let mut d = desc(w, h, perspective(v(0.3, 4.0, 3.0), DVec3::ZERO, DVec3::Y, 35.0));
            let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 1.0, 1.5);
            ruler.add_to(&mut d, 1e5);
            let film = render_with(&d, settings(threads, tile));
            assert_image("rows-and-columns", &film, EXACT, |x, y| {
                let (o, dir) = pixel_ray(&d, x, y);
                Some(if dir.y < 0.0 { ruler.seen_by(o, dir) } else { [0.0; 3] })
            });
        }
    }
}

#[test]
fn with_n_samples_a_pixel_is_the_mean_of_the_first_n_positions_of_its_sequence() {
    let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 1.0, 1.5);
    for samples in [1, 2, 3, 5, 8, 16, 37] {
        let mut d = desc(23, 17, perspective(v(0.3, 4.0, 3.0), DVec3::ZERO, DVec3::Y, 35.0));
        ruler.add_to(&mut d, 1e5);
        d.render.samples = samples;
        assert_image("mean-of-prefix", &render(&d), EXACT, |x, y| {
            let mut sum = [0.0; 3];
            for s in 0..samples {
                let (u, w) = sample_in_pixel(x, y, s);
                let (o, dir) = camera_ray(&d, f64::from(x) + u, f64::from(y) + w);
                sum = plus(sum, ruler.seen_by(o, dir));
            }
            Some(scale(sum, 1.0 / f64::from(samples)))
        });
    }
}

#[test]
fn the_first_lattice_pass_covers_the_whole_picture_and_no_pass_shows_what_was_not_traced() {
    let files = Files::new("render-lattice");
    let mut d = everything(&files, 93, 67);
    d.render.samples = 3;
    let scene = compile(&d);
    // What sample 0 gives in every pixel.
    let mut one = d.clone();
    one.render.samples = 1;
    let truth = render(&one);
    let handle = render::start(Arc::clone(&scene), settings(2, 16));
    let mut covered = vec![false; 93 * 67];
    let mut first = None;
    let mut film = Film::new(93, 67);
    for event in handle.events() {
        let RenderEvent::TileFinished { tile, pass, .. } = event else { continue };
        let Pass::Lattice { step } = pass else { continue };
        let coarsest = *first.get_or_insert(step);
        assert_eq!(tile.step, step);
        for (i, pixel) in tile.pixels.iter().enumerate() {
            let (x, y) = tile.place(i);
            assert_eq!(*pixel, truth.pixel(x, y), "({x}, {y}) at step {step}");
        }
        film.write(&tile);
        let Rect { x, y, width, height } = tile.rect;
        for (x, y) in (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))) {
            if step == coarsest {
                covered[(y * 93 + x) as usize] = true;
            }
            // The pixel itself on the lattice, else the lattice point up and left of it.
            assert_eq!(film.pixel(x, y), truth.pixel(x - x % step, y - y % step), "({x}, {y}) at step {step}");
        }
    }
    assert!(first.is_some_and(|step| step > 1) && covered.iter().all(|c| *c));
}

#[test]
fn events_come_in_order_and_their_counts_add_up() {
    let files = Files::new("render-events");
    for (threads, tile_size, samples) in [(1, 8, 1), (3, 16, 5), (7, 64, 3)] {
        let mut d = everything(&files, 61, 45);
        d.render.samples = samples;
        let scene = compile(&d);
        let mut progress = Progress::new(&scene, threads, Instant::now());
        let handle = render::start(Arc::clone(&scene), settings(threads, tile_size));
        let events: Vec<RenderEvent> = handle.events().iter().collect();
        // Finished comes once, at the end, and then the channel is closed.
        assert!(matches!(events.last(), Some(RenderEvent::Finished)));
        assert_eq!(events.iter().filter(|e| matches!(e, RenderEvent::Finished)).count(), 1);
        let (mut traced, mut camera) = (0, 0);
        let mut at_work = vec![None; threads];
        let mut percent = 0;
        let mut order: Vec<((u32, u32), Vec<Pass>)> = Vec::new();
        for event in &events {
            match event {
                RenderEvent::TileStarted { worker, rect, pass } => {
                    assert_eq!(at_work[*worker], None, "worker {worker} starts before it is done");
                    at_work[*worker] = Some((*rect, *pass));
                }
                RenderEvent::TileFinished { worker, tile, stats, pass } => {
                    assert_eq!(at_work[*worker].take(), Some((tile.rect, *pass)));
                    let points = tile.columns() * tile.rect.height.div_ceil(tile.step);
                    assert_eq!((tile.pixels.len() as u32, tile.samples.len() as u32), (points, points));
                    assert!(tile.rect.x + tile.rect.width <= 61 && tile.rect.y + tile.rect.height <= 45);
                    traced += stats.samples;
                    camera += stats.rays.camera;
                    let key = (tile.rect.x, tile.rect.y);
                    match order.iter_mut().find(|(k, _)| *k == key) {
                        Some((_, passes)) => passes.push(*pass),
                        None => order.push((key, vec![*pass])),
                    }
                }
                RenderEvent::Finished | RenderEvent::Estimated { .. } => {}
                RenderEvent::Failed(error) => panic!("{error}"),
            }
            progress.update(event, Instant::now());
            assert!(progress.percent() >= percent && (progress.percent() < 100 || progress.finished));
            percent = progress.percent();
        }
        assert_eq!(traced, 61 * 45 * u64::from(samples));
        assert_eq!(camera, traced);
        assert!(progress.finished && progress.percent() == 100);
        assert_eq!((progress.samples_done, progress.samples_total), (traced, Some(traced)));
        assert_eq!(progress.rays.camera, camera);
        for (key, passes) in order {
            // Lattice from coarse to fine, then refinements that join without gap up to the last sample.
            let rank = |p: &Pass| match *p {
                Pass::Lattice { step } => -i64::from(step),
                Pass::Refine { from, .. } => i64::from(from),
                Pass::Adapt { round } => i64::from(round),
            };
            assert!(passes.windows(2).all(|w| rank(&w[0]) < rank(&w[1])), "{key:?}: {passes:?}");
            let mut next = 1;
            for pass in &passes {
                if let Pass::Refine { from, to } = *pass {
                    assert!(from == next && to > from, "{key:?}: {passes:?}");
                    next = to;
                }
            }
            assert_eq!(next, samples, "{key:?}: {passes:?}");
        }
    }
}

#[test]
fn rays_are_counted_by_kind() {
    // A floor seen by every pixel, k_r = 0.5, under two lights, one of them below it; above it nothing. One camera ray,
    // one shadow ray to the light above, one reflection a pixel.
    let mut d = desc(16, 16, orthographic(v(0.0, 3.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 1.0));
    d.materials = vec![MaterialDesc { diffuse: 0.5, reflect: 0.5, ..bare("floor", Rgb::WHITE) }];
    d.objects = vec![object(ShapeDesc::Plane, "floor")];
    d.lights = vec![sun(v(0.1, 1.0, 0.0), Rgb::WHITE, 0.5), sun(v(0.1, -1.0, 0.0), Rgb::WHITE, 0.5)];
    let scene = compile(&d);
    let mut rays = render::RayCounts::default();
    for event in render::start(scene, settings(2, 8)).events() {
        if let RenderEvent::TileFinished { stats, .. } = event {
            rays += stats.rays;
        }
    }
    let want = render::RayCounts { camera: 256, shadow: 256, reflection: 256, refraction: 0 };
    assert_eq!(rays, want);
    assert_eq!(rays.total(), 768);
}

#[test]
fn compiling_again_after_a_change_of_the_camera_gives_the_picture_of_a_fresh_scene() {
    let files = Files::new("render-share");
    let d = everything(&files, 48, 36);
    let first = compile(&d);
    let mut moved = d.clone();
    moved.camera.position = v(-2.0, 1.5, 4.0);
    moved.objects[6].translate.y += 0.3;
    moved.materials[2].reflect = 0.5;
    let shared = glimt::scene::compile(&moved, Some(&first)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(film(&Arc::new(shared), 2, 16).hash(), render(&moved).hash());
}
