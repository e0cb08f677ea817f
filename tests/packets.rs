//! Packets of rays against single rays and brute force, bit for bit, for every instruction set.

mod support;

use glam::{DVec3, Vec3Swizzles as _};
use glimt::bvh::{Isa, PACKET, RayPacket, TreeKernels};
use glimt::description::*;
use glimt::geometry::{Classic, Fast, Hit, Ray, Reference, Robust, SurfaceInteraction};
use glimt::math::{Rgb, SplitMix64};
use glimt::scene::{Inside, PacketScratch, Scene, Surfaces, Way, compile_for};
use support::*;

/// One of each shape, two of them in the same place, turned and stretched by chance.
fn things(seed: u64, count: usize) -> SceneDesc {
    let mut rng = SplitMix64(seed);
    let mut d = desc(1, 1, CameraDesc::default());
    d.materials.push(flat("white", Rgb::WHITE));
    for i in 0..count {
        let shape = match (i as u64 + seed) % 7 {
            0 | 6 => ShapeDesc::Sphere { radius: 0.5 },
            1 => ShapeDesc::Cuboid { size: v(1.0, 0.5, 0.25) },
            2 => ShapeDesc::Cylinder { radius: 0.5, height: 1.0 },
            3 => ShapeDesc::Cone { radius: 0.5, height: 1.0 },
            4 => ShapeDesc::Quad { size: glam::DVec2::new(1.0, 0.5) },
            _ => ShapeDesc::Plane,
        };
        let mut thing = object(shape, "white");
        if i % 2 == 1 {
            thing.rotate = v(rng.range(0.0, 360.0), rng.range(0.0, 360.0), 90.0);
            thing.scale = v(rng.range(0.3, 1.0), rng.range(0.3, 1.0), rng.range(0.3, 1.0));
        }
        thing.translate = (v(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0)) * 4.0).round() / 4.0;
        if i == 4 {
            d.objects.push(thing.clone());
        }
        d.objects.push(thing);
    }
    d
}

/// The product of the k_t of all surfaces of glass along a ray, object by object.
fn part(scene: &Scene, ray: &Ray) -> f64 {
    let mut part = 1.0;
    for (index, object) in (0..).zip(scene.objects()) {
        let mut ray = *ray;
        while let Some(hit) = object.intersect::<Robust>(&ray, index) {
            part *= scene.materials[scene.material_of(index, hit.primitive) as usize].transmit;
            ray.t_min = hit.t;
        }
    }
    part
}

/// Toward the scene or inside of it, along axes with zeros of both signs, along faces, ended early, from afar, not
/// finite.
fn ray(rng: &mut SplitMix64) -> Ray {
    let place = |rng: &mut SplitMix64| v(rng.range(-1.5, 1.5), rng.range(-1.5, 1.5), rng.range(-1.5, 1.5));
    let zero = |rng: &mut SplitMix64| if rng.next_u64() & 1 == 0 { 0.0 } else { -0.0 };
    let origin = place(rng);
    let mut ray = Ray::new(origin, (place(rng) - origin).normalize());
    match rng.next_u64() % 10 {
        0 => ray.origin -= ray.direction * 1e6,
        1 => ray.t_max = rng.unit(),
        2 => (ray.t_min, ray.t_max) = (rng.unit(), f64::INFINITY),
        // Through corners and along faces: everything stands on a grid of quarters.
        3 => ray.origin = (ray.origin * 8.0).round() / 8.0,
        4 => ray = Ray::new((ray.origin * 8.0).round() / 8.0, v(zero(rng), 1.0, zero(rng))),
        5 => ray = Ray::new((ray.origin * 8.0).round() / 8.0, v(-1.0, zero(rng), zero(rng))),
        6 => ray.direction[(rng.next_u64() % 3) as usize] = zero(rng),
        7 if rng.next_u64().is_multiple_of(4) => {
            let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][(rng.next_u64() % 3) as usize];
            if rng.next_u64() & 1 == 0 { ray.origin.y = bad } else { ray.direction.z = bad }
        }
        _ => {}
    }
    ray
}

fn bits(hit: Option<Hit>) -> Option<(u64, u32, u32, u64, u64)> {
    hit.map(|h| (h.t.to_bits(), h.object, h.primitive, h.u.to_bits(), h.v.to_bits()))
}

