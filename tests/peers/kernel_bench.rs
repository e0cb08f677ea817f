//! glimt's triangle kernels as a contestant of an interleaved comparison: builds a tree over a mesh once, then answers
//! `trace RAYS MODE DUMP` on stdin with `OK nanoseconds rays hits sum-of-t`, in CPU time of this thread.
//!
//! Arguments: instruction set (or `best`), threads for the build, mesh file. Modes: `robust`, `robust-packets`, `fast`,
//! `fast-packets`, `reference`. Files: a mesh is "KMSH", counts of vertices and triangles and a pad as u32, then f32
//! positions and u32 indices; rays are "KRAY", count, kind (1: any hit), pad, then eight f32 a ray: origin, t_min,
//! direction, t_max.

use glam::{DVec3, Vec3};
use glimt::bvh::{Isa, PACKET, PacketRoom, Rays, TreeKernels, TriangleHit, Triangles};
use glimt::geometry::{Fast, Ray, Reference, Robust};
use std::io::{BufRead, Write};
use std::num::NonZeroUsize;
use std::time::Duration;

fn words(file: &str) -> Vec<[u8; 4]> {
    let bytes = std::fs::read(file).unwrap_or_else(|e| panic!("{file}: {e}"));
    bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect()
}

fn floats(words: &[[u8; 4]]) -> Vec<f32> {
    words.iter().map(|w| f32::from_le_bytes(*w)).collect()
}

fn read_mesh(file: &str) -> Vec<[Vec3; 3]> {
    let words = words(file);
    let (vertices, triangles) = (u32::from_le_bytes(words[1]) as usize, u32::from_le_bytes(words[2]) as usize);
    let positions: Vec<Vec3> = floats(&words[4..4 + 3 * vertices]).chunks_exact(3).map(Vec3::from_slice).collect();
    let indices = &words[4 + 3 * vertices..4 + 3 * (vertices + triangles)];
    indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|w| positions[u32::from_le_bytes(w) as usize])).collect()
}

/// Rays of a packet as f32, number by number as they stand in the file; laid out before time is taken, as Embree's are,
/// and widened after.
#[derive(Clone)]
#[repr(align(64))]
struct Rows([[f32; PACKET]; 8]);

/// Those, and how many there are. (Not with them in memory, behind the last of them: it is read first, and waiting for
/// it took an eighth of the time.)
struct Sheaf<'a>(&'a Rows, usize);

impl Rays for Sheaf<'_> {
    const IN_ROWS: bool = true;

    #[inline(always)]
    fn count(&self) -> usize {
        self.1
    }

    #[inline(always)]
    fn ray(&self, i: usize) -> Ray {
        let [x, y, z, t_min, dx, dy, dz, t_max] = self.0.0.each_ref().map(|row| f64::from(row[i]));
        Ray { origin: DVec3::new(x, y, z), direction: DVec3::new(dx, dy, dz), t_min, t_max }
    }
}

/// Rays, and whether any hit will do.
struct RaySets {
    single: Vec<[f32; 8]>,
    sheaves: Vec<Rows>,
    any: bool,
}

fn read_rays(file: &str) -> RaySets {
    let words = words(file);
    let count = u32::from_le_bytes(words[1]) as usize;
    let single: Vec<[f32; 8]> =
        floats(&words[4..4 + 8 * count]).chunks_exact(8).map(|c| std::array::from_fn(|k| c[k])).collect();
    let mut sheaves = vec![Rows([[0.0; PACKET]; 8]); count.div_ceil(PACKET)];
    for (i, ray) in single.iter().enumerate() {
        (0..8).for_each(|k| sheaves[i / PACKET].0[k][i % PACKET] = ray[k]);
    }
    RaySets { single, sheaves, any: u32::from_le_bytes(words[2]) == 1 }
}

#[inline(always)]
fn widened(r: &[f32; 8]) -> Ray {
    let [x, y, z, t_min, dx, dy, dz, t_max] = r.map(f64::from);
    Ray { origin: DVec3::new(x, y, z), direction: DVec3::new(dx, dy, dz), t_min, t_max }
}

#[cfg(unix)]
fn cpu_time() -> Duration {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(t.tv_sec as u64, t.tv_nsec as u32)
}

