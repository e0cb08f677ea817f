//! What good scenes mean, and that bad ones do no harm.

use super::*;
use crate::description::*;
use crate::math::{Rgb, SplitMix64, srgb_to_linear};
use glam::{DVec2, DVec3};
use std::fs;
use std::path::PathBuf;

/// A directory of this test process with the files that the example names.
fn example_directory(name: &str) -> PathBuf {
    let directory = std::env::temp_dir().join(format!("glimt-parse-{name}-{}", std::process::id()));
    fs::create_dir_all(directory.join("textures")).unwrap();
    fs::create_dir_all(directory.join("models")).unwrap();
    fs::write(directory.join("textures/fence.png"), "").unwrap();
    fs::write(directory.join("models/knot.obj"), "").unwrap();
    fs::write(directory.join("balls.csv"), "# three\n0, 0, 0, 0.5\n1 2 3 0.25 # small\n\n-1,\t0,1e-1, 1\r\n").unwrap();
    directory
}

fn parsed(text: &str) -> SceneDesc {
    parse(text, Path::new("scene.toml")).unwrap_or_else(|mistakes| panic!("{}", mistakes[0].render(false)))
}

const EXAMPLE: &str = r##"
[film]
width = 1280
height = 720
[camera]
position = [3, 2, 5]
look_at = [0, 0.5, 0]
up = [0, 1, 0]
fov = 40                      # vertical, degrees
[world]
ambient = "#ffffff"           # I_a
background = { top = "#87a9d8", bottom = "#f0f0f0" }
ior = 1.0
[render]
shading = "whitted"           # lambert | phong | whitted
max_depth = 8
samples = 16
shadows = "opaque"            # opaque | filtered
[[light]]
kind = "point"                # point | directional
position = [4, 6, 3]
color = "white"
intensity = 0.8
falloff = "none"              # none | inverse-square
[[material]]
name = "glass"
color = "violet"
ambient = 0.1
diffuse = 0.1
specular = 0.6
shininess = 80
reflect = 0.1
transmit = 0.8
ior = 1.3
[[material]]
name = "fence"
texture = { file = "textures/fence.png", scale = [2, 1], wrap = "repeat" }
[[object]]
name = "ball"
shape = "sphere"              # sphere | cuboid | cylinder | cone | plane | quad | mesh
radius = 0.5
material = "glass"
translate = [0, 0.5, 0]
rotate = [0, 30, 0]           # degrees, about x, then y, then z
scale = [1, 2, 1]
[[material]]
name = "floor"
texture = { checker = ["#d9d9d9", "#1f2659"], size = 0.8 }
[[object]]
shape = "mesh"
file = "models/knot.obj"
[[object]]
shape = "spheres"             # many at once: inline or from a file of x,y,z,r lines
data = [[0, 0, 0, 0.5], [0.27, 0.27, 0.54, 0.1667]]
material = "fence"
"##;

