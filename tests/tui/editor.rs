//! Editing by keys: keys in, description and screen out.

use super::stage::{Stage, scene};
use glam::DVec3;
use glimt::description::{Background, LightKind, MaterialDesc, ObjectDesc, Projection, SceneDesc, ShapeDesc, Target};
use glimt::math::Rgb;
use glimt::tui::app::{Focus, Tone};
use ratatui::style::Color;
use std::time::Duration;

/// Two balls of one material, a floor without one, and a light.
pub fn three() -> SceneDesc {
    let mut desc = scene();
    desc.materials.push(MaterialDesc { name: "paint".into(), ..MaterialDesc::default() });
    let ball = |name: &str, x: f64| ObjectDesc {
        name: name.into(),
        material: Some("paint".into()),
        translate: DVec3::new(x, 0.0, 0.0),
        ..ObjectDesc::new(ShapeDesc::Sphere { radius: 0.5 })
    };
    let floor = ObjectDesc { name: "floor".into(), ..ObjectDesc::new(ShapeDesc::Plane) };
    desc.objects = vec![ball("left", -1.0), ball("right", 1.0), ObjectDesc { translate: DVec3::NEG_Y, ..floor }];
    desc.lights[0].name = "lamp".into();
    desc
}

/// With the cursor of the tree on `name`.
fn at(name: &str, size: (u16, u16)) -> Stage {
    let mut stage = Stage::with(three(), size);
    stage.keys("/");
    stage.keys(name);
    stage.press("Enter Esc");
    assert_eq!(stage.selected(), [name]);
    stage
}

fn names(desc: &SceneDesc) -> Vec<&str> {
    desc.objects.iter().map(|object| object.name.as_str()).collect()
}

#[test]
fn tab_goes_round_the_screen_and_opens_the_panel_on_a_small_one() {
    let mut stage = Stage::with(three(), (80, 24));
    assert_eq!((stage.app.layout().editor, stage.app.focus()), (None, Focus::Picture));
    for focus in [Focus::Tree, Focus::Properties, Focus::Picture, Focus::Tree] {
        stage.press("Tab");
        assert_eq!(stage.app.focus(), focus);
        assert!(stage.app.layout().editor.is_some());
    }
    stage.press("Shift-Tab");
    assert_eq!(stage.app.focus(), Focus::Picture);
    stage.keys("b");
    assert_eq!(stage.app.layout().editor, None);
    // A wide screen has it from the start, and a tiny one never.
    assert!(Stage::with(three(), (200, 60)).app.layout().editor.is_some());
    let mut tiny = Stage::with(three(), (11, 3));
    tiny.press("Tab");
    assert_eq!((tiny.app.focus(), tiny.app.layout().editor), (Focus::Picture, None));
}

#[test]
fn the_tree_lists_everything_and_the_properties_what_is_selected() {
    let mut stage = at("left", (200, 60));
    let text = stage.text();
    for word in ["camera", "world", "render", "film", "Objects", "Lights", "lamp", "Materials", "paint", "radius"] {
        assert!(text.contains(word), "{word}\n{text}");
    }
    // Its material is edited with it.
    for word in ["material paint", "shininess", "0.5 units", "k_d", "ior"] {
        assert!(text.contains(word), "{word}\n{text}");
    }
}

#[test]
fn typing_after_a_slash_searches_by_name_and_kind() {
    let mut stage = Stage::with(three(), (200, 60));
    stage.keys("/plane");
    let text = stage.text();
    assert!(text.contains("floor") && !text.contains("lamp"), "{text}");
    assert_eq!(stage.selected(), ["floor"]);
    stage.press("Enter");
    assert_eq!(stage.app.focus(), Focus::Tree);
    stage.press("Esc");
    assert!(stage.text().contains("lamp"));
    stage.keys("/zzz");
    assert!(stage.text().contains("nothing has such a name"));
    stage.press("Esc");
    assert_eq!(stage.selected(), ["floor"]);
}