fn brute_force(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let all = (0..).zip(scene.objects()).filter_map(|(index, object)| object.intersect::<Robust>(ray, index));
    all.reduce(|best, hit| if hit.beats(&best) { hit } else { best })
}

#[test]
fn packets_find_what_single_rays_and_brute_force_find() {
    let mut scratch = PacketScratch::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let mut alike = 0;
        for (seed, count) in (0..60).zip([0, 1, 2, 3, 5, 6, 7, 12, 40].into_iter().cycle()) {
            let scene = compile_for(&things(seed, count), None, isa).unwrap();
            let mut rng = SplitMix64(seed);
            let mut hits = 0;
            for size in [1, 2, 7, 8, 9, 31, 64, 100, 255, 256] {
                let mut rays: Vec<Ray> = (0..size).map(|_| ray(&mut rng)).collect();
                if seed % 2 == 0 {
                    // All but a few run alike.
                    let first = rays[0];
                    for ray in &mut rays {
                        let turn = v(rng.range(-0.1, 0.1), rng.range(-0.1, 0.1), rng.range(-0.1, 0.1));
                        if !rng.next_u64().is_multiple_of(64) {
                            *ray = Ray { direction: first.direction + turn, ..first };
                            // Trees over many objects take nothing but unit directions together.
                            if seed.is_multiple_of(4) {
                                *ray = Ray {
                                    origin: ray.origin + turn.zxy(),
                                    direction: ray.direction.normalize(),
                                    ..first
                                };
                            }
                        }
                    }
                }
                let mut found = vec![None; size];
                let mut occluded = vec![true; size];
                scene.intersect_packet::<Robust>(&rays[..], &mut found, &mut scratch);
                scene.occluded_packet::<Robust>(&rays[..], &mut occluded, &mut scratch);
                for k in 0..size {
                    let what = format!("{} {seed} {count} {size} {k} {:?}", isa.name(), rays[k]);
                    assert_eq!(bits(found[k]), bits(scene.intersect::<Robust>(&rays[k])), "{what}");
                    assert_eq!(bits(found[k]), bits(brute_force(&scene, &rays[k])), "{what}");
                    assert_eq!(occluded[k], found[k].is_some(), "{what}");
                    hits += usize::from(occluded[k]);
                }
                scene.intersect_packet::<Reference>(&rays[..], &mut found, &mut scratch);
                for (ray, found) in rays.iter().zip(&found) {
                    assert_eq!(bits(*found), bits(scene.intersect::<Reference>(ray)), "{} {ray:?}", isa.name());
                }
                scene.intersect_packet::<Fast>(&rays[..], &mut found, &mut scratch);
                for (ray, found) in rays.iter().zip(&found) {
                    assert_eq!(bits(*found), bits(scene.intersect::<Fast>(ray)), "{} {ray:?}", isa.name());
                }
            }
            // Rays that run alike may all pass by.
            assert!(count < 3 || seed % 2 == 0 || hits > 50, "{hits} hits among {count}");
            alike += if seed % 2 == 0 { hits } else { 0 };
        }
        assert!(alike > 5_000, "{alike} hits of rays that run alike");
    }
}

#[test]
fn a_packet_that_all_passes_by_finds_nothing_and_none_is_left_of_the_one_before() {
    let scene = compile(&things(0, 5));
    let mut scratch = PacketScratch::default();
    let toward: Vec<Ray> = (0..64).map(|_| Ray::new(v(0.0, 0.0, 9.0), DVec3::NEG_Z)).collect();
    let away: Vec<Ray> = (0..64).map(|_| Ray::new(v(0.0, 0.0, 9.0), DVec3::Z)).collect();
    for rays in [toward, away] {
        let mut found = vec![None; 64];
        scene.intersect_packet::<Robust>(&rays[..], &mut found, &mut scratch);
        for (ray, found) in rays.iter().zip(&found) {
            assert_eq!(bits(*found), bits(brute_force(&scene, ray)));
        }
    }
}

