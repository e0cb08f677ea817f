//! The mouse, and the cursor that picks with keys.

use super::editor::three;
use super::stage::Stage;
use glimt::description::Target;
use glimt::description::edit::delete;
use glimt::tui::app::Focus;
use glimt::tui::decode::{Mouse, MouseAction};
use glimt::tui::event::Event;
use ratatui::style::Color;

/// A cell of the picture for which the ray of its upper pixel meets this.
fn cell_of(stage: &Stage, wanted: Target) -> (u16, u16) {
    let scene = glimt::scene::compile(stage.desc(), None).unwrap();
    let area = stage.app.layout().preview;
    let shows = |x: u16, y: u16| {
        let (column, row) = stage.app.preview().film_pixel(x.into(), 2 * usize::from(y))?;
        Some(scene.pick(column, row).map_or(Target::World, |pick| Target::Object(pick.object)))
    };
    let cells = (0..area.height).flat_map(|y| (0..area.width).map(move |x| (x, y)));
    let (x, y) = cells.clone().find(|(x, y)| shows(*x, *y) == Some(wanted)).expect("it is in view");
    (area.x + x, area.y + y)
}

#[test]
fn a_click_selects_what_the_ray_of_its_pixel_meets() {
    for size in [(80, 24), (200, 60)] {
        let mut stage = Stage::with(three(), size);
        for (index, name) in ["left", "right", "floor"].into_iter().enumerate() {
            let (x, y) = cell_of(&stage, Target::Object(index));
            stage.click(x, y, false);
            assert_eq!(stage.selected(), [name]);
            assert!(stage.status().contains(name), "{}", stage.status());
        }
        let (x, y) = cell_of(&stage, Target::World);
        stage.click(x, y, false);
        assert_eq!(stage.selected(), ["world"]);
    }
}

#[test]
fn a_click_with_a_modifier_adds_and_takes_away() {
    let mut stage = Stage::with(three(), (120, 40));
    let [left, right] = [0, 1].map(|index| cell_of(&stage, Target::Object(index)));
    stage.click(left.0, left.1, false);
    stage.click(right.0, right.1, true);
    assert_eq!(stage.selected(), ["left", "right"]);
    stage.click(left.0, left.1, true);
    assert_eq!(stage.selected(), ["right"]);
}

#[test]
fn clicks_reach_tree_and_properties_and_wheels_turn_what_they_are_over() {
    let mut stage = Stage::with(three(), (200, 60));
    let find = |stage: &mut Stage, word: &str| {
        let text = stage.text();
        let row = text.lines().position(|line| line.contains(word)).unwrap_or_else(|| panic!("{word}\n{text}"));
        (stage.app.layout().editor.unwrap().x + 5, row as u16)
    };
    let (x, y) = find(&mut stage, "  right ");
    stage.click(x, y, false);
    assert_eq!((stage.selected(), stage.app.focus()), (vec!["right".to_owned()], Focus::Tree));
    let (x, y) = find(&mut stage, "  radius ");
    stage.click(x, y, false);
    assert_eq!(stage.app.focus(), Focus::Properties);
    assert!(stage.text().contains("▸ radius"), "{}", stage.text());
    let turn = |stage: &mut Stage, column, row, action| {
        stage.tell(Event::Mouse(Mouse { column, row, action, held: false }));
    };
    turn(&mut stage, x, y, MouseAction::WheelDown);
    assert!(!stage.text().contains("▸ radius"));
    let distance = |stage: &Stage| stage.desc().camera.position.distance(stage.desc().camera.look_at);
    let before = distance(&stage);
    turn(&mut stage, 20, 10, MouseAction::WheelUp);
    assert!(distance(&stage) < before);
}

#[test]
fn a_cursor_moved_by_keys_selects_the_object_under_it() {
    let mut stage = Stage::with(three(), (120, 40));
    stage.press("Enter");
    let middle = stage.app.cursor().expect("there is a cursor");
    let (x, y) = cell_of(&stage, Target::Object(1));
    let area = stage.app.layout().preview;
    let wanted = (usize::from(x - area.x), 2 * usize::from(y - area.y));
    let mut far = 0;
    while stage.app.cursor().unwrap() != wanted {
        let now = stage.app.cursor().unwrap();
        let (right, below) = (wanted.0 as isize - now.0 as isize, wanted.1 as isize - now.1 as isize);
        let key = match (right, below) {
            (0, 8..) => "Shift-Down",
            (0, ..=-8) => "Shift-Up",
            (0, 1..) => "Down",
            (0, _) => "Up",
            (8.., _) => "Shift-Right",
            (..=-8, _) => "Shift-Left",
            (1.., _) => "Right",
            _ => "Left",
        };
        far += usize::from(key.starts_with("Shift"));
        stage.press(key);
    }
    assert!(middle != wanted && far > 0);
    // What is under it is named, and the pixel is marked.
    assert!(stage.status().contains("right"), "{}", stage.status());
    assert_eq!(stage.buffer()[(x, y)].bg, Color::Rgb(255, 0, 200));
    stage.press("Enter");
    assert_eq!(stage.selected(), ["right"]);
    let x0 = stage.app.cursor().unwrap();
    stage.press("Esc");
    assert!(stage.app.cursor().is_none() && x0 == wanted);
}

#[test]
fn nothing_is_picked_beside_the_picture_or_of_what_is_there_no_more() {
    let mut stage = Stage::with(three(), (80, 24));
    let area = stage.app.layout().preview;
    let beside = (0..area.width).find(|x| stage.app.preview().film_pixel((*x).into(), 8).is_none());
    stage.click(beside.expect("a wide screen has margins"), 4, false);
    assert_eq!(stage.selected(), ["camera"]);
    let (x, y) = cell_of(&stage, Target::Object(2));
    stage.keys("/floor");
    stage.press("Enter Esc x");
    // The compiled scene still has the floor.
    stage.click(x, y, false);
    let mut without = three();
    delete(&mut without, &[Target::Object(2)]).unwrap();
    assert_eq!(*stage.desc(), without);
    assert_ne!(stage.selected(), ["floor"]);
}

#[test]
fn the_cursor_stays_on_the_picture_when_the_screen_changes() {
    let mut stage = Stage::with(three(), (200, 60));
    stage.press("Enter");
    for _ in 0..30 {
        stage.press("Shift-Right Shift-Down");
    }
    for size in [(40, 12), (80, 24), (3, 2), (1, 1), (200, 60)] {
        stage.tell(Event::Resize(size.0, size.1));
        if let Some((x, y)) = stage.app.cursor() {
            assert!(stage.app.preview().film_pixel(x, y).is_some());
        }
        stage.text();
    }
}
