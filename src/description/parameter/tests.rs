//! The list is complete, and every value of it comes back as it was set.

use super::super::{DEMO, ShapeDesc, TextureDesc, TextureSource, Wrap, builtin, parse};
use super::*;
use crate::math::SplitMix64;

fn scene() -> SceneDesc {
    let text = std::str::from_utf8(builtin(Path::new(DEMO)).unwrap()).unwrap();
    let mut desc = parse(text, Path::new(DEMO)).unwrap();
    let more = "[[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\n[[object]]\nshape = 'quad'\n[[object]]\nshape = 'plane'\n\
                [[object]]\nshape = 'spheres'\ndata = [[0, 0, 0, 1]]\n[[object]]\nshape = 'cuboid'\n";
    let more = parse(more, Path::new("x.toml")).unwrap();
    desc.lights.extend(more.lights);
    desc.objects.extend(more.objects);
    desc
}

fn targets(desc: &SceneDesc) -> Vec<Target> {
    let single = [Target::Film, Target::Camera, Target::World, Target::Render];
    let lights = (0..desc.lights.len()).map(Target::Light);
    let materials = (0..desc.materials.len()).map(Target::Material);
    single.into_iter().chain(lights).chain(materials).chain((0..desc.objects.len()).map(Target::Object)).collect()
}

#[test]
fn labels_are_unique_and_what_is_set_is_what_is_read() {
    let desc = scene();
    let mut random = SplitMix64(5);
    let mut set = 0;
    for target in targets(&desc) {
        let labels: std::collections::HashSet<_> = parameters(target).iter().map(|p| p.label).collect();
        assert_eq!(labels.len(), parameters(target).len());
        for parameter in parameters(target) {
            let Some(now) = parameter.get(&desc, &[target]) else {
                assert!(parameter.nudge(&mut desc.clone(), &[target], 1, false).is_err());
                continue;
            };
            let value = match (&parameter.kind, &now) {
                (Kind::Number { range, .. }, Value::Number(_)) => Value::Number(range.clamp(random.range(0.2, 3.0))),
                (Kind::Integer { range, .. }, Value::Integer(now)) => Value::Integer((now + 1).min(*range.end())),
                (Kind::Toggle, Value::Toggle(on)) => Value::Toggle(!on),
                (Kind::Choice(_), Value::Choice(_)) => Value::Choice(1),
                (Kind::Color, Value::Color(_)) => Value::Color(Rgb::new(random.unit(), 2.0, 0.0)),
                (Kind::Name, Value::Text(_)) => Value::Text("quite new".into()),
                (Kind::Path(_), Value::Path(_)) => Value::Path("other.png".into()),
                (_, now) => panic!("{} of {target:?} is {now:?}", parameter.label),
            };
            let mut edited = desc.clone();
            parameter.set(&mut edited, &[target], &value).unwrap_or_else(|e| panic!("{} {e}", parameter.label));
            assert_eq!(parameter.get(&edited, &[target]), Some(value.clone()), "{}", parameter.label);
            // What is shown can be typed, except for paths.
            let shown = parameter.show(&edited, target, &value);
            if !matches!(parameter.kind, Kind::Path(_)) {
                parameter.enter(&mut edited, &[target], &shown).unwrap_or_else(|e| panic!("{} {e}", parameter.label));
            }
            if parameter.label == "texture" {
                continue; // The file of a picture is gone.
            }
            parameter.set(&mut edited, &[target], &now).unwrap_or_else(|e| panic!("{} {e}", parameter.label));
            if !matches!(parameter.kind, Kind::Choice(_)) {
                assert_eq!(edited, desc, "{} changes only itself", parameter.label);
            }
            set += 1;
        }
    }
    assert!(set > 200, "{set}");
}