#[test]
fn space_and_shift_mark_several() {
    let mut stage = at("left", (200, 60));
    stage.keys("  ");
    assert_eq!(stage.selected(), ["left", "right"]);
    stage.press("Up");
    stage.keys(" ");
    assert_eq!(stage.selected(), ["left"]);
    let mut stage = at("left", (200, 60));
    stage.press("Shift-Down");
    assert_eq!(stage.selected(), ["left", "right"]);
    stage.press("Shift-Down");
    assert_eq!(stage.selected(), ["left", "right", "floor"]);
    assert!(stage.text().contains("3 selected"));
    stage.press("Esc");
    assert_eq!(stage.selected(), ["floor"]);
}

#[test]
fn hide_rename_duplicate_delete_and_reorder_do_what_they_say_and_undo_takes_it_back() {
    let start = three();
    let mut stage = at("left", (200, 60));
    stage.keys("v");
    assert!(!stage.desc().objects[0].visible);
    assert!(stage.text().contains("hidden sphere"));
    stage.keys("v");
    assert!(stage.desc().objects[0].visible);

    stage.keys("e");
    assert!(stage.text().contains("Rename"));
    stage.press("Backspace Backspace Backspace Backspace");
    stage.keys("big ball");
    stage.press("Enter");
    assert_eq!(names(stage.desc()), ["big ball", "right", "floor"]);

    stage.keys("y");
    assert_eq!(names(stage.desc()), ["big ball", "big ball 2", "right", "floor"]);
    assert_eq!(stage.selected(), ["big ball 2"]);

    stage.keys(">");
    assert_eq!(names(stage.desc()), ["big ball", "right", "big ball 2", "floor"]);
    stage.keys("<<");
    assert_eq!(names(stage.desc()), ["big ball 2", "big ball", "right", "floor"]);
    assert_eq!(stage.selected(), ["big ball 2"]);

    stage.keys("x");
    assert_eq!(names(stage.desc()), ["big ball", "right", "floor"]);
    assert!(stage.status().contains("deleted big ball 2; u brings it back"), "{}", stage.status());
    let end = stage.desc().clone();
    stage.keys("uuuuuuu");
    assert_eq!(*stage.desc(), start);
    stage.keys("u");
    assert!(stage.status().contains("nothing to undo"), "{}", stage.status());
    stage.keys("UUUUU");
    stage.press("Ctrl-R");
    assert_eq!(*stage.desc(), end);
}

#[test]
fn what_cannot_be_done_is_told_and_changes_nothing() {
    let mut stage = Stage::with(three(), (80, 24));
    let start = stage.desc().clone();
    for (keys, words) in [
        ("x", "camera cannot be deleted"),
        ("y", "camera cannot be duplicated"),
        ("v", "only objects and lights can be hidden"),
        ("e", "the camera has no name"),
        ("g", "select objects or lights first"),
        ("C", "this has no colour"),
        ("T", "this has no texture"),
        ("5", "there is no view 5 yet"),
    ] {
        stage.keys(keys);
        assert!(stage.status().contains(words), "{keys}: {}", stage.status());
        assert_eq!(*stage.desc(), start);
    }
}

#[test]
fn the_menu_adds_each_kind_and_selects_it() {
    for (letter, name, objects, lights, materials) in [
        ('s', "sphere", 1, 0, 1),
        ('b', "cuboid", 1, 0, 1),
        ('c', "cylinder", 1, 0, 1),
        ('k', "cone", 1, 0, 1),
        ('p', "plane", 1, 0, 1),
        ('q', "quad", 1, 0, 1),
        ('l', "lamp 2", 0, 1, 0),
        ('d', "sun", 0, 1, 0),
        ('m', "material", 0, 0, 1),
    ] {
        let mut stage = Stage::with(three(), (80, 24));
        stage.keys("a");
        assert!(stage.text().contains("directional light"));
        stage.tell(glimt::tui::event::Event::Key(glimt::tui::key::Key::char(letter)));
        assert_eq!(stage.selected(), [name]);
        let desc = stage.desc();
        assert_eq!(desc.objects.len(), 3 + objects, "{name}");
        assert_eq!((desc.lights.len(), desc.materials.len()), (1 + lights, 1 + materials), "{name}");
        assert!(stage.status().contains(&format!("added {name}")), "{}", stage.status());
        assert!(stage.compile(), "{name}");
        stage.keys("u");
        assert_eq!(*stage.desc(), three());
    }
}

