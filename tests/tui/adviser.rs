//! The adviser's dialog, how long edits take, and what thousands of them leave behind.

use super::editor::three;
use super::stage::Stage;
use glimt::advice::{Advice, Change, CoarseModel};
use glimt::description::ShapeDesc;
use glimt::render::RenderEvent;
use glimt::scene::compile;
use glimt::tui::app::App;
use glimt::tui::color::ColorMode;
use glimt::tui::event::{Effect, Event};
use std::path::Path;

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
fn a_coarser_model_is_written_first_and_taken_when_it_is_there() {
    let mut desc = three();
    desc.objects[0].shape = ShapeDesc::Mesh { file: "/nowhere/egg.obj".into(), crease: 0.0 };
    let model = CoarseModel { file: "/nowhere/egg-coarse.obj".into(), text: "v 0 0 0\n".into() };
    let change = Change::Coarsen(0, model.into());
    for result in [Ok(()), Err("the disk is full".to_owned())] {
        // It need not compile here.
        let app = App::new(desc.clone(), "x", Path::new("x.png"), 2, ColorMode::Truecolor, (120, 40));
        let mut stage = Stage { app, now: std::time::Instant::now(), effects: Vec::new() };
        let lent = compile(&three(), None).unwrap();
        assert!(stage.app.begin_compile(stage.now).is_some());
        stage.tell(Event::Compiled(Ok(lent.into())));
        stage.effects.clear();
        stage.keys("A");
        let Some(Effect::Advise { desc: asked, .. }) = stage.effects.pop() else { panic!("nobody is asked") };
        stage.tell(Event::Advised { desc: asked, found: Ok(vec![advice(change.clone())]) });
        stage.press("Enter");
        assert_eq!(*stage.desc(), desc, "not before it is written");
        let Some(Effect::WriteModel { change, text }) = stage.effects.pop() else { panic!("nothing is written") };
        assert_eq!(text, "write egg-coarse.obj for left");
        stage.tell(Event::ModelWritten { change, text, result: result.clone() });
        stage.press("Esc");
        let mut coarse = desc.clone();
        if result.is_ok() {
            coarse.objects[0].shape = ShapeDesc::Mesh { file: "/nowhere/egg-coarse.obj".into(), crease: 0.0 };
        } else {
            assert!(stage.status().contains("the disk is full"), "{}", stage.status());
        }
        assert_eq!(*stage.desc(), coarse);
        stage.keys("u");
        assert_eq!(*stage.desc(), desc);
    }
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
