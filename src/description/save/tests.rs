//! What is saved means what was edited, and what was not edited stays as it was.

use super::super::edit::{self, Axis, Bounds, New};
use super::super::parameter::{Kind, Value, parameter, parameters, shared_parameters};
use super::*;
use crate::description::{Target, TextureSource, builtin, parse};
use crate::math::{Rgb, SplitMix64};
use glam::DVec3;
use std::fs;
use std::path::PathBuf;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// Scene files with their texts: those of the gallery, and every other way to write one.
fn corpus() -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for folder in ["", "lighting", "shapes"] {
        for entry in fs::read_dir(scenes().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|ending| ending == "toml") {
                found.push((path.clone(), fs::read_to_string(path).unwrap()));
            }
        }
    }
    found.sort();
    let odd = [
        "camera = { projection = 'orthographic', view_height = 3 }\nfilm.width = 9\n\
         object = [{ shape = 'plane' }, { shape = \"quad\", size = [1, 2], scale = [1, -2, 3] },\n{ shape = 'cone' }]\n",
        "\u{feff}# räksmörgås 球体\r\n[[light]]\r\nkind = 'directional'\r\ndirection = [0, -1, 0]\r\n[world]\r\n\
         background = 'tomato'\r\n[[object]]\r\nname = \"球\\u0041\"\r\nshape = \"sphere\"\r\n\r\n# apart\r\n\r\n# glass\r\n\
         [[material]]\r\nname = \"\"\"two\r\nlines\"\"\"\r\nfresnel = true\r\npriority = -3\r\n",
        "[[object]]\nshape = 'sphere'\n[[material]]\nname = 'a'\n[material.texture]\nchecker = ['red', [0.1, 0.2, 0.3]]\n\
         size = 0.5 # small\n[[material]]\nname = 'b'\ntexture.file = 'textures/stone.png'\ntexture.scale = 2\n\
         [camera]\nprojection = 'orthographic'\nposition = [\n  1, # one\n  2.0,\n  3,\n]",
        "[[object]]\nshape = 'sphere' # first\n\n# second\n[[object]]\nshape = 'sphere'\nradius = 2\n# third\n\
         [[object]]\nshape = 'sphere'\nradius = 3\n[[object]]\nshape = 'cuboid'\n# the end\n",
        "",
        "# nothing but this",
    ];
    found.extend(odd.into_iter().map(|text| (scenes().join("odd.toml"), text.to_owned())));
    found
}

fn parsed(text: &str, file: &Path) -> SceneDesc {
    parse(text, file).unwrap_or_else(|mistakes| panic!("{}\n{text}", mistakes[0].render(false)))
}

/// Shows only what differs.
fn same(found: &SceneDesc, expected: &SceneDesc, from: &str, to: &str) {
    let (found, expected) = (&with_real_paths(found), &with_real_paths(expected));
    assert_eq!((found.film, found.camera), (expected.film, expected.camera), "{from}\nto\n{to}");
    assert_eq!((found.world, found.render), (expected.world, expected.render), "{from}\nto\n{to}");
    assert_eq!(found.objects.len(), expected.objects.len(), "{from}\nto\n{to}");
    for (found, expected) in found.objects.iter().zip(&expected.objects) {
        assert_eq!(found, expected, "{from}\nto\n{to}");
    }
    for (found, expected) in found.materials.iter().zip(&expected.materials) {
        assert_eq!(found, expected, "{from}\nto\n{to}");
    }
    assert!(found == expected, "{:?} {:?}\n{from}\nto\n{to}", found.lights, expected.lights);
}

/// A path that leads up and down again means the same file.
fn with_real_paths(desc: &SceneDesc) -> SceneDesc {
    let mut desc = desc.clone();
    let real = |path: &mut PathBuf| {
        if let Ok(found) = fs::canonicalize(&path) {
            *path = found;
        }
    };
    for object in &mut desc.objects {
        if let ShapeDesc::Mesh { file, .. } = &mut object.shape {
            real(file);
        }
    }
    for texture in desc.materials.iter_mut().filter_map(|material| material.texture.as_mut()) {
        if let TextureSource::Image { file, .. } = &mut texture.source {
            real(file);
        }
    }
    desc
}

