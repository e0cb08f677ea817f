//! The interface without a terminal: state and keys in, screen and description out; and what is sent to a terminal.

mod adviser;
mod dialogs;
mod editor;
mod pointing;
mod stage;
mod storm;
mod views;
mod wire;

use glimt::description::{ObjectDesc, SceneDesc, Shading, ShapeDesc};
use glimt::render::{Film, RenderError, RenderEvent, Settings, start};
use glimt::scene::compile;
use glimt::tui::app::{Activity, App, Tone};
use glimt::tui::bindings::BINDINGS;
use glimt::tui::color::ColorMode;
use glimt::tui::event::{Effect, Event, Exit};
use glimt::tui::key::{Code, Key};
use glimt::tui::keymap::Keymap;
use ratatui::style::Color;
use stage::{HEIGHT, Stage, WIDTH, scene};
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

#[test]
fn keys_edit_the_description() {
    let (samples, fov, depth) = Stage::started((80, 24)).samples_fov_depth();
    for (keys, expected) in [
        ("n", (2 * samples, fov, depth)),
        ("nnN", (2 * samples, fov, depth)),
        ("NNNNNN", (1, fov, depth)),
        ("d", (samples, fov, depth + 1)),
        ("DDD", (samples, fov, depth - 3)),
        ("DDDDDDDDDDDD", (samples, fov, 0)),
        ("F", (samples, fov * 1.05, depth)),
    ] {
        let mut stage = Stage::started((80, 24));
        stage.keys(keys);
        assert_eq!(stage.samples_fov_depth(), expected, "{keys}");
    }
    let mut stage = Stage::started((80, 24));
    for shading in [Shading::Lambert, Shading::Phong, Shading::Whitted] {
        stage.keys("m");
        assert_eq!(stage.app.desc().render.shading, shading);
    }
}

#[test]
fn keys_move_the_camera_and_reset_it() {
    let start = scene().camera;
    let distance = start.position.distance(start.look_at);
    for (keys, moves_target, new_distance) in
        [("hkkl", false, distance), ("HJ", true, distance), ("i", false, distance * 0.9), ("o", false, distance / 0.9)]
    {
        let mut stage = Stage::started((80, 24));
        stage.keys(keys);
        let camera = stage.app.desc().camera;
        assert_ne!(camera.position, start.position, "{keys}");
        assert_eq!(camera.look_at != start.look_at, moves_target, "{keys}");
        assert!((camera.position.distance(camera.look_at) - new_distance).abs() < 1e-9, "{keys}");
        stage.keys("c");
        assert_eq!(stage.app.desc().camera, start);
    }
}

#[test]
fn arrows_orbit_a_fitted_picture_and_move_a_zoomed_one() {
    let mut stage = Stage::finished((80, 24));
    stage.tell(Event::Key(Key::plain(Code::Left)));
    let orbited = stage.app.desc().camera;
    assert_ne!(orbited, scene().camera);
    stage.keys("++");
    let before = stage.buffer();
    for _ in 0..9 {
        stage.tell(Event::Key(Key::plain(Code::Left)));
    }
    assert_eq!(stage.app.desc().camera, orbited);
    assert_ne!(stage.buffer(), before);
    // The left edge of the picture is red.
    assert_eq!(stage.buffer()[(0, 0)].fg, Color::Rgb(255, 0, 0));
    assert!(stage.status().contains("2.0×"), "{}", stage.status());
    stage.keys("0");
    assert!(!stage.app.is_zoomed());
}

#[test]
fn a_burst_of_keys_is_one_restart_with_all_of_them() {
    let mut stage = Stage::started((80, 24));
    stage.keys("hhhhnn");
    let (desc, ..) = stage.app.begin_compile(stage.now).expect("there were edits");
    assert_eq!(desc.render.samples, 16);
    // Keys that come while the compiler is at work wait for it.
    stage.keys("n");
    assert!(stage.app.begin_compile(stage.now).is_none());
    stage.tell(Event::Compiled(compile(&desc, None).map(Arc::new)));
    assert!(stage.compile());
    assert!(!stage.compile());
    let starts = stage.effects.iter().filter(|effect| matches!(effect, Effect::Start(_))).count();
    assert_eq!(starts, 3);
}

