//! The other presets of arithmetic, which are there to be compared with.

use crate::support::*;
use crate::*;
use glam::DVec3;
use glimt::description::*;
use glimt::render::{self, Film, RenderEvent};

/// A picture and the number of samples that were not finite.
fn with_counts(d: &SceneDesc) -> (Film, u64) {
    let handle = render::start(compile(d), settings(2, 32));
    let (mut film, mut non_finite) = (Film::new(d.film.width, d.film.height), 0);
    for event in handle.events() {
        match event {
            RenderEvent::TileFinished { tile, stats, .. } => {
                film.write(&tile);
                non_finite += stats.non_finite;
            }
            RenderEvent::Failed(error) => panic!("{error}"),
            _ => {}
        }
    }
    (film, non_finite)
}

#[test]
fn reference_arithmetic_gives_the_picture_of_the_default_to_one_code() {
    let file = model_file("reference-ball", &ball_obj(12));
    let mut d = mixed(1.0, DVec3::ZERO);
    d.objects.push(ObjectDesc { scale: DVec3::splat(0.4), ..at(v(0.9, 0.8, 1.0), mesh(&file, "glass")) });
    d.objects.push(ObjectDesc { scale: v(0.4, 0.5, 0.3), ..at(v(-0.3, 0.1, 1.9), mesh(&file, "plain")) });
    d.render.samples = 2;
    let robust = render(&d);
    d.render.numerics = Numerics::Reference;
    assert_within_one_code("reference", &render(&d), &robust, 0);
    std::fs::remove_file(file).ok();
}

#[test]
fn classic_and_fast_arithmetic_paint_a_likeness_and_count_what_is_not_finite() {
    let file = model_file("presets-ball", &ball_obj(8));
    let mut d = mixed(1.0, DVec3::ZERO);
    d.objects.push(ObjectDesc { scale: DVec3::splat(0.4), ..at(v(0.9, 0.8, 1.0), mesh(&file, "plain")) });
    let (robust, none) = with_counts(&d);
    assert_eq!(none, 0);
    let mean_difference = |film: &Film| {
        let total: f64 = film.pixels().iter().zip(robust.pixels()).map(|(a, b)| f64::from((a[0] - b[0]).abs())).sum();
        total / film.pixels().len() as f64
    };
    d.render.numerics = Numerics::Fast;
    let (fast, non_finite) = with_counts(&d);
    assert_eq!(non_finite, 0, "what is usual in practice does not make NaN here");
    assert!(mean_difference(&fast) < 0.01, "{}", mean_difference(&fast));
    d.render.numerics = Numerics::Classic;
    let (classic, _) = with_counts(&d);
    assert!(classic.pixels().iter().flatten().all(|c| c.is_finite()), "NaN reached the film");
    assert!(mean_difference(&classic) < 0.2, "{}", mean_difference(&classic));
    std::fs::remove_file(file).ok();
}

#[test]
fn the_classic_formulas_fail_where_the_catalogue_says_and_the_default_does_not() {
    // Row 21: where light turns away from the normal on entry, total reflection is the root of a negative number in the
    // coursework's formula: every such sample is lost, and counted. Looking at a sea of index 0.75 at a slant.
    let mut d = desc(20, 20, perspective(v(0.0, 2.0, 0.0), v(0.0, 0.0, -6.0), DVec3::Y, 10.0));
    d.world.background = SKY;
    d.materials = vec![clear("thin", 0.75)];
    d.objects = vec![object(ShapeDesc::Plane, "thin")];
    assert_eq!(with_counts(&d).1, 0);
    d.render.numerics = Numerics::Classic;
    let (film, non_finite) = with_counts(&d);
    assert!(film.pixels().iter().flatten().all(|c| c.is_finite()));
    assert_eq!(non_finite, 400);
    // And glass is bent by 17 degrees at 30 where the true deviation is 0: the ratio is not inverted on the way out.
    d.camera = orthographic(v(0.0, 3f64.sqrt(), 1.0) * 5.0, DVec3::ZERO, DVec3::Y, 0.1);
    d.materials = vec![clear("glass", 1.5)];
    d.objects = vec![cuboid(DVec3::ZERO, v(100.0, 1.0, 100.0), "glass")];
    let angle = |film: &Film| ((f64::from(film.pixel(10, 10)[0]) - 0.1) / 0.9 * 2.0 - 1.0).acos().to_degrees();
    let classic = angle(&render(&d));
    d.render.numerics = Numerics::Robust;
    let robust = angle(&render(&d));
    assert!((robust - 150.0).abs() < 1e-3 && ((classic - robust) - 17.2).abs() < 0.1, "{classic} {robust}");
}
