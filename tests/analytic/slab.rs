//! Items 5 and 7: flat pieces of glass.

use crate::support::*;
use glam::DVec3;
use glimt::description::*;
use glimt::math::Rgb;

/// A slab of glass of thickness `t` with its upper face at y = `top`, far wider than the view.
fn slab(top: f64, t: f64, material: &str) -> ObjectDesc {
    cuboid(v(0.0, top - t / 2.0, 0.0), v(40.0, t, 40.0), material)
}

#[test]
fn a_slab_shifts_rays_sideways_by_the_exact_amount_and_leaves_them_parallel() {
    // Refraction at parallel faces leaves the direction and shifts the ray, in the plane of incidence and toward the
    // normal that points down, by s = T sin(th) (1 - cos(th) / sqrt(n² - sin²(th))). All rays of an orthographic
    // camera have one direction, so that the whole picture moves by one vector; the ruler tells how far.
    for (n, angle) in [(1.5, 0.0_f64), (1.5, 30.0), (1.33, 55.0), (2.4, 75.0), (1.0, 40.0)] {
        let thickness = 0.7;
        let th = angle.to_radians();
        let look_at = v(0.2, 0.0, 0.1);
        let away = v(th.sin() * 0.8, th.cos(), th.sin() * 0.6);
        let up = if angle == 0.0 { DVec3::NEG_Z } else { DVec3::Y };
        let mut d = desc(48, 40, orthographic(look_at + away * 30.0, look_at, up, 2.0));
        let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 0.8, 1.0);
        ruler.add_to(&mut d, 1000.0);
        d.materials.push(clear("glass", n));
        d.objects.push(slab(2.0, thickness, "glass"));
        let shift = thickness * th.sin() * (1.0 - th.cos() / (n * n - th.sin().powi(2)).sqrt());
        assert_exact("slab", &d, 1e-10, |x, y| {
            let (o, dir) = pixel_ray(&d, x, y);
            // Unit vector across the ray, in the plane of incidence, on the side of the downward normal.
            let across = DVec3::NEG_Y - dir * DVec3::NEG_Y.dot(dir);
            let across = if angle == 0.0 { DVec3::ZERO } else { across.normalize() };
            Some(ruler.seen_by(o + across * shift, dir))
        });
    }
}

#[test]
fn a_stack_of_touching_and_separate_slabs_in_perspective_obeys_snell_in_every_pixel() {
    // Through parallel layers sin(th_i) n_i is constant: the sideways walk is the sum of thickness * tan(th_i).
    let mut d = desc(60, 44, perspective(v(0.3, 5.0, 0.2), v(1.5, 0.0, 0.5), DVec3::Y, 60.0));
    let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 0.5, 1.2);
    ruler.add_to(&mut d, 1000.0);
    // The first two have the face at y = 3 in common.
    let layers = [(3.5, 0.5, 1.5), (3.0, 0.5, 2.0), (1.9, 0.2, 1.33)];
    for (i, (top, t, n)) in layers.into_iter().enumerate() {
        d.materials.push(clear(&format!("glass {i}"), n));
        d.objects.push(slab(top, t, &format!("glass {i}")));
    }
    let glass: f64 = layers.iter().map(|l| l.1).sum();
    assert_exact("slabs", &d, 1e-10, |x, y| {
        let (o, dir) = pixel_ray(&d, x, y);
        let sin = dir.x.hypot(dir.z);
        let tan = |n: f64| {
            let s = sin / n;
            s / (1.0 - s * s).sqrt()
        };
        let walk = (o.y - glass) * tan(1.0) + layers.iter().map(|l| l.1 * tan(l.2)).sum::<f64>();
        Some(ruler.color_at(v(o.x, 0.0, o.z) + v(dir.x, 0.0, dir.z) / sin * walk))
    });
}

#[test]
fn water_looks_shallower_by_its_refractive_index() {
    // Looking straight down from height H over water of depth t, the ray at angle th meets the floor at
    // rho = H tan(th) + t tan(asin(sin(th) / n)); to first order that is a floor at depth t / n. The floor and its
    // lamps are under water, floor and water do not touch.
    let (height, t, n) = (3.0, 2.0, 4.0 / 3.0);
    let mut d = desc(61, 61, perspective(v(0.0, t + height, 0.0), DVec3::ZERO, DVec3::NEG_Z, 50.0));
    let ruler = Ruler::new(DVec3::ZERO, DVec3::Y, 0.6, 0.9);
    ruler.add_to(&mut d, 300.0);
    d.materials.push(clear("water", n));
    d.objects.push(slab(t, t + 1.0, "water"));
    let film = render(&d);
    assert_image("pool", &film, EXACT, |x, y| {
        let (o, dir) = pixel_ray(&d, x, y);
        let sin = dir.x.hypot(dir.z);
        let s = sin / n;
        let rho = height * sin / (1.0 - sin * sin).sqrt() + t * s / (1.0 - s * s).sqrt();
        let along = v(dir.x, 0.0, dir.z).normalize_or_zero();
        Some(ruler.color_at(v(o.x, 0.0, o.z) + along * rho))
    });
    // Near the axis, the picture of the pool is that of a dry floor at depth t / n, to third order in the angle.
    for (x, y) in [(30, 30), (31, 30), (30, 28), (33, 32)] {
        let (o, dir) = pixel_ray(&d, x, y);
        let dry = meet_plane(o, dir, v(0.0, t - t / n, 0.0), DVec3::Y);
        let want = ruler.color_at(v(dry.x, 0.0, dry.z));
        let angle = dir.x.hypot(dir.z);
        for (got, want) in film.pixel(x, y).into_iter().zip(want) {
            assert!((f64::from(got) - want).abs() < 2.0 * angle.powi(3) + 1e-6);
        }
    }
}