#[test]
fn a_model_that_is_compiled_already_is_not_read_again() {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tui-lend");
    std::fs::create_dir_all(&directory).unwrap();
    let file = directory.join("triangle.obj");
    std::fs::write(&file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let mesh = ObjectDesc::new(ShapeDesc::Mesh { file: file.clone(), crease: 30.0 });
    let desc = SceneDesc { objects: vec![mesh], ..scene() };
    let alone = compile(&desc, None).unwrap();
    std::fs::remove_file(&file).unwrap();
    let app = App::new(desc, "triangle", Path::new("triangle.png"), 2, ColorMode::None, (80, 24));
    let mut stage = Stage { app, now: Instant::now(), effects: Vec::new() };
    stage.app.lend(Arc::new(alone));
    for _ in 0..2 {
        assert!(stage.compile());
        assert_eq!((stage.app.exit(), stage.app.activity()), (None, Activity::Rendering));
        stage.keys("r");
    }
}

#[test]
fn a_key_at_its_limit_restarts_nothing() {
    let mut stage = Stage::started((80, 24));
    stage.keys("NNNN");
    assert!(stage.compile());
    stage.keys("N");
    assert!(!stage.compile());
    stage.keys("r");
    assert!(stage.compile());
}

#[test]
fn space_pauses_and_goes_on() {
    let mut stage = Stage::started((80, 24));
    stage.effects.clear();
    stage.keys(" ");
    assert!(matches!(stage.effects[..], [Effect::Pause(true)]));
    assert!(stage.status().contains("paused") && stage.status().contains("Space go on"), "{}", stage.status());
    stage.keys(" ");
    assert!(matches!(stage.effects[..], [_, Effect::Pause(false)]));
    assert_eq!(stage.app.activity(), Activity::Rendering);
    // An edit while paused is meant to be seen.
    stage.keys(" h");
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Rendering);
}

/// Keys come every 40 ms, and the first pass of each render takes so long: however slow the scene, whole pictures are
/// seen while the key is held, and in the end that of the last edit.
#[test]
fn between_the_edits_of_a_held_key_whole_pictures_are_shown() {
    for pass in [5, 90, 700, 5000].map(Duration::from_millis) {
        let mut stage = Stage::finished((80, 24));
        let (mut begun, mut seen) = (None, 0);
        let go_on = |stage: &mut Stage, begun: &mut Option<Instant>| {
            if begun.is_some_and(|begun| stage.now - begun >= pass) {
                stage.tile(|_, _| [0.25; 3]);
                *begun = None;
                assert!(stage.app.is_awaited(), "it is whole");
                assert!(!stage.compile_at(stage.now), "what is whole is shown first");
                stage.text();
                assert!(!stage.app.is_awaited());
                return 1;
            }
            0
        };
        for _ in 0..1000 {
            stage.press("Left");
            seen += go_on(&mut stage, &mut begun);
            if stage.compile_at(stage.now) {
                begun = Some(stage.now);
            }
        }
        let least = 1000 * 40 / (4 * pass.as_millis().max(80) as usize);
        assert!(seen >= least, "{seen} whole pictures, {least} were to be expected at {pass:?} each");
        // The key is let go.
        while !stage.app.is_seen() {
            stage.tell(Event::Resize(80, 24));
            go_on(&mut stage, &mut begun);
            if stage.compile_at(stage.now) {
                begun = Some(stage.now);
            }
        }
        assert!(!stage.compile() && stage.app.latency().is_some());
    }
}

#[test]
fn a_pause_while_the_compiler_is_at_work_is_one_of_the_new_render() {
    let mut stages =
        [Stage::new((200, 60), ColorMode::Truecolor), Stage::started((200, 60)), Stage::finished((200, 60))];
    for stage in &mut stages {
        stage.keys("br");
        let (desc, previous, _) = stage.app.begin_compile(stage.now + Duration::from_secs(1)).unwrap();
        stage.keys(" ");
        assert!(stage.status().contains("paused"), "{}", stage.status());
        stage.effects.clear();
        stage.tell(Event::Compiled(compile(&desc, previous.as_deref()).map(Arc::new)));
        assert!(matches!(stage.effects[..], [Effect::Start(_), Effect::Pause(true)]));
        assert_eq!(stage.app.activity(), Activity::Paused);
        // The clock stands.
        stage.now += Duration::from_secs(100);
        stage.keys(" ");
        assert_eq!(stage.app.activity(), Activity::Rendering);
        stage.now += Duration::from_secs(1);
        assert!(
            stage.text().lines().any(|line| line.contains("elapsed") && line.ends_with("  1.0 s ")),
            "{}",
            stage.text()
        );
    }
    // In one batch with the key that restarts, in which the old render ends too; and taken back.
    let mut stage = Stage::started((80, 24));
    stage.keys("r ");
    stage.tell(Event::Render(RenderEvent::Finished));
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Paused);
    stage.keys("r  ");
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Rendering);
}