#[test]
fn of_three_faces_in_a_chain_of_ties_packets_and_single_rays_see_the_same_one() {
    // Each ties with the next but not with the one after: with 2^-45 of t for one place, at t = 1 and 0.8 and 1.6 of
    // that behind it. In all orders of the objects, in scenes with a tree and without.
    let step = 0.8 / 2f64.powi(45);
    let mut scratch = PacketScratch::default();
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        for others in [0, 12] {
            let mut d = desc(1, 1, CameraDesc::default());
            d.materials.push(flat("white", Rgb::WHITE));
            d.objects = order.map(|k| quad(v(0.0, -step * f64::from(k), 0.0), 2.0, DVec3::ZERO, "white")).to_vec();
            d.objects.extend((0..others).map(|k| sphere(v(5.0 + f64::from(k), 0.0, 3.0), 0.4, "white")));
            let scene = compile(&d);
            let mut rng = SplitMix64(8);
            let rays: Vec<_> =
                (0..200).map(|_| Ray::new(v(rng.range(-0.5, 0.5), 1.0, rng.range(-0.5, 0.5)), DVec3::NEG_Y)).collect();
            let mut hits = vec![None; rays.len()];
            scene.intersect_packet::<Robust>(&rays[..], &mut hits, &mut scratch);
            for (ray, hit) in rays.iter().zip(&hits) {
                assert_eq!(bits(*hit), bits(scene.intersect::<Robust>(ray)), "{order:?} with {others} more");
                // Whichever it is lies in the one place that they are.
                let hit = hit.expect("three quads are in the way");
                assert!((hit.t - 1.0).abs() <= 2.5 * step && hit.object < 3, "{hit:?}");
            }
            // Two at a time there is no chain: the first in the file wins, in any order.
            let pair = |p: &Hit, q: &Hit| (p.t - q.t).abs() <= p.t.min(q.t) / 2f64.powi(45);
            let alone: Vec<_> =
                (0..3).filter_map(|k| scene.objects()[k].intersect::<Robust>(&rays[0], k as u32)).collect();
            assert_eq!(
                [(0, 1), (0, 2), (1, 2)].map(|(a, b)| pair(&alone[a], &alone[b])).iter().filter(|p| **p).count(),
                2
            );
        }
    }
}

/// All that there is to a surface, as bits; NaN is NaN.
fn surface_bits(at: &SurfaceInteraction) -> (Vec<u64>, u32, bool) {
    let vectors = [at.point, at.geometric_normal, at.shading_normal, at.shadow_point];
    let numbers = vectors.iter().flat_map(|v| v.to_array()).chain([at.point_error]);
    let bits = numbers.map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() });
    (bits.collect(), at.material, at.entering)
}

/// How many surfaces there are, each as it is alone.
fn assert_surfaces_as_alone<K: TreeKernels>(scene: &Scene, rays: &[Ray], surfaces: &mut Surfaces, what: &str) -> usize {
    let hits: Vec<Option<Hit>> = rays.iter().map(|ray| scene.intersect::<K>(ray)).collect();
    scene.surfaces::<K>(rays, &hits, surfaces);
    let rows = surfaces.rows();
    let mut numbers = rows.ray[..rows.count].to_vec();
    for (slot, &number) in numbers.iter().enumerate() {
        let ray = &rays[usize::from(number)];
        let hit = hits[usize::from(number)].as_ref().expect("only hits have surfaces");
        let alone = scene.interaction::<K>(ray, hit);
        assert_eq!(surface_bits(&surfaces.get(slot, hit)), surface_bits(&alone), "{what} {number} {ray:?}");
        assert_eq!(surfaces.directions().map(|row| row[slot]), ray.direction.to_array(), "{what} {number}");
    }
    numbers.sort_unstable();
    let met = (0..).zip(&hits).filter(|(_, hit)| hit.is_some()).map(|(number, _)| number);
    assert!(numbers.iter().copied().eq(met), "{what}: each hit has one surface");
    numbers.len()
}

