//! How fast rays are traced and trees are built, and beside every speed how wrong it is.

use super::chart::{Axis, Chart, Data, Point, Series};
use super::{Cell, Clock, Console, Plan, Report, Stats, StudyError, Table, Timed};
use crate::bvh::{Isa, TreeKernels, Triangles};
use crate::description::{Numerics, SceneDesc};
use crate::geometry::{Fast, Hit, Ray, Reference, Robust, reflect};
use crate::math::SplitMix64;
use crate::scene::{Mesh, PacketScratch, Scene, Shape, compile_for};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// What is measured, and how often.
#[derive(Clone, Debug)]
pub struct KernelOptions {
    /// Presets of arithmetic; those that stand for other shading formulas trace like [`Numerics::Fast`].
    pub numerics: Vec<Numerics>,
    /// Instruction sets, all of which this processor has.
    pub isas: Vec<Isa>,
    /// Rays of each kind, about.
    pub rays: usize,
    /// How often each is measured.
    pub rounds: usize,
    /// Threads for the second measurement of building; the first is with one.
    pub threads: NonZeroUsize,
}

impl Default for KernelOptions {
    fn default() -> Self {
        Self {
            numerics: vec![Numerics::Fast, Numerics::Robust, Numerics::Reference],
            isas: vec![Isa::best()],
            rays: 1 << 17,
            rounds: 5,
            threads: crate::render::default_threads(),
        }
    }
}

/// Rays that are traced together.
const PACKET: usize = 256;

/// Rays of one kind.
struct RaySet {
    kind: &'static str,
    rays: Vec<Ray>,
    /// Whether any hit will do.
    any_hit: bool,
}

/// What the yardstick or a contestant finds.
#[derive(Default)]
struct Found {
    hits: Vec<Option<Hit>>,
    blocked: Vec<bool>,
}

/// One contestant in one discipline.
#[derive(Clone, Copy)]
struct Setting {
    set: usize,
    isa: usize,
    numerics: Numerics,
    packets: bool,
}

/// How far from the yardstick.
struct Wrong {
    /// Part of the rays that hit something else, or that hit only here or only there.
    other: f64,
    /// The largest difference in t, over t; nothing for rays that only ask whether.
    distance: Option<f64>,
}

/// A setting and what came of it.
struct Measured {
    setting: Setting,
    runs: Vec<Timed<()>>,
    wrong: Wrong,
}

/// Traces primary, shadow, mirrored and random rays of the scene with one thread, and builds the trees of its meshes
/// again, in interleaved rounds after one that is not kept.
pub fn kernel(
    desc: &SceneDesc,
    options: &KernelOptions,
    clock: &impl Clock,
    console: &Console,
) -> Result<Report, StudyError> {
    if options.isas.is_empty() || options.numerics.is_empty() || options.rounds == 0 {
        return Err(StudyError::Asked(
            "there is nothing to measure: name numerics, instruction sets and rounds".into(),
        ));
    }
    let mut report = Report::new("kernel");
    report.set("rays", options.rays);
    report.set("rounds", options.rounds);
    report.set("packet", PACKET);
    report.set("isas", options.isas.iter().map(|isa| isa.name()).collect::<Vec<_>>());
    console.step(0, 0, "reading the scene")?;
    let mut scenes = Vec::new();
    for isa in &options.isas {
        scenes.push(compile_for(desc, None, *isa)?);
    }
    let sets = ray_sets(&scenes[0], options.rays);
    let measured = trace_all(&scenes, &sets, options, clock, console)?;
    let columns = ["kind", "numerics", "mode", "isa", "round", "count", "time (s)", "a second"];
    report.samples = Table::new("", &columns);
    tell_rays(&mut report, &scenes, &sets, &measured);
    let meshes = meshes(&scenes[0]);
    if !meshes.is_empty() {
        build_all(&mut report, &meshes, options, clock, console)?;
    }
    console.clear();
    report.notes.push(format!(
        "One thread; medians of {} rounds, ± the median distance from them. Packets are of {PACKET} rays. All presets trace the same rays, which start as far from a surface as fast \
         needs; wrong is measured against reference: rays with another hit, and the largest difference in t over t.",
        options.rounds
    ));
    Ok(report)
}

