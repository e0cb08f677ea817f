//! What an edited scene is compiled from, read from the disk, and picked.

mod support;

use glimt::description::edit::{self, New};
use glimt::description::*;
use glimt::math::SplitMix64;
use glimt::scene::{Scene, Shape, compile, recompile};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use support::{desc, orthographic, v};

/// A directory with a scene, a model with a library and a picture in it, and another picture.
fn directory(name: &str) -> PathBuf {
    let directory = std::env::temp_dir().join(format!("glimt-edit-{name}-{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    fs::write(directory.join("a.mtl"), "newmtl red\nKd 1 0 0\nmap_Kd a.png\n").unwrap();
    fs::write(directory.join("a.obj"), model(1.0)).unwrap();
    for picture in ["a.png", "b.png"] {
        paint(&directory.join(picture), [255, 0, 0]);
    }
    fs::write(directory.join("s.toml"), SCENE).unwrap();
    directory
}

const SCENE: &str = "[[material]]\nname = 'm'\ntexture = { file = 'b.png' }\n[[object]]\nshape = 'mesh'\nfile = 'a.obj'\n\
                     [[object]]\nshape = 'sphere'\nmaterial = 'm'\ntranslate = [3, 0, 0]\n[[light]]\n";

fn model(size: f64) -> String {
    format!("mtllib a.mtl\nv 0 0 0\nv {size} 0 0\nv 0 {size} 0\nusemtl red\nf 1 2 3\n")
}

fn paint(file: &Path, color: [u8; 3]) {
    image::RgbImage::from_pixel(2, 2, image::Rgb(color)).save(file).unwrap();
}

fn read(directory: &Path) -> SceneDesc {
    let file = directory.join("s.toml");
    parse(&fs::read_to_string(&file).unwrap(), &file).unwrap()
}

/// The meshes that a scene holds.
fn meshes(scene: &Scene) -> Vec<Arc<glimt::scene::Mesh>> {
    let mesh = |shape: &Shape| if let Shape::Mesh(mesh) = shape { Some(mesh.clone()) } else { None };
    scene.objects().iter().filter_map(|object| mesh(&object.shape)).collect()
}

#[test]
fn edits_of_what_is_loaded_read_no_file_and_share_what_is_unchanged() {
    let directory = directory("share");
    let desc = read(&directory);
    let first = compile(&desc, None).unwrap();
    // Whoever reads a file now, fails.
    fs::remove_dir_all(&directory).unwrap();
    let mut scene = first.clone();
    let mut edited = desc.clone();
    type Change = Box<dyn FnMut(&mut SceneDesc)>;
    let mut changes: Vec<(&str, Change)> = vec![
        ("camera", Box::new(|desc| desc.camera.position.x += 1.0)),
        ("light", Box::new(|desc| desc.lights[0].intensity *= 0.5)),
        ("material", Box::new(|desc| desc.materials[0].reflect = 0.5)),
        ("wrap", Box::new(|desc| desc.objects[1].name = "ball".into())),
        ("assign", Box::new(|desc| edit::assign(desc, &[Target::Object(0)], Some(0)).unwrap())),
        ("world", Box::new(|desc| desc.world.ior = 1.3)),
        ("film", Box::new(|desc| desc.film.width = 100)),
    ];
    for (what, change) in &mut changes {
        change(&mut edited);
        let next = compile(&edited, Some(&scene)).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(std::ptr::eq(next.objects(), scene.objects()), "{what} rebuilt the objects");
        scene = next;
    }
    // Moved, hidden, copied, removed: the mesh stays the same one.
    for step in 0..5 {
        match step {
            0 => edited.objects[0].translate.x += 1.0,
            1 => edited.objects[0].visible = false,
            2 => edited.objects[0].visible = true,
            3 => drop(edit::duplicate(&mut edited, &[Target::Object(0)]).unwrap()),
            _ => edit::delete(&mut edited, &[Target::Object(0)]).unwrap(),
        }
        scene = compile(&edited, Some(&scene)).unwrap();
        let found = meshes(&scene);
        assert_eq!(found.len(), [1, 0, 1, 2, 1][step], "step {step}");
        assert!(found.iter().all(|mesh| Arc::ptr_eq(mesh, &meshes(&first)[0])), "step {step}");
    }
    assert!(compile(&desc, None).is_err(), "the files are gone");
}

#[test]
fn of_changed_files_only_those_are_read_again_and_a_broken_one_leaves_the_old_scene_alive() {
    let directory = directory("reload");
    let desc = read(&directory);
    let scene = compile(&desc, None).unwrap();
    let [obj, mtl, a, b] = ["a.obj", "a.mtl", "a.png", "b.png"].map(|name| directory.join(name));
    assert_eq!(scene.files().into_iter().collect::<Vec<_>>(), [mtl.clone(), obj.clone(), a.clone(), b.clone()]);
    let named = files_named(SCENE, &directory.join("s.toml"));
    assert_eq!(named, [directory.join("s.toml"), obj.clone(), b.clone()]);
    assert_eq!(files_named("[[object]]\nfile = 'x.obj'\nnonsense", Path::new("d/s.toml")).len(), 2);

    // Unheard of, nothing changes.
    fs::write(&obj, model(2.0)).unwrap();
    assert!(Arc::ptr_eq(&meshes(&compile(&desc, Some(&scene)).unwrap())[0], &meshes(&scene)[0]));
    let larger = recompile(&desc, &scene, std::slice::from_ref(&obj)).unwrap();
    assert_eq!(meshes(&larger)[0].bounds().upper.x - meshes(&larger)[0].bounds().lower.x, 2.0);
    // A library is part of the model, a picture is not.
    fs::write(&mtl, "newmtl red\nKd 0 1 0\n").unwrap();
    let green = recompile(&desc, &larger, std::slice::from_ref(&mtl)).unwrap();
    assert_eq!(meshes(&green)[0].materials[0].color, parse_color("lime").unwrap());
    assert!(!Arc::ptr_eq(&meshes(&green)[0], &meshes(&larger)[0]));
    paint(&b, [0, 0, 255]);
    let blue = recompile(&desc, &green, std::slice::from_ref(&b)).unwrap();
    assert!(Arc::ptr_eq(&meshes(&blue)[0], &meshes(&green)[0]));
    assert_eq!(blue.materials[0].color(|| glam::DVec2::splat(0.5)), parse_color("blue").unwrap());

    fs::write(&obj, "f 1 2 3\n").unwrap();
    let error = recompile(&desc, &blue, std::slice::from_ref(&obj)).unwrap_err();
    assert!(error.to_string().contains("a.obj:1"), "{error}");
    assert_eq!(error.place().0, Target::Object(0));
    fs::write(&obj, model(3.0)).unwrap();
    assert!(recompile(&desc, &blue, &[obj]).is_ok());
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn a_hidden_object_is_met_by_no_ray_and_a_hidden_light_does_not_shine() {
    let text = "[[object]]\nshape = 'sphere'\nvisible = false\n[[object]]\nshape = 'cuboid'\n[[light]]\nvisible = false\n\
                [[light]]\nintensity = 0.25\n";
    let desc = parse(text, Path::new("s.toml")).unwrap();
    let scene = compile(&desc, None).unwrap();
    assert_eq!((scene.objects().len(), scene.lights.len()), (1, 1));
    assert_eq!(scene.objects()[0].source, 1, "hits name the entry of the description");
    assert_eq!(scene.lights[0].radiance.r, 0.25);
}

#[test]
fn a_picked_pixel_names_the_object_and_the_material_that_its_ray_meets() {
    // Looking down -z at 10 x 10 units on 20 x 20 pixels: pixel (x, y) is at ((x + 0.5) / 2 - 5, 5 - (y + 0.5) / 2).
    let mut desc = desc(20, 20, orthographic(v(0.0, 0.0, 20.0), v(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), 10.0));
    let mut random = SplitMix64(77);
    for name in ["a", "b", "c"] {
        desc.materials.push(MaterialDesc { name: name.into(), ..MaterialDesc::default() });
    }
    for index in 0..12 {
        let shape = match index % 3 {
            0 => ShapeDesc::Cuboid { size: v(1.0, 1.5, 1.0) },
            // A group is one entry, however many spheres it has.
            1 => ShapeDesc::Spheres { data: [[0.0, 0.0, 0.0, 0.6], [1.0, 0.0, 0.0, 0.6]].into() },
            _ => ShapeDesc::Sphere { radius: 0.7 },
        };
        let translate = v(random.range(-4.0, 4.0), random.range(-4.0, 4.0), random.range(-3.0, 3.0));
        let material = [None, Some("a"), Some("b"), Some("c")][index % 4].map(str::to_owned);
        desc.objects.push(ObjectDesc { translate, material, visible: index != 5, ..ObjectDesc::new(shape) });
    }
    let nearest = |x: f64, y: f64| {
        let ball = |cx: f64, cy: f64, cz: f64, r: f64| {
            let d = r * r - (x - cx).powi(2) - (y - cy).powi(2);
            (d >= 0.0).then(|| cz + d.sqrt())
        };
        let depth = |o: &ObjectDesc| {
            let t = o.translate;
            match &o.shape {
                ShapeDesc::Cuboid { size } => {
                    ((x - t.x).abs() <= size.x / 2.0 && (y - t.y).abs() <= size.y / 2.0).then_some(t.z + size.z / 2.0)
                }
                ShapeDesc::Spheres { data } => {
                    data.iter().filter_map(|s| ball(t.x + s[0], t.y + s[1], t.z + s[2], s[3])).max_by(f64::total_cmp)
                }
                _ => ball(t.x, t.y, t.z, 0.7),
            }
        };
        let seen = desc.objects.iter().enumerate().filter(|(_, o)| o.visible);
        seen.filter_map(|(index, o)| Some((index, depth(o)?))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    for numerics in Numerics::NAMES.iter().map(|(_, numerics)| *numerics) {
        let mut desc = desc.clone();
        desc.render.numerics = numerics;
        let scene = compile(&desc, None).unwrap();
        let mut met = 0;
        for (x, y) in (0..20).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let expected = nearest((f64::from(x) + 0.5) / 2.0 - 5.0, 5.0 - (f64::from(y) + 0.5) / 2.0);
            let pick = scene.pick(x, y);
            assert_eq!(pick.map(|p| p.object), expected.map(|e| e.0), "({x}, {y})");
            let (Some(pick), Some((object, z))) = (pick, expected) else { continue };
            assert_eq!(pick.material, [None, Some(0), Some(1), Some(2)][object % 4]);
            // In f32, a sphere of radius 0.6 that is 20 away is met to within a few hundredths at its rim.
            let slack = if matches!(numerics, Numerics::Classic | Numerics::Fast) { 0.05 } else { 1e-6 };
            assert!((pick.point.z - z).abs() < slack, "{} is not {z}", pick.point.z);
            met += 1;
        }
        assert!(met > 50, "{met}");
        assert_eq!((scene.pick(20, 0), scene.pick(0, 20)), (None, None));
    }
}

#[test]
fn everything_that_can_be_added_compiles_and_is_in_the_picture() {
    let file = Path::new(DEMO);
    let desc = parse(std::str::from_utf8(builtin(file).unwrap()).unwrap(), file).unwrap();
    for new in [New::Sphere, New::Cuboid, New::Cylinder, New::Cone, New::Quad] {
        let mut edited = desc.clone();
        // Alone with the camera, so that nothing is in front of it.
        edited.objects.clear();
        let Ok(Target::Object(index)) = edit::add(&mut edited, new.clone()) else { panic!() };
        let scene = compile(&edited, None).unwrap();
        let seen = (0..edited.film.height).step_by(8).filter(|y| {
            (0..edited.film.width).step_by(8).any(|x| scene.pick(x, *y).is_some_and(|pick| pick.object == index))
        });
        // A quad is seen from the side.
        let least = if new == New::Quad { 1 } else { (edited.film.height / 8 / 6) as usize };
        assert!(seen.count() >= least, "{new:?}");
    }
}

/// Objects that stay in place are not placed again: that must not be seen in the picture, whatever was edited before.
#[test]
fn the_picture_of_an_edited_scene_is_that_of_the_same_scene_loaded_anew() {
    let mut random = SplitMix64(11);
    let mut desc = desc(24, 16, orthographic(v(0.0, 2.0, 6.0), v(0.0, 0.0, 0.0), v(0.0, 1.0, 0.0), 4.0));
    desc.render.samples = 1;
    desc.lights.push(LightDesc::default());
    desc.materials.push(MaterialDesc { name: "glass".into(), transmit: 0.8, diffuse: 0.2, ..MaterialDesc::default() });
    let flake: Vec<[f64; 4]> = (0..200).map(|_| [(); 4].map(|()| random.range(0.02, 1.0))).collect();
    desc.objects.push(ObjectDesc::new(ShapeDesc::Plane));
    desc.objects.push(ObjectDesc::new(ShapeDesc::Spheres { data: flake.into() }));
    for new in [New::Sphere, New::Cuboid, New::Cylinder, New::Cone, New::Quad, New::Sphere] {
        edit::add(&mut desc, new).unwrap();
    }
    desc.objects[2].material = Some("glass".into());
    let mut scene = compile(&desc, None).unwrap();
    for step in 0..60 {
        let at = (random.next_u64() % desc.objects.len() as u64) as usize;
        let target = [Target::Object(at)];
        match random.next_u64() % 7 {
            0 | 1 => desc.objects[at].translate.x += random.range(-0.5, 0.5),
            2 => desc.objects[at].visible ^= true,
            3 => drop(edit::duplicate(&mut desc, &target).unwrap()),
            4 if desc.objects.len() > 4 => edit::delete(&mut desc, &target).unwrap(),
            5 => drop(edit::move_by(&mut desc, target[0], 2).unwrap()),
            _ => desc.objects[at].rotate.y += 10.0,
        }
        scene = compile(&desc, Some(&scene)).unwrap();
        let film = |scene: Scene| {
            let render = glimt::render::start(Arc::new(scene), support::settings(1, 32));
            support::finish(render, 24, 16).hash()
        };
        assert_eq!(film(scene.clone()), film(compile(&desc, None).unwrap()), "step {step}: {:#?}", desc.objects[at]);
    }
}