fn pick<T: Copy>(random: &mut SplitMix64, list: &[T]) -> T {
    list[(random.next_u64() % list.len() as u64) as usize]
}

fn all_targets(desc: &SceneDesc) -> Vec<Target> {
    let single = [Target::Film, Target::Camera, Target::World, Target::Render];
    let lights = (0..desc.lights.len()).map(Target::Light);
    let materials = (0..desc.materials.len()).map(Target::Material);
    let objects = (0..desc.objects.len()).map(Target::Object);
    single.into_iter().chain(lights).chain(materials).chain(objects).collect()
}

/// Something that a person might do; refused edits change nothing.
fn random_edit(random: &mut SplitMix64, desc: &mut SceneDesc) {
    let targets = all_targets(desc);
    let target = pick(random, &targets);
    let several: Vec<Target> = match random.next_u64() % 3 {
        0 => vec![target, pick(random, &targets)],
        _ => vec![target],
    };
    let before = desc.clone();
    let axis = pick(random, &[Axis::X, Axis::Y, Axis::Z, Axis::Right, Axis::Up, Axis::Forward]);
    let direction = axis.direction(&desc.camera);
    let amount = random.range(-3.0, 3.0);
    let point = DVec3::new(random.range(-2.0, 2.0), random.range(-2.0, 2.0), random.range(-2.0, 2.0));
    let result = match random.next_u64() % 16 {
        0 => edit::delete(desc, &several),
        1 => edit::duplicate(desc, &several).map(drop),
        2 => edit::move_by(desc, target, pick(random, &[-5, -1, 1, 7])).map(drop),
        3 => edit::set_visible(desc, &several, random.next_u64().is_multiple_of(2)),
        4 => edit::rename(desc, target, pick(random, &["ball", "a \"b\" c", "球", "two\nlines", "#", "''"])),
        5 => edit::translate(desc, &several, direction * amount),
        6 => edit::rotate(desc, &several, point, direction, 60.0 * amount),
        7 => edit::scale(desc, &several, point, (random.next_u64().is_multiple_of(2)).then_some(direction), amount),
        8 => {
            let mesh = || New::Mesh {
                file: scenes().join("models/gem.obj"),
                bounds: Bounds { lower: DVec3::NEG_ONE, upper: point.abs() },
            };
            let new = match random.next_u64() % 10 {
                0 => New::Sphere,
                1 => New::Cuboid,
                2 => New::Cylinder,
                3 => New::Cone,
                4 => New::Plane,
                5 => New::Quad,
                6 => New::PointLight,
                7 => New::DirectionalLight,
                8 => New::Material,
                _ => mesh(),
            };
            edit::add(desc, new).map(drop)
        }
        9 => {
            let count = desc.materials.len() as u64 + 1;
            edit::assign(desc, &several, (random.next_u64() % count).checked_sub(1).map(|at| at as usize))
        }
        10 => match parameter(target, "picture") {
            Some(picture) => picture.set(desc, &[target], &Value::Path(scenes().join("textures/stone.png"))),
            None => Ok(()),
        },
        _ => match shared_parameters(desc, &several) {
            list if list.is_empty() => Ok(()),
            list => {
                let parameter = pick(random, &list);
                let color = Value::Color(Rgb::new(random.unit(), random.unit(), 1.0));
                match (random.next_u64() % 5, &parameter.kind) {
                    (0, _) => parameter.reset(desc, &several),
                    (1, Kind::Path(_)) => Ok(()),
                    (1, Kind::Color) => parameter.set(desc, &several, &color),
                    (1, _) => parameter.enter(desc, &several, pick(random, &["0.1+0.2", "*2", "+-1", "1e-3", "1/3"])),
                    _ => parameter.nudge(
                        desc,
                        &several,
                        pick(random, &[-3, -1, 1, 10]),
                        random.next_u64().is_multiple_of(2),
                    ),
                }
            }
        },
    };
    if result.is_err() {
        assert_eq!(*desc, before, "a refused edit changes nothing");
    }
}

