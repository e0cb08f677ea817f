//! The real program in a pseudo-terminal, whose far end is a small terminal emulator that answers as terminals do.
#![cfg(unix)]

mod editor;
mod session;

use portable_pty::CommandBuilder;
use rustix::process::Signal;
use session::{Kind, Session, USUAL, shows_picture};
use std::fs;

/// A ball, `side` pixels wide and high.
fn scene(side: u32, samples: u32) -> String {
    format!(
        "[film]\nwidth = {side}\nheight = {side}\n[render]\nsamples = {samples}\n\
         [world]\nbackground = \"#4080c0\"\n[[light]]\nposition = [4, 6, 3]\n\
         [[material]]\nname = \"red\"\ncolor = \"tomato\"\n[[object]]\nshape = \"sphere\"\nradius = 1.2\nmaterial = \"red\"\n"
    )
}

/// Seconds of work for any machine, and a noisy picture to the end.
fn endless() -> String {
    scene(1200, 1 << 18)
}

#[test]
fn from_start_to_saved_picture_with_keys_and_resize_to_a_restored_terminal() {
    let mut session = Session::start("whole", USUAL, &scene(64, 4));
    session.wait_for_text("saved ball.png");
    session.wait("picture", shows_picture);
    assert!(session.far().parser.screen().alternate_screen());
    session.assert_picture(64);

    session.send("?");
    session.wait_for_text("show or hide the panel");
    // The Escape key is told from a sequence by time.
    session.send("\x1b");
    session.wait("end of the help screen", |screen| !screen.contents().contains("show or hide the panel"));

    fs::remove_file(session.directory.join("ball.png")).unwrap();
    session.send("\x1b[Cn");
    session.wait_for_text("8 samples  depth");
    session.wait_for_text("saved ball.png");
    session.assert_picture(64);
    // Back to what the file says, so that leaving asks nothing.
    session.send("uu");
    session.wait_for_text("4 samples  depth");

    for (columns, rows) in [(200, 60), (20, 5), (100, 30)] {
        session.resize(columns, rows);
        session.wait("status line in the last row", |screen| {
            let last = screen.rows(0, columns).nth(usize::from(rows) - 1);
            last.is_some_and(|row| row.contains("finished"))
        });
        session.wait("picture", shows_picture);
    }

    session.send("q");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    session.wait_for_text("saved ball.png");
    // No answer of the terminal is left for the shell.
    assert!(!session.far().parser.screen().contents().contains("^["));
}

#[test]
fn a_scene_is_edited_by_keys_undone_saved_and_is_what_it_was_but_for_the_edits() {
    let scene = format!("# my scene\n{}  # round\n", scene(64, 2).trim_end());
    let mut session = Session::start("edit", Kind { columns: 120, rows: 40, ..USUAL }, &scene);
    session.wait_for_text("saved ball.png");
    let file = session.directory.join("ball.toml");

    // A cuboid, moved along x and a little up.
    session.send("ab");
    session.wait_for_text("size x");
    session.send("gx1.5\r");
    session.wait_for_text("1.5 units");
    session.send("gy\x1b[A\x1b[A\r");
    // The colour of its material by code, live.
    session.send("C");
    session.wait_for_text("saturation");
    session.send("#00ff00\r");
    session.wait_for_text("#00ff00");
    // A light, and away with it.
    session.send("al");
    session.wait_for_text("lamp");
    session.send("u");
    session.wait("end of the light", |screen| !screen.contents().contains("lamp"));
    session.wait_for_text("● not saved");
    session.send("w");
    session.wait("end of the mark", |screen| !screen.contents().contains("● not saved"));

    let saved = fs::read_to_string(&file).unwrap();
    // Byte by byte what was there, with what was added behind it.
    assert!(saved.contains("name = \"red\"\ncolor = \"tomato\"\n") && saved.contains("# my scene"), "{saved}");
    assert!(saved.contains("material = \"red\"  # round\n"), "{saved}");
    let before = glimt::description::parse(&scene, &file).unwrap();
    let after = glimt::description::parse(&saved, &file).unwrap();
    assert_eq!(
        (after.film, after.camera, after.world, after.render),
        (before.film, before.camera, before.world, before.render)
    );
    assert_eq!((&after.lights, &after.objects[..1]), (&before.lights, &before.objects[..]));
    assert_eq!((after.materials.len(), after.objects.len()), (before.materials.len() + 1, before.objects.len() + 1));
    assert_eq!(after.materials[1].color, glimt::description::parse_color("lime").unwrap());
    let cuboid = &after.objects[1];
    assert_eq!(cuboid.name, "cuboid");
    assert_eq!(cuboid.translate.x, 1.5);
    assert!(cuboid.translate.y > 0.0 && cuboid.translate.z == 0.0, "{}", cuboid.translate);

    // A click on the ball, which stands in the middle, selects it; its row in the tree is told by the properties.
    session.send("\x1b[<0;42;17M\x1b[<0;42;17m");
    session.wait_for_text("▸ object 1");
    // What is not saved is asked about.
    session.send("vq");
    session.wait_for_text("changes that are not saved");
    session.send("s");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    let hidden = glimt::description::parse(&fs::read_to_string(&file).unwrap(), &file).unwrap();
    assert_eq!(hidden.objects.iter().filter(|object| !object.visible).count(), 1);
}

