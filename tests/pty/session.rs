//! The real program in a pseudo-terminal, and what a person sees and does there.

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
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The far end: what a person at the keyboard sees.
pub struct FarEnd {
    pub parser: vt100::Parser,
    pub bytes: usize,
    pub writer: Option<Box<dyn Write + Send>>,
}

/// What kind of terminal is at the far end.
#[derive(Clone, Copy)]
pub struct Kind {
    pub columns: u16,
    pub rows: u16,
    /// Whether it tells the cursor's position when asked.
    pub answers: bool,
    /// What the link carries.
    pub bytes_per_second: Option<u32>,
}

pub const USUAL: Kind = Kind { columns: 80, rows: 24, answers: true, bytes_per_second: None };

pub struct Session {
    pub child: Box<dyn Child + Send + Sync>,
    pub master: Option<Box<dyn MasterPty + Send>>,
    pub far: Arc<Mutex<FarEnd>>,
    pub directory: PathBuf,
    pub modes_before: String,
}

impl Session {
    /// Runs `glimt ball.toml` in a directory of its own.
    pub fn start(test: &str, kind: Kind, scene: &str) -> Self {
        Self::start_with(test, kind, scene, |program| {
            let mut command = CommandBuilder::new(program);
            command.arg("ball.toml");
            command
        })
    }

    pub fn start_with(test: &str, kind: Kind, scene: &str, command: impl Fn(&str) -> CommandBuilder) -> Self {
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

    pub fn far(&self) -> MutexGuard<'_, FarEnd> {
        self.far.lock().unwrap()
    }

    pub fn send(&self, keys: &str) {
        self.far().send(keys.as_bytes());
    }

    /// Keys by their names, such as `Tab`, `Shift-Left`, `Ctrl-X` or `a`, as a terminal sends them.
    pub fn press(&self, names: &str) {
        let bytes = names.split_whitespace().map(|name| match name.strip_prefix("Shift-").unwrap_or(name) {
            "Enter" => "\r".to_owned(),
            "Space" => " ".to_owned(),
            "Tab" if name.len() > 3 => "\x1b[Z".to_owned(),
            "Tab" => "\t".to_owned(),
            "Backspace" => "\x7f".to_owned(),
            "Delete" => "\x1b[3~".to_owned(),
            "Home" => "\x1b[H".to_owned(),
            "End" => "\x1b[F".to_owned(),
            // With characters after it, Escape itself would be the beginning of a sequence.
            "Escape" => "\x18".to_owned(),
            arrow @ ("Up" | "Down" | "Right" | "Left") => {
                let letter = match arrow {
                    "Up" => 'A',
                    "Down" => 'B',
                    "Right" => 'C',
                    _ => 'D',
                };
                if arrow == name { format!("\x1b[{letter}") } else { format!("\x1b[1;2{letter}") }
            }
            other => other.to_owned(),
        });
        self.send(&bytes.collect::<String>());
    }

    /// A click of the left button on the cell in this column and row, from 0.
    pub fn click(&self, column: u16, row: u16, with_control: bool) {
        let (button, x, y) = (if with_control { 16 } else { 0 }, column + 1, row + 1);
        self.send(&format!("\x1b[<{button};{x};{y}M\x1b[<{button};{x};{y}m"));
    }

    /// Selects the first entry of the tree whose name or kind has this in it; the tree has the keys then.
    pub fn choose(&self, name: &str) {
        self.send(&format!("/{name}"));
        self.wait(name, |screen| screen.contents().contains(&format!("/ {name}")));
        self.press("Enter Escape");
        self.wait("end of the search", |screen| !screen.contents().contains(&format!("/ {name}")));
    }