/// Texts of the entries of a list: from the title to the last key.
fn blocks<'a>(text: &'a str, title: &str) -> Vec<&'a str> {
    let mut found = Vec::new();
    let mut start = None;
    let mut end = 0;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let content = line.trim();
        if content.starts_with('[') && content.split('#').next().unwrap_or("").trim_end().ends_with(']') {
            found.extend(start.take().map(|start: usize| &text[start..end]));
            if content.split('#').next().unwrap_or("").trim_end() == title {
                start = Some(at);
            }
        }
        at += line.len();
        if !content.is_empty() && !content.starts_with('#') {
            end = at;
        }
    }
    found.extend(start.map(|start| &text[start..end]));
    found
}

#[test]
fn what_was_edited_is_what_is_saved_and_untouched_entries_stay_as_they_were() {
    let mut random = SplitMix64(42);
    let corpus = corpus();
    let mut compared = 0;
    for round in 0..700 {
        let (file, text) = &corpus[round % corpus.len()];
        let desc = parsed(text, file);
        let source = Source { text, desc: &desc, file };
        assert_eq!(
            save(source, &desc, file).as_deref().map(str::trim),
            Ok(if text.trim().is_empty() {
                "[film]\nwidth = 1280\nheight = 720\n\n[camera]\nposition = [3, 2, 5]\nlook_at = [0, 0, 0]"
            } else {
                text.trim()
            })
        );
        let mut edited = desc.clone();
        for _ in 0..1 + random.next_u64() % 6 {
            random_edit(&mut random, &mut edited);
        }
        let saved = save(source, &edited, file).unwrap();
        same(&parsed(&saved, file), &edited, text, &saved);
        // Once more, from what was saved.
        let reread = parsed(&saved, file);
        let mut again = reread.clone();
        random_edit(&mut random, &mut again);
        let resaved = save(Source { text: &saved, desc: &reread, file }, &again, file).unwrap();
        same(&parsed(&resaved, file), &again, &saved, &resaved);

        if text.contains("[material.texture]") || text.contains("object = [") {
            continue;
        }
        for (at, block) in blocks(text, "[[object]]").into_iter().enumerate() {
            if edited.objects.contains(&desc.objects[at]) {
                assert!(saved.contains(block), "object {at} is lost:\n{block}\nin\n{saved}");
                compared += 1;
            }
        }
        for (at, block) in blocks(text, "[[light]]").into_iter().enumerate() {
            if edited.lights.contains(&desc.lights[at]) {
                assert!(saved.contains(block), "light {at} is lost:\n{block}\nin\n{saved}");
            }
        }
        for (at, block) in blocks(text, "[[material]]").into_iter().enumerate() {
            if edited.materials.contains(&desc.materials[at]) {
                assert!(saved.contains(block), "material {at} is lost:\n{block}\nin\n{saved}");
            }
        }
    }
    assert!(compared > 500, "{compared}");
}

/// How many lines of `a` are not in `b`.
fn missing(a: &str, b: &str) -> usize {
    let mut left: Vec<&str> = b.split_inclusive('\n').collect();
    a.split_inclusive('\n')
        .filter(|line| match left.iter().position(|other| other == line) {
            Some(at) => {
                left.swap_remove(at);
                false
            }
            None => true,
        })
        .count()
}

#[test]
fn turning_one_number_changes_one_line() {
    let mut turned = 0;
    for (file, text) in corpus().into_iter().filter(|(_, text)| text.ends_with('\n')) {
        let desc = parsed(&text, &file);
        for target in all_targets(&desc) {
            for parameter in parameters(target) {
                let is_one = matches!(parameter.kind, Kind::Number { .. } | Kind::Integer { .. } | Kind::Color);
                let mut edited = desc.clone();
                if !is_one || parameter.nudge(&mut edited, &[target], 1, false).is_err() || edited == desc {
                    continue;
                }
                let saved = save(Source { text: &text, desc: &desc, file: &file }, &edited, &file).unwrap();
                // A new section or a default that is told now is one more line, or three with a blank one and a title.
                let (lost, new) = (missing(&text, &saved), missing(&saved, &text));
                assert!(lost <= 1 && new <= 3, "{} of {target:?}: {lost} {new}\n{text}\n{saved}", parameter.label);
                turned += 1;
            }
        }
    }
    assert!(turned > 1000, "{turned}");
}

