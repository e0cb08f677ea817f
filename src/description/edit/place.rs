//! Moving, turning and scaling several objects and lights at once.

use super::super::{CameraDesc, LightKind, ObjectDesc, Refused, SceneDesc, Target};
use super::{attempt, require};
use crate::description::parameter::without_noise;
use glam::{DMat3, DQuat, DVec3};

/// A direction to transform along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// World +x.
    X,
    /// World +y.
    Y,
    /// World +z.
    Z,
    /// To the right in the picture.
    Right,
    /// Upward in the picture.
    Up,
    /// Away from the eye.
    Forward,
}

impl Axis {
    /// As a unit vector of world space.
    pub fn direction(self, camera: &CameraDesc) -> DVec3 {
        let forward = (camera.look_at - camera.position).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(camera.up).normalize_or(DVec3::X);
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::Right => right,
            Self::Up => right.cross(forward),
            Self::Forward => forward,
        }
    }
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Its corner with the least coordinates.
    pub lower: DVec3,
    /// Its corner with the greatest coordinates.
    pub upper: DVec3,
}

/// The middle of the box around all targets: objects by their box in world space, if `bounds` knows it, else by their
/// origin; point lights by their position. `None` if nothing of it has a place.
pub fn centre(desc: &SceneDesc, targets: &[Target], bounds: impl Fn(usize) -> Option<Bounds>) -> Option<DVec3> {
    let boxes = targets.iter().filter_map(|target| match *target {
        Target::Object(index) => {
            let origin = desc.objects.get(index)?.translate;
            Some(bounds(index).unwrap_or(Bounds { lower: origin, upper: origin }))
        }
        Target::Light(index) => match desc.lights.get(index)?.kind {
            LightKind::Point { position, .. } => Some(Bounds { lower: position, upper: position }),
            LightKind::Directional { .. } => None,
        },
        _ => None,
    });
    let all = boxes.reduce(|a, b| Bounds { lower: a.lower.min(b.lower), upper: a.upper.max(b.upper) })?;
    Some((all.lower + all.upper) / 2.0)
}

/// Moves objects and point lights by a vector of world space.
pub fn translate(desc: &mut SceneDesc, targets: &[Target], by: DVec3) -> Result<(), Refused> {
    transform(desc, targets, |place| match place {
        Place::Object(object) => object.translate = clean(object.translate + by),
        Place::Position(position) => *position = clean(*position + by),
        Place::Direction(_) => {}
    })
}

/// Turns objects and lights about an axis through `pivot`, both of world space, counter-clockwise when seen against the
/// axis.
pub fn rotate(
    desc: &mut SceneDesc,
    targets: &[Target],
    pivot: DVec3,
    axis: DVec3,
    degrees: f64,
) -> Result<(), Refused> {
    let Some(axis) = axis.try_normalize() else { return Err(Refused::new("an axis of 0, 0, 0 leads nowhere")) };
    let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
    let turned = |v: DVec3| clean(pivot + turn * (v - pivot));
    transform(desc, targets, |place| match place {
        Place::Object(object) => {
            object.translate = turned(object.translate);
            object.rotate = turned_angles(object.rotate, axis, degrees);
        }
        Place::Position(position) => *position = turned(*position),
        Place::Direction(direction) => *direction = clean(turn * *direction),
    })
}

/// Scales objects and the positions of point lights about `pivot`, by a factor along an axis of world space, or along
/// all if there is none. An object's own axes stay perpendicular: one that does not lie along the axis or across it is
/// scaled by how much longer the factor makes it (as Blender does), since a description cannot hold a shear.
pub fn scale(
    desc: &mut SceneDesc,
    targets: &[Target],
    pivot: DVec3,
    axis: Option<DVec3>,
    factor: f64,
) -> Result<(), Refused> {
    if factor == 0.0 || !factor.is_finite() {
        return Err(Refused::new("a scale of 0 leaves nothing"));
    }
    let axis = match axis {
        None => None,
        Some(axis) => Some(axis.try_normalize().ok_or_else(|| Refused::new("an axis of 0, 0, 0 leads nowhere"))?),
    };
    let stretched = |v: DVec3| match axis {
        None => v * factor,
        Some(axis) => v + axis * (axis.dot(v) * (factor - 1.0)),
    };
    let moved = |v: DVec3| clean(pivot + stretched(v - pivot));
    transform(desc, targets, |place| match place {
        Place::Object(object) => {
            object.translate = moved(object.translate);
            let own = rotation(object.rotate);
            let along = |unit: DVec3| {
                let image = stretched(unit);
                if image.dot(unit) < 0.0 { -image.length() } else { image.length() }
            };
            let factors = DVec3::new(along(own.x_axis), along(own.y_axis), along(own.z_axis));
            object.scale = clean(object.scale * factors);
        }
        Place::Position(position) => *position = moved(*position),
        Place::Direction(_) => {}
    })
}

