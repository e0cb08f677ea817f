//! The stability map of a scene: what flips under changes that must not change its picture, and why.

use super::cause::{Cause, Side, parting};
use super::invariance::mirrored;
use super::scenes::{apart, picture};
use super::trials::Effort;
use crate::description::{Falloff, LightKind, Numerics, Projection, SceneDesc};
use crate::geometry::{Classic, Fast, Reference, Robust};
use crate::output::encode_png;
use crate::render::{self, Film, RenderEvent, Settings};
use crate::scene::{Scene, compile};
use crate::shading::Sample;
use crate::study::chart::legend;
use crate::study::{Cell, Console, Report, StudyError, Table};
use glam::DVec3;
use serde_json::json;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::sync::Arc;

/// A map: numbers, and the picture.
pub struct Map {
    /// Counts by change and cause.
    pub report: Report,
    /// PNG: the scene in grey, each pixel that flips in the colour of its cause, and a legend with the number of those.
    pub png: Vec<u8>,
    /// Pixels that flip with the default arithmetic.
    pub flipped: usize,
}

/// A change that must not change the picture.
struct Change {
    name: String,
    desc: SceneDesc,
    /// Of lengths.
    scale: f64,
    mirrored: bool,
}

/// Times 2^k: lengths, and what falls off with them.
fn scaled(desc: &SceneDesc, exponent: i32) -> Change {
    let k = 2f64.powi(exponent);
    let mut desc = desc.clone();
    desc.camera.position *= k;
    desc.camera.look_at *= k;
    if let Projection::Orthographic { view_height } = &mut desc.camera.projection {
        *view_height *= k;
    }
    for object in &mut desc.objects {
        object.translate *= k;
        object.scale *= k;
    }
    for light in &mut desc.lights {
        if let LightKind::Point { position, falloff } = &mut light.kind {
            *position *= k;
            if *falloff == Falloff::InverseSquare {
                light.intensity *= k * k;
            }
        }
    }
    Change { name: format!("times 2^{exponent}"), desc, scale: k, mirrored: false }
}

/// Everything moved, the camera too.
fn moved(desc: &SceneDesc, sizes: f64) -> Change {
    let size = desc.camera.position.distance(desc.camera.look_at);
    let way = DVec3::new(0.6, -0.5, 0.62) * (size * sizes);
    let mut desc = desc.clone();
    desc.camera.position += way;
    desc.camera.look_at += way;
    for object in &mut desc.objects {
        object.translate += way;
    }
    for light in &mut desc.lights {
        if let LightKind::Point { position, .. } = &mut light.kind {
            *position += way;
        }
    }
    Change { name: format!("moved by {sizes:e} sizes"), desc, scale: 1.0, mirrored: false }
}

fn changes(desc: &SceneDesc, quick: bool) -> Vec<Change> {
    let mut list: Vec<_> = [-40, -3, 3, 40].map(|exponent| scaled(desc, exponent)).into();
    let exponents = if quick { vec![0, 3, 6] } else { (0..=6).collect() };
    list.extend(exponents.into_iter().map(|exponent| moved(desc, 10f64.powi(exponent))));
    list.push(Change { name: "mirrored".into(), desc: mirrored(desc), scale: 1.0, mirrored: true });
    for (name, numerics) in Numerics::NAMES.iter().copied().filter(|(_, numerics)| *numerics != Numerics::Robust) {
        let mut desc = desc.clone();
        desc.render.numerics = numerics;
        list.push(Change { name: format!("{name} arithmetic"), desc, scale: 1.0, mirrored: false });
    }
    list
}

/// Why a pixel of `right` (robust) and one of `other` (`numerics`) differ.
fn cause(a: (&Scene, (u32, u32), &Sample), b: (&Scene, (u32, u32), &Sample), numerics: Numerics, scale: f64) -> Cause {
    let first = Side::primary::<Robust>(a.0, a.1, 1.0);
    let parted = match numerics {
        Numerics::Classic => parting::<Robust, Classic>(first, Side::primary::<Classic>(b.0, b.1, scale), 0),
        Numerics::Fast => parting::<Robust, Fast>(first, Side::primary::<Fast>(b.0, b.1, scale), 0),
        Numerics::Robust => parting::<Robust, Robust>(first, Side::primary::<Robust>(b.0, b.1, scale), 0),
        Numerics::Reference => parting::<Robust, Reference>(first, Side::primary::<Reference>(b.0, b.1, scale), 0),
    };
    let other_cut = (a.2.cut - b.2.cut).abs() > 1e-6;
    parted.unwrap_or(if other_cut { Cause::DepthCut } else { Cause::Rounding })
}

