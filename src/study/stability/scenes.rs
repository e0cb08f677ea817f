//! Scenes of the experiments in few words, and their pictures in every preset.

use super::trials::Effort;
use crate::description::*;
use crate::math::Rgb;
use crate::scene::{self, Scene};
use crate::shading::{RayCounts, Sample, Scratch, sampler};
use glam::{DVec2, DVec3};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;

/// A background that tells a direction.
pub const SKY: Background = Background::Gradient { top: Rgb::new(1.0, 0.2, 0.0), bottom: Rgb::new(0.1, 0.9, 0.5) };

/// The arithmetic of each preset, in the order of `PRESETS`.
pub const NUMERICS: [Numerics; 4] = [Numerics::Classic, Numerics::Fast, Numerics::Robust, Numerics::Reference];

/// A vector, in few letters.
pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// An empty scene under a black sky, one sample a pixel.
pub fn empty(width: u32, height: u32, camera: CameraDesc) -> SceneDesc {
    let mut desc = SceneDesc { film: FilmDesc { width, height }, camera, ..SceneDesc::default() };
    desc.render.samples = 1;
    desc
}

pub fn perspective(position: DVec3, look_at: DVec3, fov: f64) -> CameraDesc {
    CameraDesc { position, look_at, up: DVec3::Y, projection: Projection::Perspective { fov } }
}

pub fn orthographic(position: DVec3, look_at: DVec3, view_height: f64) -> CameraDesc {
    CameraDesc { position, look_at, up: DVec3::Y, projection: Projection::Orthographic { view_height } }
}

/// Black until a coefficient is given.
pub fn bare(name: &str, color: Rgb) -> MaterialDesc {
    MaterialDesc { name: name.into(), color, ambient: 0.0, diffuse: 0.0, specular: 0.0, ..MaterialDesc::default() }
}

/// Diffuse only.
pub fn matte(name: &str) -> MaterialDesc {
    MaterialDesc { diffuse: 1.0, ..bare(name, Rgb::WHITE) }
}

/// Lets everything through, bent.
pub fn clear(name: &str, ior: f64) -> MaterialDesc {
    MaterialDesc { transmit: 1.0, ior, ..bare(name, Rgb::BLACK) }
}

pub fn checker(colors: [Rgb; 2], size: f64) -> Option<TextureDesc> {
    Some(TextureDesc { source: TextureSource::Checker { colors, size }, scale: DVec2::ONE, offset: DVec2::ZERO })
}

pub fn object(shape: ShapeDesc, material: &str) -> ObjectDesc {
    ObjectDesc { material: Some(material.into()), ..ObjectDesc::new(shape) }
}

pub fn at(translate: DVec3, object: ObjectDesc) -> ObjectDesc {
    ObjectDesc { translate, ..object }
}

pub fn sphere(centre: DVec3, radius: f64, material: &str) -> ObjectDesc {
    at(centre, object(ShapeDesc::Sphere { radius }, material))
}

pub fn cuboid(centre: DVec3, size: DVec3, material: &str) -> ObjectDesc {
    at(centre, object(ShapeDesc::Cuboid { size }, material))
}

pub fn mesh(file: &Path, crease: f64, material: &str) -> ObjectDesc {
    object(ShapeDesc::Mesh { file: file.into(), crease }, material)
}

pub fn point_light(position: DVec3, intensity: f64, falloff: Falloff) -> LightDesc {
    LightDesc { kind: LightKind::Point { position, falloff }, intensity, ..LightDesc::default() }
}

/// A light infinitely far in this direction.
pub fn sun(toward: DVec3, intensity: f64) -> LightDesc {
    LightDesc { kind: LightKind::Directional { direction: -toward }, intensity, ..LightDesc::default() }
}