#[cfg(not(unix))]
fn cpu_time() -> Duration {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}

fn trace<K: TreeKernels>(tree: &Triangles, rays: &RaySets, out: &mut [(f32, u32)]) {
    if rays.any {
        for (ray, out) in rays.single.iter().zip(out) {
            *out = if tree.occluded::<K>(&widened(ray)) { (0.0, 0) } else { (f32::INFINITY, u32::MAX) };
        }
    } else {
        for (ray, out) in rays.single.iter().zip(out) {
            *out = tree.intersect::<K>(&widened(ray)).map_or((f32::INFINITY, u32::MAX), |h| (h.t as f32, h.triangle));
        }
    }
}

/// The same, as many rays at a time as packets take.
fn trace_packets<K: TreeKernels>(tree: &Triangles, rays: &RaySets, out: &mut [(f32, u32)]) {
    let mut room = PacketRoom::default();
    for (rows, out) in rays.sheaves.iter().zip(out.chunks_mut(PACKET)) {
        let sheaf = Sheaf(rows, out.len());
        if rays.any {
            out.fill((f32::INFINITY, u32::MAX));
            tree.occluded_packet::<K>(&sheaf, &mut room, |k| out[k] = (0.0, 0));
        } else {
            let value = |hit: Option<TriangleHit>| hit.map_or((f32::INFINITY, u32::MAX), |h| (h.t as f32, h.triangle));
            tree.intersect_packet::<K>(&sheaf, &mut room, |k, hit| out[k] = value(hit));
        }
    }
}

fn main() {
    let args: Vec<String> = std::env::args().filter(|a| a != "--bench").collect();
    let [_, isa, threads, mesh] = &args[..] else { return eprintln!("usage: kernel_bench ISA THREADS MESH") };
    let isa = Isa::ALL.into_iter().find(|i| i.name() == isa).unwrap_or_else(Isa::best);
    let threads: NonZeroUsize = threads.parse().expect("a number of threads");
    let triangles = read_mesh(mesh);
    let wall = std::time::Instant::now();
    let cpu = cpu_time();
    let tree = Triangles::build(triangles.len(), |i| triangles[i], isa, threads);
    let seconds = if threads.get() == 1 { cpu_time() - cpu } else { wall.elapsed() };
    let stats = tree.stats();
    eprintln!("{stats:?}");
    println!("READY {} {} {}", seconds.as_secs_f64(), stats.bytes, triangles.len());
    let mut loaded: Option<(String, RaySets)> = None;
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["trace", file, mode, dump] => {
                if loaded.as_ref().is_none_or(|l| l.0 != file) {
                    loaded = Some((file.to_string(), read_rays(file)));
                }
                let Some((_, rays)) = &loaded else { continue };
                let mut out = vec![(f32::INFINITY, u32::MAX); rays.single.len()];
                let start = cpu_time();
                match mode {
                    "robust" => trace::<Robust>(&tree, rays, &mut out),
                    "robust-packets" => trace_packets::<Robust>(&tree, rays, &mut out),
                    "fast" => trace::<Fast>(&tree, rays, &mut out),
                    "fast-packets" => trace_packets::<Fast>(&tree, rays, &mut out),
                    "reference" => trace::<Reference>(&tree, rays, &mut out),
                    _ => {
                        println!("NO");
                        continue;
                    }
                }
                let nanoseconds = (cpu_time() - start).as_nanos();
                let hits = out.iter().filter(|h| h.0 < f32::INFINITY);
                let (count, sum) = hits.fold((0, 0.0), |(n, s), h| (n + 1, s + f64::from(h.0)));
                if dump != "-" {
                    let bytes: Vec<u8> =
                        out.iter().flat_map(|h| [h.0.to_le_bytes(), h.1.to_le_bytes()]).flatten().collect();
                    std::fs::write(dump, bytes).expect("the dump can be written");
                }
                println!("OK {nanoseconds} {} {count} {sum}", rays.single.len());
            }
            ["drop"] => {
                loaded = None;
                println!("OK");
            }
            _ => return,
        }
        let _ = std::io::stdout().flush();
    }
}
