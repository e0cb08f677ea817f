//! Items 8 and 11: how much of the light is reflected.

use crate::UNSPENT;
use crate::support::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;

/// An endless sea of this material, seen from `eye`.
fn sea(material: MaterialDesc, eye: DVec3, look_at: DVec3, fov: f64) -> SceneDesc {
    let mut d = desc(90, 70, perspective(eye, look_at, DVec3::Y, fov));
    d.world.background = SKY;
    d.objects = vec![object(ShapeDesc::Plane, &material.name)];
    d.materials = vec![material];
    d
}

/// y of the direction of light refracted at the horizontal surface, index n behind over before; keeps the sign of y.
fn refracted_y(y: f64, n: f64) -> f64 {
    // sin(t) = sin(i) / n.
    (1.0 - (1.0 - y * y) / (n * n)).sqrt().copysign(y)
}

#[test]
fn from_under_water_the_sky_fits_into_snells_window_and_the_rest_is_a_mirror() {
    // Rays at less than asin(1/n) from the vertical leave the water, sin(t) = n sin(i); all others are reflected
    // whole and never meet anything again.
    let n = 1.333;
    let mut d = sea(clear("water", n), v(0.0, -3.0, 0.0), v(0.0, 0.0, -1.5), 110.0);
    d.render.max_depth = 2;
    let (mut window, mut mirror) = (0, 0);
    let excluded = assert_exact("snell-window", &d, 1e-12, |x, y| {
        let (_, dir) = pixel_ray(&d, x, y);
        let sin = (1.0 - dir.y * dir.y).sqrt();
        if dir.y <= 0.0 {
            return Some(sky(dir.y));
        }
        // At the critical angle the direction of what leaves has an infinite slope.
        if (sin * n - 1.0).abs() < 1e-6 {
            return None;
        }
        if sin * n > 1.0 {
            mirror += 1;
            return Some(sky(-dir.y));
        }
        window += 1;
        Some(sky(refracted_y(dir.y, 1.0 / n)))
    });
    assert!(excluded <= 2 && window > 500 && mirror > 500, "{excluded} {window} {mirror}");
}

#[test]
fn the_radius_of_snells_window_is_the_critical_angle() {
    // Straight up without a sky gradient: sky white above, water black below; the disc has the radius tan(asin(1/n))
    // at distance 1 from the eye.
    let n = 1.333;
    let mut d = sea(clear("water", n), v(0.0, -1.0, 0.0), DVec3::ZERO, 110.0);
    d.camera.up = DVec3::NEG_Z;
    d.film = FilmDesc { width: 301, height: 301 };
    d.world.background = Background::Solid(Rgb::WHITE);
    // What is reflected back into the depth meets a black floor.
    d.materials.push(bare("black", Rgb::BLACK));
    d.objects.push(quad(v(0.0, -2.0, 0.0), 1e6, DVec3::ZERO, "black"));
    d.render.samples = 4;
    let pixel = 2.0 * 55_f64.to_radians().tan() / 301.0;
    let radius = (sum(&render(&d)) / std::f64::consts::PI).sqrt() * pixel;
    let want = (1.0 / n).asin().tan();
    assert!((radius - want).abs() < 0.25 * pixel, "{radius}, expected {want}");
}

#[test]
fn a_sea_reflects_by_fresnels_equations_from_above_and_from_below() {
    // F of what comes along the mirrored direction, 1 - F of what comes through. Neither ray meets anything else.
    let n = 1.5;
    for (eye, look_at, ratio) in
        [(v(0.0, 2.0, 0.0), v(0.0, 0.0, -2.0), n), (v(0.0, -2.0, 0.0), v(0.0, 0.0, -2.0), 1.0 / n)]
    {
        let d = sea(fresnel("sea", n), eye, look_at, 85.0);
        let excluded = assert_exact("fresnel-sea", &d, 1e-12, |x, y| {
            let (_, dir) = pixel_ray(&d, x, y);
            if dir.y * eye.y >= 0.0 {
                return Some(sky(dir.y));
            }
            let sin = (1.0 - dir.y * dir.y).sqrt() / ratio;
            if (sin - 1.0).abs() < 1e-6 {
                return None;
            }
            let f = fresnel_reflectance(dir.y.abs(), ratio);
            let reflected = scale(sky(-dir.y), f);
            Some(if sin > 1.0 { reflected } else { plus(reflected, scale(sky(refracted_y(dir.y, ratio)), 1.0 - f)) })
        });
        assert!(excluded <= 2);
    }
}

/// Reflectance that a picture shows at angle of incidence `i`: white sky, black depth.
fn reflectance_seen(n: f64, i: f64, from_below: bool) -> f64 {
    let side = if from_below { -1.0 } else { 1.0 };
    let eye = v(i.sin(), i.cos() * side, 0.0);
    let mut d = desc(1, 1, orthographic(eye, DVec3::ZERO, DVec3::Z, 1e-9));
    d.world.background = Background::Solid(Rgb::WHITE);
    d.materials = vec![fresnel("glass", n), bare("black", Rgb::BLACK)];
    // Everything that goes through ends on black.
    d.objects = vec![object(ShapeDesc::Plane, "glass"), quad(v(0.0, -3.0 * side, 0.0), 1e5, DVec3::ZERO, "black")];
    f64::from(render(&d).pixel(0, 0)[0])
}

#[test]
fn normal_incidence_reflects_the_square_of_the_relative_step_of_the_index() {
    for n in [1.05, 1.333, 1.5, 2.42_f64] {
        let want = ((n - 1.0) / (n + 1.0)).powi(2);
        for below in [false, true] {
            let got = reflectance_seen(n, 0.0, below);
            assert!((got - want).abs() < 1e-7, "n = {n}: {got}, expected {want}");
        }
    }
}

