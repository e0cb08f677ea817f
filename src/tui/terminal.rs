//! The terminal's modes: entering, leaving (once, whatever happens), stopping and coming back.

use crossterm::terminal::{disable_raw_mode, enable_raw_mode};
use std::fs::File;
use std::io::{self, Write};
use std::panic::{self, PanicHookInfo};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

/// Alternate screen, cleared; no cursor; pasted text marked as such; presses of mouse buttons told, not its moves.
const ENTER: &[u8] = b"\x1b[?1049h\x1b[0m\x1b[2J\x1b[?25l\x1b[?2004h\x1b[?1000h\x1b[?1006h";
const LEAVE: &[u8] = b"\x1b[?2026l\x1b[0m\x1b[?1006l\x1b[?1000l\x1b[?2004l\x1b[?1049l\x1b[?25h";
/// Leaving does not wait longer than this for a chunk on a link that has stopped.
const LEAVE_PATIENCE: Duration = Duration::from_millis(500);

/// The terminal's output and modes, shared with the thread that writes.
#[derive(Clone, Debug)]
pub struct Terminal(Arc<Mutex<Output>>);

#[derive(Debug)]
struct Output {
    file: File,
    /// Whether the modes are ours.
    entered: bool,
}

impl Terminal {
    /// Takes the terminal on stdout: raw, alternate screen.
    pub fn enter() -> io::Result<Self> {
        let terminal = Self(Arc::new(Mutex::new(Output { file: output()?, entered: false })));
        terminal.reenter()?;
        Ok(terminal)
    }

    /// Takes the terminal again: after a stop, or when a shell has meddled with it. The screen is clear afterwards.
    pub fn reenter(&self) -> io::Result<()> {
        let mut output = self.lock();
        // What crossterm believes to be raw may have been made cooked by the shell.
        disable_raw_mode()?;
        enable_raw_mode()?;
        output.entered = true;
        output.file.write_all(ENTER)
    }

    /// Gives the terminal back as it was. Does nothing if that was done.
    pub fn leave(&self) {
        // The modes first: that does not wait for a stopped link.
        let deadline = Instant::now() + LEAVE_PATIENCE;
        let mut output = loop {
            match self.0.try_lock() {
                Ok(output) => break output,
                Err(TryLockError::Poisoned(poisoned)) => break poisoned.into_inner(),
                Err(TryLockError::WouldBlock) if Instant::now() < deadline => {
                    thread::sleep(Duration::from_millis(1));
                }
                Err(TryLockError::WouldBlock) => {
                    let _ = disable_raw_mode();
                    return;
                }
            }
        };
        if std::mem::take(&mut output.entered) {
            // Errors mean that there is no terminal to be restored.
            let _ = disable_raw_mode();
            let _ = output.file.write_all(LEAVE);
        }
    }

    /// Writes a chunk. Returns whether the terminal is ours; if not, nothing is written.
    pub fn write(&self, bytes: &[u8]) -> io::Result<bool> {
        let mut output = self.lock();
        if output.entered {
            output.file.write_all(bytes)?;
        }
        Ok(output.entered)
    }

    fn lock(&self) -> MutexGuard<'_, Output> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// The terminal without the buffer of `std::io::stdout`, which flushes line by line.
fn output() -> io::Result<File> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        io::stdout().as_fd().try_clone_to_owned().map(File::from)
    }
    #[cfg(windows)]
    {
        use std::os::windows::io::AsHandle;
        io::stdout().as_handle().try_clone_to_owned().map(File::from)
    }
}

/// The terminal, restored when this is dropped and before the message of a panic is printed.
///
/// Panics of other threads print nothing and touch nothing, for the screen lives on: whoever runs those threads reports
/// them.
pub struct Guard {
    terminal: Terminal,
    previous: Arc<Hook>,
}

type Hook = dyn Fn(&PanicHookInfo<'_>) + Send + Sync;

impl Guard {
    /// Takes the terminal. The calling thread is the one whose panic ends the interface.
    pub fn enter() -> io::Result<Self> {
        Terminal::enter().map(Self::of)
    }

    fn of(terminal: Terminal) -> Self {
        let previous: Arc<Hook> = panic::take_hook().into();
        let (interface, hook, restored) = (thread::current().id(), previous.clone(), terminal.clone());
        panic::set_hook(Box::new(move |info| {
            if thread::current().id() == interface {
                restored.leave();
                hook(info);
            }
        }));
        Self { terminal, previous }
    }

    /// The terminal.
    pub fn terminal(&self) -> &Terminal {
        &self.terminal
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        self.terminal.leave();
        if !thread::panicking() {
            let previous = self.previous.clone();
            panic::set_hook(Box::new(move |info| previous(info)));
        }
    }
}

/// The terminal is gone (the connection broke): from now on nothing can be read from it, and what is written goes
/// nowhere, without errors.
#[cfg(unix)]
pub fn detach() {
    if let Ok(null) = File::options().read(true).write(true).open("/dev/null") {
        // Whatever fails here stays as broken as it is.
        let _ = rustix::stdio::dup2_stdin(&null);
        let _ = rustix::stdio::dup2_stdout(&null);
        let _ = rustix::stdio::dup2_stderr(&null);
    }
}

/// Elsewhere nothing is known to break.
#[cfg(not(unix))]
pub fn detach() {}

/// Whether there is a shell to return to when the program stops. A program that shares the process group of its
/// session's leader (`ssh -t host glimt`) would stop for ever.
#[cfg(unix)]
pub fn can_stop() -> bool {
    rustix::process::getsid(None).is_ok_and(|session| session != rustix::process::getpgrp())
}

/// Stopping is a Unix thing.
#[cfg(not(unix))]
pub fn can_stop() -> bool {
    false
}

/// Stops the program until the shell lets it go on, and with it whoever started it in the same job.
#[cfg(unix)]
pub fn stop() {
    let _ = rustix::process::kill_current_process_group(rustix::process::Signal::STOP);
}

/// Stopping is a Unix thing.
#[cfg(not(unix))]
pub fn stop() {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::catch_unwind;

    #[test]
    fn only_a_panic_of_the_interface_itself_leaves_the_screen() {
        let path = std::env::temp_dir().join(format!("glimt-hook-{}", std::process::id()));
        let file = File::create(&path).unwrap();
        let written = || std::fs::read(&path).unwrap();
        let guard = Guard::of(Terminal(Arc::new(Mutex::new(Output { file, entered: true }))));
        // As on the thread that compiles, where readers of models may panic and are caught.
        let caught = thread::spawn(|| catch_unwind(|| panic!("of a reader")).is_err()).join();
        assert!(caught.unwrap() && written().is_empty());
        assert!(guard.terminal().write(b"a frame").unwrap());
        assert!(catch_unwind(|| panic!("of the interface")).is_err());
        assert!(written().ends_with(LEAVE));
        drop(guard);
        assert_eq!(written().len(), b"a frame".len() + LEAVE.len());
        std::fs::remove_file(&path).unwrap();
    }
}
