//! What the picture tests share: scenes in few words, the camera by its definition, and comparing of films.
//!
//! Nothing here calls the code under test except to render: cameras, falloff and colours are written out again from
//! their definitions.

#![allow(dead_code)] // Every test binary uses its own part of this.

pub mod twin;

use glam::{DVec2, DVec3};
use glimt::description::*;
use glimt::math::Rgb;
use glimt::render::{self, Film, Rect, RenderEvent, Settings, TileImage};
use glimt::scene::{self, Scene};
use glimt::shading::{RayCounts, Sample, Scratch, sampler};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A vector, in few letters.
pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// An empty scene: black all around, white ambient light, Whitted, one sample a pixel.
pub fn desc(width: u32, height: u32, camera: CameraDesc) -> SceneDesc {
    let mut desc = SceneDesc { film: FilmDesc { width, height }, camera, ..SceneDesc::default() };
    desc.world = WorldDesc { ambient: Rgb::WHITE, background: Background::Solid(Rgb::BLACK), ior: 1.0 };
    desc.render = RenderDesc {
        shading: Shading::Whitted,
        max_depth: 8,
        samples: 1,
        error: None,
        filter: Filter::Box,
        shadows: Shadows::Opaque,
        numerics: Numerics::Robust,
    };
    desc
}

pub fn orthographic(position: DVec3, look_at: DVec3, up: DVec3, view_height: f64) -> CameraDesc {
    CameraDesc { position, look_at, up, projection: Projection::Orthographic { view_height } }
}

pub fn perspective(position: DVec3, look_at: DVec3, up: DVec3, fov: f64) -> CameraDesc {
    CameraDesc { position, look_at, up, projection: Projection::Perspective { fov } }
}

/// A material of which nothing is set but its name and colour: it is black until a coefficient is given.
pub fn bare(name: &str, color: Rgb) -> MaterialDesc {
    MaterialDesc {
        name: name.into(),
        color,
        texture: None,
        ambient: 0.0,
        diffuse: 0.0,
        specular: 0.0,
        shininess: 32.0,
        reflect: 0.0,
        transmit: 0.0,
        ior: 1.5,
        fresnel: false,
        priority: 0,
    }
}

/// Shows its colour, whatever the light.
pub fn flat(name: &str, color: Rgb) -> MaterialDesc {
    MaterialDesc { ambient: 1.0, ..bare(name, color) }
}

/// Diffuse only, k_d = 1.
pub fn matte(name: &str, color: Rgb) -> MaterialDesc {
    MaterialDesc { diffuse: 1.0, ..bare(name, color) }
}

/// Transmits all and reflects nothing (but turns total internal reflection into reflection).
pub fn clear(name: &str, ior: f64) -> MaterialDesc {
    MaterialDesc { transmit: 1.0, ior, ..bare(name, Rgb::BLACK) }
}

/// Splits all light between reflection and refraction by Fresnel's equations.
pub fn fresnel(name: &str, ior: f64) -> MaterialDesc {
    MaterialDesc { fresnel: true, ..clear(name, ior) }
}

/// Reflects the part `k` and shows `base`.
pub fn mirror(name: &str, base: Rgb, k: f64) -> MaterialDesc {
    MaterialDesc { reflect: k, ..flat(name, base) }
}

pub fn object(shape: ShapeDesc, material: &str) -> ObjectDesc {
    ObjectDesc { material: Some(material.into()), ..ObjectDesc::new(shape) }
}

pub fn at(translate: DVec3, object: ObjectDesc) -> ObjectDesc {
    ObjectDesc { translate, ..object }
}

pub fn sphere(center: DVec3, radius: f64, material: &str) -> ObjectDesc {
    at(center, object(ShapeDesc::Sphere { radius }, material))
}

pub fn cuboid(center: DVec3, size: DVec3, material: &str) -> ObjectDesc {
    at(center, object(ShapeDesc::Cuboid { size }, material))
}

/// A square of this side that looks along `normal_up` (+y by default, turned by `rotate` degrees).
pub fn quad(center: DVec3, side: f64, rotate: DVec3, material: &str) -> ObjectDesc {
    let quad = object(ShapeDesc::Quad { size: DVec2::splat(side) }, material);
    ObjectDesc { translate: center, rotate, ..quad }
}

pub fn checker(a: Rgb, b: Rgb, size: f64) -> Option<TextureDesc> {
    Some(TextureDesc {
        source: TextureSource::Checker { colors: [a, b], size },
        scale: DVec2::ONE,
        offset: DVec2::ZERO,
    })
}

pub fn point_light(position: DVec3, color: Rgb, intensity: f64, falloff: Falloff) -> LightDesc {
    LightDesc { name: String::new(), kind: LightKind::Point { position, falloff }, color, intensity, visible: true }
}

