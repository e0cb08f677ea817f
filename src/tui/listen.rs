//! Threads that wait for keys, signals and changes of size, and tell the interface.

use super::decode::Input;
use super::event::Event;
use super::writer::Mailbox;
use crossbeam_channel::Sender;
use std::io;

#[cfg(unix)]
pub use unix::{input, signals};

#[cfg(not(unix))]
pub use elsewhere::{input, signals};

/// Hands what was read to whom it concerns; false if nobody listens any more.
fn deliver(inputs: impl IntoIterator<Item = Input>, events: &Sender<Event>, mailbox: &Mailbox) -> bool {
    inputs.into_iter().all(|input| match input {
        Input::Key(key) => events.send(Event::Key(key)).is_ok(),
        Input::Mouse(mouse) => events.send(Event::Mouse(mouse)).is_ok(),
        Input::Pasted(text) => events.send(Event::Pasted(text)).is_ok(),
        Input::CursorColumn(column) => {
            mailbox.answer(column);
            true
        }
    })
}

#[cfg(unix)]
mod unix {
    use super::super::decode::Decoder;
    use super::*;
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use signal_hook::consts::{SIGCONT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGWINCH};
    use signal_hook::iterator::Signals;
    use std::fs::File;
    use std::io::{IsTerminal, Read};
    use std::os::fd::AsFd;

    /// After an ESC that nothing follows for so long, it was the Escape key.
    const ESCAPE_PATIENCE: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };

    /// Reads keys until the terminal is gone. Our own reader and not crossterm's, because that keeps the answers to
    /// `CSI 6n` from whoever does not block the keys meanwhile, and spins when the terminal is gone.
    pub fn input(events: &Sender<Event>, mailbox: &Mailbox) -> io::Result<()> {
        let mut terminal = match io::stdin() {
            stdin if stdin.is_terminal() => File::from(stdin.as_fd().try_clone_to_owned()?),
            _ => File::open("/dev/tty")?,
        };
        let (mut decoder, mut bytes) = (Decoder::default(), [0; 1024]);
        loop {
            let patience = decoder.is_waiting().then_some(&ESCAPE_PATIENCE);
            match poll(&mut [PollFd::new(&terminal, PollFlags::IN)], patience) {
                Ok(0) => {
                    if !deliver(decoder.flush(), events, mailbox) {
                        return Ok(());
                    }
                    continue;
                }
                Ok(_) => {}
                Err(rustix::io::Errno::INTR) => continue,
                Err(error) => return Err(error.into()),
            }
            match terminal.read(&mut bytes) {
                // End of file and EIO both mean that the other end has closed.
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => {
                    if !deliver(decoder.push(&bytes[..count]), events, mailbox) {
                        return Ok(());
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Registers the signals now and returns what has to run in a thread.
    pub fn signals(events: Sender<Event>) -> io::Result<impl FnOnce() + Send + 'static> {
        let mut signals = Signals::new([SIGCONT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGWINCH])?;
        Ok(move || {
            let mut terminated = false;
            for signal in signals.forever() {
                let event = match signal {
                    SIGWINCH => match crossterm::terminal::size() {
                        Ok((columns, rows)) => Event::Resize(columns, rows),
                        Err(_) => continue,
                    },
                    SIGHUP => Event::HungUp,
                    SIGTSTP => Event::StopAsked,
                    SIGCONT => Event::Continued,
                    signal => {
                        // Whoever asks twice does not want to wait for a stopped link or a slow disk.
                        if std::mem::replace(&mut terminated, true) {
                            let _ = crossterm::terminal::disable_raw_mode();
                            std::process::exit(128 + signal);
                        }
                        Event::Terminated(signal)
                    }
                };
                if events.send(event).is_err() {
                    return;
                }
            }
        })
    }
}

/// Without Unix terminals: keys as crossterm reads them. Its console does not answer `CSI 6n` through them, so output
/// is not paced by answers.
#[cfg(not(unix))]
mod elsewhere {
    use super::super::key::{Code, Key};
    use super::*;
    use crossterm::event::{Event as Console, KeyCode, KeyEventKind, KeyModifiers, read};

    pub fn input(events: &Sender<Event>, mailbox: &Mailbox) -> io::Result<()> {
        loop {
            let told = match read()? {
                Console::Key(key) if key.kind != KeyEventKind::Release => {
                    let code = match key.code {
                        KeyCode::Char(c) => Code::Char(c),
                        KeyCode::Up => Code::Up,
                        KeyCode::Down => Code::Down,
                        KeyCode::Left => Code::Left,
                        KeyCode::Right => Code::Right,
                        KeyCode::Enter => Code::Enter,
                        KeyCode::Esc => Code::Escape,
                        KeyCode::Tab | KeyCode::BackTab => Code::Tab,
                        KeyCode::Backspace => Code::Backspace,
                        KeyCode::Delete => Code::Delete,
                        KeyCode::Home => Code::Home,
                        KeyCode::End => Code::End,
                        KeyCode::PageUp => Code::PageUp,
                        KeyCode::PageDown => Code::PageDown,
                        _ => Code::Other,
                    };
                    let held = |modifier| key.modifiers.contains(modifier);
                    let shift = held(KeyModifiers::SHIFT) && !matches!(code, Code::Char(_));
                    let key = Key { code, ctrl: held(KeyModifiers::CONTROL), alt: held(KeyModifiers::ALT), shift };
                    deliver([Input::Key(key)], events, mailbox)
                }
                Console::Resize(columns, rows) => events.send(Event::Resize(columns, rows)).is_ok(),
                _ => true,
            };
            if !told {
                return Ok(());
            }
        }
    }

    pub fn signals(_events: Sender<Event>) -> io::Result<impl FnOnce() + Send + 'static> {
        Ok(|| ())
    }
}
