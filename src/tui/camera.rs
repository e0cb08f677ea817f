//! Moves of the camera.

use crate::description::{CameraDesc, Projection};
use glam::{DQuat, DVec3};

/// Angles of view that keys can reach, degrees.
const FOV: std::ops::RangeInclusive<f64> = 2.0..=150.0;
/// Nearest the view may come to straight up or down, degrees.
const POLE: f64 = 1.0;
/// Lengths that keys can reach, scene units: far inside of what f64 can square.
const LENGTH: std::ops::RangeInclusive<f64> = 1e-6..=1e9;

/// Unit vectors of the view: forward, right, up (of the picture).
fn axes(camera: &CameraDesc) -> [DVec3; 3] {
    let forward = (camera.look_at - camera.position).try_normalize().unwrap_or(DVec3::NEG_Z);
    let right = forward.cross(camera.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    [forward, right, right.cross(forward)]
}

/// Moves the eye on a sphere about the point looked at: `right` degrees to its right about `up`, `above` degrees
/// toward `up`, never over the pole.
pub fn orbit(camera: &mut CameraDesc, right: f64, above: f64) {
    let Some(up) = camera.up.try_normalize() else { return };
    let arm = camera.position - camera.look_at;
    let [_, side, _] = axes(camera);
    // The angle between arm and up, now and afterwards.
    let polar = arm.angle_between(up).to_degrees();
    let tilt = polar - (polar - above).clamp(POLE, 180.0 - POLE);
    let turn = DQuat::from_axis_angle(up, right.to_radians()) * DQuat::from_axis_angle(side, -tilt.to_radians());
    camera.position = camera.look_at + turn * arm;
}

/// Moves eye and point looked at by parts of the view's height, right and up in the picture.
pub fn pan(camera: &mut CameraDesc, right: f64, above: f64) {
    let [_, side, up] = axes(camera);
    let height = match camera.projection {
        Projection::Perspective { fov } => {
            2.0 * (camera.look_at - camera.position).length() * (fov.to_radians() / 2.0).tan()
        }
        Projection::Orthographic { view_height } => view_height,
    };
    let shift = (side * right + up * above) * height;
    if (camera.look_at + shift).abs().max_element() <= *LENGTH.end() {
        camera.position += shift;
        camera.look_at += shift;
    }
}

/// Multiplies the distance to the point looked at by `factor`; an orthographic view, which distance does not change,
/// is scaled.
pub fn dolly(camera: &mut CameraDesc, factor: f64) {
    match &mut camera.projection {
        Projection::Perspective { .. } => {
            let arm = camera.position - camera.look_at;
            let distance = arm.length();
            if distance > 0.0 {
                let wanted = (distance * factor).clamp(*LENGTH.start(), *LENGTH.end());
                camera.position = camera.look_at + arm * (wanted / distance);
            }
        }
        Projection::Orthographic { view_height } => scale_height(view_height, factor),
    }
}

/// Multiplies the angle of view by `factor`, or the height of an orthographic view.
pub fn widen(camera: &mut CameraDesc, factor: f64) {
    match &mut camera.projection {
        // A start outside of what keys reach may stay there, but moves only inward.
        Projection::Perspective { fov } => *fov = (*fov * factor).clamp(FOV.start().min(*fov), FOV.end().max(*fov)),
        Projection::Orthographic { view_height } => scale_height(view_height, factor),
    }
}

/// Looks from the same side at a ball, which then fills the view. `aspect`: width of the picture by its height.
pub fn frame(camera: &mut CameraDesc, aspect: f64, centre: DVec3, radius: f64) {
    /// Air around the ball.
    const MARGIN: f64 = 1.1;
    let [forward, ..] = axes(camera);
    let distance = camera.position.distance(camera.look_at);
    let radius = if radius > 0.0 { (radius * MARGIN).clamp(*LENGTH.start(), *LENGTH.end()) } else { distance / 4.0 };
    let distance = match &mut camera.projection {
        Projection::Perspective { fov } => {
            let half = (fov.to_radians() / 2.0).tan() * aspect.min(1.0);
            radius / half.atan().sin()
        }
        Projection::Orthographic { view_height } => {
            *view_height = (2.0 * radius / aspect.min(1.0)).clamp(*LENGTH.start(), *LENGTH.end());
            distance.max(2.0 * radius)
        }
    };
    let distance = distance.clamp(*LENGTH.start(), *LENGTH.end());
    if (centre.abs().max_element()) <= *LENGTH.end() {
        (camera.look_at, camera.position) = (centre, centre - forward * distance);
    }
}

fn scale_height(height: &mut f64, factor: f64) {
    *height = (*height * factor).clamp(*LENGTH.start(), *LENGTH.end());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} is not {b}");
    }

    fn elevation(camera: &CameraDesc) -> f64 {
        90.0 - (camera.position - camera.look_at).angle_between(camera.up).to_degrees()
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_comes_round() {
        let start = CameraDesc::default();
        let mut camera = start;
        for _ in 0..72 {
            orbit(&mut camera, 5.0, 0.0);
            near(camera.position.length(), start.position.length());
            near(camera.position.y, start.position.y);
        }
        assert!(camera.position.abs_diff_eq(start.position, 1e-9));
    }

    #[test]
    fn an_orbit_to_the_right_moves_the_eye_to_its_right() {
        let mut camera = CameraDesc { position: DVec3::Z, ..CameraDesc::default() };
        orbit(&mut camera, 90.0, 0.0);
        assert!(camera.position.abs_diff_eq(DVec3::X, 1e-12));
        near(elevation(&camera), 0.0);
        orbit(&mut camera, 0.0, 30.0);
        near(elevation(&camera), 30.0);
    }

    #[test]
    fn no_orbit_goes_over_the_pole() {
        for above in [7.0, -7.0, 500.0, -500.0] {
            let mut camera = CameraDesc::default();
            for _ in 0..100 {
                orbit(&mut camera, 1.0, above);
            }
            near(elevation(&camera).abs(), 90.0 - POLE);
            assert!(camera.position.is_finite());
            near(camera.position.length(), CameraDesc::default().position.length());
        }
    }

    #[test]
    fn a_pan_moves_eye_and_target_alike_across_the_view() {
        let start = CameraDesc { projection: Projection::Perspective { fov: 90.0 }, ..CameraDesc::default() };
        let mut camera = start;
        pan(&mut camera, 0.5, 0.25);
        let shift = camera.look_at - start.look_at;
        assert!((camera.position - start.position).abs_diff_eq(shift, 1e-12));
        near(shift.dot(start.look_at - start.position), 0.0);
        // At 90 degrees the view is twice as high as far away.
        near(shift.length(), 0.5f64.hypot(0.25) * 2.0 * start.position.length());
    }

    #[test]
    fn dolly_scales_the_distance_and_stays_in_range() {
        let mut camera = CameraDesc::default();
        dolly(&mut camera, 0.5);
        near(camera.position.length(), CameraDesc::default().position.length() / 2.0);
        for factor in [0.5, 2.0] {
            for _ in 0..200 {
                dolly(&mut camera, factor);
                assert!(camera.position.is_finite() && camera.position != camera.look_at);
            }
        }
        let mut camera =
            CameraDesc { projection: Projection::Orthographic { view_height: 2.0 }, ..CameraDesc::default() };
        dolly(&mut camera, 0.5);
        assert_eq!(camera.projection, Projection::Orthographic { view_height: 1.0 });
    }

    #[test]
    fn a_framed_ball_touches_the_nearer_edges_of_the_view_but_for_a_margin() {
        for (aspect, projection) in [
            (16.0 / 9.0, Projection::Perspective { fov: 40.0 }),
            (0.5, Projection::Perspective { fov: 70.0 }),
            (0.5, Projection::Orthographic { view_height: 77.0 }),
        ] {
            let start = CameraDesc { projection, ..CameraDesc::default() };
            let mut camera = start;
            let centre = DVec3::new(1.0, -2.0, 3.0);
            frame(&mut camera, aspect, centre, 2.0);
            assert_eq!(camera.look_at, centre);
            assert!(axes(&camera)[0].abs_diff_eq(axes(&start)[0], 1e-12));
            match camera.projection {
                Projection::Perspective { fov } => {
                    let half = ((fov.to_radians() / 2.0).tan() * aspect.min(1.0)).atan();
                    near((2.2 / camera.position.distance(centre)).asin(), half);
                }
                Projection::Orthographic { view_height } => near(view_height * aspect, 4.4),
            }
        }
    }

    #[test]
    fn the_angle_of_view_stays_in_range() {
        let mut camera = CameraDesc::default();
        for (factor, limit) in [(1.2, *FOV.end()), (0.8, *FOV.start())] {
            for _ in 0..100 {
                widen(&mut camera, factor);
            }
            assert_eq!(camera.projection, Projection::Perspective { fov: limit });
        }
        let mut odd = CameraDesc { projection: Projection::Perspective { fov: 175.0 }, ..CameraDesc::default() };
        widen(&mut odd, 1.1);
        assert_eq!(odd.projection, Projection::Perspective { fov: 175.0 });
    }
}