/// Measures every set with every instruction set, preset and mode.
fn trace_all(
    scenes: &[Scene],
    sets: &[RaySet],
    options: &KernelOptions,
    clock: &impl Clock,
    console: &Console,
) -> Result<Vec<Measured>, StudyError> {
    let mut settings = Vec::new();
    for set in 0..sets.len() {
        for isa in 0..scenes.len() {
            for &numerics in &options.numerics {
                settings.extend([false, true].map(|packets| Setting { set, isa, numerics, packets }));
            }
        }
    }
    let (mut found, mut scratch) = (Found::default(), PacketScratch::default());
    let mut run = |setting: &Setting, found: &mut Found| {
        let (scene, set) = (&scenes[setting.isa], &sets[setting.set]);
        match setting.numerics {
            Numerics::Robust => trace::<Robust>(scene, set, setting.packets, found, &mut scratch),
            Numerics::Reference => trace::<Reference>(scene, set, setting.packets, found, &mut scratch),
            Numerics::Fast | Numerics::Classic => trace::<Fast>(scene, set, setting.packets, found, &mut scratch),
        }
    };
    let mut wrong = Vec::new();
    for set in 0..sets.len() {
        console.step(set, sets.len(), format_args!("{} rays of the yardstick", sets[set].kind))?;
        let mut yardstick = Found::default();
        run(&Setting { set, isa: 0, numerics: Numerics::Reference, packets: false }, &mut yardstick);
        for setting in settings.iter().filter(|setting| setting.set == set) {
            console.go_on()?;
            run(setting, &mut found);
            wrong.push(compare(&found, &yardstick, &sets[set]));
        }
    }
    let plan = Plan { settings: settings.len(), rounds: options.rounds, warm_up: 0, seed: 1 };
    let (mut done, total) = (0, settings.len() * options.rounds);
    // Comparing was the warm-up.
    let runs = plan.measure(clock, |index| {
        console.step(done, total, format_args!("{} rays", sets[settings[index].set].kind))?;
        done += 1;
        run(&settings[index], &mut found);
        Ok::<_, StudyError>(())
    })?;
    let measured = settings.into_iter().zip(runs).zip(wrong);
    Ok(measured.map(|((setting, runs), wrong)| Measured { setting, runs, wrong }).collect())
}

fn trace<K: TreeKernels>(scene: &Scene, set: &RaySet, packets: bool, found: &mut Found, scratch: &mut PacketScratch) {
    found.hits.resize(if set.any_hit { 0 } else { set.rays.len() }, None);
    found.blocked.resize(if set.any_hit { set.rays.len() } else { 0 }, false);
    match (set.any_hit, packets) {
        (true, false) => {
            for (ray, blocked) in set.rays.iter().zip(&mut found.blocked) {
                *blocked = scene.occluded::<K>(ray);
            }
        }
        (true, true) => {
            for (rays, blocked) in set.rays.chunks(PACKET).zip(found.blocked.chunks_mut(PACKET)) {
                scene.occluded_packet::<K>(rays, blocked, scratch);
            }
        }
        (false, false) => {
            for (ray, hit) in set.rays.iter().zip(&mut found.hits) {
                *hit = scene.intersect::<K>(ray);
            }
        }
        (false, true) => {
            for (rays, hits) in set.rays.chunks(PACKET).zip(found.hits.chunks_mut(PACKET)) {
                scene.intersect_packet::<K>(rays, hits, scratch);
            }
        }
    }
}

fn compare(found: &Found, yardstick: &Found, set: &RaySet) -> Wrong {
    let rays = set.rays.len().max(1) as f64;
    if set.any_hit {
        let other = found.blocked.iter().zip(&yardstick.blocked).filter(|(a, b)| a != b).count();
        return Wrong { other: other as f64 / rays, distance: None };
    }
    let (mut other, mut distance) = (0, 0.0f64);
    for pair in found.hits.iter().zip(&yardstick.hits) {
        match pair {
            (Some(a), Some(b)) => {
                other += usize::from((a.object, a.primitive) != (b.object, b.primitive));
                distance = distance.max((a.t - b.t).abs() / b.t);
            }
            (a, b) => other += usize::from(a.is_some() != b.is_some()),
        }
    }
    Wrong { other: other as f64 / rays, distance: Some(distance) }
}

