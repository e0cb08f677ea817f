//! The adviser: what it finds in scenes made for it, what it must not find, and whether what it says is true.

use glimt::advice::{Advice, Change, advise};
use glimt::description::{SceneDesc, ShapeDesc, parse};
use glimt::math::linear_to_srgb;
use glimt::render::{Film, RenderEvent, Settings, start};
use glimt::scene::compile;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

fn scene(text: &str) -> SceneDesc {
    parse(text, Path::new("/nowhere/scene.toml")).unwrap_or_else(|mistakes| panic!("{}", mistakes[0].render(false)))
}

fn ask(desc: &SceneDesc) -> Vec<Advice> {
    advise(desc, &compile(desc, None).unwrap(), Settings::default(), &|| false).unwrap()
}

fn render(desc: &SceneDesc) -> Film {
    let scene = Arc::new(compile(desc, None).unwrap());
    let mut film = Film::new(scene.width, scene.height);
    for event in start(scene, Settings::default()).events() {
        if let RenderEvent::TileFinished { tile, .. } = event {
            film.write(&tile);
        }
    }
    film
}

const VIEW: &str = "
[film]
width = 160
height = 90
[camera]
position = [0, 1.5, 6]
look_at = [0, 0.5, 0]
[render]
samples = 4
max_depth = 6
[[light]]
name = \"key\"
position = [3, 5, 4]
";