#[test]
fn g_moves_along_axes_by_nudges_and_by_typed_numbers() {
    let x = |stage: &Stage| stage.desc().objects[0].translate;
    for (keys, expected) in [
        ("g x 2 . 5 Enter", DVec3::new(1.5, 0.0, 0.0)),
        ("g y - 1 / 4 Enter", DVec3::new(-1.0, -0.25, 0.0)),
        ("g z + 0 . 5 Enter", DVec3::new(-1.0, 0.0, 0.5)),
        ("g x Right Right Left Enter", DVec3::new(-0.9, 0.0, 0.0)),
        ("g y Shift-Up Enter", DVec3::new(-1.0, 1.0, 0.0)),
        ("g x Right y Up Up Enter", DVec3::new(-0.9, 0.2, 0.0)),
        ("g x 5 Esc", DVec3::new(-1.0, 0.0, 0.0)),
        ("g x 5 Ctrl-X", DVec3::new(-1.0, 0.0, 0.0)),
        ("g x 5 Backspace 4 Enter", DVec3::new(3.0, 0.0, 0.0)),
    ] {
        let mut stage = at("left", (80, 24));
        stage.press(keys);
        assert!(x(&stage).abs_diff_eq(expected, 1e-9), "{keys}: {}", x(&stage));
        // One step, whatever it took.
        stage.keys("u");
        assert_eq!(*stage.desc(), three(), "{keys}");
    }
    let mut stage = at("left", (80, 24));
    stage.press("g x 2");
    assert!(stage.status().contains("move x: 2"), "{}", stage.status());
    assert!(stage.compile(), "what is typed is seen at once");
    stage.press("* *");
    assert_eq!(stage.app.message().unwrap().tone, Tone::Bad);
}

#[test]
fn without_an_axis_a_move_follows_the_arrows_on_the_screen() {
    let mut stage = at("left", (80, 24));
    stage.press("g Right Enter");
    let camera = stage.desc().camera;
    let moved = stage.desc().objects[0].translate - DVec3::NEG_X;
    let forward = (camera.look_at - camera.position).normalize();
    assert!(moved.dot(forward).abs() < 1e-9 && moved.dot(forward.cross(camera.up)) > 0.0);
    // Along the axes of the view.
    let mut stage = at("left", (80, 24));
    stage.press("g v z 1 Enter");
    let moved = stage.desc().objects[0].translate - DVec3::NEG_X;
    assert!(moved.abs_diff_eq(forward, 1e-9), "{moved}");
}

#[test]
fn several_objects_turn_and_scale_about_their_common_centre() {
    let both = || {
        let mut stage = at("left", (80, 24));
        stage.press("Shift-Down");
        assert_eq!(stage.selected(), ["left", "right"]);
        stage
    };
    let places = |stage: &Stage| [0, 1].map(|i: usize| stage.desc().objects[i].translate);
    let mut stage = both();
    stage.press("t y 9 0 Enter");
    let [left, right] = places(&stage);
    assert!(left.abs_diff_eq(DVec3::Z, 1e-9) && right.abs_diff_eq(DVec3::NEG_Z, 1e-9), "{left} {right}");
    let mut stage = both();
    stage.press("z * 2 Enter");
    assert_eq!(places(&stage), [DVec3::X * -2.0, DVec3::X * 2.0]);
    assert_eq!(stage.desc().objects[0].scale, DVec3::splat(2.0));
    let mut stage = both();
    stage.press("z x 3 Enter");
    assert_eq!(stage.desc().objects[1].scale, DVec3::new(3.0, 1.0, 1.0));
    // A light has a place too.
    let mut stage = at("lamp", (80, 24));
    stage.press("g y 1 Enter");
    assert!(matches!(stage.desc().lights[0].kind, LightKind::Point { position, .. } if position.y == 7.0));
}

