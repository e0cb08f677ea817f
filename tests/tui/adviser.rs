//! The adviser's dialog, how long edits take, and what thousands of them leave behind.

use super::editor::three;
use super::stage::Stage;
use glimt::advice::{Advice, Change};
use glimt::render::RenderEvent;
use glimt::tui::event::{Effect, Event};

fn advice(change: Change) -> Advice {
    Advice { change, reason: "nothing is seen of it".into(), rays: 0.25, time: 0.2, rmse: 0.0, largest: 0.0 }
}

#[test]
fn advice_is_asked_for_shown_taken_by_one_key_and_undone() {
    let mut stage = Stage::with(three(), (120, 40));
    stage.tile(|_, _| [0.5; 3]);
    stage.effects.clear();
    stage.keys("A");
    assert!(stage.text().contains("measuring"));
    let Some(Effect::Advise { desc, waits, .. }) = stage.effects.pop() else { panic!("nobody is asked") };
    let found = Ok(vec![advice(Change::Depth(0)), advice(Change::HideObjects(vec![1]))]);
    stage.tell(Event::Advised { desc: desc.clone(), found: found.clone() });
    let text = stage.text();
    assert!(text.contains("max_depth = 0: nothing is seen of it") && text.contains("hide right"), "{text}");
    assert!(text.contains("saves 25 % of the rays"), "{text}");
    stage.press("Down Enter Enter Up Enter");
    assert_eq!((stage.desc().objects[1].visible, stage.desc().render.max_depth), (false, 0));
    assert_eq!(waits.strong_count(), 1);
    stage.press("Esc");
    assert_eq!(waits.strong_count(), 0, "nobody waits any more");
    stage.keys("u");
    assert_eq!((stage.desc().objects[1].visible, stage.desc().render.max_depth), (false, three().render.max_depth));
    stage.keys("u");
    assert_eq!(*stage.desc(), three());
    // An answer to a question that was closed.
    stage.tell(Event::Advised { desc, found });
    assert!(stage.app.dialog().is_none());
}

#[test]
fn a_scene_that_needs_all_and_one_that_cannot_be_measured_are_told() {
    for (found, told) in [(Ok(Vec::new()), "it needs all"), (Err("no memory".into()), "no memory")] {
        let mut stage = Stage::with(three(), (100, 30));
        stage.keys("A");
        let Some(Effect::Advise { desc, .. }) = stage.effects.pop() else { panic!("nobody is asked") };
        stage.tell(Event::Advised { desc, found });
        assert!(stage.text().contains(told));
        stage.press("Down Enter Esc");
        assert_eq!(*stage.desc(), three());
    }
}

#[test]
fn the_status_line_tells_how_long_the_last_edit_took() {
    let mut stage = Stage::finished((160, 40));
    assert_eq!(stage.app.latency(), None);
    // The clock of the stage goes on by 40 ms with every event: the key, the compiled scene, the picture.
    stage.press("Left");
    assert!(stage.compile());
    assert!(!stage.app.is_seen());
    stage.text();
    assert_eq!(stage.app.latency(), None, "no part of the new picture is there");
    stage.tile(|_, _| [0.5; 3]);
    stage.text();
    assert!(stage.app.is_seen());
    stage.tell(Event::Render(RenderEvent::Finished));
    assert_eq!(stage.app.latency().unwrap().as_millis(), 80);
    // A pause in the middle is the user's time.
    stage.press("Left p");
    assert!(stage.compile());
    stage.tile(|_, _| [0.5; 3]);
    stage.text();
    assert_eq!(stage.app.latency().unwrap().as_millis(), 80);
}
