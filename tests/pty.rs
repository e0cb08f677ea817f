//! The real program in a pseudo-terminal, whose far end is a small terminal emulator that answers as terminals do.
#![cfg(unix)]

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, native_pty_system};
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

/// How long the machine may take for anything before a test fails.
const PATIENCE: Duration = Duration::from_secs(60);

/// The far end: what a person at the keyboard sees.
struct FarEnd {
    parser: vt100::Parser,
    bytes: usize,
    writer: Option<Box<dyn Write + Send>>,
}

/// What kind of terminal is at the far end.
#[derive(Clone, Copy)]
struct Kind {
    columns: u16,
    rows: u16,
    /// Whether it tells the cursor's position when asked.
    answers: bool,
    /// What the link carries.
    bytes_per_second: Option<u32>,
}

const USUAL: Kind = Kind { columns: 80, rows: 24, answers: true, bytes_per_second: None };

struct Session {
    child: Box<dyn Child + Send + Sync>,
    master: Option<Box<dyn MasterPty + Send>>,
    far: Arc<Mutex<FarEnd>>,
    directory: PathBuf,
    modes_before: String,
}

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

impl Session {
    /// Runs `glimt ball.toml` in a directory of its own.
    fn start(test: &str, kind: Kind, scene: &str) -> Self {
        Self::start_with(test, kind, scene, |program| {
            let mut command = CommandBuilder::new(program);
            command.arg("ball.toml");
            command
        })
    }

    fn start_with(test: &str, kind: Kind, scene: &str, command: impl Fn(&str) -> CommandBuilder) -> Self {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("pty-{test}"));
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).unwrap();
        fs::write(directory.join("ball.toml"), scene).unwrap();
        let pair = native_pty_system().openpty(size(kind.columns, kind.rows)).unwrap();
        let mut command = command(env!("CARGO_BIN_EXE_glimt"));
        command.cwd(&directory);
        for name in ["NO_COLOR", "TMUX", "WT_SESSION"] {
            command.env_remove(name);
        }
        command.env("TERM", "xterm-256color");
        command.env("COLORTERM", "truecolor");
        let modes_before = modes(&*pair.master);
        let mut reader = pair.master.try_clone_reader().unwrap();
        let [rows, columns] = [kind.rows, kind.columns].map(|n| NonZeroU16::new(n).unwrap());
        let far = Arc::new(Mutex::new(FarEnd {
            parser: vt100::Parser::new(rows, columns, 0),
            bytes: 0,
            writer: Some(pair.master.take_writer().unwrap()),
        }));
        let screen = far.clone();
        thread::spawn(move || {
            // A slow link takes little at a time.
            let mut buffer = vec![0; kind.bytes_per_second.map_or(1 << 16, |rate| rate as usize / 50)];
            let mut last = Vec::new();
            while let Ok(count @ 1..) = reader.read(&mut buffer) {
                if let Some(rate) = kind.bytes_per_second {
                    thread::sleep(Duration::from_secs_f64(count as f64 / f64::from(rate)));
                }
                let mut far = screen.lock().unwrap();
                for byte in &buffer[..count] {
                    far.parser.process(&[*byte]);
                    far.bytes += 1;
                    last.push(*byte);
                    if last.ends_with(b"\x1b[6n") && kind.answers {
                        let (row, column) = far.parser.screen().cursor_position();
                        let answer = format!("\x1b[{};{}R", row + 1, column + 1);
                        far.send(answer.as_bytes());
                    }
                    if last.len() > 8 {
                        last.remove(0);
                    }
                }
            }
        });
        let child = pair.slave.spawn_command(command).unwrap();
        Self { child, master: Some(pair.master), far, directory, modes_before }
    }

    fn far(&self) -> MutexGuard<'_, FarEnd> {
        self.far.lock().unwrap()
    }

    fn send(&self, keys: &str) {
        self.far().send(keys.as_bytes());
    }

    fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.child.process_id().unwrap() as i32).unwrap();
        kill_process(pid, signal).unwrap();
    }

    fn resize(&self, columns: u16, rows: u16) {
        let [high, wide] = [rows, columns].map(|n| NonZeroU16::new(n).unwrap());
        self.far().parser.screen_mut().set_size(high, wide);
        self.master.as_ref().unwrap().resize(size(columns, rows)).unwrap();
    }

    /// Waits until the screen is as wanted.
    fn wait(&self, what: &str, wanted: impl Fn(&vt100::Screen) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !wanted(self.far().parser.screen()) {
            let contents = self.far().parser.screen().contents();
            assert!(Instant::now() < deadline, "no {what}; the screen is\n{contents}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn wait_for_text(&self, text: &str) {
        self.wait(text, |screen| screen.contents().contains(text));
    }

    /// Waits for the program's end; its exit code.
    fn end(&mut self) -> u32 {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.exit_code();
            }
            assert!(Instant::now() < deadline, "still running; {}", self.far().parser.screen().contents());
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// The terminal is as it was before the program.
    fn assert_restored(&self) {
        self.wait("return from the alternate screen", |screen| {
            !screen.alternate_screen() && !screen.hide_cursor() && !screen.bracketed_paste()
        });
        assert_eq!(modes(&**self.master.as_ref().unwrap()), self.modes_before);
    }

    /// Names of all files but the scene.
    fn files(&self) -> Vec<String> {
        let names = fs::read_dir(&self.directory).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name != "ball.toml").collect()
    }

    fn assert_picture(&self, side: u32) {
        let picture = image::open(self.directory.join("ball.png")).unwrap();
        assert_eq!((picture.width(), picture.height()), (side, side));
        let [r, g, b] = picture.to_rgb8().get_pixel(1, 1).0;
        assert_eq!([r, g, b], [0x40, 0x80, 0xc0]);
        assert_eq!(self.files(), ["ball.png"]);
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let _ = self.child.kill();
    }
}

impl FarEnd {
    fn send(&mut self, bytes: &[u8]) {
        if let Some(writer) = &mut self.writer {
            // The program may have ended.
            let _ = writer.write_all(bytes).and_then(|()| writer.flush());
        }
    }
}

fn size(columns: u16, rows: u16) -> PtySize {
    PtySize { rows, cols: columns, pixel_width: 0, pixel_height: 0 }
}

/// Raw, cooked and so on.
fn modes(master: &dyn MasterPty) -> String {
    format!("{:?}", master.get_termios().unwrap())
}

fn shows_picture(screen: &vt100::Screen) -> bool {
    let (rows, columns) = screen.size();
    (0..rows.get())
        .flat_map(|y| (0..columns.get()).map(move |x| (y, x)))
        .filter_map(|(y, x)| screen.cell(y, x))
        .any(|cell| [cell.fgcolor(), cell.bgcolor()].contains(&vt100::Color::Rgb(0x40, 0x80, 0xc0)))
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
