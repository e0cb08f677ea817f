//! A second tracer, as naive as can be: every shape is asked one by one, in f64, by textbook formulas; which medium a
//! ray is in is found by asking every body whether it contains the point. It shares nothing with the renderer but the
//! description, and stands for what the description means.

use super::{camera_ray, plus, scale};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use glimt::description::*;
use glimt::math::Rgb;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

/// Paths of less weight are not followed; without this, many of them together would be seen in the sixth digit.
pub const NEGLIGIBLE: f64 = 1.0 / 1_048_576.0;

/// Where a ray meets a body.
#[derive(Clone, Copy, Debug)]
pub struct TwinHit {
    pub t: f64,
    pub body: usize,
    /// Unit, outward, world space.
    pub normal: DVec3,
    pub uv: DVec2,
}

enum Form {
    Shape(ShapeDesc),
    /// Corners of triangles, object space.
    Triangles(Vec<[DVec3; 3]>),
}

struct Body {
    form: Form,
    material: MaterialDesc,
    world: DAffine3,
    object: DAffine3,
    /// Volume, for who wins of two bodies that overlap.
    volume: f64,
}

pub struct Twin {
    desc: SceneDesc,
    bodies: Vec<Body>,
}

fn rgb(c: Rgb) -> [f64; 3] {
    [c.r, c.g, c.b]
}