/// What of an entry can be transformed.
enum Place<'a> {
    Object(&'a mut ObjectDesc),
    Position(&'a mut DVec3),
    Direction(&'a mut DVec3),
}

fn transform(desc: &mut SceneDesc, targets: &[Target], change: impl Fn(Place<'_>)) -> Result<(), Refused> {
    attempt(desc, |desc| {
        for &target in targets {
            require(desc, target)?;
            match target {
                Target::Object(index) => change(Place::Object(&mut desc.objects[index])),
                Target::Light(index) => match &mut desc.lights[index].kind {
                    LightKind::Point { position, .. } => change(Place::Position(position)),
                    LightKind::Directional { direction } => change(Place::Direction(direction)),
                },
                _ => return Err(Refused::new("only objects and lights can be moved, turned and scaled")),
            }
        }
        Ok(((), targets.to_vec()))
    })
}

fn clean(v: DVec3) -> DVec3 {
    v.map(without_noise)
}

/// Degrees about x, then y, then z, as a matrix.
fn rotation(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
}

/// The angles after a further turn. Of the many that mean the same those nearest to what was.
fn turned_angles(before: DVec3, axis: DVec3, degrees: f64) -> DVec3 {
    // Where the turn only adds to one of the angles, nothing is rounded.
    let about = |unit: DVec3| {
        axis.abs_diff_eq(unit, 1e-12).then_some(degrees).or(axis.abs_diff_eq(-unit, 1e-12).then_some(-degrees))
    };
    let (x, y, z) = (about(DVec3::X), about(DVec3::Y), about(DVec3::Z));
    if let Some(by) = z {
        return wrapped(before + DVec3::Z * by);
    }
    if let (Some(by), true) = (y, before.z == 0.0) {
        return wrapped(before + DVec3::Y * by);
    }
    if let (Some(by), true) = (x, before.z == 0.0 && before.y == 0.0) {
        return wrapped(before + DVec3::X * by);
    }
    let turn = DMat3::from_axis_angle(axis, degrees.to_radians());
    angles(turn * rotation(before), before)
}

/// Angles about x, then y, then z of a rotation, in degrees to 10 decimals: of those that mean the same the nearest to
/// `near`.
fn angles(m: DMat3, near: DVec3) -> DVec3 {
    let sine = (-m.x_axis.z).clamp(-1.0, 1.0);
    let cosine = m.x_axis.x.hypot(m.x_axis.y);
    let y = sine.atan2(cosine);
    let (x, z) = if cosine > 1e-9 {
        (m.y_axis.z.atan2(m.z_axis.z), m.x_axis.y.atan2(m.x_axis.x))
    } else {
        // Straight up or down, x and z turn about the same axis: x stays what it was.
        let x = near.x.to_radians();
        let (sin_x, cos_x) = x.sin_cos();
        let across = m.y_axis * cos_x - m.z_axis * sin_x;
        (x, (-across.x).atan2(across.y))
    };
    let found = DVec3::new(x, y, z).map(f64::to_degrees);
    let other = DVec3::new(found.x + 180.0, 180.0 - found.y, found.z + 180.0);
    let nearest = |v: DVec3| v + ((near - v) / 360.0).round() * 360.0;
    let (found, other) = (nearest(found), nearest(other));
    let best = if other.distance_squared(near) < found.distance_squared(near) - 1e-9 { other } else { found };
    wrapped(best.map(|v| (v * 1e10).round() / 1e10))
}

/// Within one turn either way, so that turning for hours stays within the limits.
fn wrapped(degrees: DVec3) -> DVec3 {
    degrees.map(|v| without_noise(if v.abs() > 360.0 { v % 360.0 } else { v }))
}