/// About `count` primary rays in tiles of 8 x 8, and from where they end rays to the first light, mirrored and in
/// random directions, in the same order.
fn ray_sets(scene: &Scene, count: usize) -> Vec<RaySet> {
    let (width, height) = (f64::from(scene.width), f64::from(scene.height));
    let tiles_across = ((count as f64 * width / height).sqrt() / 8.0).round().max(1.0) as usize;
    let tiles_down = (count as f64 / 64.0 / tiles_across as f64).round().max(1.0) as usize;
    let (across, down) = (width / (8 * tiles_across) as f64, height / (8 * tiles_down) as f64);
    let pixels = (0..tiles_across * tiles_down * 64).map(|index| {
        let (tile, within) = (index / 64, index % 64);
        (tile % tiles_across * 8 + within % 8, tile / tiles_across * 8 + within / 8)
    });
    let primary: Vec<Ray> =
        pixels.map(|(x, y)| scene.camera.ray((x as f64 + 0.5) * across, (y as f64 + 0.5) * down)).collect();
    let (mut shadow, mut mirrored, mut random) = (Vec::new(), Vec::new(), Vec::new());
    let mut rng = SplitMix64(1);
    for ray in &primary {
        let Some(hit) = scene.intersect::<Reference>(ray) else { continue };
        let at = scene.interaction::<Fast>(ray, &hit);
        let outward = if ray.direction.dot(at.geometric_normal) < 0.0 { 1.0 } else { -1.0 };
        let (normal, shading) = (at.geometric_normal * outward, at.shading_normal * outward);
        if let Some(light) = scene.lights.first().and_then(|light| light.illuminate(at.point))
            && light.direction.dot(normal) > 0.0
        {
            shadow.extend(match light.position {
                Some(position) => at.shadow_start().ray_to::<Fast>(position),
                None => Some(at.shadow_start().ray_along::<Fast>(light.direction)),
            });
        }
        mirrored.push(at.spawn_ray::<Fast>(reflect(ray.direction, shading, normal)));
        random.push(at.spawn_ray::<Fast>(diffuse(normal, &mut rng)));
    }
    let set = |kind, rays, any_hit| RaySet { kind, rays, any_hit };
    let mut sets = vec![
        set("primary", primary, false),
        set("shadow", shadow, true),
        set("mirrored", mirrored, false),
        set("random", random, false),
    ];
    sets.retain(|set| !set.rays.is_empty());
    sets
}

/// A direction with a density of the cosine to the normal: the normal and a point of the unit sphere.
fn diffuse(normal: DVec3, rng: &mut SplitMix64) -> DVec3 {
    let z = rng.range(-1.0, 1.0);
    let (sin, cos) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    (normal + DVec3::new(r * cos, r * sin, z)).normalize_or(normal)
}

fn tell_rays(report: &mut Report, scenes: &[Scene], sets: &[RaySet], measured: &[Measured]) {
    let columns = ["rays", "numerics", "mode", "isa", "Mrays/s", "±", "best", "ns a ray", "other hits", "largest dt/t"];
    let mut table = Table::new("Rays a second", &columns);
    let mut summary = Vec::new();
    let mut series: Vec<(String, Vec<Point>)> = Vec::new();
    for Measured { setting, runs, wrong } in measured {
        let set = &sets[setting.set];
        let (kind, numerics, isa) = (set.kind, setting.numerics.name(), scenes[setting.isa].isa().name());
        let mode = if setting.packets { "packet" } else { "single" };
        let count = set.rays.len();
        let rates: Vec<f64> = runs.iter().map(|run| count as f64 / run.time.as_secs_f64().max(1e-9)).collect();
        for (run, rate) in runs.iter().zip(&rates) {
            let time = run.time.as_secs_f64();
            let row: [Cell; 8] = [
                kind.into(),
                numerics.into(),
                mode.into(),
                isa.into(),
                run.round.into(),
                count.into(),
                time.into(),
                (*rate).into(),
            ];
            report.samples.push(row);
        }
        let Some(rate) = Stats::of(&rates) else { continue };
        let row: [Cell; 10] = [
            kind.into(),
            numerics.into(),
            mode.into(),
            isa.into(),
            (rate.median / 1e6).into(),
            (rate.mad / 1e6).into(),
            (rate.max / 1e6).into(),
            (1e9 / rate.median).into(),
            wrong.other.into(),
            wrong.distance.into(),
        ];
        table.push(row);
        let name = match scenes {
            [_] => format!("{numerics}, {mode}"),
            _ => format!("{numerics}, {mode}, {isa}"),
        };
        let at = series.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
            series.push((name, Vec::new()));
            series.len() - 1
        });
        let spread = Some((rate.lower_quartile / 1e6, rate.upper_quartile / 1e6));
        series[at].1.push(Point { x: setting.set as f64, y: rate.median / 1e6, spread });
        summary.push(json!({
            "kind": kind, "numerics": numerics, "mode": mode, "isa": isa, "rays": count, "rays_per_second": rate,
            "other_hits": wrong.other, "largest_relative_t_difference": wrong.distance,
        }));
    }
    report.tables.push(table);
    let chart = Chart {
        title: "Rays a second, by kind".into(),
        subtitle: "One thread; median, bars from quartile to quartile".into(),
        x: Axis::names("rays", sets.iter().map(|set| set.kind.to_owned()).collect()),
        y: Axis::linear("million rays a second"),
        series: series.into_iter().map(|(name, points)| Series { name, data: Data::Columns(points) }).collect(),
        limits: Vec::new(),
    };
    report.chart("", chart);
    report.summary = json!({ "rays": summary, "build": [] });
}

