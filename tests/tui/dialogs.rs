//! Dialogs: colour, texture, model, palette, saving.

use super::editor::three;
use super::stage::Stage;
use glam::DVec3;
use glimt::description::edit::Bounds;
use glimt::description::{ObjectDesc, SceneDesc, ShapeDesc, TextureSource, Wrap, parse, parse_color};
use glimt::tui::FileText;
use glimt::tui::app::{Activity, Focus, Tone};
use glimt::tui::dialog::files::{Entry, Thumbnail};
use glimt::tui::event::{Effect, Event, Exit};
use glimt::tui::keymap::Keymap;
use ratatui::style::Color;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn color(desc: &SceneDesc) -> glimt::math::Rgb {
    desc.materials[0].color
}

/// With the first ball selected.
fn ball(size: (u16, u16)) -> Stage {
    let mut stage = Stage::with(three(), size);
    stage.keys("/left");
    stage.press("Enter Esc");
    stage
}

#[test]
fn the_colour_dialog_shows_its_colour_in_the_scene_at_once() {
    let mut stage = ball((200, 60));
    let before = color(stage.desc());
    stage.keys("C");
    let text = stage.text();
    for word in ["color of paint", "red", "green", "blue", "hue", "saturation", "value", "code, name", "named"] {
        assert!(text.contains(word), "{word}\n{text}");
    }
    stage.keys("#ff0000");
    assert_eq!(color(stage.desc()), parse_color("red").unwrap());
    assert!(stage.compile(), "the picture follows");
    let buffer = stage.buffer();
    let swatch = buffer.content().iter().filter(|cell| cell.symbol() == "█" && cell.fg == Color::Rgb(255, 0, 0));
    assert!(swatch.count() > 30);
    // Escape takes all of it back.
    stage.press("Esc");
    assert_eq!(color(stage.desc()), before);
    assert!(!stage.app.editor().history().is_unsaved());
    // Enter keeps it as one step, and the colour is remembered.
    stage.keys("Ctomato");
    stage.press("Enter");
    assert_eq!(color(stage.desc()), parse_color("tomato").unwrap());
    stage.keys("u");
    assert_eq!(color(stage.desc()), before);
    stage.keys("C");
    assert!(stage.text().contains("recent"));
    stage.press("Shift-Tab Right");
    stage.press("Left Enter");
    assert_eq!(color(stage.desc()), parse_color("tomato").unwrap());
}

#[test]
fn sliders_and_palette_of_the_colour_dialog_move_by_keys() {
    let mut stage = ball((80, 24));
    stage.keys("C#102030");
    stage.press("Esc");
    stage.keys("C#102030");
    // From the code down to the named colours, round to red.
    stage.press("Down Right");
    assert_eq!(color(stage.desc()), parse_color("silver").unwrap());
    stage.press("Left Enter");
    assert_eq!(color(stage.desc()), parse_color("white").unwrap());
    stage.keys("C");
    stage.press("Left Left Enter");
    assert_eq!(color(stage.desc()), parse_color("#fdffff").unwrap());
    stage.keys("C");
    stage.press("Tab Tab Shift-Left Enter");
    assert_eq!(color(stage.desc()), parse_color("#fdfff5").unwrap());
}

#[test]
fn an_object_without_a_material_gets_one_of_its_own_with_its_first_colour() {
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys("/floor");
    stage.press("Enter Esc");
    stage.keys("Cgold");
    stage.press("Enter");
    assert_eq!(stage.desc().materials.len(), 2);
    assert_eq!(stage.desc().materials[1].color, parse_color("gold").unwrap());
    assert_eq!(stage.desc().objects[2].material.as_ref(), Some(&stage.desc().materials[1].name));
    stage.keys("u");
    assert_eq!(*stage.desc(), three());
    stage.keys("Cgold");
    stage.press("Esc");
    assert_eq!(*stage.desc(), three());
}

fn entries(names: &[(&str, bool)]) -> Vec<Entry> {
    names.iter().map(|(name, is_file)| Entry { is_file: *is_file, name: name.into() }).collect()
}