/// Real roots of a t² + b t + c, a != 0, by the textbook.
fn quadratic(a: f64, b: f64, c: f64) -> Vec<f64> {
    let disc = b * b - 4.0 * a * c;
    if disc < 0.0 {
        return Vec::new();
    }
    let root = disc.sqrt();
    vec![(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
}

fn around(p: DVec3) -> f64 {
    0.5 + p.x.atan2(p.z) / TAU
}

fn moller_trumbore(o: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (e1, e2) = (b - a, c - a);
    let p = d.cross(e2);
    let det = e1.dot(p);
    let s = o - a;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let w = d.dot(q) / det;
    (det != 0.0 && u >= 0.0 && w >= 0.0 && u + w <= 1.0).then(|| e2.dot(q) / det)
}

/// All crossings of a ray with a form in object space: (t, outward normal, uv).
fn crossings(form: &Form, o: DVec3, d: DVec3) -> Vec<(f64, DVec3, DVec2)> {
    let mut found = Vec::new();
    let shape = match form {
        Form::Shape(shape) => shape,
        Form::Triangles(triangles) => {
            for &t in triangles {
                if let Some(hit) = moller_trumbore(o, d, t) {
                    found.push((hit, (t[1] - t[0]).cross(t[2] - t[0]), DVec2::ZERO));
                }
            }
            return found;
        }
    };
    match *shape {
        ShapeDesc::Sphere { radius } => {
            for t in quadratic(d.length_squared(), 2.0 * o.dot(d), o.length_squared() - radius * radius) {
                let n = (o + d * t) / radius;
                found.push((t, n, DVec2::new(around(n), 0.5 + n.y.clamp(-1.0, 1.0).asin() / PI)));
            }
        }
        ShapeDesc::Cuboid { size } => {
            let half = size / 2.0;
            for axis in 0..3 {
                for side in [-1.0, 1.0] {
                    let t = (side * half[axis] - o[axis]) / d[axis];
                    let p = o + d * t;
                    let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
                    if t.is_finite() && p[j].abs() <= half[j] && p[k].abs() <= half[k] {
                        let mut n = DVec3::ZERO;
                        n[axis] = side;
                        found.push((t, n, DVec2::new(0.5 + p[j] / size[j], 0.5 + p[k] / size[k])));
                    }
                }
            }
        }
        ShapeDesc::Cylinder { radius, height } => {
            let (a, b) = (d.x * d.x + d.z * d.z, 2.0 * (o.x * d.x + o.z * d.z));
            for t in quadratic(a, b, o.x * o.x + o.z * o.z - radius * radius) {
                let p = o + d * t;
                if p.y.abs() <= height / 2.0 {
                    found.push((t, DVec3::new(p.x, 0.0, p.z), DVec2::new(around(p), 0.5 + p.y / height)));
                }
            }
            for side in [-1.0, 1.0] {
                disc(&mut found, o, d, radius, side * height / 2.0, side);
            }
        }
        ShapeDesc::Cone { radius, height } => {
            // x² + z² = k² (h/2 - y)², k = r / h, on the nappe below the apex.
            let k2 = (radius / height).powi(2);
            let y = height / 2.0 - o.y;
            let a = d.x * d.x + d.z * d.z - k2 * d.y * d.y;
            let b = 2.0 * (o.x * d.x + o.z * d.z + k2 * y * d.y);
            for t in quadratic(a, b, o.x * o.x + o.z * o.z - k2 * y * y) {
                let p = o + d * t;
                if p.y.abs() <= height / 2.0 {
                    let n = DVec3::new(p.x, k2 * (height / 2.0 - p.y), p.z);
                    found.push((t, n, DVec2::new(around(p), 0.5 + p.y / height)));
                }
            }
            disc(&mut found, o, d, radius, -height / 2.0, -1.0);
        }
        ShapeDesc::Plane => {
            let t = -o.y / d.y;
            let p = o + d * t;
            found.push((t, DVec3::Y, DVec2::new(p.x, -p.z)));
        }
        ShapeDesc::Quad { size } => {
            let t = -o.y / d.y;
            let p = o + d * t;
            if p.x.abs() <= size.x / 2.0 && p.z.abs() <= size.y / 2.0 {
                found.push((t, DVec3::Y, DVec2::new(0.5 + p.x / size.x, 0.5 - p.z / size.y)));
            }
        }
        ShapeDesc::Spheres { ref data } => {
            for &[x, y, z, radius] in data.iter() {
                let center = DVec3::new(x, y, z);
                let form = Form::Shape(ShapeDesc::Sphere { radius });
                found.extend(crossings(&form, o - center, d));
            }
        }
        ShapeDesc::Mesh { .. } => unreachable!("meshes are given as triangles"),
    }
    found.retain(|(t, _, _)| t.is_finite());
    found
}

fn disc(found: &mut Vec<(f64, DVec3, DVec2)>, o: DVec3, d: DVec3, radius: f64, y: f64, side: f64) {
    let t = (y - o.y) / d.y;
    let p = o + d * t;
    if p.x * p.x + p.z * p.z <= radius * radius {
        found.push((t, DVec3::Y * side, DVec2::new(0.5 + p.x / (2.0 * radius), 0.5 - p.z / (2.0 * radius))));
    }
}

fn contains(form: &Form, p: DVec3) -> bool {
    match *form {
        Form::Shape(ShapeDesc::Sphere { radius }) => p.length() < radius,
        Form::Shape(ShapeDesc::Cuboid { size }) => p.abs().cmplt(size / 2.0).all(),
        Form::Shape(ShapeDesc::Cylinder { radius, height }) => p.y.abs() < height / 2.0 && p.x.hypot(p.z) < radius,
        Form::Shape(ShapeDesc::Cone { radius, height }) => {
            p.y.abs() < height / 2.0 && p.x.hypot(p.z) < radius * (0.5 - p.y / height)
        }
        Form::Shape(ShapeDesc::Plane) => p.y < 0.0,
        Form::Shape(ShapeDesc::Spheres { ref data }) => {
            data.iter().any(|&[x, y, z, r]| (p - DVec3::new(x, y, z)).length() < r)
        }
        Form::Shape(_) => false,
        // Parity along an arbitrary direction.
        Form::Triangles(ref triangles) => {
            let d = DVec3::new(0.3, 0.5, 0.81).normalize();
            triangles.iter().filter(|t| moller_trumbore(p, d, **t).is_some_and(|t| t > 0.0)).count() % 2 == 1
        }
    }
}

fn volume(form: &Form) -> f64 {
    match *form {
        Form::Shape(ShapeDesc::Sphere { radius }) => 4.0 / 3.0 * PI * radius.powi(3),
        Form::Shape(ShapeDesc::Cuboid { size }) => size.x * size.y * size.z,
        Form::Shape(ShapeDesc::Cylinder { radius, height }) => PI * radius * radius * height,
        Form::Shape(ShapeDesc::Cone { radius, height }) => PI * radius * radius * height / 3.0,
        Form::Shape(ShapeDesc::Plane) => f64::INFINITY,
        Form::Shape(_) => 0.0,
        Form::Triangles(ref triangles) => {
            (triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c))).sum::<f64>() / 6.0).abs()
        }
    }
}