/// A triangular prism along z, half length 5, with its refracting edge at the origin pointing up and the apex angle
/// `a`: faces from the edge down to the left and to the right.
fn prism(a: f64) -> String {
    let (x, y) = (4.0 * (a / 2.0).sin(), -4.0 * (a / 2.0).cos());
    format!(
        "v 0 0 -5\nv 0 0 5\nv {x} {y} -5\nv {x} {y} 5\nv -{x} {y} -5\nv -{x} {y} 5\n\
         f 1 2 4 3\nf 1 5 6 2\nf 3 4 6 5\nf 1 3 5\nf 2 6 4\n"
    )
}

#[test]
fn a_prism_deviates_light_by_the_exact_angle() {
    // Light that meets the first face of a prism of apex A at angle i leaves the second deviated toward the base by
    // i + asin(n sin(A - asin(sin(i) / n))) - A. The background tells the direction.
    let a = 60_f64.to_radians();
    let n = 1.5;
    let file = model_file("prism", &prism(a));
    let mut deviations = Vec::new();
    for i in [30.0, 40.0, 48.59037789072914, 60.0, 75.0_f64] {
        let i = i.to_radians();
        let deviation = i + (n * (a - (i.sin() / n).asin()).sin()).asin() - a;
        // Coming from the left: the outward normal of the left face is (-cos(A/2), sin(A/2)); the ray comes from that
        // direction turned by i toward the base.
        let facing = std::f64::consts::PI - a / 2.0 + i;
        let from = v(facing.cos(), facing.sin(), 0.0);
        // Aim at a point of the left face below the edge.
        let aim = v(-(a / 2.0).sin(), -(a / 2.0).cos(), 0.0) * 1.2;
        let mut d = desc(16, 12, orthographic(aim + from * 20.0, aim, DVec3::Z, 0.3));
        d.world.background = SKY;
        d.materials.push(clear("glass", n));
        d.objects.push(mesh(&file, "glass"));
        // The way out: turned by the deviation toward the base, clockwise for light that goes to the right.
        let (sin, cos) = (-deviation).sin_cos();
        let out = v(-from.x * cos + from.y * sin, -from.x * sin - from.y * cos, 0.0);
        let film = render(&d);
        assert_image("prism", &film, EXACT, |_, _| Some(sky(out.y)));
        // And back from the colour to the angle that it stands for (red is 0.1 + 0.9 (1 + y) / 2).
        let y = (f64::from(film.pixel(8, 6)[0]) - 0.1) / 0.9 * 2.0 - 1.0;
        deviations.push((-from).y.asin() - y.asin());
        assert!((deviations[deviations.len() - 1] - deviation).abs() < 1e-5);
    }
    // The least deviation is that of the symmetric path, sin(i) = n sin(A / 2): 2 i - A.
    let least = 2.0 * (n * (a / 2.0).sin()).asin() - a;
    assert!((deviations[2] - least).abs() < 1e-5);
    assert!(deviations.iter().all(|d| *d >= least - 1e-5));
    std::fs::remove_file(file).ok();
}

#[test]
fn index_matched_glass_cannot_be_seen() {
    // No boundary in optics without a step of the index: with Fresnel or without, rays go straight on.
    let mut d = desc(40, 30, perspective(v(0.0, 3.0, 6.0), DVec3::ZERO, DVec3::Y, 40.0));
    d.world.ior = 1.3;
    d.world.background = SKY;
    d.materials = vec![clear("clear", 1.3), fresnel("fresnel", 1.3)];
    d.objects = vec![
        sphere(v(-0.8, 0.0, 0.0), 1.0, "clear"),
        sphere(v(0.7, 0.0, 0.0), 1.0, "fresnel"),
        cuboid(v(0.0, 0.5, 1.0), v(3.0, 0.5, 0.5), "fresnel"),
    ];
    d.render.max_depth = 12;
    let film = render(&d);
    d.materials.push(flat("black", Rgb::BLACK));
    assert_image("index-matched", &film, EXACT, |x, y| Some(sky(pixel_ray(&d, x, y).1.y)));
}