/// Every number of a description is turned by some parameter: changes of one description by all of its parameters reach
/// every number that its `Debug` form shows.
#[test]
fn no_number_is_left_out() {
    let desc = scene();
    let mut turned = desc.clone();
    turned.materials.iter_mut().for_each(|m| m.texture.iter_mut().for_each(|t| t.offset = glam::DVec2::splat(0.5)));
    let base = turned.clone();
    for target in targets(&desc) {
        for parameter in parameters(target) {
            if matches!(parameter.kind, Kind::Number { .. } | Kind::Integer { .. } | Kind::Color) {
                // A step that is no multiple of anything, so that nothing ends where something else was.
                if let Some(Value::Color(c)) = parameter.get(&turned, &[target]) {
                    let other = Rgb::new(c.r + 0.137, c.g + 0.137, c.b + 0.137);
                    parameter.set(&mut turned, &[target], &Value::Color(other)).unwrap();
                } else if parameter.get(&turned, &[target]).is_some() {
                    let steps =
                        if parameter.label == "reflect" || parameter.label == "transmit" { "0.437" } else { "+2" };
                    parameter.enter(&mut turned, &[target], steps).unwrap_or_else(|e| panic!("{target:?} {e}"));
                }
            }
        }
    }
    let numbers = |desc: &SceneDesc| {
        let text = format!("{desc:?}").replace("DVec3", "").replace("DVec2", "");
        let texts = text.split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | 'e')));
        texts.filter_map(|t| t.parse::<f64>().ok().map(|v| v.to_bits())).collect::<Vec<_>>()
    };
    let (before, after) = (numbers(&base), numbers(&turned));
    assert_eq!(before.len(), after.len());
    let same = before.iter().zip(&after).filter(|(a, b)| a == b).count();
    // The spheres of a group are data, four numbers; names of the demo hold none.
    let of_same: Vec<f64> =
        before.iter().zip(&after).filter(|(a, b)| a == b).map(|(a, _)| f64::from_bits(*a)).collect();
    assert_eq!(same, 4, "of {}: {of_same:?}", before.len());
}

#[test]
fn several_entries_show_mixed_values_and_an_edit_sets_all_or_none() {
    let mut desc = scene();
    let of = |desc: &SceneDesc, is: fn(&ShapeDesc) -> bool| {
        Target::Object(desc.objects.iter().position(|object| is(&object.shape)).unwrap())
    };
    let both = [
        of(&desc, |shape| matches!(shape, ShapeDesc::Cylinder { .. })),
        of(&desc, |shape| matches!(shape, ShapeDesc::Sphere { .. })),
    ];
    let place = |desc: &SceneDesc| {
        both.map(|target| match target {
            Target::Object(at) => desc.objects[at].translate.x,
            _ => f64::NAN,
        })
    };
    let x = parameter(both[0], "translate x").unwrap();
    x.set(&mut desc, &both[..1], &Value::Number(1.0)).unwrap();
    x.set(&mut desc, &both[1..], &Value::Number(3.0)).unwrap();
    assert_eq!(x.get(&desc, &both), Some(Value::Mixed));
    x.enter(&mut desc, &both, "+0.5").unwrap();
    assert_eq!(place(&desc), [1.5, 3.5]);
    x.enter(&mut desc, &both, "*2").unwrap();
    assert_eq!(place(&desc), [3.0, 7.0]);
    x.enter(&mut desc, &both, "2").unwrap();
    assert_eq!(x.get(&desc, &both), Some(Value::Number(2.0)));
    let before = desc.clone();
    assert!(x.enter(&mut desc, &both, "1e13").is_err());
    let scale = parameter(both[0], "scale x").unwrap();
    assert!(scale.enter(&mut desc, &both, "0").is_err());
    assert!(x.set(&mut desc, &both, &Value::Mixed).is_err());
    assert!(x.set(&mut desc, &both, &Value::Number(f64::NAN)).is_err());
    assert!(x.enter(&mut desc, &[both[0], Target::Object(999)], "1").is_err());
    assert_eq!(desc, before);
    // Only what applies to both is shown.
    let labels: Vec<_> = shared_parameters(&desc, &both).iter().map(|p| p.label).collect();
    assert!(labels.contains(&"radius") && !labels.contains(&"height"), "{labels:?}");
    assert!(shared_parameters(&desc, &[Target::Camera, Target::Object(0)]).is_empty());
}

#[test]
fn resetting_gives_what_a_file_means_that_does_not_say() {
    let mut desc = scene();
    let target = Target::Material(0);
    for parameter in parameters(target) {
        if parameter.get(&desc, &[target]).is_some() && parameter.label != "name" {
            parameter.reset(&mut desc, &[target]).unwrap();
        }
    }
    let default = super::super::MaterialDesc::default();
    let found = &desc.materials[0];
    assert_eq!((found.diffuse, found.ior, found.color), (default.diffuse, default.ior, default.color));
    let fov = parameter(Target::Camera, "fov").unwrap();
    assert_eq!(fov.default(&desc, Target::Camera), Some(Value::Number(40.0)));
    let radius = parameter(Target::Object(0), "radius").unwrap();
    let ball = desc.objects.iter().position(|o| matches!(o.shape, ShapeDesc::Sphere { .. })).unwrap();
    assert_eq!(radius.default(&desc, Target::Object(ball)), Some(Value::Number(0.5)));
}

