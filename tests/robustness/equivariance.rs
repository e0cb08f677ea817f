//! Rows 29 and 31: the same scene larger, mirrored, elsewhere.

use crate::support::*;
use crate::*;
use glam::DVec3;
use glimt::description::*;

#[test]
fn scaling_a_scene_by_a_power_of_two_does_not_change_a_bit() {
    // S15. All lengths times 2^k are the same digits with another exponent.
    let file = model_file("scaled-ball", &ball_obj(10));
    let want = render(&mixed_with_model(1.0, DVec3::ZERO, &file)).hash();
    for exponent in [-40, -20, -1, 1, 20, 40] {
        let scaled = mixed_with_model(2f64.powi(exponent), DVec3::ZERO, &file);
        assert_eq!(render(&scaled).hash(), want, "2^{exponent}");
    }
    std::fs::remove_file(file).ok();
}

#[test]
fn a_mirrored_scene_gives_the_mirrored_picture() {
    // S15, x -> -x: translations and scales with x negated, turns about y and z reversed; the picture read from right
    // to left.
    let file = model_file("mirrored-ball", &ball_obj(10));
    let d = mixed_with_model(1.0, DVec3::ZERO, &file);
    let mut m = d.clone();
    let flip = v(-1.0, 1.0, 1.0);
    m.camera.position *= flip;
    m.camera.look_at *= flip;
    for o in &mut m.objects {
        o.translate *= flip;
        o.scale *= flip;
        o.rotate *= v(1.0, -1.0, -1.0);
    }
    for l in &mut m.lights {
        match &mut l.kind {
            LightKind::Point { position, .. } => *position *= flip,
            LightKind::Directional { direction } => *direction *= flip,
        }
    }
    let film = render(&m);
    let (w, h) = (film.width(), film.height());
    let read_back = (0..w * h).map(|i| film.pixel(w - 1 - i % w, i / w)).collect();
    assert_within_one_code("mirrored", &film_of(w, h, read_back), &render(&d), 2);
    std::fs::remove_file(file).ok();
}

#[test]
fn a_scene_far_from_the_origin_looks_the_same() {
    // S16, to 1e6 sizes: the numbers of the translated scene are rounded to 1e-10 themselves.
    let file = model_file("translated-ball", &ball_obj(10));
    let want = render(&mixed_with_model(1.0, DVec3::ZERO, &file));
    for distance in [1.0, 1e2, 1e4, 1e6] {
        let far = render(&mixed_with_model(1.0, v(0.6, -0.5, 0.62) * distance, &file));
        assert_within_one_code("translated", &far, &want, 4);
    }
    std::fs::remove_file(file).ok();
}
