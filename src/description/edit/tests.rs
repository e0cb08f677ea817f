//! Edits do what they say, as a whole or not at all.

use super::*;
use crate::description::{DEMO, ObjectDesc, Projection, ShapeDesc, builtin, limits, parse};
use crate::math::{Affine, SplitMix64};
use glam::DAffine3;
use std::path::Path;

fn demo() -> SceneDesc {
    let text = std::str::from_utf8(builtin(Path::new(DEMO)).unwrap()).unwrap();
    parse(text, Path::new(DEMO)).unwrap()
}

fn map(object: &ObjectDesc) -> DAffine3 {
    Affine::from_scale_rotate_translate(object.scale, object.rotate, object.translate).unwrap().forward
}

fn vector(random: &mut SplitMix64, size: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| random.range(-size, size)))
}

fn close(a: DAffine3, b: DAffine3) -> bool {
    let scale = 1.0
        + b.translation.abs().max_element()
        + b.matrix3.to_cols_array().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    a.abs_diff_eq(b, 1e-9 * scale)
}

fn one_object(random: &mut SplitMix64) -> SceneDesc {
    let mut desc = SceneDesc::default();
    let sizes = vector(random, 1.0).abs() + DVec3::splat(0.1);
    let object = ObjectDesc {
        translate: vector(random, 5.0),
        rotate: match random.next_u64() % 3 {
            0 => DVec3::ZERO,
            // Where x and z turn about one axis.
            1 => DVec3::new(random.range(-180.0, 180.0), 90.0, random.range(-180.0, 180.0)),
            _ => vector(random, 360.0),
        },
        scale: sizes,
        ..ObjectDesc::new(ShapeDesc::Cuboid { size: DVec3::ONE })
    };
    desc.objects.push(object);
    desc
}

const FIRST: &[Target] = &[Target::Object(0)];

#[test]
fn turning_an_object_is_exactly_the_turn_after_its_own_map() {
    let mut random = SplitMix64(1);
    for _ in 0..3000 {
        let mut desc = one_object(&mut random);
        let before = map(&desc.objects[0]);
        let (pivot, degrees) = (vector(&mut random, 3.0), random.range(-200.0, 200.0));
        let axis = match random.next_u64() % 4 {
            0 => DVec3::X,
            1 => DVec3::NEG_Y,
            2 => DVec3::Z,
            _ => vector(&mut random, 1.0) + DVec3::splat(1e-3),
        };
        rotate(&mut desc, FIRST, pivot, axis, degrees).unwrap();
        let turn = DAffine3::from_translation(pivot)
            * DAffine3::from_axis_angle(axis.normalize(), degrees.to_radians())
            * DAffine3::from_translation(-pivot);
        assert!(close(map(&desc.objects[0]), turn * before), "{:?} {axis} {degrees}", desc.objects[0]);
        assert!(desc.objects[0].rotate.abs().max_element() <= 360.0);
    }
}

#[test]
fn turning_about_the_axes_gives_the_numbers_that_people_expect() {
    let mut desc = SceneDesc::default();
    desc.objects.push(ObjectDesc::new(ShapeDesc::Plane));
    for step in 1..=30 {
        rotate(&mut desc, FIRST, DVec3::ZERO, DVec3::Y, 10.0).unwrap();
        let angle = f64::from(step * 10);
        assert_eq!(desc.objects[0].rotate, DVec3::new(0.0, angle, 0.0));
    }
    rotate(&mut desc, FIRST, DVec3::ZERO, DVec3::Y, -300.0).unwrap();
    assert_eq!(desc.objects[0].rotate, DVec3::ZERO);
    // Not only where angles just add up.
    rotate(&mut desc, FIRST, DVec3::ZERO, DVec3::X, 90.0).unwrap();
    rotate(&mut desc, FIRST, DVec3::ZERO, DVec3::Z, 30.0).unwrap();
    rotate(&mut desc, FIRST, DVec3::ZERO, DVec3::X, -90.0).unwrap();
    assert_eq!(desc.objects[0].rotate.abs(), DVec3::new(0.0, 30.0, 0.0), "{}", desc.objects[0].rotate);
}

#[test]
fn scaling_is_exact_along_all_axes_and_along_those_of_the_object() {
    let mut random = SplitMix64(2);
    for _ in 0..2000 {
        let mut desc = one_object(&mut random);
        let before = map(&desc.objects[0]);
        let (pivot, factor) =
            (vector(&mut random, 3.0), random.range(0.2, 3.0) * if random.unit() < 0.3 { -1.0 } else { 1.0 });
        scale(&mut desc, FIRST, pivot, None, factor).unwrap();
        let about = |m: DAffine3| DAffine3::from_translation(pivot) * m * DAffine3::from_translation(-pivot);
        let expected = about(DAffine3::from_scale(DVec3::splat(factor))) * before;
        assert!(close(map(&desc.objects[0]), expected));

        // Turned by right angles, each axis of the object lies along one of the world.
        let mut desc = one_object(&mut random);
        desc.objects[0].rotate = vector(&mut random, 4.0).map(|v| v.round() * 90.0);
        let before = map(&desc.objects[0]);
        scale(&mut desc, FIRST, pivot, Some(DVec3::Y), factor).unwrap();
        let expected = about(DAffine3::from_scale(DVec3::new(1.0, factor, 1.0))) * before;
        assert!(close(map(&desc.objects[0]), expected), "{:?}", desc.objects[0]);
    }
    let mut desc = one_object(&mut random);
    for factor in [0.0, f64::NAN, f64::INFINITY] {
        assert!(scale(&mut desc, FIRST, DVec3::ZERO, None, factor).is_err());
    }
}