fn thumbnail(code: [u8; 3]) -> Thumbnail {
    Thumbnail::new((64, 32), &vec![code; 64 * 32])
}

#[test]
fn the_texture_dialog_lists_pictures_and_shows_the_one_under_the_cursor() {
    let mut stage = ball((120, 40));
    stage.app.set_directory("/pictures".into());
    stage.keys("T");
    assert!(matches!(stage.effects.last(), Some(Effect::List(directory, endings))
        if directory == Path::new("/pictures") && endings.contains(&"png")));
    let listed = entries(&[("wood.png", true), ("old", false), ("esc\u{1b}[2J.png", true)]);
    stage.tell(Event::Listed { directory: "/pictures".into(), entries: Ok(listed) });
    let text = stage.text();
    assert!(text.contains("old/") && text.contains("../") && text.contains("esc\u{fffd}[2J.png"), "{text}");
    stage.keys("wood");
    let wood = PathBuf::from("/pictures/wood.png");
    assert!(matches!(stage.effects.last(), Some(Effect::Look(file)) if *file == wood));
    stage.tell(Event::Looked { file: "/other.png".into(), picture: Ok(thumbnail([0, 255, 0])) });
    stage.tell(Event::Looked { file: wood.clone(), picture: Ok(thumbnail([200, 100, 50])) });
    let buffer = stage.buffer();
    let painted = buffer.content().iter().filter(|cell| cell.symbol() == "▀" && cell.fg == Color::Rgb(200, 100, 50));
    assert!(painted.count() > 100);
    assert!(stage.text().contains("64×32"));
    stage.press("Enter");
    let texture = |stage: &Stage| stage.desc().materials[0].texture.clone().expect("there is a texture");
    assert!(matches!(texture(&stage).source, TextureSource::Image { file, wrap: Wrap::Repeat } if file == wood));
    // Then how it is wrapped and scaled.
    stage.press("Right");
    assert!(matches!(texture(&stage).source, TextureSource::Image { wrap: Wrap::Clamp, .. }));
    stage.press("Down Shift-Right");
    assert!(texture(&stage).scale.x > 1.0 && texture(&stage).scale.y == 1.0);
    stage.press("Enter");
    assert!(stage.app.dialog().is_none());
    stage.keys("u");
    assert_eq!(*stage.desc(), three(), "all of it is one step");
    stage.keys("U");
    stage.keys("T");
    assert!(matches!(stage.effects.last(), Some(Effect::List(directory, _)) if directory == Path::new("/pictures")));
    stage.press("Tab Right Right Right Esc");
    assert!(matches!(texture(&stage).source, TextureSource::Image { wrap: Wrap::Clamp, .. }));
}

#[test]
fn a_directory_or_picture_that_cannot_be_read_says_why() {
    let mut stage = ball((120, 40));
    stage.app.set_directory("/pictures".into());
    stage.keys("T");
    stage.tell(Event::Listed { directory: "/pictures".into(), entries: Err("permission denied\u{1b}".into()) });
    assert!(stage.text().contains("permission denied\u{fffd}"), "{}", stage.text());
    stage.press("Backspace");
    assert!(matches!(stage.effects.last(), Some(Effect::List(directory, _)) if directory == Path::new("/")));
    stage.tell(Event::Listed { directory: "/".into(), entries: Ok(entries(&[("a.png", true)])) });
    stage.tell(Event::Looked { file: "/a.png".into(), picture: Err("it is no picture".into()) });
    assert!(stage.text().contains("it is no picture"), "{}", stage.text());
}