/// Each mesh of the scene once.
fn meshes(scene: &Scene) -> Vec<Arc<Mesh>> {
    let mut meshes: Vec<Arc<Mesh>> = Vec::new();
    for object in scene.objects() {
        if let Shape::Mesh(mesh) = &object.shape
            && !mesh.is_empty()
            && !meshes.iter().any(|known| Arc::ptr_eq(known, mesh))
        {
            meshes.push(mesh.clone());
        }
    }
    meshes
}

/// Builds every mesh's tree with one thread and with many.
fn build_all(
    report: &mut Report,
    meshes: &[Arc<Mesh>],
    options: &KernelOptions,
    clock: &impl Clock,
    console: &Console,
) -> Result<(), StudyError> {
    let corners = |mesh: &Arc<Mesh>| -> Vec<[Vec3; 3]> {
        (0..mesh.len() as u32).map(|index| mesh.corners(index).map(|corner| corner.as_vec3())).collect()
    };
    let soups: Vec<_> = meshes.iter().map(corners).collect();
    let triangles: usize = soups.iter().map(Vec::len).sum();
    let mut threads = vec![NonZeroUsize::MIN, options.threads];
    threads.dedup();
    let plan = Plan { settings: threads.len(), rounds: options.rounds, warm_up: 1, seed: 2 };
    let runs = plan.measure(clock, |setting| {
        console.step(0, 0, format_args!("building with {} threads", threads[setting]))?;
        let mut bytes = 0;
        for soup in &soups {
            let built = Triangles::build(soup.len(), |index| soup[index], options.isas[0], threads[setting]);
            bytes += built.stats().bytes;
        }
        Ok::<_, StudyError>(bytes)
    })?;
    let columns = ["threads", "Mtris/s", "±", "best", "time (ms)", "triangles", "bytes a triangle"];
    let mut table = Table::new("Trees over meshes", &columns);
    let mut summary = Vec::new();
    for (threads, runs) in threads.iter().zip(&runs) {
        let rates: Vec<f64> = runs.iter().map(|run| triangles as f64 / run.time.as_secs_f64().max(1e-9)).collect();
        for (run, rate) in runs.iter().zip(&rates) {
            let row: [Cell; 8] = [
                "build".into(),
                Cell::Nothing,
                format!("{threads} threads").into(),
                options.isas[0].name().into(),
                run.round.into(),
                triangles.into(),
                run.time.as_secs_f64().into(),
                (*rate).into(),
            ];
            report.samples.push(row);
        }
        let (Some(rate), Some(run)) = (Stats::of(&rates), runs.first()) else { continue };
        let bytes = run.value as f64 / triangles as f64;
        let row: [Cell; 7] = [
            threads.get().into(),
            (rate.median / 1e6).into(),
            (rate.mad / 1e6).into(),
            (rate.max / 1e6).into(),
            (1e3 * triangles as f64 / rate.median).into(),
            triangles.into(),
            bytes.into(),
        ];
        table.push(row);
        summary.push(json!({
            "threads": threads.get(), "triangles": triangles, "triangles_per_second": rate, "bytes_per_triangle": bytes,
        }));
    }
    report.tables.push(table);
    report.summary["build"] = summary.into();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{LightDesc, LightKind, ObjectDesc, ShapeDesc};
    use crate::math::Rgb;
    use crate::study::SystemClock;

    fn desc(shapes: Vec<ShapeDesc>) -> SceneDesc {
        let kind = LightKind::Directional { direction: DVec3::new(-1.0, -2.0, -1.5) };
        let light = LightDesc { name: String::new(), kind, color: Rgb::WHITE, intensity: 1.0, visible: true };
        let objects = shapes.into_iter().map(ObjectDesc::new).collect();
        SceneDesc { lights: vec![light], objects, ..SceneDesc::default() }
    }

    fn study(desc: &SceneDesc) -> Report {
        let available: Vec<_> = Isa::ALL.into_iter().filter(|isa| isa.is_available()).collect();
        let options = KernelOptions { isas: available, rays: 1000, rounds: 2, ..KernelOptions::default() };
        kernel(desc, &options, &SystemClock::default(), &Console::new(&|| false, true)).unwrap()
    }

    #[test]
    fn every_kind_of_ray_has_its_speed_and_its_error_and_robust_is_not_wrong() {
        let report = study(&desc(vec![ShapeDesc::Sphere { radius: 1.0 }, ShapeDesc::Plane]));
        let isas = Isa::ALL.into_iter().filter(|isa| isa.is_available()).count();
        let rows = report.summary["rays"].as_array().unwrap();
        assert_eq!(rows.len(), 4 * isas * 3 * 2);
        assert_eq!(report.samples.rows.len(), rows.len() * 2);
        for row in rows {
            assert!(row["rays_per_second"]["median"].as_f64().unwrap() > 0.0);
            if row["numerics"] != "fast" {
                assert_eq!(row["other_hits"], 0.0, "{row}");
                assert!(row["kind"] == "shadow" || row["largest_relative_t_difference"] == 0.0, "{row}");
            } else if row["kind"] == "primary" {
                // f32 shows.
                let off = row["largest_relative_t_difference"].as_f64().unwrap();
                assert!((1e-9..1e-2).contains(&off), "{row}");
            }
        }
        // No mesh, nothing to build.
        assert_eq!((report.tables.len(), report.summary["build"].as_array().unwrap().len()), (1, 0));
    }

    #[test]
    fn meshes_are_built_again_and_counted_once() {
        let file = std::env::temp_dir().join(format!("glimt-study-kernel-{}.obj", std::process::id()));
        std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").unwrap();
        let mesh = || ShapeDesc::Mesh { file: file.clone(), crease: 0.0 };
        let report = study(&desc(vec![mesh(), mesh()]));
        std::fs::remove_file(&file).ok();
        let build = report.summary["build"].as_array().unwrap();
        assert_eq!(build[0]["threads"], 1);
        for row in build {
            // One node and one block.
            assert_eq!((&row["triangles"], &row["bytes_per_triangle"]), (&4.into(), &((256.0 + 320.0) / 4.0).into()));
        }
        assert_eq!(report.tables.len(), 2);
    }

    #[test]
    fn an_empty_scene_has_primary_rays_alone_and_a_wish_to_stop_is_heeded() {
        let report = study(&desc(vec![]));
        assert!(report.summary["rays"].as_array().unwrap().iter().all(|row| row["kind"] == "primary"));
        let stop = || true;
        let options = KernelOptions { rays: 64, ..KernelOptions::default() };
        let stopped = kernel(&desc(vec![]), &options, &SystemClock::default(), &Console::new(&stop, true));
        assert!(matches!(stopped, Err(StudyError::Interrupted)));
        let options = KernelOptions { rounds: 0, ..options };
        let stopped = kernel(&desc(vec![]), &options, &SystemClock::default(), &Console::new(&|| false, true));
        assert!(matches!(stopped, Err(StudyError::Asked(_))));
    }

    #[test]
    fn differences_from_the_yardstick_are_counted() {
        let hit = |t, primitive| Some(Hit { t, object: 0, primitive, u: 0.0, v: 0.0 });
        let found = Found { hits: vec![hit(1.0, 0), hit(2.2, 1), None, hit(1.0, 0)], blocked: vec![] };
        let yardstick = Found { hits: vec![hit(1.0, 0), hit(2.0, 0), hit(1.0, 0), None], blocked: vec![] };
        let rays = vec![Ray::new(DVec3::ZERO, DVec3::X); 4];
        let wrong = compare(&found, &yardstick, &RaySet { kind: "primary", rays, any_hit: false });
        assert_eq!(wrong.other, 0.75);
        assert!((wrong.distance.unwrap() - 0.1).abs() < 1e-12);
    }
}