impl Twin {
    /// `models`: the triangles of every model file that the scene names.
    pub fn new(desc: &SceneDesc, models: &HashMap<PathBuf, Vec<[DVec3; 3]>>) -> Self {
        let bodies = desc.objects.iter().map(|o| {
            let form = match &o.shape {
                ShapeDesc::Mesh { file, .. } => Form::Triangles(models[file].clone()),
                shape => Form::Shape(shape.clone()),
            };
            let turn = DQuat::from_rotation_z(o.rotate.z.to_radians())
                * DQuat::from_rotation_y(o.rotate.y.to_radians())
                * DQuat::from_rotation_x(o.rotate.x.to_radians());
            let world = DAffine3::from_scale_rotation_translation(o.scale, turn, o.translate);
            let name = o.material.as_deref();
            let material = desc.materials.iter().find(|m| Some(m.name.as_str()) == name).cloned().unwrap_or_default();
            let volume = volume(&form) * o.scale.element_product().abs();
            Body { form, material, world, object: world.inverse(), volume }
        });
        Self { desc: desc.clone(), bodies: bodies.collect() }
    }

    /// The nearest crossing beyond `t_min`.
    pub fn nearest(&self, o: DVec3, d: DVec3, t_min: f64) -> Option<TwinHit> {
        self.all(o, d, t_min).into_iter().min_by(|a, b| a.t.total_cmp(&b.t))
    }