#[test]
fn a_model_is_chosen_from_the_files_measured_and_added_in_view() {
    let mut stage = Stage::with(three(), (80, 24));
    stage.app.set_directory("/models".into());
    stage.keys("af");
    assert!(
        matches!(stage.effects.last(), Some(Effect::List(directory, ["obj"])) if directory == Path::new("/models"))
    );
    stage.tell(Event::Listed {
        directory: "/models".into(),
        entries: Ok(entries(&[("sub", false), ("gem.obj", true)])),
    });
    stage.press("Down Enter");
    assert!(matches!(stage.effects.last(), Some(Effect::List(directory, _)) if directory == Path::new("/models/sub")));
    stage.tell(Event::Listed { directory: "/models/sub".into(), entries: Ok(entries(&[("gem.obj", true)])) });
    stage.press("Down Enter");
    let file = PathBuf::from("/models/sub/gem.obj");
    assert!(matches!(stage.effects.last(), Some(Effect::Measure(wanted)) if *wanted == file));
    stage.tell(Event::Measured { file: file.clone(), bounds: Err("line 3: no".into()) });
    assert_eq!(stage.app.message().unwrap().tone, Tone::Bad);
    let bounds = Bounds { lower: DVec3::splat(-100.0), upper: DVec3::splat(100.0) };
    stage.tell(Event::Measured { file: file.clone(), bounds: Ok(bounds) });
    let added = stage.desc().objects.last().unwrap();
    assert!(matches!(&added.shape, ShapeDesc::Mesh { file: named, .. } if *named == file));
    let size = 200.0 * added.scale.x;
    assert!(size > 0.2 && size < 3.0, "{size}");
    assert_eq!(stage.selected(), ["gem"]);
}

#[test]
fn the_palette_finds_commands_by_pieces_of_their_names_and_does_them() {
    for (typed, check) in
        [("undo", "nothing to undo"), ("half", "2 samples a pixel"), ("nlm", "lighting model lambert")]
    {
        for key in [":", "Ctrl-P"] {
            let mut stage = Stage::with(three(), (80, 24));
            stage.press(key);
            stage.keys(typed);
            stage.press("Enter");
            assert!(stage.status().contains(check), "{typed}: {}", stage.status());
        }
    }
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys(":sav");
    let text = stage.text();
    assert!(text.contains("save scene as") && text.contains("save picture") && !text.contains("zoom in"), "{text}");
    stage.keys("xyz");
    assert!(stage.text().contains("no such command"));
    stage.press("Enter Ctrl-X");
    assert!(stage.app.dialog().is_none());
}

#[test]
fn the_users_own_keys_are_used_and_named() {
    let mut stage = Stage::with(three(), (200, 60));
    stage.app.set_keymap(Keymap::parse("undo = \"Ctrl-U\"\nhelp = \"!\"\n").unwrap());
    assert!(stage.status().contains("! keys"), "{}", stage.status());
    stage.keys("n");
    stage.press("Ctrl-U");
    assert_eq!(*stage.desc(), three());
    stage.keys("!");
    assert!(stage.text().contains("Ctrl-U U Ctrl-R") || stage.text().contains("Ctrl-U"), "{}", stage.text());
}

fn source(text: &str) -> (SceneDesc, FileText) {
    let file = PathBuf::from("/scenes/one.toml");
    let desc = parse(text, &file).unwrap();
    (desc.clone(), FileText { file, text: text.into(), desc: Arc::new(desc) })
}

const SCENE: &str =
    "# a ball\n[film]\nwidth = 64\nheight = 36\n\n[[object]]\nname = \"ball\" # round\nshape = \"sphere\"\n";

#[test]
fn saving_writes_the_users_text_with_the_change_and_ends_the_mark() {
    let (desc, file) = source(SCENE);
    let mut stage = Stage::with(desc, (80, 24));
    stage.app.set_source(file);
    stage.keys("/ball");
    stage.press("Enter Esc g y 2 Enter");
    stage.effects.clear();
    stage.keys("w");
    let Some(Effect::WriteScene(written)) = stage.effects.pop() else { panic!("nothing is written") };
    assert_eq!(written.file, Path::new("/scenes/one.toml"));
    assert!(written.text.starts_with("# a ball\n[film]") && written.text.contains("name = \"ball\" # round"));
    assert_eq!(parse(&written.text, &written.file).unwrap(), *stage.desc());
    assert!(stage.app.editor().history().is_unsaved());
    stage.tell(Event::SceneWritten { written, result: Ok(()) });
    assert!(!stage.app.editor().history().is_unsaved());
    assert!(stage.status().contains("saved one.toml"), "{}", stage.status());
    stage.keys("q");
    assert_eq!(stage.app.exit(), Some(&Exit::Quit));
}

