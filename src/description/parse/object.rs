//! `[[object]]` and its shape.

use super::file::Files;
use super::material::not_zero;
use super::nearest::{did_you_mean, list, quoted};
use super::report::{Report, Words};
use super::section::{Kind, Section};
use super::spheres;
use super::value::Value;
use crate::description::interval::Interval;
use crate::description::{Diagnostic, MaterialDesc, ObjectDesc, ShapeDesc, limits};
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const KEYS: &[&str] = &["name", "shape", "material", "translate", "rotate", "scale", "visible"];
static SHAPES: [Kind; 8] = [
    Kind { name: "sphere", noun: "a sphere", keys: &["radius"] },
    Kind { name: "cuboid", noun: "a cuboid", keys: &["size"] },
    Kind { name: "cylinder", noun: "a cylinder", keys: &["radius", "height"] },
    Kind { name: "cone", noun: "a cone", keys: &["radius", "height"] },
    Kind { name: "plane", noun: "a plane", keys: &[] },
    Kind { name: "quad", noun: "a quad", keys: &["size"] },
    Kind { name: "mesh", noun: "a mesh", keys: &["file", "crease"] },
    Kind { name: "spheres", noun: "a group of spheres", keys: &["data", "file"] },
];

/// Largest file of spheres, bytes; more of them would fill memory.
const MAX_SPHERES: u64 = 256 << 20;

/// Reads the objects of a scene, one after the other.
pub(super) struct ObjectReader<'a> {
    materials: &'a [MaterialDesc],
    names: HashSet<&'a str>,
    /// Files of spheres by path, `None` if they are wrong.
    spheres: HashMap<PathBuf, Option<Arc<[[f64; 4]]>>>,
}

impl<'a> ObjectReader<'a> {
    /// For objects that are made of `materials`.
    pub fn new(materials: &'a [MaterialDesc]) -> Self {
        let names = materials.iter().map(|material| material.name.as_str()).collect();
        Self { materials, names, spheres: HashMap::new() }
    }

    /// Reads an object. `None` if its shape is wrong.
    pub fn object(
        &mut self,
        report: &mut Report<'a>,
        files: &mut Files<'a>,
        section: Section<'a>,
    ) -> Option<ObjectDesc> {
        let kind = section
            .require(report, "shape", "write shape = \"sphere\", or cuboid, cylinder, cone, plane, quad, mesh, spheres")
            .and_then(|v| v.one_of(report, &SHAPES, |shape| shape.name));
        let section = section.with_kind(&SHAPES, kind);
        section.check_keys(report, KEYS);
        let name = section.read("name", |v| v.text(report)).unwrap_or_default().to_owned();
        let material = section.read("material", |v| self.material(report, v));
        let translate = section.read("translate", |v| v.vec3(report, Interval::PLACE)).unwrap_or(DVec3::ZERO);
        let rotate = section.read("rotate", |v| v.vec3(report, Interval::DEGREES)).unwrap_or(DVec3::ZERO);
        let scale = section.read("scale", |v| scale(report, v)).unwrap_or(DVec3::ONE);
        let shape = self.shape(report, files, &section, kind?)?;
        let visible = section.read("visible", |v| v.boolean(report)).unwrap_or(true);
        Some(ObjectDesc { name, shape, material, translate, rotate, scale, visible })
    }

    fn material(&self, report: &mut Report<'a>, value: Value<'a>) -> Option<String> {
        let name = value.text(report)?;
        if !self.names.contains(name) {
            let materials = self.materials;
            report.conflict(value.span(), move || {
                let names = || materials.iter().map(|material| material.name.as_str()).filter(|name| !name.is_empty());
                let words = Words::new(
                    format!("no material {}", quoted(name)),
                    did_you_mean(name, names(), "no [[material]] has this name"),
                );
                if names().next().is_none() {
                    words.help("add a [[material]] of this name, or remove the line for the default material")
                } else {
                    words.help(format!("materials of this scene: {}", list(names())))
                }
            });
        }
        Some(name.to_owned())
    }

