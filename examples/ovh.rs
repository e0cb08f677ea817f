use glimt::render::*;
use glimt::scene::*;
use glimt::shading::*;
use glimt::study;
use std::num::NonZeroUsize;
use std::sync::atomic::*;
use std::sync::*;
use std::time::*;
#[repr(C)]
struct Ts(i64, i64);
unsafe extern "C" {
    fn clock_gettime(id: i32, t: *mut Ts) -> i32;
}
fn clock(id: i32) -> f64 {
    let mut t = Ts(0, 0);
    unsafe { clock_gettime(id, &mut t) };
    t.0 as f64 + 1e-9 * t.1 as f64
}
fn cpu() -> f64 {
    clock(2)
}
fn thread_cpu() -> f64 {
    clock(3)
}
/// passes, each group of tiles; nothing kept
#[allow(unused)]
fn passes(scene: &Scene, threads: usize, list: &[Pass]) {
    let tiles = Rect::spiral(scene.width, scene.height, 32);
    let mut jobs = Vec::new();
    for p in list {
        let g = if let Pass::Lattice { step } = p { if *step > 2 { 16 } else { 1 } } else { 1 };
        for c in tiles.chunks(g) {
            jobs.push((*p, c.to_vec()));
        }
    }
    let next = AtomicUsize::new(0);
    std::thread::scope(|s| {
        for _ in 0..threads {
            s.spawn(|| {
                let (mut pts, mut samples, mut scratch) =
                    (Vec::new(), vec![Sample::default(); BATCH], Scratch::default());
                let never = AtomicBool::new(false);
                let f = sampler(scene);
                while let Some((p, rects)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let mut flush = |pts: &mut Vec<glam::DVec2>| {
                        let mut rays = RayCounts::default();
                        let n = pts.len();
                        f(scene, pts, &mut samples[..n], &mut rays, &mut scratch, &never);
                        pts.clear();
                    };
                    for r in rects {
                        let step = if let Pass::Lattice { step } = p { *step } else { 1 };
                        for (row, col) in blocks(r.width.div_ceil(step), r.height.div_ceil(step)) {
                            let (x, y) = (r.x + col * step, r.y + row * step);
                            for i in p.samples_at(x, y) {
                                pts.push(film_point(Some(scene.render.filter), x, y, i));
                                if pts.len() == BATCH {
                                    flush(&mut pts);
                                }
                            }
                        }
                    }
                    flush(&mut pts);
                }
            });
        }
    });
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let rounds: usize = a[1].parse().unwrap();
    let samples: u32 = a[2].parse().unwrap();
    let only = a.get(3).cloned();
    let path = std::path::Path::new("/tmp/wt/adapt/scenes/demo.toml");
    let mut d =
        glimt::description::parse(&std::fs::read_to_string(path).unwrap(), path).unwrap_or_else(|e| panic!("{e:?}"));
    let w: u32 = std::env::var("W").map_or(640, |w| w.parse().unwrap());
    let h = w * 9 / 16;
    (d.film.width, d.film.height) = (w, h);
    d.render.samples = samples;
    d.render.error = None;
    let scene = Arc::new(
        compile_for(&d, None, std::env::var("ISA").map_or(glimt::bvh::Isa::best(), |_| glimt::bvh::Isa::Avx2)).unwrap(),
    );
    let threads = NonZeroUsize::new(std::env::var("T").map_or(2, |w| w.parse().unwrap())).unwrap();
    let names = ["plain", "drain", "film", "passes", "by4", "one"];
    let mut best = [[f64::MAX; 4]; 6];
    let mut all: Vec<Vec<[f64; 2]>> = vec![Vec::new(); 6];
    for r in 0..rounds {
        for k in 0..names.len() {
            let way = (k + r) % names.len();
            if only.as_ref().is_some_and(|o| o != names[way]) {
                continue;
            }
            let (c0, t0, th0) = (cpu(), Instant::now(), thread_cpu());
            let mut busy = 0.0;
            match way {
                0 => {
                    std::hint::black_box(study::plain(&scene, threads));
                }
                1 | 2 => {
                    let mut film = Film::new(w, h);
                    let mut progress = Progress::new(&scene, 2, Instant::now());
                    let h = start(scene.clone(), Settings { threads, ..Default::default() });
                    while let Ok(e) = h.next_event(Duration::from_secs(1000)) {
                        if way == 2 {
                            progress.update(&e, Instant::now());
                        }
                        match e {
                            RenderEvent::TileFinished { tile, stats, .. } => {
                                busy += stats.busy.as_secs_f64();
                                if way == 2 {
                                    film.write(&tile);
                                }
                            }
                            RenderEvent::Finished => break,
                            _ => {}
                        }
                    }
                }
                3 => passes(&scene, threads.get(), &Pass::sequence(samples)),
                4 => {
                    let mut l = Pass::lattices();
                    l.push(Pass::Refine { from: 1, to: samples });
                    passes(&scene, threads.get(), &l)
                }
                _ => passes(&scene, threads.get(), &[Pass::Refine { from: 0, to: samples }]),
            }
            let v = [cpu() - c0, t0.elapsed().as_secs_f64(), thread_cpu() - th0, busy];
            all[way].push([v[0], v[1]]);
            for i in 0..4 {
                best[way][i] = best[way][i].min(v[i]);
            }
        }
    }
    let med = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    for (k, (n, b)) in names.iter().zip(best).enumerate() {
        if b[0] < 1e9 {
            let ratio = |i: usize| {
                if all[0].len() == all[k].len() {
                    med(all[k].iter().zip(&all[0]).map(|(a, p)| 100.0 * (a[i] / p[i] - 1.0)).collect())
                } else {
                    0.0
                }
            };
            println!(
                "{n:8} cpu {:.4} ({:+.2} %, med {:+.2} %) wall {:.4} ({:+.2} %, med {:+.2} %) reader cpu {:.4} busy {:.4}",
                b[0],
                100.0 * (b[0] / best[0][0] - 1.0),
                ratio(0),
                b[1],
                100.0 * (b[1] / best[0][1] - 1.0),
                ratio(1),
                b[2],
                b[3]
            );
        }
    }
}