#[test]
fn a_scene_that_cannot_be_written_is_still_not_saved() {
    let (desc, file) = source(SCENE);
    let mut stage = Stage::with(desc, (80, 24));
    stage.app.set_source(file);
    stage.keys("nqs");
    let Some(Effect::WriteScene(written)) = stage.effects.pop() else { panic!("nothing is written") };
    assert_eq!(stage.app.exit(), None);
    stage.tell(Event::SceneWritten { written: written.clone(), result: Err("the disk is full".into()) });
    assert!(stage.status().contains("cannot save one.toml: the disk is full"), "{}", stage.status());
    assert!(stage.app.exit().is_none() && stage.app.editor().history().is_unsaved());
    // And once more, with room.
    stage.keys("qs");
    stage.tell(Event::SceneWritten { written, result: Ok(()) });
    assert_eq!(stage.app.exit(), Some(&Exit::Quit));
}

#[test]
fn a_scene_without_a_file_asks_for_one() {
    let mut stage = Stage::with(three(), (80, 24));
    stage.keys("nw");
    assert!(stage.text().contains("Save the scene as"));
    for _ in 0..60 {
        stage.press("Backspace");
    }
    stage.press("Enter");
    assert!(stage.text().contains("type the name of a file"), "{}", stage.text());
    stage.keys("picture.png");
    stage.press("Enter");
    assert!(stage.text().contains("ends in .toml"), "{}", stage.text());
    for _ in 0..4 {
        stage.press("Backspace");
    }
    stage.keys(".toml");
    stage.press("Enter");
    let Some(Effect::WriteScene(written)) = stage.effects.pop() else { panic!("nothing is written") };
    assert_eq!(written.file, Path::new("picture.toml"));
    assert_eq!(parse(&written.text, &written.file).unwrap(), *stage.desc());
    stage.tell(Event::SceneWritten { written, result: Ok(()) });
    assert_eq!(stage.app.name(), "picture");
    // From now on it has one.
    stage.keys("Nw");
    assert!(matches!(stage.effects.last(), Some(Effect::WriteScene(_))));
}

#[test]
fn what_flags_said_is_not_written_into_the_file() {
    let (desc, file) = source(SCENE);
    let mut flagged = desc.clone();
    (flagged.film.width, flagged.render.samples) = (32, 2);
    let mut stage = Stage::with(flagged, (80, 24));
    stage.app.set_source(file);
    stage.keys("/ball");
    stage.press("Enter Esc");
    stage.keys("vw");
    let Some(Effect::WriteScene(written)) = stage.effects.pop() else { panic!("nothing is written") };
    let said = parse(&written.text, &written.file).unwrap();
    assert_eq!((said.film, said.render), (desc.film, desc.render));
    assert!(!said.objects[0].visible);
}

#[test]
fn pasted_text_goes_into_fields_and_nowhere_else() {
    let mut stage = ball((80, 24));
    stage.tell(Event::Pasted("xxqq".into()));
    assert!(stage.app.exit().is_none() && *stage.desc() == three());
    stage.keys("e");
    stage.tell(Event::Pasted(" hand\u{1b}[2J\n".into()));
    stage.press("Enter");
    assert_eq!(stage.desc().objects[0].name, "left hand[2J");
    stage.keys("C");
    stage.tell(Event::Pasted("#00ff00".into()));
    stage.press("Enter");
    assert_eq!(color(stage.desc()), parse_color("lime").unwrap());
}

#[test]
fn a_picture_that_is_missing_leaves_the_last_good_one() {
    let mut stage = ball((120, 40));
    stage.tile(|_, _| [0.0, 1.0, 0.0]);
    let good = stage.buffer()[(20, 8)].fg;
    stage.app.set_directory("/nowhere".into());
    stage.keys("T");
    stage.tell(Event::Listed { directory: "/nowhere".into(), entries: Ok(entries(&[("no.png", true)])) });
    stage.keys("no");
    stage.press("Enter Enter");
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Failed);
    assert!(stage.status().contains("no.png"), "{}", stage.status());
    assert_eq!(stage.buffer()[(20, 8)].fg, good);
    stage.keys("u");
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Rendering);
    assert_eq!(stage.app.focus(), Focus::Tree);
}