/// The map of a scene, one sample in the middle of each pixel.
pub fn map(desc: &SceneDesc, quick: bool, threads: NonZeroUsize, console: &Console) -> Result<Map, StudyError> {
    let mut desc = desc.clone();
    desc.render.numerics = Numerics::Robust;
    let effort = Effort { quick, threads, go_on: &|_| true };
    let scene = compile(&desc, None)?;
    let right = picture(&effort, &scene);
    let (width, height) = (scene.width, scene.height);
    let mut causes: Vec<Option<Cause>> = vec![None; right.len()];
    let mut report = Report::new("stability-map");
    report.set("width", width);
    report.set("height", height);
    let mut columns = vec!["change", "pixels that flip"];
    columns.extend(Cause::ALL.iter().map(|(_, name, _)| *name));
    let mut table = Table::new("Pixels that flip by more than one code, by cause", &columns);
    let list = changes(&desc, quick);
    let mut flipped = 0;
    for (done, change) in list.iter().enumerate() {
        console.step(done, list.len() + 1, &change.name)?;
        // Meshes and pictures are shared.
        let other = compile(&change.desc, Some(&scene))?;
        let samples = picture(&effort, &other);
        let mut counts: BTreeMap<Cause, usize> = BTreeMap::new();
        for (at, sample) in right.iter().enumerate() {
            let (x, y) = (at as u32 % width, at as u32 / width);
            let there = (if change.mirrored { width - 1 - x } else { x }, y);
            let twin = &samples[(there.1 * width + there.0) as usize];
            if !apart(sample, twin) {
                continue;
            }
            let numerics = change.desc.render.numerics;
            let cause = cause((&scene, (x, y), sample), (&other, there, twin), numerics, change.scale);
            *counts.entry(cause).or_default() += 1;
            // What the default arithmetic does is drawn over what the others do.
            if numerics == Numerics::Robust || causes[at].is_none() {
                causes[at] = Some(cause);
            }
        }
        let total: usize = counts.values().sum();
        if change.desc.render.numerics == Numerics::Robust {
            flipped += total;
        }
        let mut row = vec![Cell::from(change.name.as_str()), total.into()];
        row.extend(Cause::ALL.iter().map(|(cause, ..)| Cell::from(counts.get(cause).copied().unwrap_or(0))));
        table.push(row);
    }
    console.step(list.len(), list.len() + 1, "threads and tiles")?;
    let scene = Arc::new(scene);
    let whole = film(&scene, 1, 64)?;
    for (threads, tile_size) in [(2, 8), (16, 32), (3, 1024)] {
        let other = film(&scene, threads, tile_size)?;
        let differ =
            whole.pixels().iter().zip(other.pixels()).filter(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits));
        let differ = differ.count();
        flipped += differ;
        let mut row = vec![Cell::from(format!("{threads} threads, tiles of {tile_size}")), differ.into()];
        row.extend(Cause::ALL.iter().map(|_| Cell::Nothing));
        table.push(row);
    }
    console.clear();
    let legend = Cause::ALL.map(|(_, name, [r, g, b])| format!("{name} #{r:02x}{g:02x}{b:02x}")).join(", ");
    report.notes.push(format!("Colours of the map: {legend}"));
    report.summary = json!({ "flipped_with_robust": flipped, "pixels": right.len() });
    report.samples = Table { title: String::new(), ..table.clone() };
    report.tables.push(table);
    Ok(Map { png: paint(width, height, &right, &causes)?, report, flipped })
}

/// One sample a pixel, by these threads and tiles.
fn film(scene: &Arc<Scene>, threads: usize, tile_size: u32) -> Result<Film, StudyError> {
    let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
    let handle = render::start(Arc::clone(scene), Settings { threads, tile_size });
    let mut film = Film::new(scene.width, scene.height);
    for event in handle.events() {
        match event {
            RenderEvent::TileFinished { tile, .. } => film.write(&tile),
            RenderEvent::Failed(error) => return Err(error.into()),
            _ => {}
        }
    }
    Ok(film)
}

