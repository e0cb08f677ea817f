//! Brute-force twins of the hierarchies: whatever the trees return is what testing every primitive one by one returns,
//! to the last bit, ties included.

mod support;

use glam::{DVec2, DVec3};
use glimt::bvh::TreeKernels;
use glimt::description::*;
use glimt::geometry::{Hit, Ray, Reference, Robust, TriangleRay};
use glimt::math::{Rgb, SplitMix64};
use glimt::scene::{Scene, Shape};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use support::twin::Twin;
use support::*;

/// The closest of all hits of all primitives, each tested on its own.
fn brute_force<K: TreeKernels>(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    let mut take = |hit: Hit| {
        if best.is_none_or(|b| hit.beats(&b)) {
            best = Some(hit);
        }
    };
    for (object, o) in (0..).zip(scene.objects()) {
        if let Shape::Mesh(mesh) = &o.shape {
            let prepared = TriangleRay::new(&ray.transformed(&o.map.inverse));
            for primitive in 0..mesh.len() as u32 {
                let corners = mesh.corners(primitive).map(|p| p.as_vec3());
                if let Some((t, u, v)) = prepared.intersect(&corners, ray.t_max) {
                    take(Hit { t, object, primitive, u, v });
                }
            }
        } else if let Some(hit) = o.intersect::<K>(ray, object) {
            take(hit);
        }
    }
    best
}