/// A light far away in direction `toward`.
pub fn sun(toward: DVec3, color: Rgb, intensity: f64) -> LightDesc {
    LightDesc {
        name: String::new(),
        kind: LightKind::Directional { direction: -toward },
        color,
        intensity,
        visible: true,
    }
}

/// Writes a model into the tests' directory and gives its path. `name` must be unique among all tests.
pub fn model_file(name: &str, obj: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.obj", std::process::id()));
    std::fs::write(&path, obj).expect("the tests' directory can be written");
    path
}

pub fn mesh(file: &Path, material: &str) -> ObjectDesc {
    object(ShapeDesc::Mesh { file: file.into(), crease: 0.0 }, material)
}

/// All files below a folder with this ending, in order.
pub fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
}

/// Compiles; the scenes of the tests are right.
pub fn compile(desc: &SceneDesc) -> Arc<Scene> {
    Arc::new(scene::compile(desc, None).unwrap_or_else(|e| panic!("{e}")))
}

pub fn settings(threads: usize, tile_size: u32) -> Settings {
    Settings { threads: NonZeroUsize::new(threads).expect("at least one thread"), tile_size }
}

/// The finished picture.
pub fn render(desc: &SceneDesc) -> Film {
    render_with(desc, settings(2, 32))
}

pub fn render_with(desc: &SceneDesc, settings: Settings) -> Film {
    finish(render::start(compile(desc), settings), desc.film.width, desc.film.height)
}

/// The finished picture of a scene file's text.
pub fn render_text(toml: &str) -> Film {
    let desc = parse(toml, Path::new("test.toml")).unwrap_or_else(|errors| panic!("{errors:#?}"));
    render(&desc)
}

/// Gathers the events of a render into a film.
pub fn finish(handle: render::RenderHandle, width: u32, height: u32) -> Film {
    let mut film = Film::new(width, height);
    for event in handle.events() {
        match event {
            RenderEvent::TileFinished { tile, stats, .. } => {
                assert_eq!(stats.non_finite, 0, "samples that are not finite in {:?}", tile.rect);
                film.write(&tile);
            }
            RenderEvent::Failed(error) => panic!("{error}"),
            RenderEvent::Finished => return film,
            RenderEvent::TileStarted { .. } | RenderEvent::Estimated { .. } => {}
        }
    }
    panic!("the events ended without Finished");
}

/// Origin and unit direction of the ray through (x, y), pixel units, (0, 0) the upper left corner of the picture:
/// the definition of both projections.
pub fn camera_ray(desc: &SceneDesc, x: f64, y: f64) -> (DVec3, DVec3) {
    let (w, h) = (f64::from(desc.film.width), f64::from(desc.film.height));
    let camera = &desc.camera;
    let forward = (camera.look_at - camera.position).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    // Heights from the middle of the picture, upward, in units of half its height.
    let (sx, sy) = ((2.0 * x - w) / h, (h - 2.0 * y) / h);
    match camera.projection {
        Projection::Perspective { fov } => {
            let t = (fov.to_radians() / 2.0).tan();
            (camera.position, (forward + right * (sx * t) + up * (sy * t)).normalize())
        }
        Projection::Orthographic { view_height } => {
            let t = view_height / 2.0;
            (camera.position + right * (sx * t) + up * (sy * t), forward)
        }
    }
}