#[test]
fn the_end_of_a_render_saves_the_picture_and_says_where() {
    let mut stage = Stage::started((80, 24));
    stage.tile(|_, _| [0.5; 3]);
    stage.effects.clear();
    stage.tell(Event::Render(RenderEvent::Finished));
    assert!(matches!(stage.effects[..], [Effect::Save(100)]));
    stage.tell(Event::Saved(Ok(100)));
    assert!(stage.status().contains("finished") && stage.status().contains("saved balls.png"), "{}", stage.status());
    assert!(stage.text().contains("100 %"));
    assert_eq!(stage.app.exit(), None);
    stage.keys("s");
    stage.tell(Event::Saved(Err("no room on the disk".into())));
    assert_eq!(stage.app.note().unwrap().tone, Tone::Bad);
    assert!(stage.status().contains("cannot save balls.png: no room"), "{}", stage.status());
}

#[test]
fn a_save_before_the_first_whole_picture_waits_for_it() {
    let mut stage = Stage::finished((80, 24));
    stage.keys("h");
    assert!(stage.compile());
    stage.effects.clear();
    stage.keys("s");
    assert!(stage.effects.is_empty());
    assert!(stage.status().contains("will be saved"), "{}", stage.status());
    stage.tile(|_, _| [0.2; 3]);
    assert!(matches!(stage.effects[..], [Effect::Save(percent)] if percent < 100));
}

#[test]
fn the_old_picture_stays_until_tiles_of_the_new_one_come() {
    let mut stage = Stage::finished((80, 24));
    let before = stage.buffer();
    stage.keys("h");
    assert!(stage.compile());
    let preview = stage.app.layout().preview;
    let after = stage.buffer();
    for position in preview.positions() {
        assert_eq!(after[position], before[position]);
    }
    stage.tile(|_, _| [0.0, 1.0, 0.0]);
    assert_eq!(stage.buffer()[(40, 5)].fg, Color::Rgb(0, 255, 0));
}

#[test]
fn a_failed_render_is_told_and_keeps_its_picture() {
    let mut stage = Stage::finished((80, 24));
    let colour = stage.buffer()[(20, 5)].fg;
    stage.tell(Event::Render(RenderEvent::Failed(RenderError { worker: 1, message: "index out\x1b[2J".into() })));
    let status = stage.status();
    assert!(status.contains("render thread 1 failed: index out\u{fffd}[2J"), "{status}");
    assert_eq!(stage.buffer()[(20, 5)].fg, colour);
    // And keys go on working.
    stage.keys("h");
    assert!(stage.compile());
    assert_eq!(stage.app.activity(), Activity::Rendering);
}

#[test]
fn without_a_terminal_the_program_lives_until_the_picture_is_saved() {
    let mut stage = Stage::started((80, 24));
    stage.keys(" ");
    stage.effects.clear();
    stage.tell(Event::HungUp);
    assert!(matches!(stage.effects[..], [Effect::Detach, Effect::Pause(false)]));
    stage.tile(|_, _| [0.5; 3]);
    stage.tell(Event::Render(RenderEvent::Finished));
    assert_eq!(stage.app.exit(), None);
    stage.tell(Event::Saved(Ok(100)));
    assert_eq!(stage.app.exit(), Some(&Exit::Signal(1)));

    let mut done = Stage::finished((80, 24));
    done.tell(Event::HungUp);
    assert_eq!(done.app.exit(), Some(&Exit::Signal(1)));

    // A disk that is gone does not keep it for ever.
    let mut stuck = Stage::started((80, 24));
    stuck.tell(Event::HungUp);
    stuck.tile(|_, _| [0.5; 3]);
    stuck.tell(Event::Render(RenderEvent::Finished));
    let by = stuck.app.leaves_by().expect("there is an end");
    stuck.app.lose_patience(by - Duration::from_millis(1));
    assert_eq!(stuck.app.exit(), None);
    stuck.app.lose_patience(by);
    assert_eq!(stuck.app.exit(), Some(&Exit::Signal(1)));
}