#[test]
fn properties_are_nudged_typed_and_reset() {
    let mut stage = at("left", (80, 24));
    let radius = |stage: &Stage| match stage.desc().objects[0].shape {
        ShapeDesc::Sphere { radius } => radius,
        _ => panic!("not in this scene"),
    };
    stage.press("Enter");
    assert_eq!(stage.app.focus(), Focus::Properties);
    let to_radius = |stage: &mut Stage| {
        for _ in 0..30 {
            if stage.text().lines().any(|line| line.contains("▸ radius")) {
                return;
            }
            stage.press("Down");
        }
        panic!("{}", stage.text());
    };
    to_radius(&mut stage);
    stage.press("Shift-Right");
    assert!((radius(&stage) - 0.55).abs() < 1e-9, "{}", radius(&stage));
    stage.now += Duration::from_secs(5);
    stage.press("Right");
    assert!((radius(&stage) - 0.55 * 1.1f64.powf(0.1)).abs() < 1e-9, "{}", radius(&stage));
    assert!(stage.compile());
    stage.keys("uu");
    assert_eq!(radius(&stage), 0.5);
    stage.press("Enter");
    for _ in 0..3 {
        stage.press("Backspace");
    }
    stage.keys("+0.25");
    stage.press("Enter");
    assert_eq!(radius(&stage), 0.75);
    stage.press("Enter");
    stage.keys("*");
    stage.press("Enter");
    assert_eq!(stage.app.message().unwrap().tone, Tone::Bad);
    assert_eq!(radius(&stage), 0.75);
    stage.press("Esc");
    assert_eq!(stage.app.focus(), Focus::Properties);
    stage.press("Backspace");
    assert_eq!(radius(&stage), 0.5, "the default of the scene language");
    // Out of range.
    stage.press("Enter Backspace");
    stage.keys("0");
    stage.press("Enter");
    assert!(stage.status().contains("radius must be above 0"), "{}", stage.status());
}

#[test]
fn several_values_are_shown_as_mixed_and_an_edit_sets_all() {
    let mut stage = at("left", (200, 60));
    stage.press("Shift-Down Tab");
    let line = |stage: &mut Stage, label: &str| {
        stage.text().lines().find(|line| line.contains(label)).map(str::to_owned).unwrap()
    };
    assert!(line(&mut stage, "translate x").contains("mixed"));
    assert!(line(&mut stage, "translate y").contains(" 0 "));
    for _ in 0..30 {
        if line(&mut stage, "translate x").contains('▸') {
            break;
        }
        stage.press("Down");
    }
    stage.press("Enter");
    stage.keys("*2");
    stage.press("Enter");
    assert_eq!([0, 1].map(|i: usize| stage.desc().objects[i].translate.x), [-2.0, 2.0]);
    stage.press("Enter");
    stage.keys("3");
    stage.press("Enter");
    assert_eq!([0, 1].map(|i: usize| stage.desc().objects[i].translate.x), [3.0, 3.0]);
    stage.keys("uu");
    assert_eq!(*stage.desc(), three());
}

#[test]
fn a_held_key_is_one_step_and_a_pause_begins_another() {
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys("hhhhhhhhhh");
    let after = stage.desc().clone();
    stage.now += Duration::from_secs(3);
    stage.keys("hhh");
    stage.keys("u");
    assert_eq!(*stage.desc(), after);
    stage.keys("u");
    assert_eq!(*stage.desc(), three());
    assert!(!stage.app.editor().history().is_unsaved());
}

#[test]
fn the_camera_frames_the_selection_and_views_are_kept() {
    let mut stage = at("right", (80, 24));
    let start = stage.desc().camera;
    stage.keys(".");
    let camera = stage.desc().camera;
    assert!(camera.look_at.abs_diff_eq(DVec3::X, 1e-6), "{}", camera.look_at);
    let Projection::Perspective { fov } = camera.projection else { panic!("not in this scene") };
    // The ball's box has a half diagonal of 0.87; with a margin it touches the upper edge.
    let distance = camera.position.distance(camera.look_at);
    let angle = (0.5 * 3f64.sqrt() * 1.1 / distance).asin().to_degrees();
    assert!((angle - fov / 2.0).abs() < 0.01, "{angle}");
    stage.keys("V3");
    assert!(stage.status().contains("this is view 3 now"), "{}", stage.status());
    stage.keys("i");
    assert_ne!(stage.desc().camera, camera);
    stage.keys("3");
    assert_eq!(stage.desc().camera, camera);
    stage.keys("c");
    assert_eq!(stage.desc().camera, start);
}