#[test]
fn a_signal_restores_the_terminal_and_leaves_no_half_of_a_picture() {
    for (signal, code) in [(Signal::TERM, 143), (Signal::INT, 130), (Signal::QUIT, 131)] {
        let mut session = Session::start(&format!("signal-{code}"), USUAL, &endless());
        session.wait("picture", shows_picture);
        session.signal(signal);
        assert_eq!(session.end(), code);
        session.assert_restored();
        session.wait_for_text("nothing was saved");
        assert!(session.files().is_empty());
    }
}

#[test]
fn control_c_and_a_save_on_the_way() {
    let mut session = Session::start("control-c", USUAL, &endless());
    session.wait("picture", shows_picture);
    session.send("s");
    session.wait_for_text("saved ball.png at");
    session.send("\x03");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    session.assert_picture(1200);
}

#[test]
fn a_picture_that_cannot_be_written_does_not_keep_the_program_from_leaving() {
    let mut session = Session::start("fifo", USUAL, &endless());
    session.wait("picture", shows_picture);
    // A pipe without a reader: whoever opens it waits for ever.
    let made = std::process::Command::new("mkfifo").arg(session.directory.join("ball.png")).status();
    assert!(made.unwrap().success());
    session.send("s");
    // Refused, or begun and never to end.
    session.wait("save", |screen| ["saving", "cannot save"].iter().any(|word| screen.contents().contains(word)));
    session.send("q");
    assert_eq!(session.end(), 1);
    session.assert_restored();
    session.wait("what became of the picture", |screen| {
        let text = screen.contents();
        text.contains("left before the picture was saved as ball.png") || text.contains("cannot save ball.png")
    });
}

#[test]
fn a_broken_connection_does_not_stop_the_render() {
    let mut session = Session::start("hang-up", USUAL, &scene(400, 64));
    session.wait("picture", shows_picture);
    session.far().writer = None;
    session.master = None;
    // The reader of the far end still holds it open; the signal is what the system would send.
    session.signal(Signal::HUP);
    assert_eq!(session.end(), 129);
    session.assert_picture(400);
}

#[test]
fn control_z_gives_the_terminal_to_the_shell_and_fg_takes_it_back() {
    let mut session = Session::start_with("stop", USUAL, &endless(), |program| {
        let mut command = CommandBuilder::new("sh");
        // A shell with jobs, as a person has.
        command.args(["-c", "set -m; \"$0\" ball.toml; echo in the shell; read line; echo got $line; fg", program]);
        command
    });
    session.wait("picture", shows_picture);
    session.send("\x1a");
    session.wait("shell", |screen| !screen.alternate_screen() && screen.contents().contains("in the shell"));
    session.assert_restored();
    session.send("something\r");
    session.wait("picture", |screen| screen.alternate_screen() && shows_picture(screen));
    session.send("d");
    session.wait_for_text("depth 9");
    session.send("uq");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    session.wait_for_text("got something");
}

#[test]
fn without_a_shell_control_z_is_refused() {
    let mut session = Session::start("no-shell", USUAL, &scene(64, 4));
    session.wait_for_text("saved ball.png");
    session.send("\x1a");
    session.wait_for_text("there is no shell to go to");
    session.send("q");
    assert_eq!(session.end(), 0);
}

#[test]
fn a_terminal_that_does_not_answer_gets_the_whole_screen_too() {
    let mut session = Session::start("mute", Kind { answers: false, columns: 200, rows: 60, ..USUAL }, &scene(300, 4));
    session.wait_for_text("saved ball.png");
    session.wait("picture", shows_picture);
    session.wait("status line", |screen| screen.rows(0, 200).nth(59).is_some_and(|row| row.contains("finished")));
    session.send("q");
    assert_eq!(session.end(), 0);
    session.assert_restored();
}

#[test]
fn a_slow_link_echoes_keys_before_it_carries_the_picture() {
    let slow = Kind { columns: 200, rows: 60, bytes_per_second: Some(30_000), ..USUAL };
    let mut session = Session::start("slow", slow, &endless());
    session.wait("picture", shows_picture);
    let mut between = Vec::new();
    for depth in 9..17 {
        // Each of these keys also changes the whole picture.
        let before = session.far().bytes;
        session.send("hd");
        session.wait_for_text(&format!("depth {depth} "));
        between.push(session.far().bytes - before);
    }
    between.sort_unstable();
    // A screen of pixels is 200 kB; a tenth of a second on this link is 3 kB.
    assert!(between[4] < 12_000, "{between:?} bytes between key and echo");
    session.send("q");
    session.wait_for_text("not saved");
    session.send("q");
    assert_eq!(session.end(), 0);
    session.assert_restored();
}

#[test]
fn when_the_system_refuses_threads_the_terminal_is_restored_and_the_reason_told() {
    let mut session = Session::start_with("threads", USUAL, &scene(64, 4), |program| {
        let mut command = CommandBuilder::new(program);
        command.arg("ball.toml");
        // More than any machine has: no thread gets its stack.
        command.env("RUST_MIN_STACK", (1u64 << 60).to_string());
        command
    });
    assert_eq!(session.end(), 1);
    session.assert_restored();
    session.wait_for_text("cannot start a thread for");
    assert!(!session.far().parser.screen().contents().contains("panicked"));
}

#[test]
fn the_terminal_is_restored_when_the_scene_cannot_be_rendered() {
    let mut session = Session::start(
        "bad",
        USUAL,
        "[[object]]\nshape = \"sphere\"\n[[object]]\nshape = \"mesh\"\nfile = \"no.obj\"\n",
    );
    assert_eq!(session.end(), 2);
    session.assert_restored();
    session.wait_for_text("no.obj");
}
