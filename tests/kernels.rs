//! The triangle kernels of every instruction set against the all-f64 yardstick and against brute force, bit for bit.

use glam::{DVec3, Vec3};
use glimt::bvh::{Isa, PACKET, PacketRoom, Rays, TreeKernels, TriangleHit, Triangles};
use glimt::geometry::{Fast, Ray, Reference, Robust, TriangleRay};
use glimt::math::SplitMix64;
use std::num::NonZeroUsize;

type Corners = Vec<[Vec3; 3]>;

fn build(triangles: &Corners, isa: Isa) -> Triangles {
    Triangles::build(triangles.len(), |i| triangles[i], isa, NonZeroUsize::MIN)
}

fn available() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.is_available())
}

fn unit(rng: &mut SplitMix64) -> DVec3 {
    loop {
        let p = DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// A closed sphere of 20 · 4^level triangles whose neighbours share their corners bit for bit.
fn icosphere(level: u32, size: f32) -> Corners {
    let phi = (1.0 + 5f32.sqrt()) / 2.0;
    let p: Vec<Vec3> = [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)]
        .iter()
        .flat_map(|&(a, b)| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
        .collect();
    // The faces of the convex hull: all triples of mutual neighbours (distance 2), turned outward.
    let near = |a: Vec3, b: Vec3| (a.distance_squared(b) - 4.0).abs() < 1e-3;
    let mut faces = Corners::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(p[i], p[j]) && near(p[j], p[k]) && near(p[i], p[k]) {
                    let outward = (p[j] - p[i]).cross(p[k] - p[i]).dot(p[i]) > 0.0;
                    faces.push(if outward { [p[i], p[j], p[k]] } else { [p[i], p[k], p[j]] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..level {
        let middle = |a: Vec3, b: Vec3| ((a + b) / 2.0).normalize() * phi;
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces.into_iter().map(|f| f.map(|p| p.normalize() * size)).collect()
}

/// Triangles of many sizes and shapes, slivers among them.
fn soup(n: usize, rng: &mut SplitMix64) -> Corners {
    (0..n)
        .map(|_| {
            let at = (unit(rng) * rng.unit()).as_vec3();
            let size = 10f64.powf(rng.range(-4.0, -0.5));
            let thin = 10f64.powf(rng.range(-4.0, 0.0));
            let (a, b) = (unit(rng) * size, unit(rng) * size);
            [at, at + a.as_vec3(), at + (a * 0.5 + b * thin).as_vec3()]
        })
        .collect()
}

/// A point of a triangle that is hard to decide: a corner, on an edge, beside one, or inside.
fn hard_point(triangle: &[Vec3; 3], rng: &mut SplitMix64) -> DVec3 {
    let [a, b, c] = triangle.map(|p| p.as_dvec3());
    match rng.next_u64() % 5 {
        0 => a,
        1 => (a + b) / 2.0,
        2 => a.lerp(b, rng.unit()),
        3 => a.lerp(b, rng.unit()) + unit(rng) * (b - a).length() * 10f64.powf(rng.range(-14.0, -5.0)),
        _ => a + (b - a) * (rng.unit() * 0.5) + (c - a) * (rng.unit() * 0.5),
    }
}

fn random_ray(triangles: &Corners, size: f64, rng: &mut SplitMix64) -> Ray {
    let target = hard_point(&triangles[(rng.next_u64() % triangles.len() as u64) as usize], rng);
    let distance = size * 10f64.powf(rng.range(-2.0, 4.0));
    let origin = match rng.next_u64() % 4 {
        0 => unit(rng) * size * rng.unit(),
        _ => target + unit(rng) * distance,
    };
    let direction = target - origin;
    let mut ray =
        Ray::new(origin, if rng.next_u64().is_multiple_of(2) { direction } else { direction.normalize_or(DVec3::X) });
    match rng.next_u64() % 8 {
        0 => ray.t_max = rng.unit() * 2.0,
        1 => ray.t_min = rng.unit(),
        2 => {
            ray.direction[(rng.next_u64() % 3) as usize] = 0.0;
            if ray.direction == DVec3::ZERO {
                ray.direction = DVec3::Y;
            }
        }
        _ => {}
    }
    ray
}

fn brute_force(triangles: &Corners, ray: &Ray) -> Option<TriangleHit> {
    let prepared = TriangleRay::new(ray);
    let hits = triangles.iter().zip(0..).filter_map(|(corners, triangle)| {
        prepared.intersect(corners, ray.t_max).map(|(t, u, v)| TriangleHit { t, triangle, u, v })
    });
    hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
}

fn bits(hit: Option<TriangleHit>) -> Option<(u64, u32, u64, u64)> {
    hit.map(|h| (h.t.to_bits(), h.triangle, h.u.to_bits(), h.v.to_bits()))
}

#[test]
fn every_instruction_set_returns_the_hit_of_brute_force_to_the_last_bit() {
    let mut rng = SplitMix64(31);
    for (what, triangles, size) in
        [("soup", soup(300, &mut rng), 1.0), ("sphere", icosphere(2, 1e-3), 1e-3), ("one", soup(1, &mut rng), 1.0)]
    {
        let trees: Vec<_> = available().map(|isa| (isa, build(&triangles, isa))).collect();
        for i in 0..40_000 {
            let ray = random_ray(&triangles, size, &mut rng);
            let expected = bits(brute_force(&triangles, &ray));
            for (isa, tree) in &trees {
                assert_eq!(bits(tree.intersect::<Robust>(&ray)), expected, "{what} {i} {} {ray:?}", isa.name());
                assert_eq!(tree.occluded::<Robust>(&ray), expected.is_some(), "{what} {i} {} {ray:?}", isa.name());
            }
        }
    }
}

/// More than a million rays, adversarial ones among them.
#[test]
fn every_instruction_set_returns_the_hit_of_an_all_f64_traversal_in_large_trees() {
    let meshes = [
        ("soup", soup(20_000, &mut SplitMix64(31)), 1.0),
        ("sphere", icosphere(5, 1.0), 1.0),
        ("large sphere", icosphere(4, 1e3), 1e3),
        ("small sphere", icosphere(4, 1e-6), 1e-6),
    ];
    std::thread::scope(|threads| {
        for (seed, (what, triangles, size)) in (32..).zip(&meshes) {
            threads.spawn(move || {
                let mut rng = SplitMix64(seed);
                let reference = build(triangles, Isa::Portable);
                let trees: Vec<_> = available().map(|isa| (isa, build(triangles, isa))).collect();
                for i in 0..300_000 {
                    let ray = random_ray(triangles, *size, &mut rng);
                    let expected = bits(reference.intersect::<Reference>(&ray));
                    for (isa, tree) in &trees {
                        let what = || format!("{what} {i} {} {ray:?}", isa.name());
                        assert_eq!(bits(tree.intersect::<Robust>(&ray)), expected, "{}", what());
                        assert_eq!(tree.occluded::<Robust>(&ray), expected.is_some(), "{}", what());
                    }
                }
            });
        }
    });
}

#[test]
fn no_ray_from_inside_of_a_closed_mesh_gets_out() {
    let mut rng = SplitMix64(33);
    for size in [1e-3f32, 1.0, 1e3] {
        let triangles = icosphere(4, size);
        let tree = build(&triangles, Isa::best());
        for _ in 0..200_000 {
            let target = hard_point(&triangles[(rng.next_u64() % triangles.len() as u64) as usize], &mut rng);
            let origin = unit(&mut rng) * f64::from(size) * 0.9 * rng.unit();
            let ray = Ray::new(origin, target - origin);
            assert!(tree.intersect::<Robust>(&ray).is_some(), "size {size}: {ray:?}");
        }
    }
}

#[test]
fn every_instruction_set_returns_the_same_hit_of_the_fast_kernel() {
    fn bits_of<K: TreeKernels>(tree: &Triangles, ray: &Ray) -> Option<(u64, u32, u64, u64)> {
        bits(tree.intersect::<K>(ray))
    }
    let mut rng = SplitMix64(34);
    let triangles = icosphere(5, 1.0);
    let trees: Vec<_> = available().map(|isa| build(&triangles, isa)).collect();
    let mut differ = 0;
    for _ in 0..100_000 {
        let ray = Ray::new(unit(&mut rng) * 3.0, unit(&mut rng));
        let first = bits_of::<Fast>(&trees[0], &ray);
        // Its boxes are not conservative, so that a fused and an unfused slab may pass over different ones.
        differ += trees[1..].iter().filter(|tree| bits_of::<Fast>(tree, &ray) != first).count();
    }
    assert!(differ <= 2, "{differ} of 100000 rays differ");
}

/// Rays that run alike, more or less, to hard points that are near each other; a few are ended, shifted, along axes or
/// not finite.
fn alike(triangles: &Corners, size: f64, rng: &mut SplitMix64) -> Vec<Ray> {
    let any = |rng: &mut SplitMix64| (rng.next_u64() % triangles.len() as u64) as usize;
    let middle = hard_point(&triangles[any(rng)], rng);
    let eye = middle + unit(rng) * size * 10f64.powf(rng.range(-1.0, 2.0));
    let spread = size * 10f64.powf(rng.range(-6.0, -0.3));
    let apart = if rng.next_u64() & 1 == 0 { 0.0 } else { spread };
    let count = [8, 12, 13, 16, 33, 64, 65, 200, PACKET][(rng.next_u64() % 9) as usize];
    let (odd, strict) = (rng.next_u64().is_multiple_of(4), rng.next_u64().is_multiple_of(2));
    (0..count)
        .map(|_| {
            let near = middle + unit(rng) * spread;
            // A point that is hard to decide, of a triangle as near to the others as can be found in a few tries.
            let tries: Vec<DVec3> = (0..8).map(|_| hard_point(&triangles[any(rng)], rng)).collect();
            let target = tries.into_iter().min_by(|a, b| a.distance(near).total_cmp(&b.distance(near))).unwrap();
            let origin = eye + unit(rng) * apart;
            let mut ray = Ray::new(origin, (if strict || rng.next_u64() & 1 == 0 { near } else { target }) - origin);
            match rng.next_u64() % 32 {
                0 => ray.t_max = rng.unit() * 2.0,
                1 => ray.t_min = rng.unit(),
                2 => ray.t_max = f64::NEG_INFINITY,
                3 if odd => ray.direction[(rng.next_u64() % 3) as usize] *= 1e-30,
                4 if odd => ray.direction[(rng.next_u64() % 3) as usize] = 0.0,
                5 if odd => ray.origin[(rng.next_u64() % 3) as usize] = f64::NAN,
                6 if odd => ray.origin -= ray.direction * 1e6,
                _ => {}
            }
            if ray.direction == DVec3::ZERO {
                ray.direction = DVec3::Y;
            }
            ray
        })
        .collect()
}

#[test]
fn rays_that_run_alike_meet_together_what_each_meets_alone() {
    let mut rng = SplitMix64(33);
    for (what, triangles, size) in
        [("soup", soup(2_000, &mut rng), 1.0), ("sphere", icosphere(4, 1e-3), 1e-3), ("one", soup(1, &mut rng), 1.0)]
    {
        let trees: Vec<_> = available().map(|isa| (isa, build(&triangles, isa))).collect();
        let (mut together, mut hits, packets) = (0, 0, 1_000);
        for i in 0..packets {
            let rays = alike(&triangles, size, &mut rng);
            for (isa, tree) in &trees {
                let (mut found, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
                let left =
                    tree.intersect_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k, hit| found[k] = hit);
                together += usize::from(left.len() < rays.len() as u32);
                tree.occluded_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k| occluded[k] = true);
                for (k, ray) in rays.iter().enumerate() {
                    let alone = tree.intersect::<Robust>(ray);
                    assert_eq!(bits(found[k]), bits(alone), "{what} {i} {k} {} {ray:?}", isa.name());
                    assert_eq!(occluded[k], alone.is_some(), "{what} {i} {k} {} {ray:?}", isa.name());
                    hits += usize::from(alone.is_some());
                }
            }
        }
        assert!(together > packets * trees.len() / 10, "{together} packets went together through {what}");
        assert!(hits > packets * trees.len(), "{hits} hits with {what}");
    }
}

#[test]
fn what_a_ray_meets_in_f32_depends_neither_on_the_others_nor_on_the_instruction_set() {
    let mut rng = SplitMix64(34);
    for (what, triangles, size) in
        [("soup", soup(2_000, &mut rng), 1.0), ("sphere", icosphere(4, 1e-3), 1e-3), ("one", soup(1, &mut rng), 1.0)]
    {
        let trees: Vec<_> = available().map(|isa| (isa, build(&triangles, isa))).collect();
        let (mut hits, mut differ) = (0, 0);
        for i in 0..500 {
            let rays = alike(&triangles, size, &mut rng);
            let mut alone = vec![];
            for ray in &rays {
                let (mut hit, mut any) = (None, false);
                trees[0].1.intersect_packet::<Fast>(&[*ray][..], &mut PacketRoom::default(), |_, found| hit = found);
                trees[0].1.occluded_packet::<Fast>(&[*ray][..], &mut PacketRoom::default(), |_| any = true);
                assert_eq!(any, hit.is_some(), "{what} {i} {ray:?}");
                differ += usize::from(bits(hit) != bits(trees[0].1.intersect::<Fast>(ray)));
                hits += usize::from(any);
                alone.push(bits(hit));
            }
            for (isa, tree) in &trees {
                for start in [0, rays.len() / 3] {
                    let (mut found, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
                    tree.intersect_packet::<Fast>(&rays[start..], &mut PacketRoom::default(), |k, hit| {
                        found[start + k] = hit
                    });
                    tree.occluded_packet::<Fast>(&rays[start..], &mut PacketRoom::default(), |k| {
                        occluded[start + k] = true
                    });
                    for (k, ray) in rays.iter().enumerate().skip(start) {
                        assert_eq!(bits(found[k]), alone[k], "{what} {i} {k} {} {ray:?}", isa.name());
                        assert_eq!(occluded[k], alone[k].is_some(), "{what} {i} {k} {} {ray:?}", isa.name());
                    }
                }
            }
        }
        println!("{differ} of {hits} hits with {what} are others where rays are traced one by one");
        assert!(hits > 500 && differ * 4 < hits, "{differ} of {hits} hits with {what} are others one by one");
    }
}

/// Rays of f32, number by number.
struct Columns<'a>(&'a [Vec<f32>; 8]);

impl Rays for Columns<'_> {
    const IN_ROWS: bool = true;

    fn count(&self) -> usize {
        self.0[0].len()
    }

    fn ray(&self, i: usize) -> Ray {
        let [x, y, z, p, q, r, t_min, t_max] = self.0.each_ref().map(|column| f64::from(column[i]));
        Ray { origin: DVec3::new(x, y, z), direction: DVec3::new(p, q, r), t_min, t_max }
    }
}

#[test]
fn rays_that_are_told_one_by_one_meet_what_those_in_memory_meet() {
    let mut rng = SplitMix64(71);
    let triangles = icosphere(4, 1.0);
    let mut hits = 0;
    // Rooms that larger packets have been in.
    let (mut in_memory, mut one_by_one) = (PacketRoom::default(), PacketRoom::default());
    for (isa, tree) in available().map(|isa| (isa, build(&triangles, isa))) {
        for i in 0..200 {
            let given = alike(&triangles, 1.0, &mut rng);
            let given = &given[..given.len().min([PACKET, 100, 9, 31][i % 4])];
            let number = |k: usize| match k {
                0..3 => given.iter().map(|ray| ray.origin[k] as f32).collect(),
                3..6 => given.iter().map(|ray| ray.direction[k - 3] as f32).collect(),
                6 => given.iter().map(|ray| ray.t_min as f32).collect(),
                _ => given.iter().map(|ray| ray.t_max as f32).collect(),
            };
            let columns: [Vec<f32>; 8] = std::array::from_fn(number);
            let told = Columns(&columns);
            let rays: Vec<Ray> = (0..given.len()).map(|i| told.ray(i)).collect();
            let [mut a, mut b, mut c, mut d] = [(); 4].map(|()| vec![None; rays.len()]);
            let left = [
                tree.intersect_packet::<Robust>(&told, &mut one_by_one, |k, hit| a[k] = hit),
                tree.intersect_packet::<Robust>(&rays[..], &mut in_memory, |k, hit| b[k] = hit),
            ];
            assert_eq!(left[0], left[1], "{i} {}", isa.name());
            let left = [
                tree.intersect_packet::<Fast>(&told, &mut one_by_one, |k, hit| c[k] = hit),
                tree.intersect_packet::<Fast>(&rays[..], &mut in_memory, |k, hit| d[k] = hit),
            ];
            assert_eq!(left[0], left[1], "{i} {}", isa.name());
            for (k, ray) in rays.iter().enumerate() {
                assert_eq!(bits(a[k]), bits(tree.intersect::<Robust>(ray)), "{i} {k} {} {ray:?}", isa.name());
                assert_eq!(bits(a[k]), bits(b[k]), "{i} {k} {} {ray:?}", isa.name());
                assert_eq!(bits(c[k]), bits(d[k]), "{i} {k} {} {ray:?}", isa.name());
                hits += usize::from(a[k].is_some());
            }
        }
    }
    assert!(hits > 1_000, "{hits} hits");
}

#[test]
fn the_length_of_directions_does_not_matter_to_rays_that_run_alike() {
    let mut rng = SplitMix64(72);
    let mut together = 0;
    let sizes = [1.0, 1e9].map(|size| (size, icosphere(4, size as f32)));
    let trees =
        || sizes.iter().flat_map(|(size, triangles)| available().map(|isa| (*size, isa, build(triangles, isa))));
    for (size, isa, tree) in trees() {
        for exponent in [-300, -45, -42, -40, -38, -37, -35, -30, -20, 0, 20, 30, 35, 38, 39, 300] {
            let length = 10f64.powi(exponent);
            let toward = unit(&mut rng);
            let rays: Vec<Ray> = (0..PACKET)
                .map(|_| {
                    let (from, to) = (unit(&mut rng) * 0.5 - toward * 3.0, unit(&mut rng) * 0.3);
                    let ray = Ray::new(from * size, (to - from) * length);
                    Ray { t_max: if size == 1.0 { 100.0 / length } else { ray.t_max }, ..ray }
                })
                .collect();
            let (mut found, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
            let left = tree.intersect_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k, hit| found[k] = hit);
            tree.occluded_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k| occluded[k] = true);
            together += usize::from(left.is_empty());
            for (k, ray) in rays.iter().enumerate() {
                let alone = tree.intersect::<Robust>(ray);
                assert_eq!(bits(found[k]), bits(alone), "{size} 1e{exponent} {k} {} {ray:?}", isa.name());
                assert_eq!(occluded[k], alone.is_some(), "{size} 1e{exponent} {k} {} {ray:?}", isa.name());
            }
        }
    }
    assert!(together > 0, "none together");
}

/// Rays in a packet toward a middle, and each alone: the same bits. Returns the hits.
fn same_together(triangles: &Corners, rays: &[Ray], what: &str) -> usize {
    let mut hits = 0;
    for isa in available() {
        let tree = build(triangles, isa);
        let (mut found, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        tree.intersect_packet::<Robust>(rays, &mut PacketRoom::default(), |k, hit| found[k] = hit);
        tree.occluded_packet::<Robust>(rays, &mut PacketRoom::default(), |k| occluded[k] = true);
        for (k, ray) in rays.iter().enumerate() {
            let alone = tree.intersect::<Robust>(ray);
            assert_eq!(bits(found[k]), bits(alone), "{what} {k} {} {ray:?}", isa.name());
            assert_eq!(occluded[k], alone.is_some(), "{what} {k} {} {ray:?}", isa.name());
            hits += usize::from(alone.is_some());
        }
    }
    hits
}

/// Products of three coordinates are beyond f32 for large ones, and nothing for small ones.
#[test]
fn triangles_of_any_size_are_met_together_as_alone() {
    let mut rng = SplitMix64(36);
    for exponent in (-15..=15).map(|e| 2 * e) {
        let size = 10f64.powi(exponent);
        let corner = |x: f64, y: f64| (DVec3::new(x, y, 1.0) * size).as_vec3();
        let one = vec![[corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)]];
        // Thin layers of small triangles.
        let layers: Corners = (0..200)
            .map(|_| {
                let at = unit(&mut rng) * size * 0.5;
                let side = size * 10f64.powf(rng.range(-5.0, -1.0));
                [0; 3].map(|_| (at + unit(&mut rng).with_z(0.0) * side).as_vec3())
            })
            .collect();
        for (what, triangles) in [("one", &one), ("layers", &layers)] {
            let mut hits = 0;
            for _ in 0..20 {
                let eye = DVec3::new(rng.range(-0.2, 0.2), rng.range(-0.2, 0.2), -rng.range(0.1, 3.0)) * size;
                let aim = triangles[(rng.next_u64() % triangles.len() as u64) as usize];
                let middle = (aim[0] + aim[1] + aim[2]).as_dvec3() / 3.0;
                let spread = size * 10f64.powf(rng.range(-6.0, -1.0));
                let rays: Vec<Ray> =
                    (0..PACKET).map(|_| Ray::new(eye, middle + unit(&mut rng) * spread - eye)).collect();
                hits += same_together(triangles, &rays, &format!("{what} of size {size:e}"));
            }
            assert!(hits > 0 || exponent.abs() > 19, "{what} of size {size:e}");
        }
    }
}

/// Two sheets in one plane, seen by rays that run along different axes most: the depth where they meet is found along
/// another axis than the packet's.
#[test]
fn sheets_that_overlap_are_met_together_as_alone() {
    let mut rng = SplitMix64(37);
    let mut hits = 0;
    for _ in 0..300 {
        let sheet = |rng: &mut SplitMix64| {
            let mut corner = || DVec3::new(rng.range(-1e3, 1e3), rng.range(-1e3, 1e3), 0.0).as_vec3();
            [corner(), corner(), corner()]
        };
        let triangles: Corners = (0..6).map(|_| sheet(&mut rng)).collect();
        let height = 10f64.powf(rng.range(-4.0, 1.0));
        let over = DVec3::new(rng.range(-300.0, 300.0), rng.range(-300.0, 300.0), height);
        let rays: Vec<Ray> = (0..PACKET)
            .map(|_| Ray::new(over, DVec3::new(rng.range(0.95, 1.05), rng.range(-0.3, 0.3), -1.0)))
            .collect();
        hits += same_together(&triangles, &rays, "sheets");
    }
    assert!(hits > 1000, "{hits}");
}

/// Their edge functions are nothing but rounding for rays beside them.
#[test]
fn triangles_seen_edge_on_are_met_together_as_alone() {
    let mut rng = SplitMix64(35);
    for _ in 0..20 {
        let eye = unit(&mut rng) * 2.0;
        let triangles: Corners = (0..500)
            .map(|_| {
                // In a plane that holds the eye, up to rounding.
                let (along, across) = (unit(&mut rng) * 1e-1 - eye, unit(&mut rng));
                let size = 10f64.powf(rng.range(-6.0, -1.0));
                let (at, across) = (rng.range(0.8, 1.2), across * size);
                let depth = size * rng.range(0.0, 0.3);
                let point = |depth: f64, aside: f64| (eye + along * (at + depth) + across * aside).as_vec3();
                [point(0.0, 0.0), point(depth, rng.unit()), point(-depth, rng.unit() * 0.5)]
            })
            .collect();
        let trees: Vec<_> = available().map(|isa| (isa, build(&triangles, isa))).collect();
        for i in 0..50 {
            let (middle, spread) = (unit(&mut rng) * rng.unit(), 10f64.powf(rng.range(-3.0, -0.3)));
            let rays: Vec<Ray> = (0..PACKET).map(|_| Ray::new(eye, middle + unit(&mut rng) * spread - eye)).collect();
            for (isa, tree) in &trees {
                let (mut found, mut occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
                tree.intersect_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k, hit| found[k] = hit);
                tree.occluded_packet::<Robust>(&rays[..], &mut PacketRoom::default(), |k| occluded[k] = true);
                for (k, ray) in rays.iter().enumerate() {
                    let alone = tree.intersect::<Robust>(ray);
                    assert_eq!(bits(found[k]), bits(alone), "{i} {k} {} {ray:?}", isa.name());
                    assert_eq!(occluded[k], alone.is_some(), "{i} {k} {} {ray:?}", isa.name());
                }
            }
        }
    }
}
