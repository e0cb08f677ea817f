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
            shadows: Shadows::Opaque,
            numerics: Numerics::Robust,
        },
        lights: vec![LightDesc {
            name: String::new(),
            kind: LightKind::Point { position: DVec3::new(4.0, 6.0, 3.0), falloff: Falloff::None },
            color: Rgb::WHITE,
            intensity: 0.8,
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