#[test]
fn quitting_is_one_key_and_two_if_something_is_not_saved() {
    for key in [Key::char('q'), Key::ctrl('c')] {
        let mut stage = Stage::started((80, 24));
        stage.tell(Event::Key(key));
        assert_eq!(stage.app.exit(), Some(&Exit::Quit));
        let mut stage = Stage::started((80, 24));
        stage.keys("n");
        stage.tell(Event::Key(key));
        assert_eq!(stage.app.exit(), None);
        assert!(stage.text().contains("changes that are not saved"), "{}", stage.text());
        stage.press("Esc");
        assert!(stage.app.exit().is_none() && stage.app.dialog().is_none());
        stage.tell(Event::Key(key));
        stage.tell(Event::Key(key));
        assert_eq!(stage.app.exit(), Some(&Exit::Quit));
    }
    // Out of any dialog.
    let mut stage = Stage::started((80, 24));
    stage.press(": Ctrl-C");
    assert_eq!(stage.app.exit(), Some(&Exit::Quit));
    // Taken back is as if nothing was done.
    let mut stage = Stage::started((80, 24));
    stage.keys("nuq");
    assert_eq!(stage.app.exit(), Some(&Exit::Quit));
}

#[test]
fn quitting_waits_for_a_save_until_it_is_done_or_two_seconds_are_over_or_it_is_asked_for_again() {
    let saving = || {
        let mut stage = Stage::finished((80, 24));
        stage.keys("sq");
        assert!(stage.app.exit().is_none() && stage.app.is_saving());
        assert!(stage.status().contains("saving balls.png; q leaves at once"), "{}", stage.status());
        stage
    };
    let mut stage = saving();
    stage.tell(Event::Saved(Ok(100)));
    assert_eq!((stage.app.exit(), stage.app.is_saving()), (Some(&Exit::Quit), false));

    for (event, exit) in [(Event::Key(Key::ctrl('c')), Exit::Quit), (Event::Terminated(15), Exit::Signal(15))] {
        let mut stage = saving();
        stage.tell(event);
        assert_eq!((stage.app.exit(), stage.app.is_saving()), (Some(&exit), true));
    }

    let mut stage = saving();
    let by = stage.app.leaves_by().expect("there is a bound");
    assert_eq!(by - stage.now, Duration::from_secs(2));
    stage.app.lose_patience(by - Duration::from_millis(1));
    assert_eq!(stage.app.exit(), None);
    stage.app.lose_patience(by);
    assert_eq!((stage.app.exit(), stage.app.is_saving()), (Some(&Exit::Quit), true));

    // A first signal waits as a first key does.
    let mut stage = Stage::finished((80, 24));
    stage.keys("s");
    stage.tell(Event::Terminated(15));
    assert_eq!(stage.app.exit(), None);
    stage.tell(Event::Saved(Ok(100)));
    assert_eq!(stage.app.exit(), Some(&Exit::Signal(15)));
}

#[test]
fn the_help_screen_lists_every_binding_at_80_by_24() {
    for size in [(80, 24), (200, 60)] {
        let mut stage = Stage::finished(size);
        stage.keys("?");
        let mut text = stage.text();
        for _ in 0..20 {
            stage.press("PageDown");
            text += &stage.text();
        }
        for binding in BINDINGS {
            let keys = Keymap::default().text(binding);
            let line = |text: &str| text.contains(&keys) && text.contains(binding.help);
            assert!(text.lines().any(line), "{keys}: {} at {size:?}\n{text}", binding.help);
        }
        stage.press("Esc");
        assert!(!stage.text().contains(" Keys "));
    }
}

#[test]
fn the_panel_shows_what_is_asked_of_it() {
    for (size, words) in [
        (
            (80, 24),
            "balls|64×36|whitted|4 samples|depth 8|field of view 40.0°|elapsed|left|first picture|camera|shadow|busy",
        ),
        (
            (200, 60),
            "balls|64×36|whitted|depth 8|samples|pass|elapsed|left|first picture|Rays|camera|shadow|reflection|refraction|Threads|busy|Camera|position|looks at",
        ),
    ] {
        let mut stage = Stage::started(size);
        if stage.app.layout().editor.is_some() {
            stage.keys("b");
        }
        stage.tile(|_, _| [0.5; 3]);
        let text = stage.text();
        for word in words.split('|') {
            assert!(text.contains(word), "{word} at {size:?}\n{text}");
        }
        // The instruction set where there is room for it.
        assert!(size.0 < 200 || text.contains(glimt::bvh::Isa::best().name()), "{text}");
    }
}