fn edited(text: &str, edit: impl FnOnce(&mut SceneDesc)) -> String {
    let file = scenes().join("x.toml");
    let desc = parsed(text, &file);
    let mut edited = desc.clone();
    edit(&mut edited);
    let saved = save(Source { text, desc: &desc, file: &file }, &edited, &file).unwrap();
    assert_eq!(parsed(&saved, &file), edited);
    saved
}

#[test]
fn comments_stay_where_they_belong() {
    let text = "# Title\n\n# ball one\n[[object]] # here\nname = \"one\"\nshape = \"sphere\"   # round\n\
                translate = [1, 2.50, 3] # place\n\n# About the second.\n\n# ball two\n[[object]]\nname = \"two\"\n\
                shape = \"sphere\"\nradius = 0.50 # half\n# the end\n";
    let moved = edited(text, |desc| desc.objects[0].translate.x = 1.25);
    assert_eq!(moved, text.replace("[1, 2.50, 3]", "[1.25, 2.50, 3]"));
    let grown = edited(text, |desc| desc.objects[1].shape = ShapeDesc::Sphere { radius: 3.0 });
    assert_eq!(grown, text.replace("0.50 # half", "3.0 # half"));
    let first = edited(text, |desc| drop(desc.objects.remove(0)));
    assert_eq!(
        first,
        "# Title\n\n# About the second.\n\n# ball two\n[[object]]\nname = \"two\"\nshape = \"sphere\"\n\
         radius = 0.50 # half\n# the end\n"
    );
    let second = edited(text, |desc| drop(desc.objects.remove(1)));
    assert_eq!(
        second,
        "# Title\n\n# ball one\n[[object]] # here\nname = \"one\"\nshape = \"sphere\"   # round\n\
         translate = [1, 2.50, 3] # place\n\n# About the second.\n\n# the end\n"
    );
    let swapped = edited(text, |desc| desc.objects.swap(0, 1));
    assert_eq!(
        swapped,
        "# Title\n\n# ball two\n[[object]]\nname = \"two\"\nshape = \"sphere\"\nradius = 0.50 # half\n\n\
         # About the second.\n\n# ball one\n[[object]] # here\nname = \"one\"\nshape = \"sphere\"   # round\n\
         translate = [1, 2.50, 3] # place\n# the end\n"
    );
    let hidden = edited(text, |desc| desc.objects[0].visible = false);
    assert_eq!(hidden, text.replace("# place\n", "# place\nvisible = false\n"));
    let added = edited(text, |desc| drop(edit::duplicate(desc, &[Target::Object(1)]).unwrap()));
    assert!(added.starts_with(text.trim_end_matches("# the end\n")) && added.ends_with("# the end\n"), "{added}");
    assert!(added.contains("\n[[object]]\nname = \"three\"") || added.contains("name = \"two 2\""), "{added}");
}

#[test]
fn tables_of_one_line_stay_so_and_are_spaced_like_others() {
    let text =
        "film = { width = 9, height = 9 }\nobject = [\n    { shape = 'sphere' }, # one\n    { shape = 'cone' },\n]\n";
    let saved = edited(text, |desc| {
        desc.objects[0].visible = false;
        desc.objects.push(desc.objects[1].clone());
    });
    assert!(saved.contains("    { shape = 'sphere', visible = false }, # one\n"), "{saved}");
    assert!(saved.starts_with("film = { width = 9, height = 9 }\n"), "{saved}");
    let saved = edited("[[material]]\nname = 'a'\ntexture = { checker = ['red', 'blue'] }\n", |desc| {
        let size = parameter(Target::Material(0), "checker size").unwrap();
        size.enter(desc, &[Target::Material(0)], "0.25").unwrap();
    });
    assert_eq!(saved, "[[material]]\nname = 'a'\ntexture = { checker = ['red', 'blue'], size = 0.25 }\n");
}

#[test]
fn numbers_are_written_shortest_and_come_back_exactly() {
    let mut random = SplitMix64(9);
    for _ in 0..300 {
        let number = 10f64.powf(random.range(-11.0, 11.9)) * pick(&mut random, &[-1.0, 1.0]);
        let saved = edited("[[object]]\nshape = 'sphere'\n", |desc| desc.objects[0].translate.x = number);
        assert!(saved.contains(&format!("{number:?}")) || number.fract() == 0.0, "{number} in {saved}");
    }
    let saved =
        edited("[[object]]\nshape = 'sphere'\n", |desc| desc.objects[0].translate = DVec3::new(2.0, 0.1, -7e11));
    assert!(saved.contains("translate = [2, 0.1, -700000000000]"), "{saved}");
}

