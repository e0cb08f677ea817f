//! A sample is what it is alone, whatever is traced together with it, and tracing takes no memory.

mod support;

use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::{Rgb, sample_in_pixel};
use glimt::scene::Scene;
use glimt::shading::{RayCounts, Sample, Scratch, sampler};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use support::*;

/// Counts what this thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: everything is left to `System`; counting touches no memory of the allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

const WIDTH: u32 = 48;
const HEIGHT: u32 = 32;

/// One sample in every pixel, in blocks of 8 by 8.
fn points() -> Vec<DVec2> {
    let mut pixels: Vec<(u32, u32)> = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))).collect();
    pixels.sort_by_key(|(x, y)| (y / 8, x / 8, *y, *x));
    let place = |(x, y)| {
        let (u, w) = sample_in_pixel(x, y, 0);
        DVec2::new(f64::from(x) + u, f64::from(y) + w)
    };
    pixels.into_iter().map(place).collect()
}

/// Traces the points in slices of this size.
fn trace(scene: &Scene, points: &[DVec2], size: usize, scratch: &mut Scratch) -> (Vec<Sample>, RayCounts) {
    let mut samples = vec![Sample::default(); points.len()];
    let mut counts = RayCounts::default();
    let sampler = sampler(scene);
    for (points, samples) in points.chunks(size).zip(samples.chunks_mut(size)) {
        sampler(scene, points, samples, &mut counts, scratch, &AtomicBool::new(false));
    }
    (samples, counts)
}

/// Bit for bit, NaN included.
fn assert_same(name: &str, a: &[Sample], b: &[Sample]) {
    let bits = |s: &Sample| {
        let (Rgb { r, g, b }, Rgb { r: x, g: y, b: z }) = (s.radiance, s.tail);
        let normal = s.normal.to_array().map(f32::to_bits);
        ([r, g, b, s.cut, x, y, z].map(f64::to_bits), s.surface, normal, s.tree, s.cost, s.overfull)
    };
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(bits(a), bits(b), "{name}: sample {k} is {a:?} alone and {b:?} in company");
    }
}

fn assert_alone_as_in_company(name: &str, desc: &SceneDesc) {
    for numerics in [Numerics::Classic, Numerics::Fast, Numerics::Robust, Numerics::Reference] {
        for shading in [Shading::Lambert, Shading::Phong, Shading::Whitted] {
            for shadows in [Shadows::Opaque, Shadows::Filtered] {
                let mut desc = desc.clone();
                desc.film = FilmDesc { width: WIDTH, height: HEIGHT };
                desc.render = RenderDesc { numerics, shading, shadows, ..desc.render };
                let scene = compile(&desc);
                let (points, mut scratch) = (points(), Scratch::default());
                let name = format!("{name}, {numerics:?}, {shading:?}, {shadows:?}");
                let (alone, counts) = trace(&scene, &points, 1, &mut Scratch::default());
                for size in [256, 3, 40] {
                    let (together, counts_together) = trace(&scene, &points, size, &mut scratch);
                    assert_same(&name, &alone, &together);
                    assert_eq!(counts, counts_together, "{name}");
                }
            }
        }
    }
}

/// Glass in glass, glass on glass, glass on a floor, a ball half in a block, a camera inside of a body, mirrors face to
/// face.
fn bodies() -> SceneDesc {
    let mut d = desc(WIDTH, HEIGHT, perspective(v(0.4, 1.4, 4.6), v(0.0, 0.4, 0.0), DVec3::Y, 42.0));
    d.world.background = SKY;
    d.render.max_depth = 9;
    d.materials = vec![
        MaterialDesc { ambient: 0.1, reflect: 0.2, ..matte("floor", Rgb::new(0.7, 0.6, 0.5)) },
        MaterialDesc {
            transmit: 0.7,
            ior: 1.5,
            diffuse: 0.2,
            specular: 0.4,
            reflect: 0.2,
            ..bare("glass", Rgb::WHITE)
        },
        MaterialDesc { transmit: 0.9, ior: 1.3, priority: 1, ..fresnel("water", 1.3) },
        // Gives back more than it gets.
        mirror("mirror", Rgb::grey(0.1), 1.0),
    ];
    d.objects = vec![
        object(ShapeDesc::Plane, "floor"),
        // Two blocks with a common face on the floor, and a ball of another medium across it.
        cuboid(v(-0.5, 0.5, 0.0), v(1.0, 1.0, 1.0), "glass"),
        cuboid(v(0.5, 0.5, 0.0), v(1.0, 1.0, 1.0), "water"),
        sphere(v(0.0, 0.5, 0.1), 0.35, "glass"),
        sphere(v(1.4, 0.4, 0.9), 0.4, "water"),
        sphere(v(1.4, 0.4, 0.9), 0.2, "mirror"),
        sphere(v(-1.5, 0.5, 0.5), 0.5, "mirror"),
        sphere(v(-1.4, 0.3, 1.6), 0.3, "mirror"),
        // Around the camera.
        sphere(v(0.4, 1.4, 4.6), 0.5, "water"),
        ObjectDesc {
            rotate: v(90.0, 20.0, 0.0),
            ..at(v(0.3, 0.8, 1.5), object(ShapeDesc::Quad { size: DVec2::ONE }, "glass"))
        },
    ];
    d.lights = vec![
        point_light(v(3.0, 5.0, 3.0), Rgb::WHITE, 0.6, Falloff::None),
        // In a body.
        point_light(v(-0.6, 0.6, 0.1), Rgb::new(1.0, 0.5, 0.2), 0.5, Falloff::InverseSquare),
        sun(v(-0.3, 1.0, 0.5), Rgb::grey(0.8), 0.4),
    ];
    d
}