/// `camera_ray` through the centre of a pixel.
pub fn pixel_ray(desc: &SceneDesc, x: u32, y: u32) -> (DVec3, DVec3) {
    camera_ray(desc, f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// Where a ray meets the plane through `point` with this normal.
pub fn meet_plane(origin: DVec3, direction: DVec3, point: DVec3, normal: DVec3) -> DVec3 {
    origin + direction * ((point - origin).dot(normal) / direction.dot(normal))
}

/// A floor that can be read like a ruler: matte white under a red, a green and a blue point light with inverse-square
/// falloff, so that the colour tells the place on it, continuously. It must be farther from everything else than the
/// lights, which stand close to it: then nothing throws a shadow on it.
pub struct Ruler {
    /// A point of the floor.
    pub point: DVec3,
    /// Toward the lights.
    pub normal: DVec3,
    /// Positions of the red, green and blue light.
    pub lights: [DVec3; 3],
    /// Intensity of each light.
    pub intensity: f64,
}

impl Ruler {
    /// Lights at `height` over the floor, around `point` at distance `spread`.
    pub fn new(point: DVec3, normal: DVec3, height: f64, spread: f64) -> Self {
        let (a, b) = normal.any_orthonormal_pair();
        let center = point + normal * height;
        let lights = [center + a * spread, center - a * (0.5 * spread) + b * spread, center - b * spread];
        Self { point, normal, lights, intensity: height * height }
    }

    /// Adds floor (a quad of this side), its material and the lights to a scene. Only +y and +z are asked for.
    pub fn add_to(&self, desc: &mut SceneDesc, side: f64) {
        let rotate = if self.normal == DVec3::Y { DVec3::ZERO } else { v(90.0, 0.0, 0.0) };
        assert!(self.normal == DVec3::Y || self.normal == DVec3::Z);
        desc.materials.push(matte("ruler", Rgb::WHITE));
        desc.objects.push(quad(self.point, side, rotate, "ruler"));
        let colors = [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.0), Rgb::new(0.0, 0.0, 1.0)];
        for (position, color) in self.lights.into_iter().zip(colors) {
            desc.lights.push(point_light(position, color, self.intensity, Falloff::InverseSquare));
        }
    }

    /// Colour of the floor at `p`: I cos(theta) / d² = I h / d³ for each light.
    pub fn color_at(&self, p: DVec3) -> [f64; 3] {
        self.lights.map(|light| {
            let to = light - p;
            self.intensity * to.dot(self.normal) / to.length().powi(3)
        })
    }

    /// Colour where a ray meets the floor.
    pub fn seen_by(&self, origin: DVec3, direction: DVec3) -> [f64; 3] {
        self.color_at(meet_plane(origin, direction, self.point, self.normal))
    }
}

/// A background that tells a direction: its gradient is linear in the y of the unit direction.
pub const SKY: Background = Background::Gradient { top: Rgb::new(1.0, 0.2, 0.0), bottom: Rgb::new(0.1, 0.9, 0.5) };

/// What `SKY` shows in a unit direction of this y.
pub fn sky(y: f64) -> [f64; 3] {
    let t = (1.0 + y) / 2.0;
    [0.1 + (1.0 - 0.1) * t, 0.9 + (0.2 - 0.9) * t, 0.5 + (0.0 - 0.5) * t]
}

/// Unpolarised reflectance of a dielectric by Fresnel's equations in their angle form (sine and tangent laws), which
/// shares no arithmetic with the usual code. `n`: index behind over index before. 1 at total internal reflection.
pub fn fresnel_reflectance(cos_i: f64, n: f64) -> f64 {
    let i = cos_i.clamp(-1.0, 1.0).acos();
    let sin_t = i.sin() / n;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let t = sin_t.asin();
    if i < 1e-7 {
        return ((n - 1.0) / (n + 1.0)).powi(2);
    }
    let s = ((i - t).sin() / (i + t).sin()).powi(2);
    let p = ((i - t).tan() / (i + t).tan()).powi(2);
    (s + p) / 2.0
}

pub fn scale(color: [f64; 3], k: f64) -> [f64; 3] {
    color.map(|c| c * k)
}

pub fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// How far a film may be from what is expected: |got - want| <= relative |want| + absolute, in linear light.
#[derive(Clone, Copy)]
pub struct Tolerance {
    pub relative: f64,
    pub absolute: f64,
    /// How many pixels may be off by more.
    pub pixels: usize,
}

/// What f32 in the film takes away: half a unit in the last place is 6e-8.
pub const EXACT: Tolerance = Tolerance { relative: 1e-6, absolute: 1e-9, pixels: 0 };

/// Compares every pixel with a closed form. Where that gives `None` the pixel is not judged; the number of those is
/// returned, for the test to say that they are few.
pub fn assert_image(
    name: &str,
    film: &Film,
    tolerance: Tolerance,
    mut expected: impl FnMut(u32, u32) -> Option<[f64; 3]>,
) -> usize {
    let (w, h) = (film.width(), film.height());
    let (mut excluded, mut wrong, mut worst) = (0, 0, (0.0, 0, 0));
    let mut reference = Vec::with_capacity((w * h) as usize);
    let mut difference = Vec::with_capacity((w * h) as usize);
    for y in 0..h {
        for x in 0..w {
            let got = film.pixel(x, y).map(f64::from);
            let Some(want) = expected(x, y) else {
                excluded += 1;
                reference.push(got.map(|c| c as f32));
                difference.push([0.0; 3]);
                continue;
            };
            // Above 1: too far.
            let error = (0..3)
                .map(|c| (got[c] - want[c]).abs() / (tolerance.relative * want[c].abs() + tolerance.absolute))
                .fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
            if error > 1.0 || error.is_nan() {
                wrong += 1;
            }
            if error > worst.0 || error.is_nan() {
                worst = (error, x, y);
            }
            reference.push(want.map(|c| c as f32));
            difference.push([0, 1, 2].map(|c| (got[c] - want[c]).abs() as f32));
        }
    }
    if wrong > tolerance.pixels {
        let (_, x, y) = worst;
        let want = reference[(y * w + x) as usize];
        let directory = save_comparison(name, film, reference, difference);
        panic!(
            "{name}: {wrong} of {} pixels are wrong ({} allowed); worst is ({x}, {y}): {:?}, expected {want:?}; \
             image, reference and difference are in {}",
            w * h,
            tolerance.pixels,
            film.pixel(x, y),
            directory.display()
        );
    }
    excluded
}

/// `assert_image` on the film, which is f32, and then on the radiance at every pixel's centre in f64, which is asked to
/// be within `limit` (relative above 1, absolute below).
pub fn assert_exact(
    name: &str,
    desc: &SceneDesc,
    limit: f64,
    mut expected: impl FnMut(u32, u32) -> Option<[f64; 3]>,
) -> usize {
    let tolerance = Tolerance { relative: EXACT.relative, absolute: EXACT.absolute.max(limit), pixels: 0 };
    let excluded = assert_image(name, &render(desc), tolerance, &mut expected);
    let scene = compile(desc);
    let (sampler, mut scratch) = (sampler(&scene), Scratch::default());
    for y in 0..desc.film.height {
        for x in 0..desc.film.width {
            let Some(want) = expected(x, y) else { continue };
            let centre = [DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)];
            let mut sample = [Sample::default()];
            sampler(&scene, &centre, &mut sample, &mut RayCounts::default(), &mut scratch, &AtomicBool::new(false));
            let got = sample[0].radiance;
            for (got, want) in [got.r, got.g, got.b].into_iter().zip(want) {
                let error = (got - want).abs() / want.abs().max(1.0);
                assert!(error <= limit, "{name}: ({x}, {y}) is {got} in f64, expected {want}: off by {error:e}");
            }
        }
    }
    excluded
}

