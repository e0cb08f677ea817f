//! What thousands of edits leave behind, in a process of its own: other tests would be counted too.

#![cfg(target_os = "linux")]

#[path = "tui/stage.rs"]
#[allow(dead_code, reason = "the tests of the interface use the rest")]
mod stage;

use glimt::render::{Pass, RenderEvent, Rooms, Settings, start_in};
use glimt::tui::event::{Effect, Event};
use stage::{Stage, scene};

/// Bytes of this process that are in memory.
fn resident() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096 * statm.split(' ').nth(1).unwrap().parse::<u64>().unwrap()
}

/// Every edit is a step of its own, is compiled, and its render is begun and broken off.
#[test]
fn ten_thousand_edits_leave_little_more_than_their_history() {
    // In one arena: the C library makes up to eight a processor as threads come and go, each with some free megabytes.
    if std::env::var_os("MALLOC_ARENA_MAX").is_none() {
        let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
        let alone = alone.args(["--nocapture", "--exact", "ten_thousand_edits_leave_little_more_than_their_history"]);
        assert!(alone.env("MALLOC_ARENA_MAX", "1").status().unwrap().success());
        return;
    }
    let mut stage = Stage::with(scene(), (80, 24));
    stage.press("/ s p h e r e Enter Esc");
    let rooms = Rooms::default();
    let (first, mut after_a_thousand, mut at_the_end) = (Pass::sequence(1)[0], 0, u64::MAX);
    for number in 0..10_000 {
        // Along x and back: steps of undo, since the keys come slowly.
        stage.now += std::time::Duration::from_secs(1);
        stage.press(if number % 2 == 0 { "g Right Enter" } else { "g Left Enter" });
        assert!(stage.compile());
        for effect in std::mem::take(&mut stage.effects) {
            if let Effect::Start(scene) = effect {
                let threads = std::num::NonZeroUsize::MIN;
                // In the rooms of the renders before, as the program does.
                let render = start_in(scene, Settings { threads, ..Settings::default() }, &rooms);
                // Until the first picture is whole, which the next edit waits for.
                for event in render.events() {
                    let is_whole = matches!(&event, RenderEvent::TileStarted { pass, .. } if *pass != first);
                    stage.tell(Event::Render(event));
                    if is_whole {
                        break;
                    }
                }
            }
        }
        if number % 100 == 0 {
            stage.buffer();
        }
        // Threads that are going home hold some megabytes, now more of them and now less.
        match number {
            500..1000 => after_a_thousand = after_a_thousand.max(resident()),
            9500.. => at_the_end = at_the_end.min(resident()),
            _ => {}
        }
    }
    let grown = at_the_end.saturating_sub(after_a_thousand);
    // A step of undo is what has changed of a description, half a kilobyte here; a film or a compiled scene that stayed
    // would be far more.
    println!("{grown} bytes more after 9000 edits");
    assert!(grown < 9000 * 1024, "{grown} bytes more after 9000 edits");
    for _ in 0..10_000 {
        stage.keys("u");
    }
    assert_eq!(*stage.desc(), scene());
}
