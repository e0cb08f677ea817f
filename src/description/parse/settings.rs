//! `[film]`, `[camera]`, `[world]`, `[render]` and `[[light]]`.

use super::report::{Report, Words};
use super::section::{Kind, Section};
use super::value::Value;
use super::{CAMERA, FILM, RENDER, WORLD, single};
use crate::description::interval::Interval;
use crate::description::{
    Background, CameraDesc, Falloff, FilmDesc, Filter, LightDesc, LightKind, Numerics, Projection, RenderDesc,
    SceneDesc, Shading, Shadows, WorldDesc, limits,
};
use toml::de::DeTable;

/// Reads the sections that stand once; the rest of the scene is empty.
pub(super) fn settings<'a>(report: &mut Report<'a>, root: &'a DeTable<'a>) -> SceneDesc {
    let mut scene = SceneDesc::default();
    if let Some(section) = single(root, FILM) {
        scene.film = film(report, &section);
    }
    if let Some(section) = single(root, CAMERA) {
        scene.camera = camera(report, section);
    }
    if let Some(section) = single(root, WORLD) {
        scene.world = world(report, &section);
    }
    if let Some(section) = single(root, RENDER) {
        scene.render = render(report, &section);
    }
    scene
}

fn film<'a>(report: &mut Report<'a>, section: &Section<'a>) -> FilmDesc {
    section.check_keys(report, &["width", "height"]);
    let default = FilmDesc::default();
    let mut side = |key, default| count(report, section, key, 1..=limits::MAX_SIDE, default);
    FilmDesc { width: side("width", default.width), height: side("height", default.height) }
}

fn count<'a>(
    report: &mut Report<'a>,
    section: &Section<'a>,
    key: &str,
    range: std::ops::RangeInclusive<u32>,
    default: u32,
) -> u32 {
    let range = i64::from(*range.start())..=i64::from(*range.end());
    section.read(key, |v| v.integer(report, range)).and_then(|v| u32::try_from(v).ok()).unwrap_or(default)
}

const CAMERA_KEYS: &[&str] = &["position", "look_at", "up", "projection"];
static PROJECTIONS: [Kind; 2] = [
    Kind { name: "perspective", noun: "a perspective camera", keys: &["fov"] },
    Kind { name: "orthographic", noun: "an orthographic camera", keys: &["view_height"] },
];

fn camera<'a>(report: &mut Report<'a>, section: Section<'a>) -> CameraDesc {
    let default = CameraDesc::default();
    let kind = match section.value("projection") {
        None => PROJECTIONS.first(),
        Some(projection) => projection.one_of(report, &PROJECTIONS, |kind| kind.name),
    };
    let section = section.with_kind(&PROJECTIONS, kind);
    section.check_keys(report, CAMERA_KEYS);
    let before = report.count();
    let position = section.read("position", |v| v.vec3(report, Interval::PLACE)).unwrap_or(default.position);
    let look_at = section.read("look_at", |v| v.vec3(report, Interval::PLACE)).unwrap_or(default.look_at);
    let up = section.read("up", |v| v.direction(report)).unwrap_or(default.up);
    if report.count() == before {
        check_view(report, &section, position, look_at, up);
    }
    let fov = section.read("fov", |v| v.number(report, Interval::FOV));
    let view_height = section.read("view_height", |v| v.number(report, Interval::LENGTH));
    let projection = match kind.map(|kind| kind.name) {
        Some("orthographic") => Projection::Orthographic {
            // By default what a perspective camera shows at the distance of `look_at`.
            view_height: view_height
                .unwrap_or(2.0 * position.distance(look_at) * (limits::DEFAULT_FOV / 2.0).to_radians().tan()),
        },
        _ => fov.map_or(default.projection, |fov| Projection::Perspective { fov }),
    };
    CameraDesc { position, look_at, up, projection }
}

/// Adds a mistake if the camera looks nowhere, or along `up`.
fn check_view<'a>(
    report: &mut Report<'a>,
    section: &Section<'a>,
    position: glam::DVec3,
    look_at: glam::DVec3,
    up: glam::DVec3,
) {
    let place =
        |keys: &[&str]| keys.iter().find_map(|key| section.value(key)).map_or(section.span.clone(), Value::span);
    let view = (look_at - position).normalize_or_zero();
    if view == glam::DVec3::ZERO {
        report.conflict(place(&["look_at", "position"]), || {
            Words::new("`look_at` and `position` are the same point", "the camera must look at another point")
        });
    } else if view.cross(up.normalize_or_zero()).length() < limits::MIN_UP_SINE {
        let vertical = view.x.hypot(view.z) < view.y.abs();
        let given = section.value("up").is_some();
        report.conflict(place(&["up", "look_at", "position"]), move || {
            let label =
                if given { "must point elsewhere than the view" } else { "`up` is [0, 1, 0] where it is not given" };
            let other = if vertical { "[0, 0, -1]" } else { "[0, 1, 0]" };
            Words::new("the camera looks along `up`", label)
                .help(format!("`up` is what is upward in the picture; for this view write up = {other}"))
        });
    }
}

