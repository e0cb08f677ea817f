//! `[[material]]` and its texture.

use super::file::Files;
use super::report::{Report, Words};
use super::section::{Kind, Section};
use super::value::Value;
use crate::description::interval::Interval;
use crate::description::{MaterialDesc, TextureDesc, TextureSource, Wrap, limits};
use glam::DVec2;

const KEYS: &[&str] = &[
    "name",
    "color",
    "texture",
    "ambient",
    "diffuse",
    "specular",
    "shininess",
    "reflect",
    "transmit",
    "ior",
    "fresnel",
    "priority",
];

/// Reads a material; its name is empty if that is wrong.
pub(super) fn material<'a>(report: &mut Report<'a>, files: &mut Files<'a>, section: &Section<'a>) -> MaterialDesc {
    section.check_keys(report, KEYS);
    let default = MaterialDesc::default();
    let name = section.require(report, "name", "objects refer to a material by its name, as in name = \"glass\"");
    let mut number = |key, range, default| section.read(key, |v| v.number(report, range)).unwrap_or(default);
    MaterialDesc {
        ambient: number("ambient", Interval::COEFFICIENT, default.ambient),
        diffuse: number("diffuse", Interval::COEFFICIENT, default.diffuse),
        specular: number("specular", Interval::COEFFICIENT, default.specular),
        shininess: number("shininess", Interval::SHININESS, default.shininess),
        reflect: number("reflect", Interval::SHARE, default.reflect),
        transmit: number("transmit", Interval::SHARE, default.transmit),
        ior: number("ior", Interval::IOR, default.ior),
        name: name.and_then(|v| v.text(report)).unwrap_or_default().to_owned(),
        color: section.read("color", |v| v.color(report)).unwrap_or(default.color),
        texture: section.read("texture", |v| texture(report, files, v)),
        fresnel: section.read("fresnel", |v| v.boolean(report)).unwrap_or(default.fresnel),
        priority: section
            .read("priority", |v| v.integer(report, limits::PRIORITY))
            .map_or(default.priority, |priority| priority as i32),
    }
}

const TEXTURE_FORMS: &str =
    r#"write texture = { file = "wood.png" } or texture = { checker = ["white", "black"], size = 0.5 }"#;
const TEXTURE_KEYS: &[&str] = &["scale", "offset"];
const PICTURE: Kind = Kind { name: "file", noun: "a picture", keys: &["file", "wrap"] };
const CHECKER: Kind = Kind { name: "checker", noun: "a checker", keys: &["checker", "size"] };
static TEXTURE_KINDS: [Kind; 2] = [PICTURE, CHECKER];

fn texture<'a>(report: &mut Report<'a>, files: &mut Files<'a>, value: Value<'a>) -> Option<TextureDesc> {
    let Some(section) = Section::of("`texture`", value.toml) else {
        value.wrong_type(report, "a table", Some(TEXTURE_FORMS));
        return None;
    };
    let [picture, checker] = &TEXTURE_KINDS;
    let (file, colors) = (section.value("file"), section.value("checker"));
    let kind = match (file, colors) {
        (Some(_), None) => Some(picture),
        (None, Some(_)) => Some(checker),
        _ => None,
    };
    let section = section.with_kind(&TEXTURE_KINDS, kind);
    section.check_keys(report, TEXTURE_KEYS);
    let scale = section.read("scale", |v| {
        let scale = if v.is_number() {
            v.number(report, Interval::UV).map(DVec2::splat)
        } else {
            v.vec2(report, Interval::UV)
        }?;
        not_zero(report, v, scale.x == 0.0 || scale.y == 0.0).then_some(scale)
    });
    let offset = section.read("offset", |v| v.vec2(report, Interval::UV));
    let source = match (file, colors) {
        (Some(file), None) => TextureSource::Image {
            file: files.path(report, file)?,
            wrap: section.read("wrap", |v| v.choice(report, Wrap::NAMES)).unwrap_or(Wrap::Repeat),
        },
        (None, Some(colors)) => {
            let size = section.read("size", |v| v.number(report, Interval::LENGTH)).unwrap_or(1.0);
            let [first, second] = colors.elements(report, "an array of 2 colours")?;
            let (first, second) = (first.color(report), second.color(report));
            TextureSource::Checker { colors: [first?, second?], size }
        }
        (Some(_), Some(second)) => {
            report.conflict(second.span(), || {
                Words::new("a texture is a picture or a checker", "remove `file` or `checker`")
            });
            return None;
        }
        (None, None) => {
            report.conflict(value.span(), || {
                Words::new("a texture needs `file` or `checker`", "both are missing").help(TEXTURE_FORMS)
            });
            return None;
        }
    };
    Some(TextureDesc { source, scale: scale.unwrap_or(DVec2::ONE), offset: offset.unwrap_or(DVec2::ZERO) })
}

/// Whether a scale is all right: a mistake if some factor is `zero`.
pub(super) fn not_zero<'a>(report: &mut Report<'a>, value: Value<'a>, zero: bool) -> bool {
    if zero {
        report.mistake(value.span(), move || {
            Words::new(format!("`{}` must not be 0", value.key), "a factor of 0 leaves nothing")
        });
    }
    !zero
}