#[test]
fn the_example_of_the_issue_means_what_it_says() {
    let directory = example_directory("example");
    let scene = parse(EXAMPLE, &directory.join("scene.toml")).unwrap();
    let rgb = |r: u8, g: u8, b: u8| {
        let [r, g, b] = [r, g, b].map(|code| srgb_to_linear(f64::from(code) / 255.0));
        Rgb::new(r, g, b)
    };
    let expected = SceneDesc {
        film: FilmDesc { width: 1280, height: 720 },
        camera: CameraDesc {
            position: DVec3::new(3.0, 2.0, 5.0),
            look_at: DVec3::new(0.0, 0.5, 0.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov: 40.0 },
        },
        world: WorldDesc {
            ambient: Rgb::WHITE,
            background: Background::Gradient { top: rgb(0x87, 0xa9, 0xd8), bottom: rgb(0xf0, 0xf0, 0xf0) },
            ior: 1.0,
        },
        render: RenderDesc {
            shading: Shading::Whitted,
            max_depth: 8,
            samples: 16,
            error: None,
            filter: Filter::Box,
            shadows: Shadows::Opaque,
            numerics: Numerics::Robust,
        },
        lights: vec![LightDesc {
            name: String::new(),
            kind: LightKind::Point { position: DVec3::new(4.0, 6.0, 3.0), falloff: Falloff::None },
            color: Rgb::WHITE,
            intensity: 0.8,
            visible: true,
        }],
        materials: vec![
            MaterialDesc {
                name: "glass".into(),
                color: rgb(238, 130, 238),
                ambient: 0.1,
                diffuse: 0.1,
                specular: 0.6,
                shininess: 80.0,
                reflect: 0.1,
                transmit: 0.8,
                ior: 1.3,
                ..MaterialDesc::default()
            },
            MaterialDesc {
                name: "fence".into(),
                texture: Some(TextureDesc {
                    source: TextureSource::Image { file: directory.join("textures/fence.png"), wrap: Wrap::Repeat },
                    scale: DVec2::new(2.0, 1.0),
                    offset: DVec2::ZERO,
                }),
                ..MaterialDesc::default()
            },
            MaterialDesc {
                name: "floor".into(),
                texture: Some(TextureDesc {
                    source: TextureSource::Checker {
                        colors: [rgb(0xd9, 0xd9, 0xd9), rgb(0x1f, 0x26, 0x59)],
                        size: 0.8,
                    },
                    scale: DVec2::ONE,
                    offset: DVec2::ZERO,
                }),
                ..MaterialDesc::default()
            },
        ],
        objects: vec![
            ObjectDesc {
                name: "ball".into(),
                material: Some("glass".into()),
                translate: DVec3::new(0.0, 0.5, 0.0),
                rotate: DVec3::new(0.0, 30.0, 0.0),
                scale: DVec3::new(1.0, 2.0, 1.0),
                ..ObjectDesc::new(ShapeDesc::Sphere { radius: 0.5 })
            },
            ObjectDesc::new(ShapeDesc::Mesh { file: directory.join("models/knot.obj"), crease: 30.0 }),
            ObjectDesc {
                material: Some("fence".into()),
                ..ObjectDesc::new(ShapeDesc::Spheres {
                    data: [[0.0, 0.0, 0.0, 0.5], [0.27, 0.27, 0.54, 0.1667]].into(),
                })
            },
        ],
    };
    assert_eq!(scene, expected);
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn an_empty_file_is_the_default_scene() {
    for text in ["", "\n", "# nothing\n", "\u{feff}", "[film]\n[camera]\n[world]\n[render]\n", "\u{feff}[film]\r\n"] {
        assert_eq!(parsed(text), SceneDesc::default(), "{text:?}");
    }
}

#[test]
fn every_key_that_is_left_out_has_its_default() {
    let scene = parsed("[[light]]\n[[material]]\nname = 'm'\n[[object]]\nshape = 'sphere'\n");
    assert_eq!(scene.lights, [LightDesc::default()]);
    assert_eq!(scene.materials, [MaterialDesc { name: "m".into(), ..MaterialDesc::default() }]);
    let shapes = [
        ("sphere", ShapeDesc::Sphere { radius: 0.5 }),
        ("cuboid", ShapeDesc::Cuboid { size: DVec3::ONE }),
        ("cylinder", ShapeDesc::Cylinder { radius: 0.5, height: 1.0 }),
        ("cone", ShapeDesc::Cone { radius: 0.5, height: 1.0 }),
        ("plane", ShapeDesc::Plane),
        ("quad", ShapeDesc::Quad { size: DVec2::ONE }),
    ];
    for (name, shape) in shapes {
        let scene = parsed(&format!("[[object]]\nshape = '{name}'"));
        assert_eq!(scene.objects, [ObjectDesc::new(shape)]);
    }
    let texture = |inside: &str| {
        let scene = parsed(&format!("[[material]]\nname = 'm'\ntexture = {{ {inside} }}"));
        scene.materials[0].texture.clone().unwrap()
    };
    let checker = TextureSource::Checker { colors: [Rgb::BLACK, Rgb::WHITE], size: 1.0 };
    let expected = TextureDesc { source: checker, scale: DVec2::ONE, offset: DVec2::ZERO };
    assert_eq!(texture("checker = ['black', 'white']"), expected);
    let scaled = TextureDesc { scale: DVec2::splat(-2.0), offset: DVec2::new(0.5, -1.0), ..expected };
    assert_eq!(texture("checker = ['black', 'white'], scale = -2, offset = [0.5, -1]"), scaled);
}

#[test]
fn every_default_written_out_is_the_default() {
    let text = r##"
        [film]
        width = 1280
        height = 720
        [camera]
        position = [3, 2, 5]
        look_at = [0, 0, 0]
        up = [0, 1, 0]
        projection = "perspective"
        fov = 40
        [world]
        ambient = [1, 1, 1]
        background = "#000"
        ior = 1
        [render]
        shading = "whitted"
        max_depth = 8
        samples = 16
        shadows = "opaque"
        numerics = "robust"
        [[light]]
        kind = "point"
        position = [4, 6, 3]
        falloff = "none"
        color = "white"
        intensity = 1
        [[material]]
        name = "m"
        color = [0.6, 0.6, 0.6]
        ambient = 0.1
        diffuse = 0.8
        specular = 0.2
        shininess = 32
        reflect = 0
        transmit = 0
        ior = 1.5
        fresnel = false
        priority = 0
    "##;
    let expected = SceneDesc {
        lights: vec![LightDesc::default()],
        materials: vec![MaterialDesc { name: "m".into(), ..MaterialDesc::default() }],
        ..SceneDesc::default()
    };
    assert_eq!(parsed(text), expected);
}

#[test]
fn every_choice_is_read() {
    let render = |key: &str, value: &str| parsed(&format!("[render]\n{key} = '{value}'")).render;
    assert_eq!(render("shading", "lambert").shading, Shading::Lambert);
    assert_eq!(render("shading", "phong").shading, Shading::Phong);
    assert_eq!(render("shadows", "filtered").shadows, Shadows::Filtered);
    assert_eq!(render("numerics", "classic").numerics, Numerics::Classic);
    assert_eq!(render("numerics", "fast").numerics, Numerics::Fast);
    assert_eq!(render("numerics", "reference").numerics, Numerics::Reference);

    let light = |text: &str| parsed(&format!("[[light]]\n{text}")).lights[0].kind;
    assert_eq!(
        light("kind = 'directional'\ndirection = [0, -1, 0.5]"),
        LightKind::Directional { direction: DVec3::new(0.0, -1.0, 0.5) }
    );
    let LightKind::Point { falloff, .. } = light("falloff = 'inverse-square'") else { panic!() };
    assert_eq!(falloff, Falloff::InverseSquare);

    let camera = |text: &str| parsed(&format!("[camera]\n{text}")).camera;
    let orthographic = |view_height| Projection::Orthographic { view_height };
    assert_eq!(camera("projection = 'orthographic'\nview_height = 3").projection, orthographic(3.0));
    // What a perspective camera with the default angle shows at the distance of `look_at`, here 10.
    let default = camera("projection = 'orthographic'\nposition = [0, 0, 10]").projection;
    assert_eq!(default, orthographic(20.0 * 20f64.to_radians().tan()));

    let directory = example_directory("choices");
    for (name, wrap) in [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)] {
        let text = format!("[[material]]\nname = 'm'\ntexture = {{ file = 'textures/fence.png', wrap = '{name}' }}");
        let scene = parse(&text, &directory.join("scene.toml")).unwrap();
        let Some(TextureSource::Image { wrap: found, .. }) = scene.materials[0].texture.clone().map(|t| t.source)
        else {
            panic!()
        };
        assert_eq!(found, wrap);
    }
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn numbers_may_be_written_in_every_way_of_toml() {
    let camera = parsed("camera = { position = [0x10, 1_000, -2.5e1], fov = +4_0 }").camera;
    assert_eq!(camera.position, DVec3::new(16.0, 1000.0, -25.0));
    assert_eq!(camera.projection, Projection::Perspective { fov: 40.0 });
    let scene = parsed("object = [{ shape = 'sphere', scale = 2 }, { shape = 'cuboid', size = [1, 2, 3] }]");
    assert_eq!(scene.objects[0].scale, DVec3::splat(2.0));
    assert_eq!(scene.objects[1].shape, ShapeDesc::Cuboid { size: DVec3::new(1.0, 2.0, 3.0) });
    let scene = parsed("film.width = 7\n[[material]]\nname = 'm'\n[material.texture]\nchecker = ['red', 'red']");
    assert_eq!(scene.film.width, 7);
    assert!(scene.materials[0].texture.is_some());
}

#[test]
fn colours_are_decoded_from_srgb_and_arrays_are_not() {
    let close = |found: Option<Rgb>, r: f64, g: f64, b: f64| {
        let found = found.unwrap();
        let off = (found.r - r).abs().max((found.g - g).abs()).max((found.b - b).abs());
        assert!(off < 5e-7, "{found:?}");
    };
    // Linear values from the published curve, to seven digits: (188/255 -> 0.5028865), (128/255 -> 0.2158605).
    close(parse_color("#bcbcbc"), 0.5028865, 0.5028865, 0.5028865);
    close(parse_color("gray"), 0.2158605, 0.2158605, 0.2158605);
    close(parse_color("#ff8000"), 1.0, 0.2158605, 0.0);
    // Below the kink of the curve: 10/255/12.92.
    close(parse_color("#0a0000"), 0.0030353, 0.0, 0.0);
    assert_eq!(parse_color("#fff"), Some(Rgb::WHITE));
    assert_eq!(parse_color("#a1F"), parse_color("#aa11ff"));
    assert_eq!(parse_color("RebeccaPurple"), parse_color("#663399"));
    assert_eq!(parse_color("violet"), parse_color("#ee82ee"));
    let wrong = ["", "#", "#ff", "#ffff", "#ff00ff80", "#ggg", "fff", "facade", "transparent", "red ", " red", "#é0"];
    for text in wrong.into_iter().chain(["rgb(1,2,3)", "hsl(0,0,0)", "#+12", "none", "currentcolor", "vert"]) {
        assert_eq!(parse_color(text), None, "{text}");
    }
    assert_eq!(parsed("[world]\nambient = [0.5, 2, 0]").world.ambient, Rgb::new(0.5, 2.0, 0.0));
}

#[test]
fn every_css_name_is_a_colour() {
    for (name, code) in csscolorparser::NAMED_COLORS.entries() {
        let [r, g, b] = code.map(|code| srgb_to_linear(f64::from(code) / 255.0));
        assert_eq!(parse_color(name.as_str()), Some(Rgb::new(r, g, b)), "{name}");
    }
}

#[test]
fn spheres_are_read_from_lines() {
    let directory = example_directory("spheres");
    let text = "[[object]]\nshape = 'spheres'\nfile = 'balls.csv'\n".repeat(2);
    let scene = parse(&text, &directory.join("scene.toml")).unwrap();
    let expected = [[0.0, 0.0, 0.0, 0.5], [1.0, 2.0, 3.0, 0.25], [-1.0, 0.0, 0.1, 1.0]];
    let [ShapeDesc::Spheres { data: first }, ShapeDesc::Spheres { data: second }] =
        [&scene.objects[0].shape, &scene.objects[1].shape]
    else {
        panic!()
    };
    assert_eq!(**first, expected);
    assert!(std::sync::Arc::ptr_eq(first, second), "one file is read once");
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn mistakes_are_told_in_the_order_of_the_text_whatever_the_order_of_sections() {
    let text =
        "[[object]]\nshape = 'x'\n[film]\nwidth = 0\n[[material]]\nior = 0\n[camera]\nfov = 0\n[[light]]\nx = 0\n";
    let lines: Vec<_> = parse(text, Path::new("s.toml")).unwrap_err().iter().map(|mistake| mistake.line).collect();
    assert_eq!(lines, [2, 4, 5, 6, 8, 10]);
}

#[test]
fn a_mistake_has_a_form_of_one_line_and_a_coloured_one() {
    let mistakes = parse("[film]\n\twidth = 0\n", Path::new("a\u{1b}b.toml")).unwrap_err();
    assert_eq!(mistakes[0].to_string(), "a\u{fffd}b.toml:2:10: `width` is out of range (must be from 1 to 32768)");
    let colored = mistakes[0].render(true);
    assert!(colored.contains("\u{1b}[") && !colored.contains('\t'), "{colored:?}");
    let plain: String =
        colored.split('\u{1b}').map(|part| part.split_once('m').map_or(part, |(_, text)| text)).collect();
    assert_eq!(plain.trim_start_matches("error"), mistakes[0].render(false).trim_start_matches("error"));
}

/// Scenes to be damaged: all of the language is in them.
const GOOD: [&str; 3] = [
    EXAMPLE,
    "camera = { projection = 'orthographic', view_height = 3 }\nfilm.width = 9\n\
     object = [{ shape = 'plane' }, { shape = \"quad\", size = [1, 2], scale = [1, -2, 3] },\n{ shape = 'cone' }]\n",
    "# räksmörgås 球体\r\n[[light]]\r\nkind = 'directional'\r\ndirection = [0, -1, 0]\r\n[world]\r\n\
     background = 'tomato'\r\n[[object]]\r\nname = \"球\\u0041\"\r\nshape = \"spheres\"\r\nfile = \"balls.csv\"\r\n\
     [[material]]\r\nname = \"\"\"two\r\nlines\"\"\"\r\nfresnel = true\r\npriority = -3\r\n",
];
/// What a damaged scene gets in place of a few of its characters.
const SCRAPS: [&str; 34] = [
    "",
    "",
    "\n",
    "\"",
    "'",
    "\"\"\"",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ",",
    ".",
    "#",
    "-",
    "nan",
    "1e999",
    "0x",
    "\t",
    "\r",
    "light = []\n",
    "[light]\n",
    "[[film]]\n",
    "object.x = 1\n",
    "\u{0}",
    "\u{1b}[31m",
    "\u{202e}",
    "球",
    "e\u{301}",
    "\\",
    "99999999999999999999999",
    "name",
];

/// Two or three seconds of damage.
const ROUNDS: usize = 20_000;

#[test]
fn damaged_scenes_give_mistakes_with_a_place_in_the_text_and_never_a_panic() {
    let directory = example_directory("damaged");
    let file = directory.join("scene.toml");
    let mut random = SplitMix64(0x5eed);
    let mut pick = |n: usize| (random.next_u64() % n.max(1) as u64) as usize;
    let (mut good, mut bad) = (0, 0);
    for _ in 0..ROUNDS {
        let mut chars: Vec<char> = GOOD[pick(GOOD.len())].chars().collect();
        for _ in 0..1 + pick(4) {
            let at = pick(chars.len() + 1);
            let end = (at + pick(4)).min(chars.len());
            // Half of the time a piece of the scene itself, so that words and lines stand where they do not belong.
            let from = pick(chars.len());
            let piece: Vec<char> = match pick(2) {
                0 => SCRAPS[pick(SCRAPS.len())].chars().collect(),
                _ => chars[from..(from + pick(30)).min(chars.len())].to_vec(),
            };
            chars.splice(at..end, piece);
        }
        let text: String = chars.into_iter().collect();
        let Err(mistakes) = parse(&text, &file) else {
            assert!(DeTable::parse(text.trim_start_matches('\u{feff}')).is_ok(), "an error is lost in\n{text}");
            good += 1;
            continue;
        };
        bad += 1;
        assert!(!mistakes.is_empty() && mistakes.len() <= 21, "{text}");
        let shown = text.trim_start_matches('\u{feff}');
        let mut before = (0, 0);
        for mistake in mistakes.iter().filter(|mistake| mistake.file == file) {
            let line = shown.split('\n').nth(mistake.line.checked_sub(1).unwrap()).expect("a line of the text");
            let columns = line.trim_end_matches('\r').chars().count() + 1;
            assert!((1..=columns).contains(&mistake.column), "{mistake} of {columns}\n{text}");
            assert!(before <= (mistake.line, mistake.column), "{mistake} is out of order\n{text}");
            before = (mistake.line, mistake.column);
            let rendered = mistake.render(false);
            assert!(!rendered.contains(|c: char| c.is_control() && c != '\n'), "{rendered:?}");
            assert!(rendered.contains('^'), "{rendered}");
        }
    }
    assert!(good > 100 && bad > 1000, "{good} good, {bad} bad");
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn damaged_lists_of_spheres_give_mistakes_with_a_place_in_the_text_and_never_a_panic() {
    let mut random = SplitMix64(0xba11);
    let mut pick = |n: usize| (random.next_u64() % n as u64) as usize;
    for _ in 0..2000 {
        let mut chars: Vec<char> = "0, 0, 0, 0.5\n1 2 3 0.25 # small\r\n\n-1,\t0,1e-1, 1\n".chars().collect();
        for _ in 0..pick(5) {
            let at = pick(chars.len());
            chars.splice(at..(at + pick(4)).min(chars.len()), SCRAPS[pick(SCRAPS.len())].chars());
        }
        let text: String = chars.into_iter().collect();
        match spheres::from_text(&text, Path::new("balls.csv")) {
            Ok(found) => assert!(found.iter().all(|sphere| sphere.iter().all(|v| v.is_finite()) && sphere[3] > 0.0)),
            Err(mistakes) => {
                for mistake in mistakes {
                    let line = text.split('\n').nth(mistake.line - 1).expect("a line of the text");
                    assert!((1..=line.chars().count() + 1).contains(&mistake.column), "{mistake}\n{text}");
                    mistake.render(false);
                }
            }
        }
    }
}