#[test]
fn surfaces_computed_together_are_to_the_bit_what_each_is_alone() {
    let flat = "v -1 -1 -1\nv 1 -1 -1\nv 0 1 0\nv 0 -1 1\nf 1 3 2\nf 1 4 3\nf 2 3 4\nf 1 2 4\n";
    let smooth = "v -1 -1 -1\nv 1 -1 -1\nv 0 1 0\nv 0 -1 1\nvn -1 -1 -1\nvn 1 -1 -1\nvn 0 1 0\nvn 0 -1 1\n\
                  f 1//1 3//3 2//2\nf 1//1 4//4 3//3\nf 2//2 3//3 4//4\nf 1//1 2//2 4//4\n";
    let models = [model_file("flat-surfaces", flat), model_file("smooth-surfaces", smooth)];
    let mut surfaces = Surfaces::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let mut met = 0;
        for (seed, count) in (0..30).zip([1, 2, 3, 5, 7, 12, 40].into_iter().cycle()) {
            let mut desc = things(seed, count);
            let mut rng = SplitMix64(seed);
            for model in &models {
                let mut thing = mesh(model, "white");
                thing.rotate = v(rng.range(0.0, 360.0), rng.range(0.0, 360.0), 0.0);
                thing.scale = v(rng.range(0.3, 1.0), rng.range(0.3, 1.0), rng.range(-1.0, -0.3));
                desc.objects.push(thing);
            }
            let scene = compile_for(&desc, None, isa).unwrap();
            for size in [1, 2, 3, 8, 9, 100, PACKET] {
                let rays: Vec<Ray> = (0..size).map(|_| ray(&mut rng)).collect();
                let what = format!("{} {seed} {count} {size}", isa.name());
                met += assert_surfaces_as_alone::<Robust>(&scene, &rays, &mut surfaces, &what);
                assert_surfaces_as_alone::<Reference>(&scene, &rays, &mut surfaces, &what);
                assert_surfaces_as_alone::<Fast>(&scene, &rays, &mut surfaces, &what);
                assert_surfaces_as_alone::<Classic>(&scene, &rays, &mut surfaces, &what);
            }
        }
        assert!(met > 3_000, "{met} surfaces");
    }
}

/// Things of all shapes and meshes, opaque and transparent; more of them than are asked one after the other.
fn many(file: &std::path::Path, seed: u64) -> SceneDesc {
    let mut d = things(seed, 30);
    d.materials.push(MaterialDesc { transmit: 0.8, ior: 1.4, ..flat("glass", Rgb::WHITE) });
    let mut rng = SplitMix64(seed);
    for k in 0..6 {
        let mut model = mesh(file, "white");
        model.translate = v(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        model.rotate = v(rng.range(0.0, 360.0), 20.0 * f64::from(k), 0.0);
        d.objects.push(model);
    }
    for (k, thing) in d.objects.iter_mut().enumerate() {
        // A plane would be in the way of everything.
        thing.visible = !matches!(thing.shape, ShapeDesc::Plane) || seed.is_multiple_of(3);
        thing.scale *= 0.4;
        // Every other one with room between things.
        thing.translate *= if seed.is_multiple_of(2) { 1.0 } else { 2.0 };
        if (k as u64 + seed).is_multiple_of(3) {
            thing.material = Some("glass".into());
        }
    }
    d
}

#[test]
fn among_many_objects_rays_that_run_alike_find_what_they_find_alone() {
    let (mut text, n) = (String::new(), 12);
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
            text += &format!("v {x} {} {y}\n", 0.2 * (7.0 * x).sin() * (5.0 * y).cos());
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j + 1;
            text += &format!("f {} {} {} {}\n", a, a + 1, a + n + 2, a + n + 1);
        }
    }
    let file = model_file("packets-waves", &text);
    let mut scratch = PacketScratch::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let (mut hits, mut ways) = (0, [0; 4]);
        for seed in 0..12 {
            let scene = compile_for(&many(&file, seed), None, isa).unwrap();
            let mut rng = SplitMix64(seed);
            for size in [16, 17, 40, 64, 65, 256] {
                let wide = [0.05, 0.3, 2.0][(rng.next_u64() % 3) as usize];
                let mut near = |size: f64| v(rng.range(-size, size), rng.range(-size, size), rng.range(-size, size));
                let (from, to) = (near(2.5), near(0.5));
                let rays: Vec<Ray> = (0..size)
                    .map(|k| {
                        let origin = from + near(0.1);
                        let ray = Ray::new(origin, (to + near(wide) - origin).normalize());
                        Ray { t_max: if k % 3 == 0 { from.distance(to) } else { ray.t_max }, ..ray }
                    })
                    .collect();
                let (mut found, mut occluded, mut seen) =
                    (vec![None; size], vec![false; size], vec![Way::Unknown; size]);
                scene.intersect_packet::<Robust>(&rays[..], &mut found, &mut scratch);
                scene.occluded_packet::<Robust>(&rays[..], &mut occluded, &mut scratch);
                let inside = vec![Inside::Nothing; size];
                scene.look_along_packet::<Robust>(&rays[..], &inside, &mut seen, &mut scratch);
                let (mut behind, mut glass) = (Vec::new(), Vec::new());
                for k in 0..size {
                    let (ray, what) = (&rays[k], format!("{} {seed} {size} {k} {:?}", isa.name(), rays[k]));
                    assert_eq!(bits(found[k]), bits(scene.intersect::<Robust>(ray)), "{what}");
                    assert_eq!(occluded[k], found[k].is_some(), "{what}");
                    let blocked = scene.blocked::<Robust>(ray, &mut behind);
                    let expected = match (blocked, behind.is_empty()) {
                        (true, _) => Way::Blocked,
                        (_, true) => Way::Clear,
                        _ if matches!(seen[k], Way::Part(_)) => Way::Part(part(&scene, ray)),
                        _ => Way::Glass,
                    };
                    assert!(seen[k] == expected || seen[k] == Way::Unknown, "{what}: {:?} is {expected:?}", seen[k]);
                    if !blocked {
                        scene.glass_along::<Robust>(ray, &mut glass);
                        assert_eq!(glass, behind, "{what}");
                    }
                    hits += usize::from(occluded[k]);
                    match seen[k] {
                        Way::Clear => ways[0] += 1,
                        Way::Blocked => ways[1] += 1,
                        Way::Glass => ways[2] += 1,
                        Way::Part(_) => ways[3] += 1,
                        Way::Unknown => {}
                    }
                }
            }
        }
        assert!(hits > 1_500 && ways.iter().all(|&n| n > 100), "{hits} hits, {ways:?}");
    }
    std::fs::remove_file(file).ok();
}