    /// Gives the keys to the row of the properties with this label. No key is on its way when the next is sent.
    pub fn to_property(&self, label: &str) {
        self.press("Home");
        self.wait("the first row", |screen| {
            let text = screen.contents();
            let mut below = text.lines().skip_while(|row| !row.contains("├──"));
            below.nth(2).is_some_and(|row| row.contains("│ ▸ "))
        });
        let deadline = Instant::now() + PATIENCE;
        loop {
            let here = self.property_here();
            if here.as_deref().is_some_and(|row| row.starts_with(label)) {
                return;
            }
            assert!(Instant::now() < deadline, "no {label}; the screen is\n{}", self.contents());
            self.press("Down");
            self.wait("the next row", |screen| property_here(screen).is_some_and(|now| Some(now) != here));
        }
    }

    fn property_here(&self) -> Option<String> {
        property_here(self.far().parser.screen())
    }

    /// Types a value into the row of the properties with this label, which is shown as `shown` then.
    pub fn enter(&self, label: &str, value: &str, shown: &str) {
        self.to_property(label);
        self.press("Enter");
        self.send(&"\x7f".repeat(40));
        self.send(value);
        self.press("Enter");
        self.wait_for_property(label, shown);
    }

    /// Waits until the row of the properties with this label, which has the keys, shows this.
    pub fn wait_for_property(&self, label: &str, shown: &str) {
        let is_shown = |row: String| row.strip_prefix(label).is_some_and(|value| value.trim().starts_with(shown));
        self.wait(&format!("{label} {shown}"), |screen| property_here(screen).is_some_and(is_shown));
    }

    /// Waits until the last row has this.
    pub fn wait_for_status(&self, text: &str) {
        self.wait(text, |screen| screen.contents().lines().last().is_some_and(|row| row.contains(text)));
    }

    /// The screen as text.
    pub fn contents(&self) -> String {
        self.far().parser.screen().contents()
    }

    /// What stands in a file of the directory.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.directory.join(name)).unwrap()
    }

    pub fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.child.process_id().unwrap() as i32).unwrap();
        kill_process(pid, signal).unwrap();
    }

    pub fn resize(&self, columns: u16, rows: u16) {
        let [high, wide] = [rows, columns].map(|n| NonZeroU16::new(n).unwrap());
        self.far().parser.screen_mut().set_size(high, wide);
        self.master.as_ref().unwrap().resize(size(columns, rows)).unwrap();
    }

    /// Waits until the screen is as wanted.
    pub fn wait(&self, what: &str, wanted: impl Fn(&vt100::Screen) -> bool) {
        let deadline = Instant::now() + PATIENCE;
        while !wanted(self.far().parser.screen()) {
            let contents = self.far().parser.screen().contents();
            assert!(Instant::now() < deadline, "no {what}; the screen is\n{contents}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn wait_for_text(&self, text: &str) {
        self.wait(text, |screen| screen.contents().contains(text));
    }

    /// Waits for the program's end; its exit code.
    pub fn end(&mut self) -> u32 {
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
    pub fn assert_restored(&self) {
        self.wait("return from the alternate screen", |screen| {
            !screen.alternate_screen() && !screen.hide_cursor() && !screen.bracketed_paste()
        });
        assert_eq!(modes(&**self.master.as_ref().unwrap()), self.modes_before);
    }

    /// Names of all files but the scene.
    pub fn files(&self) -> Vec<String> {
        let names = fs::read_dir(&self.directory).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name != "ball.toml").collect()
    }

    pub fn assert_picture(&self, side: u32) {
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
    pub fn send(&mut self, bytes: &[u8]) {
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

/// The row of the properties that has the keys: below the line under the tree, marked by an arrow.
fn property_here(screen: &vt100::Screen) -> Option<String> {
    let text = screen.contents();
    let below = text.lines().skip_while(|row| !row.contains("├──"));
    below.filter_map(|row| row.split_once("│ ▸ ")).map(|(_, row)| row.trim_end().to_owned()).next()
}

pub fn shows_picture(screen: &vt100::Screen) -> bool {
    let (rows, columns) = screen.size();
    (0..rows.get())
        .flat_map(|y| (0..columns.get()).map(move |x| (y, x)))
        .filter_map(|(y, x)| screen.cell(y, x))
        .any(|cell| [cell.fgcolor(), cell.bgcolor()].contains(&vt100::Color::Rgb(0x40, 0x80, 0xc0)))
}
