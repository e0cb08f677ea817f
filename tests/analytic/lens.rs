//! Item 6: a ball of glass.

use crate::support::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;
use std::f64::consts::PI;

/// The way out of a glass ball (centre 0, radius r, index n) of light that comes along a unit direction: where it
/// leaves and whereto, or `None` if it passes by. In the plane of ray and centre, with i = asin(b) for the impact
/// parameter b (in radii) and t = asin(b / n), the ray is turned by 2 (i - t) in all toward the axis, and the chord
/// inside spans the angle pi - 2 t at the centre.
fn through_ball(o: DVec3, d: DVec3, r: f64, n: f64) -> Option<(DVec3, DVec3)> {
    let foot = o - d * o.dot(d);
    let b = foot.length() / r;
    if b >= 1.0 {
        return None;
    }
    let side = foot.normalize_or_zero();
    let (i, t) = (b.asin(), (b / n).asin());
    // Angles at the centre from the direction toward the light's source.
    let exit = i + PI - 2.0 * t;
    let turned = 2.0 * (i - t);
    Some((r * (side * exit.sin() - d * exit.cos()), d * turned.cos() - side * turned.sin()))
}

#[test]
fn a_glass_ball_bends_every_ray_by_the_closed_form_and_the_ruler_behind_it_shows_where_to() {
    let r = 1.0;
    let cameras = [
        orthographic(v(0.0, 0.0, 9.0), DVec3::ZERO, DVec3::Y, 2.6),
        perspective(v(0.7, 0.4, 4.0), v(0.1, 0.0, 0.0), DVec3::Y, 36.0),
        perspective(v(0.0, 0.3, 1.3), DVec3::ZERO, DVec3::Y, 60.0),
    ];
    for camera in cameras {
        for n in [1.5, 1.3, 1.9] {
            let mut d = desc(81, 61, camera);
            let ruler = Ruler::new(v(0.0, 0.0, -4.0), DVec3::Z, 1.2, 1.5);
            ruler.add_to(&mut d, 2000.0);
            d.materials.push(clear("glass", n));
            d.objects.push(sphere(DVec3::ZERO, r, "glass"));
            // Rays that graze amplify rounding: asin(b) has the slope 1 / sqrt(1 - b²).
            let mut seen = 0;
            let excluded = assert_exact("ball-lens-ruler", &d, 1e-9, |x, y| {
                let (o, dir) = pixel_ray(&d, x, y);
                let b = (o - dir * o.dot(dir)).length() / r;
                if (b - 1.0).abs() < 1e-6 {
                    return None;
                }
                let Some((o, dir)) = through_ball(o, dir, r, n) else { return Some(ruler.seen_by(o, dir)) };
                seen += 1;
                // Bent away from the ruler: nothing there.
                Some(if dir.z < 0.0 { ruler.seen_by(o, dir) } else { [0.0; 3] })
            });
            assert!(excluded <= 2 && seen > 500, "{excluded} {seen}");
        }
    }
}

#[test]
fn the_whole_image_of_a_checkerboard_through_a_glass_ball_is_the_closed_form() {
    let (r, n, size) = (1.0, 1.5, 0.25);
    let (white, blue) = (Rgb::new(0.9, 0.8, 0.7), Rgb::new(0.1, 0.2, 0.6));
    let mut d = desc(240, 180, perspective(v(0.4, 0.9, 4.5), v(0.0, 0.1, 0.0), DVec3::Y, 34.0));
    // A board that stands at z = -2.5: an infinite plane turned up; u = x, v = y there.
    d.materials =
        vec![MaterialDesc { texture: checker(white, blue, size), ..flat("board", Rgb::WHITE) }, clear("glass", n)];
    d.objects = vec![
        ObjectDesc { rotate: v(90.0, 0.0, 0.0), ..at(v(0.0, 0.0, -2.5), object(ShapeDesc::Plane, "board")) },
        sphere(DVec3::ZERO, r, "glass"),
    ];
    let mut through = 0;
    let excluded = assert_exact("ball-lens-checker", &d, 1e-12, |x, y| {
        let (o, dir) = pixel_ray(&d, x, y);
        let b = (o - dir * o.dot(dir)).length() / r;
        if (b - 1.0).abs() < 1e-9 {
            return None;
        }
        let (o, dir) = through_ball(o, dir, r, n).inspect(|_| through += 1).unwrap_or((o, dir));
        if dir.z >= 0.0 {
            return Some([0.0; 3]);
        }
        let p = meet_plane(o, dir, v(0.0, 0.0, -2.5), DVec3::Z);
        let (s, t) = (p.x / size, p.y / size);
        // Nearer to an edge than rounding can tell; what is bent far off lands far out, with larger numbers.
        let margin = 1e-11 * (1.0 + s.abs() + t.abs()).powi(2) / (1.0 - b).abs().max(1e-6);
        if (s - s.round()).abs() < margin || (t - t.round()).abs() < margin {
            return None;
        }
        let even = (s.floor() + t.floor()).rem_euclid(2.0) == 0.0;
        Some(if even { [0.9, 0.8, 0.7] } else { [0.1, 0.2, 0.6] })
    });
    assert!(excluded <= 4, "{excluded} pixels too near to an edge");
    assert!(through > 8000, "{through}");
}