#[test]
fn at_brewsters_angle_only_the_polarisation_across_the_plane_of_incidence_is_reflected() {
    // tan(i) = n: reflected and refracted ray are at right angles, tan(i + t) is infinite and R_p = 0; what is left of
    // the unpolarised mean is half of R_s = ((n² - 1) / (n² + 1))². From inside the angle is atan(1/n), R_s the same.
    for n in [1.333, 1.5, 2.0_f64] {
        let want = ((n * n - 1.0) / (n * n + 1.0)).powi(2) / 2.0;
        for (angle, below) in [(n.atan(), false), ((1.0 / n).atan(), true)] {
            let got = reflectance_seen(n, angle, below);
            assert!((got - want).abs() < 1e-7, "n = {n}: {got}, expected {want}");
        }
    }
}

#[test]
fn reflected_and_transmitted_light_add_up_to_all_of_it() {
    // R + T = 1 under a sky that is 1 everywhere, at any angle, from both sides, at and beyond the critical angle.
    for (eye, fov) in [(v(0.0, 2.0, 0.0), 100.0), (v(0.0, -2.0, 0.0), 150.0)] {
        let mut d = sea(fresnel("sea", 1.5), eye, v(0.0, 0.0, -0.7), fov);
        d.world.background = Background::Solid(Rgb::WHITE);
        assert_exact("r-plus-t", &d, 1e-12, |_, _| Some([1.0; 3]));
    }
}

#[test]
fn a_fresnel_mirror_without_transmission_reflects_its_part_of_the_coefficient() {
    // k_t = 0: nothing to split, k_r F is reflected.
    let material = MaterialDesc { reflect: 0.8, transmit: 0.0, ..fresnel("lacquer", 1.5) };
    let d = sea(material, v(0.0, 2.0, 0.0), v(0.0, 0.0, -1.0), 80.0);
    assert_exact("lacquer", &d, 1e-12, |x, y| {
        let (_, dir) = pixel_ray(&d, x, y);
        if dir.y >= 0.0 {
            return Some(sky(dir.y));
        }
        Some(scale(sky(-dir.y), 0.8 * fresnel_reflectance(-dir.y, 1.5)))
    });
}

#[test]
fn a_fresnel_ball_in_a_white_furnace_misses_only_what_the_depth_cuts_off() {
    // Inside a ball every reflection has the F of the first. The part F is reflected (1 step), and
    // (1 - F)² F^k leaves after k reflections inside (k + 2 steps): F + (1 - F)² sum F^k = 1, and cut at depth m >= 2
    // what is missing is (1 - F) F^(m-1).
    let n = 1.5;
    let mut d = desc(64, 64, perspective(v(0.3, 0.5, 3.0), DVec3::ZERO, DVec3::Y, 50.0));
    d.world.background = Background::Solid(Rgb::WHITE);
    d.materials = vec![fresnel("glass", n)];
    d.objects = vec![sphere(DVec3::ZERO, 1.0, "glass")];
    for depth in 0..=10 {
        d.render.max_depth = depth;
        let excluded = assert_exact("furnace", &d, UNSPENT, |x, y| {
            let (o, dir) = pixel_ray(&d, x, y);
            let b = (o - dir * o.dot(dir)).length();
            // F runs to 1 with an infinite slope at the limb.
            if (b - 1.0).abs() < 1e-6 {
                return None;
            }
            if b > 1.0 {
                return Some([1.0; 3]);
            }
            let f = fresnel_reflectance((1.0 - b * b).sqrt(), n);
            Some(
                [match depth {
                    0 => 0.0,
                    1 => f,
                    m => 1.0 - (1.0 - f) * f.powi(m as i32 - 1),
                }; 3],
            )
        });
        assert!(excluded <= 2);
    }
}

#[test]
fn many_glass_bodies_in_a_white_furnace_never_make_light_and_lose_little() {
    // Nested and neighbouring bodies: energy is never made, and at the deepest setting almost none is lost.
    let mut d = desc(40, 30, perspective(v(1.0, 1.5, 5.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.world.background = Background::Solid(Rgb::WHITE);
    d.materials = vec![fresnel("glass", 1.5), fresnel("water", 1.33), fresnel("air", 1.0)];
    d.objects = vec![
        sphere(DVec3::ZERO, 1.0, "glass"),
        sphere(v(0.1, 0.1, 0.0), 0.5, "air"),
        cuboid(v(1.8, 0.0, 0.0), v(1.0, 1.0, 1.0), "water"),
        at(v(-1.7, 0.0, 0.0), object(ShapeDesc::Cylinder { radius: 0.5, height: 1.0 }, "glass")),
    ];
    let mut before = vec![0.0; 40 * 30];
    for depth in [2, 5, 9, 12] {
        d.render.max_depth = depth;
        let film = render(&d);
        for (i, p) in film.pixels().iter().enumerate() {
            let got = f64::from(p[0]);
            assert!(got <= 1.0 + 1e-6, "pixel {i} at depth {depth}: {got}");
            assert!(got >= before[i] - 1e-6, "pixel {i} is darker at depth {depth}: {got} < {}", before[i]);
            before[i] = got;
        }
    }
    // A cube holds light by total reflection for ever; the mean is what can be asked for.
    let mean = before.iter().sum::<f64>() / before.len() as f64;
    assert!(mean > 0.97, "mean {mean}");
}