#[test]
fn a_turn_and_its_reverse_about_the_common_centre_lead_back_to_the_same_description() {
    let mut random = SplitMix64(3);
    let desc = demo();
    let targets: Vec<_> = (0..desc.objects.len()).map(Target::Object).chain([Target::Light(0)]).collect();
    for _ in 0..100 {
        let mut edited = desc.clone();
        let pivot = centre(&desc, &targets, |_| None).unwrap();
        let axis = vector(&mut random, 1.0) + DVec3::splat(2e-3);
        let degrees = random.range(-90.0, 90.0);
        let by = vector(&mut random, 2.0);
        rotate(&mut edited, &targets, pivot, axis, degrees).unwrap();
        translate(&mut edited, &targets, by).unwrap();
        scale(&mut edited, &targets, pivot, None, 2.0).unwrap();
        assert_ne!(edited, desc);
        scale(&mut edited, &targets, pivot, None, 0.5).unwrap();
        translate(&mut edited, &targets, -by).unwrap();
        rotate(&mut edited, &targets, pivot, axis, -degrees).unwrap();
        for (a, b) in edited.objects.iter().zip(&desc.objects) {
            assert!(close(map(a), map(b)), "{a:?}\n{b:?}");
        }
    }
}

#[test]
fn the_common_centre_is_that_of_the_box_around_all() {
    let mut desc = demo();
    let bounds = |index: usize| {
        (index == 0).then_some(Bounds { lower: DVec3::new(-1.0, 0.0, 0.0), upper: DVec3::new(1.0, 4.0, 2.0) })
    };
    desc.objects[1].translate = DVec3::new(5.0, 0.0, 0.0);
    assert_eq!(centre(&desc, &[Target::Object(0)], bounds), Some(DVec3::new(0.0, 2.0, 1.0)));
    assert_eq!(centre(&desc, &[Target::Object(0), Target::Object(1)], bounds), Some(DVec3::new(2.0, 2.0, 1.0)));
    assert_eq!(centre(&desc, &[Target::Camera], bounds), None);
}

#[test]
fn what_is_added_is_in_the_middle_of_the_view_and_fills_a_quarter_of_it() {
    let mut random = SplitMix64(4);
    for _ in 0..200 {
        let mut desc = demo();
        let distance = 10f64.powf(random.range(-3.0, 4.0));
        desc.camera.position = desc.camera.look_at + vector(&mut random, 1.0).normalize_or(DVec3::Z) * distance;
        let fov = random.range(5.0, 120.0);
        desc.camera.projection = Projection::Perspective { fov };
        let before = desc.clone();
        let Ok(target) = add(&mut desc, New::Sphere) else { panic!() };
        let Target::Object(index) = target else { panic!("{target:?}") };
        let object = &desc.objects[index];
        let ShapeDesc::Sphere { radius } = object.shape else { panic!() };
        let share = 2.0 * radius / (2.0 * distance * (fov.to_radians() / 2.0).tan());
        assert!((0.2..0.3).contains(&share), "{share}");
        let off = (object.translate - desc.camera.look_at).length();
        assert!(off < 0.1 * desc.camera.look_at.length() + 1e-9, "{off}");
        assert_eq!(desc.materials.len(), before.materials.len() + 1);
        assert_eq!(object.material.as_ref(), Some(&desc.materials.last().unwrap().name));
        // A model too, whatever its own size and place.
        let lower = vector(&mut random, 100.0);
        let bounds = Bounds { lower, upper: lower + DVec3::splat(10f64.powf(random.range(-3.0, 5.0))) };
        let Ok(Target::Object(index)) = add(&mut desc, New::Mesh { file: "a/knot.obj".into(), bounds }) else {
            panic!()
        };
        let object = &desc.objects[index];
        assert_eq!((object.name.as_str(), &object.material), ("knot", &None));
        let edge = (map(object).transform_vector3(bounds.upper - bounds.lower)).max_element();
        assert!((edge / (2.0 * radius) - 1.0).abs() < 0.06, "{edge} {radius}");
    }
}