/// Bodies of glass of all shapes, of two k_t, most with room between them, some that touch or overlap, some with opaque
/// things in between, and a light inside of one.
fn field() -> SceneDesc {
    let mut d = desc(WIDTH, HEIGHT, perspective(v(1.0, 5.0, 12.0), v(0.0, 0.5, 0.0), DVec3::Y, 45.0));
    d.world.background = SKY;
    d.render.max_depth = 5;
    let glass = |name: &str, transmit: f64| MaterialDesc {
        transmit,
        ior: 1.5,
        diffuse: 0.2,
        specular: 0.4,
        reflect: 1.0 - transmit,
        ..bare(name, Rgb::WHITE)
    };
    d.materials = vec![matte("floor", Rgb::new(0.7, 0.6, 0.5)), glass("clear", 0.9), glass("dim", 0.6)];
    d.objects.push(object(ShapeDesc::Plane, "floor"));
    for k in 0..49u32 {
        let shape = match k % 8 {
            0 | 5 | 7 => ShapeDesc::Sphere { radius: 0.5 },
            1 | 6 => ShapeDesc::Cuboid { size: v(1.0, 0.6, 0.8) },
            2 => ShapeDesc::Cylinder { radius: 0.4, height: 0.8 },
            3 => ShapeDesc::Cone { radius: 0.4, height: 0.8 },
            _ => ShapeDesc::Quad { size: DVec2::ONE },
        };
        let material = if k % 11 == 10 {
            "floor"
        } else if k > 40 {
            "dim"
        } else {
            "clear"
        };
        let mut body = object(shape, material);
        let gap = if k % 5 == 4 { 0.0 } else { 0.2 };
        body.translate = v(f64::from(k % 7) * 1.2 - 3.6, 0.5 + gap, f64::from(k / 7) * 1.2 - 3.6);
        body.rotate = v(0.0, 17.0 * f64::from(k), if k % 3 == 0 { 30.0 } else { 0.0 });
        if k % 9 == 8 {
            body.scale.y = 0.7;
        }
        d.objects.push(body);
    }
    // Across two of them.
    d.objects.push(sphere(v(0.6, 0.7, 0.6), 0.3, "dim"));
    let inside = d.objects[25].translate;
    d.lights = vec![
        point_light(v(3.0, 8.0, 3.0), Rgb::WHITE, 0.6, Falloff::None),
        point_light(inside, Rgb::new(1.0, 0.5, 0.2), 0.5, Falloff::InverseSquare),
        sun(v(-1.0, 0.4, 0.5), Rgb::grey(0.8), 0.4),
    ];
    d
}

#[test]
fn a_sample_is_the_same_alone_and_in_company_among_many_bodies_of_glass() {
    assert_alone_as_in_company("field", &field());
    // With light to be spared and paths to be cut.
    let mut to_an_error = field();
    to_an_error.render.error = Some(2.0);
    assert_alone_as_in_company("field to an error", &to_an_error);
}

#[test]
fn a_sample_is_the_same_alone_and_in_company_where_media_touch_and_overlap() {
    assert_alone_as_in_company("bodies", &bodies());
}

#[test]
fn a_sample_is_the_same_alone_and_in_company_in_every_scene_that_ships() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in ["demo", "refraction", "mesh", "whitted", "sphereflake"] {
        let path: PathBuf = scenes.join(format!("{name}.toml"));
        let text = std::fs::read_to_string(&path).expect("a scene can be read");
        assert_alone_as_in_company(name, &parse(&text, &path).expect("a scene that ships is right"));
    }
}

#[test]
fn code_for_scenes_with_less_gives_what_code_for_all_scenes_gives() {
    // A glass ball behind the camera, and an opaque mirror there, change nothing but the code that is picked.
    let mut plain = bodies();
    plain.objects.truncate(1);
    plain.objects.push(sphere(v(0.0, 0.5, 0.0), 0.5, "matte"));
    plain.materials.push(matte("matte", Rgb::new(0.2, 0.5, 0.3)));
    for reflect in [0.0, 0.3] {
        plain.materials[0].reflect = reflect;
        plain.materials.retain(|m| ["floor", "matte"].contains(&m.name.as_str()));
        let mut all = plain.clone();
        all.materials.push(fresnel("glass", 1.5));
        let (a, b): (Arc<Scene>, Arc<Scene>) = (compile(&plain), compile(&all));
        let points = points();
        let mut scratch = Scratch::default();
        // The room is that of the other scene, each time.
        trace(&b, &points, 256, &mut scratch);
        let ((few, few_rays), (many, many_rays)) =
            (trace(&a, &points, 256, &mut scratch), trace(&b, &points, 256, &mut scratch));
        assert_same("features", &few, &many);
        assert_eq!(few_rays, many_rays);
    }
}

#[test]
fn tracing_takes_no_memory_once_the_room_has_grown() {
    let scene = compile(&bodies());
    let points = points();
    let mut scratch = Scratch::default();
    let mut samples = vec![Sample::default(); 256];
    let sampler = sampler(&scene);
    let mut pass = || {
        let mut counts = RayCounts::default();
        for points in points.chunks(256) {
            let samples = &mut samples[..points.len()];
            sampler(&scene, points, samples, &mut counts, &mut scratch, &AtomicBool::new(false));
        }
        counts.total()
    };
    let rays = pass();
    let before = ALLOCATIONS.with(Cell::get);
    assert_eq!(pass(), rays);
    let taken = ALLOCATIONS.with(Cell::get) - before;
    assert!(before > 0 && rays > 10_000);
    assert_eq!(taken, 0, "allocations for {rays} rays");
}