/// Bodies of all shapes and kinds over a floor, two instances of a model among them; all lengths times `k`, and all
/// moved by `offset`.
pub fn mixed(k: f64, offset: DVec3, model: &Path) -> SceneDesc {
    let p = |x: f64, y: f64, z: f64| v(x, y, z) * k + offset;
    let mut desc = empty(96, 72, perspective(p(1.0, 2.0, 5.0), p(0.0, 0.25, 0.0), 45.0));
    desc.world.background = SKY;
    desc.render.max_depth = 6;
    desc.materials = vec![
        MaterialDesc { ambient: 0.1, specular: 0.3, shininess: 12.5, diffuse: 0.7, ..matte("plain") },
        MaterialDesc { texture: checker([Rgb::WHITE, Rgb::new(0.1, 0.2, 0.4)], 0.2), ambient: 0.1, ..matte("checker") },
        MaterialDesc { ambient: 0.1, reflect: 0.8, ..bare("mirror", Rgb::grey(0.4)) },
        MaterialDesc { fresnel: true, ..clear("fresnel", 1.5) },
        MaterialDesc { reflect: 0.1, transmit: 0.8, specular: 0.5, diffuse: 0.1, ior: 1.3, ..matte("glass") },
    ];
    desc.objects = vec![
        cuboid(p(0.0, -1.0, 0.0), v(20.0, 1.0, 20.0) * k, "checker"),
        sphere(p(-1.25, 0.25, 0.25), 0.625 * k, "mirror"),
        sphere(p(0.25, 0.25, 1.25), 0.5 * k, "fresnel"),
        ObjectDesc { rotate: v(10.0, 40.0, 0.0), ..cuboid(p(1.5, 0.25, -0.25), DVec3::splat(0.875 * k), "checker") },
        at(p(0.375, 0.25, -0.75), object(ShapeDesc::Cylinder { radius: 0.375 * k, height: 1.25 * k }, "glass")),
        at(p(-0.5, 0.25, -1.25), object(ShapeDesc::Cone { radius: 0.625 * k, height: 1.5 * k }, "plain")),
        ObjectDesc {
            rotate: v(30.0, 10.0, 5.0),
            ..at(p(0.0, 1.5, -0.5), object(ShapeDesc::Quad { size: DVec2::new(1.0, 0.5) * k }, "plain"))
        },
        ObjectDesc { scale: DVec3::splat(0.375 * k), ..at(p(0.875, 0.75, 1.0), mesh(model, 0.0, "glass")) },
        ObjectDesc { scale: v(0.375, 0.5, 0.25) * k, ..at(p(-0.25, 0.125, 1.875), mesh(model, 0.0, "plain")) },
    ];
    desc.lights = vec![point_light(p(4.0, 6.0, 3.0), 0.7, Falloff::None), sun(v(0.2, 1.0, 0.4), 0.3)];
    desc
}

/// Compiles a scene of an experiment; these are right.
pub fn compile(desc: &SceneDesc, previous: Option<&Scene>) -> Scene {
    scene::compile(desc, previous).unwrap_or_else(|error| panic!("a scene of the study does not compile: {error}"))
}

/// What is seen through the centre of every pixel, row by row.
pub fn picture(effort: &Effort, scene: &Scene) -> Vec<Sample> {
    let (width, height) = (scene.width, scene.height);
    let mut samples = vec![Sample::default(); (width * height) as usize];
    let rows = samples.chunks_mut(width as usize).zip(0..).collect::<Vec<_>>();
    let per_thread = rows.len().div_ceil(effort.threads.get()).max(1);
    let mut rows = rows.into_iter();
    thread::scope(|scope| {
        loop {
            let share: Vec<_> = rows.by_ref().take(per_thread).collect();
            if share.is_empty() {
                break;
            }
            scope.spawn(move || {
                for (row, y) in share {
                    let points: Vec<_> =
                        (0..width).map(|x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).collect();
                    let mut rays = RayCounts::default();
                    let stop = AtomicBool::new(false);
                    sampler(scene)(scene, &points, row, &mut rays, &mut Scratch::default(), &stop);
                }
            });
        }
    });
    samples
}

/// The picture of every preset.
pub fn pictures(effort: &Effort, desc: &SceneDesc) -> [Vec<Sample>; 4] {
    let mut scene = compile(desc, None);
    NUMERICS.map(|numerics| {
        scene.render.numerics = numerics;
        picture(effort, &scene)
    })
}

/// 8-bit codes of a sample.
pub fn codes(sample: &Sample) -> [u8; 3] {
    let Rgb { r, g, b } = sample.radiance;
    [r, g, b].map(crate::math::linear_to_srgb8)
}

/// Whether two samples differ by more than one code in a channel, or one of them is not finite.
pub fn apart(a: &Sample, b: &Sample) -> bool {
    let differ = codes(a).into_iter().zip(codes(b)).any(|(a, b)| a.abs_diff(b) > 1);
    differ || !a.radiance.is_finite() || !b.radiance.is_finite()
}

/// A model file that is there as long as this value.
pub struct ModelFile(PathBuf);

impl ModelFile {
    /// Writes these flat triangles; corners with the same bits are one vertex.
    pub fn new(triangles: &[[glam::Vec3; 3]]) -> Self {
        Self::write(triangles, false)
    }

    /// The same as a smooth ball about the origin: the normal of each vertex is its direction.
    pub fn smooth_ball(triangles: &[[glam::Vec3; 3]]) -> Self {
        Self::write(triangles, true)
    }

    fn write(triangles: &[[glam::Vec3; 3]], smooth: bool) -> Self {
        use std::fmt::Write;
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let (mut vertices, mut faces) = (String::new(), String::new());
        let mut known = std::collections::HashMap::new();
        for triangle in triangles {
            let corners = triangle.map(|p| {
                let next = known.len() + 1;
                *known.entry(p.to_array().map(f32::to_bits)).or_insert_with(|| {
                    let _ = writeln!(vertices, "v {} {} {}", p.x, p.y, p.z);
                    if smooth {
                        let _ = writeln!(vertices, "vn {} {} {}", p.x, p.y, p.z);
                    }
                    next
                })
            });
            let [a, b, c] = corners.map(|n| if smooth { format!("{n}//{n}") } else { n.to_string() });
            let _ = writeln!(faces, "f {a} {b} {c}");
        }
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("glimt-stability-{}-{number}.obj", std::process::id()));
        std::fs::write(&path, vertices + &faces)
            .unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
        Self(path)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ModelFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}