#[test]
fn every_kind_is_added_under_a_name_of_its_own_and_lights_shine_on_what_is_seen() {
    let mut desc = demo();
    for new in [
        New::Sphere,
        New::Cuboid,
        New::Cylinder,
        New::Cone,
        New::Plane,
        New::Quad,
        New::PointLight,
        New::DirectionalLight,
        New::Material,
    ] {
        for _ in 0..3 {
            let target = add(&mut desc, new.clone()).unwrap();
            assert!(target.exists(&desc));
            assert_eq!(check(&desc, target), Ok(()));
            assert!(!target.label(&desc).is_empty());
        }
    }
    let names: Vec<_> =
        desc.objects.iter().map(|object| object.name.as_str()).filter(|name| name.starts_with("sph")).collect();
    assert_eq!(names, ["sphere", "sphere 2", "sphere 3"]);
    for light in desc.lights.iter().skip(2) {
        let way = match light.kind {
            LightKind::Point { position, .. } => desc.camera.look_at - position,
            LightKind::Directional { direction } => direction,
        };
        assert!(
            way.y < 0.0 && way.dot(Axis::Forward.direction(&desc.camera)) > 0.0,
            "from above and from the eye: {way}"
        );
    }
}

#[test]
fn deleting_a_material_in_use_leaves_its_objects_with_the_default() {
    let mut desc = demo();
    let name = desc.objects[0].material.clone().unwrap();
    let at = desc.materials.iter().position(|material| material.name == name).unwrap();
    delete(&mut desc, &[Target::Material(at), Target::Object(2), Target::Object(1), Target::Object(2)]).unwrap();
    assert_eq!(desc.objects.len(), demo().objects.len() - 2);
    assert_eq!(desc.objects[0].material, None);
    assert!(desc.objects.iter().all(|object| object.material.as_ref() != Some(&name)));
    let before = desc.clone();
    assert!(delete(&mut desc, &[Target::Object(0), Target::Camera]).is_err());
    assert!(delete(&mut desc, &[Target::Object(0), Target::Object(99)]).is_err());
    assert_eq!(desc, before);
}

#[test]
fn copies_stand_behind_their_originals_beside_them_and_under_other_names() {
    let mut desc = demo();
    let copies = duplicate(&mut desc, &[Target::Object(2), Target::Object(0), Target::Light(0)]).unwrap();
    assert_eq!(copies, [Target::Light(1), Target::Object(1), Target::Object(4)]);
    let old = demo();
    for (copy, original) in [(1, 0), (4, 2)] {
        let (copy, original) = (&desc.objects[copy], &old.objects[original]);
        assert_ne!(copy.name, original.name);
        assert_eq!((&copy.shape, &copy.material), (&original.shape, &original.material));
        assert!(copy.translate.distance(original.translate) > 0.01);
    }
}

#[test]
fn renaming_a_material_renames_its_uses_and_names_stay_unique() {
    let mut desc = demo();
    let name = desc.objects[0].material.clone().unwrap();
    let at = Target::Material(desc.materials.iter().position(|material| material.name == name).unwrap());
    rename(&mut desc, at, "other").unwrap();
    assert_eq!(desc.objects[0].material.as_deref(), Some("other"));
    assert!(desc.objects.iter().all(|object| object.material.as_ref() != Some(&name)));
    let before = desc.clone();
    let taken = desc.materials.iter().find(|material| material.name != "other").unwrap().name.clone();
    assert!(rename(&mut desc, at, &taken).is_err());
    assert!(rename(&mut desc, at, "").is_err());
    assert!(rename(&mut desc, Target::Camera, "x").is_err());
    assert_eq!(desc, before);
    rename(&mut desc, Target::Object(0), "").unwrap();
    rename(&mut desc, Target::Object(1), "").unwrap();
}

#[test]
fn entries_move_within_their_list_and_stop_at_its_ends() {
    let mut desc = demo();
    let names = |desc: &SceneDesc| desc.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let before = names(&desc);
    assert_eq!(move_by(&mut desc, Target::Object(0), 2), Ok(Target::Object(2)));
    assert_eq!(names(&desc)[..3], [before[1].clone(), before[2].clone(), before[0].clone()]);
    assert_eq!(move_by(&mut desc, Target::Object(2), -99), Ok(Target::Object(0)));
    assert_eq!(names(&desc), before);
    assert_eq!(move_by(&mut desc, Target::Object(0), 99), Ok(Target::Object(before.len() - 1)));
    assert!(move_by(&mut desc, Target::World, 1).is_err());
}

#[test]
fn an_edit_that_would_leave_the_limits_is_refused_as_a_whole() {
    let mut desc = demo();
    desc.objects[1].translate.x = 0.9 * limits::MAX_LENGTH;
    let before = desc.clone();
    let both = [Target::Object(0), Target::Object(1)];
    assert!(translate(&mut desc, &both, DVec3::X * 0.2 * limits::MAX_LENGTH).is_err());
    assert!(scale(&mut desc, &both, DVec3::ZERO, None, 2.0).is_err());
    assert!(assign(&mut desc, &both, Some(99)).is_err());
    assert!(assign(&mut desc, &[Target::Light(0)], None).is_err());
    assert!(set_visible(&mut desc, &[Target::Object(0), Target::World], false).is_err());
    assert_eq!(desc, before);
    assign(&mut desc, &both, Some(0)).unwrap();
    assert_eq!(desc.objects[1].material.as_ref(), Some(&desc.materials[0].name));
    set_visible(&mut desc, &[Target::Object(0), Target::Light(1)], false).unwrap();
    assert!(!desc.objects[0].visible && !desc.lights[1].visible);
}