/// The picture in dark grey, with the causes in their colours, enlarged to what an eye can tell, and what they mean
/// below.
fn paint(width: u32, height: u32, samples: &[Sample], causes: &[Option<Cause>]) -> Result<Vec<u8>, StudyError> {
    let color = |at: usize| {
        let of = |cause: Cause| Cause::ALL.iter().find(|(c, ..)| *c == cause).map(|(.., color)| *color);
        causes[at].and_then(of).unwrap_or_else(|| {
            let [r, g, b] = super::scenes::codes(&samples[at]).map(u32::from);
            [((r + g + b) / 6) as u8; 3]
        })
    };
    let times = (LEAST_WIDTH / width.max(1)).max(1);
    let (wide, high) = (width * times, height * times);
    let mut codes = Vec::with_capacity((wide * high * 3) as usize);
    for y in 0..high {
        codes.extend((0..wide).flat_map(|x| color((y / times * width + x / times) as usize)));
    }
    let count = |cause: Cause| causes.iter().filter(|other| **other == Some(cause)).count();
    let entries = Cause::ALL.map(|(cause, name, color)| (format!("{name} {}", count(cause)), color));
    let seen: Vec<_> = entries.into_iter().zip(Cause::ALL).filter(|(_, (cause, ..))| count(*cause) > 0).collect();
    let entries: Vec<_> = match seen.is_empty() {
        true => vec![("nothing flips".to_owned(), [40; 3])],
        false => seen.into_iter().map(|(entry, _)| entry).collect(),
    };
    let (below, strip) = legend(wide, &entries).map_err(StudyError::Chart)?;
    codes.extend(strip);
    Ok(encode_png(wide, high + below, &codes)?)
}

