//! Every size of the screen, and keys in no order.

use super::editor::three;
use super::stage::Stage;
use glimt::description::{SceneDesc, Source, parse, save};
use glimt::math::SplitMix64;
use glimt::render::RenderEvent;
use glimt::tui::bindings::BINDINGS;
use glimt::tui::color::ColorMode;
use glimt::tui::decode::{Mouse, MouseAction};
use glimt::tui::dialog::files::{Entry, Thumbnail};
use glimt::tui::event::{Effect, Event};
use glimt::tui::key::{Code, Key};
use std::path::Path;

/// Keys that open something, each to be closed by Escape.
const OPENERS: [&str; 15] =
    ["?", ":", "a", "a f", "C", "T", "e", "W", "V", "/ f", "Enter", "Tab Tab Enter", "g x 1", "n q", "A"];

#[test]
fn every_screen_from_1_by_1_to_300_by_100_can_be_drawn_with_anything_open() {
    let widths = (1..=12).chain([19, 20, 29, 30, 31, 38, 40, 55, 56, 57, 74, 79, 80, 100, 140, 200, 300]);
    for columns in widths {
        for rows in (1..=12).chain([16, 17, 23, 24, 25, 59, 60, 100]) {
            let mut stage = Stage::with(three(), (columns, rows));
            stage.tile(|_, _| [0.5; 3]);
            stage.text();
            // An object is selected, so that its dialogs open.
            stage.press("/ l e f t Enter Esc");
            stage.text();
            for keys in OPENERS {
                stage.press(keys);
                stage.tell(Event::Listed {
                    directory: ".".into(),
                    entries: Ok(vec![Entry { is_file: true, name: "a.png".into() }]),
                });
                stage.press("Down");
                let picture = Ok(Thumbnail::new((3, 5), &[[9; 3]; 15]));
                stage.tell(Event::Looked { file: "./a.png".into(), picture });
                stage.text();
                stage.press("Esc Esc Esc");
            }
            stage.keys("++");
            stage.text();
            stage.tell(Event::Render(RenderEvent::Finished));
            stage.tell(Event::Resize(rows, columns));
            stage.text();
        }
    }
}

#[test]
fn without_colours_nothing_is_coloured_whatever_is_open() {
    for keys in OPENERS {
        let app = glimt::tui::app::App::new(three(), "x", Path::new("x.png"), 2, ColorMode::None, (120, 40));
        let mut stage = Stage { app, now: std::time::Instant::now(), effects: Vec::new() };
        assert!(stage.compile());
        stage.tile(|_, _| [0.5; 3]);
        stage.press("/ l e f t Enter Esc");
        stage.press(keys);
        for cell in stage.buffer().content() {
            let none = ratatui::style::Color::Reset;
            assert_eq!((cell.fg, cell.bg), (none, none), "{keys}");
        }
    }
}

/// A key that is bound to something, or typed, or neither.
fn any_key(random: &mut SplitMix64) -> Key {
    let mut pick = |n: usize| (random.next_u64() % n as u64) as usize;
    let bound: Vec<Key> = BINDINGS.iter().flat_map(|b| b.actions).flat_map(|a| a.keys).copied().collect();
    match pick(8) {
        0 => Key::char(b"0123456789.+-*/#abcdef "[pick(23)] as char),
        1 => Key::plain([Code::Enter, Code::Escape, Code::Tab, Code::Backspace, Code::Delete, Code::Other][pick(6)]),
        2 => Key::plain([Code::Up, Code::Down, Code::Left, Code::Right, Code::Home, Code::End][pick(6)]),
        _ => bound[pick(bound.len())],
    }
}

fn answer(stage: &mut Stage) {
    for effect in std::mem::take(&mut stage.effects) {
        match effect {
            Effect::List(directory, _) => {
                let names = [("a.png", true), ("b.obj", true), ("d", false)];
                let entries = names.iter().map(|(name, is_file)| Entry { is_file: *is_file, name: name.into() });
                stage.tell(Event::Listed { directory, entries: Ok(entries.collect()) });
            }
            Effect::Look(file) => {
                stage.tell(Event::Looked { file, picture: Ok(Thumbnail::new((2, 2), &[[1; 3]; 4])) });
            }
            Effect::Measure(file) => stage.tell(Event::Measured { file, bounds: Err("no".into()) }),
            Effect::WriteScene(written) => stage.tell(Event::SceneWritten { written, result: Ok(()) }),
            _ => {}
        }
    }
}

/// The description says what its saved text says.
fn assert_valid(desc: &SceneDesc, context: &str) {
    let file = Path::new("/tmp/storm/scene.toml");
    let text = save(Source { text: "", desc: &SceneDesc::default(), file: Path::new("") }, desc, file);
    let text = text.unwrap_or_else(|error| panic!("{context}: {error}"));
    match parse(&text, file) {
        Ok(parsed) => assert_eq!(parsed, *desc, "{context}\n{text}"),
        // The files that are picked here do not exist.
        Err(mistakes) if mistakes.iter().all(|mistake| mistake.render(false).contains("cannot read")) => {}
        Err(mistakes) => panic!("{context}: {}\n{text}", mistakes[0].render(false)),
    }
}

#[test]
fn any_keys_in_any_order_keep_the_description_valid_and_can_be_undone() {
    for seed in 0..40 {
        let mut random = SplitMix64(seed);
        let size = [(80, 24), (200, 60), (30, 10), (57, 9)][seed as usize % 4];
        let mut stage = Stage::with(three(), size);
        stage.tile(|_, _| [0.5; 3]);
        let mut keys = String::new();
        for step in 0..400 {
            let key = any_key(&mut random);
            keys += &format!("{key} ");
            if random.next_u64().is_multiple_of(40) {
                let at = random.next_u64();
                let (column, row) = ((at % u64::from(size.0)) as u16, (at / 1000 % u64::from(size.1)) as u16);
                let action = [MouseAction::Press, MouseAction::WheelUp, MouseAction::WheelDown][at as usize % 3];
                stage.tell(Event::Mouse(Mouse { column, row, action, held: at & 8 == 0 }));
            }
            stage.tell(Event::Key(key));
            answer(&mut stage);
            if step % 16 == 0 {
                stage.text();
                stage.compile();
            }
            if step % 40 == 0 {
                assert_valid(stage.desc(), &format!("seed {seed}: {keys}"));
            }
        }
        // Out of whatever is open, and back to the beginning.
        stage.press("Esc Esc Esc Esc");
        for _ in 0..3000 {
            stage.keys("u");
        }
        assert_eq!(*stage.desc(), three(), "seed {seed}: {keys}");
    }
}