/// Bodies of glass of all shapes, few enough to be asked one after the other: with room between them, touching face to
/// face, or one in another.
fn glass(seed: u64) -> SceneDesc {
    let mut rng = SplitMix64(seed);
    let mut d = desc(1, 1, CameraDesc::default());
    d.materials.push(flat("white", Rgb::WHITE));
    for (name, transmit, priority) in [("clear", 0.9, 0), ("dim", 0.7, 0), ("first", 0.9, 1)] {
        d.materials.push(MaterialDesc { transmit, priority, ior: 1.3, ..flat(name, Rgb::WHITE) });
    }
    for i in 0..1 + seed % 8 {
        let mut thing = match (i + seed / 8) % 6 {
            0 => object(ShapeDesc::Sphere { radius: 0.4 }, "clear"),
            1 => object(ShapeDesc::Cuboid { size: DVec3::splat(0.5) }, "clear"),
            2 => object(ShapeDesc::Cylinder { radius: 0.25, height: 0.5 }, "clear"),
            3 => object(ShapeDesc::Cone { radius: 0.4, height: 0.8 }, "clear"),
            4 => object(ShapeDesc::Quad { size: glam::DVec2::splat(0.5) }, "clear"),
            _ => ObjectDesc { scale: v(1.0, 0.6, 0.8), ..object(ShapeDesc::Sphere { radius: 0.4 }, "clear") },
        };
        let at = v((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64);
        match seed / 48 % 4 {
            // Side by side: cuboids and cylinders have common faces.
            0 => thing.translate = at * 0.5,
            1 => thing.translate = at * rng.range(0.0, 0.5),
            _ => {
                thing.translate = at * 1.2;
                thing.rotate = v(rng.range(0.0, 360.0), rng.range(0.0, 360.0), rng.range(0.0, 360.0));
                thing.scale *= v(rng.range(0.5, 1.2), rng.range(0.5, 1.2), rng.range(0.5, 1.2));
            }
        }
        thing.material = match rng.next_u64() % 12 {
            0 => Some("white".into()),
            1 => Some("dim".into()),
            2 => Some("first".into()),
            _ => thing.material,
        };
        d.objects.push(thing);
    }
    d
}

/// Through glass, out of it, into it, and along its faces and edges.
fn ray_at_glass(scene: &Scene, rng: &mut SplitMix64) -> Ray {
    let mut place = |size: f64| v(rng.range(-size, size), rng.range(-size, size), rng.range(-size, size));
    let objects = scene.objects();
    let (from, to, far, turn) = (place(1.0), place(1.0), place(4.0), place(1.0));
    let mut one = || &objects[rng.next_u64() as usize % objects.len()].map.forward;
    let (a, b) = (one(), one());
    let target = b.transform_point3(to);
    let origin = match rng.next_u64() % 4 {
        0 => a.transform_point3(from),
        // Along a face or, where two are rounded, an edge.
        1 => return Ray::new(far, (b.transform_point3(v(to.x.round(), to.y.round(), to.z)) - far).normalize()),
        _ => far + turn,
    };
    let ray = Ray::new(origin, (target - origin).normalize());
    let t_max = if rng.next_u64().is_multiple_of(3) { origin.distance(target) } else { ray.t_max };
    Ray { t_max, ..ray }
}

/// The part of the light that gets along a ray, surface by surface: the product of the k_t of all that change the
/// medium, where those that touch are taken together.
fn followed(scene: &Scene, ray: &Ray) -> f64 {
    let (mut ray, mut part, mut media) = (*ray, 1.0, scene.media_at(ray.origin));
    while let Some(first) = brute_force(scene, &ray) {
        let touching = 1e-9;
        let near = Ray { t_min: (first.t - touching).max(ray.t_min), t_max: first.t + touching, ..ray };
        let (before, mut passed) = (media, 1.0);
        for (index, object) in (0..).zip(scene.objects()) {
            let Some(hit) = object.intersect::<Robust>(&near, index) else { continue };
            let material = scene.material_of(index, hit.primitive);
            passed *= scene.materials[material as usize].transmit;
            media.cross(scene, index, material, scene.facet::<Robust>(&ray, &hit).entering);
        }
        if before == media || before.filling(scene) != media.filling(scene) {
            part *= passed;
        }
        ray.t_min = first.t + touching;
    }
    part
}

#[test]
fn what_is_counted_of_glass_in_a_small_scene_is_what_following_the_ray_finds() {
    let mut scratch = PacketScratch::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        // By what they are told to have in the way; how many of them start inside.
        let (mut ways, mut inside_ways) = ([0; 4], [0; 4]);
        for seed in 0..192 {
            let scene = compile_for(&glass(seed), None, isa).unwrap();
            let mut rng = SplitMix64(seed);
            let rays: Vec<Ray> = (0..203).map(|_| ray_at_glass(&scene, &mut rng)).collect();
            let inside: Vec<Inside> = rays.iter().map(|ray| scene.media_at(ray.origin).inside()).collect();
            let mut seen = vec![Way::Unknown; rays.len()];
            let mut check = |seen: &[Way], what: &str| {
                for ((ray, seen), inside) in rays.iter().zip(seen).zip(&inside) {
                    let what = format!("{} {what} {seed} {ray:?} {inside:?}", isa.name());
                    let mut glass = Vec::new();
                    let blocked = scene.blocked::<Robust>(ray, &mut glass);
                    match *seen {
                        Way::Blocked => assert!(blocked, "{what}"),
                        Way::Clear => assert!(!blocked && glass.is_empty(), "{what}"),
                        Way::Part(part) => {
                            assert!(!blocked && !glass.is_empty(), "{what}");
                            assert_eq!(part, followed(&scene, ray), "{what}");
                        }
                        Way::Glass => assert!(!blocked && !glass.is_empty(), "{what}"),
                        Way::Unknown => panic!("{what}: nothing was found out"),
                    }
                    let kind = match seen {
                        Way::Clear => 0,
                        Way::Blocked => 1,
                        Way::Part(_) => 2,
                        _ => 3,
                    };
                    ways[kind] += 1;
                    inside_ways[kind] += u32::from(*inside != Inside::Nothing);
                }
            };
            scene.look_along_packet::<Robust>(&rays[..], &inside, &mut seen, &mut scratch);
            check(&seen, "robust");
            scene.look_along_packet::<Reference>(&rays[..], &inside, &mut seen, &mut scratch);
            check(&seen, "reference");
            scene.look_along_packet::<Fast>(&rays[..], &inside, &mut seen, &mut scratch);
            assert!(!seen.iter().any(|seen| matches!(seen, Way::Part(_))), "{seed}: what f32 finds is followed");
        }
        assert!(ways.iter().all(|&n| n > 1000) && inside_ways[2] > 1000, "{ways:?}, {inside_ways:?} from inside");
    }
}