#[test]
fn threads_are_one_fewer_or_more_and_never_none() {
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys("]");
    assert!(stage.compile() && stage.status().contains("3 threads"), "{}", stage.status());
    stage.keys("[[[[");
    assert!(stage.status().contains("1 thread"), "{}", stage.status());
    assert!(stage.compile() && *stage.desc() == three());
}

#[test]
fn an_edit_is_marked_as_not_saved_until_it_is_undone() {
    for size in [(200, 60), (80, 24)] {
        let mut stage = at("left", size);
        let mark = |stage: &mut Stage| stage.text().contains("● not saved");
        assert!(!mark(&mut stage));
        stage.keys("v");
        assert!(mark(&mut stage));
        stage.keys("u");
        assert!(!mark(&mut stage));
    }
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys("n");
    assert!(stage.status().contains('●'), "{}", stage.status());
}

#[test]
fn swatches_in_the_tree_have_the_colour_of_their_material() {
    let mut desc = three();
    desc.materials[0].color = Rgb::new(1.0, 0.0, 0.0);
    desc.world.background = Background::Solid(Rgb::BLACK);
    let mut stage = Stage::with(desc, (200, 60));
    let text = stage.text();
    let row = text.lines().position(|line| line.contains("paint")).unwrap();
    let buffer = stage.buffer();
    let red = (0..200).filter(|x| buffer[(*x, row as u16)].symbol() == "█");
    assert!(red.clone().count() > 0);
    for x in red {
        assert_eq!(buffer[(x, row as u16)].fg, Color::Rgb(255, 0, 0));
    }
    assert_eq!(stage.app.editor().tree.cursor(), Target::Camera);
}

/// A scene of so many balls, and the rest of [`three`].
pub fn many(count: usize) -> SceneDesc {
    let mut desc = three();
    for index in 0..count {
        let (x, y) = ((index % 90) as f64 / 10.0, (index / 90) as f64 / 10.0);
        desc.objects.push(ObjectDesc {
            name: format!("ball {index}"),
            material: Some("paint".into()),
            translate: DVec3::new(x, y, 0.0),
            ..ObjectDesc::new(ShapeDesc::Sphere { radius: 0.05 })
        });
    }
    desc
}

#[test]
fn a_group_of_thousands_is_folded_and_shows_what_is_selected_of_it() {
    let mut stage = Stage::with(many(7378), (200, 60));
    let text = stage.text();
    for word in ["▸ Objects (7381)", "  left ", "… 7380 more", "Lights", "lamp", "paint"] {
        assert!(text.contains(word), "{word}\n{text}");
    }
    assert!(!text.contains("right"), "{text}");
    // What is picked or found is shown in its place; a search finds in folded groups.
    stage.keys("/ball 500");
    assert!(stage.text().contains("ball 5001"));
    stage.press("Enter Esc");
    assert_eq!(stage.selected(), ["ball 500"]);
    let text = stage.text();
    assert!(text.contains("… 7379 more") && text.contains("ball 500 "), "{text}");
    assert!(stage.status().contains("open the group"), "{}", stage.status());
    // It opens about the cursor, and folds again.
    stage.press("Right Down");
    assert_eq!(stage.selected(), ["ball 501"]);
    let text = stage.text();
    assert!(text.contains("ball 499") && text.contains("ball 502") && !text.contains(" more"), "{text}");
    stage.press("Left");
    assert!(stage.text().contains("… 7379 more"));
    stage.press("Down");
    assert_eq!(stage.selected(), ["lamp"]);
    // Small groups fold too, on their heading, by the mouse.
    let row = stage.text().lines().position(|line| line.contains("Scene")).unwrap();
    let column = stage.app.layout().editor.unwrap().x + 5;
    stage.click(column, row as u16, false);
    let text = stage.text();
    assert!(text.contains("▸ Scene") && text.contains("… 3 more") && !text.contains("  world"), "{text}");
    stage.click(column, row as u16, false);
    assert!(stage.text().contains("  world"));
}