#[test]
fn a_file_that_changes_is_reloaded_with_selection_and_camera_and_a_broken_one_is_told() {
    let (desc, file) = source(&format!("{SCENE}[[object]]\nname = \"other\"\nshape = \"cuboid\"\n"));
    let own = file.file.clone();
    let mut stage = Stage::with(desc, (120, 40));
    stage.app.set_source(file);
    assert!(matches!(stage.app.begin_watch(), Some(Effect::Watch(files)) if files.contains(&own)));
    assert!(stage.app.begin_watch().is_none());
    stage.keys("/other");
    stage.press("Enter Esc");
    stage.keys("i");
    let camera = stage.desc().camera;
    stage.tell(Event::FilesChanged(vec![own.clone()]));
    assert!(matches!(stage.effects.last(), Some(Effect::Reread(file)) if *file == own));

    // What is wrong is told beside the picture, which goes on.
    let before = stage.desc().clone();
    let mistakes = vec!["error: there is no key radus".to_owned(), "  --> one.toml:7:1".to_owned()];
    stage.tell(Event::Reread { file: own.clone(), result: Err(mistakes) });
    let text = stage.text();
    assert!(text.contains("there is no key radus") && text.contains("one.toml:7:1"), "{text}");
    assert_eq!(*stage.desc(), before);

    // Put right, with another object before the selected one.
    let text = "[film]\nwidth = 64\nheight = 36\n[[object]]\nshape = \"plane\"\n[[object]]\nname = \"ball\"\n\
                shape = \"sphere\"\nradius = 0.7\n[[object]]\nname = \"other\"\nshape = \"cuboid\"\n";
    let now = parse(text, &own).unwrap();
    stage.tell(Event::Reread { file: own.clone(), result: Ok((text.to_owned(), now.clone())) });
    assert!(stage.compile() && !stage.text().contains("radus"));
    assert_eq!(stage.desc().objects, now.objects);
    assert_eq!((stage.desc().camera, stage.selected()), (camera, vec!["other".to_owned()]));
    assert!(
        stage.status().contains("one.toml has changed: reloaded; u brings your changes back"),
        "{}",
        stage.status()
    );
    // The same again, as after a save of our own, does nothing.
    stage.tell(Event::Reread { file: own, result: Ok((text.to_owned(), now)) });
    assert!(!stage.compile());
    stage.keys("u");
    assert_eq!(*stage.desc(), before);
}

#[test]
fn a_model_that_changes_is_read_again_and_a_broken_one_leaves_the_last_good_picture() {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tui-reload");
    std::fs::create_dir_all(&directory).unwrap();
    let file = directory.join("triangle.obj");
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let mut desc = three();
    desc.objects.push(ObjectDesc::new(ShapeDesc::Mesh { file: file.clone(), crease: 30.0 }));
    let mut stage = Stage::with(desc, (120, 40));
    assert!(matches!(stage.app.begin_watch(), Some(Effect::Watch(files)) if files.contains(&file)));
    let starts = |stage: &Stage| stage.effects.iter().filter(|effect| matches!(effect, Effect::Start(_))).count();
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n").unwrap();
    stage.tell(Event::FilesChanged(vec![file.clone()]));
    assert!(stage.compile());
    let Some(Effect::Start(scene)) = stage.effects.last() else { panic!("nothing is rendered") };
    assert_eq!((scene.summary.triangles, starts(&stage)), (2, 2));
    std::fs::write(&file, "nothing of use\n").unwrap();
    stage.tell(Event::FilesChanged(vec![file.clone()]));
    assert!(stage.compile());
    assert_eq!((stage.app.activity(), starts(&stage)), (Activity::Failed, 2));
    assert!(stage.status().contains("triangle.obj"), "{}", stage.status());
    // It is still another one when anything else is edited.
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    stage.keys("i");
    assert!(stage.compile());
    let Some(Effect::Start(scene)) = stage.effects.last() else { panic!("nothing is rendered") };
    assert_eq!(scene.summary.triangles, 1);
}
