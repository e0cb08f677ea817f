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
        if matches!(change, Change::Samples(_) | Change::Error(_)) {
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
fn samples_beyond_the_usual_error_are_told_where_most_pixels_need_few_and_nowhere_else() {
    let of = |text: &str| ask(&scene(text)).into_iter().find(|advice| matches!(advice.change, Change::Error(_)));
    let view = VIEW.replace("samples = 4", "samples = 16");
    // A ball before the sky: its outline needs samples, all else one.
    let desc = scene(&format!("{view}{WASTE}"));
    let found = of(&format!("{view}{WASTE}")).expect("much is smooth");
    assert!(found.rays > 0.1 && found.rmse < 0.5, "{found:?}");
    let mut edited = desc.clone();
    found.change.apply(&mut edited);
    assert_eq!((edited.render.error, edited.render.samples), (Some(0.5), 16));
    // It saves what it says, and the error of the picture stays below the target.
    let count = |desc: &SceneDesc| {
        let scene = Arc::new(compile(desc, None).unwrap());
        let render = start(scene, Settings::default());
        let rays = |event| if let RenderEvent::TileFinished { stats, .. } = event { stats.rays.total() } else { 0 };
        render.events().iter().map(rays).sum::<u64>()
    };
    let saved = 1.0 - count(&edited) as f64 / count(&desc) as f64;
    assert!((saved - found.rays).abs() < 0.05, "{saved} of {}", found.rays);
    // Edges everywhere: 16 samples are not enough anywhere. (Not in black, which with an error to reach asks for no
    // shadow rays.)
    let edges = "[[material]]\nname = \"check\"\ntexture = { checker = [\"#303030\", \"white\"], size = 0.002 }\n\
                 [[object]]\nshape = \"plane\"\nmaterial = \"check\"\n";
    let steep = view.replace("position = [0, 1.5, 6]", "position = [0, 6, 0.1]");
    assert_eq!(of(&format!("{steep}{edges}")), None);
    // Who asks for an error or for few samples gets what is asked for.
    assert_eq!(of(&format!("{VIEW}{WASTE}")), None);
    assert_eq!(of(&format!("{}{WASTE}", view.replace("samples = 16", "samples = 16\nerror = 0.1"))), None);
}

#[test]
fn a_mesh_of_triangles_below_a_tenth_of_a_pixel_becomes_a_coarser_one_and_a_near_one_does_not() {
    let directory = std::env::temp_dir().join(format!("glimt-advice-coarse-{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    let file = directory.join("egg.obj");
    // Blunt below and pointed above: no ball.
    let pointed = |line: &str| match line.strip_prefix("v ").map(|v| v.split(' ').map(str::parse).map(Result::unwrap)) {
        Some(v) => {
            let [x, y, z]: [f64; 3] = v.collect::<Vec<_>>().try_into().unwrap();
            format!("v {x} {} {z}\n", if y > 0.0 { 1.8 * y } else { y })
        }
        None => format!("{line}\n"),
    };
    fs::write(&file, ball_obj(96).lines().map(pointed).collect::<String>()).unwrap();
    let text = |scale: f64, more: &str| {
        format!(
            "{VIEW}[[material]]\nname = \"paint\"\n{more}[[object]]\nname = \"egg\"\nshape = \"mesh\"\nfile = \"egg.obj\"\n\
             material = \"paint\"\nscale = [{scale}, {}, {scale}]\ntranslate = [{}, 0.5, 0]\n[[object]]\nshape = \"plane\"\n",
            scale,
            -3.0 * scale
        )
    };
    let read = |text: &str| parse(text, &directory.join("s.toml")).unwrap_or_else(|m| panic!("{}", m[0].render(false)));
    let of = |desc: &SceneDesc| ask(desc).into_iter().find(|advice| matches!(advice.change, Change::Coarsen(..)));
    let desc = read(&text(0.4, ""));
    let found = of(&desc).expect("far too many triangles");
    assert!(found.rmse < 0.5, "{found:?}");
    // Nothing is written before it is taken, and nothing is left of the trial.
    assert_eq!(fs::read_dir(&directory).unwrap().count(), 1);
    let model = found.change.model().unwrap().clone();
    assert_eq!(model.file, directory.join("egg-coarse.obj"));
    fs::write(&model.file, &model.text).unwrap();
    let mut edited = desc.clone();
    found.change.apply(&mut edited);
    let triangles = |desc: &SceneDesc| compile(desc, None).unwrap().summary.triangles;
    assert!(triangles(&edited) * 2 <= triangles(&desc) && triangles(&edited) > 100, "{}", triangles(&edited));
    // The picture is what it was, nearly: the corners have moved by half a pixel at most.
    let (before, after) = (render(&desc), render(&edited));
    let code = |c: f32| 255.0 * linear_to_srgb(f64::from(c));
    let pairs = || before.pixels().iter().flatten().zip(after.pixels().iter().flatten());
    let sum: f64 = pairs().map(|(a, b)| (code(*a) - code(*b)).powi(2)).sum();
    assert!((sum / pairs().count() as f64).sqrt() < 1.0);
    // A file that is there is not written over; near, of glass or with a texture it stays as it is.
    let again = of(&desc).unwrap();
    assert_eq!(again.change.model().unwrap().file, directory.join("egg-coarse2.obj"));
    let near = text(0.4, "").replace("width = 160\nheight = 90", "width = 1600\nheight = 900");
    for (what, text) in [
        ("near", near),
        ("glass", text(0.4, "transmit = 0.5\n")),
        ("checked", text(0.4, "texture = { checker = [\"red\", \"blue\"], size = 0.1 }\n")),
    ] {
        assert_eq!(of(&read(&text)), None, "{what}");
    }
    fs::remove_dir_all(&directory).unwrap();
}

#[test]
fn asked_to_stop_it_stops() {
    let desc = scene(&format!("{VIEW}{WASTE}"));
    let compiled = compile(&desc, None).unwrap();
    let stopped = advise(&desc, &compiled, Settings::default(), &|| true);
    assert_eq!(stopped, Err(glimt::advice::Failure::Stopped));
}