/// Maps of narrower pictures are enlarged, each pixel to a square.
const LEAST_WIDTH: u32 = 960;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{MaterialDesc, ObjectDesc, ShapeDesc};
    use crate::math::Rgb;
    use crate::study::stability::scenes::{
        ModelFile, SKY, at, bare, empty, matte, mesh, object, orthographic, point_light, v,
    };
    use crate::study::stability::triangles::icosphere;

    fn floor_under_a_lamp() -> SceneDesc {
        let mut desc = empty(40, 30, orthographic(v(0.0, 5.0, 3.0), DVec3::ZERO, 3.0));
        desc.materials = vec![matte("floor"), MaterialDesc { ambient: 1.0, color: Rgb::grey(0.5), ..matte("ball") }];
        desc.objects = vec![
            object(ShapeDesc::Plane, "floor"),
            at(v(0.5, 1.0, 0.1), object(ShapeDesc::Sphere { radius: 0.5 }, "ball")),
        ];
        desc.lights = vec![point_light(v(1.0, 4.0, 2.0), 20.0, Falloff::InverseSquare)];
        desc
    }

    #[test]
    fn a_plain_scene_is_stable_and_its_map_is_grey() {
        let console = Console::new(&|| false, true);
        let map = map(&floor_under_a_lamp(), true, NonZeroUsize::MIN, &console).unwrap();
        assert_eq!(map.flipped, 0, "{}", map.report.text());
        assert!(map.png.starts_with(b"\x89PNG"));
    }

    #[test]
    fn causes_are_told_apart() {
        // A ball of radius 1e4 as a floor: coarse arithmetic throws it into its own shadow.
        let mut desc = floor_under_a_lamp();
        desc.objects[0] = at(v(0.0, -1e5, 0.0), object(ShapeDesc::Sphere { radius: 1e5 }, "floor"));
        let count = |desc: &SceneDesc, change: &str, cause: &str| {
            let map = map(desc, true, NonZeroUsize::MIN, &Console::new(&|| false, true)).unwrap();
            assert_eq!(map.flipped, 0, "{}", map.report.text());
            let table = &map.report.tables[0];
            let column = table.columns.iter().position(|name| name == cause).unwrap();
            let row = table.rows.iter().find(|row| row[0] == Cell::from(change)).unwrap();
            let Cell::Whole(count) = row[column] else { panic!("{row:?}") };
            count
        };
        assert!(count(&desc, "fast arithmetic", "acne") + count(&desc, "classic arithmetic", "acne") > 0);
        // A sea of thin glass under a slanted eye: the coursework knows no total reflection.
        let mut desc = floor_under_a_lamp();
        desc.world.background = SKY;
        desc.camera = orthographic(v(0.0, 1.0, 5.0), DVec3::ZERO, 1.0);
        desc.materials.push(MaterialDesc { transmit: 1.0, ior: 0.5, diffuse: 0.0, ..matte("thin") });
        desc.objects = vec![ObjectDesc::new(ShapeDesc::Plane)];
        desc.objects[0].material = Some("thin".into());
        assert_eq!(count(&desc, "classic arithmetic", "total reflection"), 1200);
    }

    fn quiet_map(desc: &SceneDesc) -> Map {
        map(desc, true, NonZeroUsize::MIN, &Console::new(&|| false, true)).unwrap()
    }

    /// How often a change, or all of them, flips pixels for a cause.
    fn counted(map: &Map, change: Option<&str>, cause: &str) -> u64 {
        let table = &map.report.tables[0];
        let column = table.columns.iter().position(|name| name == cause).unwrap();
        let rows = table.rows.iter().filter(|row| change.is_none_or(|change| row[0] == Cell::from(change)));
        let counts = rows.map(|row| if let Cell::Whole(count) = row[column] { count } else { 0 });
        counts.sum()
    }

    #[test]
    fn two_faces_nearer_than_f32_can_tell_are_a_tie() {
        // The upper one is green; in f32 both are as far, and the first in the file wins.
        let mut desc = empty(40, 30, orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, 1.0));
        desc.camera.up = DVec3::NEG_Z;
        let flat = |name: &str, color| MaterialDesc { ambient: 1.0, color, ..matte(name) };
        desc.materials = vec![flat("red", Rgb::new(1.0, 0.0, 0.0)), flat("green", Rgb::new(0.0, 1.0, 0.0))];
        let quad = |material| object(ShapeDesc::Quad { size: glam::DVec2::splat(4.0) }, material);
        desc.objects = vec![quad("red"), at(v(0.0, 1e-7, 0.0), quad("green"))];
        let map = quiet_map(&desc);
        assert_eq!(map.flipped, 0, "{}", map.report.text());
        assert_eq!(counted(&map, Some("fast arithmetic"), "tie"), 1200, "{}", map.report.text());
    }

    #[test]
    fn a_smooth_mesh_that_shadows_itself_is_told_as_terminator() {
        // One ball throws its shadow on another one of the same mesh, so far from the origin that points in f32 are off
        // by 0.02: the edge of the shadow moves.
        let small = icosphere(2).into_iter().map(|t| t.map(|p| p * 0.4 + glam::Vec3::new(0.8, 1.0, 1.2)));
        let model = ModelFile::new(&icosphere(2).into_iter().chain(small).collect::<Vec<_>>());
        let place = v(2e5, -1e5, 3e5);
        let mut desc = empty(40, 30, orthographic(place + v(0.0, 0.0, 5.0), place, 2.2));
        desc.materials = vec![matte("balls")];
        desc.objects = vec![at(place, mesh(model.path(), 180.0, "balls"))];
        desc.lights = vec![point_light(place + v(3.0, 4.0, 6.0), 1.0, Falloff::None)];
        let map = quiet_map(&desc);
        assert_eq!(map.flipped, 0, "{}", map.report.text());
        assert!(counted(&map, Some("fast arithmetic"), "terminator") > 5, "{}", map.report.text());
        assert_eq!(counted(&map, None, "acne"), 0, "{}", map.report.text());
    }

    #[test]
    fn a_path_that_weighs_just_enough_is_told_as_depth_cut() {
        // Varnish on a ball under a white sky: what a pixel mirrors is followed from a weight of k_r F on. With k_r
        // such that one pixel is right at it, some other arithmetic decides otherwise.
        let mut desc = empty(12, 9, orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, 1.0));
        desc.world.background = crate::description::Background::Solid(Rgb::WHITE);
        desc.render.error = Some(8.0);
        desc.objects = vec![object(ShapeDesc::Sphere { radius: 1.0 }, "varnish")];
        let of = |reflect: f64| {
            let varnish = MaterialDesc { fresnel: true, reflect, ior: 1.5, ..bare("varnish", Rgb::BLACK) };
            SceneDesc { materials: vec![varnish], ..desc.clone() }
        };
        let effort = Effort { quick: true, threads: NonZeroUsize::MIN, go_on: &|_| true };
        let is_cut = |reflect: f64| picture(&effort, &compile(&of(reflect), None).unwrap())[20].cut > 0.0;
        let (mut cut, mut followed) = (1e-6f64, 0.9);
        assert!(is_cut(cut) && !is_cut(followed));
        while cut.next_up() < followed {
            let middle = cut + (followed - cut) / 2.0;
            if is_cut(middle) { cut = middle } else { followed = middle }
        }
        let maps = [cut, followed].map(|reflect| quiet_map(&of(reflect)));
        let found: u64 = maps.iter().map(|map| counted(map, None, "depth cut")).sum();
        assert!(found > 0, "{} {}", maps[0].report.text(), maps[1].report.text());
        for (_, other, _) in Cause::ALL.iter().filter(|(cause, ..)| *cause != Cause::DepthCut) {
            assert_eq!(maps.iter().map(|map| counted(map, None, other)).sum::<u64>(), 0, "{other}");
        }
    }
}
