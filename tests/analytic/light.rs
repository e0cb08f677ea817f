//! Items 1, 2 and 4: what lights do to matte surfaces.

use crate::support::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;

const WHITE: Rgb = Rgb::WHITE;

/// A matte ball of radius `r` at the origin, seen from +z without perspective, and the direction to the sun at phase
/// angle `alpha` from the direction to the eye.
fn lit_ball(side: u32, r: f64, alpha: f64) -> (SceneDesc, DVec3) {
    let mut d = desc(side, side, orthographic(v(0.0, 0.0, 10.0), DVec3::ZERO, DVec3::Y, 2.2 * r));
    // Tilted about the view axis, so that rows and columns are not alike.
    let tilt = 0.3_f64;
    let toward = v(alpha.sin() * tilt.cos(), alpha.sin() * tilt.sin(), alpha.cos());
    d.materials.push(matte("matte", Rgb::new(0.9, 0.5, 0.2)));
    d.objects.push(sphere(DVec3::ZERO, r, "matte"));
    d.lights.push(sun(toward, Rgb::new(1.0, 0.8, 0.6), 1.5));
    (d, toward)
}

#[test]
fn a_lambert_ball_under_the_sun_has_the_exact_value_in_every_pixel() {
    // At (x, y) of the picture the normal of the ball is (x, y, sqrt(r² - x² - y²)) / r, and the colour
    // k_d I C max(0, (n, l)), nothing outside. A convex body throws no shadow on what faces the light, so that
    // Whitted's model gives the same.
    for alpha in [0.0, 0.7, 1.6, 2.5_f64] {
        let (mut d, toward) = lit_ball(101, 1.3, alpha);
        for shading in [Shading::Lambert, Shading::Phong, Shading::Whitted] {
            d.render.shading = shading;
            let film = render(&d);
            assert_image("lambert-ball", &film, EXACT, |x, y| {
                let (o, _) = pixel_ray(&d, x, y);
                let z2 = 1.3 * 1.3 - o.x * o.x - o.y * o.y;
                if z2 < 0.0 {
                    return Some([0.0; 3]);
                }
                let cos = (v(o.x, o.y, z2.sqrt()) / 1.3).dot(toward).max(0.0);
                Some([0.9 * 1.0 * 1.5 * cos, 0.5 * 0.8 * 1.5 * cos, 0.2 * 0.6 * 1.5 * cos])
            });
        }
    }
}

#[test]
fn the_light_of_a_lambert_ball_adds_up_to_its_phase_integral() {
    // The integral of max(0, (n, l)) over the visible disc is (2/3) r² (sin a + (pi - a) cos a) (Lambert's sphere).
    for alpha in [0.0, 0.7, 1.6, 2.5_f64] {
        let (mut d, _) = lit_ball(200, 1.3, alpha);
        d.render.samples = 16;
        let pixel = (2.2 * 1.3 / 200.0_f64).powi(2);
        let got = sum(&render(&d)) * pixel / (0.9 * 1.5);
        let want = 2.0 / 3.0 * 1.3 * 1.3 * (alpha.sin() + (std::f64::consts::PI - alpha) * alpha.cos());
        // 40,000 pixels of 16 stratified samples: the limb is about 500 pixels, each known to some 5 %.
        assert!((got - want).abs() < 2e-4 * 1.3 * 1.3, "at {alpha}: {got}, expected {want}");
    }
}

#[test]
fn the_lighting_equation_has_every_term_as_written() {
    // I = k_a I_a C + k_d sum I_i (n, l_i) C + k_s sum I_i (v, r_i)^s on a floor seen at a slant, no perspective: the
    // only thing that varies is the direction to the point light. r_i is l_i mirrored in the normal.
    let mut d = desc(64, 48, orthographic(v(4.0, 5.0, 3.0), DVec3::ZERO, DVec3::Y, 4.0));
    d.world.ambient = Rgb::new(0.3, 0.6, 0.9);
    let c = [0.8, 0.4, 0.2];
    d.materials.push(MaterialDesc {
        ambient: 0.25,
        diffuse: 0.7,
        specular: 0.4,
        shininess: 7.5,
        ..bare("floor", Rgb::new(c[0], c[1], c[2]))
    });
    d.objects.push(object(ShapeDesc::Plane, "floor"));
    let (lamp, toward) = (v(-1.0, 1.5, -0.5), v(-3.0, 2.0, -1.0).normalize());
    d.lights.push(point_light(lamp, Rgb::new(1.0, 0.9, 0.5), 0.8, Falloff::None));
    d.lights.push(sun(toward, Rgb::new(0.2, 0.5, 1.0), 0.6));
    for shading in [Shading::Lambert, Shading::Phong, Shading::Whitted] {
        d.render.shading = shading;
        let highlight = if shading == Shading::Lambert { 0.0 } else { 0.4 };
        assert_exact("lighting-equation", &d, 1e-12, |x, y| {
            let (o, dir) = pixel_ray(&d, x, y);
            let p = meet_plane(o, dir, DVec3::ZERO, DVec3::Y);
            let mut sum = [0.25 * 0.3 * c[0], 0.25 * 0.6 * c[1], 0.25 * 0.9 * c[2]];
            for (l, i) in [((lamp - p).normalize(), [0.8, 0.72, 0.4]), (toward, [0.12, 0.3, 0.6])] {
                let r = v(-l.x, l.y, -l.z);
                let phong = (-dir).dot(r).max(0.0).powf(7.5);
                for k in 0..3 {
                    sum[k] += i[k] * (0.7 * l.y * c[k] + highlight * phong);
                }
            }
            Some(sum)
        });
    }
}

