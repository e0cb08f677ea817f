//! Generated scenes that grow in one thing: triangles, spheres, lights, pixels or depth.

use super::StudyError;
use crate::assets::Model;
use crate::description::{
    FilmDesc, LightKind, MaterialDesc, ObjectDesc, RenderDesc, SceneDesc, ShapeDesc, limits, parse,
};
use crate::math::SplitMix64;
use crate::scene::{Scene, compile, lender};
use glam::{DVec3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// What grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Growing {
    /// Of one mesh.
    Triangles,
    /// Of one cloud.
    Spheres,
    /// All of them lighting the same spheres.
    Lights,
    /// Of the picture.
    Pixels,
    /// Of the ray trees in a room of mirrors.
    Depth,
}

impl Growing {
    pub const ALL: [Growing; 5] = [Self::Triangles, Self::Spheres, Self::Lights, Self::Pixels, Self::Depth];

    pub fn name(self) -> &'static str {
        match self {
            Self::Triangles => "triangles",
            Self::Spheres => "spheres",
            Self::Lights => "lights",
            Self::Pixels => "pixels",
            Self::Depth => "depth",
        }
    }

    /// Sizes from small to large; `most` limits triangles and spheres.
    pub fn sizes(self, quick: bool, most: u64) -> Vec<u64> {
        let powers = |base: u64, range: std::ops::RangeInclusive<u32>| range.map(move |power| base.pow(power));
        match self {
            Self::Triangles => powers(10, 2..=7).filter(|n| *n <= most).collect(),
            Self::Spheres => powers(10, 1..=6).filter(|n| *n <= most).collect(),
            Self::Lights => powers(2, 0..=if quick { 4 } else { 6 }).collect(),
            // Of 4:3 pictures 80, 160... across.
            Self::Pixels => powers(4, 0..=if quick { 2 } else { 4 }).map(|n| n * 80 * 60).collect(),
            Self::Depth => powers(2, 0..=if quick { 4 } else { 5 }).collect(),
        }
    }

    /// The scene of this size. Only compiling it is timed, so what it is made of is made before.
    pub fn make(self, size: u64) -> Result<Seed, StudyError> {
        let scene = |text: &str| {
            parse(text, Path::new("generated")).map_err(|_| StudyError::Asked("a generated scene is wrong".to_owned()))
        };
        Ok(match self {
            Self::Triangles => {
                let mut desc = scene(VIEW)?;
                let mesh = ShapeDesc::Mesh { file: TERRAIN.into(), crease: limits::DEFAULT_CREASE };
                desc.objects.push(ObjectDesc::new(mesh));
                Seed { desc, model: Some(terrain(size)) }
            }
            Self::Spheres => {
                let mut desc = scene(VIEW)?;
                desc.objects.push(cloud(size));
                Seed { desc, model: None }
            }
            Self::Lights => {
                let mut desc = scene(VIEW)?;
                desc.objects.push(cloud(1000));
                let light = desc.lights[0].clone();
                let mut random = SplitMix64(5);
                desc.lights = (0..size)
                    .map(|_| {
                        let mut light = light.clone();
                        light.intensity = 1.0 / size as f64;
                        if let LightKind::Point { position, .. } = &mut light.kind {
                            *position = DVec3::new(random.range(-3.0, 3.0), 3.0, random.range(-1.0, 4.0));
                        }
                        light
                    })
                    .collect();
                Seed { desc, model: None }
            }
            Self::Pixels => {
                let mut desc = scene(VIEW)?;
                desc.objects.push(cloud(1000));
                let side = (size as f64 / 4800.0).sqrt().round() as u32;
                (desc.film.width, desc.film.height) = (80 * side, 60 * side);
                Seed { desc, model: None }
            }
            Self::Depth => {
                let mut desc = scene(ROOM)?;
                desc.render.max_depth = size as u32;
                Seed { desc, model: None }
            }
        })
    }
}

/// What a scene is compiled from.
pub(super) struct Seed {
    desc: SceneDesc,
    model: Option<Model>,
}

impl Seed {
    /// Builds the trees.
    pub fn compile(self) -> Result<Arc<Scene>, StudyError> {
        let lent = match self.model {
            Some(model) => Some(lender(Path::new(TERRAIN), limits::DEFAULT_CREASE, model)?),
            None => None,
        };
        Ok(Arc::new(compile(&self.desc, lent.as_ref())?))
    }
}