#[test]
fn the_way_out_of_a_body_is_what_the_whole_scene_says() {
    let mut rng = SplitMix64(31);
    let mut scratch = PacketScratch::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let mut desc = things(7, 40);
        for (k, thing) in desc.objects.iter_mut().enumerate() {
            thing.scale *= if k % 2 == 0 { 0.5 } else { 1.5 };
            thing.translate *= 2.0;
            thing.visible = !matches!(thing.shape, ShapeDesc::Plane);
        }
        let scene = compile_for(&desc, None, isa).unwrap();
        let (mut told, mut not) = (0, 0);
        for (index, object) in (0..).zip(scene.objects()).chain((0..).zip(scene.objects())) {
            let mut rays = RayPacket::default();
            let mut bodies = Vec::new();
            for k in 0..PACKET {
                let mut vector = |size: f64| v(rng.range(-size, size), rng.range(-size, size), rng.range(-size, size));
                // Inside and about, and on the surface with the error of a point there.
                let (place, direction) = (vector(1.1), vector(1.0).normalize());
                let mut ray = Ray::new(object.map.forward.transform_point3(place), direction);
                if k % 2 == 0 {
                    let Some(hit) = object.intersect::<Robust>(&ray, index) else { continue };
                    let at = scene.interaction::<Robust>(&ray, &hit);
                    ray = at.spawn_ray::<Robust>(glimt::geometry::reflect(
                        direction,
                        at.shading_normal,
                        at.geometric_normal,
                    ));
                }
                // Some are said to be inside of another body.
                let other = (index + u32::from(k % 7 == 0)) % scene.objects().len() as u32;
                rays.rows.put(bodies.len(), &ray);
                bodies.push(other);
            }
            rays.set_len(bodies.len());
            let (first, mut hits) = (bodies.len() / 5, vec![None; bodies.len()]);
            scene.leave_packet::<Robust>(&rays, first..bodies.len(), |k| Some(bodies[k]), &mut hits, &mut scratch);
            for (k, &hit) in hits.iter().enumerate().skip(first) {
                let ray = rays.ray(k);
                assert_eq!(bits(hit), bits(scene.intersect::<Robust>(&ray)), "{index} {ray:?}");
                let from_inside = scene.is_free::<Robust>(index) && hit.is_some_and(|hit| hit.object == index);
                told += u32::from(from_inside);
                not += u32::from(!from_inside);
            }
            assert!(hits[..first].iter().all(Option::is_none), "nobody asked");
        }
        assert!(told > 1_000 && not > 1_000, "{told} told, {not} not");
    }
}