#[test]
fn a_point_light_over_a_plane_follows_the_inverse_square_law() {
    // At distance rho from the foot of a light at height h: I cos(theta) / d² = I h / (h² + rho²)^(3/2).
    let (h, intensity) = (1.7, 2.5);
    let mut d = desc(90, 70, orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 12.0));
    d.materials.push(matte("floor", WHITE));
    d.objects.push(object(ShapeDesc::Plane, "floor"));
    d.lights.push(point_light(v(0.4, h, -0.3), WHITE, intensity, Falloff::InverseSquare));
    assert_exact("inverse-square", &d, 1e-12, |x, y| {
        let (o, _) = pixel_ray(&d, x, y);
        let rho2 = (o.x - 0.4).powi(2) + (o.z + 0.3).powi(2);
        Some([intensity * h / (h * h + rho2).powf(1.5); 3])
    });
}

#[test]
fn the_flux_of_a_point_light_through_a_plane_is_two_pi() {
    // The flux through the square |x|, |z| < a is the solid angle that it fills, 4 asin(a² / (a² + h²)), which goes to
    // 2 pi as a grows. The sum over pixel centres is the midpoint rule: its error goes with (pixel / h)².
    let (a, h) = (40.0, 1.0);
    let n = 640;
    let mut d = desc(n, n, orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 2.0 * a));
    d.materials.push(matte("floor", WHITE));
    d.objects.push(object(ShapeDesc::Plane, "floor"));
    d.lights.push(point_light(v(0.0, h, 0.0), WHITE, 1.0, Falloff::InverseSquare));
    let pixel = (2.0 * a / f64::from(n)).powi(2);
    let flux = sum(&render(&d)) * pixel;
    let square = 4.0 * (a * a / (a * a + h * h)).asin();
    assert!((flux / square - 1.0).abs() < 1e-5, "{flux}, expected {square}");
    // The rest lies outside of the square: at most 2 pi h / a.
    assert!((std::f64::consts::TAU - flux) < std::f64::consts::TAU * h / a && flux < std::f64::consts::TAU);
}