#[test]
fn a_ball_lens_focuses_at_its_back_focal_length() {
    // EFL = n D / (4 (n - 1)) from the centre, so BFL = R (2 - n) / (2 (n - 1)) behind the back surface. Spherical
    // aberration: a ray at b (in radii) crosses the focal plane at a distance that goes with b³. A white spot there
    // fills the paraxial aperture; a tenth of the focal length nearer or farther it does not.
    let (r, n) = (1.0, 1.5_f64);
    let efl = n * 2.0 * r / (4.0 * (n - 1.0));
    let bfl: f64 = r * (2.0 - n) / (2.0 * (n - 1.0));
    assert!((efl - r - bfl).abs() < 1e-15);
    let aperture = 0.15;
    let count = |z: f64| {
        let mut d = desc(80, 80, orthographic(v(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 2.0 * aperture));
        d.materials = vec![clear("glass", n), flat("spot", Rgb::WHITE)];
        d.objects = vec![sphere(DVec3::ZERO, r, "glass"), quad(v(0.0, 0.0, -z), 0.01, v(90.0, 0.0, 0.0), "spot")];
        let film = render(&d);
        // In the middle of the picture, b < 0.15.
        let inside = |x: u32, y: u32| pixel_ray(&d, x, y).0.truncate().length() < aperture;
        let white = |x: u32, y: u32| inside(x, y) && film.pixel(x, y)[0] > 0.5;
        (0..80).flat_map(|y| (0..80).map(move |x| (x, y))).filter(|&(x, y)| white(x, y)).count() as f64
            / (0..80).flat_map(|y| (0..80).map(move |x| (x, y))).filter(|&(x, y)| inside(x, y)).count() as f64
    };
    assert_eq!(count(efl), 1.0);
    assert!(count(1.1 * efl) < 0.3 && count(0.9 * efl - 0.05) < 0.3);
}

/// Angle by which light has turned after entering a ball at impact parameter b and k reflections inside:
/// 2 (i - t) + k (pi - 2 t).
fn turned(b: f64, n: f64, k: u32) -> f64 {
    let (i, t) = (b.asin(), (b / n).asin());
    2.0 * (i - t) + f64::from(k) * (PI - 2.0 * t)
}

#[test]
fn reflections_inside_a_ball_add_up_to_the_closed_form_at_every_depth() {
    // Seen from above, light going down: the part k_r is mirrored (turned by pi - 2 i), and k_t k_r^k k_t leaves after
    // k reflections inside, which takes k + 2 steps of depth. The background is known by the y of the direction,
    // which is -cos(turned).
    let (n, kr, kt) = (1.333, 0.35, 0.6);
    let mut d = desc(61, 61, orthographic(v(0.0, 7.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.2));
    d.world.background = SKY;
    d.materials = vec![MaterialDesc { reflect: kr, ..clear("drop", n) }];
    d.materials[0].transmit = kt;
    d.objects = vec![sphere(DVec3::ZERO, 1.0, "drop")];
    for depth in 0..=7 {
        d.render.max_depth = depth;
        let excluded = assert_exact("drop", &d, 1e-9, |x, y| {
            let (o, _) = pixel_ray(&d, x, y);
            let b = o.x.hypot(o.z);
            if (b - 1.0).abs() < 1e-6 {
                return None;
            }
            if b > 1.0 {
                return Some(sky(-1.0));
            }
            let mut sum = [0.0; 3];
            if depth >= 1 {
                sum = plus(sum, scale(sky(-(PI - 2.0 * b.asin()).cos()), kr));
            }
            for k in 0..depth.saturating_sub(1) {
                sum = plus(sum, scale(sky(-turned(b, n, k).cos()), kt * kr.powi(k as i32) * kt));
            }
            Some(sum)
        });
        assert!(excluded <= 2);
    }
}

#[test]
fn the_rainbow_stands_at_descartes_angle() {
    // Light reflected once inside a drop is turned least at cos(i) = sqrt((n² - 1) / 3): 42 degrees from the direction
    // back to the sun for water. The picture of depth 3 less that of depth 2 is that light alone (times k_t² k_r); its
    // colour gives the y of its direction, -cos(turned), the least of which over all pixels is the bow.
    let (n, kr, kt) = (1.333, 0.5, 0.5);
    let mut d = desc(401, 1, orthographic(v(0.0, 7.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.0 / 401.0));
    d.world.background = SKY;
    d.materials = vec![MaterialDesc { reflect: kr, transmit: kt, ..clear("drop", n) }];
    d.objects = vec![sphere(DVec3::ZERO, 1.0, "drop")];
    let at_depth = |depth| {
        let mut d = d.clone();
        d.render.max_depth = depth;
        render(&d)
    };
    let (three, two) = (at_depth(3), at_depth(2));
    let mut bow = (f64::INFINITY, 0.0);
    for x in 0..401 {
        let b = pixel_ray(&d, x, 0).0.x.abs();
        let red = (f64::from(three.pixel(x, 0)[0]) - f64::from(two.pixel(x, 0)[0])) / (kt * kt * kr);
        let y = (red - 0.1) / 0.9 * 2.0 - 1.0;
        let angle = PI - (-y).acos(); // From the way back to the sun.
        if -angle < bow.0 {
            bow = (-angle, b);
        }
    }
    let i = ((n * n - 1.0) / 3.0_f64).sqrt().acos();
    let want = PI - turned(i.sin(), n, 1);
    // Sampled at steps of 0.005 in b around a flat maximum: 1e-4 rad is far more than needed.
    assert!((-bow.0 - want).abs() < 1e-4, "{} degrees, expected {}", -bow.0.to_degrees(), want.to_degrees());
    assert!((bow.1 - i.sin()).abs() < 0.02, "at b = {}, expected {}", bow.1, i.sin());
    assert!((want.to_degrees() - 42.08).abs() < 0.05);
}