fn unit(rng: &mut SplitMix64) -> DVec3 {
    loop {
        let p = v(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// A ray toward or inside a scene that fills [-size, size]³: anywhere, from afar, with zero components, ended early,
/// exactly through corners of things.
fn random_ray(rng: &mut SplitMix64, size: f64, corners: &[DVec3]) -> Ray {
    let place = |rng: &mut SplitMix64| unit(rng) * size * rng.unit().cbrt();
    let kind = rng.next_u64() % 8;
    let target = if kind < 3 && !corners.is_empty() {
        corners[(rng.next_u64() % corners.len() as u64) as usize]
    } else {
        place(rng)
    };
    let origin = match kind {
        0 => target + unit(rng) * size * 1e5,
        1 => target + unit(rng) * size * 3.0,
        _ => place(rng),
    };
    let mut direction = (target - origin).normalize_or(DVec3::X);
    if kind == 7 {
        direction =
            [DVec3::X, DVec3::NEG_Y, DVec3::Z, v(0.6, 0.8, 0.0), v(0.0, -0.6, 0.8)][(rng.next_u64() % 5) as usize];
    }
    let mut ray = Ray::new(origin, direction);
    if kind == 5 {
        ray.t_min = size * rng.unit();
        ray.t_max = ray.t_min + size * rng.unit();
    }
    ray
}

/// A bumpy closed surface of 2 n² triangles.
fn bumpy(n: usize, size: f64) -> (String, Vec<DVec3>) {
    let (mut text, mut points) = (String::new(), Vec::new());
    for i in 0..=n {
        for j in 0..n {
            let (t, p) = (3.0 * i as f64 / n as f64 + 0.07, std::f64::consts::TAU * j as f64 / n as f64);
            let r = size * (0.8 + 0.2 * (5.0 * t).sin() * (3.0 * p).cos());
            let q = v(r * t.sin() * p.sin(), r * t.cos(), r * t.sin() * p.cos());
            text += &format!("v {:e} {:e} {:e}\n", q.x, q.y, q.z);
            points.push(q);
        }
    }
    for i in 0..n {
        for j in 0..n {
            let at = |i: usize, j: usize| i * n + j % n + 1;
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1));
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    (text, points)
}

/// `n` things of all shapes in [-1, 1]³, some in the same place, some huge, some tiny; every fifth a mesh if there is
/// one.
fn crowd(n: usize, seed: u64, model: Option<&Path>) -> SceneDesc {
    let mut rng = SplitMix64(seed);
    let mut d = desc(1, 1, CameraDesc::default());
    d.materials.push(flat("white", Rgb::WHITE));
    for i in 0..n {
        let size = 0.9 * (n as f64).cbrt().recip() * 10f64.powf(rng.range(-1.0, 0.0));
        let stretch = |rng: &mut SplitMix64| size * rng.range(0.2, 1.0);
        let shape = match (i % 10, model) {
            (0 | 5, Some(file)) => ShapeDesc::Mesh { file: file.into(), crease: 0.0 },
            (1 | 6, _) => ShapeDesc::Cuboid { size: v(stretch(&mut rng), stretch(&mut rng), stretch(&mut rng)) },
            (2 | 7, _) => ShapeDesc::Cylinder { radius: stretch(&mut rng), height: stretch(&mut rng) },
            (3, _) => ShapeDesc::Cone { radius: stretch(&mut rng), height: stretch(&mut rng) },
            (8, _) => ShapeDesc::Quad { size: DVec2::new(stretch(&mut rng), stretch(&mut rng)) },
            _ => ShapeDesc::Sphere { radius: stretch(&mut rng) },
        };
        let is_mesh = matches!(shape, ShapeDesc::Mesh { .. });
        let mut thing = object(shape, "white");
        if i % 3 != 0 {
            thing.rotate = v(rng.range(0.0, 360.0), rng.range(0.0, 360.0), rng.range(0.0, 360.0));
            let sign = if rng.unit() < 0.2 { -1.0 } else { 1.0 };
            thing.scale = v(rng.range(0.3, 1.0), rng.range(0.3, 1.0) * sign, rng.range(0.3, 1.0));
        }
        if is_mesh {
            thing.scale *= size;
        }
        thing.translate = v(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        match i % 13 {
            4 => d.objects.push(thing.clone()), // A twin in the same place.
            9 => thing.translate = (thing.translate * 4.0).round() / 4.0,
            _ => {}
        }
        d.objects.push(thing);
    }
    if n > 20 {
        d.objects.push(at(v(0.0, -1.1, 0.0), object(ShapeDesc::Plane, "white")));
        d.objects.push(sphere(v(0.0, -1e3, 0.0), 999.0, "white"));
    }
    d
}

/// Compares so many rays; returns how many of them hit something.
fn check<K: TreeKernels>(scene: &Arc<Scene>, rays: usize, seed: u64, size: f64, corners: &[DVec3]) -> usize {
    let mut rng = SplitMix64(seed);
    let mut hits = 0;
    for i in 0..rays {
        let ray = random_ray(&mut rng, size, corners);
        let want = brute_force::<K>(scene, &ray);
        let got = scene.intersect::<K>(&ray);
        assert_eq!(got, want, "ray {i} of seed {seed}: {ray:?}");
        assert_eq!(scene.occluded::<K>(&ray), want.is_some(), "occluded, ray {i} of seed {seed}: {ray:?}");
        hits += usize::from(want.is_some());
    }
    hits
}

#[test]
fn the_tree_over_objects_finds_what_brute_force_finds() {
    for (n, rays) in [(0, 1000), (1, 100_000), (2, 100_000), (3, 100_000), (10, 150_000), (60, 100_000), (300, 40_000)]
    {
        let d = crowd(n, 40 + n as u64, None);
        let scene = compile(&d);
        let corners: Vec<DVec3> = d.objects.iter().map(|o| o.translate).collect();
        let hits = check::<Robust>(&scene, rays, 1 + n as u64, 1.5, &corners);
        assert!(n == 0 || hits > rays / 40, "{hits} of {rays} rays hit one of {n}");
        check::<Reference>(&scene, rays / 10, 2 + n as u64, 1.5, &corners);
    }
}

#[test]
fn trees_in_trees_find_what_brute_force_finds() {
    let (text, vertices) = bumpy(14, 1.0);
    let file = model_file("hierarchy-bumpy", &text);
    for (n, rays) in [(1, 100_000), (11, 60_000), (60, 10_000)] {
        let d = crowd(n, 70 + n as u64, Some(&file));
        let scene = compile(&d);
        // World-space vertices of the meshes: rays exactly at them meet several triangles at the same t or nearly.
        let mut corners = Vec::new();
        for o in scene.objects() {
            if let Shape::Mesh(mesh) = &o.shape {
                let all = (0..mesh.len() as u32).flat_map(|t| mesh.corners(t));
                corners.extend(all.step_by(7).map(|p| o.map.forward.transform_point3(p)));
            }
        }
        assert!(corners.len() >= vertices.len() / 7);
        check::<Robust>(&scene, rays, 3 + n as u64, 1.5, &corners);
        check::<Reference>(&scene, rays / 10, 4 + n as u64, 1.5, &corners);
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn meshes_of_any_size_in_their_file_are_met_as_by_brute_force() {
    for exponent in [-30, -20, -10, -5, 0, 5, 10, 15, 18, 25] {
        let size = 10f64.powi(exponent);
        let (text, vertices) = bumpy(10, size);
        let file = model_file("hierarchy-size", &text);
        let mut d = desc(1, 1, CameraDesc::default());
        d.materials.push(flat("white", Rgb::WHITE));
        d.objects.push(mesh(&file, "white"));
        let hits = check::<Robust>(&compile(&d), 20_000, 5, 1.5 * size, &vertices);
        assert!(hits > 10_000, "{hits} hits at size {size:e}");
        std::fs::remove_file(file).ok();
    }
}

#[test]
fn ten_thousand_spheres_in_one_object_are_found_as_by_brute_force() {
    let mut rng = SplitMix64(9);
    let data: Vec<[f64; 4]> = (0..10_000)
        .map(|_| {
            let p = unit(&mut rng) * rng.unit().cbrt();
            [p.x, p.y, p.z, 0.02 * rng.unit() + 1e-4]
        })
        .collect();
    let mut d = desc(1, 1, CameraDesc::default());
    d.materials.push(flat("white", Rgb::WHITE));
    d.objects.push(object(ShapeDesc::Spheres { data: data.into() }, "white"));
    assert!(check::<Robust>(&compile(&d), 4_000, 10, 1.5, &[]) > 1_000);
}

#[test]
fn what_is_found_is_where_the_naive_tracer_finds_it() {
    // The brute force above shares the kernels with the tree; this one shares nothing.
    let d = crowd(40, 5, None);
    let scene = compile(&d);
    let twin = Twin::new(&d, &HashMap::<PathBuf, Vec<[DVec3; 3]>>::new());
    let (mut rng, mut apart, mut hits) = (SplitMix64(6), 0, 0);
    for _ in 0..100_000 {
        let origin = unit(&mut rng) * 3.0;
        let ray = Ray::new(origin, (unit(&mut rng) * rng.unit() - origin).normalize());
        let (got, want) = (scene.intersect::<Robust>(&ray), twin.nearest(ray.origin, ray.direction, 0.0));
        hits += usize::from(want.is_some());
        let same = match (got, want) {
            (None, None) => true,
            // A grazing hit is where a root has an infinite slope; its neighbourhood is rounding in the naive formula.
            (Some(g), Some(w)) => (g.t - w.t).abs() < 1e-8,
            _ => false,
        };
        apart += usize::from(!same);
    }
    // Rays that pass an outline within rounding of the naive formulas: below one in a hundred thousand.
    assert!(apart <= 1 && hits > 20_000, "{apart} apart, {hits} hits");
}

#[test]
fn surfaces_lie_on_the_ray_and_normals_and_sides_agree_with_the_naive_tracer() {
    let d = crowd(40, 8, None);
    let scene = compile(&d);
    let twin = Twin::new(&d, &HashMap::<PathBuf, Vec<[DVec3; 3]>>::new());
    let mut rng = SplitMix64(11);
    let mut checked = 0;
    for _ in 0..50_000 {
        let origin = unit(&mut rng) * 3.0;
        let ray = Ray::new(origin, (unit(&mut rng) * rng.unit() - origin).normalize());
        let (Some(hit), Some(want)) = (scene.intersect::<Robust>(&ray), twin.nearest(ray.origin, ray.direction, 0.0))
        else {
            continue;
        };
        // Far from outlines and edges, where the naive tracer has the digits.
        if (hit.t - want.t).abs() > 1e-9 || want.normal.dot(ray.direction).abs() < 1e-3 {
            continue;
        }
        let surface = scene.interaction::<Robust>(&ray, &hit);
        let uv = scene.uv(&surface.hit, surface.point);
        assert!(surface.point.distance(ray.at(hit.t)) < 1e-9 * (1.0 + hit.t));
        assert!(surface.geometric_normal.distance(want.normal) < 1e-6, "{hit:?} {want:?}");
        assert_eq!(surface.entering, want.normal.dot(ray.direction) < 0.0);
        // The uv of sphere, cylinder, cone, plane, quad; a cuboid's faces and bottom caps turn theirs.
        let shape = &d.objects[scene.objects()[hit.object as usize].source as usize].shape;
        if !matches!(shape, ShapeDesc::Cuboid { .. }) && hit.primitive != 1 {
            assert!(uv.distance(want.uv) < 1e-6, "{shape:?}: {} is not {}", uv, want.uv);
        }
        assert!(uv.is_finite());
        checked += 1;
    }
    assert!(checked > 10_000, "{checked}");
}