/// Compares two films pixel by pixel.
pub fn assert_same(name: &str, film: &Film, reference: &Film, tolerance: Tolerance) {
    assert_eq!((film.width(), film.height()), (reference.width(), reference.height()), "{name}: sizes");
    assert_image(name, film, tolerance, |x, y| Some(reference.pixel(x, y).map(f64::from)));
}

/// The number of pixels that differ by more than `codes` of 255 in any channel.
pub fn pixels_apart(a: &Film, b: &Film, codes: u8) -> usize {
    assert_eq!((a.width(), a.height()), (b.width(), b.height()));
    let (a, b) = (a.to_srgb8(), b.to_srgb8());
    a.chunks_exact(3).zip(b.chunks_exact(3)).filter(|(p, q)| (0..3).any(|c| p[c].abs_diff(q[c]) > codes)).count()
}

/// Fails if more than `allowed` pixels of two films differ by more than one code of 255.
pub fn assert_within_one_code(name: &str, film: &Film, reference: &Film, allowed: usize) {
    let apart = pixels_apart(film, reference, 1);
    if apart > allowed {
        let difference = film
            .pixels()
            .iter()
            .zip(reference.pixels())
            .map(|(p, q)| std::array::from_fn(|c| (p[c] - q[c]).abs()))
            .collect();
        let directory = save_comparison(name, film, reference.pixels().to_vec(), difference);
        panic!(
            "{name}: {apart} of {} pixels differ by more than one code ({allowed} allowed); image, reference and \
             difference are in {}",
            film.pixels().len(),
            directory.display()
        );
    }
}

fn save_comparison(name: &str, film: &Film, reference: Vec<[f32; 3]>, difference: Vec<[f32; 3]>) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("test-images");
    std::fs::create_dir_all(&directory).expect("target can be written");
    let (w, h) = (film.width(), film.height());
    let largest = difference.iter().flatten().fold(0.0, |a: f32, &b| a.max(b));
    let stretched = difference.iter().map(|p| p.map(|c| c / largest.max(f32::MIN_POSITIVE))).collect();
    for (what, pixels) in [("image", film.pixels().to_vec()), ("reference", reference), ("difference", stretched)] {
        let path = directory.join(format!("{name}-{what}.png"));
        let codes = film_of(w, h, pixels).to_srgb8();
        image::save_buffer(&path, &codes, w, h, image::ExtendedColorType::Rgb8).expect("a picture can be written");
    }
    directory
}

/// A film of these pixels.
pub fn film_of(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Film {
    let mut film = Film::new(width, height);
    film.write(&TileImage { rect: Rect { x: 0, y: 0, width, height }, pixels, ..TileImage::default() });
    film
}

/// Sum of the first channel over all pixels.
pub fn sum(film: &Film) -> f64 {
    film.pixels().iter().map(|p| f64::from(p[0])).sum()
}