/// In the ball there are a light and a box with a texture.
const WASTE: &str = "
[[light]]
name = \"buried\"
position = [0, 0.5, 0.2]
[[material]]
name = \"plain\"
[[material]]
name = \"papered\"
texture = { checker = [\"red\", \"blue\"], size = 0.1 }
[[object]]
name = \"ball\"
shape = \"sphere\"
radius = 0.5
translate = [0, 0.5, 0]
material = \"plain\"
[[object]]
name = \"inner\"
shape = \"cuboid\"
size = [0.2, 0.2, 0.2]
translate = [0, 0.5, 0]
material = \"papered\"
[[object]]
shape = \"plane\"
material = \"plain\"
";

#[test]
fn what_is_buried_in_a_ball_is_not_needed_and_what_is_seen_is() {
    let desc = scene(&format!("{VIEW}{WASTE}"));
    let found = ask(&desc);
    let changes: Vec<_> = found.iter().map(|advice| &advice.change).collect();
    for expected in [Change::Depth(0), Change::HideLight(1), Change::HideObjects(vec![1]), Change::RemoveTexture(1)] {
        assert!(changes.contains(&&expected), "{expected:?} in {changes:?}");
    }
    for change in changes {
        // The shadow of the ball is seen, and it is lit by the other light.
        assert!(!matches!(change, Change::HideLight(0) | Change::Shading(_)), "{change:?}");
        assert!(!matches!(change, Change::HideObjects(objects) if objects != &[1]), "{change:?}");
    }
    let light = found.iter().find(|advice| advice.change == Change::HideLight(1)).unwrap();
    assert!(light.rays > 0.1, "a light less is a shadow ray less: {light:?}");
}

#[test]
fn what_is_advised_changes_the_picture_as_little_as_it_is_said_to() {
    let desc = scene(&format!("{VIEW}{WASTE}"));
    let before = render(&desc);
    for Advice { change, .. } in ask(&desc) {
        if matches!(change, Change::Samples(_)) {
            continue;
        }
        let mut edited = desc.clone();
        change.apply(&mut edited);
        assert_ne!(edited, desc, "{change:?} changes something");
        let after = render(&edited);
        for (a, b) in before.pixels().iter().flatten().zip(after.pixels().iter().flatten()) {
            let apart = 255.0 * (linear_to_srgb(f64::from(*a)) - linear_to_srgb(f64::from(*b))).abs();
            assert!(apart < 0.5, "{change:?}: {apart}");
        }
    }
}

#[test]
fn mirrors_that_face_each_other_need_the_depth_in_which_they_are_seen() {
    let mirrors = "
[[material]]
name = \"mirror\"
diffuse = 0.2
reflect = 0.8
[[object]]
shape = \"sphere\"
radius = 0.8
translate = [-0.9, 0.8, 0]
material = \"mirror\"
[[object]]
shape = \"sphere\"
radius = 0.8
translate = [0.9, 0.8, 0]
material = \"mirror\"
[[object]]
shape = \"plane\"
";
    let found = ask(&scene(&format!("{VIEW}{mirrors}")));
    for Advice { change, .. } in &found {
        assert!(!matches!(change, Change::Shading(_) | Change::Depth(0..=2)), "{change:?}");
    }
}

/// A ball of `2 * n * n` triangles.
fn ball_obj(n: usize) -> String {
    let mut text = String::new();
    for i in 0..=n {
        for j in 0..2 * n {
            let (polar, around) = (i as f64 / n as f64, j as f64 / n as f64);
            let (polar, around) = (polar * std::f64::consts::PI, around * std::f64::consts::PI);
            let [x, y, z] = [polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin()];
            writeln!(text, "v {} {} {}", 3.0 + x, y, z).unwrap();
        }
    }
    for i in 0..n {
        for j in 0..2 * n {
            let at = |i: usize, j: usize| 1 + i * 2 * n + j % (2 * n);
            writeln!(text, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)).unwrap();
        }
    }
    text
}

#[test]
fn a_mesh_that_is_a_ball_or_a_box_becomes_one_and_a_coarse_one_does_not() {
    let directory = std::env::temp_dir().join(format!("glimt-advice-{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    let cube = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let roof = "v -1 -1 -1\nv 1 -1 -1\nv 0 1 -1\nv -1 -1 1\nv 1 -1 1\nv 0 1 1\n\
                f 3 2 1\nf 4 5 6\nf 1 2 5 4\nf 2 3 6 5\nf 3 1 4 6\n";
    let advised = |name: &str, obj: &str| {
        fs::write(directory.join(name), obj).unwrap();
        let object = format!(
            "{VIEW}[[material]]\nname = \"paint\"\n[[object]]\nshape = \"mesh\"\nfile = \"{name}\"\n\
             material = \"paint\"\nscale = 0.5\nrotate = [0, 30, 0]\ntranslate = [0, 0.7, 0]\n"
        );
        let desc = parse(&object, &directory.join("scene.toml")).unwrap_or_else(|m| panic!("{}", m[0].render(false)));
        ask(&desc).into_iter().find_map(|advice| match advice.change {
            Change::Replace(0, object) => Some((*object, advice.rmse)),
            _ => None,
        })
    };
    let (ball, rmse) = advised("ball.obj", &ball_obj(96)).expect("a ball");
    let ShapeDesc::Sphere { radius } = ball.shape else { panic!("{:?}", ball.shape) };
    assert!((radius - 1.0).abs() < 1e-3, "{radius}");
    // The middle of the model is at (3, 0, 0) in its file: turned by 30 degrees, scaled and moved with it.
    let middle = glam::DVec3::new(1.5 * 30f64.to_radians().cos(), 0.7, -1.5 * 30f64.to_radians().sin());
    assert!(ball.translate.distance(middle) < 1e-3, "{}", ball.translate);
    assert!(rmse < 2.0, "{rmse}");
    let (cuboid, rmse) = advised("cube.obj", cube).expect("a box");
    assert!(matches!(cuboid.shape, ShapeDesc::Cuboid { size } if size.distance(glam::DVec3::splat(2.0)) < 1e-6));
    assert!(rmse < 0.1, "{rmse}");
    assert_eq!(advised("coarse.obj", &ball_obj(6)), None);
    assert_eq!(advised("roof.obj", roof), None);
    fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn asked_to_stop_it_stops() {
    let desc = scene(&format!("{VIEW}{WASTE}"));
    let compiled = compile(&desc, None).unwrap();
    let stopped = advise(&desc, &compiled, Settings::default(), &|| true);
    assert_eq!(stopped, Err(glimt::advice::Failure::Stopped));
}