#[test]
fn the_shadow_of_a_ball_right_under_the_light_is_a_disc_of_the_exact_radius() {
    // Light at distance L over the centre, plane at h below it: rays that touch the ball make the angle asin(r/L) with
    // the axis, and meet the plane at (L + h) tan(asin(r/L)) = (L + h) r / sqrt(L² - r²).
    let (r, l, h) = (0.6, 1.9, 1.1_f64);
    let radius = (l + h) * r / (l * l - r * r).sqrt();
    let mut d = desc(151, 149, orthographic(v(0.0, 9.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 4.0));
    d.materials = vec![matte("floor", WHITE), flat("ball", Rgb::new(0.0, 0.0, 1.0))];
    d.objects = vec![object(ShapeDesc::Plane, "floor"), sphere(v(0.0, h, 0.0), r, "ball")];
    d.lights.push(point_light(v(0.0, h + l, 0.0), WHITE, 3.0, Falloff::InverseSquare));
    let height = h + l;
    let film = render(&d);
    let excluded = assert_image("shadow-disc", &film, EXACT, |x, y| {
        let (o, _) = pixel_ray(&d, x, y);
        let rho = o.x.hypot(o.z);
        // Whether a ray passes a rim nearer than rounding is not ours to say.
        if (rho - radius).abs() < 1e-12 || (rho - r).abs() < 1e-12 {
            return None;
        }
        Some(match rho {
            rho if rho < r => [0.0, 0.0, 1.0],
            rho if rho < radius => [0.0; 3],
            rho => [3.0 * height / (height * height + rho * rho).powf(1.5); 3],
        })
    });
    assert!(excluded <= 2);
    // The radius itself, from the dark area (ball and shadow are both black in red): 16 samples a pixel put an outline
    // to within 0.5 / sqrt(16) pixels.
    d.render.samples = 16;
    let film = render(&d);
    let mut dark = 0.0;
    for y in 0..149 {
        for x in 0..151 {
            let (o, _) = pixel_ray(&d, x, y);
            let lit = 3.0 * height / (height * height + o.x * o.x + o.z * o.z).powf(1.5);
            dark += 1.0 - f64::from(film.pixel(x, y)[0]) / lit;
        }
    }
    let pixel = 4.0 / 149.0;
    let got = (dark / std::f64::consts::PI).sqrt();
    assert!((got - radius / pixel).abs() < 0.125, "radius {got} pixels, expected {}", radius / pixel);
}

#[test]
fn the_shadow_of_a_ball_far_from_the_axis_obeys_the_tangent_cone_in_every_pixel() {
    // A point P behind the ball (centre C, radius r) is in shadow exactly if the angle between P - S and C - S at the
    // light S is below asin(r/|C - S|): (P - S, C - S) > |P - S| sqrt(|C - S|² - r²).
    let (s, c, r) = (v(-2.0, 3.0, 0.5), v(0.2, 1.1, -0.3), 0.7);
    let mut d = desc(160, 120, perspective(v(3.0, 4.0, 6.0), v(1.0, 0.0, 0.0), DVec3::Y, 45.0));
    d.materials = vec![matte("floor", WHITE), flat("ball", Rgb::new(0.0, 0.0, 1.0))];
    d.objects = vec![object(ShapeDesc::Plane, "floor"), sphere(c, r, "ball")];
    d.lights.push(point_light(s, WHITE, 9.0, Falloff::InverseSquare));
    let (mut shadowed, mut lit) = (0, 0);
    let excluded = assert_exact("shadow-cone", &d, 1e-12, |x, y| {
        let (o, dir) = pixel_ray(&d, x, y);
        let sees_ball = |o: DVec3, dir: DVec3| {
            let to = c - o;
            to.dot(dir) - (to.length_squared() - r * r).sqrt()
        };
        let margin = sees_ball(o, dir);
        if margin.abs() < 1e-11 {
            return None;
        }
        if margin > 0.0 {
            return Some([0.0, 0.0, 1.0]);
        }
        if dir.y >= 0.0 {
            return Some([0.0; 3]);
        }
        let p = meet_plane(o, dir, DVec3::ZERO, DVec3::Y);
        let margin = sees_ball(s, (p - s).normalize());
        if margin.abs() < 1e-11 {
            return None;
        }
        if margin > 0.0 {
            shadowed += 1;
            return Some([0.0; 3]);
        }
        lit += 1;
        Some([9.0 * s.y / (p - s).length().powi(3); 3])
    });
    assert!(excluded <= 2 && shadowed > 500 && lit > 5000, "{excluded} {shadowed} {lit}");
}

#[test]
fn several_lights_add_up_and_a_light_behind_the_surface_gives_nothing() {
    let camera = orthographic(v(0.0, 5.0, 0.0), DVec3::ZERO, DVec3::NEG_Z, 3.0);
    let lights = [
        point_light(v(1.0, 1.0, 0.0), Rgb::new(1.0, 0.2, 0.1), 0.7, Falloff::InverseSquare),
        point_light(v(-0.5, 2.0, 0.3), Rgb::new(0.1, 0.9, 0.3), 0.5, Falloff::None),
        sun(v(1.0, 1.0, 1.0), Rgb::new(0.3, 0.3, 0.8), 0.4),
        point_light(v(0.0, -1.0, 0.0), WHITE, 100.0, Falloff::None),
        sun(v(0.0, -1.0, 0.2), WHITE, 100.0),
    ];
    let with = |lights: &[LightDesc]| {
        let mut d = desc(40, 30, camera);
        d.materials.push(matte("floor", WHITE));
        d.objects.push(object(ShapeDesc::Plane, "floor"));
        d.lights = lights.to_vec();
        render(&d)
    };
    let each: Vec<_> = lights.iter().map(|l| with(std::slice::from_ref(l))).collect();
    assert!(each[3].pixels().iter().chain(each[4].pixels()).all(|p| *p == [0.0; 3]));
    assert_image("lights-add-up", &with(&lights), EXACT, |x, y| {
        Some(each.iter().fold([0.0; 3], |sum, film| plus(sum, film.pixel(x, y).map(f64::from))))
    });
}