#[test]
fn the_view_height_that_follows_from_the_distance_is_told_when_the_distance_changes() {
    let saved = edited("[camera]\nprojection = 'orthographic'\n", |desc| desc.camera.position.z += 1.0);
    assert!(saved.contains("view_height = "), "{saved}");
}

#[test]
fn a_scene_without_a_file_becomes_a_whole_one_and_the_demo_keeps_its_pictures_and_comments() {
    let file = Path::new("/tmp/nowhere/new.toml");
    let desc = SceneDesc::default();
    let mut new = desc.clone();
    edit::add(&mut new, New::Sphere).unwrap();
    edit::add(&mut new, New::PointLight).unwrap();
    let text = save(Source { text: "", desc: &desc, file: Path::new("") }, &new, file).unwrap();
    assert!(text.starts_with("[film]\nwidth = 1280\nheight = 720\n\n[camera]\n"), "{text}");
    assert_eq!(parsed(&text, file), new);

    let demo_file = Path::new(crate::description::DEMO);
    let demo = std::str::from_utf8(builtin(demo_file).unwrap()).unwrap();
    let desc = parsed(demo, demo_file);
    let text = save(Source { text: demo, desc: &desc, file: demo_file }, &desc, file).unwrap();
    assert_eq!(missing(demo, &text), demo.matches("file = ").count());
    assert_eq!(parsed(&text, file), desc);
}

#[test]
fn paths_follow_the_scene_into_another_directory() {
    let root = std::env::temp_dir().join(format!("glimt-save-{}", std::process::id()));
    fs::create_dir_all(root.join("a/models")).unwrap();
    fs::create_dir_all(root.join("b/c")).unwrap();
    fs::write(root.join("a/models/m.obj"), "").unwrap();
    fs::write(root.join("a/balls.txt"), "0 0 0 1\n").unwrap();
    let text = "[[object]] # kept\nshape = 'mesh'\nfile = 'models/m.obj' # model\n[[object]]\nshape = 'spheres'\nfile = 'balls.txt'\n";
    let (from, to) = (root.join("a/s.toml"), root.join("b/c/s.toml"));
    let desc = parsed(text, &from);
    let saved = save(Source { text, desc: &desc, file: &from }, &desc, &to).unwrap();
    assert_eq!(
        saved,
        text.replace("'models/m.obj'", "\"../../a/models/m.obj\"").replace("'balls.txt'", "\"../../a/balls.txt\"")
    );
    assert_eq!(parsed(&saved, &to).objects.len(), 2);
    // A copy of spheres names the same file.
    let mut copied = desc.clone();
    edit::duplicate(&mut copied, &[Target::Object(1)]).unwrap();
    let saved = save(Source { text, desc: &desc, file: &from }, &copied, &from).unwrap();
    assert_eq!(saved.matches("file = ").count(), 3, "{saved}");
    assert_eq!(parsed(&saved, &from), copied);
    // Relative to the working directory.
    let written = |path: &str, file: &str| Directories::of(Path::new(file), Path::new(file)).written(Path::new(path));
    assert_eq!(written("scenes/models/m.obj", "scenes/s.toml").unwrap(), "models/m.obj");
    assert_eq!(written("models/m.obj", "scenes/s.toml").unwrap(), "../models/m.obj");
    assert_eq!(written("m.obj", "s.toml").unwrap(), "m.obj");
    assert_eq!(written("/elsewhere/m.obj", "/home/s.toml").unwrap(), "/elsewhere/m.obj");
    // A scene in the working directory, a file that is known by its whole path.
    let here = std::env::current_dir().unwrap().join("models/m.obj");
    assert_eq!(written(here.to_str().unwrap(), "s.toml").unwrap(), "models/m.obj");
    assert_eq!(written(here.to_str().unwrap(), "scenes/s.toml").unwrap(), "../models/m.obj");
    fs::remove_dir_all(root).unwrap();
}