#[test]
fn every_thread_has_its_busy_and_its_idle_share() {
    for size in [(80, 24), (200, 60)] {
        let mut stage = Stage::started(size);
        // 30 of 40 milliseconds.
        stage.tile(|_, _| [0.5; 3]);
        let text = stage.text();
        for words in ["busy idle", " 75%  25%", "  0% 100%"] {
            assert!(text.contains(words), "{words} at {size:?}\n{text}");
        }
    }
}

#[test]
fn one_sample_is_not_samples() {
    let mut stage = Stage::started((80, 24));
    stage.keys("NN");
    assert!(stage.status().contains(" 1 sample a pixel"), "{}", stage.status());
    assert!(stage.text().contains(" 1 sample  depth"));
}

#[test]
fn numbers_stand_still_between_their_periods() {
    let mut stage = Stage::started((200, 60));
    stage.keys("b");
    stage.tile(|_, _| [0.5; 3]);
    let before = stage.text();
    stage.now += Duration::from_millis(50);
    assert_eq!(stage.text(), before);
    stage.now += Duration::from_millis(200);
    assert_ne!(stage.text(), before);
}

#[test]
fn the_picture_has_its_colours_and_its_aspect() {
    let mut stage = Stage::finished((80, 24));
    let preview = stage.app.layout().preview;
    let buffer = stage.buffer();
    let row = |y: u16| preview.columns().map(move |c| (c.x, y));
    let (red, blue) = (Color::Rgb(255, 0, 0), Color::Rgb(0, 0, 255));
    let painted: Vec<_> = row(8).filter(|p| buffer[*p].symbol() == "▀").collect();
    // 16:9 of square half cells.
    let rows = preview.rows().filter(|r| buffer[(40, r.y)].symbol() == "▀").count();
    assert!((painted.len() as f64 / (2 * rows) as f64 - 16.0 / 9.0).abs() < 0.1, "{} by {rows}", painted.len());
    // Centred, one half each.
    let (first, last) = (painted[0].0, painted[painted.len() - 1].0);
    assert!(first.abs_diff(preview.width - 1 - last) <= 1);
    for (i, position) in painted.iter().enumerate() {
        let expected = if 2 * i + 1 < painted.len() { red } else { blue };
        if 2 * i + 1 != painted.len() {
            assert_eq!((buffer[*position].fg, buffer[*position].bg), (expected, expected), "column {i}");
        }
    }
}

#[test]
fn without_colours_the_picture_is_made_of_characters() {
    let mut stage = Stage::new((80, 24), ColorMode::None);
    assert!(stage.compile());
    stage.tile(|x, _| [x as f32 / WIDTH as f32; 3]);
    let buffer = stage.buffer();
    for cell in buffer.content() {
        assert_eq!((cell.fg, cell.bg), (Color::Reset, Color::Reset));
        assert_ne!(cell.symbol(), "▀");
    }
    let row: String = (0..80).map(|x| buffer[(x, 8)].symbol()).collect();
    let row = row.trim();
    assert!(" .'`^\",:;Il!i><~+".contains(&row[..1]) && row.ends_with('$'), "{row}");
}

#[test]
fn a_real_render_ends_with_the_film_that_the_workers_made() {
    let mut stage = Stage::started((80, 24));
    let Some(Effect::Start(scene)) = stage.effects.pop() else { panic!("nothing to start") };
    let mut film = Film::new(WIDTH, HEIGHT);
    let settings = Settings { threads: NonZeroUsize::MIN.saturating_add(1), tile_size: 8 };
    for event in start(scene, settings).events() {
        if let RenderEvent::TileFinished { tile, .. } = &event {
            film.write(tile);
        }
        stage.tell(Event::Render(event));
    }
    assert_eq!(stage.app.film().hash(), film.hash());
    assert!(matches!(stage.effects[..], [Effect::Save(100)]));
}

#[test]
fn with_256_colours_the_picture_is_of_the_palette() {
    let mut stage = Stage::new((80, 24), ColorMode::Indexed);
    assert!(stage.compile());
    stage.tile(|_, _| [1.0, 0.0, 0.0]);
    assert_eq!(stage.buffer()[(40, 8)].fg, Color::Indexed(196));
}

#[test]
fn the_readme_has_the_table_of_keys() {
    let readme = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap_or_default();
    let table = Keymap::default().markdown();
    assert!(readme.contains(&table), "put this into README.md:\n{table}");
}