fn world<'a>(report: &mut Report<'a>, section: &Section<'a>) -> WorldDesc {
    section.check_keys(report, &["ambient", "background", "ior"]);
    let default = WorldDesc::default();
    WorldDesc {
        ambient: section.read("ambient", |v| v.color(report)).unwrap_or(default.ambient),
        background: section.read("background", |v| background(report, v)).unwrap_or(default.background),
        ior: section.read("ior", |v| v.number(report, Interval::IOR)).unwrap_or(default.ior),
    }
}

const GRADIENT: &str = r#"write background = { top = "skyblue", bottom = "white" }"#;

fn background<'a>(report: &mut Report<'a>, value: Value<'a>) -> Option<Background> {
    let Some(section) = Section::of("`background`", value.toml) else {
        return value.color(report).map(Background::Solid);
    };
    section.check_keys(report, &["top", "bottom"]);
    let top = section.require(report, "top", GRADIENT).and_then(|v| v.color(report));
    let bottom = section.require(report, "bottom", GRADIENT).and_then(|v| v.color(report));
    Some(Background::Gradient { top: top?, bottom: bottom? })
}

fn render<'a>(report: &mut Report<'a>, section: &Section<'a>) -> RenderDesc {
    section.check_keys(report, &["shading", "max_depth", "samples", "error", "filter", "shadows", "numerics"]);
    let default = RenderDesc::default();
    let error = section.read("error", |v| v.number(report, Interval::ERROR));
    // On the way to an error `samples` is only a limit.
    let samples = if error.is_some() { limits::ADAPTIVE_SAMPLES } else { default.samples };
    RenderDesc {
        shading: section.read("shading", |v| v.choice(report, Shading::NAMES)).unwrap_or(default.shading),
        max_depth: count(report, section, "max_depth", 0..=limits::MAX_DEPTH, default.max_depth),
        samples: count(report, section, "samples", 1..=limits::MAX_SAMPLES, samples),
        error,
        filter: section.read("filter", |v| v.choice(report, Filter::NAMES)).unwrap_or(default.filter),
        shadows: section.read("shadows", |v| v.choice(report, Shadows::NAMES)).unwrap_or(default.shadows),
        numerics: section.read("numerics", |v| v.choice(report, Numerics::NAMES)).unwrap_or(default.numerics),
    }
}

const LIGHT_KEYS: &[&str] = &["kind", "name", "color", "intensity", "visible"];
static LIGHT_KINDS: [Kind; 2] = [
    Kind { name: "point", noun: "a point light", keys: &["position", "falloff"] },
    Kind { name: "directional", noun: "a directional light", keys: &["direction"] },
];

/// Reads a light; `None` if its kind is wrong.
pub(super) fn light<'a>(report: &mut Report<'a>, section: Section<'a>) -> Option<LightDesc> {
    let default = LightDesc::default();
    let kind = match section.value("kind") {
        None => LIGHT_KINDS.first(),
        Some(kind) => kind.one_of(report, &LIGHT_KINDS, |kind| kind.name),
    };
    let section = section.with_kind(&LIGHT_KINDS, kind);
    section.check_keys(report, LIGHT_KEYS);
    let name = section.read("name", |v| v.text(report)).unwrap_or_default().to_owned();
    let color = section.read("color", |v| v.color(report)).unwrap_or(default.color);
    let intensity = section.read("intensity", |v| v.number(report, Interval::LIGHT)).unwrap_or(default.intensity);
    let kind = match kind?.name {
        "directional" => directional(report, &section)?,
        _ => point(report, &section, default.kind),
    };
    let visible = section.read("visible", |v| v.boolean(report)).unwrap_or(default.visible);
    Some(LightDesc { name, kind, color, intensity, visible })
}

fn directional<'a>(report: &mut Report<'a>, section: &Section<'a>) -> Option<LightKind> {
    let form = "the way the light travels, as in direction = [0, -1, 0]";
    let direction = section.require(report, "direction", form)?.direction(report)?;
    Some(LightKind::Directional { direction })
}

fn point<'a>(report: &mut Report<'a>, section: &Section<'a>, default: LightKind) -> LightKind {
    let mut kind = default;
    if let LightKind::Point { position, falloff } = &mut kind {
        *position = section.read("position", |v| v.vec3(report, Interval::PLACE)).unwrap_or(*position);
        *falloff = section.read("falloff", |v| v.choice(report, Falloff::NAMES)).unwrap_or(*falloff);
    }
    kind
}