#[test]
fn rays_from_very_far_away_find_together_what_they_find_alone() {
    let mut rng = SplitMix64(66);
    let mut desc = SceneDesc::default();
    for _ in 0..200 {
        let mut v = || v(rng.range(-0.5, 0.5), rng.range(-0.5, 0.5), rng.range(-0.5, 0.5));
        desc.objects.push(sphere(v(), 0.02, "white"));
    }
    desc.materials.push(flat("white", Rgb::WHITE));
    let mut scratch = PacketScratch::default();
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let scene = compile_for(&desc, None, isa).unwrap();
        let (mut met, mut rng) = (0, SplitMix64(67));
        for round in 0..300 {
            let (from, wide) = (10f64.powi(2 + round % 7), [1e-5, 1e-3, 0.1][round as usize % 3]);
            // Near the upper side of a ball, where boxes end.
            let ball = &desc.objects[rng.next_u64() as usize % 200];
            let top = ball.translate + v(0.0, 0.02, 0.0);
            let rays: Vec<Ray> =
                (0..64).map(|_| Ray::new(v(top.x, top.y - rng.unit() * wide, from), DVec3::NEG_Z)).collect();
            let mut found = vec![None; rays.len()];
            scene.intersect_packet::<Robust>(&rays[..], &mut found, &mut scratch);
            for (ray, found) in rays.iter().zip(found) {
                let alone = scene.intersect::<Robust>(ray);
                assert_eq!(bits(found), bits(alone), "{} {round} {ray:?}", isa.name());
                met += usize::from(found.is_some());
            }
        }
        assert!(met > 3_000, "{met} hits");
    }
}