    fn all(&self, o: DVec3, d: DVec3, t_min: f64) -> Vec<TwinHit> {
        let mut all = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let (oo, od) = (body.object.transform_point3(o), body.object.transform_vector3(d));
            let normals = body.object.matrix3.transpose();
            for (t, n, uv) in crossings(&body.form, oo, od) {
                if t > t_min {
                    all.push(TwinHit { t, body: index, normal: (normals * n).normalize(), uv });
                }
            }
        }
        all
    }

    /// The transparent body that is at a point: highest priority, then smallest.
    fn medium(&self, p: DVec3) -> Option<usize> {
        let inside = |b: &Body| b.material.transmit > 0.0 && contains(&b.form, b.object.transform_point3(p));
        (0..self.bodies.len()).filter(|&i| inside(&self.bodies[i])).min_by(|&i, &j| {
            let (a, b) = (&self.bodies[i], &self.bodies[j]);
            b.material.priority.cmp(&a.material.priority).then(a.volume.total_cmp(&b.volume))
        })
    }

    fn ior(&self, medium: Option<usize>) -> f64 {
        medium.map_or(self.desc.world.ior, |i| self.bodies[i].material.ior)
    }

    fn background(&self, d: DVec3) -> [f64; 3] {
        match self.desc.world.background {
            Background::Solid(c) => rgb(c),
            Background::Gradient { top, bottom } => {
                let t = (1.0 + d.y) / 2.0;
                plus(scale(rgb(top), t), scale(rgb(bottom), 1.0 - t))
            }
        }
    }

    fn color(&self, hit: &TwinHit) -> [f64; 3] {
        let material = &self.bodies[hit.body].material;
        match &material.texture {
            None => rgb(material.color),
            Some(TextureDesc { source: TextureSource::Checker { colors, size }, scale, offset }) => {
                let uv = (hit.uv * *scale + *offset) / *size;
                rgb(colors[(uv.x.floor() + uv.y.floor()).rem_euclid(2.0) as usize])
            }
            Some(_) => unreachable!("no pictures in the twin"),
        }
    }

    /// The part of a light's light that reaches `p`.
    fn unshadowed(&self, p: DVec3, toward: DVec3, distance: f64) -> f64 {
        let between = self.all(p, toward, 1e-7).into_iter().filter(|h| h.t < distance * (1.0 - 1e-9));
        match self.desc.render.shadows {
            Shadows::Opaque => {
                if between.count() == 0 {
                    1.0
                } else {
                    0.0
                }
            }
            Shadows::Filtered => between
                .map(|h| {
                    let body = &self.bodies[h.body];
                    let q = p + toward * h.t;
                    let solid = !matches!(body.form, Form::Shape(ShapeDesc::Quad { .. }));
                    // A surface inside of a body that outranks its own is not there.
                    let drowned = body.material.transmit > 0.0
                        && solid
                        && self.medium(q - toward * 1e-7) == self.medium(q + toward * 1e-7);
                    if drowned { 1.0 } else { body.material.transmit }
                })
                .product(),
        }
    }

    /// What the ray sees; `depth` more reflections or refractions are allowed.
    pub fn radiance(&self, o: DVec3, d: DVec3, depth: u32) -> [f64; 3] {
        self.beyond(o, d, 1e-7, depth, 1.0)
    }

    /// `weight`: of the path so far.
    fn beyond(&self, o: DVec3, d: DVec3, t_min: f64, depth: u32, weight: f64) -> [f64; 3] {
        let Some(hit) = self.nearest(o, d, t_min) else { return self.background(d) };
        let body = &self.bodies[hit.body];
        let material = &body.material;
        let p = o + d * hit.t;
        let entering = hit.normal.dot(d) < 0.0;
        let n = if entering { hit.normal } else { -hit.normal };
        let solid = !matches!(body.form, Form::Shape(ShapeDesc::Quad { .. }));
        let (mut before, mut behind) = (None, None);
        if material.transmit > 0.0 && solid {
            // Far enough from the surface to tell the sides, and nearer than any other surface of these scenes.
            before = self.medium(p - d * 1e-7);
            behind = self.medium(p + d * 1e-7);
            if before == behind {
                // Drowned in a body that wins here.
                return self.beyond(o, d, hit.t + 1e-7, depth, weight);
            }
        }
        let c = self.color(&hit);
        let local = self.desc.render.shading != Shading::Whitted;
        let mut sum: [f64; 3] = std::array::from_fn(|k| material.ambient * rgb(self.desc.world.ambient)[k] * c[k]);
        for light in &self.desc.lights {
            let (toward, distance, falloff) = match light.kind {
                LightKind::Point { position, falloff } => {
                    let to = position - p;
                    (
                        to.normalize(),
                        to.length(),
                        if falloff == Falloff::None { 1.0 } else { 1.0 / to.length_squared() },
                    )
                }
                LightKind::Directional { direction } => (-direction.normalize(), f64::INFINITY, 1.0),
            };
            let cos = n.dot(toward);
            if cos <= 0.0 {
                continue;
            }
            let seen = if local { 1.0 } else { self.unshadowed(p, toward, distance) };
            let mirrored = n * (2.0 * cos) - toward;
            let phong = match self.desc.render.shading {
                Shading::Lambert => 0.0,
                _ => material.specular * (-d).dot(mirrored).max(0.0).powf(material.shininess),
            };
            for k in 0..3 {
                let i = rgb(light.color)[k] * light.intensity * falloff * seen;
                sum[k] += i * (material.diffuse * cos * c[k] + phong);
            }
        }
        if local || depth == 0 {
            return sum;
        }
        let (mut kr, mut kt) = (material.reflect, material.transmit);
        // Snell's law in the plane of incidence: the part of d along the surface is scaled by the ratio.
        let cos = -d.dot(n);
        let along = d + n * cos;
        let ratio = if solid && kt > 0.0 { self.ior(before) / self.ior(behind) } else { 1.0 };
        let sin2 = along.length_squared() * ratio * ratio;
        let refracted = (sin2 <= 1.0).then(|| along * ratio - n * (1.0 - sin2).sqrt());
        if material.fresnel {
            let f = match (kt > 0.0, entering) {
                (true, _) => super::fresnel_reflectance(cos, 1.0 / ratio),
                (false, true) => super::fresnel_reflectance(cos, material.ior / self.ior(self.medium(p - d * 1e-7))),
                (false, false) => 1.0,
            };
            (kr, kt) = if kt > 0.0 { ((kr + kt) * f, (kr + kt) * (1.0 - f)) } else { (kr * f, 0.0) };
        } else if refracted.is_none() {
            (kr, kt) = (kr + kt, 0.0);
        }
        if kr * weight >= NEGLIGIBLE {
            sum = plus(sum, scale(self.beyond(p, along + n * cos, 1e-7, depth - 1, kr * weight), kr));
        }
        if let (true, Some(onward)) = (kt * weight >= NEGLIGIBLE, refracted) {
            sum = plus(sum, scale(self.beyond(p, onward, 1e-7, depth - 1, kt * weight), kt));
        }
        sum
    }

    /// The colour of a pixel's centre.
    pub fn pixel(&self, x: u32, y: u32) -> [f64; 3] {
        let (o, d) = camera_ray(&self.desc, f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.radiance(o, d, self.desc.render.max_depth)
    }
}