    fn shape(
        &mut self,
        report: &mut Report<'a>,
        files: &mut Files<'a>,
        section: &Section<'a>,
        kind: &Kind,
    ) -> Option<ShapeDesc> {
        let length = |report: &mut Report<'a>, key, default| {
            section.read(key, |v| v.number(report, Interval::LENGTH)).unwrap_or(default)
        };
        Some(match kind.name {
            "sphere" => ShapeDesc::Sphere { radius: length(report, "radius", 0.5) },
            "cuboid" => ShapeDesc::Cuboid {
                size: section.read("size", |v| v.vec3(report, Interval::LENGTH)).unwrap_or(DVec3::ONE),
            },
            "cylinder" => {
                ShapeDesc::Cylinder { radius: length(report, "radius", 0.5), height: length(report, "height", 1.0) }
            }
            "cone" => ShapeDesc::Cone { radius: length(report, "radius", 0.5), height: length(report, "height", 1.0) },
            "plane" => ShapeDesc::Plane,
            "quad" => ShapeDesc::Quad {
                size: section.read("size", |v| v.vec2(report, Interval::LENGTH)).unwrap_or(DVec2::ONE),
            },
            "mesh" => {
                let crease =
                    section.read("crease", |v| v.number(report, Interval::CREASE)).unwrap_or(limits::DEFAULT_CREASE);
                let file = section.require(report, "file", "write file = \"models/knot.obj\" or the like")?;
                ShapeDesc::Mesh { file: files.path(report, file)?, crease }
            }
            // The last of `SHAPES`.
            _ => ShapeDesc::Spheres { data: self.data(report, files, section)? },
        })
    }

    /// Spheres, from the scene file or from their own.
    fn data(
        &mut self,
        report: &mut Report<'a>,
        files: &mut Files<'a>,
        section: &Section<'a>,
    ) -> Option<Arc<[[f64; 4]]>> {
        match (section.value("data"), section.value("file")) {
            (Some(data), None) => spheres::inline(report, data),
            (None, Some(file)) => {
                let path = files.path(report, file)?;
                if let Some(known) = self.spheres.get(&path) {
                    return known.clone();
                }
                let found = read_spheres(&path).map_err(|mistakes| {
                    for mistake in mistakes {
                        report.mistake(file.span(), || Words::Elsewhere(mistake));
                    }
                });
                self.spheres.entry(path).or_insert(found.ok()).clone()
            }
            (Some(_), Some(file)) => {
                report.conflict(file.span(), || {
                    Words::new("spheres come from `data` or from `file`", "remove `file` or `data`")
                });
                None
            }
            (None, None) => {
                report.conflict(section.span.clone(), || {
                    Words::new("a group of spheres needs `data` or `file`", "both are missing")
                        .help("write data = [[x, y, z, radius], ..] or file = \"spheres.csv\"")
                });
                None
            }
        }
    }
}

fn read_spheres(path: &Path) -> Result<Arc<[[f64; 4]]>, Vec<Diagnostic>> {
    let whole = |message: &str| vec![Diagnostic::new(path, "", 0..0, message, "")];
    let read = || {
        let mut bytes = Vec::new();
        File::open(path)?.take(MAX_SPHERES + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().map_err(|error: io::Error| whole(&format!("cannot be read: {error}")))?;
    if bytes.len() as u64 > MAX_SPHERES {
        return Err(whole(&format!("is larger than {} MiB", MAX_SPHERES >> 20)));
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => spheres::from_text(text, path),
        Err(error) => {
            let text = String::from_utf8_lossy(&bytes);
            let at = error.valid_up_to();
            Err(vec![Diagnostic::new(path, &text, at..at + 1, "this is not text in UTF-8", "")])
        }
    }
}

/// One factor for all axes, or one for each; none is 0.
fn scale<'a>(report: &mut Report<'a>, value: Value<'a>) -> Option<DVec3> {
    let factors = if value.is_number() {
        DVec3::splat(value.number(report, Interval::PLACE)?)
    } else {
        value.vec3(report, Interval::PLACE)?
    };
    not_zero(report, value, factors.abs().min_element() < limits::MIN_LENGTH).then_some(factors)
}