#[test]
fn nudges_are_round_stop_at_the_limits_and_lead_back() {
    let mut desc = scene();
    let target = [Target::Material(0)];
    let reflect = parameter(target[0], "reflect").unwrap();
    reflect.enter(&mut desc, &target, "0.1").unwrap();
    reflect.nudge(&mut desc, &target, 4, false).unwrap();
    assert_eq!(desc.materials[0].reflect, 0.3);
    reflect.nudge(&mut desc, &target, 1, true).unwrap();
    assert_eq!(desc.materials[0].reflect, 0.305);
    reflect.nudge(&mut desc, &target, 1000, false).unwrap();
    assert_eq!(desc.materials[0].reflect, 1.0);
    let samples = parameter(Target::Render, "samples").unwrap();
    desc.render.samples = 1;
    for expected in [2, 4, 8] {
        samples.nudge(&mut desc, &[Target::Render], 1, false).unwrap();
        assert_eq!(desc.render.samples, expected);
    }
    samples.nudge(&mut desc, &[Target::Render], 1, true).unwrap();
    assert_eq!(desc.render.samples, 9, "at least by one");
    samples.nudge(&mut desc, &[Target::Render], -99, false).unwrap();
    assert_eq!(desc.render.samples, 1);
    let fov = parameter(Target::Camera, "fov").unwrap();
    fov.nudge(&mut desc, &[Target::Camera], 999, false).unwrap();
    fov.nudge(&mut desc, &[Target::Camera], -999, false).unwrap();
    assert!(fov.enter(&mut desc, &[Target::Camera], "180").is_err());
    for (distance, step) in [(1.0, 0.02), (8.0, 0.1), (100.0, 2.0), (3e-3, 5e-5)] {
        desc.camera.position = desc.camera.look_at + glam::DVec3::Z * distance;
        assert!((view_step(&desc) / step - 1.0).abs() < 1e-9, "{distance}: {}", view_step(&desc));
    }
}

#[test]
fn a_camera_without_a_view_and_a_light_without_a_direction_are_refused() {
    let mut desc = scene();
    desc.camera.position = desc.camera.look_at + glam::DVec3::X;
    let before = desc.clone();
    let x = format!("{}", desc.camera.look_at.x);
    assert!(parameter(Target::Camera, "position x").unwrap().enter(&mut desc, &[Target::Camera], &x).is_err());
    assert!(parameter(Target::Camera, "up y").unwrap().enter(&mut desc, &[Target::Camera], "0").is_err());
    let sun = Target::Light(desc.lights.len() - 1);
    assert!(parameter(sun, "direction y").unwrap().enter(&mut desc, &[sun], "0").is_err());
    assert_eq!(desc, before);
}

#[test]
fn other_kinds_keep_what_they_can() {
    let mut desc = scene();
    let camera = [Target::Camera];
    let projection = parameter(Target::Camera, "projection").unwrap();
    let before = desc.camera;
    projection.enter(&mut desc, &camera, "ortho").unwrap();
    assert!(parameter(Target::Camera, "view_height").unwrap().get(&desc, &camera).is_some());
    projection.nudge(&mut desc, &camera, 1, false).unwrap();
    let (super::super::Projection::Perspective { fov: was }, super::super::Projection::Perspective { fov: is }) =
        (before.projection, desc.camera.projection)
    else {
        panic!()
    };
    assert!((was - is).abs() < 1e-9);
    let material = [Target::Material(0)];
    let texture = parameter(material[0], "texture").unwrap();
    texture.enter(&mut desc, &material, "none").unwrap();
    assert!(texture.enter(&mut desc, &material, "picture").is_err(), "a picture needs a file");
    texture.enter(&mut desc, &material, "checker").unwrap();
    let scale = parameter(material[0], "texture scale u").unwrap();
    scale.enter(&mut desc, &material, "3").unwrap();
    desc.materials[0].texture.as_ref().unwrap();
    let picture = parameter(material[0], "picture").unwrap();
    assert!(picture.get(&desc, &material).is_none());
    picture.set(&mut desc, &material, &Value::Path("a.png".into())).unwrap();
    let expected = TextureSource::Image { file: "a.png".into(), wrap: Wrap::Repeat };
    let Some(TextureDesc { source, scale, .. }) = &desc.materials[0].texture else { panic!() };
    assert_eq!((source, scale.x), (&expected, 3.0));
}