/// Hills of so many triangles to be edited, with a light and a material; and a scene that lends their mesh.
pub fn landscape(triangles: u64) -> Result<(SceneDesc, Scene), StudyError> {
    let Seed { mut desc, model } = Growing::Triangles.make(triangles)?;
    desc.film = FilmDesc::default();
    desc.render = RenderDesc::default();
    desc.materials.push(MaterialDesc { name: "land".into(), ..MaterialDesc::default() });
    for object in &mut desc.objects {
        object.material = Some("land".into());
    }
    Ok((desc, lender(Path::new(TERRAIN), limits::DEFAULT_CREASE, model.unwrap_or_default())?))
}

/// What the terrain is called, as if it were a file.
const TERRAIN: &str = "terrain";

/// A camera above a square of side 4, and a light.
const VIEW: &str = "
[film]
width = 320
height = 240
[camera]
position = [0, 2.6, 3.4]
look_at = [0, -0.2, 0]
[world]
background = \"white\"
[render]
samples = 1
[[light]]
position = [3, 5, 2]
";

/// A room whose walls are mirrors, and a sphere.
const ROOM: &str = "
[film]
width = 160
height = 120
[camera]
position = [0.7, 0.3, 1.6]
look_at = [0, 0, 0]
[world]
ambient = \"white\"
[render]
samples = 1
[[light]]
position = [0.5, 1.5, 0.5]
[[material]]
name = \"mirror\"
diffuse = 0.1
reflect = 0.9
[[object]]
shape = \"cuboid\"
size = [4, 4, 4]
material = \"mirror\"
[[object]]
shape = \"sphere\"
radius = 0.5
";

/// Hills over a square of side 4 in as many triangles as there are asked for, or one less.
fn terrain(triangles: u64) -> Model {
    let cells = ((triangles / 2) as f64).sqrt();
    let (across, down) = (cells.floor().max(1.0) as u32, (triangles / 2) as u32 / cells.floor().max(1.0) as u32);
    let height =
        |x: f64, z: f64| 0.25 * (3.0 * x).sin() * (2.0 * z + x).cos() + 0.03 * (17.0 * x).sin() * (19.0 * z).sin();
    let mut positions = Vec::with_capacity(((across + 1) * (down + 1)) as usize);
    for j in 0..=down {
        for i in 0..=across {
            let (x, z) = (4.0 * f64::from(i) / f64::from(across) - 2.0, 4.0 * f64::from(j) / f64::from(down) - 2.0);
            positions.push(Vec3::new(x as f32, height(x, z) as f32, z as f32));
        }
    }
    let mut faces = Vec::with_capacity(triangles as usize);
    for j in 0..down {
        for i in 0..across {
            let a = j * (across + 1) + i;
            let (b, c, d) = (a + 1, a + across + 1, a + across + 2);
            faces.extend([[a, c, b], [b, c, d]]);
        }
    }
    Model { positions, triangles: faces, ..Model::default() }
}

/// Spheres that fill a tenth of a flat box of side 4, whatever their number.
fn cloud(spheres: u64) -> ObjectDesc {
    let mut random = SplitMix64(9);
    let radius = (0.1 * 16.0 * 0.6 / (spheres as f64 * 4.2)).cbrt();
    let mut sphere = || [random.range(-2.0, 2.0), random.range(-0.3, 0.3), random.range(-2.0, 2.0), radius];
    ObjectDesc::new(ShapeDesc::Spheres { data: (0..spheres).map(|_| sphere()).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_what_it_is_asked_for() {
        let count = |growing: Growing, size| growing.make(size).unwrap().compile().unwrap();
        for size in [100u64, 1000, 12345] {
            let found = count(Growing::Triangles, size).summary.instanced_triangles as u64;
            assert!(found <= size && found as f64 > 0.95 * size as f64, "{found} of {size}");
        }
        assert_eq!(count(Growing::Spheres, 1000).summary.primitives, 1000);
        assert_eq!(count(Growing::Lights, 8).lights.len(), 8);
        let picture = count(Growing::Pixels, 4800 * 16);
        assert_eq!((picture.width, picture.height), (320, 240));
        assert_eq!(count(Growing::Depth, 16).render.max_depth, 16);
    }

    #[test]
    fn sizes_grow_and_stay_below_the_limit() {
        for growing in Growing::ALL {
            let sizes = growing.sizes(false, 1000);
            assert!(sizes.len() >= 2 && sizes.is_sorted(), "{growing:?}");
        }
        assert_eq!(Growing::Triangles.sizes(false, 10_000), [100, 1000, 10_000]);
    }
}
